"""Cache of reductions in memory, with their input as key, for many variants of a model."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from jousto.reduction.files.cache import NotHashable, key
from jousto.reduction.reduced import ReducedPart

MOST = 64
"""Largest number of reduced parts in the cache; the oldest is removed first."""


class Recalled:
    """Reduced parts in memory, by the content of their input.

    Attributes
    ----------
    made : int
        Reductions that were computed.
    found : int
        Reductions that were found in the cache.
    """

    def __init__(self) -> None:
        self.made = 0
        self.found = 0
        self._parts: dict[str, ReducedPart] = {}

    def get(self, things: tuple[object, ...], make: Callable[[], ReducedPart]) -> ReducedPart:
        """Return the result for an input from the cache, or compute and store it."""
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
    """Return the active cache; None outside of `recalling`."""
    return _CURRENT.get()


@contextmanager
def recalling(memory: Recalled) -> Iterator[None]:
    """Use a cache in all calls of `reduce` within the block."""
    token = _CURRENT.set(memory)
    try:
        yield
    finally:
        _CURRENT.reset(token)
