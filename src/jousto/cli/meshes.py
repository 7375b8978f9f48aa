"""The command on meshes and CAD files: mesh."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from jousto.base.errors import InputError, Problem
from jousto.cli.group import command
from jousto.cli.options import Output, amount
from jousto.cli.terminal import BAD_INPUT, facts, say
from jousto.mesh.formats import CAD, is_cad

if TYPE_CHECKING:
    from jousto.mesh.inspection import Finding
    from jousto.mesh.mesh import Mesh

SHOWN = 24  # rows in the list of sets or holes


@command()
def mesh(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Mesh or CAD file.")],
    output: Output = None,
    unit: Annotated[
        str | None, typer.Option("--unit", help="Unit of length in the file: m, mm, in ...")
    ] = None,
    size: Annotated[
        str | None, typer.Option("--size", metavar="LENGTH", help="Edges of a CAD file, '8 mm'.")
    ] = None,
    order: Annotated[
        int, typer.Option("--order", min=1, max=2, help="Of the tetrahedra of a CAD file.")
    ] = 2,
    straight: Annotated[
        bool, typer.Option("--straight", help="Edges of a CAD file's mesh do not follow curves.")
    ] = False,
    per_circle: Annotated[
        int, typer.Option("--per-circle", min=4, help="Elements along a full turn, CAD files.")
    ] = 12,
    refine: Annotated[
        list[str] | None,
        typer.Option("--refine", metavar="FACE=LENGTH", help="Smaller edges at a face or group."),
    ] = None,
    picture: Annotated[
        Path | None, typer.Option("--picture", metavar="FILE.png", help="Draw the mesh.")
    ] = None,
    mark: Annotated[
        list[str] | None, typer.Option("--mark", metavar="SET", help="Set to mark in the picture.")
    ] = None,
) -> None:
    """Read a mesh, or mesh a CAD file, and print its content and its faults.

    With -o the mesh is written, in m: .vtu, .vtk, .inp, .msh, .med, .bdf, .nas, .stl.
    """
    from jousto.mesh.readers.files import read_mesh

    if output is not None and output.exists() and file.exists() and output.samefile(file):
        raise InputError(Problem(str(output), "is the input, it would be overwritten"))
    if is_cad(file):
        from jousto.mesh.readers.step import mesh_cad

        if size is None:
            raise InputError(
                Problem(file.name, "a CAD file needs the length of the elements: --size '8 mm'")
            )
        found = mesh_cad(
            file,
            size=amount(size, "m", "--size"),
            order=order,
            curved=not straight,
            unit=unit,
            per_circle=per_circle,
            refine=dict(_refined(item) for item in refine or ()),
        )
    else:
        _only_cad(
            file,
            {
                "--size": size is not None,
                "--order": order != 2,
                "--straight": straight,
                "--per-circle": per_circle != 12,
                "--refine": bool(refine),
            },
        )
        _no_data(file)
        found = read_mesh(file, unit=unit or "m")
    findings = describe_mesh(found)
    if output is not None:
        from jousto.output.write import write

        say(f"mesh in {write(found, output)}", style="green")
    if picture is not None:
        from jousto.output.scenes.draw import draw

        say(f"picture in {draw(found, picture, sets=tuple(mark or ()))}", style="green")
    if any(finding.severity == "error" for finding in findings):
        raise typer.Exit(BAD_INPUT)


def _only_cad(file: Path, given: dict[str, bool]) -> None:
    """Raise an error for a mesh with options that apply to CAD files only."""
    for option in (name for name, used in given.items() if used):
        message = f"is for CAD files ({' '.join(CAD)}); {file.name} is read with its elements"
        raise InputError(Problem(option, message))


def _no_data(file: Path) -> None:
    """Raise an error if the file is a reduced part or results of jousto, not a mesh."""
    from jousto.schema.output_paths import REDUCED_PART, WORDS, hdf5_format

    kind = hdf5_format(file) if file.is_file() else ""
    if kind in WORDS:
        more = "; jousto export writes it as .vtu" if kind == REDUCED_PART else ""
        message = f"is {WORDS[kind]} of jousto, not a mesh: jousto info {file.name} shows it{more}"
        raise InputError(Problem(file.name, message))


def _refined(text: str) -> tuple[str, float]:
    name, equals, length = text.partition("=")
    if not equals or not name.strip():
        raise InputError(Problem("--refine", f"is {text!r}, must be such as 'face12=2 mm'"))
    return name.strip(), amount(length, "m", "--refine")


def describe_mesh(found: Mesh) -> tuple[Finding, ...]:
    """Print the content and the faults of a mesh, and return the faults."""
    from jousto.mesh.holes import hole_text
    from jousto.schema.summary import mesh_facts, set_text

    facts(mesh_facts(found), f"mesh {found.name}")
    holes = [
        (hole.name if hole.name.startswith("hole") else f"hole {hole.name}", hole_text(hole))
        for hole in found.holes()[:SHOWN]
    ]
    facts(holes)
    sets = list(found.node_sets.items())
    facts([(f"set {name}", set_text(found, name, nodes)) for name, nodes in sets[:SHOWN]])
    if len(sets) > SHOWN:
        say(f"  ... and {len(sets) - SHOWN} more sets")
    findings = found.check()
    for finding in findings:
        error = finding.severity == "error"
        word = "error" if error else "warning"
        say(f"{word}: {finding.message}", error=True, style="red" if error else "yellow")
    if not findings:
        say(f"{found.name}: nothing wrong found", style="green")
    return findings
