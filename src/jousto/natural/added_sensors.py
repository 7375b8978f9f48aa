"""Sensors that verify adds to a mechanism, and typical values of each unit."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from jousto.mechanism.beams.discretisation import BeamNode
from jousto.mechanism.bodies.body import Body, FlexibleBody, RigidBody
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.forces.base import ForceElement
from jousto.mechanism.forces.friction import Friction
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coupling import Coupler
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.base import Sensor
from jousto.mechanism.sensors.loads import ForceSensor, ReactionSensor
from jousto.mechanism.sensors.motion import AccelerationSensor, AngularAccelerationSensor
from jousto.mechanism.sensors.scalar import EnergySensor
from jousto.natural.equations.supported import is_read
from jousto.simulation.results.dataframes import component_units
from jousto.simulation.results.solution import Solution

SOME_NODES = 4  # number of nodes per flexible body with acceleration sensors


def with_added_sensors(mechanism: Mechanism, *, every: bool = False) -> Mechanism:
    """Return the mechanism with sensors of all accelerations, reactions, forces and energies.

    Parameters
    ----------
    mechanism : Mechanism
    every : bool
        Whether to keep sensors that the moving frame does not support.
    """
    kept = [
        item for item in mechanism.items if every or not isinstance(item, Sensor) or is_read(item)
    ]
    taken = {sensor.name for sensor in mechanism.sensors}
    more = [sensor for sensor in added_sensors(mechanism) if sensor.name not in taken]
    return Mechanism(*kept, *more, name=mechanism.name, core=mechanism.core)


def added_sensors(mechanism: Mechanism) -> Iterator[Sensor]:
    """Yield the added sensors."""
    for body in mechanism.bodies:
        if isinstance(body, BeamNode):
            continue
        for marker in places(body):
            yield AccelerationSensor(f"acceleration of {marker.label}", marker)
            if not isinstance(body, FlexibleBody) or marker.Psi.any():
                yield AngularAccelerationSensor(f"angular acceleration of {marker.label}", marker)
    sensed = {id(s.reading.of) for s in mechanism.sensors}
    held: tuple[Joint | Coupler, ...] = (*mechanism.joints, *mechanism.couplings)
    for joint in held:
        if id(joint) not in sensed:
            yield ReactionSensor(f"reaction of {joint.name}", joint)
    pushing: tuple[ForceElement | Friction, ...] = (*mechanism.forces, *mechanism.frictions)
    for force in pushing:
        if id(force) not in sensed:
            yield ForceSensor(f"force of {force.name}", force)
    for term in ("kinetic", "potential"):
        yield EnergySensor(f"{term} energy", term)
    if any(isinstance(body, FlexibleBody) for body in mechanism.bodies):
        yield EnergySensor("strain energy", "strain")
    if mechanism.forces:
        yield EnergySensor("energy of springs", "springs")


def places(body: Body) -> list[Marker]:
    """Return markers of a body whose accelerations determine those of its frame and modes."""
    if not isinstance(body, FlexibleBody):
        if isinstance(body, RigidBody):
            return [body["center"]]
        return [Marker(body, "node", np.zeros(3), None, np.eye(3))]
    nodes = np.unique(np.linspace(0, len(body.reduced.nodes) - 1, SOME_NODES).astype(int))
    still, turned = np.zeros(3), np.eye(3)
    return [
        Marker(body, f"node{k + 1}", body.reduced.nodes[k] + still, int(k), turned) for k in nodes
    ]


def largest_of(run: Solution, last: int | None = None) -> dict[str, float]:
    """Return the largest value of every unit in a run, or in its first `last` outputs."""
    found: dict[str, float] = {}
    for name in run:
        top = np.abs(run[name][:last]).max(axis=0, initial=0.0)
        for unit, x in zip(component_units(run.about(name)), top, strict=True):
            found[unit] = max(found.get(unit, 0.0), float(x))
    return found


def typical_sizes(
    mechanism: Mechanism, t_end: float, largest: dict[str, float]
) -> dict[str, float]:
    """Return typical values of units, from size, weight, duration and largest values.

    The typical force includes the largest force of the machine, whose rounding error affects all
    forces in equilibrium with it.
    """
    mass = sum(
        float(b.reduced.invariants.mass if isinstance(b, FlexibleBody) else b.mass)
        for b in mechanism.bodies
    )
    length = mechanism.size
    a = max(float(np.linalg.norm(mechanism.gravity)), length / t_end**2)
    force = max(mass * a, largest.get("N", 0.0))
    a = max(a, largest.get("m/s2", 0.0))
    return {
        "m": length,
        "rad": 1.0,
        "1": 1.0,
        "m/s": length / t_end,
        "rad/s": 1.0 / t_end,
        "m/s2": a,
        "rad/s2": a / length,
        "N": force,
        "N m": force * length,
        "J": force * length,
    }
