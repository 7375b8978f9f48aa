"""The command on loads of bodies and on forces along exact beams."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, Problem, Problems, warn
from jousto.cli.group import command
from jousto.cli.options import (
    From,
    Output,
    To,
    Trust,
    compile_model,
    end_time,
    instant,
    only_one,
)
from jousto.cli.terminal import columns, say

if TYPE_CHECKING:
    from jousto.mechanism.mechanism import Mechanism
    from jousto.model.model import Model
    from jousto.parts.part import Part
    from jousto.recovery.loads.body_loads import BodyLoads
    from jousto.simulation.results.solution import Solution

    Machine = tuple[Mechanism, Model]

DECKS = ("inp", "bdf", "nas")


@command()
def forces(
    source: Annotated[
        Path, typer.Argument(metavar="MODEL|RESULT", help="Model file, or results of a run.")
    ],
    body: Annotated[
        str | None,
        typer.Argument(metavar="[BODY]", help="Body or exact beam; may be left out if only one."),
    ] = None,
    at: Annotated[
        list[str] | None, typer.Option("--at", metavar="TIME", help="An instant, '0.5 s'; again.")
    ] = None,
    start: From = None,
    end: To = None,
    frame: Annotated[
        str, typer.Option("--frame", metavar="body|world", help="Axes of the loads on a body.")
    ] = "body",
    model: Annotated[
        Path | None,
        typer.Option(
            "--model", metavar="FILE", help="Model of the results, if they lack its text."
        ),
    ] = None,
    program: Annotated[
        str | None,
        typer.Option(
            "--program", metavar="calculix|abaqus", help="Dialect of an .inp file; calculix."
        ),
    ] = None,
    output: Output = None,
    trust: Trust = False,
) -> None:
    """Print all loads on a body with their balance, or the forces along an exact beam.

    A body: joints, forces, friction, gravity, inertia and elastic forces, the largest of the run or
    those at the instants --at. A model is simulated first. -o writes a table .csv, or a deck .inp
    (CalculiX, Abaqus), .bdf or .nas (Nastran) of the part with a load step for each instant --at.

    A beam: the smallest and largest forces and moments along it, with place and time, in the whole
    run, from --from to --to, or at the instants --at only. -o writes the envelope or the instant
    --at as .csv, diagrams at the instants --at as .png, .svg, .pdf, .jpg, .jpeg, .webp or .eps, the
    swept surface with its stress as .vtu, and all instants as .pvd.
    """
    from jousto.output.style import PICTURES, target
    from jousto.output.write import write
    from jousto.recovery.shape import find_body
    from jousto.schema.file.document import is_hdf5
    from jousto.simulation.results.solution import load

    moments = sorted(float(instant(text, "--at") or 0.0) for text in at or ())
    first, last = instant(start, "--from"), instant(end, "--to")
    if output is not None:
        target(output, ("csv", "vtu", "pvd", *PICTURES, *DECKS))
    stored = is_hdf5(source)
    if model is not None and not stored:
        raise InputError(Problem("--model", f"{source} is a model itself; leave --model out"))
    if program is not None and (output is None or output.suffix.lower().lstrip(".") not in DECKS):
        message = "is the dialect of a deck; name the deck, -o FILE.inp, or leave --program out"
        raise InputError(Problem("--program", message))
    run, machine = (load(source), None) if stored else simulated(source, trust)
    beams, bodies = [beam.name for beam in run.beams], bodies_of(run)
    name = body or only_one(
        beams or bodies, run.where, "beams" if beams else "bodies", "this run has no bodies"
    )
    find_body(run, name)  # an unknown name is an error with the nearest one
    if name in beams:
        problems = Problems()
        for option, differs in (("--model", model is not None), ("--frame", frame != "body")):
            if differs:
                problems.add(option, f"is for loads on a body; {name!r} is an exact beam")
        problems.raise_if_any()
        along_beam(run, name, moments, (first, last), output)
        return
    if output is not None:
        suffix = target(output, ("csv", *DECKS)).suffix.lower()
        if suffix != ".csv" and not moments:
            raise InputError(Problem("--at", "name the instants of the load steps, --at '0.5 s'"))
    if machine is None:
        machine = machine_of_results(run, source, model, trust)
    loads = on_body(run, machine[1], name, moments, (first, last), frame)
    if output is None:
        return
    if suffix == ".csv":
        path = loads.to_csv(output)
    else:
        part = part_of(machine[0], name, model if stored else source)
        options: dict[str, Any] = {"times": moments, "program": program}
        path = write(loads, output, part, **options)
    say(f"written to {path}", style="green")


def bodies_of(run: Solution) -> list[str]:
    """Return the names of the bodies without the nodes of beams."""
    beams = {beam.name for beam in run.beams}
    names = [shape.name for shape in run.bodies]
    return [name for name in names if name.rpartition(".node")[0] not in beams]


def simulated(path: Path, trust: bool) -> tuple[Solution, Machine]:
    """Return the run of a model file by its own settings, in memory, and its machine."""
    from jousto.schema.read import read_model
    from jousto.simulation.running.simulate import simulate

    file = read_model(path, trust=trust, progress=sys.stderr.isatty())
    until = end_time(file, path)
    compiled = compile_model(file.mechanism)
    given = file.simulation.given(compiled) if file.simulation is not None else {}
    shown = sys.stderr.isatty()
    run = simulate(compiled, until, progress=shown, model_text=file.text, **given)
    return run, (file.mechanism, compiled)


def machine_of_results(run: Solution, source: Path, given: Path | None, trust: bool) -> Machine:
    """Return the machine of results: of a model file, or of the text stored with them.

    Raises
    ------
    InputError
        If the results contain no text, or a text that cannot be read here.
    """
    from jousto.schema.read import parse_model, read_model

    if given is not None:
        file = read_model(given, trust=trust)
        if run.model_text.strip() and run.model_text.strip() != file.text.strip():
            message = (
                f"{given} is not the text of the model in {source.name}; without --model the loads "
                "are those of that text"
            )
            warn("--model", message)
        return file.mechanism, compile_model(file.mechanism)
    if not run.model_text.strip():
        message = (
            "does not contain its model, which was made in Python: jo.recovery.loads_of(run, "
            "body) gives its loads there; or give --model FILE"
        )
        raise InputError(Problem(str(source), message))
    folder = source.resolve().parent
    file = parse_model(run.model_text, name=f"model in {source.name}", folder=folder, trust=trust)
    return file.mechanism, compile_model(file.mechanism)


def on_body(
    run: Solution,
    model: Model,
    name: str,
    moments: list[float],
    span: tuple[float | None, float | None],
    frame: str,
) -> BodyLoads:
    """Print the loads on a body, and return them."""
    from jousto.recovery.instants import window
    from jousto.recovery.loads.body_loads import FRAMES
    from jousto.recovery.loads.gathered_loads import loads_of

    problems = Problems()
    if frame not in FRAMES:
        problems.add("--frame", f"is {frame!r}, must be 'body' or 'world'")
    if moments and span != (None, None):
        problems.add("--at", "with --from or --to: give either instants or a span")
    problems.raise_if_any()
    times = moments or run.time[window(run.time, *span, run.where)]
    loads = loads_of(run, name, times, model=model).resolved(frame)  # type: ignore[arg-type]
    for t in moments:
        say(f"loads on {name} at {t:g} s, {frame} axes, moments about the place")
        columns(loads.table(t), "<<<>")
    if not moments:
        columns(loads.table(), "<<<>")
    say(loads.verdict)
    return loads


def part_of(mechanism: Mechanism, body: str, file: Path | None) -> Part:
    """Return the part of a flexible body: as reduced, or read again from the model file.

    Raises
    ------
    InputError
        If the body has no part, or the file is not known.
    """
    from jousto.schema.read import read_part_file

    found: Any = next(x for x in mechanism.bodies if x.name == body)
    reduced = getattr(found, "reduced", None)
    if reduced is None:
        message = "is rigid and has no part; in Python jo.write(loads, path, part) takes one"
        raise InputError(Problem(f"body '{body}'", message))
    part: Part | None = reduced.source
    if part is None and file is not None:
        part = read_part_file(file, reduced.name, reduce=False).part
    if part is None:
        message = (
            f"its part '{reduced.name}' is not known here; give --model FILE, or in Python "
            "jo.write(loads, path, part)"
        )
        raise InputError(Problem(f"body '{body}'", message))
    return part


def along_beam(
    run: Solution,
    name: str,
    moments: list[float],
    span: tuple[float | None, float | None],
    output: Path | None,
) -> None:
    """Print the forces along a beam, and write them as a table, diagrams or a surface."""
    from jousto.recovery.beams.forces import section_forces

    suffix = "" if output is None else output.suffix.lower()
    if suffix == ".csv" and len(moments) > 1:
        raise InputError(Problem("--at", f"a table has one instant, not {len(moments)}"))
    found = section_forces(run, name, start=span[0], end=span[1])
    # start and end must lie within the run
    say(str(section_forces(run, name, times=moments) if moments else found))
    if output is None:
        return
    if suffix == ".csv":
        path = found.to_csv(output, *moments)
    elif suffix in (".vtu", ".pvd"):
        from jousto.output.write import write

        path = write(run, output, beam=name, times=moments or None)
    else:
        from jousto.output.plot import plot

        path = output
        plot(found, times=moments or None, path=output)
    say(f"written to {path}", style="green")
