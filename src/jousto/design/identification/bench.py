"""Benches: machines with a measurement each, whose results are computed at any point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, Self

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problems
from jousto.design.identification.experiment import Comparison
from jousto.design.studies.case import Settings
from jousto.design.studies.parameters.parameter import Parameter
from jousto.design.studies.running.evaluator import Evaluator
from jousto.design.studies.running.sources import Memory, Source, source_of
from jousto.model.model import Model


class Bench(Protocol):
    """A machine with a measurement."""

    @property
    def name(self) -> str:
        """Name for tables and messages."""

    @property
    def evaluator(self) -> Evaluator:
        """Machines of the measurement."""

    @property
    def places(self) -> Array:
        """Places (k,) of the machine's parameters among all unknowns."""

    @property
    def t_end(self) -> float | None:
        """End of the runs, s; None if nothing is compared over time."""

    @property
    def solver(self) -> Any:
        """Method of the runs; None if it is not chosen yet, or there is nothing to choose."""

    @property
    def steps(self) -> tuple[float, float]:
        """Steps of one-sided and of central differences, relative to the size of an unknown."""

    @property
    def scales(self) -> int:
        """Number of scales that are fitted beside the unknowns, each to one comparison."""

    def results(self, points: Sequence[Array]) -> list[Any]:
        """Return the results at points (np,) of all unknowns, or the error of each."""

    def compare(self, problems: Problems, result: Any) -> tuple[Comparison, ...]:
        """Return what is compared, from the result at the start values, and report problems."""

    def show(self, result: Any, comparison: Comparison, shift: float) -> tuple[Array, Array]:
        """Return the computed values (n,) of a comparison, and their rates."""

    def with_solver(self, solver: Any) -> Bench:
        """Return the bench with another method or step."""

    def until(self, share: float) -> Bench:
        """Return the bench whose runs end at a share of the time."""


@dataclass(frozen=True, eq=False)
class StillBench:
    """Base of benches that compare nothing over time; see `Bench`.

    Parameters
    ----------
    experiment : Values or Modal
    evaluator : Evaluator
        Machines of the experiment.
    places : (k,) array of int
        Places of the machine's parameters among all unknowns.
    """

    experiment: Any
    evaluator: Evaluator
    places: Array
    t_end: float | None = None
    solver: Any = None

    @property
    def name(self) -> str:
        """Name for tables and messages."""
        return str(self.experiment.name)

    @property
    def steps(self) -> tuple[float, float]:
        """Steps of differences: eigenvalues and positions of rest are found by iterations."""
        return 1e-5, 1e-4

    @property
    def scales(self) -> int:
        """Number of scales that are fitted beside the unknowns."""
        return 0

    def with_solver(self, solver: Any) -> Self:
        """Return the same bench: its results need no method of the search."""
        return self

    def until(self, share: float) -> Self:
        """Return the same bench: nothing is compared over time."""
        return self


@dataclass(frozen=True, eq=False)
class Machines:
    """Machines of one measurement.

    Attributes
    ----------
    source : Source
        What makes them.
    start : Model
        The machine of the start values.
    places : (k,) array of int
        Places of their parameters among all unknowns.
    parameters : tuple of Parameter
        These parameters, without bounds: the search keeps them.
    """

    source: Source
    start: Model
    places: Array
    parameters: tuple[Parameter, ...]


def machines_of(
    problems: Problems,
    experiment: Any,
    model: Any,
    parameters: Sequence[Parameter],
    settings: Settings,
) -> Machines | None:
    """Return the machines of a measurement; None, with problems, if there are none.

    Parameters
    ----------
    problems : Problems
    experiment : Experiment, Values or Modal
    model : object
        Machine of all measurements that have none of their own.
    parameters : sequence of Parameter
        Unknowns of the model.
    settings : Settings
        Settings of the runs.
    """
    own = model if experiment.model is None else experiment.model
    if own is None:
        problems.add(experiment.where, "has no model; give one here or to identify")
        return None
    try:
        source = source_of(own, settings)
        taken = {p.name: p.value for p in parameters if source.takes(p.name)}
        start = source.machine(taken, Memory()).model
    except InputError as error:
        problems.found += error.problems
        return None
    used = [k for k, p in enumerate(parameters) if p.name in taken or p.name in start.inputs]
    chosen = tuple(replace(parameters[k], bounds=None, distribution=None) for k in used)
    return Machines(source, start, np.array(used, dtype=int), chosen)
