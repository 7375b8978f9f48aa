"""Command ``realtime``: step times of a machine as a compiled program."""

from __future__ import annotations

from typing import Annotated

import typer

from jousto.cli.group import command
from jousto.cli.options import Model, Trust, amount
from jousto.cli.terminal import progress_bar, say


@command()
def realtime(
    model: Model,
    step: Annotated[
        str | None, typer.Option("--step", metavar="TIME", help="Own step, '0.5 ms'.")
    ] = None,
    steps: Annotated[
        int, typer.Option("--steps", min=1000, help="How many are timed.")
    ] = 1_000_000,
    margin: Annotated[
        float, typer.Option("--margin", min=1.0, help="Of the rate that is held.")
    ] = 2.0,
    urgent: Annotated[
        bool, typer.Option("--urgent/--ordinary", help="Go before other programs, where allowed.")
    ] = True,
    trust: Trust = False,
) -> None:
    """Measure the time of single steps of a machine as a C program on this computer.

    The command prints the median and the longest steps, the memory, the rate at which all but one
    of 10,000 steps keep the margin, and, where Valgrind is installed, the instructions of a step by
    kinds of elements. Other programs on the same cores increase the longest steps.
    """
    from jousto.cli.export import machine_of
    from jousto.export.realtime import realtime as measure

    compiled, solver, state = machine_of(model, amount(step, "s", "--step"), trust)[:3]
    with progress_bar("compiling and timing"):
        found = measure(compiled, solver, state=state, steps=steps, urgent=urgent)
    say(str(found))
    say(f"with a margin of {margin:g}: {found.rate(margin):.0f} steps a second")
