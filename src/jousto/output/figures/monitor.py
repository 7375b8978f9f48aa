"""The record of a monitoring run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from jousto.measurement.monitor.health import STATES
from jousto.output.style import COLORS, MUTED, Picture, drawing

if TYPE_CHECKING:
    from jousto.measurement.monitor.recorded import MonitorRecord

WIDTH = 8.0  # inch
MOST = 4000  # points of a line; more are drawn as smallest and largest of their neighbours
BAD = COLORS[1]


@drawing
def plot_monitor(record: MonitorRecord) -> Picture:
    """Draw stress with its band, damage, and the health of the channels over time.

    Parameters
    ----------
    record : MonitorRecord
        From `watch`, or of a file.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path.
    """
    time, counted = record.time, record.counted
    rows = 3 if counted else 2
    figure = Picture(figsize=(WIDTH, 2.4 * rows + 0.6), layout="constrained")
    axes = figure.subplots(rows, 1, sharex=True)
    top, health = axes[0], axes[-1]
    low, high, stress = record.low / 1e6, record.high / 1e6, record.stress / 1e6
    for k, spot in enumerate(record.spots):
        color = COLORS[k % len(COLORS)]
        t, (a, b) = thinned(time, low[:, k], high[:, k])
        top.fill_between(t, a, b, color=color, alpha=0.25, linewidth=0)
        t, (a, b) = thinned(time, stress[:, k], stress[:, k])
        top.fill_between(t, a, b, color=color, linewidth=0.8, label=spot)
    limit = record.attributes.get("limit_stress")
    if limit is not None:
        for sign in (1.0, -1.0):
            top.axhline(sign * limit / 1e6, color=MUTED, dashes=(5, 2), linewidth=0.8)
    top.set_ylabel("stress (MPa)")
    top.set_title(
        f"{record.attributes['criterion']}, {100 * record.attributes['level']:g} % band",
        loc="left",
    )
    if len(record.spots) <= 8:
        # above the axes: within them it would cover peaks
        top.legend(
            loc="lower right",
            bbox_to_anchor=(1.0, 1.0),
            borderaxespad=0.0,
            ncols=min(4, len(record.spots)),
        )
    if counted:
        t = record.summary("time")
        D, a, b = (record.summary(n) for n in ("damage", "damage_low", "damage_high"))
        for k in range(len(record.spots)):
            color = COLORS[k % len(COLORS)]
            axes[1].fill_between(t, a[:, k], b[:, k], color=color, alpha=0.2, linewidth=0)
            axes[1].plot(t, D[:, k], color=color)
        axes[1].set_ylabel("damage")
        if np.any(D > 0.0):
            axes[1].set_yscale("log")
            axes[1].set_ylim(bottom=1e-4 * float(D.max()))
    states = record.states
    for c, _ in enumerate(record.channels):
        for first, last, state in pieces(states[:, c]):
            ends = (time[first], time[min(last, len(time) - 1)])
            health.plot(
                ends,
                (c, c),
                color=BAD if state else COLORS[2],
                linewidth=5,
                solid_capstyle="butt",
            )
            if state and STATES[state] != "back":
                health.annotate(
                    STATES[state], (ends[0], c), (0, 4), textcoords="offset points", fontsize=7
                )
    health.set_yticks(range(len(record.channels)), record.channels)
    health.set_ylim(len(record.channels) - 0.4, -0.8)
    health.grid(False)
    health.set_xlabel("time (s)")
    return figure


def thinned(
    time: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64]
) -> tuple[NDArray[np.float64], tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Return times and the smallest and largest value around each, at most MOST of them."""
    step = max(1, -(-len(time) // MOST))
    starts = np.arange(0, len(time), step)
    if step == 1 or not len(time):
        return time, (low, high)
    return time[starts], (np.fmin.reduceat(low, starts), np.fmax.reduceat(high, starts))


def pieces(states: NDArray[np.uint8]) -> list[tuple[int, int, int]]:
    """Return first and last index and state of each piece of equal states."""
    if not len(states):
        return []
    cuts = [0, *(np.flatnonzero(np.diff(states.astype(int))) + 1).tolist(), len(states)]
    return [(a, b, int(states[a])) for a, b in zip(cuts[:-1], cuts[1:], strict=True)]
