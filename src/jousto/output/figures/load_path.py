"""Equilibrium paths as pictures and tables."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from jousto.base.arguments import explained_as
from jousto.base.errors import InputError, Problem, suggest
from jousto.base.files import write_table
from jousto.output.style import COLORS, INK, MUTED, Picture, drawing, target
from jousto.simulation.statics.load_path_result import LoadPath

SIZE = (7.6, 4.6)  # width and height, inch
AXES = "xyz"
CLOSE = 0.06  # distance of critical points, relative to the picture, below which they share a label


def sensor_place(counts: Mapping[str, int], sensor: str) -> tuple[str, int]:
    """Return sensor and component index of ``sensor``, ``sensor.y`` or ``sensor.1``.

    Raises
    ------
    InputError
        If there is no such sensor or value.
    """
    name, _, part = sensor.partition(".")
    if sensor in counts:
        name, part = sensor, ""
    if name not in counts:
        have = ", ".join(counts) or "none"
        hint = suggest(name, list(counts)) or f"; there are: {have}"
        raise InputError(Problem("load path", f"no sensor {name!r}{hint}"))
    k = AXES.find(part) if part and part in AXES else int(part) if part.isdigit() else -1
    if not part and counts[name] == 1:
        k = 0
    if not 0 <= k < counts[name]:
        one = "1 value" if counts[name] == 1 else f"{counts[name]} values"
        message = f"sensor {name!r} has {one}; say which, as '{name}.y' or '{name}.0'"
        raise InputError(Problem("load path", message))
    return name, k


def _column(data: LoadPath, sensor: str) -> tuple[NDArray[np.float64], str]:
    """Return the values of ``sensor``, ``sensor.y`` or ``sensor.1`` with an axis label."""
    counts = {n: v.shape[1] if v.ndim == 2 else 1 for n, v in data.sensors.items()}
    name, k = sensor_place(counts, sensor)
    values, unit = data.sensors[name], data.units.get(name, "")
    values = values[:, k] if values.ndim == 2 else values
    return np.asarray(values), f"{sensor} ({unit})" if unit else sensor


@drawing
def plot_load_path(data: LoadPath, sensor: str) -> Picture:
    """Draw load over a sensor value, unstable parts dashed, critical points marked.

    Parameters
    ----------
    data : LoadPath
        Result of `load_path`.
    sensor : str
        Name, with the component if it has several: "tip.y" or "tip.1".
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown sensor or suffix or an unwritable path.
    """
    values, label = _column(data, sensor)
    figure = Picture(figsize=SIZE, layout="constrained")
    ax = figure.subplots()
    stable = data.stable
    for k in range(len(data) - 1):
        both = bool(stable[k] and stable[k + 1])
        ax.plot(values[k : k + 2], data.load[k : k + 2], "-" if both else "--", color=COLORS[0])
    ax.plot(values, data.load, ".", color=COLORS[0], markersize=4)
    _mark_critical(ax, data, values)
    ax.axhline(0.0, color=MUTED, linewidth=0.6)
    ax.margins(x=0.03)
    ax.set_xlabel(label)
    ax.set_ylabel(data.parameter)
    return figure


def _mark_critical(ax: Axes, data: LoadPath, values: NDArray[np.float64]) -> None:
    """Mark limit and bifurcation points by numbers, with their loads beside the picture."""
    spans = np.ptp(values) or 1.0, np.ptp(data.load) or 1.0
    groups: list[tuple[float, float, list[str]]] = []
    for number, found in enumerate(data.critical, 1):
        k = found.after
        a, b = data.load[k], data.load[k + 1]
        near = values[k : k + 2]
        share = float(np.clip((found.load - a) / (b - a), 0.0, 1.0)) if b != a else 0.5
        x = float(near[0] + share * (near[1] - near[0]))
        marker = "o" if found.kind == "limit" else "D"
        label = f"{number} {found.kind} {found.load:.5g}"
        ax.plot(x, found.load, marker, color=COLORS[1], markersize=6, label=label, linestyle="none")
        for left, up, numbers in groups:  # nearly coincident points share one label
            if np.hypot((x - left) / spans[0], (found.load - up) / spans[1]) < CLOSE:
                numbers.append(str(number))
                break
        else:
            groups.append((x, found.load, [str(number)]))
    for x, y, numbers in groups:
        ax.annotate(
            ", ".join(numbers),
            (x, y),
            xytext=(0, 6),
            textcoords="offset points",
            color=INK,
            ha="center",
            va="bottom",
        )
    if groups:
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), handletextpad=0.2)


@explained_as("write")
def write_load_path(data: LoadPath, path: str | Path) -> Path:
    """Write a load path as a table: load, unstable modes, lowest omega^2 and all sensors.

    Parameters
    ----------
    data : LoadPath
        Result of `load_path`.
    path : path
        Ends with .csv.

    Raises
    ------
    InputError
        For a path that cannot be written.
    """
    out = target(path, ("csv",))
    heads = [data.parameter, "unstable modes", "lowest omega^2 (rad2/s2)"]
    columns = [data.load, data.unstable, data.squares]
    for name, values in data.sensors.items():
        unit = f" ({data.units[name]})" if data.units.get(name, "") not in ("", "1") else ""
        if values.ndim == 1:
            heads.append(f"{name}{unit}")
            columns.append(values)
            continue
        three = values.shape[1] == 3
        for k in range(values.shape[1]):
            heads.append(f"{name}.{AXES[k] if three else k}{unit}")
            columns.append(values[:, k])
    return write_table(out, heads, np.column_stack(columns).tolist())
