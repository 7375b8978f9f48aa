"""Command ``advise``: which bodies of a machine must be flexible, and which modes of a part."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, Problem, Problems
from jousto.cli.group import command
from jousto.cli.hotspots import check_targets
from jousto.cli.options import End, Output, PartName, Solver, Trust, amount
from jousto.cli.terminal import say

if TYPE_CHECKING:
    from jousto.design.flexibility.flexibility_advice import FlexibilityAdvice
    from jousto.parts.part import Part


@command()
def advise(
    file: Annotated[
        Path, typer.Argument(metavar="MODEL|PART", help="Model file, or YAML file of a part.")
    ],
    name: PartName = None,
    limit: Annotated[
        str | None,
        typer.Option(metavar="SHARE", help="Largest loss of a reading / its range; 2 %."),
    ] = None,
    life_limit: Annotated[
        str | None,
        typer.Option("--life-limit", metavar="SHARE", help="Largest loss of the damage; 10 %."),
    ] = None,
    slope: Annotated[
        float | None,
        typer.Option(metavar="M", help="Slope of the S-N curve, for bodies without a check."),
    ] = None,
    bodies: Annotated[
        list[str] | None, typer.Option("--body", metavar="BODY", help="Bodies; all if none.")
    ] = None,
    readings: Annotated[
        list[str] | None,
        typer.Option("--reading", metavar="NAME", help="Sensors, tip.x or 'stress BODY'."),
    ] = None,
    from_rigid: Annotated[
        bool, typer.Option("--from-rigid", help="Run the rigid machine alone, estimate the rest.")
    ] = False,
    no_modes: Annotated[
        bool, typer.Option("--no-modes", help="Look for no modes to be left out.")
    ] = False,
    t_end: End = None,
    output: Output = None,
    trust: Trust = False,
    frequency_limit: Annotated[
        str | None,
        typer.Option("--frequency-limit", metavar="HZ", help="Highest frequency that matters."),
    ] = None,
    load: Annotated[
        list[str] | None,
        typer.Option(
            "--load", metavar="NODES.fx", help="Unit force or moment to be met: tip.fz, node3.mx."
        ),
    ] = None,
    accuracy: Annotated[
        float | None,
        typer.Option("--accuracy", metavar="SHARE", help="Largest relative error; 0.01."),
    ] = None,
    solver: Solver = None,
) -> None:
    """Propose which bodies of a MODEL must be flexible, or which modes a PART needs.

    MODEL: every flexible body is made rigid in turn, and modes without energy are left out. The
    table shows what each sensor and the stress at each hot spot loses, and an estimate from the
    rigid run alone; -o writes it as .csv or .json.

    PART, or a MODEL with the NAME of a part or with --frequency-limit or --load: the modes for a
    frequency limit or for loads, with the gain of each. The interfaces are those of the part's
    reduce entry; without --frequency-limit and --load its frequency_limit applies.
    """
    for_part = {
        "NAME": name,
        "--frequency-limit": frequency_limit,
        "--load": load,
        "--accuracy": accuracy,
        "--solver": solver,
    }
    for_machine = {
        "--limit": limit,
        "--life-limit": life_limit,
        "--slope": slope,
        "--body": bodies,
        "--reading": readings,
        "--from-rigid": from_rigid,
        "--no-modes": no_modes,
        "--t-end": t_end,
        "--output": output,
        "--trust": trust,
    }
    given = [key for key, value in for_part.items() if value]
    _check_kind(file, given, [key for key, value in for_machine.items() if value])
    if given or not _is_machine(file):
        _advise_modes(file, name, frequency_limit, load or [], accuracy or 0.01, solver)
    else:
        _advise_bodies(file, for_machine)


def _is_machine(path: Path) -> bool:
    """Return whether a file is a model, not a part alone."""
    from jousto.robots.readers.suffixes import SUFFIXES
    from jousto.schema.file.document import read_document

    return path.suffix.lower() in SUFFIXES or "bodies" in read_document(path).data


def _check_kind(path: Path, of_part: list[str], of_machine: list[str]) -> None:
    """Raise an error for options that the other kind of advice has."""
    problems = Problems()
    if of_part and of_machine:
        problems.add(
            ", ".join(of_machine),
            f"for the bodies of a machine, cannot be combined with {', '.join(of_part)}, for the "
            "modes of a part; leave out one kind",
        )
    elif of_machine and not _is_machine(path):
        message = f"for the bodies of a machine, but {path.name} is a part"
        problems.add(", ".join(of_machine), message)
    problems.raise_if_any()


def _advise_bodies(path: Path, given: dict[str, Any]) -> None:
    """Print the advice on the bodies of a machine, and write its table."""
    from jousto.design.flexibility.advise_flexibility import advise_flexibility
    from jousto.schema.read import read_model

    output, problems = given["--output"], Problems()
    numbers: dict[str, Any] = {"slope": given["--slope"]}
    for key, unit in (("--limit", "1"), ("--life-limit", "1"), ("--t-end", "s")):
        try:
            value = amount(given[key], unit, key)
        except InputError as error:
            problems.found += error.problems
            continue
        if value is not None:
            numbers[key[2:].replace("-", "_")] = value
    try:
        check_targets({output: ("csv", "json")})
    except InputError as error:
        problems.found += error.problems
    problems.raise_if_any()
    advice = advise_flexibility(
        read_model(path, trust=given["--trust"]),
        bodies=given["--body"] or None,
        readings=given["--reading"] or None,
        from_rigid=given["--from-rigid"],
        modes=not given["--no-modes"],
        **numbers,
    )
    _tell(advice, output)


def _tell(advice: FlexibilityAdvice, output: Path | None) -> None:
    """Print an advice with its recommendations in green, and write its table."""
    recommended = set(advice.recommendations())
    for line in str(advice).splitlines():
        say(line, style="green" if line in recommended else "")
    if output is not None:
        write = advice.to_json if output.suffix.lower() == ".json" else advice.to_csv
        say(f"table in {write(output)}", style="green")


def _advise_modes(
    path: Path,
    name: str | None,
    frequency_limit: str | None,
    load: list[str],
    accuracy: float,
    solver: str | None,
) -> None:
    """Print the modes that a part needs."""
    from jousto.certificate.advice import advise as propose
    from jousto.reduction.methods import CraigBampton
    from jousto.schema.read import read_part_file

    file = read_part_file(path, name, reduce=False)
    if file.part is None:
        message = "was reduced before: advice needs the part with its mesh"
        raise InputError(Problem(f"part '{file.name}'", message))
    limit = amount(frequency_limit, "Hz", "--frequency-limit")
    interfaces = file.method.interfaces if isinstance(file.method, CraigBampton) else ()
    loads: dict[str, Any] = {}
    for text in load:
        pattern = _load(file.part, text)
        if pattern is None:
            place = text.rpartition(".")[0]
            say(f"--load {text}: '{place}' is an interface, its static loads are exact anyway")
        else:
            loads[text] = pattern
    if limit is None and not loads:
        limit = file.method.frequency_limit
    advice = propose(
        file.part,
        interfaces,
        frequency_limit=limit,
        loads=loads or None,
        accuracy=accuracy,
        solver=solver,
        progress=sys.stderr.isatty(),
    )
    text = str(advice)
    residuals = getattr(advice.method, "residuals", ())
    if residuals and all(".f" in load[-3:] for load in loads):
        # residual loads as entries of a model file, where loads at nodes are forces without moments
        entries = ", ".join(_entry(load) for load in loads)
        text = text.replace(f"residuals={residuals}", f"residuals: [{entries}]")
    for line in text.splitlines():
        say(line, style="green" if line.startswith("take ") else "")


def _entry(text: str) -> str:
    """Return the residual load `tip.fz` as an entry of a model file."""
    place, _, kind = text.rpartition(".")
    along = ", ".join("1" if kind[1] == axis else "0" for axis in "xyz")
    return f"{{force: [{along}], nodes: {place}}}"


def _load(part: Part, text: str) -> Any:
    """Return the nodal loads of a unit force or moment on a set; None for an interface."""
    import numpy as np

    from jousto.base.errors import suggest

    kinds = ("fx", "fy", "fz", "mx", "my", "mz")[: part.dofs_per_node]
    place, _, kind = text.rpartition(".")
    if kind not in kinds or not place:
        known = ", ".join(kinds)
        message = f"is {text!r}, must be a node set and one of {known}, such as tip.{kinds[0]}"
        raise InputError(Problem("--load", message))
    if any(tie.name == place for tie in part.ties):
        return None
    if place not in part.node_sets:
        message = f"no node set '{place}'{suggest(place, part.node_sets)}"
        raise InputError(Problem("--load", message))
    nodes = np.array(part.node_sets[place])
    f = np.zeros((len(part.nodes), part.dofs_per_node))
    f[nodes, kinds.index(kind)] = 1.0 / len(nodes)
    return f.ravel()
