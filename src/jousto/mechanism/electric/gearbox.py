"""Gears with elasticity, backlash and losses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import DefaultNumber, Number
from jousto.mechanism.electric.book import Booked
from jousto.mechanism.forces.gear_spring import RATIO
from jousto.mechanism.joints.coordinate import (
    DAMPING,
    STIFFNESS,
    VALUE,
    Angle,
    CoordinateField,
)
from jousto.mechanism.states.block import Equations
from jousto.mechanism.states.expression import (
    Expression,
    absolute,
    expression,
    maximum,
    minimum,
    rate,
    value,
    where,
)
from jousto.mechanism.states.hysteresis import TOUCH


class Gearbox(Booked, tag="gearbox"):
    """Gearbox between the angle phi of a rotor and a coordinate q, with backlash and losses.

    The wind-up is ``e = phi/ratio - q``, 0 in the declared pose. Teeth touch beyond half of the
    backlash j and carry ``T = stiffness (e -+ j/2) + damping e'`` to q; they part where T becomes
    0 and never pull. The rotor supplies ``(T + F)/ratio``. The friction F of the teeth is ``(1/
    efficiency - 1) abs(T)`` against the rotor while it drives, ``(1 - back_efficiency) abs(T)``
    while the load drives it; at rest it sticks, with the stiffness of the gear, up to these
    limits. Steps end where teeth touch or part, stick or slip.

    Outputs are ``torque`` on q, ``motor_torque`` on the rotor, ``windup``, and ``supplied_power =
    mechanical_power + heat_power + stored_power``.

    Examples
    --------
    >>> from jousto import Revolute, RigidBody, ground
    >>> from jousto.electric import Gearbox
    >>> rotor = RigidBody("rotor", 0.1, (1e-4, 1e-4, 1e-4))
    >>> drum = RigidBody("drum", 10.0, (0.1, 0.1, 0.2))
    >>> motor = Revolute("motor", ground["origin"], rotor["origin"])
    >>> axle = Revolute("axle", ground["origin"], drum["origin"])
    >>> gear = Gearbox("gear", motor.angle, axle.angle, 20.0, 1e5, 50.0, backlash=1e-3)
    >>> print(gear["torque"])
    gear.torque
    """

    kind = "gearbox"
    jumps = True
    motor: CoordinateField = field("Angle phi of the rotor")
    coordinate: CoordinateField = field("Coordinate q that the gear drives, an angle or a length")
    ratio: Number = field(
        "Turns of the rotor per turn of q, or radians per metre; negative if it turns the other "
        "way",
        unit=RATIO,
        nonzero=True,
    )
    stiffness: Number = field("Stiffness on the side of q", unit=STIFFNESS, above=0)
    damping: Number = field("Damping on the side of q", unit=DAMPING, least=0, default=0.0)
    backlash: Number = field(
        "Backlash j, the whole play, on the side of q", unit=VALUE, least=0, default=0.0,
        kw_only=True,
    )  # fmt: skip
    efficiency: Number = field(
        "Efficiency while the rotor drives", above=0, most=1, default=1.0, kw_only=True
    )
    back_efficiency: DefaultNumber = field(
        "Efficiency while the load drives, 0 or less for a self-locking gear; None for that of "
        "the other direction",
        most=1,
        default=None,
        kw_only=True,
    )
    windup: Number = field("Wind-up e in the declared pose", unit=VALUE, default=0.0, kw_only=True)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a rotor that does not turn, a gear on one coordinate, losses without range."""
        back: float | None = self.back_efficiency
        object.__setattr__(self, "back_efficiency", self.efficiency if back is None else back)
        if not isinstance(self.motor, Angle):
            problems.add(where, f"motor is {self.motor.name}, a length; must be an angle", "motor")
        if self.motor.same_as(self.coordinate):
            problems.add(where, f"couples {self.motor.name} with itself", "motor")

    @property
    def lossy(self) -> bool:
        """Whether the teeth lose power."""
        return self.efficiency != 1.0 or self.back_efficiency != 1.0

    @property
    def memories(self) -> Mapping[str, float]:
        """Teeth that touch: 1 ahead, -1 behind, 0 none; place and direction of their friction."""
        teeth = {"side": 0.0} if self.backlash else {}
        return teeth | ({"slip": 0.0, "place": 0.0, "begun": 0.0} if self.lossy else {})

    others = ("torque", "motor_torque", "windup")

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return torques, powers, and the side that touches."""
        made, k, N = Equations(), self.stiffness, self.ratio
        turn, speed = rate(self.motor) / N, rate(self.coordinate)
        angle = (value(self.motor) - self.motor.initial) / N
        e = angle - (value(self.coordinate) - self.coordinate.initial) + self.windup
        strain, T = e, k * e + self.damping * (turn - speed)
        touching: Any = expression(1.0)
        if self.backlash:
            side, half = x["side"], 0.5 * self.backlash
            strain = e - side * half
            rubbing = self.damping / k * (turn - speed)
            ahead = minimum(e - half, e - half + rubbing)  # positive: the teeth ahead touch
            behind = minimum(0.0 - e - half, 0.0 - e - half - rubbing)
            touching = side * side
            T = touching * (k * strain + k * rubbing)
            made.updates["side"] = where(ahead, 1.0, where(behind, -1.0, 0.0))
            pressed = side * (strain + rubbing)
            made.margin = where(touching, pressed, 0.0 - maximum(ahead, behind))
        taken: Any = T + self._friction(made, x, T, angle, turn) if self.lossy else T
        made.outputs.update(torque=T, motor_torque=0.0 - taken / N, windup=e)
        made.forces = [(self.coordinate, T), (self.motor, 0.0 - taken / N)]
        supplied, given = taken * turn, T * speed
        stored = touching * k * strain * (turn - speed)
        self.add_powers(made, supplied, given, supplied - given - stored, stored)
        return made

    def _friction(self, made: Equations, x: Any, T: Any, angle: Any, turn: Any) -> Any:
        """Return the friction of the teeth, and add what is kept of it."""
        k, slip, size = self.stiffness, x["slip"], absolute(T)
        driving, driven = 1.0 / self.efficiency - 1.0, 1.0 - self.back_efficiency
        # limits of the friction for slip forwards and backwards
        up, down = size * where(T, driving, driven), size * where(T, driven, driving)
        slips, held = slip * slip, k * (angle - x["place"])
        F = where(slips, where(slip, up, 0.0 - down), held)
        above = held - (1.0 + TOUCH) * up
        below = 0.0 - held - (1.0 + TOUCH) * down
        after = where(
            slips,
            where(slip * turn, slip, 0.0),
            where(above, 1.0, where(below, -1.0, 0.0)),
        )
        forward = where(turn, 1.0, where(0.0 - turn, -1.0, 0.0))
        place = where(slips, angle - F / k, x["place"])
        made.updates["slip"] = where(x["begun"], after, forward)
        made.updates["place"] = where(x["begun"], place, angle)
        made.updates["begun"] = 1.0
        margin = where(slips, slip * turn, 0.0 - maximum(above, below))
        made.margin = margin if made.margin is None else minimum(margin, made.margin)
        return F
