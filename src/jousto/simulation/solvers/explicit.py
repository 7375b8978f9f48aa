"""Time integration methods: each an object with its own step."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from jousto.base.declare import Declared
from jousto.base.fields import Flag, OptionalItem, field
from jousto.base.numbers import Duration, Number
from jousto.simulation.solvers.adaptive import DormandPrince
from jousto.simulation.solvers.implicit import GeneralizedAlpha, Newmark

if TYPE_CHECKING:
    from jousto.model.native.native import Engine


class Solver(Protocol):
    """What `simulate` needs to know of a method.

    ``step`` is a float, ``projection`` a bool, ``baumgarte`` a `Baumgarte` or None; they stand here
    as Any since type checkers of editors do not look through the fields of a declared class.
    """

    method: ClassVar[str]
    order: ClassVar[int]
    evaluations: ClassVar[int]
    adaptive: ClassVar[bool]

    @property
    def step(self) -> Any:
        """Step size, s; of an adaptive method the time between outputs."""

    @property
    def options(self) -> dict[str, float | int]:
        """Further fields of the engine's jo_solver."""

    @property
    def projection(self) -> Any:
        """Whether positions and velocities are projected after every step."""

    @property
    def baumgarte(self) -> Any:
        """Stabilisation of the acceleration equations, if any."""

    def unstable(self, step: float, eigenvalues: NDArray[np.complex128]) -> NDArray[np.bool_]:
        """Which linear oscillations ``y' = lambda y`` grow at this step."""

    def explicit_growth(self, z: NDArray[np.complex128]) -> NDArray[np.float64]:
        """Growth in a step of terms that the method treats explicitly, z = step * lambda."""


def prepared(engine: Engine, solver: Solver, step: float) -> Any:
    """Return the engine's own form of a method with a step in s."""
    terms = solver.baumgarte
    alpha, beta = (terms.alpha, terms.beta) if terms else (0.0, 0.0)
    return engine.native_solver(
        solver.method, step, solver.projection, alpha, beta, **solver.options
    )


class Baumgarte(Declared, by_value=True):
    """Constraint stabilisation ``C'' + 2 alpha C' + beta^2 C = 0``.

    ``alpha = beta`` is critically damped. A good size is 1 / (10 step).
    """

    alpha: Number = field(
        "Of the velocities", unit="1/s", least=0, wanted="0 or more, 1/s", plain=True
    )
    beta: Number = field(
        "Of the positions", unit="1/s", least=0, wanted="0 or more, 1/s", plain=True
    )


class Explicit(Declared, section="solvers", by_value=True):
    """What `RK4` and `ROS2` share."""

    adaptive: ClassVar[bool] = False
    step: Duration = field("Step size", default=1e-3)
    projection: Flag = field(
        "Project positions and velocities onto the constraints after every step", default=True
    )
    baumgarte: OptionalItem[Baumgarte] = field(
        "Stabilisation instead of, or besides, projection",
        wanted="Baumgarte(alpha, beta)",
        default=None,
    )

    @property
    def options(self) -> dict[str, float | int]:
        """No further fields."""
        return {}


class RK4(Explicit, tag="RK4"):
    """Classical Runge-Kutta of order 4 (Rantalainen 2007, chapter 4).

    Four evaluations a step. Stable only while ``step * omega`` stays below 2.83 for the highest
    modal frequency omega.

    Examples
    --------
    >>> RK4(step=1e-3)
    RK4(step=0.001, projection=True, baumgarte=None)
    """

    method: ClassVar[str] = "rk4"
    order: ClassVar[int] = 4
    evaluations: ClassVar[int] = 4

    def unstable(self, step: float, eigenvalues: NDArray[np.complex128]) -> NDArray[np.bool_]:
        """Return where the explicit growth exceeds 1, z = step * eigenvalue."""
        return np.asarray(self.explicit_growth(step * eigenvalues) > 1.0 + 1e-12)

    def explicit_growth(self, z: NDArray[np.complex128]) -> NDArray[np.float64]:
        """Return ``|1 + z + z^2/2 + z^3/6 + z^4/24|``."""
        return np.asarray(np.abs(1.0 + z * (1.0 + z / 2.0 * (1.0 + z / 3.0 * (1.0 + z / 4.0)))))


class ROS2(Explicit, tag="ROS2"):
    """Linearly implicit W-method of order 2 with the modal stiffness and damping implicit.

    ROS2 of Verwer, Spee, Blom and Hundsdorfer (SIAM J. Sci. Comput. 20, 1999) with
    gamma = 1 - 1/sqrt 2. Two evaluations a step and no iteration but the projection, which is one
    correction, rarely more and never more than four: the work of a step is bounded. High modal
    frequencies do not limit the step; modes that the step cannot resolve are damped.
    """

    method: ClassVar[str] = "ros2"
    order: ClassVar[int] = 2
    evaluations: ClassVar[int] = 2

    def unstable(self, step: float, eigenvalues: NDArray[np.complex128]) -> NDArray[np.bool_]:
        """Return False everywhere: the method is L-stable for the modal equations."""
        return np.zeros(len(eigenvalues), dtype=bool)

    def explicit_growth(self, z: NDArray[np.complex128]) -> NDArray[np.float64]:
        """Return ``|1 + z + z^2/2|``, what happens to all but the modal terms."""
        return np.asarray(np.abs(1.0 + z * (1.0 + z / 2.0)))


SOLVERS: tuple[type[Solver], ...] = (RK4, ROS2, GeneralizedAlpha, Newmark, DormandPrince)
