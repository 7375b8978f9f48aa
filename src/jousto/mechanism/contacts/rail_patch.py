"""Places where a wheel may touch its rail: shape, ellipse of Hertz, creep coefficients."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

from jousto.base.object_repr import described
from jousto.mechanism.contacts.creep import CreepCoefficients, creep_coefficients
from jousto.mechanism.contacts.hertz import HertzScale, point_scale


@described
@dataclass(frozen=True)
class RailPatch:
    """A place of contact of a wheel on its rail, the tread or the flange.

    Parameters
    ----------
    centre : tuple of float
        Centre of the arc of the rail in the frame of the rail, across and up, m.
    head : float
        Radius of that arc, m.
    place, radius : float
        A point of the section of the wheel: along the axle from marker b, and its radius, m.
    slope : float
        Increase of the radius along the axle over the length there.
    curvature : float
        Curvature of the section, 1/m, positive if it is convex, 0 for a cone.
    rolling : float
        Radius of the wheel where it touches, m.
    E, nu : float
        Young's modulus, Pa, and Poisson's ratio of both bodies.

    Attributes
    ----------
    radii : tuple of float
        Relative radii of curvature along and across the rail, m.
    scale : HertzScale
        Pressure, half axes and approach under 1 N.
    coefficients : CreepCoefficients
        C11, C22, C23, C33 of Kalker's linear theory.
    """

    centre: tuple[float, float]
    head: float
    place: float
    radius: float
    slope: float
    curvature: float
    rolling: float
    E: float
    nu: float

    @property
    def radii(self) -> tuple[float, float]:
        """Relative radii along and across: the wheel's is that of its normal section."""
        along = self.rolling * math.sqrt(1.0 + self.slope**2)
        return along, 1.0 / (1.0 / self.head + self.curvature)

    @cached_property
    def scale(self) -> HertzScale:
        """Hertz's contact under 1 N."""
        return point_scale(self.E / (2.0 * (1.0 - self.nu**2)), self.radii)

    @cached_property
    def coefficients(self) -> CreepCoefficients:
        """Coefficients for the half axes of the ellipse."""
        return creep_coefficients(self.scale.a / self.scale.b, self.nu)

    @property
    def numbers(self) -> tuple[float, ...]:
        """Numbers of the engine (``jo_rail_patch``)."""
        one, (C11, C22, C23, C33) = self.scale, self.coefficients
        G, area = self.E / (2.0 * (1.0 + self.nu)), one.a * one.b
        # N = K d^1.5: N^(1/3) = K^(1/3) d^0.5 times the half axes under 1 N
        K = one.approach**-1.5
        creep = (
            G * area * C11 * K ** (2 / 3),
            G * area * C22 * K ** (2 / 3),
            G * area**1.5 * C23 * K,
            G * area**2 * C33 * K ** (4 / 3),
        )
        hertz = (x * K ** (1 / 3) for x in (one.p0, one.a, one.b))
        shape = (*self.centre, self.head, self.place, self.radius, self.slope, self.curvature)
        return (*shape, K, *creep, *hertz)
