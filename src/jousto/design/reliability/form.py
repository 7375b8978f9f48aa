"""First-order reliability method (FORM): design point, and probability from its tangent."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from scipy.special import ndtr

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, count
from jousto.base.frozen_dict import Frozen
from jousto.base.object_repr import described
from jousto.design.reliability.errors import DesignPointError, LimitStateError
from jousto.design.reliability.inputs.random import Affine, Random
from jousto.design.reliability.inputs.space import Space
from jousto.design.reliability.inputs.transform import Transformation
from jousto.design.reliability.limit import LimitState, Values, format_values

ARMIJO = 0.1
HALVINGS = 12
ROUNDING = 1e-10  # rounding error of merit functions with difference gradients, relative
PENALTY = 2.0  # safety factor on the smallest penalty that makes the step a descent direction
FAR = 8.0
MOVE = 1e-3  # step of central differences with respect to the moments, standard deviations


@described
@dataclass(frozen=True, eq=False)
class FormResult:
    """Reliability index, design point, importance factors and sensitivities.

    Attributes
    ----------
    name : str
        Name of the limit state.
    beta : float
        Distance of the limit surface from the origin of standard normal space; negative if the
        medians fail.
    probability : float
        ``Phi(-beta)``, the probability beyond the tangent.
    u : (n,) array
        Design point, standard normal.
    x : Values
        Design point by names.
    alpha : (n,) array
        ``-grad g / |grad g|``; ``u = beta alpha``.
    gradient : (n,) array
        ``dg/du`` at the design point.
    iterations, calls, gradients : int
        Steps, calls of the limit state (with those of differences) and of its given gradient.
    method : str
        Method that found the design point.
    history : (iterations + 1, 4) array
        Calls, beta, limit state and residual before each step and at the end.
    limit : LimitState
        Analysed limit state.
    variables : Transformation
        The random variables.
    fixed : dict of float
        Other values.
    """

    name: str
    beta: float
    probability: float
    u: Array
    x: Values
    alpha: Array
    gradient: Array
    iterations: int
    calls: int
    gradients: int
    method: str
    history: Array
    limit: LimitState
    variables: Transformation
    fixed: Mapping[str, float]

    def _facts(self) -> str:
        work = count(self.calls, "call") + (
            f" and {count(self.gradients, 'gradient')}" if self.gradients else ""
        )
        return f"beta {self.beta:.6g}, Pf {self.probability:.4g} at {format_values(self.x)}; {work}"

    @cached_property
    def importance(self) -> Mapping[str, float]:
        """Share of each variable in the variance of the linearised limit state.

        ``alpha_i^2`` for independent variables; for dependent ones the squared components of the
        unit vector along ``alpha J^-1 D``, with J = dx/du and the deviations D of the equivalent
        normal variables at the design point.
        """
        J = self.variables.jacobian(self.u)
        gamma = np.linalg.solve(J.T, self.alpha) * np.sqrt(np.sum(J * J, axis=1))
        share = gamma**2 / np.sum(gamma**2)
        return Frozen(dict(zip(self.variables.names, share.tolist(), strict=True)))

    @cached_property
    def by_mean(self) -> Mapping[str, float]:
        """Derivatives of beta by the mean of each variable at constant standard deviation.

        Lognormal, Weibull and gamma variables keep their family. Empty for conditional variables
        and joint distributions, whose moments are not parameters.
        """
        return Frozen(self._moments(0))

    @cached_property
    def by_deviation(self) -> Mapping[str, float]:
        """Derivatives of beta by the standard deviation of each variable at constant mean."""
        return Frozen(self._moments(1))

    def _moments(self, which: int) -> dict[str, float]:
        slope = np.linalg.solve(self.variables.jacobian(self.u).T, self.gradient)
        size = float(np.linalg.norm(self.gradient))
        moves = moment_derivatives(self.variables, self.u, which)
        return {name: float(slope @ dx) / size for name, dx in moves.items()}


def moment_derivatives(variables: Transformation, u: Array, which: int) -> dict[str, Array]:
    """Return ``dx/dmean`` (which 0) or ``dx/ddeviation`` (1) at point u, by variable."""
    x = variables.to_x(u) if variables.randoms else u
    return {one.name: moment_derivative(variables, u, x, one, which) for one in variables.randoms}


def moment_derivative(
    variables: Transformation, u: Array, x: Array, one: Random, which: int, *, tied: bool = False
) -> Array:
    """Return the derivative ``dx`` by the mean (0) or the deviation (1) of one variable.

    `tied`: a change of the mean also changes the deviation of variables with constant
    coefficient of variation.
    """
    if isinstance(one.law, Affine):  # closed form; the correlations remain the same
        out = np.zeros(len(u))
        i = variables.names.index(one.name)
        y = (x[i] - one.mean) / one.deviation
        share = one.deviation / one.mean if tied and one.keep == "cov" and one.mean else 0.0
        out[i] = y if which else 1.0 + share * y
        return out
    step = MOVE * one.deviation
    ends = []
    for side in (1.0, -1.0):
        moments: list[float | None] = [one.mean, one.deviation]
        moments[which] = (one.deviation if which else one.mean) + side * step
        deviation = None if tied else moments[1]
        ends.append(variables.moved({one.name: (float(moments[0] or 0.0), deviation)}).to_x(u))
    return np.asarray((ends[0] - ends[1]) / (2.0 * step))


@explained
def form(
    limit: LimitState | Callable[..., Any],
    variables: Any = None,
    *,
    method: Literal["sqp", "hlrf"] = "sqp",
    start: Mapping[str, float] | None = None,
    tolerance: float = 1e-6,
    iterations: int = 100,
    far: float = FAR,
) -> FormResult:
    """Return reliability index and design point of a limit state by first-order reliability.

    ``beta = min |u|`` with ``g(u) = 0``, u being independent standard normal variables. The method
    of Hasofer, Lind, Rackwitz and Fiessler, hlrf, takes the nearest point of the tangent,
    ``u+ = (grad g^T u - g) grad g / |grad g|^2``, with a line search on ``|u|^2 / 2 + c |g|``
    (Y. Zhang and A. Der Kiureghian, IFIP WG 7.5 (1995)); sqp adds the curvature of the surface,
    estimated from the gradients (BFGS), and needs fewer calls. Where its line search fails, hlrf
    continues as sqp.

    Parameters
    ----------
    limit : LimitState or callable
        ``G(x) <= 0`` is failure; x has values by name (`Values`).
    variables : sequence of Random, Nataf, Rosenblatt or JointDistribution, optional
        The random variables; variables of a sequence are independent.
    method : {"sqp", "hlrf"}
        Method, see above.
    start : dict of float, optional
        Start values; None: the medians.
    tolerance : float
        Largest distance, in standard normal space, from the limit surface and from its normal
        through the origin.
    iterations : int
        Largest number of iterations.
    far : float
        Largest beta for which a failure is searched.

    Returns
    -------
    FormResult
        With importance factors and sensitivities.

    Raises
    ------
    DesignPointError
        If there is no failure within `far`, the iteration does not end, or the limit state does not
        depend on the variables.
    LimitStateError
        If the limit state fails or is not a number.
    InputError
        For wrong arguments.

    Examples
    --------
    >>> from scipy.stats import norm
    >>> from jousto.design import Random
    >>> found = form(lambda x: x["R"] - x["S"], [Random("R", norm(5, 3)), Random("S", norm(0, 4))])
    >>> found
    <FormResult 'G': beta 1, Pf 0.1587 at R = 3.2, S = 3.2; ... calls>
    >>> print(f"{found.importance['R']:.2f}")
    0.36
    """
    problems = Problems()
    if method not in ("hlrf", "sqp"):
        problems.add("form", f"method is {method!r}, must be 'hlrf' or 'sqp'")
    check_iteration(problems, "form", tolerance, iterations)
    problems.positive("form", "far", far, "")
    problems.raise_if_any()
    space = Space(limit, variables)
    found = design_point(space, space.start(start), method, tolerance, iterations, far)
    if abs(found.beta) > far:
        message = (
            f"{space.counted.where}: its design point is at beta = {found.beta:.4g}, beyond "
            f"{far:g}: probabilities of {ndtr(-abs(found.beta)):.1g} have no practical "
            "meaning; give a larger far= to accept it"
        )
        raise DesignPointError(message, found.u, [tuple(row) for row in found.history.tolist()])
    return found


def form_result(where: str, limit: Any, variables: Any, **options: Any) -> FormResult:
    """Return the given FORM result, or that of a limit state, its variables and options.

    Raises
    ------
    InputError
        If variables or options are given beside a FORM result.
    """
    if not isinstance(limit, FormResult):
        return form(limit, variables, **options)
    if variables is not None or options:
        message = "a result of form contains its variables; leave variables out"
        raise InputError(Problem(where, message))
    return limit


def check_iteration(problems: Problems, where: str, tolerance: float, iterations: int) -> None:
    """Add problems of a tolerance that is not positive and of a wrong number of iterations."""
    problems.positive(where, "tolerance", tolerance, "")
    problems.whole(where, "iterations", iterations)


def design_point(
    space: Space, u: Array, method: str, tolerance: float, iterations: int, far: float
) -> FormResult:
    """Return the design point by sequential quadratic programming with line search."""
    rows: list[tuple[float, ...]] = []
    used, B, c = method, np.eye(space.n), 0.0
    edge = max(2.0 * far, 2.0 * float(np.linalg.norm(u)))
    g = space.g(u)
    slope = slope_at(space, u, g, rows)
    for k in range(iterations + 1):
        size = float(np.linalg.norm(slope))
        alpha = -slope / size
        beta = float(alpha @ u) + g / size
        across = float(np.linalg.norm(u - (alpha @ u) * alpha))
        residual = max(abs(g) / size, across) / max(1.0, abs(beta))
        rows.append((space.calls, beta, g, residual))
        stalled = used == "sqp" and k > 0 and residual > 0.5 * rows[-2][3]
        if residual <= tolerance or (stalled and residual <= 0.1 * space.blur):
            return _result(space, beta, alpha, slope, rows, used)
        if k == iterations:
            break
        # quadratic program: nearest point of the tangent in the metric B
        solved = np.linalg.solve(B, np.stack([u, slope], axis=1))
        lam = (g - float(slope @ solved[:, 0])) / float(slope @ solved[:, 1])
        d = -(solved[:, 0] + lam * solved[:, 1])
        longest = edge / max(float(np.linalg.norm(u + d)), 1e-300)
        if longest < 1.0:  # limit the step: a nearly flat limit state has its tangent very far away
            d = longest * (u + d) - u
        c = max(c if used == "sqp" else 0.0, PENALTY * abs(lam))
        if used == "hlrf" and abs(g) > tolerance * size:
            c = max(c, PENALTY * 0.5 * float((u + d) @ (u + d)) / abs(g))
        slack = ROUNDING if used == "sqp" else 0.0
        moved = _search_merit(space, u, g, d, c, float(u @ d) - c * abs(g), slack)
        if moved is None:
            if residual <= space.blur:
                return _result(space, beta, alpha, slope, rows, used)
            if used == "hlrf" and np.linalg.norm(u) < edge:
                used = "sqp"
                continue
            break
        new, g_new = moved
        slope_new = slope_at(space, new, g_new, rows)
        if used == "sqp":
            B = bfgs(B, new - u, new - u + lam * (slope_new - slope))
        u, g, slope = new, g_new, slope_new
    raise _no_point(space, u, g, far, rows, iterations)


def slope_at(space: Space, u: Array, g: float, rows: list[tuple[float, ...]]) -> Array:
    """Return the gradient ``dg/du`` at a point; raise DesignPointError if it is zero."""
    slope = space.gradient(u, g)
    if not np.linalg.norm(slope) > 1e-14 * abs(g):
        point = format_values(space.values(u))
        message = (
            f"{space.counted.where}: its gradient is zero at {point}, so there "
            "is no search direction; give another start, or leave out a limit that no random "
            "variable changes"
        )
        raise DesignPointError(message, u, rows)
    return slope


def line_search(
    space: Space,
    point: Callable[[float], Array],
    accepts: Callable[[float, Array, float], bool],
    *,
    first: float = 1.0,
    halvings: int = HALVINGS,
) -> tuple[Array, float] | None:
    """Return the first accepted point u and g(u) of a halved step s, None if there is none.

    ``point(s)`` returns u, and ``accepts(s, u, g)`` accepts it. A point at which the limit state
    cannot be computed is not accepted: a step that is too long may leave the region in which G can
    be computed.

    Raises
    ------
    LimitStateError
        If no point is accepted and the limit state could not be computed at one of them.
    """
    failed: LimitStateError | None = None
    for k in range(halvings):
        s = first * 0.5**k
        u = point(s)
        try:
            g = space.g(u)
        except LimitStateError as error:
            failed = error
            continue
        if accepts(s, u, g):
            return u, g
    if failed is not None:
        raise failed
    return None


def _search_merit(
    space: Space, u: Array, g: float, d: Array, c: float, decrease: float, slack: float
) -> tuple[Array, float] | None:
    """Return a point along d with a smaller merit ``|u|^2 / 2 + c |g|``, and g there."""

    def merit(u: Array, g: float) -> float:
        return 0.5 * float(u @ u) + c * abs(g)

    old = merit(u, g)
    slack *= 1.0 + old

    def accepts(s: float, new: Array, g_new: float) -> bool:
        return merit(new, g_new) <= old + ARMIJO * s * min(decrease, 0.0) + slack

    return line_search(space, lambda s: u + s * d, accepts)


def bfgs(B: Array, s: Array, y: Array) -> Array:
    """Return the damped update of a Hessian (M. J. D. Powell, 1978)."""
    Bs = B @ s
    sBs, sy = float(s @ Bs), float(s @ y)
    if sBs <= 0.0:
        return B
    if sy < 0.2 * sBs:
        theta = 0.8 * sBs / (sBs - sy)
        y = theta * y + (1.0 - theta) * Bs
        sy = float(s @ y)
    return np.asarray(B + np.outer(y, y) / sy - np.outer(Bs, Bs) / sBs)


def _no_point(
    space: Space, u: Array, g: float, far: float, rows: list[tuple[float, ...]], iterations: int
) -> DesignPointError:
    point = format_values(space.values(u))
    where = space.counted.where
    same = all(row[2] * rows[0][2] > 0.0 for row in rows) and rows[-1][2] * g > 0.0
    if same and len(rows) <= iterations:
        found, none = ("no failure", "none") if g > 0.0 else ("nothing safe", "nothing")
        kink = "" if np.linalg.norm(u) >= far else ", or a kink of G stops the search"
        message = (
            f"{where}: {found} found; G is still {g:.4g} at {point}. There may be {none} within "
            f"beta = {far:g} (probability < {ndtr(-far):.1g}){kink}; try another start"
        )
    else:
        message = (
            f"{where}: no design point after {count(len(rows) - 1, 'step')}; the last is at "
            f"{point}, G = {g:.4g}, residual {rows[-1][3]:.2g}; a noisy limit state needs a larger "
            "step of its differences"
        )
    return DesignPointError(message, u, rows)


def _result(
    space: Space, beta: float, alpha: Array, slope: Array, rows: list[tuple[float, ...]], used: str
) -> FormResult:
    u = beta * alpha
    return FormResult(
        name=space.limit.name,
        beta=beta,
        probability=float(ndtr(-beta)),
        u=u,
        x=space.values(u),
        alpha=alpha,
        gradient=slope,
        iterations=len(rows) - 1,
        calls=space.calls,
        gradients=space.gradients,
        method=used,
        history=np.array(rows),
        limit=space.limit,
        variables=space.variables,
        fixed=Frozen(space.fixed),
    )
