"""Coupling: a model and functional mock-up units that step side by side and exchange values.

Both sides step from one exchange to the next with what they knew at its beginning (Jacobi's
scheme); then the units get the new values of the sensors and the model their outputs.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import ASK_TRUST, InputError, Problems, warn
from jousto.model.model import FmuModel, Model
from jousto.model.native.header import places
from jousto.model.native.native import Engine
from jousto.simulation.foreign.process import FmuProcess
from jousto.simulation.results.diagnostics import FAIR
from jousto.simulation.solvers.explicit import Solver
from jousto.simulation.solvers.schedule import Schedule
from jousto.simulation.state import State

REST = 1e-9  # of a step: times that agree up to round-off


@dataclass
class Partner:
    """A unit in a run.

    Attributes
    ----------
    model : FmuModel
        The unit.
    every : int
        Steps of the model between two exchanges.
    known : list of (time, outputs, inputs)
        At the last exchanges, the newest last.
    account : (2,) array
        Energy that it delivered and that the model received, J.
    told : (2,) array
        The same at the last exchange: only there do both know as much.
    """

    model: FmuModel
    every: int
    process: FmuProcess = field(init=False)
    known: list[tuple[float, Array, Array]] = field(default_factory=list)
    account: Array = field(default_factory=lambda: np.zeros(2))
    told: Array = field(default_factory=lambda: np.zeros(2))
    extremes: Array = field(default_factory=lambda: np.zeros(2))
    error: float = 0.0

    def __post_init__(self) -> None:
        fmu = self.model.fmu
        self.linear = fmu.between == "linear"
        outputs, inputs = list(fmu.outputs), [*self.model.measured, *self.model.given]
        self.pairs = [(outputs.index(a), inputs.index(b)) for a, b in fmu.power.items()]
        self.places = np.array(list(self.model.measured.values()), dtype=np.intp)
        self.given = np.array(list(self.model.given.values()))
        self.errors = np.zeros(len(outputs))

    def measured(self, sensors: Array) -> Array:
        """Return its inputs for sensor values (nout,)."""
        return np.concatenate([sensors[self.places], self.given])

    def ahead(self, time: float, lag: int, which: int) -> Array:
        """Return its outputs (1) or inputs (2) at a time, from what was known at exchanges."""
        t, *last = self.known[-1]
        value = last[which - 1]
        if not self.linear or len(self.known) <= lag:
            return value
        before = self.known[-1 - lag]
        slope = (value - before[which]) / (t - before[0])
        return np.asarray(value + (time - t) * slope)

    def step(self, time: float, lag: int) -> None:
        """Step to a time with inputs as they were known in the middle."""
        t, start, _ = self.known[-1]
        given = self.ahead(0.5 * (t + time), lag, 2)
        end = self.process.step(t, time - t, given)
        for out, into in self.pairs:
            self.account[0] += 0.5 * (start[out] + end[out]) * given[into] * (time - t)
        self.known = [*self.known[-2:], (time, end, given)]

    def exchange(self, time: float, sensors: Array) -> None:
        """Give it new inputs and take its outputs."""
        given = self.measured(sensors)
        outputs = self.process.exchange(time, given)
        self.known[-1] = (time, outputs, given)
        self.told = self.account.copy()
        self.extremes = np.array(
            [min(self.extremes[0], self.account[1]), max(self.extremes[1], self.account[1])]
        )
        self.error = max(self.error, abs(self.account[1] - self.account[0]))


class Coupling:
    """All units of a run.

    Parameters
    ----------
    engine : Engine
        At the start.
    plan : Schedule
        Steps of the run.

    Raises
    ------
    FmuFailed
        As all its methods, if a unit fails.
    """

    def __init__(self, engine: Engine, plan: Schedule) -> None:
        model = engine.model
        self.engine = engine
        self.partners = [
            Partner(unit, round(unit.fmu.step / plan.step)) for unit in model.fmus
        ]  # fmt: skip
        self.estimates = any(unit.fmu.estimate for unit in model.fmus)
        self.linear = any(partner.linear for partner in self.partners)
        self.sensors = 1 + model.nq + model.nv + model.nrow + len(places("jo_diagnostics"))
        self._inputs = {name: i for i, name in enumerate(model.inputs)}
        self._seen = np.zeros(model.nout)
        opened = []
        try:
            row = engine.row()[self.sensors : self.sensors + model.nout]
            stop = plan.start + plan.step * plan.steps
            for partner in self.partners:
                partner.process = FmuProcess(partner.model, partner.measured(row), stop)
                opened.append(partner)
                partner.known = [(0.0, partner.process.values, partner.measured(row))]
            self._put(0.0, 1)
        except BaseException:
            for partner in opened:
                partner.process.close()
            raise

    @property
    def largest(self) -> int:
        """Most steps of the model between two exchanges."""
        return max(partner.every for partner in self.partners)

    def ahead(self, done: int) -> int:
        """Return the steps until the next exchange."""
        return min(partner.every - done % partner.every for partner in self.partners)

    def begin(self, row: Array) -> None:
        """Take what the sensors have at the start."""
        self._seen = self._values(row).copy()

    def extrapolate(self, step: float, lag: int) -> None:
        """Set what the model knows of the units in the middle of its next step."""
        if self.linear:
            self._put(float(self.engine.time[0]) + 0.5 * step, lag)

    def audit(self, rows: Array, step: float) -> None:
        """Add up what the model received in steps that end with these rows."""
        for row in rows:
            now = self._values(row)
            for partner in self.partners:
                outputs = list(partner.model.fmu.outputs)
                for out, into in partner.pairs:
                    place = partner.places[into]
                    name = partner.model.set.get(outputs[out], "")
                    force = (
                        self.engine.input[self._inputs[name]] if name else partner.known[-1][1][out]
                    )
                    mean = 0.5 * (self._seen[place] + now[place])
                    partner.account[1] += force * mean * step
            self._seen = now.copy()  # the rows are written over

    def meet(self, done: int, lag: int = 1, *, all_of_them: bool = False) -> None:
        """Step the units that are due to the time of the model, and exchange."""
        time = float(self.engine.time[0])
        due = [p for p in self.partners if all_of_them or done % p.every == 0]
        for partner in due:
            partner.step(time, lag)
        self._put(time, lag)
        # sensors may depend on what another unit has now
        row = self.engine.row()
        for partner in due:
            partner.exchange(time, self._values(row))
        self._put(time, lag)

    def save(self) -> None:
        """Keep where the units are."""
        time = float(self.engine.time[0])
        self._kept = [
            (list(p.known), p.account.copy(), p.told, p.extremes, p.error) for p in self.partners
        ]
        self._seen_then = self._seen
        for partner in self.partners:
            partner.process.save(time)

    def restore(self) -> list[Array]:
        """Go back to there; return the outputs where they were."""
        found = [partner.known[-1][1] for partner in self.partners]
        time = float(self.engine.time[0])
        self._seen = self._seen_then
        for partner, kept in zip(self.partners, self._kept, strict=True):
            partner.known, partner.account, partner.told, partner.extremes, partner.error = kept
            partner.process.restore(time)
        return found

    def compare(self, coarse: list[Array]) -> None:
        """Estimate the errors of a step, made as two halves, from one of full length."""
        for partner, other in zip(self.partners, coarse, strict=True):
            share = 3.0 if partner.linear else 1.0  # 2^p - 1 of a method of order p
            partner.errors = np.abs(partner.known[-1][1] - other) / share
        self._put(float(self.engine.time[0]), 1)

    def again(self) -> None:
        """Set what the model knew where it went back to."""
        self._put(float(self.engine.time[0]), 1)

    def judge(self) -> None:
        """Warn of energy that the exchange added or took."""
        for partner in self.partners:
            crossed = float(partner.extremes[1] - partner.extremes[0])
            if partner.pairs and partner.error > FAIR * crossed and crossed > 0.0:
                fmu = partner.model.fmu
                hint = "" if fmu.between == "linear" else " or between='linear'"
                warn(
                    f"fmu {fmu.name!r}",
                    f"the exchange misses up to {partner.error:.3g} J of {crossed:.3g} J that "
                    f"crossed; a smaller step than {fmu.step:g} s{hint} is more accurate",
                )

    def close(self) -> None:
        """End all units."""
        for partner in self.partners:
            partner.process.close()

    def _values(self, row: Array) -> Array:
        return row[self.sensors : self.sensors + self.engine.model.nout]

    def _put(self, time: float, lag: int) -> None:
        """Set the inputs of the model and what the results have of the units."""
        put = self.engine.input
        for partner in self.partners:
            fmu = partner.model.fmu
            ahead, last = partner.ahead(time, lag, 1), partner.known[-1][1]
            for k, name in enumerate(fmu.outputs):
                if name in partner.model.set:
                    put[self._inputs[partner.model.set[name]]] = ahead[k]
                put[self._inputs[f"{fmu.name}.{name}"]] = last[k]
                if fmu.estimate:
                    put[self._inputs[f"{fmu.name}.{name}.error"]] = partner.errors[k]
            if partner.pairs:
                delivered, received = partner.told
                put[self._inputs[f"{fmu.name}.delivered"]] = delivered
                put[self._inputs[f"{fmu.name}.received"]] = received
                put[self._inputs[f"{fmu.name}.energy_error"]] = received - delivered


def check_trust(model: Model) -> None:
    """Refuse to load native code that a model file names and nobody trusts.

    Raises
    ------
    InputError
        With all such units.
    """
    problems = Problems()
    for unit in model.fmus:
        fmu = unit.fmu
        if fmu.untrusted:
            problems.add(
                f"{fmu.untrusted}: fmu {fmu.name!r}",
                f"{fmu.file.name!r} contains native code, {ASK_TRUST}",
            )
    problems.raise_if_any()


def check_coupling(
    model: Model, solver: Solver, plan: Schedule, state: State | None, inputs: object
) -> None:
    """Refuse runs that foreign models cannot make.

    Raises
    ------
    InputError
        With all reasons.
    """
    problems = Problems()
    steps = {unit.fmu.step for unit in model.fmus}
    for unit in model.fmus:
        fmu, where = unit.fmu, f"fmu {unit.fmu.name!r}"
        if solver.adaptive:
            problems.add(
                where,
                f"{type(solver).__name__} chooses its steps itself; take a method of fixed step, "
                "such as ROS2",
            )
            continue
        if state is not None and state.time != 0.0:
            problems.add(
                where,
                f"starts at time 0 and its state at {state.time:g} s is not known: a run with it "
                "cannot be continued, run from 0 to the new end",
            )
        every = fmu.step / plan.step
        if round(every) < 1 or abs(every - round(every)) > REST * every:
            good = max(1, round(every)) * plan.step
            problems.add(
                where,
                f"step is {fmu.step:g} s, must be a multiple of the step of the run, "
                f"{plan.step:g} s; for example {good:g} s",
            )
        elif plan.steps % round(every):
            problems.add(
                where,
                f"the run of {plan.steps * plan.step:g} s is no multiple of its step, "
                f"{fmu.step:g} s",
            )
        elif fmu.estimate and round(every) % 2:
            problems.add(
                where,
                f"estimate=True halves its step of {fmu.step:g} s, which the step of the run, "
                f"{plan.step:g} s, does not divide; take {0.5 * plan.step:g} s or "
                f"{2 * fmu.step:g} s",
            )
        if any(other.fmu.estimate for other in model.fmus):
            if len(steps) > 1:
                problems.add(where, "with estimate=True all units need one step")
            if not fmu.description.states:
                problems.add(where, "cannot go back to a state, which estimate=True needs")
        for name in fmu.driven:
            if isinstance(inputs, dict) and name in inputs:
                problems.add("simulate", f"inputs: {name!r} is set by {where}, leave it out")
    if problems.found:
        raise InputError(problems.found)
