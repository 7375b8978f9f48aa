"""Block ``fatigue`` of a model file: S-N curves by name, and checks."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

from pydantic import Tag

from jousto.schema.entries.base import Component, Direction, Entry, Text
from jousto.schema.entries.choices import by_form
from jousto.schema.entries.curves import CurveForm
from jousto.schema.entries.declared import FORMS, EntryOf

Sites: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")] | Annotated[tuple[Component, ...], Tag("list")], by_form()
]
FORMS.update(
    {
        "stress sites": lambda field: Sites,
        "criterion": lambda field: Text,
        "plane": lambda field: Direction,
    }
)
CheckEntry: Any = Annotated[Any, EntryOf("jousto.fatigue.miner.check", "FatigueCheck")]


class FatigueEntry(Entry):
    """S-N curves by name, and fatigue checks."""

    curves: dict[Text, CurveForm] | None = None
    checks: tuple[CheckEntry, ...] | None = None
