"""Position, displacement and stress at a point of a body over rows, in double precision.

Bodies: ``x = R + A(e) (x0 + sum_j phi_j p_j)`` and ``sigma = static + sum_j Sigma_j p_j``; swept
beams between the poses of the ends of their elements (`jousto.scene.values_at_rows`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from jousto.base.arrays import Array
from jousto.recovery.beams.strains import exponential, logarithm
from jousto.recovery.shape import rotation_matrices

if TYPE_CHECKING:
    from jousto.scene.scene import Body, Rings, Scene


@dataclass(frozen=True, eq=False)
class Point:
    """Vertex of a body, with the row columns on which it depends.

    Attributes
    ----------
    body : Body
    vertex : int
    """

    body: Body
    vertex: int

    @cached_property
    def columns(self) -> slice:
        """Row columns on which the point depends."""
        body, rings = self.body, self.body.rings
        if rings is not None:
            i, j = self._element(rings)
            found = [*rings.places[[i, j]].tolist(), *(rings.places[[i, j]] + 6).tolist()]
            if rings.forces >= 0:
                first = rings.forces + 12 * i
                found += [first, first + 11]
            return slice(int(min(found)), int(max(found)) + 1)
        if body.place < 0:
            return slice(0, 0)
        return slice(body.place, body.place + 7 + body.modes)

    def _element(self, rings: Rings) -> tuple[int, int]:
        i = int(rings.element[int(rings.vertex_ring[self.vertex])])
        return i, i + 1

    def displacements(self, rows: Array) -> Array:
        """Return the displacement (k, 3) in the body frame, m; zero for swept beams.

        Parameters
        ----------
        rows : (k, ...) array
            The `columns` of rows.
        """
        body = self.body
        if body.shapes is None or body.place < 0:
            return np.zeros((len(rows), 3))
        shapes = np.asarray(body.shapes[:, self.vertex], dtype=np.float64)
        return np.asarray(rows[:, 7:] @ shapes)

    def positions(self, rows: Array) -> Array:
        """Return the world position (k, 3), m."""
        body = self.body
        if body.rings is not None:
            return self._swept(body.rings, rows)
        local = np.asarray(body.positions[self.vertex]) + self.displacements(rows)
        if body.place < 0:
            return local
        A = rotation_matrices(rows[:, 3:7])
        return np.asarray(rows[:, :3] + np.einsum("tij,tj->ti", A, local))

    def stresses(self, rows: Array) -> Array | None:
        """Return the stress (k, 6), Pa, in the axes of the body; None where unknown."""
        body, v = self.body, self.vertex
        if body.known is not None and not body.known[v]:
            return None
        if body.rings is not None:
            return self._carried(body.rings, rows)
        if body.stress is None and body.static is None:
            return None
        found = np.zeros((len(rows), 6))
        if body.static is not None:
            found += np.asarray(body.static[v], dtype=np.float64)
        if body.stress is not None and body.place >= 0:
            found += rows[:, 7:] @ np.asarray(body.stress[:, v], dtype=np.float64)
        return found

    # -- swept beams ------------------------------------------------------------------------

    def _swept(self, rings: Rings, rows: Array) -> Array:
        i, j = self._element(rings)
        b = float(rings.share[int(rings.vertex_ring[self.vertex])])
        a = 1.0 - b
        ra, Qa = self._end(rings, rows, i, i, 0)
        rb, Qb = self._end(rings, rows, i, j, 1)
        phi = logarithm(np.swapaxes(Qa, -1, -2) @ Qb)
        Q = Qa @ exponential(b * phi)
        size = np.linalg.norm(rb - ra, axis=-1, keepdims=True)
        ta, tb = size * Qa[..., 0], size * Qb[..., 0]
        r = a * a * (1 + 2 * b) * ra + b * b * (1 + 2 * a) * rb + a * a * b * ta - a * b * b * tb
        yz = np.asarray(rings.yz[self.vertex], dtype=np.float64)
        return np.asarray(r + Q[..., 1:] @ yz)

    def _end(
        self, rings: Rings, rows: Array, element: int, node: int, side: int
    ) -> tuple[Array, Array]:
        first = int(rings.places[node]) - self.columns.start
        R, e = rows[:, first : first + 3], rows[:, first + 3 : first + 7]
        A = rotation_matrices(e)
        own = np.asarray(rings.ends[element, side], dtype=np.float64)
        return R + A @ own[:3], A @ rotation_matrices(own[3:])

    def _carried(self, rings: Rings, rows: Array) -> Array | None:
        if rings.forces < 0:
            return None
        i, _ = self._element(rings)
        b = float(rings.share[int(rings.vertex_ring[self.vertex])])
        first = rings.forces + 12 * i - self.columns.start
        p = (1.0 - b) * rows[:, first : first + 6] + b * rows[:, first + 6 : first + 12]
        stress = p @ np.asarray(rings.rows[int(rings.corner[self.vertex])]).T
        return None if np.isnan(stress).any() else stress


def rows_of(scene: Scene, point: Point, instants: slice) -> Array:
    """Return the `columns` of a point at stored instants; only these are read from a file."""
    assert scene.motion is not None
    if point.body.place < 0 and point.body.rings is None:
        return np.zeros((len(range(*instants.indices(len(scene.motion.times)))), 0))
    if scene.run is not None and point.body.rings is None:
        return scene.run.coordinates(point.body.name, instants)
    return scene.motion.rows(instants)[:, point.columns]
