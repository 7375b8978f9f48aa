"""Options shared by several commands, and the conversion of their values."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, Problem
from jousto.cli.terminal import say

if TYPE_CHECKING:
    from jousto.schema.read import ModelFile

Model = Annotated[Path, typer.Argument(metavar="MODEL", help="Model file (YAML or JSON).")]
Result = Annotated[Path, typer.Argument(metavar="RESULT", help="Results file (HDF5).")]
Output = Annotated[Path | None, typer.Option("--output", "-o", metavar="FILE", help="Output file.")]
From = Annotated[
    str | None, typer.Option("--from", metavar="TIME", help="Start of the time span, '0.5 s'.")
]
To = Annotated[str | None, typer.Option("--to", metavar="TIME", help="End of the time span.")]
Trust = Annotated[
    bool,
    typer.Option("--trust", help="Run Python functions and mock-up units that the file names."),
]
Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]
Table = Annotated[Path | None, typer.Option("--csv", metavar="FILE.csv", help="Write every place.")]
Vtu = Annotated[
    Path | None, typer.Option("--vtu", metavar="FILE.vtu", help="Write them for ParaView.")
]
Quantity = Annotated[
    str,
    typer.Option(
        "--criterion",
        metavar="NAME",
        help="von-mises, signed-von-mises, principal-1 .. 3, signed-principal, max-shear, "
        "s11 .. s13, or normal:x,y,z of a plane; with --strain of strain.",
    ),
]
Strain = Annotated[bool, typer.Option("--strain", help="Strain instead of stress.")]
Residue = Annotated[
    str | None,
    typer.Option("--residue", metavar="half|repeat|ignore", help="Cycles that stay open."),
]
PartPath = Annotated[
    Path, typer.Argument(metavar="PART", help="YAML file of a part, or a model file.")
]
PartName = Annotated[
    str | None, typer.Argument(metavar="[NAME]", help="Name of a part of the model.")
]
Solver = Annotated[
    str | None, typer.Option("--solver", metavar="NAME", help="Library for the factorisation.")
]
Initial = Annotated[
    bool, typer.Option("--initial", help="About the initial pose, not the equilibrium.")
]
Workers = Annotated[int, typer.Option("--workers", min=1, help="How many at once.")]
On = Annotated[str, typer.Option("--on", metavar="threads|processes|dask", help="What works.")]
Core = Annotated[
    str | None,
    typer.Option(
        "--core",
        metavar="auto|joint|maximal",
        help="Run in joint coordinates or in the positions of all bodies, else in the faster.",
    ),
]
Limits = Annotated[
    list[str] | None,
    typer.Option(
        "--limit",
        metavar="LIMIT",
        help="An outcome and its bound, 'max(tip.y) <= 12 mm'; without it the limits of the model.",
    ),
]
Vary = Annotated[
    list[str] | None,
    typer.Option(
        "--vary",
        metavar="NAME=VALUES",
        help="wall=2..8mm (bounds), load=lognormal(mean=1 kN, sd=100 N); instead of the model's.",
    ),
]
End = Annotated[
    str | None, typer.Option("--t-end", metavar="TIME", help="End of the runs, '500 ms'.")
]
Drawing = Annotated[
    Path | None, typer.Option("--picture", metavar="FILE.png", help="Draw the result.")
]


def compile_model(mechanism: Any, core: str | None = None) -> Any:
    """Return the compiled model of a mechanism for the requested core."""
    from jousto.model.compile import compile

    return compile(mechanism, core=core)


def compiled_model(path: Path, trust: bool) -> Any:
    """Return the compiled model of a model file."""
    from jousto.schema.read import read_model

    return compile_model(read_model(path, trust=trust).mechanism)


def instant(text: str | None, option: str) -> float | None:
    """Return the time of an option in s; None if the option is absent."""
    return None if text is None else value_of(text, "s", option)


def amount(text: str | None, unit: str, option: str) -> Any:
    """Return the positive value of an option such as '12 mm' in SI; None if it is absent."""
    if text is None:
        return None
    value = value_of(text, unit, option)
    if value <= 0:
        raise InputError(Problem(option, f"is {value:g} {unit}, must be positive"))
    return value


def value_of(text: str, unit: str, option: str) -> float:
    """Return the value of an option, a number or a text such as '12 mm', in SI."""
    from jousto.base.units import UnitError, quantity

    try:
        return quantity(text, unit)
    except UnitError as error:
        raise InputError(Problem(option, str(error))) from None


def end_time(file: ModelFile, source: Path, wanted: str = "how long to simulate") -> float:
    """Return the end time of the run in a model file, s."""
    if file.simulation is None:
        message = f"does not say {wanted}; add simulation: {{t_end: 10 s}}, or give --t-end"
        raise InputError(Problem(source.name, message))
    end: float = file.simulation.t_end
    return end


def only_one(names: Iterable[str], where: str, kind: str, none: str) -> str:
    """Return the only name of a list; raise an error if there are none or several."""
    some = list(names)
    if len(some) != 1:
        found = f"name one of the {kind} {', '.join(some)}" if some else none
        raise InputError(Problem(where, found))
    return some[0]


def tell_files(
    found: Any,
    *more: Any,
    csv: Path | None = None,
    picture: Path | None = None,
    vtu: Path | None = None,
    **how: Any,
) -> None:
    """Write a result as CSV table, picture and VTU file where requested, and print the paths."""
    if csv is not None:
        say(f"table in {found.to_csv(csv)}", style="green")
    if picture is not None:
        from jousto.output.plot import plot

        plot(found, *more, path=picture, **how)
        say(f"picture in {picture}", style="green")
    if vtu is not None:
        from jousto.output.write import write

        say(f"for ParaView in {write(found, vtu, *more)}", style="green")
