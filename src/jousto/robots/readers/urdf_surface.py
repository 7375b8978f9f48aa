"""Friction and springs of links that ``<gazebo reference=...>`` blocks of URDF files contain."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from jousto.robots.description import Link
from jousto.robots.readers.xml import Element, Reading
from jousto.robots.softness import Spring

NUMBERS = ("mu1", "mu", "mu2", "kp", "kd")
SPRINGS = ("kp", "kd")
UNREAD = ("minDepth", "maxVel")
"""Words on springs that belong to the solver of another program."""


def with_surfaces(reading: Reading, root: Element, links: list[Link]) -> list[Link]:
    """Return the links with friction and softness of the blocks that refer to them."""
    blocks: dict[str, list[Element]] = {}
    for block in root.all("gazebo"):
        blocks.setdefault(block.given.get("reference", ""), []).extend(block.children)
    return [
        replace(
            link,
            collisions=tuple(
                replace(one, **surface_of(reading, blocks.get(link.name, ())))
                for one in link.collisions
            ),
        )
        for link in links
    ]


def surface_of(reading: Reading, words: Any) -> dict[str, Any]:
    """Return friction, softness and unread words from the elements of a block."""
    x = {word.tag: read_number(reading, word) for word in words if word.tag in NUMBERS}
    soft: dict[str, Any] = {key: x[key] for key in SPRINGS if key in x}
    unread = [*soft, *(word.tag for word in words if word.tag in UNREAD)]
    friction = x.get("mu1", x.get("mu", 1.0))
    if x.get("mu2", friction) != friction:
        unread.append("mu2")
    return {
        "friction": friction,
        "softness": Spring(**soft),
        "unread": tuple(dict.fromkeys(unread)),
    }


def read_number(reading: Reading, element: Element) -> float:
    """Return the number in an element, which must not be negative; 0 with an error."""
    x = float(reading.numbers(element, element.text, element.tag, 1, None)[0])
    if x < 0.0:
        reading.add(element, f"{element.tag} is {x:g}, must not be negative")
        return 0.0
    return x
