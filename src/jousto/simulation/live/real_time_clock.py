"""Pace: real-time scheduling of steps, with statistics of their lateness."""

from __future__ import annotations

import time
from bisect import bisect_right
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from jousto.base.errors import InputError, Problem

EDGES = (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2)
"""Upper limits of the classes of lateness, s; the last class has none."""
SLOWEST, FASTEST = 1e-6, 1e6  # limits of the speed, simulated seconds per second of real time
FARTHEST = 0.25  # largest delay that is made up for, s; a larger one is skipped
WINDOW = 1.0  # real time over which the real-time factor is averaged, s


def checked_speed(factor: float) -> float:
    """Return the speed unchanged if it is 0 or within the limits, simulated s per s.

    Raises
    ------
    InputError
        If it is another value.
    """
    value = float(factor)
    if value != 0.0 and not SLOWEST <= value <= FASTEST:
        raise InputError(
            Problem(
                "live",
                f"speed is {factor!r}, must be from {SLOWEST:g} to {FASTEST:g} simulated seconds "
                "per second, or 0 for the highest possible speed",
            )
        )
    return value


class Pace:
    """Real-time schedule of steps, which waits for each step and counts late ones.

    Step k is due at ``start + k step / speed`` of a monotonic clock. A late step does not delay
    the due times of the next steps, which follow without waiting until the delay is made up for. A
    delay above a quarter of a second is skipped: the schedule starts again at the current time.

    Parameters
    ----------
    step : float
        Simulated time of a step, s.
    speed : float
        Simulated seconds per second of real time, 1e-6 to 1e6; 0 is the highest possible speed.
    clock, sleep : callable
        Function that returns a monotonic time, s, and function that waits for a time, s.

    Attributes
    ----------
    native : bool
        Whether the engine may wait for due times itself (see `given`); only with the default clock.
    latest, worst : float
        Largest lateness of a step, and longest time of a step, s.
    missed : int
        Number of steps that ended after the next one was due.
    given_up : int
        Number of skipped delays.

    Examples
    --------
    With a simulated clock; the third step takes too long:

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
        """Reset the statistics."""
        self._late[:] = 0
        self.latest = self.worst = 0.0
        self.missed = self.given_up = 0
        self.start()

    def start(self, speed: float | None = None) -> None:
        """Start the schedule at the current time, after a pause or at another speed."""
        self.speed = self.speed if speed is None else speed
        self._due: float | None = None
        self._began = 0.0
        self._seen: list[tuple[float, int]] = []
        self._steps = 0

    @property
    def left(self) -> float:
        """Time until the next step is due, s; 0 if it is due."""
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
        """Count the end of one or several steps."""
        now = self._clock()
        self.worst = max(self.worst, (now - self._began) / steps)
        assert self._due is not None
        if self.speed:
            self._due += steps * self.step / self.speed
            self.missed += now > self._due
            self._plan(now)
        self._count(now, steps)

    def given(self) -> dict[str, Any]:
        """Return the arguments of `Engine.paced`, which replaces calls of `wait` and `done`."""
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
        """Update the statistics by the results of `Engine.paced`."""
        now = self._clock()
        self._due = now + found["ahead"]
        self.latest, self.worst = found["latest"], found["worst"]
        self.missed = int(found["missed"])
        self._plan(now)
        self._count(now, int(found["done"]))

    def _plan(self, now: float) -> None:
        """Start the schedule again at the current time if the delay is too long."""
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
        """Number of steps in each class of lateness, see `EDGES`."""
        return list(map(int, self._late))

    @property
    def factor(self) -> float:
        """Real-time factor over the last second: simulated time over real time."""
        if len(self._seen) < 2:
            return 0.0
        (before, first), (now, last) = self._seen[0], self._seen[-1]
        return (last - first) * self.step / (now - before) if now > before else 0.0
