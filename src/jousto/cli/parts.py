"""Commands on parts: reduce, export."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, MissingFileError, Problem
from jousto.base.names import file_name
from jousto.cli.certificates import Html, page_path, tell_certificate
from jousto.cli.group import command
from jousto.cli.options import Output, PartName, PartPath, Solver
from jousto.cli.terminal import FAILED, facts, say

if TYPE_CHECKING:
    from jousto.reduction.reduced import ReducedPart


@command("reduce")
def reduce_part(
    part: PartPath,
    name: PartName = None,
    output: Output = None,
    html: Html = None,
    bare: Annotated[
        bool, typer.Option("--no-certificate", help="Compare nothing with the full model.")
    ] = False,
    strict: Annotated[
        bool, typer.Option("--strict", help="End with code 1 if the certificate has a fault.")
    ] = False,
    solver: Solver = None,
    cache: Annotated[
        bool | None,
        typer.Option(
            "--cache/--no-cache",
            help="Keep the result, and the stages of a run that is killed, for the next time; "
            "if neither is given, of parts that take long.",
        ),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Reduce a part to modes; it goes to NAME.h5 next to the file unless -o names another file.

    A reduction that was killed continues after its last finished stage when it is started again.

    Ends with the certificate: what the part weighs, whether it is sound, and how its modes compare
    with the full model.
    """
    from jousto.schema.file.read import read_part_file
    from jousto.schema.targets import REDUCED_PART, output_path

    if strict and bare:
        raise InputError(Problem("--strict", "needs the certificate, without --no-certificate"))
    # a wrong output should not cost a reduction
    if output is not None:
        output_path(output, part, ".h5", kind=REDUCED_PART)
    page = page_path(html, part)
    options: dict[str, Any] = {"solver": solver, "cache": cache}
    options = {key: value for key, value in options.items() if value is not None}
    progress = sys.stderr.isatty() and not quiet
    if progress:
        options["progress"] = True
    file = read_part_file(part, name, **options)
    reduced = file.reduced
    target = output_path(output, part, f"{file_name(reduced.name)}.h5", kind=REDUCED_PART)
    reduced.save(target)
    describe_part(reduced)
    passed = bare or tell_certificate(file, page, solver=solver, progress=progress)
    say(f"reduced part in {target}", style="green")
    if strict and not passed:
        raise typer.Exit(FAILED)


@command()
def export(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Reduced part or results (HDF5).")],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="File to write.")],
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME]...", help="Sensors of results; all if none."),
    ] = None,
) -> None:
    """Write a reduced part or results for other programs; the ending selects which.

    Reduced parts: .vtu (ParaView, with modes and modal stress), .fem (MBDyn), .sid (standard
    input data). Results: .csv (time and sensors).
    """
    from jousto.schema.targets import REDUCED_PART, RESULTS, hdf5_format, output_path

    kind, suffix = hdf5_format(file), output.suffix.lower()
    if not file.is_file():
        raise MissingFileError(Problem(str(file), "no such file"))
    known = {REDUCED_PART: (".vtu", ".fem", ".sid"), RESULTS: (".csv",)}.get(kind)
    if known is None:
        raise InputError(Problem(str(file), "is neither a reduced part nor results of jousto"))
    if suffix not in known:
        what = "a reduced part" if kind == REDUCED_PART else "results"
        raise InputError(Problem(str(output), f"must end with {', '.join(known)} to export {what}"))
    from jousto.output.write import write

    output_path(output, file, suffix)
    if kind == RESULTS:
        from jousto.simulation.results.solution import load

        write(load(file), output, *(names or ()))
    else:
        from jousto.reduction.reduced import ReducedPart

        if names:
            raise InputError(Problem(names[0], "a reduced part has no sensors to name"))
        write(ReducedPart.load(file), output)
    say(f"written to {output}", style="green")


def describe_part(part: ReducedPart) -> None:
    """Print what is in a reduced part."""
    from jousto.schema.summary import part_facts

    facts(part_facts(part), f"reduced part {part.name}")
