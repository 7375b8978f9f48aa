"""Variants of a mechanism: some flexible bodies rigid, or with fewer modes."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, is_dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.declare import Declared
from jousto.base.errors import Problems, suggest
from jousto.mechanism.bodies.base import Posed
from jousto.mechanism.bodies.body import FlexibleBody, RigidBody, ground
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.bodies.rigid_equivalent import rigid_body
from jousto.mechanism.checks import where as name_of
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.base import Sensor


@dataclass(frozen=True, eq=False)
class BodyVariant:
    """Mechanism with some bodies replaced.

    Attributes
    ----------
    mechanism : Mechanism
        The same items in the same order, attached to the new bodies.
    dropped : tuple of str
        Names of the sensors that the new bodies cannot have: modes, stress and strain of bodies
        that are rigid now, and what counts the cycles of these sensors.
    """

    mechanism: Mechanism
    dropped: tuple[str, ...] = ()


def with_rigid_bodies(mechanism: Mechanism, names: Sequence[str]) -> BodyVariant:
    """Return the mechanism with some flexible bodies made rigid.

    A rigid body has the mass, the inertia, the pose and the velocity of the undeformed flexible
    one, and every marker stays where it is on the undeformed body.

    Parameters
    ----------
    mechanism : Mechanism
    names : sequence of str
        Names of flexible bodies.

    Raises
    ------
    InputError
        Names that are no flexible bodies; forces and events that need the modes of such a body.
    """
    chosen = _flexible(mechanism, names)
    return _with_bodies(mechanism, {name: rigid_body(body) for name, body in chosen.items()})


def with_modes(mechanism: Mechanism, modes: Mapping[str, Sequence[int]]) -> BodyVariant:
    """Return the mechanism with some of the modes of flexible bodies left out.

    Parameters
    ----------
    mechanism : Mechanism
    modes : mapping of str to sequence of int
        Indices of the modes to keep, from 0, by the name of the body.

    Raises
    ------
    InputError
        Names that are no flexible bodies; modes that do not exist.
    """
    chosen = _flexible(mechanism, list(modes))
    new = {name: _with_modes(body, np.asarray(modes[name])) for name, body in chosen.items()}
    return _with_bodies(mechanism, new)


def _flexible(mechanism: Mechanism, names: Sequence[str]) -> dict[str, FlexibleBody]:
    """Return flexible bodies by name; raise an error for names of no flexible body."""
    known = {body.name: body for body in mechanism.bodies if isinstance(body, FlexibleBody)}
    others = [body.name for body in mechanism.bodies if body.name not in known]
    problems = Problems()
    for name in names:
        if name in others:
            problems.add(f"body '{name}'", "is not a flexible body: it has no modes")
        elif name not in known:
            message = f"no body '{name}'{suggest(name, known)}"
            problems.add(f"mechanism '{mechanism.name}'", message)
    problems.raise_if_any()
    return {name: known[name] for name in names}


def _with_modes(body: FlexibleBody, kept: NDArray[Any]) -> FlexibleBody:
    """Return the body with selected modes, their damping and initial values."""
    reduced = body.reduced.keep(kept)
    damping = body.damping
    if isinstance(damping, tuple):
        damping = tuple(np.asarray(damping)[kept].tolist())
    given = {key: getattr(body, key) for key in body.fields}
    start = {key: given[key][kept] for key in ("modal_coordinates", "modal_velocities")}
    return FlexibleBody(**given | start | {"reduced": reduced, "damping": damping})


def _with_bodies(mechanism: Mechanism, new: Mapping[str, RigidBody | FlexibleBody]) -> BodyVariant:
    """Return the mechanism with its items attached to new bodies."""
    stiff = {name for name, body in new.items() if isinstance(body, RigidBody)}
    dropped = _dropped(mechanism, stiff)
    memo: dict[int, Any] = {id(ground): ground}
    for item in (*mechanism.bodies, *mechanism.beams):
        memo[id(item)] = new.get(item.name, item)
    gone = set(map(id, dropped))
    items = [attached(item, memo) for item in mechanism.items if id(item) not in gone]
    _check(items, set(map(id, new.values())))
    options = {key: getattr(mechanism, key) for key in ("name", "core", "start")}
    return BodyVariant(Mechanism(*items, **options), tuple(item.name for item in dropped))


def _dropped(mechanism: Mechanism, stiff: set[str]) -> list[Sensor]:
    """Return the sensors that measure the deformation of rigid bodies, directly or through others.

    Raises
    ------
    InputError
        If an item that is no sensor uses one of them, such as an event.
    """
    found = [
        sensor
        for sensor in mechanism.sensors
        if sensor.flexible and getattr(getattr(sensor, "body", None), "name", None) in stiff
    ]
    gone, problems = set(map(id, found)), Problems()
    for item in mechanism.items:
        if isinstance(item, Posed) or id(item) in gone:
            continue
        used = [one for one in _values(item) if id(one) in gone]
        if used and isinstance(item, Sensor):
            found.append(item)
            gone.add(id(item))
        elif used:
            body = getattr(used[0], "body", None)
            problems.add(
                name_of(item),
                f"needs sensor '{used[0].name}', which a rigid body "
                f"'{getattr(body, 'name', '')}' does not have",
            )
    problems.raise_if_any()
    return found


def _values(item: Any) -> Iterator[Any]:
    """Yield the values of the fields of an item, those of sequences and mappings one by one."""
    for value in vars(item).values() if hasattr(item, "__dict__") else ():
        if isinstance(value, Mapping):
            yield from value.values()
        elif isinstance(value, tuple | list):
            yield from value
        else:
            yield value


def attached(value: Any, memo: dict[int, Any]) -> Any:
    """Return a copy of an item whose markers and references are those of the new bodies.

    Parameters
    ----------
    value : object
        An item, or the value of one of its fields.
    memo : dict
        New objects by the identity of the old ones, extended by this function.
    """
    if id(value) in memo:
        return memo[id(value)]
    if isinstance(value, Marker):
        memo[id(value)] = found = _marker(value, memo)
        return found
    if isinstance(value, tuple | list):
        copies = [attached(one, memo) for one in value]
        return type(value)(*copies) if hasattr(value, "_fields") else type(value)(copies)
    if isinstance(value, Mapping):
        kind: Any = type(value)
        return kind({key: attached(one, memo) for key, one in value.items()})
    if isinstance(value, type) or not (isinstance(value, Declared) or is_dataclass(value)):
        return value
    if isinstance(value, Sensor) and value.flexible:  # it may store rows of the modes of its body
        fields = {key: attached(getattr(value, key), memo) for key in value.fields}
        memo[id(value)] = sensor = type(value)(**fields)
        return sensor
    memo[id(value)] = made = copy.copy(value)  # before its fields, which may refer to it
    for key, one in vars(value).items():
        vars(made)[key] = attached(one, memo)
    return made


def _marker(marker: Marker, memo: Mapping[int, Any]) -> Marker:
    """Return a marker at the same point of the new body."""
    body = memo.get(id(marker.body), marker.body)
    if isinstance(body, RigidBody) and not isinstance(marker.body, RigidBody):
        return replace(marker, body=body, node=None, followed=None)
    if marker.point == "center" and isinstance(body, RigidBody):
        return replace(marker, body=body, position_local=body.center)
    return replace(marker, body=body)


def _check(items: Sequence[Any], new: set[int]) -> None:
    """Raise an error for items with a field that does not accept a new body."""
    problems = Problems()
    for item in items:
        for key, kind in getattr(item, "fields", {}).items():
            value = vars(item).get(key)
            if id(value) in new:
                found = Problems()
                kind.check(found, name_of(item), value)
                if found.found:
                    message = f"needs the modes of body '{value.name}', which is rigid here"
                    problems.add(name_of(item), message)
    problems.raise_if_any()
