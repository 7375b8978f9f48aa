"""Commands on models and results: check, run, info, plot, animate, schema."""

from __future__ import annotations

import sys
import warnings
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, JoustoWarning, Problem, count
from jousto.base.files import check_input
from jousto.base.garbage_collection import uncollected
from jousto.cli.group import command
from jousto.cli.options import Core, Model, Output, Result, Trust, amount, compile_model, end_time
from jousto.cli.parts import describe_content, describe_part
from jousto.cli.terminal import facts, plain, progress_bar, say

if TYPE_CHECKING:
    from jousto.model.model import Model as CompiledModel
    from jousto.schema.read import ModelFile
    from jousto.simulation.results.solution import Solution

MOST_EVENTS = 20  # number of events that are printed


@command()
def run(
    model: Model,
    output: Output = None,
    t_end: Annotated[
        str | None,
        typer.Option("--t-end", metavar="TIME", help="End of the run such as 2 or '500 ms'."),
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option(metavar="SHARE", help="Choose the steps by their error, such as 1e-6."),
    ] = None,
    step: Annotated[
        str | None,
        typer.Option("--step", metavar="TIME", help="Step of the solver such as '0.2 ms'."),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no summary.")] = False,
    rigid: Annotated[bool, typer.Option("--rigid", help="Make flexible bodies rigid.")] = False,
    core: Core = None,
    trust: Trust = False,
) -> None:
    """Simulate a model; the results go to MODEL.h5 unless -o names another file."""
    from jousto.schema.output_paths import RESULTS, output_path
    from jousto.schema.read import read_model

    target = output_path(output, model, ".h5", kind=RESULTS)
    end, width = amount(t_end, "s", "--t-end"), amount(step, "s", "--step")
    if width is not None and tolerance is not None:
        raise InputError(Problem("--step", "--tolerance chooses the steps; leave one of them out"))
    bar = sys.stderr.isatty() and not quiet
    file = read_model(model, rigid=rigid, trust=trust, progress=bar)
    settings = file.simulation
    from jousto.simulation.running.simulate import describe, simulate
    from jousto.simulation.solvers.default_solver import choose_adaptive

    compiled = compile_model(file.mechanism, core)
    given = settings.given(compiled) if settings is not None else {}
    if tolerance is not None:
        given["solver"] = replace(choose_adaptive(given.get("solver")), tolerance=tolerance)
    until = end or end_time(file, model)
    if width is not None:
        given["solver"] = stepping(compiled, until, given, width)
    solution = simulate(
        compiled,
        until,
        path=target,
        progress=not quiet and sys.stderr.isatty(),
        model_text=file.text,
        **given,
    )
    if not quiet:
        facts([(name, plain(value)) for name, value in describe(solution).items()])
        tell_events(solution)
        say(f"results in {target}", style="green")


def stepping(model: CompiledModel, t_end: float, given: dict[str, Any], step: float) -> Any:
    """Return the fixed-step solver of a run: from the model file, or chosen for the model."""
    from jousto.simulation.solvers.default_solver import choose

    solver: Any = given.get("solver") or choose(model, t_end, given.get("output_step"), 0.0)[0]
    if solver.adaptive:
        sentence = f"{type(solver).__name__} chooses its steps itself; give --tolerance"
        raise InputError(Problem("--step", sentence))
    return replace(solver, step=step)


@command()
def info(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Model, results, record, part or mesh.")
    ],
    trust: Trust = False,
) -> None:
    """Print the content of a model file, results file, reduced part or mesh (lengths in m)."""
    from jousto.mesh.formats import begins_as_mesh, is_mesh
    from jousto.reduction.files.suffixes import SID
    from jousto.schema.file.document import MODELS, is_hdf5
    from jousto.schema.output_paths import MONITOR, REDUCED_PART, hdf5_format

    check_input(file)
    if is_mesh(file) or (file.suffix.lower() not in MODELS and begins_as_mesh(file)):
        from jousto.cli.meshes import describe_mesh
        from jousto.mesh.readers.files import read_mesh

        describe_mesh(read_mesh(file))
    elif file.suffix.lower() in SID or (is_hdf5(file) and hdf5_format(file) == REDUCED_PART):
        from jousto.reduction.reduced import ReducedPart

        part = ReducedPart.load(file)
        describe_part(part)
        describe_content(part)
    elif not is_hdf5(file):
        if file.suffix.lower() in (".h5", ".hdf5") and file.is_file():
            raise InputError(Problem(str(file), "is not an HDF5 file, or it is damaged"))
        from jousto.schema.read import read_model

        describe_model(read_model(file, trust=trust))
    elif hdf5_format(file) == MONITOR:
        from jousto.measurement.monitor.record_reader import MonitorRecord

        say(str(MonitorRecord(file)))
    else:
        describe_result(file)


