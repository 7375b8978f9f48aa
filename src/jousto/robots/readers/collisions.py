"""Shapes of links that touch others, from the kinds and sizes of robot files."""

from __future__ import annotations

from jousto.base.arrays import Array
from jousto.mechanism.contacts.ellipsoid import Ellipsoid
from jousto.mechanism.contacts.shapes import Capsule, Cuboid, Cylinder, HalfSpace, Shape, Sphere

KINDS = {"plane", "sphere", "capsule", "cylinder", "box", "ellipsoid"}
"""Kinds of shapes that can touch."""


def shape_of(kind: str, sizes: Array) -> Shape | None:
    """Return the shape of a kind with sizes as for `solid_of`; None for another kind.

    Parameters
    ----------
    kind : str
        "plane", "sphere", "capsule", "cylinder", "box", "ellipsoid", or a kind that cannot touch.
    sizes : (n,) array
        Radius, radius and length, lengths, or half axes, m.
    """
    if kind == "plane":
        return HalfSpace()
    if not (sizes > 0.0).all():
        return None
    if kind == "sphere":
        return Sphere(float(sizes[0]))
    if kind == "capsule":
        return Capsule(float(sizes[0]), float(sizes[1]))
    if kind == "cylinder":
        return Cylinder(float(sizes[0]), float(sizes[1]))
    if kind == "ellipsoid":
        return Ellipsoid(2.0 * sizes)
    return Cuboid(sizes) if kind == "box" else None
