"""The same model run many times: what `simulate` prepares and says once is not done again."""

from __future__ import annotations

import time as clock
import uuid
from typing import Any

import numpy as np

from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.simulation.results.columns import columns
from jousto.simulation.results.events import Chronicle
from jousto.simulation.results.memory import IN_MEMORY, MemoryRecords
from jousto.simulation.results.solution import Solution
from jousto.simulation.running.simulate import simulate
from jousto.simulation.running.state import State, put
from jousto.simulation.running.watch import Contradiction, RunWatch
from jousto.simulation.solvers.choice import choose
from jousto.simulation.solvers.explicit import prepared
from jousto.simulation.solvers.schedule import schedule


class Repeated:
    """Runs of one model with other values of its external inputs.

    Results are those of `simulate` to the last bit. Runs of a fixed step go through the engine in
    one call; all others, and those that an event ends or that fail, are left to `simulate`.

    Parameters
    ----------
    model : Model
        From `compile`.
    t_end : float
        End of the runs, s.
    **how
        Arguments of `simulate`: solver, output_step, state.
    """

    def __init__(self, model: Model, t_end: float, **how: Any) -> None:
        self.model = model
        self.t_end = float(t_end)
        self.how = {key: value for key, value in how.items() if value is not None}
        self._state: State | None = self.how.get("state")
        start = 0.0 if self._state is None else self._state.time
        solver, output = self.how.get("solver"), self.how.get("output_step")
        reason = ""
        if solver is None:
            solver, reason = choose(model, t_end, output, start)
        self._solver = solver
        self._plan = plan = schedule(model, t_end, solver, output, start)
        self._rows = plan.steps // plan.every + 1
        last = columns(model)[-1]
        self._width = last.first + last.count
        self._plain = not solver.adaptive and 8 * self._rows * self._width <= IN_MEMORY
        self._about = {
            "solver": repr(solver),
            "chosen": reason,
            "step": plan.step,
            "t_end": self.t_end,
            "gravity": model.gravity,
            "evaluations_per_step": solver.evaluations,
        }

    def run(self, inputs: dict[str, float] | None = None) -> Solution:
        """Return the results of a run, as `simulate` does.

        Raises
        ------
        RunFailed
            If it cannot go on.
        """
        if self._plain:
            found = self._in_one_call(inputs or {})
            if found is not None:
                return found
        return simulate(self.model, self.t_end, inputs=inputs or None, **self.how)

    def _in_one_call(self, inputs: dict[str, float]) -> Solution | None:
        """Return the results; None if something happened that `simulate` knows more of."""
        plan, solver = self._plan, self._solver
        engine = Engine(self.model)
        if self._state is not None:
            put(engine, self._state, "simulate")
            engine.steps_done = plan.before
        for name, value in inputs.items():
            engine.input[self.model.inputs.index(name)] = value
        native = prepared(engine, solver, plan.step)
        rows = np.empty((self._rows, self._width))
        rows[0] = engine.row()
        chronicle = Chronicle(engine)
        first, started = engine.steps_done, clock.perf_counter()
        status, written = engine.run(native, plan.steps, plan.every, rows[1:])
        wall = clock.perf_counter() - started
        if status != "ok" or engine.steps_done - first < plan.steps or written < self._rows - 1:
            return None
        watch = RunWatch(self.model, projected=solver.projection)
        try:
            watch.see(rows)
        except Contradiction:
            return None
        watch.judge()
        factor = (float(engine.time[0].real) - plan.start) / wall if wall > 0 else 0.0
        facts = {"ended": "completed", "wall_time": wall, "real_time_factor": factor, "complete": 1}
        about = {**self._about, "run": uuid.uuid4().hex}
        return Solution(MemoryRecords(self.model, rows, chronicle.read(), facts, about, ""))
