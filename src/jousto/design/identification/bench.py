"""Protocol of a bench: a machine with a measurement, whose results are computed at any point."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.design.identification.experiment import Comparison
from jousto.design.studies.running.evaluator import Evaluator


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
