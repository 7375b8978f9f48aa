"""The settings of a monitor from the block ``monitor`` of a model file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from jousto.mechanism.sensors.gauge import Gauge
from jousto.schema.make.declared import build_declared

if TYPE_CHECKING:
    from jousto.schema.make.builder import Builder


def build_monitor(builder: Builder, entry: Any, mechanism: Any) -> Any:
    """Return the MonitorSettings of a model; None, with problems, if they are invalid."""
    gauges = {s.name: s for s in mechanism.sensors if isinstance(s, Gauge)}
    if entry.gauges is None:
        entry = entry.model_copy(update={"gauges": tuple(gauges)})
    errors = {} if entry.errors is None else entry.errors.given()
    known = {"gauges": gauges, "curves": builder.curves}
    return build_declared(builder, ("monitor",), entry, known, more=errors)
