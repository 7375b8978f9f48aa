"""Progress of a run: a bar with the real-time factor and the remaining time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from jousto.base.progress import bars

Report = Callable[[float, float], None]


@contextmanager
def reporter(progress: bool | Report | None, t_end: float) -> Iterator[Report]:
    """Yield a function of the simulated time, s, and the wall time, s, that shows the progress.

    `progress` is True for a bar (see `bars`), a function, or None for no output.
    """
    if callable(progress):
        yield progress
        return
    if not progress:
        yield lambda time, wall: None
        return
    from rich.progress import BarColumn, TextColumn, TimeRemainingColumn

    bar = bars(
        TextColumn("{task.completed:.3f} of {task.total:g} s"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %  {task.fields[factor]}"),
        TextColumn("left"),
        TimeRemainingColumn(),
    )
    with bar:
        task = bar.add_task("run", total=t_end, factor="")

        def report(time: float, wall: float) -> None:
            factor = time / wall if wall > 0.0 else 0.0
            bar.update(task, completed=time, factor=f"{factor:.3g} x real time")

        yield report
