"""Comparison of two formulations as one HTML page without network or script."""

from __future__ import annotations

import html
from pathlib import Path

from jousto.base.arguments import explained_as
from jousto.natural.verification import COLUMNS, Verification
from jousto.output.pages.html_page import badge, document, facts_table, number_table, write_page

STATUS = {"agree": "ok", "undecided": "warn", "disagree": "fail"}


@explained_as("write")
def write_verification(verification: Verification, path: str | Path) -> Path:
    """Write a verification as a self-contained HTML page.

    Parameters
    ----------
    verification : Verification
        Result of `verify`.
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
    return write_page(page(verification), path)


def page(found: Verification) -> str:
    """Return the HTML text of a verification."""
    title = "Two methods of the engine" if found.unknown else "Two formulations"
    of = "two methods of the engine" if found.unknown else "engine and moving frame"
    different = [row.name for row in found.different]
    body = f"""<p class="verdict">{badge(STATUS[found.word], found.word)}
{html.escape(found.verdict)}</p>
{facts_table(found.facts)}
<h2>Largest differences of {of}, as shares of the size</h2>
{number_table(COLUMNS, found.table, bold=different)}
"""
    heading = f"{title} of &lsquo;{html.escape(found.name)}&rsquo;"
    return document(f"{title} of {found.name}", heading, body)
