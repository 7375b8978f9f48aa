"""The command that lists the largest values of a run: peaks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from jousto.base.errors import InputError, Problem, suggest
from jousto.cli.group import command
from jousto.cli.hotspots import FINER
from jousto.cli.options import From, Result, To, instant
from jousto.cli.terminal import columns, say

if TYPE_CHECKING:
    from jousto.recovery.hotspots.spots import HotSpots
    from jousto.simulation.results.solution import Solution

HEAD = ("", "smallest", "at", "largest", "at", "")


@command()
def peaks(
    result: Result,
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help="Sensors; all if none.")
    ] = None,
    start: From = None,
    end: To = None,
) -> None:
    """List the smallest and largest value of sensors, and the largest stress of bodies."""
    from jousto.recovery.budget import error_budget
    from jousto.simulation.results.solution import load

    run = load(result)
    span = instant(start, "--from"), instant(end, "--to")
    rows = [HEAD, *sensor_peaks(run, tuple(names or run.sensors), *span)]
    worst = [] if names else worst_places(run, *span)
    rows += stress_peaks(run, worst)
    columns(rows, "<>>>><")
    for found in worst:
        say(f"  {str(error_budget(found)).splitlines()[0]}")
    if worst:
        say(f"  {FINER}")


def sensor_peaks(
    run: Solution, names: tuple[str, ...], start: float | None = None, end: float | None = None
) -> list[tuple[str, ...]]:
    """Return name, smallest value, its time, largest value, its time and unit of components."""
    import numpy as np

    from jousto.recovery.instants import window
    from jousto.simulation.results.frames import component_units

    time = run.time
    within = window(time, start, end, run.where)
    time = time[within]
    rows: list[tuple[str, ...]] = []
    for name in names:
        if name not in run:
            raise InputError(Problem(run.where, f"no sensor {name!r}{suggest(name, run.sensors)}"))
        about, values = run.about(name), np.asarray(run[name])[within]
        values = values.reshape(len(values), -1)
        parts = about["components"] if values.shape[1] > 1 else ("",)
        units = component_units(about) if values.shape[1] > 1 else (about["unit"],)
        for part, unit, column in zip(parts, units, values.T, strict=True):
            low, high = int(np.argmin(column)), int(np.argmax(column))
            rows.append(
                (
                    f"{name}.{part}" if part else name,
                    f"{column[low]:.6g}",
                    f"{time[low]:.6g} s",
                    f"{column[high]:.6g}",
                    f"{time[high]:.6g} s",
                    unit if unit != "1" else "",
                )
            )
    return rows


def worst_places(
    run: Solution, start: float | None = None, end: float | None = None
) -> list[HotSpots]:
    """Return the place of the largest von Mises stress of each body that has stress data."""
    from jousto.recovery.hotspots.spots import hot_spots

    return [hot_spots(run, bodies=name, count=1, start=start, end=end) for name in run.stressed]


def stress_peaks(run: Solution, found: list[HotSpots]) -> list[tuple[str, ...]]:
    """Return the largest von Mises stress of bodies, where and when."""
    rows: list[tuple[str, ...]] = []
    solids = {
        body.name for body in run.bodies if body.elements.ndim == 2 and body.elements.shape[1] == 3
    }
    for worst in (spots[0] for spots in found):
        name = worst.body
        place = ", ".join(f"{1e3 * x:.4g}" for x in worst.position)
        where = "on the surface" if name in solids else f"in {worst.site}"
        unit = f"Pa, von Mises {where} at ({place}) mm"
        rows.append((name, "", "", f"{worst.value:.6g}", f"{worst.time:.6g} s", unit))
    return rows
