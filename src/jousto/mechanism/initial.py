"""Initial: value and rate of a coordinate at the start."""

from __future__ import annotations

import numpy as np

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import OptionalNumber
from jousto.mechanism.joints.coordinate import RATE, VALUE, Angle, CoordinateField, Distance


class Initial(Declared, section="initial"):
    """Value and rate of one coordinate at time 0; dependent bodies follow.

    `compile` moves the mechanism from the declared pose until the coordinate has the value, in
    small steps and with rigid bodies, so that closed loops stay on their branch. It then solves for
    velocities that satisfy the joints, the drives and all given rates. The remaining freedom keeps
    the velocities given to the bodies, with the smallest change in the metric of kinetic energy.

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
        "The coordinate, such as ``crank.angle`` or ``slide.displacement``"
    )
    value: OptionalNumber = field(
        "Value as read by a `CoordinateSensor`: angles of joints are measured from the declared "
        "pose of the bodies, within half a turn. None keeps the declared pose",
        unit=VALUE,
        default=None,
        kw_only=True,
    )
    rate: OptionalNumber = field(
        "Rate; None if it follows from the other velocities", unit=RATE, default=None, kw_only=True
    )

    def heading(self, problems: Problems) -> str:
        """Return the prefix of messages, ``initial 'crank.angle'``."""
        return f"initial {getattr(self.coordinate, 'name', '')!r}"

    def consistent(self, problems: Problems, where: str) -> None:
        """Report missing value and rate, angles beyond half a turn and distances <= 0."""
        at = self.value
        if at is None and self.rate is None:
            problems.add(where, "contains neither a value nor a rate")
        if at is not None and isinstance(self.coordinate, Angle) and abs(at) > np.pi:
            near = np.degrees(np.arctan2(np.sin(at), np.cos(at)))
            problems.add(
                where,
                f"value is {np.degrees(at):.6g} deg, must be within half a turn of the declared "
                f"pose; give {near:.6g} deg",
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
