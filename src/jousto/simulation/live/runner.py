"""Runner: a live machine in its own thread, in real time."""

from __future__ import annotations

import logging
import queue
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jousto.base.arrays import Array
from jousto.base.errors import InputError, JoustoError, Problem
from jousto.simulation.live.datagrams import Datagrams
from jousto.simulation.live.machine import LiveMachine
from jousto.simulation.live.real_time_clock import Pace, checked_speed
from jousto.simulation.live.recorder import Recorder
from jousto.simulation.live.thread_priority import hurry

log = logging.getLogger(__name__)

PICTURES = 60.0  # glances per second of real time
SWITCH = 2e-4  # switch interval of Python's threads, s: longest delay of a step by another thread
IDLE = 0.5  # longest wait for a command, s
ALONE = 0.02  # longest real time in one call of the engine, s; commands wait for its end
CALL = 0.005  # real time in one call of the engine at the highest possible speed, s


@dataclass(frozen=True, eq=False)
class Glance:
    """Snapshot of a live machine.

    Attributes
    ----------
    time : float
        Simulated time, s.
    q : (nq,) array
        Current positions.
    row : (row_size,) array
        The last row of the engine.
    playing : bool
        Whether the machine runs.
    factor, worst, latest : float
        Real-time factor; longest step and largest lateness, s.
    late : tuple of int
        Number of steps in each class of lateness, see `real_time_clock.EDGES`.
    missed, given_up : int
        Number of steps that ended after the next one was due; number of skipped delays.
    deferred : int
        Number of steps of bounded work that left a change of friction or an event to the next one.
    recording : str
        Path of the file being written; empty if there is none.
    message : str
        Last message: an event or a failure; empty if there is none.
    inputs : dict
        Values of the inputs by name.
    """

    time: float
    q: Array
    row: Array
    playing: bool
    factor: float
    worst: float
    latest: float
    late: tuple[int, ...]
    missed: int
    given_up: int
    deferred: int
    recording: str
    message: str
    inputs: dict[str, float]


