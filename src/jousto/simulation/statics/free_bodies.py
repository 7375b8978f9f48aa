"""Check for bodies without a link to the ground under a load with a resultant."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import SimulationError
from jousto.model.model import ForceModel, JointModel, Model
from jousto.simulation.state import State
from jousto.simulation.statics.residual import TIME, Balance

GROUND = -1
NOTHING = 1e-9
"""Of the sum of the absolute forces on a group: the resultant that is left of forces in balance."""
UNHELD = (
    "a force acts on body '{}' in a direction in which nothing holds it; add a joint, "
    "or remove the load"
)


def check_adrift(model: Model, state: State | None) -> None:
    """Raise an error for a group of bodies without a link to the ground and with a resultant load.

    Forces between bodies have no resultant; gravity and loads of fixed direction have the same one
    at all positions. If it is not zero, there is no equilibrium. Groups with other forces, such as
    follower loads, are not checked.

    Raises
    ------
    SimulationError
        If there is such a group; the message names one of its bodies.
    """
    groups = _adrift(model)
    if not groups:
        return
    balance = Balance(model, TIME, state, where="equilibrium", frictionless=True)
    q, lam = balance.engine.q, np.zeros(model.nrow)
    forces = balance.residual(np.array(q), lam, balance.value)
    for group in groups:
        pushes: Array = np.array([forces[model.bodies[k].iv :][:3] for k in group])
        if np.abs(pushes.sum(axis=0)).max() > NOTHING * np.abs(pushes).sum():
            body = model.bodies[group[0]].name
            raise SimulationError(
                f"no static equilibrium found: {UNHELD.format(body)}",
                time=balance.value,
                body=body,
            )


def _adrift(model: Model) -> list[list[int]]:
    """Return groups of linked bodies whose only outer loads have a fixed direction."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    pairs = [(element.a, element.b) for element in model.beams]
    for links in (
        *(_of_joint(model, joint) for joint in model.joints),
        *(_of_force(model, force) for force in model.forces),
    ):
        first = next(links, GROUND)  # a slot of a set of contacts has no bodies of its own
        pairs += [(first, other) for other in links]
    n = len(model.bodies)  # index n is the ground
    a, b = np.array(pairs, dtype=np.int64).reshape(-1, 2).T % (n + 1)
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(n + 1, n + 1))
    label = connected_components(graph, directed=False)[1]
    groups: dict[int, list[int]] = {}
    for k in range(n):
        groups.setdefault(int(label[k]), []).append(k)
    groups.pop(int(label[n]), None)
    return list(groups.values())


def _of_joint(model: Model, joint: JointModel) -> Iterator[int]:
    """Yield the bodies that a joint connects."""
    yield from (model.markers[side].body for side in joint.sides)
    for line in joint.lines:
        for place in line.coordinates:
            yield from _of_coordinate(model, place)


def _of_coordinate(model: Model, place: int) -> Iterator[int]:
    c = model.coordinates[place]
    yield from (model.markers[c.a].body, model.markers[c.b].body)


def _of_force(model: Model, force: ForceModel) -> Iterator[int]:
    """Yield the bodies linked by a force, with the ground if its resultant depends on positions."""
    if force.body >= 0:
        yield force.body
    sides = (force.a, force.b, *force.touches)
    yield from dict.fromkeys(model.markers[side].body for side in sides if side >= 0)
    for place in force.coordinates:
        yield from _of_coordinate(model, place)
    dead = force.kind == "load" and not force.follow
    if not (dead or force.law.between):
        yield GROUND
