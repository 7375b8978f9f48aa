"""Simulator: a model that is stepped from outside, with a controller in the loop."""

from __future__ import annotations

import time as clock
import weakref
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem, Problems, SimulationError, suggest
from jousto.base.object_repr import described
from jousto.certificate.load_warnings import warn_loads
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.model.packing.foreign import without_fmus
from jousto.simulation.results.events import Chronicle, Happening, happenings, joints_of, sources
from jousto.simulation.results.memory import Keeper
from jousto.simulation.results.solution import Solution
from jousto.simulation.results.writer import free_bytes
from jousto.simulation.running.start_state import initial_state
from jousto.simulation.solvers.base import Solver, known, prepared
from jousto.simulation.solvers.bounded_work import check_bounded
from jousto.simulation.solvers.rosenbrock import ROS2
from jousto.simulation.state import State, put, take

ROWS = 256  # rows of a results file per call of the engine
LONGEST = 10_000_000  # maximum number of rows of a results file


@explained
@described
class Simulator:
    """A model that is stepped from outside: set inputs, step, read sensors.

    Use it for controllers, tests with hardware and optimisation, where the next input depends on
    measured values. `simulate` is faster for runs of known length.

    Parameters
    ----------
    model : Model
        From `compile`.
    solver : Solver, optional
        Method with a fixed step; None is ``ROS2(step=1e-3)``.
    state : State, optional
        Initial state; None: the initial state of the model.
    path : path, optional
        Results file (HDF5) with all rows and events from the first `step` to `close`. An existing
        file is overwritten when the first rows are written. None writes no file.
    every : int
        Steps between two rows of the file.

    Attributes
    ----------
    model : Model
        The model.
    events : tuple of Happening
        Events of the run so far.
    stopped : str
        Name of the event that stopped the simulator, empty if there is none; a further `step`
        continues from the event.

    Examples
    --------
    >>> import jousto as jo
    >>> cart = jo.RigidBody("cart", 2.0, (1, 1, 1))
    >>> rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    >>> push = jo.JointForce("push", rail.displacement, jo.Input("force"))
    >>> place = jo.CoordinateSensor("place", rail.displacement)
    >>> sim = Simulator(jo.compile(jo.Mechanism(cart, rail, push, place)), jo.RK4(step=0.01))
    >>> while sim.time < 1.0 - 1e-9:
    ...     sim.set("force", 8.0 * (0.25 - sim.read("place")[0]))
    ...     sim.step()
    >>> round(float(sim.read("place")[0]), 2)
    0.36

    ``Simulator(model, path="run.h5")`` writes its results into a file; ``close()`` returns them.
    """

    def __init__(
        self,
        model: Model,
        solver: Solver | None = None,
        *,
        state: State | None = None,
        path: str | Path | None = None,
        every: int = 1,
    ) -> None:
        chosen: Any = ROS2() if solver is None else solver
        given: Any = model
        problems = Problems()
        if not isinstance(given, Model):
            problems.add("Simulator", f"model is a {type(model).__name__}, must be a Model")
        if not isinstance(chosen, Solver):
            problems.add("Simulator", f"solver is {solver!r}, must be one of {known()}")
        elif chosen.adaptive:
            problems.add(
                "Simulator",
                f"{type(chosen).__name__} chooses its steps itself; use a method with a fixed step",
            )
        count: Any = every
        if not isinstance(count, int) or isinstance(count, bool) or count < 1:
            problems.add("Simulator", f"every is {every!r}, must be a whole number from 1 on")
        problems.raise_if_any()
        without_fmus(model, "Simulator", "steps in simulate alone")
        check_bounded(model, chosen)
        warn_loads(model)
        self.model = model
        self.events: tuple[Happening, ...] = ()
        self.stopped = ""
        self._engine = Engine(model)
        if (begun := initial_state(model, state)) is not None:
            put(self._engine, begun, "Simulator")
        self._native = prepared(self._engine, chosen, chosen.step)
        self._record = None if path is None else _Record(Path(path), self._engine, chosen, every)
        rows = 1 if self._record is None else ROWS
        self._rows = np.zeros((rows, self._engine.row_size))
        self._chronicle = Chronicle(self._engine)
        self._known: NDArray[np.float64] | None = None
        self._sensors = {sensor.name: sensor for sensor in model.sensors}

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return float(self._engine.time[0])

    @property
    def deferred(self) -> int:
        """Steps so far that left a change of friction or an event to the next step.

        Only solvers with ``events="step"`` defer changes, when their passes are used up.
        """
        return int(self._engine.counts.deferred)

    def set(self, name: str, value: float) -> None:
        """Set an external input to a value that remains until the next `set` of this input.

        Raises
        ------
        InputError
            If there is no input of this name or the value is not finite.
        """
        inputs = self.model.inputs
        if name not in inputs:
            raise InputError(Problem("Simulator", f"no input {name!r}{suggest(name, inputs)}"))
        number = float(value)
        if not np.isfinite(number):
            raise InputError(Problem(f"input {name!r}", f"is {value!r}, must be finite"))
        self._engine.input[inputs.index(name)] = number
        self._known = None

    def step(self, count: int = 1) -> None:
        """Advance by `count` steps, or up to the first event with ``stop=True``.

        Raises
        ------
        SimulationError
            If the motion diverges or the engine cannot continue.
        """
        engine = self._engine
        self.stopped = ""
        self._known = None
        goal = engine.steps_done + count
        record = self._record
        every = 1 << 62 if record is None else record.every
        if record is not None:
            record.begin()
        while engine.steps_done < goal:
            left = goal - engine.steps_done
            if record is not None:
                left = min(left, (ROWS - 1) * every)
            status, written = engine.run(self._native, left, every, self._rows)
            happened = self._chronicle.read()
            if record is not None:
                record.add(self._rows[:written], happened)
            names = sources(self.model)
            self.events += happenings(
                happened, names, len(self.model.events), joints_of(self.model)
            )
            if status == "event":
                self.stopped = self.model.events[engine.error_index].name
                return
            if status != "ok":
                problem = engine.problem(status)
                self.close(f"failed: {problem}", complete=False)
                raise SimulationError(
                    f"the simulator stopped at {self.time:.6g} s: {problem}", time=self.time
                )

    def close(self, ended: str = "completed", *, complete: bool = True) -> Solution | None:
        """Close the results file and return its results; None without a `path`.

        Parameters
        ----------
        ended : str
            Text of the attribute `ended` of the results.
        complete : bool
            Whether the attribute `complete` of the results is true.
        """
        if self._record is None:
            return None
        record, self._record = self._record, None
        return record.close(ended, complete)

    def __enter__(self) -> Simulator:
        return self

    def __exit__(self, *error: object) -> None:
        if error[0] is None:
            self.close()
        else:
            self.close("failed: an error of the caller", complete=False)

    def read(self, name: str) -> NDArray[np.float64]:
        """Return the components (k,) of a sensor at the current time.

        Raises
        ------
        InputError
            If there is no sensor of this name.
        """
        if name not in self._sensors:
            tail = suggest(name, self._sensors)
            raise InputError(Problem("Simulator", f"no sensor {name!r}{tail}"))
        if self._known is None:
            self._engine.row()
            self._known = np.array(self._engine.sensors())
        sensor = self._sensors[name]
        return self._known[sensor.offset : sensor.offset + sensor.count]

    def state(self) -> State:
        """Return the current state, from which `simulate` or another simulator can continue."""
        self._engine.row()
        return take(self._engine)


