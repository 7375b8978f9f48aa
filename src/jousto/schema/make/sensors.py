"""Values of the fields of sensors, from their entries in model files."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from jousto.materials.library import material
from jousto.mechanism.sensors.gauge import Gauge
from jousto.schema.entries.base import Entry
from jousto.schema.make.curves import build_curve, build_mean
from jousto.schema.make.declared import Place, marker


def axes(place: Place, value: Any) -> Any:
    """Return the marker of axes, or their keyword such as "world"."""
    named = isinstance(value, Entry) or "." in value
    return marker(place, value) if named else value


def sites(place: Place, value: Any) -> Any:
    """Return the labels of stress sites; a position selects the nearest site."""
    stress = getattr(getattr(place.values["body"], "reduced", None), "stress", None)
    return tuple(
        site if isinstance(site, str) or stress is None else stress.nearest(site) for site in value
    )


def arms(place: Place, names: Any) -> Any:
    """Return the gauges of a bridge; None if one does not exist."""
    sensors = place.known["sensors"]
    known = [name for name in sensors if issubclass(sensors.entry(name).declared, Gauge)]
    gauges = {name: sensors[name] for name in known if name in names and name in sensors}
    missing = [i for i, name in enumerate(names) if name is not None and name not in gauges]
    for i in missing:
        place.builder.unknown((*place.loc, i), ("sensors",), "gauge", names[i], known)
    return None if missing else tuple(name and gauges[name] for name in names)


def expansion(place: Place, value: Any) -> Any:
    """Return the coefficient of thermal expansion, 1/K, or the material of a name."""
    return place.builder.make(place.loc, material, value) if isinstance(value, str) else value


def curve(place: Place, value: Any) -> Any:
    """Return the S-N curve of an entry or of a name."""
    return build_curve(place.builder, place.loc, value, dict(place.known["curves"]))


def mean(place: Place, value: Any) -> Any:
    """Return the mean stress correction of an entry."""
    return build_mean(place.builder, place.loc, value)


def run(place: Place, name: str) -> Any:
    """Return the keyword "run", or the path of a results file."""
    return name if name in ("", "run") else str(place.builder.file(name))


FORMS: dict[str, Callable[[Place, Any], Any]] = {
    "axes": axes,
    "sites": sites,
    "arms": arms,
    "expansion": expansion,
    "sn": curve,
    "mean": mean,
    "run": run,
}
"""How a value of each form becomes an object."""
