"""Events: a sensor or coordinate crosses a threshold.

At the event the run ends, a signal switches or a joint is released.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, TypeAlias

from jousto.base.declare import Declared
from jousto.base.errors import Problems, suggest
from jousto.base.fields import Choice, Field, Flag, Name, field
from jousto.base.numbers import Number
from jousto.mechanism.forces.base import ForceElement
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.joints.coupling import Coupler
from jousto.mechanism.sensors.base import Sensor

DIRECTIONS = ("both", "rising", "falling")
FURTHEST = 30
"""Largest distance of components whose size is watched: bits of an int."""
Measurable: TypeAlias = Sensor | Coordinate
Releasable: TypeAlias = Joint | Coupler | ForceElement


class Watched(Field[Measurable, Measurable]):
    """Field of a sensor, given by its name in model files, or of a coordinate."""

    form = "watched"
    noun = "Sensor or Coordinate"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the sensor or coordinate, or report that the value is neither."""
        if not isinstance(value, Sensor | Coordinate):
            problems.add(where, f"watch is {value!r}, must be a sensor or a coordinate", "watch")
        return value


class Component(Field["int | str | Iterable[int | str] | None", "int | tuple[int, ...]"]):
    """Field of the component of a sensor with several components, or of those whose size counts."""

    form = "component"
    noun = "int, str or sequence of int or str"


class Threshold(Number):
    """Field of a value in the unit of the sensor or coordinate."""

    form = "threshold"


class Direction(Choice):
    """Field of the direction of the crossing."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the direction, or report an unknown one."""
        if value not in self.words:
            problems.add(where, f"direction is {value!r}{suggest(value, self.words)}", "direction")
        return value


class Released(Field["Iterable[Releasable] | Releasable", "tuple[Releasable, ...]"]):
    """Field of joints, couplings, drives and forces that an event removes.

    A model file contains their names.
    """

    form = "references"
    section = ("joints", "couplings", "forces")
    word = "joint, coupling or force"
    noun = "sequence of Joint, coupling, drive or force"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the items as a tuple, or report wrong ones."""
        found = (value,) if not isinstance(value, Iterable) else tuple(value)
        for i, one in enumerate(found):
            if not isinstance(one, Joint | Coupler | ForceElement):
                problems.add(
                    where,
                    f"releases[{i}] is {one!r}, must be a joint, a coupling, a drive or a force",
                    "releases",
                    i,
                )
        return found


class Event(Declared, section="events"):
    """Zero crossing: a sensor or coordinate passes a threshold.

    `simulate` locates the crossing in time to 1e-12 s by repeating the step with other lengths.
    A value that crosses and returns within one step is not detected. A value that starts at the
    threshold has not crossed it.
    """

    kind = "event"
    name: Name = field("Unique among the events")
    watch: Watched = field("The watched sensor, or a coordinate such as ``hinge.angle``")
    component: Component = field(
        "Name or number (from 0) of the component, for a sensor with several. Several, such as "
        "``('Fx', 'Fy', 'Fz')``: their size, the root of the sum of the squares, is watched",
        default=None,
        kw_only=True,
    )
    threshold: Threshold = field(
        "Threshold in the unit of the watched sensor or coordinate", default=0.0
    )
    direction: Direction = field(
        "Direction of the crossings that count", words=DIRECTIONS, default="both"
    )
    stop: Flag = field(
        "Whether the run ends at the event; to switch a signal instead, use `Switched`",
        default=False,
    )
    releases: Released = field(
        "Joints, couplings, drives and forces that act only until the event: a bolt that breaks, "
        "a load that is dropped. The energy stored in a released spring is lost",
        default=(),
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Store the indices of the components, or report components that do not exist."""
        given: Any = self.component
        found: int | tuple[int, ...] = 0
        if isinstance(self.watch, Coordinate):
            if given not in (None, 0):
                problems.add(
                    where, f"component is {given!r}: {self.watch.name} is one number", "component"
                )
        elif isinstance(given, Iterable) and not isinstance(given, str):
            found = components_of(problems, where, self.watch, tuple(given))
            low: Any = self.threshold
            if isinstance(low, float | int) and low <= 0:
                problems.add(
                    where, f"threshold is {low:g}, but a size is not negative: above 0", "threshold"
                )
        else:
            found = component_of(problems, where, self.watch, given)
        object.__setattr__(self, "component", found)

    @property
    def components(self) -> tuple[int, ...]:
        """Indices of the watched components, rising; of several their size is watched."""
        found = self.component
        return found if isinstance(found, tuple) else (found,)

    @property
    def watched(self) -> str:
        """Name of what is watched, with its components if the sensor has several."""
        names = () if isinstance(self.watch, Coordinate) else self.watch.components
        if len(names) < 2:
            return self.watch.name
        given = [names[k] for k in self.components]
        part = given[0] if len(given) == 1 else f"size of {', '.join(given)}"
        return f"{self.watch.name} ({part})"

    def __repr__(self) -> str:
        mark = {"both": "crosses", "rising": "rises above", "falling": "falls below"}
        action = ", stop" if self.stop else ""
        return (
            f"<Event {self.name!r}: {self.watched} {mark[self.direction]} "
            f"{self.threshold:g}{action}>"
        )


def component_of(problems: Problems, where: str, sensor: Any, component: int | str | None) -> int:
    """Return the index of a component of a sensor, or report that it does not exist."""
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
            where,
            f"sensor {sensor.name!r} has {len(names)} components, name one: {known}",
            "sensor",
        )
    else:
        problems.add(
            where,
            f"sensor {sensor.name!r} has no component {component!r}; known: {known}",
            "sensor",
        )
    return 0


def components_of(
    problems: Problems, where: str, sensor: Any, given: tuple[int | str, ...]
) -> tuple[int, ...]:
    """Return the indices of several components, rising, or report what is wrong with them."""
    if not given:
        problems.add(where, "component is empty; name one or more components", "component")
        return (0,)
    before = len(problems.found)
    found = sorted(component_of(problems, where, sensor, one) for one in given)
    if len(problems.found) > before:
        return (0,)
    if len(set(found)) < len(found):
        problems.add(where, f"component {given!r} has one twice", "component")
    if found[-1] - found[0] > FURTHEST:
        problems.add(
            where,
            f"component {given!r}: at most {FURTHEST} components may lie between two of them",
            "component",
        )
    units = {unit_at(sensor, k) for k in found}
    if len(units) > 1:
        problems.add(
            where,
            f"component {given!r} has values in {' and in '.join(sorted(units))}, whose squares "
            "have no sum; take those of one unit",
            "component",
        )
    return tuple(found)


def unit_at(sensor: Any, component: int) -> str:
    """Return the SI unit of a component of a sensor, whose halves may have units of their own."""
    units: list[str] = [unit.strip() for unit in sensor.unit.split(",")]
    second = len(units) == 2 and component >= len(getattr(sensor, "components", ())) // 2
    return units[1] if second else units[0]
