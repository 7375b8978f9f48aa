"""Progress of a reduction: its stages, its solver, and results stored in case of interruption."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.progress import bars
from jousto.reduction.sparse import factor
from jousto.reduction.sparse.memory import machine_memory

Report = Callable[[str, float], None]
"""Function of (stage, finished fraction of it, 0 to 1)."""


class Keeper(Protocol):
    """Storage of the results of stages, such as an entry of the cache."""

    def read(self, stage: str) -> dict[str, NDArray[Any]] | None:
        """Return the arrays of a stage; None if none are stored."""

    def write(self, stage: str, arrays: Mapping[str, NDArray[Any]]) -> None:
        """Write the arrays of a stage."""


class Run:
    """Data shared by the stages of a reduction.

    Parameters
    ----------
    solver : str, optional
        Library of the factorisation; None for the best one.
    report : callable, optional
        Function called with the stage and its finished fraction.
    entry : Entry, optional
        Storage of the results of stages.
    """

    def __init__(
        self, solver: str | None = None, report: Report | None = None, entry: Keeper | None = None
    ) -> None:
        self.solver = solver
        self.used = ""
        self.report = report
        self._entry = entry

    def _use(self, names: str) -> None:
        """Record the libraries used, each once, since a continued reduction may use another one."""
        known = [*self.used.split(", "), *names.split(", ")]
        self.used = ", ".join(name for name in dict.fromkeys(known) if name)

    @contextmanager
    def stage(self, name: str) -> Iterator[Report]:
        """Report the beginning and the end of a stage.

        The method yields a function of (name, finished fraction).
        """
        report = self.report or (lambda stage, done: None)
        report(name, 0.0)
        yield report
        report(name, 1.0)

    def factorise(
        self,
        K: sp.csc_array | sp.csr_array,
        where: str,
        dof_name: Callable[[int], str],
        points: Array | None = None,
    ) -> factor.Solver:
        """Factorise a stiffness matrix as a separate stage; see `factor.factorise`."""
        with self.stage("factorisation"):
            solve = factor.factorise(
                K, where, dof_name, points, solver=self.solver, limit=machine_memory()
            )
        self._use(getattr(solve, "name", ""))
        return solve

    def found(self, stage: str) -> dict[str, Array] | None:
        """Return the stored result of an interrupted reduction for this stage, or None."""
        kept = None if self._entry is None else self._entry.read(stage)
        if kept is not None and "solver" in kept:
            self._use(str(kept.pop("solver")))
        return kept

    def keep(self, stage: str, **arrays: Array) -> None:
        """Store the result of a stage until the reduction is finished."""
        if self._entry is not None:
            self._entry.write(stage, {**arrays, "solver": np.array(self.used)})


@contextmanager
def reporter(progress: bool | Report | None) -> Iterator[Report | None]:
    """Yield the function that reports progress.

    `progress` is True for bars (see `bars`), a function of the user, or None for no report.
    """
    if callable(progress):
        yield progress
        return
    if not progress:
        yield None
        return
    from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeElapsedColumn

    shown = bars(
        SpinnerColumn(finished_text="[green]✓"),
        TextColumn("{task.description:24}"),
        BarColumn(bar_width=24),
        TimeElapsedColumn(),
    )
    with shown:
        tasks: dict[str, int] = {}

        def report(stage: str, done: float) -> None:
            if stage not in tasks:
                tasks[stage] = shown.add_task(stage, total=1.0)
            shown.update(tasks[stage], completed=done)  # type: ignore[arg-type]

        yield report
