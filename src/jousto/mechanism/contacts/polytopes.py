"""Convex polytopes: faces, edges and vertices of the hull of points, as the engine reads them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array

MOST_VERTICES = 1000
"""Vertices, and faces, of a hull that the engine distinguishes (``JO_MAX_VERTICES``)."""
MOST_CORNERS = 64
"""Corners of a face that the engine cuts (half of ``JO_ROOM`` in ``corners.c``)."""
CYLINDER, ELLIPSOID = 1, 2
"""Numbers of ``jo_roundness`` of the engine."""
BORDER = 16
"""Corners of the polygon that the end of a cylinder is over the border of a face."""
FLAT = 1e-9
"""Thickness over size below which points are in one plane."""
SAME_PLANE = 1e-7
"""Angle of two triangles of one face, rad."""


@dataclass(frozen=True, eq=False)
class Polytope:
    """Convex polytope with rounded edges: all places within `radius` of it; or a round shape.

    Attributes
    ----------
    vertices : (nv, 3) array
        m.
    faces : tuple of tuple of int
        Vertices of each face, counterclockwise seen from outside. Points and segments have none.
    radius : float
        m.
    round : int
        Number of a round shape in ``jo_roundness`` of the engine: `CYLINDER`, `ELLIPSOID`;
        0 for a polytope. Vertices and faces of a cylinder are polygons within its ends.
    size : tuple of float
        Radius and half the length, or half axes, of a round shape, m.
    """

    vertices: Array
    faces: tuple[tuple[int, ...], ...] = ()
    radius: float = 0.0
    round: int = 0
    size: tuple[float, ...] = ()

    @cached_property
    def planes(self) -> Array:
        """Outward normal and offset of each face (nf, 4): ``n . x = offset``."""
        rows = []
        for face in self.faces:
            x = self.vertices[list(face)]
            about = x - x[0]
            n = np.cross(about[1:-1], about[2:]).sum(axis=0)
            n /= np.linalg.norm(n)
            rows.append([*n, np.mean(x @ n)])
        return np.array(rows).reshape(-1, 4)

    @cached_property
    def neighbours(self) -> list[list[int]]:
        """Vertices at the other end of the edges of each vertex."""
        found: list[set[int]] = [set() for _ in self.vertices]
        if self.round and len(self.vertices):  # along the side of a cylinder
            half = len(found) // 2
            for i in range(half):
                found[i].add(i + half)
                found[i + half].add(i)
        for face in self.faces:
            for i, j in zip(face, face[1:] + face[:1], strict=True):
                found[i].add(j)
                found[j].add(i)
        if not self.faces and len(self.vertices) == 2:
            found = [{1}, {0}]
        return [sorted(one) for one in found]

    @cached_property
    def numbers(self) -> Array:
        """Data of the engine: see ``jo_polytope_read`` in ``polytope.c``."""
        corners = [i for face in self.faces for i in face]
        near = [i for one in self.neighbours for i in one]
        return np.concatenate(
            [
                [len(self.vertices), len(self.faces), len(corners), len(near), self.radius],
                self.vertices.mean(axis=0) if len(self.vertices) else np.zeros(3),
                [self.round, *(*self.size, 0.0, 0.0, 0.0)[:3]],
                self.vertices.ravel(),
                self.planes.ravel(),
                _starts(self.faces),
                corners,
                _starts(self.neighbours),
                near,
            ]
        ).astype(float)


def _starts(lists: Any) -> Array:
    return np.concatenate([[0], np.cumsum([len(one) for one in lists])])


def half_space() -> Polytope:
    """Return everything below z = 0: a face without vertices."""
    plane = Polytope(np.zeros((0, 3)), ((),))
    plane.__dict__["planes"] = np.array([[0.0, 0.0, 1.0, 0.0]])
    return plane


def round_cylinder(radius: float, half: float) -> Polytope:
    """Return a cylinder about z with these sizes, m."""
    angle = np.arange(BORDER) * (2.0 * np.pi / BORDER)
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(BORDER, half)], axis=1)
    ends = np.concatenate([rim * (1.0, 1.0, -1.0), rim])
    low, high = tuple(range(BORDER))[::-1], tuple(range(BORDER, 2 * BORDER))
    return Polytope(ends, (low, high), round=CYLINDER, size=(radius, half))


def hull(points: Array, radius: float = 0.0, flat: float = 0.0) -> Polytope:
    """Return the convex hull of points (n, 3), m, by Qhull; triangles in one plane become a face.

    Parameters
    ----------
    points : (n, 3) array
        m.
    radius : float
        Radius of rounded edges, m.
    flat : float
        Distance from the plane of a face, over the size, up to which triangles belong to it; with
        0 those at an angle below `SAME_PLANE` do.

    Raises
    ------
    ValueError
        If there are fewer than 4 points, or all are in one plane.
    """
    from scipy.spatial import ConvexHull, QhullError

    if len(points) < 4:
        raise ValueError(f"has {len(points)} points, needs 4 or more")
    centred = points - points.mean(axis=0)
    spread = np.linalg.svd(centred, compute_uv=False)
    if not spread[2] > FLAT * spread[0]:
        raise ValueError("is flat: all points are in one plane")
    try:
        found = ConvexHull(points)
    except QhullError as error:
        raise ValueError(f"has no hull: {str(error).splitlines()[0]}") from None
    within = flat * float(np.ptp(points, axis=0).max())
    group = _flat_faces(found, within) if flat else _planes(found)
    members = [np.unique(found.simplices[group == k].ravel()) for k in range(int(group.max()) + 1)]
    normals = [found.equations[group == k, :3].mean(axis=0) for k in range(len(members))]
    count = np.bincount(np.concatenate(members), minlength=len(points))
    kept = np.flatnonzero(count >= 3)  # others are within an edge or a face
    place = np.full(len(points), -1)
    place[kept] = np.arange(len(kept))
    faces = []
    for member, n in zip(members, normals, strict=True):
        ring = member[place[member] >= 0]
        faces.append(tuple(int(place[i]) for i in ring[_around(points[ring], n)]))
    return Polytope(points[kept], tuple(faces), radius)


def too_fine(found: Polytope) -> str:
    """Return that a hull has more vertices, faces or corners than the engine takes; else ""."""
    finest = max((len(face) for face in found.faces), default=0)
    if max(len(found.vertices), len(found.faces)) <= MOST_VERTICES and finest <= MOST_CORNERS:
        return ""
    return (
        f"the hull has {len(found.vertices)} vertices, {len(found.faces)} faces and up to {finest} "
        f"corners a face; at most {MOST_VERTICES}, {MOST_VERTICES} and {MOST_CORNERS} are possible"
    )


def _planes(found: Any) -> NDArray[np.int_]:
    """Return the number of the face of each triangle of a hull."""
    n = found.equations[:, :3]
    group = np.full(len(n), -1)
    faces = 0
    for first in range(len(n)):
        if group[first] >= 0:
            continue
        group[first], front = faces, [first]
        while front:
            for other in found.neighbors[front.pop()]:
                same = np.linalg.norm(n[other] - n[first]) < SAME_PLANE
                if group[other] < 0 and same:
                    group[other] = faces
                    front.append(other)
        faces += 1
    return group


def _flat_faces(found: Any, within: float) -> NDArray[np.int_]:
    """Return the number of the face of each triangle of a hull.

    A face consists of its largest triangle and of neighbours, all within a distance of its plane.
    """
    x, n = found.points[found.simplices], found.equations[:, :3]
    area = np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1)
    group = np.full(len(n), -1)
    faces = 0
    for first in np.argsort(-area, kind="stable"):
        if group[first] >= 0:
            continue
        group[first], front = faces, [int(first)]
        while front:
            for other in found.neighbors[front.pop()]:
                away = np.abs((x[other] - x[first, 0]) @ n[first]).max()
                if group[other] < 0 and away <= within:
                    group[other] = faces
                    front.append(int(other))
        faces += 1
    return group


def _around(x: Array, n: Array) -> NDArray[np.intp]:
    """Return the order of points of a plane, counterclockwise about its normal n."""
    about = x - x.mean(axis=0)
    e = about[np.argmax(np.linalg.norm(about, axis=1))]
    return np.argsort(np.arctan2(np.cross(n, e) @ about.T, e @ about.T))
