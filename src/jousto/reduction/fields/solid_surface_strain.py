"""Surface strain of solids under the grid of a strain gauge, from displacements only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array, Index
from jousto.mesh.reference import FACES, places, shape_functions

STEPS = 16
"""Number of pieces of a grid along its length."""

LINES = 5
"""Number of lines over the width of a grid (Gauss-Legendre, exact to degree 9)."""

SLACK = 0.25
"""Largest distance of a grid from the surface / length of a piece."""

INWARD = 1e-12


@dataclass(frozen=True, eq=False)
class Foot:
    """Point of a surface nearest to a point of space.

    Attributes
    ----------
    x : (3,) array
        Position of the nearest point, m.
    normal : (3,) array
        Unit normal, outwards.
    nodes : (k,) int array
        Nodes of the face.
    N : (k,) array
        Shape functions.
    G : (3, k) array
        Their derivatives along x, y and z within the tangent plane, 1/m.
    distance : float
        Distance from the point to its foot, m.
    """

    x: Array
    normal: Array
    nodes: Index
    N: Array
    G: Array
    distance: float


@dataclass(frozen=True, eq=False)
class Weights:
    """Linear functional of nodal displacements, ``sum_a w_a . u_a``.

    Attributes
    ----------
    nodes : (m,) int array
        Nodes, each once, ascending.
    values : (m, 3) array
        Weights w of the displacements of these nodes; 1/m for a strain.
    """

    nodes: Index
    values: Array

    def __call__(self, u: Array) -> Array:
        """Return the value for displacements u (nn, 3), or the values (n,) for modes (nn, 3, n)."""
        return np.asarray(np.tensordot(self.values, u[self.nodes], axes=([0, 1], [0, 1])))

    @classmethod
    def gather(cls, nodes: Sequence[Index], values: Sequence[Array]) -> Weights:
        """Return the sum of several functionals."""
        every, place = np.unique(np.concatenate(nodes), return_inverse=True)
        total = np.zeros((len(every), 3))
        np.add.at(total, place, np.concatenate(values))
        return cls(every, total)


class LeavesSurface(Exception):
    """Error raised if a grid extends beyond the surface or around a sharp edge.

    Attributes
    ----------
    reach : float
        Distance from the middle of the grid to that point, m.
    """

    def __init__(self, reach: float) -> None:
        super().__init__(f"{reach:g} m")
        self.reach = reach


class Skin:
    """Outer faces of a solid: nearest points and paths on them.

    Parameters
    ----------
    nodes : (nn, 3) array
        Positions, m.
    faces : sequence of (nf, k) int array
        Faces of 3, 4, 6 or 8 nodes, corners first, normals outwards.
    """

    def __init__(self, nodes: Array, faces: Sequence[Index]) -> None:
        self.nodes = nodes
        self.faces = tuple(face for face in faces if len(face))
        self._middle = [nodes[face].mean(axis=1) for face in self.faces]
        # a quadratic face may bulge between its nodes
        self._radius = [
            1.2 * np.linalg.norm(nodes[face] - middle[:, None], axis=2).max(axis=1)
            for face, middle in zip(self.faces, self._middle, strict=True)
        ]

    def around(self, x: Array, reach: float) -> Skin:
        """Return the faces within a distance of a point, m, and the face nearest to it."""
        near = []
        gaps = [
            np.linalg.norm(middle - x, axis=1) - radius
            for middle, radius in zip(self._middle, self._radius, strict=True)
        ]
        spare = min(
            float((gap + 2.0 * radius).min())
            for gap, radius in zip(gaps, self._radius, strict=True)
        )
        for face, gap in zip(self.faces, gaps, strict=True):
            near.append(face[gap <= max(reach, spare)])
        return Skin(self.nodes, near)

    def foot(self, x: Array) -> Foot:
        """Return the point of the surface nearest to x (3,)."""
        best: tuple[float, int, int, Array] | None = None
        for block, (middle, radius) in enumerate(zip(self._middle, self._radius, strict=True)):
            away = np.linalg.norm(middle - x, axis=1)
            bound = float((away + radius).min())
            if best is not None:
                bound = min(bound, best[0])
            rows = np.flatnonzero(away - radius <= bound)
            if not len(rows):
                continue
            xi, distance = _nearest(self.nodes[self.faces[block][rows]], x)
            # among faces at equal distance the first one counts, so that every run has the same
            # result
            i = int(np.argmax(distance <= distance.min() * (1.0 + 1e-9) + 1e-15))
            if best is None or distance[i] < best[0]:
                best = (float(distance[i]), block, int(rows[i]), xi[i])
        assert best is not None
        return self._foot(best[1], best[2], best[3], best[0])

    def feet(self, x: Array) -> list[Foot]:
        """Return the nearest point once per face that contains it."""
        nearest = self.foot(x)
        found = []
        for block, (middle, radius) in enumerate(zip(self._middle, self._radius, strict=True)):
            rows = np.flatnonzero(np.linalg.norm(middle - nearest.x, axis=1) <= radius * 1.0001)
            if not len(rows):
                continue
            xi, distance = _nearest(self.nodes[self.faces[block][rows]], nearest.x)
            for i in np.flatnonzero(distance <= 1e-6 * radius[rows]):
                foot = self._foot(block, int(rows[i]), xi[i], nearest.distance)
                if float(foot.normal @ nearest.normal) > 0.7:
                    found.append(foot)
        return found or [nearest]

    def _foot(self, block: int, row: int, xi: Array, distance: float) -> Foot:
        nodes = self.faces[block][row]
        N, dN = shape_functions(FACES[len(nodes)][0], xi[None])
        x = self.nodes[nodes]
        tangents = dN[0] @ x
        across = np.cross(tangents[0], tangents[1])
        area = float(np.linalg.norm(across))
        normal = across / area
        dual = np.stack([np.cross(tangents[1], normal), np.cross(normal, tangents[0])]) / area
        return Foot(N[0] @ x, normal, nodes, N[0], dual.T @ dN[0], distance)


def point_strain(feet: Sequence[Foot], t: Array) -> Weights:
    """Return the strain ``t . grad u t`` at a point, the mean over the faces at the point.

    Parameters
    ----------
    feet : sequence of Foot
        See `Skin.feet`.
    t : (3,) array
        Unit direction; its component in the plane of each face is used.
    """
    values = []
    for foot in feet:
        s = tangent(t, foot.normal)
        values.append(np.outer(s @ foot.G, s) / len(feet))
    return Weights.gather([foot.nodes for foot in feet], values)


def grid_strain(skin: Skin, start: Foot, t: Array, length: float, width: float) -> Weights:
    """Return the mean strain under a grid, which is its elongation over its length.

    ``sum_k c_k . (u_k+1 - u_k) / sum_k |dx_k|`` along the unit chords c_k of a path on the surface.
    On a plane face this is the difference of the displacements of both ends divided by the length,
    exact for the finite element field. The mean over the width uses `LINES` lines.

    Parameters
    ----------
    skin : Skin
    start : Foot
        Middle of the grid.
    t : (3,) array
        Unit direction in the tangent plane.
    length, width : float
        Of the grid, m; a width of zero is one line.

    Raises
    ------
    LeavesSurface
        If the grid extends beyond the surface or around a sharp edge.
    """
    near = skin.around(start.x, 0.75 * (length + width))
    gauss, share = np.polynomial.legendre.leggauss(LINES)
    offsets, shares = (0.5 * width * gauss, 0.5 * share) if width > 0.0 else (np.zeros(1), [1.0])
    nodes: list[Index] = []
    values: list[Array] = []
    for offset, part in zip(offsets, shares, strict=True):
        middle, along = start, t
        if offset != 0.0:
            across = np.cross(start.normal, t) * np.sign(offset)
            pieces = STEPS // 4
            walked = _walk(near, start, across, abs(float(offset)), pieces)
            middle = walked[-1]
            along = tangent(t, middle.normal)
        back = _walk(near, middle, -along, 0.5 * length, STEPS // 2)
        forth = _walk(near, middle, along, 0.5 * length, STEPS // 2)
        path = [*back[::-1], middle, *forth]
        chords = np.diff([foot.x for foot in path], axis=0)
        size = np.linalg.norm(chords, axis=1)
        c = chords / size[:, None]
        # u_k belongs to the end of chord k-1 and to the start of chord k
        factor = np.zeros((len(path), 3))
        factor[1:] += c
        factor[:-1] -= c
        factor *= part / size.sum()
        for foot, w in zip(path, factor, strict=True):
            nodes.append(foot.nodes)
            values.append(np.outer(foot.N, w))
    return Weights.gather(nodes, values)


def tangent(t: Array, normal: Array) -> Array:
    """Return the unit vector along the projection of t onto the plane with a unit normal."""
    s = t - (t @ normal) * normal
    return np.asarray(s / np.linalg.norm(s))


def _walk(skin: Skin, start: Foot, t: Array, length: float, pieces: int) -> list[Foot]:
    """Return the points of a straightest path on the surface, without the start."""
    step = length / pieces
    out, here, along = [], start, t
    for k in range(pieces):
        there = skin.foot(here.x + step * along)
        bend = float(there.normal @ here.normal)
        if there.distance > SLACK * step or bend < 0.5:
            raise LeavesSurface((k + 1) * step)
        along = tangent(along, there.normal)
        out.append(there)
        here = there
    return out


def _nearest(x: Array, point: Array) -> tuple[Array, Array]:
    """Return the reference coordinates (m, 2) on faces x (m, k, 3) nearest to a point.

    Gauss-Newton steps restricted to the face; the distances (m,) are returned, too.
    """
    kind = FACES[x.shape[1]][0]
    corners = 3 if kind.startswith("triangle") else 4
    xi = np.tile(places(kind)[:corners].mean(axis=0), (len(x), 1))
    best, least = xi.copy(), np.full(len(x), np.inf)
    for _ in range(25):
        N, dN = shape_functions(kind, xi)
        r = point - np.einsum("mk,mkx->mx", N, x)
        distance = np.linalg.norm(r, axis=1)
        better = distance < least
        best[better], least[better] = xi[better], distance[better]
        J = np.einsum("mck,mkx->mcx", dN, x)
        A = np.einsum("mcx,mdx->mcd", J, J)
        b = np.einsum("mcx,mx->mc", J, r)
        A = A + INWARD * np.trace(A, axis1=1, axis2=2)[:, None, None] * np.eye(2)
        new = _inside(xi + np.linalg.solve(A, b[:, :, None])[:, :, 0], corners)
        if float(np.abs(new - xi).max(initial=0.0)) < 1e-13:
            break
        xi = new
    return best, least


def _inside(xi: Array, corners: int) -> Array:
    """Return the reference coordinates, moved into the triangle or the square if outside."""
    if corners == 4:
        return np.clip(xi, 0.0, 1.0)
    over = np.maximum(xi.sum(axis=1) - 1.0, 0.0) / 2.0
    beyond = over > 0.0
    xi = xi - over[:, None]
    clipped = np.maximum(xi, 0.0)
    # on the hypotenuse, points beyond a corner are moved to the corner
    total = clipped.sum(axis=1)
    scale = np.where(beyond & (total > 1.0), 1.0 / np.where(total > 0.0, total, 1.0), 1.0)
    return np.asarray(clipped * scale[:, None])
