"""Repeated runs of one model: the preparation and the warnings of `simulate` are done once."""

from __future__ import annotations

import time as clock
import uuid
from collections.abc import Callable, Hashable
from functools import cached_property
from typing import Any

import numpy as np

from jousto.base.complexstep import plainly
from jousto.base.errors import NotAnalytic, warn
from jousto.model.model import Model
from jousto.model.native.ensemble import structure
from jousto.model.native.native import Engine
from jousto.model.packing.foreign import without_fmus
from jousto.model.start_complex_step import has_steps, plain_model
from jousto.simulation.check_openings import opening_facts
from jousto.simulation.results.contact_table import ContactTable
from jousto.simulation.results.events import Chronicle
from jousto.simulation.results.memory import IN_MEMORY, MemoryRecords
from jousto.simulation.results.row_layout import columns
from jousto.simulation.results.solution import Solution
from jousto.simulation.running.run_checks import Contradiction, RunWatch
from jousto.simulation.running.simulate import simulate
from jousto.simulation.running.start_state import initial_state
from jousto.simulation.solvers.base import prepared, solver_text
from jousto.simulation.solvers.bounded_work import check_bounded
from jousto.simulation.solvers.default_solver import choose
from jousto.simulation.solvers.implicit import Newton
from jousto.simulation.solvers.schedule import schedule
from jousto.simulation.state import State, put

Started = tuple[Engine, Any, Callable[[], None]]


