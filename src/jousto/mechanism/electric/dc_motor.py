"""Motors with direct current."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jousto.base.fields import field
from jousto.base.numbers import Number, Positive
from jousto.mechanism.electric.book import Booked
from jousto.mechanism.forces.gear_spring import RATIO
from jousto.mechanism.joints.coordinate import CoordinateField
from jousto.mechanism.states.block import Equations
from jousto.mechanism.states.expression import Expression, expression, rate
from jousto.mechanism.states.inputs import InputField


class Motor(Booked):
    """Base of motors: the coordinate q that they drive, through a rigid gear if wanted.

    The rotor turns at ``w = ratio q'``; its inertia is that of a body in the mechanism.
    """

    shaft: CoordinateField = field(
        "Coordinate q that the motor drives: the angle of its rotor, or of a joint"
    )
    ratio: Number = field(
        "Turns of the rotor per turn of q, or radians per metre; negative if it turns the other "
        "way",
        unit=RATIO,
        nonzero=True,
        default=1.0,
        kw_only=True,
    )
    size: Positive = field(
        "Size of the currents for the error control of DormandPrince", unit="A", default=1.0,
        kw_only=True,
    )  # fmt: skip

    @property
    def nominals(self) -> Mapping[str, float]:
        """Sizes of the currents."""
        return dict.fromkeys(self.own, self.size)

    @property
    def speed(self) -> Any:
        """Speed w of the rotor, rad/s."""
        return self.ratio * rate(self.shaft)

    def push(self, torque: Any) -> list[Any]:
        """Return the force along q of a torque of the rotor."""
        return [(self.shaft, self.ratio * torque)]


class DCMotor(Motor, tag="dc-motor"):
    """Motor with direct current: ``L i' = u - R i - k w``, torque ``k i``.

    Outputs are ``current``, ``torque`` and ``speed`` of the rotor, and ``supplied_power =
    mechanical_power + heat_power + stored_power``. Without inductance the current has no state.

    Examples
    --------
    >>> from jousto import Revolute, RigidBody, ground
    >>> from jousto.electric import DCMotor
    >>> wheel = RigidBody("wheel", 1.0, (1e-4, 1e-4, 1e-4))
    >>> axle = Revolute("axle", ground["origin"], wheel["origin"])
    >>> motor = DCMotor("motor", axle.angle, 12.0, 1.0, 0.5e-3, 0.05)
    >>> print(motor["torque"])
    motor.torque
    """

    kind = "DC motor"
    voltage: InputField = field("Voltage u", unit="V")
    resistance: Number = field("Resistance R", unit="ohm", above=0)
    inductance: Number = field("Inductance L; 0 for none", unit="H", least=0)
    constant: Number = field(
        "Torque per current, which is also voltage per speed, k", unit="N m/A", nonzero=True
    )
    initial: Number = field("Current at the start", unit="A", default=0.0, kw_only=True)

    @property
    def own(self) -> dict[str, float]:
        """Initial current, if there is an inductance."""
        return {"current": self.initial} if self.inductance else {}

    @property
    def others(self) -> tuple[str, ...]:
        """Names of the outputs beside the powers."""
        return ("torque", "speed") if self.inductance else ("current", "torque", "speed")

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return rate or value of the current, torque and powers."""
        made, w, u, k = Equations(), self.speed, self.voltage, self.constant
        free = u - k * w
        stored: Any = expression(0.0)
        if self.inductance:
            i: Any = x["current"]
            made.rates["current"] = (free - self.resistance * i) / self.inductance
            stored = (free - self.resistance * i) * i
        else:
            i = made.outputs["current"] = free / self.resistance
        torque = k * i
        made.outputs.update(torque=torque, speed=w)
        self.add_powers(made, u * i, torque * w, self.resistance * i * i, stored)
        made.forces = self.push(torque)
        return made
