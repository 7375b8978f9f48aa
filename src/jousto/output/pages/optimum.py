"""Optimisation by one or several methods as one HTML page without network or script."""

from __future__ import annotations

import html
from pathlib import Path

from jousto.base.arguments import explained_as
from jousto.design.optimisation.comparison import Comparison
from jousto.design.optimisation.optimum import Optimum
from jousto.design.optimisation.rigid_optimum import RigidOptimum
from jousto.output.figures.optimisation import plot_comparison, plot_optimum
from jousto.output.pages.html_page import badge, document, image_address, number_table, write_page


@explained_as("write")
def write_optimum(found: Optimum | Comparison, path: str | Path) -> Path:
    """Write one or several optima as a self-contained HTML page.

    Parameters
    ----------
    found : Optimum or Comparison
        Result of `optimise`.
    path : str or Path
        File that ends in ``.html``.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        For another ending, a folder that does not exist, or a file that cannot be written.
    """
    return write_page(page(found), path)


def page(found: Optimum | Comparison) -> str:
    """Return the HTML text of an optimisation."""
    whole = found if isinstance(found, Comparison) else Comparison([found])
    optima = list(whole.optima)
    figure = plot_comparison(whole) if len(optima) > 1 else plot_optimum(optima[0])
    head, *rows = whole.table
    verdicts = "".join(
        f'<p class="verdict">{_status(one)} {html.escape(f"{one.method}: {one.message}")}</p>\n'
        for one in optima
    )
    details = "".join(_details(one) for one in optima)
    body = f"""{verdicts}{number_table(head, rows)}
<p><img alt="cost, largest ratio and parameters" src="{image_address(figure)}"></p>
{details}"""
    return document("Optimisation", "Optimisation", body)


def _status(one: Optimum) -> str:
    """Return a badge: converged, not converged, or limit exceeded."""
    status = "ok" if one.converged else "warn" if one.kept else "fail"
    word = {"ok": "converged", "warn": "not converged", "fail": "limit exceeded"}[status]
    return badge(status, word)


def _details(one: Optimum) -> str:
    """Return the tables of active limits and of cycles."""
    active = [(str(place), f"{multiplier:.4g}") for place, multiplier in one.active]
    rows = [
        (str(i), *(f"{v:.5g}" for v in c.values.values()), f"{c.cost:.6g}", f"{c.ratio:.4f}")
        + (f"{c.loads:.1e}", f"{c.step:.1e}", str(c.runs))
        for i, c in enumerate(one.history)
    ]
    head = ("cycle", *one.values, "cost", "largest ratio", "change of loads", "step", "runs")
    bounds = number_table(("active limit", "multiplier"), active) if active else "<p>None.</p>"
    name = html.escape(one.method)
    peaks = _peaks(one) if isinstance(one, RigidOptimum) else ""
    return (
        f"{peaks}<h2>{name}: what bounds the design</h2>\n{bounds}\n<h2>{name}: cycles</h2>\n"
        f"{number_table(head, rows)}\n"
    )


def _peaks(one: RigidOptimum) -> str:
    """Return the verdict on the flexible machine with the table of its peaks."""
    rows = [
        (p.limit, p.value(1.0), p.value(p.own), "" if p.other is None else p.value(p.other))
        + (p.value(p.true), f"{100 * p.excess:+.2f} %")
        for p in one.peaks
    ]
    head = ("limit", "value", "part alone", "held the other way", "flexible machine", "excess")
    verdict = f"{badge('ok' if one.safe else 'fail', 'safe' if one.safe else 'unsafe')}"
    return (
        f"<h2>{html.escape(one.method)}: peaks of the flexible machine</h2>\n"
        f'<p class="verdict">{verdict} {html.escape(one.verdict)}</p>\n'
        f"{number_table(head, rows)}\n"
    )
