"""Damage sensors: fatigue damage of what another sensor measures, counted by the engine."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

from jousto.base.arguments import explained
from jousto.base.described import described
from jousto.base.errors import Problems, suggest, warn
from jousto.base.names import check_name
from jousto.base.numbers import number, set_fields
from jousto.mechanism.sensors.body import VonMisesSensor
from jousto.mechanism.sensors.rule import MeterRule, meter_rule


@explained
@described
@dataclass(frozen=True, eq=False, init=False)
class DamageSensor:
    """Fatigue damage of values of another sensor, (2 k,): Miner's sum and closed cycles of each.

    The engine counts rainflow cycles at every step that it accepts, whatever is stored of them: at
    the ends of steps of fixed length, and at those of the adaptive method's own steps. Memory is
    fixed, and part of the state: with steps of fixed length a run that goes on from
    ``run.state()`` counts on as if it had not been interrupted; the adaptive method chooses its
    steps anew, and damage differs by what peaks between steps are missed. The value includes the
    residue as declared.

    Parameters
    ----------
    name : str
        Name, unique among the sensors.
    sensor : sensor
        What is counted: a sensor of the same mechanism, of stress in Pa or, with a factor, of
        anything that stress follows.
    sn : SN
        S-N curve, amplitudes in Pa.
    residue : str
        "half", "repeat" or "ignore"; see `DamageMeter`.
    mean : MeanStress, optional
        Mean stress correction, such as ``Goodman(S_u=..)``.
    components : str or sequence of str, optional
        Which components of the sensor; None for all of them.
    factor : float, optional
        Stress, Pa, for a value of 1, not 0; needed where the sensor does not measure Pa. A stress
        concentration factor too.
    depth : int
        Turning points that each meter remembers.
    resolution : float
        Samples are rounded to multiples of it, Pa; 0 takes them as they are.

    Warns
    -----
    JoustoWarning
        If the sensor measures von Mises stress, which has no sign: half of a reversed cycle.
    """

    unit: ClassVar[str] = "1"
    frame: ClassVar[str] = "scalar"
    name: str
    sensor: Any
    sn: Any
    residue: str
    mean: Any
    measured: tuple[str, ...]
    factor: float
    rule: MeterRule

    def __init__(
        self,
        name: str,
        sensor: Any,
        sn: Any,
        *,
        residue: str,
        mean: Any = None,
        components: Iterable[str] | str | None = None,
        factor: float | None = None,
        depth: int = 32,
        resolution: float = 0.0,
    ) -> None:
        problems = Problems()
        where = check_name(problems, "sensor", name)
        rule = meter_rule(
            problems, where, sn, residue=residue, mean=mean, depth=depth, resolution=resolution
        )
        known: tuple[str, ...] = tuple(getattr(sensor, "components", ()))
        measured = (components,) if isinstance(components, str) else tuple(components or known)
        if not known or isinstance(sensor, DamageSensor):
            problems.add(where, f"sensor is {sensor!r}, must be a sensor of stress")
        else:
            for component in measured:
                if component not in known:
                    problems.add(
                        where,
                        f"components: sensor {sensor.name!r} has no {component!r}"
                        f"{suggest(str(component), known)}",
                    )
            unit = str(sensor.unit)
            if factor is None and unit != "Pa":
                problems.add(
                    where,
                    f"sensor {sensor.name!r} measures {unit}, the S-N curve is in Pa; give factor,"
                    " the stress in Pa for a value of 1",
                )
        scale = 1.0 if factor is None else number(problems, where, "factor", factor)
        if scale == 0.0:
            problems.add(
                where,
                "factor is 0, with which nothing is damaged; give the stress for a value of 1",
            )
        problems.raise_if_any()
        if isinstance(sensor, VonMisesSensor):
            warn(
                where,
                f"sensor {sensor.name!r} measures von Mises stress, which is never negative: of a"
                " stress that changes sign it counts half the range; take components",
            )
        set_fields(
            self,
            name=name,
            sensor=sensor,
            sn=sn,
            residue=residue,
            mean=mean,
            measured=measured,
            factor=scale,
            rule=rule,
        )

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components: damage and cycles, of several values with theirs before."""
        if len(self.measured) == 1:
            return ("damage", "cycles")
        return tuple(f"{name}:{value}" for name in self.measured for value in ("damage", "cycles"))

    @property
    def places(self) -> tuple[int, ...]:
        """Which values of the sensor are counted."""
        known = tuple(self.sensor.components)
        return tuple(known.index(name) for name in self.measured)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        corrected = "" if self.mean is None else f", mean stress by {self.mean}"
        return f"fatigue damage of {self.sensor.name}, residue {self.residue}{corrected}"
