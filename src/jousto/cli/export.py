"""jousto export: parts, results and whole machines for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, MissingFileError, Problem
from jousto.cli.group import command
from jousto.cli.options import Trust, amount, compile_model
from jousto.cli.terminal import progress_bar, say

if TYPE_CHECKING:
    from jousto.model.model import Model as CompiledModel

PROGRAMS = (".c", ".zip", ".fmu", ".html")
KNOWN = {
    "reduced part": (".vtu", ".fem", ".sid"),
    "results": (".csv", ".pvd", ".vtu"),
    "model": PROGRAMS,
}


@command()
def export(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Reduced part or results (HDF5), or a model.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="File to write.")],
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME]...", help="Sensors of results; all if none."),
    ] = None,
    step: Annotated[
        str | None,
        typer.Option("--step", metavar="TIME", help="Own step of a machine, '0.5 ms'."),
    ] = None,
    fmi: Annotated[int, typer.Option("--fmi", metavar="2|3", help="Version of an .fmu.")] = 3,
    on: Annotated[
        list[str] | None,
        typer.Option(
            "--on",
            metavar="PLATFORM",
            help="Binaries of an .fmu: here, x86_64-linux, aarch64-linux, x86_64-windows, "
            "x86_64-darwin, aarch64-darwin; 'none' for sources alone.",
        ),
    ] = None,
    derivatives: Annotated[
        bool, typer.Option("--derivatives", help="Directional derivatives in an .fmu.")
    ] = False,
    inputs: Annotated[
        list[str] | None,
        typer.Option(
            "--input", metavar="NAME=LOW..HIGH", help="Range of an input in an .html, in SI."
        ),
    ] = None,
    twin: Annotated[
        bool,
        typer.Option(
            "--twin", help="Not the machine but the twin of its block monitor (.c, .zip)."
        ),
    ] = False,
    trust: Trust = False,
) -> None:
    """Write a reduced part, results or a machine for other programs; the ending selects which.

    Reduced parts: .vtu (ParaView, with modes and modal stress), .fem (MBDyn), .sid (standard input
    data). Results: .csv (time and sensors), .pvd (ParaView, all bodies at all instants), .vtu (at
    the last instant). Models: .c (one file of C99 and its header), .zip (the same as a project),
    .fmu (functional mock-up unit), .html (a page in which the machine runs, with a slider for each
    input); they use the method and the initial state of the model file. With --twin: a program that
    reads the strains of the block monitor and computes stress with its band, and damage.
    """
    from jousto.schema.output_paths import REDUCED_PART, RESULTS, hdf5_format, output_path

    if not file.is_file():
        raise MissingFileError(Problem(str(file), "no such file"))
    kind = hdf5_format(file)
    what = {REDUCED_PART: "reduced part", RESULTS: "results"}.get(kind, "")
    if not what:
        from jousto.schema.file.document import MODELS

        what = "model" if file.suffix.lower() in MODELS else ""
    if not what:
        raise InputError(
            Problem(str(file), "is neither a reduced part, results of jousto nor a model file")
        )
    suffix = output.suffix.lower()
    if suffix not in KNOWN[what]:
        endings = ", ".join(KNOWN[what])
        shown = what if what == "results" else f"a {what}"
        raise InputError(Problem(str(output), f"must end with {endings} to export {shown}"))
    if suffix != ".fmu" and (on or fmi != 3 or derivatives):
        raise InputError(
            Problem(str(output), "--fmi, --on and --derivatives apply to .fmu files only")
        )
    if suffix != ".html" and inputs:
        raise InputError(Problem(str(output), "--input applies to .html files only"))
    if names and (what != "results" or suffix != ".csv"):
        shown = f"a {what}" if what != "results" else f"a file {suffix}"
        raise InputError(Problem(names[0], f"{shown} has no sensors to name"))
    from jousto.output.write import write

    output_path(output, file, suffix)
    if what == "results":
        from jousto.simulation.results.solution import load

        write(load(file), output, *(names or ()))
    elif twin:
        with progress_bar("writing the twin"):
            _twin(file, output, what, trust)
    elif what == "model":
        length = amount(step, "s", "--step")
        with progress_bar("writing and compiling"):
            if suffix == ".html":
                _page(file, output, length, inputs or [], trust)
            else:
                _machine(file, output, length, fmi, on, derivatives, trust)
    else:
        from jousto.reduction.reduced import ReducedPart

        write(ReducedPart.load(file), output)
    say(f"written to {output}", style="green")


def _twin(file: Path, output: Path, what: str, trust: bool) -> None:
    """Write the twin that the block ``monitor`` of a model file describes."""
    from jousto.cli.monitor import reference_run
    from jousto.output.write import write
    from jousto.schema.read import read_model

    if what != "model" or output.suffix.lower() == ".fmu":
        raise InputError(Problem("--twin", "converts a model file to .c or .zip"))
    found = read_model(file, trust=trust)
    if found.monitor is None:
        raise InputError(
            Problem(
                file.name,
                "has no block monitor; add monitor: {spots: [..], ..}, see docs/model-stress.md",
            )
        )
    write(found.monitor.monitor(reference_run(found, file, True)), output)


def machine_of(file: Path, step: float | None, trust: bool) -> tuple[CompiledModel, Any, Any, Any]:
    """Return compiled model, fixed-step method, initial state and the model file itself."""
    from dataclasses import replace

    from jousto.schema.read import read_model
    from jousto.simulation.solvers.default_solver import choose, choose_fixed

    found = read_model(file, trust=trust)
    model = compile_model(found.mechanism)
    given: dict[str, Any] = {} if found.simulation is None else found.simulation.given(model)
    solver: Any = given.get("solver")
    if solver is None and found.simulation is not None:
        solver = choose(model, found.simulation.t_end, found.simulation.output_step)[0]
    elif solver is None:
        solver = choose_fixed(model)
    if step is not None:
        solver = replace(solver, step=step)
    return model, solver, given.get("state"), found


def _machine(
    file: Path,
    output: Path,
    step: float | None,
    fmi: int,
    on: list[str] | None,
    derivatives: bool,
    trust: bool,
) -> None:
    """Write a machine with the method, the initial state and the end time of its model file."""
    from jousto.export.tunable_constants import named_constants
    from jousto.output.write import write

    model, solver, state, found = machine_of(file, step, trust)
    named = named_constants(found, model)
    if output.suffix.lower() != ".fmu":
        write(model, output, solver=solver, state=state, named=named)
        return
    end = None if found.simulation is None else found.simulation.t_end
    places = () if on == ["none"] else tuple(on or ("here",))
    documents = {f"resources/{file.name}": file.read_bytes()}
    write(
        model,
        output,
        solver=solver,
        state=state,
        version=fmi,
        on=places,
        stop=end or 1.0,
        documents=documents,
        derivatives=derivatives,
        named=named,
    )


def _page(file: Path, output: Path, step: float | None, inputs: list[str], trust: bool) -> None:
    """Write a machine as an HTML page in which it runs."""
    from jousto.export.tunable_constants import named_constants
    from jousto.output.write import write
    from jousto.simulation.live.ranges import parse_ranges

    ranges = parse_ranges(inputs)
    model, solver, state, found = machine_of(file, step, trust)
    named = named_constants(found, model)
    write(model, output, solver=solver, state=state, ranges=ranges, named=named)
