"""Values of the fields of forces and events, from their entries in model files."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.errors import ASK_TRUST, InputError, MissingFileError, Problem, suggest
from jousto.base.files import executed
from jousto.base.units import KINDS
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.event import unit_at
from jousto.schema.entries.base import Entry
from jousto.schema.file.files import read_points
from jousto.schema.make.declared import Place, build_coordinate
from jousto.schema.make.quantities import build_amount
from jousto.schema.make.tables import build_table

if TYPE_CHECKING:
    from jousto.schema.make.builder import Builder


def curve(place: Place, value: Any) -> Any:
    """Return the table of a force over a coordinate or its rate."""
    at = place.unit(place.field.at)
    return build_table(place.builder, place.loc, value, at, place.unit())


def matrix6(place: Place, value: Any) -> Any:
    """Return six numbers, or a 6 x 6 matrix, in the units of the blocks of a bushing."""
    found: list[Any] = []
    for i, row in enumerate(value):
        units = place.field.units[i // 3]
        for j, x in enumerate(row if isinstance(row, tuple) else (row,)):
            at, unit = ((i, j), units[j // 3]) if isinstance(row, tuple) else ((i,), units[i // 3])
            found.append(build_amount(place.builder, (*place.loc, *at), x, unit))
    if any(x is None for x in found):
        return None
    return np.array(found).reshape(-1, 6).squeeze()


def wrench(place: Place, value: Any) -> Any:
    """Return three forces, N, and three torques, N m."""
    found = [
        build_amount(place.builder, (*place.loc, i), x, ("N", "N m")[i // 3])
        for i, x in enumerate(value)
    ]
    return None if None in found else tuple(found)


def pattern(place: Place, value: Any) -> Any:
    """Return nodal forces (nodes, 3), N, from a file, from rows, or from a mapping of nodes."""
    body = place.values["body"]
    # the constructor reports a body that is not flexible, unless it was made rigid by rigid=True
    if not isinstance(body, FlexibleBody):
        return None if place.builder.rigid or body is None else value
    if isinstance(value, str):
        return place.builder.make(place.loc, read_points, place.builder.file(value))
    if not isinstance(value, dict):
        return value
    sets = body.reduced.node_sets
    forces = np.zeros((len(body.reduced.nodes), 3))
    for name, force in value.items():
        if name not in sets:
            place.builder.note(
                (*place.loc, name),
                f"body {body.name!r} has no node set {name!r}{suggest(name, sets)}",
            )
            return None
        forces[list(sets[name])] += force
    return forces


def function(place: Place, text: str) -> Any:
    """Return the function of a text ``module:name`` or ``file.py:name``.

    The function is imported only if the user trusts the model file, since an import runs code.
    """
    module, _, name = text.rpartition(":")
    if not place.builder.trust:
        place.builder.note(place.loc, f"{text!r} is Python code, {ASK_TRUST}")
        return None
    return place.builder.make(place.loc, load_function, place.builder, module, name)


def load_function(builder: Builder, place: str, name: str) -> Any:
    """Import a module, or run a file relative to the model file, and return a function of it.

    Raises
    ------
    InputError
        If the module cannot be imported or has no such function.
    """
    try:
        if place.endswith(".py"):
            path = builder.file(place)
            if not path.is_file():
                raise MissingFileError(Problem("", f"no such file {str(path)!r}"))
            module = executed(path)
        else:
            module = importlib.import_module(place)
    except InputError:
        raise
    except Exception as error:  # user code may raise any exception
        raise InputError(
            Problem("", f"{place!r} cannot be imported: {type(error).__name__}: {error}")
        ) from error
    found = getattr(module, name, None)
    if found is None:
        known = [key for key, value in vars(module).items() if callable(value) and key[0] != "_"]
        raise InputError(Problem("", f"{place!r} has no function {name!r}{suggest(name, known)}"))
    return found


# -- events ---------------------------------------------------------------------------------


def watched(place: Place, value: Any) -> Any:
    """Return the sensor or the coordinate that an event names."""
    builder, known = place.builder, place.known
    if isinstance(value, str) and value in builder.sensors:
        found = known["sensors"].get(value)
        if found is None and ("sensors", value) not in builder.broken:
            builder.note(
                place.loc,
                f"sensor {value!r} belongs to a flexible body, which rigid=True makes rigid; leave "
                "the event out or watch something else",
            )
        return found
    if isinstance(value, Entry) or "." in value:
        return build_coordinate(builder, place.loc, value, known["bodies"], known["joints"])
    if builder.lost(value):
        return None
    builder.note(
        place.loc,
        f"no sensor {value!r}{suggest(value, builder.sensors)}; or a coordinate such as "
        "hinge.angle",
    )
    return None


def threshold(place: Place, value: Any) -> Any:
    """Return a number in the unit of the watched sensor or coordinate."""
    watch = place.values["watch"]
    if watch is None:
        return None
    unit = unit_of(watch, place.values.get("component"))
    return build_amount(place.builder, place.loc, value, unit)


def unit_of(watch: Any, component: Any) -> str:
    """Return the SI unit of the quantity that an event watches; "1" if it has no name in files."""
    if isinstance(component, list | tuple):
        component = next(iter(component), None)
    names = list(getattr(watch, "components", ()))
    if isinstance(component, str):
        component = names.index(component) if component in names else 0
    unit = unit_at(watch, component or 0)
    return unit if unit in KINDS else "1"


FORMS: dict[str, Callable[[Place, Any], Any]] = {
    "curve": curve,
    "matrix6": matrix6,
    "wrench": wrench,
    "pattern": pattern,
    "function": function,
    "watched": watched,
    "threshold": threshold,
}
