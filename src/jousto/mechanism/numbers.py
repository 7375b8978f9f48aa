"""Numbers of a mechanism by name, such as ``arm.mass``, and mechanisms with other numbers."""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import read_only
from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.mechanism.bodies.body import RigidBody, ground
from jousto.mechanism.body_variants import attached
from jousto.mechanism.checks import check_distances, check_joints, where
from jousto.mechanism.forces.loads import Gravity
from jousto.mechanism.items_by_kind import POINT
from jousto.mechanism.mechanism import Mechanism

VECTOR: dict[str, tuple[int, ...]] = {"x": (0,), "y": (1,), "z": (2,)}
TENSOR: dict[str, tuple[int, ...]] = {
    "xx": (0, 0),
    "yy": (1, 1),
    "zz": (2, 2),
    "yz": (1, 2),
    "xz": (0, 2),
    "xy": (0, 1),
}
COMPONENTS: dict[Any, dict[str, tuple[int, ...]]] = {(3,): VECTOR, (3, 3): TENSOR}
"""Components of arrays by shape; tensors are symmetric."""
SEVERAL = ("items", "bodies", "forces", "frictions", "events", "initials")
"""Tuples of a mechanism that contain items with numbers."""


@dataclass(frozen=True, eq=False)
class Number:
    """A number of an item, or one component of an array.

    Attributes
    ----------
    item : Declared
        The item.
    field : str
        Name of its field.
    at : tuple of int
        Indices of the component; empty for a plain number or a whole array.
    """

    item: Any
    field: str
    at: tuple[int, ...] = ()

    @property
    def value(self) -> Any:
        """Value of the number, or array."""
        found = vars(self.item)[self.field]
        return found[self.at] if self.at else found


def item_name(item: Any) -> str:
    """Return the name by which an item is addressed; ``gravity`` for the gravity."""
    return "gravity" if isinstance(item, Gravity) else str(getattr(item, "name", ""))


def has_number(mechanism: Mechanism, address: str) -> bool:
    """Return whether a mechanism, or several of its items, have a number at an address."""
    return any(True for _ in _matches(mechanism, address))


def find_number(mechanism: Mechanism, address: str) -> Number:
    """Return the number at an address ``item.field`` or ``item.field.component``.

    ``link.mass``, ``link.center.x``, ``link.inertia.xx``, ``spring.stiffness``, ``gravity.y`` and
    ``crank.angle.value`` (of an `Initial`) are addresses.

    Raises
    ------
    InputError
        If there is no such number, or several items have it.
    """
    found = list(_matches(mechanism, address))
    if len(found) == 1:
        return found[0]
    place = f"number {address!r}"
    if found:
        names = " and ".join(where(number.item) for number in found)
        raise InputError(Problem(place, f"could be that of {names}; give them different names"))
    known = list(number_addresses(mechanism))
    hint = suggest(address, known)
    message = f"is not in mechanism {mechanism.name!r}{hint}"
    raise InputError(Problem(place, message))


def _matches(mechanism: Mechanism, address: str) -> Iterator[Number]:
    for item in mechanism.items:
        name = item_name(item)
        if not name or not address.startswith(f"{name}."):
            continue
        key, _, component = address[len(name) + 1 :].partition(".")
        if isinstance(item, Gravity):
            key, component = "acceleration", component or key
        if key not in getattr(item, "fields", ()) or not is_numeric(vars(item)[key]):
            continue
        at = COMPONENTS.get(np.shape(vars(item)[key]), {}).get(component)
        if at is not None or not component:
            yield Number(item, key, at or ())


def number_addresses(mechanism: Mechanism) -> Iterator[str]:
    """Yield the addresses of all plain numbers and of the components of arrays."""
    for item in mechanism.items:
        if not isinstance(item, Declared) or not item_name(item):
            continue
        for key in item.fields:
            value = vars(item)[key]
            if is_numeric(value):
                path = "gravity" if isinstance(item, Gravity) else f"{item_name(item)}.{key}"
                components = COMPONENTS.get(np.shape(value), {})
                yield from (f"{path}.{component}" for component in components)
                if not components:
                    yield path


def is_numeric(value: Any) -> bool:
    """Return whether a field contains a real number or an array of real numbers."""
    if isinstance(value, np.ndarray):
        return bool(value.dtype.kind == "f")
    return isinstance(value, float)


def replaced_items(mechanism: Mechanism, values: Mapping[str, Any]) -> dict[int, Any]:
    """Return checked items with other numbers, by the id of the items that they replace.

    Raises
    ------
    InputError
        If a number does not exist or is not allowed.
    """
    return replaced([(find_number(mechanism, name), values[name]) for name in values])


def replaced(values: list[tuple[Number, Any]]) -> dict[int, Any]:
    """Return checked items with given values of their numbers, by the id of the old items."""
    changed: dict[int, tuple[Any, dict[str, Any]]] = {}
    for number, value in values:
        new = changed.setdefault(id(number.item), (number.item, {}))[1]
        new[number.field] = _with(number, new.get(number.field), value)
    return {key: with_fields(item, new) for key, (item, new) in changed.items()}


