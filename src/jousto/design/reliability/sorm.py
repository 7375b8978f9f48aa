"""Second-order reliability method (SORM): probability with the limit surface's curvature."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import log_ndtr, ndtr, ndtri

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import Problems, count, warn
from jousto.base.object_repr import described
from jousto.design.reliability.errors import DesignPointError
from jousto.design.reliability.form import FormResult, form_result
from jousto.design.reliability.inputs.space import Space
from jousto.design.reliability.limit import LimitState

STEP = 1e-3  # step of differences of a given gradient, standard deviations
STEP_OF_VALUES = 3.0  # factor on the step where second derivatives are taken from values
NOISY = 0.05  # relative change of the probability for a doubled step above which G counts as noisy


@described
@dataclass(frozen=True, eq=False)
class SormResult:
    """Probabilities of failure and the principal curvatures of the limit surface.

    Attributes
    ----------
    form : FormResult
        The design point.
    curvatures : (n - 1,) array
        Principal curvatures at the design point; positive if the surface bends away from the
        origin, so that failure is less probable than beyond the tangent.
    breitung, hohenbichler, tvedt : float
        Probabilities of failure; NaN where a formula does not hold.
    calls, gradients : int
        All calls, including those of FORM.
    """

    form: FormResult
    curvatures: Array
    breitung: float
    hohenbichler: float
    tvedt: float
    calls: int
    gradients: int

    @property
    def probability(self) -> float:
        """Probability by Tvedt's formula; by Breitung's where Tvedt's does not apply."""
        return self.breitung if math.isnan(self.tvedt) else self.tvedt

    @property
    def beta(self) -> float:
        """Reliability index ``-Phi^-1(P)`` of the probability."""
        return float(-ndtri(self.probability))

    def _facts(self) -> str:
        three = f"Breitung {self.breitung:.4g}, Hohenbichler-Rackwitz {self.hohenbichler:.4g}"
        work = count(self.calls, "call")
        return f"Pf {self.form.probability:.4g} by FORM, {three}, Tvedt {self.tvedt:.4g}; {work}"


@explained
def sorm(
    limit: LimitState | Callable[..., Any] | FormResult,
    variables: Any = None,
    *,
    step: float | None = None,
    **options: Any,
) -> SormResult:
    """Return probabilities of failure with the curvature of the limit surface.

    In the tangent plane of the design point the surface is ``u_n = beta + sum kappa_i v_i^2 / 2``.
    K. Breitung (*J. Eng. Mech.* 110 (1984) 357-366):
    ``Phi(-beta) prod (1 + beta kappa_i)^(-1/2)``; M. Hohenbichler and R. Rackwitz (*J. Eng. Mech.*
    114 (1988) 2195-2199) put ``phi(beta) / Phi(-beta)`` for beta in the product; L. Tvedt (1983)
    adds two more terms.

    Parameters
    ----------
    limit : LimitState, callable or FormResult
        ``G(x) <= 0`` is failure; a result of `form` needs no further arguments.
    variables : sequence of Random, Nataf, Rosenblatt or JointDistribution, optional
        The random variables.
    step : float, optional
        Step of second differences, in standard deviations. None: 1e-3 with a given gradient, else
        three times the root of the step of the limit state, about 0.01.
    **options
        Options of `form`.

    Returns
    -------
    SormResult
        Result; the curvatures need ``4 (n - 1)`` calls of a given gradient, or ``(n - 1) (n + 6) /
        2 + 1`` calls of the limit state.

    Raises
    ------
    InputError
        If there are no variables, or for a step that is not positive.
    DesignPointError
        If there is no design point, or the point is not the nearest one, because the surface bends
        towards the origin more than a sphere.

    Warns
    -----
    JoustoWarning
        Where one of the formulas does not hold, or curvatures change with the step: a noisy limit
        state.

    Examples
    --------
    >>> from scipy.stats import norm
    >>> from jousto.design import Random
    >>> x = [Random("a", norm(0, 1)), Random("b", norm(0, 1))]
    >>> found = sorm(lambda x: 3 + 0.1 * x["b"] ** 2 - x["a"], x)
    >>> print(f"{found.curvatures[0]:.3f}")  # the second derivative of a by b
    0.200
    """
    found = form_result("sorm", limit, variables, **options)
    problems = Problems()
    if step is not None:
        problems.positive("sorm", "step", step, "")
    problems.raise_if_any()
    space = Space(found.limit, found.variables, dict(found.fixed))
    kappa, own = _curvatures(space, found, step)
    # negative index: swap the sides, so that failure is the small probability
    side = 1.0 if found.beta >= 0.0 else -1.0
    if own.size:
        _check_noise(found, own, side)
    given = probabilities(abs(found.beta), side * kappa)
    breitung, hohenbichler, tvedt = (_swap_side(p, side) for p in given)
    if math.isnan(breitung):
        worst = float(np.min(side * kappa))
        message = (
            f"beta is {found.beta:.4g} and the least curvature {worst:.4g}: below -1/beta the "
            "point is not the nearest one of the surface; another start of form may find that"
        )
        raise DesignPointError(f"{space.counted.where}: {message}", found.u)
    for name, p in (("Hohenbichler-Rackwitz", hohenbichler), ("Tvedt", tvedt)):
        if math.isnan(p):
            warn(f"limit state '{found.name}'", f"the formula of {name} does not hold here")
    calls, gradients = found.calls + space.calls, found.gradients + space.gradients
    kappa.setflags(write=False)
    return SormResult(found, kappa, breitung, hohenbichler, tvedt, calls, gradients)


