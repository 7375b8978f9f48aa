"""Coupling: co-simulation of a model and functional mock-up units, with Jacobi's scheme.

Model and units step from one exchange to the next with the values of the last exchange; then the
units receive the new values of the sensors, and the model receives their outputs. If outputs and
sensors depend on each other at the same instant, `algebraic_loops` solves for both.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import warn
from jousto.model.model import FmuModel
from jousto.model.native.header import places
from jousto.model.native.native import Engine
from jousto.simulation.cosimulation.algebraic_loops import Growth, Loop, LoopFailed
from jousto.simulation.cosimulation.fmu_process import FmuFailed, FmuProcess
from jousto.simulation.results.diagnostics import FAIR
from jousto.simulation.solvers.schedule import Schedule

GROWING = 2  # number of growing ratios of differences after which a message names the unit


@dataclass
class Partner:
    """Functional mock-up unit in a run.

    Attributes
    ----------
    model : FmuModel
        Functional mock-up unit.
    every : int
        Steps of the model between two exchanges.
    known : list of (time, outputs, inputs)
        Values at the last exchanges, the newest last.
    account : (2,) array
        Energy that the unit delivered and that the model received, J. Without `power`: work of the
        outputs in the model, with their values at exchanges and with those used by the model.
    told : (2,) array
        Value of `account` at the last exchange, the only instants at which both are comparable.
    rate : float
        Power of its outputs in the model after the last exchange, W.
    growth : Growth
        Growth of the outputs that depend directly on inputs.
    """

    model: FmuModel
    every: int
    process: FmuProcess = field(init=False)
    known: list[tuple[float, Array, Array]] = field(default_factory=list)
    account: Array = field(default_factory=lambda: np.zeros(2))
    told: Array = field(default_factory=lambda: np.zeros(2))
    extremes: Array = field(default_factory=lambda: np.zeros(2))
    error: float = 0.0
    rate: float = 0.0
    growth: Growth = field(default_factory=Growth)

    def __post_init__(self) -> None:
        fmu = self.model.fmu
        self.where = f"fmu {fmu.name!r}"
        self.linear = fmu.between == "linear"
        outputs, inputs = list(fmu.outputs), [*self.model.measured, *self.model.given]
        self.pairs = [(outputs.index(a), inputs.index(b)) for a, b in fmu.power.items()]
        self.places = np.array(list(self.model.measured.values()), dtype=np.intp)
        self.given = np.array(list(self.model.given.values()))
        self.errors = np.zeros(len(outputs))
        about, acting = fmu.description, [k for k in outputs if k in self.model.set]
        self.direct = np.array(
            [outputs.index(k) for k in acting if any(about.feeds_through(k, u) for u in inputs)],
            dtype=np.intp,
        )
        held = [about.variables[k].variability == "discrete" for k in acting]
        self.watched = bool(acting) and not self.pairs and not all(held)

    def measured(self, sensors: Array) -> Array:
        """Return the inputs of the unit for sensor values (nout,)."""
        return np.concatenate([sensors[self.places], self.given])

    def ahead(self, time: float, lag: int, which: int) -> Array:
        """Return outputs (which=1) or inputs (which=2) at a time, extrapolated from exchanges."""
        t, *last = self.known[-1]
        value = last[which - 1]
        if not self.linear or len(self.known) <= lag:
            return value
        before = self.known[-1 - lag]
        slope = (value - before[which]) / (t - before[0])
        return np.asarray(value + (time - t) * slope)

    def step(self, time: float, lag: int) -> None:
        """Step to a time with the inputs extrapolated to the middle of the step."""
        t, start, _ = self.known[-1]
        given = self.ahead(0.5 * (t + time), lag, 2)
        end = self.process.step(t, time - t, given)
        for out, into in self.pairs:
            self.account[0] += 0.5 * (start[out] + end[out]) * given[into] * (time - t)
        self.known = [*self.known[-2:], (time, end, given)]

    def exchange(self, time: float, sensors: Array) -> None:
        """Set the inputs to sensor values and read the outputs."""
        given = self.measured(sensors)
        self.known[-1] = (time, self.process.exchange(time, given), given)

    def tally(self) -> None:
        """Update the largest difference of delivered and received energy at an exchange."""
        self.told = self.account.copy()
        self.extremes = np.array(
            [min(self.extremes[0], self.account[1]), max(self.extremes[1], self.account[1])]
        )
        self.error = max(self.error, abs(self.account[1] - self.account[0]))

    @property
    def misses(self) -> str:
        """Return the warning for the energy error of the exchange; empty if the error is small."""
        crossed = float(self.extremes[1] - self.extremes[0])
        if not (self.error > FAIR * crossed and crossed > 0.0):
            return ""
        fmu = self.model.fmu
        hint = "" if fmu.between == "linear" else " or between='linear'"
        return (
            f"the exchange has an energy error of up to {self.error:.3g} J of {crossed:.3g} J "
            f"transferred; a smaller step than {fmu.step:g} s{hint} is more accurate"
        )


class Coupling:
    """Functional mock-up units of a run.

    Parameters
    ----------
    engine : Engine
        Engine in the initial state.
    plan : Schedule
        Steps of the run.

    Raises
    ------
    FmuFailed
        From the constructor and all methods, if a unit fails.
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
        self._loop = Loop()
        self._forces = places("jo_work")["forces"]
        opened = []
        try:
            row = engine.row()[self.sensors : self.sensors + model.nout]
            stop = plan.start + plan.step * plan.steps
            for partner in self.partners:
                partner.process = FmuProcess(partner.model, partner.measured(row), stop)
                opened.append(partner)
                partner.known = [(0.0, partner.process.values, partner.measured(row))]
            self._put(0.0, 1)
            self._close_loops(0.0, 1, self.partners)
            for partner in self.partners:
                if partner.watched:
                    partner.rate = self._power_of(partner, partner.known[-1][1])
        except BaseException:
            for partner in opened:
                partner.process.close()
            raise

    @property
    def largest(self) -> int:
        """Largest number of steps of the model between two exchanges."""
        return max(partner.every for partner in self.partners)

    def ahead(self, done: int) -> int:
        """Return the number of steps to the next exchange, after `done` steps."""
        return min(partner.every - done % partner.every for partner in self.partners)

    def begin(self, row: Array) -> None:
        """Set the inputs of the units to the sensor values in the row of the initial state."""
        self._seen = self._values(row).copy()

    def extrapolate(self, step: float, lag: int) -> None:
        """Set the inputs of the model to the outputs extrapolated to the middle of its step."""
        if self.linear:
            self._put(float(self.engine.time[0]) + 0.5 * step, lag)

    def audit(self, rows: Array, step: float) -> None:
        """Add the energy that the model received in the steps that end with these rows."""
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
            self._seen = now.copy()  # copy, since the buffer of rows is overwritten

    def meet(self, done: int, lag: int = 1, *, all_of_them: bool = False) -> None:
        """Step the units that are due to the time of the model, then exchange values."""
        time = float(self.engine.time[0])
        due = [p for p in self.partners if all_of_them or done % p.every == 0]
        self._put(time, lag)
        used = [self._power_of(p, p.ahead(time, lag, 1)) if p.watched else 0.0 for p in due]
        for partner in due:
            partner.step(time, lag)
        self._put(time, lag)
        # evaluate the sensors again, since they may depend on outputs of another unit
        row = self.engine.row()
        for partner in due:
            partner.exchange(time, self._values(row))
        self._put(time, lag)
        self._close_loops(time, lag, due)
        for partner, power in zip(due, used, strict=True):
            self._watch(partner, power)
            partner.tally()
        self._put(time, lag)

    def save(self) -> None:
        """Save the states of all units."""
        time = float(self.engine.time[0])
        self._kept = [
            (list(p.known), p.account.copy(), p.told, p.extremes, p.error, p.rate,
             replace(p.growth))
            for p in self.partners
        ]  # fmt: skip
        self._seen_then = self._seen
        for partner in self.partners:
            partner.process.save(time)

    def restore(self) -> list[Array]:
        """Restore the saved states of all units; return the outputs before the restoration."""
        found = [partner.known[-1][1] for partner in self.partners]
        time = float(self.engine.time[0])
        self._seen = self._seen_then
        for partner, kept in zip(self.partners, self._kept, strict=True):
            known, account, told, extremes, error, rate, growth = kept
            partner.known, partner.account, partner.told = known, account, told
            partner.extremes, partner.error, partner.rate = extremes, error, rate
            partner.growth = growth
            partner.process.restore(time)
        return found

    def compare(self, coarse: list[Array]) -> None:
        """Set the error estimate of a step: two halves compared with one step of full length."""
        for partner, other in zip(self.partners, coarse, strict=True):
            share = 3.0 if partner.linear else 1.0  # 2^p - 1 of a method of order p
            partner.errors = np.abs(partner.known[-1][1] - other) / share
        self._put(float(self.engine.time[0]), 1)

    def again(self) -> None:
        """Set the inputs of the model to their values at the restored instant."""
        self._put(float(self.engine.time[0]), 1)

    def judge(self) -> None:
        """Warn of units whose exchange has a large energy error."""
        for partner in self.partners:
            if partner.misses:
                warn(partner.where, partner.misses)

    @property
    def suspects(self) -> str:
        """Return the units that probably caused the failure of a run, as a text; empty if none."""
        found = []
        for partner in self.partners:
            ratios = np.abs(partner.growth.ratios[-GROWING:])
            if len(ratios) == GROWING and (ratios > 1.0).all():
                what = f"its outputs grew by a factor of {ratios.mean():.3g} at each exchange"
                found.append(f"{partner.where}: {what}")
            elif partner.misses:
                found.append(f"{partner.where}: {partner.misses}")
        return "; ".join(found)

    def close(self) -> None:
        """Terminate all units."""
        for partner in self.partners:
            partner.process.close()

    # -- algebraic loops -----------------------------------------------------------------------

    def _close_loops(self, time: float, lag: int, due: list[Partner]) -> None:
        """Solve the algebraic loops: outputs of units and the sensors that depend on them.

        Raises
        ------
        FmuFailed
            If Newton's method finds no solution, or if the outputs of a unit that responds only
            after a step grow from exchange to exchange.
        """
        direct = [p for p in due if len(p.direct)]
        if not direct:
            return
        row = self._values(self.engine.row())
        if any(not np.array_equal(p.measured(row), p.known[-1][2]) for p in direct):

            def answer(y: Array) -> Array:
                for p, part in zip(direct, np.split(y, ends), strict=True):
                    t, outputs, given = p.known[-1]
                    outputs = outputs.copy()
                    outputs[p.direct] = part
                    p.known[-1] = (t, outputs, given)
                self._put(time, lag)
                values = self._values(self.engine.row())
                for p in direct:
                    p.exchange(time, values)
                return np.concatenate([p.known[-1][1][p.direct] for p in direct])

            ends = np.cumsum([len(p.direct) for p in direct])[:-1]
            try:
                self._loop.solve(np.concatenate([p.known[-1][1][p.direct] for p in direct]), answer)
            except LoopFailed:
                names = ", ".join(p.where for p in direct)
                raise FmuFailed(
                    f"{names} at {time:.6g} s: the algebraic loop with the machine, of gain "
                    f"{self._loop.gain:.3g}, has no solution that Newton's method finds; give the "
                    "unit positions and velocities instead of accelerations and reactions"
                ) from None
            self._put(time, lag)
        for p in direct:
            if len(p.known) > 1:
                p.growth.see(p.known[-2][1][p.direct], p.known[-1][1][p.direct])
                if p.growth.gain and self._answers(p):
                    raise FmuFailed(
                        f"{p.where} at {time:.6g} s: its outputs grow by a factor of "
                        f"{p.growth.gain:.3g} at each exchange, an algebraic loop with the machine "
                        "of that gain; the unit responds to new inputs only after a step, so that "
                        "the loop cannot be solved: give it positions and velocities instead of "
                        "accelerations and reactions, or model the loop in the machine"
                    )

    def _answers(self, partner: Partner) -> bool:
        """Return whether the inputs of a unit depend on its outputs at the same instant."""
        before = partner.measured(self._values(self.engine.row()))
        kept = self.engine.input.copy()
        for name in partner.model.set.values():
            self.engine.input[self._inputs[name]] *= 1.5
        after = partner.measured(self._values(self.engine.row()))
        self.engine.input[:] = kept
        return not np.array_equal(before, after)

    # -- energy without `power` ----------------------------------------------------------------

    def _power_of(self, partner: Partner, outputs: Array) -> float:
        """Return the power of given outputs of a unit in the current state of the model, W."""
        kept, found = self.engine.input.copy(), []
        for values in (outputs, np.zeros(len(outputs))):
            for k, name in enumerate(partner.model.fmu.outputs):
                if name in partner.model.set:
                    self.engine.input[self._inputs[partner.model.set[name]]] = values[k]
            self.engine.row()
            found.append(float(self.engine.power[self._forces].item()))
        self.engine.input[:] = kept
        return found[0] - found[1]

    def _watch(self, partner: Partner, used: float) -> None:
        """Add a step to the energy balance; `used` is the end power by extrapolated outputs, W."""
        if partner.watched:
            now = self._power_of(partner, partner.known[-1][1])
            length = partner.known[-1][0] - partner.known[-2][0]
            partner.account += 0.5 * length * (np.array([now, used]) + partner.rate)
            partner.rate = now

    def _values(self, row: Array) -> Array:
        return row[self.sensors : self.sensors + self.engine.model.nout]

    def _put(self, time: float, lag: int) -> None:
        """Set the inputs of the model and the columns of the units in the results."""
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
