"""Implicit methods with Newton's iteration: generalised alpha and Newmark."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from jousto.base.fields import Choice, Flag, field
from jousto.base.numbers import Duration, Number, NumberOrWord, Whole
from jousto.simulation.solvers.base import EVENTS, Solver

STEP: Any = field("Step size", default=1e-3)
TIGHT = 1e-10  # tolerance where "auto" has no estimate of the error of the step
SHARE = 1e-3  # last change of the accelerations over their second difference with "auto"
TOLERANCE: Any = field(
    "Tolerance of Newton's iteration: last change of the accelerations in the metric of the "
    "masses, relative to the accelerations and elastic forces. auto: 0.1 % of the "
    "second difference of the accelerations of successive steps, which measures the error of the "
    "step, so that the iteration is not visible; 1e-10 until that is known and without "
    "projection. None: always `max_iterations` iterations, so that the work of a step is bounded",
    word="auto",
    least=1e-14,
    most=1e-2,
    wanted="'auto', between 1e-14 and 1e-2, or None for max_iterations iterations at every step",
    plain=True,
    default="auto",
)
MOST: Any = field(
    "Maximum number of iterations of a step. A step that does not converge, as at kinks of "
    "force laws, is repeated with damped increments and up to five times as many iterations",
    least=1,
    most=1000,
    default=10,
)
TANGENT: Any = field(
    "Whether to reuse the factors over many steps while the iteration converges fast (a step "
    "that does not converge is repeated with the exact matrix), or to factorise the exact "
    "matrix in every iteration, as complex-step derivatives always do",
    words=("exact", "modified"),
    default="modified",
)
PROJECTION: Any = field(
    "Whether to solve the velocity constraints (index 2) and project the "
    "positions, or to solve the position constraints (index 3)",
    default=True,
)
INERTIA: Any = field(
    "Whether the exact matrix includes the derivatives of inertia forces by positions and "
    "velocities: the matrices K_acc and C_acc of Makinen, Marjamaki and Pajunen (eq. 13) and "
    "the gyroscopic ones. "
    "Without them the result is the same within the tolerance, after more iterations if bodies "
    "turn fast; ``run.work.iterations`` shows what they save",
    default=True,
)


class Newton(Solver):
    """Base of the implicit methods."""

    method: ClassVar[str] = "alpha"
    evaluations: ClassVar[int] = 3
    needs_tangent: ClassVar[bool] = True
    joint_coordinates: ClassVar[bool] = False

    @property
    def baumgarte(self) -> None:
        """Baumgarte stabilisation; always None, since constraints are solved in every step."""

    @property
    def coefficients(self) -> tuple[float, float, float, float]:
        """Coefficients alpha_m, alpha_f, beta and gamma of the method."""
        raise NotImplementedError

    @property
    def options(self) -> dict[str, float | int]:
        """Further fields of the engine's jo_solver."""
        names = ("alpha_m", "alpha_f", "newmark_beta", "newmark_gamma")
        solver: Any = self
        automatic = solver.tolerance == "auto"
        return (
            super().options
            | dict(zip(names, self.coefficients, strict=True))
            | {
                "tolerance": TIGHT if automatic else solver.tolerance or 0.0,
                "error_share": SHARE if automatic and solver.projection else 0.0,
                "iterations": solver.max_iterations,
                "modified": int(solver.tangent == "modified"),
                "plain_inertia": int(not solver.inertia_tangents),
            }
        )

    def tight(self) -> Newton:
        """Return the method with a fixed tolerance instead of "auto"."""
        solver: Any = self
        return replace(solver, tolerance=TIGHT) if solver.tolerance == "auto" else self

    def unstable(self, step: float, eigenvalues: NDArray[np.complex128]) -> NDArray[np.bool_]:
        """Return a mask of oscillations that grow at this step; none with generalised alpha."""
        alpha_m, alpha_f, beta, gamma = self.coefficients
        if (alpha_m, alpha_f) != (0.0, 0.0) or 2.0 * beta >= gamma:
            return np.zeros(len(eigenvalues), dtype=bool)
        return np.asarray(spectral_radius(self, step * eigenvalues) > 1.0 + 1e-9)