def _swap_side(p: float, side: float) -> float:
    return p if side > 0.0 else 1.0 - p


def probabilities(beta: float, kappa: Array) -> tuple[float, float, float]:
    """Return the probabilities of Breitung, of Hohenbichler and Rackwitz, and of Tvedt.

    Examples
    --------
    >>> probabilities(3.0, np.zeros(2)) == (float(ndtr(-3.0)),) * 3
    True
    """
    tail = float(ndtr(-beta))
    if np.any(1.0 + beta * kappa <= 0.0):
        return math.nan, math.nan, math.nan
    breitung = tail * _product(beta, kappa)
    log_density = -0.5 * beta * beta - 0.5 * math.log(2.0 * math.pi)
    psi = math.exp(log_density - float(log_ndtr(-beta)))
    hohenbichler = tail * _product(psi, kappa)
    both = _product(beta + 1.0, kappa)
    a = beta * tail - math.exp(log_density)
    turned = complex(np.prod(1.0 / np.sqrt(1.0 + (beta + 1j) * kappa)))
    first = _product(beta, kappa)
    tvedt = breitung + a * (first - both) + (beta + 1.0) * a * (first - turned.real)
    return breitung, hohenbichler, tvedt if tvedt > 0.0 else math.nan


def _product(factor: float, kappa: Array) -> float:
    inside = 1.0 + factor * kappa
    return float(np.prod(1.0 / np.sqrt(inside))) if np.all(inside > 0.0) else math.nan


def _curvatures(space: Space, found: FormResult, step: float | None) -> tuple[Array, Array]:
    """Return the principal curvatures (n - 1,), and the curvatures along the tangent axes.

    The curvatures along the axes, (2, n - 1), use the step and its double; their difference is an
    error of the differences.
    """
    u, n = found.u, space.n
    if n == 1:
        return np.zeros(0), np.zeros((2, 0))
    # orthonormal basis (n, n - 1) of the tangent plane
    plane = np.linalg.svd(found.alpha[None, :])[2][1:].T
    size = float(np.linalg.norm(found.gradient))
    if space.counted.has_gradient:
        h = STEP if step is None else step
        H, wide = (
            _hessian_by_gradients(space, u, plane, h),
            _hessian_by_gradients(space, u, plane, 2.0 * h),
        )
        own = np.stack([np.diag(H), np.diag(wide)])
        return np.asarray(np.linalg.eigvalsh(0.5 * (H + H.T)) / size), own / size
    h = STEP_OF_VALUES * math.sqrt(space.limit.step) if step is None else step
    H, own = _hessian_by_values(space, u, plane, h)
    return np.asarray(np.linalg.eigvalsh(H) / size), own / size


def _hessian_by_gradients(space: Space, u: Array, plane: Array, h: float) -> Array:
    """Return second derivatives in a plane by central differences of gradients."""
    ends = [
        [plane.T @ space.gradient(u + side * h * move, 0.0) for move in plane.T]
        for side in (1.0, -1.0)
    ]
    return np.asarray((np.array(ends[0]) - np.array(ends[1])) / (2.0 * h))


def _hessian_by_values(space: Space, u: Array, plane: Array, h: float) -> tuple[Array, Array]:
    """Return second derivatives in a plane by values, and its diagonal by steps h and 2 h."""
    m = plane.shape[1]
    pairs = [(i, j) for i in range(m) for j in range(i)]
    moves = [s * plane[:, i] for s in (1.0, -1.0, 2.0, -2.0) for i in range(m)]
    moves += [plane[:, i] + plane[:, j] for i, j in pairs]
    values = space.g_columns(np.stack([u + h * move for move in moves], axis=1))
    g = space.g(u)
    up, down, up_2, down_2 = values[: 4 * m].reshape(4, m)
    H = np.diag(up - 2.0 * g + down)
    for (i, j), g_ij in zip(pairs, values[4 * m :], strict=True):
        # g(a + b) = g + (g_a - g) + (g_b - g) + H_ab
        H[i, j] = H[j, i] = g_ij - up[i] - up[j] + g
    own = np.stack([np.diag(H), (up_2 - 2.0 * g + down_2) / 4.0])
    return H / h**2, own / h**2


def _check_noise(found: FormResult, own: Array, side: float) -> None:
    """Warn if a doubled step changes the probability by more than `NOISY`."""
    near, wide = (probabilities(abs(found.beta), side * kappa)[0] for kappa in own)
    if math.isnan(near) is not math.isnan(wide) or abs(wide - near) > NOISY * near:
        warn(
            f"limit state '{found.name}'",
            "its curvatures change with the step of their differences, from "
            f"{_range(own[0])} to {_range(own[1])} with twice the step: G is noisy or has a "
            "kink there; give a larger step=, or take importance_sampling, which needs no "
            "curvature",
        )


def _range(kappa: Array) -> str:
    low, high = float(kappa.min()), float(kappa.max())
    return f"{low:.3g}" if low == high else f"{low:.3g} .. {high:.3g}"
