"""Softness of contacts in MJCF: ``solref``, ``solimp``, ``solmix``, ``priority`` and ``margin``."""

from __future__ import annotations

from typing import Any

from jousto.robots.readers.xml import Element, Reading
from jousto.robots.softness import SoftConstraint


def soft_words(reading: Reading, given: Element) -> dict[str, Any]:
    """Return the fields of a `SoftConstraint` that a geom or a pair gives.

    Numbers that are missing at the end of ``solref`` and ``solimp`` have their defaults; wrong ones
    are reported.
    """
    found: dict[str, Any] = {}
    usual = SoftConstraint()
    for word in ("solref", "solimp"):
        listed = reading.list(given, word) if word in given.given else None
        if listed is None:
            if word in given.given:
                reading.add(given, f"{word} is {given.given[word]!r}, must be numbers")
            continue
        numbers: tuple[float, ...] = getattr(usual, word)
        if len(listed) > len(numbers):
            reading.add(given, f"{word} has {len(listed)} numbers, at most {len(numbers)}")
            continue
        found[word] = (*map(float, listed), *numbers[len(listed) :])
    if (found.get("solref", usual.solref)[0] > 0.0) != (found.get("solref", usual.solref)[1] > 0.0):
        reading.note(given, "solref mixes a positive and a negative number; its default is taken")
        del found["solref"]
    if found.get("solref", usual.solref)[0] == 0.0:
        reading.note(given, "solref has no stiffness; its default is taken")
        del found["solref"]
    if (low_high := found.get("solimp", usual.solimp))[0] > low_high[1]:
        reading.note(given, "solimp falls with the depth; its second number is taken throughout")
    for word, name in (("solmix", "mix"), ("margin", "margin")):
        if word in given.given:
            found[name] = reading.number(given, word)
            if found[name] < 0.0:
                reading.add(given, f"{word} is {found[name]:g}, must not be negative")
                del found[name]
    if "priority" in given.given:
        found["priority"] = int(reading.number(given, "priority"))
    return found
