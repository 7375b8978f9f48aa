"""Sources of running machines: model file with parameters, mechanism, compiled model."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from jousto.base.errors import InputError, Problem, suggest
from jousto.design.studies.parameters.parameter import Parameter
from jousto.mechanism.mechanism import Mechanism
from jousto.model.compile import compile
from jousto.model.model import Model
from jousto.simulation.live.machine import LiveMachine
from jousto.simulation.state import State


@dataclass(frozen=True, eq=False)
class OpenedMachine:
    """Machine ready to run.

    Attributes
    ----------
    model : Model
        The compiled machine.
    solver : Solver or None
        Method of its file; None: automatic.
    interval : float or None
        Time between rows, s, if the file has one.
    state : State or None
        Initial state.
    text : str
        Text of its file.
    parameters : tuple of Parameter
        Changeable parameters.
    values : dict
        Values of parameters that were changed, in SI.
    variants : Variants or None
        Source of the machine for other parameter values.
    kept : dict
        Reduced parts of all variants.
    """

    model: Model
    solver: Any = None
    interval: float | None = None
    state: State | None = None
    text: str = ""
    parameters: tuple[Parameter, ...] = ()
    values: dict[str, float] = field(default_factory=dict)
    variants: Any = None
    kept: dict[Any, Any] = field(default_factory=dict)

    rows: bool = False
    """Solver settings: rows and inputs at every step."""

    def machine(self, step: float | None) -> LiveMachine:
        """Return the machine at its start."""
        solver = None if self.solver is None or self.solver.adaptive else self.solver
        made = LiveMachine(self.model, solver, step=step, interval=self.interval, state=self.state)
        if not self.rows or made.every == 1:
            return made
        return LiveMachine(self.model, solver, step=step, interval=made.step_size, state=self.state)

    def changed(self, name: str, value: float) -> OpenedMachine:
        """Return the machine with a new value of a parameter.

        Raises
        ------
        InputError
            If there is no such parameter, or the machine is invalid with its value.
        """
        known = [parameter.name for parameter in self.parameters]
        if name not in known:
            raise InputError(Problem("live", f"no parameter {name!r}{suggest(name, known)}"))
        values = {**self.values, name: value}
        mechanism, settings, _ = self.variants.make(values, self.kept)
        return replace(self, values=values, **_compiled(mechanism, settings))


def open_machine(thing: Any, *, trust: bool = False) -> OpenedMachine:
    """Return the machine of a path, a mechanism or a model.

    Raises
    ------
    InputError
        If it is neither a path, a mechanism nor a model.
    """
    if isinstance(thing, str | Path):
        from jousto.schema.read import read_model

        file = read_model(thing, trust=trust)
        return OpenedMachine(
            **_compiled(file.mechanism, file.simulation),
            text=file.text,
            parameters=file.parameters,
            variants=file.variants,
        )
    if isinstance(thing, Mechanism):
        return OpenedMachine(compile(thing))
    if isinstance(thing, Model):
        return OpenedMachine(thing)
    message = f"is a {type(thing).__name__}, must be a Mechanism, a Model or a path"
    raise InputError(Problem("live", f"machine {message}"))


def _compiled(mechanism: Mechanism, settings: Any) -> dict[str, Any]:
    model = compile(mechanism)
    given = {} if settings is None else settings.given(model)
    return {
        "model": model,
        "solver": given.get("solver"),
        "interval": given.get("output_step"),
        "state": given.get("state"),
    }
