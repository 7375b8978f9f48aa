"""Pace: steps at their time by the watch, and how late they were."""

from __future__ import annotations

import time
from bisect import bisect_right
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from jousto.base.errors import InputError, Problem

EDGES = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2)
"""Upper ends of the classes of lateness, s; the last class has none."""

SLOWEST, FASTEST = 1e-6, 1e6  # simulated seconds in a second of the watch

FARTHEST = 0.25  # s behind; what is further behind is given up
WINDOW = 1.0  # s of the watch over which the real-time factor is taken


def checked_speed(factor: float) -> float:
    """Return the simulated seconds in a second of the watch, 0 or within the bounds.

    Raises
    ------
    InputError
        If it is anything else.
    """
    value = float(factor)
    if value != 0.0 and not SLOWEST <= value <= FASTEST:
        raise InputError(
            Problem(
                "live",
                f"speed is {factor!r}, must be from {SLOWEST:g} to {FASTEST:g} simulated seconds a "
                "second, or 0 for as fast as it can",
            )
        )
    return value


class Pace:
    """Waits for the time of each step and keeps count of how late it began.

    Step k is due at ``start + k step / speed`` of a clock that never jumps. A step that is late
    does not move the next ones: they follow at once until the machine has caught up. If it is
    more than a quarter of a second behind, what is missing is given up and the plan starts anew.

    Parameters
    ----------
    step : float
        Step, s simulated.
    speed : float
        Simulated seconds in a second of the watch, 1e-6 to 1e6; 0 is as fast as it can.
    clock, sleep : callable
        Monotonic time in s, and a function that waits that long.

    Attributes
    ----------
    native : bool
        Whether the engine may wait itself (see `given`): not with another clock.
    latest, worst : float
        Largest lateness, and longest time that a step took, s.
    missed : int
        Steps that ended after the next one was due.
    given_up : int
        How often the plan started anew.

    Examples
    --------
    A clock that is moved by hand; the third step takes too long:

    >>> now = [0.0]
    >>> pace = Pace(1e-3, clock=lambda: now[0], sleep=lambda s: now.__setitem__(0, now[0] + s))
    >>> for work in (0.2e-3, 0.2e-3, 1.7e-3, 0.2e-3, 0.2e-3):
    ...     pace.wait()
    ...     now[0] += work
    ...     pace.done()
    >>> pace.late, pace.missed
    ([4, 0, 0, 1, 0, 0, 0, 0], 1)
    """

    def __init__(
        self,
        step: float,
        speed: float = 1.0,
        *,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.step, self.speed = step, checked_speed(speed)
        self._clock, self._sleep = clock, sleep
        self.native = clock is time.monotonic and sleep is time.sleep
        self._edges, self._late = np.array(EDGES), np.zeros(len(EDGES) + 1, np.int64)
        self.forget()

    def forget(self) -> None:
        """Count anew."""
        self._late[:] = 0
        self.latest = self.worst = 0.0
        self.missed = self.given_up = 0
        self.start()

    def start(self, speed: float | None = None) -> None:
        """Plan anew from now: after a pause, or at another speed."""
        self.speed = self.speed if speed is None else speed
        self._due: float | None = None
        self._began = 0.0
        self._seen: list[tuple[float, int]] = []
        self._steps = 0

    @property
    def left(self) -> float:
        """Time of the clock until the next step is due, s; 0 if it is."""
        return 0.0 if self._due is None or not self.speed else max(0.0, self._due - self._clock())

    def wait(self) -> None:
        """Wait until the next step is due."""
        now = self._clock()
        if self._due is None:
            self._due = now
        if self.speed:
            while now < self._due:
                self._sleep(self._due - now)
                now = self._clock()
            late = now - self._due
            self._late[bisect_right(EDGES, late)] += 1
            self.latest = max(self.latest, late)
        self._began = now

    def done(self, steps: int = 1) -> None:
        """Note that the step, or several, ended."""
        now = self._clock()
        self.worst = max(self.worst, (now - self._began) / steps)
        assert self._due is not None
        if self.speed:
            self._due += steps * self.step / self.speed
            self.missed += now > self._due
            self._plan(now)
        self._count(now, steps)

    def given(self) -> dict[str, Any]:
        """Return what `Engine.paced` needs, which waits instead of `wait` and `done`."""
        now = self._clock()
        if self._due is None:
            self._due = now
        return {
            "step": self.step / self.speed,
            "farthest": FARTHEST,
            "ahead": self._due - now,
            "latest": self.latest,
            "worst": self.worst,
            "missed": self.missed,
            "edges": self._edges,
            "late": self._late,
        }

    def took(self, found: Mapping[str, float]) -> None:
        """Note what `Engine.paced` returned."""
        now = self._clock()
        self._due = now + found["ahead"]
        self.latest, self.worst = found["latest"], found["worst"]
        self.missed = int(found["missed"])
        self._plan(now)
        self._count(now, int(found["done"]))

    def _plan(self, now: float) -> None:
        """Give up what is too far behind."""
        if self._due is not None and now - self._due > FARTHEST:
            self._due = now
            self.given_up += 1

    def _count(self, now: float, steps: int) -> None:
        self._steps += steps
        if not self._seen or now - self._seen[-1][0] > 0.05 * WINDOW:
            self._seen.append((now, self._steps))
        while len(self._seen) > 2 and now - self._seen[1][0] >= WINDOW:
            self._seen.pop(0)

    @property
    def late(self) -> list[int]:
        """Steps by lateness, in the classes of `EDGES`."""
        return list(map(int, self._late))

    @property
    def factor(self) -> float:
        """Simulated seconds in a second of the watch, over the last second."""
        if len(self._seen) < 2:
            return 0.0
        (before, first), (now, last) = self._seen[0], self._seen[-1]
        return (last - first) * self.step / (now - before) if now > before else 0.0
