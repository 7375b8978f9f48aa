"""HTML of objects in notebook cells: a table, a small picture, and useful calls.

IPython finds the functions by type name; the classes themselves have no code for notebooks.
"""

from __future__ import annotations

import base64
import html
import sys
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jousto.certificate.certificate import Certificate
    from jousto.fatigue.miner.damage_field import DamageField
    from jousto.measurement.monitor.monitor import Monitor
    from jousto.mechanism.mechanism import Mechanism
    from jousto.mesh.mesh import Mesh
    from jousto.parts.part import Part
    from jousto.reduction.reduced import ReducedPart
    from jousto.simulation.results.solution import Solution

MOST = 16  # rows of a table
DRAWN = 50_000  # largest number of elements drawn in a cell
CELL = "text-align: left; vertical-align: top; padding: 1px 12px 1px 0"
COLOURS = {"ok": "#2e7d32", "note": "inherit", "warn": "#b26a00", "fail": "#c62828"}

Rows = Iterable[tuple[str, ...]]


def register(shell: Any = None) -> None:
    """Register jousto's objects with IPython; no effect without IPython.

    Parameters
    ----------
    shell : InteractiveShell, optional
        By default the running one.
    """
    if shell is None:
        shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if shell is not None:
        formatter = shell.display_formatter.formatters["text/html"]
        for place, function in SHOWN.items():
            module, _, name = place.rpartition(".")
            formatter.for_type_by_name(f"jousto.{module}", name, function)


def solution(run: Solution) -> str:
    """Return a run as HTML: statistics and sensors."""
    time = run.time
    facts = [
        ("instants", f"{run.nt}, {time[0]:g} to {time[-1]:g} s" if run.nt else "none"),
        ("solver", str(run.attributes.get("solver", ""))),
        ("ended", str(run.attributes.get("ended", "still running or killed"))),
        ("energy", run.energy.verdict if run.nt else ""),
    ]
    sensors = []
    for name in run.sensors:
        about = run.about(name)
        sensors.append((name, ", ".join(about["components"]), about["unit"], about["description"]))
    body = table(facts) + table(sensors, ("sensor", "components", "unit", "what"))
    return cell(f"run of {run.name}", body, "jo.view(run) shows it move")


def mechanism(thing: Mechanism) -> str:
    """Return a mechanism as HTML: its content."""
    from jousto.schema.summary import mechanism_facts

    body = table(mechanism_facts(thing))
    return cell(f"mechanism {thing.name}", body, "jo.view(mechanism) shows it")


def part(thing: Part) -> str:
    """Return a part as HTML: size, mass, sets and a picture."""
    x = thing.nodes
    size = " x ".join(f"{1e3 * a:.5g}" for a in x.max(axis=0) - x.min(axis=0))
    sets = (f"{name} ({len(members)})" for name, members in thing.node_sets.items())
    facts = [
        ("size", f"{size} mm"),
        ("nodes", f"{len(x)}, {thing.dofs_per_node * len(x)} degrees of freedom"),
        ("mass", f"{thing.mass:.6g} kg"),
        ("centre", ", ".join(f"{1e3 * a:.5g}" for a in thing.center) + " mm"),
        ("sets", ", ".join(list(sets)[:MOST])),
    ]
    return cell(
        f"part {thing.name}", side_by_side(table(facts), picture(thing)), "jo.view(part) shows it"
    )


def reduced_part(thing: ReducedPart) -> str:
    """Return a reduced part as HTML: modes, origin, picture of the first mode."""
    from jousto.schema.summary import part_facts

    shares = thing.static_shares
    modes = [
        (str(k + 1), f"{f:.6g}", f"{100 * shares[k]:.0f} %")
        for k, f in enumerate(thing.frequencies)
    ]
    body = table(part_facts(thing)) + table(modes, ("mode", "Hz", "static"))
    hint = (
        "jo.view(part) shows its modes; jo.certificate.certify(full, part) compares them with the "
        "full model"
    )
    return cell(f"reduced part {thing.name}", side_by_side(body, picture(thing)), hint)


def certificate(thing: Certificate) -> str:
    """Return a certificate as HTML: its checks, with advice for those not passed."""
    rows = []
    for check in thing.checks:
        limit = f" ({check.limit})" if check.limit else ""
        advice = "" if check.status == "ok" else check.advice
        rows.append((check.status, check.topic, f"{check.value}{limit}", advice))
    colours = [COLOURS[check.status] for check in thing.checks]
    body = table(rows, ("", "check", "found", "advice"), most=len(rows), colours=colours)
    hint = "jo.write(certificate, 'certificate.html') writes all of it"
    return cell(f"certificate of {thing.name}: {thing.verdict}", table(thing.facts) + body, hint)


