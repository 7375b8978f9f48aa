"""Wheatstone bridges of virtual strain gauges."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array, read_only
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.fields import Field, field
from jousto.base.names import check_name
from jousto.base.numbers import Number
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.sensors.base import Reading, Sensor
from jousto.mechanism.sensors.gauge import Gauge
from jousto.mechanism.signals.base import Signal

if TYPE_CHECKING:
    from jousto.reduction.reduced import ReducedPart

SIGNS = np.array([1.0, -1.0, 1.0, -1.0])
KINDS = {1: "quarter", 2: "half", 3: "three-quarter", 4: "full"}


@explained
def bridge_output(r: ArrayLike) -> Array:
    """Return the output of a Wheatstone bridge / supply voltage, V/V.

    ``V/U = (1 + r1)/(2 + r1 + r2) - (1 + r4)/(2 + r3 + r4)``, approximately ``(r1 - r2 + r3 - r4) /
    4``: arms 1 and 2 in series are parallel to arms 4 and 3 in series.

    Parameters
    ----------
    r : (..., 4) array_like
        Relative changes of resistance of arms 1 to 4; a gauge has ``k e``.

    Examples
    --------
    A quarter bridge of 2000 um/m and k = 2 shows 0.998 mV/V, not 1:

    >>> bridge_output([0.004, 0, 0, 0]).round(6)
    np.float64(0.000998)
    """
    changes = np.asarray(r, dtype=np.float64)
    if changes.shape[-1:] != (4,):
        message = f"r has shape {changes.shape}, must be (..., 4): one change for each arm"
        raise InputError(Problem("bridge_output", message))
    r1, r2, r3, r4 = np.moveaxis(changes, -1, 0)
    left, right = (r1 - r2) / (2.0 + r1 + r2), (r3 - r4) / (2.0 + r3 + r4)
    return np.asarray(0.5 * (left + right))[()]


@explained
def quarter_bridge_strain(output: ArrayLike, gauge_factor: float = 2.0) -> Array:
    """Return the strain of a quarter bridge from its output, V/V, without linearisation.

    ``e = 4 v / (k (1 - 2 v))``, the inverse of ``v = k e / (4 + 2 k e)``.

    Raises
    ------
    InputError
        If a strain exceeds 10 %: the output was probably given in mV/V.

    Examples
    --------
    >>> quarter_bridge_strain(bridge_output([0.004, 0, 0, 0]))
    np.float64(0.002)
    """
    v = np.asarray(output, dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        strain = np.abs(4.0 * v / (gauge_factor * (1.0 - 2.0 * v)))
    if np.nanmax(strain, initial=0.0) > 0.1:
        big = float(np.nanmax(np.abs(v)))
        raise InputError(
            Problem(
                "quarter_bridge_strain",
                f"an output of {big:g} V/V is a strain of "
                f"{100 * np.nanmax(strain):.3g} %, beyond the range of any gauge; if the output "
                f"is in mV/V, divide by 1000",
            )
        )
    return np.asarray(4.0 * v / (gauge_factor * (1.0 - 2.0 * v)))[()]


class Arms(Field["Sequence[Gauge | None] | Gauge", "tuple[Gauge | None, ...]"]):
    """Field of up to four gauges; a model file contains their names."""

    form = "arms"
    noun = "sequence of Gauge or None"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a tuple of four, each a gauge or None, or report wrong values."""
        given: Any = (value,) if isinstance(value, Gauge) else value
        if not isinstance(given, Sequence) or isinstance(given, str):
            problems.add(where, f"{self.name} is {value!r}, must be up to four gauges")
            return ()
        if not 1 <= len(given) <= 4 or all(arm is None for arm in given):
            problems.add(
                where, f"has {len(given)} arms, must have one to four and at least one gauge"
            )
        for i, arm in enumerate(given):
            if arm is not None and not isinstance(arm, Gauge):
                problems.add(where, f"arm {i + 1} is {arm!r}, must be a Gauge or None")
        gauges = [arm for arm in given if isinstance(arm, Gauge)]
        if len({id(g.body) for g in gauges}) > 1:
            names = ", ".join(sorted({g.body.name for g in gauges}))
            problems.add(where, f"its gauges sit on several bodies ({names}), must be on one")
        if len({id(g) for g in gauges}) < len(gauges):
            problems.add(where, "one gauge is in several arms; give each arm its own gauge")
        if len({id(g.temperature.signal) for g in gauges if g.temperature is not None}) > 1:
            problems.add(
                where,
                "its gauges have different temperature signals; give all gauges the same signal",
            )
        return (*given, *(None,) * (4 - len(given)))


class GaugeFactor(Number):
    """Field of a gauge factor of either sign."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the gauge factor, or report an improbable one."""
        k = super().check(problems, where, value)
        if k is not None and not 0.1 <= abs(k) <= 300.0:
            problems.add(where, f"{self.name} is {k:g}, must be near 2 (metal) or 100 (silicon)")
        return k


