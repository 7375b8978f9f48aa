"""Sources of machines for a study: a function, a model file, or one model with inputs."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from jousto.base.arguments import DEEP
from jousto.base.errors import InputError, JoustoError, Problem, suggest
from jousto.design.studies.case import Counts, Machine, Models, Numbered, Settings
from jousto.design.studies.parameters.parameter import Parameter
from jousto.design.studies.running.content_hash import key_of
from jousto.mechanism.checks import input_names
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.numbers import has_number
from jousto.model.model import Model
from jousto.reduction.files.memory_cache import Recalled
from jousto.simulation.results.solution import Solution

MADE = "a Mechanism, a Model or a Solution"


class Memory:
    """Data shared by the machines of a study: reductions and other intermediate results.

    Attributes
    ----------
    reductions : Recalled
        Reduced parts by their content.
    counts : dict
        Numbers of reductions, compilations and runs.
    models : Models
        Compiled models.
    kept : dict
        Cached intermediate results of a source.
    """

    def __init__(self) -> None:
        self.reductions = Recalled()
        self.counts: Counts = {"compilations": 0, "runs": 0}
        self.models = Models(self.counts)
        self.kept: dict[Any, Any] = {}


class Source(Protocol):
    """Protocol of a source of machines."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters that the source defines."""

    @property
    def key(self) -> str:
        """Hash of the content of the source."""

    @property
    def unused(self) -> tuple[str, ...]:
        """Names of parameters without influence on the machines."""

    def takes(self, name: str) -> bool:
        """Return whether the machine depends on a parameter; otherwise it is an external input."""

    def machine(self, values: Mapping[str, float], memory: Memory) -> Machine:
        """Return the machine for parameter values."""


@dataclass(frozen=True, eq=False)
class FunctionSource:
    """Source: a function of the user that returns a machine.

    Parameters
    ----------
    function : callable
        Called with the values of parameters by name.
    settings : Settings
        Settings of the runs.
    """

    function: Callable[..., Any]
    settings: Settings
    parameters: tuple[Parameter, ...] = ()
    unused: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        """Hash of the function with its captured values."""
        return key_of(self.function)

    def takes(self, name: str) -> bool:
        """Return whether the function has an argument of that name."""
        try:
            known = inspect.signature(self.function).parameters
        except (TypeError, ValueError):
            return True
        return name in known or any(p.kind is p.VAR_KEYWORD for p in known.values())

    def machine(self, values: Mapping[str, float], memory: Memory) -> Machine:
        """Return the machine that the function returns."""
        try:
            made = self.function(**values)
        except DEEP as error:
            if isinstance(error, JoustoError):
                raise
            message = f"the function failed: {type(error).__name__}: {error}"
            raise InputError(Problem("study", message)) from error
        if not isinstance(made, Mechanism | Model | Solution):
            kind = type(made).__name__
            raise InputError(Problem("study", f"the function returned a {kind}, must be {MADE}"))
        return Machine(made, self.settings, (), memory.models)


@dataclass(frozen=True, eq=False)
class FixedSource:
    """Source: one machine with variable numbers and external inputs."""

    made: Mechanism | Model
    settings: Settings
    parameters: tuple[Parameter, ...] = ()
    unused: tuple[str, ...] = ()

    @property
    def key(self) -> str:
        """Hash of the content of the machine."""
        return key_of(self.made)

    def takes(self, name: str) -> bool:
        """Return whether a parameter is a number of the mechanism; otherwise it is an input."""
        if not isinstance(self.made, Mechanism):
            return False
        return name not in input_names(self.made) and has_number(self.made, name)

    def machine(self, values: Mapping[str, float], memory: Memory) -> Machine:
        """Return the machine with these numbers."""
        made: Any = self.made
        if values:
            made = Numbered(made, dict(values))
        return Machine(made, self.settings, (), memory.models)


@dataclass(frozen=True, eq=False)
class FileSource:
    """Source: a model file with parameters."""

    variants: Any
    settings: Settings

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the file."""
        found: tuple[Parameter, ...] = self.variants.parameters
        return found

    @property
    def unused(self) -> tuple[str, ...]:
        """Names of parameters that only limits depend on."""
        return tuple(self.variants.unused)

    @property
    def key(self) -> str:
        """Hash of the file's text, the files it names and the options of reading."""
        return str(self.variants.key)

    def takes(self, name: str) -> bool:
        """Return whether the file has a parameter of that name."""
        return any(parameter.name == name for parameter in self.parameters)

    def machine(self, values: Mapping[str, float], memory: Memory) -> Machine:
        """Return the machine of the file for parameter values."""
        mechanism, simulation, checks = self.variants.make(values, memory.kept)
        t_end, own = self.settings.t_end, {}
        if simulation is not None:
            t_end = simulation.t_end if t_end is None else t_end
            own = {"solver": simulation.solver, "output_step": simulation.output_step}
            own["state"] = simulation.begin
        how = {key: value for key, value in own.items() if value is not None}
        settings = Settings(t_end, how | dict(self.settings.how), self.settings.inputs)
        return Machine(mechanism, settings, checks, memory.models)


def source_of(model: Any, settings: Settings) -> Source:
    """Return the source for a function, a model file, a mechanism or a model.

    Raises
    ------
    InputError
        If `model` is not a source of machines.
    """
    variants = getattr(model, "variants", None)
    if variants is not None:
        return FileSource(variants, settings)
    if isinstance(model, Mechanism | Model):
        return FixedSource(model, settings)
    if callable(model):
        return FunctionSource(model, settings)
    message = (
        f"model is {model!r:.60}, must be a function that returns {MADE}, a model with inputs, or "
        "jo.read_model(path)"
    )
    raise InputError(Problem("study", message))


def choose_parameters(source: Source, given: Any) -> tuple[Parameter, ...]:
    """Return the varied parameters from objects or names; all of the source for None.

    Raises
    ------
    InputError
        With all problems of the parameters.
    """
    known = {parameter.name: parameter for parameter in source.parameters}
    if given is None:
        given = tuple(known)
    if isinstance(given, (str, Parameter)):
        given = (given,)
    found: list[Parameter] = []
    problems: list[Problem] = []
    for item in given:
        if isinstance(item, Parameter):
            own = known.get(item.name)
            if own is not None and own.exponents != item.exponents:
                message = f"is in {item.unit}, in the model file in {own.unit}"
                problems.append(Problem(f"parameter {item.name!r}", message))
            found.append(item)
        elif isinstance(item, str) and item in known:
            found.append(known[item])
        else:
            tail = suggest(str(item), known) if known else "; give jo.Parameter(name, value)"
            problems.append(Problem("study", f"no parameter {item!r}{tail}"))
    names = [parameter.name for parameter in found]
    for name in dict.fromkeys(names):
        if names.count(name) > 1:
            problems.append(Problem(f"parameter {name!r}", "given twice"))
    if not found and not problems:
        problems.append(Problem("study", "no parameters; give jo.Parameter(name, value)"))
    if problems:
        raise InputError(problems)
    return tuple(found)
