"""Stress over the surface of a solid body, for pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arrays import Array
from jousto.recovery.fields.build import field_from
from jousto.recovery.shape import bracket, find_body
from jousto.simulation.results.solution import Solution


def surface_stress(
    run: Solution, body: str, times: ArrayLike | None = None
) -> tuple[NDArray[np.int64], Array] | None:
    """Return the von Mises stress over the surface of a solid body at some instants.

    Parameters
    ----------
    run : Solution
        The results.
    body : str
        Name of the body.
    times : (nt,) array_like, optional
        Instants in s, as for `positions`; None takes every stored instant.

    Returns
    -------
    nodes : (ns,) int array
        Nodes whose stress is known.
    values : (nt, ns) array
        Pa. None instead of both if the body has no surface or no stress.

    Raises
    ------
    InputError
        If there is no such body, or a time is outside the run.
    """
    shape = find_body(run, body)
    modes = run.stress_modes(body)
    if modes is None or shape.elements.ndim != 2 or shape.elements.shape[1] != 3:
        return None
    assert modes.nodes is not None
    modes = modes.select(np.flatnonzero(modes.nodes >= 0))
    assert modes.nodes is not None
    if not len(modes.nodes):
        return None
    p = run.coordinates(body)[:, 7:]
    if times is not None:
        before, after, share = bracket(run, times)
        p = (1.0 - share[:, None]) * p[before] + share[:, None] * p[after]
    # a picture may show instants in any order
    field = field_from(modes, p, np.arange(len(p), dtype=np.float64), name=body)
    return modes.nodes, field.values("von-mises", memory=8 * len(p) * len(modes.nodes))
