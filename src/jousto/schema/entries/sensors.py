"""Types of sensors in model files."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, Discriminator, Tag

from jousto.schema.entries.base import Count, Length, Marker, Number, Position, Text
from jousto.schema.entries.choices import by_form
from jousto.schema.entries.curves import MeanEntry, SNOrName
from jousto.schema.entries.declared import FORMS, one_of


def _axes(value: Any) -> str:
    if isinstance(value, dict | BaseModel):
        return "mapping"
    return "marker" if isinstance(value, str) and "." in value else "word"


def _at(value: Any) -> str:
    return "word" if value in ("start", "middle", "end") else "length"


def _expansion(value: Any) -> str:
    """Return "number" for a thermal expansion as a number or quoted number, "text" for a name."""
    try:
        float(value)
    except (TypeError, ValueError):
        return "text" if isinstance(value, str) else "number"
    return "number"


Axes: TypeAlias = Annotated[
    Annotated[Literal["world", "joint"], Tag("word")]
    | Annotated[Marker, Tag("marker")]
    | Annotated[Marker, Tag("mapping")],
    Discriminator(_axes),
]
Spot: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")] | Annotated[Position, Tag("list")], by_form()
]
Along: TypeAlias = Annotated[
    Annotated[Literal["start", "middle", "end"], Tag("word")] | Annotated[Length, Tag("length")],
    Discriminator(_at),
]
Expansion: TypeAlias = Annotated[
    Annotated[Number, Tag("number")] | Annotated[Text, Tag("text")], Discriminator(_expansion)
]
Index: TypeAlias = Annotated[
    Annotated[Count, Tag("number")] | Annotated[Text, Tag("text")], Discriminator(_expansion)
]
Words: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")] | Annotated[tuple[Text, ...], Tag("list")], by_form()
]
FORMS.update(
    {
        "axes": lambda field: Axes,
        "spot": lambda field: Spot,
        "sites": lambda field: tuple[Spot, ...],
        "along": lambda field: Along,
        "element": lambda field: Index,
        "arms": lambda field: tuple[Text | None, ...],
        "expansion": lambda field: Expansion,
        "words": lambda field: Words,
        "sn": lambda field: SNOrName,
        "mean": lambda field: MeanEntry,
    }
)
SensorEntry: Any = one_of("sensors", "jousto.mechanism.sensors")