class _Record:
    """Results file of a simulator.

    The number of rows is unknown at the start: the file is laid out for as many rows as fit into
    half of the free disk space, at most 1e7, and cut to the written rows at the end. Rows that are
    not written take no disk space.
    """

    def __init__(self, path: Path, engine: Engine, solver: Any, every: int) -> None:
        self.path, self.every, self._engine, self._begun = path, every, engine, False
        self._bounded = solver.bounded
        self._room = max(2, min(LONGEST, int(0.5 * free_bytes(path) / (8 * engine.row_size))))
        about = {
            "solver": repr(solver),
            "chosen": "",
            "step": float(solver.step),
            "t_end": float(engine.time[0]) + self._room * every * float(solver.step),
            "gravity": engine.model.gravity,
            "evaluations_per_step": solver.evaluations,
        }
        self._keeper = Keeper(path, engine.model, self._room, about)
        weakref.finalize(
            self, self._keeper.discard
        )  # removes a file without rows if `close` is never called
        self._written, self._started = 0, clock.perf_counter()

    def begin(self) -> None:
        """Write the row of the state before the first step, with the current inputs."""
        if not self._begun:
            self._begun = True
            self.add(self._engine.row()[None], np.zeros((0, 4)))

    def add(self, rows: NDArray[np.float64], happened: NDArray[np.float64]) -> None:
        """Append rows (k, row_size) of the engine and events (k, 4) to the file.

        Raises
        ------
        SimulationError
            If the file cannot be written or has no room for more rows.
        """
        time = float(self._engine.time[0])
        if self._written + len(rows) > self._room:
            message = (
                f"{self.path} has no room for more than {self._room} rows; a larger every fits"
            )
            raise SimulationError(message, time=time)
        try:
            self._keeper.append(rows)
            self._keeper.note(happened)
            if self._engine.model.touches:
                self._keeper.touch(*self._engine.touched())
        except OSError as error:
            raise SimulationError(f"cannot write {self.path}: {error}", time=time) from error
        self._written += len(rows)

    def close(self, ended: str, complete: bool) -> Solution:
        """Close the file and return its results."""
        wall = clock.perf_counter() - self._started
        facts = {"ended": ended, "wall_time": wall, "real_time_factor": float("nan")}
        if self._bounded:
            facts["deferred"] = int(self._engine.counts.deferred)
        if self._engine.model.touches:
            self._keeper.touch(self._engine.touching())
        return self._keeper.close(complete, facts)