class Runner:
    """Thread that steps a live machine until it is closed.

    Orders (`do`) are executed between two steps, first come first served.

    Parameters
    ----------
    machine : LiveMachine
        The machine; other threads may use it only through `do`.
    speed : float
        Simulated seconds per second of real time; 0 is the highest possible speed.
    playing : bool
        Whether the machine starts to run at once.
    text : str
        Text of the model file, for records.
    pace : Pace, optional
        Schedule with another clock, for tests.
    link : Datagrams, optional
        UDP link that receives inputs before each step and sends outputs after it.
    urgent : bool
        Whether to request real-time priority for the thread; `refused` lists refused requests.

    Examples
    --------
    >>> import jousto as jo
    >>> cart = jo.RigidBody("cart", 2.0, (1, 1, 1))
    >>> rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    >>> push = jo.JointForce("push", rail.displacement, jo.Input("force"))
    >>> model = jo.compile(jo.Mechanism(cart, rail, push))
    >>> runner = Runner(LiveMachine(model, jo.RK4(step=1e-3)), speed=0, playing=False)
    >>> runner.do(lambda machine: machine.set("force", 8.0))
    >>> runner.step()
    >>> f"{runner.glance.q[0]:.6f} m after {runner.glance.time:.2f} s"
    '0.000200 m after 0.01 s'
    >>> runner.close()
    """

    def __init__(
        self,
        machine: LiveMachine,
        *,
        speed: float = 1.0,
        playing: bool = True,
        text: str = "",
        pace: Pace | None = None,
        link: Datagrams | None = None,
        urgent: bool = False,
    ) -> None:
        self.machine = machine
        self.pace = Pace(machine.step_size, speed) if pace is None else pace
        self.link = link
        self.fresh = threading.Event()
        self.refused = ""
        self._text, self._playing, self._message = text, playing, ""
        self._recorder: Recorder | None = None
        self._records: list[Path] = []
        self._orders: queue.SimpleQueue[tuple[Callable[[], Any], _Answer]] = queue.SimpleQueue()
        self._woken, self._ended = threading.Event(), False
        self._shown = 0.0
        self._show()
        self._switch = sys.getswitchinterval()
        sys.setswitchinterval(SWITCH)
        self._thread = threading.Thread(target=self._run, name="jousto-live", daemon=True)
        self._thread.start()
        if urgent:
            self._ask(self._hurry)

    # -- for any thread ------------------------------------------------------------------------

    def do(self, order: Callable[[LiveMachine], Any]) -> Any:
        """Call a function with the machine between two steps, and return its result.

        Raises
        ------
        InputError
            If the runner is closed.
        """
        return self._ask(lambda: order(self.machine))

    def play(self) -> None:
        """Let the machine run."""
        self._ask(lambda: self._play(True))

    def pause(self) -> None:
        """Pause the machine."""
        self._ask(lambda: self._play(False))

    def step(self) -> None:
        """Advance to the next row, then pause."""

        def one() -> None:
            self._play(False)
            machine = self.machine
            self._advance(machine.every - machine.engine.steps_done % machine.every)

        self._ask(one)

    def reset(self) -> None:
        """Reset the machine to its initial state; a record continues in another file."""
        self._ask(self._reset)

    def speed(self, factor: float) -> None:
        """Set the simulated seconds per second of real time; 0 is the highest possible speed.

        Raises
        ------
        InputError
            If the value is neither 0 nor from 1e-6 to 1e6.
        """
        value = checked_speed(factor)
        self._ask(lambda: self.pace.start(value))

    def record(self, path: str | Path | None) -> None:
        """Record to a file from now on; None ends the record.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        self._ask(lambda: self._record(path))

    def replace(self, make: Callable[[LiveMachine], LiveMachine], text: str) -> None:
        """Replace the machine by another one; a record continues in another file."""

        def change() -> None:
            made = make(self.machine)
            self._renewed("completed", lambda: self._use(made, text))

        self._ask(change)

    def say(self, message: str) -> None:
        """Show a message in the glances; an empty text removes it."""

        def said() -> None:
            self._message = message

        self._ask(said)

    def close(self) -> None:
        """End the thread and close a record; further calls do nothing."""
        if not self._ended:
            self._ended = True
            self._woken.set()
        self._thread.join()
        sys.setswitchinterval(self._switch)

    def _ask(self, order: Callable[[], Any]) -> Any:
        answer = _Answer()
        self._orders.put((order, answer))
        self._woken.set()
        while not answer.there.wait(IDLE):
            if not self._thread.is_alive():
                raise InputError(Problem("live", "the machine was closed; make a new Runner"))
        if answer.error is not None:
            raise answer.error
        return answer.value

    # -- in its thread -------------------------------------------------------------------------

    def _hurry(self) -> None:
        self.refused = hurry()

    def _run(self) -> None:
        while not self._ended:
            while not self._orders.empty():
                order, answer = self._orders.get()
                try:
                    answer.value = order()
                except Exception as error:  # raised again in the thread that gave the command
                    answer.error = error
                self._show()
                answer.there.set()
            if not self._playing:
                self._woken.wait(IDLE)
                self._woken.clear()
                continue
            left = self.pace.left if self.pace.native else 0.0
            if left > ALONE:  # wait for orders until shortly before the step is due
                self._woken.wait(min(left - ALONE, IDLE))
                self._woken.clear()
            elif self.pace.native and self.pace.speed and self.link is None:
                self._advance(self._together(), self.pace)
            else:
                self._waited()
            if time.monotonic() - self._shown >= 0.9 / PICTURES:
                self._show()
        self._end_record("completed")
        if self.link is not None:
            self.link.close()

    def _waited(self) -> None:
        """Make due steps one by one in Python's time, each with a frame of the link."""
        self.pace.wait()
        count = self._count()
        if self.link is not None:
            self.link.before(self.machine)
        if self._advance(count):
            self.pace.done(count)
            if self.link is not None:
                self.link.after(self.machine)

    def _together(self) -> int:
        """Return the number of steps for one timed call of the engine, up to the next row."""
        machine, pace = self.machine, self.pace
        left = machine.every - machine.engine.steps_done % machine.every
        return max(1, min(left, int(ALONE * pace.speed / pace.step)))

    def _count(self) -> int:
        """Return the number of steps of the next call: 1, or more at the highest speed."""
        if self.pace.speed or self.link is not None:
            return 1
        fit = int(CALL / max(self.pace.worst, 1e-7))
        return max(1, min(fit, self.machine.every))

    def _play(self, playing: bool) -> None:
        if playing and not self._playing:
            self.pace.start()
            self._message = ""
        self._playing = playing

    def _advance(self, count: int, pace: Pace | None = None) -> bool:
        """Make steps; pause with a message on an event or a failure."""
        machine = self.machine
        try:
            rows = machine.step(count, pace)
        except Exception as error:  # after any error the thread continues, for `reset`
            if not isinstance(error, JoustoError):
                log.exception("a live machine failed")
            self._stop(
                f"{error}; reset returns to the initial state", f"failed: {error}", complete=False
            )
            return False
        if self._recorder is not None:
            self._recorder.add(rows, machine.events(), machine.contacts())
            if self._recorder.failed:
                self._stop(self._recorder.failed, "failed", complete=False)
            elif self._recorder.full:
                self._renewed("completed", lambda: None)
        else:
            machine.happened.clear()
            machine.touched.clear()
        if machine.stopped:
            message = f"stopped by event '{machine.stopped}' at {machine.time:.9g} s"
            self._stop(f"{message}; play continues from here", message)
            return False
        return True

    def _stop(self, message: str, ended: str, complete: bool = True) -> None:
        self._playing, self._message = False, message
        self._end_record(ended, complete)
        self._show()

    def _reset(self) -> None:
        self._message = ""
        self._renewed("completed", self.machine.reset)
        self.pace.forget()

    def _use(self, machine: LiveMachine, text: str) -> None:
        self.machine, self._text = machine, text
        self.pace.step = machine.step_size
        self.pace.start()

    def _renewed(self, ended: str, change: Callable[[], Any]) -> None:
        """Close the record, make a change, and continue the record in another file."""
        path = self._recorder.path if self._recorder is not None else None
        self._end_record(ended)
        change()
        if path is not None:
            self._record(self._next())
        self.pace.start()

    def _next(self) -> Path:
        """Return the path of the next record, such as crane.h5, then crane-2.h5."""
        first = self._records[0]
        number = len(self._records) + 1
        return first.with_name(f"{first.stem}-{number}{first.suffix}")

    def _record(self, path: str | Path | None) -> None:
        self._end_record("completed")
        if path is None:
            self._records.clear()
            return
        self._recorder = Recorder(Path(path), self.machine, self._text)
        self._records.append(Path(path))
        self.pace.start()

    def _end_record(self, ended: str, complete: bool = True) -> None:
        if self._recorder is not None:
            recorder, self._recorder = self._recorder, None
            recorder.close(ended, complete)

    def _show(self) -> None:
        machine, pace = self.machine, self.pace
        self._shown = time.monotonic()
        self.glance = Glance(
            time=machine.time,
            q=machine.engine.q.copy(),
            row=machine.row,
            playing=self._playing,
            factor=pace.factor,
            worst=pace.worst,
            latest=pace.latest,
            late=tuple(pace.late),
            missed=pace.missed,
            given_up=pace.given_up,
            deferred=int(machine.engine.counts.deferred),
            recording="" if self._recorder is None else str(self._recorder.path),
            message=self._message,
            inputs=machine.inputs,
        )
        self.fresh.set()


class _Answer:
    """Result or error of an order."""

    def __init__(self) -> None:
        self.there = threading.Event()
        self.value: Any = None
        self.error: Exception | None = None
