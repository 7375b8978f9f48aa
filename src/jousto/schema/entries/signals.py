"""Signals in model files, with tables from lists or text files."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

from pydantic import Field, Tag
from pydantic_core import core_schema

from jousto.base.units import describe
from jousto.mechanism.signals.piecewise import Table
from jousto.schema.entries.base import Amount, Entry, Text, fail
from jousto.schema.entries.choices import by_form
from jousto.schema.entries.declared import FORMS, SPECIAL, keys_of, one_of, said, special


class _Column:
    """Annotation of the name of a column or its number from 0."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Accept text and whole numbers."""

        def check(value: Any) -> int | str:
            if isinstance(value, bool) or not isinstance(value, int | str):
                raise fail(f"expects the name of a column or its number, got {describe(value)}")
            return value

        return core_schema.no_info_plain_validator_function(check)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe as text or a whole number."""
        return {"type": ["string", "integer"]}


Column: TypeAlias = Annotated[int | str, _Column()]


LINES = Table.fields["interpolation"]
Lines: Any = FORMS["choice"](LINES)


class Columns(Entry):
    """Keys of all tables beside their numbers: interpolation, extrapolation and file."""

    interpolation: Lines | None = Field(None, description=said(LINES))
    file: Text | None = Field(
        None,
        description="Text file with columns of numbers instead, relative to the model file",
    )
    columns: tuple[Column, Column] | None = Field(
        None,
        description="Their names in the first line, or numbers from 0; the first two if not given",
    )
    units: tuple[Text, Text] | None = Field(
        None, description="Units of the two columns in the file; SI if not given"
    )


POINTS = keys_of(Table, without=("interpolation",), optional=("times", "values"))
TableEntry: Any = special(Table, "table", base=Columns, **POINTS)


class CurveEntry(Columns):
    """`Table` of a force over a coordinate or its rate."""

    at: tuple[Amount, ...] | None = Field(None, description="Values of the coordinate or its rate")
    values: tuple[Amount, ...] | None = Field(None, description="Forces or torques")


SignalEntry: Any = one_of("signals", "jousto.mechanism.signals")
SignalOrNumber: TypeAlias = Annotated[
    Annotated[Amount, Tag("scalar")] | Annotated[SignalEntry, Tag("mapping")], by_form()
]
SPECIAL[Table] = TableEntry
FORMS["signal"] = lambda field: SignalOrNumber
FORMS["formulas"] = lambda field: dict[Text, SignalOrNumber]
FORMS["formula"] = lambda field: SignalOrNumber
FORMS["formula list"] = lambda field: tuple[SignalOrNumber, ...]
FORMS["signals"] = lambda field: tuple[SignalOrNumber, ...]
