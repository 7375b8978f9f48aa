"""Sensors and diagnostics of a run over time."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.rounding import without_rounding
from jousto.output.style import (
    COLORS,
    DASHES,
    INK,
    MUTED,
    Picture,
    blend,
    drawing,
    headline,
    panels_below,
)
from jousto.simulation.results.dataframes import pick
from jousto.simulation.results.solution import Solution

PREFIXES = {-12: "p", -9: "n", -6: "µ", -3: "m", 3: "k", 6: "M", 9: "G"}
PREFIXED = ("m", "m/s", "m/s²", "m/m", "N", "N m", "Pa", "J", "rad")
NONE = (None, None)  # solid line: no dash pattern
LABELLED = 10  # number of lines up to which each line has a label


DIAGNOSTICS = ("energy", "residuals")
TERMS = ("kinetic", "strain", "potential", "springs", "dissipated", "friction", "work")
MANY = 8  # number of curves above which curves that are always zero are left out
POINTS = 3000  # points of a curve
STEPS = 200  # intervals of an envelope
NOTHING = 1e-18  # lower limit of residuals on the logarithmic axis


@drawing
def plot_run(run: Solution | Mapping[str, Solution], *names: str) -> Picture:
    """Draw sensors over time, one panel per quantity.

    Parameters
    ----------
    run : Solution or mapping of str to Solution
        The results; several runs, each with its label, are drawn over one another: a component has
        the same colour in all of them, a run the same kind of line in all components.
    *names : str
        A sensor ``"middle"``, one component ``"middle.y"`` or ``"middle:y"``, ``"energy"`` for the
        energy balance or ``"residuals"`` for the residuals of the constraints. None for all
        sensors.
    path : path, optional
        File to write; the suffix chooses the format: png, svg, pdf, jpg, webp or eps.

    Returns
    -------
    matplotlib.figure.Figure
        The figure is not registered in pyplot and need not be closed.

    Raises
    ------
    InputError
        With all unknown names and suggestions; for an unknown suffix or an unwritable path.

    Examples
    --------
    ``plot(run, "middle.y", "energy", path="pendulum.png")``
    """
    runs = {"": run} if isinstance(run, Solution) else dict(run)
    if not runs:
        raise InputError(Problem("plot", "there is no run to draw"))
    figure = draw(panels(runs, names), tuple(runs))
    return figure


def draw(rows: list[Panel], labels: tuple[str, ...]) -> Picture:
    """Return the figure of panels; `labels` are the names of the runs."""
    figure, axes = panels_below(len(rows))
    for ax, panel in zip(axes, rows, strict=True):
        _panel(ax, panel, labels)
    if len(labels) > 1:
        alone = all(len({c.name for c in p.curves}) == 1 for p in rows)
        keys = [
            Line2D([], [], label=label, **_line(k, len(labels), 0 if alone else None))
            for k, label in enumerate(labels)
        ]
        figure.legend(handles=keys, loc="outside upper right", ncols=min(len(keys), 5))
    return figure


def _panel(ax: Axes, panel: Panel, labels: tuple[str, ...]) -> None:
    headline(ax, panel.title, panel.subtitle)
    ax.set_ylabel(panel.unit)
    if panel.log:
        ax.set_yscale("log")
    else:
        _scale(ax, panel)
    names = list(dict.fromkeys(curve.name for curve in panel.curves))
    ends: list[tuple[float, str, str]] = []
    for curve in panel.curves:
        k, j = labels.index(curve.run), names.index(curve.name)
        style = _line(k, len(labels), 0 if len(names) == 1 else j)
        ax.plot(curve.t, curve.y, **style)
        if k == 0:
            known = curve.y[np.isfinite(curve.y)]
            end = float(known[-1]) if len(known) else 0.0
            ends.append((end, curve.name, COLORS[j % len(COLORS)]))
    if len(panel.curves):
        ax.set_xlim(panel.curves[0].t[0], max(c.t[-1] for c in panel.curves))
    _widen(ax, panel)
    if len(names) <= LABELLED:
        _name_lines(ax, ends)
    else:
        ax.annotate(f"{len(names)} components", (1.012, 0.5), xycoords="axes fraction", color=MUTED)


def _widen(ax: Axes, panel: Panel) -> None:
    """Widen the range of an axis whose values differ by rounding errors only."""
    if panel.log:
        return
    low = min((float(np.nanmin(c.y)) for c in panel.curves), default=0.0)
    high = max((float(np.nanmax(c.y)) for c in panel.curves), default=0.0)
    size = max(abs(low), abs(high))
    if high - low <= 1e-12 * size or size < 1e-300:
        margin = 0.1 * size if size >= 1e-300 else 1.0
        ax.set_ylim(low - margin, high + margin)


def _line(run: int, runs: int, component: int | None) -> dict[str, Any]:
    """Return the style of a line; None gives the style of a run.

    The colour identifies the component, the line style the run: the first of several runs is broad
    and pale, the next ones are solid, dashed, dotted and so on, eight styles, which then repeat in
    a paler colour.
    """
    color = INK if component is None else COLORS[component % len(COLORS)]
    if runs == 1:
        return {"color": color}
    if run == 0:
        return {"color": blend(color, 0.35), "linewidth": 4.0}
    again, kind = divmod(run - 1, len(DASHES))
    shade = blend(color, max(0.65**again, 0.4))
    return {"color": shade, "linewidth": 1.4, "dashes": DASHES[kind] or NONE}


def _scale(ax: Axes, panel: Panel) -> None:
    """Return a decimal prefix of the unit, or a power of ten, that gives short numbers."""
    size = max((float(np.nanmax(np.abs(c.y))) for c in panel.curves), default=0.0)
    power = 0 if size == 0.0 or 1e-2 <= size < 1e4 else 3 * int(np.floor(np.log10(size) / 3.0))
    if power == 0 or size < 1e-300:
        return
    if panel.unit in PREFIXED and power in PREFIXES and not (panel.unit[0] == "m" and power > 0):
        ax.set_ylabel(PREFIXES[power] + panel.unit)
    else:
        superscript = str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        ax.set_ylabel(f"10{superscript} {panel.unit}".rstrip())
    factor = 10.0**power
    ax.yaxis.set_major_formatter(lambda y, _: f"{y / factor:.10g}".replace("-", "\u2212"))


def _name_lines(ax: Axes, ends: list[tuple[float, str, str]]) -> None:
    """Write the name of each line at its right end without overlaps."""
    transform = ax.transScale + ax.transLimits
    wanted = np.array([transform.transform((1.0, y))[1] for y, _, _ in ends])
    height = ax.get_position().height * ax.figure.get_figure().get_figheight()  # type: ignore[union-attr]
    for at, (_, name, color) in zip(spread(wanted, 0.17 / height), ends, strict=True):
        ax.annotate(
            name.replace(":", " "),
            (1.0, at),
            xytext=(7, 0),
            xycoords="axes fraction",
            textcoords="offset points",
            va="center",
            ha="left",
            color=color,
            fontsize=9,
            fontweight="bold",
        )


def spread(wanted: NDArray[np.float64], gap: float) -> NDArray[np.float64]:
    """Return places at least `gap` apart, in the same order and near the wanted places.

    Examples
    --------
    >>> spread(np.array([0.5, 0.1, 0.5]), 0.2)
    array([0.4, 0.1, 0.6])
    """
    order = np.argsort(wanted, kind="stable")
    # isotonic regression of the places minus k times the gap, by pooling adjacent violators
    groups: list[tuple[float, int]] = []
    for value in np.clip(wanted[order], 0.0, 1.0) - gap * np.arange(len(wanted)):
        groups.append((float(value), 1))
        while len(groups) > 1 and groups[-2][0] > groups[-1][0]:
            (a, n), (b, m) = groups[-2:]
            groups[-2:] = [((a * n + b * m) / (n + m), n + m)]
    places = np.empty(len(wanted))
    flat = np.concatenate([np.full(n, value) for value, n in groups]) if groups else np.zeros(0)
    places[order] = flat + gap * np.arange(len(wanted))
    return places


@dataclass(frozen=True, eq=False)
class Curve:
    """One line: component `name`, label of its `run`, t (nt,) s and y (nt,)."""

    name: str
    run: str
    t: Array
    y: Array


@dataclass(frozen=True, eq=False)
class Panel:
    """Curves on a common axis."""

    title: str
    subtitle: str
    unit: str
    curves: tuple[Curve, ...]
    log: bool = False


def panels(runs: Mapping[str, Solution], names: tuple[str, ...]) -> list[Panel]:
    """Return the panels of named sensors; all sensors if none is named.

    Raises
    ------
    InputError
        With all names that are not known, and suggestions.
    """
    first = next(iter(runs.values()))
    wanted = names or first.sensors or ("energy",)
    problems: list[Problem] = []
    found: list[Panel] = []
    for name in wanted:
        try:
            found += _panels(runs, name)
        except InputError as error:
            problems += error.problems
    if problems:
        raise InputError(problems)
    return found


def _panels(runs: Mapping[str, Solution], name: str) -> list[Panel]:
    first = next(iter(runs.values()))
    if name in DIAGNOSTICS and name not in first.sensors:
        return _energy(runs) if name == "energy" else _residuals(runs)
    sensor, wanted = pick(first, name, DIAGNOSTICS)
    about = first.about(sensor)
    components, units = about["components"], about["unit"].split(", ")
    axes = about["resolved_in"]
    per_unit = len(components) // len(units)
    result = []
    for k, unit in enumerate(units):
        indices = [i for i in wanted if i // per_unit == k]
        if not indices:
            continue
        curves = []
        for label, run in runs.items():
            t = run.time
            of_unit = slice(k * per_unit, (k + 1) * per_unit)
            values = without_rounding(run[sensor][:, of_unit], run.floors(sensor)[of_unit])
            curves += [
                Curve(components[i], label, *thin(t, values[:, i - of_unit.start])) for i in indices
            ]
        where = {"world": "world frame", "body": "", "element": "element axes", "coordinate": ""}
        where["joint"] = "joint axes"
        subtitle = ", ".join(
            word
            for word in (
                about["description"],
                where.get(axes, f"axes of {axes}") if unit not in ("1", "J") else "",
            )
            if word
        )
        result.append(Panel(sensor, subtitle, readable(unit), _worth_drawing(curves, unit)))
    return result


def readable(unit: str) -> str:
    """Return a unit in its printed form.

    Examples
    --------
    >>> readable("kg^0.5 m/s"), readable("m/s2"), readable("1")
    ('√kg m/s', 'm/s²', '')
    """
    return "" if unit == "1" else re.sub(r"(?<=s)2", "²", unit.replace("kg^0.5", "√kg"))


def _worth_drawing(curves: list[Curve], unit: str) -> tuple[Curve, ...]:
    """Return curves without those that are zero: stresses, and all if there are many."""
    if len(curves) <= MANY and unit != "Pa":
        return tuple(curves)
    sizes = {id(c): float(np.abs(c.y).max(initial=0.0)) for c in curves}
    least = 1e-9 * max(sizes.values())
    names = {c.name for c in curves if sizes[id(c)] > least}
    return tuple(c for c in curves if c.name in names) or tuple(curves[:1])


def _energy(runs: Mapping[str, Solution]) -> list[Panel]:
    terms, errors = [], []
    for label, run in runs.items():
        t, energy = run.time, run.energy
        for name in (*TERMS, "total"):
            y = getattr(energy, name)
            if name in ("kinetic", "total") or y.any():
                terms.append(Curve(name, label, *thin(t, y)))
        errors.append(Curve("error", label, *thin(t, energy.error)))
    return [
        Panel("energy", "kinetic, strain and potential energy", "J", tuple(terms)),
        Panel("energy error", "what the balance misses", "J", tuple(errors)),
    ]


def _residuals(runs: Mapping[str, Solution]) -> list[Panel]:
    curves = []
    for label, run in runs.items():
        t = run.time
        for name in ("position", "velocity"):
            y = getattr(run.residuals, name)
            curves.append(Curve(name, label, *envelope(t, np.maximum(y, NOTHING))))
    return [
        Panel(
            "residuals",
            "largest violation of the constraints, |C| and |C'|",
            "m, m/s",
            tuple(curves),
            log=True,
        )
    ]


def thin(t: Array, y: Array) -> tuple[Array, Array]:
    """Return fewer points of a curve: the extremes of each of many short intervals."""
    pieces = POINTS // 2
    size = -(-len(t) // pieces)
    if size <= 2:
        return t, y
    starts = np.arange(0, len(t), size)
    chosen = {0, len(t) - 1}
    for start in starts:
        block = y[start : start + size]
        chosen |= {int(start + block.argmin()), int(start + block.argmax())}
    index = np.array(sorted(chosen))
    return t[index], y[index]


def envelope(t: Array, y: Array) -> tuple[Array, Array]:
    """Return the largest value of each of many intervals as a step line."""
    size = -(-len(t) // STEPS)
    if size == 1:
        return t, y
    starts = np.arange(0, len(t), size)
    largest = np.maximum.reduceat(y, starts)
    edges = t[np.minimum(np.append(starts, len(t) - 1), len(t) - 1)]
    return np.repeat(edges, 2)[1:-1], np.repeat(largest, 2)
