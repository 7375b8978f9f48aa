"""The command on stress along bodies."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer
from numpy.typing import NDArray

from jousto.cli.group import command
from jousto.cli.hotspots import REMARK, plane_or_name
from jousto.cli.options import From, Output, Quantity, Result, Strain, To, instant, only_one
from jousto.cli.terminal import columns, say

if TYPE_CHECKING:
    from jousto.recovery.fields.criteria import Criterion
    from jousto.recovery.fields.field import StressField
    from jousto.simulation.results.solution import Solution

Array = NDArray[Any]

SHOWN = 12


@command()
def stress(
    result: Result,
    body: Annotated[str | None, typer.Argument(metavar="[BODY]", help="Body; may be left out.")] = (
        None
    ),
    site: Annotated[
        list[str] | None,
        typer.Option(
            "--site", "-s", metavar="SITE", help="Label, node set or node number from 0; again."
        ),
    ] = None,
    criterion: Quantity = "von-mises",
    frame: Annotated[
        str, typer.Option("--frame", metavar="site|body|world", help="Axes of components.")
    ] = "site",
    start: From = None,
    end: To = None,
    at: Annotated[
        str | None, typer.Option("--at", metavar="TIME", help="One instant, '0.5 s'.")
    ] = None,
    strain: Strain = False,
    residual: Annotated[
        bool,
        typer.Option("--residual", help="Add the stress that modes neglect (mode acceleration)."),
    ] = False,
    output: Output = None,
) -> None:
    """Print the smallest and largest stress at places of a body, with their times.

    -o writes histories of the sites as .png or .csv, the envelope as .csv or .vtu, the instant
    --at as .csv or .vtu, all instants as .pvd for a film in ParaView, and everything as .h5.
    """
    from jousto.recovery.fields.build import stress_field
    from jousto.simulation.results.solution import load

    sought = plane_or_name(criterion)
    first, last, moment = instant(start, "--from"), instant(end, "--to"), instant(at, "--at")
    run = load(result)
    field = stress_field(
        run,
        body or only_one(run.stressed, run.where, "bodies", "no body has stress data"),
        sites=None if not site else [int(x) if x.isdecimal() else x for x in site],
        start=first,
        end=last,
        frame=frame,  # type: ignore[arg-type]
        strain=strain,
        residual=residual,
    )
    if moment is not None:
        shown = field.values(sought, times=[moment])[0]
        order = worst_first(sought, field.strain, field.labels, shown)
        rows = [(field.labels[i], f"{factor(field) * shown[i]:.6g}") for i in order]
        table([("site", f"{sought} ({unit(field)}) at {moment:g} s"), *rows[:SHOWN]], len(rows))
    else:
        envelope = field.envelope(sought)
        order = worst_first(sought, field.strain, field.labels, envelope.min, envelope.max)[:SHOWN]
        f = factor(field)
        head = ("site", f"smallest ({unit(field)})", "at (s)", f"largest ({unit(field)})", "at (s)")
        table(
            [
                head,
                *(
                    (
                        envelope.labels[i],
                        f"{f * envelope.min[i]:.6g}",
                        f"{envelope.min_time[i]:.6g}",
                        f"{f * envelope.max[i]:.6g}",
                        f"{envelope.max_time[i]:.6g}",
                    )
                    for i in order
                ),
            ],
            field.ns,
        )
        say(f"{sought}, {field.frame} axes, {field.time[0]:g} to {field.time[-1]:g} s")
        for line in errors(field, sought, residual=residual):
            say(line)
    if output is not None:
        say(f"written to {write(run, field, sought, moment, output, bool(site))}", style="green")


def errors(field: StressField, criterion: Criterion, *, residual: bool = False) -> list[str]:
    """Return lines on the error of the stress at the most stressed place."""
    from jousto.recovery.budget import budget_text, error_budget
    from jousto.recovery.fields.criteria import weights
    from jousto.recovery.hotspots.hot_spots import hot_spots

    if field.frame == "world" and weights(criterion) is not None:
        # no error estimate for components in a rotating frame: the search does not cover them
        return [f"errors: {REMARK}"]
    found = hot_spots(field, count=1, criterion=criterion)
    if not found.spots:
        return [f"errors: {REMARK}"]
    return [budget_text(error_budget(found), residual=residual)]


def worst_first(
    criterion: Criterion, strain: bool, labels: Sequence[str], *values: Array
) -> NDArray[np.intp]:
    """Return indices of places, largest magnitude first, in the ranking of hot spots."""
    from jousto.base.ranking import ranking
    from jousto.recovery.hotspots.measures import measure

    rank = measure(criterion, strain=strain).rank
    worst = np.max([rank(value) for value in values], axis=0)
    return ranking(worst, labels)


def factor(field: StressField) -> float:
    """Return the factor from SI to the unit of the tables."""
    return 1e6 if field.strain else 1e-6


def unit(field: StressField) -> str:
    """Return the unit of the tables."""
    return "um/m" if field.strain else "MPa"


def table(rows: list[tuple[str, ...]], count: int) -> None:
    """Print rows, first column left-aligned, and the total number of places."""
    columns(rows, "<>")
    if count > len(rows) - 1:
        say(f"  ... of {count} places; -o FILE.csv has all of them")


def write(
    run: Solution,
    field: StressField,
    criterion: Criterion,
    moment: float | None,
    path: Path,
    sites: bool,
) -> Path:
    """Write a field as the format that the suffix of the path selects.

    Raises
    ------
    InputError
        For an unknown suffix, or a path that cannot be written.
    """
    from jousto.output.plot import plot
    from jousto.output.write import write

    suffix = path.suffix.lower()
    if suffix == ".h5":
        return field.write(path, criterion)
    if suffix in (".vtu", ".pvd"):
        times: Any = None if moment is None else [moment]
        return write(field, path, run, criterion=criterion, times=times)
    if suffix == ".csv":
        return write(field, path, criterion=criterion, time=moment, histories=sites)
    plot(field, criterion=criterion, path=path)
    return path
