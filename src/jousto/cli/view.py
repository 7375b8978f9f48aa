"""Command ``view``: results, models and parts on a page in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from jousto.base.errors import InputError, Problem
from jousto.cli.group import command
from jousto.cli.options import Output, Trust
from jousto.cli.terminal import say, until_ctrl_c

if TYPE_CHECKING:
    from jousto.fatigue.miner.damage_field import DamageField


@command()
def view(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="Results, model, part or mesh; more to compare."),
    ],
    output: Output = None,
    no_open: Annotated[
        bool, typer.Option("--no-open", help="Print the address and leave the browser alone.")
    ] = False,
    port: Annotated[
        int, typer.Option("--port", min=0, max=65535, help="Where it listens; 0 for any free port.")
    ] = 0,
    frames: Annotated[
        int, typer.Option("--frames", min=2, help="Instants of each run in the page of -o.")
    ] = 400,
    modes: Annotated[
        bool, typer.Option("--modes", help="Modes of vibration of the model at rest.")
    ] = False,
    damage: Annotated[
        bool, typer.Option("--damage", help="Damage by the checks of the model, in colours.")
    ] = False,
    sn: Annotated[
        str | None,
        typer.Option("--sn", metavar="CURVE", help="Damage of all bodies by this S-N curve."),
    ] = None,
    residue: Annotated[
        str | None,
        typer.Option("--residue", metavar="half|repeat|ignore", help="Cycles that stay open."),
    ] = None,
    trust: Trust = False,
) -> None:
    """Show results, a model, a reduced part or a mesh in the browser, until Ctrl-C.

    The page rotates, plays, colours and plots; press ? on it for its keys. A server on this
    computer provides it; the printed address contains a random token.

    With -o FILE.html the whole page goes into one file, which needs no jousto and no network.
    """
    from jousto.viewer.file_watch import unfinished_note
    from jousto.viewer.server import Server
    from jousto.viewer.standalone import write_page
    from jousto.viewer.view import answers_of

    fields: list[DamageField] = []
    if damage or sn is not None:
        fields = damage_of(files[0], sn, residue)
    answers = answers_of(files, frames=frames, damage=fields, modes=modes, trust=trust)
    for scene in answers.scenes:
        if note := unfinished_note(scene.run):
            say(note, error=True, style="yellow")
    if output is not None:
        if any(output.exists() and output.samefile(file) for file in files):
            raise InputError(Problem(str(output), "is the input, it would be overwritten"))
        write_page(answers.scenes, output, frames=frames, titles=answers.titles)
        size = output.stat().st_size / 1e6
        say(f"page in {output}, {size:.1f} MB{thinning(answers.scenes, frames)}", style="green")
        return
    until_ctrl_c(Server(answers, port), opens=not no_open)


def thinning(scenes: tuple[object, ...], frames: int) -> str:
    """Return the note on instants that the page leaves out; empty if it contains all."""
    from jousto.simulation.results.events import ordinal

    counts = [len(motion.times) for x in scenes if (motion := getattr(x, "motion", None))]
    most = max(counts, default=0)
    if most <= frames:
        return ""
    every = -(-most // frames)
    return f"; every {ordinal(every)} of {most} instants is in it, --frames {most} takes all"


def damage_of(path: Path, sn: str | None, residue: str | None) -> list[DamageField]:
    """Return the damage of the bodies of a run by the checks of its model or by an S-N curve."""
    from jousto.cli.fatigue import check_fields
    from jousto.viewer.viewable import read

    run = read(path)
    if type(run).__name__ != "Solution":
        raise InputError(
            Problem(str(path), "has no damage: damage is counted from the stress of a run")
        )
    return check_fields(run, sn, residue)
