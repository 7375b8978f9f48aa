"""Events: something measured crosses a threshold; the run stops or a signal switches."""

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
Measurable: TypeAlias = Sensor | Coordinate
Releasable: TypeAlias = Joint | Coupler | ForceElement


class Watched(Field[Measurable, Measurable]):
    """A sensor, which a model file gives by its name, or a coordinate."""

    form = "watched"
    noun = "Sensor or Coordinate"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return what is watched."""
        if not isinstance(value, Sensor | Coordinate):
            problems.add(where, f"watch is {value!r}, must be a sensor or a coordinate", "watch")
        return value


class Component(Field["int | str | None", int]):
    """The component of a sensor that has several."""

    form = "component"
    noun = "int or str"


class Threshold(Number):
    """A value in the unit of what is watched."""

    form = "threshold"


class Direction(Choice):
    """Which crossings count."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return one of the words."""
        if value not in self.words:
            problems.add(where, f"direction is {value!r}{suggest(value, self.words)}", "direction")
        return value


class Released(Field["Iterable[Releasable] | Releasable", "tuple[Releasable, ...]"]):
    """Joints, couplings, drives and forces that an event ends; a model file gives their names."""

    form = "references"
    section = ("joints", "couplings", "forces")
    word = "joint, coupling or force"
    noun = "sequence of Joint, coupling, drive or force"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return them as a tuple."""
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
    """A zero crossing: the watched value passes the threshold.

    `simulate` locates it in time by repeating the step with other lengths, to 1e-12 s; a value that
    comes back within one step is not seen. Who starts at the threshold has not crossed it.
    """

    kind = "event"
    name: Name = field("Unique among the events")
    watch: Watched = field("What is watched: a sensor, or a coordinate such as ``hinge.angle``")
    component: Component = field(
        "Number from 0 or name of the component of a sensor that has several",
        default=None,
        kw_only=True,
    )
    threshold: Threshold = field(
        "Value that is passed, in the unit of what is watched", default=0.0
    )
    direction: Direction = field("Which crossings count", words=DIRECTIONS, default="both")
    stop: Flag = field(
        "Whether the run ends there; a `Switched` signal refers to the event instead",
        default=False,
    )
    releases: Released = field(
        "Joints, couplings, drives and forces that hold or act only until the event happens: a "
        "bolt that breaks, a load that is dropped. What a released spring has stored is lost",
        default=(),
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Keep the number of the component; note one that does not exist."""
        given: int | str | None = self.component
        index = 0
        if not isinstance(self.watch, Coordinate):
            index = component_of(problems, where, self.watch, given)
        elif given is not None:
            problems.add(
                where, f"component is {given!r}: {self.watch.name} is one number", "component"
            )
        object.__setattr__(self, "component", index)

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
