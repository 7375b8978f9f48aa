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
from jousto.simulation.running.start_state import beginning
from jousto.simulation.solvers.explicit import ROS2, SOLVERS, Solver, prepared
from jousto.simulation.state import State, put, take

ROWS = 256  # of a results file that are computed in one call
LONGEST = 10_000_000  # rows of a results file


@explained
@described
class Simulator:
    """A model that is stepped from outside: set inputs, step, read sensors.

    For controllers, tests with hardware and optimisation, where what comes next depends on what
    was measured. Runs of known length belong to `simulate`, which is faster and writes a file.

    Parameters
    ----------
    model : Model
        From `compile`.
    solver : Solver, optional
        Method with a fixed step; None is ``ROS2(step=1e-3)``.
    state : State, optional
        Where to start; None is the initial state of the model.
    path : path, optional
        Results file (HDF5), overwritten when the first rows are written: everything that happens
        from the first `step` on, up to `close`. None keeps nothing.
    every : int
        Steps between two rows of it.

    Attributes
    ----------
    model : Model
        The model.
    events : tuple of Happening
        What happened so far.
    stopped : str
        Name of the event that stopped the simulator, empty while none did; it steps on from there
        if asked to.

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

    ``Simulator(model, path="run.h5")`` keeps its results, which ``close()`` returns.
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
        if not isinstance(chosen, SOLVERS):
            known = ", ".join(s.__name__ for s in SOLVERS)
            problems.add("Simulator", f"solver is {solver!r}, must be one of {known}")
        elif chosen.adaptive:
            problems.add(
                "Simulator",
                f"{type(chosen).__name__} chooses its steps itself; take a method of fixed step",
            )
        count: Any = every
        if not isinstance(count, int) or isinstance(count, bool) or count < 1:
            problems.add("Simulator", f"every is {every!r}, must be a whole number from 1 on")
        problems.raise_if_any()
        without_fmus(model, "Simulator", "steps in simulate alone")
        warn_loads(model)
        self.model = model
        self.events: tuple[Happening, ...] = ()
        self.stopped = ""
        self._engine = Engine(model)
        if (begun := beginning(model, state)) is not None:
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

    def set(self, name: str, value: float) -> None:
        """Set an external input; it is held until it is set again.

        Raises
        ------
        InputError
            If there is no such input or the value is no finite number.
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
        """Advance by `count` steps, or to an event that stops.

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
        """End the results file and return its results; None without a `path`.

        Parameters
        ----------
        ended : str
            What the file says of its end.
        complete : bool
            Whether it says that the results are whole.
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
        """Return the value (k,) of a sensor now.

        Raises
        ------
        InputError
            If there is no such sensor.
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
        """Return all that is needed to continue from here, with `simulate` or another simulator."""
        self._engine.row()
        return take(self._engine)


class _Record:
    """The results file of a simulator.

    Its length is not known before, so that it is laid out for the steps that have room on half of
    the free disk, up to 1e7 rows (no space is taken by what is not written), and cut at the end.
    """

    def __init__(self, path: Path, engine: Engine, solver: Any, every: int) -> None:
        self.path, self.every, self._engine, self._begun = path, every, engine, False
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
        weakref.finalize(self, self._keeper.discard)  # a file without rows, if nobody closes it
        self._written, self._started = 0, clock.perf_counter()

    def begin(self) -> None:
        """Write the state before the first step, with the inputs as they are now."""
        if not self._begun:
            self._begun = True
            self.add(self._engine.row()[None], np.zeros((0, 4)))

    def add(self, rows: NDArray[np.float64], happened: NDArray[np.float64]) -> None:
        """Write rows (k, row_size) and events (k, 4).

        Raises
        ------
        SimulationError
            If they cannot be written.
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
        except OSError as error:
            raise SimulationError(f"cannot write {self.path}: {error}", time=time) from error
        self._written += len(rows)

    def close(self, ended: str, complete: bool) -> Solution:
        """Return the results."""
        wall = clock.perf_counter() - self._started
        facts = {"ended": ended, "wall_time": wall, "real_time_factor": float("nan")}
        return self._keeper.close(complete, facts)
