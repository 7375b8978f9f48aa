"""Adaptive method: step control by the error estimate, results at equally spaced times."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from jousto.base.fields import field
from jousto.base.numbers import Duration, Number, OptionalDuration, OptionalNumber
from jousto.model.native.native import Engine
from jousto.simulation.progress import Report
from jousto.simulation.solvers.base import Solver

WALL_PER_CALL = 0.1  # wall time of a call of the engine, s; progress and Ctrl-C act between calls
LONGEST = 0.1  # default largest step over the duration of the run


class DormandPrince(Solver, tag="DormandPrince"):
    """Runge-Kutta pair of orders 5 and 4 with step control by the error estimate.

    Dormand and Prince (J. Comp. Appl. Math. 6, 1980) with the step control and the dense output
    of order 4 of Hairer, Norsett and Wanner (*Solving Ordinary Differential Equations I*, 1993,
    II.4 to II.6). A step takes six evaluations. Results are at equally spaced times, interpolated
    within the steps; a step ends where a `Step`, `Ramp`, `Table` or `SCurve` jumps or has a kink.

    The method is explicit: stiff springs and modes of high frequency force small steps even if they
    are at rest; then `ROS2` is faster.

    Examples
    --------
    >>> DormandPrince(tolerance=1e-8).tolerance
    1e-08
    """

    method: ClassVar[str] = "dopri"
    evaluations: ClassVar[int] = 6
    adaptive: ClassVar[bool] = True
    most: ClassVar[int] = 100_000  # maximum number of steps between two outputs
    tolerance: Number = field(
        "Largest error of a step: of positions, as a share of the size of the mechanism; of "
        "rotations, in rad; of speeds, as a share of the largest speed of the body so far; of "
        "modal coordinates and their rates, as a share of the largest so far of the body. "
        "Reference values are at least a thousandth of the size of the mechanism, and a "
        "thousandth of that size per duration of the run for speeds",
        least=1e-13,
        most=0.1,
        wanted="between 1e-13 and 0.1",
        plain=True,
        default=1e-6,
    )
    absolute: OptionalNumber = field(
        "Absolute tolerance, m and m/s (rad and rad/s times the size of the mechanism): smaller "
        "errors are ignored; None for zero",
        unit="m",
        above=0,
        wanted="None or positive, m",
        plain=True,
        default=None,
    )
    first_step: OptionalDuration = field(
        "First trial step; None to estimate it from speeds, accelerations and frequencies",
        default=None,
    )
    max_step: OptionalDuration = field(
        "Largest step; None for a tenth of the run. Steps longer than a short pulse of a "
        "`UserForce` may miss it",
        default=None,
    )
    output: Duration = field(
        "Time between stored instants, unless `simulate` is given an `output_step`", default=1e-2
    )

    @property
    def projection(self) -> bool:
        """Whether positions and velocities are projected after every step; always true."""
        return True

    @property
    def baumgarte(self) -> None:
        """Baumgarte stabilisation; always None, since the projection closes the constraints."""

    @property
    def step(self) -> float:
        """Time between outputs, s."""
        return self.output

    @property
    def options(self) -> dict[str, float | int]:
        """Fields of the engine's jo_solver."""
        return {
            "tolerance": self.tolerance,
            "absolute": self.absolute or 0.0,
            "first": self.first_step or 0.0,
            "largest": self.max_step or 0.0,
            "iterations": self.most,
        }

    def explicit_growth(self, z: NDArray[np.complex128]) -> NDArray[np.float64]:
        """Return the growth factor ``|1 + z + ... + z^5/120 + z^6/600|`` of a step."""
        sums = z / 5.0  # Horner's scheme: one term of the series per line
        for k in (5.0, 4.0, 3.0, 2.0, 1.0):
            sums = z / k * (1.0 + sums)
        return np.asarray(np.abs(1.0 + sums))


def follow(
    engine: Engine,
    native: Any,
    last: int,
    rows: NDArray[np.float64],
    record: Callable[[NDArray[np.float64]], None],
    report: Report,
) -> str:
    """Step to row `last` in calls of about 0.1 s wall time; return "ok" or the cause of the end."""
    started = clock.perf_counter()
    tries = 1
    while engine.steps_done <= last:  # rows written so far
        before = clock.perf_counter()
        status, written = engine.follow(native, last, tries, rows)
        now = clock.perf_counter()
        record(rows[:written])
        if status != "ok":
            return status
        report(float(engine.time[0].real), now - started)
        spent = max(now - before, 1e-6)
        tries = max(1, min(int(tries * WALL_PER_CALL / spent), 4 * tries))
    return "ok"


def too_many_steps(engine: Engine, start: float, output: float) -> tuple[str, str]:
    """Return why the error control fails for rows from `start`, and the body concerned."""
    body = engine.model.bodies[engine.error_index].name
    time = float(engine.time[0].real)
    mean = (time - start - (engine.steps_done - 1) * output) / DormandPrince.most
    if mean > 1e-12 * max(abs(time), output):
        return (
            f"it needs steps of about {mean:.2g} s, more than {DormandPrince.most} between two "
            f"outputs, mostly for body '{body}': something stiff holds it (a mode of high "
            "frequency, a stiff spring or a strong damper); take ROS2 or GeneralizedAlpha, which "
            "are made for that, or something softer",
            body,
        )
    return (
        f"the step became shorter than round-off allows, body '{body}' has the largest error: a "
        "force on it jumps (let it rise over a short time, or use Step or Table signals, whose "
        "jumps are known), or it is held by something very stiff (take ROS2 or GeneralizedAlpha)",
        body,
    )
