"""Result of an optimisation, and its residual of the optimality conditions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from jousto.base.arrays import Array
from jousto.base.errors import count
from jousto.base.files import Rows, Tabular
from jousto.base.object_repr import described
from jousto.design.optimisation.problem import Place

ACTIVE = 1e-3
"""Distance from 1 within which a ratio counts as active."""


@described
@dataclass(frozen=True)
class Cycle:
    """One cycle of an optimisation.

    Attributes
    ----------
    values : dict of float
        The design.
    cost : float
    ratio : float
        Largest ratio of value to limit in motion; above 1 a limit is exceeded.
    loads : float
        Change of the equivalent loads since the last cycle, relative; NaN where there are none.
    step : float
        Largest step from this design, as a share of the span of a parameter.
    runs : int
        Runs of the machine so far.
    """

    values: Mapping[str, float]
    cost: float
    ratio: float
    loads: float
    step: float
    runs: int


@described
@dataclass(frozen=True, eq=False)
class Optimum(Tabular):
    """Optimal design with its history, active limits and multipliers.

    Attributes
    ----------
    method : str
        "esl, order 0", "esl, order 1" or "direct".
    values : dict of float
        The parameters.
    cost : float
    ratio : float
        Largest ratio of value to limit in motion.
    converged : bool
    message : str
        Reason of the end.
    active : tuple of (Place, float)
        Active rows with their multipliers: relative increase of the cost per relative decrease of
        that limit.
    kkt : float
        Residual of the conditions of Karush, Kuhn and Tucker in motion, 0 for an optimum: the share
        of the cost gradient that no active limit or bound explains, or the excess of a limit if
        that is larger.
    runs : int
        Runs of the machine.
    history : tuple of Cycle
    others : tuple of Optimum
        Optima of the other starts, in their order.
    """

    method: str
    values: Mapping[str, float]
    cost: float
    ratio: float
    converged: bool
    message: str
    active: tuple[tuple[Place, float], ...]
    kkt: float
    runs: int
    history: tuple[Cycle, ...]
    others: tuple[Optimum, ...] = ()

    @property
    def instants(self) -> int:
        """Number of instants with active limits.

        If their number reaches that of the parameters, they explain the gradient of any cost, and a
        small KKT residual is no evidence of an optimum.
        """
        times = {(p.case, p.time) for p, _ in self.active if not np.isnan(p.time)}
        return len(times)

    @property
    def kept(self) -> bool:
        """Whether all limits are satisfied: ratios below 1 + 1e-3."""
        return self.ratio <= 1.0 + ACTIVE

    def _facts(self) -> str:
        values = ", ".join(f"{k} {v:.6g}" for k, v in list(self.values.items())[:4])
        end = "" if self.converged else ", not converged"
        return (
            f"{self.method}, cost {self.cost:.6g} at {values}, KKT {self.kkt:.1e} with"
            f" {count(self.instants, 'active instant')}, {self.runs} runs{end}"
        )

    def __str__(self) -> str:
        lines = [f"{self.method}: {self.message}", ""]
        lines += [f"  {name:<16} {value:.6g}" for name, value in self.values.items()]
        lines += [
            f"  {'cost':<16} {self.cost:.7g}",
            f"  {'largest ratio':<16} {self.ratio:.6f}",
            f"  {'KKT residual':<16} {self.kkt:.1e} with {count(self.instants, 'active instant')}"
            f" and {count(len(self.values), 'parameter')}",
            f"  {'runs':<16} {self.runs}",
        ]
        for place, multiplier in self.active:
            lines.append(f"  active: {place}, multiplier {multiplier:.4g}")
        return "\n".join(lines)

    def _csv(self) -> Rows:
        head = ["cycle", *self.values, "cost", "ratio", "load_change", "step", "runs"]
        rows = [
            [i, *one.values.values(), one.cost, one.ratio, one.loads, one.step, one.runs]
            for i, one in enumerate(self.history)
        ]
        return head, rows


def multipliers(
    gradient: Array, ratios: Array, slopes: Array, at_low: Array, at_high: Array
) -> tuple[float, dict[int, float]]:
    """Return the KKT residual and the multipliers of the rows by row number.

    ``|grad c + sum m_j grad r_j - m_low + m_high| / |grad c|`` with the best ``m >= 0``.

    Parameters
    ----------
    gradient : (nd,) array
        Derivatives of the cost.
    ratios : (m,) array
    slopes : (m, nd) array
        Derivatives of the ratios.
    at_low, at_high : (nd,) bool array
        Masks of the parameters at a bound.
    """
    near = np.flatnonzero(ratios >= 1.0 - ACTIVE)
    unit = np.eye(len(gradient))
    columns = np.vstack([slopes[near], -unit[at_low], unit[at_high]]).T
    size = float(np.linalg.norm(gradient))
    if not columns.shape[1] or not size:
        return (1.0 if size else 0.0), {}
    m, rest = nnls(columns, -gradient)
    return float(rest / size), {
        int(row): float(m[j]) for j, row in enumerate(near) if m[j] > 1e-9 * m.max(initial=0.0)
    }
