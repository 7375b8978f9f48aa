"""Commands that analyse a model: equilibrium, modes, linearise, kinematics, path, buckle."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.files import written
from jousto.cli.group import command
from jousto.cli.options import (
    Initial,
    Model,
    Output,
    Trust,
    amount,
    compile_model,
    compiled_model,
    end_time,
    tell_files,
)
from jousto.cli.terminal import columns, facts, most_at, named, numbers, plain, say

MATRICES = (".npz", ".mat")

IN_LINE = 6  # number of components in one unit up to which they are printed in one row
ROWS = 20


Input = Annotated[
    str | None,
    typer.Option("--input", metavar="NAME", help="Input that grows, or gravity or time."),
]
Start = Annotated[float | None, typer.Option("--start", help="First value; now or 0 without it.")]
Steps = Annotated[int, typer.Option("--steps", min=1, help="Steps to the last value.")]


@command()
def equilibrium(model: Model, trust: Trust = False) -> None:
    """Print the equilibrium of a model: positions of the bodies and values of the sensors."""
    from jousto.base.rounding import without_rounding
    from jousto.model.native.native import Engine
    from jousto.model.scales import scales_of
    from jousto.simulation.results.dataframes import component_units
    from jousto.simulation.state import put
    from jousto.simulation.statics.equilibrium import equilibrium as rest

    compiled = compiled_model(model, trust)
    state = rest(compiled)
    engine = Engine(compiled)
    put(engine, state, "equilibrium")
    engine.accelerations()
    values, scales = engine.sensors(), scales_of(compiled)
    places = without_rounding(state.q, scales.floor("m"))
    # bodies inside a beam are left out, its two ends are listed
    inner = {int(i) for beam in compiled.beam_shapes for i in beam.bodies[1:-1]}
    rows = [
        (f"body {body.name}", f"origin at x y z = {numbers(places[body.iq : body.iq + 3])} m")
        for i, body in enumerate(compiled.bodies)
        if i not in inner
    ]
    tables: list[tuple[str, list[tuple[str, ...]]]] = []
    for sensor in compiled.sensors:
        units = component_units({"unit": sensor.unit, "components": sensor.components})
        found = values[sensor.offset : sensor.offset + sensor.count]
        found = without_rounding(found, [scales.floor(unit) for unit in units])
        if len(found) > IN_LINE * len(set(units)):
            tables.append((sensor.name, largest_first(found, sensor.components, units)))
        else:
            rows.append((f"sensor {sensor.name}", named(found, sensor.components, sensor.unit)))
    facts(rows, f"{model.name} at rest")
    for name, lines in tables:
        say(f"  sensor {name}")
        columns(lines[:ROWS], "<><")
        if len(lines) > ROWS:
            say(
                f"  the largest {ROWS} of {len(lines)}; all of them in Python: "
                f"jo.simulate(model, 1e-4, state=jo.equilibrium(model))[{name!r}][0]"
            )


def largest_first(
    values: Array, names: Sequence[str], units: Sequence[str]
) -> list[tuple[str, ...]]:
    """Return rows of name, value and unit, sorted by magnitude if there are more than `ROWS`."""
    order = np.arange(len(values))
    if len(values) > ROWS:
        order = np.argsort(-np.abs(values), kind="stable")
    return [(names[i], numbers(values[i : i + 1]), units[i]) for i in order.tolist()]


@command()
def modes(
    model: Model,
    count: Annotated[
        int, typer.Option("--count", "-n", min=1, help="Number of modes, the slowest first.")
    ] = 10,
    initial: Initial = False,
    picture: Annotated[
        Path | None,
        typer.Option("--picture", metavar="FILE", help="Draw a mode: png, svg, pdf ..."),
    ] = None,
    mode: Annotated[
        int, typer.Option("--mode", min=1, help="Number of the mode that --picture draws, from 1.")
    ] = 1,
    trust: Trust = False,
) -> None:
    """Compute the undamped natural modes of a model about its equilibrium."""
    from jousto.simulation.modes.linear import modes as natural
    from jousto.simulation.statics.equilibrium import equilibrium as rest

    compiled = compiled_model(model, trust)
    found = natural(compiled, None if initial else rest(compiled))
    rows = []
    for k in range(min(count, len(found.eigenvalues))):
        moves = most_at({name: shapes[k] for name, shapes in found.shapes.items()})
        rows.append((f"mode {k + 1}", f"{found.describe_mode(k)}, most at {moves}"))
    place = "its initial pose" if initial else "rest"
    facts(rows or [("modes", "none: no motion is free")], f"{model.name} about {place}")
    if picture is not None:
        tell_files(found, mode - 1, picture=picture)


@command()
def linearise(
    model: Model,
    output: Output = None,
    initial: Initial = False,
    trust: Trust = False,
) -> None:
    """Linearise a model: A, B, C, D of its inputs and sensors, into MODEL.npz or -o FILE.mat."""
    import numpy as np

    from jousto.schema.output_paths import output_path
    from jousto.simulation.modes.linear import linearise as small_motions
    from jousto.simulation.statics.equilibrium import equilibrium as rest

    target = output_path(output, model, ".npz")
    if target.suffix not in MATRICES:
        raise InputError(Problem(str(target), f"must end with {' or '.join(MATRICES)}"))
    compiled = compiled_model(model, trust)
    found = small_motions(compiled, None if initial else rest(compiled))
    values: dict[str, Any] = {
        "A": found.A,
        "B": found.B,
        "C": found.C,
        "D": found.D,
        "inputs": np.array(found.input_names, dtype=str),
        "outputs": np.array(found.output_names, dtype=str),
    }
    with written(target) as beside:
        if target.suffix == ".mat":
            from scipy.io import savemat

            names = ("inputs", "outputs")
            savemat(beside, values | {name: values[name].astype(object) for name in names})
        else:
            np.savez(beside, **values)
    rows = [
        ("states", str(len(found.A))),
        ("inputs", ", ".join(found.input_names) or "none"),
        ("outputs", ", ".join(found.output_names) or "none"),
    ]
    facts(rows, f"{model.name} about {'its initial pose' if initial else 'rest'}")
    say(f"A, B, C, D in {target}", style="green")


@command()
def kinematics(
    model: Model,
    output: Output = None,
    t_end: Annotated[
        str | None, typer.Option("--t-end", metavar="TIME", help="Last instant such as 2 or '5 s'.")
    ] = None,
    instants: Annotated[
        int, typer.Option("--instants", "-n", min=1, help="Number of instants, evenly spaced.")
    ] = 101,
    trust: Trust = False,
) -> None:
    """Compute the motion and the drive forces of a fully driven model without integration."""
    import numpy as np

    from jousto.schema.output_paths import RESULTS, output_path
    from jousto.schema.read import read_model
    from jousto.simulation.kinematics import kinematics as motion

    target = output_path(output, model, ".h5", kind=RESULTS)
    file = read_model(model, trust=trust)
    end = amount(t_end, "s", "--t-end") or end_time(file, model, "until when")
    found = motion(compile_model(file.mechanism), np.linspace(0.0, end, instants), path=target)
    rows = [
        ("instants", str(len(found.time))),
        ("last instant (s)", plain(float(found.time[-1]))),
        ("largest position residual", plain(float(found.residuals.position.max(initial=0.0)))),
    ]
    facts(rows)
    say(f"results in {target}", style="green")


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
    """Compute the equilibrium path of a model over a growing input; -o plots it over a sensor."""
    import numpy as np

    from jousto.output.figures.load_path import sensor_place
    from jousto.output.style import PICTURES, target
    from jousto.output.write import write
    from jousto.simulation.statics.load_path import load_path

    compiled = compiled_model(model, trust)
    name = _parameter(compiled, parameter, model)
    if to is None:
        raise InputError(Problem(model.name, f"has no last value of {name}; give --to VALUE"))
    # check the output files before the long computation
    if table is not None:
        target(table, ("csv",))
    if output is not None:
        target(output, PICTURES)
    shown = sensor or ("" if output is None else _default_component(compiled, model))
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
        bool, typer.Option("--path", help="On the path itself, not by the linear theory.")
    ] = False,
    to: Annotated[
        float | None, typer.Option("--to", metavar="VALUE", help="End of the path.")
    ] = None,
    start: Start = None,
    trust: Trust = False,
) -> None:
    """Compute the buckling loads of a model, lowest first, and the bodies that move most."""
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
    """Return the name of the growing input: the given one, or the only input of the model."""
    if given is not None:
        return given
    if len(compiled.inputs) == 1:
        return str(compiled.inputs[0])
    have = ", ".join(compiled.inputs) or "none"
    raise InputError(
        Problem(
            model.name,
            f"name the load parameter with --input NAME; inputs: {have}; others: gravity, time. "
            "A load grows "
            "with signal: {type: input, name: NAME}",
        )
    )


def _default_component(compiled: Any, model: Path) -> str:
    if not compiled.sensors:
        raise InputError(
            Problem(model.name, "has no sensor to plot the load against; add a position sensor")
        )
    sensor = compiled.sensors[0]
    return str(sensor.name) if sensor.count == 1 else f"{sensor.name}.{min(1, sensor.count - 1)}"
