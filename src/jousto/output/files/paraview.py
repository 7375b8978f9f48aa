"""ParaView files: points with values, one instant or a series."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.files import written

KINDS = {2: "line", 3: "triangle"}

Cells = Sequence[tuple[str, Any]]


def cells_of(elements: Any, offset: int = 0) -> list[tuple[str, Any]]:
    """Return lines or triangles (ne, 2 or 3) of a body as cells; empty for other elements."""
    corners = elements.shape[1] if elements.ndim == 2 else 0
    return [(KINDS[corners], elements + offset)] if len(elements) and corners in KINDS else []


def save_vtu(path: Path, x: Array, cells: Cells, fields: Mapping[str, Any]) -> Path:
    """Write points (nn, 3) with values and their cells (single points without cells)."""
    import meshio

    shown = list(cells) or [("vertex", np.arange(len(x))[:, None])]
    mesh = meshio.Mesh(x, shown, point_data=dict(fields))
    with written(path) as beside:
        meshio.write(beside, mesh, file_format="vtu")
    return path


def save_series(
    path: Path, instants: Array, content: Callable[[float], tuple[Array, Cells, Mapping[str, Any]]]
) -> Path:
    """Write one instant as .vtu file, or several with a .pvd file that lists them.

    Raises
    ------
    InputError
        For several instants in a .vtu file.
    """
    single = path.suffix == ".vtu"
    if single and len(instants) != 1:
        message = f"one instant fits into a .vtu file, not {len(instants)}; write a .pvd file"
        raise InputError(Problem(str(path), message))
    digits = len(str(max(len(instants) - 1, 1)))
    lines = []
    for k, t in enumerate(instants):
        piece = path if single else path.with_name(f"{path.stem}_{k:0{digits}d}.vtu")
        save_vtu(piece, *content(t))
        lines.append(f'<DataSet timestep="{t:.15g}" part="0" file={quoteattr(piece.name)}/>')
    if not single:
        head = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n<Collection>\n'
        with written(path) as beside:
            beside.write_text(head + "\n".join(lines) + "\n</Collection>\n</VTKFile>\n", "utf-8")
    return path
