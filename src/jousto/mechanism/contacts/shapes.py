"""Shapes of bodies that touch, in the frame of a marker."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import hypot, inf, pi
from typing import Any, ClassVar

import numpy as np

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Nested, field
from jousto.base.numbers import Number, Values
from jousto.base.object_repr import described
from jousto.mechanism.bodies.shapes import Lengths, box, cylinder, revolved, sphere
from jousto.mechanism.contacts.polytopes import (
    Polytope,
    half_space,
    hull,
    round_cylinder,
    too_fine,
)
from jousto.mechanism.contacts.triangles import Triangles

FLAT = 2.0
"""Half the side of the square that shows a half-space, m."""
RIM = 4
"""Points of the rim of a cylinder that touch a plane on which it stands."""


@dataclass(frozen=True)
class Tip:
    """Part of a shape that touches another one: a sphere, a circle of spheres, or an ellipsoid.

    Parameters
    ----------
    centre : tuple of float
        Centre in the frame of the marker, m.
    radius : float
        Radius of the sphere, m; 0 for a corner.
    ring : float
        Radius of the circle about z on which the sphere is wherever it touches, m; 0: none.
    around : float, optional
        Angle on this circle from its lowest point, rad, of one of several points; None: the only
        one.
    axes : tuple of float
        Half axes along x, y and z of an ellipsoid whose lowest point touches, m; empty: none.
    """

    centre: tuple[float, float, float]
    radius: float
    ring: float = 0.0
    around: float | None = None
    axes: tuple[float, ...] = ()

    @property
    def moves(self) -> bool:
        """Whether another point of the body touches as it turns: its lowest one over a plane."""
        return bool(self.ring or self.axes)

    @property
    def reach(self) -> float:
        """Distance from the marker to its farthest place, m."""
        return hypot(*self.centre) + self.radius + self.ring + max(self.axes, default=0.0)

    @property
    def place(self) -> float:
        """The angle plus 1 as in the engine; 0 for the only point."""
        return 0.0 if self.around is None else 1.0 + self.around


class Shape(Declared, section="contact shapes", by_value=True):
    """Base of the shapes that touch; axes of revolution are the z axis of the marker.

    Attributes
    ----------
    code : int
        Number of the shape in ``jo_shape_type`` of the engine; -1: none.
    round : bool
        Whether the shape is one sphere, which touches every other shape in one point.
    hollow : bool
        Whether the other shape is inside of it, or above it: tips of a convex shape touch first.
    """

    kind = "shape"
    code: ClassVar[int]
    round: ClassVar[bool] = False
    hollow: ClassVar[bool] = False

    @property
    def size(self) -> tuple[float, ...]:
        """Sizes in the order of the engine, m."""
        return ()

    @property
    def tips(self) -> tuple[Tip, ...]:
        """Parts that touch a hollow shape; none if the shape has no such parts."""
        return ()

    @property
    def polytope(self) -> Polytope | None:
        """The shape as a polytope with rounded edges; None if it is none."""
        return None

    @property
    def reach(self) -> float:
        """Distance from the marker to the farthest place, m; -1 for kinds that `reach` knows."""
        return -1.0

    @property
    def mesh(self) -> Triangles | None:
        """The shape as a surface of triangles; None if it is none."""
        return None

    @property
    def size_about(self) -> float:
        """Largest distance from the marker, m; infinite for shapes without end."""
        far = reach(self)
        return far if far >= 0.0 else inf

    @property
    def curvature(self) -> float | None:
        """Curvature of a sphere, 1/m; 0 for a plane, negative if hollow; None: differs by place."""
        return None

    @property
    def triangles(self) -> Array:
        """Triangles (nt, 3, 3) that show it, m."""
        raise NotImplementedError


class HalfSpace(Shape, tag="half-space"):
    """Everything below the plane z = 0 of the marker: a floor, a wall, a ramp."""

    code = 0
    hollow = True

    @property
    def polytope(self) -> Polytope:
        """Its face."""
        return half_space()

    @property
    def curvature(self) -> float:
        """0."""
        return 0.0

    @property
    def triangles(self) -> Array:
        """A square of 4 m."""
        a, b, c, d = ((x * FLAT, y * FLAT, 0.0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)))
        return np.array([[a, b, c], [a, c, d]])


class Sphere(Shape, tag="sphere"):
    """Sphere about the marker; with radius 0 a point."""

    code = 1
    round = True
    radius: Number = field("Radius; 0 for a point", unit="m", least=0)

    @property
    def size(self) -> tuple[float, ...]:
        """The radius."""
        return (self.radius,)

    @property
    def tips(self) -> tuple[Tip, ...]:
        """The sphere itself."""
        return (Tip((0.0, 0.0, 0.0), self.radius),)

    @property
    def polytope(self) -> Polytope:
        """Its centre with its radius."""
        return Polytope(np.zeros((1, 3)), radius=self.radius)

    @property
    def curvature(self) -> float | None:
        """1 / radius; None for a point."""
        return 1.0 / self.radius if self.radius else None

    @property
    def triangles(self) -> Array:
        """Its surface."""
        return sphere(self.radius).triangles


class HollowSphere(Shape, tag="hollow-sphere"):
    """Everything outside of a sphere about the marker: a seat, a bowl."""

    code = 2
    hollow = True
    radius: Number = field("Radius", unit="m", above=0)

    @property
    def size(self) -> tuple[float, ...]:
        """The radius."""
        return (self.radius,)

    @property
    def curvature(self) -> float:
        """-1 / radius."""
        return -1.0 / self.radius

    @property
    def triangles(self) -> Array:
        """Its lower half."""
        whole: Array = sphere(self.radius).triangles[:, ::-1]
        lower: Array = whole[whole[:, :, 2].max(axis=1) < 1e-9 * self.radius]
        return lower


class Capsule(Shape, tag="capsule"):
    """Cylinder along z about the marker, with half-spheres at its ends."""

    code = 3
    radius: Number = field("Radius", unit="m", above=0)
    length: Number = field("Length between the centres of the half-spheres", unit="m", above=0)

    @property
    def size(self) -> tuple[float, ...]:
        """Radius, and half the length."""
        return (self.radius, 0.5 * self.length)

    @property
    def tips(self) -> tuple[Tip, ...]:
        """The spheres at its ends."""
        half = 0.5 * self.length
        return (Tip((0.0, 0.0, -half), self.radius), Tip((0.0, 0.0, half), self.radius))

    @property
    def polytope(self) -> Polytope:
        """Its axis with its radius."""
        return Polytope(np.array([tip.centre for tip in self.tips]), radius=self.radius)

    @property
    def triangles(self) -> Array:
        """Its surface."""
        angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 16)
        shift = np.where(angle < 0, -0.5, 0.5) * self.length
        profile = np.stack(
            [self.radius * np.cos(angle), self.radius * np.sin(angle) + shift], axis=1
        )
        profile[[0, -1], 0] = 0.0
        return revolved(profile)


@described
class Cuboid(Shape, tag="cuboid"):
    """Box about the marker, its edges along the axes."""

    code = 4
    lengths: Lengths = field("Lengths along x, y and z", unit="m")

    @property
    def size(self) -> tuple[float, ...]:
        """Half the lengths."""
        return tuple(0.5 * x for x in self.lengths)

    @property
    def tips(self) -> tuple[Tip, ...]:
        """Its corners."""
        x, y, z = self.size
        return tuple(Tip((i * x, j * y, k * z), 0.0) for i, j, k in product((-1, 1), repeat=3))

    @cached_property
    def polytope(self) -> Polytope:
        """Its corners, edges and faces."""
        return hull(np.array([tip.centre for tip in self.tips]))

    @property
    def triangles(self) -> Array:
        """Its surface."""
        return box(self.lengths).triangles


class Cylinder(Shape, tag="cylinder"):
    """Cylinder along z about the marker, with flat ends."""

    code = 5
    radius: Number = field("Radius", unit="m", above=0)
    length: Number = field("Length", unit="m", above=0)

    @property
    def size(self) -> tuple[float, ...]:
        """Radius, and half the length."""
        return (self.radius, 0.5 * self.length)

    @property
    def tips(self) -> tuple[Tip, ...]:
        """Four points of the rim of each end, which turn with its lowest point."""
        half = 0.5 * self.length
        quarters = (0.5 * pi * i for i in range(RIM))
        return tuple(
            Tip((0.0, 0.0, z), 0.0, self.radius, a) for a in quarters for z in (-half, half)
        )

    @cached_property
    def polytope(self) -> Polytope:
        """The cylinder as a round shape."""
        return round_cylinder(*self.size)

    @property
    def triangles(self) -> Array:
        """Its surface."""
        return cylinder(self.radius, self.length, np.array([0.0, 0.0, 1.0])).triangles


class Bore(Shape, tag="bore"):
    """Endless hole along z: everything outside of a cylinder."""

    code = 6
    hollow = True
    radius: Number = field("Radius", unit="m", above=0)

    @property
    def size(self) -> tuple[float, ...]:
        """The radius."""
        return (self.radius,)

    @property
    def triangles(self) -> Array:
        """A piece as long as it is wide."""
        profile = np.array([[self.radius, self.radius], [self.radius, -self.radius]])
        return revolved(profile)


class Torus(Shape, tag="torus"):
    """Ring about z: a tyre, a wheel with a rounded rim, a coin."""

    code = 7
    radius: Number = field("Radius of the circle of centres", unit="m", above=0)
    tube: Number = field("Radius of the tube; 0 for the edge of a disc", unit="m", least=0)

    @property
    def size(self) -> tuple[float, ...]:
        """Radius of the circle, and of the tube."""
        return (self.radius, self.tube)

    @property
    def tips(self) -> tuple[Tip, ...]:
        """The sphere of the tube where it touches."""
        return (Tip((0.0, 0.0, 0.0), self.tube, self.radius),)

    @property
    def triangles(self) -> Array:
        """Its surface."""
        angle = np.linspace(0.0, 2.0 * np.pi, 17)
        tube = max(self.tube, 0.02 * self.radius)
        return revolved(
            np.stack([self.radius + tube * np.cos(angle), tube * np.sin(angle)], axis=1)
        )


@described
class ConvexHull(Shape, tag="convex-hull"):
    """Hull of points, found by Qhull when it is declared: any convex part with flat faces.

    Examples
    --------
    >>> wedge = ConvexHull([(0, 0, 0), (2, 0, 0), (0, 1, 0), (2, 1, 0), (0, 0, 1), (0, 1, 1)])
    >>> len(wedge.polytope.vertices), len(wedge.polytope.faces)
    (6, 5)
    """

    code = -1
    points: Values = field("Points in the frame of the marker", unit="m", shape=(None, 3))
    flat: Number = field(
        "Distance from the plane of a face, over the size, up to which points belong to it: 1e-5 "
        "for points with six digits; 0 for points that are exact",
        unit="1",
        least=0,
        most=0.1,
        default=0.0,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report points that have no hull, and hulls that are too fine."""
        try:
            found = self.polytope
        except ValueError as error:
            problems.add(where, f"points: {error}", "points")
            return
        if fault := too_fine(found):
            problems.add(where, f"{fault}: take fewer points", "points")

    @property
    def size(self) -> tuple[float, ...]:
        """Largest distance of a vertex from the marker."""
        return (float(np.linalg.norm(self.polytope.vertices, axis=1).max()),)

    @cached_property
    def polytope(self) -> Polytope:
        """The hull."""
        return hull(self.points, flat=self.flat)

    @property
    def triangles(self) -> Array:
        """Its surface."""
        x = self.polytope.vertices
        fans = [
            [face[0], face[i], face[i + 1]]
            for face in self.polytope.faces
            for i in range(1, len(face) - 1)
        ]
        return np.asarray(x[np.array(fans)])


class ShapeField(Nested[Shape, Shape]):
    """Field of a shape, which a model file declares by its type and sizes."""

    section = "contact shapes"
    room = "jousto.mechanism.contacts"
    noun = "HalfSpace, Sphere, Cuboid or another shape"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the shape, or report a value of another type."""
        if not isinstance(value, Shape):
            problems.add(where, f"{self.label} is {value!r}, must be a {self.noun}", self.key)
        return value


def reach(shape: Shape) -> float:
    """Return the distance from the marker to the farthest place of a shape, m; -1 without end."""
    if isinstance(shape, Cylinder | Cuboid | ConvexHull):
        return float(hypot(*shape.size))
    if isinstance(shape, Sphere | Capsule | Torus):
        return float(sum(shape.size))
    return shape.reach


def touching(on: Shape, of: Shape) -> Sequence[Tip] | None:
    """Return the tips of `of` that touch `on`; None if this pair is not available."""
    if of.round:
        return of.tips if on.code >= 0 else None
    moves = any(tip.moves for tip in of.tips)
    if not on.hollow or not of.tips or (moves and not isinstance(on, HalfSpace)):
        return None
    return of.tips
