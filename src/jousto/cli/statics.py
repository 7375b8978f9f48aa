"""Commands of statics: a path over a load, and the loads at which a model buckles."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from jousto.base.errors import InputError, Problem
from jousto.cli.group import command
from jousto.cli.options import Model, Output, Trust, compiled_model, tell_files
from jousto.cli.terminal import facts, most_at, named, say

Input = Annotated[
    str | None,
    typer.Option("--input", metavar="NAME", help="Input that grows, or gravity or time."),
]
Start = Annotated[float | None, typer.Option("--start", help="First value; now or 0 without it.")]
Steps = Annotated[int, typer.Option("--steps", min=1, help="Steps to the last value.")]


@command()
def path(
    model: Model,
    parameter: Input = None,
    to: Annotated[
        float | None, typer.Option("--to", metavar="VALUE", help="Last value, SI.")
    ] = None,
    start: Start = None,
    steps: Steps = 20,
    arc: Annotated[
        bool, typer.Option("--arc", help="Steps along the path: through snap-through.")
    ] = False,
    sensor: Annotated[
        str | None, typer.Option("--sensor", metavar="NAME", help="For the picture, such as tip.y.")
    ] = None,
    table: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Table of the path.")
    ] = None,
    output: Output = None,
    trust: Trust = False,
) -> None:
    """Follow the equilibrium of a model while an input grows; -o draws it over a sensor."""
    from jousto.output.figures.load_path import sensor_place
    from jousto.output.style import PICTURES, target
    from jousto.output.write import write
    from jousto.simulation.statics.paths import load_path

    compiled = compiled_model(model, trust)
    name = _parameter(compiled, parameter, model)
    if to is None:
        raise InputError(Problem(model.name, f"does not say how far {name} grows; give --to VALUE"))
    # what cannot be written is told before the path is followed
    if table is not None:
        target(table, ("csv",))
    if output is not None:
        target(output, PICTURES)
    shown = sensor or ("" if output is None else _first(compiled, model))
    if shown:
        sensor_place({quantity.name: quantity.count for quantity in compiled.sensors}, shown)
    found = load_path(
        compiled, name, to=to, start=start, steps=steps, method="arc" if arc else "load"
    )
    rows = [
        ("points", str(len(found))),
        (name, f"{found.load[0]:.6g} to {found.load[-1]:.6g}"),
        ("Newton iterations", f"{found.iterations[1:].mean():.2g} a point"),
    ]
    for point in found.critical:
        moves = most_at(point.shape)
        rows.append((point.kind, f"{name} = {point.load:.6g}, most at {moves}"))
    if not found.critical:
        rows.append(("critical points", "none"))
    rows.append(("at the end", "stable" if found.stable[-1] else "unstable"))
    for quantity in compiled.sensors:
        value = np.atleast_1d(found[quantity.name][-1])
        text = named(value, quantity.components, quantity.unit)
        rows.append((f"sensor {quantity.name}", text))
    facts(rows, f"{model.name} over {name}")
    if table is not None:
        say(f"table in {write(found, table)}", style="green")
    tell_files(found, shown, picture=output)
    if not found.complete:
        say(f"the path ends before {name} = {to:g}: {found.ended}", style="yellow")


@command()
def buckle(
    model: Model,
    parameter: Input = None,
    count: Annotated[int, typer.Option("--count", "-n", min=1, help="How many loads.")] = 3,
    along: Annotated[
        bool, typer.Option("--path", help="On the path itself, not of the linear theory.")
    ] = False,
    to: Annotated[
        float | None, typer.Option("--to", metavar="VALUE", help="End of the path.")
    ] = None,
    start: Start = None,
    trust: Trust = False,
) -> None:
    """Find the loads at which a model buckles, the lowest first, and where it moves."""
    from jousto.simulation.statics.buckling import buckling

    compiled = compiled_model(model, trust)
    name = _parameter(compiled, parameter, model)
    found = buckling(
        compiled, name, count, method="path" if along else "linear", start=start, to=to
    )
    rows = []
    for k, load in enumerate(found.loads):
        moves = most_at({body: shapes[k] for body, shapes in found.shapes.items()})
        rows.append((f"{name} = {load:.6g}", f"{found.kinds[k]}, most at {moves}"))
    kind = "on the path" if along else "by the linear theory"
    facts(rows or [("loads", "none: nothing buckles in this direction")], f"{model.name} {kind}")


def _parameter(compiled: Any, given: str | None, model: Path) -> str:
    """Return what grows: the one input if none is named."""
    if given is not None:
        return given
    if len(compiled.inputs) == 1:
        return str(compiled.inputs[0])
    have = ", ".join(compiled.inputs) or "none"
    raise InputError(
        Problem(
            model.name,
            f"say what grows, --input NAME; inputs: {have}; others: gravity, time. A load grows "
            "with signal: {type: input, name: NAME}",
        )
    )


def _first(compiled: Any, model: Path) -> str:
    if not compiled.sensors:
        raise InputError(
            Problem(model.name, "has no sensor to draw the load over; add a position sensor")
        )
    sensor = compiled.sensors[0]
    return str(sensor.name) if sensor.count == 1 else f"{sensor.name}.{min(1, sensor.count - 1)}"
