"""Stress with and without friction, and what happens at stick and slip."""

from __future__ import annotations

from jousto.output.style import COLORS, MUTED, Picture, drawing
from jousto.recovery.friction import FrictionStress

SIZE = (9.5, 5.4)  # inch


@drawing
def plot_friction_stress(found: FrictionStress, *, site: str | None = None) -> Picture:
    """Draw von Mises stress with and without friction at a place, and that of their difference.

    Parameters
    ----------
    found : FrictionStress
        From `friction_stress`.
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