def _with(number: Number, known: Any, value: Any) -> Any:
    """Return the new value of a field: the number itself, or the array with a new component."""
    if not number.at:
        return value
    old = vars(number.item)[number.field] if known is None else known
    array: NDArray[Any] = np.array(old, dtype=np.result_type(old, value))
    array[number.at] = array[number.at[::-1]] = value
    return array


def with_fields(item: Any, new: Mapping[str, Any]) -> Any:
    """Return a declared item with other values of some fields, which are checked."""
    made = object.__new__(type(item))
    own = [key for key in item.__dataclass_fields__ if key in vars(item)]
    old = {key: vars(item)[key] for key in own}
    vars(made).update(old | dict(new))
    if type(item).__post_init__ is Declared.__post_init__:
        _check_fields(made, new)
    else:
        made.__post_init__()
    for key in item.fields:  # checked before
        if key not in new:
            vars(made)[key] = old[key]
    return made


def _check_fields(made: Any, new: Mapping[str, Any]) -> None:
    """Check and store new fields of an item whose other fields are valid.

    Raises
    ------
    InputError
        If a value is not allowed.
    """
    problems = Problems()
    where = made.heading(problems)
    for key, value in new.items():
        kind, before = made.fields[key], len(problems.found)
        vars(made)[key] = kind.check(problems, where, value)
        problems.found[before:] = map(kind.located, problems.found[before:])
    if not problems.found:
        made.consistent(problems, where)
    problems.raise_if_any()


@explained
def with_numbers(mechanism: Mechanism, values: Mapping[str, Any]) -> Mechanism:
    """Return a mechanism with other numbers, for example ``{"link.mass": 2.0}``.

    The items are the same, in the same order; those that refer to a changed item refer to the new
    one. A marker at the centre of mass of a body follows it; other markers keep their places.

    Parameters
    ----------
    mechanism : Mechanism
        A mechanism.
    values : dict
        Values in SI units by address, see `find_number`.

    Raises
    ------
    InputError
        If a number does not exist or is not allowed.

    Examples
    --------
    >>> import jousto as jo
    >>> rod = jo.RigidBody("rod", 1.0, (0.01, 0.1, 0.1), center=(0.5, 0, 0))
    >>> pivot = jo.Revolute("pivot", jo.ground["origin"], rod["origin"])
    >>> heavier = with_numbers(jo.Mechanism(rod, pivot), {"rod.mass": 2.0, "rod.center.x": 0.4})
    >>> heavier.bodies
    (<RigidBody 'rod': 2 kg>,)
    """
    return with_items(mechanism, replaced_items(mechanism, values))


def with_items(mechanism: Mechanism, new: Mapping[int, Any]) -> Mechanism:
    """Return a mechanism with other items; `new` has them by the id of the old ones."""
    memo: dict[int, Any] = {id(ground): ground}
    for body in (*mechanism.bodies, *mechanism.beams):
        memo[id(body)] = new.get(id(body), body)
    others = {key: copy.copy(item) for key, item in new.items() if key not in memo}
    memo |= others
    for made in others.values():
        for key, value in vars(made).items():
            vars(made)[key] = attached(value, memo)
    items = [attached(item, memo) for item in mechanism.items]
    return Mechanism(*items, **{key: getattr(mechanism, key) for key in ("name", "core", "start")})


def with_local_items(mechanism: Mechanism, new: Mapping[int, Any]) -> Mechanism:
    """Return a mechanism with other items, to which the other items do not refer.

    The result serves to pack new numbers: joints and forces still refer to the old bodies.

    Raises
    ------
    InputError
        If the new numbers do not fit to the mechanism.
    """
    made = copy.copy(mechanism)
    for group in SEVERAL:
        items = vars(mechanism)[group]
        if any(id(item) in new for item in items):
            vars(made)[group] = tuple(new.get(id(item), item) for item in items)
    for item in new.values():
        if isinstance(item, Gravity):
            vars(made)["gravity"] = read_only(item.acceleration)
    bodies = [(x, new[id(x)]) for x in mechanism.bodies if id(x) in new and hasattr(x, "center")]
    arms = [gyration(body) for _, body in bodies]
    if bodies and mechanism.extent <= POINT * max(mechanism.arm, *arms):
        vars(made).pop("size", None)
        vars(made).pop("arm", None)
    if any(a.center.tobytes() != b.center.tobytes() for a, b in bodies):
        vars(made).pop("size", None)
        vars(made).pop("extent", None)
        problems = Problems()  # both depend on the size of the mechanism
        check_joints(problems, made)
        check_distances(problems, made)
        problems.raise_if_any()
    return made


def gyration(body: RigidBody) -> float:
    """Return the radius of gyration of a body about its centre of mass, m."""
    J = body.inertia
    return math.sqrt(0.5 * (J[0, 0] + J[1, 1] + J[2, 2]) / body.mass)
