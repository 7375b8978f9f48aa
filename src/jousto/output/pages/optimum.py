"""An optimisation as one HTML page, by one method or by several: no network, no script."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

from jousto.base.arguments import explained_as
from jousto.base.files import written
from jousto.base.version import __version__
from jousto.design.optimisation.comparison import Comparison
from jousto.design.optimisation.optimum import Optimum
from jousto.output.figures.optimisation import plot_comparison, plot_optimum
from jousto.output.pages.certificate import COLOUR, CSS
from jousto.output.style import Picture, styled, target


@explained_as("write")
def write_optimum(found: Optimum | Comparison, path: str | Path) -> Path:
    """Write an optimum, or several methods side by side, as an HTML page that stands for itself.

    Parameters
    ----------
    found : Optimum or Comparison
        From `optimise`.
    path : str or Path
        File that ends in ``.html``.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        Another ending, a folder that does not exist, or a file that cannot be written.
    """
    path = target(path, ("html", "htm"), hint="; print it to PDF in a browser")
    with written(path) as beside:
        beside.write_text(page(found), encoding="utf-8")
    return path


def page(found: Optimum | Comparison) -> str:
    """Return the HTML text of an optimisation."""
    whole = found if isinstance(found, Comparison) else Comparison([found])
    optima = list(whole.optima)
    figure = plot_comparison(whole) if len(optima) > 1 else plot_optimum(optima[0])
    head, *rows = whole.table
    verdicts = "".join(
        f'<p class="verdict">{_badge(one)} {html.escape(f"{one.method}: {one.message}")}</p>\n'
        for one in optima
    )
    details = "".join(_details(one) for one in optima)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>Optimisation</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><style>{CSS}</style>
</head><body>
<h1>Optimisation</h1>
{verdicts}{_table(head, rows)}
<p><img alt="cost, largest ratio and parameters" src="{_address(figure)}"></p>
{details}<footer>Written by jousto {html.escape(__version__)}.</footer>
</body></html>
"""


def _badge(one: Optimum) -> str:
    status = "ok" if one.converged else "warn" if one.kept else "fail"
    word = {"ok": "converged", "warn": "not converged", "fail": "limit exceeded"}[status]
    return f'<span class="badge" style="background:{COLOUR[status]}">{word}</span>'


def _details(one: Optimum) -> str:
    """Return what bounds a design, and its cycles."""
    active = [(str(place), f"{multiplier:.4g}") for place, multiplier in one.active]
    rows = [
        (str(i), *(f"{v:.5g}" for v in c.values.values()), f"{c.cost:.6g}", f"{c.ratio:.4f}")
        + (f"{c.loads:.1e}", f"{c.step:.1e}", str(c.runs))
        for i, c in enumerate(one.history)
    ]
    head = ("cycle", *one.values, "cost", "largest ratio", "change of loads", "step", "runs")
    bounds = _table(("active limit", "multiplier"), active) if active else "<p>None.</p>"
    name = html.escape(one.method)
    return (
        f"<h2>{name}: what bounds the design</h2>\n{bounds}<h2>{name}: cycles</h2>\n"
        f"{_table(head, rows)}"
    )


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    first = "".join(f"<th>{html.escape(cell)}</th>" for cell in head)
    more = "".join(
        f"<tr>{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>\n" for row in rows
    )
    return f'<div class="scroll"><table class="numbers"><tr>{first}</tr>\n{more}</table></div>\n'


def _address(figure: Picture) -> str:
    """Return a picture as a data address."""
    data = io.BytesIO()
    with styled():
        figure.savefig(data, format="png", dpi=150)
    return "data:image/png;base64," + base64.b64encode(data.getvalue()).decode()
