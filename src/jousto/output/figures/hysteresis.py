"""Local loops at a notch, and random stress."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from jousto.output.style import COLORS, MUTED, Picture, drawing

if TYPE_CHECKING:
    from jousto.fatigue.local.strain_life import Rule
    from jousto.fatigue.random.random_response import RandomResponse
    from jousto.materials.strength.strain_life import StrainLife

SIZE = (6.4, 4.6)  # inch
MOST = 80  # turning points that are drawn


@drawing
def plot_hysteresis(
    material: StrainLife,
    series: ArrayLike,
    *,
    rule: Rule = "neuber",
) -> Picture:
    """Draw local stress over local strain at a notch, the first 80 reversals.

    Parameters
    ----------
    material : StrainLife
    series : (nt,) array_like
        Linear elastic stress, Pa.
    rule : {"neuber", "glinka", "elastic"}
        Notch rule.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For a bad history or rule, an unknown suffix or an unwritable path.
    """
    from jousto.fatigue.local.strain_life import local_path

    whole = local_path(series, material, rule=rule)
    S = whole.elastic[:MOST]
    e, s = [0.0], [0.0]
    for k, end in enumerate(S):
        start = S[k - 1] if k else 0.0
        # on its way a branch ends as if it turned there
        for part in np.linspace(start, end, 25)[1:]:
            there = local_path([*S[:k], part], material, rule=rule)
            e.append(float(there.strain[-1]))
            s.append(float(there.stress[-1]))
    figure = Picture(figsize=SIZE, layout="constrained")
    ax = figure.subplots()
    ax.plot(1e6 * np.array(e), 1e-6 * np.array(s), color=COLORS[0])
    points = 1e6 * whole.strain[:MOST], 1e-6 * whole.stress[:MOST]
    ax.plot(*points, ".", color=COLORS[1])
    ax.axhline(0.0, color=MUTED, linewidth=0.6)
    ax.axvline(0.0, color=MUTED, linewidth=0.6)
    ax.set_xlabel("local strain (um/m)")
    ax.set_ylabel("local stress (MPa)")
    ax.set_title(f"{material.name or 'material'}, {rule}")
    return figure


@drawing
def plot_spectrum(
    response: RandomResponse,
    sites: Sequence[str] | str,
    *,
    criterion: str = "von-mises",
) -> Picture:
    """Draw the spectral density of a stress at some places.

    Parameters
    ----------
    response : RandomResponse
        From `random_response`.
    sites : str or sequence of str
        Labels of the places.
    criterion : str
        A component or "von-mises".
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown place or criterion, an unknown suffix or an unwritable path.
    """
    labels, _ = response.sites(sites)
    densities = response.psd(criterion, labels)
    figure = Picture(figsize=SIZE, layout="constrained")
    ax = figure.subplots()
    for k, (label, density) in enumerate(zip(labels, densities, strict=True)):
        color = COLORS[k % len(COLORS)]
        ax.semilogy(response.frequency, 1e-12 * density, color=color, label=label)
    ax.set_xlabel("frequency (Hz)")
    ax.set_ylabel(f"{criterion} (MPa²/Hz)")
    ax.legend()
    return figure
