"""Virtual rosettes: two or three gauges at one position."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.arrays import Array, read_only
from jousto.base.errors import InputError, Problems
from jousto.base.fields import Field, field
from jousto.base.names import check_name
from jousto.base.numbers import set_fields
from jousto.mechanism.sensors.base import Reading
from jousto.mechanism.sensors.gauge import Attached, Gauge, Heading, outward
from jousto.mechanism.signals.base import Signal

if TYPE_CHECKING:
    from jousto.reduction.reduced import ReducedPart

ANGLES = {"45": (0.0, 45.0, 90.0), "60": (0.0, 60.0, 120.0), "90": (0.0, 90.0)}
"""Directions of the grids in degrees, counterclockwise seen from outside."""

KINDS = {**{kind: kind for kind in ANGLES}, "rectangular": "45", "delta": "60", "tee": "90"}


class Pattern(Field[str, str]):
    """Field of the angle between the grids."""

    form = "text"
    noun = '{"45", "60", "90"}'

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the angle as a keyword, or report an unknown one."""
        if str(value) not in KINDS:
            problems.add(
                where, f"kind is {value!r}, must be '45', '60' (delta) or '90' (tee)", "kind"
            )
        return KINDS.get(str(value))


class Rosette(Attached, tag="rosette"):
    """Virtual rosette on a flexible body, (3,) or (2,) m/m: stacked grids a, b, c.

    Grid a lies along the direction, the others are rotated counterclockwise as seen from outside
    the body. `rosette_state` computes strains, stresses and principal directions from its values.

    Attributes
    ----------
    grids : tuple of Gauge
        Gauge of each grid, with position and axis.
    """

    kind: Pattern = field(  # type: ignore[misc]  # what messages say first is in heading()
        "Angle between the grids: rectangular (0, 45, 90), delta (0, 60, 120), or a tee of two "
        'grids for known principal directions; also ``"rectangular"``, ``"delta"``, ``"tee"``',
        default="45",
        kw_only=True,
    )
    normal: Heading = field(
        "Outward normal on beams, part frame; None for away from the middle of the section",
        default=None,
        kw_only=True,
    )

    if TYPE_CHECKING:

        @property
        def grids(self) -> tuple[Gauge, ...]: ...  # noqa: D102

    def heading(self, problems: Problems) -> str:
        """Return the prefix of messages."""
        return check_name(problems, "rosette", self.name)

    def consistent(self, problems: Problems, where: str) -> None:
        """Place the grids in the plane of the surface."""
        keys = ("length", "width", "transverse", "temperature", "reach", "E", "nu")
        shared: dict[str, Any] = {key: getattr(self, key) for key in keys}
        gauge = f"{Gauge.kind} {self.name!r}"
        try:
            first = Gauge(self.name, self.body, self.at, self.direction, **shared)
            n = outward(first, self.normal)
            a = first.axis - (first.axis @ n) * n
            a /= np.linalg.norm(a)
            b = np.cross(n, a)
            angles = np.radians(ANGLES[self.kind])
            directions = [np.cos(t) * a + np.sin(t) * b for t in angles]
            grids = tuple(Gauge(self.name, self.body, self.at, d, **shared) for d in directions)
        except InputError as error:
            raise InputError(
                [replace(p, where=where) if p.where == gauge else p for p in error.problems]
            ) from None
        set_fields(self, normal=read_only(n), grids=grids)

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the grids."""
        return ("a", "b", "c")[: len(self.grids)]

    @property
    def position(self) -> Array:
        """Position of the rosette, part frame, m."""
        return self.grids[0].position

    @property
    def axis(self) -> Array:
        """Unit vector along grid a, part frame."""
        return self.grids[0].axis

    @property
    def reduced(self) -> ReducedPart:
        """Part on which the rosette is placed."""
        return self.grids[0].reduced

    @property
    def rows(self) -> Array:
        """Strain of each grid per unit modal coordinate, (3, n) or (2, n)."""
        return read_only(np.concatenate([grid.rows for grid in self.grids]))

    @property
    def signal(self) -> Signal | None:
        """Apparent strain as a function of time."""
        return self.grids[0].signal

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading("stress", self.body, self.signal, rows=self.rows)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        angles = "/".join(f"{angle:g}" for angle in ANGLES[self.kind])
        return f"rosette {angles} deg, " + self.grids[0].description

    def placed(self, reduced: ReducedPart) -> tuple[Array, Array, Array]:
        """Return position, axis of grid a and rows on a part, see `Gauge.placed`."""
        found = [grid.placed(reduced) for grid in self.grids]
        return found[0][0], found[0][1], np.stack([rows for _, _, rows in found])
