"""Commands on parts: reduce, export, advise, and the output of certificates."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, Problem
from jousto.base.names import file_name
from jousto.cli.group import command
from jousto.cli.options import Output, PartName, PartPath, Solver, amount
from jousto.cli.terminal import FAILED, facts, say

if TYPE_CHECKING:
    from jousto.parts.part import Part
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


@command()
def advise(
    part: PartPath,
    name: PartName = None,
    frequency_limit: Annotated[
        str | None,
        typer.Option("--frequency-limit", metavar="HZ", help="Highest frequency that matters."),
    ] = None,
    load: Annotated[
        list[str] | None,
        typer.Option(
            "--load", metavar="NODES.fx", help="Unit force or moment to be met: tip.fz, node3.mx."
        ),
    ] = None,
    accuracy: Annotated[
        float, typer.Option("--accuracy", metavar="SHARE", help="Largest relative error.")
    ] = 0.01,
    solver: Solver = None,
) -> None:
    """Propose the modes of a part for a frequency limit or for loads, with the gain of each mode.

    The interfaces are those of the part's `reduce` entry; without --frequency-limit and --load its
    frequency_limit applies.
    """
    from jousto.certificate.advice import advise as propose
    from jousto.reduction.methods import CraigBampton
    from jousto.schema.read import read_part_file

    file = read_part_file(part, name, reduce=False)
    if file.part is None:
        message = "was reduced before: advice needs the part with its mesh"
        raise InputError(Problem(f"part '{file.name}'", message))
    limit = amount(frequency_limit, "Hz", "--frequency-limit")
    interfaces = file.method.interfaces if isinstance(file.method, CraigBampton) else ()
    loads: dict[str, Any] = {}
    for text in load or ():
        pattern = _load(file.part, text)
        if pattern is None:
            place = text.rpartition(".")[0]
            say(f"--load {text}: '{place}' is an interface, its static loads are exact anyway")
        else:
            loads[text] = pattern
    if limit is None and not loads:
        limit = file.method.frequency_limit
    advice = propose(
        file.part,
        interfaces,
        frequency_limit=limit,
        loads=loads or None,
        accuracy=accuracy,
        solver=solver,
        progress=sys.stderr.isatty(),
    )
    text = str(advice)
    residuals = getattr(advice.method, "residuals", ())
    if residuals and all(".f" in load[-3:] for load in loads):
        # residual loads as entries of a model file, where loads at nodes are forces without moments
        entries = ", ".join(_entry(load) for load in loads)
        text = text.replace(f"residuals={residuals}", f"residuals: [{entries}]")
    for line in text.splitlines():
        say(line, style="green" if line.startswith("take ") else "")


def _entry(text: str) -> str:
    """Return the residual load `tip.fz` as an entry of a model file."""
    place, _, kind = text.rpartition(".")
    along = ", ".join("1" if kind[1] == axis else "0" for axis in "xyz")
    return f"{{force: [{along}], nodes: {place}}}"


def _load(part: Part, text: str) -> Any:
    """Return the nodal loads of a unit force or moment on a set; None for an interface."""
    import numpy as np

    from jousto.base.errors import suggest

    kinds = ("fx", "fy", "fz", "mx", "my", "mz")[: part.dofs_per_node]
    place, _, kind = text.rpartition(".")
    if kind not in kinds or not place:
        known = ", ".join(kinds)
        message = f"is {text!r}, must be a node set and one of {known}, such as tip.{kinds[0]}"
        raise InputError(Problem("--load", message))
    if any(tie.name == place for tie in part.ties):
        return None
    if place not in part.node_sets:
        message = f"no node set '{place}'{suggest(place, part.node_sets)}"
        raise InputError(Problem("--load", message))
    nodes = np.array(part.node_sets[place])
    f = np.zeros((len(part.nodes), part.dofs_per_node))
    f[nodes, kinds.index(kind)] = 1.0 / len(nodes)
    return f.ravel()
