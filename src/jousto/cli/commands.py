"""The command line: check, run, equilibrium, modes, info, plot, reduce, animate, schema.

Exit codes: 0 success, 1 the run failed, 2 bad input. Problems and warnings go to stderr, one
line each. Everything heavy is imported inside the commands.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.cli.terminal import command, facts, numbers, plain, progress_bar, say
from jousto.errors import InputError, JoustoWarning, Problem

if TYPE_CHECKING:
    from jousto.reduction import ReducedPart
    from jousto.schema import ModelFile

app = typer.Typer(
    name="jousto",
    help="Simulate mechanisms with flexible bodies.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

Model = Annotated[Path, typer.Argument(metavar="MODEL", help="Model file (YAML or JSON).")]
Result = Annotated[Path, typer.Argument(metavar="RESULT", help="Results file (HDF5).")]
Output = Annotated[Path | None, typer.Option("--output", "-o", metavar="FILE", help="Output file.")]
Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]


# -- commands -------------------------------------------------------------------------------


def _version(value: bool) -> None:
    if value:
        from jousto import __version__

        say(f"jousto {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Simulate mechanisms with flexible bodies."""


@app.command()
@command
def check(model: Model, debug: Debug = False) -> None:
    """Read a model file, check everything and say what is in it and how it can move."""
    from jousto.engine import doctor
    from jousto.schema import read_model

    file = read_model(model)
    describe_model(file)
    compiled = compile_model(file)
    facts(doctor(compiled).lines())
    settings = file.simulation
    if settings is not None:
        from jousto.simulation import ROS2
        from jousto.simulation.simulate import schedule
        from jousto.simulation.stability import stability_warning

        solver = settings.solver or ROS2()
        steps = schedule(compiled, settings.t_end, solver, settings.output_step)
        sentence = stability_warning(compiled, solver, steps.step)
        if sentence:
            warnings.warn(JoustoWarning(f"{model.name}: simulation: {sentence}"), stacklevel=1)
    say(f"{model.name}: ok", style="green")


@app.command()
@command
def run(
    model: Model,
    output: Output = None,
    t_end: Annotated[
        str | None,
        typer.Option("--t-end", metavar="TIME", help="End of the run such as 2 or '500 ms'."),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no summary.")] = False,
    debug: Debug = False,
) -> None:
    """Simulate a model; the results go to MODEL.h5 unless -o says otherwise."""
    from jousto.schema import read_model
    from jousto.schema.targets import RESULTS, output_path

    target = output_path(output, model, ".h5", kind=RESULTS)
    end = None if t_end is None else end_time(t_end)
    file = read_model(model)
    settings = file.simulation
    if end is None:
        if settings is None:
            raise InputError(
                Problem(
                    model.name,
                    "does not say how long to simulate; add simulation: {t_end: 10 s}, "
                    "or give --t-end",
                )
            )
        end = settings.t_end
    from jousto.simulation import describe, simulate

    solution = simulate(
        compile_model(file),
        end,
        path=target,
        progress=not quiet and sys.stderr.isatty(),
        model_text=file.text,
        **(settings.given() if settings is not None else {}),
    )
    if not quiet:
        facts([(name, plain(value)) for name, value in describe(solution).items()])
        say(f"results in {target}", style="green")


@app.command()
@command
def equilibrium(model: Model, debug: Debug = False) -> None:
    """Find where a model rests: positions of the bodies and values of the sensors."""
    from jousto.engine import Engine
    from jousto.schema import read_model
    from jousto.simulation import equilibrium as rest

    compiled = compile_model(read_model(model))
    state = rest(compiled)
    engine = Engine(compiled)
    engine.q[:], engine.v[:], engine.time[0] = state.q, state.v, state.time
    engine.accelerations()
    values = engine.sensors()
    rows = [
        (f"body {body.name}", f"{numbers(state.q[body.iq : body.iq + 3])} m")
        for body in compiled.bodies
    ]
    for sensor in compiled.sensors:
        found = values[sensor.offset : sensor.offset + sensor.count]
        rows.append((f"sensor {sensor.name}", f"{numbers(found)} {sensor.unit}".rstrip()))
    facts(rows, f"{model.name} at rest")


@app.command()
@command
def modes(
    model: Model,
    count: Annotated[
        int, typer.Option("--count", "-n", min=1, help="How many, the slowest first.")
    ] = 10,
    initial: Annotated[
        bool, typer.Option("--initial", help="About the initial pose, not the rest position.")
    ] = False,
    debug: Debug = False,
) -> None:
    """Compute the natural modes of a model, without damping, about where it rests."""
    import numpy as np

    from jousto.schema import read_model
    from jousto.simulation import equilibrium as rest
    from jousto.simulation import modes as natural

    compiled = compile_model(read_model(model))
    found = natural(compiled, None if initial else rest(compiled))
    largest = {name: np.abs(x).max(axis=(1, 2), initial=0.0) for name, x in found.shapes.items()}
    rows = []
    for k, value in enumerate(found.eigenvalues[:count]):
        text = f"{found.frequencies[k]:.6g} Hz"
        if value.real > abs(value.imag):
            text = f"falls away, {value.real:.6g} 1/s"
        moves = max(largest, key=lambda name: float(largest[name][k]))
        rows.append((f"mode {k + 1}", f"{text}, most at {moves}"))
    place = "its initial pose" if initial else "rest"
    facts(rows or [("modes", "none: nothing is free to move")], f"{model.name} about {place}")


@app.command()
@command
def info(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Model, results or reduced part.")],
    debug: Debug = False,
) -> None:
    """Say what is in a model file, a results file or a reduced part."""
    from jousto.schema.document import is_hdf5
    from jousto.schema.targets import REDUCED_PART, hdf5_format

    if not is_hdf5(file):
        if file.suffix.lower() in (".h5", ".hdf5") and file.is_file():
            raise InputError(Problem(str(file), "is not an HDF5 file, or it is damaged"))
        from jousto.schema import read_model

        describe_model(read_model(file))
    elif hdf5_format(file) == REDUCED_PART:
        from jousto.reduction import ReducedPart

        describe_part(ReducedPart.load(file))
    else:
        describe_result(file)


@app.command()
@command
def plot(
    result: Result,
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME...", help="Sensors (middle, middle.y), energy, residuals; all if none."
        ),
    ] = None,
    output: Output = None,
    debug: Debug = False,
) -> None:
    """Plot sensors over time; the picture goes to RESULT.png unless -o says otherwise."""
    from jousto.schema.targets import output_path

    target = output_path(output, result, ".png")
    from jousto.output import plot as draw
    from jousto.simulation import load

    draw(load(result), *(names or ()), path=target)
    say(f"plot in {target}", style="green")


