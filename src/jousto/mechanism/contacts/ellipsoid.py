"""Ellipsoid that touches other convex shapes."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array
from jousto.base.fields import field
from jousto.base.object_repr import described
from jousto.mechanism.bodies.shapes import Lengths, sphere
from jousto.mechanism.contacts.polytopes import ELLIPSOID, Polytope
from jousto.mechanism.contacts.shapes import Shape, Tip


@described
class Ellipsoid(Shape, tag="ellipsoid"):
    """Ellipsoid about the marker, its axes along those of the marker."""

    code = 8
    lengths: Lengths = field("Lengths of its axes x, y and z", unit="m")

    @property
    def size(self) -> tuple[float, ...]:
        """Half the lengths."""
        return tuple(0.5 * x for x in self.lengths)

    @property
    def tips(self) -> tuple[Tip, ...]:
        """Its lowest point over a half-space."""
        return (Tip((0.0, 0.0, 0.0), 0.0, axes=self.size),)

    @property
    def polytope(self) -> Polytope:
        """The ellipsoid as a round shape."""
        return Polytope(np.zeros((0, 3)), round=ELLIPSOID, size=self.size)

    @property
    def reach(self) -> float:
        """Half the longest axis, m."""
        return max(self.size)

    @property
    def triangles(self) -> Array:
        """Its surface."""
        return np.asarray(sphere(0.5).triangles * self.lengths)
