"""Cylindrical holes of a mesh, and axes of cylinders through points."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Ints
from jousto.base.object_repr import described
from jousto.mesh.grid import Grid
from jousto.mesh.surface import face_normals

# largest angle between the normals of neighbouring faces of one wall, degrees
SMOOTH = 35.0
# largest difference of radius and axis, relative to the radius, for walls of one cylinder
NEAR = 0.02
# fraction of the circumference that a hole must close
CLOSED = 0.75


LEAST = 8
"""Smallest number of points that identify a cylinder."""
ROUND = 0.01
"""Largest root mean square distance of the points from the cylinder / radius."""
GAP = np.radians(210.0)
"""Largest angle without points, rad."""


@described
@dataclass(frozen=True, eq=False)
class Hole:
    """Cylindrical hole.

    Attributes
    ----------
    name : str
        Names of the CAD faces of the hole, such as ``face3`` or ``face3+face4``; without CAD faces
        ``hole1`` and so on.
    point : (3,) ndarray
        Middle of the hole on its axis, m, part frame.
    axis : (3,) ndarray
        Unit vector along the hole; its largest component is positive.
    radius, length : float
        Radius and length, m.
    nodes : (n,) ndarray of int
        Node indices of the wall, sorted.
    """

    name: str
    point: Array
    axis: Array
    radius: float
    length: float
    nodes: Ints

    def __str__(self) -> str:
        at = ", ".join(f"{round(1e3 * x, 6) + 0.0:.6g}" for x in self.point)
        along = ", ".join(f"{round(x, 6) + 0.0:.3g}" for x in self.axis)
        return (
            f"{self.name}: hole of {2e3 * self.radius:.4g} mm, {1e3 * self.length:.4g} mm long,"
            f" at ({at}) mm along ({along}), {len(self.nodes)} nodes"
        )


def hole_text(hole: Hole) -> str:
    """Return diameter, length, position and direction of a hole as text."""
    place = ", ".join(f"{round(1e3 * x, 3) + 0.0:g}" for x in hole.point)
    along = [round(float(x), 3) + 0.0 for x in hole.axis]
    axis = "xyz"[int(np.argmax(np.abs(along)))]
    if sorted(map(abs, along)) != [0.0, 0.0, 1.0]:
        axis = "(" + ", ".join(f"{x:g}" for x in along) + ")"
    size = f"{2e3 * hole.radius:.4g} mm, {1e3 * hole.length:.4g} mm long"
    return f"{size}, at ({place}) mm along {axis}, {len(hole.nodes)} nodes"


def find_holes(mesh: Grid, radius: tuple[float, float]) -> tuple[Hole, ...]:
    """Return the cylindrical holes of a mesh, largest first.

    Outer faces are grouped into smooth walls, and a cylinder is fitted to each wall. Walls of the
    same cylinder are joined; they form a hole if they cover three quarters of the circumference and
    their normals point towards the axis.
    """
    walls = [wall for wall in _walls(mesh) if radius[0] <= wall.shape.radius <= radius[1]]
    found = []
    while walls:
        first = walls.pop(0)
        same = [wall for wall in walls if _same(first.shape, wall.shape)]
        walls = [wall for wall in walls if not any(wall is other for other in same)]
        hole = _joined(mesh, [first, *same])
        if hole is not None:
            found.append(hole)
    found.sort(key=lambda hole: -hole.radius)
    return tuple(
        hole if hole.name else replace(hole, name=f"hole{i + 1}") for i, hole in enumerate(found)
    )


@dataclass(frozen=True, eq=False)
class _Wall:
    shape: Cylinder
    nodes: Ints
    corners: Ints


def _walls(mesh: Grid) -> list[_Wall]:
    """Return the cylinders fitted to smooth walls with normals towards the axis."""
    corners = [block.corners for block in mesh.faces]
    if not corners:
        return []
    normals = np.concatenate([face_normals(mesh.nodes, c) for c in corners])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    label = _smooth(corners, normals)
    order = np.argsort(label, kind="stable")
    bounds = np.flatnonzero(np.diff(label[order])) + 1
    rows = np.full((len(normals), 4), -1)
    nodes = np.full((len(normals), 8), -1)
    at = 0
    for block, corner in zip(mesh.faces, corners, strict=True):
        rows[at : at + len(block), : corner.shape[1]] = corner
        nodes[at : at + len(block), : block.nodes.shape[1]] = block.nodes
        at += len(block)
    fitted = (
        _fit(mesh.nodes, rows[faces], nodes[faces], normals[faces])
        for faces in np.split(order, bounds)
    )
    return [wall for wall in fitted if wall is not None]


def _smooth(corners: list[Ints], normals: Array) -> Ints:
    """Return the index of the smooth wall of each face."""
    from scipy.sparse.csgraph import connected_components

    ends, faces, first = [], [], 0
    for block in corners:
        n = block.shape[1]
        pair = np.stack([block, np.roll(block, -1, axis=1)], axis=2).reshape(-1, 2)
        ends.append(np.sort(pair, axis=1))
        faces.append(np.repeat(np.arange(first, first + len(block)), n))
        first += len(block)
    edge, face = np.concatenate(ends), np.concatenate(faces)
    order = np.lexsort(edge.T)
    edge, face = edge[order], face[order]
    same = np.all(edge[1:] == edge[:-1], axis=1)
    i, j = face[:-1][same], face[1:][same]
    smooth = np.einsum("ij,ij->i", normals[i], normals[j]) > np.cos(np.radians(SMOOTH))
    i, j = i[smooth], j[smooth]
    graph = sp.coo_array((np.ones(len(i), dtype=np.int8), (i, j)), shape=(first, first))
    label: Ints = connected_components(graph, directed=False)[1].astype(np.int64)
    return label


def _fit(nodes: Array, corners: Ints, all_nodes: Ints, normals: Array) -> _Wall | None:
    """Return the cylinder of a wall; None if it is no cylinder or the normals point outwards."""
    if len(normals) < 3:
        return None
    # normals of a cylinder have almost no component along its axis (facets may be inclined)
    values = np.linalg.eigvalsh(normals.T @ normals / len(normals))
    if values[0] > 0.06 or values[1] < 0.02:
        return None
    used = np.unique(corners[corners >= 0])
    shape = cylinder_through(nodes[used])
    if shape is None:
        return None
    out = nodes[corners[:, 0]] - shape.middle
    out -= np.outer(out @ shape.axis, shape.axis)
    if np.sum(out * normals) > 0.0:  # a pin, not a hole
        return None
    return _Wall(shape, np.unique(all_nodes[all_nodes >= 0]), used)


def _same(a: Cylinder, b: Cylinder) -> bool:
    if abs(float(a.axis @ b.axis)) < 0.999 or abs(a.radius - b.radius) > NEAR * a.radius:
        return False
    apart = a.middle - b.middle
    apart = apart - (apart @ a.axis) * a.axis
    return float(np.linalg.norm(apart)) < NEAR * a.radius


def _joined(mesh: Grid, walls: list[_Wall]) -> Hole | None:
    shape = walls[0].shape
    axis = shape.axis * np.sign(shape.axis[np.argmax(np.abs(shape.axis))])
    wall = np.unique(np.concatenate([w.nodes for w in walls]))
    corners = np.unique(np.concatenate([w.corners for w in walls]))
    X = mesh.nodes[corners] - shape.middle
    along = X @ axis
    flat = X - np.outer(along, axis)
    e1 = flat[0] / np.linalg.norm(flat[0])
    angle = np.sort(np.arctan2(flat @ np.cross(axis, e1), flat @ e1))
    gaps = np.diff(angle, append=angle[0] + 2 * np.pi)
    if gaps.max() > 2 * np.pi * (1.0 - CLOSED):
        return None
    low, high = float(along.min()), float(along.max())
    point = shape.middle + (low + high) / 2.0 * axis
    names = [
        name
        for name, faces in mesh.surfaces.items()
        if len(faces) and np.isin(faces[faces >= 0], wall).all()
    ]
    radius = float(np.mean([w.shape.radius for w in walls]))
    return Hole("+".join(names), point, axis, radius, high - low, wall)


@dataclass(frozen=True, eq=False)
class Cylinder:
    """Cylinder through points.

    Attributes
    ----------
    middle : (3,) ndarray
        Middle of its axis in m.
    axis : (3,) ndarray
        Unit vector along it.
    radius, length : float
        Radius and length, m.
    """

    middle: Array
    axis: Array
    radius: float
    length: float


def cylinder_middle(x: Array) -> Array | None:
    """Return the middle of the axis of the cylinder through points, or None.

    Parameters
    ----------
    x : (k, 3) ndarray
        Points in m.

    Examples
    --------
    >>> t = np.linspace(0.0, 4.0, 12)  # 230 degrees of a ring
    >>> x = np.stack([np.cos(t), np.sin(t), 0.3 * (np.arange(12) % 2)], axis=1)
    >>> cylinder_middle(x).round(9) + 0.0
    array([0.  , 0.  , 0.15])
    """
    found = cylinder_through(x)
    return None if found is None else found.middle


def cylinder_through(x: Array) -> Cylinder | None:
    """Return the cylinder through points, or None.

    Least squares fit of axis, centre and radius, started from the three principal directions of the
    points.

    Parameters
    ----------
    x : (k, 3) ndarray
        Points in m.

    Examples
    --------
    >>> t = np.linspace(0.0, 4.0, 12)  # 230 degrees of a ring
    >>> x = np.stack([np.cos(t), np.sin(t), 0.3 * (np.arange(12) % 2)], axis=1)
    >>> round(cylinder_through(x).radius, 9)
    1.0
    """
    if len(x) < LEAST:
        return None
    centroid = x.mean(axis=0)
    size = float(np.linalg.norm(x - centroid, axis=1).max())
    if size == 0.0:
        return None
    y = (x - centroid) / size
    best: tuple[float, Cylinder] | None = None
    for axis in np.linalg.eigh(y.T @ y)[1].T:
        found = _fitted(y, axis)
        if found is not None and (best is None or found[0] < best[0]):
            best = found
    if best is None or best[0] > ROUND:
        return None
    c = best[1]
    return Cylinder(centroid + size * c.middle, c.axis, size * c.radius, size * c.length)


def _fitted(y: Array, axis: Array) -> tuple[float, Cylinder] | None:
    """Return the relative error and the fitted cylinder, for an initial axis."""
    from scipy.optimize import least_squares  # slow to import and rarely needed

    u, v = np.linalg.svd(axis[None, :])[2][1:]
    # circle in the plane normal to the axis: |y|^2 = 2 c.y + (r^2 - |c|^2)
    plane = np.stack([y @ u, y @ v], axis=1)
    A = np.column_stack([2.0 * plane, np.ones(len(y))])
    (a, b, c), *_ = np.linalg.lstsq(A, np.einsum("ij,ij->i", plane, plane), rcond=None)
    r = np.sqrt(max(c + a * a + b * b, 0.0))
    if not 0.0 < r < 4.0:
        return None

    def frame(p: Array) -> tuple[Array, Array, Array]:
        e = axis + p[0] * u + p[1] * v
        e = e / np.linalg.norm(e)
        centre = p[2] * u + p[3] * v
        arm = y - centre
        along = arm @ e
        return centre, e, np.linalg.norm(arm - along[:, None] * e, axis=1)

    if np.sqrt(np.mean((frame(np.array([0.0, 0.0, a, b, r]))[2] - r) ** 2)) > 0.3 * r:
        return None

    def distance(p: Array) -> Array:
        return np.asarray(frame(p)[2] - p[4])

    p = least_squares(distance, np.array([0.0, 0.0, a, b, r]), method="lm").x
    centre, e, away = frame(p)
    if not 0.0 < p[4] < 4.0:
        return None
    error = float(np.sqrt(np.mean((away / p[4] - 1.0) ** 2)))

    arm = y - centre
    along = arm @ e
    first = arm[0] - along[0] * e
    second = np.cross(e, first)
    angle = np.sort(np.arctan2(arm @ second, arm @ first))
    if np.diff(angle, append=angle[0] + 2.0 * np.pi).max() > GAP:
        return None
    low, high = float(along.min()), float(along.max())
    return error, Cylinder(centre + 0.5 * (low + high) * e, e, float(p[4]), high - low)
