"""Tables from entries: numbers in the model file, or columns of a text file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from jousto.base.errors import InputError, Problem
from jousto.base.units import UnitError, quantity
from jousto.mechanism.signals.piecewise import Table, read_columns
from jousto.schema.file.document import Loc
from jousto.schema.make.quantities import build_amount

if TYPE_CHECKING:
    from jousto.schema.make.builder import Builder


def build_table(builder: Builder, loc: Loc, entry: Any, at: str, unit: str) -> Any:
    """Return the table of an entry; None, with problems, if it is invalid.

    Parameters
    ----------
    builder, loc, entry
        Builder, path of the entry, and the entry.
    at, unit : str
        SI units of the places, such as times, and of the values.
    """
    values = entry.given()
    key = "times" if "times" in type(entry).model_fields else "at"
    rest = {k: values[k] for k in ("interpolation",) if k in values}
    inline = [k for k in (key, "values") if k in values]
    if "file" not in values:
        if stray := [k for k in ("columns", "units") if k in values]:
            builder.note((*loc, stray[0]), f"{stray[0]} are those of a file; give file: too")
            return None
        if len(inline) < 2:
            missing = next(k for k in (key, "values") if k not in values)
            builder.note(loc, f"{missing!r} is missing; or give file: NAME.csv")
            return None
        places, found = (
            build_amount(builder, (*loc, k), values[k], u) for k, u in ((key, at), ("values", unit))
        )
        if places is None or found is None:
            return None
        return builder.make(loc, Table, places, found, **rest)
    if inline:
        builder.note((*loc, inline[0]), f"give either file: or {key}: and values:, not both")
        return None
    units = values.get("units", (at, unit))
    columns = values.get("columns", (0, 1))
    pair = builder.make(
        (*loc, "file"), scaled_columns, builder.file(values["file"]), columns, units, (at, unit)
    )
    return None if pair is None else builder.make((*loc, "file"), Table, *pair, **rest)


def scaled_columns(
    path: Path, columns: tuple[Any, ...], units: tuple[str, ...], wanted: tuple[str, ...]
) -> list[list[float]]:
    """Return columns of a text file, converted from their units to the wanted units.

    Raises
    ------
    InputError
        If the file or a column cannot be read, or a unit is of another dimension.
    """
    factors = []
    for unit, target in zip(units, wanted, strict=True):
        try:
            factors.append(quantity(f"1 {unit}", target))
        except UnitError as error:
            raise InputError(Problem("", f"units: {error}")) from None
    found = read_columns(path, columns, None)
    return [[factor * x for x in xs] for factor, xs in zip(factors, found, strict=True)]
