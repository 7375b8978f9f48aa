"""Simulator: a model that is stepped from outside, with a controller in the loop."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.described import described
from jousto.base.errors import InputError, Problem, Problems, SimulationError, suggest
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.model.packing.foreign import without_fmus
from jousto.simulation.results.events import Chronicle, Happening, happenings, joints_of, sources
from jousto.simulation.solvers.explicit import ROS2, SOLVERS, Solver, prepared
from jousto.simulation.state import State, put, take


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
    """

    def __init__(
        self, model: Model, solver: Solver | None = None, *, state: State | None = None
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
        problems.raise_if_any()
        without_fmus(model, "Simulator", "steps in simulate alone")
        self.model = model
        self.events: tuple[Happening, ...] = ()
        self.stopped = ""
        self._engine = Engine(model)
        if state is not None:
            put(self._engine, state, "Simulator")
        self._native = prepared(self._engine, chosen, chosen.step)
        self._rows = np.zeros((1, self._engine.row_size))
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
        while engine.steps_done < goal:
            left = goal - engine.steps_done
            status, _ = engine.run(self._native, left, 1 << 62, self._rows)
            names = sources(self.model)
            self.events += happenings(
                self._chronicle.read(), names, len(self.model.events), joints_of(self.model)
            )
            if status == "event":
                self.stopped = self.model.events[engine.error_index].name
                return
            if status != "ok":
                problem = engine.problem(status)
                raise SimulationError(
                    f"the simulator stopped at {self.time:.6g} s: {problem}", time=self.time
                )

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
