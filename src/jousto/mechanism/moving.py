"""A force that travels along a flexible body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jousto.errors import InputError, Problems
from jousto.mechanism.body import FlexibleBody
from jousto.mechanism.fields import check_name, set_fields
from jousto.mechanism.orientation import Array, readonly
from jousto.mechanism.signals import Signal, check_factor, check_signal

NEAR = 1e-6  # of the length of a line: nodes that count as on it


@dataclass(frozen=True, eq=False, init=False)
class MovingLoad:
    """A force whose point of attack travels along a flexible body, such as a wheel on a rail.

    Between two nodes the body is followed by cubics through their displacements and slopes, as
    the elements of a beam do: ``Q_p = Phi(s)^T A^T F`` at the path length s(t). The force has no
    mass, and acts only while s is on the path.

    Parameters
    ----------
    name : str
        Name, unique among the forces.
    body : FlexibleBody
        The body, whose part has rotations at its nodes.
    path : sequence of str
        Names of two nodes or more: the corners of the path. It goes straight from one to the
        next, through all nodes that lie between; s is counted from the first, m.
    vector : (3,) array_like
        Force F, N: in the world frame, or in the body frame if `follow`.
    position : Signal or float
        s(t), m.
    follow : bool
        Whether the force turns with the body.
    signal : Signal, optional
        Factor on the force as a function of time; None for 1.
    """

    kind: ClassVar[str] = "moving load"
    name: str
    body: FlexibleBody
    path: tuple[str, ...]
    vector: Array
    position: Signal
    follow: bool
    signal: Signal | None
    nodes: tuple[int, ...]

    def __init__(
        self,
        name: str,
        body: FlexibleBody,
        path: Sequence[str],
        vector: ArrayLike,
        position: Signal | float,
        *,
        follow: bool = False,
        signal: Signal | None = None,
    ) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        nodes: tuple[int, ...] = ()
        checked: Any = body
        if not isinstance(checked, FlexibleBody):
            problems.add(where, f"body is {checked!r}, must be a flexible body")
        elif body.reduced.rotations is None:
            problems.add(
                where,
                f"body {body.name!r} knows no rotations of its nodes, so that the way between them "
                "is unknown; use a part made of beams, or forces at its nodes",
            )
        else:
            nodes = nodes_on(problems, where, body, path)
        F = problems.array(where, "vector", vector, (3,))
        s = check_signal(problems, where, "position", position)
        factor = None if signal is None else check_factor(problems, where, "signal", signal)
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
        )

    @property
    def lengths(self) -> Array:
        """Path length at each node of the path (k,), m, from 0."""
        x = np.asarray(self.body.reduced.nodes)[list(self.nodes)]
        steps = np.linalg.norm(np.diff(x, axis=0), axis=1)
        return readonly(np.concatenate([[0.0], np.cumsum(steps)]))

    @property
    def pieces(self) -> Array:
        """Coefficients (k - 1, 1 + n, 3, 4) of (s - s_k)^0..3: position, then the modes."""
        reduced, nodes = self.body.reduced, list(self.nodes)
        assert reduced.rotations is not None
        x = np.asarray(reduced.nodes)[nodes]
        h = np.diff(self.lengths)[:, None, None]
        t = np.diff(x, axis=0) / h[:, 0]
        u, theta = reduced.modes[nodes], reduced.rotations[nodes]
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
        zero = np.zeros_like(t)
        position = np.stack([x[:-1], t, zero, zero], axis=-1)[:, None]
        return readonly(np.concatenate([position, np.stack(powers, -1).swapaxes(1, 2)], axis=1))


def nodes_on(problems: Problems, where: str, body: FlexibleBody, path: Any) -> tuple[int, ...]:
    """Return the nodes of a path from corner to corner, or note why there is none."""
    names: Any = () if isinstance(path, str) else tuple(path)
    if len(names) < 2:
        problems.add(where, f"path is {path!r}, must name two nodes or more, such as start and end")
        return ()
    corners = []
    for name in names:
        try:
            corners.append(body.reduced.node(name))
        except InputError as error:
            problems.add(where, f"path: {error.problems[0].message}")
    if len(corners) < len(names):
        return ()
    x = np.asarray(body.reduced.nodes)
    nodes = corners[:1]
    for i, j in zip(corners[:-1], corners[1:], strict=True):
        line = x[j] - x[i]
        length = float(np.linalg.norm(line))
        if length == 0.0:
            problems.add(where, f"path: two corners that follow one another are at {x[i].tolist()}")
            return ()
        way = (x - x[i]) @ line / length
        off = np.linalg.norm(x - x[i] - np.outer(way, line / length), axis=1)
        between = (off < NEAR * length) & (way > NEAR * length) & (way < (1 - NEAR) * length)
        nodes += [int(k) for k in np.flatnonzero(between)[np.argsort(way[between])]]
        nodes.append(j)
    return tuple(nodes)
