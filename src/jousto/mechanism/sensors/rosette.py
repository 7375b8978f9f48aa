"""Virtual rosettes: two or three gauges at one place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.described import described
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.names import check_name
from jousto.base.numbers import set_fields
from jousto.base.rotations import Array, readonly
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.sensors.gauge import Gauge, outward
from jousto.mechanism.sensors.temperature import Temperature
from jousto.mechanism.signals.base import Signal

if TYPE_CHECKING:
    from jousto.reduction.reduced import ReducedPart

ANGLES = {"45": (0.0, 45.0, 90.0), "60": (0.0, 60.0, 120.0), "90": (0.0, 90.0)}
"""Directions of the grids in degrees, counterclockwise seen from outside."""

KINDS = {**{kind: kind for kind in ANGLES}, "rectangular": "45", "delta": "60", "tee": "90"}


@described
@dataclass(frozen=True, eq=False, init=False)
class Rosette:
    """A virtual rosette on a flexible body, (3,) or (2,) m/m: stacked grids a, b, c.

    Grid a lies along the direction, the others are turned counterclockwise as seen from outside
    the body. `rosette_state` makes strains, stresses and principal directions of its values.

    Parameters
    ----------
    name, body, at, length, width, transverse, reach, E, nu, temperature
        As of a `Gauge`.
    direction : (3,) array_like, optional
        Along grid a, part frame; None is along the beam.
    kind : {"45", "60", "90"}
        Angle between the grids: rectangular (0, 45, 90), delta (0, 60, 120), or a tee of two
        grids for known principal directions; also ``"rectangular"``, ``"delta"``, ``"tee"``.
    normal : (3,) array_like, optional
        Outward normal on beams, part frame; away from the middle of the section if not given.

    Attributes
    ----------
    grids : tuple of Gauge
        One for each grid, with position and axis.
    """

    unit: ClassVar[str] = "m/m"
    frame: ClassVar[str] = "gauge"
    name: str
    body: FlexibleBody | ReducedPart
    at: str | Array
    kind: str
    direction: Array | None
    normal: Array
    grids: tuple[Gauge, ...]
    temperature: Temperature | None

    def __init__(
        self,
        name: str,
        body: FlexibleBody | ReducedPart,
        at: str | ArrayLike,
        direction: ArrayLike | None = None,
        *,
        kind: str = "45",
        normal: ArrayLike | None = None,
        length: float = 0.0,
        width: float = 0.0,
        transverse: float = 0.0,
        temperature: Temperature | None = None,
        reach: float | None = None,
        E: float | None = None,
        nu: float | None = None,
    ) -> None:
        problems = Problems()
        where = check_name(problems, "rosette", name)
        if str(kind) not in KINDS:
            problems.add(where, f"kind is {kind!r}, must be '45', '60' (delta) or '90' (tee)")
        up = None if normal is None else problems.array(where, "normal", normal, (3,))
        if up is not None and not np.any(up):
            problems.add(where, "normal is zero")
        problems.raise_if_any()
        chosen = KINDS[str(kind)]
        shared: dict[str, Any] = {
            "length": length,
            "width": width,
            "transverse": transverse,
            "temperature": temperature,
            "reach": reach,
            "E": E,
            "nu": nu,
        }
        try:
            first = Gauge(name, body, at, direction, **shared)
            n = outward(first, up)
            # in the plane of the surface
            a = first.axis - (first.axis @ n) * n
            a /= np.linalg.norm(a)
            b = np.cross(n, a)
            angles = np.radians(ANGLES[chosen])
            directions = [np.cos(t) * a + np.sin(t) * b for t in angles]
            grids = tuple(Gauge(name, body, at, d, **shared) for d in directions)
        except InputError as error:
            raise InputError(
                [Problem(where if "'" in p.where else p.where, p.message) for p in error.problems]
            ) from None
        set_fields(
            self,
            name=name,
            body=body,
            at=first.at,
            kind=chosen,
            direction=first.direction,
            normal=readonly(n),
            grids=grids,
            temperature=temperature,
        )

    @property
    def components(self) -> tuple[str, ...]:
        """Names of the grids."""
        return ("a", "b", "c")[: len(self.grids)]

    @property
    def position(self) -> Array:
        """Where it sticks, part frame, m."""
        return self.grids[0].position

    @property
    def axis(self) -> Array:
        """Unit vector along grid a, part frame."""
        return self.grids[0].axis

    @property
    def reduced(self) -> ReducedPart:
        """The part it sticks to."""
        return self.grids[0].reduced

    @property
    def rows(self) -> Array:
        """Strain of each grid per unit modal coordinate, (3, n) or (2, n)."""
        return readonly(np.concatenate([grid.rows for grid in self.grids]))

    @property
    def signal(self) -> Signal | None:
        """Apparent strain over time."""
        return self.grids[0].signal

    @property
    def description(self) -> str:
        """One line for results and plots."""
        angles = "/".join(f"{angle:g}" for angle in ANGLES[self.kind])
        return f"rosette {angles} deg, " + self.grids[0].description

    def placed(self, reduced: ReducedPart) -> tuple[Array, Array, Array]:
        """Return position, axis of grid a and rows on a part, see `Gauge.placed`."""
        found = [grid.placed(reduced) for grid in self.grids]
        return found[0][0], found[0][1], np.stack([rows for _, _, rows in found])
