"""Identification as one HTML page without network or script."""

from __future__ import annotations

import html
from pathlib import Path

from jousto.base.arguments import explained_as
from jousto.design.identification.identified import Identified
from jousto.output.figures.identification import over_time, plot_correlation, plot_identified
from jousto.output.pages.html_page import badge, document, image_address, number_table, write_page


@explained_as("write")
def write_identified(found: Identified, path: str | Path) -> Path:
    """Write an identification as a self-contained HTML page.

    Parameters
    ----------
    found : Identified
        Result of `identify`.
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


def page(found: Identified) -> str:
    """Return the HTML text of an identification."""
    status = "warn" if found.troubled or found.certainty.unseen else "ok"
    word = {"ok": "agrees", "warn": "read the remarks"}[status]
    verdict = f'<p class="verdict">{badge(status, word)} {html.escape(found.summary)}</p>\n'
    head, *rows = found.table
    parts = [verdict, number_table(head, rows)]
    for title, lines in (("What is not sure", found.doubts), ("Remarks", list(found.notes))):
        if lines:
            items = "".join(f"<li>{html.escape(line)}</li>" for line in lines)
            parts.append(f"<h2>{title}</h2><ul>{items}</ul>\n")
    for title, table in found.channel_tables:
        parts.append(f"<h2>{html.escape(title)}</h2>{number_table(table[0], table[1:])}\n")
    if over_time(found):
        parts.append(_image("measured and fitted channels", image_address(plot_identified(found))))
    if len(found.names) > 1:
        parts.append(_image("correlation of the values", image_address(plot_correlation(found))))
    return document("Identification", "Identification", "".join(parts))


def _image(text: str, address: str) -> str:
    return f'<p><img alt="{html.escape(text)}" src="{address}"></p>\n'
