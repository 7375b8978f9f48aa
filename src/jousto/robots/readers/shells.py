"""Mass of hollow solids and of meshes by MuJoCo's rules: volume, area or convex hull."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jousto.base.arrays import Array
from jousto.mechanism.bodies.shapes import Solid

HULL, EXACT, LEGACY, SHELL = "convex", "exact", "legacy", "shell"
MESH_MASSES = (HULL, EXACT, LEGACY, SHELL)
THOMSEN = 1.6075  # exponent of Thomsen's formula for the area of an ellipsoid (error below 1.1 %)


def surface_mass(triangles: Array) -> Solid:
    """Return the shell of triangles (nt, 3, 3) with unit mass per area.

    With the corners a, b, c of a triangle of area A and s = a + b + c:
    ``int x x^T dA = A (s s^T + a a^T + b b^T + c c^T) / 12``.
    """
    a, b, c = np.moveaxis(triangles, 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return _moments(area, triangles, 12.0, 3.0, np.zeros(3))


def pyramid_mass(triangles: Array) -> Solid:
    """Return the solid of MuJoCo's ``inertia="legacy"``: pyramids of positive volume on all faces.

    Their apex is the centroid of the surface for the centre of mass, and the centre of mass for the
    inertia. The volume is exact for star-shaped solids and too large for others.
    """
    apex = surface_mass(triangles).center
    about = _pyramids(triangles, apex)
    return _pyramids(triangles, about.center, about.center)


def hull_mass(triangles: Array) -> Solid:
    """Return the convex hull of the corners of triangles as a solid."""
    hull = convex_hull(triangles.reshape(-1, 3))
    return replace(pyramid_mass(hull), triangles=triangles)


def convex_hull(points: Array) -> Array:
    """Return the triangles (nt, 3, 3) of the convex hull of points (n, 3).

    Raises
    ------
    ValueError
        If the points lie in a plane.
    """
    from scipy.spatial import ConvexHull, QhullError  # rarely needed

    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError) as error:
        raise ValueError("the points have no convex hull with a volume") from error
    triangles = points[hull.simplices]
    a, b, c = np.moveaxis(triangles, 1, 0)
    inward = np.einsum("ti,ti->t", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    triangles[inward] = triangles[inward][:, ::-1]
    return triangles


def _pyramids(triangles: Array, apex: Array, center: Array | None = None) -> Solid:
    a, b, c = np.moveaxis(triangles - apex, 1, 0)
    volume = np.abs(np.einsum("ti,ti->t", a, np.cross(b, c))) / 6.0
    return _moments(volume, triangles, 20.0, 4.0, apex, center)


def _moments(
    share: Array, triangles: Array, n: float, k: float, apex: Array, center: Array | None = None
) -> Solid:
    """Return weighted triangles (k = 3) or pyramids on them (k = 4), summed as a solid."""
    total = float(share.sum())
    a, b, c = np.moveaxis(triangles - apex, 1, 0)
    s = a + b + c
    first = np.einsum("t,ti->i", share, s) / k
    second = sum(np.einsum("t,ti,tj->ij", share, x, x) for x in (s, a, b, c)) / n
    if not total > 0.0:
        return Solid(0.0, np.zeros(3), np.zeros((3, 3)), triangles)
    middle = first / total
    if center is None:
        second = second - total * np.outer(middle, middle)
        center = apex + middle
    return Solid(total, center, np.trace(second) * np.eye(3) - second, triangles)


def shell_of(kind: str, sizes: Array, solid: Solid) -> Solid:
    """Return a hollow solid of unit mass per area, centred at the origin, with axis z.

    Parameters
    ----------
    kind : {"box", "cylinder", "capsule", "sphere", "ellipsoid"}
        Form of the solid.
    sizes : (n,) array
        Lengths of a box; radius and length without round ends; radius; half axes, m.
    solid : Solid
        Full solid, whose triangles the hollow one has.
    """
    if kind == "box":
        x, y, z = sizes
        parts = [(y * z, 0, y, z), (z * x, 1, z, x), (x * y, 2, x, y)]
        area = 2.0 * sum(part[0] for part in parts)
        squares = np.zeros(3)  # int x^2 dA, ...
        for own, axis, p, q in parts:
            squares[axis] += 2.0 * own * (sizes[axis] / 2.0) ** 2
            squares[(axis + 1) % 3] += 2.0 * own * p * p / 12.0
            squares[(axis + 2) % 3] += 2.0 * own * q * q / 12.0
        inertia = np.diag(squares.sum() - squares)
    elif kind in ("cylinder", "capsule", "sphere"):
        r, long = float(sizes[0]), float(sizes[1]) if len(sizes) > 1 else 0.0
        side = 2.0 * np.pi * r * long
        ends = (2.0 if kind == "cylinder" else 4.0) * np.pi * r * r
        area = side + ends
        across, axial = side * (6.0 * r * r + long * long) / 12.0, side * r * r
        if kind == "cylinder":
            across += ends * (r * r / 4.0 + long * long / 4.0)
            axial += ends * r * r / 2.0
        else:  # centre of mass of a hollow half-sphere: r / 2 above its disc
            away = 0.5 * long + 0.5 * r
            across += ends * (2.0 / 3.0 * r * r + away * away - 0.25 * r * r)
            axial += ends * 2.0 / 3.0 * r * r
        inertia = np.diag([across, across, axial])
    else:
        area, inertia = _ellipsoid(sizes)
    return replace(solid, volume=float(area), inertia=inertia)


def _ellipsoid(half: Array) -> tuple[float, Array]:
    """Return area (Thomsen's formula) and inertia per area of a shell of constant thickness.

    The inertia is ``d/dt int x^2 dV`` of an ellipsoid whose half axes grow by t, over ``dV/dt``.
    """
    products = half * np.roll(half, -1)
    area = 4.0 * np.pi * float(np.mean(products**THOMSEN)) ** (1.0 / THOMSEN)
    # derivative of int x^2 dV = V a^2 / 5, V ~ a b c, over that of V
    rate = (1.0 / half).sum()
    squares = (half**2 * rate + 2.0 * half) / (5.0 * rate) * area
    return area, np.diag(squares.sum() - squares)


def inertia_box(solid: Solid) -> tuple[Array, Array]:
    """Return half lengths of the box of equal mass and inertia, and its axes in columns."""
    values, vectors = np.linalg.eigh(solid.inertia)
    values, vectors = values[::-1], vectors[:, ::-1].copy()
    if np.linalg.det(vectors) < 0.0:
        vectors[:, 2] *= -1.0
    half = 0.5 * np.sqrt(np.maximum(6.0 * (values.sum() - 2.0 * values) / solid.volume, 0.0))
    return half, vectors
