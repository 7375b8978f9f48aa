"""Dependencies between constraint rows by elimination of bodies, for large mechanisms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.rotations import rotation_matrix
from jousto.model.elimination_order import eliminate
from jousto.model.model import JointModel, Model
from jousto.model.native.native import Engine


@dataclass(frozen=True)
class Front:
    """Constraint rows that are not yet eliminated.

    Attributes
    ----------
    bodies : tuple of int
        Bodies on which the rows depend.
    rows : tuple of arrays
        Rows of each body (r, 6 + n).
    count : int
        Number of rows.
    """

    bodies: tuple[int, ...]
    rows: tuple[Array, ...]
    count: int


@dataclass(frozen=True)
class Turn:
    """Orthogonal elimination of one body from the stacked rows that depend on it.

    Attributes
    ----------
    fronts : dict of int to int
        Indices of the fronts and their numbers of rows.
    vanishing : array (d, r)
        Combinations of the rows that vanish.
    kept : array (k, r)
        Combinations of the rows that form a new front.
    new : int
        Index of the new front.
    """

    fronts: dict[int, int]
    vanishing: Array
    kept: Array
    new: int


def bodies_of(model: Model, joint: JointModel) -> tuple[int, ...]:
    """Return the moving bodies that a joint connects."""
    found = {model.markers[side].body for side in joint.sides}
    return tuple(sorted(body for body in found if body >= 0))


def joint_fronts(model: Model, engine: Engine, rows: int) -> list[Front]:
    """Return the first `rows` rows of C' v, in the mass metric and of unit length, by joints.

    Bodies without a common joint are moved at once, so that the effort is linear in the size of the
    mechanism.
    """
    joints = [joint for joint in model.joints if joint.row < rows]
    held = [bodies_of(model, joint) for joint in joints]
    near: list[set[int]] = [set() for _ in model.bodies]
    for clique in held:
        for body in clique:
            near[body].update(clique)
    colour: list[int] = []
    for body, others in enumerate(near):
        taken = {colour[other] for other in others if other < body}
        colour.append(next(c for c in range(len(taken) + 1) if c not in taken))
    blocks = [
        {body: np.zeros((joint.rows, 6 + model.bodies[body].n)) for body in clique}
        for joint, clique in zip(joints, held, strict=True)
    ]
    kept = engine.v.copy()
    engine.v[:] = 0.0
    rest = engine.constraints()[1]
    for c in range(max(colour, default=-1) + 1):
        members = [i for i, own in enumerate(colour) if own == c]
        for j in range(max(6 + model.bodies[i].n for i in members)):
            for i in members:
                if j < 6 + model.bodies[i].n:
                    engine.v[model.bodies[i].iv + j] = 1.0
            rate = engine.constraints()[1] - rest
            engine.v[:] = 0.0
            for joint, found in zip(joints, blocks, strict=True):
                for body, block in found.items():
                    if colour[body] == c and j < block.shape[1]:
                        block[:, j] = rate[joint.row : joint.row + joint.rows]
    engine.v[:] = kept
    factors = [np.linalg.cholesky(engine.mass_matrix(i)) for i in range(len(model.bodies))]
    fronts: list[Front] = []
    for joint, found in zip(joints, blocks, strict=True):
        square = np.zeros(joint.rows)
        for body, block in found.items():
            iq = model.bodies[body].iq
            A = rotation_matrix(engine.q[iq + 3 : iq + 7])
            block[:, :3] = block[:, :3] @ A  # the mass matrix is resolved in the body frame
            block[:] = np.linalg.solve(factors[body], block.T).T
            square += np.sum(block**2, axis=1)
        length = np.sqrt(np.where(square > 0.0, square, 1.0))[:, None]
        blocks_of = tuple(block / length for block in found.values())
        fronts.append(Front(tuple(found), blocks_of, joint.rows))
    return fronts


def dependencies(fronts: Sequence[Front], bodies: int, tolerance: float) -> Array:
    """Return an orthonormal basis Y (rows, d) of vanishing combinations of rows, Y^T G = 0.

    Bodies are eliminated one after the other: the rows that depend on a body are transformed
    orthogonally until as few as possible depend on it; these are passed to its neighbours. Rows
    that depend on no body any more are redundant.

    Parameters
    ----------
    fronts : sequence of Front
        All rows, from `joint_fronts`.
    bodies : int
        Number of moving bodies.
    tolerance : float
        Largest singular value of unit rows that counts as zero.
    """
    order = eliminate([6] * bodies, [front.bodies for front in fronts]).order
    at: list[set[int]] = [set() for _ in range(bodies)]
    alive = dict(enumerate(fronts))
    turns: list[Turn] = []
    for k, front in alive.items():
        for body in front.bodies:
            at[body].add(k)
        if not front.bodies:  # both sides on ground
            every = np.eye(front.count)
            turns.append(Turn({k: front.count}, every, every[:0], -1))
    new = len(fronts)
    for body in order:
        touching = sorted(at[body])
        if not touching:
            continue
        seen = {k: alive[k].count for k in touching}
        merged = _merge([alive.pop(k) for k in touching], body)
        U, s, _ = np.linalg.svd(merged.rows[0])
        rest = U[:, int((s > tolerance).sum()) :].T
        widths = np.cumsum([block.shape[1] for block in merged.rows[1:]])
        left = rest @ np.hstack(merged.rows[1:]) if len(widths) else np.zeros((len(rest), 0))
        # rows that depend on no other body are redundant; fewer rows remain
        U, s, _ = np.linalg.svd(left) if left.size else (np.eye(len(left)), np.zeros(0), None)
        rank = int((s > tolerance).sum())
        go = U[:, :rank].T
        turns.append(Turn(seen, U[:, rank:].T @ rest, go @ rest, new))
        others = merged.bodies[1:]
        for other in others:
            at[other].difference_update(touching)
        if rank:
            alive[new] = Front(others, tuple(np.hsplit(go @ left, widths[:-1])), rank)
            for other in others:
                at[other].add(new)
            new += 1
    return _combined(turns, [front.count for front in fronts])


def _combined(turns: Sequence[Turn], counts: Sequence[int]) -> Array:
    """Return vanishing combinations of the original rows, from the last elimination back."""
    start = np.cumsum([0, *counts])
    column = sum(len(turn.vanishing) for turn in turns)
    Y = np.zeros((start[-1], column))
    shares: dict[int, tuple[NDArray[np.intp], Array]] = {}
    for turn in reversed(turns):
        own = len(turn.vanishing)
        column -= own
        none = np.zeros(0, np.intp), np.zeros((len(turn.kept), 0))
        later, share = shares.pop(turn.new, none)
        columns = np.concatenate([np.arange(column, column + own), later])
        share = np.hstack([turn.vanishing.T, turn.kept.T @ share])
        r = 0
        for k, count in turn.fronts.items() if len(columns) else ():
            part = share[r : r + count]
            if k < len(counts):
                Y[start[k] : start[k + 1], columns] = part
            else:
                shares[k] = columns, part
            r += count
    return Y


def _merge(fronts: Sequence[Front], body: int) -> Front:
    """Return all rows stacked, with the columns of `body` first."""
    bodies = (body, *sorted({b for front in fronts for b in front.bodies if b != body}))
    width = {
        b: block.shape[1]
        for front in fronts
        for b, block in zip(front.bodies, front.rows, strict=True)
    }
    total = sum(front.count for front in fronts)
    rows = {b: np.zeros((total, width[b])) for b in bodies}
    r = 0
    for front in fronts:
        for b, block in zip(front.bodies, front.rows, strict=True):
            rows[b][r : r + front.count] = block
        r += front.count
    return Front(bodies, tuple(rows.values()), total)
