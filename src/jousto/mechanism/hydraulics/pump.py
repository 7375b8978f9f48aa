"""Pumps and hydraulic motors: a displacement on a shaft, with losses and controllers."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Field, OptionalItem, field
from jousto.base.numbers import Number, OptionalNumber, Values
from jousto.base.object_repr import described
from jousto.mechanism.hydraulics.circuit import constant, limited
from jousto.mechanism.hydraulics.element import HydraulicElement, Port
from jousto.mechanism.joints.coordinate import Coordinate, check_coordinate
from jousto.mechanism.states.expression import (
    absolute,
    maximum,
    minimum,
    rate,
    smooth_step,
    sqrt,
    where,
)
from jousto.mechanism.states.inputs import InputField, OptionalInput
from jousto.mechanism.states.tables import check_knots, surface

if TYPE_CHECKING:
    from jousto.mechanism.hydraulics.circuit import Circuit

TURNING = 0.1
"""Speed, rad/s, within which friction of a shaft changes its sign."""
LEAST_POWER = 1.0
"""Smallest power, W, by which a power limit divides."""


class OptionalCoordinate(Field[Coordinate | None, Coordinate | None]):
    """Field of a coordinate, or None."""

    form = "coordinate"
    noun = "Coordinate"
    optional = True

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the coordinate, or report a value of another type."""
        return check_coordinate(problems, where, self.name, value)


@described
class EfficiencyMap(Declared, by_value=True, kw_only=True):
    """Measured efficiencies of a pump or motor over speed and pressure difference.

    Between the knots the losses ``(1 - volumetric) D w`` and ``(1/mechanical - 1) D p`` are
    interpolated, with those at full displacement for all shares. Below the first pressure the loss
    of flow falls to 0; else the value at the nearest knot holds outside.
    """

    kind = "efficiency map"
    speeds: Values = field("Speeds (n,) of the shaft, increasing", unit="rad/s", shape=(None,))
    pressures: Values = field("Pressure differences (m,), increasing", unit="Pa", shape=(None,))
    volumetric: Values = field("Volumetric efficiency (n x m)", shape=(None, None))
    mechanical: Values = field("Mechanical efficiency (n x m)", shape=(None, None))

    def consistent(self, problems: Problems, where: str) -> None:
        """Report knots that do not increase or are not positive, and efficiencies beyond 0 to 1."""
        for key, axis in (("speeds", 0), ("pressures", 1)):
            at = getattr(self, key)
            if len(at) and not at[0] > 0.0:
                problems.add(where, f"{key} begins at {at[0]:g}, must be positive", key)
            for values in (self.volumetric, self.mechanical):
                check_knots(problems, where, key, at, values.shape[axis])
        for key in ("volumetric", "mechanical"):
            worst = [x for x in getattr(self, key).ravel() if not 0.0 < x <= 1.0]
            if worst:
                text = f"{key} has {worst[0]:g}, must be above 0 and at most 1"
                problems.add(where, text, key)

    def losses(self, displacement: Any, w: Any, dp: Any) -> tuple[Any, Any]:
        """Return the loss of flow, m3/s, from b to a, and of torque, N m, against the speed."""
        speeds = self.speeds
        pressures = np.concatenate([[0.0], self.pressures])
        flow = (1.0 - self.volumetric) * speeds[:, None]
        flow = np.hstack([np.zeros((len(speeds), 1)), flow])
        drag = (1.0 / self.mechanical - 1.0) * self.pressures
        drag = np.hstack([drag[:, :1], drag])
        speed, p = absolute(w), absolute(dp)
        lost = displacement * surface(speed, p, speeds, pressures, flow)
        torque = displacement * surface(speed, p, speeds, pressures, drag)
        return where(dp, lost, 0.0 - lost), torque * w / sqrt(w * w + TURNING**2)


