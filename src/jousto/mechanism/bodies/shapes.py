"""Shapes of rigid bodies: mass, inertia and surface triangles for drawing."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.complexstep import scalar
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.fields import Choice
from jousto.base.numbers import Vector
from jousto.base.rotations import turn_onto
from jousto.base.units import LENGTHS
from jousto.mechanism.bodies.surface_files import file_triangles
from jousto.mesh.formats import is_cad

FACETS = 32  # facets around a drawn circle


@dataclass(frozen=True, eq=False)
class Solid:
    """Homogeneous solid with density 1.

    Attributes
    ----------
    volume : float
        m3.
    center : (3,) array
        m.
    inertia : (3, 3) array
        About the centre, m5.
    triangles : (nt, 3, 3) array
        The surface, m, counterclockwise seen from outside.
    """

    volume: float
    center: Array
    inertia: Array
    triangles: Array


class Lengths(Vector):
    """Field of three positive lengths."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the lengths as a read-only array, or report what is wrong."""
        lengths = super().check(problems, where, value)
        if lengths is not None and (lengths <= 0.0).any():
            problems.add(where, f"{self.name} is {lengths.tolist()} m, must be positive")
        return lengths


class LengthUnit(Choice):
    """Field of a unit of length."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the name of the unit, or report an unknown one."""
        if value not in self.words:
            problems.add(where, f"{self.name} is {value!r}{suggest(value, self.words)}")
        return value


def box(lengths: Array) -> Solid:
    """Return a box about the origin: ``I_xx = m (ly^2 + lz^2) / 12``."""
    squares = lengths**2
    volume = scalar(np.prod(lengths))
    inertia = np.diag(volume * (squares.sum() - squares) / 12.0)
    corner = 0.5 * lengths
    outward = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            j, k = (axis + 1) % 3, (axis + 2) % 3
            ring = []
            for y, z in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                x = np.zeros(3)
                x[axis], x[j], x[k] = side, y, z
                ring.append(x * corner)
            ring = ring if side > 0 else ring[::-1]
            outward += [[ring[0], ring[1], ring[2]], [ring[0], ring[2], ring[3]]]
    return Solid(volume, np.zeros(3), inertia, np.array(outward))


def cylinder(r: float, long: float, direction: Array) -> Solid:
    """Return a cylinder: ``I = m r^2 / 2`` about its axis, ``m (3 r^2 + l^2) / 12`` across."""
    volume = scalar(np.pi * r * r * long)
    across = (3.0 * r * r + long * long) / 12.0
    A = turn_onto(np.eye(3), direction)
    inertia = A @ np.diag(volume * np.array([across, across, 0.5 * r * r])) @ A.T
    profile = np.array([[0.0, -0.5], [r, -0.5], [r, 0.5], [0.0, 0.5]]) * [1.0, long]
    return Solid(volume, np.zeros(3), inertia, revolved(profile) @ A.T)


def sphere(r: float) -> Solid:
    """Return a sphere about the origin: ``I = 2 m r^2 / 5``."""
    volume = scalar(4.0 / 3.0 * np.pi * r**3)
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, FACETS // 2 + 1)
    profile = r * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    profile[[0, -1], 0] = 0.0
    return Solid(volume, np.zeros(3), 0.4 * volume * r * r * np.eye(3), revolved(profile))


def revolved(profile: Array) -> Array:
    """Return the triangles (nt, 3, 3) of a surface of revolution about z.

    The profile (k, 2) contains radius and height, m.
    """
    turn = 2.0 * np.pi * np.arange(FACETS + 1) / FACETS
    turn[-1] = 0.0
    x = profile[:, :1] * np.cos(turn)
    y = profile[:, :1] * np.sin(turn)
    z = np.repeat(profile[:, 1:], FACETS + 1, axis=1)
    grid = np.stack([x, y, z], axis=2)
    low, high = grid[:-1], grid[1:]
    first = np.stack([low[:, :-1], low[:, 1:], high[:, 1:]], axis=2).reshape(-1, 3, 3)
    second = np.stack([low[:, :-1], high[:, 1:], high[:, :-1]], axis=2).reshape(-1, 3, 3)
    triangles = np.concatenate([first, second])
    area = np.linalg.norm(
        np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1
    )
    return np.asarray(triangles[area > 1e-12 * area.max()])


