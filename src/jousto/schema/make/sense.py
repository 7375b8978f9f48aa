"""From entries to sensors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from jousto.materials.library import material
from jousto.mechanism.sensors.body import (
    ModalSensor,
    PrincipalStressSensor,
    StressSensor,
    VonMisesSensor,
)
from jousto.mechanism.sensors.bridge import Bridge
from jousto.mechanism.sensors.damage import DamageSensor
from jousto.mechanism.sensors.gauge import Gauge
from jousto.mechanism.sensors.kinds import BODY_SENSORS
from jousto.mechanism.sensors.loads import ForceSensor, ReactionSensor
from jousto.mechanism.sensors.motion import (
    AccelerationSensor,
    AngularAccelerationSensor,
    AngularVelocitySensor,
    OrientationSensor,
    PositionSensor,
    VelocitySensor,
)
from jousto.mechanism.sensors.readings import (
    CoordinateSensor,
    EnergySensor,
    RateSensor,
    SignalSensor,
)
from jousto.mechanism.sensors.rosette import Rosette
from jousto.mechanism.sensors.section import SectionSensor
from jousto.mechanism.sensors.temperature import Temperature
from jousto.mechanism.signals.base import Constant
from jousto.schema.entries.base import Entry
from jousto.schema.entries.curves import build_curve, build_mean
from jousto.schema.file.document import Loc
from jousto.schema.make.declared import build_coordinate, build_signal

if TYPE_CHECKING:
    from jousto.schema.make.builder import Builder

SENSORS: dict[str, Any] = {
    "position": PositionSensor,
    "velocity": VelocitySensor,
    "acceleration": AccelerationSensor,
    "orientation": OrientationSensor,
    "angular-velocity": AngularVelocitySensor,
    "angular-acceleration": AngularAccelerationSensor,
    "modal": ModalSensor,
    "reaction": ReactionSensor,
    "force": ForceSensor,
    "stress": StressSensor,
    "von-mises": VonMisesSensor,
    "principal-stress": PrincipalStressSensor,
    "gauge": Gauge,
    "rosette": Rosette,
    "bridge": Bridge,
    "section": SectionSensor,
    "coordinate": CoordinateSensor,
    "rate": RateSensor,
    "energy": EnergySensor,
    "signal": SignalSensor,
    "damage": DamageSensor,
}
FLEXIBLE_ONLY = tuple(
    key for key, kind in SENSORS.items() if kind in BODY_SENSORS and kind is not SectionSensor
)
# keys that name something, the sections where it may stand, and what it is called
NAMES = {
    "body": (("bodies",), "body"),
    "beam": (("bodies",), "beam"),
    "joint": (("joints", "couplings"), "joint"),
    "force": (("forces", "frictions"), "force"),
    "sensor": (("sensors",), "sensor"),
}


def build_sensor(builder: Builder, loc: Loc, entry: Any, known: dict[str, dict[str, Any]]) -> Any:
    """Return the sensor of an entry, None if anything is wrong with it.

    Parameters
    ----------
    builder, loc, entry
        As everywhere.
    known : dict
        The objects that could be built, by section and name.
    """
    values = entry.given()
    for key in ("marker", "relative_to", "resolved_in"):
        if key in values and (isinstance(values[key], Entry) or "." in values[key]):
            values[key] = builder.marker((*loc, key), values[key], known["bodies"])
    for key, (sections, kind) in NAMES.items():
        if key in values:
            name = values[key]
            values[key] = next((known[s][name] for s in sections if name in known[s]), None)
            if values[key] is None:
                builder.unknown(
                    (*loc, key), sections, kind, name, [n for s in sections for n in known[s]]
                )
    if "sn" in values:
        values["sn"] = build_curve(builder, (*loc, "sn"), values["sn"], known.get("curves", {}))
    if "mean" in values:
        values["mean"] = build_mean(builder, (*loc, "mean"), values["mean"])
    if "sites" in values and getattr(values.get("body"), "reduced", None) is not None:
        stress = values["body"].reduced.stress
        values["sites"] = tuple(
            site if isinstance(site, str) or stress is None else stress.nearest(site)
            for site in values["sites"]
        )
    if "coordinate" in values:
        values["coordinate"] = build_coordinate(
            builder, (*loc, "coordinate"), values["coordinate"], known["bodies"], known["joints"]
        )
    if "signal" in values:
        values["signal"] = build_signal(builder, (*loc, "signal"), values["signal"], "1")
        if isinstance(values["signal"], float):
            values["signal"] = Constant(values["signal"])
    if "temperature" in values:
        values["temperature"] = _temperature(builder, (*loc, "temperature"), values["temperature"])
    if "arms" in values:
        values["arms"] = _arms(builder, (*loc, "arms"), values["arms"], known["sensors"])
    if any(value is None for value in values.values()):
        return None
    return builder.make(loc, SENSORS[entry.type], **values)


def _temperature(builder: Builder, loc: Loc, entry: Any) -> Any:
    """Return the temperature of a gauge, None if anything is wrong with it."""
    values = entry.given()
    values["signal"] = build_signal(builder, (*loc, "signal"), values["signal"], "1")
    if isinstance(values["part"], str):
        values["part"] = builder.make((*loc, "part"), material, values["part"])
    if any(value is None for value in values.values()):
        return None
    return builder.make(loc, Temperature, **values)


def _arms(
    builder: Builder, loc: Loc, names: tuple[str | None, ...], sensors: dict[str, Any]
) -> tuple[Any, ...] | None:
    """Return the gauges of a bridge, None if one is not there."""
    gauges = [name for name, sensor in sensors.items() if isinstance(sensor, Gauge)]
    missing = False
    for i, name in enumerate(names):
        if name is not None and name not in gauges:
            builder.unknown((*loc, i), ("sensors",), "gauge", name, gauges)
            missing = True
    if missing:
        return None
    return tuple(None if name is None else sensors[name] for name in names)
