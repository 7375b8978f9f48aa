"""Command ``monitor``: supervision of measured strains."""

from __future__ import annotations

import contextlib
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, Problem
from jousto.base.names import harmless
from jousto.cli.group import command
from jousto.cli.options import Model, Output, amount, compile_model
from jousto.cli.terminal import say

if TYPE_CHECKING:
    from jousto.measurement.monitor.watch import Progress
    from jousto.schema.read import ModelFile

STYLES = {"alarm": "bold red", "channel": "yellow", "garbage": "yellow", "backwards": "yellow"}
SHOWN = 12  # number of events below the table


@command()
def monitor(
    model: Model,
    gauges: Annotated[
        str, typer.Option("--gauges", metavar="FILE|-", help="Measured strains, - for a pipe.")
    ],
    output: Output = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue the record of a run that was killed.")
    ] = False,
    stress_limit: Annotated[
        str | None, typer.Option("--limit", metavar="STRESS", help="Alarm, such as '200 MPa'.")
    ] = None,
    csv: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Stress of all samples at the end.")
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No table, no summary.")] = False,
    plain: Annotated[
        bool, typer.Option("--plain", help="Lines instead of a table that is drawn anew.")
    ] = False,
) -> None:
    """Compute stress at hot spots, damage, remaining life and alarms from measured strains.

    The model's block monitor defines what is watched. The record is written to MODEL.monitor.h5
    unless -o names another file; it is complete at every moment, and --resume continues it. Ctrl-C
    ends it.
    """
    from dataclasses import replace

    from jousto.measurement.monitor.watch import watch
    from jousto.schema.output_paths import MONITOR, output_path
    from jousto.schema.read import read_model

    target = output_path(output, model, ".monitor.h5", kind=MONITOR)
    file = read_model(model)
    settings = file.monitor
    if settings is None:
        raise InputError(
            Problem(
                model.name,
                "has no block monitor; add monitor: {spots: [..], ..}, see docs/model-stress.md",
            )
        )
    if stress_limit is not None:
        limit = amount(stress_limit, "Pa", "--limit")
        settings = replace(settings, limits=replace(settings.limits, stress=limit))
    if gauges != "-" and Path(gauges).exists() and target.exists() and target.samefile(gauges):
        raise InputError(
            Problem(str(target), "is the input, it would be overwritten; give -o FILE")
        )
    watcher = settings.monitor(reference_run(file, model, quiet))
    drawn = sys.stdout.isatty() and not plain
    show: Any = None
    board: Any = None
    if not quiet:
        board = Board(gauges) if drawn else Lines()
        show = board.show
    with board.live() if board is not None and drawn else contextlib.nullcontext():
        record = watch(
            watcher,
            gauges,
            target,
            columns=settings.columns,
            unit=settings.unit,
            resume=resume,
            show=show,
            text=file.text,
        )
    if csv is not None:
        record.to_csv(csv)
    if not quiet:
        say(str(record))
        say(f"record in {target}", style="green")


def reference_run(file: ModelFile, model: Path, quiet: bool) -> Any:
    """Return the run that provides hot spots and motion amplitudes, None if the block has none."""
    settings = file.monitor
    if not settings.reference:
        return None
    from jousto.simulation.results.solution import load
    from jousto.simulation.running.simulate import simulate

    if settings.reference != "run":
        return load(settings.reference)
    if file.simulation is None:
        raise InputError(
            Problem(
                model.name,
                "monitor: reference: run needs a simulation time; add simulation: {t_end: 10 s}",
            )
        )
    if not quiet:
        say(f"reference run of {file.simulation.t_end:g} s")
    compiled = compile_model(file.mechanism)
    return simulate(compiled, file.simulation.t_end, **file.simulation.given(compiled))


class Lines:
    """Output of events as lines for logs and pipes, with a line of values about every 10 s."""

    def __init__(self) -> None:
        self._next = -math.inf

    def show(self, progress: Progress) -> None:
        """Print the events since the last call."""
        for time, kind, text in progress.events:
            at = "" if math.isnan(time) else f"{time:12.3f} s  "
            message = text if kind == "alarm" else f"{kind}: {text}"
            say(f"{at}{message}", style=STYLES.get(kind, ""))
        update = progress.update
        from time import monotonic

        if len(update.time) and monotonic() >= self._next:
            self._next = monotonic() + 10.0
            parts = [
                f"{spot} {value / 1e6:.4g} MPa"
                for spot, value in zip(progress.monitor.spots, update.stress[-1], strict=True)
            ]
            say(f"{update.time[-1]:12.3f} s  {', '.join(parts)}")


class Board:
    """Output as a table that is redrawn while samples arrive."""

    def __init__(self, name: str) -> None:
        self.name = name
        self._events: list[tuple[float, str, str]] = []
        self._peaks: Any = None
        self._live: Any = None

    def live(self) -> Any:
        """Return the context manager that displays the table."""
        from rich.live import Live

        self._live = Live(refresh_per_second=4, transient=True)
        return self._live

    def show(self, progress: Progress) -> None:
        """Redraw the table."""
        self._events = [*self._events, *progress.events][-SHOWN:]
        if self._live is not None:
            self._live.update(self.table(progress))

    def table(self, progress: Progress) -> Any:
        """Return the table of the present values."""
        import numpy as np
        from rich.console import Group
        from rich.table import Table
        from rich.text import Text

        from jousto.measurement.monitor.health import STATES
        from jousto.measurement.monitor.record_reader import duration

        monitor, update, place = progress.monitor, progress.update, progress.place
        if len(update.time):
            now = np.abs(update.stress)
            top = np.fmax.reduce(now, axis=0)
            self._peaks = top if self._peaks is None else np.fmax(self._peaks, top)
        life = monitor.life
        active = {spot for _, spot in monitor.alarms.active}
        title = Text(harmless(f"{self.name}: {place.time:.3f} s"))
        table = Table(title=title, title_justify="left")
        for head in ("hot spot", "MPa now", f"{100 * monitor.level:g} % band", "MPa peak"):
            table.add_column(head, justify="left" if head == "hot spot" else "right")
        if life is not None:
            for head in ("damage", "remaining life", "band"):
                table.add_column(head, justify="right")
        for k, spot in enumerate(monitor.spots):
            peak = "" if self._peaks is None else f"{self._peaks[k] / 1e6:.4g}"
            row: list[Any] = [Text(harmless(spot)), "", "", peak]
            if len(update.time):
                value, low, high = (
                    x[-1, k] / 1e6 for x in (update.stress, update.low, update.high)
                )
                row[1:3] = [f"{value:.4g}", f"{low:.4g} .. {high:.4g}"]
            if life is not None:
                row += [
                    f"{life.damage[k]:.3g}",
                    duration(life.remaining[k]),
                    f"{duration(life.remaining_low[k])} .. {duration(life.remaining_high[k])}",
                ]
            table.add_row(*row, style="bold red" if spot in active else "")
        bad = [
            f"{name} {STATES[state]}"
            for name, state in zip(monitor.channels, monitor.health.state, strict=True)
            if state
        ]
        health = f"channels: {', '.join(bad) if bad else 'all ok'}"
        lost = f"invalid lines: {place.garbage}, backwards in time: {place.backwards}"
        lines = [Text(harmless(health), style="yellow" if bad else ""), Text(lost)]
        for time, kind, text in self._events:
            at = "" if math.isnan(time) else f"{time:.3f} s  "
            lines.append(Text(harmless(f"{at}{text}"), style=STYLES.get(kind, "")))
        return Group(table, *lines)
