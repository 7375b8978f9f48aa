"""Scalar functions of two markers, for constraints and for forces along coordinates.

Every kind has the value, the derivatives by points and axes of both markers, and the second
derivative by time. Points and axes are linear in the body frames, so that all functions except
distances and angles are linear or quadratic.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from jousto.base.arrays import Array, Index
from jousto.mechanism.joints.coordinate import Angle, Coordinate, Displacement, Distance
from jousto.natural.equations.frames import Frames, Pose

PASCAL = ((1,), (1, 1), (1, 2, 1))


class Kind(Protocol):
    """Interface of a kind of scalar function; `ends` (k, 2) are the markers a, b of each."""

    ends: Index

    def value(self, a: Array, b: Array) -> Array:
        """Return the values (k,) from y (k, 4, 3) of both markers."""

    def gradient(self, a: Array, b: Array) -> Array:
        """Return the derivatives (k, 2, 4, 3) by y of both markers."""

    def second(self, a: tuple[Array, ...], b: tuple[Array, ...]) -> Array:
        """Return the second time derivative (k,) from y, y', y'' of both markers."""


class Products:
    """Scalar products ``P . Q`` of an axis of marker a with an axis of b or with ``r_b - r_a``.

    Parameters
    ----------
    ends : int array (k, 2)
        Markers a and b.
    axes : int array (k, 2)
        Rows of y: an axis 1..3 of a, and an axis of b or 0 for the vector from a to b.
    """

    def __init__(self, ends: Index, axes: Index) -> None:
        self.ends, self.axes = ends, axes
        self.each = np.arange(len(ends))
        self.line = (axes[:, 1] == 0)[:, None]

    def _factors(self, a: Array, b: Array) -> tuple[Array, Array]:
        P, Q = a[self.each, self.axes[:, 0]], b[self.each, self.axes[:, 1]]
        return P, np.where(self.line, Q - a[:, 0], Q)

    def value(self, a: Array, b: Array) -> Array:
        """Return ``P . Q`` (k,)."""
        P, Q = self._factors(a, b)
        return np.asarray(np.sum(P * Q, axis=1))

    def gradient(self, a: Array, b: Array) -> Array:
        """Return the gradient: Q on the axis of a, P on the axis or point of b, -P on a's point."""
        P, Q = self._factors(a, b)
        g = np.zeros((len(P), 2, 4, 3))
        g[self.each, 0, self.axes[:, 0]] = Q
        g[self.each, 1, self.axes[:, 1]] = P
        g[:, 0, 0] -= np.where(self.line, P, 0.0)
        return g

    def second(self, a: tuple[Array, ...], b: tuple[Array, ...]) -> Array:
        """Return ``P'' . Q + 2 P' . Q' + P . Q''``."""
        (P, Q), (dP, dQ), (ddP, ddQ) = (self._factors(*y) for y in zip(a, b, strict=True))
        return np.asarray(np.sum(ddP * Q + 2.0 * dP * dQ + P * ddQ, axis=1))


class Gaps:
    """World components of ``r_b - r_a``.

    Parameters
    ----------
    ends : int array (k, 2)
        Markers a and b.
    axes : int array (k,)
        World axis, 0..2.
    """

    def __init__(self, ends: Index, axes: Index) -> None:
        self.ends, self.axes = ends, axes
        self.each = np.arange(len(ends))

    def value(self, a: Array, b: Array) -> Array:
        """Return the component."""
        return np.asarray((b[:, 0] - a[:, 0])[self.each, self.axes])

    def gradient(self, a: Array, b: Array) -> Array:
        """Return the gradient: -1 for the point of a and 1 for that of b."""
        g = np.zeros((len(self.each), 2, 4, 3))
        g[self.each, 0, 0, self.axes] = -1.0
        g[self.each, 1, 0, self.axes] = 1.0
        return g

    def second(self, a: tuple[Array, ...], b: tuple[Array, ...]) -> Array:
        """Return the component of the accelerations."""
        return self.value(a[2], b[2])


class Distances:
    """Distances ``|r_b - r_a|``."""

    def __init__(self, ends: Index, axes: Index) -> None:
        self.ends = ends

    def value(self, a: Array, b: Array) -> Array:
        """Return the distance."""
        return np.asarray(np.linalg.norm(b[:, 0] - a[:, 0], axis=1))

    def gradient(self, a: Array, b: Array) -> Array:
        """Return the gradient: the direction from a to b."""
        d = b[:, 0] - a[:, 0]
        g = np.zeros((len(d), 2, 4, 3))
        g[:, 1, 0] = d / np.linalg.norm(d, axis=1)[:, None]
        g[:, 0, 0] = -g[:, 1, 0]
        return g

    def second(self, a: tuple[Array, ...], b: tuple[Array, ...]) -> Array:
        """Return ``(d' . d' + d . d'' - s'^2) / s``."""
        d, v, w = (y[:, 0] - x[:, 0] for x, y in zip(a, b, strict=True))
        s = np.linalg.norm(d, axis=1)
        rate = np.sum(d * v, axis=1) / s
        return np.asarray((np.sum(v * v + d * w, axis=1) - rate * rate) / s)