class DisplacementElement(HydraulicElement):
    """Base of pumps and motors: flow ``e D w`` less leaks from a to b, torque ``e D dp``.

    Leaks are ``(leak + slip D/mu) dp``, and friction of the shaft is
    ``drag mu D abs(w) + friction D abs(dp)`` against its speed (Wilson, Trans. ASME 71, 1949), or
    both follow from a map of efficiencies.
    """

    a: Port = field("Port from which oil is taken when the shaft turns forwards")
    b: Port = field("Port to which it goes")
    displacement: Number = field(
        "Displacement D per angle, such as 28 cm3/rev in files", unit="m3/rad", above=0
    )
    speed: OptionalInput = field("Given speed of the shaft", unit="rad/s", default=None,
                                 kw_only=True)  # fmt: skip
    shaft: OptionalCoordinate = field(
        "Angle of a joint that is the shaft, instead of a given speed", default=None, kw_only=True
    )
    leak: InputField = field("Leak between the ports", unit="m3/s/Pa", default=0.0, kw_only=True)
    slip: InputField = field("Wilson's slip coefficient c_s", default=0.0, kw_only=True)
    drag: Number = field("Wilson's viscous drag c_v", least=0, default=0.0, kw_only=True)
    friction: Number = field("Wilson's friction c_f", least=0, default=0.0, kw_only=True)
    map: OptionalItem[EfficiencyMap] = field(
        "Efficiencies over speed and pressure, instead of leak and Wilson's coefficients",
        default=None, kw_only=True,
    )  # fmt: skip
    suction: OptionalNumber = field(
        "Net positive suction head as a pressure: excess over that of the vapour at the port that "
        "takes oil, below which the flow is cut; None for none", unit="Pa", above=0, default=None,
        kw_only=True,
    )  # fmt: skip

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a shaft that is missing or given twice, or that is no angle."""
        if (self.speed is None) == (self.shaft is None):
            problems.add(where, "give either speed or shaft, the angle of a joint")
        if self.shaft is not None and self.shaft.unit != "rad":
            problems.add(where, f"shaft is {self.shaft.name!r}, must be an angle")
        losses = self.drag, self.friction, *map(constant, (self.leak, self.slip))
        if self.map is not None and any(x != 0.0 for x in losses):
            problems.add(where, "has a map and leak, slip, drag or friction; take one of both")

    def turn(self, circuit: Circuit, share: Any) -> None:
        """Add flow, torque and powers at a share of the full displacement."""
        D, mu = self.displacement, circuit.oil.viscosity
        w = rate(self.shaft) if self.shaft is not None else self.speed
        dp = circuit.pressure(self.b) - circuit.pressure(self.a)
        filled = self._filled(circuit, share * w)
        if self.map is None:
            leaks, loss = (self.leak + D / mu * self.slip) * dp, 0.0 * w
            if self.drag or self.friction:
                sign = w / sqrt(w * w + TURNING**2)
                loss = self.drag * mu * D * w + self.friction * D * absolute(dp) * sign
        else:
            leaks, loss = self.map.losses(D, w, dp)
        q = filled * share * D * w - leaks
        taken = circuit.add_passage(self.a, self.b, q)
        torque = filled * share * D * dp + loss  # that the shaft gives
        power = torque * w
        circuit.add_heat(self.name, taken + power)
        circuit.add_output(f"{self.name}_flow", q)
        circuit.add_output(f"{self.name}_torque", torque)
        if self.shaft is not None:
            circuit.forces.append((self.shaft, 0.0 - torque))
            circuit.mechanical(0.0 - power)
        else:
            circuit.supplied(power)

    def _filled(self, circuit: Circuit, turning: Any) -> Any:
        """Return the share of the displacement that the oil at the port behind the shaft fills."""
        if self.suction is None:
            return 1.0
        p = where(turning, circuit.pressure(self.a), circuit.pressure(self.b))
        filled = circuit.opened(
            f"suction of {self.kind} {self.name!r} (suction)",
            (p - circuit.oil.floor) / self.suction,
        )
        circuit.add_output(f"{self.name}_filled", filled)
        return filled


class Pump(DisplacementElement, tag="pump"):
    """Pump of fixed or variable displacement, with pressure compensator and power limit.

    The share e of the displacement follows ``lag e' = e_c - e``. A compensator takes
    ``e_c = 1 - S((p - cutoff)/full)`` with the smooth step S; p is the pressure at b, or, for
    load sensing, its excess over that of another port.
    """

    kind = "pump"
    share: InputField = field("Share of the displacement, 0 to 1", default=1.0, kw_only=True)
    lag: OptionalNumber = field(
        "Time constant of the share; None for none", unit="s", above=0, default=None, kw_only=True
    )
    cutoff: OptionalInput = field(
        "Pressure, or with sense the margin, at which a compensator begins to reduce the share",
        unit="Pa",
        default=None,
        kw_only=True,
    )
    full: Number = field(
        "Further pressure at which the share is 0", unit="Pa", above=0, default=1e6, kw_only=True
    )
    sense: OptionalInput = field(
        "Pressure of the load for load sensing, such as 'oil.lift'", unit="Pa", default=None,
        kw_only=True,
    )  # fmt: skip
    power: OptionalNumber = field("Largest power", unit="W", above=0, default=None, kw_only=True)
    first_share: OptionalNumber = field(
        "Share at the start with a lag; None for that of share", least=0, most=1, default=None,
        kw_only=True,
    )  # fmt: skip

    def consistent(self, problems: Problems, where: str) -> None:
        """Report options that need another one."""
        super().consistent(problems, where)
        if self.sense is not None and self.cutoff is None:
            problems.add(where, "sense needs the margin of the compensator; give cutoff")

    def connect(self, circuit: Circuit) -> None:
        """Add the controller of the share, flow and torque."""
        e = limited(self.share, 0.0, 1.0)
        p = circuit.pressure(self.b)
        if self.cutoff is not None:
            over = p - self.cutoff if self.sense is None else p - self.sense - self.cutoff
            if self.lag is None:
                closed = circuit.opened(f"cut-off of pump {self.name!r} (full)", over / self.full)
            else:
                closed = smooth_step(over / self.full)
            e = minimum(e, 1.0 - closed)
        if self.power is not None:
            w = rate(self.shaft) if self.shaft is not None else self.speed
            asked = maximum(self.displacement * absolute(w) * p, LEAST_POWER)
            e = minimum(e, self.power / asked)
        if self.lag is not None:
            key = f"{self.name}_share"
            first = self.first_share
            if first is None:
                given = self.share
                first = given.of if given.operation == "number" else 0.0
            kept = circuit.add_state(key, first, 1.0)
            circuit.set_rate(key, (e - kept) / self.lag)
            e = kept
        circuit.add_output(f"{self.name}_setting", e)
        self.turn(circuit, e)


class HydraulicMotor(DisplacementElement, tag="hydraulic-motor"):
    """Motor: oil from a to b turns the shaft forwards."""

    kind = "hydraulic motor"
    share: InputField = field("Share of the displacement, -1 to 1", default=1.0, kw_only=True)

    def connect(self, circuit: Circuit) -> None:
        """Add flow and torque."""
        self.turn(circuit, limited(self.share, -1.0, 1.0))


def per_revolution(volume: float) -> float:
    """Return a displacement per angle, m3/rad, from one per revolution, m3.

    Examples
    --------
    >>> round(per_revolution(28e-6) * 1e6, 6)
    4.456338
    """
    return volume / (2.0 * math.pi)
