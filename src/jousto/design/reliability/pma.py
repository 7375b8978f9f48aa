"""The inverse question: how small a limit state gets on the sphere of a target index."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import Problems, count
from jousto.base.frozen_dict import Frozen
from jousto.base.object_repr import described
from jousto.design.reliability.errors import DesignPointError, LimitStateError
from jousto.design.reliability.form import (
    FormResult,
    bfgs,
    check_iteration,
    form,
    moved_by_moments,
    slope_at,
)
from jousto.design.reliability.inputs.space import Space
from jousto.design.reliability.inputs.transform import Transformation
from jousto.design.reliability.limit import LimitState, Values, shown

Method = Literal["sqp", "hmv", "amv", "cmv"]
METHODS = ("sqp", "hmv", "amv", "cmv")
SAME = 1e-6  # distance, by that of the last step, of points that an iteration comes back to
ARMIJO = 1e-4
HALVINGS = 20
ROUNDING = 1e-12


@described
@dataclass(frozen=True, eq=False)
class PmaResult:
    """The least value of a limit state on a sphere: its probabilistic performance measure.

    Attributes
    ----------
    name : str
        Of the limit state.
    target : float
        Radius of the sphere: the index that is asked for.
    value : float
        Least limit state there. What is not negative has the index.
    u : (n,) array
        Where it is, standard normal.
    x : Values
        Where it is, by names.
    gradient : (n,) array
        ``dg/du`` there.
    residual : float
        ``|u / beta - n(u)|``, n being the direction of steepest descent.
    iterations, calls, gradients : int
        Steps, calls of the limit state (with those of differences) and of its given gradient.
    method : str
        That which found it.
    handed_over : str
        Why the method that was asked for did not end; empty if it did.
    history : (iterations + 1, 3) array
        Calls, limit state and residual before each step and at the end.
    limit : LimitState
        Of which it is.
    variables : Transformation
        The random variables.
    fixed : dict of float
        Other values.
    """

    name: str
    target: float
    value: float
    u: Array
    x: Values
    gradient: Array
    residual: float
    iterations: int
    calls: int
    gradients: int
    method: str
    handed_over: str
    history: Array
    limit: LimitState
    variables: Transformation
    fixed: Mapping[str, float]

    @property
    def reliable(self) -> bool:
        """Whether the target is reached."""
        return self.value >= 0.0

    def _facts(self) -> str:
        work = count(self.calls, "call")
        at = f"{self.value:.6g} at {shown(self.x)}, beta = {self.target:g}"
        over = f"; from {self.handed_over}" if self.handed_over else ""
        return f"{at}; {self.method}, {count(self.iterations, 'step')}, {work}{over}"

    @cached_property
    def by_mean(self) -> Mapping[str, float]:
        """Derivatives of the value by the mean of each variable, without further calls."""
        return self._moments(0)

    @cached_property
    def by_deviation(self) -> Mapping[str, float]:
        """Derivatives of the value by the standard deviation of each variable."""
        return self._moments(1)

    def _moments(self, which: int) -> Mapping[str, float]:
        slope = np.linalg.solve(self.variables.jacobian(self.u).T, self.gradient)
        moves = moved_by_moments(self.variables, self.u, which)
        return Frozen({name: float(slope @ dx) for name, dx in moves.items()})


@described
@dataclass(frozen=True, eq=False)
class RiaResult:
    """Whether a reliability index reaches its target.

    Attributes
    ----------
    target : float
        Index that is asked for.
    value : float
        ``beta - target``; what is not negative has it.
    form : FormResult
        The index, with its design point and sensitivities.
    """

    target: float
    value: float
    form: FormResult

    @property
    def reliable(self) -> bool:
        """Whether the target is reached."""
        return self.value >= 0.0

    def _facts(self) -> str:
        how = "reached" if self.reliable else "missed"
        work = count(self.form.calls, "call")
        return f"beta {self.form.beta:.6g}, target {self.target:g} {how}; {work}"


@explained
def ria(
    limit: LimitState | Callable[..., Any],
    variables: Any = None,
    beta: float = 3.0,
    **options: Any,
) -> RiaResult:
    """Compare the reliability index with a target: the reliability index approach.

    Parameters
    ----------
    limit : LimitState or callable
        ``G(x) <= 0`` is failure.
    variables : sequence of Random, Nataf, Rosenblatt or JointDistribution, optional
        The random variables.
    beta : float
        Target.
    **options
        Of `form`.

    Returns
    -------
    RiaResult

    Raises
    ------
    DesignPointError
        If there is no failure within reach; `pma` works there, too.
    InputError
        For wrong arguments.

    Examples
    --------
    >>> from scipy.stats import norm
    >>> from jousto.design import Random
    >>> ria(lambda x: 3 - x["a"], [Random("a", norm(0, 1))], 2.5).value
    0.5
    """
    problems = Problems()
    problems.positive("ria", "beta", beta, "")
    problems.raise_if_any()
    found = form(limit, variables, **options)
    return RiaResult(float(beta), found.beta - float(beta), found)


@explained
def pma(
    limit: LimitState | Callable[..., Any],
    variables: Any = None,
    beta: float = 3.0,
    *,
    method: Method = "sqp",
    start: Mapping[str, float] | None = None,
    tolerance: float = 1e-6,
    iterations: int = 100,
) -> PmaResult:
    """Return the least limit state on the sphere of a target index: performance measure approach.

    ``G_p = min g(u)`` with ``|u| = beta``. With ``n = -grad g / |grad g|``, the steps are
    ``u+ = beta n(u)`` (advanced mean value, amv), ``u+ = beta s / |s|`` with s the sum of the last
    three n (conjugate, cmv) or, of these, that which suits the sign of
    ``(n+ - n) . (n - n-)`` (hybrid, hmv: B. D. Youn, K. K. Choi and Y. H. Park, *J. Mech. Des.* 125
    (2003) 221-232); sqp are quadratic programs with the curvature learnt on the way, which need the
    fewest calls. The others go on as sqp where they come back to a point or do not end.

    Parameters
    ----------
    limit : LimitState or callable
        ``G(x) <= 0`` is failure; x has values by name (`Values`).
    variables : sequence of Random, Nataf, Rosenblatt or JointDistribution, optional
        The random variables; a sequence is of independent ones.
    beta : float
        Target, the radius of the sphere.
    method : {"sqp", "hmv", "amv", "cmv"}
        See above.
    start : dict of float, optional
        Values where to begin; None takes the medians.
    tolerance : float
        Largest ``|u / beta - n(u)|``.
    iterations : int
        At most with each of the methods.

    Returns
    -------
    PmaResult

    Raises
    ------
    DesignPointError
        If no method ends, or the limit state does not depend on the variables.
    LimitStateError
        If the limit state fails or is no number.
    InputError
        For wrong arguments.

    Examples
    --------
    >>> from scipy.stats import norm
    >>> from jousto.design import Random
    >>> x = [Random("a", norm(6, 0.8)), Random("b", norm(6, 0.8))]
    >>> found = pma(lambda x: 10 - np.exp(x["a"] - 7) - x["b"], x, 3.0)
    >>> print(f"{found.value:.6f} at ({found.x['a']:.4f}, {found.x['b']:.4f})")
    -0.357938 at (8.3185, 6.6203)
    """
    problems = Problems()
    if method not in METHODS:
        problems.add("pma", f"method is {method!r}, must be one of {', '.join(METHODS)}")
    problems.positive("pma", "beta", beta, "")
    if problems.number("pma", "beta", beta, "") and beta > 38.0:
        problems.add("pma", f"beta is {beta:g}, beyond 38 no probability is a double")
    check_iteration(problems, "pma", tolerance, iterations)
    problems.raise_if_any()
    space = Space(limit, variables)
    return performance(space, space.start(start), float(beta), method, tolerance, iterations)


def performance(
    space: Space, u: Array, beta: float, method: str, tolerance: float, iterations: int
) -> PmaResult:
    """Return the least limit state on a sphere by steps from u."""
    rows: list[tuple[float, ...]] = []
    over = ""
    if method != "sqp":
        u, g, slope, over = _mean_values(space, u, beta, method, tolerance, iterations, rows)
    if method == "sqp" or over:
        u, g, slope = _sphere(space, u, beta, tolerance, iterations, rows)
    return PmaResult(
        name=space.limit.name,
        target=beta,
        value=g,
        u=u,
        x=space.values(u),
        gradient=slope,
        residual=rows[-1][2],
        iterations=len(rows) - 1,
        calls=space.calls,
        gradients=space.gradients,
        method="sqp" if over else method,
        handed_over=f"{method}: {over}" if over else "",
        history=np.array(rows),
        limit=space.limit,
        variables=space.variables,
        fixed=Frozen(space.fixed),
    )


def _residual(u: Array, slope: Array, beta: float) -> float:
    return float(np.linalg.norm(u / beta + slope / np.linalg.norm(slope)))


def _mean_values(
    space: Space,
    u: Array,
    beta: float,
    method: str,
    tolerance: float,
    iterations: int,
    rows: list[tuple[float, ...]],
) -> tuple[Array, float, Array, str]:
    """Return the point of mean value steps, and why they did not end, or nothing."""
    normals: list[Array] = []
    points = [u]
    why = f"no end after {count(iterations, 'step')}"
    for k in range(iterations + 1):
        g = space.g(u)
        slope = slope_at(space, u, g, rows)
        residual = _residual(u, slope, beta)
        rows.append((space.calls, g, residual))
        if residual <= tolerance:
            return u, g, slope, ""
        normals = [*normals, -slope / np.linalg.norm(slope)][-3:]
        if k == iterations:
            break
        s = normals[-1]
        if len(normals) == 3 and (method == "cmv" or (method == "hmv" and _concave(normals))):
            s = normals[0] + normals[1] + normals[2]
        size = float(np.linalg.norm(s))
        if size < 1e-8:
            why = "its directions cancel one another"
            break
        u = beta * s / size
        # an iteration that comes back to a point before the last goes on for ever
        step = float(np.linalg.norm(u - points[-1]))
        if any(np.linalg.norm(u - old) < SAME * step for old in points[-6:-1]):
            ends = " and ".join(f"({shown(space.values(v))})" for v in (points[-1], u))
            why = f"goes to and fro between {ends}"
            break
        points.append(u)
    return u, g, slope, why


def _concave(normals: list[Array]) -> bool:
    """Return whether the last two turns of the direction are against one another."""
    return float((normals[2] - normals[1]) @ (normals[1] - normals[0])) <= 0.0


def _sphere(
    space: Space,
    u: Array,
    beta: float,
    tolerance: float,
    iterations: int,
    rows: list[tuple[float, ...]],
) -> tuple[Array, float, Array]:
    """Return the least point by quadratic programs whose steps return to the sphere.

    ``L = g + lam (|u|^2 - beta^2) / 2``; its Hessian B is learnt (BFGS).
    """
    g = space.g(u)
    slope = slope_at(space, u, g, rows)
    if abs(np.linalg.norm(u) / beta - 1.0) > 1e-12:  # the first step is that of the mean value
        rows.append((space.calls, g, _residual(u, slope, beta)))
        u = -beta * slope / np.linalg.norm(slope)
        g = space.g(u)
        slope = slope_at(space, u, g, rows)
    B = np.eye(space.n) * float(np.linalg.norm(slope)) / beta
    last = np.inf
    for _ in range(iterations + 1):
        residual = _residual(u, slope, beta)
        rows.append((space.calls, g, residual))
        if residual <= tolerance or 0.5 * last < residual <= 0.1 * space.blur:
            return u, g, slope
        last = residual
        solved = np.linalg.solve(B, np.stack([slope, u], axis=1))
        lam = -float(u @ solved[:, 0]) / float(u @ solved[:, 1])
        d = -(solved[:, 0] + lam * solved[:, 1])
        moved = _around(space, u, g, d, beta, float(slope @ d))
        if moved is None:
            if residual <= space.blur:
                return u, g, slope
            break
        new, g_new = moved
        slope_new = slope_at(space, new, g_new, rows)
        size = float(np.linalg.norm(slope_new))
        # with the multiplier of the new point, which is that of the solution in the end
        lam = -float(slope_new @ new) / beta**2
        turn = slope_new - slope + lam * (new - u)
        B = bfgs(B, new - u, turn) if size > 0.0 else B
        u, g, slope = new, g_new, slope_new
    message = (
        f"{space.counted.where}: no least value on the sphere of beta = {beta:g} after "
        f"{count(len(rows) - 1, 'step')}; the last is {g:.4g} at {shown(space.values(u))}, "
        f"residual {rows[-1][2]:.2g}; a noisy limit state needs a larger step of its differences"
    )
    raise DesignPointError(message, u, rows)


def _around(
    space: Space, u: Array, g: float, d: Array, beta: float, decrease: float
) -> tuple[Array, float] | None:
    """Return a point of the sphere along d with a smaller g, None if there is none."""
    failed: LimitStateError | None = None
    size = float(np.linalg.norm(d))
    longest = min(1.0, beta / size) if size > 0.0 else 1.0
    for k in range(HALVINGS):
        s = longest * 0.5**k
        new = u + s * d
        new *= beta / np.linalg.norm(new)
        try:
            g_new = space.g(new)
        except LimitStateError as error:
            failed = error
            continue
        if g_new <= g + ARMIJO * s * min(decrease, 0.0) + ROUNDING * max(abs(g), abs(decrease)):
            return new, g_new
    if failed is not None:
        raise failed
    return None
