"""The block ``monitor`` of a model file: what ``jousto monitor`` watches."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from pydantic import Field, Tag

from jousto.schema.entries.base import Angle, Count, Duration, Entry, Length, Number, Text
from jousto.schema.entries.choices import by_form
from jousto.schema.entries.curves import MeanEntry, SNOrName, build_curve, build_mean
from jousto.schema.entries.declared import EntryOf

if TYPE_CHECKING:
    from jousto.schema.make.context import Builder


WATCH = "jousto.measurement.monitor"
LimitsEntry: TypeAlias = Annotated[Any, EntryOf(f"{WATCH}.alarms", "AlarmLimits")]
RulesEntry: TypeAlias = Annotated[Any, EntryOf(f"{WATCH}.health", "ChannelRules")]


class GaugeErrorsEntry(Entry):
    """Errors that stay through a record: `stress_band` (scale) and `gauge_errors`."""

    scale: Number | None = Field(None, description="Of all stress, relative: modulus, gauge factor")
    factor: Number | None = Field(None, description="Of each gauge's factor, relative")
    position: Length | None = Field(None, description="Of each gauge's place")
    angle: Angle | None = Field(None, description="Of each gauge's direction")


SpotsForm: TypeAlias = Annotated[
    Annotated[Count, Tag("scalar")] | Annotated[tuple[Text, ...], Tag("list")], by_form()
]


class MonitorEntry(Entry):
    """`MonitorSettings`: strains in; stress, damage, remaining life and alarms out."""

    gauges: tuple[Text, ...] | None = Field(
        None, description="Sensors of type gauge on one body; all if not given"
    )
    spots: SpotsForm = Field(
        description="Stress sites such as e1.a.top, or how many hot spots of the reference run"
    )
    separation: Length | None = Field(None, description="Least distance of hot spots found")
    criterion: Text | None = Field(None, description="Of the stress, signed-von-mises if none")
    noise: Number | None = Field(
        None, description="Standard deviation of the gauges, 1e-6 or '1 um/m'"
    )
    reference: Text | None = Field(
        None, description="run to simulate the model first, or a results file of it"
    )
    sn: SNOrName | None = Field(
        None, description="A curve: a name of curves or of the library, or its keys"
    )
    mean: MeanEntry | None = None
    residue: Literal["half", "repeat", "ignore"] | None = None
    limits: LimitsEntry | None = Field(None, description="What raises an alarm")
    channels: RulesEntry | None = Field(None, description="When a channel is not believed")
    errors: GaugeErrorsEntry | None = Field(
        None, description="Standard deviations of errors that no record shows"
    )
    columns: dict[Text, Text] | None = Field(None, description="Column of the data for each gauge")
    unit: Text | None = Field(None, description="Of columns that name none, such as um/m")
    level: Number | None = Field(None, description="Share of the bands, 0.95")
    every: Duration | None = Field(None, description="Time between summaries, 1 s")


def build_monitor(builder: Builder, entry: MonitorEntry, mechanism: Any) -> Any:
    """Return the MonitorSettings of a model, None if anything is wrong."""
    from jousto.base.errors import suggest
    from jousto.measurement.monitor.setup import MonitorSettings
    from jousto.mechanism.sensors.gauge import Gauge
    from jousto.schema.make.declared import build_declared

    here = ("monitor",)
    before = len(builder.found)
    values = entry.given("gauges", "sn", "mean", "limits", "channels", "errors")
    known = {s.name: s for s in mechanism.sensors if isinstance(s, Gauge)}
    gauges = []
    for i, name in enumerate(entry.gauges if entry.gauges is not None else known):
        if name in known:
            gauges.append(known[name])
        else:
            builder.note((*here, "gauges", i), f"no gauge {name!r}{suggest(name, known)}")
    if entry.sn is not None:
        values["sn"] = build_curve(builder, (*here, "sn"), entry.sn, builder.curves)
    if entry.mean is not None:
        values["mean"] = build_mean(builder, (*here, "mean"), entry.mean)
    if entry.limits is not None:
        values["limits"] = build_declared(builder, (*here, "limits"), entry.limits, {})
    if entry.channels is not None:
        values["rules"] = build_declared(builder, (*here, "channels"), entry.channels, {})
    if entry.errors is not None:
        values |= entry.errors.given()
    reference = values.get("reference", "")
    if reference and reference != "run":
        values["reference"] = str(builder.file(reference))
    if len(builder.found) > before:
        return None
    return builder.make(here, MonitorSettings, gauges=tuple(gauges), **values)
