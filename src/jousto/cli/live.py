"""Command ``live``: a machine that runs on a page in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from jousto.base.errors import InputError, Problem
from jousto.cli.group import command
from jousto.cli.options import Model, Trust, amount
from jousto.cli.terminal import facts, say, until_ctrl_c

if TYPE_CHECKING:
    from jousto.simulation.live.runner import Glance


@command()
def live(
    model: Model,
    step: Annotated[
        str | None, typer.Option("--step", metavar="TIME", help="Step of the method, '1 ms'.")
    ] = None,
    rate: Annotated[
        str | None,
        typer.Option("--rate", metavar="FREQUENCY", help="Steps a second instead, '1 kHz'."),
    ] = None,
    speed: Annotated[
        float,
        typer.Option("--speed", min=0.0, help="Simulated per second; 0 is as fast as it can."),
    ] = 1.0,
    record: Annotated[
        Path | None, typer.Option("--record", metavar="FILE.h5", help="Record from the start.")
    ] = None,
    inputs: Annotated[
        list[str] | None,
        typer.Option("--input", metavar="NAME=LOW..HIGH", help="Range of an input, in SI."),
    ] = None,
    paused: Annotated[bool, typer.Option("--paused", help="Wait for the page to play.")] = False,
    urgent: Annotated[
        bool, typer.Option("--urgent", help="Go before other programs, where that is allowed.")
    ] = False,
    udp: Annotated[
        int | None,
        typer.Option(
            "--udp",
            metavar="PORT",
            min=0,
            max=65535,
            help="Take inputs and send outputs as datagrams at this port, each step.",
        ),
    ] = None,
    no_open: Annotated[
        bool, typer.Option("--no-open", help="Print the address and leave the browser alone.")
    ] = False,
    port: Annotated[
        int, typer.Option("--port", min=0, max=65535, help="Where it listens; 0 for any free port.")
    ] = 0,
    trust: Trust = False,
) -> None:
    """Run a model in real time on a page in the browser, until Ctrl-C.

    Inputs become sliders, and the mouse pulls bodies; the page can pause, step, reset, change
    parameters and record. At the end the command prints how well the machine kept real time.
    """
    from jousto.simulation.live.ranges import parse_ranges
    from jousto.viewer.live.live import live as run

    if step is not None and rate is not None:
        raise InputError(Problem("--rate", "is 1 / --step; give one of them"))
    if record is not None and record.exists() and record.samefile(model):
        raise InputError(Problem("--record", f"{record} is the model, it would be overwritten"))
    length = amount(step, "s", "--step")
    if rate is not None:
        length = 1.0 / amount(rate, "Hz", "--rate")
    machine = run(
        model,
        step=length,
        speed=speed,
        ranges=parse_ranges(inputs or []),
        record=record,
        playing=not paused,
        open=False,
        port=port,
        urgent=urgent,
        udp=udp,
        trust=trust,
    )
    if machine.runner.refused:
        say(f"no higher priority: {machine.runner.refused}", error=True, style="yellow")
    link = machine.runner.link
    if link is not None:
        say(f"frames on 127.0.0.1:{link.port}", error=True)
    until_ctrl_c(machine, opens=not no_open)
    frames = [] if link is None else [("frames", str(link.received))]
    facts([*timekeeping(machine.now), *frames])


def timekeeping(glance: Glance) -> list[tuple[str, str]]:
    """Return rows of name and value on the lateness of a machine that runs in real time."""
    from jousto.simulation.live.real_time_clock import EDGES

    total = max(1, sum(glance.late))
    ends = [f"below {1e3 * edge:g} ms late" for edge in EDGES]
    names = [*ends, f"{1e3 * EDGES[-1]:g} ms late or more"]
    return [
        ("simulated time (s)", f"{glance.time:.3f}"),
        ("real-time factor of the last second", f"{glance.factor:.4f}"),
        ("longest step (ms)", f"{1e3 * glance.worst:.3f}"),
        ("largest lateness (ms)", f"{1e3 * glance.latest:.3f}"),
        ("steps that ended after the next was due", str(glance.missed)),
        ("times that 0.25 s were given up", str(glance.given_up)),
        *([("steps that deferred a change", str(glance.deferred))] if glance.deferred else []),
        *(
            (f"  {name}", f"{count} ({100.0 * count / total:.2f} %)")
            for name, count in zip(names, glance.late, strict=True)
            if sum(glance.late)
        ),
    ]
