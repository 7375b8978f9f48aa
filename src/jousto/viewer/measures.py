"""Measures for colours and plots: names on the page, stress criteria, units."""

from __future__ import annotations

from jousto.base.voigt import STRESS_COMPONENTS

CRITERIA = {
    "von-mises": "von-mises",
    "signed-von-mises": "signed-von-mises",
    "principal-max": "principal-1",
    "principal-min": "principal-3",
    **{name: name for name in STRESS_COMPONENTS},
}
"""Stress criteria by their names on the page."""
SHIFTS = ("ux", "uy", "uz")
NUMBERED = (*CRITERIA, "displacement", *SHIFTS, "x", "y", "z", "damage")
"""Measures with a history at a point."""


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
