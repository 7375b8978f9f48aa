"""Damage sensors: fatigue damage of what another sensor measures, counted by the engine."""

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
    """A sensor; a model file gives its name."""

    section = "sensors"
    word = "sensor"
    noun = "sensor"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the sensor."""
        if not isinstance(value, Sensor) or isinstance(value, DamageSensor):
            problems.add(where, f"{self.name} is {value!r}, must be a sensor of stress")
        return value


class Curve(Field[Any, Any]):
    """An S-N curve."""

    form = "sn"
    noun = "SN"


class Correction(Field[Any, Any]):
    """A mean stress correction."""

    form = "mean"
    noun = "MeanStress"


class Residue(Choice):
    """How what the rainflow count leaves over is counted; `meter_rule` checks it."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the value."""
        return value


class Components(Field["Iterable[str] | str | None", "tuple[str, ...]"]):
    """Components of the sensor that is counted."""

    form = "words"
    noun = "str or sequence of str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return them as a tuple."""
        if not isinstance(value, Iterable):
            problems.add(where, f"{self.name} is {value!r}, must be names of components")
            return ()
        return (value,) if isinstance(value, str) else tuple(value)


class Depth(Field[int, int]):
    """A number of turning points; `meter_rule` checks it."""

    form = "count"
    noun = "int"


class DamageSensor(Sensor, tag="damage"):
    """Fatigue damage of values of another sensor, (2 k,): Miner's sum and closed cycles of each.

    The engine counts rainflow cycles at every step that it accepts, whatever is stored of them: at
    the ends of steps of fixed length, and at those of the adaptive method's own steps. Memory is
    fixed, and part of the state: with steps of fixed length a run that goes on from
    ``run.state()`` counts on as if it had not been interrupted; the adaptive method chooses its
    steps anew, and damage differs by what peaks between steps are missed. The value includes the
    residue as declared.

    Attributes
    ----------
    components : tuple of str
        Names of its values: damage and cycles, of several values with theirs before.
    measured : tuple of str
        The components of the other sensor that are counted.
    rule : MeterRule
        How they are counted.

    Warns
    -----
    JoustoWarning
        If the sensor measures von Mises stress, which has no sign: half of a reversed cycle.
    """

    unit: ClassVar[str] = "1"
    frame: ClassVar[str] = "scalar"
    sensor: Counted = field(
        "What is counted: a sensor of the same mechanism, of stress in Pa or, with a factor, of "
        "anything that stress follows"
    )
    sn: Curve = field("S-N curve, amplitudes in Pa (in files also its name)")
    residue: Residue = field(
        "How what the rainflow count leaves over counts; see `DamageMeter`",
        words=RESIDUES,
        kw_only=True,
    )
    mean: Correction = field(
        "Mean stress correction, such as ``Goodman(S_u=..)``", default=None, kw_only=True
    )
    components: Components = field(
        "Which components of the sensor; None for all of them", default=None, kw_only=True
    )
    factor: DefaultNumber = field(
        "Stress, Pa, for a value of 1, not 0; needed where the sensor does not measure Pa; a "
        "stress concentration factor too",
        default=None,
        kw_only=True,
    )
    depth: Depth = field("Turning points that each meter remembers", default=32, kw_only=True)
    resolution: Number = field(
        "Samples are rounded to multiples of it; 0 takes them as they are",
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
        """Find what is counted, and how."""
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
                "factor, the stress in Pa for a value of 1",
                "sensor",
            )
        if factor == 0.0:
            problems.add(
                where,
                "factor is 0, with which nothing is damaged; give the stress for a value of 1",
                "factor",
            )
        if isinstance(sensor, VonMisesSensor) and not problems.found:
            warn(
                where,
                f"sensor {sensor.name!r} measures von Mises stress, which is never negative: of a"
                " stress that changes sign it counts half the range; take components",
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
        """The count of each component."""
        known = tuple(self.sensor.components)
        return tuple(
            Meter(self.rule, self.sensor, known.index(name), self.factor) for name in self.measured
        )

    @property
    def reading(self) -> Reading:
        """What the engine reads."""
        return Reading("damage", self)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        corrected = "" if self.mean is None else f", mean stress by {self.mean}"
        return f"fatigue damage of {self.sensor.name}, residue {self.residue}{corrected}"
