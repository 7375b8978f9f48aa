"""Sensors in the small vocabulary of the engine."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.forces.friction import Friction
from jousto.mechanism.joints.coupling import Coupler
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.body import (
    ModalSensor,
    PrincipalStressSensor,
    StressSensor,
    VonMisesSensor,
)
from jousto.mechanism.sensors.bridge import Bridge
from jousto.mechanism.sensors.damage import DamageSensor
from jousto.mechanism.sensors.gauge import Gauge
from jousto.mechanism.sensors.loads import ForceSensor, ReactionSensor
from jousto.mechanism.sensors.motion import MotionSensor
from jousto.mechanism.sensors.readings import (
    CoordinateSensor,
    EnergySensor,
    RateSensor,
    SignalSensor,
)
from jousto.mechanism.sensors.rosette import Rosette
from jousto.mechanism.sensors.section import SectionSensor
from jousto.model.builder import Builder
from jousto.model.model import MeterModel, SensorModel
from jousto.model.native.header import kinds

NOT_UNIQUE = " (not unique: least norm)"
ROWS = {
    StressSensor: "stress",
    VonMisesSensor: "von mises",
    PrincipalStressSensor: "principal",
}


@dataclass(frozen=True)
class Measure:
    """What the engine needs to know of a sensor; fields as in `SensorModel`."""

    kind: str
    object: int
    rows: NDArray[np.float64] | None = None
    other: int = -1
    frame: int = -1


class Measures:
    """Turns sensors into measures; frames that only sensors use are kept apart.

    Parameters
    ----------
    mechanism : Mechanism
        The mechanism.
    builder : Builder
        With all joints, forces and coordinates.
    bodies : dict of int to int
        Index of every moving body by its id.
    """

    def __init__(self, mechanism: Mechanism, builder: Builder, bodies: dict[int, int]) -> None:
        self._builder = builder
        self._bodies = bodies
        joints = (*mechanism.joints, *mechanism.couplings)
        self._joints = {id(joint): i for i, joint in enumerate(joints)}
        self._forces = builder.force_places
        self._frictions = {id(friction): i for i, friction in enumerate(mechanism.frictions)}
        self._elements: dict[int, int] = {}  # first element of every beam
        for beam in mechanism.beams:
            self._elements[id(beam)] = sum(b.n for b in mechanism.beams[: len(self._elements)])
        self._frames: dict[Any, int] = {}
        self._meters = 0

    def frame(self, marker: Marker | None, turns: bool = True) -> int:
        """Return the index of a frame for sensors, -1 for the world."""
        if marker is None:
            return -1
        place = (marker.position_local.tobytes(), marker.axes.tobytes())
        key = (id(marker.body), marker.node, *place, turns)
        if key not in self._frames:
            self._frames[key] = self._builder.marker(marker, turns, shared=False)
        return self._frames[key]

    def __call__(self, sensor: Any) -> Measure:
        """Return what the engine measures for a sensor."""
        if isinstance(sensor, MotionSensor):
            turning = {key for key, _ in sensor.turning}
            return Measure(
                sensor.quantity,
                self.frame(sensor.marker, "marker" in turning),
                other=self.frame(sensor.relative_to, "relative_to" in turning),
                frame=self.frame(sensor.axes),
            )
        if isinstance(sensor, ReactionSensor):
            kind = "multiplier" if isinstance(sensor.joint, Coupler) else "reaction"
            return Measure(kind, self._joints[id(sensor.joint)], frame=self.frame(sensor.axes))
        if isinstance(sensor, ForceSensor) and isinstance(sensor.force, Friction):
            return Measure("friction", self._frictions[id(sensor.force)])
        if isinstance(sensor, ForceSensor):
            place = self._forces[id(sensor.force)]
            return Measure("element", place, other=sensor.first, frame=self.frame(sensor.axes))
        if isinstance(sensor, ModalSensor):
            return Measure("modal", self._bodies[id(sensor.body)])
        if isinstance(sensor, Gauge | Rosette):
            signal = self._builder.signal(sensor.signal)
            place = self._bodies[id(sensor.body)]
            return Measure("stress", place, rows=sensor.rows, other=signal)
        if isinstance(sensor, SectionSensor):
            place = self._elements[id(sensor.beam)] + sensor.element
            return Measure("section", place, other=sensor.first)
        if isinstance(sensor, Bridge):
            # rows of the arms, then one with their drifts
            rows = np.zeros((5, max(sensor.arm_rows.shape[1], 4)))
            rows[:4, : sensor.arm_rows.shape[1]] = sensor.arm_rows
            rows[4, :4] = sensor.arm_drift
            signal = self._builder.signal(sensor.signal)
            return Measure("bridge", self._bodies[id(sensor.body)], rows=rows, other=signal)
        if type(sensor) in ROWS:
            return Measure(ROWS[type(sensor)], self._bodies[id(sensor.body)], rows=sensor.rows)
        if isinstance(sensor, CoordinateSensor | RateSensor):
            kind = "coordinate" if isinstance(sensor, CoordinateSensor) else "rate"
            return Measure(kind, self._builder.declared(sensor.coordinate))
        if isinstance(sensor, EnergySensor):
            return Measure("energy", kinds("jo_energy_kind")[sensor.energy])
        if isinstance(sensor, SignalSensor):
            return Measure("signal", self._builder.signal(sensor.signal))
        if isinstance(sensor, DamageSensor):
            first, self._meters = self._meters, self._meters + len(sensor.measured)
            return Measure("damage", first)
        raise TypeError(f"no engine sensor for {type(sensor).__name__}")


def sensor_models(
    mechanism: Mechanism,
    builder: Builder,
    bodies: dict[int, int],
    further: tuple[CoordinateSensor, ...] = (),
) -> tuple[SensorModel, ...]:
    """Return the sensors of a mechanism and `further` ones, their values one after the other."""
    measure = Measures(mechanism, builder, bodies)
    models: list[SensorModel] = []
    offset = 0
    for sensor in (*mechanism.sensors, *further):
        found = measure(sensor)
        models.append(
            SensorModel(
                name=sensor.name,
                kind=found.kind,
                object=found.object,
                offset=offset,
                count=len(sensor.components),
                unit=sensor.unit,
                resolved_in=sensor.frame,
                description=sensor.description,
                components=tuple(sensor.components),
                rows=found.rows,
                other=found.other,
                frame=found.frame,
            )
        )
        offset += len(sensor.components)
    return tuple(models)


def meter_models(mechanism: Mechanism, models: tuple[SensorModel, ...]) -> tuple[MeterModel, ...]:
    """Return the damage meters of a mechanism; `models` are those of its sensors."""
    offsets = {id(s): model.offset for s, model in zip(mechanism.sensors, models, strict=False)}
    return tuple(
        MeterModel(sensor.rule, offsets[id(sensor.sensor)] + place, sensor.factor)
        for sensor in mechanism.sensors
        if isinstance(sensor, DamageSensor)
        for place in sensor.places
    )


def flag_reactions(
    sensors: tuple[SensorModel, ...], joints: tuple[str, ...], names: tuple[str, ...]
) -> tuple[SensorModel, ...]:
    """Return the sensors, with a note on those of reactions that are not unique.

    Parameters
    ----------
    sensors : tuple of SensorModel
        All sensors.
    joints : tuple of str
        Names of all joints, couplings and drives of the model.
    names : tuple of str
        Those whose rows repeat others.
    """
    return tuple(
        replace(sensor, description=sensor.description + NOT_UNIQUE)
        if sensor.kind in ("reaction", "multiplier") and joints[sensor.object] in names
        else sensor
        for sensor in sensors
    )
