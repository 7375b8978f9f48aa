"""Designs by several optimisation methods for one problem, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from jousto.base.errors import InputError, Problem, Problems
from jousto.base.files import Rows, Tabular
from jousto.base.object_repr import described
from jousto.design.optimisation.optimum import Optimum


@described
@dataclass(frozen=True, eq=False)
class Comparison(Tabular):
    """Optima of one problem by several methods.

    Parameters
    ----------
    optima : sequence of Optimum
        Results of `optimise` by different methods, with the same parameters.

    Raises
    ------
    InputError
        If there are no optima, or their parameters differ.
    """

    optima: Sequence[Optimum]

    def __post_init__(self) -> None:
        problems = Problems()
        optima = problems.several("Comparison", "optima", self.optima, Optimum)
        problems.raise_if_any()
        if not optima:
            raise InputError(Problem("Comparison", "there are no optima"))
        if any(set(one.values) != set(optima[0].values) for one in optima):
            raise InputError(Problem("Comparison", "the optima have different parameters"))
        object.__setattr__(self, "optima", optima)

    def _facts(self) -> str:
        return "; ".join(f"{one.method}: cost {one.cost:.6g}" for one in self.optima)

    @property
    def table(self) -> list[tuple[str, ...]]:
        """Rows of the comparison, one column for each method; the first row has the method names.

        The excess is the cost minus that of the cheapest design that satisfies its limits.
        """
        optima = list(self.optima)
        kept = [one.cost for one in optima if one.kept]
        least = min(kept, default=float("nan"))
        scale = abs(least) or 1.0
        rows = [("", *(one.method for one in optima))]
        for name in optima[0].values:
            rows.append((name, *(f"{one.values[name]:.6g}" for one in optima)))
        rows += [
            ("cost", *(f"{one.cost:.7g}" for one in optima)),
            ("excess", *(f"{(one.cost - least) / scale:.3%}" for one in optima)),
            ("largest ratio", *(f"{one.ratio:.6f}" for one in optima)),
            ("KKT residual", *(f"{one.kkt:.1e}" for one in optima)),
            ("cycles", *(str(len(one.history)) for one in optima)),
            ("runs", *(str(one.runs) for one in optima)),
            ("converged", *("yes" if one.converged else "no" for one in optima)),
        ]
        return rows

    def __str__(self) -> str:
        rows = self.table
        widths = [max(map(len, cells)) for cells in zip(*rows, strict=True)]
        lines = []
        for row in rows:
            cells = [f"{row[0]:<{widths[0]}}"]
            cells += [f"{cell:>{w}}" for cell, w in zip(row[1:], widths[1:], strict=True)]
            lines.append("  " + "  ".join(cells))
        return "\n".join(lines)

    def _csv(self) -> Rows:
        tables = [one._csv() for one in self.optima]
        rows = [
            [one.method, *row]
            for one, (_, rows) in zip(self.optima, tables, strict=True)
            for row in rows
        ]
        return ["method", *tables[0][0]], rows
