"""What commands say of a part: its certificate, in the terminal and as a page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from jousto.cli.terminal import say
from jousto.errors import InputError, Problem

if TYPE_CHECKING:
    from jousto.schema import PartFile

Html = Annotated[
    Path | None,
    typer.Option("--html", metavar="FILE", help="Write the certificate as a page, too."),
]

STYLES = {"ok": "green", "note": "", "warn": "yellow", "fail": "red"}


def page_path(given: Path | None, source: Path) -> Path | None:
    """Return where the page goes, checked before anything is computed."""
    if given is None:
        return None
    from jousto.schema.targets import output_path

    if given.suffix.lower() not in (".html", ".htm"):
        raise InputError(Problem(str(given), "must end with .html; print it to PDF in a browser"))
    return output_path(given, source, ".html")


def tell_certificate(file: PartFile, page: Path | None) -> None:
    """Print the certificate of a part and its modes, and write its page."""
    if file.part is None:
        say("no certificate: the part was reduced before, its mesh is not in the file")
        return
    from jousto.reduction import certify

    certificate = certify(file.part, file.reduced)
    for line in str(certificate).splitlines():
        word = line.split()[0] if line.startswith("  ") and line.split() else ""
        say(line, style=STYLES.get(word, ""))
    if page is not None:
        from jousto.output import write_certificate

        write_certificate(certificate, page)
        say(f"certificate in {page}", style="green")
