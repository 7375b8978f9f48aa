"""Commands on parts: reduce."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

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
    finish_reduction(reduced)
    say(f"reduced part in {target}", style="green")


def finish_reduction(reduced: ReducedPart) -> None:
    """Print what was reduced."""
    describe_part(reduced)


def describe_part(part: ReducedPart) -> None:
    """Print what is in a reduced part."""
    from jousto.schema.summary import part_facts

    facts(part_facts(part), f"reduced part {part.name}")
