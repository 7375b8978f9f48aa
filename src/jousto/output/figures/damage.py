"""Damage over a body as pictures and ParaView files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import LogNorm, Normalize, to_rgb

from jousto.base.arguments import explained_as
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, suggest
from jousto.fatigue.miner.damage_field import DamageField
from jousto.output.figures.coloured_body import extent, mark_place, paint_body
from jousto.output.files.paraview import cells_of, save_vtu
from jousto.output.scenes.stage import UNKNOWN
from jousto.output.scenes.surface import STRESS_COLORS
from jousto.output.scenes.view import View, choose_view
from jousto.output.style import MUTED, Picture, drawing, scale_at, target
from jousto.recovery.shape import find_body
from jousto.simulation.results.records import BodyShape
from jousto.simulation.results.solution import Solution

WIDTH, LEGEND, GAP, TOP = 7.2, 1.15, 0.2, 0.82  # inch: width, colour legend, gap, top margin
DECADES = 8.0  # decades of damage in the colour range
QUANTITIES = ("damage", "life", "safety")


@drawing
def plot_damage(
    field: DamageField,
    run: Solution,
    *,
    quantity: str = "damage",
    view: View | str | None = None,
    marks: int = 3,
) -> Picture:
    """Draw damage, life or safety over a body, with the worst places.

    Parameters
    ----------
    field : DamageField
        Result of `damage_field`.
    run : Solution
        A run with that body, for its shape.
    quantity : str
        "damage", "life" (s; both in decades) or "safety" (to 5).
    view : View, "xy", "xz" or "yz", optional
        Direction of view in the body frame.
    marks : int
        Worst places that are numbered; those behind the body are faded, in brackets.
    path : path, optional
        File to write: png, svg, pdf, jpg, webp or eps.

    Raises
    ------
    InputError
        If the run has no such body, for an unknown quantity or suffix, or an unwritable path.
    """
    if quantity not in QUANTITIES:
        known = suggest(quantity, QUANTITIES)
        raise InputError(Problem("plot", f"quantity is {quantity!r}{known}"))
    shape = find_body(run, field.body)
    values = node_values(
        shape, field, getattr(field, quantity), max if quantity == "damage" else min
    )
    eye = choose_view(view, shape.nodes, None)
    figure = _picture(shape, field, values, quantity, eye, marks)
    return figure


@explained_as("write")
def write_damage(field: DamageField, path: str | Path, run: Solution) -> Path:
    """Write damage, its decimal logarithm, life and safety at the nodes of a body for ParaView.

    Nodes without stress are NaN; nodes with several places, such as the points of a beam section,
    have the largest value.

    Parameters
    ----------
    field : DamageField
    path : path
        Ends with .vtu.
    run : Solution
        A run with that body, for its shape.

    Raises
    ------
    InputError
        If the run has no such body, for another ending or an unwritable path.
    """
    out = target(path, ("vtu",))
    shape = find_body(run, field.body)
    damage = node_values(shape, field, field.damage, max)
    with np.errstate(divide="ignore"):
        decades = np.log10(damage)
    fields = {
        "damage": damage,
        "log10 damage": np.where(np.isneginf(decades), -30.0, decades),
        "life (s)": np.minimum(node_values(shape, field, field.life, min), 1e30),
        "safety": np.minimum(node_values(shape, field, field.safety, min), 1e30),
        "largest stress (Pa)": node_values(shape, field, np.abs(field.peak), max),
    }
    return save_vtu(out, shape.nodes, cells_of(shape.elements), fields)


def node_values(
    shape: BodyShape, field: DamageField, values: Array, worst: Callable[..., Any]
) -> Array:
    """Return the largest damage at each node (nn,) of a body, nan where unknown."""
    high = worst is max
    out = np.full(len(shape.nodes), -np.inf if high else np.inf)
    known = np.zeros(len(out), dtype=bool)
    nodes: Any = field.nodes
    if nodes is None or np.any(nodes < 0):
        from scipy.spatial import cKDTree  # slow import, rarely needed

        nearest = cKDTree(shape.nodes).query(field.positions)[1]
        nodes = nearest if nodes is None else np.where(nodes < 0, nearest, nodes)
    (np.maximum if high else np.minimum).at(out, nodes, values)
    known[nodes] = True
    return np.where(known, out, np.nan)


def _norm(values: Array, quantity: str) -> tuple[Any, bool]:
    """Return the colour scale, and whether small values are critical."""
    known = values[np.isfinite(values)]
    if quantity == "safety":
        return Normalize(0.0, 5.0), True
    positive = known[(known > 0.0) & (known < 1e29)]
    low = float(positive.min()) if len(positive) else 1e-6
    high = float(positive.max()) if len(positive) else 1.0
    if quantity == "life":
        return LogNorm(low, max(min(high, low * 10.0**DECADES), 10.0 * low)), True
    return LogNorm(min(max(low, high / 10.0**DECADES), 0.1 * high), high), False


def _picture(
    shape: BodyShape, field: DamageField, values: Array, quantity: str, view: View, marks: int
) -> Picture:
    _, size = extent(shape, view)
    inner = WIDTH - GAP - LEGEND
    height = float(inner * size[1] / size[0])
    total = height + TOP + GAP
    figure = Picture(figsize=(WIDTH, total))
    ax = figure.add_axes((GAP / WIDTH, GAP / total, inner / WIDTH, height / total))
    norm, reverse = _norm(values, quantity)
    shades = STRESS_COLORS.reversed() if reverse else STRESS_COLORS

    def colors(of: Array) -> Array:
        floor = norm.vmin if not reverse else norm.vmax
        plain = np.where(np.isfinite(of) & ((of > 0.0) | reverse), of, floor)
        found = np.asarray(shades(norm(np.clip(plain, norm.vmin, norm.vmax))))[:, :3]
        found[np.isnan(of)] = to_rgb(UNKNOWN)
        return found

    paint_body(ax, shape, view, values, colors, decades=True)
    near = 0.03 * float(size.max())
    marked: list[Array] = []
    places: list[str] = []
    for label in field.worst(20 * marks):
        position = field.positions[field.labels.index(label)]
        at = view.project(position[None])[0]
        # points of one section or one notch get one mark
        if len(marked) == marks or any(np.hypot(*(at - m)[:2]) < near for m in marked):
            continue
        marked.append(at)
        places.append(f"{len(marked)} {label}")
        mark_place(ax, shape, view, position, len(marked))
    title = f"{quantity} of {field.body}: {field.sn.name or 'S-N curve'}, {field.criterion}"
    figure.text(GAP / WIDTH, 1 - 0.2 / total, title, fontsize=10.5, fontweight="bold", va="center")
    mean = "not corrected" if field.mean is None else str(field.mean)
    note = (
        f"mean stress: {mean}, residue: {field.residue}, survival {100 * field.sn.survival:.5g} %"
    )
    if quantity == "safety":
        note = f"{field.safety_of}, {note}"
    figure.text(GAP / WIDTH, 1 - 0.42 / total, note, color=MUTED, fontsize=8.5, va="center")
    worst = ", ".join(places)
    figure.text(GAP / WIDTH, 1 - 0.62 / total, worst, color=MUTED, fontsize=8.5, va="center")
    _bar(figure, norm, shades, quantity, (1 - (LEGEND - 0.15) / WIDTH, GAP / total, height / total))
    return figure


def _bar(
    figure: Picture, norm: Any, shades: Any, quantity: str, place: tuple[float, float, float]
) -> None:
    ax = scale_at(figure, place, "life (s)" if quantity == "life" else quantity)
    log = isinstance(norm, LogNorm)
    edges = (np.geomspace if log else np.linspace)(norm.vmin, norm.vmax, 257)
    ax.pcolormesh([0.0, 1.0], edges, edges[:-1, None], cmap=shades, norm=norm)
    if log:
        ax.set_yscale("log")
