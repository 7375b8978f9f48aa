"""Initial: the value and the rate of a coordinate at the start."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from jousto.base.errors import Problems
from jousto.base.numbers import number, set_fields
from jousto.mechanism.joints.coordinate import Angle, Coordinate, Distance, check_coordinate


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Initial:
    """Value and rate of one coordinate at time 0; what hangs on it follows.

    `compile` moves the mechanism from the pose it is given in until the coordinate has the value,
    in small steps and as rigid bodies, so that loops stay on their branch, and finds velocities
    that fit joints, drives and all such rates. What they leave free takes the velocities given to
    the bodies, changed as little as possible in the metric of kinetic energy.

    Parameters
    ----------
    coordinate : Coordinate
        What starts there, such as ``crank.angle`` (rad) or ``slide.displacement`` (m).
    value : float, optional
        Value, rad or m, as a `CoordinateSensor` reads it: angles of joints count from the pose
        that the bodies are given in. Angles within half a turn. None keeps the given pose.
    rate : float, optional
        Rate, rad/s or m/s; None leaves it to what else is given.

    Raises
    ------
    InputError
        If neither is given or one is no finite number.

    Examples
    --------
    >>> from jousto import Revolute, RigidBody, ground
    >>> wheel = RigidBody("wheel", 3.0, (0.01, 0.01, 0.02))
    >>> axle = Revolute("axle", ground["origin"], wheel["origin"])
    >>> Initial(axle.angle, rate=5.24)
    <Initial 'axle.angle': rate 5.24 rad/s>
    """

    kind: ClassVar[str] = "initial"
    coordinate: Coordinate
    value: float | None
    rate: float | None

    def __init__(
        self, coordinate: Coordinate, *, value: float | None = None, rate: float | None = None
    ) -> None:
        problems = Problems()
        where = f"initial {getattr(coordinate, 'name', '')!r}"
        found = check_coordinate(problems, where, "coordinate", coordinate)
        numbers: dict[str, Any] = {"value": value, "rate": rate}
        for key, given in numbers.items():
            numbers[key] = None if given is None else number(problems, where, key, given)
        if value is None and rate is None:
            problems.add(where, "gives neither a value nor a rate")
        at = numbers["value"]
        if at is not None and isinstance(found, Angle) and abs(at) > np.pi:
            near = np.degrees(np.arctan2(np.sin(at), np.cos(at)))
            problems.add(
                where,
                f"value is {np.degrees(at):.6g} deg, must be within half a turn, from which angles "
                f"are counted; give {near:.6g} deg",
            )
        if at is not None and isinstance(found, Distance) and at <= 0.0:
            problems.add(where, f"value is {at:g} m, a distance must be positive")
        problems.raise_if_any()
        set_fields(self, coordinate=coordinate, **numbers)

    @property
    def name(self) -> str:
        """Name of the coordinate."""
        return self.coordinate.name

    def __repr__(self) -> str:
        unit = self.coordinate.unit
        facts = [] if self.value is None else [f"{self.value:g} {unit}"]
        facts += [] if self.rate is None else [f"rate {self.rate:g} {unit}/s"]
        return f"<Initial {self.name!r}: {', '.join(facts)}>"
