"""Time integration methods and criteria of convergence, as objects."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from jousto.base.errors import Problems


class Method(Protocol):
    """An implicit method of the family of generalised-alpha methods.

    ``q' = q + h v + h^2 ((1/2 - beta) s + beta s')``, ``v' = v + h ((1 - gamma) s + gamma s')`` and
    ``(1 - alpha_m) s' + alpha_m s = (1 - alpha_f) a' + alpha_f a``, where a are the accelerations,
    which satisfy the equations of motion at the end of each step.
    """

    @property
    def step(self) -> float:
        """Step, s."""

    @property
    def weights(self) -> tuple[float, float, float, float]:
        """Return alpha_m, alpha_f, beta, gamma."""


@dataclass(frozen=True)
class PlanarNewmark:
    """Newmark's method, ``gamma = 1/2 + damping, beta = (1 + damping)^2 / 4``.

    N. M. Newmark, *J. Eng. Mech. Div. ASCE* 85 (1959) 67-94; the parameter as in M. Geradin,
    A. Cardona, *Flexible Multibody Dynamics*, Wiley 2001.

    Parameters
    ----------
    step : float
        s.
    damping : float
        Numerical damping; 0 is the trapezoidal rule, of order 2.
    """

    step: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        problems = Problems()
        problems.positive("PlanarNewmark", "step", self.step, "s")
        wanted = "a number from 0 to 0.5"
        problems.number(
            "PlanarNewmark", "damping", self.damping, "", wanted, lambda x: 0.0 <= x <= 0.5
        )
        problems.raise_if_any()

    @property
    def weights(self) -> tuple[float, float, float, float]:
        """Return alpha_m, alpha_f, beta, gamma."""
        return 0.0, 0.0, 0.25 * (1.0 + self.damping) ** 2, 0.5 + self.damping


@dataclass(frozen=True)
class PlanarGeneralizedAlpha:
    """The method of Chung and Hulbert, of order 2, with the damping chosen.

    J. Chung, G. M. Hulbert, *J. Appl. Mech.* 60 (1993) 371-375; for systems whose mass changes in
    the form of M. Arnold, O. Bruls, *Multibody Syst. Dyn.* 18 (2007) 185-202.

    Parameters
    ----------
    step : float
        s.
    rho : float
        Share of an oscillation much faster than the step that is left after a step, 0 to 1.
    """

    step: float
    rho: float = 0.8

    def __post_init__(self) -> None:
        problems = Problems()
        problems.positive("PlanarGeneralizedAlpha", "step", self.step, "s")
        problems.number(
            *("PlanarGeneralizedAlpha", "rho", self.rho, "", "a number from 0 to 1"),
            lambda x: 0.0 <= x <= 1.0,
        )
        problems.raise_if_any()

    @property
    def weights(self) -> tuple[float, float, float, float]:
        """Return alpha_m, alpha_f, beta, gamma."""
        am, af = (2.0 * self.rho - 1.0) / (self.rho + 1.0), self.rho / (self.rho + 1.0)
        return am, af, 0.25 * (1.0 - am + af) ** 2, 0.5 - am + af


@dataclass(frozen=True)
class Convergence:
    """When Newton's iteration ends: all criteria given must be met.

    Norms are Euclidean, over unknowns that are not held, in N and N m or m and rad as they come.

    Parameters
    ----------
    residual : float, optional
        ``|r| <= residual``, N and N m.
    relative : float, optional
        ``|r| <= relative * (largest of |F_int|, |F_ext|, |M u''|)``, or what rounding leaves if
        that is more, ``4 eps EA (1 + |u| / L)``. The default is 1e-9 unless another criterion is
        given.
    increment : float, optional
        ``|dq| <= increment``, m and rad. The residual after that correction is not looked at, so
        that the last correction costs no evaluation.
    max_iterations : int
        Most corrections of a step.

    Raises
    ------
    InputError
        For criteria that are not positive.
    """

    residual: float | None = None
    relative: float | None = None
    increment: float | None = None
    max_iterations: int = 25

    def __post_init__(self) -> None:
        problems = Problems()
        for name in ("residual", "relative", "increment"):
            if getattr(self, name) is not None:
                problems.positive("Convergence", name, getattr(self, name), "")
        problems.number(
            *("Convergence", "max_iterations", self.max_iterations, "", "an integer from 1"),
            lambda x: x >= 1 and x == int(x),
        )
        problems.raise_if_any()
        if self.residual is None and self.relative is None and self.increment is None:
            object.__setattr__(self, "relative", 1e-9)
