"""From entries to forces and torques, springs, bushings, servos and other force elements."""

from __future__ import annotations

import importlib
import importlib.util
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.errors import InputError, MissingFileError, Problem, suggest
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.forces.line_load import LineLoad
from jousto.mechanism.forces.loads import Force, Torque
from jousto.mechanism.forces.moving import MovingLoad
from jousto.mechanism.forces.springs import Bushing, JointForce, ModalLoad, Servo, Spring, UserForce
from jousto.schema.entries.signals import CurveEntry
from jousto.schema.file.document import Loc
from jousto.schema.file.files import read_points
from jousto.schema.make.amounts import build_amount
from jousto.schema.make.connect import with_markers
from jousto.schema.make.declared import build_coordinate, build_signal
from jousto.schema.make.tables import build_table

if TYPE_CHECKING:
    from jousto.schema.make.builder import Builder

LOADS = {"force": Force, "torque": Torque}
ELEMENTS = {
    "spring": Spring,
    "bushing": Bushing,
    "joint-force": JointForce,
    "moving-load": MovingLoad,
    "servo": Servo,
    "modal-load": ModalLoad,
    "user-force": UserForce,
    "line": LineLoad,
}

# units of stiffness and damping along a length and along an angle
STIFFNESS = {"m": "N/m", "rad": "N m/rad"}
DAMPING = {"m": "N s/m", "rad": "N m s/rad"}
RATES = {"m": "m/s", "rad": "rad/s"}
# of the blocks of a 6 x 6 matrix: force and torque against translation and turn
BLOCKS = {
    "stiffness": (("N/m", "N/rad"), ("N", "N m/rad")),
    "damping": (("N s/m", "N s/rad"), ("N s", "N m s/rad")),
}


def build_load(
    builder: Builder, loc: Loc, entry: Any, bodies: dict[str, Any], joints: dict[str, Any]
) -> Any:
    """Return the force of an entry, None if anything is wrong with it."""
    values = entry.given()
    for key in ("marker", "reference"):  # the reference of a servo is a signal
        if key in values and "coordinate" not in values:
            values[key] = builder.marker((*loc, key), values[key], bodies)
    if entry.type == "bushing":
        values = bushing(builder, loc, entry, bodies)
    elif "coordinate" in values:
        along(builder, loc, values, bodies, joints)
    else:
        for key, unit in (("position", "m"), ("signal", "1")):
            if key in values:
                values[key] = build_signal(builder, (*loc, key), values[key], unit)
    for key in ("body", "beam"):
        if key in values:
            name = values[key]
            values[key] = bodies.get(name)
            if values[key] is None:
                builder.unknown((*loc, key), "bodies", key, name, bodies)
    if entry.type == "modal-load":
        values["pattern"] = pattern(builder, (*loc, "pattern"), entry.pattern, values["body"])
    if entry.type == "user-force":
        values["function"] = function(builder, (*loc, "function"), entry.function)
    if any(value is None for value in values.values()):
        return None
    return builder.make(loc, {**LOADS, **ELEMENTS}[entry.type], **values)


def along(
    builder: Builder,
    loc: Loc,
    values: dict[str, Any],
    bodies: dict[str, Any],
    joints: dict[str, Any],
) -> None:
    """Replace the entries of a force along a coordinate by values in its units."""
    s = build_coordinate(builder, (*loc, "coordinate"), values["coordinate"], bodies, joints)
    values["coordinate"] = s
    if s is None:
        return
    stiffness, damping, force = STIFFNESS[s.unit], DAMPING[s.unit], s.force_unit
    units = {
        "stiffness": stiffness, "kp": stiffness, "damping": damping, "kd": damping,
        "free": s.unit, "reference": s.unit, "preload": force, "limit": force, "signal": force,
    }  # fmt: skip
    for key, unit in units.items():
        if key in values:
            values[key] = build_signal(builder, (*loc, key), values[key], unit)
    for key, unit in (("table", s.unit), ("damper_table", RATES[s.unit])):
        if isinstance(values.get(key), CurveEntry):
            values[key] = build_table(builder, (*loc, key), values[key], unit, force)


def bushing(builder: Builder, loc: Loc, entry: Any, bodies: dict[str, Any]) -> dict[str, Any]:
    """Return the values of a bushing; matrices are six numbers or six rows."""
    values = with_markers(builder, loc, entry, bodies) or {"a": None}
    for key, blocks in BLOCKS.items():
        if key not in values:
            continue
        rows = values[key]
        found: list[Any] = []
        for i, row in enumerate(rows):
            units = blocks[i // 3]
            if isinstance(row, tuple):
                found += [
                    build_amount(builder, (*loc, key, i, j), x, units[j // 3])
                    for j, x in enumerate(row)
                ]
            else:
                found.append(build_amount(builder, (*loc, key, i), row, units[i // 3]))
        values[key] = None if None in found else np.array(found).reshape(-1, 6).squeeze()
    if "preload" in values:
        found = [
            build_amount(builder, (*loc, "preload", i), x, ("N", "N m")[i // 3])
            for i, x in enumerate(values["preload"])
        ]
        values["preload"] = None if None in found else tuple(found)
    return values


def pattern(builder: Builder, loc: Loc, value: Any, body: Any) -> Any:
    """Return nodal forces (nodes, 3) N of a file, of rows, or of named nodes."""
    if isinstance(value, str):
        return builder.make(loc, read_points, builder.file(value))
    if not isinstance(value, dict):
        return value
    if not isinstance(body, FlexibleBody):
        return None
    sets = body.reduced.node_sets
    forces = np.zeros((len(body.reduced.nodes), 3))
    for name, force in value.items():
        if name not in sets:
            builder.note(
                (*loc, name), f"body {body.name!r} has no node set {name!r}{suggest(name, sets)}"
            )
            return None
        forces[list(sets[name])] += force
    return forces


def function(builder: Builder, loc: Loc, text: str) -> Any:
    """Return the function that ``module:name`` or ``file.py:name`` means.

    It is imported only if the user trusts the model file: importing runs its code.
    """
    place, _, name = text.rpartition(":")
    if not builder.trust:
        builder.note(
            loc,
            f"{text!r} is Python code, which may do anything on this computer; if you trust this "
            "file, run it with --trust (in Python: read_model(path, trust=True))",
        )
        return None
    return builder.make(loc, load_function, builder, place, name)


def load_function(builder: Builder, place: str, name: str) -> Any:
    """Import a module, or run a file relative to the model file, and return a function of it.

    Raises
    ------
    InputError
        If it cannot be imported or has no such function.
    """
    try:
        if place.endswith(".py"):
            path = builder.file(place)
            if not path.is_file():
                raise MissingFileError(Problem("", f"no such file {str(path)!r}"))
            spec = importlib.util.spec_from_file_location(f"jousto_user_{path.stem}", path)
            assert spec is not None
            assert spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
        else:
            module = importlib.import_module(place)
    except InputError:
        raise
    except Exception as error:  # user code may raise whatever it likes
        raise InputError(
            Problem("", f"{place!r} cannot be imported: {type(error).__name__}: {error}")
        ) from error
    found = getattr(module, name, None)
    if found is None:
        known = [key for key, value in vars(module).items() if callable(value) and key[0] != "_"]
        raise InputError(Problem("", f"{place!r} has no function {name!r}{suggest(name, known)}"))
    return found
