"""Temperature of strain gauges: their apparent strain without load."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Field, field
from jousto.base.numbers import Number, number
from jousto.mechanism.signals.base import Signal, SignalField


class PerKelvin(Field[float, float]):
    """Field of a temperature coefficient."""

    form = "number"
    noun = "float"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the coefficient, or report a value that was probably given in 1e-6/K."""
        found = number(problems, where, self.name, value)
        if found is not None and abs(found) > 0.01:
            problems.add(
                where,
                f"{self.name} is {found:g} 1/K; if it is in 1e-6/K, multiply by "
                f"1e-6 (12e-6 for steel)",
            )
        return found


class Expansion(PerKelvin):
    """Field of a coefficient of thermal expansion, or of a material with one."""

    form = "expansion"
    noun = "float or Material"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the coefficient, or report that there is none."""
        alpha = getattr(value, "alpha", value)
        if alpha is None:
            problems.add(where, f"{self.name}: {value!r} has no alpha; give it in 1/K, as 12e-6")
            return None
        return super().check(problems, where, alpha)


class Temperature(Declared):
    """Apparent strain of a gauge from a change of temperature.

    ``e_T = (alpha_part - alpha_gauge + beta / k) (T - T0)``: part and grid expand differently, and
    the resistance of the foil changes. A gauge matched to the part has an ``alpha_gauge`` for which
    the apparent strain vanishes; in a half or full bridge of equal gauges it cancels, too.

    Raises
    ------
    InputError
        If a value is not a number, the material has no ``alpha``, or a coefficient is so large that
        it was probably given in 1e-6/K.

    Examples
    --------
    >>> warm = Temperature(30.0, part=12e-6, gauge=11e-6, reference=20.0)
    >>> float(warm.apparent(0.0).round(12))
    1e-05
    """

    kind = "temperature"
    signal: SignalField = field(
        "Temperature T over time, such as an `Input` or a `Table`, in K or deg C", unit="1"
    )
    part: Expansion = field(
        "Coefficient of thermal expansion of the part, 1/K, or a material that has it (in files "
        "its name)",
        kw_only=True,
    )
    gauge: PerKelvin = field(
        "Coefficient of thermal expansion of the grid", unit="1/K", default=0.0, kw_only=True
    )
    reference: Number = field(
        "Temperature T0 at which the gauge was balanced, in the unit of the signal",
        default=20.0,
        kw_only=True,
    )
    resistance: PerKelvin = field(
        "Temperature coefficient beta of the grid's resistance",
        unit="1/K",
        default=0.0,
        kw_only=True,
    )
    gauge_factor: Number = field("Gauge factor k, used with beta only", default=2.0, kw_only=True)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a gauge factor of zero."""
        if self.gauge_factor == 0.0:
            problems.add(where, "gauge_factor is zero", "gauge_factor")

    @property
    def per_kelvin(self) -> float:
        """Apparent strain per kelvin, 1/K."""
        return self.part - self.gauge + self.resistance / self.gauge_factor

    @cached_property
    def change(self) -> Signal:
        """T - T0 as a function of time, K."""
        return self.signal - self.reference

    @cached_property
    def apparent(self) -> Signal:
        """Apparent strain as a function of time, m/m."""
        return self.per_kelvin * self.change
