"""Time integration methods: each an object with its own step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from jousto.engine import Model
from jousto.errors import Problems


class Solver(Protocol):
    """What `simulate` needs to know of a method."""

    method: ClassVar[int]
    order: ClassVar[int]
    evaluations: ClassVar[int]

    @property
    def step(self) -> float:
        """Step size, s."""

    @property
    def projection(self) -> bool:
        """Whether positions and velocities are projected after every step."""

    @property
    def baumgarte(self) -> Baumgarte | None:
        """Stabilisation of the acceleration equations, if any."""

    def unstable(self, step: float, eigenvalues: NDArray[np.complex128]) -> NDArray[np.bool_]:
        """Which linear oscillations ``y' = lambda y`` grow at this step."""


@dataclass(frozen=True)
class Baumgarte:
    """Constraint stabilisation ``C'' + 2 alpha C' + beta^2 C = 0``.

    Parameters
    ----------
    alpha, beta : float
        1/s; ``alpha = beta`` is critically damped. A good size is 1 / (10 step).
    """

    alpha: float
    beta: float

    def __post_init__(self) -> None:
        problems = Problems()
        for name in ("alpha", "beta"):
            value = getattr(self, name)
            if not _is_number(value) or not np.isfinite(value) or value < 0.0:
                problems.add("Baumgarte", f"{name} is {value!r}, must be 0 or more, 1/s")
        problems.raise_if_any()


@dataclass(frozen=True)
class RK4:
    """Classical Runge-Kutta of order 4 (Rantalainen 2007, chapter 4).

    Four evaluations a step. Stable only while ``step * omega`` stays below 2.83 for the highest
    modal frequency omega.

    Parameters
    ----------
    step : float
        Step size, s.
    projection : bool
        Project positions and velocities onto the constraints after every step.
    baumgarte : Baumgarte, optional
        Stabilisation instead of, or besides, projection.

    Examples
    --------
    >>> RK4(step=1e-3)
    RK4(step=0.001, projection=True, baumgarte=None)
    """

    method: ClassVar[int] = 1
    order: ClassVar[int] = 4
    evaluations: ClassVar[int] = 4
    step: float = 1e-3
    projection: bool = True
    baumgarte: Baumgarte | None = None

    def __post_init__(self) -> None:
        _check(self)

    def unstable(self, step: float, eigenvalues: NDArray[np.complex128]) -> NDArray[np.bool_]:
        """Return where ``|1 + z + z^2/2 + z^3/6 + z^4/24| > 1``, z = step * eigenvalue."""
        z = step * eigenvalues
        growth = np.abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0))))
        return np.asarray(growth > 1.0 + 1e-12)


@dataclass(frozen=True)
class ROS2:
    """Linearly implicit W-method of order 2 with the modal stiffness and damping implicit.

    ROS2 of Verwer, Spee, Blom and Hundsdorfer (SIAM J. Sci. Comput. 20, 1999) with
    gamma = 1 - 1/sqrt 2. Two evaluations a step, no iteration: the work of a step is fixed. High
    modal frequencies do not limit the step; modes that the step cannot resolve are damped.

    Parameters
    ----------
    step : float
        Step size, s.
    projection : bool
        Project positions and velocities onto the constraints after every step.
    baumgarte : Baumgarte, optional
        Stabilisation instead of, or besides, projection.
    """

    method: ClassVar[int] = 2
    order: ClassVar[int] = 2
    evaluations: ClassVar[int] = 2
    step: float = 1e-3
    projection: bool = True
    baumgarte: Baumgarte | None = None

    def __post_init__(self) -> None:
        _check(self)

    def unstable(self, step: float, eigenvalues: NDArray[np.complex128]) -> NDArray[np.bool_]:
        """Return False everywhere: the method is L-stable for the modal equations."""
        return np.zeros(len(eigenvalues), dtype=bool)


SOLVERS: tuple[type[RK4] | type[ROS2], ...] = (RK4, ROS2)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | np.number) and not isinstance(value, bool)


def _check(solver: RK4 | ROS2) -> None:
    where = type(solver).__name__
    problems = Problems()
    projection: Any = solver.projection
    baumgarte: Any = solver.baumgarte
    if not _is_number(solver.step) or not np.isfinite(solver.step) or solver.step <= 0.0:
        problems.add(where, f"step is {solver.step!r}, must be a positive number of seconds")
    if not isinstance(projection, bool):
        problems.add(where, f"projection is {projection!r}, must be True or False")
    if not isinstance(baumgarte, Baumgarte | None):
        problems.add(where, f"baumgarte is {baumgarte!r}, must be Baumgarte(alpha, beta)")
    problems.raise_if_any()


def body_eigenvalues(model: Model, body: int) -> NDArray[np.complex128]:
    """Return the eigenvalues lambda of a free body's modal motion at p = 0, 1/s.

    ``(lambda^2 M + lambda D + K) y = 0`` with the rigid coordinates eliminated. Joints can only
    lower the highest of them (Cauchy interlacing), so they bound the stable step.
    """
    b = model.bodies[body]
    if b.n == 0:
        return np.zeros(0, dtype=np.complex128)
    S, J = b.S0, b.J0
    skew = np.array([[0.0, -S[2], S[1]], [S[2], 0.0, -S[0]], [-S[1], S[0], 0.0]])
    inertia = np.array([[J[0], J[5], J[4]], [J[5], J[1], J[3]], [J[4], J[3], J[2]]])
    Mrr = np.block([[b.mass[0] * np.eye(3), -skew], [skew, inertia]])
    Mrp = np.vstack([b.I3, b.B0])
    M = np.eye(b.n) - Mrp.T @ np.linalg.lstsq(Mrr, Mrp, rcond=None)[0]
    companion = np.block(
        [
            [np.zeros((b.n, b.n)), np.eye(b.n)],
            [-np.linalg.solve(M, np.diag(b.K)), -np.linalg.solve(M, np.diag(b.D))],
        ]
    )
    return np.asarray(np.linalg.eigvals(companion), dtype=np.complex128)


def stability_warning(model: Model, solver: Solver, step: float) -> str:
    """Return a sentence if the step is too large for the model's modes, else an empty string."""
    worst: tuple[float, int] | None = None
    for i in range(len(model.bodies)):
        eigenvalues = body_eigenvalues(model, i)
        bad = eigenvalues[solver.unstable(step, eigenvalues)]
        if len(bad) and (worst is None or np.abs(bad).max() > worst[0]):
            worst = (float(np.abs(bad).max()), i)
    if worst is None:
        return ""
    omega, i = worst
    limit = largest_stable_step(model, solver, step)
    return (
        f"body '{model.bodies[i].name}' has a mode of {omega / (2 * np.pi):.4g} Hz, for which "
        f"{type(solver).__name__} needs a step below {limit:.2g} s (it is {step:.3g} s); "
        "take a smaller step, fewer modes, or ROS2"
    )


def largest_stable_step(model: Model, solver: Solver, step: float) -> float:
    """Return the largest stable step not above `step`, found by bisection, s."""
    eigenvalues = np.concatenate(
        [np.zeros(0), *(body_eigenvalues(model, i) for i in range(len(model.bodies)))]
    ).astype(np.complex128)
    low, high = 0.0, step
    for _ in range(60):
        middle = 0.5 * (low + high)
        if solver.unstable(middle, eigenvalues).any():
            high = middle
        else:
            low = middle
    return low
