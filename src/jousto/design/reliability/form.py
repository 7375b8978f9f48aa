"""FORM: the most probable point of failure, and the probability of what lies beyond its tangent."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from scipy.special import ndtr

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import Problems, count
from jousto.base.frozen_dict import Frozen
from jousto.base.object_repr import described
from jousto.design.reliability.errors import DesignPointError, LimitStateError
from jousto.design.reliability.inputs.random import Affine, Random
from jousto.design.reliability.inputs.space import Space
from jousto.design.reliability.inputs.transform import Transformation
from jousto.design.reliability.limit import LimitState, Values, shown

ARMIJO = 0.1
HALVINGS = 12
ROUNDING = 1e-10  # of a merit, of differences with small steps
PENALTY = 2.0  # times the least that makes the step a descent
FAR = 8.0
MOVE = 1e-3  # of a deviation, in differences of a transformation by its moments


@described
@dataclass(frozen=True, eq=False)
class FormResult:
    """Reliability index, design point and what matters for them.

    Attributes
    ----------
    name : str
        Of the limit state.
    beta : float
        Distance of the limit surface from the origin of standard normal space; negative if the
        medians fail.
    probability : float
        ``Phi(-beta)``, that of the tangent.
    u : (n,) array
        Design point, standard normal.
    x : Values
        Design point by names.
    alpha : (n,) array
        ``-grad g / |grad g|``; ``u = beta alpha``.
    gradient : (n,) array
        ``dg/du`` there.
    iterations, calls, gradients : int
        Steps, calls of the limit state (with those of differences) and of its given gradient.
    method : str
        That which found it.
    history : (iterations + 1, 4) array
        Calls, beta, limit state and residual before each step and at the end.
    limit : LimitState
        Of which it is.
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
        return f"beta {self.beta:.6g}, Pf {self.probability:.4g} at {shown(self.x)}; {work}"

    @cached_property
    def importance(self) -> Mapping[str, float]:
        """Share of each variable in the variance of the linearised limit state.

        ``alpha_i^2`` of independent variables; of others the squares of the unit vector along
        ``alpha J^-1 D``, J being dx/du and D the deviations of the normal variables that replace x
        at the design point.
        """
        J = self.variables.jacobian(self.u)
        gamma = np.linalg.solve(J.T, self.alpha) * np.sqrt(np.sum(J * J, axis=1))
        share = gamma**2 / np.sum(gamma**2)
        return Frozen(dict(zip(self.variables.names, share.tolist(), strict=True)))

    @cached_property
    def by_mean(self) -> Mapping[str, float]:
        """Derivatives of beta by the mean of each variable, its deviation being the same.

        Lognormal, Weibull and gamma variables stay in their family. Empty for variables whose
        moments are no parameters: conditional ones and joint distributions.
        """
        return Frozen(self._moments(0))

    @cached_property
    def by_deviation(self) -> Mapping[str, float]:
        """Derivatives of beta by the deviation of each variable, its mean being the same."""
        return Frozen(self._moments(1))

    def _moments(self, which: int) -> dict[str, float]:
        slope = np.linalg.solve(self.variables.jacobian(self.u).T, self.gradient)
        size = float(np.linalg.norm(self.gradient))
        moves = moved_by_moments(self.variables, self.u, which)
        return {name: float(slope @ dx) / size for name, dx in moves.items()}


def moved_by_moments(variables: Transformation, u: Array, which: int) -> dict[str, Array]:
    """Return ``dx/dmean`` (which 0) or ``dx/ddeviation`` (1) of a point u, by variable."""
    x = variables.to_x(u) if variables.randoms else u
    return {one.name: moved_by(variables, u, x, one, which) for one in variables.randoms}


