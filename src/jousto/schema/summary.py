"""What is in a model or a reduced part, as lines of names and values for people."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from jousto.errors import count
from jousto.mechanism import FlexibleBody

if TYPE_CHECKING:
    from jousto.reduction import ReducedPart
    from jousto.schema.read import ModelFile

Facts: TypeAlias = list[tuple[str, str]]


def model_facts(file: ModelFile) -> Facts:
    """Return what is in a model."""
    mechanism = file.mechanism
    rows: Facts = []
    for body in mechanism.bodies:
        if isinstance(body, FlexibleBody):
            f, mass = body.reduced.frequencies, body.reduced.invariants.mass
            text = f"flexible, {mass:.6g} kg, {count(len(f), 'mode')}, {f[0]:.6g}"
            text += f" to {f[-1]:.6g} Hz" if len(f) > 1 else " Hz"
        else:
            text = f"rigid, {body.mass:.6g} kg"
        rows.append((f"body {body.name}", text))
    for joint in mechanism.joints:
        kind = type(joint).__name__.lower()
        rows.append((f"joint {joint.name}", f"{kind}, {joint.a.label} to {joint.b.label}"))
    for coupler in mechanism.couplings:
        kind = type(coupler).__name__.lower()
        rows.append((f"{kind} {coupler.name}", coupler.row_names[0]))
    for force in mechanism.forces:
        kind = type(force).__name__.lower()
        marker = getattr(force, "marker", None)
        rows.append((f"{kind} {force.name}", f"at {marker.label}" if marker else ""))
    for friction in mechanism.frictions:
        text = f"of joint {friction.joint.name}, mu {friction.mu_kinetic:g}"
        rows.append((f"friction {friction.name}", f"{text}, {friction.law}"))
    rows += [(f"sensor {s.name}", f"{s.description}, {s.unit}") for s in mechanism.sensors]
    for event in mechanism.events:
        mark = {"both": "passes", "rising": "rises above", "falling": "falls below"}
        text = f"{event.watch.name} {mark[event.direction]} {event.threshold:g}"
        rows.append((f"event {event.name}", text + (", stops the run" if event.stop else "")))
    rows.append(("gravity", " ".join(f"{g:g}" for g in mechanism.gravity) + " m/s2"))
    if file.simulation is not None:
        solver = file.simulation.solver
        text = f"{file.simulation.t_end:g} s" + (f" with {solver}" if solver else "")
        rows.append(("simulation", text))
    return rows


def part_facts(part: ReducedPart) -> Facts:
    """Return what is in a reduced part."""
    sets = [s for s in part.node_sets if not (s.startswith("node") and s[4:].isdigit())]
    frequencies = [f"{f:.6g}" for f in part.frequencies]
    if len(frequencies) > 12:
        frequencies = [*frequencies[:10], "...", frequencies[-1]]
    stress = "none" if part.stress is None else count(len(part.stress.labels), "site")
    return [
        ("mass", f"{part.invariants.mass:.6g} kg"),
        ("nodes", str(len(part.nodes))),
        ("named nodes", ", ".join(sets)),
        ("interfaces", ", ".join(part.interfaces) or "none"),
        ("modes", str(part.n)),
        ("frequencies", ", ".join(frequencies) + " Hz"),
        ("stress", stress),
        *((str(k), str(v)) for k, v in part.provenance.items()),
    ]
