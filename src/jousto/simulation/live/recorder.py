"""Recorder: results file of a live machine; repeat: a run with the recorded inputs."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.files import unwritable
from jousto.model.model import Model
from jousto.simulation.live.drag_spring import NAMES
from jousto.simulation.live.machine import LiveMachine
from jousto.simulation.results.memory import Keeper
from jousto.simulation.results.solution import Solution
from jousto.simulation.results.writer import free_bytes
from jousto.simulation.solvers.base import Solver

LONGEST = 4 * 3600.0  # longest simulated time in a file, s
SHARE = 0.5  # largest size of a file over the free disk space


class Recorder:
    """Writer of the rows of a live machine into a results file, in its own thread.

    Each row is written as soon as it is computed, so that a killed program loses no rows; the
    machine does not wait for the disk.

    Parameters
    ----------
    path : path
        Results file, overwritten.
    machine : LiveMachine
        Machine to record; its integration restarts at its current state.
    text : str
        Text of the model file.

    Attributes
    ----------
    path : Path
        The file.
    failed : str
        Error of writing; empty if there was none.

    Raises
    ------
    InputError
        If the file cannot be written.
    """

    def __init__(self, path: str | Path, machine: LiveMachine, text: str = "") -> None:
        machine.restart()
        path = Path(path)
        row_bytes = 8 * len(machine.row)
        room = int(SHARE * free_bytes(path) / row_bytes)
        self._room = min(int(LONGEST / machine.interval), max(room, 2))
        about = _about(machine, machine.time + self._room * machine.interval)
        self.path, self.failed = path, ""
        self._keeper = Keeper(path, machine.model, self._room, about, text)
        self._begin, self._started = machine.time, time.perf_counter()
        self._time, self._given = machine.time, 1
        try:
            self._keeper.append(machine.row[None])  # the first row creates the file
        except OSError as error:
            self._keeper.discard()
            raise unwritable(path, error) from error
        self._queue: queue.SimpleQueue[tuple[Array, Array, Sequence[tuple[Array, int]]] | None] = (
            queue.SimpleQueue()
        )
        self._thread = threading.Thread(target=self._write, name="jousto-recorder", daemon=True)
        self._thread.start()

    @property
    def full(self) -> bool:
        """Whether the file has no room for another row."""
        return self._given >= self._room

    def add(self, rows: Array, happened: Array, touched: Sequence[tuple[Array, int]] = ()) -> None:
        """Add rows (k, row_size), events (k, 4) and contacts (k, 14) to the file."""
        rows = rows[: self._room - self._given]
        self._given += len(rows)
        if len(rows):
            self._time = float(rows[-1, 0])
        if len(rows) or len(happened) or touched:
            self._queue.put((rows, happened, touched))

    def close(self, ended: str = "completed", complete: bool = True) -> Solution:
        """Close the file and return its results, with attributes `ended` and `complete`."""
        self._queue.put(None)
        self._thread.join()
        wall = time.perf_counter() - self._started
        factor = (self._time - self._begin) / wall if wall > 0 else 0.0
        facts = {"ended": ended, "wall_time": wall, "real_time_factor": factor}
        return self._keeper.close(complete, facts)

    def _write(self) -> None:
        while (item := self._queue.get()) is not None:
            if self.failed:
                continue
            try:
                self._keeper.append(item[0])
                self._keeper.note(item[1])
                for some in item[2]:
                    self._keeper.touch(*some)
            except OSError as error:
                self.failed = f"cannot write {self.path}: {error}"


def _about(machine: LiveMachine, t_end: float) -> dict[str, Any]:
    """Return the attributes of the results that are known before the run."""
    return {
        "solver": repr(machine.solver),
        "chosen": "",
        "step": machine.step_size,
        "t_end": t_end,
        "gravity": machine.model.gravity,
        "evaluations_per_step": machine.solver.evaluations,
        "every": machine.every,
    }


@explained
def repeat(
    recorded: Solution,
    model: Model,
    solver: Solver,
    *,
    path: str | Path | None = None,
    watch: Callable[[LiveMachine], Any] | None = None,
) -> Solution:
    """Return the results of a run with the inputs of a recorded live run, drags included.

    On the same computer the results equal those of the record to the last bit.

    Parameters
    ----------
    recorded : Solution
        Results of the live run.
    model : Model
        Model of the live run, from `compile`.
    solver : Solver
        Method of the live run.
    path : path, optional
        Results file; None keeps the results in memory.
    watch : function, optional
        Called with the machine after every row.

    Returns
    -------
    Solution
        The results.

    Raises
    ------
    InputError
        If `recorded` is not the results of a live run of this model.
    """
    about = recorded.attributes
    wanted, inputs = (*model.inputs, *NAMES), recorded.inputs
    if "every" not in about or tuple(inputs) != wanted or not recorded.nt:
        message = "are not those of a live run of this model; jousto live --record makes them"
        raise InputError(Problem(recorded.where, message))
    step, every = float(about["step"]), int(about["every"])
    machine = LiveMachine(
        model,
        solver,
        step=step,
        interval=step * every,
        state=recorded.state(float(recorded.time[0])),
    )
    for name, column in inputs.items():
        machine.set(name, column[0])
    machine.restart()
    keeper = Keeper(
        path,
        machine.model,
        recorded.nt,
        _about(machine, float(about["t_end"])),
        recorded.model_text,
    )
    keeper.append(machine.row[None])
    started, ended = time.perf_counter(), "completed"
    for k in range(1, recorded.nt):
        for name, column in inputs.items():
            machine.set(name, column[k])
        rows = machine.step(every)
        keeper.append(rows)
        keeper.note(machine.events())
        for some in machine.contacts():
            keeper.touch(*some)
        if watch is not None:
            watch(machine)
        if machine.stopped:
            ended = f"stopped by event '{machine.stopped}' at {machine.time:.9g} s"
            break
    wall = time.perf_counter() - started
    factor = (machine.time - float(recorded.time[0])) / wall if wall > 0 else 0.0
    facts = {"ended": ended, "wall_time": wall, "real_time_factor": factor}
    return keeper.close(True, facts)
