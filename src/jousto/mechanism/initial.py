"""Initial: the value and the rate of a coordinate at the start."""

from __future__ import annotations

import numpy as np

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import OptionalNumber
from jousto.mechanism.joints.coordinate import RATE, VALUE, Angle, CoordinateField, Distance


class Initial(Declared, section="initial"):
    """Value and rate of one coordinate at time 0; what hangs on it follows.

    `compile` moves the mechanism from the pose it is given in until the coordinate has the value,
    in small steps and as rigid bodies, so that loops stay on their branch, and finds velocities
    that fit joints, drives and all such rates. What they leave free takes the velocities given to
    the bodies, changed as little as possible in the metric of kinetic energy.

    Examples
    --------
    >>> from jousto import Revolute, RigidBody, ground
    >>> wheel = RigidBody("wheel", 3.0, (0.01, 0.01, 0.02))
    >>> axle = Revolute("axle", ground["origin"], wheel["origin"])
    >>> Initial(axle.angle, rate=5.24)
    <Initial 'axle.angle': rate 5.24 rad/s>
    """

    kind = "initial"
    coordinate: CoordinateField = field(
        "What starts there, such as ``crank.angle`` or ``slide.displacement``"
    )
    value: OptionalNumber = field(
        "Value as a `CoordinateSensor` reads it: angles of joints count from the pose that the "
        "bodies are given in, within half a turn. None keeps the given pose",
        unit=VALUE,
        default=None,
        kw_only=True,
    )
    rate: OptionalNumber = field(
        "Rate; None leaves it to what else is given", unit=RATE, default=None, kw_only=True
    )

    def heading(self, problems: Problems) -> str:
        """Return the beginning of messages, ``initial 'crank.angle'``."""
        return f"initial {getattr(self.coordinate, 'name', '')!r}"

    def consistent(self, problems: Problems, where: str) -> None:
        """Note what gives nothing, angles of more than half a turn and distances that are none."""
        at = self.value
        if at is None and self.rate is None:
            problems.add(where, "gives neither a value nor a rate")
        if at is not None and isinstance(self.coordinate, Angle) and abs(at) > np.pi:
            near = np.degrees(np.arctan2(np.sin(at), np.cos(at)))
            problems.add(
                where,
                f"value is {np.degrees(at):.6g} deg, must be within half a turn, from which angles "
                f"are counted; give {near:.6g} deg",
                "value",
            )
        if at is not None and isinstance(self.coordinate, Distance) and at <= 0.0:
            problems.add(where, f"value is {at:g} m, a distance must be positive", "value")

    @property
    def name(self) -> str:
        """Name of the coordinate."""
        return self.coordinate.name

    def __repr__(self) -> str:
        unit = self.coordinate.unit
        facts = [] if self.value is None else [f"{self.value:g} {unit}"]
        facts += [] if self.rate is None else [f"rate {self.rate:g} {unit}/s"]
        return f"<Initial {self.name!r}: {', '.join(facts)}>"
