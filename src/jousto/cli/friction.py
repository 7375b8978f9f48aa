"""The command that compares a machine with and without the friction of its joints."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from jousto.base.errors import InputError, Problem, suggest
from jousto.base.names import file_name
from jousto.cli.group import offer
from jousto.cli.options import Debug, Output, Trust, compile_model, end_time
from jousto.cli.terminal import command, say

if TYPE_CHECKING:
    from jousto.simulation.results.solution import Solution


@offer()
@command
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
    debug: Debug = False,
) -> None:
    """Say which stress is due to friction, and its peaks where joints stick and slip.

    Of a model both runs are made and kept, MODEL.friction.h5 and MODEL.frictionless.h5.
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
            Problem(str(source), "is a model file, of which both runs are made; give it alone")
        )
    else:
        pair = both_runs(source, t_end, trust, body)
    names = _names(source, body, [shape.name for shape in pair[0].bodies if shape.n])
    for name in names:
        found = friction_stress(*pair, name, start=start, end=end, window=window)
        say(str(found))
        if csv is not None:
            target = _of(csv, name, len(names))
            found.to_csv(target)
            say(f"table in {target}", style="green")
        if output is not None:
            from jousto.output.plot import plot

            target = _of(output, name, len(names))
            plot(found, path=target)
            say(f"picture in {target}", style="green")


def _names(source: Path, asked: list[str] | None, flexible: list[str]) -> list[str]:
    """Return the bodies to compare; refuse what is not a flexible one."""
    names = asked or flexible
    unknown = [name for name in names if name not in flexible]
    if unknown or not names:
        text = "no flexible body" if not flexible else f"no flexible body {unknown[0]!r}"
        raise InputError(
            Problem(str(source), f"{text}{suggest(unknown[0], flexible) if unknown else ''}")
        )
    return names


def _of(path: Path, name: str, count: int) -> Path:
    """Return the file of one body of several."""
    return path if count == 1 else path.with_name(f"{path.stem}-{file_name(name)}{path.suffix}")


def both_runs(
    source: Path, t_end: str | None, trust: bool, asked: list[str] | None = None
) -> tuple[Solution, Solution]:
    """Simulate a model with and without its friction; return the results.

    Bodies `asked` for are looked for before anything is simulated.
    """
    from jousto.recovery.friction import without_friction
    from jousto.schema.file.read import read_model
    from jousto.schema.targets import RESULTS, output_path
    from jousto.simulation.running.simulate import simulate

    file = read_model(source, trust=trust, progress=sys.stderr.isatty())
    settings = file.simulation
    if settings is None and t_end is None:
        raise InputError(Problem(source.name, "does not say how long to simulate; give --t-end"))
    end = settings.t_end if t_end is None and settings is not None else end_time(str(t_end))
    smooth = without_friction(file.mechanism)
    rubbed = compile_model(file)
    _names(source, asked, [shape.name for shape in rubbed.bodies if shape.n])
    runs = []
    for kind in ("friction", "frictionless"):
        compiled = rubbed if kind == "friction" else _compiled(smooth)
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


def _compiled(mechanism: Any) -> Any:
    from jousto.model.compile import compile

    return compile(mechanism)
