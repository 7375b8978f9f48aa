"""Assembly: a group of items that is added to a mechanism as one argument."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from jousto.base.declare import Declared
from jousto.base.fields import kept
from jousto.mechanism.bodies.marker import Marker


class Assembly(Declared):
    """Group of items whose names share a prefix, such as a robot.

    Attributes
    ----------
    items : tuple
        Bodies, joints, forces and sensors, as accepted by `Mechanism`.
    prefix : str
        Prefix of the names of the items.
    """

    prefix: str
    items: tuple[Any, ...] = kept()

    @property
    def named(self) -> dict[str, Marker]:
        """Markers of the assembly by name; the names have the prefix of the assembly."""
        return {}


def unpacked(items: Sequence[Any]) -> Iterator[Any]:
    """Yield the items, with the items of an assembly in place of each assembly.

    An assembly whose prefix was used before is skipped.
    """
    seen: set[str] = set()
    for item in items:
        if not isinstance(item, Assembly):
            yield item
        elif item.prefix not in seen:
            seen.add(item.prefix)
            yield from item.items
