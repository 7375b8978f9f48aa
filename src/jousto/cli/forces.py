"""The command that shows the forces and moments along exact beams: forces."""

from __future__ import annotations

from typing import Annotated

import typer

from jousto.base.errors import InputError, Problem
from jousto.cli.group import command
from jousto.cli.options import From, Output, Result, To, instant, only_one
from jousto.cli.terminal import say


@command()
def forces(
    result: Result,
    beam: Annotated[
        str | None, typer.Argument(metavar="[BEAM]", help="Exact beam; may be left out.")
    ] = None,
    at: Annotated[
        list[str] | None, typer.Option("--at", metavar="TIME", help="An instant, '0.5 s'; again.")
    ] = None,
    start: From = None,
    end: To = None,
    output: Output = None,
) -> None:
    """Show the forces and moments along an exact beam: the smallest and largest, where and when.

    With --at at these instants alone, else over the run or from --from to --to.

    -o writes the envelope or the instant --at as .csv, diagrams at the instants --at as .png,
    .svg, .pdf, .jpg, .jpeg, .webp or .eps, the swept surface with its stress as .vtu, and all
    instants as .pvd.
    """
    from jousto.output.style import PICTURES, target
    from jousto.recovery.beams.forces import section_forces
    from jousto.simulation.results.solution import load

    moments = [float(instant(text, "--at") or 0.0) for text in at or ()]
    suffix = ""
    if output is not None:
        suffix = target(output, ("csv", "vtu", "pvd", *PICTURES)).suffix.lower()
        if suffix == ".csv" and len(moments) > 1:
            raise InputError(Problem("--at", f"a table has one instant, not {len(moments)}"))
    run = load(result)
    names = [shape.name for shape in run.beams]
    name = beam or only_one(names, run.where, "beams", "this run has no beams")
    found_forces = section_forces(
        run, name, start=instant(start, "--from"), end=instant(end, "--to")
    )
    # what is shown is what was asked for; an instant outside the run is refused
    say(str(section_forces(run, name, times=sorted(moments)) if moments else found_forces))
    if output is None:
        return
    if suffix == ".csv":
        path = found_forces.to_csv(output, *moments)
    elif suffix in (".vtu", ".pvd"):
        from jousto.output.write import write

        path = write(run, output, beam=name, times=moments or None)
    else:
        from jousto.output.plot import plot

        path = output
        plot(found_forces, times=moments or None, path=output)
    say(f"written to {path}", style="green")
