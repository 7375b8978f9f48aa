"""Events in the engine: sensors for watched coordinates, places in the sensor vector."""

from __future__ import annotations

from jousto.mechanism.event import Event
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.base import Sensor
from jousto.mechanism.sensors.readings import CoordinateSensor
from jousto.model.model import EventModel, SensorModel

DIRECTIONS = {"both": 0, "rising": 1, "falling": -1}


def watched_coordinates(mechanism: Mechanism) -> tuple[CoordinateSensor, ...]:
    """Return a sensor for every watched coordinate that has none, named like the coordinate.

    Should a sensor have that name already, the name of the event comes before it.
    """
    sensors: list[Sensor] = list(mechanism.sensors)
    added = []
    for event in mechanism.events:
        if isinstance(event.watch, Coordinate) and _place(event, sensors) is None:
            names = {sensor.name for sensor in sensors}
            name = event.watch.name
            sensor = CoordinateSensor(
                f"{event.name}.{name}" if name in names else name, event.watch
            )
            sensors.append(sensor)
            added.append(sensor)
    return tuple(added)


def event_models(
    mechanism: Mechanism, gauges: tuple[Sensor, ...], models: tuple[SensorModel, ...]
) -> list[EventModel]:
    """Return the events of a mechanism; `models` are those of the sensors `gauges`."""
    events = []
    for event in mechanism.events:
        place = _place(event, gauges)
        assert place is not None
        output = models[place].offset + event.component
        direction = DIRECTIONS[event.direction]
        events.append(EventModel(event.name, output, event.threshold, direction, event.stop))
    return events


def _place(event: Event, sensors: list[Sensor] | tuple[Sensor, ...]) -> int | None:
    """Return which sensor measures what the event watches."""
    for i, sensor in enumerate(sensors):
        if sensor is event.watch:
            return i
        if (
            isinstance(event.watch, Coordinate)
            and isinstance(sensor, CoordinateSensor)
            and sensor.coordinate.same_as(event.watch)
        ):
            return i
    return None
