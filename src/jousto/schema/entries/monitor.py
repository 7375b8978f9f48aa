"""The block ``monitor`` of a model file: what ``jousto monitor`` watches."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from pydantic import Field, Tag

from jousto.mechanism.sensors.gauge import Gauge
from jousto.schema.entries.base import Count, Text
from jousto.schema.entries.choices import by_form
from jousto.schema.entries.declared import FORMS, EntryOf
from jousto.schema.make.declared import build_declared

if TYPE_CHECKING:
    from jousto.schema.make.context import Builder

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


def build_monitor(builder: Builder, entry: Any, mechanism: Any) -> Any:
    """Return the MonitorSettings of a model, None if anything is wrong."""
    gauges = {s.name: s for s in mechanism.sensors if isinstance(s, Gauge)}
    if entry.gauges is None:
        entry = entry.model_copy(update={"gauges": tuple(gauges)})
    errors = {} if entry.errors is None else entry.errors.given()
    known = {"gauges": gauges, "curves": builder.curves}
    return build_declared(builder, ("monitor",), entry, known, more=errors)
