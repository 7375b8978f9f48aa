"""Commands on parts: reduce."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.cli.certificates import Html, page_path, tell_certificate
from jousto.cli.options import Debug, Output, app
from jousto.cli.terminal import command, facts, say

if TYPE_CHECKING:
    from jousto.reduction import ReducedPart


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
    html: Html = None,
    bare: Annotated[
        bool, typer.Option("--no-certificate", help="Compare nothing with the full model.")
    ] = False,
    solver: Annotated[
        str | None,
        typer.Option("--solver", metavar="NAME", help="Library for the factorisation."),
    ] = None,
    cache: Annotated[
        bool | None,
        typer.Option(
            "--cache/--no-cache",
            help="Keep the result, and the stages of a run that is killed, for the next time; "
            "if neither is given, of parts that take long.",
        ),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
    debug: Debug = False,
) -> None:
    """Reduce a part to modes; it goes to NAME.h5 next to the file unless -o says otherwise.

    A reduction that was killed goes on after its last finished stage when it is started again.

    Ends with the certificate: what the part weighs, whether it is sound, and how its modes compare
    with the full model.
    """
    from jousto.schema import read_part_file
    from jousto.schema.targets import REDUCED_PART, output_path

    # a wrong output should not cost a reduction
    if output is not None:
        output_path(output, part, ".h5", kind=REDUCED_PART)
    page = page_path(html, part)
    options: dict[str, Any] = {"solver": solver, "cache": cache}
    options = {key: value for key, value in options.items() if value is not None}
    if sys.stderr.isatty() and not quiet:
        options["progress"] = True
    file = read_part_file(part, name, **options)
    reduced = file.reduced
    target = output_path(output, part, f"{reduced.name}.h5", kind=REDUCED_PART)
    reduced.save(target)
    describe_part(reduced)
    if not bare:
        tell_certificate(file, page)
    say(f"reduced part in {target}", style="green")


def describe_part(part: ReducedPart) -> None:
    """Print what is in a reduced part."""
    from jousto.schema.summary import part_facts

    facts(part_facts(part), f"reduced part {part.name}")
