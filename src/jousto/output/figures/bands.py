"""Stress with the band in which it lies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.measurement.twin.bands import Band
from jousto.output.style import COLORS, INK, Picture, drawing

MOST = 6  # places in a picture
HEIGHT, WIDTH = 1.9, 7.2  # inch


@drawing
def plot_band(
    band: Band,
    *,
    sites: Sequence[str] | str | None = None,
    truth: ArrayLike | None = None,
) -> Picture:
    """Draw the stress of some places over time with its band, one panel each.

    Parameters
    ----------
    band : Band
        From `stress_band`.
    sites : sequence of str, optional
        Which places, six at most; the first ones if not given.
    truth : (nt, ns) array_like, optional
        Stress of the same places from elsewhere, Pa: measured there, or simulated.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown place, a truth of another shape, an unknown suffix or an unwritable path.
    """
    given = band.labels[:MOST] if sites is None else (sites,) if isinstance(sites, str) else sites
    problems = Problems()
    for site in given:
        if site not in band.labels:
            problems.add("plot", f"no place '{site}' in the band{suggest(site, band.labels)}")
    if not 0 < len(given) <= MOST:
        problems.add("plot", f"{len(given)} places, must be 1 to {MOST}")
    problems.raise_if_any()
    true = None if truth is None else np.asarray(truth, dtype=np.float64)
    if true is not None and true.shape != (len(band.time), len(given)):
        raise InputError(
            Problem(
                "plot",
                f"truth has shape {true.shape}, must be ({len(band.time)}, {len(given)})",
            )
        )
    figure = Picture(figsize=(WIDTH, HEIGHT * len(given) + 0.4), layout="constrained")
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
