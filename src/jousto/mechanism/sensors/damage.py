"""Damage sensors: fatigue damage of the values of another sensor, counted by the engine."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, ClassVar

from jousto.base.errors import Problems, suggest, warn
from jousto.base.fields import Choice, Field, Reference, field
from jousto.base.numbers import DefaultNumber, Number, set_fields
from jousto.mechanism.sensors.base import Meter, Reading, Sensor
from jousto.mechanism.sensors.body import VonMisesSensor
from jousto.mechanism.sensors.damage_rule import RESIDUES, MeterRule, meter_rule


class Counted(Reference[Any, Any]):
    """Field of a sensor; a model file contains its name."""

    section = "sensors"
    word = "sensor"
    noun = "sensor"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the sensor, or report a value of another type."""
        if not isinstance(value, Sensor) or isinstance(value, DamageSensor):
            problems.add(where, f"{self.name} is {value!r}, must be a sensor of stress")
        return value


class Curve(Field[Any, Any]):
    """Field of an S-N curve."""

    form = "sn"
    noun = "SN"


class Correction(Field[Any, Any]):
    """Field of a mean stress correction."""

    form = "mean"
    noun = "MeanStress"


class Residue(Choice):
    """Field of the residue rule of the rainflow count; `meter_rule` checks it."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the value unchanged."""
        return value


class Components(Field["Iterable[str] | str | None", "tuple[str, ...]"]):
    """Field of components of the counted sensor."""

    form = "words"
    noun = "str or sequence of str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the names as a tuple, or report wrong ones."""
        if not isinstance(value, Iterable):
            problems.add(where, f"{self.name} is {value!r}, must be names of components")
            return ()
        return (value,) if isinstance(value, str) else tuple(value)


class Depth(Field[int, int]):
    """Field of a number of turning points; `meter_rule` checks it."""

    form = "count"
    noun = "int"


class DamageSensor(Sensor, tag="damage"):
    """Fatigue damage of another sensor, (2 k,): Miner's sum and closed cycles of each value.

    The engine counts rainflow cycles at the end of every accepted step, independent of the output
    instants. The memory of the count has a fixed size and is part of the state: with a fixed step a
    run that continues from ``run.state()`` counts as if it had not been interrupted. The adaptive
    method chooses other steps after an interruption, so that damage differs by the peaks missed
    between steps. The damage includes the residue, by the given rule.

    Attributes
    ----------
    components : tuple of str
        Names of the values: damage and cycles, preceded by the component if there are several.
    measured : tuple of str
        Counted components of the other sensor.
    rule : MeterRule
        Rule of the count.

    Warns
    -----
    JoustoWarning
        If the sensor measures von Mises stress, which has no sign, so that a fully reversed cycle
        counts with half its range.
    """

    unit: ClassVar[str] = "1"
    frame: ClassVar[str] = "scalar"
    sensor: Counted = field(
        "The counted sensor of the same mechanism: stress in Pa or, with a factor, a quantity "
        "proportional to stress"
    )
    sn: Curve = field("S-N curve with amplitudes in Pa (in files also its name)")
    residue: Residue = field(
        "Rule for the residue of the rainflow count; see `DamageMeter`",
        words=RESIDUES,
        kw_only=True,
    )
    mean: Correction = field(
        "Mean stress correction, such as ``Goodman(S_u=..)``", default=None, kw_only=True
    )
    components: Components = field(
        "Components of the sensor; None for all", default=None, kw_only=True
    )
    factor: DefaultNumber = field(
        "Stress, Pa, per unit of the sensor, not 0; needed if the sensor does not measure Pa; may "
        "include a stress concentration factor",
        default=None,
        kw_only=True,
    )
    depth: Depth = field(
        "Number of turning points that each meter stores", default=32, kw_only=True
    )
    resolution: Number = field(
        "Resolution to which samples are rounded; 0 for no rounding",
        unit="Pa",
        default=0.0,
        kw_only=True,
    )

    if TYPE_CHECKING:

        @property
        def measured(self) -> tuple[str, ...]: ...  # noqa: D102
        @property
        def rule(self) -> MeterRule: ...  # noqa: D102

    def consistent(self, problems: Problems, where: str) -> None:
        """Find the counted components and the rule of the count."""
        sensor, factor = self.sensor, vars(self)["factor"]
        rule = meter_rule(
            problems,
            where,
            self.sn,
            residue=self.residue,
            mean=self.mean,
            depth=self.depth,
            resolution=self.resolution,
        )
        known: tuple[str, ...] = tuple(sensor.components)
        measured = vars(self)["components"] or known
        for component in measured:
            if component not in known:
                problems.add(
                    where,
                    f"sensor {sensor.name!r} has no {component!r}{suggest(str(component), known)}",
                    "components",
                    named=False,
                )
        if factor is None and sensor.unit != "Pa":
            problems.add(
                where,
                f"sensor {sensor.name!r} measures {sensor.unit}, the S-N curve is in Pa; give "
                "factor, the stress in Pa per unit of the sensor",
                "sensor",
            )
        if factor == 0.0:
            problems.add(
                where,
                "factor is 0, so that there is no damage; give the stress in Pa per unit of the"
                " sensor",
                "factor",
            )
        if isinstance(sensor, VonMisesSensor) and not problems.found:
            warn(
                where,
                f"sensor {sensor.name!r} measures von Mises stress, which is never negative: half "
                f"the range of an alternating stress is counted; use the components of a "
                f"StressSensor",
                "sensor",
            )
        values: tuple[str, ...] = ("damage", "cycles")
        if len(measured) > 1:
            values = tuple(f"{name}:{value}" for name in measured for value in values)
        set_fields(
            self,
            components=values,
            measured=measured,
            factor=1.0 if factor is None else factor,
            rule=rule,
        )

    @property
    def meters(self) -> tuple[Meter, ...]:
        """Rainflow count of each component."""
        known = tuple(self.sensor.components)
        return tuple(
            Meter(self.rule, self.sensor, known.index(name), self.factor) for name in self.measured
        )

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading("damage", self)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        corrected = "" if self.mean is None else f", mean stress by {self.mean}"
        return f"fatigue damage of {self.sensor.name}, residue {self.residue}{corrected}"
