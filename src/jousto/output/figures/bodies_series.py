"""ParaView series of all bodies of a run: surfaces, lines, and exact beams as tubes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained_as
from jousto.base.arrays import Array, Index
from jousto.output.figures.beams import write_beam
from jousto.output.files.paraview import Cells, save_series
from jousto.output.style import target
from jousto.recovery.fields.criteria import evaluate
from jousto.scene.make import make_scene
from jousto.scene.scene import Body
from jousto.scene.values_at_rows import rows_at, stresses, vertices
from jousto.simulation.results.solution import Solution


@explained_as("write")
def write_run(
    run: Solution,
    path: str | Path,
    *,
    beam: str | None = None,
    times: ArrayLike | None = None,
    scale: float = 1.0,
) -> Path:
    """Write all bodies of a run at their positions in the world for ParaView.

    Solids are written as surfaces, frames and exact beams as tubes of their sections, rigid bodies
    in their displayed shape. Point data: ``body``, its number from 1 in the order of ``run.bodies``
    and then of ``run.beams``; ``displacement (m)`` since the first instant of the run ("Warp By
    Vector" with factor -1 gives the start); and ``von Mises (Pa)``, nan where unknown, if any body
    has stress.

    Parameters
    ----------
    run : Solution
    path : path
        Ends with .vtu for one instant, or .pvd for a series that ParaView plays.
    beam : str, optional
        Name of an exact beam, to write only its surface, with the axes of its sections.
    times : (nt,) array_like, optional
        Instants, s; by default the last one for .vtu and all stored ones for .pvd.
    scale : float
        Factor on the deformation of modal bodies.

    Raises
    ------
    InputError
        If there is no such beam, for another ending, or several instants in a .vtu file.
    """
    if beam is not None:
        return write_beam(run, path, beam=beam, times=times)
    out = target(path, ("vtu", "pvd"))
    scene = make_scene(run)
    bodies = [
        body
        for body in scene.bodies
        if body.kind not in ("ground", "contact") and len(body.positions)
    ]
    sizes = [_size(body) for body in bodies]
    cells = _cells(bodies, np.cumsum([0, *sizes]))
    number = np.repeat(np.arange(1.0, len(bodies) + 1.0), sizes)
    instants = run.time[-1:] if out.suffix == ".vtu" else run.time
    if times is not None:
        instants = np.atleast_1d(np.asarray(times, dtype=np.float64))
    first = _places(bodies, rows_at(scene, run.time[:1]), scale)

    def content(t: float) -> tuple[Array, Cells, dict[str, Array]]:
        row = rows_at(scene, [t])
        x = _places(bodies, row, scale)
        data = {"body": number, "displacement (m)": x - first}
        known = [stresses(body, row) for body in bodies]
        if any(tensors is not None for tensors in known):
            data["von Mises (Pa)"] = np.concatenate(
                [
                    np.full(size, np.nan) if one is None else evaluate(one, "von-mises")[0]
                    for one, size in zip(known, sizes, strict=True)
                ]
            )
        return x, cells, data

    return save_series(out, instants, content)


def _size(body: Body) -> int:
    """Return the number of vertices of a body."""
    return len(body.positions) if body.rings is None else len(body.rings.vertex_ring)


def _places(bodies: list[Body], row: Array, scale: float) -> Array:
    """Return the vertices (nv, 3) of all bodies at one row (1, nr), m."""
    return np.concatenate([vertices(body, row, scale=scale)[0] for body in bodies])


def _cells(bodies: list[Body], first: Index) -> Cells:
    """Return triangles, lines, and the points of bodies that have neither."""
    found: dict[str, list[Index]] = {"triangle": [], "line": [], "vertex": []}
    for body, start, end in zip(bodies, first[:-1], first[1:], strict=True):
        triangles, lines = body.triangles, body.lines
        if triangles is not None and len(triangles):
            found["triangle"].append(triangles + start)
        elif lines is not None and len(lines):
            found["line"].append(lines + start)
        else:
            found["vertex"].append(np.arange(start, end)[:, None])
    return [(kind, np.concatenate(parts)) for kind, parts in found.items() if parts]
