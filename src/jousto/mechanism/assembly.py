"""Assembly: items that a mechanism takes together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from jousto.base.declare import Declared
from jousto.base.fields import kept
from jousto.mechanism.bodies.marker import Marker


class Assembly(Declared):
    """Items that belong together and have names that begin alike, such as a robot.

    Attributes
    ----------
    items : tuple
        Bodies, joints, forces and sensors, as `Mechanism` takes them.
    prefix : str
        What their names begin with.
    """

    prefix: str
    items: tuple[Any, ...] = kept()

    @property
    def named(self) -> dict[str, Marker]:
        """Markers by names that begin with the prefix."""
        return {}


def unpacked(items: Sequence[Any]) -> Iterator[Any]:
    """Yield items, those of an assembly in its place; of two with one prefix only the first."""
    seen: set[str] = set()
    for item in items:
        if not isinstance(item, Assembly):
            yield item
        elif item.prefix not in seen:
            seen.add(item.prefix)
            yield from item.items