class GeneralizedAlpha(Newton, tag="GeneralizedAlpha"):
    """Implicit method of order 2 with numerical damping of motions that the step does not resolve.

    Generalised alpha (Chung and Hulbert, J. Appl. Mech. 60, 1993) on the Lie group of the poses
    (Bruels, Cardona and Arnold, Mech. Mach. Theory 48, 2012), with exact derivatives of all
    forces and joints. The stiffness of springs, bushings, dampers and modes does not limit the
    step. With projection the multipliers enforce the velocity constraints (index 2), and the
    positions are projected after every step. Without it they enforce the position constraints
    (index 3), and the velocities violate theirs by the error of the method.

    Examples
    --------
    >>> GeneralizedAlpha(step=1e-3, rho=0.6).rho
    0.6
    """

    step: Duration = STEP
    rho: Number = field(
        "Spectral radius at infinite frequency, 0 to 1: amplitude ratio per step of an "
        "oscillation much faster than the step; 1 for no numerical damping",
        least=0,
        most=1,
        wanted="between 0 (damps most) and 1 (none)",
        plain=True,
        default=0.8,
    )
    tolerance: NumberOrWord = TOLERANCE
    max_iterations: Whole = MOST
    tangent: Choice = TANGENT
    projection: Flag = PROJECTION
    inertia_tangents: Flag = INERTIA
    events: Choice = EVENTS

    @property
    def coefficients(self) -> tuple[float, float, float, float]:
        """Coefficients alpha_m, alpha_f, beta and gamma of Chung and Hulbert."""
        alpha_m = (2.0 * self.rho - 1.0) / (self.rho + 1.0)
        alpha_f = self.rho / (self.rho + 1.0)
        gamma = 0.5 + alpha_f - alpha_m
        return alpha_m, alpha_f, 0.25 * (gamma + 0.5) ** 2, gamma


class Newmark(Newton, tag="Newmark"):
    """Newmark's implicit method (J. Eng. Mech. Div. ASCE 85, 1959) with Newton's iteration.

    ``q1 = q0 o exp(h v0 + h^2 ((1/2 - beta) a0 + beta a1))``, ``v1 = v0 + h ((1 - gamma) a0 +
    gamma a1)``. With beta = 1/4 and gamma = 1/2, the trapezoidal rule, a linear oscillator keeps
    its energy exactly. With gamma above 1/2 the method has damping but only order 1; for numerical
    damping at order 2 use `GeneralizedAlpha`.
    """

    step: Duration = STEP
    beta: Number = field(
        "Weight of the new acceleration in the displacement; stable at any step if "
        "``2 beta >= gamma >= 1/2``",
        above=0,
        most=1,
        wanted="between 0 and 1 and not 0",
        plain=True,
        default=0.25,
    )
    gamma: Number = field(
        "Weight of the new acceleration in the velocity",
        least=0.5,
        most=1,
        wanted="between 0.5 and 1",
        plain=True,
        default=0.5,
    )
    tolerance: NumberOrWord = TOLERANCE
    max_iterations: Whole = MOST
    tangent: Choice = TANGENT
    projection: Flag = PROJECTION
    inertia_tangents: Flag = INERTIA
    events: Choice = EVENTS

    @property
    def coefficients(self) -> tuple[float, float, float, float]:
        """Coefficients alpha_m = 0, alpha_f = 0, beta and gamma."""
        return 0.0, 0.0, self.beta, self.gamma


def spectral_radius(solver: Newton, z: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return the growth factor per step of an oscillator, with z = step * lambda.

    ``s'' = -2 d w s' - w^2 s`` with ``lambda = w (-d +- i sqrt(1 - d^2))``: the result is the
    largest magnitude of an eigenvalue of the matrix that advances (s, h s', h^2 a) by a step.
    """
    alpha_m, alpha_f, beta, gamma = solver.coefficients
    z = np.atleast_1d(np.asarray(z, dtype=np.complex128))
    out = np.zeros(z.shape)
    for i, x in np.ndenumerate(z):
        stiffness, damping = abs(x) ** 2, -2.0 * x.real
        # terms without the new acceleration a1
        rows = np.array([[1.0, 1.0, 0.5 - beta], [0.0, 1.0, 1.0 - gamma]])
        old = np.array([-stiffness, -damping, 0.0])
        left = 1.0 - alpha_m + (1.0 - alpha_f) * (stiffness * beta + damping * gamma)
        right = alpha_f * old - (1.0 - alpha_f) * (stiffness * rows[0] + damping * rows[1])
        new = (right - np.array([0.0, 0.0, alpha_m])) / left
        step = np.vstack([rows[0] + beta * new, rows[1] + gamma * new, new])
        out[i] = np.abs(np.linalg.eigvals(step)).max()
    return out
