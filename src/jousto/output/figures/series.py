"""What to draw against time: from names such as ``middle.y`` to curves with names and units."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.simulation.results.naming import pick
from jousto.simulation.results.solution import Solution

DIAGNOSTICS = ("energy", "residuals")
TERMS = ("kinetic", "strain", "potential", "springs", "dissipated", "friction", "work")
MANY = 8  # more curves than this: leave out those that are always zero
POINTS = 3000  # a picture has no room for more
STEPS = 200  # intervals of an envelope
NOTHING = 1e-18  # residuals are drawn on a logarithmic axis, which has no zero


@dataclass(frozen=True, eq=False)
class Curve:
    """One line: `name` of the component, `run` it belongs to, t (nt,) s and y (nt,)."""

    name: str
    run: str
    t: Array
    y: Array


@dataclass(frozen=True, eq=False)
class Panel:
    """Curves that share an axis."""

    title: str
    subtitle: str
    unit: str
    curves: tuple[Curve, ...]
    log: bool = False


def panels(runs: Mapping[str, Solution], names: tuple[str, ...]) -> list[Panel]:
    """Return the panels for these names; without names all sensors.

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
            t, values = run.time, run[sensor]
            curves += [Curve(components[i], label, *thin(t, values[:, i])) for i in indices]
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
    """Return a unit as it is printed.

    Examples
    --------
    >>> readable("kg^0.5 m/s"), readable("m/s2"), readable("1")
    ('√kg m/s', 'm/s²', '')
    """
    return "" if unit == "1" else re.sub(r"(?<=s)2", "²", unit.replace("kg^0.5", "√kg"))


def _worth_drawing(curves: list[Curve], unit: str) -> tuple[Curve, ...]:
    """Leave out what is zero but for round-off: of stresses, and where there are many curves."""
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
    """Return fewer points with the same picture: the extremes of each of many short intervals."""
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
    """Return the largest value of each of many intervals, as a line of steps."""
    size = -(-len(t) // STEPS)
    if size == 1:
        return t, y
    starts = np.arange(0, len(t), size)
    largest = np.maximum.reduceat(y, starts)
    edges = t[np.minimum(np.append(starts, len(t) - 1), len(t) - 1)]
    return np.repeat(edges, 2)[1:-1], np.repeat(largest, 2)
