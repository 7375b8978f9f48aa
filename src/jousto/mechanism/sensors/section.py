"""Sensors of the section resultants and strains of exact beams."""

from __future__ import annotations

import re
from functools import cached_property
from typing import Any

import numpy as np

from jousto.base.errors import Problems
from jousto.base.fields import Choice, Field, field
from jousto.base.numbers import number, set_fields
from jousto.mechanism.beams.body import BeamBody
from jousto.mechanism.forces.line_load import BeamField
from jousto.mechanism.sensors.base import Reading, Sensor

RESULTANTS = ("N", "Qy", "Qz", "Mx", "My", "Mz")
"""Resultants of a section: N along the beam, shear forces, torque and bending moments."""
STRAINS = ("Gamma_x", "Gamma_y", "Gamma_z", "kappa_x", "kappa_y", "kappa_z")
QUANTITIES = {"resultants": RESULTANTS, "strains": STRAINS}
PLACES = {"start": 0.0, "middle": 0.5, "end": 1.0}


class Along(Field["str | float | None", "str | float | None"]):
    """Field of a position along a beam."""

    form = "along"
    noun = '"start", "middle", "end" or float'


class Element(Field["int | str | None", int]):
    """Field of an element: index from 0, or label such as ``"e4"``, which counts from 1."""

    form = "element"
    noun = "int or str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the index, or report what is wrong."""
        if isinstance(value, str) and re.fullmatch(r"e[1-9]\d*", value):
            return int(value[1:]) - 1
        if isinstance(value, bool) or not isinstance(value, int | np.integer):
            problems.add(
                where, f"{self.name} is {value!r}, must be a whole number or a label such as 'e4'"
            )
        return value


class SectionSensor(Sensor, tag="section"):
    """Resultants ``[N, Qy, Qz, Mx, My, Mz]`` of a beam section (6,), N and N m, or strains.

    The resultants are resolved in section axes, about the reference axis of the section. They act
    from the part of the beam towards its end on the part towards its start; tension is positive. At
    the start, the end and the nodes they follow from the equilibrium of the adjacent element, as in
    `section_forces`: the force of the element, and the moment in its middle plus force times lever
    arm. Strains, and resultants between two nodes, refer to the middle of the element.
    """

    beam: BeamField = field("The beam")
    at: Along = field(
        "Position, the middle by default; or the distance from the start along the unstressed "
        "axis, m. At a node the resultants are those on the side towards the end; within an "
        "element those of its middle",
        default=None,
    )
    element: Element = field(
        "Element, for the values in its middle, in place of `at`: its label such as ``e4``, as in "
        "hot spots, or its index from 0; -1 is the last",
        default=None,
        kw_only=True,
    )
    quantity: Choice = field(
        "Resultants, or strains ``[Gamma_x, Gamma_y, Gamma_z]`` m/m and ``[kappa_x, kappa_y, "
        "kappa_z]`` rad/m of the reference axis, minus those of the unstressed beam",
        words=("resultants", "strains"),
        default="resultants",
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Find the element."""
        at, element = self.at, vars(self)["element"]
        if at is not None and element is not None:
            problems.add(where, "give either at, a position along the beam, or element, not both")
        if at is None and element is None:
            at = "middle"
        place = _element(problems, where, self.beam, at, element)
        set_fields(self, element=place)

    @cached_property
    def end(self) -> int | None:
        """End of the element, 0 or 1; None for its middle."""
        return None if self.quantity == "strains" else _end(self.beam, self.at, self.element)

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
        """Index of the first component among strains, resultants and those at both ends."""
        if self.quantity == "strains":
            return 0
        return 6 if self.end is None else 12 + 6 * self.end

    @property
    def frame(self) -> str:
        """Name of the axes in which the components are resolved."""
        return "section"

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading("section", self.beam, self.first, at=self.element)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        share = 0.5 if self.end is None else self.end
        s = float(self.beam.s[self.element] + self.beam.lengths[self.element] * share)
        place = f"element e{self.element + 1}, {s:.4g} m from start"
        return f"{self.quantity} of {self.beam.name}, {place}"


def _end(beam: BeamBody, at: Any, element: int) -> int | None:
    """Return the end of the element, 0 or 1, at a position; None for its middle."""
    if at is None or at == "middle":
        return None
    s = PLACES[at] * beam.length if isinstance(at, str) else float(at)
    apart = np.abs(beam.s[element : element + 2] - s) / beam.length
    return int(apart.argmin()) if apart.min() < 1e-9 else None


def _element(problems: Problems, where: str, beam: BeamBody, at: Any, element: Any) -> int:
    """Return the number of the element, or report that it does not exist."""
    n = beam.n
    if at is None:
        if not -n <= element < n:
            problems.add(
                where,
                f"element {element}: beam {beam.name!r} has 0 to {n - 1}, e1 to e{n}",
                "element",
            )
        else:
            return int(element) % n
        return 0
    if isinstance(at, str):
        if at not in PLACES:
            problems.add(
                where, f"at is {at!r}, must be 'start', 'middle', 'end' or a length in m", "at"
            )
            return 0
        s: float | None = PLACES[at] * beam.length
    else:
        s = number(problems, where, "at", at)
    if s is None:
        return 0
    if not 0.0 <= s <= beam.length * (1 + 1e-9):
        problems.add(
            where, f"at is {s:g} m, beam {beam.name!r} goes from 0 to {beam.length:g} m", "at"
        )
    nearest = int(np.abs(beam.s - s).argmin())
    if abs(beam.s[nearest] - s) < 1e-9 * beam.length:
        return min(nearest, n - 1)
    return min(int(np.searchsorted(beam.s, s, side="right")) - 1, n - 1)
