"""Sensors of one number: coordinates, their rates, energies and signals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from jousto.base.described import described
from jousto.base.errors import Problems, suggest
from jousto.base.names import check_name
from jousto.base.numbers import set_fields
from jousto.mechanism.joints.coordinate import Coordinate, check_coordinate
from jousto.mechanism.signals.base import Signal, check_signal

ENERGIES = ("kinetic", "strain", "potential", "springs", "dissipated", "friction", "work")


@described
@dataclass(frozen=True, eq=False, init=False)
class CoordinateSensor:
    """Value of a coordinate, m or rad; angles run on without jumps."""

    frame: ClassVar[str] = "coordinate"
    components: ClassVar[tuple[str, ...]] = ("s",)
    name: str
    coordinate: Coordinate

    def __init__(self, name: str, coordinate: Coordinate) -> None:
        init_coordinate_sensor(self, name, coordinate)

    @property
    def unit(self) -> str:
        """Unit of the coordinate."""
        return self.coordinate.unit

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"coordinate {self.coordinate.name}"


@described
@dataclass(frozen=True, eq=False, init=False)
class RateSensor:
    """Rate of a coordinate, m/s or rad/s."""

    frame: ClassVar[str] = "coordinate"
    components: ClassVar[tuple[str, ...]] = ("s'",)
    name: str
    coordinate: Coordinate

    def __init__(self, name: str, coordinate: Coordinate) -> None:
        init_coordinate_sensor(self, name, coordinate)

    @property
    def unit(self) -> str:
        """Unit of the rate."""
        return f"{self.coordinate.unit}/s"

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"rate of {self.coordinate.name}"


@dataclass(frozen=True, eq=False, init=False)
class EnergySensor:
    """One term of the energy balance of the whole mechanism, J: one of `ENERGIES`."""

    unit: ClassVar[str] = "J"
    frame: ClassVar[str] = "world"
    components: ClassVar[tuple[str, ...]] = ("E",)
    name: str
    energy: str

    def __init__(self, name: str, energy: str) -> None:
        problems = Problems()
        where = check_name(problems, "sensor", name)
        if energy not in ENERGIES:
            problems.add(where, f"energy is {energy!r}{suggest(energy, ENERGIES)}")
        problems.raise_if_any()
        set_fields(self, name=name, energy=energy)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"energy: {self.energy}"


@described
@dataclass(frozen=True, eq=False, init=False)
class SignalSensor:
    """Value of a signal, also of an input."""

    unit: ClassVar[str] = "1"
    frame: ClassVar[str] = "world"
    components: ClassVar[tuple[str, ...]] = ("f",)
    name: str
    signal: Signal

    def __init__(self, name: str, signal: Signal | float) -> None:
        problems = Problems()
        where = check_name(problems, "sensor", name)
        value = check_signal(problems, where, "signal", signal)
        problems.raise_if_any()
        set_fields(self, name=name, signal=value)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return "value of a signal"


def init_coordinate_sensor(sensor: Any, name: str, coordinate: Coordinate) -> None:
    """Check and set the fields of a sensor on a coordinate."""
    problems = Problems()
    where = check_name(problems, "sensor", name)
    check_coordinate(problems, where, "coordinate", coordinate)
    problems.raise_if_any()
    set_fields(sensor, name=name, coordinate=coordinate)
