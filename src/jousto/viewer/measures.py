"""What bodies are coloured by and plotted: the page's names, those of criteria, units."""

from __future__ import annotations

CRITERIA = {
    "von-mises": "von-mises",
    "signed-von-mises": "signed-von-mises",
    "principal-max": "principal-1",
    "principal-min": "principal-3",
    **{name: name for name in ("s11", "s22", "s33", "s12", "s23", "s13")},
}
"""Criteria of stress by the names of the page."""
SHIFTS = ("ux", "uy", "uz")
NUMBERED = (*CRITERIA, "displacement", *SHIFTS, "x", "y", "z", "damage")
"""What has a history at a point."""


def unit_of(name: str) -> str:
    """Return the unit of a measure.

    Examples
    --------
    >>> unit_of("von-mises"), unit_of("ux"), unit_of("damage"), unit_of("life")
    ('Pa', 'm', '1', 's')
    """
    if name in CRITERIA:
        return "Pa"
    return {"damage": "1", "life": "s"}.get(name, "m")
