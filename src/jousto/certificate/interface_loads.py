"""Responses of a reduced part and its full model to unit interface loads, for the certificate."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array, Index
from jousto.base.errors import count
from jousto.certificate.certificate import Check, Status, Table, number, percent
from jousto.certificate.interface_modes import Modes, determinate, scaled_rigid
from jousto.certificate.part_checks import FullModel

EXACT = 1e-8
"""Relative error of a static displacement that counts as exact."""

MOST_LOADS = 60
"""Largest number of interface loads; of more a uniform sample is used."""


def static_loads(full: FullModel, modes: Modes) -> tuple[list[Check], Table] | None:
    """Return the checks of the response to interface loads against the full model.

    A unit force or moment acts on each interface degree of freedom. First it is balanced by
    statically determinate supports of the interfaces: the modes must reproduce the displacements
    ``K^-1 F`` of the full model exactly. Then it acts on the free body, which it accelerates
    (inertia relief, ``F - M R R^T F``): the error depends on the number of vibration modes.
    """
    if full.held is None or full.held.solve is None or full.rigid is None or not modes.names:
        return None
    supports = determinate(modes.moved(scaled_rigid(full)))
    if supports is None:
        return None
    chosen = np.arange(len(modes.names))
    if len(chosen) > MOST_LOADS:
        chosen = np.linspace(0, len(chosen) - 1, MOST_LOADS).astype(np.intp)
    F = modes.loads[:, chosen].toarray()
    R, MR = full.rigid.R, full.rigid.MR
    balanced, trivial = _balanced(full, modes, F, chosen, supports)
    relieved = F - MR @ (R.T @ F)

    both = np.concatenate([balanced, relieved], axis=1)
    exact = elastic_response(full, both)
    omega2 = (2.0 * np.pi * modes.reduced.frequencies) ** 2
    found = modes.X @ ((modes.X.T @ both) / omega2[:, None])
    w = full.weights[:, None]
    scale = np.abs(exact * w).max(axis=0)
    error = np.abs((found - exact) * w).max(axis=0) / np.maximum(scale, np.finfo(float).tiny)
    m = len(chosen)
    static, dynamic = np.where(trivial, 0.0, error[:m]), error[m:]
    # work of load and reactions: displacement at the load relative to the supports
    own = np.einsum("ij,ij->j", balanced, exact[:, :m])
    rows = tuple(
        (
            modes.names[load],
            "support" if trivial[k] else number(own[k]),
            "-" if trivial[k] else number(static[k], 2),
            percent(dynamic[k]),
        )
        for k, load in enumerate(chosen)
    )
    table = Table(
        "unit interface loads, reduced part against full model",
        ("load", "displacement (m/N, rad/N m)", "static error", "error with acceleration"),
        rows,
        "Static: balanced at supports of the interfaces. Acceleration: on the free body.",
    )
    return [_static_check(modes, chosen, static, trivial), _relief_check(dynamic)], table


def _balanced(
    full: FullModel, modes: Modes, F: Array, chosen: Index, supports: Index
) -> tuple[Array, NDArray[np.bool_]]:
    """Return loads with the reactions of six supports, and the loads without possible reactions.

    A load on a support is balanced by six other supports, if possible.
    """
    assert full.rigid is not None
    R = full.rigid.R
    P = modes.moved(scaled_rigid(full))
    balanced = F.copy()
    trivial = np.zeros(len(chosen), dtype=bool)
    own = {int(load): k for k, load in enumerate(chosen) if load in supports}
    groups: list[tuple[Any, Index | None]] = [(~np.isin(chosen, supports), supports)]
    for load, k in own.items():
        others = np.setdiff1d(np.arange(len(P)), [load])
        found = determinate(P[others])
        groups.append(([k], None if found is None else others[found]))
    for columns, six in groups:
        if six is None:
            trivial[columns] = True
            balanced[:, columns] = 0.0
            continue
        # reactions r with R^T (F + S r) = 0
        S = modes.loads[:, six].toarray()
        balanced[:, columns] -= S @ np.linalg.solve(R.T @ S, R.T @ F[:, columns])
    return balanced, trivial


def elastic_response(full: FullModel, F: Array) -> Array:
    """Return displacements under self-equilibrated loads (ndof, m), without rigid part."""
    assert full.held is not None and full.held.solve is not None and full.rigid is not None
    f = full.held.lower(F)
    y = full.held.solve(f)
    # iterative refinement, for the accuracy of fine meshes
    y = y + full.held.solve(f - full.held.B @ y)
    return full.rigid.remove(full.held.lift(y))


def _static_check(modes: Modes, chosen: Index, error: Array, trivial: NDArray[np.bool_]) -> Check:
    topic = "static loads"
    limit = f"relative error below {EXACT:g}"
    loads = count(len(chosen), "interface load")
    if trivial.all():
        sentence = (
            "a single interface node balances every load without deformation; the part deforms "
            "only with acceleration"
        )
        return Check(topic, "ok", "single support", "", sentence)
    worst = int(np.argmax(error))
    value = f"{number(error[worst], 2)} at worst"
    # accuracy of the solver
    if error[worst] < EXACT:
        what = f"each of {loads} deforms the reduced part like the full model"
        return Check(topic, "ok", value, limit, what)
    name = modes.names[chosen[worst]]
    if error[worst] > 0.999:
        rigid = int(np.sum(error > 0.999))
        return Check(
            topic,
            "warn",
            value,
            limit,
            f"the reduced part does not deform under {rigid} of {loads}, such as {name}",
            "right if modes were left out on purpose (in_plane, keep); otherwise keep all modes",
        )
    # fewer modes than static deformations of the interfaces: some were left out
    left_out = modes.reduced.n < len(modes.names) - 6
    status: Status = "warn" if error[worst] < 1e-4 or left_out else "fail"
    return Check(
        topic,
        status,
        value,
        limit,
        f"under {name} the reduced part deforms differently from the full model",
        "keep the constraint modes of all interfaces (CraigBampton with these interfaces, all "
        "modes); if the part was reduced in this way, the stiffness matrix is too "
        "ill-conditioned for this accuracy",
    )


def _relief_check(error: Array) -> Check:
    worst = float(error.max())
    value, limit = f"{percent(worst)} at worst", "below 5 %"
    topic = "accelerating loads"
    if worst < 0.05:
        sentence = "loads that accelerate the free body deform it like the full model"
        return Check(topic, "ok", value, limit, sentence)
    return Check(
        topic,
        "note",
        value,
        limit,
        "a load that accelerates the free body deforms it differently from the full model, "
        "since there are few vibration modes",
        "ask for more fixed-interface modes; not needed if such loads do not occur",
    )
