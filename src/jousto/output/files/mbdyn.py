"""MBDyn: the modal joint's .fem file."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from jousto.base.arguments import explained_as
from jousto.base.arrays import Array
from jousto.output.files.exported_nodes import damping_ratios, exposed_nodes, node_modes, write_text
from jousto.reduction.reduced import ReducedPart


@explained_as("write")
def write_fem(
    reduced: ReducedPart,
    path: str | Path,
    *,
    nodes: Sequence[str | int] | None = None,
    damping: float | Sequence[float] = 0.0,
    invariants: bool = True,
) -> Path:
    """Write a reduced part as the .fem file of MBDyn's modal joint.

    Records 1 to 10 are header, nodes, mode shapes, modal mass and stiffness; 12 is the inertia of
    the rigid body about its centre; 13 the modal damping; 14 to 18 the invariants
    ``int phi_j dm``, ``int u0~ phi_j dm``, ``-int u0~ phi_j~ dm``, ``int phi_j~ phi_k dm`` and
    ``int phi_j~ phi_k~ dm`` (MBDyn input manual, modal joint). Names of nodes are those of node
    sets; the modal node is the part's frame. Stiffening is not included.

    Parameters
    ----------
    reduced : ReducedPart
    path : str or Path
    nodes : sequence of str or int, optional
        Node sets or node numbers from 0; by default all for parts with up to 500 nodes, else those
        of interfaces and of named nodes.
    damping : float or sequence of float
        Damping ratio, of all modes or of each.
    invariants : bool
        Whether records 14 to 18 are written; MBDyn reads them from version 1.7.3 on; without record
        11, older versions neglect the coupling of rigid motion and modes.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If a node does not exist or the file cannot be written.
    """
    target = Path(path)
    index, names = exposed_nodes(reduced, nodes, target.name)
    ratios = damping_ratios(reduced, damping, target.name)
    n, inv = reduced.n, reduced.invariants
    x = reduced.nodes[index]
    translations, rotations = node_modes(reduced, index)
    lines = [
        f"** MBDyn MODAL DATA FILE, part '{reduced.name}' written by jousto, SI units",
        *_record(1, "HEADER"),
        "**   REVISION, NODE, NORMAL, ATTACHMENT, CONSTRAINT, REJECTED MODES.",
        f"      REV0      {len(index)}      {n}      0      0      0",
        *_record(2, "FINITE ELEMENT NODE LIST"),
        " ".join(name.replace(" ", "_") for name in names),
    ]
    for a, axis in enumerate("XYZ"):
        lines += [*_record(5 + a, f"NODAL {axis} COORDINATES"), *_rows(x[:, a : a + 1])]
    lines += _record(8, "MODE SHAPES")
    for j in range(n):
        lines.append(f"**    NORMAL MODE SHAPE #  {j + 1}, {reduced.frequencies[j]:.6g} Hz")
        lines += _rows(np.concatenate([translations[:, :, j], rotations[:, :, j]], axis=1))
    lines += [*_record(9, "MODAL MASS MATRIX"), *_rows(np.eye(n))]
    lines += [*_record(10, "MODAL STIFFNESS MATRIX"), *_rows(np.diag(reduced.stiffness))]

    # inertia about the centre of mass
    centre = inv.I2 / inv.mass
    about = inv.I7 - inv.mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    lines += [*_record(12, "RIGID BODY INERTIA MATRIX"), f"{inv.mass:.16e}"]
    lines += [*_rows(centre[None]), *_rows(about)]
    if np.any(ratios > 0.0):
        D = np.diag(2.0 * ratios * np.sqrt(reduced.stiffness))
        lines += [*_record(13, "MODAL DAMPING MATRIX"), *_rows(D)]
    if invariants:
        lines += [*_record(14, "INVARIANT 3"), *_rows(inv.I3)]
        lines += [*_record(15, "INVARIANT 4"), *_rows(inv.I4)]
        # 3 x 3 blocks side by side; MBDyn's phi~ phi~ is minus our phi~^T phi~
        lines += [*_record(16, "INVARIANT 8"), *_rows(inv.I8.transpose(1, 0, 2).reshape(3, -1))]
        lines += [*_record(17, "INVARIANT 5"), *_rows(inv.I5.transpose(1, 0, 2).reshape(3, -1))]
        blocks = -inv.I9.transpose(2, 0, 1, 3).reshape(3, -1)
        lines += [*_record(18, "INVARIANT 9"), *_rows(blocks)]
    write_text(target, "\n".join([*lines, "**", ""]))
    return target


def _record(number: int, title: str) -> list[str]:
    return ["**", f"** RECORD GROUP {number}, {title}"]


def _rows(matrix: Array) -> Iterable[str]:
    return [" ".join(f"{value:.16e}" for value in row) for row in np.atleast_2d(matrix)]
