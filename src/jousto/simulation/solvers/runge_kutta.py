"""Explicit Runge-Kutta methods."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from jousto.simulation.solvers.base import Staged


class RungeKutta(Staged):
    """Base of explicit methods, which are stable if `explicit_growth` is at most 1."""

    def unstable(self, step: float, eigenvalues: NDArray[np.complex128]) -> NDArray[np.bool_]:
        """Return a mask of eigenvalues with an explicit growth above 1, z = step * eigenvalue."""
        return np.asarray(self.explicit_growth(step * eigenvalues) > 1.0 + 1e-12)


class RK4(RungeKutta, tag="RK4"):
    """Classical Runge-Kutta of order 4 (Rantalainen 2007, chapter 4).

    A step takes four evaluations. The method is stable only while ``step * omega`` stays below 2.83
    for the highest modal frequency omega.

    Examples
    --------
    >>> RK4(step=1e-3)
    RK4(step=0.001, projection=True, baumgarte=None, events='located')
    """

    method: ClassVar[str] = "rk4"


class SSPRK3(RungeKutta, tag="SSPRK3"):
    """Strong stability preserving Runge-Kutta method of order 3.

    Shu and Osher (J. Comput. Phys. 77, 1988), eq. 2.18: the stages are averages of Euler steps. A
    step takes three evaluations. The method is stable only while ``step * omega`` stays below 1.73
    for the highest modal frequency omega.
    """

    method: ClassVar[str] = "ssprk3"
