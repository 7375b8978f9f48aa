"""Entries of signals; their values have the unit of what the signal is used for."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, Tag
from pydantic_core import core_schema

from jousto.base.units import UnitError, describe, quantity
from jousto.schema.entries.base import Angle, Entry, Frequency, Text, Time, fail
from jousto.schema.entries.choices import by_form, tagged


class _Amount:
    """Annotation of a number, or a string whose unit is checked where its use is known."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Keep strings as they are."""

        def check(value: Any) -> float | str:
            if isinstance(value, str):
                return value
            try:
                return quantity(value, "1")
            except UnitError as error:
                raise fail(str(error)) from None

        return core_schema.no_info_plain_validator_function(check)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe as a number or a string."""
        return {
            "type": ["number", "string"],
            "description": "A number in SI, or a string with a unit of what the value is used for",
        }


Amount: TypeAlias = Annotated[float | str, _Amount()]


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
LINES = "Straight lines if not given"
FILE = "Text file with columns of numbers instead, relative to the model file"
COLUMNS = "Their names in the first line, or numbers from 0; the first two if not given"
UNITS = "Units of the two columns in the file; SI if not given"


class ConstantEntry(Entry):
    """`Constant`: one value at all times, the same as the value alone."""

    type: Literal["constant"]
    value: Amount


class ConstantSpeedEntry(Entry):
    """`ConstantSpeed`: offset + speed t, from the start."""

    type: Literal["constant-speed"]
    speed: Amount = Field(description="Per second: rad/s or rpm of an angle, m/s of a length")
    offset: Amount | None = None


class HarmonicEntry(Entry):
    """`Harmonic`: offset + amplitude sin(2 pi frequency t + phase)."""

    type: Literal["harmonic"]
    frequency: Frequency
    amplitude: Amount | None = None
    phase: Angle | None = None
    offset: Amount | None = None


class TableEntry(Entry):
    """`Table`: interpolation between points, held constant outside."""

    type: Literal["table"]
    times: tuple[Time, ...] | None = None
    values: tuple[Amount, ...] | None = None
    interpolation: Literal["linear", "cubic"] | None = Field(None, description=LINES)
    file: Text | None = Field(None, description=FILE)
    columns: tuple[Column, Column] | None = Field(None, description=COLUMNS)
    units: tuple[Text, Text] | None = Field(None, description=UNITS)


class CurveEntry(Entry):
    """`Table` of a force over a coordinate or its rate."""

    at: tuple[Amount, ...] | None = Field(None, description="Values of the coordinate or its rate")
    values: tuple[Amount, ...] | None = Field(None, description="Forces or torques")
    interpolation: Literal["linear", "cubic"] | None = Field(None, description=LINES)
    file: Text | None = Field(None, description=FILE)
    columns: tuple[Column, Column] | None = Field(None, description=COLUMNS)
    units: tuple[Text, Text] | None = Field(None, description=UNITS)


class StepEntry(Entry):
    """`Step`: a jump from before to after."""

    type: Literal["step"]
    time: Time
    before: Amount | None = None
    after: Amount | None = None


class RampEntry(Entry):
    """`Ramp`: a straight line from before to after, constant outside."""

    type: Literal["ramp"]
    start: Time
    end: Time
    before: Amount | None = None
    after: Amount | None = None


class SCurveEntry(Entry):
    """`SCurve`: smooth moves between points, at rest at each of them."""

    type: Literal["s-curve"]
    times: tuple[Time, ...]
    values: tuple[Amount, ...]


class InputEntry(Entry):
    """`Input`: a value that is set from outside while the model runs."""

    type: Literal["input"]
    name: Text
    initial: Amount | None = None


class SumEntry(Entry):
    """`Sum` of signals and numbers."""

    type: Literal["sum"]
    terms: tuple[SignalOrNumber, ...]


class ProductEntry(Entry):
    """`Product` of signals and numbers."""

    type: Literal["product"]
    factors: tuple[SignalOrNumber, ...] = Field(
        description="The first may have a unit, the others are plain numbers"
    )


class SwitchedEntry(Entry):
    """`Switched`: one signal until an event, another from then on."""

    type: Literal["switched"]
    event: Text = Field(description="Name of an entry of events")
    before: SignalOrNumber
    after: SignalOrNumber


SignalEntry: TypeAlias = Annotated[
    Annotated[ConstantEntry, Tag("constant")]
    | Annotated[ConstantSpeedEntry, Tag("constant-speed")]
    | Annotated[HarmonicEntry, Tag("harmonic")]
    | Annotated[TableEntry, Tag("table")]
    | Annotated[StepEntry, Tag("step")]
    | Annotated[RampEntry, Tag("ramp")]
    | Annotated[SCurveEntry, Tag("s-curve")]
    | Annotated[InputEntry, Tag("input")]
    | Annotated[SwitchedEntry, Tag("switched")]
    | Annotated[SumEntry, Tag("sum")]
    | Annotated[ProductEntry, Tag("product")],
    tagged(),
]
SignalOrNumber: TypeAlias = Annotated[
    Annotated[Amount, Tag("scalar")] | Annotated[SignalEntry, Tag("mapping")], by_form()
]
