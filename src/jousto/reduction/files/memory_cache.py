"""Reductions remembered while many variants of a model are made, by what they are made of."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from jousto.reduction.files.cache import NotHashable, key
from jousto.reduction.reduced import ReducedPart

MOST = 64
"""Reduced parts that are kept; the one made first goes first."""


class Recalled:
    """Reduced parts by the content of what they are made of.

    Attributes
    ----------
    made : int
        Reductions that were computed.
    found : int
        Those that were asked for again.
    """

    def __init__(self) -> None:
        self.made = 0
        self.found = 0
        self._parts: dict[str, ReducedPart] = {}

    def get(self, things: tuple[object, ...], make: Callable[[], ReducedPart]) -> ReducedPart:
        """Return what was made of the same things before, or make it."""
        try:
            place = key(*things)
        except NotHashable:
            self.made += 1
            return make()
        if place in self._parts:
            self.found += 1
            return self._parts[place]
        self.made += 1
        reduced = make()
        self._parts[place] = reduced
        while len(self._parts) > MOST:
            del self._parts[next(iter(self._parts))]
        return reduced


_CURRENT: ContextVar[Recalled | None] = ContextVar("recalled", default=None)


def current() -> Recalled | None:
    """Return what remembers reductions here, None outside of `recalling`."""
    return _CURRENT.get()


@contextmanager
def recalling(memory: Recalled) -> Iterator[None]:
    """Let `reduce` look up what it made before within the block."""
    token = _CURRENT.set(memory)
    try:
        yield
    finally:
        _CURRENT.reset(token)