def moved_by(
    variables: Transformation, u: Array, x: Array, one: Random, which: int, *, tied: bool = False
) -> Array:
    """Return dx by mean (0) or deviation (1) of one variable; tied to the mean as it is kept."""
    if isinstance(one.law, Affine):  # it moves alone, and so does no correlation
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
    """Return the reliability index and design point of a limit state: first-order reliability.

    ``beta = min |u|`` with ``g(u) = 0``, u being independent standard normal variables. The method
    of Hasofer, Lind, Rackwitz and Fiessler, hlrf, takes the nearest point of the tangent,
    ``u+ = (grad g^T u - g) grad g / |grad g|^2``, with a line search on ``|u|^2 / 2 + c |g|``
    (Y. Zhang and A. Der Kiureghian, IFIP WG 7.5 (1995)); sqp adds the curvature of the surface,
    learnt on the way (BFGS), and needs fewer calls. Where its line search fails, hlrf continues as
    sqp.

    Parameters
    ----------
    limit : LimitState or callable
        ``G(x) <= 0`` is failure; x has values by name (`Values`).
    variables : sequence of Random, Nataf, Rosenblatt or JointDistribution, optional
        The random variables; a sequence is of independent ones.
    method : {"sqp", "hlrf"}
        See above.
    start : dict of float, optional
        Values where to begin; None takes the medians.
    tolerance : float
        Distance, in standard normal space, to the limit surface and across to its normal through
        the origin.
    iterations : int
        At most.
    far : float
        Largest beta that counts as a probability.

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
        If the limit state fails or is no number.
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
            f"{far:g}: probabilities of {ndtr(-abs(found.beta)):.1g} say nothing of real things; a "
            "larger far accepts it"
        )
        raise DesignPointError(message, found.u, [tuple(row) for row in found.history.tolist()])
    return found


def check_iteration(problems: Problems, where: str, tolerance: float, iterations: int) -> None:
    """Note a tolerance or a number of iterations that is none."""
    problems.positive(where, "tolerance", tolerance, "")
    whole = "a whole number, at least 1"
    problems.number(where, "iterations", iterations, "", whole, lambda x: x >= 1 and x == int(x))


def design_point(
    space: Space, u: Array, method: str, tolerance: float, iterations: int, far: float
) -> FormResult:
    """Return the design point by steps of quadratic programs with line search."""
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
        # the quadratic program: nearest point of the tangent in the metric B
        solved = np.linalg.solve(B, np.stack([u, slope], axis=1))
        lam = (g - float(slope @ solved[:, 0])) / float(slope @ solved[:, 1])
        d = -(solved[:, 0] + lam * solved[:, 1])
        longest = edge / max(float(np.linalg.norm(u + d)), 1e-300)
        if longest < 1.0:  # a nearly flat limit state points to nowhere
            d = longest * (u + d) - u
        c = max(c if used == "sqp" else 0.0, PENALTY * abs(lam))
        if used == "hlrf" and abs(g) > tolerance * size:
            c = max(c, PENALTY * 0.5 * float((u + d) @ (u + d)) / abs(g))
        slack = ROUNDING if used == "sqp" else 0.0
        moved = _along(space, u, g, d, c, float(u @ d) - c * abs(g), slack)
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
    """Return the gradient at a point or say that there is none."""
    slope = space.gradient(u, g)
    if not np.linalg.norm(slope) > 1e-14 * abs(g):
        point = shown(space.values(u))
        message = (
            f"{space.counted.where}: its gradient is zero at {point}; nothing there says where it "
            "fails: give another start; a limit that nothing random changes needs no analysis"
        )
        raise DesignPointError(message, u, rows)
    return slope


def _along(
    space: Space, u: Array, g: float, d: Array, c: float, decrease: float, slack: float
) -> tuple[Array, float] | None:
    """Return a point along d with less merit and g there, None if there is none."""
    merit = 0.5 * float(u @ u) + c * abs(g)
    failed: LimitStateError | None = None
    for k in range(HALVINGS):
        s = 0.5**k
        new = u + s * d
        try:
            g_new = space.g(new)
        except LimitStateError as error:  # a step too far may leave what can be computed
            failed = error
            continue
        allowed = merit + ARMIJO * s * min(decrease, 0.0) + slack * (1.0 + merit)
        if 0.5 * float(new @ new) + c * abs(g_new) <= allowed:
            return new, g_new
    if failed is not None:
        raise failed
    return None


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
    point = shown(space.values(u))
    where = space.counted.where
    same = all(row[2] * rows[0][2] > 0.0 for row in rows) and rows[-1][2] * g > 0.0
    if same and len(rows) <= iterations:
        found, none = ("no failure", "none") if g > 0.0 else ("nothing safe", "nothing")
        kink = "" if np.linalg.norm(u) >= far else ", or a kink of G holds the search"
        message = (
            f"{where}: {found} found; G is still {g:.4g} at {point}. There may be {none} within "
            f"beta = {far:g} (probability < {ndtr(-far):.1g}){kink}; another start makes sure"
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
