"""Fatigue pictures: S-N curves with cycles, hysteresis loops, stress spectra."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.layout_engine import ConstrainedLayoutEngine
from numpy.typing import ArrayLike

from jousto.base.errors import InputError, Problem
from jousto.fatigue.cycles.rainflow import Cycles
from jousto.fatigue.miner.damage import equivalents
from jousto.materials.strength.mean_stress import MeanStress
from jousto.materials.strength.sn import SN
from jousto.output.scenes.surface import STRESS_COLORS
from jousto.output.style import COLORS, INK, MUTED, Picture, drawing

if TYPE_CHECKING:
    from jousto.fatigue.local.strain_life import Rule
    from jousto.fatigue.random.random_response import RandomResponse
    from jousto.materials.strength.strain_life import StrainLife

WIDTH = 7.2  # width of a picture, inch


SIZE = (6.4, 4.6)  # width and height, inch
MOST = 80  # turning points drawn


@drawing
def plot_sn(
    curves: SN | Sequence[SN],
    cycles: Cycles | None = None,
    *,
    mean: MeanStress | None = None,
) -> Picture:
    """Draw S-N curves, and the load spectrum of counted cycles as steps.

    Parameters
    ----------
    curves : SN or sequence of SN
    cycles : Cycles, optional
        Result of `rainflow`.
    mean : MeanStress, optional
        Correction of the amplitudes of the cycles.
    path : path, optional
        File to write: png, svg, pdf, jpg, webp or eps.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path.
    """
    chosen = (curves,) if isinstance(curves, SN) else tuple(curves)
    if not chosen:
        raise InputError(Problem("plot", "there is no curve to draw"))
    figure = _figure(3.9)
    _sn(figure.subplots(), chosen, cycles, mean)
    return figure


@drawing
def plot_cycles(
    cycles: Cycles,
    sn: SN | None = None,
    *,
    mean: MeanStress | None = None,
    bins: int = 32,
) -> Picture:
    """Draw the rainflow matrix, the level crossings and, with a curve, the S-N plot of a history.

    Parameters
    ----------
    cycles : Cycles
        Result of `rainflow`.
    sn : SN, optional
    mean : MeanStress, optional
        Correction of the amplitudes in the S-N plot.
    bins : int
        Classes of the matrix on each side.
    path : path, optional
        File to write.

    Raises
    ------
    InputError
        For an unknown suffix, an unwritable path or a history without cycles.
    """
    if not len(cycles):
        raise InputError(Problem("plot", "the history is constant: there are no cycles"))
    figure = _figure(3.1 if sn is None else 6.4)
    if sn is None:
        left, right = figure.subplots(1, 2)
    else:
        grid = figure.add_gridspec(2, 2)
        left, right = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1])
        _sn(figure.add_subplot(grid[1, :]), (sn,), cycles, mean)
    _matrix(figure, left, cycles, bins)
    _levels(right, cycles)
    return figure


def _figure(height: float) -> Picture:
    return Picture(
        figsize=(WIDTH, height), layout=ConstrainedLayoutEngine(h_pad=0.09, w_pad=0.09, hspace=0.04)
    )


def _title(ax: Axes, text: str) -> None:
    ax.set_title(text, loc="left", fontsize=10.0, fontweight="bold", pad=6)


def _sn(ax: Axes, curves: Sequence[SN], cycles: Cycles | None, mean: MeanStress | None) -> None:
    _title(ax, "S-N curve" + ("" if cycles is None else f" and cycles, residue: {cycles.residue}"))
    S: Any = np.zeros(0)
    if cycles is not None and len(cycles):
        S = equivalents(cycles, mean)
        # leave out cycles at rounding level
        known = np.isfinite(S) & (S > 1e-4 * float(S[np.isfinite(S)].max(initial=0.0)))
        order = np.argsort(S[known])[::-1]
        S, n = S[known][order], np.cumsum(cycles.count[known][order])
        if len(S):
            ax.step(
                np.append(min(0.5, n[0]), n),
                np.append(S, S[-1]) / 1e6,
                where="post",
                color=INK,
                label="cycles of this amplitude or more",
            )
    end = max([1e9, *(10.0 * c.N_D for c in curves)])
    N = np.geomspace(1e2 if not len(S) else 1.0, end, 400)
    for k, curve in enumerate(curves):
        levels = curve.amplitude(N)
        name = curve.name or f"k = {curve.k:g}"
        label = f"{name}, {100 * curve.survival:.4g} %"
        ax.plot(N, levels / 1e6, color=COLORS[k % len(COLORS)], label=label)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlabel("cycles")
    ax.set_ylabel("stress amplitude (MPa)")
    ax.legend(loc="upper right")


def _matrix(figure: Picture, ax: Axes, cycles: Cycles, bins: int) -> None:
    matrix = cycles.matrix(bins)
    _title(ax, "rainflow matrix")
    counts = np.ma.masked_equal(matrix.counts.T, 0.0)
    mesh = ax.pcolormesh(
        matrix.x / 1e6,
        matrix.y / 1e6,
        counts,
        cmap=STRESS_COLORS,
        norm=LogNorm(max(float(counts.min()), 1e-3), max(float(counts.max()), 1.0)),
    )
    ax.set_xlabel("range (MPa)")
    ax.set_ylabel("mean (MPa)")
    bar = figure.colorbar(mesh, ax=ax, pad=0.02)
    bar.outline.set_visible(False)
    bar.set_label("cycles", color=MUTED)


def _levels(ax: Axes, cycles: Cycles) -> None:
    levels, count = cycles.levels(200)
    if not len(levels):  # duty cycles have levels only per event
        _title(ax, "ranges")
        amplitude, number = cycles.exceedance()
        ax.step(np.append(number[:1], number), 2e-6 * np.append(amplitude, 0.0), color=COLORS[0])
        ax.set_xscale("log")
        ax.set_xlabel("cycles of this range or more")
        ax.set_ylabel("range (MPa)")
        return
    _title(ax, "level crossings")
    many = count.max() > 20
    ax.step(np.maximum(count, 0.5) if many else count, levels / 1e6, where="mid", color=COLORS[0])
    ax.set_xscale("log" if many else "linear")
    ax.set_xlabel("crossings upwards")
    ax.set_ylabel("stress (MPa)")


@drawing
def plot_hysteresis(
    material: StrainLife,
    series: ArrayLike,
    *,
    rule: Rule = "neuber",
) -> Picture:
    """Draw the hysteresis of local stress over local strain at a notch, first 80 reversals.

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
        For an invalid history or rule, an unknown suffix or an unwritable path.
    """
    from jousto.fatigue.local.strain_life import local_path

    whole = local_path(series, material, rule=rule)
    S = whole.elastic[:MOST]
    e, s = [0.0], [0.0]
    for k, end in enumerate(S):
        start = S[k - 1] if k else 0.0
        # path of a branch: local_path of the series that turns at each point of the branch
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
        Result of `random_response`.
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
