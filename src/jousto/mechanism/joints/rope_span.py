"""Length of rope between two sheaves, as a coordinate."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from jousto.base.arrays import Array
from jousto.base.complexstep import arctan2, floats, scalar
from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.base import aligned
from jousto.mechanism.joints.coordinate import Coordinate

SEARCH = 30
"""Largest number of iterations for the direction of a rope."""
FOUND = 1e-24
"""Square of the change of a unit vector at which it is found."""
STRAIGHT = 1e-9
"""Angle, rad, by which a straight rope may turn by rounding."""
PARALLEL = 1e-3
"""Sine of the angle between rope and axle below which the rope does not run over the sheave."""


class RopeSpan(Coordinate, tag="rope-span"):
    """Length of rope from sheave a to sheave b along their common tangent, m.

    The axle of a sheave is the z axis of its marker. Its radius is positive where the rope runs
    about this axis by the right hand on its way from a to b, negative where it runs the other way,
    and 0 for a point. The value is the length of the straight part, plus the rope that has come
    onto the rims since the initial pose because the rope has turned against them. The sum over all
    spans of a rope is its length but for a constant, and a tension T along all of them acts on
    every sheave as the rope does.

    Sheaves may turn and move in space. The rope leaves the rim where it is tangent to it; out of
    the plane of the sheave by an angle f, the radius counts as ``R / cos f``. The directions at
    which the rope leaves the sheaves may turn by less than half a turn from the initial ones.

    Examples
    --------
    >>> from jousto import RigidBody, ground
    >>> load = RigidBody("load", 10.0, (1, 1, 1), position=(0.3, -4, 0))
    >>> span = RopeSpan(ground["origin"], load["origin"], -0.3)  # down on the right
    >>> round(span.initial, 12)
    4.0
    """

    engine: ClassVar[str] = "rope"
    radius_a: Number = field(
        "Radius of the sheave at a, negative for the other sense of the rope; 0 for a point",
        unit="m",
        default=0.0,
    )
    radius_b: Number = field("The same of the sheave at b", unit="m", default=0.0)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report sheaves inside one another and ropes along an axle; turn x along the rope."""
        super().consistent(problems, where)
        e = self.direction
        if problem := misfit(self.a, self.b, self.radius_a, self.radius_b, e):
            problems.add(where, problem)
            return
        for key, radius in (("a", self.radius_a), ("b", self.radius_b)):
            marker = getattr(self, key)
            if not radius:
                continue
            n = marker.A[:, 2]
            x = e - (n @ e) * n
            x = x / np.sqrt(x @ x)
            made = aligned(marker, np.stack([x, np.cross(n, x), n], axis=1))
            object.__setattr__(self, key, made)

    @property
    def direction(self) -> Array:
        """Unit vector (3,) from a to b along the rope at the initial pose, world frame."""
        return rope_direction(self.a, self.b, self.radius_a, self.radius_b)

    @property
    def radius(self) -> float:
        """Radius of the sheave at a, m, by the name in the engine."""
        return self.radius_a

    @property
    def head(self) -> float:
        """Radius of the sheave at b, m, by the name in the engine."""
        return self.radius_b

    @property
    def initial(self) -> float:
        """Value at the initial pose, m."""
        e = self.direction
        made: Any = e @ (self.b.r - self.a.r)
        for marker, radius in ((self.a, self.radius_a), (self.b, -self.radius_b)):
            if radius:
                made = made + radius * arctan2(e @ marker.A[:, 1], e @ marker.A[:, 0])
        return scalar(made)

    @property
    def turns_a(self) -> bool:
        """Whether the coordinate depends on the orientation of frame a."""
        return bool(self.radius_a)

    @property
    def turns_b(self) -> bool:
        """Whether the coordinate depends on the orientation of frame b."""
        return bool(self.radius_b)

    @property
    def key(self) -> tuple[Any, ...]:
        """Key that is equal for the same sheaves."""
        return (*super().key, float(np.real(self.radius_a)), float(np.real(self.radius_b)))


