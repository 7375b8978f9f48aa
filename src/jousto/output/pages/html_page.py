"""HTML pages of a certificate, a verification or an optimisation: no network, no script."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

from jousto.base.files import written
from jousto.base.version import __version__
from jousto.output.style import FAINT, INK, MUTED, PAPER, Picture, styled, target

COLOUR = {"ok": "#2A7D5F", "note": "#1C5FA8", "warn": "#A56A00", "fail": "#B3261E"}
"""Background of the badge of each status."""
BOLD = ' style="font-weight:600"'

CSS = f"""
body {{ font: 13px/1.45 system-ui, "Segoe UI", Helvetica, Arial, sans-serif; color: {INK};
       background: {PAPER}; max-width: 1080px; margin: 24px auto; padding: 0 20px; }}
h1 {{ font-size: 21px; margin: 0; }} h2 {{ font-size: 14px; margin: 20px 0 6px; }}
.verdict {{ margin: 4px 0 14px; }} .badge {{ color: {PAPER}; border-radius: 4px; padding: 1px 8px;
       font-weight: 600; white-space: nowrap; }}
.top {{ display: flex; gap: 28px; align-items: center; flex-wrap: wrap; }}
.top > * {{ flex: 1 1 380px; min-width: 0; }} img {{ max-width: 100%; height: auto; }}
table {{ border-collapse: collapse; width: 100%; }}
td, th {{ padding: 3px 10px 3px 0; text-align: left; vertical-align: top; }}
tr + tr td {{ border-top: 1px solid {FAINT}; }}
th {{ color: {MUTED}; font-weight: 500; border-bottom: 1px solid #9AA1AB; }}
.numbers td + td, .numbers th + th {{ text-align: right; font-variant-numeric: tabular-nums; }}
.numbers td {{ white-space: nowrap; }}
.name {{ color: {MUTED}; white-space: nowrap; }} .advice {{ color: {MUTED}; }}
.advice b {{ color: {INK}; font-weight: 600; }} .scroll {{ overflow-x: auto; }}
.checks td:nth-child(2) {{ white-space: nowrap; }} .checks td:nth-child(3) {{ width: 42%; }}
.tables {{ columns: 2 440px; column-gap: 32px; }} section {{ break-inside: avoid; }}
section h2 {{ padding-top: 14px; margin-top: 0; }}
.remark, footer {{ color: {MUTED}; font-size: 11.5px; }} footer {{ margin-top: 22px; }}
@media print {{ body {{ font-size: 8.6px; margin: 0; max-width: none; padding: 0; }}
       h1 {{ font-size: 15px; }} h2 {{ font-size: 10.5px; margin: 7px 0 2px; }}
       td, th {{ padding: 1px 6px 1px 0; line-height: 1.25; }} .verdict {{ margin: 2px 0 6px; }}
       .top {{ flex-wrap: nowrap; gap: 12px; }} .top > * {{ flex: 1 1 45%; }}
       img {{ max-height: 44mm; }}
       .tables {{ columns: 2 auto; column-gap: 20px; }} section h2 {{ padding-top: 6px; }}
       .remark, footer {{ font-size: 7.6px; margin: 2px 0; }} }}
"""


def write_page(text: str, path: str | Path) -> Path:
    """Write the text of an HTML page and return its path; the suffix is .html or .htm.

    Raises
    ------
    InputError
        For another ending, a folder that does not exist, or a file that cannot be written.
    """
    path = target(path, ("html", "htm"), hint="; print it to PDF in a browser")
    with written(path) as beside:
        beside.write_text(text, encoding="utf-8")
    return path


def document(title: str, heading: str, body: str) -> str:
    """Return an HTML page from its title (plain text) and the HTML of its heading and its body."""
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><style>{CSS}</style>
</head><body>
<h1>{heading}</h1>
{body}<footer>Written by jousto {html.escape(__version__)}.</footer>
</body></html>
"""


def badge(status: str, text: str) -> str:
    """Return a text on the colour of a status: ok, note, warn or fail."""
    return f'<span class="badge" style="background:{COLOUR[status]}">{html.escape(text)}</span>'


def facts_table(facts: Iterable[tuple[str, str]]) -> str:
    """Return a table of two columns from names and values."""
    rows = "".join(
        f'<tr><td class="name">{html.escape(key)}</td><td>{html.escape(value)}</td></tr>'
        for key, value in facts
    )
    return f"<table>{rows}</table>"


def number_table(
    head: Sequence[str], rows: Iterable[Sequence[str]], *, bold: Iterable[str] = ()
) -> str:
    """Return a table of numbers; rows whose first cell is in `bold` are bold."""
    first = "".join(f"<th>{html.escape(cell)}</th>" for cell in head)
    names = set(bold)
    lines = "".join(
        f"<tr{BOLD if row[0] in names else ''}>"
        f"{''.join(f'<td>{html.escape(cell)}</td>' for cell in row)}</tr>\n"
        for row in rows
    )
    return f'<div class="scroll"><table class="numbers"><tr>{first}</tr>\n{lines}</table></div>'


def image_address(figure: Picture) -> str:
    """Return a picture as the data address of an HTML image: PNG in base64."""
    data = io.BytesIO()
    with styled():
        figure.savefig(data, format="png", dpi=150)
    return "data:image/png;base64," + base64.b64encode(data.getvalue()).decode()
