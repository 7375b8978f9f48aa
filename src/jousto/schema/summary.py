"""Content of a model or a reduced part as lines of names and values."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from jousto.base.errors import count
from jousto.mechanism.beams.body import BeamBody
from jousto.mechanism.bodies.body import FlexibleBody, RigidBody
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.forces.contact_set import Contacts
from jousto.mechanism.forces.springs import CurveField
from jousto.mechanism.joints.coordinate import Along, Coordinate
from jousto.mechanism.signals.base import Constant
from jousto.mechanism.signals.piecewise import Table

if TYPE_CHECKING:
    from jousto.mechanism.forces.base import ForceElement
    from jousto.mechanism.mechanism import Mechanism
    from jousto.mesh.mesh import Mesh
    from jousto.reduction.reduced import ReducedPart
    from jousto.schema.read import ModelFile

Facts: TypeAlias = list[tuple[str, str]]

FLAT = 1e-6  # thickness / size below which a surface is flat


def model_facts(file: ModelFile) -> Facts:
    """Return lines on the content of a model file."""
    rows = mechanism_facts(file.mechanism)
    if file.fatigue is not None:
        rows += [(f"S-N curve {name}", str(curve)) for name, curve in file.fatigue.curves.items()]
        for check in file.fatigue.checks:
            text = f"body {check.body}, {check.sn.name or 'S-N curve'}, residue: {check.residue}"
            rows.append((f"fatigue {check.name}", text))
    if file.simulation is not None:
        solver = file.simulation.solver
        text = f"{file.simulation.t_end:g} s" + (
            f" with {solver}" if solver else ", solver chosen by the model"
        )
        rows.append(("simulation", text))
    return rows


def mechanism_facts(mechanism: Mechanism) -> Facts:
    """Return lines on the content of a mechanism."""
    rows: Facts = []
    for body in mechanism.items:
        if not isinstance(body, RigidBody | FlexibleBody | BeamBody):
            continue
        if isinstance(body, BeamBody):
            text = f"exact beam, {body.mass:.6g} kg, {body.length:.6g} m, {body.n + 1} nodes, "
            text += f"elements up to {body.highest_frequency:.4g} Hz"
        elif isinstance(body, FlexibleBody):
            f, mass = body.reduced.frequencies, body.reduced.invariants.mass
            text = f"flexible, {mass:.6g} kg, {count(len(f), 'mode')}, {f[0]:.6g}"
            text += f" to {f[-1]:.6g} Hz" if len(f) > 1 else " Hz"
        else:
            text = f"rigid, {body.mass:.6g} kg"
        rows.append((f"body {body.name}", text))
    for joint in mechanism.joints:
        kind = joint.tag.replace("-", " ")
        rows.append((f"joint {joint.name}", f"{kind}, {joint.a.label} to {joint.b.label}"))
    for coupler in mechanism.couplings:
        kind = coupler.tag.replace("-", " ")
        rows.append((f"{kind} {coupler.name}", coupler.row_names[0]))
    for force in mechanism.forces:
        if isinstance(force, Contacts):
            rows += force.facts
        else:
            rows.append((f"{force.kind} {force.name}", given(force)))
    if mechanism.assemblies:
        from jousto.robots.in_mechanism import RobotInMechanism  # slow to import

        for robot in mechanism.assemblies:
            if isinstance(robot, RobotInMechanism) and robot.contact:
                rows += [
                    (name.replace("shape ", f"shape {robot.prefix}"), text)
                    for name, text in robot.robot.shape_facts
                ]
    for block in mechanism.blocks:
        names = ", ".join(block.starts) or "no states"
        outputs = ", ".join(block.outputs)
        along = ", ".join(c.name or "" for c, _ in block.checked().forces)
        text = names + (f"; outputs {outputs}" if outputs else "")
        rows.append(
            (f"{block.kind} {block.name}", text + (f"; acts along {along}" if along else ""))
        )
    for friction in mechanism.frictions:
        text = f"of joint {friction.joint.name}, mu {friction.mu_kinetic:g}"
        rows.append((f"friction {friction.name}", f"{text}, {friction.law}"))
    rows += [(f"sensor {s.name}", f"{s.description}, {s.unit}") for s in mechanism.sensors]
    for fmu in mechanism.fmus:
        inputs, outputs = (", ".join(names) or "none" for names in (fmu.inputs, fmu.outputs))
        text = f"{fmu.file.name}, step {fmu.step:g} s, inputs {inputs}, outputs {outputs}"
        text += "; native code, runs only if trusted (--trust)" if fmu.untrusted else ""
        rows.append((f"fmu {fmu.name}", text))
    for event in mechanism.events:
        mark = {"both": "passes", "rising": "rises above", "falling": "falls below"}
        text = f"{event.watched} {mark[event.direction]} {event.threshold:g}"
        text += f", releases {', '.join(one.name for one in event.releases)}" * bool(event.releases)
        rows.append((f"event {event.name}", text + (", stops the run" if event.stop else "")))
    rows.append(("gravity", " ".join(f"{g:g}" for g in mechanism.gravity) + " m/s2"))
    return rows


def given(force: ForceElement) -> str:
    """Return the attachment of a force and its other values: numbers, vectors and flags."""
    places: list[str] = []
    values: list[str] = []
    for key, kind in force.fields.items():
        value = getattr(force, key)
        size = np.size(value) if isinstance(value, float | complex | np.ndarray) else 0
        if isinstance(value, Marker):
            places.append(value.label)
        elif (
            isinstance(value, Coordinate)
            and value.joint is None
            and value.name.startswith(f"{force.name}.")  # coordinate created by Spring.between
        ):
            places.append(f"{value.a.label} to {value.b.label}")
        elif isinstance(value, Coordinate | BeamBody | FlexibleBody | RigidBody):
            places.append(value.name)
        elif value is True and kind.default is not True:
            values.append(kind.label)
        elif isinstance(value, Constant) and isinstance(kind.unit, Along):
            unit = kind.unit.of(getattr(force, kind.unit.field))
            values.append(f"{kind.label} {value.value:.6g} {unit}")
        elif isinstance(value, Table) and isinstance(kind, CurveField):
            s = getattr(force, kind.at.field)
            units = (str(kind.unit.of(s)), str(kind.at.of(s)))
            values.append(table_text(key, kind.label, value, units))
        elif 0 < size <= 3 and np.any(value != kind.default):
            unit = kind.unit
            unit = unit.of(getattr(force, unit.field)) if isinstance(unit, Along) else unit
            number = ", ".join(f"{x:.6g}" for x in np.ravel(value))
            number = f"({number})" if size > 1 else number
            values.append(f"{kind.label} {number}" + (f" {unit}" if unit != "1" else ""))
    where = " to ".join(places)
    return ", ".join([where, *values] if where else values)


def table_text(key: str, label: str, table: Table, units: tuple[str, str]) -> str:
    """Return a description of a force table: dry friction, or its points and their range."""
    x, y = np.asarray(table.times), np.asarray(table.values)
    if key == "damper_table" and len(x) == 2 and x[0] == -x[1] and y[0] == -y[1] >= 0.0:
        return f"dry friction {y[0]:.6g} {units[0]}, full from {x[1]:.6g} {units[1]}"
    ends = f"{y.min():.6g} to {y.max():.6g} {units[0]} at {x[0]:.6g} to {x[-1]:.6g} {units[1]}"
    return f"{label} of {count(len(x), 'point')}, {ends}"


def mesh_facts(mesh: Mesh) -> Facts:
    """Return lines on a mesh, lengths in mm, in which wrong units are easy to see."""
    low, high = mesh.bounds
    kinds: dict[str, int] = {}
    for block in mesh.cells:
        kinds[block.kind] = kinds.get(block.kind, 0) + len(block)
    size = " x ".join(f"{1e3 * x:.5g}" for x in high - low)
    rows = [
        ("size", f"{size} mm"),
        ("from", f"({', '.join(f'{1e3 * x:.5g}' for x in low)}) mm"),
        ("nodes", f"{len(mesh.nodes)}, {3 * len(mesh.used)} degrees of freedom"),
        ("elements", ", ".join(f"{n} {kind}" for kind, n in kinds.items()) or "none"),
        ("volume", f"{1e6 * mesh.volume:.5g} cm3, {7850.0 * mesh.volume:.5g} kg if it is steel"),
    ]
    if mesh.cad_volume:
        beside = f"{100.0 * (mesh.volume / mesh.cad_volume - 1.0):+.2g} %"
        rows.append(("CAD volume", f"{1e6 * mesh.cad_volume:.5g} cm3, the mesh {beside}"))
    if len(mesh.element_ids):
        rows.append(("quality", str(mesh.quality()).partition(": ")[2]))
    if mesh.element_sets:
        sets = (f"{name} ({len(members)})" for name, members in mesh.element_sets.items())
        rows.append(("element sets", ", ".join(sets)))
    return rows


def set_text(mesh: Mesh, name: str, nodes: Any) -> str:
    """Return a description of a set: number of nodes, position, and form of a surface."""
    from jousto.mesh.holes import cylinder_through

    if not len(nodes):
        return "0 nodes"
    x = mesh.nodes[np.asarray(nodes)]
    low, high = x.min(axis=0), x.max(axis=0)
    text = f"{count(len(x), 'node')}, {_millimetres(0.5 * (low + high))} mm"
    if len(x) > 1:
        text += f", {' x '.join(f'{1e3 * s:.4g}' for s in high - low)} mm"
    if name not in mesh.surfaces or len(x) < 4:
        return text
    _, size, directions = np.linalg.svd(x - x.mean(axis=0), full_matrices=False)
    if size[2] <= FLAT * size[0]:
        return f"{text}, flat, normal {_direction(directions[2])}"
    cylinder = cylinder_through(x)
    if cylinder is None:
        return text
    radius = f"{1e3 * cylinder.radius:.4g} mm"
    return f"{text}, cylinder of radius {radius} along {_direction(cylinder.axis)}"


def _millimetres(x: Any) -> str:
    return "at (" + ", ".join(f"{round(1e3 * float(a), 3) + 0.0:g}" for a in x) + ")"


def _direction(e: Any) -> str:
    """Return x, y or z, or components with the largest one positive."""
    along = np.asarray(e) * np.sign(e[int(np.argmax(np.abs(e)))])
    parts = [round(float(a), 3) + 0.0 for a in along]
    if sorted(parts) == [0.0, 0.0, 1.0]:
        return "xyz"[parts.index(1.0)]
    return "(" + ", ".join(f"{a:g}" for a in parts) + ")"


def content_facts(part: ReducedPart) -> Facts:
    """Return lines on the mass integrals of a reduced part and the purpose of its modes."""
    i = part.invariants

    def matrix(a: Any, unit: str) -> str:
        shape = " x ".join(str(n) for n in a.shape)
        return f"{shape}, largest {np.abs(a).max(initial=0.0):.4g} {unit}".rstrip()

    def rounded(a: Any, size: float) -> str:
        return ", ".join(f"{x:.6g}" for x in np.where(np.abs(a) < 1e-9 * size, 0.0, a))

    J = i.I7
    size = float(np.abs(J).max())
    rows = [
        ("I1", f"mass, {i.I1:.6g} kg"),
        ("I2", f"first moment, {rounded(i.I2, (i.I1 * size) ** 0.5)} kg m"),
        ("I3", f"momentum of the modes, {matrix(i.I3, 'kg^0.5')}"),
        ("I4", f"angular momentum of the modes, {matrix(i.I4, 'kg^0.5 m')}"),
        ("I5", f"its change with the modes, {matrix(i.I5, '')}"),
        ("I6", f"modal mass, {matrix(i.I6, '')}"),
        ("I7", f"inertia xx yy zz, {rounded(np.diag(J), size)} kg m2"),
        ("", f"inertia yz xz xy, {rounded(J[[1, 0, 0], [2, 2, 1]], size)} kg m2"),
        ("I8", f"its change with the modes, {matrix(i.I8, 'kg^0.5 m')}"),
        ("I9", f"with products of modes, {matrix(i.I9, '')}"),
    ]
    # attachment modes and residual vectors are mixed with vibration modes, because their loads move
    # masses
    text = part.provenance.get("method", "")
    mixed = any(word in text for word in ("residuals=", "inertia_relief=True"))
    mixed = (
        mixed
        or text.startswith("ShapeFunctions")
        or (text.startswith("FreeFree") and bool(part.interfaces))
    )
    for j, (f, share) in enumerate(zip(part.frequencies, part.static_shares, strict=True)):
        kind = "" if mixed else " correction," if share > 0.5 else " vibration,"
        rows.append((f"mode {j + 1}", f"{f:.6g} Hz,{kind} {100 * share:.0f} % static"))
    return rows


def part_facts(part: ReducedPart) -> Facts:
    """Return lines on the content of a reduced part."""
    # node numbers only where interfaces have no other names
    numbered = re.compile(r"n(ode)?\d+")
    sets = [s for s in part.node_sets if s in part.interfaces or not numbered.fullmatch(s)]
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
