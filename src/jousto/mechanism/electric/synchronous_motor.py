"""Three-phase synchronous motors in the frame of the rotor, with current control."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jousto.base.errors import Problems
from jousto.base.fields import Choice, Flag, field
from jousto.base.numbers import Number, OptionalPositive, Whole
from jousto.mechanism.electric.dc_motor import Motor
from jousto.mechanism.states.block import Equations
from jousto.mechanism.states.expression import (
    Expression,
    absolute,
    clip,
    expression,
    maximum,
    minimum,
    sqrt,
    where,
)
from jousto.mechanism.states.inputs import OptionalInput

TRACKING = 0.9
"""Time of the back-calculation of the current controllers over their integral time L/R."""
TINY = 1e-12
"""Smallest square under a root over that of its scale: the slope of the root is finite."""
STRATEGIES = ("zero", "least-current")


class SynchronousMotor(Motor, tag="synchronous-motor"):
    """Three-phase synchronous motor in the frame of its rotor, d along the magnet.

    ``Ld id' = vd - R id + we Lq iq``, ``Lq iq' = vq - R iq - we (Ld id + flux)``, torque ``1.5 pp
    (flux iq + (Ld - Lq) id iq)``, ``we = pp w``; currents and voltages are amplitudes of a phase.

    It has voltages as inputs, or controllers of the currents: ``v = b L (i* - i) + I``, ``I' = b R
    (i* - i)`` with back-calculation, and the cross terms fed forward. Within the limit of the
    voltage, ``|v| <= dc_voltage/sqrt(3)`` with d first, a current follows by a lag of 1/b exactly.

    Outputs are ``torque`` and ``speed`` of the rotor, ``amplitude`` of the current, ``vd``, ``vq``,
    and ``supplied_power = mechanical_power + heat_power + stored_power``; with controllers
    ``wanted_d`` and ``wanted_q``, too.

    Examples
    --------
    >>> from jousto import Revolute, RigidBody, ground
    >>> from jousto.electric import SynchronousMotor
    >>> rotor = RigidBody("rotor", 1.0, (2e-3, 2e-3, 2e-3))
    >>> axle = Revolute("axle", ground["origin"], rotor["origin"])
    >>> motor = SynchronousMotor(
    ...     "motor", axle.angle, 0.5, 2e-3, 3e-3, 0.08, 4, current=5.0, bandwidth=1250.0
    ... )
    >>> print(motor["torque"])
    motor.torque
    """

    kind = "synchronous motor"
    resistance: Number = field("Resistance R of a phase", unit="ohm", above=0)
    inductance_d: Number = field("Inductance Ld along the magnet", unit="H", above=0)
    inductance_q: Number = field("Inductance Lq across it", unit="H", above=0)
    flux: Number = field("Flux of the magnet, an amplitude", unit="V s", least=0)
    pole_pairs: Whole = field("Number of pairs of poles, pp", least=1)
    voltage_d: OptionalInput = field("Voltage vd", unit="V", default=None, kw_only=True)
    voltage_q: OptionalInput = field("Voltage vq", unit="V", default=None, kw_only=True)
    current: OptionalInput = field(
        "Wanted current iq of the controllers, instead of voltages", unit="A", default=None,
        kw_only=True,
    )  # fmt: skip
    current_d: OptionalInput = field(
        "Wanted current id of the controllers; None for that of the strategy", unit="A",
        default=None, kw_only=True,
    )  # fmt: skip
    bandwidth: OptionalPositive = field(
        "Bandwidth b of the controllers of the currents", unit="rad/s", default=None, kw_only=True
    )
    dc_voltage: OptionalPositive = field(
        "Voltage of the intermediate circuit; None for voltages without limit", unit="V",
        default=None, kw_only=True,
    )  # fmt: skip
    largest_current: OptionalPositive = field(
        "Largest wanted amplitude of the current; None for any", unit="A", default=None,
        kw_only=True,
    )  # fmt: skip
    strategy: Choice = field(
        "Wanted current id below the base speed: zero, or that of the least amplitude",
        words=STRATEGIES,
        default="zero",
        kw_only=True,
    )
    weakening: Flag = field(
        "Whether id weakens the field above the base speed", default=False, kw_only=True
    )
    reserve: Number = field(
        "Part of the voltage that weakening leaves to the controllers and the resistance",
        least=0, most=0.9, default=0.1, kw_only=True,
    )  # fmt: skip
    ideal: Flag = field(
        "Whether currents follow by lags 1/b, whatever voltage they need", default=False,
        kw_only=True,
    )  # fmt: skip
    initial_d: Number = field("Current id at the start", unit="A", default=0.0, kw_only=True)
    initial_q: Number = field("Current iq at the start", unit="A", default=0.0, kw_only=True)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report inputs that are missing or exclude one another."""
        voltages = [one is not None for one in (self.voltage_d, self.voltage_q)]
        if self.current is None and not all(voltages):
            text = "give voltage_d and voltage_q, or current and bandwidth for a current control"
            problems.add(where, text, "current")
        if self.current is not None:
            if any(voltages):
                problems.add(where, "has a current and voltages; give either", "current")
            if self.bandwidth is None:
                problems.add(where, "bandwidth of the current control is missing, rad/s; give "
                             "about a tenth of its sampling rate", "bandwidth")  # fmt: skip
            if self.flux == 0.0 and self.current_d is None:
                text = "flux is 0: the motor has no torque without current_d; give it"
                problems.add(where, text, "current_d")
        else:
            given = ("current_d", "bandwidth", "dc_voltage", "largest_current", "ideal")
            for key in (*given, "weakening"):
                if getattr(self, key) not in (None, False):
                    text = f"{key} is given, which only a current control has; give current"
                    problems.add(where, text, key)
        if self.weakening:
            if self.dc_voltage is None or self.largest_current is None:
                text = "weakening needs dc_voltage and largest_current; give both"
                problems.add(where, text, "weakening")
            if self.current_d is not None:
                text = "weakening chooses id itself; leave current_d out"
                problems.add(where, text, "weakening")
        if self.ideal and self.dc_voltage is not None and not self.weakening:
            text = "ideal currents follow at any voltage; leave out ideal or dc_voltage"
            problems.add(where, text, "ideal")

    @property
    def own(self) -> dict[str, float]:
        """Initial currents, and integral parts of the controllers."""
        integrals = {"integral_d": 0.0, "integral_q": 0.0}
        controlled = self.current is not None and not self.ideal
        return {"id": self.initial_d, "iq": self.initial_q} | (integrals if controlled else {})

    @property
    def nominals(self) -> Mapping[str, float]:
        """Sizes of the currents, and of the integral parts."""
        sizes = dict.fromkeys(("id", "iq"), self.size)
        volts = self.size * self.resistance
        return sizes | dict.fromkeys(tuple(self.own)[2:], volts)

    @property
    def fastest(self) -> Mapping[str, float]:
        """Largest rate of the currents, 1/s."""
        b = 0.0 if self.bandwidth is None else float(np.real(self.bandwidth))
        L = min(np.real(self.inductance_d), np.real(self.inductance_q))
        return {f"{self.name}.iq": max(b, float(np.real(self.resistance) / L))}

    @property
    def others(self) -> tuple[str, ...]:
        """Names of the outputs beside the powers."""
        wanted = () if self.current is None else ("wanted_d", "wanted_q")
        return ("torque", "speed", "amplitude", "vd", "vq", *wanted)

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the rates of the currents, torque, voltages and powers."""
        made, R, psi = Equations(), self.resistance, self.flux
        i: tuple[Any, Any] = x["id"], x["iq"]
        L = self.inductance_d, self.inductance_q
        w = self.speed
        we = self.pole_pairs * w
        cross = (0.0 - we * L[1] * i[1], we * (L[0] * i[0] + psi))
        v: Any = self.voltage_d, self.voltage_q
        if self.current is not None:
            wanted = self._wanted(self.current, absolute(we))
            made.outputs.update(wanted_d=wanted[0], wanted_q=wanted[1])
            v = self._controlled(made, x, wanted, cross)
        for name, vk, ik, Lk, ck in zip(("id", "iq"), v, i, L, cross, strict=True):
            made.rates[name] = (vk - R * ik - ck) / Lk
        square = i[0] * i[0] + i[1] * i[1]
        torque = 1.5 * self.pole_pairs * (psi * i[1] + (L[0] - L[1]) * i[0] * i[1])
        made.outputs.update(
            torque=torque,
            speed=w,
            amplitude=sqrt(square + TINY * self.size**2),
            vd=v[0],
            vq=v[1],
        )
        stored = 1.5 * sum(
            Lk * ik * made.rates[name] for name, ik, Lk in zip(("id", "iq"), i, L, strict=True)
        )
        supplied = 1.5 * (v[0] * i[0] + v[1] * i[1])
        self.add_powers(made, supplied, torque * w, 1.5 * R * square, stored)
        made.forces = self.push(torque)
        return made

    def _controlled(self, made: Any, x: Any, wanted: Any, cross: Any) -> tuple[Any, Any]:
        """Return the voltages of the current controllers, and add their integral parts."""
        b, R = self.bandwidth, self.resistance
        L = self.inductance_d, self.inductance_q
        errors = [wanted[0] - x["id"], wanted[1] - x["iq"]]
        assert b is not None
        if self.ideal:
            pairs = zip(errors, L, ("id", "iq"), cross, strict=True)
            d, q = (b * Lk * e + R * x[name] + ck for e, Lk, name, ck in pairs)
            return d, q
        asked = [
            b * Lk * e + x[f"integral_{name}"] + ck
            for e, Lk, name, ck in zip(errors, L, "dq", cross, strict=True)
        ]
        given = list(asked)
        if self.dc_voltage is not None:
            most = self.dc_voltage / np.sqrt(3.0)
            given[0] = clip(asked[0], -most, most)
            left = sqrt(maximum(most**2 - given[0] * given[0], TINY * most**2))
            given[1] = clip(asked[1], 0.0 - left, left)
        for e, Lk, name, v, u in zip(errors, L, "dq", asked, given, strict=True):
            back = (u - v) / (TRACKING * Lk / R) if self.dc_voltage is not None else 0.0
            made.rates[f"integral_{name}"] = b * R * e + back
        return given[0], given[1]

    # -- wanted currents -----------------------------------------------------------------------

    def _wanted(self, iq: Any, we: Any) -> tuple[Any, Any]:
        """Return the wanted currents of a wanted iq at the electrical speed we >= 0."""
        Ld, Lq, psi, most = self.inductance_d, self.inductance_q, self.flux, self.largest_current
        if not self.weakening:
            if self.current_d is not None:
                d: Any = self.current_d
                if most is not None:
                    d = clip(d, -most, most)
                    left = sqrt(maximum(most**2 - d * d, TINY * most**2))
                    iq = clip(iq, 0.0 - left, left)
                return d, iq
            if most is not None:
                left = sqrt(most**2 - self._least(most) ** 2)
                iq = clip(iq, -left, left)
            return self._least_of(iq), iq
        assert most is not None and self.dc_voltage is not None
        # largest flux linkage at this speed, that of no speed where the voltage has no effect
        V = (1.0 - self.reserve) * self.dc_voltage / np.sqrt(3.0)
        free = psi**2 + Lq**2 * most**2
        linkage = minimum(V**2 / maximum(we * we, V**2 / free), free)  # square
        # id where the circle of the current meets the ellipse of the voltage
        a, b = Ld**2 - Lq**2, 2.0 * psi * Ld
        c = free - linkage
        crossing = -2.0 * c / (b + sqrt(maximum(b * b - 4.0 * a * c, TINY * free**2 / most**2)))
        deepest = minimum(crossing, self._least(most))
        room = maximum(most**2 - deepest * deepest, TINY * most**2)
        iq = clip(iq, 0.0 - sqrt(room), sqrt(room))
        across = Lq * iq
        inside = (sqrt(maximum(linkage - across * across, TINY * free)) - psi) / Ld
        d = maximum(minimum(inside, self._least_of(iq)), -most)
        return d, where(room - 2.0 * TINY * most**2, iq, 0.0)

    def _least(self, most: float) -> Any:
        """Return id of the least amplitude for the torque at the amplitude `most`."""
        more, psi = self.inductance_q - self.inductance_d, self.flux
        if self.strategy == "zero" or more == 0.0:
            return 0.0
        return (psi - np.sqrt(psi**2 + 8.0 * more**2 * most**2)) / (4.0 * more)

    def _least_of(self, iq: Any) -> Any:
        """Return id of the least amplitude for the torque at a current iq."""
        more, psi = self.inductance_q - self.inductance_d, self.flux
        if self.strategy == "zero" or more == 0.0:
            return expression(0.0)
        half = psi / (2.0 * more)
        sign = 1.0 if np.real(more) > 0.0 else -1.0
        scale = half * half + TINY * self.size**2
        return half - sign * sqrt(scale + iq * iq)