def closed_surface(where: str, triangles: Array) -> Solid:
    """Return the solid inside a closed surface, by the divergence theorem.

    With the corners a, b, c of each triangle, s = a + b + c and d = a . (b x c):
    ``V = sum d / 6``, ``int x dV = sum d s / 24`` and
    ``int x x^T dV = sum d (s s^T + a a^T + b b^T + c c^T) / 120``.

    Raises
    ------
    InputError
        If the surface is open, its triangles have inconsistent orientation, or it encloses no
        volume.
    """
    points, corners = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    corners = corners.reshape(-1, 3)
    full = (corners != np.roll(corners, 1, axis=1)).all(axis=1)  # edges whose ends differ
    corners, triangles = corners[full], triangles[full]
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    there = np.unique(edges, axis=0, return_counts=True)
    back = np.unique(edges[:, ::-1], axis=0, return_counts=True)
    same = len(there[0]) == len(back[0]) and all(
        np.array_equal(one, other) for one, other in zip(there, back, strict=True)
    )
    if not same:
        _refuse(where, points, edges)
    # relative to the middle, so that a body far from the origin is computed accurately
    middle = points.mean(axis=0)
    a, b, c = np.moveaxis(triangles - middle, 1, 0)
    d = np.einsum("ti,ti->t", a, np.cross(b, c))
    _check_pieces(where, corners, triangles - middle, d)
    volume = float(d.sum()) / 6.0
    size = float(np.ptp(points, axis=0).max())
    if abs(volume) <= 1e-12 * size**3:
        raise InputError(
            Problem(where, "the surface encloses no volume; give the surface of a solid")
        )
    if volume < 0.0:  # all triangles face inwards
        triangles, d, volume = triangles[:, ::-1], -d, -volume
    s = a + b + c
    first = np.einsum("t,ti->i", d, s) / 24.0
    second = sum(np.einsum("t,ti,tj->ij", d, x, x) for x in (s, a, b, c)) / 120.0
    center = first / volume
    second = second - volume * np.outer(center, center)
    inertia = np.trace(second) * np.eye(3) - second
    return Solid(volume, middle + center, inertia, np.array(triangles))


def _check_pieces(where: str, corners: NDArray[np.int_], triangles: Array, d: Array) -> None:
    """Raise InputError if a piece of a surface faces inwards and is not a cavity of another piece.

    A cavity faces inwards and lies inside a piece that faces outwards: seen from a corner of the
    cavity, the solid angle of that piece is 4 pi; seen from outside of the piece it is 0.
    """
    from scipy.sparse import coo_array  # slow to import and rarely needed
    from scipy.sparse.csgraph import connected_components

    count = int(corners.max()) + 1
    links = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]]])
    graph = coo_array((np.ones(len(links)), links.T), shape=(count, count))
    number, label = connected_components(graph, directed=False)
    piece = label[corners[:, 0]]
    volumes = np.bincount(piece, d, number)
    turned = np.flatnonzero(volumes * np.sign(d.sum() or 1.0) < 0.0)
    outer = triangles[~np.isin(piece, turned)]
    lost = [i for i in turned if abs(_turns_round(outer, triangles[piece == i][0, 0])) < 0.5]
    if lost:
        at = ", ".join(f"{x:.4g}" for x in triangles[piece == lost[0]].mean(axis=(0, 1)))
        raise InputError(
            Problem(
                where,
                f"{len(lost)} of {number} pieces of the surface face inwards without being "
                f"cavities of another piece, the first at ({at}) m from the middle; let the "
                f"program that made it "
                "repair the normals",
            )
        )


def _turns_round(triangles: Array, point: Array) -> float:
    """Return the winding number of triangles (nt, 3, 3) about a point (3,): solid angle / 4 pi.

    ``tan(W / 2) = a . (b x c) / (abc + (a . b) c + (b . c) a + (c . a) b)`` (Van Oosterom and
    Strackee 1983).
    """
    a, b, c = np.moveaxis(triangles - point, 1, 0)
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    top = np.einsum("ti,ti->t", a, np.cross(b, c))
    dots = [np.einsum("ti,ti->t", x, y) for x, y in ((a, b), (b, c), (c, a))]
    below = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    return float(np.arctan2(top, below).sum() / (2.0 * np.pi))


def _refuse(where: str, points: Array, edges: NDArray[np.int_]) -> None:
    """Raise InputError with number and place of open edges or inconsistently oriented triangles."""
    low = np.sort(edges, axis=1)
    found, times = np.unique(low, axis=0, return_counts=True)
    open_ = found[times % 2 == 1]
    if len(open_):
        at = ", ".join(f"{x:.4g}" for x in points[open_[0]].mean(axis=0))
        raise InputError(
            Problem(
                where,
                f"the surface is open: {len(open_)} edges belong to one triangle only, the first "
                f"at ({at}) m; close it, or give mass and inertia",
            )
        )
    raise InputError(
        Problem(
            where,
            "triangles of the surface have inconsistent orientation, so that inside and outside "
            "cannot be distinguished; let the program that made it repair the normals",
        )
    )


def read_surface(where: str, source: Any, unit: str) -> Array:
    """Return the triangles (nt, 3, 3), m, of a file, a `Mesh` or an array."""
    if hasattr(source, "triangles") and hasattr(source, "nodes"):  # a mesh of solids, in m
        mesh: Any = source
        return np.asarray(mesh.nodes[mesh.triangles], dtype=np.float64)
    if isinstance(source, str | os.PathLike) and is_cad(Path(source)):
        from jousto.mesh.readers.step import cad_surface  # slow to import

        # a STEP file contains its unit
        step = Path(source).suffix.lower() in (".step", ".stp")
        return cad_surface(Path(source), None if step else unit)
    if isinstance(source, str | os.PathLike):
        return file_triangles(where, Path(source), LENGTHS[unit])
    problems = Problems()
    found = problems.array(where, "triangles", source, (None, 3, 3))
    problems.raise_if_any()
    assert found is not None
    return LENGTHS[unit] * found
