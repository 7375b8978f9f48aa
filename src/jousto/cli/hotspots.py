"""Commands on the largest values of a run: hotspots, peaks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from jousto.base.errors import InputError, Problem, suggest
from jousto.cli.group import command
from jousto.cli.options import (
    From,
    Output,
    Quantity,
    Result,
    Strain,
    To,
    Vtu,
    amount,
    instant,
    tell_files,
)
from jousto.cli.terminal import columns, say

if TYPE_CHECKING:
    from jousto.recovery.fields.criteria import Plane
    from jousto.recovery.hotspots.hot_spots import HotSpots
    from jousto.simulation.results.solution import Solution

REMARK = "at stored instants, of these modes, step and mesh; jousto hotspots gives the error budget"
FINER = "finer runs give better estimates: jousto hotspots --finer-step, --more-modes, --finer-mesh"


HEAD = ("", "smallest", "at", "largest", "at", "")


@command()
def hotspots(
    result: Result,
    bodies: Annotated[
        list[str] | None, typer.Argument(metavar="[BODY]...", help="Bodies; all if none.")
    ] = None,
    count: Annotated[int, typer.Option("--count", "-n", help="How many places.")] = 10,
    criterion: Quantity = "von-mises",
    separation: Annotated[
        str | None,
        typer.Option(
            "--separation",
            metavar="LENGTH",
            help="How far they keep apart, '20 mm'; beams: their section.",
        ),
    ] = None,
    extreme: Annotated[
        str | None,
        typer.Option("--extreme", metavar="largest|smallest|magnitude", help="What is sought."),
    ] = None,
    start: From = None,
    end: To = None,
    strain: Strain = False,
    csv: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE.csv", help="Write the table.")
    ] = None,
    histories: Annotated[
        Path | None,
        typer.Option("--histories", metavar="FILE.csv|.h5", help="Write their full histories."),
    ] = None,
    step: Annotated[
        Path | None,
        typer.Option("--finer-step", metavar="FILE.h5", help="Same run, half the step."),
    ] = None,
    modes: Annotated[
        Path | None,
        typer.Option("--more-modes", metavar="FILE.h5", help="Same run, more modes."),
    ] = None,
    mesh: Annotated[
        Path | None,
        typer.Option("--finer-mesh", metavar="FILE.h5", help="Same run, finer mesh."),
    ] = None,
    output: Output = None,
    vtu: Vtu = None,
) -> None:
    """Rank the places with the largest stress and prove that no other place exceeds them.

    -o draws the largest stress on the surface with the hot spots and their histories. The error
    budget of the first hot spot estimates the error of its stress; runs with a finer mesh complete
    it.
    """
    from jousto.recovery.budget import error_budget
    from jousto.recovery.fields.build import stress_field
    from jousto.recovery.hotspots.hot_spots import hot_spots
    from jousto.simulation.results.solution import load

    apart = amount(separation, "m", "--separation")
    first, last = instant(start, "--from"), instant(end, "--to")
    sought = plane_or_name(criterion)
    check_targets({csv: ("csv",), histories: ("csv", "h5"), vtu: ("vtu",), output: ()})
    run = load(result)
    source = run
    if strain:
        names = bodies or list(run.stressed)
        source = [stress_field(run, name, strain=True) for name in names]  # type: ignore[assignment]
    found = hot_spots(
        source,
        bodies=None if strain else bodies,
        count=count,
        criterion=sought,
        separation=apart,
        start=first,
        end=last,
        extreme=extreme,
    )
    say(str(found))
    if found.spots:
        finer = [None if path is None else load(path) for path in (step, modes, mesh)]
        say(str(error_budget(found, step=finer[0], modes=finer[1], mesh=finer[2])))
    advice = found.advice()
    if advice:
        say(f"warning: {advice}", error=True, style="yellow")
    if histories is not None:
        say(f"histories in {found.write_histories(histories)}", style="green")
    tell_files(found, run, csv=csv, picture=output, vtu=vtu)


def check_targets(targets: dict[Path | None, tuple[str, ...]]) -> None:
    """Check output paths before the computation; without suffixes any picture format is valid."""
    for path, endings in targets.items():
        if path is not None:
            from jousto.output.style import PICTURES, target

            target(path, endings or PICTURES)


def plane_or_name(text: str) -> str | Plane:
    """Return the stress criterion of an option: a name, or the plane of ``normal:x,y,z``."""
    from jousto.recovery.fields.criteria import Plane

    kind, _, numbers = text.partition(":")
    if kind != "normal" or not numbers:
        return text
    try:
        normal = [float(x) for x in numbers.split(",")]
    except ValueError:
        message = f"{text!r} must be three numbers as in normal:0,0,1"
        raise InputError(Problem("--criterion", message)) from None
    return Plane(normal)


@command()
def peaks(
    result: Result,
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help="Sensors; all if none.")
    ] = None,
    start: From = None,
    end: To = None,
) -> None:
    """List the smallest and largest values of sensors and the largest stress of bodies."""
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
    """Return rows of component, smallest value, its time, largest value, its time, and unit."""
    import numpy as np

    from jousto.base.rounding import without_rounding
    from jousto.recovery.instants import window
    from jousto.simulation.results.dataframes import component_units

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
        floors = run.floors(name)
        for part, unit, floor, column in zip(parts, units, floors, values.T, strict=True):
            column = without_rounding(column, floor)
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
    """Return the place of the largest von Mises stress of each body with stress data."""
    from jousto.recovery.hotspots.hot_spots import hot_spots

    return [hot_spots(run, bodies=name, count=1, start=start, end=end) for name in run.stressed]


def stress_peaks(run: Solution, found: list[HotSpots]) -> list[tuple[str, ...]]:
    """Return the largest von Mises stress of each body with its place and time."""
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
