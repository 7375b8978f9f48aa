"""jousto study: a model at many points."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, Problem, suggest
from jousto.cli.group import command
from jousto.cli.hotspots import check_targets
from jousto.cli.options import Model, Output, Trust, amount
from jousto.cli.terminal import say

if TYPE_CHECKING:
    from jousto.base.arrays import Array
    from jousto.design.studies.parameter import Parameter

METHODS = ("lhs", "sobol", "random")
RANGE = re.compile(r"(.+?)\.\.(.+?)(?:/\s*(\d+))?")


@command()
def study(
    model: Model,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            "--vary",
            metavar="NAME=VALUES",
            help="wall=2..8mm/20 (20 values), wall=2..8mm (to be sampled), wall=2,4,8mm, or"
            " load=lognormal(mean=1e3, sd=100); or a name alone, as the file says.",
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
        str, typer.Option(metavar="lhs|sobol|random", help="How samples are spread.")
    ] = "lhs",
    seed: Annotated[int, typer.Option(help="The same seed gives the same samples.")] = 0,
    workers: Annotated[int, typer.Option(min=1, help="How many at once.")] = 1,
    on: Annotated[
        str, typer.Option("--on", metavar="threads|processes|dask", help="What works.")
    ] = "processes",
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

    The table goes to MODEL-study.h5 unless -o names another file (.h5, .csv, .parquet). Rows are
    kept as they come: after a kill the same command goes on. A point that fails stays in the table
    with its reason.
    """
    from jousto.design.studies.outcomes import read_outcomes
    from jousto.design.studies.study import study as function_of
    from jousto.design.studies.table import check_suffix
    from jousto.schema.file.read import read_model

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
        lambda: _choice("--method", method, METHODS),
        lambda: _choice("--on", on, ("threads", "processes", "dask")),
    ):
        problems += _problems(check)
    known = {p.name: p for p in file.parameters}
    axes: dict[str, list[float]] = {}
    for text in vary or ():
        problems += _problems(lambda t=text: parameters.append(_varied(t, known, axes)))
    if not vary and not (samples or "").endswith(".csv"):
        problems.append(Problem("--vary", _nothing(known)))
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


def _problems(check: Any) -> list[Problem]:
    """Return what is wrong, if anything is."""
    try:
        check()
    except InputError as error:
        return list(error.problems)
    return []


def _how_many(samples: str | None) -> None:
    given = samples is not None and not samples.endswith(".csv")
    if given and not (samples and samples.isdecimal() and int(samples) > 0):
        message = f"is {samples!r}, must be a number of samples or a file .csv"
        raise InputError(Problem("--samples", message))


def _choice(option: str, word: str, known: tuple[str, ...]) -> None:
    if word not in known:
        raise InputError(Problem(option, f"is {word!r}{suggest(word, known)}"))


def _nothing(known: dict[str, Any]) -> str:
    if not known:
        return "the model has no parameters; add parameters: {wall: 4 mm} and use ${wall}"
    return f"name what is varied: {', '.join(known)}"


def _varied(text: str, known: dict[str, Parameter], axes: dict[str, list[float]]) -> Parameter:
    """Return the parameter of an option; values of a grid go into `axes`."""
    from jousto.design.studies.distributions import CALL, read_distribution

    name, equals, values = (piece.strip() for piece in text.partition("="))
    where = f"--vary {name}"
    if name not in known:
        tail = suggest(name, known) if known else f"; {_nothing(known)}"
        raise InputError(Problem("--vary", f"no parameter {name!r}{tail}"))
    own = known[name]
    if not equals:
        return own
    if CALL.fullmatch(values):
        made = read_distribution(values, own.value, own.exponents, where)
        return replace(own, distribution=made)
    match = RANGE.fullmatch(values)
    if match is None:
        axes[name] = _numbers(values.split(","), own, where)
        return replace(own, bounds=None)
    low, high = _numbers([match[1], match[2]], own, where)
    if not low < high:
        raise InputError(Problem(where, f"{low:g} must be below {high:g}"))
    if match[3] is None:
        value = min(max(own.value, low), high)
        return replace(own, value=value, bounds=(low, high), distribution=None)
    count = int(match[3])
    if count < 2:
        raise InputError(Problem(where, f"has {count} values, must have 2 or more"))
    axes[name] = [low + (high - low) * k / (count - 1) for k in range(count)]
    return replace(own, bounds=None)


def _numbers(texts: list[str], parameter: Parameter, where: str) -> list[float]:
    """Return values in SI; the unit of the last one is that of those without."""
    from jousto.base.expressions import NONE, ExpressionError, evaluate

    unit = re.sub(r"^\s*[-+]?[\d._]+(?:[eE][-+]?\d+)?", "", texts[-1]).strip()
    found = []
    for text in texts:
        try:
            quantity = evaluate(text, {})
            if unit and quantity.exponents == NONE:
                quantity = evaluate(f"{text} {unit}", {})
        except ExpressionError as error:
            raise InputError(Problem(where, str(error))) from None
        if quantity.exponents not in (NONE, parameter.exponents):
            raise InputError(Problem(where, f"{quantity.said} must be in {parameter.unit}"))
        found.append(quantity.value)
    return found


def _points(
    parameters: list[Parameter],
    axes: dict[str, list[float]],
    samples: str | None,
    method: str,
    seed: int,
) -> Array:
    """Return the points: the grid, with samples of what is not on it."""
    import numpy as np

    from jousto.design.studies import samples as spread

    if samples is not None and samples.endswith(".csv"):
        return spread.read_samples(samples, parameters)
    grid = spread.grid(parameters, {name: np.array(axis) for name, axis in axes.items()})
    rest = [k for k, p in enumerate(parameters) if p.name not in axes]
    if not rest:
        if samples is not None:
            raise InputError(Problem("--samples", "nothing is sampled: all values are listed"))
        return grid
    if samples is None and not axes:
        raise InputError(Problem("--samples", "say how many, --samples 100"))
    points = np.repeat(grid, int(samples or 1), axis=0)
    make = {"lhs": spread.latin_hypercube, "sobol": spread.sobol, "random": spread.random_samples}
    points[:, rest] = make[method]([parameters[k] for k in rest], len(points), seed=seed)
    return points
