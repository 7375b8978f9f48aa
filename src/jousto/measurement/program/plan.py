"""Plan: constants of a monitor in C, and the names of its inputs and outputs."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.version import __version__
from jousto.export.constants import array, number, text
from jousto.export.ports import identifier
from jousto.measurement.monitor.life import PAUSE
from jousto.measurement.monitor.monitor import Monitor
from jousto.measurement.twin.bands.bands import BENT, sample_points
from jousto.measurement.twin.kalman import STEADY
from jousto.measurement.twin.observer import JITTER, Observer
from jousto.measurement.twin.reconstruction import Reconstruction
from jousto.model.native.header import kinds
from jousto.model.native.library import ffi
from jousto.recovery.fields.kernels import NAMES

MOTION = tuple(
    (f"{what}.{axis}", unit, about)
    for what, unit, about in (
        ("acceleration", "m/s2", "of the origin of the frame less gravity, body axes"),
        ("w", "rad/s", "angular velocity of the frame, body axes"),
        ("dw", "rad/s2", "angular acceleration of the frame, body axes"),
    )
    for axis in "xyz"
)
"""Inputs of a twin with a moving frame, after the gauges: name, unit, description."""


@dataclass(frozen=True)
class Channel:
    """Input or output: name, C identifier, unit, one-line description."""

    name: str
    symbol: str
    unit: str
    about: str


@dataclass(frozen=True, eq=False)
class Plan:
    """Constants of a monitor in C.

    Attributes
    ----------
    name : str
        C identifier with which all names begin.
    monitor : Monitor
    source : str
        Text of the C file with the data, one ``const jo_plan NAME_plan``.
    bytes : int
        Upper bound of the memory of one twin, bytes.
    inputs, outputs : tuple of Channel
        Gauges, then the motion of a frame that moves; for each hot spot stress, ends of its band
        and damage with its band, then the watched time and the unknown loads.
    """

    name: str
    monitor: Monitor
    source: str
    bytes: int
    inputs: tuple[Channel, ...]
    outputs: tuple[Channel, ...]

    @property
    def header(self) -> str:
        """C header: inputs and outputs with their units, and the size of the state."""
        upper = self.name.upper()
        pieces = [
            f"/* {self.name}.h - names of what goes into a twin and comes out of it.",
            " * Numbers are in SI units. See gauged_twin.h for the functions. */",
            f"#ifndef {upper}_H\n#define {upper}_H\n",
            '#include "gauged_twin.h"\n',
            f"extern const jo_plan {self.name}_plan;\n",
            f"#define {upper}_BYTES {self.bytes}   /* of memory for one twin, at most */",
            f"#define {upper}_INPUTS {len(self.inputs)}",
            f"#define {upper}_OUTPUTS {len(self.outputs)}\n",
        ]
        for word, found in (("input", self.inputs), ("output", self.outputs)):
            lines = [
                f"    {self.name}_{word}_{x.symbol} = {k},   "
                f"/* {_comment(f'{x.name} ({x.unit}): {x.about}')} */"
                for k, x in enumerate(found)
            ]
            lines.append(f"    {self.name}_{word}s = {len(found)}")
            pieces.append("enum {\n" + "\n".join(lines) + "\n};\n")
        pieces.append("#endif\n")
        return "\n".join(pieces)


def plan_of(monitor: Monitor, name: str) -> Plan:
    """Return the constants of a monitor in C.

    Parameters
    ----------
    monitor : Monitor
        Monitor whose twin, hot spots, band, S-N curve and channel rules are included, not its
        alarms.
    name : str
        C identifier with which all names begin.
    """
    values, arrays, sizes = _parts(monitor)
    inputs, outputs = _channels(_inputs(monitor)), _channels(_outputs(monitor))
    mark = zlib.crc32(repr(sorted((k, str(v)) for k, v in values.items())).encode())
    pieces = [
        f"/* {name}: the constants of a twin, written by jousto {__version__}. */",
        '#include "gauged_twin.h"',
        "#include <math.h>\n",
    ]
    for key, (x, kind) in arrays.items():
        mark = zlib.crc32(np.ascontiguousarray(x).tobytes(), mark)
        if x.size:
            pieces.append(array(f"data_{key}", x, kind=kind))
            values[key] = f"data_{key}"
    for key, found in (("input", inputs), ("output", outputs)):
        mark = zlib.crc32("\n".join(f"{x.name} {x.unit}" for x in found).encode(), mark)
        rows = ",\n".join(f"    {{{text(x.name)}, {text(x.unit)}, {text(x.about)}}}" for x in found)
        pieces.append(f"static const jo_channel {key}s[{len(found)}] = {{\n{rows}\n}};\n")
        values |= {f"n{key}": len(found), key: f"{key}s"}
    values |= {"name": text(name), "mark": f"{mark}u"}
    body = ",\n".join(f"    .{key} = {_value(x)}" for key, x in values.items())
    pieces.append(f"const jo_plan {name}_plan = {{\n{body}\n}};\n")
    size = _bytes(sizes, len(outputs))
    return Plan(name, monitor, "\n".join(pieces), size, inputs, outputs)


def _twin(monitor: Monitor) -> Reconstruction | Observer:
    found: Any = monitor.estimator
    twin: Reconstruction | Observer = found.twin
    return twin


def _moving(monitor: Monitor) -> bool:
    twin = _twin(monitor)
    return isinstance(twin, Observer) and twin.reference is not None


def _inputs(monitor: Monitor) -> Iterator[tuple[str, str, str]]:
    for gauge in monitor.channels:
        yield gauge, "m/m", "strain, NaN where nothing was measured"
    if _moving(monitor):
        yield from MOTION


def _outputs(monitor: Monitor) -> Iterator[tuple[str, str, str]]:
    share = f"{100 * monitor.level:g} % band"
    for spot in monitor.spots:
        yield f"{spot}.stress", "Pa", str(monitor.criterion)
        yield f"{spot}.low", "Pa", f"lower end of the {share}"
        yield f"{spot}.high", "Pa", f"upper end of the {share}"
        if monitor.meter is not None:
            yield f"{spot}.damage", "1", f"sum of Miner, residue {monitor.residue}"
            yield f"{spot}.damage low", "1", "lower end of its band"
            yield f"{spot}.damage high", "1", "upper end of its band"
    if monitor.meter is not None:
        yield "watched", "s", "time that damage was counted in"
    twin = _twin(monitor)
    if isinstance(twin, Observer):
        for label in twin.system.labels:
            yield label, "N m" if label.split(".")[-1].startswith("m") else "N", "unknown load"


def _channels(rows: Iterator[tuple[str, str, str]]) -> tuple[Channel, ...]:
    used: set[str] = set()
    made = []
    for name, unit, about in rows:
        symbol = base = identifier(name)
        k = 2
        while symbol in used:
            symbol, k = f"{base}_{k}", k + 1
        used.add(symbol)
        made.append(Channel(name, symbol, unit, about))
    return tuple(made)


Arrays = dict[str, tuple[NDArray[Any], str]]


def _parts(monitor: Monitor) -> tuple[dict[str, Any], Arrays, dict[str, int]]:
    """Return scalar fields of jo_plan, its arrays with their types, and its sizes."""
    twin = _twin(monitor)
    if isinstance(twin, Observer):
        values, given = _observer(twin)
    else:
        values, given = _alone(twin)
    errors = twin.errors
    sizes = {"ngauge": len(monitor.channels), "nspot": len(monitor.spots)}
    sizes["kinds"] = 0 if errors is None else len(errors)
    each = sizes["kinds"] if isinstance(twin, Observer) else min(sizes["kinds"], 1)
    sizes["nerror"] = each * sizes["ngauge"]
    if errors is not None:
        given["errors"] = np.asarray(errors)
    stress, more = _stress(monitor, sizes["nerror"])
    values |= stress | sizes
    given |= more
    arrays: Arrays = {key: (x, "double") for key, x in given.items()}
    if isinstance(twin, Observer):
        arrays["dynamic"] = (np.flatnonzero(twin.system.dynamic), "int")
    values |= _meters(monitor) | _rules(monitor)
    known = {key: x for key, x in values.items() if isinstance(x, int)}
    meters = () if monitor.meter is None else monitor.meter.meters.values()
    return values, arrays, known | {"depth": max((m.rule.depth for m in meters), default=0)}


def _observer(twin: Observer) -> tuple[dict[str, Any], dict[str, Array]]:
    system, channels, I = twin.system, twin.channels, twin.reduced.invariants
    F, Gu, Q = system.discrete(twin.dt)
    balanced = twin.balance is not None
    values: dict[str, Any] = {
        "method": "JO_TWIN_OBSERVER",
        "moving": int(twin.reference is not None),
        "balanced": int(balanced),
        "nchannel": len(channels.names),
        "n": twin.reduced.n,
        "nx": system.nx,
        "nd": system.nd,
        "na": system.na,
        "load_at": system.places.start,
        "step": twin.dt,
        "jitter": JITTER,
        "gate": float(twin.gate or 0.0),
        "steady": STEADY,
        "mass": float(I.mass),
        "first_moment": np.asarray(I.first_moment),
        "inertia": np.asarray(twin.inertia).reshape(-1),
    }
    stiffness = np.asarray(twin.reduced.stiffness)
    still = ~system.dynamic
    arrays = {
        "F": F,
        "Gu": Gu,
        "Q": Q,
        "P0": system.start(),
        "H": channels.H,
        "R": channels.R,
        "shape": system.shape,
        "rates": system.rates,
        "B": twin.B,
        "rest": np.where(still, 1.0 / np.where(still, stiffness, 1.0), 0.0),
        "stiffness": stiffness,
        "mean": system.mean,
        "mean_force": system.columns @ system.mean,
    }
    if twin.reference is not None:
        arrays |= {"I3": I.I3, "N0": I.N0, "E": I.E}
    if balanced:
        arrays |= {"arms": twin.arms, "wrenches": system.wrenches}
    return values, arrays


def _alone(twin: Reconstruction) -> tuple[dict[str, Any], dict[str, Array]]:
    values: dict[str, Any] = {
        "method": "JO_TWIN_ALONE" if twin.prior is None else "JO_TWIN_PRIOR",
        "nchannel": len(twin.B),
        "n": twin.n,
        "nx": twin.n,
    }
    arrays = {"H": twin.B, "B": twin.B, "R": np.asarray(twin.noise)}
    if twin.prior is not None:
        arrays["P0"] = np.asarray(twin.prior)
    return values, arrays


def _stress(monitor: Monitor, nerror: int) -> tuple[dict[str, Any], dict[str, Array]]:
    band = monitor.band
    values: dict[str, Any] = {
        "linear": int(band.linear),
        "quantile": band.quantile,
        "level": band.level,
        "scale": band.scale,
        "bent": BENT,
        "floor": float(band.criterion in ("von-mises", "max-shear")),
        "criterion_scale": 1.0,
    }
    if band.linear:
        rows, variances = band.rows
        return values, {"S": rows, "missed": variances}
    mises = band.criterion == "von-mises"
    values["mises"] = int(mises)
    values["criterion"] = "JO_NORM" if mises else f"JO_{NAMES[str(band.criterion)]}"
    values["criterion_scale"] = 0.5 if band.criterion == "max-shear" else 1.0
    points = sample_points(6 + nerror + int(band.scale > 0.0))
    values["npoint"] = len(points)
    _, variances = band.rows
    return values, {"S": band.S, "missed": variances, "points": points}


def _meters(monitor: Monitor) -> dict[str, Any]:
    """Return the fields of the three damage meters: estimate, low and high."""
    life = monitor.meter
    if life is None:
        return {}
    rows = [_struct("jo_meter", life.meters[x].native) for x in ("value", "low", "high")]
    return {
        "metered": 1,
        "residue": int(kinds("jo_residue")[life.residue]),
        "meter": "{" + ", ".join(rows) + "}",
        "every": monitor.every,
        "pause": PAUSE,
    }


def _rules(monitor: Monitor) -> dict[str, Any]:
    return {"health": _struct("jo_health", monitor.health.native)}


def _struct(kind: str, given: Any) -> str:
    fields = []
    for key, about in ffi().typeof(kind).fields:
        value = getattr(given, key)
        assert about.type.kind == "primitive"
        fields.append(f".{key} = {number(value) if isinstance(value, float) else int(value)}")
    return "{" + ", ".join(fields) + "}"


def _value(x: Any) -> str:
    if isinstance(x, str):
        return x
    if isinstance(x, np.ndarray):
        return "{" + ", ".join(number(float(v)) for v in x.ravel()) + "}"
    return number(x) if isinstance(x, float) else str(int(x))


def _comment(about: str) -> str:
    return about.replace("*/", "* /")


def _bytes(size: dict[str, int], outputs: int) -> int:
    """Return the memory of a twin in bytes, an upper bound of lay_out in gauged_twin.c."""
    n, nx, nc, ng, ns = (size[key] for key in ("n", "nx", "nchannel", "ngauge", "nspot"))
    ne, nd = size["nerror"], size.get("nd", 0)
    side, roots = max(nx, nc), 7 + ne
    depth = size["depth"]
    meters = 3 * ns * (13 + depth) if depth else 0
    remembered = 16 + nc + 9 * ng + nx * (1 + nc + nx + ne) + n + nc + 2 * ns + meters
    gains = nx * nc + 5 * nc + 2 * nx * nx + side * (2 * side + nx) + nc * nx + nc * nc
    laps = nx * (4 * nx + 2 * nd)
    modes = nx + 3 * n + n * n + n * ne + 2 * side * ne + 15 + 2 * depth + outputs
    bands = 43 * ns + 7 * max(1 + 2 * roots, size.get("npoint", 0)) + 6 * roots + ng
    doubles = remembered + gains + laps + modes + bands
    return int(-(-(8 * doubles + 2048) // 64) * 64)
