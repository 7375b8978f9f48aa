"""Stress of a moving body in one call; `stress_field` does all of it and more."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.recovery.fields.build import field_from, stress_field
from jousto.recovery.fields.field import StressField
from jousto.recovery.hotspots.spots import hot_spots
from jousto.recovery.shape import bracket, find_body
from jousto.reduction.reduced import ReducedPart
from jousto.simulation.results.solution import Solution

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Peak:
    """The largest equivalent stress of a body.

    Attributes
    ----------
    site : str
        Where: a label such as ``e1.a.top``.
    time : float
        When, s.
    value : float
        Equivalent (von Mises) stress, Pa.
    position : tuple of float
        Where, undeformed, part frame, m.
    """

    site: str
    time: float
    value: float
    position: tuple[float, float, float]


def stress(
    run: Solution, reduced: ReducedPart, body: str, sites: Sequence[str] | str | None = None
) -> Array:
    """Return the stress history of a body at its stress sites, (nt, ns, 6) in Pa.

    ``s = S p`` with the stress S of each mode: components ``[s11 s22 s33 s12 s23 s13]`` in the
    axes of each site, which turn with the body.

    Parameters
    ----------
    run : Solution
        The results.
    reduced : ReducedPart
        The part the body was made of.
    body : str
        Name of the body.
    sites : sequence of str, optional
        Labels of the sites; None for all of them.

    Raises
    ------
    InputError
        If the body, the part or a site do not fit together.
    """
    field = _field(run, reduced, body, sites)
    return field.history(slice(None))


def peak(
    run: Solution, reduced: ReducedPart, body: str, sites: Sequence[str] | str | None = None
) -> Peak:
    """Return the largest von Mises stress of a run: where, when and how much.

    The history is searched in blocks, so that the memory does not grow with the run.

    Parameters
    ----------
    run, reduced, body, sites
        As for `stress`.

    Raises
    ------
    InputError
        If the body, the part or a site do not fit together.
    """
    worst = hot_spots(_field(run, reduced, body, sites), count=1)[0]
    x, y, z = worst.position.tolist()
    return Peak(worst.site, worst.time, worst.value, (x, y, z))


def surface_stress(
    run: Solution, body: str, times: ArrayLike | None = None
) -> tuple[NDArray[np.int64], Array] | None:
    """Return the von Mises stress over the surface of a solid body, for pictures.

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


def _field(
    run: Solution, reduced: ReducedPart, body: str, sites: Sequence[str] | str | None
) -> StressField:
    return stress_field(run, body, reduced=reduced, sites=sites)
