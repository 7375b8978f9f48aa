"""Events: something measured crosses a threshold; the run stops or a signal switches."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from jousto.base.errors import Problems, suggest
from jousto.base.names import check_name
from jousto.base.numbers import number, set_fields
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.sensors.kinds import SENSORS, Sensor

DIRECTIONS = ("both", "rising", "falling")


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Event:
    """A zero crossing: the watched value passes the threshold.

    `simulate` locates it in time by repeating the step with other lengths, to 1e-12 s; a value that
    comes back within one step is not seen. Who starts at the threshold has not crossed it.

    Parameters
    ----------
    name : str
        Name, unique among the events.
    watch : Sensor or Coordinate
        What is watched.
    threshold : float
        Value that is passed, in the unit of what is watched.
    direction : {"both", "rising", "falling"}
        Which crossings count.
    stop : bool
        Whether the run ends there. A `Switched` signal refers to the event instead.
    component : int or str, optional
        Number from 0 or name of the component of a sensor that has several.
    """

    kind: ClassVar[str] = "event"
    name: str
    watch: Sensor | Coordinate
    threshold: float
    direction: str
    stop: bool
    component: int

    def __init__(
        self,
        name: str,
        watch: Sensor | Coordinate,
        threshold: float = 0.0,
        direction: str = "both",
        stop: bool = False,
        *,
        component: int | str | None = None,
    ) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        value = number(problems, where, "threshold", threshold)
        if direction not in DIRECTIONS:
            problems.add(where, f"direction is {direction!r}{suggest(direction, DIRECTIONS)}")
        index = 0
        if isinstance(watch, SENSORS):
            index = component_of(problems, where, watch, component)
        elif not isinstance(watch, Coordinate):
            problems.add(where, f"watch is {watch!r}, must be a sensor or a coordinate")
        elif component is not None:
            problems.add(where, f"component is {component!r}: {watch.name} is one number")
        problems.raise_if_any()
        set_fields(
            self,
            name=name,
            watch=watch,
            threshold=value,
            direction=direction,
            stop=bool(stop),
            component=index,
        )

    def __repr__(self) -> str:
        mark = {"both": "crosses", "rising": "rises above", "falling": "falls below"}
        action = ", stop" if self.stop else ""
        return (
            f"<Event {self.name!r}: {self.watch.name} {mark[self.direction]} "
            f"{self.threshold:g}{action}>"
        )


def component_of(problems: Problems, where: str, sensor: Any, component: int | str | None) -> int:
    """Return the number of a component of a sensor, or note why there is none."""
    names = sensor.components
    known = ", ".join(names[:8]) + (", ..." if len(names) > 8 else "")
    if component is None and len(names) == 1:
        return 0
    if isinstance(component, str) and component in names:
        return int(names.index(component))
    if isinstance(component, int) and 0 <= component < len(names):
        return component
    if component is None:
        problems.add(
            where, f"sensor {sensor.name!r} has {len(names)} components, name one: {known}"
        )
    else:
        problems.add(
            where, f"sensor {sensor.name!r} has no component {component!r}; known: {known}"
        )
    return 0
