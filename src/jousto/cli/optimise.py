"""Command ``optimise``: dimensions of least mass within the limits of a model."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, Problem
from jousto.cli.group import command
from jousto.cli.hotspots import check_targets
from jousto.cli.options import Drawing, End, Limits, Model, Output, Trust, Vary, amount, tell_files
from jousto.cli.study_options import check_choice, check_index, problems_of, read_study
from jousto.cli.terminal import FAILED, columns, say

if TYPE_CHECKING:
    from jousto.design.optimisation.optimum import Optimum
    from jousto.design.studies.outcomes.requirement import Requirement

WITHOUT = "is for designs without scatter; leave it out with --reliable"
NO_EFFECT = "has no effect without --machine rigid"
METHODS = {"esl1": ("esl", 1), "esl0": ("esl", 0), "direct": ("direct", 1)}


@command()
def optimise(
    model: Model,
    limit: Limits = None,
    vary: Vary = None,
    minimise: Annotated[
        str,
        typer.Option(
            metavar="COST", help="mass, mass(boom), or arithmetic of parameters, '2 * b + h'."
        ),
    ] = "mass",
    method: Annotated[
        str,
        typer.Option(
            metavar="esl1|esl0|direct",
            help="Equivalent static loads of order 1 or 0, or the runs themselves.",
        ),
    ] = "esl1",
    compare: Annotated[bool, typer.Option("--compare", help="All three, side by side.")] = False,
    machine: Annotated[
        str | None,
        typer.Option(
            metavar="flexible|rigid",
            help="Machine of the runs; rigid: each flexible part vibrates alone.",
        ),
    ] = None,
    held: Annotated[
        str | None,
        typer.Option(
            metavar="motion|force", help="With rigid: parts follow its joints, or are free."
        ),
    ] = None,
    beyond: Annotated[
        bool, typer.Option("--beyond", help="With rigid: parts carry the bodies beyond them.")
    ] = False,
    load_tolerance: Annotated[
        float | None,
        typer.Option(metavar="SHARE", help="With rigid: change of the interface loads that ends."),
    ] = None,
    reliable: Annotated[
        bool,
        typer.Option("--reliable", help="Limits have an index of reliability, by SORA."),
    ] = False,
    target: Annotated[
        float | None,
        typer.Option(metavar="BETA", help="That index, instead of the model's reliability."),
    ] = None,
    tolerance: Annotated[
        float, typer.Option(metavar="SHARE", help="Step, of the bounds, that ends.")
    ] = 1e-4,
    cycles: Annotated[int, typer.Option(min=1, help="At most.")] = 50,
    starts: Annotated[
        int, typer.Option("--starts", min=1, help="How many starts; the best is kept.")
    ] = 1,
    t_end: End = None,
    output: Output = None,
    picture: Drawing = None,
    trust: Trust = False,
) -> None:
    """Find the dimensions of least mass that satisfy the limits of a model at all instants.

    The design variables are the parameters with bounds; limits of stress, deflection, frequency,
    life and damage come from the model file or from --limit. The command prints the design, the
    active limits, and the residual of the optimality conditions. -o writes the history (.csv), or a
    page with history and active limits (.html); --compare puts the three methods side by side in
    all of these. With --machine rigid an outer loop runs the machine with rigid bodies, an inner
    loop optimises each part alone under its loads, and the flexible machine's peaks at the end are
    printed beside those of the parts. With --reliable, parameters with a distribution are random,
    and each limit is exceeded at most with the probability of its reliability index.
    """
    from jousto.schema.read import read_model

    given = {"held": held, "beyond": beyond or None, "load_tolerance": load_tolerance}
    checks = (
        lambda: check_targets({output: ("csv",) if reliable else ("csv", "html"), picture: ()}),
        lambda: amount(t_end, "s", "--t-end"),
        lambda: check_choice("--method", method, tuple(METHODS)),
        lambda: _check_together(reliable, target, compare, method, starts),
        lambda: _check_machine(reliable, machine, given),
    )
    file = read_model(model, trust=trust)
    wanted = ("bounds", "distribution") if reliable else ("bounds",)
    limits, parameters = read_study(limit, vary, file, wanted, checks)
    made = {"cost": minimise, "parameters": parameters, "t_end": amount(t_end, "s", "--t-end")}
    how = {"tolerance": tolerance, "cycles": cycles}
    if reliable:
        _reliable(file, limits, made | how | {"target": target}, output, picture)
        return
    runs = _runs(method, compare, _machine(file, machine, given))
    _least(file, limits, made, how | {"starts": starts}, runs, output, picture)


def _check_together(
    reliable: bool, target: float | None, compare: bool, method: str, starts: int
) -> None:
    """Raise InputError for options that exclude each other."""
    problems = problems_of(lambda: check_index(target))
    if not reliable and target is not None:
        problems.append(Problem("--target", "is an index of reliability: add --reliable"))
    if reliable and (compare or method != "esl1"):
        problems.append(Problem("--compare" if compare else "--method", WITHOUT))
    if reliable and starts > 1:
        problems.append(Problem("--starts", WITHOUT))
    if problems:
        raise InputError(problems)


def _check_machine(reliable: bool, machine: str | None, given: dict[str, Any]) -> None:
    """Raise InputError for an unknown machine, or options that the machine does not have."""
    if machine is not None:
        check_choice("--machine", machine, ("flexible", "rigid"))
    if given["held"] is not None:
        check_choice("--held", given["held"], ("motion", "force"))
    named = [f"--{key.replace('_', '-')}" for key, value in given.items() if value is not None]
    if reliable and (machine == "rigid" or named):
        raise InputError(Problem(named[0] if named else "--machine", WITHOUT))
    if machine == "flexible" and named:
        raise InputError([Problem(one, NO_EFFECT) for one in named])


def _machine(file: Any, machine: str | None, given: dict[str, Any]) -> Any:
    """Return the machine of the optimisation: that of the options, else that of the model file.

    Raises
    ------
    InputError
        For options of a rigid machine without one.
    """
    from jousto.design.optimisation.rigid_options import RigidMachine

    options = {key: value for key, value in given.items() if value is not None}
    of_file = None if file.optimisation is None else file.optimisation.rigid
    if machine == "flexible" or (machine is None and of_file is None):
        if options:
            names = [f"--{key.replace('_', '-')}" for key in options]
            raise InputError([Problem(one, NO_EFFECT) for one in names])
        return "flexible"
    return replace(RigidMachine() if of_file is None else of_file, **options)


def _runs(method: str, compare: bool, machine: Any) -> list[tuple[str, Any]]:
    """Return the methods and machines of the optimisations, the chosen one first."""
    chosen = [(method, machine)]
    every = [(name, "flexible") for name in METHODS] if compare else []
    return chosen + [one for one in every if one != (method, machine)]


def _least(
    file: Any,
    limits: list[Requirement],
    made: dict[str, Any],
    how: dict[str, Any],
    runs: list[tuple[str, Any]],
    output: Path | None,
    picture: Path | None,
) -> None:
    """Run one or several optimisation methods, and print and write the designs."""
    from jousto.design.optimisation.comparison import Comparison
    from jousto.design.optimisation.from_model_file import file_problem
    from jousto.design.optimisation.optimise import optimise as best_of

    found: list[Optimum] = []
    for name, machine in runs:
        way, order = METHODS[name]
        problem = file_problem(file, limits, **made)
        given = {**how, "order": order, "machine": machine}
        found.append(best_of(problem, way, **given))  # type: ignore[arg-type]
    first = found[0]
    _history(first)
    say(str(first))
    whole: Any = first
    if len(found) > 1:
        whole = Comparison(found)
        say(str(whole))
    if output is not None and output.suffix.lower() == ".html":
        from jousto.output.write import write

        say(f"page in {write(whole, output)}", style="green")
    elif output is not None:
        say(f"history in {whole.to_csv(output)}", style="green")
    tell_files(whole, picture=picture)
    if not (first.converged and first.kept):
        raise typer.Exit(FAILED)


def _reliable(
    file: Any,
    limits: list[Requirement],
    options: dict[str, Any],
    output: Path | None,
    picture: Path | None,
) -> None:
    """Run a reliability-based optimisation, and print and write the design."""
    from jousto.design.reliability.errors import DesignPointError, LimitStateError
    from jousto.design.reliability.from_model_file import file_rbdo

    try:
        found = file_rbdo(file, limits, **options)
    except (DesignPointError, LimitStateError) as error:
        say(str(error), error=True, style="red")
        raise typer.Exit(FAILED) from None
    say(str(found))
    if output is not None:
        say(f"history in {found.to_csv(output)}", style="green")
    tell_files(found, picture=picture)


def _history(found: Optimum) -> None:
    """Print a row for each optimisation cycle."""
    rows = [("cycle", *found.values, "cost", "largest ratio", "runs")]
    for i, one in enumerate(found.history):
        values = [f"{value:.5g}" for value in one.values.values()]
        rows.append((str(i), *values, f"{one.cost:.6g}", f"{one.ratio:.4f}", str(one.runs)))
    columns(rows, ">")
