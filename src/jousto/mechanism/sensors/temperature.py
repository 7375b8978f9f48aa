"""Temperature of strain gauges: what they show without any load."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from jousto.base.described import described
from jousto.base.errors import Problems
from jousto.base.numbers import number, set_fields
from jousto.mechanism.signals.base import Signal, check_signal


@described
@dataclass(frozen=True, eq=False, init=False)
class Temperature:
    """Apparent strain of a gauge whose temperature changes.

    ``e_T = (alpha_part - alpha_gauge + beta / k) (T - T0)``: part and grid expand differently and
    the resistance of the foil changes. A gauge made for the part has ``alpha_gauge`` chosen so that
    nothing is left; a half or full bridge of equal gauges takes it out, too.

    Parameters
    ----------
    signal : Signal or float
        Temperature T over time, such as an `Input` or a `Table`, in K or deg C.
    part : float or Material
        Coefficient of thermal expansion of the part, 1/K, or a material that knows it.
    gauge : float
        That of the grid, 1/K.
    reference : float
        Temperature T0 at which the gauge was balanced, in the unit of the signal.
    resistance : float
        Temperature coefficient beta of the grid's resistance, 1/K.
    gauge_factor : float
        k, for beta only.

    Attributes
    ----------
    apparent : Signal
        Apparent strain over time, m/m.
    change : Signal
        T - T0 over time, K.
    per_kelvin : float
        Apparent strain of one kelvin, 1/K.

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

    signal: Signal
    part: float
    gauge: float
    reference: float
    resistance: float
    gauge_factor: float
    apparent: Signal
    change: Signal
    per_kelvin: float

    def __init__(
        self,
        signal: Signal | float,
        *,
        part: Any,
        gauge: float = 0.0,
        reference: float = 20.0,
        resistance: float = 0.0,
        gauge_factor: float = 2.0,
    ) -> None:
        problems = Problems()
        where = "temperature"
        over_time = check_signal(problems, where, "signal", signal)
        if hasattr(part, "alpha"):
            if part.alpha is None:
                problems.add(where, f"part: {part!r} has no alpha; give it in 1/K, as 12e-6")
            part = 0.0 if part.alpha is None else part.alpha
        values = {
            "part": number(problems, where, "part", part),
            "gauge": number(problems, where, "gauge", gauge),
            "reference": number(problems, where, "reference", reference),
            "resistance": number(problems, where, "resistance", resistance),
            "gauge_factor": number(problems, where, "gauge_factor", gauge_factor),
        }
        for key in ("part", "gauge", "resistance"):
            found = values[key]
            if found is not None and abs(found) > 0.01:
                problems.add(where, f"{key} is {found:g} 1/K; was it meant in 1e-6/K? Give 12e-6")
        if values["gauge_factor"] is not None and values["gauge_factor"] == 0.0:
            problems.add(where, "gauge_factor is zero")
        problems.raise_if_any()
        assert over_time is not None
        set_fields(self, signal=over_time, **values)
        rate = self.part - self.gauge + self.resistance / self.gauge_factor
        change = over_time - self.reference
        set_fields(self, per_kelvin=rate, change=change, apparent=rate * change)


def check_temperature(problems: Problems, where: str, value: Any) -> Temperature | None:
    """Return a temperature or None, or note that the value is neither."""
    if value is not None and not isinstance(value, Temperature):
        problems.add(
            where, f"temperature is {value!r}, must be a Temperature(signal, part=..., gauge=...)"
        )
        return None
    return value
