"""Signed distance of two shapes of contacts."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.mechanism.contacts.shapes import Shape
from jousto.model.native import library


def shape_distance(
    shape_a: Shape,
    shape_b: Shape,
    position: ArrayLike = (0.0, 0.0, 0.0),
    rotation: ArrayLike = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
) -> tuple[float, Array]:
    """Return the signed distance of two convex shapes, m, and the normal (3,) from a to b.

    The distance of shapes that overlap is minus the smallest displacement that parts them, among
    those near the closest points of smaller copies: exact for depths below a third of a shape.

    Parameters
    ----------
    shape_a, shape_b : Shape
        Sphere, capsule, cuboid, convex hull, cylinder or ellipsoid; `shape_a` may be a half-space,
        a triangle mesh or a height field, from which the spheres or corners of `shape_b` have
        their distance.
    position : (3,) array_like
        Position of the frame of b in the frame of a, m.
    rotation : (3, 3) array_like
        Axes of b as columns, resolved in a.

    Examples
    --------
    >>> from jousto.mechanism import Cuboid
    >>> gap, normal = shape_distance(Cuboid((1, 1, 1)), Cuboid((2, 2, 2)), (0, 0, 1.7))
    >>> print(f"{gap:.3f}", normal)
    0.200 [0. 0. 1.]
    """
    problems = Problems()
    r = problems.array("distance", "position", position, (3,))
    R = problems.array("distance", "rotation", rotation, (3, 3))
    a = shape_a.mesh or shape_a.polytope
    b = None if shape_b.mesh else shape_b.polytope
    for key, shape, found in (("shape_a", shape_a, a), ("shape_b", shape_b, b)):
        if found is None or (key == "shape_b" and shape.hollow):
            problems.add(
                "distance",
                f"{key} is a {shape.tag}; sphere, capsule, cuboid, hull, cylinder and "
                "ellipsoid work",
            )
    problems.raise_if_any()
    assert a is not None and b is not None
    ffi = library.ffi()
    y = np.empty(4)
    numbers = [np.ascontiguousarray(x) for x in (np.concatenate([a.numbers, b.numbers]), r, R)]
    library.real_library().jo_pair_distance(
        *(ffi.from_buffer("jo_real[]", x) for x in numbers), ffi.from_buffer("jo_real[]", y)
    )
    return float(y[3]), y[:3]
