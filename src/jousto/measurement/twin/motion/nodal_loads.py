"""Loads on the nodes of a part: of all loads on a body of a run, or given by the user."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.measurement.twin.motion.balance import Load
from jousto.recovery.loads.body_loads import BodyLoad, BodyLoads
from jousto.recovery.loads.nodal_forces import LEVER, NEAR
from jousto.recovery.loads.own_loads import OWN
from jousto.reduction.reduced import ReducedPart


def given_at_nodes(
    problems: Problems,
    where: str,
    reduced: ReducedPart,
    loads: Mapping[str, ArrayLike],
    A: Array,
) -> list[Load]:
    """Return the loads that the user gives by node, turned from world axes into the body frame."""
    found = []
    for name, given in loads.items():
        columns = 6 if np.shape(given)[-1:] == (6,) else 3
        load = problems.array(where, f"loads[{name!r}]", given, (len(A), columns))
        if load is None:
            continue
        node = reduced.node(name)
        force, moment = np.einsum("tba,tb->ta", A, load[:, :3]), np.zeros((len(A), 3))
        if columns == 6 and reduced.rotation(node) is not None:
            moment = np.einsum("tba,tb->ta", A, load[:, 3:])
        elif columns == 6 and np.any(load[:, 3:]):
            problems.add(where, f"loads[{name!r}] has moments, but node {name!r} has no rotations")
        found.append((node, force, moment))
    return found


def loads_at_nodes(
    problems: Problems, where: str, reduced: ReducedPart, loads: BodyLoads, time: Array
) -> list[Load]:
    """Return the loads on a body at the nodes of a part in its frame, without its own loads."""
    here, found = loads.resolved("body"), []
    if here.time.shape != time.shape or not np.array_equal(here.time, time):
        problems.add(where, "loads have other instants than the run; give loads_of(run, body)")
        return []
    size = float(np.ptp(reduced.nodes, axis=0).max())
    largest = max(
        (
            np.abs(x).max(initial=0.0)
            for load in here.loads
            for x in (load.force * size, load.moment)
        ),
        default=0.0,
    )
    for name, load in here.items():
        if load.kind in OWN:
            continue
        turns = np.abs(load.moment).max(initial=0.0) > LEVER * largest
        node = node_of(problems, where, reduced, name, load, turns=turns, near=NEAR * size)
        if node is not None:
            found.append((node, load.force, load.moment))
    return found


def node_of(
    problems: Problems,
    where: str,
    reduced: ReducedPart,
    name: str,
    load: BodyLoad,
    *,
    turns: bool,
    near: float,
) -> int | None:
    """Return the node of a part where a load acts, one with rotations if the load has a moment."""
    if load.position is None:
        place = load.place or "the whole body"
        problems.add(where, f"load {name!r} acts on {place}, not at one node of the part")
        return None
    distance = np.linalg.norm(reduced.nodes - load.position, axis=1)
    nodes = [int(k) for k in np.flatnonzero(distance <= near)]
    if not nodes:
        k = int(np.argmin(distance))
        problems.add(
            where,
            f"load {name!r} acts at {load.place}, {distance[k]:.3g} m from the nearest node of "
            f"part '{reduced.name}', node {k}; give the part an interface there",
        )
        return None
    turning = [k for k in nodes if reduced.rotation(k) is not None]
    if turns and not turning:
        problems.add(
            where,
            f"load {name!r} has a moment, but the node at {load.place} does not turn; give the "
            f"part an interface there",
        )
        return None
    return (turning or nodes)[0]
