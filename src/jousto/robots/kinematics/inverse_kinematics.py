"""Inverse kinematics: coordinates within their limits for a pose of a frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array, read_only
from jousto.base.errors import Problems
from jousto.base.object_repr import described
from jousto.base.rotations import euler_parameters, parse_orientation, rotation_matrix
from jousto.mechanism.bodies.marker import Marker
from jousto.robots.kinematics.tree import Tree

SMALLEST, LARGEST = 1e-12, 1e8  # limits of the damping d, over the square of the largest column
SEED = 20  # seed of the random starts
UNWOUND = 1e-12  # error over the size of the machine, up to which revolutions are removed
STALLED = 1e-10  # relative gain of an iteration below which a start has failed
WEIGHTS = 10.0, 100.0, 1000.0  # weights of the loops for a target out of reach


@described
@dataclass(frozen=True, eq=False)
class IKResult:
    """Result of inverse kinematics.

    Parameters
    ----------
    q : (nq,) array
        Positions of the tree, within their limits.
    reached : bool
        Whether the frame is at the target within the tolerances, and all loops are closed.
    distance : float
        Distance from the target position, m; zero without one.
    angle : float
        Angle from the target axes, rad; zero without them.
    at_limit : tuple of str
        Coordinates at a limit.
    iterations : int
        Total number of iterations.
    starts : int
        Number of starting points.
    gap : float
        Largest gap of a loop joint, m (angles times the size of the machine).
    open : tuple of str
        Open joints and couplings, and their coordinates beyond limits.
    """

    q: Array
    reached: bool
    distance: float
    angle: float
    at_limit: tuple[str, ...]
    iterations: int
    starts: int
    gap: float = 0.0
    open: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return self.reached

    def __str__(self) -> str:
        word = "reached" if self.reached else "not reached"
        text = f"{word}: {self.distance:.3g} m and {self.angle:.3g} rad off"
        if not self.reached and self.at_limit:
            text += f", with {', '.join(self.at_limit)} at the limit"
        if self.open:
            text += f"; the loops cannot be closed, {', '.join(self.open)} by {self.gap:.3g} m"
        return f"{text} ({self.iterations} iterations from {self.starts} starts)"


@explained
def inverse_kinematics(
    tree: Tree,
    frame: str | Marker,
    position: ArrayLike | None = None,
    axes: Any = None,
    *,
    start: ArrayLike | None = None,
    tolerance: float = 1e-8,
    angle_tolerance: float = 1e-8,
    starts: int = 50,
    iterations: int = 200,
) -> IKResult:
    """Return coordinates with which a frame has a given position, given axes, or both.

    Damped least squares: ``dq = (J^T W J + d D)^-1 J^T W e`` with the diagonal D of the first
    matrix (Levenberg and Marquardt); d grows after a step that does not reduce the error e.
    Coordinates at a limit that would exceed it are fixed in that step. If a starting point leads to
    no solution, others within the limits follow, the same ones in every call.

    The error e includes the constraints of loop joints (``tree.constraints``) and the excess of
    their coordinates over limits. Loops are closed first at every starting point, to 1e-12 of the
    size of the machine. For a target out of reach the result is the nearest position with closed
    loops. Flexible bodies are undeformed.

    Parameters
    ----------
    tree : Tree
        Tree of the machine.
    frame : str or Marker
        Frame to be moved to the target, as for ``tree.jacobian``.
    position : (3,) array_like, optional
        Target of its origin in the world, m; None for any.
    axes : orientation, optional
        Target of its axes in the world: Euler parameters, a rotation matrix, `Rotate`; None for
        any.
    start : (nq,) array_like, optional
        First starting point; None: the initial pose of the machine. The first solution is
        returned, so that a start nearby keeps the branch.
    tolerance, angle_tolerance : float
        Largest distance, m, and angle, rad, from the target.
    starts : int
        Maximum number of starting points; narrow limits need more.
    iterations : int
        Maximum number of iterations per starting point.

    Returns
    -------
    IKResult
        Best result; ``reached`` is True if it is within the tolerances.

    Raises
    ------
    InputError
        If neither position nor axes are given, or a value is not a number.
    """
    where, problems = "inverse_kinematics", Problems()
    r = None if position is None else problems.array(where, "position", position, (3,))
    e = None if axes is None else parse_orientation(problems, where, "axes", axes)
    q = problems.array(where, "start", tree.initial if start is None else start, (tree.nq,))
    problems.positive(where, "tolerance", tolerance, "m")
    problems.positive(where, "angle_tolerance", angle_tolerance, "rad")
    for name, value in (("starts", starts), ("iterations", iterations)):
        if value != int(value) or value < 1:
            problems.add(where, f"{name} is {value!r}, must be a whole number above zero")
    if position is None and axes is None:
        problems.add(where, "give a position, axes, or both")
    problems.raise_if_any()
    assert q is not None
    target = _Target(tree, frame, r, None if e is None else rotation_matrix(e))
    search = _Search(target, (tolerance, angle_tolerance), iterations)
    rng = np.random.default_rng(SEED)
    best, tried = search.tried(target.inside(q)), 1
    while tried < starts and not search.there(best, ALL):
        found, tried = search.tried(target.drawn(q, rng)), tried + 1
        best = min(best, found, key=target.rank)
    if tree.cut and not search.there(best, ALL):
        best = min(best, search.nearest(best), key=target.rank)
    best = search.unwound(best, q)
    distance, angle = target.off(best)
    stuck = target.at_limit(best)
    names = [name for name, there in zip(tree.velocities, stuck, strict=True) if there]
    gaps = tree.loops.gaps(tree.view(best))
    return IKResult(
        read_only(best),
        search.there(best, ALL),
        distance,
        angle,
        (*names, *tree.loops.at_bounds(tree.view(best))),
        search.used,
        tried,
        max(gaps.values(), default=0.0),
        tuple(name for name, gap in gaps.items() if gap > tree.loops.tolerance),
    )


class _Aim(NamedTuple):
    """Terms of the error: whether the pose of the frame is included, and the weight of loops."""

    place: bool
    weight: float


ALL, LOOPS = _Aim(True, 1.0), _Aim(False, 1.0)


class _Target:
    """Target of a frame, with error and Jacobian at given positions."""

    def __init__(self, tree: Tree, frame: str | Marker, r: Array | None, A: Array | None) -> None:
        self.tree, self.frame, self.r, self.A = tree, frame, r, A
        poses = tree.forward_kinematics(tree.initial).values()
        here = tree.pose(frame, tree.initial).r
        # length that converts angles to m
        self.length = max([float(np.linalg.norm(here - x.r)) for x in poses], default=1.0) or 1.0
        self.units = np.where(tree.lengths, self.length, 1.0)
        self.index = {
            tree.velocities.index(name): tree.positions.index(name)
            for name in tree.velocities
            if name in tree.positions
        }

    def error(self, q: Array, aim: _Aim = ALL) -> Array:
        """Return the error e, m: position, rotation vector times length, and loops."""
        parts = [-aim.weight * self.tree.loops.missing(self.tree.view(q))[0]]
        if aim.place:
            here = self.tree.pose(self.frame, q)
            parts += [] if self.r is None else [self.r - here.r]
            if self.A is not None:
                parts.append(self.length * turn_vector(self.A @ here.A.T))
        return np.concatenate(parts)

    def rows(self, q: Array, aim: _Aim = ALL) -> Array:
        """Return the Jacobian of the error."""
        parts = [aim.weight * self.tree.loops.missing(self.tree.view(q))[1]]
        if aim.place:
            J = self.tree.jacobian(self.frame, q)
            parts += [] if self.r is None else [J[:3]]
            if self.A is not None:
                parts.append(self.length * J[3:])
        return np.concatenate(parts)

    def size(self, q: Array, aim: _Aim = ALL) -> float:
        """Return the norm of the error, m."""
        return float(np.linalg.norm(self.error(q, aim)))

    def gap(self, q: Array) -> float:
        """Return the largest gap of the loops, m."""
        found = self.tree.loops.missing(self.tree.view(q))[0]
        return float(np.abs(found).max(initial=0.0))

    def rank(self, q: Array) -> tuple[float, float]:
        """Return the sort key of positions: gap of the loops, then distance to the target."""
        gap = self.gap(q)
        return (gap if gap > self.tree.loops.tolerance else 0.0), self.size(q)

    def off(self, q: Array) -> tuple[float, float]:
        """Return the distance, m, and the angle, rad, from the target."""
        here = self.tree.pose(self.frame, q)
        distance = 0.0 if self.r is None else float(np.linalg.norm(self.r - here.r))
        turn = np.zeros(3) if self.A is None else turn_vector(self.A @ here.A.T)
        return distance, float(np.linalg.norm(turn))

    def inside(self, q: Array) -> Array:
        """Return positions clipped to their limits."""
        found = np.array(q)
        for i, place in self.index.items():
            found[place] = np.clip(found[place], self.tree.lower[i], self.tree.upper[i])
        return found

    def at_limit(self, q: Array, step: Array | None = None) -> Array:
        """Return a mask (nv,) of coordinates at a limit; with a step, only those exceeding it."""
        tree = self.tree
        found = np.zeros(tree.nv, dtype=bool)
        for i, place in self.index.items():
            low, high = q[place] <= tree.lower[i], q[place] >= tree.upper[i]
            if step is not None:
                low, high = low and step[i] < 0.0, high and step[i] > 0.0
            found[i] = low or high
        return found

    def drawn(self, q: Array, rng: np.random.Generator) -> Array:
        """Return random positions within the limits."""
        tree = self.tree
        spread = np.where(tree.lengths, self.length, np.pi)
        found = tree.moved(q, spread * rng.uniform(-1.0, 1.0, tree.nv))
        for i, place in self.index.items():
            low, high = tree.lower[i], tree.upper[i]
            if np.isfinite(low) and np.isfinite(high):
                found[place] = rng.uniform(low, high)
        return self.inside(found)


class _Search:
    """Damped least squares from several starting points."""

    def __init__(self, target: _Target, near: tuple[float, float], most: int) -> None:
        self.target, self.tree, self.near, self.most = target, target.tree, near, most
        self.used = 0

    def tried(self, q: Array) -> Array:
        """Return the result from a start: at the target, or near it with closed loops."""
        found = self.descend(self.descend(q, LOOPS), ALL)
        return found if self.there(found, ALL) else self.descend(found, LOOPS)

    def nearest(self, q: Array) -> Array:
        """Return the positions with closed loops nearest to a target out of reach."""
        for weight in WEIGHTS:
            q = self.descend(q, _Aim(True, weight))
        return self.descend(q, LOOPS)

    def unwound(self, q: Array, start: Array) -> Array:
        """Return positions with angles changed by whole turns to be near those of the start."""
        for i, place in self.target.index.items():
            turns = np.round((q[place] - start[place]) / (2.0 * np.pi))
            if self.tree.lengths[i] or not turns:
                continue
            new = np.array(q)
            new[place] -= 2.0 * np.pi * turns
            inside = self.tree.lower[i] <= new[place] <= self.tree.upper[i]
            as_near = self.target.size(new) <= self.target.size(q) + UNWOUND * self.target.length
            if inside and as_near and self.there(new, LOOPS) == self.there(q, LOOPS):
                q = new
        return q

    def there(self, q: Array, aim: _Aim) -> bool:
        """Return whether the error is within the tolerances."""
        if self.target.gap(q) > self.tree.loops.tolerance:
            return False
        distance, angle = self.target.off(q) if aim.place else (0.0, 0.0)
        return distance <= self.near[0] and angle <= self.near[1]

    def descend(self, q: Array, aim: _Aim) -> Array:
        """Return the last positions of damped least squares from a start."""
        target, damping, size = self.target, 1e-3, self.target.size(q, aim)
        for _ in range(self.most):
            if self.there(q, aim):
                return q
            self.used += 1
            e, J = target.error(q, aim), target.rows(q, aim)
            while True:
                new = target.inside(self.tree.moved(q, self.step(q, J, e, damping)))
                there = target.size(new, aim)
                if there < size or damping > LARGEST:
                    break
                damping *= 4.0
            if there >= size * (1.0 - STALLED):
                return new if there < size else q
            q, size, damping = new, there, max(0.2 * damping, SMALLEST)
        return q

    def step(self, q: Array, J: Array, e: Array, damping: float) -> Array:
        """Return a step (nv,) that exceeds no limit."""
        held = np.zeros(self.tree.nv, dtype=bool)
        step = np.zeros(self.tree.nv)
        for _ in range(self.tree.nv + 1):
            K = J[:, ~held]
            squares = (K * K).sum(axis=0)
            top = float(squares.max(initial=0.0))
            if top == 0.0:
                return np.zeros(self.tree.nv)
            # least squares instead of normal equations, which would lose digits of the loops
            D = np.diag(np.sqrt(damping * np.maximum(squares, 1e-6 * top)))
            rhs = np.concatenate([e, np.zeros(len(D))])
            step[:] = 0.0
            step[~held] = np.linalg.lstsq(np.vstack([K, D]), rhs, rcond=None)[0]
            more = self.target.at_limit(q, step) & ~held
            if not more.any():
                break
            held |= more
        # limit the step to 1 rad, the range of the linearisation
        return step / max(1.0, float(np.abs(step / self.target.units).max(initial=0.0)))


def turn_vector(R: Array) -> Array:
    """Return the rotation vector (3,), rad, of a rotation matrix, with an angle of at most pi.

    Examples
    --------
    >>> turn_vector(np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])).round(6)
    array([0.      , 0.      , 1.570796])
    """
    e = euler_parameters(R)
    sine = float(np.linalg.norm(e[1:]))
    if sine < 1e-12:
        return np.asarray(2.0 * e[1:])
    return np.asarray(2.0 * np.arctan2(sine, e[0]) / sine * e[1:])
