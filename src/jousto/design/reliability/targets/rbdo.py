"""Reliability-based design optimisation: least cost with an index for each limit state."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array, some
from jousto.base.errors import Problems, count
from jousto.base.files import Rows, Tabular
from jousto.base.frozen_dict import Frozen
from jousto.base.object_repr import described
from jousto.design.reliability.errors import DesignPointError
from jousto.design.reliability.form import FormResult, design_point
from jousto.design.reliability.limit import LimitState
from jousto.design.reliability.targets.nested import far_index, nested
from jousto.design.reliability.targets.redesign import FAR, STEPS, WHERE, Redesign
from jousto.design.reliability.targets.redesign_input import read_redesign
from jousto.design.reliability.targets.sora import sora

ACTIVE = 1e-2  # distance from the target at which an index counts as active


@described
@dataclass(frozen=True, eq=False)
class RbdoResult(Tabular):
    """Design of least cost whose limit states have their target indices.

    Attributes
    ----------
    design : dict of float
        Means of random variables, and values of others.
    cost : float
        Cost of the design.
    betas : dict of float
        Indices of the limit states by FORM; infinite where no failure was found.
    target : dict of float
        Target indices.
    deterministic : dict of float
        The optimal design without scatter, the start of the search.
    deterministic_cost : float
        Cost of the deterministic design.
    cycles : int
        Number of optimisations with shifts ("sora"), or of trial designs (other methods).
    calls : dict of int
        Calls of each limit state, including those of differences.
    gradients : dict of int
        Calls of the limit states' gradients.
    method : str
        "sora", "pma" or "ria".
    history : (cycles + 1, 1 + n) array
        Cost and design after each cycle, the deterministic one first.
    forms : tuple of FormResult
        FORM results at the design, for limit states that can fail.
    """

    design: Mapping[str, float]
    cost: float
    betas: Mapping[str, float]
    target: Mapping[str, float]
    deterministic: Mapping[str, float]
    deterministic_cost: float
    cycles: int
    calls: Mapping[str, int]
    gradients: Mapping[str, int]
    method: str
    history: Array
    forms: tuple[FormResult, ...]

    @property
    def active(self) -> tuple[str, ...]:
        """Names of the limit states at their target index."""
        return tuple(k for k, beta in self.betas.items() if beta - self.target[k] <= ACTIVE)

    def _facts(self) -> str:
        at = ", ".join(f"{name} = {value:.6g}" for name, value in list(self.design.items())[:6])
        more = ", ..." if len(self.design) > 6 else ""
        work = count(sum(self.calls.values()), "call")
        active = some(list(self.active)) or "none"
        return f"cost {self.cost:.6g} at {at}{more}; active {active}; {self.method}, {work}"

    def __str__(self) -> str:
        rows = [("", "without scatter", self.method)]
        for name, value in self.design.items():
            rows.append((name, f"{self.deterministic[name]:.6g}", f"{value:.6g}"))
        rows.append(("cost", f"{self.deterministic_cost:.7g}", f"{self.cost:.7g}"))
        for name, beta in self.betas.items():
            word = ", active" if name in self.active else ""
            rows.append((f"beta of {name}", f"target {self.target[name]:g}", f"{beta:.4g}{word}"))
        rows.append(("cycles", "", str(self.cycles)))
        rows.append(("calls", "", str(sum(self.calls.values()))))
        widths = [max(map(len, cells)) for cells in zip(*rows, strict=True)]
        return "\n".join(
            ("  " + "  ".join(f"{c:<{w}}" for c, w in zip(row, widths, strict=True))).rstrip()
            for row in rows
        )

    def _csv(self) -> Rows:
        return ["cycle", "cost", *self.design], [[i, *row] for i, row in enumerate(self.history)]


@explained
def rbdo(
    cost: LimitState | Callable[..., Any],
    limits: Mapping[str, Any] | Sequence[Any],
    variables: Any = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    beta: Any = 3.0,
    *,
    method: Literal["sora", "pma", "ria"] = "sora",
    start: Mapping[str, float] | None = None,
    inner: Literal["sqp", "hmv", "amv", "cmv"] = "sqp",
    tolerance: float = 1e-5,
    cycles: int = 50,
) -> RbdoResult:
    """Return the design of least cost with ``P(G_i <= 0) <= Phi(-beta_i)``.

    "sora" alternates (X. Du and W. Chen, *J. Mech. Des.* 126 (2004) 225-233): a deterministic
    optimisation, with each limit state at its most probable point of the last cycle, shifted with
    the design; then new most probable points by `pma`. "pma" and "ria" are nested: for every trial
    design they compute the limit states on the sphere of the target, or the indices by `form`.

    Parameters
    ----------
    cost : callable or LimitState
        ``cost(d)`` of the design variables by name; a LimitState has a gradient.
    limits : dict or sequence of LimitState or callable
        ``G(x) <= 0`` is failure; x has the random variables and the design variables that are not
        random.
    variables : sequence of Random, Nataf, Rosenblatt or JointDistribution, optional
        The random variables at the start; by default those of the limit states.
    bounds : dict of (float, float)
        Smallest and largest value of each design variable by name. The name of a random variable
        means its mean; other names are values without scatter.
    beta : float or dict of float
        Target indices.
    method : {"sora", "pma", "ria"}
        Method, see above.
    start : dict of float, optional
        Start of the search; by default the means of the random variables.
    inner : {"sqp", "hmv", "amv", "cmv"}
        Method of `pma`.
    tolerance : float
        Relative change of the design, over the width of its bounds, at which the search ends.
    cycles : int
        Largest number of cycles, or of iterations for nested methods.

    Returns
    -------
    RbdoResult
        Optimal design; `check_linearisation` checks it by sampling.

    Raises
    ------
    DesignPointError
        If no design within the bounds reaches the targets, or the cycles do not converge.
    LimitStateError
        If a limit state fails or is not a number.
    InputError
        For wrong arguments: crossed bounds, a start outside of them, unknown names.
    """
    problem = read_redesign(cost, limits, variables, bounds, beta, start, method, inner)
    problems = Problems()
    problems.positive(WHERE, "tolerance", tolerance, "")
    problems.whole(WHERE, "cycles", cycles)
    problems.raise_if_any()
    first = problem.optimum(problem.start, problem.shifted([None] * len(problem.names)), STEPS)
    rows = [(problem.cost_of(first), *first)]
    if method == "sora":
        d, points = sora(problem, first, inner, tolerance, int(cycles), rows)
    else:
        d, points = nested(problem, first, method, inner, int(cycles), rows)
    return _result(problem, d, first, points, method, rows)


def _result(
    problem: Redesign,
    d: Array,
    first: Array,
    points: Sequence[Array | None],
    method: str,
    rows: list[tuple[float, ...]],
) -> RbdoResult:
    forms: list[FormResult] = []
    betas: dict[str, float] = {}
    for i, name in enumerate(problem.names):
        u = points[i]
        space = problem.space_at(d, i)
        try:
            found = design_point(
                space, np.zeros(space.n) if u is None else u, "sqp", 1e-6, 100, FAR
            )
        except DesignPointError:
            betas[name] = math.copysign(math.inf, far_index(problem, d, i))
            continue
        betas[name] = found.beta
        forms.append(found)
    return RbdoResult(
        design=Frozen(dict(zip(problem.designs, d.tolist(), strict=True))),
        cost=problem.cost_of(d),
        betas=Frozen(betas),
        target=Frozen(dict(zip(problem.names, problem.beta.tolist(), strict=True))),
        deterministic=Frozen(dict(zip(problem.designs, first.tolist(), strict=True))),
        deterministic_cost=problem.cost_of(first),
        cycles=len(rows) - 1,
        calls=Frozen({k: c.calls for k, c in zip(problem.names, problem.counted, strict=True)}),
        gradients=Frozen(
            {k: c.gradients for k, c in zip(problem.names, problem.counted, strict=True)}
        ),
        method=method,
        history=np.array(rows),
        forms=tuple(forms),
    )
