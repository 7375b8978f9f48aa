"""Linear structures under forces that are known functions of time."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import scipy.linalg as sl
import scipy.sparse as sp
from numpy.typing import ArrayLike
from scipy.signal import lfilter

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem as Trouble, Problems
from jousto.design.optimisation.elastic import Elastic, Motion
from jousto.design.optimisation.limits import Limit
from jousto.design.optimisation.problem import Problem
from jousto.design.studies.parameter import Parameter

GAUSS = np.polynomial.legendre.leggauss(5)


class StructureProblem(Problem):
    """Optimise a supported linear structure, ``M z'' + K z = F(t)`` with modal damping.

    It starts at rest. The motion is exact for forces that are polynomials of degree 4 between
    instants, whatever the frequencies of the modes: each mode by its exponential, the force by its
    polynomial through the five points of Gauss' rule.

    Parameters
    ----------
    parameters : sequence of Parameter
    matrices : function
        Returns M and K (n, n) for the parameters by name.
    force : function
        Returns F (n, nt) at times (nt,), N.
    time : (nt,) array_like
        Instants, evenly spaced from 0, s.
    cost : function
        Returns what shall be least, for the parameters by name.
    limits : sequence of Limit
        Their body is "structure", its nodes "1" .. "n", one for each degree of freedom.
    damping : float
        Ratio of all modes, below 1.
    """

    def __init__(
        self,
        parameters: Sequence[Parameter],
        matrices: Callable[[Mapping[str, float]], tuple[Any, Any]],
        force: Callable[[Array], Array],
        time: ArrayLike,
        cost: Callable[[Mapping[str, float]], float],
        limits: Sequence[Limit],
        damping: float = 0.0,
    ) -> None:
        super().__init__(parameters, limits)
        problems, where = Problems(), "StructureProblem"
        t = problems.array(where, "time", time, (None,))
        problems.number(where, "damping", damping, "", "from 0 to below 1", lambda v: 0 <= v < 1)
        if t is not None and (
            len(t) < 2 or t[0] != 0.0 or np.ptp(np.diff(t)) > 1e-9 * t[-1] or t[1] <= 0.0
        ):
            problems.add(where, "time must start at 0 and be evenly spaced")
        functions: dict[str, Any] = {"matrices": matrices, "force": force, "cost": cost}
        for key, function in functions.items():
            if not callable(function):
                problems.add(where, f"{key} is {function!r}, must be a function")
        problems.raise_if_any()
        assert t is not None
        self.time = t
        self._matrices, self._cost, self._damping = matrices, cost, damping
        x, _ = GAUSS
        h = t[1]
        share = 0.5 * (1.0 + x)
        # column j: the powers of share in the polynomial that is 1 at point j and 0 at the others
        self._powers = np.linalg.inv(np.vander(share, increasing=True))
        points = (t[:-1, None] + h * share).ravel()
        F = np.asarray(force(points), dtype=np.float64)
        if F.ndim != 2 or F.shape[1] != len(points) or not np.all(np.isfinite(F)):
            message = "force must return finite numbers (n, nt) at any times of the run"
            raise InputError(Trouble(where, message))
        self._force = F.reshape(F.shape[0], len(t) - 1, len(x))

    def cost(self, x: Array) -> float:
        """Return what shall be least."""
        return float(self._cost(self.values(x)))

    def elastic(self, x: Array) -> tuple[Elastic, ...]:
        """Return the structure."""
        K = np.asarray(self._matrices(self.values(x))[1], dtype=np.float64)
        n = len(K)
        names = {str(i + 1): i for i in range(n)}
        none = np.zeros(0, dtype=np.intp)
        return (Elastic("structure", sp.csr_array(K), none, np.zeros((n, 0)), None, names),)

    def frequencies(self, x: Array) -> Array:
        """Return the natural frequencies, Hz."""
        M, K = self._matrices(self.values(x))
        return np.asarray(np.sqrt(sl.eigh(K, M, eigvals_only=True)) / (2.0 * np.pi))

    def _weights(self, z: complex) -> Any:
        """Return the weights (5,) of ``int_0^1 exp(z (1 - s)) f(s) ds`` at Gauss' points.

        ``int_0^1 exp(z (1 - s)) s^k / k! ds = phi_(k+1)(z)``, by one exponential of a matrix
        (C. Van Loan, IEEE Trans. Autom. Control 23 (1978) 395-404).
        """
        n = len(self._powers)
        A = np.diag(np.ones(n, dtype=complex), 1)
        A[0, 0] = z
        phi = sl.expm(A)[0, 1:]
        return (phi * [math.factorial(k) for k in range(n)]) @ self._powers

    def run(self, x: Array) -> tuple[Motion, ...]:
        """Return the motion, mode by mode."""
        M, K = self._matrices(self.values(x))
        w2, shapes = sl.eigh(np.asarray(K), np.asarray(M))
        w, h = np.sqrt(w2), self.time[1]
        pole = w * (-self._damping + 1j * np.sqrt(1.0 - self._damping**2))
        q = np.zeros((len(w), len(self.time)))
        for i, p in enumerate(pole):
            f = np.tensordot(shapes[:, i], self._force, axes=(0, 0))
            pushed = f @ self._weights(p * h) * h
            s = lfilter([1.0], [1.0, -np.exp(p * h)], pushed)
            q[i, 1:] = s.imag / p.imag
        return (Motion(0, "", self.time, shapes, q),)
