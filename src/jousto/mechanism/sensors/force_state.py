"""Sensor of first-order states of forces, such as plastic deformation or integral parts."""

from __future__ import annotations

from typing import Any, ClassVar

from jousto.base.errors import Problems, suggest
from jousto.base.fields import Field, Reference, field
from jousto.mechanism.forces.base import ForceElement
from jousto.mechanism.forces.law import law_of, unit_along
from jousto.mechanism.sensors.base import Reading, Sensor


class Stateful(Reference[ForceElement, ForceElement]):
    """Field of a force element that has states; a model file contains its name."""

    section = ("forces",)
    word = "force"
    noun = "PlasticSpring, PID or another force element with states"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the force element, or report that it has no states."""
        if not isinstance(value, ForceElement):
            problems.add(where, f"{self.name} is {value!r}, must be a {self.noun}")
        elif not any(push.states for push in value.pushes):
            problems.add(
                where,
                f"{value.kind} {value.name!r} has no states; take a {self.noun}, or a ForceSensor "
                "for its force",
                self.name,
            )
        return value


class StateName(Field[str, str]):
    """Field of the name of a state."""

    form = "text"
    noun = "str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the name, or report a value that is not a word."""
        if not isinstance(value, str):
            problems.add(where, f"{self.name} is {value!r}, must be the name of a state")
        return value


class ForceStateSensor(Sensor, tag="force-state"):
    """First-order state of a force element, at the instant of the row.

    States of a `PlasticSpring`: ``plastic`` (plastic deformation), ``back`` (back force), ``path``
    (length of the plastic path), ``dissipated`` (J) and ``flow`` (direction of the flow at the end
    of the last step, 0 for none); of a `PID`: ``integral`` and ``filtered``.
    """

    frame: ClassVar[str] = "coordinate"
    components: ClassVar[tuple[str, ...]] = ("x",)
    force: Stateful = field("Force element with the state")
    state: StateName = field("Name of the state", default="plastic")

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a state that the force does not have."""
        names = self._push.states
        if self.state not in names:
            more = suggest(self.state, names) or f"; there are: {', '.join(names)}"
            problems.add(
                where,
                f"{self.force.name!r} has no state {self.state!r}{more}",
                "state",
                named=False,
            )
        elif getattr(self.force, "sticks", False) and self.state not in ("approach", "since"):
            problems.add(
                where,
                f"the friction of {self.force.name!r} is StickSlip(), which is no state of the "
                "contact; read it from run.contacts.at(time)",
                "state",
                named=False,
            )

    @property
    def _push(self) -> Any:
        return next(push for push in self.force.pushes if push.states)

    @property
    def unit(self) -> str:
        """Unit of the state."""
        push = self._push
        units = law_of(push.kind).states
        angular = push.coordinate is not None and push.coordinate.unit == "rad"
        return unit_along(units.get(self.state, "1"), angular)

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading("force state", self.force, self._push.states.index(self.state))

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"{self.state} of {self.force.kind} {self.force.name}"
