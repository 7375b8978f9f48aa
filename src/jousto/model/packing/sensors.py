"""Sensors of a mechanism for the engine."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.base import Sensor
from jousto.mechanism.sensors.scalar import CoordinateSensor
from jousto.mechanism.signals.base import Signal
from jousto.model.model import MeterModel, SensorModel
from jousto.model.native.header import kinds
from jousto.model.packing.builder import Builder

NOT_UNIQUE = " (not unique: least norm)"


class Places:
    """Engine indices of measured objects; frames only for sensors are stored separately.

    Parameters
    ----------
    mechanism : Mechanism
        The mechanism.
    builder : Builder
        Builder with all joints, forces and coordinates.
    bodies : dict of int to int
        Index of every moving body by id.
    """

    def __init__(self, mechanism: Mechanism, builder: Builder, bodies: dict[int, int]) -> None:
        self._builder = builder
        self._places = {**bodies, **builder.force_places}
        for items in ((*mechanism.joints, *mechanism.couplings), mechanism.frictions):
            self._places |= {id(item): i for i, item in enumerate(items)}
        element = meter = 0  # first free indices of beam elements and of damage meters
        for beam in mechanism.beams:
            self._places[id(beam)] = element
            element += beam.n
        for sensor in mechanism.sensors:
            self._places[id(sensor)] = meter
            meter += len(sensor.meters)
        self._frames: dict[Any, int] = {}

    def frame(self, marker: Marker, turns: bool) -> int:
        """Return the index of a frame for sensors."""
        place = (marker.position_local.tobytes(), marker.axes.tobytes())
        key = (id(marker.body), marker.site, *place, turns)
        if key not in self._frames:
            self._frames[key] = self._builder.marker(marker, turns, shared=False)
        return self._frames[key]

    def of(self, thing: Any, sensor: Sensor) -> int:
        """Return the index of the object that a sensor measures, -1 for None."""
        if thing is None or isinstance(thing, int):
            return -1 if thing is None else thing
        if isinstance(thing, str):
            return kinds("jo_energy_kind")[thing]
        if isinstance(thing, Marker):
            return self.frame(thing, any(thing is marker for _, marker in sensor.turning))
        if isinstance(thing, Coordinate):
            return self._builder.declared(thing)
        if isinstance(thing, Signal):
            return self._builder.signal(thing)
        return self._places[id(thing)]


def sensor_models(
    mechanism: Mechanism,
    builder: Builder,
    bodies: dict[int, int],
    further: tuple[CoordinateSensor, ...] = (),
) -> tuple[SensorModel, ...]:
    """Return the sensors of a mechanism and `further` ones, with consecutive values."""
    places = Places(mechanism, builder, bodies)
    models: list[SensorModel] = []
    offset = 0
    for sensor in (*mechanism.sensors, *further):
        reading = sensor.reading
        models.append(
            SensorModel(
                name=sensor.name,
                kind=reading.kind,
                object=places.of(reading.of, sensor) + reading.at,
                offset=offset,
                count=len(sensor.components),
                unit=sensor.unit,
                resolved_in=sensor.frame,
                description=sensor.description,
                components=tuple(sensor.components),
                rows=reading.rows,
                other=places.of(reading.other, sensor),
                frame=places.of(reading.axes, sensor),
            )
        )
        offset += len(sensor.components)
    return tuple(models)


def meter_models(mechanism: Mechanism, models: tuple[SensorModel, ...]) -> tuple[MeterModel, ...]:
    """Return the damage meters of a mechanism; `models` are the sensors of the model."""
    offsets = {id(s): model.offset for s, model in zip(mechanism.sensors, models, strict=False)}
    return tuple(
        MeterModel(meter.rule, offsets[id(meter.sensor)] + meter.value, meter.factor)
        for sensor in mechanism.sensors
        for meter in sensor.meters
    )


def flag_reactions(
    sensors: tuple[SensorModel, ...],
    joints: tuple[str, ...],
    names: tuple[str, ...],
    rubbing: tuple[int, ...],
) -> tuple[SensorModel, ...]:
    """Return the sensors, with a note on reactions and friction that are not unique.

    Parameters
    ----------
    sensors : tuple of SensorModel
        All sensors.
    joints : tuple of str
        Names of all joints, couplings and drives of the model.
    names : tuple of str
        Names of those with redundant rows.
    rubbing : tuple of int
        Joint of each friction, on whose reactions it depends.
    """

    def shared(sensor: SensorModel) -> bool:
        if sensor.kind == "friction":
            return joints[rubbing[sensor.object]] in names
        return sensor.kind in ("reaction", "multiplier") and joints[sensor.object] in names

    return tuple(
        replace(sensor, description=sensor.description + NOT_UNIQUE) if shared(sensor) else sensor
        for sensor in sensors
    )
