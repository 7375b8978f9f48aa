"""LiveMachine: a model that is stepped while its inputs change, reproducibly.

Inputs change only at the instants of the rows. Therefore the rows contain all inputs, and the same
inputs give identical rows, bit for bit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, SimulationError, suggest
from jousto.base.object_repr import described
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.model.packing.foreign import without_fmus
from jousto.simulation.live.drag_spring import (
    BODY,
    NAMES,
    TARGET,
    Grip,
    grip_at,
    point_position,
    with_grip,
    with_hand,
)
from jousto.simulation.live.real_time_clock import Pace
from jousto.simulation.results.events import Chronicle
from jousto.simulation.running.simulate import failure_ending
from jousto.simulation.running.start_state import initial_state
from jousto.simulation.solvers.base import Solver, prepared
from jousto.simulation.solvers.bounded_work import check_bounded
from jousto.simulation.solvers.default_solver import choose
from jousto.simulation.solvers.schedule import Schedule
from jousto.simulation.state import State, put, take

INTERVAL = 0.01  # default time between rows, s


@explained
@described
class LiveMachine:
    """Model that is stepped while a user changes its inputs and drags its bodies.

    Parameters
    ----------
    model : Model
        From `compile`.
    solver : Solver, optional
        Method with a fixed step; None chooses as `simulate` does.
    step : float, optional
        Step of the method, s; None: that of the solver.
    interval : float, optional
        Time between rows, at which inputs change, s; a multiple of the step. None is about 10 ms.
    state : State, optional
        Initial state, also of `reset`; None: that of the model.

    Attributes
    ----------
    model : Model
        The model with the drag spring.
    every : int
        Number of steps between rows.
    stopped : str
        Name of the event at which the last steps ended; empty if there was none.

    Raises
    ------
    InputError
        If the method has an adaptive step, or the model has FMUs.
    """

    def __init__(
        self,
        model: Model,
        solver: Solver | None = None,
        *,
        step: float | None = None,
        interval: float | None = None,
        state: State | None = None,
    ) -> None:
        without_fmus(model, "live", "does not step in a live machine")
        chosen: Any = choose(model, 1.0, None)[0] if solver is None else solver
        if chosen.adaptive:
            name = type(chosen).__name__
            raise InputError(
                Problem("live", f"{name} chooses its steps itself; use a method with a fixed step")
            )
        check_bounded(model, chosen)
        self.solver: Any = chosen if step is None else replace(chosen, step=step)
        self.step_size = float(self.solver.step)
        self.every = max(1, round((interval or INTERVAL) / self.step_size))
        self.model = with_hand(model)
        self.stopped = ""
        self._start = initial_state(model, state)
        self.reset()

    # -- state ---------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return float(self.engine.time[0])

    @property
    def between(self) -> bool:
        """Whether the current instant is between two rows."""
        return self.engine.steps_done % self.every != 0

    @property
    def interval(self) -> float:
        """Time between rows, s."""
        return self.every * self.step_size

    @property
    def inputs(self) -> dict[str, float]:
        """Values of the inputs from the next row on, by name."""
        return dict(self._wanted)

    def state(self) -> State:
        """Return the current state."""
        return take(self.engine)

    # -- inputs --------------------------------------------------------------------------------

    def set(self, name: str, value: float) -> None:
        """Set an input from the next row on.

        Raises
        ------
        InputError
            If there is no input of this name, or the value is not finite.
        """
        if name not in self._wanted:
            known = [known for known in self._wanted if known not in NAMES]
            raise InputError(Problem("live", f"no input {name!r}{suggest(name, known)}"))
        number = float(value)
        if not np.isfinite(number):
            raise InputError(Problem(f"input {name!r}", f"is {value!r}, must be finite"))
        self._wanted[name] = number

    def pull(
        self, body: int, point: Array, target: ArrayLike | None = None, *, speed: float = 1.0
    ) -> Grip:
        """Attach the drag spring to a point of a body, from the next row on; return the grip.

        The point is undeformed in the body frame, m; the target is in the world frame, m, by
        default the current position of the point.
        """
        state = self.state()
        grip = grip_at(self.model, state, body, np.asarray(point), step=self.step_size, speed=speed)
        self._wanted.update(grip.inputs)
        self.aim(
            point_position(self.model, state.q, body, np.asarray(point))
            if target is None
            else target
        )
        return grip

    def aim(self, target: ArrayLike) -> None:
        """Move the target of the drag spring, m, world frame."""
        for name, value in zip(TARGET, np.asarray(target).tolist(), strict=True):
            self.set(name, value)

    def release(self) -> None:
        """Detach the drag spring from the next row on."""
        self._wanted[BODY] = -1.0

    # -- running -------------------------------------------------------------------------------

    def reset(self) -> None:
        """Reset to the initial state; inputs keep their values, the drag spring is detached."""
        kept = getattr(self, "_wanted", {})
        self._begin(self._start, {**kept, BODY: -1.0})

    def restart(self) -> None:
        """Restart the integration at the current state, so that a record can be repeated."""
        self._begin(self.state(), self._wanted)

    def carry(self, state: State, inputs: Mapping[str, float]) -> None:
        """Continue from a state of a similar machine; gaps at joints are closed.

        Raises
        ------
        InputError
            If the state does not fit the model.
        """
        self._begin(replace(state, inputs=None), inputs, close=True)

    def step(self, count: int = 1, pace: Pace | None = None) -> Array:
        """Advance by `count` steps, or to an event that stops; return the rows (k, row_size).

        With a pace the engine waits for the due time of each step, while other threads run.

        Raises
        ------
        SimulationError
            If the motion diverges or the engine cannot continue; `reset` is possible.
        """
        engine, rows = self.engine, []
        self.stopped = ""
        goal = engine.steps_done + count
        while engine.steps_done < goal:
            if not self.between:
                self._take_over()
                engine = self.engine
            left = min(goal - engine.steps_done, self.every - engine.steps_done % self.every)
            if pace is None:
                status, written = engine.run(self._native, left, self.every, self._rows)
            else:
                status, written, found = engine.paced(
                    self._native, left, self.every, self._rows, pace.given()
                )
                pace.took(found)
            self.happened.append(self._chronicle.read())
            if self.model.touches:
                self.touched.append(engine.touched())
            if written:
                self.row = self._rows[written - 1].copy()
                rows.append(self.row)
            if status == "event":
                self.stopped = self.model.events[engine.error_index].name
                break
            if status != "ok":
                plan = Schedule(self.step_size, 1, self.every)
                ending = failure_ending(self.model, self.solver, plan, engine, status)
                raise SimulationError(
                    f"the machine stopped at {self.time:.6g} s: {ending.sentence}",
                    time=self.time,
                    body=ending.body,
                )
        return np.array(rows).reshape(len(rows), engine.row_size)

    def events(self) -> Array:
        """Return time, source, change and count (k, 4) of the events since the last call."""
        found = np.vstack([np.zeros((0, 4)), *self.happened])
        self.happened.clear()
        return found

    def contacts(self) -> list[tuple[Array, int]]:
        """Return contacts (k, 14) that parted since the last call, with the number dropped."""
        found = [some for some in self.touched if len(some[0])]
        self.touched.clear()
        return found

    def _before(self, time: float) -> int:
        return Schedule(self.step_size, 1, self.every, time).before

    def _begin(
        self, state: State | None, inputs: Mapping[str, float], *, close: bool = False
    ) -> None:
        """Set a new engine to a state with given inputs, as `simulate` starts a run."""
        grip = Grip.of(inputs) if BODY in inputs else None
        engine = Engine(with_grip(self.model, grip))
        if state is not None:
            put(engine, state, "live")
            engine.steps_done = self._before(state.time)
        known = dict(zip(self.model.inputs, map(float, engine.input), strict=True))
        self._wanted = {**known, **{name: inputs[name] for name in known if name in inputs}}
        if grip is None:
            self._wanted[BODY] = -1.0
        self._held = dict(self._wanted)
        engine.input[:] = list(self._held.values())
        if close:
            engine.assemble()
            engine.restart()
        self._chronicle = Chronicle(engine)
        self.happened: list[Array] = []
        self.touched: list[tuple[Array, int]] = []
        self._rows = np.zeros((2, engine.row_size))
        self.stopped = ""
        self._use(engine)
        self.row = np.array(engine.row())

    def _use(self, engine: Engine) -> None:
        self.engine = engine
        self._native = prepared(engine, self.solver, self.step_size)
        self._chronicle.follow(engine)

    def _take_over(self) -> None:
        """Set the requested inputs in the engine; a new grip needs a new model and engine."""
        if Grip.of(self._wanted) != Grip.of(self._held):
            old = self.engine
            engine = Engine(with_grip(self.model, Grip.of(self._wanted)))
            put(engine, take(old), "live")
            engine.steps_done = old.steps_done
            engine.counts[0] = old.counts[0]
            self._use(engine)
        self._held = dict(self._wanted)
        self.engine.input[:] = list(self._held.values())
