"""Reliability pictures: importance, convergence of samples, linearisation error, design."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from jousto.design.reliability.form import FormResult
from jousto.design.reliability.sampling import LinearisationCheck, SamplingResult
from jousto.design.reliability.targets.rbdo import RbdoResult
from jousto.output.style import COLORS, MUTED, PAPER, Picture, blend, drawing

SIZE = (8.0, 3.4)  # width and height, inch
MOST = 12  # number of variables shown, most important first
CAP = 3.0  # multiple of the largest target at which bars are cut
BAND = 1.96  # half width of a 95 % interval, standard deviations


@drawing
def plot_form(data: FormResult) -> Picture:
    """Draw importance factors and sensitivities of a reliability index.

    Parameters
    ----------
    data : FormResult
        Result of `form`.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path.
    """
    figure = Picture(figsize=SIZE, layout="constrained")
    share = data.importance
    names = sorted(share, key=lambda name: -share[name])[:MOST]
    spread = {one.name: one.deviation for one in data.variables.randoms}
    axes = figure.subplots(1, 2 if spread else 1, sharey=True, squeeze=False)
    left, *rest = axes[0].tolist()
    y = np.arange(len(names))
    left.barh(y, [share[name] for name in names], color=COLORS[0], height=0.6)
    left.set_yticks(y, names)
    left.invert_yaxis()
    left.set_xlabel("importance")
    left.set_xlim(0.0, 1.0)
    figure.suptitle(
        f"{data.name}: beta = {data.beta:.4g}, Pf = {data.probability:.3g}", fontsize=10
    )
    for ax in rest:
        moments = ((data.by_mean, "mean", -0.18), (data.by_deviation, "deviation", 0.18))
        for k, (slope, label, shift) in enumerate(moments):
            values = [slope[name] * spread[name] for name in names]
            ax.barh(y + shift, values, color=COLORS[k], height=0.32, label=label)
        ax.axvline(0.0, color=MUTED, linewidth=0.6)
        ax.margins(x=0.06)
        ax.set_xlabel("change of beta, by a deviation more of")
        ax.legend(loc="best")
    return figure


@drawing
def plot_sampling(data: SamplingResult) -> Picture:
    """Draw the convergence of a sampled probability, or the levels of a subset simulation.

    Parameters
    ----------
    data : SamplingResult
        Result of `monte_carlo`, `importance_sampling` or `subset_simulation`.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path.
    """
    figure = Picture(figsize=(6.4, 3.6), layout="constrained")
    ax = figure.subplots()
    samples, values, third = data.history.T
    if data.method == "subset simulation":
        reached = np.cumprod(third)
        ax.semilogy(values, reached, "o-", color=COLORS[0])
        ax.axvline(0.0, color=MUTED, linewidth=0.6)
        ax.invert_xaxis()
        ax.set_xlabel(f"threshold of {data.name}")
        ax.set_ylabel("probability to be below")
        return figure
    known = np.isfinite(third)
    wide = BAND * values * np.where(known, third, 0.0)
    low, high = values - wide, values + wide
    band = blend(COLORS[0], 0.25)
    ax.fill_between(samples[known], np.maximum(low, 0.0)[known], high[known], color=band)
    ax.plot(samples, values, "o-", color=COLORS[0], markersize=3)
    ax.set_xlabel("samples")
    ax.set_ylabel(f"probability of failure, {data.name}")
    return figure


@drawing
def plot_linearisation(data: LinearisationCheck) -> Picture:
    """Draw FORM indices and sampled indices with their confidence intervals.

    Parameters
    ----------
    data : LinearisationCheck
        Result of `check_linearisation`.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path.
    """
    figure = Picture(figsize=(6.4, 0.9 + 0.45 * len(data.names)), layout="constrained")
    ax = figure.subplots()
    y = np.arange(len(data.names))
    ends = np.abs(np.stack([data.sampled - data.low, data.high - data.sampled]))
    ends = np.where(np.isfinite(ends), ends, 0.0)
    known = np.isfinite(data.sampled)
    ax.errorbar(
        data.sampled[known],
        y[known],
        xerr=ends[:, known],
        fmt="o",
        color=COLORS[0],
        capsize=3,
        label="sampled",
    )
    ax.plot(data.form, y, "D", color=COLORS[1], label="FORM", linestyle="none")
    ax.set_yticks(y, data.names)
    ax.set_ylim(len(y) - 0.5, -0.5)
    ax.margins(x=0.08)
    ax.set_xlabel("reliability index")
    ax.legend(loc="best")
    return figure


@drawing
def plot_rbdo(data: RbdoResult) -> Picture:
    """Draw the cost over the cycles of a design, and its indices with their targets.

    Parameters
    ----------
    data : RbdoResult
        Result of `rbdo`.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path.
    """
    figure = Picture(figsize=SIZE, layout="constrained")
    left, right = figure.subplots(1, 2)
    cycles = np.arange(len(data.history))
    left.plot(cycles, data.history[:, 0], "o-", color=COLORS[0])
    left.set_xlabel("cycle")
    left.set_ylabel("cost")
    left.set_xticks(cycles if len(cycles) < 12 else cycles[:: len(cycles) // 6])
    left.margins(x=0.05)
    _indices(right, data)
    return figure


def _indices(ax: Axes, data: RbdoResult) -> None:
    names = list(data.betas)
    cap = CAP * max(data.target.values())
    y = np.arange(len(names))
    for k, name in enumerate(names):
        beta = data.betas[name]
        color = COLORS[1] if name in data.active else COLORS[0]
        ax.barh(k, min(beta, cap), color=color, height=0.6)
        if beta > cap:
            text = "> " if np.isinf(beta) else f"{beta:.3g} "
            ax.annotate(text, (cap, k), ha="right", va="center", color=PAPER)
        ax.plot([data.target[name]] * 2, [k - 0.4, k + 0.4], color=MUTED)
    ax.set_yticks(y, names)
    ax.set_ylim(len(y) - 0.5, -0.5)
    ax.set_xlabel("reliability index, target as a line")
