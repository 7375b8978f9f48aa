"""Frozen: an immutable mapping that can be pickled."""

from __future__ import annotations

from collections.abc import ItemsView, Iterator, KeysView, Mapping, ValuesView
from typing import TypeVar

from jousto.base.object_repr import FEW, LIMIT

K = TypeVar("K")
V = TypeVar("V")


class Frozen(Mapping[K, V]):
    """Immutable mapping; unlike `types.MappingProxyType` it can be pickled.

    Examples
    --------
    >>> Frozen({"a": 1})["a"]
    1
    """

    __slots__ = ("_items",)

    def __init__(self, items: Mapping[K, V]) -> None:
        self._items = dict(items)

    def __getitem__(self, key: K) -> V:
        return self._items[key]

    def __iter__(self) -> Iterator[K]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __contains__(self, key: object) -> bool:
        return key in self._items

    def keys(self) -> KeysView[K]:
        """Return the keys, as in a dictionary."""
        return self._items.keys()

    def values(self) -> ValuesView[V]:
        """Return the values, as in a dictionary."""
        return self._items.values()

    def items(self) -> ItemsView[K, V]:
        """Return keys and values, as in a dictionary."""
        return self._items.items()

    def __repr__(self) -> str:
        shown = repr(self._items)
        if len(shown) < LIMIT and "array(" not in shown:
            return shown
        n = len(self._items)
        few = ", ".join(repr(key) for key in list(self._items)[:FEW])
        return f"<{n} {'entry' if n == 1 else 'entries'}: {few}{', ...' * (n > FEW)}>"
