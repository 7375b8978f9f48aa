"""Runs of a machine and of its variants, with their readings at the same instants."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.rounding import DIGITS
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.damage import DamageSensor
from jousto.model.compile import compile
from jousto.model.model import Model
from jousto.model.scales import scales_of
from jousto.simulation.results.dataframes import component_units
from jousto.simulation.results.solution import Solution
from jousto.simulation.running.simulate import simulate
from jousto.simulation.running.start_state import initial_state

NO_RANGE = 1e-12
"""Range / scale of the unit in the machine, below which a reading has no range."""
BESIDE = 1e-9
"""Range / largest value of the same unit in the sensor, below which it has no range."""


@dataclass(frozen=True, eq=False)
class Settings:
    """Arguments of `simulate`, the same for all runs.

    Attributes
    ----------
    t_end : float
        End of the runs, s.
    how : dict
        solver and output_step, where given.
    start : str or None
        Start of the runs, as in `Mechanism`; None is that of the mechanism.
    """

    t_end: float
    how: dict[str, Any]
    start: str | None


@dataclass(frozen=True, eq=False)
class VariantRun:
    """Run of a machine.

    Attributes
    ----------
    mechanism : Mechanism
    model : Model
    run : Solution
    arguments : dict
        Arguments of `simulate` with the initial state.
    """

    mechanism: Mechanism
    model: Model
    run: Solution
    arguments: dict[str, Any]

    @property
    def steps(self) -> float:
        """Number of steps, with those repeated."""
        work = self.run.work
        return float(work.steps[-1] + work.rejected[-1])

    @property
    def seconds(self) -> float:
        """Duration of the run, s."""
        return float(self.run.attributes["wall_time"])


@dataclass(frozen=True, eq=False)
class Reading:
    """One value of a sensor.

    Attributes
    ----------
    name : str
        ``sensor.component``, or the sensor if it has one value.
    sensor : str
    component : int
    unit : str
    floor : float
        Range in the unit, up to which the reading has none.
    values : (nt,) array
    """

    name: str
    sensor: str
    component: int
    unit: str
    floor: float
    values: Array


def run_variant(mechanism: Mechanism, settings: Settings, *, quiet: bool = True) -> VariantRun:
    """Return the run of a mechanism; without warnings, which the first run has shown.

    Raises
    ------
    JoustoError
        If the mechanism cannot be compiled, or the run fails.
    """
    with warnings.catch_warnings():
        if quiet:
            warnings.simplefilter("ignore")
        model = compile(mechanism)
        state = initial_state(model, start=settings.start)
        arguments = {"t_end": settings.t_end, **settings.how, "state": state}
        return VariantRun(mechanism, model, simulate(model, **arguments), arguments)


def sensor_readings(done: VariantRun) -> Iterator[Reading]:
    """Yield the values of all sensors of a run, except those of damage."""
    damage = {one.name for one in done.mechanism.sensors if isinstance(one, DamageSensor)}
    scales = scales_of(done.model)
    for sensor in done.run.sensors:
        if sensor in damage:
            continue
        values = done.run[sensor].reshape(done.run.nt, -1)
        about = done.run.about(sensor)
        units, names = np.array(component_units(about)), about["components"]
        largest = np.abs(values).max(axis=0, initial=0.0)
        for k, (unit, name) in enumerate(zip(units, names, strict=True)):
            beside = float(largest[units == unit].max())
            floor = max(NO_RANGE / DIGITS * scales.floor(str(unit)), BESIDE * beside)
            label = sensor if len(names) == 1 else f"{sensor}.{name}"
            yield Reading(label, sensor, k, str(unit), floor, values[:, k])
