"""Scalar sensors: coordinates, their rates, energies and signals."""

from __future__ import annotations

from typing import Any, ClassVar

from jousto.base.errors import Problems, suggest
from jousto.base.fields import Field, field
from jousto.mechanism.joints.coordinate import CoordinateField
from jousto.mechanism.sensors.base import Reading, Sensor
from jousto.mechanism.signals.base import SignalField

ENERGIES = ("kinetic", "strain", "potential", "springs", "dissipated", "friction", "work")


class CoordinateSensor(Sensor, tag="coordinate"):
    """Value of a coordinate, m or rad; angles are continuous over several turns."""

    frame: ClassVar[str] = "coordinate"
    components: ClassVar[tuple[str, ...]] = ("s",)
    coordinate: CoordinateField = field("The coordinate, such as ``hinge.angle``")

    @property
    def unit(self) -> str:
        """Unit of the coordinate."""
        return self.coordinate.unit

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading("coordinate", self.coordinate)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"coordinate {self.coordinate.name}"


class RateSensor(Sensor, tag="rate"):
    """Rate of a coordinate, m/s or rad/s."""

    frame: ClassVar[str] = "coordinate"
    components: ClassVar[tuple[str, ...]] = ("s'",)
    coordinate: CoordinateField = field("The coordinate, such as ``hinge.angle``")

    @property
    def unit(self) -> str:
        """Unit of the rate."""
        return f"{self.coordinate.unit}/s"

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading("rate", self.coordinate)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"rate of {self.coordinate.name}"


class Energy(Field[str, str]):
    """Field of the name of a term of the energy balance."""

    form = "text"
    noun = "str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the name, or report an unknown one."""
        if value not in ENERGIES:
            problems.add(where, f"{self.name} is {value!r}{suggest(str(value), ENERGIES)}")
        return value


class EnergySensor(Sensor, tag="energy"):
    """One term of the energy balance of the whole mechanism, J: one of `ENERGIES`."""

    unit: ClassVar[str] = "J"
    frame: ClassVar[str] = "world"
    components: ClassVar[tuple[str, ...]] = ("E",)
    energy: Energy = field(f"{', '.join(ENERGIES[:-1])} or {ENERGIES[-1]}")

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading("energy", self.energy)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"energy: {self.energy}"


class SignalSensor(Sensor, tag="signal"):
    """Value of a signal or of an input."""

    unit: ClassVar[str] = "1"
    frame: ClassVar[str] = "world"
    components: ClassVar[tuple[str, ...]] = ("f",)
    signal: SignalField = field("The signal", unit="1")

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading("signal", self.signal)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return "value of a signal"
