"""Pictures of measurements: gauges with virtual gauges, stress bands, monitoring runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.units import shown_unit
from jousto.measurement.gauges.compare import GaugeComparison
from jousto.measurement.monitor.health import STATES
from jousto.measurement.twin.bands.bands import Band
from jousto.output.style import COLORS, INK, MUTED, Picture, blend, drawing, headline, panels_below

if TYPE_CHECKING:
    from jousto.measurement.monitor.record_reader import MonitorRecord

PANELS = 12  # maximum number of panels


PLACES = 6  # maximum number of places in a picture
POINTS = 4000  # points of a line; longer lines are drawn as minimum and maximum of intervals
BAD = COLORS[1]


@drawing
def plot_gauges(comparison: GaugeComparison) -> Picture:
    """Draw measured channels with their virtual gauges, one panel per pair.

    Parameters
    ----------
    comparison : GaugeComparison
        Result of `compare_gauges`.
    path : path, optional
        File to write; the suffix chooses the format.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path, or too many pairs for one picture.
    """
    pairs = comparison.pairs
    if len(pairs) > PANELS:
        raise InputError(Problem("plot", f"{len(pairs)} pairs; a picture has at most {PANELS}"))
    figure, axes = panels_below(len(pairs))
    for ax, pair in zip(axes, pairs, strict=True):
        unit, factor = shown_unit(pair.unit)
        measured, virtual = factor * pair.measured, factor * pair.virtual
        pale = blend(INK, 0.35)
        ax.plot(comparison.time, measured, color=pale, linewidth=3.0, label="measured")
        ax.plot(comparison.time, virtual, color=COLORS[1], linewidth=1.2, label="virtual")
        same = pair.sensor == pair.channel
        title = pair.channel if same else f"{pair.channel}, {pair.sensor}"
        note = f"scale {pair.scale:.3f}, rms of the difference {factor * pair.rms:.3g} {unit}"
        headline(ax, title, note)
        ax.set_ylabel(unit.replace("um/m", "µm/m"))
        known = np.isfinite(pair.measured)
        if known.any():
            ax.set_xlim(comparison.time[known][0], comparison.time[known][-1])
    axes[-1].set_xlabel("time (s)")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=2)
    return figure


@drawing
def plot_band(
    band: Band,
    *,
    sites: Sequence[str] | str | None = None,
    truth: ArrayLike | None = None,
) -> Picture:
    """Draw the stress of some places over time with its band, one panel per place.

    Parameters
    ----------
    band : Band
        Result of `stress_band`.
    sites : sequence of str, optional
        Places, six at most; by default the first ones.
    truth : (nt, ns) array_like, optional
        True stress of the same places for comparison, Pa, measured or simulated.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown place, a truth of another shape, an unknown suffix or an unwritable path.
    """
    given = band.labels[:PLACES] if sites is None else (sites,) if isinstance(sites, str) else sites
    problems = Problems()
    for site in given:
        if site not in band.labels:
            problems.add("plot", f"no place '{site}' in the band{suggest(site, band.labels)}")
    if not 0 < len(given) <= PLACES:
        problems.add("plot", f"{len(given)} places, must be 1 to {PLACES}")
    problems.raise_if_any()
    true = None if truth is None else np.asarray(truth, dtype=np.float64)
    if true is not None and true.shape != (len(band.time), len(given)):
        raise InputError(
            Problem(
                "plot",
                f"truth has shape {true.shape}, must be ({len(band.time)}, {len(given)})",
            )
        )
    figure = Picture(figsize=(7.2, 1.9 * len(given) + 0.4), layout="constrained")
    axes = np.atleast_1d(figure.subplots(len(given), 1, sharex=True))
    for i, (ax, site) in enumerate(zip(axes, given, strict=True)):
        k = band.labels.index(site)
        low, value, high = (1e-6 * x[:, k] for x in (band.low, band.value, band.high))
        share = f"{100 * band.level:g} %"
        ax.fill_between(band.time, low, high, color=COLORS[1], alpha=0.3, lw=0, label=share)
        ax.plot(band.time, value, color=COLORS[1], label="twin")
        if true is not None:
            ax.plot(band.time, 1e-6 * true[:, i], color=COLORS[0], lw=0.9, label="truth")
        ax.set_ylabel("MPa")
        ax.set_title(f"{site}, {band.criterion}", color=INK)
    axes[0].legend()
    axes[-1].set_xlabel("time (s)")
    return figure


@drawing
def plot_monitor(record: MonitorRecord) -> Picture:
    """Draw stress with its band, damage, and the states of the channels over time.

    Parameters
    ----------
    record : MonitorRecord
        Record from `watch`, or of a file.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path.
    """
    time, counted = record.time, record.counted
    rows = 3 if counted else 2
    figure = Picture(figsize=(8.0, 2.4 * rows + 0.6), layout="constrained")
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
        # text above the axes: inside it would cover peaks
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
    """Return times with minimum and maximum of intervals, at most POINTS of them."""
    step = max(1, -(-len(time) // POINTS))
    starts = np.arange(0, len(time), step)
    if step == 1 or not len(time):
        return time, (low, high)
    return time[starts], (np.fmin.reduceat(low, starts), np.fmax.reduceat(high, starts))


def pieces(states: NDArray[np.uint8]) -> list[tuple[int, int, int]]:
    """Return first and last index and state of each run of equal states."""
    if not len(states):
        return []
    cuts = [0, *(np.flatnonzero(np.diff(states.astype(int))) + 1).tolist(), len(states)]
    return [(a, b, int(states[a])) for a, b in zip(cuts[:-1], cuts[1:], strict=True)]