def damage_field(thing: DamageField) -> str:
    """Return damage as HTML: the most damaged places."""
    rows = []
    for place in thing.worst(MOST):
        damage, life, safety = thing.at(place)
        rows.append((place, f"{damage:.4g}", f"{life:.4g} s", f"{safety:.4g}"))
    facts = [
        ("places", f"{len(thing)}, of which {thing.pruned} cannot be damaged"),
        ("history", f"{thing.duration:g} s of {thing.criterion}, residue {thing.residue}"),
        ("curve", str(thing.sn)),
    ]
    body = table(facts) + table(rows, ("place", "damage", "life", "safety"))
    return cell(f"damage of {thing.body}", body, "jo.view(run, damage=field) colours the body")


def monitor(thing: Monitor) -> str:
    """Return a monitor as HTML: part, gauges, hot spots and limits."""
    curve = "none, so no damage" if thing.sn is None else str(thing.sn)
    facts = [
        ("channels", ", ".join(thing.channels[:MOST])),
        ("places", ", ".join(thing.spots[:MOST])),
        ("stress", f"{thing.criterion}, with a band of {100 * thing.level:g} %"),
        ("curve", curve),
        ("summary", f"every {thing.every:g} s"),
    ]
    life = thing.life
    rows = []
    if life is not None:
        facts.append(("watched", f"{life.watched:.6g} s"))
        for k, place in enumerate(thing.spots):
            numbers = (life.damage, life.damage_low, life.damage_high, life.remaining)
            rows.append((place, *(f"{x[k]:.4g}" for x in numbers)))
    head = ("place", "damage", "lower end", "upper end", "life left in s")
    return cell("monitor", table(facts) + table(rows, head))


def mesh(thing: Mesh) -> str:
    """Return a mesh as HTML: size, quality and a picture."""
    from jousto.schema.summary import mesh_facts

    return cell(
        "mesh", side_by_side(table(mesh_facts(thing)), picture(thing)), "jo.view(mesh) shows it"
    )


SHOWN: dict[str, Callable[[Any], str]] = {
    "simulation.results.solution.Solution": solution,
    "mechanism.mechanism.Mechanism": mechanism,
    "parts.part.Part": part,
    "reduction.reduced.ReducedPart": reduced_part,
    "certificate.certificate.Certificate": certificate,
    "fatigue.miner.damage_field.DamageField": damage_field,
    "measurement.monitor.monitor.Monitor": monitor,
    "mesh.mesh.Mesh": mesh,
}
"""HTML functions by the module paths of types below ``jousto``."""


# -- pieces of HTML -------------------------------------------------------------------------


def cell(title: str, body: str, hint: str = "") -> str:
    """Return the HTML of an object: title, content and useful calls."""
    more = f'<div style="opacity: 0.7">{html.escape(hint)}</div>' if hint else ""
    return f"<div><strong>{html.escape(title)}</strong>{body}{more}</div>"


def table(
    rows: Rows, head: tuple[str, ...] = (), *, most: int = MOST, colours: Iterable[str] = ()
) -> str:
    """Return rows of text as a table, long ones cut; rows without value are left out."""
    lines = [row for row in rows if any(row[1:])]
    if not lines:
        return ""
    paint = list(colours) or ["inherit"] * len(lines)
    shown = [
        f'<tr style="background: none; color: {colour}">{_cells(row, "td")}</tr>'
        for row, colour in zip(lines[:most], paint, strict=False)
    ]
    if head:
        shown.insert(0, f"<tr>{_cells(head, 'th')}</tr>")
    if len(lines) > most:
        shown.append(f"<tr>{_cells((f'... {len(lines) - most} more',), 'td')}</tr>")
    return f"<table>{''.join(shown)}</table>"


def _cells(row: tuple[str, ...], kind: str) -> str:
    return "".join(f'<{kind} style="{CELL}">{html.escape(text)}</{kind}>' for text in row)


def side_by_side(left: str, right: str) -> str:
    """Return two pieces of HTML side by side, stacked in narrow cells."""
    style = "display: flex; flex-wrap: wrap; gap: 1em; align-items: flex-start"
    return f'<div style="{style}"><div>{left}</div>{right}</div>' if right else left


def picture(thing: Mesh | Part | ReducedPart) -> str:
    """Return a small picture of a mesh or a part as HTML; empty if there is no shape."""
    from jousto.base.errors import JoustoError
    from jousto.output.scenes.draw import draw

    if len(getattr(thing, "elements", ())) > DRAWN:
        return ""
    with tempfile.TemporaryDirectory() as folder:
        try:
            data = draw(thing, Path(folder) / "thing.png").read_bytes()
        except JoustoError:
            return ""  # parts given by matrices have no shape
    source = f"data:image/png;base64,{base64.b64encode(data).decode()}"
    return f'<img alt="" style="width: 20em; max-width: 100%" src="{source}">'
