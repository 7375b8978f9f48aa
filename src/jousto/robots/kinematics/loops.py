"""Loops: constraint equations of the joints outside a tree, with their Jacobians.

A joint is declared as rows (see `Joint`): coincident points, perpendicular axes and linear
relations of coordinates, which are evaluated here between two frames of a tree.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from jousto.base.arrays import Array, skew
from jousto.robots.kinematics.jacobians import Motion
from jousto.robots.kinematics.loop_joints import Bound, Closure, Measured, Place, Sum

CLOSED = 1e-12  # gap over the size of the machine, below which a loop is closed (round-off)
TURN = 2.0 * np.pi


class Spot(NamedTuple):
    """Frame in the world: origin, m, axes, and the Jacobians (3, nv) of both."""

    r: Array
    A: Array
    Jr: Array
    Jw: Array


class Row(NamedTuple):
    """Constraint row: residual, its Jacobian (nv,), and the factor from its unit to m."""

    value: float
    rates: Array
    scale: float


@dataclass(frozen=True, eq=False)
class View:
    """Tree at given positions.

    Parameters
    ----------
    motion : Motion
        Its steps in the world.
    at : tuple of int
        Index of the step of each body.
    q, G : arrays
        All positions, and the matrix from free to all velocities.
    scalar : dict of str to (int, int)
        Indices of the scalar coordinates in q and v.
    """

    motion: Motion
    at: tuple[int, ...]
    q: Array
    G: Array
    scalar: Mapping[str, tuple[int, int]]

    def spot(self, place: Place) -> Spot:
        """Return pose and Jacobians of a frame."""
        body, frame = place
        if body < 0:
            none = np.zeros((3, self.G.shape[1]))
            return Spot(frame.r, frame.A, none, none)
        x, i = self.motion, self.at[body]
        arm = x.A[i] @ frame.r
        return Spot(x.r[i] + arm, x.A[i] @ frame.A, x.Jr[i] - skew(arm) @ x.Jw[i], x.Jw[i])

    def measure(self, s: Measured) -> tuple[float, Array]:
        """Return a coordinate, m or rad, and its Jacobian (nv,); angles are from -pi to pi."""
        if s.a is None or s.b is None:
            place, rate = self.scalar[s.name]
            return float(self.q[place]), self.G[rate]
        a, b = self.spot(s.a), self.spot(s.b)
        d, Jd = b.r - a.r, b.Jr - a.Jr
        if s.kind == "distance":
            length = float(np.linalg.norm(d))
            return length, (d / max(length, 1e-300)) @ Jd
        if s.kind == "along":
            x = a.A[:, s.column]
            return float(x @ d), x @ Jd + np.cross(x, d) @ a.Jw
        turn, x = b.Jw - a.Jw, b.A[:, 0]
        cosine, sine = a.A[:, 0] @ x, a.A[:, 1] @ x
        rates = cosine * np.cross(x, a.A[:, 1]) - sine * np.cross(x, a.A[:, 0])
        # lower bound, since there is no angle if x of b is along the axis of a
        square = max(float(cosine * cosine + sine * sine), 1e-300)
        return float(np.arctan2(sine, cosine)), (rates / square) @ turn


class Loops:
    """Constraint equations of the loops of a tree.

    Parameters
    ----------
    closures : sequence of Closure
        Joints and couplings outside the tree.
    size : float
        Size of the machine, m.

    Attributes
    ----------
    bounds : list of Bound
        Limits of coordinates of these joints.
    tolerance : float
        Largest gap of a closed loop, m.
    """

    def __init__(self, closures: Sequence[Closure], size: float) -> None:
        self.closures, self.size = tuple(closures), size
        self.bounds: list[Bound] = []
        self.tolerance = CLOSED * size

    def __repr__(self) -> str:
        return f"<Loops: {', '.join(self.names) or 'none'}>"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the joints and couplings."""
        return tuple(closure.name for closure in self.closures)

    def rows(self, view: View) -> list[Row]:
        """Return the rows of all joints in their order."""
        return [row for closure in self.closures for row in self._of(view, closure)]

    def missing(self, view: View) -> tuple[Array, Array]:
        """Return residuals (m,) in m and their Jacobian (m, nv), with excesses over limits last."""
        rows = self.rows(view)
        rows += [row for bound in self.bounds for row in self._excess(view, bound)]
        values = np.array([row.scale * row.value for row in rows])
        rates = [row.scale * row.rates for row in rows]
        return values, np.array(rates).reshape(len(rows), view.G.shape[1])

    def gaps(self, view: View) -> dict[str, float]:
        """Return the gap of each joint and the excess over each limit, m, by name."""
        found = {c.name: self._most(self._of(view, c)) for c in self.closures}
        return found | {b.of.name: self._most(self._excess(view, b)) for b in self.bounds}

    def at_bounds(self, view: View) -> tuple[str, ...]:
        """Return the coordinates outside the tree that are at a limit."""
        found = []
        for bound in self.bounds:
            s = middle_turn(bound, view.measure(bound.of)[0])
            near = min(abs(s - bound.lower), abs(s - bound.upper))
            if near <= self.tolerance / self._scale(bound.of) or not bound.lower < s < bound.upper:
                found.append(bound.of.name)
        return tuple(found)

    def turned(self, view: View) -> dict[str, float]:
        """Return the angles between frames in linear relations, rad, revolutions included."""
        found = {}
        for line in (line for closure in self.closures for line in closure.lines):
            k, turns = self._turns(line, self._raw(view, line)[0])
            if k is not None:
                s = line.terms[k]
                found[s.name] = view.measure(s)[0] - TURN * turns
        return found

    def _most(self, rows: Sequence[Row]) -> float:
        return max((abs(row.scale * row.value) for row in rows), default=0.0)

    def _scale(self, s: Measured) -> float:
        return self.size if s.kind == "angle" else 1.0

    def _of(self, view: View, closure: Closure) -> list[Row]:
        found: list[Row] = []
        if closure.a is not None and closure.b is not None:
            a, b = view.spot(closure.a), view.spot(closure.b)
            if closure.coincident:
                d, Jd = b.r - a.r, b.Jr - a.Jr
                found += [Row(float(d[i]), Jd[i], 1.0) for i in range(3)]
            for i, j in closure.perpendicular:
                x, y = a.A[:, i], b.A[:, j]
                found.append(Row(float(x @ y), np.cross(x, y) @ (a.Jw - b.Jw), self.size))
        return found + [self._sum(view, line) for line in closure.lines]

    def _raw(self, view: View, line: Sum) -> tuple[float, Array]:
        value, rates = -line.offset, np.zeros(view.G.shape[1])
        for s, factor in zip(line.terms, line.factors, strict=True):
            x, J = view.measure(s)
            value, rates = value + factor * x, rates + factor * J
        return value, rates

    def _sum(self, view: View, line: Sum) -> Row:
        value, rates = self._raw(view, line)
        k, turns = self._turns(line, value)
        if k is not None:
            value -= line.factors[k] * TURN * turns
        # scale of the row: m per unit of its largest coordinate, angles times the size
        pairs = zip(line.terms, line.factors, strict=True)
        unit = max(abs(factor) / self._scale(s) for s, factor in pairs)
        return Row(value, rates, 1.0 / unit if unit > 0.0 else 1.0)

    def _turns(self, line: Sum, value: float) -> tuple[int | None, float]:
        """Return the index of the angle to be changed by whole turns, and their number."""
        angles = [
            k
            for k, s in enumerate(line.terms)
            if s.kind == "angle" and s.a is not None and line.factors[k] != 0.0
        ]
        if not angles:
            return None, 0.0
        k = min(angles, key=lambda k: abs(line.factors[k]))
        return k, float(np.round(value / (line.factors[k] * TURN)))

    def _excess(self, view: View, bound: Bound) -> list[Row]:
        s, J = view.measure(bound.of)
        s = middle_turn(bound, s)
        over = max(s - bound.upper, 0.0) + min(s - bound.lower, 0.0)
        return [Row(over, J, self._scale(bound.of))] if over != 0.0 else []


def middle_turn(bound: Bound, s: float) -> float:
    """Return a coordinate; whole turns bring an angle near the middle of its limits."""
    middle = 0.5 * (bound.lower + bound.upper)
    if bound.of.kind != "angle" or not np.isfinite(middle):
        return s
    return s - TURN * float(np.round((s - middle) / TURN))
