"""Block ``monitor`` of a model file: settings of ``jousto monitor``."""

from __future__ import annotations

from typing import Annotated, Any, TypeAlias

from pydantic import Field, Tag

from jousto.schema.entries.base import Count, Text
from jousto.schema.entries.choices import by_form
from jousto.schema.entries.declared import FORMS, EntryOf

Spots: TypeAlias = Annotated[
    Annotated[Count, Tag("scalar")] | Annotated[tuple[Text, ...], Tag("list")], by_form()
]
FORMS.update(
    {
        "spots": lambda field: Spots,
        "run": lambda field: Text,
        "columns": lambda field: dict[Text, Text],
    }
)
ErrorsEntry: Any = Annotated[Any, EntryOf("jousto.measurement.twin.signals", "GaugeErrors")]
MonitorEntry: Any = Annotated[
    Any,
    EntryOf(
        "jousto.measurement.monitor.setup",
        "MonitorSettings",
        without=("scale", "factor", "position", "angle"),
        gauges=(
            tuple[Text, ...] | None,
            Field(None, description="Sensors of type gauge on one body; all if not given"),
        ),
        errors=(
            ErrorsEntry | None,
            Field(None, description="Standard deviations of errors that no record shows"),
        ),
    ),
]
