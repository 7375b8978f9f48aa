"""The command that says how large things became in a run: peaks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from jousto.cli.options import Debug, Result, app
from jousto.cli.terminal import command, say
from jousto.errors import InputError, Problem, suggest

if TYPE_CHECKING:
    from jousto.simulation import Solution

HEAD = ("", "smallest", "at", "largest", "at", "")


@app.command()
@command
def peaks(
    result: Result,
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help="Sensors; all if none.")
    ] = None,
    debug: Debug = False,
) -> None:
    """List the smallest and largest value of sensors, and the largest stress of solids."""
    from jousto.simulation import load

    run = load(result)
    rows: list[tuple[str, ...]] = [HEAD, *sensor_peaks(run, tuple(names or run.sensors))]
    if not names:
        rows += stress_peaks(run)
    widths = [max(len(row[k]) for row in rows) for k in range(len(HEAD))]
    for row in rows:
        cells = [
            row[0].ljust(widths[0]),
            *(c.rjust(w) for c, w in zip(row[1:5], widths[1:5], strict=True)),
        ]
        say(("  " + "  ".join(cells) + "  " + row[5]).rstrip())


def sensor_peaks(run: Solution, names: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Return name, smallest value, its time, largest value, its time and unit of components."""
    import numpy as np

    rows: list[tuple[str, ...]] = []
    for name in names:
        if name not in run:
            raise InputError(
                Problem(str(run.path), f"no sensor {name!r}{suggest(name, run.sensors)}")
            )
        about, values = run.about(name), np.asarray(run[name])
        values = values.reshape(len(values), -1)
        parts = about["components"] if values.shape[1] > 1 else ("",)
        unit = about["unit"] if about["unit"] != "1" else ""
        for part, column in zip(parts, values.T, strict=True):
            low, high = int(np.argmin(column)), int(np.argmax(column))
            rows.append(
                (
                    f"{name}.{part}" if part else name,
                    f"{column[low]:.6g}",
                    f"{run.time[low]:.6g} s",
                    f"{column[high]:.6g}",
                    f"{run.time[high]:.6g} s",
                    unit,
                )
            )
    return rows


def stress_peaks(run: Solution, block: int = 200) -> list[tuple[str, ...]]:
    """Return the largest von Mises stress of each body with a surface, where and when."""
    import numpy as np

    from jousto.recovery import surface_stress

    rows: list[tuple[str, ...]] = []
    for body in run.bodies:
        best = (-1.0, 0.0, 0)
        for start in range(0, len(run), block):
            times = run.time[start : start + block]
            found = surface_stress(run, body.name, times)
            if found is None:
                break
            nodes, values = found
            at, site = np.unravel_index(int(np.argmax(values)), values.shape)
            if values[at, site] > best[0]:
                best = (float(values[at, site]), float(times[at]), int(nodes[site]))
        if best[0] >= 0.0:
            place = ", ".join(f"{1e3 * x:.4g}" for x in body.nodes[best[2]])
            unit = f"Pa, von Mises on the surface at ({place}) mm"
            rows.append((body.name, "", "", f"{best[0]:.6g}", f"{best[1]:.6g} s", unit))
    return rows
