"""Force that travels along a body."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from jousto.base.arrays import Array, read_only
from jousto.base.complexstep import floats
from jousto.base.errors import InputError, Problems
from jousto.base.fields import Flag, Texts, field
from jousto.base.numbers import Vector
from jousto.mechanism.bodies.body import FlexibleBody, MovingBody, RigidBody
from jousto.mechanism.bodies.body_field import MovingBodyField
from jousto.mechanism.forces.base import ForceElement, Push
from jousto.mechanism.forces.law import EngineLaw
from jousto.mechanism.signals.base import OptionalSignal, SignalField

NEAR = 1e-6  # largest distance of a node from the line, relative to the length of the line

TWO = "must name two nodes or more, such as start and end"


EngineLaw(
    "moving load", units={"force": "N"}, constants=("count", "modes"), reference="m"
).declared()


class MovingLoad(ForceElement, tag="moving-load"):
    """Force whose point of application travels along a body, such as a wheel on a rail.

    Between two nodes of a flexible body the displacement is a cubic through the displacements and
    slopes of the nodes, as in a beam element: ``Q_p = Phi(s)^T A^T F`` at the path length s(t). The
    load has no mass and acts only while s is on the path. The path is straight from each corner to
    the next, through all nodes between them.
    """

    kind = "moving load"
    measured = ("force",)
    together = ("body", "path")
    body: MovingBodyField = field(
        "The body; the part of a flexible body must have rotations at its nodes"
    )
    path: Texts = field(
        "Corners of the path: names of two or more nodes or markers; s is measured from the first",
        wanted=TWO,
    )
    vector: Vector = field(
        "Force F: in the world frame, or in the body frame if `follow`", unit="N"
    )
    position: SignalField = field("Path length s(t)", unit="m")
    follow: Flag = field("Whether the force turns with the body", default=False, kw_only=True)
    signal: OptionalSignal = field(
        "Factor on the force as a function of time; None for 1",
        unit="1",
        default=None,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report an invalid path, and nodes without rotational degrees of freedom."""
        if len(self.path) < 2:
            problems.add(where, f"path is {list(self.path)!r}, {TWO}", "path")
            return
        corners = corners_of(problems, where, self.body, self.path)
        if isinstance(self.body, RigidBody) or not len(corners):
            return
        if any(self.body.reduced.rotation(k) is None for k in nodes_on(self.body, corners)):
            problems.add(
                where,
                f"body {self.body.name!r} has no rotations at its nodes, so that the path "
                "between them is unknown; use a part made of beams, or forces at its nodes",
                "body",
            )

    @cached_property
    def nodes(self) -> tuple[int, ...]:
        """Nodes of the path; none on a rigid body."""
        if isinstance(self.body, RigidBody):
            return ()
        return nodes_on(self.body, corners_of(Problems(), "", self.body, self.path))

    @cached_property
    def points(self) -> Array:
        """Positions (k, 3) of the nodes or corners of the path, body frame, m."""
        if isinstance(self.body, RigidBody):
            return read_only(corners_of(Problems(), "", self.body, self.path))
        return read_only(np.asarray(self.body.reduced.nodes)[list(self.nodes)])

    @property
    def lengths(self) -> Array:
        """Path length (k,) in m at each node of the path, from 0."""
        steps = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        return read_only(np.concatenate([[0.0], np.cumsum(steps)]))

    @property
    def drawn_at(self) -> tuple[tuple[MovingBody, Array], ...]:
        """The points of the path."""
        return tuple((self.body, point) for point in self.points)

    @property
    def direction(self) -> tuple[Array, bool]:
        """Direction of the vector, in the body frame if it follows the body."""
        return np.array(floats(self.vector)), self.follow

    @property
    def pieces(self) -> Array:
        """Coefficients (k - 1, 1 + n, 3, 4) of (s - s_k)^0..3, for the position, then each mode."""
        x = self.points
        h = np.diff(self.lengths)[:, None, None]
        t = np.diff(x, axis=0) / h[:, 0]
        zero = np.zeros_like(t)
        position = np.stack([x[:-1], t, zero, zero], axis=-1)[:, None]
        if isinstance(self.body, RigidBody):
            return read_only(position)
        reduced, nodes = self.body.reduced, list(self.nodes)
        u = reduced.modes[nodes]
        theta = np.stack([np.asarray(reduced.rotation(k)) for k in nodes])
        rise = (u[1:] - u[:-1]) / h
        # the lateral slope follows the rotations; the stretch along the line is uniform
        along = t[:, :, None] * np.einsum("ka,kaj->kj", t, rise)[:, None, :]
        first = np.cross(theta[:-1], t[:, :, None], axis=1) + along
        last = np.cross(theta[1:], t[:, :, None], axis=1) + along
        powers = [
            u[:-1],
            first,
            (3 * rise - 2 * first - last) / h,
            (first + last - 2 * rise) / h**2,
        ]
        return read_only(np.concatenate([position, np.stack(powers, -1).swapaxes(1, 2)], axis=1))

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The force along its path."""
        pieces = self.pieces
        count, modes = len(self.points), pieces.shape[1] - 1
        return (
            Push(
                "moving load",
                {"count": count, "modes": modes, "force": self.vector},
                (self.lengths, pieces),
                body=self.body,
                follow=self.follow,
                signal=self.signal,
                reference=self.position,
            ),
        )


def corners_of(problems: Problems, where: str, body: MovingBody, names: Sequence[str]) -> Array:
    """Return the corners (k, 3) of a path, body frame, m, or report wrong ones."""
    corners = []
    for i, name in enumerate(names):
        try:
            marker = body[name]
        except InputError as error:
            problems.add(where, error.problems[0].message, "path", i, named=False)
            continue
        if isinstance(body, FlexibleBody) and marker.node is None:
            problems.add(where, f"{name!r} is not a node", "path", i, named=False)
        else:
            corners.append(marker.position_local)
    if len(corners) < len(names):
        return np.zeros((0, 3))
    points = np.array(corners)
    for a, b in itertools.pairwise(points):
        if np.array_equal(a, b):
            problems.add(
                where,
                f"two successive corners are both at {a.tolist()}",
                "path",
                named=False,
            )
            return np.zeros((0, 3))
    return points


def nodes_on(body: FlexibleBody, corners: Array) -> tuple[int, ...]:
    """Return all nodes of a path from corner to corner."""
    x = np.asarray(body.reduced.nodes)
    nodes: list[int] = []
    for a, b in itertools.pairwise(corners):
        line = b - a
        length = float(np.linalg.norm(line))
        way = (x - a) @ line / length
        off = np.linalg.norm(x - a - np.outer(way, line / length), axis=1)
        on = (off < NEAR * length) & (way > -NEAR * length) & (way < (1 + NEAR) * length)
        found = [int(k) for k in np.flatnonzero(on)[np.argsort(way[on], kind="stable")]]
        # first of several nodes at one position
        found = [
            k for i, k in enumerate(found) if not i or way[k] - way[found[i - 1]] > NEAR * length
        ]
        nodes += found[1:] if nodes else found
    return tuple(nodes)
