"""Base classes of solvers: step, capabilities, stability for linear oscillations."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from jousto.base.declare import Declared, kinds
from jousto.base.fields import Choice, Flag, OptionalItem, field
from jousto.base.numbers import Duration, Number
from jousto.model.native.tableau import Tableau, tableau

if TYPE_CHECKING:
    from jousto.model.native.native import Engine

ROOM = "jousto.simulation.solvers"
EVENTS: Any = field(
    "When events and transitions between stick and slip take effect: at their instants, which are "
    "located by repetition of the step, or at the ends of steps, so that the work of a step is "
    "bounded, with an error of first order in the step",
    words=("located", "step"),
    default="located",
)


class _OfTableau:
    """Descriptor of a value of a method's tableau, read when it is first used."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __get__(self, solver: Any, cls: Any) -> int:
        return int(getattr(tableau(cls.method), self.name))


class Solver(Declared, section="solvers", by_value=True):
    """Integration method with its step; class attributes declare its capabilities."""

    method: ClassVar[str]
    """Its row of JO_METHODS in jousto.h."""
    adaptive: ClassVar[bool] = False
    """Whether it chooses its steps by their error; ``step`` is then the time between outputs."""
    needs_tangent: ClassVar[bool] = False
    """Whether it iterates with the derivatives of all forces and joints."""
    lanes: ClassVar[bool] = False
    """Whether it steps machines of one structure side by side."""
    joint_coordinates: ClassVar[bool] = True
    """Whether it integrates trees in joint coordinates."""

    if TYPE_CHECKING:

        @property
        def step(self) -> Any:
            """Step size, s; for an adaptive method the time between outputs."""

        @property
        def projection(self) -> Any:
            """Whether positions and velocities are projected after every step."""

        @property
        def baumgarte(self) -> Any:
            """Stabilisation of the acceleration equations, a `Baumgarte` or None."""

    if TYPE_CHECKING:
        order: ClassVar[int]
        evaluations: ClassVar[int]
    else:
        order = _OfTableau("order")
        evaluations = _OfTableau("stages")
        """Evaluations of the accelerations in a step, as far as they are known beforehand."""

    @property
    def options(self) -> dict[str, float | int]:
        """Further fields of the engine's jo_solver."""
        return {"step_ends": int(self.bounded)}

    @property
    def bounded(self) -> bool:
        """Whether events and transitions of friction take effect at the ends of steps."""
        return getattr(self, "events", "located") == "step"

    def unstable(self, step: float, eigenvalues: NDArray[np.complex128]) -> NDArray[np.bool_]:
        """Return a mask of the linear oscillations ``y' = lambda y`` that grow at this step."""
        return np.zeros(len(eigenvalues), dtype=bool)

    def explicit_growth(self, z: NDArray[np.complex128]) -> NDArray[np.float64]:
        """Return the growth factor per step of explicitly treated terms, z = step * lambda."""
        return np.zeros(len(z))


def solvers() -> tuple[type[Solver], ...]:
    """Return the classes of all solvers, by their names."""
    found = [cls for cls in kinds("solvers", ROOM).values() if issubclass(cls, Solver)]
    return tuple(sorted(found, key=lambda cls: cls.__name__))


def known() -> str:
    """Return the names of all solvers, for messages."""
    return ", ".join(cls.__name__ for cls in solvers())


@lru_cache(maxsize=64)
def solver_text(solver: Solver) -> str:
    """Return the call that makes a solver, as results contain it."""
    return repr(solver)


def prepared(engine: Engine, solver: Solver, step: float) -> Any:
    """Return the method as the engine stores it, with a step in s."""
    terms = solver.baumgarte
    alpha, beta = (terms.alpha, terms.beta) if terms else (0.0, 0.0)
    return engine.native_solver(
        solver.method, step, solver.projection, alpha, beta, **solver.options
    )


class Baumgarte(Declared, by_value=True):
    """Constraint stabilisation ``C'' + 2 alpha C' + beta^2 C = 0``.

    ``alpha = beta`` is critically damped. A suitable value is 1 / (10 step).
    """

    alpha: Number = field(
        "Coefficient alpha of the velocities",
        unit="1/s",
        least=0,
        wanted="0 or more, 1/s",
        plain=True,
    )
    beta: Number = field(
        "Coefficient beta of the positions",
        unit="1/s",
        least=0,
        wanted="0 or more, 1/s",
        plain=True,
    )


class Staged(Solver):
    """Method of fixed work per step, whose tableau is a row of JO_METHODS in jousto.h."""

    lanes: ClassVar[bool] = True
    step: Duration = field("Step size", default=1e-3)
    projection: Flag = field(
        "Project positions and velocities onto the constraints after every step", default=True
    )
    baumgarte: OptionalItem[Baumgarte] = field(
        "Baumgarte stabilisation, instead of or in addition to projection",
        wanted="Baumgarte(alpha, beta)",
        default=None,
    )
    events: Choice = EVENTS

    @property
    def tableau(self) -> Tableau:
        """Butcher tableau of the method."""
        return tableau(self.method)

    def explicit_growth(self, z: NDArray[np.complex128]) -> NDArray[np.float64]:
        """Return ``|1 + z b^T (E - z A)^-1 1|`` with the explicit coefficients A and weights b."""
        table = self.tableau
        rates, sums = np.ones(table.stages), np.ones(np.shape(z), np.complex128)
        power = np.ones(np.shape(z), np.complex128)
        for _ in range(table.stages):
            power = power * z
            sums += power * (table.b @ rates)
            rates = table.A @ rates
        return np.asarray(np.abs(sums))
