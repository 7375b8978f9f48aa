"""A force that travels along a body."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.described import described
from jousto.base.errors import InputError, Problems
from jousto.base.names import check_name
from jousto.base.numbers import set_fields
from jousto.base.rotations import Array, readonly
from jousto.mechanism.bodies.body import FlexibleBody, MovingBody, RigidBody
from jousto.mechanism.signals.base import Signal, check_signal

NEAR = 1e-6  # of the length of a line: nodes that count as on it


@explained
@described
@dataclass(frozen=True, eq=False, init=False)
class MovingLoad:
    """A force whose point of attack travels along a body, such as a wheel on a rail.

    Between two nodes a flexible body is followed by cubics through their displacements and slopes,
    as the elements of a beam do: ``Q_p = Phi(s)^T A^T F`` at the path length s(t). The force has
    no mass, and acts only while s is on the path.

    Parameters
    ----------
    name : str
        Name, unique among the forces.
    body : FlexibleBody or RigidBody
        The body; the part of a flexible one has rotations at its nodes.
    path : sequence of str
        Names of two nodes or markers or more: the corners of the path. It goes straight from one
        to the next, through all nodes that lie between; s is counted from the first, m.
    vector : (3,) array_like
        Force F, N: in the world frame, or in the body frame if `follow`.
    position : Signal or float
        s(t), m.
    follow : bool
        Whether the force turns with the body.
    signal : Signal or float, optional
        Factor on the force as a function of time; None for 1.
    """

    kind: ClassVar[str] = "moving load"
    name: str
    body: MovingBody
    path: tuple[str, ...]
    vector: Array
    position: Signal
    follow: bool
    signal: Signal | None
    nodes: tuple[int, ...]
    points: Array

    def __init__(
        self,
        name: str,
        body: MovingBody,
        path: Sequence[str],
        vector: ArrayLike,
        position: Signal | float,
        *,
        follow: bool = False,
        signal: Signal | float | None = None,
    ) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        nodes: tuple[int, ...] = ()
        points = np.zeros((0, 3))
        checked: Any = body
        names: Any = () if isinstance(path, str) else tuple(path)
        if not isinstance(checked, FlexibleBody | RigidBody):
            problems.add(where, f"body is {checked!r}, must be a flexible or a rigid body")
        elif len(names) < 2:
            text = "must name two nodes or more, such as start and end"
            problems.add(where, f"path is {path!r}, {text}")
        elif isinstance(body, RigidBody):
            points = corners_of(problems, where, body, names)
        else:
            points = corners_of(problems, where, body, names)
            nodes = nodes_on(body, points)
            points = np.asarray(body.reduced.nodes)[list(nodes)]
            if any(body.reduced.rotation(k) is None for k in nodes):
                problems.add(
                    where,
                    f"body {body.name!r} knows no rotations of its nodes, so that the way between "
                    "them is unknown; use a part made of beams, or forces at its nodes",
                )
        F = problems.array(where, "vector", vector, (3,))
        s = check_signal(problems, where, "position", position)
        factor = None if signal is None else check_signal(problems, where, "signal", signal)
        problems.raise_if_any()
        set_fields(
            self,
            name=name,
            body=body,
            path=tuple(path),
            vector=F,
            position=s,
            follow=bool(follow),
            signal=factor,
            nodes=nodes,
            points=readonly(points),
        )

    @property
    def lengths(self) -> Array:
        """Path length at each node of the path (k,), m, from 0."""
        steps = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        return readonly(np.concatenate([[0.0], np.cumsum(steps)]))

    @property
    def pieces(self) -> Array:
        """Coefficients (k - 1, 1 + n, 3, 4) of (s - s_k)^0..3: position, then the modes."""
        x = self.points
        h = np.diff(self.lengths)[:, None, None]
        t = np.diff(x, axis=0) / h[:, 0]
        zero = np.zeros_like(t)
        position = np.stack([x[:-1], t, zero, zero], axis=-1)[:, None]
        if isinstance(self.body, RigidBody):
            return readonly(position)
        reduced, nodes = self.body.reduced, list(self.nodes)
        u = reduced.modes[nodes]
        theta = np.stack([np.asarray(reduced.rotation(k)) for k in nodes])
        rise = (u[1:] - u[:-1]) / h
        # across the line the slope follows the rotations, along it the stretch is even
        along = t[:, :, None] * np.einsum("ka,kaj->kj", t, rise)[:, None, :]
        first = np.cross(theta[:-1], t[:, :, None], axis=1) + along
        last = np.cross(theta[1:], t[:, :, None], axis=1) + along
        powers = [
            u[:-1],
            first,
            (3 * rise - 2 * first - last) / h,
            (first + last - 2 * rise) / h**2,
        ]
        return readonly(np.concatenate([position, np.stack(powers, -1).swapaxes(1, 2)], axis=1))


def corners_of(problems: Problems, where: str, body: MovingBody, names: Sequence[str]) -> Array:
    """Return the corners (k, 3) of a path, body frame, or none if one is wrong."""
    corners = []
    for name in names:
        try:
            marker = body[name]
        except InputError as error:
            problems.add(where, f"path: {error.problems[0].message}")
            continue
        if isinstance(body, FlexibleBody) and marker.node is None:
            problems.add(where, f"path: {name!r} is not a node")
        else:
            corners.append(marker.position_local)
    if len(corners) < len(names):
        return np.zeros((0, 3))
    points = np.array(corners)
    for a, b in itertools.pairwise(points):
        if np.array_equal(a, b):
            problems.add(where, f"path: two corners that follow one another are at {a.tolist()}")
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
        # of nodes at one place the first
        found = [
            k for i, k in enumerate(found) if not i or way[k] - way[found[i - 1]] > NEAR * length
        ]
        nodes += found[1:] if nodes else found
    return tuple(nodes)
