"""The command on contacts of a run."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from jousto.base.errors import InputError, JoustoWarning, Problem
from jousto.cli.forces import machine_of_results, simulated
from jousto.cli.group import command
from jousto.cli.options import Output, Trust, instant
from jousto.cli.terminal import columns, say

if TYPE_CHECKING:
    from jousto.simulation.results.contacts import ContactPoints, RunContacts

SHOWN = 20
"""Largest number of contacts that are printed."""


@command()
def contacts(
    source: Annotated[
        Path, typer.Argument(metavar="MODEL|RESULT", help="Model file, or results of a run.")
    ],
    at: Annotated[
        str | None, typer.Option("--at", metavar="TIME", help="A stored instant, '0.5 s'.")
    ] = None,
    near: Annotated[
        bool, typer.Option("--near", help="With --at: also points that do not touch.")
    ] = False,
    model: Annotated[
        Path | None,
        typer.Option(
            "--model", metavar="FILE", help="Model of the results, if they lack its text."
        ),
    ] = None,
    output: Output = None,
    trust: Trust = False,
) -> None:
    """Print the contacts of a run, from touch to part, or those of an instant.

    A model is simulated first. For each contact: touch and part, speed of approach, largest force
    and depth, impulse, energy lost, number of steps. With --at the points that touch at a stored
    instant: gap, normal force, friction, whether it sticks or slips. -o writes a table .csv.
    """
    from jousto.output.style import target
    from jousto.schema.file.document import is_hdf5
    from jousto.simulation.results.solution import load

    if near and at is None:
        raise InputError(Problem("--near", "is of an instant; give --at TIME, or leave it out"))
    if output is not None:
        target(output, ("csv",))
    stored = is_hdf5(source)
    if model is not None and not stored:
        raise InputError(Problem("--model", f"{source} is a model itself; leave --model out"))
    if model is not None and at is None:
        raise InputError(Problem("--model", "is needed with --at only; leave it out"))
    run, machine = (load(source), None) if stored else simulated(source, trust)
    found: RunContacts | ContactPoints = run.contacts
    if at is None:
        _print_events(run.contacts)
    else:
        if machine is None:
            machine = machine_of_results(run, source, model, trust)
        points = run.contacts.at(float(instant(at, "--at") or 0.0), near=near, model=machine[1])
        _print_points(points)
        found = points
    if output is not None:
        say(f"written to {found.to_csv(output)}", style="green")


def _pair(contact: str, a: str, b: str, tip: int) -> str:
    """Return the name of a contact with its pair: ``feet: floor - pad 2``."""
    return f"{contact}: {a} - {b}" + (f" {tip}" if tip else "")


def _print_events(found: RunContacts) -> None:
    if not len(found):
        say("no contacts")
        return
    rows: list[tuple[str, ...]] = [
        (
            *("contact", "touch (s)", "part (s)", "speed (m/s)", "force (N)", "depth (m)"),
            *("impulse (N s)", "lost (J)", "steps"),
        )
    ]
    for one in found[:SHOWN]:
        lost = one.lost_restitution + one.lost_friction
        part = f"{one.part:.6g}" if one.part == one.part else "touches"
        rows.append(
            (
                _pair(one.contact, one.a, one.b, one.tip),
                f"{one.touch:.6g}",
                part,
                *(f"{x:.4g}" for x in (one.approach, one.force, one.depth, one.impulse, lost)),
                str(one.steps),
            )
        )
    columns(rows, "<>>>>>>>>")
    if len(found) > SHOWN:
        say(f"and {len(found) - SHOWN} more; -o FILE.csv has all")
    for sentence in found.findings:
        warnings.warn(JoustoWarning(sentence), stacklevel=1)


def _print_points(found: ContactPoints) -> None:
    say(f"contacts at {found.time:g} s")
    if not len(found):
        say("nothing touches")
        return
    rows: list[tuple[str, ...]] = [
        ("contact", "phase", "gap (m)", "force (N)", "friction (N)", "pressure (MPa)", "age (s)")
    ]
    for one in found[:SHOWN]:
        rubbed = sum(x * x for x in one.friction) ** 0.5
        pressure = f"{1e-6 * one.pressure:.4g}" if one.pressure == one.pressure else "-"
        rows.append(
            (
                _pair(one.contact, one.a, one.b, one.tip),
                one.phase,
                *(f"{x:.4g}" for x in (one.gap, one.force, rubbed)),
                pressure,
                f"{one.age:.4g}" if one.age == one.age else "-",
            )
        )
    columns(rows, "<<>>>>>")
    if len(found) > SHOWN:
        say(f"and {len(found) - SHOWN} more; -o FILE.csv has all")
