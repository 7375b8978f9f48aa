"""Temperature of strain gauges: what they show without any load."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Field, field
from jousto.base.numbers import Number, number
from jousto.mechanism.signals.base import Signal, SignalField


class PerKelvin(Field[float, float]):
    """A coefficient of temperature."""

    form = "number"
    noun = "float"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the coefficient, or note one that was likely given in 1e-6/K."""
        found = number(problems, where, self.name, value)
        if found is not None and abs(found) > 0.01:
            problems.add(where, f"{self.name} is {found:g} 1/K; was it meant in 1e-6/K? Give 12e-6")
        return found


class Expansion(PerKelvin):
    """A coefficient of thermal expansion, or a material that knows it."""

    form = "expansion"
    noun = "float or Material"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the coefficient."""
        alpha = getattr(value, "alpha", value)
        if alpha is None:
            problems.add(where, f"{self.name}: {value!r} has no alpha; give it in 1/K, as 12e-6")
            return None
        return super().check(problems, where, alpha)


class Temperature(Declared):
    """Apparent strain of a gauge whose temperature changes.

    ``e_T = (alpha_part - alpha_gauge + beta / k) (T - T0)``: part and grid expand differently and
    the resistance of the foil changes. A gauge made for the part has ``alpha_gauge`` chosen so that
    nothing is left; a half or full bridge of equal gauges takes it out, too.

    Raises
    ------
    InputError
        Values that are no numbers, a material without ``alpha``, or one so large that it was likely
        given in 1e-6/K.

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
    gauge: PerKelvin = field("That of the grid", unit="1/K", default=0.0, kw_only=True)
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
    gauge_factor: Number = field("k, for beta only", default=2.0, kw_only=True)

    def consistent(self, problems: Problems, where: str) -> None:
        """Note a gauge factor of zero."""
        if self.gauge_factor == 0.0:
            problems.add(where, "gauge_factor is zero", "gauge_factor")

    @property
    def per_kelvin(self) -> float:
        """Apparent strain of one kelvin, 1/K."""
        return self.part - self.gauge + self.resistance / self.gauge_factor

    @cached_property
    def change(self) -> Signal:
        """T - T0 over time, K."""
        return self.signal - self.reference

    @cached_property
    def apparent(self) -> Signal:
        """Apparent strain over time, m/m."""
        return self.per_kelvin * self.change
