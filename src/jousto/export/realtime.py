"""What a machine can hold in real time: the times of single steps of its program on a computer."""

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
from jousto.export.project import flat
from jousto.export.toolchain import build, here, platforms
from jousto.model.model import Model
from jousto.simulation.solvers.explicit import Solver
from jousto.simulation.state import State

NO_ALLOCATION = ("-DJO_NO_ALLOCATION",)
SECONDS = 600.0  # that the measurement may take
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
        Its own step, s.
    steps : int
        How many were timed.
    mean, worst : float
        s; the worst holds what the operating system did meanwhile.
    times, counts : arrays (k,)
        Upper ends of classes of 5 %, s, and how many steps fell into each.
    bytes : int
        Memory of one machine; nothing is allocated.
    granted : tuple of (str, bool)
        What was asked of the operating system, and whether it was granted; empty if nothing was.
    work : Work or None
        Instructions of a step; None without Valgrind.
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

    def share(self, part: float) -> float:
        """Return the time that a part of the steps, such as 0.999, stayed below, s."""
        sums = np.cumsum(self.counts)
        return min(float(self.times[np.searchsorted(sums, part * sums[-1])]), self.worst)

    @property
    def median(self) -> float:
        """Half of the steps took no longer, s."""
        return self.share(0.5)

    def rate(self, margin: float = 2.0) -> float:
        """Return the largest rate in Hz at which 99.99 % of the steps keep a margin.

        A step of ``1 / rate`` is `margin` times as long as all but one of 10,000 steps took. It is
        the rate that this computer keeps up with, not one at which the motion is right.
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
    """Compile a machine for this computer and time its single steps.

    Parameters
    ----------
    model : Model
        From `compile`.
    solver : Solver, optional
        Method of fixed step; None is that which `simulate` chooses for 10 s.
    state : State, optional
        Where it starts; None is the initial state of the model.
    steps : int
        How many steps are timed.
    urgent : bool
        Ask the operating system that the program goes before others (SCHED_FIFO) and that its
        memory stays in place; `StepTimes.granted` is what it allowed. Linux.

    Raises
    ------
    InputError
        For what cannot be exported, a missing compiler, or a machine whose motion diverges.
    """
    problems = Problems()
    if int(steps) < 1000:
        problems.add("realtime", f"steps is {steps}, must be 1000 or more")
    problems.raise_if_any()
    made = program(model, solver, state=state, name="machine")
    with tempfile.TemporaryDirectory(prefix="jousto-realtime-") as folder:
        binary = Path(folder) / "timing"
        flags = (*NO_ALLOCATION, "-g")  # its lines say whose the instructions are
        build(flat(made, "timing.c"), platforms(["here"])[0], binary, flags=flags)
        found = timed(made, binary, int(steps), urgent=urgent)
        return replace(found, work=work_of(model, binary, Path(folder)))


def timed(made: Program, binary: Path, steps: int, *, urgent: bool) -> StepTimes:
    """Return the times of the steps of a program made of timing.c; its work is not counted.

    Raises
    ------
    InputError
        If it takes too long, or the motion diverges.
    """
    line = [str(binary), str(steps), *(["urgent"] if urgent else [])]
    try:
        done = subprocess.run(line, capture_output=True, text=True, timeout=SECONDS)
    except subprocess.TimeoutExpired:
        message = f"{steps} steps took more than {SECONDS:g} s; time fewer"
        raise InputError(Problem("realtime", message)) from None
    if done.returncode:
        raise InputError(
            Problem("realtime", "the motion of the machine diverges; simulate it first")
        )
    first, *rest = done.stdout.splitlines()
    count, total, worst, size, allowed = first.split()
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
    )
