"""Simulation settings of a model file."""

from __future__ import annotations

from typing import Any

from jousto.base.declare import Declared
from jousto.base.fields import Choice, Nested, field
from jousto.base.numbers import Duration, OptionalDuration
from jousto.mechanism.items_by_kind import CORES, STARTS


class SolverField(Nested[Any, Any]):
    """A solver; `simulate` checks it."""

    section = "solvers"
    room = "jousto.simulation.solvers"
    noun = "Solver"


class Simulation(Declared):
    """Arguments of `simulate`, and options of `compile`."""

    t_end: Duration = field("End time")
    solver: SolverField = field("Integration method; by default that of `simulate`", default=None)
    output_step: OptionalDuration = field(
        "Time between stored instants; by default that of `simulate`", default=None
    )
    start: Choice = field(
        "Initial state: the initial pose, the equilibrium near it (`equilibrium`), or elastic "
        "bodies with their quasi-static shape (`vibration_free_state`)",
        words=STARTS,
        default="initial",
    )

    core: Choice = field(
        "Coordinates of the solver: joint coordinates (`joint`), positions of all bodies "
        "(`maximal`), or the faster choice (`auto`)",
        words=CORES,
        default="auto",
    )

    @property
    def begin(self) -> Any:
        """Function of a model that returns the initial state of runs; None for the initial pose."""
        return None if self.start == "initial" else self._state

    def _state(self, model: Any) -> Any:
        return self.given(model).get("state")

    def given(self, model: Any = None) -> dict[str, Any]:
        """Return the keyword arguments of `simulate` in the file, except `t_end`.

        With a compiled model, the arguments include the initial state of the run.
        """
        values = {"solver": self.solver, "output_step": self.output_step}
        if model is not None:
            from jousto.simulation.running.start_state import initial_state

            values["state"] = initial_state(model, start=self.start)
        return {key: value for key, value in values.items() if value is not None}
