"""Options that commands share, and what they stand for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, Problem

if TYPE_CHECKING:
    from jousto.schema.file.read import ModelFile

Model = Annotated[Path, typer.Argument(metavar="MODEL", help="Model file (YAML or JSON).")]
Result = Annotated[Path, typer.Argument(metavar="RESULT", help="Results file (HDF5).")]
Output = Annotated[Path | None, typer.Option("--output", "-o", metavar="FILE", help="Output file.")]
From = Annotated[
    str | None, typer.Option("--from", metavar="TIME", help="Leave out what is before, '0.5 s'.")
]
To = Annotated[str | None, typer.Option("--to", metavar="TIME", help="Leave out what is after.")]
Trust = Annotated[
    bool, typer.Option("--trust", help="Run Python functions that the model file names.")
]
Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]


def compile_model(file: ModelFile) -> Any:
    """Return the compiled model of a model file."""
    from jousto.model.compile import compile

    return compile(file.mechanism)


def end_time(text: str) -> float:
    """Return the end time of an option, s."""
    return amount(text, "s", "--t-end")


def instant(text: str | None, option: str) -> float | None:
    """Return the time of an option in s, None if it is not given."""
    from jousto.base.units import UnitError, quantity

    if text is None:
        return None
    try:
        return quantity(text, "s")
    except UnitError as error:
        raise InputError(Problem(option, str(error))) from None


def amount(text: str, unit: str, option: str) -> float:
    """Return the positive value of an option, a number or a text such as '12 mm', in SI."""
    from jousto.base.units import UnitError, quantity

    try:
        value = quantity(text, unit)
    except UnitError as error:
        raise InputError(Problem(option, str(error))) from None
    if value <= 0:
        raise InputError(Problem(option, f"is {value:g} {unit}, must be positive"))
    return value