def rope_direction(a: Marker, b: Marker, radius_a: Any, radius_b: Any) -> Array:
    """Return the unit vector (3,) along the rope from sheave a to sheave b at the initial pose.

    Parameters
    ----------
    a, b : Marker
        The sheaves, with their axles along z.
    radius_a, radius_b : float
        Their radii, m, with the sign of the sense of the rope.

    Returns
    -------
    array
        World frame; not finite if no rope fits.
    """
    w = floats(b.r - a.r)
    ends = ((a, radius_a), (b, -radius_b))
    axles = [(floats(marker.A[:, 2]), radius) for marker, radius in ends if radius]
    if not axles:
        size = np.sqrt(w @ w)
        return np.asarray(w / size if size else w * np.nan)
    e = _start(w, axles[0][0], radius_b - radius_a)
    for _ in range(SEARCH):
        if not np.isfinite(np.real(e)).all():
            break
        change = _newton(w, axles, e)
        e = e + change
        e = e / np.sqrt(e @ e)
        if not np.abs(change @ change) > FOUND:
            break
    return np.asarray(e)


def misfit(a: Marker, b: Marker, radius_a: Any, radius_b: Any, way: Array) -> str:
    """Return why no rope fits between two sheaves, with the remedy; empty if it does."""
    w = np.real(floats(b.r - a.r))
    if not w.any():
        return f"{a.label} and {b.label} are at one place; move one"
    found = bool(np.isfinite(np.real(way)).all())
    for marker, radius in ((a, radius_a), (b, radius_b)):
        n, line = np.real(marker.A[:, 2]), np.real(way) if found else w / np.linalg.norm(w)
        if radius and float(np.linalg.norm(np.cross(n, line))) < PARALLEL:
            return f"the rope runs along the axle of {marker.label}, its z axis; turn the marker"
    if found:
        return ""
    sizes = [abs(float(np.real(radius))) for radius in (radius_a, radius_b)]
    return (
        f"no rope fits between {a.label} and {b.label}: the sheaves of radius {sizes[0]:g} and "
        f"{sizes[1]:g} m are inside one another or too near; move them apart"
    )


def wrap_angle(n: Array, before: Array, after: Array, radius: Any) -> Any:
    """Return the angle, rad, from 0, by which a rope turns about the axle n of a sheave.

    Rounding of a straight rope may be slightly below 0.
    """
    if not radius:
        return 0.0
    turn: Any = arctan2(n @ np.cross(before, after), before @ after - (n @ before) * (n @ after))
    if np.real(radius) < 0:
        turn = -turn
    return turn + 2.0 * np.pi if np.real(turn) < -STRAIGHT else turn


def _start(w: Array, n: Array, apart: Any) -> Array:
    """Return the direction as if both axles were parallel to n; not finite if there is none."""
    height = n @ w
    flat = w - height * n
    with np.errstate(invalid="ignore", divide="ignore"):
        sine = -apart / np.sqrt(flat @ flat)
        rest = 1.0 - sine * sine
        cosine = np.sqrt(rest) if np.real(rest) > 0 else np.nan
        e = cosine * (cosine * flat + sine * np.cross(n, flat)) + height * n
        return np.asarray(e / np.sqrt(e @ e))


def _newton(w: Array, axles: list[tuple[Array, Any]], e: Array) -> Array:
    """Return the change of e by Newton's method for ``w + sum R k(e)`` along e."""
    off, slope = w, (e @ w) * np.eye(3, dtype=e.dtype)
    for n, radius in axles:
        h = np.cross(n, e)
        square = h @ h
        k = h / square
        skew = np.cross(n, np.eye(3)).T  # n x .
        off = off + radius * k
        slope = slope - radius * (skew - 2.0 * np.outer(k, h @ skew)) / square
    across = np.linalg.svd(np.real(e)[None])[2][1:]
    across = across - np.outer(across @ e, e)
    made = np.linalg.solve(across @ slope @ across.T, across @ off)
    return np.asarray(made @ across)
