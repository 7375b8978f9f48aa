"""Time loop of a run coupled with functional mock-up units (FMUs)."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.model.native.native import Engine
from jousto.simulation.cosimulation.coupling import Coupling
from jousto.simulation.progress import Report
from jousto.simulation.running.inputs import Feed
from jousto.simulation.solvers.schedule import Schedule


class Coupled:
    """Stepper of an engine from one exchange with the FMUs to the next.

    Parameters
    ----------
    engine, native, plan, feed
        Engine, its compiled method, step schedule and inputs, as in a run of `simulate`.
    coupling : Coupling
        FMUs of the run with their connections.
    record : function
        Called with rows (k, row_size) for the results.
    """

    def __init__(
        self,
        engine: Engine,
        native: Any,
        plan: Schedule,
        feed: Feed,
        coupling: Coupling,
        record: Callable[[Array], None],
    ) -> None:
        self.engine, self.native, self.plan, self.feed = engine, native, plan, feed
        self.coupling, self.record = coupling, record
        self._rows = np.zeros((coupling.largest + 2, engine.row_size))
        self.done = 0

    def run(self, report: Report) -> str:
        """Step to the end of the run; return "ok", or the status with which it ended early."""
        started = clock.perf_counter()
        self.feed.set(self.engine, 0)
        first = self.engine.row()
        self.coupling.begin(first)
        self.record(first[None])
        while self.done < self.plan.steps:
            if self.coupling.estimates:
                status = self._twice()
            else:
                status = self._segment(self.coupling.ahead(self.done), self.record)
            if status != "ok":
                return status
            report(float(self.engine.time[0].real), clock.perf_counter() - started)
        return "ok"

    def _twice(self) -> str:
        """Make one exchange step, then repeat it as two half steps, whose results are used.

        The difference of both is the error estimate of the exchange step.
        """
        count, done = self.coupling.largest, self.done
        rewind = self.engine.mark()
        self.coupling.save()
        status = self._segment(count, lambda rows: None, lag=2)
        coarse = self.coupling.restore()
        rewind()
        self.done = done
        if status not in ("ok", "event"):
            return status
        self.coupling.again()
        for half in (1, 2):
            after = self._comparing(coarse) if half == 2 else None
            status = self._segment(count // 2, self.record, after=after)
            if status != "ok":
                return status
        return "ok"

    def _comparing(self, coarse: list[Array]) -> Callable[[], None]:
        return lambda: self.coupling.compare(coarse)

    def _segment(
        self,
        count: int,
        record: Callable[[Array], None],
        lag: int = 1,
        after: Callable[[], None] | None = None,
    ) -> str:
        """Make `count` steps of the engine up to the next exchange; return the status."""
        engine, coupling, plan = self.engine, self.coupling, self.plan
        goal, filled = self.done + count, 0
        while self.done < goal:
            left = goal - self.done
            room = min(1 if coupling.linear else left, self.feed.ahead(self.done))
            if self.done:
                self.feed.set(engine, self.done)
            coupling.extrapolate(plan.step, lag)
            before = engine.steps_done
            status, written = engine.run(self.native, min(left, room), 1, self._rows[filled:])
            coupling.audit(self._rows[filled : filled + written], plan.step)
            filled += written
            self.done += engine.steps_done - before
            if status != "ok":
                record(self._kept(filled))
                return status
        coupling.meet(self.done, lag, all_of_them=coupling.estimates)
        if after is not None:
            after()
        self._rows[filled - 1] = engine.row()  # row with the values received at this exchange
        record(self._kept(filled))
        return "ok"

    def _kept(self, filled: int) -> Array:
        """Return the rows among the first `filled` ones that belong to the results."""
        every, last = self.plan.every, self.engine.steps_done
        numbers = np.arange(last - filled + 1, last + 1)
        return np.asarray(self._rows[:filled][numbers % every == 0])
