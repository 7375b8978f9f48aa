"""The elements of planar frames by their words."""

from __future__ import annotations

from jousto.base.errors import Problems, suggest
from jousto.planar.ancf import AncfElement
from jousto.planar.corotational import CorotationalElement
from jousto.planar.element import PlanarElement
from jousto.planar.exact import ExactElement

ELEMENTS: dict[str, PlanarElement] = {
    kind.word: kind() for kind in (ExactElement, CorotationalElement, AncfElement)
}
"""Each element with its default options, by its word."""


def find_element(problems: Problems, where: str, value: object) -> PlanarElement | None:
    """Return the element of a word or an element itself, or report what the value is."""
    if isinstance(value, PlanarElement) and type(value) is not PlanarElement:
        return value
    if isinstance(value, str) and value in ELEMENTS:
        return ELEMENTS[value]
    hint = suggest(value, ELEMENTS) if isinstance(value, str) else ""
    known = ", ".join(f"'{word}'" for word in ELEMENTS)
    text = f"element is {value!r}, must be {known} or a PlanarElement, as AncfElement(){hint}"
    problems.add(where, text)
    return None
