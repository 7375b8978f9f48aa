"""realtime: times of single steps of an exported machine on this computer."""

from __future__ import annotations

import subprocess
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.object_repr import described
from jousto.export.instruction_count import Work, work_of
from jousto.export.program import Program, program
from jousto.export.project import flat_files
from jousto.export.toolchain import build, here, platforms
from jousto.model.model import Model
from jousto.simulation.solvers.base import Solver
from jousto.simulation.state import State

NO_ALLOCATION = ("-DJO_NO_ALLOCATION",)
SECONDS = 600.0  # timeout of the measurement, s
ASKED = {"goes before other programs (SCHED_FIFO)": 1, "memory stays in place": 2}


@described
@dataclass(frozen=True, eq=False)
class StepTimes:
    """Times of single steps of an exported machine on this computer.

    Attributes
    ----------
    name : str
        Name of the mechanism.
    step : float
        Step of the method, s.
    steps : int
        Number of timed steps.
    mean, worst : float
        Mean and largest time of a step, s, including interruptions by the operating system.
    times, counts : arrays (k,)
        Upper limits of classes of 5 % width, s, and number of steps in each.
    bytes : int
        Memory of one machine, bytes; no allocation.
    granted : tuple of (str, bool)
        Requests to the operating system, and whether each was granted; empty without requests.
    work : Work or None
        Instruction count of a step; None without Valgrind.
    deferred : int
        Number of steps of bounded work that left a change of friction or an event to the next one.
    """

    name: str
    step: float
    steps: int
    mean: float
    worst: float
    times: Array
    counts: Array
    bytes: int
    granted: tuple[tuple[str, bool], ...] = ()
    work: Work | None = None
    deferred: int = 0

    def share(self, part: float) -> float:
        """Return the quantile of the step times, s, for a part of the steps such as 0.999."""
        sums = np.cumsum(self.counts)
        return min(float(self.times[np.searchsorted(sums, part * sums[-1])]), self.worst)

    @property
    def median(self) -> float:
        """Median of the step times, s."""
        return self.share(0.5)

    def rate(self, margin: float = 2.0) -> float:
        """Return the largest step rate, Hz, at which 99.99 % of the steps keep a time margin.

        ``1 / rate`` is `margin` times the 99.99 % quantile of the step times. The rate depends on
        the computer only; the accuracy of the motion at this step is not considered.
        """
        return 1.0 / (margin * self.share(0.9999))

    def __str__(self) -> str:
        micro = 1e6
        lines = [
            f"{self.name}: {self.steps} steps of {self.step:g} s on {here()}",
            f"a step     median {micro * self.median:.3g} us, mean {micro * self.mean:.3g} us",
            f"           99.9 % below {micro * self.share(0.999):.3g} us, 99.99 % below "
            f"{micro * self.share(0.9999):.3g} us, worst {micro * self.worst:.3g} us, "
            f"{self.worst / self.median:.3g} medians",
            f"memory     {self.bytes / 1024:.1f} KiB for one machine, nothing is allocated",
            f"real time  {self.step / self.mean:.3g} times; holds {self.rate():.0f} steps a second "
            "with a margin of 2",
            *(
                f"{what}: {'yes' if allowed else 'not allowed here'}"
                for what, allowed in self.granted
            ),
            *(
                [f"deferred   a change to the next step: {self.deferred} steps"]
                * (self.deferred > 0)
            ),
            str(self.work)
            if self.work is not None
            else "instructions are not counted: that needs Valgrind",
        ]
        return "\n".join(lines)


@explained
def realtime(
    model: Model,
    solver: Solver | None = None,
    *,
    state: State | None = None,
    steps: int = 1_000_000,
    urgent: bool = True,
) -> StepTimes:
    """Return the times of single steps of a machine, compiled for this computer.

    Parameters
    ----------
    model : Model
        From `compile`.
    solver : Solver, optional
        Method of fixed step; None: the choice of `simulate` for 10 s.
    state : State, optional
        Initial state; None: that of the model.
    steps : int
        Number of timed steps.
    urgent : bool
        Whether to request real-time priority (SCHED_FIFO) and locked memory from the operating
        system (Linux); `StepTimes.granted` is the result.

    Raises
    ------
    InputError
        For unsupported items, a missing compiler, or a machine whose motion diverges.
    """
    problems = Problems()
    if int(steps) < 1000:
        problems.add("realtime", f"steps is {steps}, must be 1000 or more")
    problems.raise_if_any()
    made = program(model, solver, state=state, name="machine")
    with tempfile.TemporaryDirectory(prefix="jousto-realtime-") as folder:
        binary = Path(folder) / "timing"
        flags = (*NO_ALLOCATION, "-g")  # debug information, which assigns instructions to files
        build(flat_files(made, "timing.c"), platforms(["here"])[0], binary, flags=flags)
        found = time_steps(made, binary, int(steps), urgent=urgent)
        return replace(found, work=work_of(model, binary, Path(folder)))


def time_steps(made: Program, binary: Path, steps: int, *, urgent: bool) -> StepTimes:
    """Return the step times of a program with timing.c, without instruction count.

    Raises
    ------
    InputError
        If the program takes too long, or the motion diverges.
    """
    line = [str(binary), str(steps), *(["urgent"] if urgent else [])]
    try:
        done = subprocess.run(line, capture_output=True, text=True, timeout=SECONDS)
    except subprocess.TimeoutExpired:
        message = f"{steps} steps took more than {SECONDS:g} s; give fewer steps"
        raise InputError(Problem("realtime", message)) from None
    if done.returncode:
        raise InputError(
            Problem("realtime", "the motion of the machine diverges; simulate it first")
        )
    first, *rest = done.stdout.splitlines()
    count, total, worst, size, allowed, deferred = first.split()
    asked = tuple((what, bool(int(allowed) & bit)) for what, bit in ASKED.items())
    table = np.array([[float(x) for x in row.split()] for row in rest])
    return StepTimes(
        made.model.name,
        made.solver.step,
        int(count),
        1e-9 * float(total) / int(count),
        1e-9 * float(worst),
        1e-9 * table[:, 0],
        table[:, 1],
        int(size),
        asked if urgent else (),
        deferred=int(deferred),
    )
