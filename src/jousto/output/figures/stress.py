"""Histories and tables of stress fields; stress with and without friction."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arguments import explained_as
from jousto.base.errors import InputError, Problem
from jousto.base.files import written
from jousto.output.figures.histories import Curve, Panel, draw
from jousto.output.style import COLORS, MUTED, Picture, drawing, target
from jousto.recovery.fields.criteria import Criterion
from jousto.recovery.fields.field import StressField
from jousto.recovery.friction import FrictionStress

MOST = 10


SIZE = (9.5, 5.4)  # inch


@drawing
def plot_stress(
    field: StressField,
    *,
    criterion: Criterion = "von-mises",
) -> Picture:
    """Draw the history of a criterion at the places of a field.

    Parameters
    ----------
    field : StressField
        Stress field of at most ten places: ``field.only("e1.a.top")``.
    criterion : str or Plane
        Criterion, see `jousto.recovery.fields.criteria.evaluate`.
    path : path, optional
        File to write: png, svg, pdf, jpg, webp or eps.

    Raises
    ------
    InputError
        For an unknown suffix, an unwritable path, or too many places.
    """
    if field.ns > MOST:
        message = f"{field.ns} histories cannot be distinguished: choose at most {MOST} sites"
        raise InputError(Problem(f"stress of '{field.name}'", message))
    values = field.values(criterion)
    curves = tuple(
        Curve(label, "", field.time, values[:, k]) for k, label in enumerate(field.labels)
    )
    kind = "strain" if field.strain else "stress"
    title = f"{criterion} {kind} of {field.name}"
    figure = draw([Panel(title, f"{field.frame} axes", field.unit, curves)], ("",))
    return figure


@explained_as("write")
def write_stress(
    field: StressField,
    path: str | Path,
    *,
    criterion: Criterion = "von-mises",
    time: float | None = None,
    histories: bool = False,
) -> Path:
    """Write a criterion as a table: envelope of every place, one instant, or histories.

    Parameters
    ----------
    field : StressField
    path : path
        Ends with .csv.
    criterion : str or Plane
        Criterion, see `jousto.recovery.fields.criteria.evaluate`.
    time : float, optional
        The instant, s; by default the envelope over all instants.
    histories : bool
        Whether to write one row for each instant and one column for each place instead.

    Raises
    ------
    InputError
        For another suffix or an unwritable path.
    """
    out = target(path, ("csv",))
    unit = field.unit
    with written(out) as beside, beside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        if histories and time is None:
            writer.writerow(["time (s)", *(f"{x} {criterion} ({unit})" for x in field.labels)])
            for instants, _, values in field.blocks(criterion, along="sites", memory=1 << 24):
                rows = np.column_stack([field.time[instants], values])
                writer.writerows(rows.tolist())
            return out
        head = ["site", "node", "x (m)", "y (m)", "z (m)"]
        nodes = np.full(field.ns, -1) if field.modes.nodes is None else field.modes.nodes
        columns: list[Any]
        if time is not None:
            head.append(f"{criterion} at {time:g} s ({unit})")
            columns = [field.values(criterion, times=[time])[0]]
        else:
            found = field.envelope(criterion)
            head += [f"smallest {criterion} ({unit})", "at (s)"]
            head += [f"largest {criterion} ({unit})", "at (s)"]
            columns = [found.min, found.min_time, found.max, found.max_time]
        writer.writerow(head)
        for i, label in enumerate(field.labels):
            row = [label, int(nodes[i]), *field.positions[i].tolist()]
            writer.writerow([*row, *(float(column[i]) for column in columns)])
    return out


@drawing
def plot_friction_stress(found: FrictionStress, *, site: str | None = None) -> Picture:
    """Draw von Mises stress with and without friction at a place, and of their difference.

    Parameters
    ----------
    found : FrictionStress
        Result of `friction_stress`.
    site : str, optional
        Label of the place; None for that of the largest stress due to friction.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown site or suffix, or an unwritable path.
    """
    place = found.table(1)[0]["site"] if site is None else site
    figure = Picture(figsize=SIZE, layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    for k, (label, field) in enumerate(
        (("with friction", found.with_friction), ("without", found.without_friction))
    ):
        values = field.values("von-mises", place)[:, 0]
        upper.plot(found.time, 1e-6 * values, color=COLORS[k], label=label)
    due = found.due.values("von-mises", place)[:, 0]
    lower.plot(found.time, 1e-6 * due, color=COLORS[2], label="due to friction")
    for transition in found.transitions:
        for ax in (upper, lower):
            ax.axvline(transition.time, color=MUTED, linewidth=0.6, linestyle=":")
    top = found.peaks(5)
    lower.plot(
        [t.at for t in top if t.site == place],
        [1e-6 * due[abs(found.time - t.at).argmin()] for t in top if t.site == place],
        "o",
        color=COLORS[1],
        markersize=4,
        label="peaks after stick and slip",
    )
    upper.set_title(f"{found.body}, {place}", loc="left", fontweight="bold")
    upper.set_ylabel("von Mises (MPa)")
    lower.set_ylabel("MPa")
    lower.set_xlabel("time (s)")
    for ax in (upper, lower):
        ax.legend()
    return figure
