"""SLSQP with a stop at the first design that meets the first-order optimality conditions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from jousto.base.arrays import Array

FLAT = 1e-9  # change of the scaled cost at which SLSQP stops
ACTIVE = 1e-7  # distance at which a limit or bound counts as active, scaled design variables
LEFT = 1e-7  # residual of the KKT conditions, relative to the gradient of the cost


@dataclass(frozen=True, eq=False)
class Search:
    """Search for the minimum of a cost f(z) with limits g(z) >= 0, all scaled.

    The quadratic programs of SLSQP lose digits where its Hessian estimate is small or nearly
    singular: at an optimum with several active limits, a step of 3e-9 becomes 8e-8 and then 0.3 in
    a random direction, each with a line search. So the search stops at the first design that meets
    the first-order conditions.

    Attributes
    ----------
    cost, cost_slope : callable
        f (float) and df/dz (n,).
    limits, limit_slopes : callable
        g (m,) and dg/dz (m, n).
    """

    cost: Callable[[Array], float]
    cost_slope: Callable[[Array], Array]
    limits: Callable[[Array], Array]
    limit_slopes: Callable[[Array], Array]

    def least(self, z: Array, low: Array, high: Array, iterations: int) -> tuple[Array, int]:
        """Return the optimal design (n,) from a start within bounds, and SLSQP's status."""
        last: dict[str, tuple[Array, Array]] = {}

        def keep(name: str, z: Array, value: Array) -> Array:
            last[name] = z.copy(), value
            return value

        def limit_slopes(z: Array) -> Array:
            J = self.limit_slopes(z)
            (at_g, g), (at_f, slope) = last["limits"], last["cost slope"]
            if np.array_equal(at_g, z) and np.array_equal(at_f, z):
                lower, upper = z - low, high - z
                if is_optimum(slope, g, J, np.minimum(lower, upper), lower < upper):
                    raise _Optimum(z)
            return J

        minimize: Any = scipy.optimize.minimize
        try:
            found = minimize(
                self.cost,
                z,
                jac=lambda z: keep("cost slope", z, self.cost_slope(z)),
                bounds=list(zip(low, high, strict=True)),
                constraints={
                    "type": "ineq",
                    "fun": lambda z: keep("limits", z, self.limits(z)),
                    "jac": limit_slopes,
                },
                method="SLSQP",
                options={"maxiter": iterations, "ftol": FLAT},
            )
        except _Optimum as end:
            return end.z, 0
        return np.asarray(found.x), int(found.status)


class _Optimum(Exception):
    """Signal that stops SLSQP at a first-order optimum."""

    def __init__(self, z: Array) -> None:
        super().__init__("an optimum of first order")
        self.z = z.copy()


def is_optimum(slope: Array, g: Array, J: Array, inside: Array, lower: NDArray[np.bool_]) -> bool:
    """Return whether multipliers of active limits and bounds balance the gradient (KKT).

    ``df/dz = A^T lam``, ``lam >= 0`` with the rows A of the active limits and bounds. Without
    active rows the result is False: SLSQP then stops by the change of the cost.

    Parameters
    ----------
    slope : (n,) array
        df/dz.
    g, J : (m,), (m, n) array
        Limits and dg/dz.
    inside : (n,) array
        Distance to the nearer bound.
    lower : (n,) array of bool
        Whether the bound is the lower one.
    """
    sizes = np.linalg.norm(J, axis=1)
    near = ACTIVE * np.minimum(sizes, 1.0)
    active = (g <= near) & (sizes > 0.0)
    if np.any(g < -near):
        return False
    unit = np.eye(len(slope)) * np.where(lower, 1.0, -1.0)[:, None]
    A = np.concatenate([J[active] / sizes[active, None], unit[inside <= ACTIVE]])
    if not len(A):
        return False
    lam = np.linalg.lstsq(A.T, slope, rcond=None)[0]
    allowed = LEFT * float(np.linalg.norm(slope))
    return bool(np.linalg.norm(slope - lam @ A) < allowed and np.all(lam >= -allowed))