class Repeated:
    """Repeated runs of one model with different values of its external inputs.

    The results equal those of `simulate` to the last bit. A run with a fixed step is one call of
    the engine. Runs with an adaptive step, runs that end at an event, and runs that fail are
    computed by `simulate`.

    Parameters
    ----------
    model : Model
        From `compile`.
    t_end : float
        End of the runs, s.
    smooth : bool
        Whether implicit methods iterate to a fixed, tight tolerance, so that the results change
        smoothly with the model and its inputs, as differences between runs need it.
    **how
        Arguments of `simulate`: solver, output_step, state.
    """

    def __init__(self, model: Model, t_end: float, *, smooth: bool = False, **how: Any) -> None:
        without_fmus(model, "study", "cannot be repeated with other values")
        # initial state, computed once for all runs, with the derivatives of the model
        how = how | {"state": initial_state(model, how.get("state"))}
        self.model = model
        self._smooth = smooth
        self._stepped = has_steps(model)
        with plainly():
            model = plain_model(model) if self._stepped else model
            self._prepare(model, t_end, how)

    def _prepare(self, model: Model, t_end: float, how: dict[str, Any]) -> None:
        self._plain_model = model
        self.t_end = float(t_end)
        self.how = {key: value for key, value in how.items() if value is not None}
        self._state: State | None = self.how.get("state")
        start = 0.0 if self._state is None else self._state.time
        solver, output = self.how.get("solver"), self.how.get("output_step")
        reason = ""
        if solver is None:
            solver, reason = choose(model, t_end, output, start)
        if self._smooth and isinstance(solver, Newton) and solver != (tight := solver.tight()):
            self.how["solver"] = solver = tight
        self._solver = solver
        self.plan = plan = schedule(model, t_end, solver, output, start)
        check_bounded(model, solver)
        self._rows = plan.steps // plan.every + 1
        last = columns(model)[-1]
        self._width = last.first + last.count
        self._idle: list[
            Started
        ] = []  # unused engines at t = 0; one thread uses an engine at a time
        self._plain = not solver.adaptive and 8 * self._rows * self._width <= IN_MEMORY
        self._about = {
            "solver": solver_text(solver),
            "chosen": reason,
            "step": plan.step,
            "t_end": self.t_end,
            "gravity": model.gravity,
            "evaluations_per_step": solver.evaluations,
        }

    def run(self, inputs: dict[str, float] | None = None) -> Solution:
        """Return the results of a run with these values of the inputs.

        Raises
        ------
        RunFailed
            If the run diverges or the engine cannot continue.
        """
        stepped = self._stepped or any(np.iscomplexobj(x) for x in (inputs or {}).values())
        if stepped:
            return self._stepped_run(inputs or {})
        if self._plain:
            found = self._in_one_call(inputs or {})
            if found is not None:
                return found
        return simulate(self.model, self.t_end, inputs=inputs or None, **self.how)

    def _stepped_run(self, inputs: dict[str, float]) -> Solution:
        """Return the results of a run with derivatives (complex steps), computed by this engine.

        Raises
        ------
        NotAnalytic
            If the run contains switching (adaptive steps, friction, yielding, events) or Python
            functions, does not fit into memory, or does not reach its end.
        """
        model = self._plain_model
        if self._solver.adaptive:
            raise NotAnalytic(f"{type(self._solver).__name__} chooses its steps")
        if any(friction.sticks for friction in model.frictions):
            raise NotAnalytic("friction sticks and slips")
        for force in model.forces:
            if force.law.yields:
                touches = force.kind.startswith("contact")
                may = "closes, opens, sticks and slips" if touches else "yields"
                raise NotAnalytic(
                    f"{force.element or force.kind} '{force.name}' {may}", noisy=touches
                )
        if any(force.function is not None for force in model.forces):
            raise NotAnalytic("a force is a function of Python")
        if not self._plain:
            raise NotAnalytic("the results do not fit into memory")
        found = self._in_one_call(inputs, stepped=True)
        if found is None:
            raise NotAnalytic("the run does not reach its end")
        if len(found.events):
            raise NotAnalytic("events")
        return found

    def _in_one_call(self, inputs: dict[str, float], stepped: bool = False) -> Solution | None:
        """Return the results of one call of the engine; None if `simulate` must repeat the run.

        `simulate` repeats a run that ended early or whose joints opened.
        """
        plan, started = self.plan, self.begin(inputs, stepped)
        engine, native, _ = started
        rows: Any = np.empty((self._rows, self._width), engine.dtype)
        rows[0] = engine.row()
        chronicle = Chronicle(engine)
        first, begin = engine.steps_done, clock.perf_counter()
        status, written = engine.run(native, plan.steps, plan.every, rows[1:])
        wall = clock.perf_counter() - begin
        if status != "ok" or engine.steps_done - first < plan.steps or written < self._rows - 1:
            return None
        return self.finish(started, rows, wall, chronicle)

    @cached_property
    def alike(self) -> Hashable:
        """Key that is equal for runs that can share vector lanes; None if this run cannot."""
        kind = ""
        if self._plain and not self._stepped and self._solver.lanes:
            kind = structure(self.model)
        return (kind, solver_text(self._solver), self.plan) if kind else None

    def begin(self, inputs: dict[str, float], stepped: bool = False) -> Started:
        """Return an engine at the initial state with these inputs, for `finish`."""
        started = self._idle.pop() if self._idle and not stepped else self._started(stepped)
        for name, value in inputs.items():
            started[0].input[self.model.inputs.index(name)] = value
        return started

    def finish(
        self, started: Started, rows: Any, wall: float, chronicle: Chronicle
    ) -> Solution | None:
        """Return the results of a completed run; None if redundant joints contradict each other.

        Parameters
        ----------
        started : tuple
            From `begin`.
        rows : (k, row_size) array
            Rows of the engine.
        wall : float
            Wall time of the run, s.
        chronicle : Chronicle
            Events of the run.
        """
        plan, (engine, _, rewind) = self.plan, started
        watch = RunWatch(self._plain_model, projected=self._solver.projection)
        try:
            watch.see(rows.real)
        except Contradiction:
            return None
        watch.judge()
        openings = opening_facts(engine, plan.step)
        if openings:
            warn(f"simulate {self._plain_model.name!r}", openings["openings"])
        factor = (float(rows[-1, 0].real) - plan.start) / wall if wall > 0 else 0.0
        facts = {"ended": "completed", "wall_time": wall, "real_time_factor": factor, "complete": 1}
        facts |= openings
        about = {**self._about, "run": uuid.uuid4().hex}
        touched = ContactTable()
        if self.model.touches:
            touched.add(*engine.touched())
            touched.add(engine.touching())
        found = MemoryRecords(self.model, rows, chronicle.read(), facts, about, "", touched)
        rewind()
        if engine.dtype == np.float64:
            self._idle.append(started)
        return Solution(found)

    def _started(self, stepped: bool = False) -> Started:
        """Return an engine at the initial state, its stepper and the function that resets it."""
        engine = Engine(self.model, complex_scalars=stepped)
        if self._state is not None:
            put(engine, self._state, "simulate")
            engine.steps_done = self.plan.before
        return engine, prepared(engine, self._solver, self.plan.step), engine.mark()
