"""Least cost with limits: scipy's SLSQP, ended where a design is an optimum of first order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from jousto.base.arrays import Array

FLAT = 1e-9  # change of the scaled cost at which SLSQP ends
ACTIVE = 1e-7  # distance of an active limit or bound, in scaled design variables
LEFT = 1e-7  # share of the slope of the cost that active limits and bounds may leave


@dataclass(frozen=True, eq=False)
class Search:
    """Minimise a cost f(z) with limits g(z) >= 0, all of them scaled.

    The quadratic programs of SLSQP lose digits where its estimate of the curvature is small or
    nearly singular: at an optimum where limits meet, a step of 3e-9 becomes 8e-8 and then 0.3 in
    a direction that rounding chooses, each with a line search. So the search ends as soon as the
    design is an optimum of first order.

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
        """Return the design (n,) from a start within bounds, and the status of SLSQP."""
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
    """SLSQP stands at an optimum of first order."""

    def __init__(self, z: Array) -> None:
        super().__init__("an optimum of first order")
        self.z = z.copy()


def is_optimum(slope: Array, g: Array, J: Array, inside: Array, lower: NDArray[np.bool_]) -> bool:
    """Return whether active limits and bounds bear the slope of the cost (Karush, Kuhn, Tucker).

    ``df/dz = A^T lam``, ``lam >= 0`` with the rows A of limits and bounds at which the design
    stands. Where none is active the answer is no: SLSQP ends there by the change of the cost.

    Parameters
    ----------
    slope : (n,) array
        df/dz.
    g, J : (m,), (m, n) array
        Limits and dg/dz.
    inside : (n,) array
        Distance to the nearer bound.
    lower : (n,) array of bool
        Whether that is the lower one.
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