class Bridge(Sensor, tag="bridge"):
    """Wheatstone bridge of one to four gauges on a body, (1,) V/V.

    The output / supply voltage is that of four resistors, see `bridge_output`: like a real bridge,
    a quarter bridge is slightly nonlinear. ``rows`` is its linear part, ``k (e1 - e2 + e3 - e4) /
    4``.

    Raises
    ------
    InputError
        Without a gauge, with more than four, or if the gauges differ in body or temperature.
    """

    unit: ClassVar[str] = "V/V"
    frame: ClassVar[str] = "gauge"
    components: ClassVar[tuple[str, ...]] = ("ratio",)
    flexible: ClassVar[bool] = True
    arms: Arms = field(
        "Up to four gauges in the order of the arms; None and missing arms are fixed resistors. "
        "Arms 1 and 3 count positive, 2 and 4 negative: ``(top, bottom)`` measures bending, "
        "``(top, None, bottom)`` tension without bending"
    )
    gauge_factor: GaugeFactor = field("Gauge factor k of ``dR/R = k e``", default=2.0, kw_only=True)
    resistance: Number = field(
        "Resistance R of each arm, for shunt calibration",
        unit="ohm",
        above=0,
        default=350.0,
        kw_only=True,
    )

    def heading(self, problems: Problems) -> str:
        """Return the prefix of messages."""
        return check_name(problems, "bridge", self.name)

    @property
    def gauges(self) -> tuple[Gauge, ...]:
        """Gauges of the arms."""
        return tuple(arm for arm in self.arms if arm is not None)

    @property
    def kind(self) -> str:  # type: ignore[override]
        """``quarter``, ``half``, ``three-quarter`` or ``full``."""
        return KINDS[len(self.gauges)]

    @property
    def body(self) -> FlexibleBody | ReducedPart:
        """Body on which the gauges are placed."""
        return self.gauges[0].body

    @property
    def reduced(self) -> ReducedPart:
        """Part on which the gauges are placed."""
        return self.gauges[0].reduced

    @property
    def arm_rows(self) -> Array:
        """Relative changes of resistance of the arms per unit modal coordinate, (4, n)."""
        out = np.zeros((4, self.gauges[0].rows.shape[1]))
        for i, arm in enumerate(self.arms):
            if arm is not None:
                out[i] = self.gauge_factor * arm.rows[0]
        return read_only(out)

    @property
    def arm_drift(self) -> Array:
        """Relative changes of resistance of the arms per kelvin, (4,)."""
        rates = [0.0 if a is None or a.temperature is None else a.temperature.per_kelvin
                 for a in self.arms]  # fmt: skip
        return read_only(self.gauge_factor * np.array(rates))

    @property
    def rows(self) -> Array:
        """Linear part of the output per unit modal coordinate, (1, n) V/V."""
        return read_only(0.25 * (SIGNS @ self.arm_rows)[None])

    @property
    def reading(self) -> Reading:
        """Input of the engine: the rows of the arms, then one row with the drifts of the arms."""
        rows = np.zeros((5, max(self.arm_rows.shape[1], 4)))
        rows[:4, : self.arm_rows.shape[1]] = self.arm_rows
        rows[4, :4] = self.arm_drift
        return Reading("bridge", self.body, self.signal, rows=rows)

    @property
    def signal(self) -> Signal | None:
        """Temperature change over time, K; None if no gauge has a temperature."""
        for gauge in self.gauges:
            if gauge.temperature is not None:
                return gauge.temperature.change
        return None

    @property
    def description(self) -> str:
        """One line for results and plots."""
        names = ", ".join("-" if arm is None else arm.name for arm in self.arms)
        return f"{self.kind} bridge ({names}), k = {self.gauge_factor:g}"

    def placed(self, reduced: ReducedPart) -> tuple[Array, Array, Array]:
        """Return position and axis of the first gauge, and rows (n,) of the bridge on a part."""
        total = np.zeros(len(reduced.frequencies))
        position, axis = np.zeros(3), np.zeros(3)
        for sign, arm in reversed(list(zip(SIGNS, self.arms, strict=True))):
            if arm is not None:
                position, axis, rows = arm.placed(reduced)
                total += 0.25 * sign * self.gauge_factor * rows
        return position, axis, total

    def output(self, strains: ArrayLike) -> Array:
        """Return the output, V/V, for strains (..., m) of the gauges, in their order."""
        e = np.asarray(strains, dtype=np.float64)
        if e.shape[-1:] != (len(self.gauges),):
            raise InputError(
                Problem(
                    f"bridge {self.name!r}",
                    f"strains have shape {e.shape}, the last dimension must be "
                    f"{len(self.gauges)}, the number of gauges",
                )
            )
        r = np.zeros((*e.shape[:-1], 4))
        active = [i for i, arm in enumerate(self.arms) if arm is not None]
        r[..., active] = self.gauge_factor * e
        return bridge_output(r)

    def shunt(self, resistor: float, arm: int = 1) -> float:
        """Return the output, V/V, with a shunt resistor parallel to an arm.

        The arm has ``r = -R / (R + R_shunt)``, which simulates the strain ``r/k``.

        Parameters
        ----------
        resistor : float
            Shunt resistance, ohm.
        arm : int
            Number of the arm, 1 to 4.
        """
        problems = Problems()
        where = f"bridge {self.name!r}"
        problems.positive(where, "resistor", resistor, "ohm")
        if arm not in (1, 2, 3, 4):
            problems.add(where, f"arm is {arm!r}, must be 1 to 4")
        problems.raise_if_any()
        r = np.zeros(4)
        r[arm - 1] = -self.resistance / (self.resistance + resistor)
        return float(bridge_output(r))
