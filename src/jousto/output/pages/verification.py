"""The comparison of two formulations as one HTML page: no network, no script."""

from __future__ import annotations

import html
from pathlib import Path

from jousto.base.arguments import explained_as
from jousto.base.files import written
from jousto.base.version import __version__
from jousto.natural.verification import COLUMNS, Verification
from jousto.output.pages.certificate import COLOUR, CSS
from jousto.output.style import target

STATUS = {"agree": "ok", "undecided": "warn", "disagree": "fail"}
BOLD = ' style="font-weight:600"'


@explained_as("write")
def write_verification(verification: Verification, path: str | Path) -> Path:
    """Write a verification as an HTML page that stands for itself.

    Parameters
    ----------
    verification : Verification
        From `verify`.
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
        beside.write_text(page(verification), encoding="utf-8")
    return path


def page(found: Verification) -> str:
    """Return the HTML text of a verification."""
    name, badge = html.escape(found.name), found.word
    head = "".join(f"<th>{html.escape(column)}</th>" for column in COLUMNS)
    wrong = {row.name for row in found.different}
    rows = "".join(
        f"<tr{BOLD if line[0] in wrong else ''}>"
        f"{''.join(f'<td>{html.escape(cell)}</td>' for cell in line)}</tr>\n"
        for line in found.table
    )
    facts = "".join(
        f'<tr><td class="name">{html.escape(key)}</td><td>{html.escape(value)}</td></tr>'
        for key, value in found.facts
    )
    title = "Two methods of the engine" if found.unknown else "Two formulations"
    of = "two methods of the engine" if found.unknown else "engine and moving frame"
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{title} of {name}</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><style>{CSS}</style>
</head><body>
<h1>{title} of &lsquo;{name}&rsquo;</h1>
<p class="verdict"><span class="badge" style="background:{COLOUR[STATUS[badge]]}">{badge}</span>
{html.escape(found.verdict)}</p>
<table>{facts}</table>
<h2>Largest differences of {of}, as shares of the size</h2>
<div class="scroll"><table class="numbers"><tr>{head}</tr>
{rows}</table></div>
<footer>Written by jousto {html.escape(__version__)}.</footer>
</body></html>
"""
