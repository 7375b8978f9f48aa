"""Stress of a body for ParaView: envelope, one instant, or a series of instants."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained_as
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.output.files.paraview import Cells, cells_of, save_series, save_vtu
from jousto.output.style import target
from jousto.recovery.fields.criteria import Criterion
from jousto.recovery.fields.field import StressField
from jousto.recovery.shape import find_body, positions
from jousto.simulation.results.records import BodyShape
from jousto.simulation.results.solution import Solution


@explained_as("write")
def write_contour(
    field: StressField,
    path: str | Path,
    run: Solution,
    *,
    criterion: Criterion = "von-mises",
    times: ArrayLike | None = None,
    scale: float = 1.0,
) -> Path:
    """Write a criterion over a body for ParaView.

    Without `times` a .vtu file contains the envelope over all instants of the field: smallest and
    largest value at every node with their times, on the undeformed body in its own frame. With one
    instant it contains the value at that time, on the deformed body at its position in the world. A
    .pvd file lists such files for several instants, which ParaView plays as a film.

    Parameters
    ----------
    field : StressField
        Stress field of all or some places of a body; values at the other places are nan.
    path : path
        Ends with .vtu, or .pvd for a series.
    run : Solution
        Run of the field.
    criterion : str or Plane
        Criterion, see `jousto.recovery.fields.criteria.evaluate`.
    times : (nt,) array_like, optional
        Instants, s; by default, for a .pvd file, all instants of the field.
    scale : float
        Factor on the deformation.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        For another ending, a path that cannot be written, several instants in a .vtu file, or
        places that are not nodes.

    Examples
    --------
    ``write(stress_field(run, "arm"), "arm.pvd", run, times=np.linspace(0, 1, 51))``
    """
    out = target(path, ("vtu", "pvd"))
    shape = find_body(run, field.name)
    nodes = field.modes.nodes
    if nodes is None or not np.any(nodes >= 0):
        message = "its places are not nodes of the body: there is nothing to colour"
        raise InputError(Problem(f"stress of '{field.name}'", message))
    name, cells = f"{criterion} ({field.unit})", cells_of(shape.elements)
    if out.suffix == ".vtu" and times is None:
        found = field.envelope(criterion)
        high, low = _winners(shape, nodes, found.max), _winners(shape, nodes, -found.min)
        fields = {
            f"largest {name}": _nodal(high, found.max),
            "time of the largest (s)": _nodal(high, found.max_time),
            f"smallest {name}": _nodal(low, found.min),
            "time of the smallest (s)": _nodal(low, found.min_time),
        }
        return save_vtu(out, shape.nodes, cells, fields)
    instants = field.time if times is None else np.atleast_1d(np.asarray(times, dtype=np.float64))

    def content(t: float) -> tuple[Array, Cells, dict[str, Array]]:
        values = field.values(criterion, times=[t])[0]
        x = positions(run, field.name, [t], scale=scale)[0]
        return x, cells, {name: _nodal(_winners(shape, nodes, values), values)}

    return save_series(out, instants, content)


def _winners(shape: BodyShape, nodes: NDArray[np.int64], values: Array) -> NDArray[np.intp]:
    """Return the place (nn,) with the largest value at each node, -1 where unknown."""
    out = np.full(len(shape.nodes), -1, dtype=np.intp)
    order = np.argsort(values, kind="stable")
    order = order[nodes[order] >= 0]
    # later assignments overwrite earlier ones, so the largest value comes last
    out[nodes[order]] = order
    return out


def _nodal(winners: NDArray[np.intp], values: Array) -> Array:
    return np.where(winners >= 0, values[winners], np.nan)
