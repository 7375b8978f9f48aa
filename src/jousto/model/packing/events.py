"""Events for the engine: sensors of watched coordinates, indices in the sensor vector."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from jousto.mechanism.event import Event
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.base import Sensor
from jousto.mechanism.sensors.scalar import CoordinateSensor
from jousto.model.model import EventModel, SensorModel

DIRECTIONS = {"both": 0, "rising": 1, "falling": -1}


def watched_coordinates(mechanism: Mechanism) -> tuple[CoordinateSensor, ...]:
    """Return a sensor for every watched coordinate without one, with the coordinate's name.

    If a sensor has that name already, the name of the event is put before it.
    """
    measured = set(_places(mechanism.sensors))
    names = {sensor.name for sensor in mechanism.sensors}
    added = []
    for event in mechanism.events:
        if isinstance(event.watch, Coordinate) and _watched(event) not in measured:
            name = event.watch.name
            sensor = CoordinateSensor(
                f"{event.name}.{name}" if name in names else name, event.watch
            )
            measured.add(_watched(event))
            names.add(sensor.name)
            added.append(sensor)
    return tuple(added)


def event_models(
    mechanism: Mechanism, gauges: tuple[Sensor, ...], models: tuple[SensorModel, ...]
) -> list[EventModel]:
    """Return the events of a mechanism; `models` are those of the sensors `gauges`."""
    events, places = [], _places(gauges)
    for event in mechanism.events:
        first, *others = event.components
        output = models[places[_watched(event)]].offset + first
        bits = sum(1 << (other - first - 1) for other in others)
        direction = DIRECTIONS[event.direction]
        events.append(EventModel(event.name, output, bits, event.threshold, direction, event.stop))
    return events


def _watched(event: Event) -> Any:
    """Return the watched sensor or coordinate of an event as a key of `_places`."""
    return event.watch.key if isinstance(event.watch, Coordinate) else id(event.watch)


def _places(sensors: Sequence[Sensor]) -> dict[Any, int]:
    """Return the index of every sensor, by its id and by the coordinate that it measures."""
    places: dict[Any, int] = {}
    for i, sensor in enumerate(sensors):
        places.setdefault(id(sensor), i)
        if isinstance(sensor, CoordinateSensor):
            places.setdefault(sensor.coordinate.key, i)
    return places
