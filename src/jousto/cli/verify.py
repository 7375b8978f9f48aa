"""Command ``verify``: comparison of the engine with a second formulation."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from jousto.cli.group import command
from jousto.cli.options import Model, Trust, amount
from jousto.cli.terminal import FAILED, say

COLOURS = {"agree": "green", "undecided": "yellow", "disagree": "red"}


@command()
def verify(
    model: Model,
    t_end: Annotated[
        str | None,
        typer.Option("--t-end", metavar="TIME", help="End of the runs such as 2 or '500 ms'."),
    ] = None,
    step: Annotated[
        str | None, typer.Option("--step", metavar="TIME", help="Longer step of both; 1 ms.")
    ] = None,
    beside: Annotated[
        list[Path] | None,
        typer.Option(
            "--beside", metavar="MODEL", help="A model to compare it with, such as a finer mesh."
        ),
    ] = None,
    trust: Trust = False,
) -> None:
    """Compare the engine with the moving-frame formulation; exit code 1 if they differ.

    Every sensor, acceleration, reaction and force is compared at the same states, and in runs with
    two steps. Both start as in the model file. Sensors of the models --beside are compared by their
    names.
    """
    from jousto.base.errors import InputError, Problem
    from jousto.natural.verify import verify as compare
    from jousto.schema.read import read_model

    file = read_model(model, trust=trust)
    end = amount(t_end, "s", "--t-end")
    if end is None and file.simulation is not None:
        end = file.simulation.t_end
    if end is None:
        raise InputError(Problem(model.name, "has no simulation with its end; give --t-end"))
    longer = amount(step, "s", "--step")
    begin = None if file.simulation is None else file.simulation.begin
    found = compare(
        file.mechanism,
        end,
        step=1e-3 if longer is None else longer,
        begin=begin,
        beside={str(path): read_model(path, trust=trust).mechanism for path in beside or ()},
    )
    say(str(found).removesuffix(found.verdict).rstrip())
    say(found.verdict, style=COLOURS[found.word])
    if not found.agrees:
        raise typer.Exit(FAILED)
