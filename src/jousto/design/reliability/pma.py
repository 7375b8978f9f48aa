"""Performance measure approach (PMA): least limit state on the sphere of a target index."""

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
from jousto.design.reliability.errors import DesignPointError
from jousto.design.reliability.form import (
    FormResult,
    bfgs,
    check_iteration,
    form,
    line_search,
    moment_derivatives,
    slope_at,
)
from jousto.design.reliability.inputs.space import Space
from jousto.design.reliability.inputs.transform import Transformation
from jousto.design.reliability.limit import LimitState, Values, format_values

Method = Literal["sqp", "hmv", "amv", "cmv"]
METHODS = ("sqp", "hmv", "amv", "cmv")
SAME = 1e-6  # distance of two iterates that count as equal, relative to the last step
ARMIJO = 1e-4
HALVINGS = 20
ROUNDING = 1e-12


@described
@dataclass(frozen=True, eq=False)
class PmaResult:
    """Least value of a limit state on a sphere: the probabilistic performance measure.

    Attributes
    ----------
    name : str
        Name of the limit state.
    target : float
        Radius of the sphere: the target index.
    value : float
        Least limit state on the sphere; if it is not negative, the target is reached.
    u : (n,) array
        Point of the least value, standard normal.
    x : Values
        Point of the least value, by names.
    gradient : (n,) array
        ``dg/du`` at this point.
    residual : float
        ``|u / beta - n(u)|`` with the direction n of steepest descent.
    iterations, calls, gradients : int
        Steps, calls of the limit state (with those of differences) and of its given gradient.
    method : str
        Method that found the point.
    handed_over : str
        Why the requested method did not converge; empty if it did.
    history : (iterations + 1, 3) array
        Calls, limit state and residual before each step and at the end.
    limit : LimitState
        Analysed limit state.
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
        """Whether the target index is reached."""
        return self.value >= 0.0

    def _facts(self) -> str:
        work = count(self.calls, "call")
        at = f"{self.value:.6g} at {format_values(self.x)}, beta = {self.target:g}"
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
        moves = moment_derivatives(self.variables, self.u, which)
        return Frozen({name: float(slope @ dx) for name, dx in moves.items()})


@described
@dataclass(frozen=True, eq=False)
class RiaResult:
    """Comparison of a reliability index with its target.

    Attributes
    ----------
    target : float
        Target index.
    value : float
        ``beta - target``; if it is not negative, the target is reached.
    form : FormResult
        Result with the index, its design point and sensitivities.
    """

    target: float
    value: float
    form: FormResult

    @property
    def reliable(self) -> bool:
        """Whether the target index is reached."""
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
    """Compare a reliability index with its target by the reliability index approach (RIA).

    Parameters
    ----------
    limit : LimitState or callable
        ``G(x) <= 0`` is failure.
    variables : sequence of Random, Nataf, Rosenblatt or JointDistribution, optional
        The random variables.
    beta : float
        Target.
    **options
        Options of `form`.

    Returns
    -------
    RiaResult

    Raises
    ------
    DesignPointError
        If no failure is found within the largest beta; `pma` also works in this case.
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
    """Return the least limit state on the sphere of a target index by the PMA.

    ``G_p = min g(u)`` with ``|u| = beta``. With ``n = -grad g / |grad g|``, the steps are ``u+ =
    beta n(u)`` (advanced mean value, amv), ``u+ = beta s / |s|`` with the sum s of the last three n
    (conjugate mean value, cmv), or one of the two by the sign of ``(n+ - n) . (n - n-)`` (hybrid,
    hmv: B. D. Youn, K. K. Choi and Y. H. Park, *J. Mech. Des.* 125 (2003) 221-232); sqp solves
    quadratic programs with a BFGS Hessian and needs the fewest calls. The other methods continue as
    sqp if they cycle or do not converge.

    Parameters
    ----------
    limit : LimitState or callable
        ``G(x) <= 0`` is failure; x has values by name (`Values`).
    variables : sequence of Random, Nataf, Rosenblatt or JointDistribution, optional
        The random variables; variables of a sequence are independent.
    beta : float
        Target index, the radius of the sphere.
    method : {"sqp", "hmv", "amv", "cmv"}
        Method, see above.
    start : dict of float, optional
        Start values; None: the medians.
    tolerance : float
        Largest ``|u / beta - n(u)|``.
    iterations : int
        Largest number of iterations of each method.

    Returns
    -------
    PmaResult

    Raises
    ------
    DesignPointError
        If no method converges, or the limit state does not depend on the variables.
    LimitStateError
        If the limit state fails or is not a number.
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
        problems.add(
            "pma", f"beta is {beta:g}, must be at most 38: smaller probabilities underflow"
        )
    check_iteration(problems, "pma", tolerance, iterations)
    problems.raise_if_any()
    space = Space(limit, variables)
    return performance(space, space.start(start), float(beta), method, tolerance, iterations)


def performance(
    space: Space, u: Array, beta: float, method: str, tolerance: float, iterations: int
) -> PmaResult:
    """Return the least limit state on a sphere, from the start u."""
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
    """Return point, g and gradient by mean-value steps, and the reason if they did not converge."""
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
        # a cycle: the iteration returns to an earlier point
        step = float(np.linalg.norm(u - points[-1]))
        if any(np.linalg.norm(u - old) < SAME * step for old in points[-6:-1]):
            ends = " and ".join(f"({format_values(space.values(v))})" for v in (points[-1], u))
            why = f"cycles between {ends}"
            break
        points.append(u)
    return u, g, slope, why


def _concave(normals: list[Array]) -> bool:
    """Return whether the last two changes of direction are opposed."""
    return float((normals[2] - normals[1]) @ (normals[1] - normals[0])) <= 0.0


def _sphere(
    space: Space,
    u: Array,
    beta: float,
    tolerance: float,
    iterations: int,
    rows: list[tuple[float, ...]],
) -> tuple[Array, float, Array]:
    """Return the least point by quadratic programs, each step followed by a return to the sphere.

    The Lagrangian is ``L = g + lam (|u|^2 - beta^2) / 2``, with a BFGS approximation B of its
    Hessian.
    """
    g = space.g(u)
    slope = slope_at(space, u, g, rows)
    # start off the sphere: the first step is a mean-value step
    if abs(np.linalg.norm(u) / beta - 1.0) > 1e-12:
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
        moved = _search_sphere(space, u, g, d, beta, float(slope @ d))
        if moved is None:
            if residual <= space.blur:
                return u, g, slope
            break
        new, g_new = moved
        slope_new = slope_at(space, new, g_new, rows)
        size = float(np.linalg.norm(slope_new))
        # multiplier at the new point, which converges to that of the solution
        lam = -float(slope_new @ new) / beta**2
        turn = slope_new - slope + lam * (new - u)
        B = bfgs(B, new - u, turn) if size > 0.0 else B
        u, g, slope = new, g_new, slope_new
    message = (
        f"{space.counted.where}: no least value on the sphere of beta = {beta:g} after "
        f"{count(len(rows) - 1, 'step')}; the last is {g:.4g} at {format_values(space.values(u))}, "
        f"residual {rows[-1][2]:.2g}; a noisy limit state needs a larger step of its differences"
    )
    raise DesignPointError(message, u, rows)


def _search_sphere(
    space: Space, u: Array, g: float, d: Array, beta: float, decrease: float
) -> tuple[Array, float] | None:
    """Return a point of the sphere ``|u| = beta`` along d with a smaller g, and g there."""
    size = float(np.linalg.norm(d))
    longest = min(1.0, beta / size) if size > 0.0 else 1.0
    slack = ROUNDING * max(abs(g), abs(decrease))

    def point(s: float) -> Array:
        new = u + s * d
        return np.asarray(new * (beta / np.linalg.norm(new)))

    def accepts(s: float, new: Array, g_new: float) -> bool:
        return g_new <= g + ARMIJO * s * min(decrease, 0.0) + slack

    return line_search(space, point, accepts, first=longest, halvings=HALVINGS)