@command()
def plot(
    result: Result,
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="NAME...", help="Sensors (middle, middle.y), energy, residuals; all if none."
        ),
    ] = None,
    output: Output = None,
) -> None:
    """Plot sensors over time; the picture goes to RESULT.png unless -o names another file."""
    from jousto.schema.output_paths import MONITOR, hdf5_format, output_path

    target = output_path(output, result, ".png")
    from jousto.output.plot import plot as draw

    if hdf5_format(result) == MONITOR:
        from jousto.measurement.monitor.record_reader import MonitorRecord

        if names:
            raise InputError(Problem(names[0], "the record of a monitoring run has no sensors"))
        draw(MonitorRecord(result), path=target)
    else:
        from jousto.simulation.results.solution import load

        draw(load(result), *(names or ()), path=target)
    say(f"plot in {target}", style="green")


@command()
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
    stress: Annotated[
        bool, typer.Option("--stress", help="Colour solids by their von Mises stress.")
    ] = False,
    stress_limit: Annotated[
        str | None,
        typer.Option(
            "--stress-limit", metavar="STRESS", help="Stress of the highest colour, '200 MPa'."
        ),
    ] = None,
) -> None:
    """Film the motion, into RESULT.gif unless -o names another file.

    The ending of the file selects the format: .gif, .mp4 or .html films, .png, .svg or .pdf
    pictures of several instants. Modal beams are lines, exact beams and solids are
    surfaces.
    """
    from jousto.schema.output_paths import output_path

    target = output_path(output, result, ".gif")
    limit = amount(stress_limit, "Pa", "--stress-limit")
    from jousto.output.scenes.animate import animate as draw
    from jousto.simulation.results.solution import load

    with progress_bar("drawing") as report:
        draw(
            load(result),
            target,
            speed=speed,
            fps=fps,
            scale=scale,
            view=view,
            trail=trail,
            stress=stress if limit is None else limit,
            progress=report,
        )
    say(f"animation in {target}", style="green")


@command()
def schema() -> None:
    """Print the JSON schema of the model file, for editors."""
    import json

    from jousto.schema.read import model_schema

    sys.stdout.write(json.dumps(model_schema(), indent=1, ensure_ascii=False) + "\n")


def tell_events(solution: Solution) -> None:
    """Print the events of a run; only the first ones of a long list."""
    events = solution.events
    rows = [(f"{e.time:.9g} s", f"{e.name} {e.effect}") for e in events[:MOST_EVENTS]]
    if len(events) > MOST_EVENTS:
        rows.append(("...", f"{len(events) - MOST_EVENTS} more in the results"))
    if rows:
        facts(rows, "events")


def describe_result(path: Path) -> None:
    """Print the content of a results file."""
    from jousto.simulation.results.solution import Solution
    from jousto.simulation.running.simulate import describe

    solution = Solution(path)  # a results file may contain no instants yet
    facts([(name, plain(value)) for name, value in describe(solution).items()], path.name)
    rows = []
    for name in solution.sensors:
        values = solution[name]
        about, width = solution.about(name), values.shape[1] if values.ndim > 1 else 1
        text = f"{about['description']}, {count(width, 'value')}"
        text += f", {about['unit']}" if about["unit"] != "1" else ""
        rows.append((f"sensor {name}", text))
    facts(rows)
    tell_events(solution)


@command()
@uncollected()
def check(model: Model, core: Core = None, trust: Trust = False) -> None:
    """Check a model file and print its content and its degrees of freedom."""
    from jousto.certificate.doctor import doctor
    from jousto.model.overlaps import overlap_facts
    from jousto.schema.read import read_model

    file = read_model(model, trust=trust)
    describe_model(file)
    mechanism, settings = file.mechanism, file.simulation
    del file  # the data of the file, a quarter of the memory of a large model
    compiled = compile_model(mechanism, core)
    diagnosis = doctor(compiled)
    facts([line for line in diagnosis.lines() if line[0] != "warning"])
    facts(overlap_facts(mechanism, compiled))
    for sentence in diagnosis.warnings:
        warnings.warn(JoustoWarning(sentence), stacklevel=1)
    if settings is not None:
        from jousto.simulation.running.closed_contacts import closed_contact_warning
        from jousto.simulation.solvers.bounded_work import check_bounded
        from jousto.simulation.solvers.default_solver import choose
        from jousto.simulation.solvers.schedule import schedule
        from jousto.simulation.solvers.stability import stability_warning

        solver = settings.solver
        if solver is None:
            solver, reason = choose(compiled, settings.t_end, settings.output_step)
            facts([("solver", f"{solver}, {reason}")])
        steps = schedule(compiled, settings.t_end, solver, settings.output_step)
        check_bounded(compiled, solver)
        if compiled.fmus:
            from jousto.simulation.cosimulation.requirements import check_coupling

            check_coupling(compiled, solver, steps, None, None)
        for sentence in (
            stability_warning(compiled, solver, steps.step),
            closed_contact_warning(compiled, solver, steps.step),
        ):
            if sentence:
                warnings.warn(JoustoWarning(f"{model.name}: simulation: {sentence}"), stacklevel=1)
    say(f"{model.name}: ok", style="green")


def describe_model(file: ModelFile) -> None:
    """Print the content of a model."""
    from jousto.schema.summary import model_facts

    facts(model_facts(file), file.mechanism.name)
