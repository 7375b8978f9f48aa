"""Command ``study``: outcomes of a model at many parameter values."""

from __future__ import annotations

import math
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, Problem
from jousto.cli.group import command
from jousto.cli.hotspots import check_targets
from jousto.cli.options import Model, On, Output, Trust, Workers, amount
from jousto.cli.study_options import LONG, WAYS, check_choice, nothing_varied, problems_of, varied
from jousto.cli.terminal import say

if TYPE_CHECKING:
    from jousto.base.arrays import Array
    from jousto.design.studies.parameters.parameter import Parameter

METHODS = ("lhs", "sobol", "random")


@command()
def study(
    model: Model,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            "--vary",
            metavar="NAME=VALUES",
            help="wall=2..8mm/20 (20 values), wall=2..8mm (to be sampled), wall=2,4,8mm, or"
            " load=lognormal(mean=1e3, sd=100); or a name alone, as in the file.",
        ),
    ] = None,
    outcome: Annotated[
        list[str] | None,
        typer.Option(
            "--outcome",
            metavar="OUTCOME",
            help="max(tip.y) (min, peak, range, rms, mean, first, last), mass, frequency(1),"
            " stress(arm), damage(arm), life(arm), reaction(pivot); NAME = ... names it.",
        ),
    ] = None,
    output: Output = None,
    samples: Annotated[
        str | None,
        typer.Option(
            metavar="N|FILE.csv", help="How many samples for every point of the grid; or a list."
        ),
    ] = None,
    method: Annotated[
        str, typer.Option(metavar="lhs|sobol|random", help="Distribution of the samples.")
    ] = "lhs",
    seed: Annotated[int, typer.Option(help="The same seed gives the same samples.")] = 0,
    workers: Workers = 1,
    on: On = "processes",
    t_end: Annotated[
        str | None, typer.Option("--t-end", metavar="TIME", help="End of the runs, '500 ms'.")
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option("--picture", metavar="FILE.png", help="Draw outcomes over parameters."),
    ] = None,
    retry: Annotated[bool, typer.Option("--retry", help="Try again what failed before.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress, no summary.")] = False,
    trust: Trust = False,
) -> None:
    """Vary parameters of a model and write a table of outcomes.

    The table goes to MODEL-study.h5 unless -o names another file (.h5, .csv, .parquet). Each row is
    stored at once: after a kill the same command continues. A failed point stays in the table with
    its reason.
    """
    from jousto.design.studies.outcomes.outcomes import read_outcomes
    from jousto.design.studies.study import study as function_of
    from jousto.design.studies.table import check_suffix
    from jousto.schema.read import read_model

    problems: list[Problem] = []
    file = read_model(model, trust=trust)
    target = output or model.with_name(f"{model.stem}-study.h5")
    points: Any = None
    parameters: list[Parameter] = []
    outcomes: Any = ()
    for check in (
        lambda: check_suffix(target),
        lambda: check_targets({picture: ()}),
        lambda: amount(t_end, "s", "--t-end"),
        lambda: _how_many(samples),
        lambda: check_choice("--method", method, METHODS),
        lambda: check_choice("--on", on, WAYS),
    ):
        problems += problems_of(check)
    known = {p.name: p for p in file.parameters}
    axes: dict[str, list[float]] = {}
    for text in vary or ():
        problems += problems_of(partial(_add, parameters, text, known, axes))
    if not vary and not (samples or "").endswith(".csv"):
        problems.append(Problem("--vary", nothing_varied(known)))
    try:
        outcomes = read_outcomes(outcome or ())
    except InputError as error:
        problems += error.problems
    names = [p.name for p in parameters]
    problems += (
        Problem(f"--vary {name}", "given twice") for name in set(names) if names.count(name) > 1
    )
    if (samples or "").endswith(".csv"):
        parameters = parameters or list(file.parameters)
    if not problems:
        try:
            points = _points(parameters, axes, samples, method, seed)
        except InputError as error:
            problems += error.problems
    if outcomes and parameters and not problems:
        made = function_of(file, parameters, outcomes, t_end=amount(t_end, "s", "--t-end"))
    if problems:
        raise InputError(problems)
    bar = sys.stderr.isatty() and not quiet
    how = "threads" if workers == 1 and on == "processes" else on
    table = made.run(points, workers=workers, how=how, path=target, retry=retry, progress=bar)
    if not quiet:
        say(str(table))
        say(f"table in {target}", style="green")
    if picture is not None:
        from jousto.output.plot import plot

        plot(table, path=picture)
        say(f"picture in {picture}", style="green")


def _add(
    parameters: list[Parameter],
    text: str,
    known: dict[str, Parameter],
    axes: dict[str, list[float]],
) -> None:
    parameters.append(varied(text, known, axes))


def _how_many(samples: str | None) -> None:
    from jousto.design.studies.parameters.samples import check_count

    given = samples is not None and not samples.endswith(".csv")
    if given and not (samples and samples.isdecimal() and int(samples) > 0):
        message = f"is {samples!r}, must be a number of samples or a file .csv"
        raise InputError(Problem("--samples", message))
    if given and samples:
        check_count("--samples", int(samples) if len(samples) < LONG else math.inf)


def _points(
    parameters: list[Parameter],
    axes: dict[str, list[float]],
    samples: str | None,
    method: str,
    seed: int,
) -> Array:
    """Return the sample points: grid points, each with random samples of the other parameters."""
    import numpy as np

    from jousto.design.studies.parameters import samples as spread

    if samples is not None and samples.endswith(".csv"):
        return spread.read_samples(samples, parameters)
    grid = spread.grid(parameters, {name: np.array(axis) for name, axis in axes.items()})
    rest = [k for k, p in enumerate(parameters) if p.name not in axes]
    if not rest:
        if samples is not None:
            raise InputError(Problem("--samples", "has no effect: all parameter values are listed"))
        return grid
    if samples is None and not axes:
        raise InputError(Problem("--samples", "give the number of samples, --samples 100"))
    spread.check_count("--samples", len(grid), int(samples or 1))
    points = np.repeat(grid, int(samples or 1), axis=0)
    make = {"lhs": spread.latin_hypercube, "sobol": spread.sobol, "random": spread.random_samples}
    points[:, rest] = make[method]([parameters[k] for k in rest], len(points), seed=seed)
    return points
