"""Equivalent static loads of a motion, and the ratios of limits under them.

``f(t) = K z(t)`` loads a body at rest so that it deforms as it does in motion (W. S. Choi,
G. J. Park, Comput. Methods Appl. Mech. Eng. 191 (2002) 2077-2094).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from jousto.base.arrays import Array, Ints
from jousto.base.errors import InputError, Problem as Trouble
from jousto.design.optimisation.elastic import Elastic, EquivalentLoad, Motion
from jousto.design.optimisation.limits import BodyLimit, LifeLimit
from jousto.design.optimisation.problem import Kept, Place, Problem

Table = list[tuple[BodyLimit, int, Array]]
"""Ratios value / limit (places, columns) of each limit in each motion."""


def classical(
    x: Array, bodies: Sequence[Elastic], motions: Sequence[Motion]
) -> list[EquivalentLoad]:
    """Return the equivalent static loads of order 0: constant over the design."""
    return [
        EquivalentLoad(m, x, np.asarray(bodies[m.body].K @ m.shapes), m.coordinates)
        for m in motions
    ]


def first_order(problem: Problem, x: Array, size: float) -> list[EquivalentLoad]:
    """Return the equivalent static loads of order 1 with their slopes ``df/dx = d(K z)/dx``.

    Central differences over two runs for each parameter. M. Stolpe and N. Pollini (2023) proposed
    such first-order loads for nonlinear statics.

    Parameters
    ----------
    problem : Problem
    x : (nd,) array
        The design.
    size : float
        Step of the differences as a share of the span of each parameter.
    """
    here = classical(x, problem.bodies(x), problem.motions(x))
    ends_of = [sides(problem, x, i, size) for i in range(len(x))]
    pairs = [
        [classical(y, problem.bodies(y), problem.motions(y)) for y in pair] for pair in ends_of
    ]
    found = []
    for k, load in enumerate(here):
        parts = [load.columns, *(side[k].columns for pair in pairs for side in pair)]
        if len({part.shape[0] for part in parts}) > 1:
            message = (
                f"body {load.motion.body + 1} has another mesh when a parameter changes: loads of"
                " first order need the same nodes; use order=0"
            )
            raise InputError(Trouble("optimise", message))
        widths = [part.shape[1] for part in parts]
        ends = np.cumsum(widths)
        nt = load.values.shape[1]
        values = np.zeros((ends[-1], nt))
        values[: widths[0]] = load.values
        slopes = np.zeros((len(x), ends[-1], nt))
        for i, pair in enumerate(pairs):
            width = ends_of[i][0][i] - ends_of[i][1][i]
            for j, (sign, side) in enumerate(zip((1.0, -1.0), pair, strict=True)):
                y = side[k].values
                same_instants(y.shape[1], nt)
                first = ends[2 * i + j]
                slopes[i, first : first + len(y)] = sign * y / width
        found.append(EquivalentLoad(load.motion, x, np.hstack(parts), values, slopes))
    return found


def sides(problem: Problem, x: Array, i: int, size: float) -> tuple[Array, Array]:
    """Return the designs on both sides of x along one parameter, within its bounds."""
    h = size * (problem.high[i] - problem.low[i])
    up, down = x.copy(), x.copy()
    up[i] = min(x[i] + h, problem.high[i])
    down[i] = max(x[i] - h, problem.low[i])
    return up, down


def same_instants(found: int, wanted: int) -> None:
    """Raise InputError if two designs do not have the same number of instants."""
    if found != wanted:
        message = "the number of instants changes with the design: give output_step="
        raise InputError(Trouble("optimise", message))


def _finite(limit: BodyLimit, ratios: Array) -> Array:
    """Return the ratios of a limit, or raise InputError if they are not finite."""
    if not np.all(np.isfinite(ratios)):
        message = "has values that are not finite: look at the motion, forces and functions"
        raise InputError(Trouble(f"limit on {limit.label}", message))
    return ratios


@dataclass(frozen=True, eq=False)
class Deformed:
    """Static model of a body with its deformation ``z(t) = shapes y(t)``.

    Parameters
    ----------
    body : Elastic
    shapes : (ndof, nc) array
    count : int
        Number of instants.
    coordinates : function
        Returns y (nc, ni) at some instants.
    """

    body: Elastic
    shapes: Array
    count: int
    coordinates: Callable[[Ints], Array]


def deformed(
    problem: Problem, x: Array, loads: Sequence[EquivalentLoad] | None = None
) -> list[Deformed]:
    """Return the bodies of a design, deformed by equivalent loads, or as in its motion (None)."""
    bodies = problem.bodies(x)
    if loads is None:
        return [
            Deformed(
                *(bodies[m.body], m.shapes, len(m.time)),
                lambda i, m=m: m.coordinates[:, i],  # type: ignore[misc]
            )
            for m in problem.motions(x)
        ]
    return [
        Deformed(
            bodies[load.motion.body],
            bodies[load.motion.body].solve(load.columns),
            load.values.shape[1],
            partial(load.coordinates, x),
        )
        for load in loads
    ]


def table_of(problem: Problem, x: Array, loads: Sequence[EquivalentLoad] | None = None) -> Table:
    """Return the ratios of all limits at all instants."""
    table: Table = []
    for k, one in enumerate(deformed(problem, x, loads)):
        y = one.coordinates(np.arange(one.count))
        for limit in limits_of(problem, one.body):
            ratios = limit.ratios(limit.rows(one.body, one.shapes), y)
            table.append((limit, k, _finite(limit, ratios)))
    return table


def limits_of(problem: Problem, body: Elastic) -> list[BodyLimit]:
    """Return the limits on one body."""
    limits = [limit for limit in problem.limits if isinstance(limit, BodyLimit)]
    return [limit for limit in limits if limit.body == body.name]


def screened(table: Table, share: float, most: int = 400) -> list[Kept]:
    """Return the rows with at least a given share of the largest ratio of their limit.

    At most `most` rows per limit, the largest first; equal ones are sorted by place, then instant.
    """
    kept = []
    for limit, motion, r in table:
        places, columns = np.nonzero(r >= share * r.max())
        order = np.argsort(-r[places, columns], kind="stable")[:most]
        order.sort()
        places, columns = places[order], columns[order]
        if isinstance(limit, LifeLimit):
            kept.append(Kept(limit, motion, places, columns, None, 0))
        else:
            instants, columns = np.unique(columns, return_inverse=True)
            kept.append(Kept(limit, motion, places, columns, instants, r.shape[1]))
    return kept


def ratios_of(
    problem: Problem,
    x: Array,
    kept: Sequence[Kept],
    loads: Sequence[EquivalentLoad] | None = None,
) -> Array:
    """Return the ratios of the kept rows in one array."""
    bodies = deformed(problem, x, loads)
    found = [problem.fixed(x)]
    for row in kept:
        one = bodies[row.motion]
        if row.instants is not None:
            same_instants(one.count, row.count)
        y = one.coordinates(np.arange(one.count) if row.instants is None else row.instants)
        r = _finite(row.limit, row.limit.ratios(row.limit.rows(one.body, one.shapes), y))
        found.append(r[row.places, row.columns])
    return np.concatenate(found)


def labels(problem: Problem, x: Array, kept: Sequence[Kept]) -> list[Place]:
    """Return the `Place` of each kept row."""
    bodies, motions = problem.bodies(x), problem.motions(x)
    found = [Place(name) for name in problem.fixed_labels]
    for one in kept:
        motion = motions[one.motion]
        names = one.limit.places(bodies[motion.body])
        for place, column in zip(one.places, one.columns, strict=True):
            time = float("nan") if one.instants is None else motion.time[one.instants[column]]
            found.append(Place(one.limit.label, names[place], motion.case, float(time)))
    return found
