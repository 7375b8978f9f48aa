"""Checks of the modes and interfaces of a reduced part, for the certificate."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.errors import count
from jousto.certificate.certificate import Check, number
from jousto.certificate.interface_modes import Modes, determinate, scaled_rigid
from jousto.certificate.part_checks import FullModel

ORTHONORMAL = 1e-5
"""Largest deviation of the modal matrices from their diagonal."""

MANY_DOFS = 120
"""Number of degrees of freedom of all interfaces above which a tie to one node is better."""

HOLD = 1e-3
"""Smallest independent motion / size of the body by which an interface fixes it."""

CONDITION = (1e8, 1e12)
"""Condition numbers of the flexibility of the interfaces: for a warning, and singular."""


def orthonormality(full: FullModel, modes: Modes) -> Check:
    """Return the check that the modes are orthonormal, diagonal and free of rigid motion."""
    X = modes.X
    mass = np.abs(X.T @ (full.M @ X) - np.eye(X.shape[1])).max()
    omega = 2.0 * np.pi * modes.reduced.frequencies
    stiff = X.T @ (full.K @ X) / np.multiply.outer(omega, omega)
    stiff = np.abs(stiff - np.eye(len(omega))).max()
    rigid = 0.0 if full.rigid is None else np.abs(full.rigid.MR.T @ X).max()
    worst = float(max(mass, stiff, rigid))
    value = f"{number(mass, 2)} mass, {number(stiff, 2)} stiffness, {number(rigid, 2)} rigid part"
    limit = f"below {ORTHONORMAL:g}"
    if worst < ORTHONORMAL:
        sentence = "the modes are orthonormal and free of rigid motion"
        return Check("modes", "ok", value, limit, sentence)
    status: Any = "warn" if worst < 1e-3 else "fail"
    return Check(
        "modes",
        status,
        value,
        limit,
        "the modes are not the orthonormal modes of this mass and stiffness matrix",
        "reduce this part again; give printed mode shapes with all available digits",
    )


def hold(full: FullModel, modes: Modes) -> Check:
    """Return the checks of how well each interface fixes the body, and of the interface modes."""
    topic = "interfaces"
    if not modes.interfaces:
        return Check(
            topic,
            "note",
            "none",
            "",
            "the modes are those of a free body: near joints they converge slowly",
            "use CraigBampton with the nodes where joints and forces act",
        )
    P = modes.moved(scaled_rigid(full))
    nb = len(P)
    least = []
    ties = {tie.name: tie for tie in full.part.ties}
    for name, rows in modes.interfaces:
        s = np.linalg.svd(P[rows], compute_uv=False)
        # divided by the norm of one node, so that many nodes do not look stiffer
        norm = max(np.sqrt(len(rows) / full.dofs), 1.0)
        own = ties[name].conditioning if name in ties else 1.0
        least.append((min(float(s[5] / norm), own) if len(s) > 5 else 0.0, name))
    value = ", ".join(f"{name} {number(s, 2)}" for s, name in least)
    limit = f"fix every rigid motion by more than {HOLD:g}"
    if nb > MANY_DOFS:
        return Check(
            topic,
            "warn",
            f"{count(nb, 'degree')} of freedom",
            f"at most {MANY_DOFS}",
            "each interface degree of freedom adds one mode, most of very high frequency, which"
            " needs small steps",
            "tie the nodes of the surface to one node, rigidly or on average",
        )
    if determinate(P) is None:
        return Check(
            topic,
            "fail",
            value,
            limit,
            "the interfaces together do not fix the body",
            "add interface nodes that are not on one line",
        )
    weak = [name for s, name in least if s < HOLD]
    if weak and weak[0] in ties:
        return Check(
            topic,
            "warn",
            value,
            limit,
            f"the nodes tied to '{weak[0]}' lie almost on a line or far from its reference point: "
            f"moments there cause very large strains",
            "tie a wider surface or move the reference point",
        )
    if weak:
        if full.dofs == 3:
            reason = (
                "its nodes have no rotations and are few, on one line or very close to one another"
            )
            remedy = "tie the surface of the joint to one node with rotations"
        else:
            reason = "it has too few nodes"
            remedy = "add nodes to it"
        status: Any = "note" if full.dofs == 3 and len(modes.interfaces) > 1 else "warn"
        return Check(
            topic,
            status,
            value,
            limit,
            f"'{weak[0]}' alone cannot transmit every moment: {reason}",
            f"fine for joints that transmit forces only; otherwise {remedy}",
        )
    return Check(topic, "ok", value, limit, "every interface can transmit all forces and moments")


def conditioning(full: FullModel, modes: Modes) -> Check | None:
    """Return the condition number of the elastic flexibility of the interfaces."""
    # one interface node, or statically determinate supports, have no flexibility
    rank = len(modes.names) - 6
    if rank < 1 or len(modes.names) > 6 * MANY_DOFS:
        return None
    C = modes.moved(modes.X) / (2.0 * np.pi * modes.reduced.frequencies)
    values = np.linalg.svd(C, compute_uv=False) ** 2
    value = float(values[0] / max(values[min(rank, len(values)) - 1], np.finfo(float).tiny))
    text, limit = number(value, 2), f"below {CONDITION[0]:.0e}"
    topic = "conditioning"
    moved = int(np.sum(values > values[0] / CONDITION[1]))
    if moved < rank:
        return Check(
            topic,
            "warn",
            f"{moved} of {rank} motions",
            "all",
            "the modes do not contain all motions of the interfaces",
            "keep all modes of the reduction, except for plane motion; tie neighbouring "
            "interface nodes to one node",
        )
    if value > CONDITION[0]:
        return Check(
            topic,
            "warn",
            text,
            limit,
            "a motion of the interfaces is much stiffer than others, with rounding errors",
            "tie neighbouring interface nodes to one node",
        )
    return Check(
        topic, "ok", text, limit, "the interfaces have all motions without large rounding errors"
    )
