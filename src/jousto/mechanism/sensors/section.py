"""Sensors of the resultants and strains of beams."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.errors import Problems
from jousto.mechanism.beam import BeamBody
from jousto.mechanism.fields import check_name, number, set_fields

RESULTANTS = ("N", "Qy", "Qz", "Mx", "My", "Mz")
STRAINS = ("Gamma_x", "Gamma_y", "Gamma_z", "kappa_x", "kappa_y", "kappa_z")
QUANTITIES = {"resultants": RESULTANTS, "strains": STRAINS}
PLACES = {"start": 0.0, "middle": 0.5, "end": 1.0}


@dataclass(frozen=True, eq=False, init=False)
class SectionSensor:
    """Resultants ``[N, Qy, Qz, Mx, My, Mz]`` of a beam's section (6,), N and N m, or its strains.

    In the middle of an element, where they are most accurate, in section axes and about the
    section's reference axis. What the part of the beam towards its end exerts on the part towards
    its start: tension is positive.

    Parameters
    ----------
    name : str
        Name, unique among the sensors.
    beam : BeamBody
        The beam.
    at : "start", "middle", "end" or float, optional
        Where, the middle if nothing is given: its first, middle or last element, or the element at
        that distance from the start along the unstressed axis, m.
    element : int, optional
        The element itself instead, from 0; -1 is the last.
    quantity : "resultants" or "strains"
        Strains are ``[Gamma_x, Gamma_y, Gamma_z]`` m/m and ``[kappa_x, kappa_y, kappa_z]`` rad/m
        of the reference axis, less those of the unstressed beam.
    """

    name: str
    beam: BeamBody
    element: int
    quantity: str

    def __init__(
        self,
        name: str,
        beam: BeamBody,
        at: str | float | None = None,
        *,
        element: int | None = None,
        quantity: str = "resultants",
    ) -> None:
        problems = Problems()
        where = check_name(problems, "sensor", name)
        checked: Any = beam
        if not isinstance(checked, BeamBody):
            problems.add(where, f"beam is {checked!r}, must be a BeamBody")
            problems.raise_if_any()
        if quantity not in QUANTITIES:
            problems.add(where, f"quantity is {quantity!r}, must be 'resultants' or 'strains'")
        if at is not None and element is not None:
            problems.add(where, "give at, a place along the beam, or element, its number, not both")
        if at is None and element is None:
            at = "middle"
        place = _element(problems, where, beam, at, element)
        problems.raise_if_any()
        set_fields(self, name=name, beam=beam, element=place, quantity=quantity)

    @property
    def unit(self) -> str:
        """Units of the two halves of the components."""
        return "N, N m" if self.quantity == "resultants" else "m/m, rad/m"

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the components."""
        return QUANTITIES[self.quantity]

    @property
    def first(self) -> int:
        """Place of the first component among strains and resultants."""
        return 6 if self.quantity == "resultants" else 0

    @property
    def frame(self) -> str:
        """Name of the axes that the components are in."""
        return "section"

    @property
    def description(self) -> str:
        """One line for results and plots."""
        s = float(self.beam.s[self.element] + self.beam.lengths[self.element] / 2)
        return f"{self.quantity} of {self.beam.name}, element {self.element}, {s:.4g} m from start"


def _element(problems: Problems, where: str, beam: BeamBody, at: Any, element: Any) -> int:
    """Return the number of the element, or note why there is none."""
    n = beam.n
    if at is None:
        if isinstance(element, bool) or not isinstance(element, int | np.integer):
            problems.add(where, f"element is {element!r}, must be a whole number")
        elif not -n <= element < n:
            problems.add(where, f"element {element}: beam {beam.name!r} has 0 to {n - 1}")
        else:
            return int(element) % n
        return 0
    if isinstance(at, str):
        if at not in PLACES:
            problems.add(where, f"at is {at!r}, must be 'start', 'middle', 'end' or a length in m")
            return 0
        s: float | None = PLACES[at] * beam.length
    else:
        s = number(problems, where, "at", at)
    if s is None:
        return 0
    if not 0.0 <= s <= beam.length * (1 + 1e-9):
        problems.add(where, f"at is {s:g} m, beam {beam.name!r} goes from 0 to {beam.length:g} m")
    return min(int(np.searchsorted(beam.s, s, side="right")) - 1, n - 1)
