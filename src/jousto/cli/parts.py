"""Commands on parts: reduce, and the output of certificates."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, Problem
from jousto.base.names import file_name
from jousto.cli.group import command
from jousto.cli.options import Output, PartName, PartPath, Solver
from jousto.cli.terminal import FAILED, facts, say

if TYPE_CHECKING:
    from jousto.reduction.reduced import ReducedPart
    from jousto.schema.read import PartFile


Html = Annotated[
    Path | None,
    typer.Option("--html", metavar="FILE", help="Write the certificate as a page, too."),
]
STYLES = {"ok": "green", "note": "", "warn": "yellow", "fail": "red"}


@command("reduce")
def reduce_part(
    part: PartPath,
    name: PartName = None,
    output: Output = None,
    html: Html = None,
    bare: Annotated[
        bool, typer.Option("--no-certificate", help="Omit the comparison with the full model.")
    ] = False,
    strict: Annotated[
        bool, typer.Option("--strict", help="End with code 1 if the certificate has a fault.")
    ] = False,
    solver: Solver = None,
    cache: Annotated[
        bool | None,
        typer.Option(
            "--cache/--no-cache",
            help="Keep the result, and the stages of a run that is killed, for the next time; "
            "if neither is given, of parts that take long.",
        ),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")] = False,
) -> None:
    """Reduce a part to modes, into NAME.h5 next to the file unless -o names another file.

    A reduction that was killed continues after its last finished stage when it is started again.

    At the end the command prints the certificate: mass properties, checks of the part, and accuracy
    of its modes against the full model.
    """
    from jousto.schema.output_paths import REDUCED_PART, output_path
    from jousto.schema.read import read_part_file

    if strict and bare:
        raise InputError(Problem("--strict", "needs the certificate; leave out --no-certificate"))
    # check the output path before the long reduction
    if output is not None:
        output_path(output, part, ".h5", kind=REDUCED_PART)
    page = page_path(html, part)
    options: dict[str, Any] = {"solver": solver, "cache": cache}
    options = {key: value for key, value in options.items() if value is not None}
    progress = sys.stderr.isatty() and not quiet
    if progress:
        options["progress"] = True
    file = read_part_file(part, name, **options)
    reduced = file.reduced
    target = output_path(output, part, f"{file_name(reduced.name)}.h5", kind=REDUCED_PART)
    reduced.save(target)
    describe_part(reduced)
    passed = bare or tell_certificate(file, page, solver=solver, progress=progress)
    say(f"reduced part in {target}", style="green")
    if strict and not passed:
        raise typer.Exit(FAILED)


def describe_part(part: ReducedPart) -> None:
    """Print the content of a reduced part."""
    from jousto.schema.summary import part_facts

    facts(part_facts(part), f"reduced part {part.name}")


def describe_content(part: ReducedPart) -> None:
    """Print the mass integrals and the modes of a reduced part."""
    from jousto.schema.summary import content_facts

    facts(content_facts(part), "mass integrals and modes")


def page_path(given: Path | None, source: Path) -> Path | None:
    """Return the path of the certificate's page, checked before the computation."""
    if given is None:
        return None
    from jousto.schema.output_paths import output_path

    if given.suffix.lower() not in (".html", ".htm"):
        raise InputError(Problem(str(given), "must end with .html; print it to PDF in a browser"))
    return output_path(given, source, ".html")


def tell_certificate(
    file: PartFile, page: Path | None, *, solver: str | None = None, progress: bool = False
) -> bool:
    """Print a part's certificate and modes, write its page, and return whether it passed."""
    if file.part is None:
        say("no certificate: the part was reduced before, its mesh is not in the file")
        return True
    from jousto.certificate.certify import certify

    certificate = certify(file.part, file.reduced, solver=solver, progress=progress)
    for line in str(certificate).splitlines():
        word = line.split()[0] if line.startswith("  ") and line.split() else ""
        say(line, style=STYLES.get(word, ""))
    if page is not None:
        from jousto.output.write import write

        write(certificate, page)
        say(f"certificate in {page}", style="green")
    return certificate.passed
