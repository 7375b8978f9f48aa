"""Shapes that are larger by the margin of a robot file, at which a touch begins."""

from __future__ import annotations

import numpy as np

from jousto.mechanism.contacts.ellipsoid import Ellipsoid
from jousto.mechanism.contacts.shapes import (
    Capsule,
    ConvexHull,
    Cuboid,
    Cylinder,
    HalfSpace,
    Shape,
    Sphere,
)
from jousto.mechanism.contacts.surfaces import HeightField
from jousto.robots.description import Frame


def grown(shape: Shape, frame: Frame, margin: float) -> tuple[Shape, Frame]:
    """Return a shape and its pose that reach a margin, m, beyond its surface.

    Faces of boxes, cylinders and hulls move outward and keep their sharp edges, those of a height
    field rise; axes of ellipsoids become longer.
    """
    if not margin:
        return shape, frame
    if isinstance(shape, HalfSpace):
        return shape, frame @ Frame(np.array([0.0, 0.0, margin]))
    return larger(shape, margin), frame


def larger(shape: Shape, margin: float) -> Shape:
    """Return a shape with a size that reaches a margin, m, beyond its surface, see `grown`."""
    if isinstance(shape, Sphere):
        return Sphere(shape.radius + margin)
    if isinstance(shape, Capsule):
        return Capsule(shape.radius + margin, shape.length)
    if isinstance(shape, Cylinder):
        return Cylinder(shape.radius + margin, shape.length + 2.0 * margin)
    if isinstance(shape, Cuboid):
        return Cuboid(np.asarray(shape.lengths) + 2.0 * margin)
    if isinstance(shape, Ellipsoid):
        return Ellipsoid(np.asarray(shape.lengths) + 2.0 * margin)
    if isinstance(shape, HeightField):
        return HeightField(shape.heights + margin, shape.length, shape.width, base=shape.base)
    assert isinstance(shape, ConvexHull)
    from scipy.spatial import HalfspaceIntersection  # slow to import

    planes = shape.polytope.planes  # n . x = d, see `inner_radius`
    faces = np.column_stack([planes[:, :3], -planes[:, 3] - margin])
    inside = shape.polytope.vertices.mean(axis=0)
    return ConvexHull(HalfspaceIntersection(faces, inside).intersections, flat=shape.flat)