class Angles:
    """Angles ``atan2(g_a . f_b, f_a . f_b)`` of b about the third axis of a."""

    def __init__(self, ends: Index, axes: Index) -> None:
        self.ends = ends

    @staticmethod
    def _parts(a: Array, b: Array) -> tuple[Array, Array]:
        return np.sum(a[:, 2] * b[:, 1], axis=1), np.sum(a[:, 1] * b[:, 1], axis=1)

    def value(self, a: Array, b: Array) -> Array:
        """Return the angle in (-pi, pi]."""
        return np.asarray(np.arctan2(*self._parts(a, b)))

    def gradient(self, a: Array, b: Array) -> Array:
        """Return the gradient ``(c ds - s dc) / (s^2 + c^2)`` with s, c the arguments of atan2."""
        s, c = (x[:, None] for x in self._parts(a, b))
        square = s * s + c * c
        g = np.zeros((len(a), 2, 4, 3))
        g[:, 0, 2] = c / square * b[:, 1]
        g[:, 0, 1] = -s / square * b[:, 1]
        g[:, 1, 1] = (c * a[:, 2] - s * a[:, 1]) / square
        return g

    def second(self, a: tuple[Array, ...], b: tuple[Array, ...]) -> Array:
        """Return the second derivative of the angle."""

        def dots(row: int, order: int) -> Array:
            terms = zip(PASCAL[order], range(order + 1), strict=True)
            each = (n * np.sum(a[i][:, row] * b[order - i][:, 1], axis=1) for n, i in terms)
            return np.asarray(sum(each))

        (s, ds, dds), (c, dc, ddc) = ([dots(row, k) for k in range(3)] for row in (2, 1))
        square = s * s + c * c
        rate = (c * ds - s * dc) / square
        return np.asarray((c * dds - s * ddc - 2.0 * (c * dc + s * ds) * rate) / square)


KINDS: dict[str, Any] = {
    "gap": Gaps,
    "product": Products,
    "distance": Distances,
    "angle": Angles,
}


class Scalars:
    """Scalar functions of a machine, each stored once.

    Attributes
    ----------
    long : bool array (ns,)
        Whether a function is a length, m; others are cosines and angles.
    """

    def __init__(self, frames: Frames) -> None:
        self.frames = frames
        self._found: dict[str, list[tuple[int, int, Any]]] = {kind: [] for kind in KINDS}
        self._places: dict[tuple[Any, ...], tuple[str, int]] = {}

    def add(self, kind: str, a: int, b: int, axes: Any = 0) -> tuple[str, int]:
        """Return kind and index of a function of markers a and b, which is added if new."""
        key = (kind, a, b, axes)
        if key not in self._places:
            self._places[key] = kind, len(self._found[kind])
            self._found[kind].append((a, b, axes))
        return self._places[key]

    def coordinate(self, s: Coordinate) -> tuple[str, int]:
        """Return kind and index of a declared coordinate."""
        a, b = self.frames.place(s.a), self.frames.place(s.b)
        if isinstance(s, Displacement):
            return self.add("product", a, b, (1 + s.column, 0))
        return self.add({Distance: "distance", Angle: "angle"}[type(s)], a, b)

    def close(self) -> None:
        """Number all functions in the order of their kinds; none can be added afterwards."""
        self.kinds: list[tuple[Kind, slice]] = []
        self._first: dict[str, int] = {}
        count = 0
        for kind, found in self._found.items():
            self._first[kind] = count
            if found:
                a, b, axes = zip(*found, strict=True)
                ends = np.array([a, b], dtype=np.intp).T
                here = slice(count, count + len(found))
                self.kinds.append((KINDS[kind](ends, np.array(axes, dtype=np.intp)), here))
            count += len(found)
        self.count = count
        every = [kind.ends for kind, _ in self.kinds]
        self.ends: Index = np.concatenate([np.zeros((0, 2), dtype=np.intp), *every])
        angles = slice(self._first["angle"], count)
        self.turning = np.arange(count)[angles]
        self.long = np.array(
            [
                kind in ("gap", "distance") or (kind == "product" and axes[1] == 0)
                for kind, found in self._found.items()
                for _, _, axes in found
            ],
            dtype=bool,
        )

    def number(self, place: tuple[str, int]) -> int:
        """Return the index of a function among all functions."""
        return self._first[place[0]] + place[1]

    def values(self, y: Array, near: Array) -> Array:
        """Return all values (ns,); angles are nearest to the values `near`."""
        out = np.zeros(self.count)
        for kind, here in self.kinds:
            out[here] = kind.value(y[kind.ends[:, 0]], y[kind.ends[:, 1]])
        turns = self.turning
        out[turns] += 2 * np.pi * np.round((near[turns] - out[turns]) / (2 * np.pi))
        return out

    def gradients(self, y: Array) -> Array:
        """Return all derivatives (ns, 2, 4, 3) by y of markers a and b."""
        out = np.zeros((self.count, 2, 4, 3))
        for kind, here in self.kinds:
            out[here] = kind.gradient(y[kind.ends[:, 0]], y[kind.ends[:, 1]])
        return out

    def seconds(self, motion: tuple[Array, Array, Array]) -> Array:
        """Return all second time derivatives (ns,) for a motion of the markers."""
        out = np.zeros(self.count)
        for kind, here in self.kinds:
            a, b = (tuple(y[kind.ends[:, k]] for y in motion) for k in (0, 1))
            out[here] = kind.second(a, b)
        return out

    def blocks(self, pose: Pose, gradients: Array) -> Array:
        """Return the derivatives (ns, 2, 12 + n) by the coordinates of the bodies of a and b."""
        return pose.pulled(gradients, self.ends)
