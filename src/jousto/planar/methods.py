"""Time integration methods and convergence criteria of planar frames."""

from __future__ import annotations

from typing import Any, Protocol

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, OptionalPositive, Positive, Whole


class Method(Protocol):
    """Interface of the generalised-alpha family of implicit methods.

    ``q' = q + h v + h^2 ((1/2 - beta) s + beta s')``, ``v' = v + h ((1 - gamma) s + gamma s')`` and
    ``(1 - alpha_m) s' + alpha_m s = (1 - alpha_f) a' + alpha_f a``, where a are the accelerations,
    which satisfy the equations of motion at the end of each step.
    """

    @property
    def step(self) -> Any:
        """Step, s."""

    @property
    def weights(self) -> tuple[float, float, float, float]:
        """Return the coefficients alpha_m, alpha_f, beta, gamma."""


class PlanarNewmark(Declared, by_value=True):
    """Newmark's method, ``gamma = 1/2 + damping, beta = (1 + damping)^2 / 4``.

    N. M. Newmark, *J. Eng. Mech. Div. ASCE* 85 (1959) 67-94; the parameter as in M. Geradin,
    A. Cardona, *Flexible Multibody Dynamics*, Wiley 2001.
    """

    step: Positive = field("Step", unit="s")
    damping: Number = field(
        "Numerical damping; 0 is the trapezoidal rule, of order 2",
        least=0,
        most=0.5,
        wanted="a number from 0 to 0.5",
        default=0.0,
    )

    @property
    def weights(self) -> tuple[float, float, float, float]:
        """Return the coefficients alpha_m, alpha_f, beta, gamma."""
        return 0.0, 0.0, 0.25 * (1.0 + self.damping) ** 2, 0.5 + self.damping


class PlanarGeneralizedAlpha(Declared, by_value=True):
    """Generalised-alpha method of Chung and Hulbert, of order 2, with adjustable damping.

    J. Chung, G. M. Hulbert, *J. Appl. Mech.* 60 (1993) 371-375; in the form of M. Arnold, O. Bruls,
    *Multibody Syst. Dyn.* 18 (2007) 185-202, for variable mass matrices.
    """

    step: Positive = field("Step", unit="s")
    rho: Number = field(
        "Spectral radius at high frequency, 0 to 1: amplitude ratio of a fast oscillation per step",
        least=0,
        most=1,
        wanted="a number from 0 to 1",
        default=0.8,
    )

    @property
    def weights(self) -> tuple[float, float, float, float]:
        """Return the coefficients alpha_m, alpha_f, beta, gamma."""
        am, af = (2.0 * self.rho - 1.0) / (self.rho + 1.0), self.rho / (self.rho + 1.0)
        return am, af, 0.25 * (1.0 - am + af) ** 2, 0.5 - am + af


class Convergence(Declared, by_value=True):
    """Convergence criteria of Newton's iteration, all of which must be satisfied.

    Norms are Euclidean, over the unsupported unknowns, in N and N m, or m and rad.

    Raises
    ------
    InputError
        For criteria that are not positive.
    """

    residual: OptionalPositive = field("``|r| <= residual``, N and N m", default=None)
    relative: OptionalPositive = field(
        "``|r| <= relative * (largest of |F_int|, |F_ext|, |M u''|)``, or the rounding error "
        "``4 eps EA (1 + |u| / L)`` if it is larger; 1e-9 unless another criterion is given",
        default=None,
    )
    increment: OptionalPositive = field(
        "``|dq| <= increment``, m and rad. The residual after the last correction is not "
        "evaluated, which saves time",
        default=None,
    )
    max_iterations: Whole = field(
        "Maximum number of corrections of a step", least=1, most=10**6, default=25
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Set the default criterion if none is given."""
        if self.residual is None and self.relative is None and self.increment is None:
            object.__setattr__(self, "relative", 1e-9)
