"""The command that compares a machine with and without the friction of its joints."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from jousto.base.errors import InputError, Problem, suggest
from jousto.base.names import file_name
from jousto.cli.group import command
from jousto.cli.options import Output, Trust, amount, compile_model, end_time, tell_files
from jousto.cli.terminal import say

if TYPE_CHECKING:
    from jousto.simulation.results.solution import Solution


@command()
def friction(
    source: Annotated[
        Path, typer.Argument(metavar="MODEL|RESULT", help="Model file, or results with friction.")
    ],
    other: Annotated[
        Path | None, typer.Argument(metavar="[RESULT]", help="Results without friction.")
    ] = None,
    body: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="Flexible bodies; all if not given.")
    ] = None,
    start: Annotated[
        float | None, typer.Option("--from", metavar="TIME", help="First instant, s.")
    ] = None,
    end: Annotated[
        float | None, typer.Option("--to", metavar="TIME", help="Last instant, s.")
    ] = None,
    window: Annotated[
        float | None,
        typer.Option(metavar="TIME", help="Longest search after a stick-slip transition, s."),
    ] = None,
    t_end: Annotated[
        str | None, typer.Option("--t-end", metavar="TIME", help="End of the runs of a model.")
    ] = None,
    csv: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Places and transitions.")
    ] = None,
    output: Output = None,
    trust: Trust = False,
) -> None:
    """Print the stress due to friction, and its peaks at stick-slip transitions.

    For a model file both runs are simulated and stored: MODEL.friction.h5 and
    MODEL.frictionless.h5.
    """
    from jousto.recovery.friction import friction_stress
    from jousto.schema.file.document import is_hdf5
    from jousto.simulation.results.solution import load

    if is_hdf5(source):
        if other is None:
            raise InputError(
                Problem(
                    str(source),
                    "is a results file; give that of the run without friction as well, or the model"
                    " file alone",
                )
            )
        pair = load(source), load(other)
    elif other is not None:
        raise InputError(
            Problem(
                str(source),
                "is a model file, from which both runs are computed; leave the second file out",
            )
        )
    else:
        pair = both_runs(source, t_end, trust, body)
    names = _names(source, body, [shape.name for shape in pair[0].bodies if shape.n])
    for name in names:
        found = friction_stress(*pair, name, start=start, end=end, window=window)
        say(str(found))
        table, picture = (_path_of_body(path, name, len(names)) for path in (csv, output))
        tell_files(found, csv=table, picture=picture)


def _names(source: Path, asked: list[str] | None, flexible: list[str]) -> list[str]:
    """Return the names of the bodies to compare; raise an error for a body that is not flexible."""
    names = asked or flexible
    unknown = [name for name in names if name not in flexible]
    if unknown or not names:
        text = "no flexible body" if not flexible else f"no flexible body {unknown[0]!r}"
        raise InputError(
            Problem(str(source), f"{text}{suggest(unknown[0], flexible) if unknown else ''}")
        )
    return names


def _path_of_body(path: Path | None, name: str, count: int) -> Path | None:
    """Return the output path of one body: with its name if there are several bodies."""
    if path is None:
        return None
    return path if count == 1 else path.with_name(f"{path.stem}-{file_name(name)}{path.suffix}")


def both_runs(
    source: Path, t_end: str | None, trust: bool, asked: list[str] | None = None
) -> tuple[Solution, Solution]:
    """Simulate a model with and without friction and return both results.

    The names `asked` for are checked before the simulation.
    """
    from jousto.recovery.friction import without_friction
    from jousto.schema.output_paths import RESULTS, output_path
    from jousto.schema.read import read_model
    from jousto.simulation.running.simulate import simulate

    file = read_model(source, trust=trust, progress=sys.stderr.isatty())
    settings = file.simulation
    end = amount(t_end, "s", "--t-end") or end_time(file, source)
    smooth = without_friction(file.mechanism)
    rubbed = compile_model(file.mechanism)
    _names(source, asked, [shape.name for shape in rubbed.bodies if shape.n])
    runs = []
    for kind in ("friction", "frictionless"):
        compiled = rubbed if kind == "friction" else compile_model(smooth)
        target = output_path(None, source, f".{kind}.h5", kind=RESULTS)
        given = settings.given(compiled) if settings is not None else {}
        runs.append(
            simulate(
                compiled,
                end,
                path=target,
                progress=sys.stderr.isatty(),
                model_text=file.text,
                **given,
            )
        )
        say(f"results in {target}", style="green")
    return runs[0], runs[1]
