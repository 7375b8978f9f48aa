"""Commands on parts: reduce."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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
    debug: Debug = False,
) -> None:
    """Reduce a part to modes; it goes to NAME.h5 next to the file unless -o says otherwise.

    Ends with the certificate: what the part weighs, whether it is sound, and how its modes compare
    with the full model.
    """
    from jousto.schema import read_part_file
    from jousto.schema.targets import REDUCED_PART, output_path

    # a wrong output should not cost a reduction
    if output is not None:
        output_path(output, part, ".h5", kind=REDUCED_PART)
    page = page_path(html, part)
    file = read_part_file(part, name)
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
