"""Stress of a moving body from its modal coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.errors import InputError, Problem, Problems, suggest
from jousto.recovery.shape import bracket, find_body
from jousto.reduction import ReducedPart
from jousto.simulation import Solution

Array = NDArray[np.float64]
BLOCK_BYTES = 64 << 20


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
    """

    site: str
    time: float
    value: float


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
    S = _modes(reduced, sites)[1]
    return np.asarray(np.einsum("scj,tj->tsc", S, _modal(run, reduced, body)))


def von_mises(s: ArrayLike) -> Array:
    """Return the equivalent stress (...,) of stresses (..., 6) in Voigt order.

    ``sqrt(((s11-s22)^2 + (s22-s33)^2 + (s33-s11)^2) / 2 + 3 (s12^2 + s23^2 + s13^2))``

    Examples
    --------
    >>> von_mises([[100.0, 0, 0, 0, 0, 0], [0, 0, 0, 100.0, 0, 0], [5, 5, 5, 0, 0, 0]]).round(2)
    array([100.  , 173.21,   0.  ])
    """
    s11, s22, s33, s12, s23, s13 = np.moveaxis(np.asarray(s, dtype=np.float64), -1, 0)
    direct = (s11 - s22) ** 2 + (s22 - s33) ** 2 + (s33 - s11) ** 2
    return np.asarray(np.sqrt(0.5 * direct + 3.0 * (s12**2 + s23**2 + s13**2)))


def peak(
    run: Solution, reduced: ReducedPart, body: str, sites: Sequence[str] | str | None = None
) -> Peak:
    """Return the largest von Mises stress of a run: where, when and how much.

    The history is searched in blocks of time, so that the memory does not grow with the run.

    Parameters
    ----------
    run, reduced, body, sites
        As for `stress`.

    Raises
    ------
    InputError
        If the body, the part or a site do not fit together.
    """
    labels, S = _modes(reduced, sites)
    p = _modal(run, reduced, body)
    rows = max(1, BLOCK_BYTES // (8 * S[:, :, 0].size))
    best = Peak(labels[0], float(run.time[0]), -1.0)
    for start in range(0, len(p), rows):
        value = von_mises(np.einsum("scj,tj->tsc", S, p[start : start + rows]))
        at, site = np.unravel_index(int(np.argmax(value)), value.shape)
        if value[at, site] > best.value:
            time = float(run.time[start + int(at)])
            best = Peak(labels[int(site)], time, float(value[at, site]))
    return best


def surface_stress(
    run: Solution, body: str, times: ArrayLike | None = None
) -> tuple[NDArray[np.int64], Array] | None:
    """Return the von Mises stress over the surface of a solid body, for pictures.

    Parameters
    ----------
    run : Solution
        The results; they hold the stress of each mode with seven digits.
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
    known = run.surface_stress(body)
    if known is None:
        return None
    nodes, S = known
    start = shape.q_offset + 7
    p = run.q[:, start : start + shape.n]
    if times is not None:
        before, after, share = bracket(run, times)
        p = (1.0 - share[:, None]) * p[before] + share[:, None] * p[after]
    flat = S.reshape(-1, shape.n).astype(np.float64)
    values = np.empty((len(p), len(nodes)))
    rows = max(1, BLOCK_BYTES // (8 * max(len(flat), 1)))
    for first in range(0, len(p), rows):
        s = p[first : first + rows] @ flat.T
        values[first : first + rows] = von_mises(s.reshape(len(s), -1, 6))
    return nodes, values


def _modes(
    reduced: ReducedPart, sites: Sequence[str] | str | None
) -> tuple[tuple[str, ...], Array]:
    """Return labels and stress modes (ns, 6, n) of the chosen sites."""
    where = f"part '{reduced.name}'"
    if reduced.stress is None:
        raise InputError(Problem(where, "no stress modes; the part it was made of knows no stress"))
    known = {label: i for i, label in enumerate(reduced.stress.labels)}
    labels = tuple(known) if sites is None else (sites,) if isinstance(sites, str) else tuple(sites)
    problems = Problems()
    if not labels:
        problems.add(where, "sites is empty; None takes all of them")
    for label in labels:
        if label not in known:
            problems.add(where, f"no stress site '{label}'{suggest(label, known)}")
    problems.raise_if_any()
    return labels, reduced.stress.modes[[known[label] for label in labels]]


def _modal(run: Solution, reduced: ReducedPart, body: str) -> Array:
    """Return the modal coordinates (nt, n) of a body made of this part."""
    shape = find_body(run, body)
    if shape.n != reduced.n or shape.modes.shape != reduced.modes.shape:
        raise InputError(
            Problem(
                f"body '{body}'",
                f"has {shape.n} modes at {len(shape.nodes)} nodes, but part '{reduced.name}' has "
                f"{reduced.n} at {len(reduced.nodes)}; give the part the body was made of",
            )
        )
    if not np.allclose(shape.modes, reduced.modes, rtol=1e-9, atol=1e-12):
        raise InputError(
            Problem(f"body '{body}'", f"its mode shapes are not those of part '{reduced.name}'")
        )
    start = shape.q_offset + 7
    return run.q[:, start : start + shape.n]
