"""Comparison of two mechanisms: the items whose numbers differ, if nothing else differs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from jousto.base.declare import Declared
from jousto.mechanism.mechanism import Mechanism

PLAIN = (str, bytes, bool, int, type(None))


class Comparison:
    """Comparison of the objects of two mechanisms, item by item.

    An object of the first mechanism corresponds to the object of the second that is at the same
    place. Objects that several items share in the first have to be shared in the second, too.

    Parameters
    ----------
    was, now : Mechanism
        Two mechanisms with the same number of bodies, beams and items.
    """

    def __init__(self, was: Mechanism, now: Mechanism) -> None:
        self._pairs: dict[int, Any] = {}
        self._back: dict[int, int] = {}
        self._numbers: set[int] = set()
        first, second = ((*m.bodies, *m.beams, *m.items) for m in (was, now))
        for a, b in zip(first, second, strict=True):
            self._pair(a, b)
        self._items = set(self._pairs)

    def _pair(self, a: Any, b: Any) -> bool:
        """Note that two objects correspond; return whether this fits to the earlier ones."""
        known = self._pairs.setdefault(id(a), b)
        return known is b and self._back.setdefault(id(b), id(a)) == id(a)

    def differing(self, a: Any, b: Any) -> list[str] | None:
        """Return the fields in which two items differ; None if they are of another class."""
        if a is b:
            return []
        if type(a) is not type(b) or not self._pair(a, b):
            return None
        x, y = vars(a), vars(b)
        return [key for key in own_fields(type(a)) if not self.same(x.get(key), y.get(key))]

    def same(self, a: Any, b: Any) -> bool:
        """Return whether two values are equal to the last bit and refer to equal objects."""
        if a is b:
            return True
        kind = type(a)
        if kind is not type(b):
            return False
        if kind is float:
            return bool(a == b and (a or np.copysign(1.0, a) == np.copysign(1.0, b)))
        if kind in PLAIN:
            return bool(a == b)
        if kind is np.ndarray:
            same = a.shape == b.shape and a.dtype == b.dtype
            return bool(same and a.tobytes() == b.tobytes())
        if kind in (tuple, list):
            return len(a) == len(b) and all(map(self.same, a, b))
        if isinstance(a, Mapping):
            return list(a) == list(b) and all(map(self.same, a.values(), b.values()))
        if id(a) in self._items:
            return self._pairs[id(a)] is b
        if isinstance(a, frozenset):
            return bool(a == b)
        return is_dataclass(a) and self._same_object(a, b)

    def _same_object(self, a: Any, b: Any) -> bool:
        """Return whether two objects have equal fields."""
        if id(a) in self._pairs and isinstance(a, Declared):
            return self._pairs[id(a)] is b and id(a) not in self._numbers
        if isinstance(a, Declared) and not self._pair(a, b):
            return False
        x, y = vars(a), vars(b)
        for key in own_fields(type(a)):
            if key not in x or key not in y or not self.same(x[key], y[key]):
                self._numbers.add(id(a))
                return False
        return True


_FIELDS: dict[type, tuple[str, ...]] = {}


def own_fields(kind: type) -> tuple[str, ...]:
    """Return the names of the fields of a class, without cached values (known ones at once)."""
    if kind not in _FIELDS:
        _FIELDS[kind] = tuple(one.name for one in fields(kind))
    return _FIELDS[kind]
