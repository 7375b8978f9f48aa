"""VTU: the part with its modes and modal stress for ParaView."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arguments import explained_as
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.output.files.paraview import save_vtu
from jousto.output.style import target
from jousto.reduction.reduced import ReducedPart

KINDS = {
    2: "line",
    3: "triangle",
    6: "triangle6",
    8: "hexahedron",
    10: "tetra10",
    20: "hexahedron20",
}
"""Cell types by number of nodes; four nodes: tetrahedron, or quadrilateral if planar."""


@explained_as("write")
def write_vtu(reduced: ReducedPart, path: str | Path, *, stress: bool = True) -> Path:
    """Write nodes, elements, modes and modal stress for ParaView.

    Each mode is a vector field of the points (mass-normalised, kg^-0.5): "Warp By Vector" shows its
    shape. Parts with stress at their nodes get a symmetric tensor field for each mode, Pa per unit
    modal coordinate, part frame, in ParaView's order xx yy zz xy yz xz. A node with several stress
    values, as on the border of two materials, has their mean.

    Parameters
    ----------
    reduced : ReducedPart
    path : str or Path
        Ends with .vtu.
    stress : bool
        Whether modal stress is written where it is known at nodes.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        If the file has another ending or cannot be written.
    """
    out = target(path, ("vtu",))
    digits = len(str(reduced.n))
    fields: dict[str, Any] = {}
    for j, f in enumerate(reduced.frequencies):
        fields[f"mode {j + 1:0{digits}d}, {f:.5g} Hz"] = np.ascontiguousarray(
            reduced.modes[:, :, j]
        )
    nodal = _nodal_stress(reduced) if stress else None
    if nodal is not None:
        for j in range(reduced.n):
            fields[f"stress {j + 1:0{digits}d}"] = np.ascontiguousarray(nodal[:, :, j])
    cells = [(_kind(reduced), reduced.elements)] if reduced.elements.size else []
    return save_vtu(out, reduced.nodes, cells, fields)


def _kind(reduced: ReducedPart) -> str:
    count = reduced.elements.shape[1]
    if count == 4:
        a, b, c, d = (reduced.nodes[reduced.elements[:, k]] for k in range(4))
        volume = np.abs(np.einsum("ei,ei->e", np.cross(b - a, c - a), d - a))
        size = np.linalg.norm(b - a, axis=1) * np.linalg.norm(c - a, axis=1)
        flat = volume < 1e-3 * size * np.linalg.norm(d - a, axis=1)
        return "quad" if np.all(flat) else "tetra"
    if count not in KINDS:
        where = f"reduced part '{reduced.name}'"
        raise InputError(Problem(where, f"elements of {count} nodes cannot be drawn in ParaView"))
    return KINDS[count]


def _nodal_stress(reduced: ReducedPart) -> Array | None:
    """Return the modal stress (nn, 6, n) in the part frame, nan where unknown.

    None if the places are not nodes, such as the points of the sections of beams.
    """
    if reduced.stress is None:
        return None
    from scipy.spatial import cKDTree  # slow import, rarely needed

    places = reduced.stress.positions
    distance, node = cKDTree(reduced.nodes).query(places)
    size = float(np.ptp(reduced.nodes, axis=0).max())
    if np.any(distance > 1e-9 * size):
        return None
    s = reduced.stress.modes
    # [s11 s22 s33 s12 s23 s13] as tensors, rotated from the axes of the places
    tensor = s[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]
    A = reduced.stress.axes
    turned = np.einsum("sia,sabn,sjb->sijn", A, tensor, A, optimize=True)
    out = np.zeros((len(reduced.nodes), 6, reduced.n))
    np.add.at(out, node, turned[:, [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]])
    # mean value of each node, nan without any
    times = np.bincount(node, minlength=len(out)).astype(float)
    times[times == 0.0] = np.nan
    return np.asarray(out / times[:, None, None])