@app.command(name="reduce")
@command
def reduce_part(
    part: Annotated[
        Path, typer.Argument(metavar="PART", help="YAML file of a part, or a model file.")
    ],
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help="Which of the model's parts.")
    ] = None,
    output: Output = None,
    debug: Debug = False,
) -> None:
    """Reduce a part to modes; it goes to NAME.h5 next to the file unless -o says otherwise."""
    from jousto.schema import read_part
    from jousto.schema.targets import REDUCED_PART, output_path

    # a wrong output should not cost a reduction
    if output is not None:
        output_path(output, part, ".h5", kind=REDUCED_PART)
    reduced = read_part(part, name)
    target = output_path(output, part, f"{reduced.name}.h5", kind=REDUCED_PART)
    reduced.save(target)
    describe_part(reduced)
    say(f"reduced part in {target}", style="green")


@app.command()
@command
def animate(
    result: Result,
    output: Output = None,
    speed: Annotated[
        float, typer.Option("--speed", help="Simulated per shown second; 0.1 is slow motion.")
    ] = 1.0,
    fps: Annotated[float, typer.Option("--fps", help="Frames per second.")] = 25.0,
    scale: Annotated[float, typer.Option("--scale", help="Factor on the deformation.")] = 1.0,
    view: Annotated[
        str | None, typer.Option("--view", metavar="xy|xz|yz", help="Plane to look at.")
    ] = None,
    trail: Annotated[
        list[str] | None,
        typer.Option("--trail", metavar="SENSOR", help="Position sensor that leaves a trail."),
    ] = None,
    debug: Debug = False,
) -> None:
    """Film the motion; it goes to RESULT.gif unless -o says otherwise.

    The ending of the file says what is made: .gif, .mp4 or .html films, .png, .svg or .pdf
    pictures of several instants.
    """
    from jousto.schema.targets import output_path

    target = output_path(output, result, ".gif")
    from jousto.output import animate as draw
    from jousto.simulation import load

    with progress_bar("drawing") as report:
        draw(
            load(result),
            target,
            speed=speed,
            fps=fps,
            scale=scale,
            view=view,
            trail=trail,
            progress=report,
        )
    say(f"animation in {target}", style="green")


@app.command()
@command
def schema(debug: Debug = False) -> None:
    """Print the JSON schema of the model file, for editors."""
    import json

    from jousto.schema import model_schema

    sys.stdout.write(json.dumps(model_schema(), indent=1, ensure_ascii=False) + "\n")


# -- what the commands need -----------------------------------------------------------------


def compile_model(file: ModelFile) -> Any:
    """Return the compiled model of a model file."""
    from jousto.engine import compile

    return compile(file.mechanism)


def end_time(text: str) -> float:
    """Return the end time of an option, s."""
    from jousto.schema.units import UnitError, quantity

    try:
        value = quantity(text, "s")
    except UnitError as error:
        raise InputError(Problem("--t-end", str(error))) from None
    if value <= 0:
        raise InputError(Problem("--t-end", f"is {value:g} s, must be positive"))
    return value


def describe_model(file: ModelFile) -> None:
    """Print what is in a model."""
    from jousto.schema.summary import model_facts

    facts(model_facts(file), file.mechanism.name)


def describe_part(part: ReducedPart) -> None:
    """Print what is in a reduced part."""
    from jousto.schema.summary import part_facts

    facts(part_facts(part), f"reduced part {part.name}")


def describe_result(path: Path) -> None:
    """Print what is in a results file."""
    from jousto.schema.summary import count
    from jousto.simulation import describe, load

    solution = load(path)
    facts([(name, plain(value)) for name, value in describe(solution).items()], path.name)
    rows = []
    for name in solution.sensors:
        values = solution[name]
        about, width = solution.about(name), values.shape[1] if values.ndim > 1 else 1
        rows.append((f"sensor {name}", f"{about['description']}, {count(width, 'value')}"))
    facts(rows)


def main() -> None:
    """Run the command line; the entry point of the ``jousto`` command."""
    app(prog_name="jousto")
