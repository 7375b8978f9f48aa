"""Constraint rows that repeat or contradict one another: which, and what to change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.base.rotations import rotation_matrix
from jousto.model.model import BodyModel, JointModel, Model
from jousto.model.native.native import Engine, displaced
from jousto.model.rank.dependency import dependencies, joint_fronts
from jousto.model.scales import speed_scale, velocity_metres

RANK = 1e-9  # singular values of unit rows in the mass metric below this are zero
WEAK = 2e-7
"""The same, of rows that are independent, below which solving with repeated rows loses digits.

That is where a moment of inertia is 1e-12 of the largest of its body: the engine raises a diagonal
by ``e = 1e-8 sqrt(1e-12)`` of it, and its three steps leave ``(e / (e + s^2))^3`` of a multiplier,
here 1 %."""
SHARE = 1e-6  # share of a row in a dependency that counts
NEARBY = 1e-2  # of the size of the mechanism, or rad: how far the neighbouring position is
STILL = 1e-6  # of the size of the mechanism, or rad: what is left of a motion that nothing allows
OPEN = 1e-8  # of the size of the mechanism, or of its speed: joints that contradict one another
LISTED = 24  # names in a sentence
TOGETHER = 100  # rows left out before the whole basis is renewed
DENSE = 400  # rows up to which one singular value decomposition is quick


@dataclass(frozen=True)
class Redundancy:
    """Rows that repeat one another.

    Attributes
    ----------
    joints : tuple of str
        Joints, couplings and drives whose rows take part in a dependency; their reactions are
        not unique.
    count : int
        Rows too many.
    mobility : int
        Motions that the joints leave free, modal coordinates included.
    advice : tuple of str
        Replacements that make all rows independent without freeing a motion, if some were found;
        none of a joint whose coordinate is used.
    only_here : bool
        The rows differ in neighbouring positions: the initial one is singular.
    drives : tuple of str
        Drives among the joints.
    driven : int
        Rows of all drives: motions that they take from those that the joints leave free.
    weak : str
        The body whose inertias differ so much that the other rows hardly differ from repeated ones,
        with the remedy; empty if none does.
    """

    joints: tuple[str, ...]
    count: int
    mobility: int
    advice: tuple[str, ...]
    only_here: bool = False
    drives: tuple[str, ...] = ()
    driven: int = 0
    weak: str = ""

    @property
    def sentence(self) -> str:
        """What repeats, what it means and what to do."""
        names = _some([f"'{name}'" for name in self.joints], ", ")
        if self.only_here:
            return (
                f"the initial position is singular: {self.count} of the constraint rows of {names} "
                "repeat the others there, and the motion may continue in more than one way; start "
                "from another position or give initial velocities that choose one"
            )
        free = self.mobility + self.driven
        motion = "the motion is right, but" if free else "nothing can move, and"
        if self.drives:
            drives = ", ".join(f"'{name}'" for name in self.drives)
            motion = (
                f"a motion is driven twice ({drives})"
                if len(self.drives) > 1
                else f"the drive {drives} moves what joints hold or move already"
            )
            motion += ": the run stops where they disagree, and"
        text = (
            f"{self.count} of the constraint rows of {names} repeat the others; {motion} the "
            "reactions of these joints are not unique (given: those of least norm)"
        )
        if self.weak:
            text += f"; {self.weak}"
        if self.advice:
            text += f"; to make them unique, {_some(self.advice, ' and ')}"
        return text


def _some(items: Sequence[str], between: str) -> str:
    """Return the items, of very many only the first."""
    more = len(items) - LISTED
    if more <= 1:
        return between.join(items)
    return between.join([*items[:LISTED], f"{more} more"])


def constraint_matrix(model: Model, engine: Engine) -> Array:
    """Return Cq (rows, nv) at the engine's state, for [R' (world), w_local, p'] of every body.

    Rows of friction that may stick are left out.
    """
    kept = engine.v.copy()
    rows = model.permanent
    engine.v[:] = 0.0
    rest = engine.constraints()[1][:rows]
    Cq = np.zeros((rows, model.nv), rest.dtype)
    for j in range(model.nv):
        engine.v[j] = 1.0
        Cq[:, j] = engine.constraints()[1][:rows] - rest
        engine.v[j] = 0.0
    engine.v[:] = kept
    return Cq


def unit_rows(model: Model, engine: Engine) -> Array:
    """Return Cq L^-T with M = L L^T, rows scaled to length 1: S = Cq M^-1 Cq^T in unit diagonal."""
    G = constraint_matrix(model, engine)
    for i, body in enumerate(model.bodies):
        columns = slice(body.iv, body.iv + 6 + body.n)
        A = rotation_matrix(engine.q[body.iq + 3 : body.iq + 7])
        block = G[:, columns].copy()
        block[:, :3] = block[:, :3] @ A  # the mass matrix is resolved in the body frame
        L = np.linalg.cholesky(engine.mass_matrix(i))
        G[:, columns] = np.linalg.solve(L, block.T).T
    length = np.linalg.norm(G, axis=1)
    return np.asarray(G / np.where(length > 0.0, length, 1.0)[:, None])


def null_space(G: Array) -> Array:
    """Return the motions (f, nv) that unit rows leave free, orthonormal."""
    _, s, Vt = np.linalg.svd(G)
    return np.asarray(Vt[int((s > RANK).sum()) :])


def dependent_rows(model: Model, engine: Engine) -> Array:
    """Return an orthonormal basis Y (rows, d) of what repeats at the engine's state, Y^T Cq = 0."""
    rows = model.permanent
    if rows <= DENSE:
        U, s, _ = np.linalg.svd(unit_rows(model, engine))
        return np.asarray(U[:, int((s > RANK).sum()) :])
    return dependencies(joint_fronts(model, engine, rows), len(model.bodies), RANK)


def repeated_rows(model: Model) -> Redundancy | None:
    """Return the rows of a model that repeat one another at its initial pose, None if none do."""
    Y = dependent_rows(model, Engine(model, implicit=False))
    rows, count = Y.shape
    if not count:
        return None
    share = np.linalg.norm(Y, axis=1)
    taking = [j for j in model.joints if share[j.row : j.row + j.rows].max(initial=0.0) > SHARE]
    return Redundancy(
        joints=tuple(joint.name for joint in taking),
        count=count,
        mobility=model.nv - (rows - count),
        advice=tuple(_advice(Y, taking)),
        drives=tuple(joint.name for joint in taking if is_drive(joint)),
        driven=sum(joint.rows for joint in model.joints if is_drive(joint)),
        only_here=_repeated_nearby(model) < count,
        weak=_weak(model),
    )


def _weak(model: Model) -> str:
    """Return which inertias make independent rows look like repeated ones, and what to do."""
    if model.permanent > DENSE:
        return ""
    s = np.linalg.svd(unit_rows(model, Engine(model, implicit=False)), compute_uv=False)
    if s[s > RANK].min(initial=1.0) > WEAK:
        return ""
    ratios = [_inertia_ratio(body) for body in model.bodies]
    least = int(np.argmin(ratios))
    return (
        f"their solution loses digits, because inertias differ too much: body "
        f"'{model.bodies[least].name}' has {ratios[least]:.1g} of its largest moment of inertia "
        "about its own axis; give slender bodies a millionth of it there, which changes the motion "
        "by as little"
    )


def _inertia_ratio(body: BodyModel) -> float:
    c = body.S0 / body.mass[0]
    xx, yy, zz, yz, xz, xy = body.J0
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    moments = np.linalg.eigvalsh(J - body.mass[0] * (c @ c * np.eye(3) - np.outer(c, c)))
    return float(max(moments[0], 0.0) / max(moments[-1], np.finfo(float).tiny))


def _repeated_nearby(model: Model) -> int:
    """Return how many rows repeat others a small way along a motion that the joints allow."""
    engine = Engine(replace(model, redundant=True), implicit=False)
    metres = velocity_metres(model) / model.size
    engine.v[:] = np.random.default_rng(0).normal(size=model.nv) / metres
    engine.assemble()
    size = float(np.abs(engine.v * metres).max(initial=0.0))
    if size < STILL:
        return model.permanent  # nothing can move
    engine.q[:] = displaced(model, engine.q, engine.v * (NEARBY / size))
    engine.v[:] = model.v0
    engine.assemble()
    return int(dependent_rows(model, engine).shape[1])


def is_drive(joint: JointModel) -> bool:
    """Return whether a row of the joint follows a signal."""
    return any(line.signal >= 0 for line in joint.lines)


def place(joint: JointModel) -> str:
    """Return the place of a joint, coupling or drive for messages, ``joint 'pivot'``."""
    if is_drive(joint):
        return f"drive '{joint.name}'"
    own = not joint.coincident and not joint.perpendicular
    coupled = own and any(len(line.coordinates) > 1 for line in joint.lines)
    return f"{'coupling' if coupled else 'joint'} '{joint.name}'"


class _Spare:
    """Rows that can be left out while the others still hold every motion that all of them hold.

    Leaving out rows R keeps the rank if the rows R of Y are independent; what repeats then is the
    part of Y that vanishes on R.
    """

    def __init__(self, Y: Array) -> None:
        self._Y = Y
        self._gone = np.zeros((Y.shape[1], 0))  # orthonormal columns that Y has still to lose
        self.left = Y.shape[1]

    def free(self, rows: Sequence[int]) -> bool:
        """Whether these rows can be left out."""
        if len(rows) > self.left:
            return False
        return bool(np.linalg.svd(self._rest(self._Y[list(rows)]), compute_uv=False).min() > SHARE)

    def leave_out(self, rows: Sequence[int]) -> None:
        """Leave them out."""
        rest = self._rest(self._rest(self._Y[list(rows)]))  # twice for round-off
        self._gone = np.hstack([self._gone, np.linalg.qr(rest.T)[0]])
        self.left -= len(rows)
        if self._gone.shape[1] > TOGETHER:
            self._Y = self._rest(self._Y)
            self._gone = self._gone[:, :0]

    def _rest(self, rows: Array) -> Array:
        return np.asarray(rows - (rows @ self._gone) @ self._gone.T)


def _advice(Y: Array, joints: Sequence[JointModel]) -> list[str]:
    """Leave out what is repeated as a whole, drives first; then free rotations of point joints."""
    spare = _Spare(Y)
    advice: list[str] = []
    gone: set[str] = set()
    last_first = list(reversed(joints))
    for joint in sorted(last_first, key=lambda joint: not is_drive(joint)):
        rows = range(joint.row, joint.row + joint.rows)
        if not joint.used and spare.free(rows):
            spare.leave_out(rows)
            gone.add(joint.name)
            advice.append(f"leave out the {place(joint)}")
    for joint in joints:
        count = len(joint.perpendicular)
        kept = joint.used or joint.name in gone
        if kept or not joint.coincident or count not in (2, 3):
            continue
        first = joint.row + 3
        for freed in sorted(range(1, count + 1), reverse=True):
            choices = combinations(range(first, first + count), freed)
            if (trial := next((rows for rows in choices if spare.free(rows)), None)) is not None:
                spare.leave_out(trial)
                old = "revolute" if count == 2 else "fixed"
                new = {0: "spherical", 1: "universal", 2: "revolute"}[count - freed]
                advice.append(f"replace the {old} joint '{joint.name}' by a {new} one")
                break
    return advice if spare.left == 0 else []


def check_closed(model: Model, engine: Engine, found: Redundancy | None) -> None:
    """Raise InputError with every joint that assembly left open or in conflict.

    Parameters
    ----------
    model, engine : Model, Engine
        After assembly.
    found : Redundancy or None
        The rows that repeat one another.
    """
    problems = Problems()
    c, cdot = (np.abs(x) for x in engine.constraints())
    metres, speed = engine.row_metres, speed_scale(model, engine.v, engine.a)
    closed, kept = c * metres <= OPEN * model.size, cdot * metres <= OPEN * speed
    if np.all(closed & kept):
        return
    for joint in model.joints:
        rows = slice(joint.row, joint.row + joint.rows)
        if np.all(closed[rows] & kept[rows]):
            continue
        gap, rate = c[rows].max(), cdot[rows].max()
        names = [f"'{name}'" for name in (found.joints if found else ()) if name != joint.name]
        others = ", ".join(names) or "the others"
        where = place(joint)
        if not np.all(closed[rows]):
            problems.add(
                where,
                f"cannot be closed, {gap:.3g} (m or rad) remain; it conflicts with {others}: "
                "change a length or an axis of the loop, free a motion of one of them, or start "
                "nearer to the closed position"
                if names
                else f"cannot be closed, {gap:.3g} (m or rad) remain: the bodies do not reach one "
                "another or stand the wrong way; change a length or an axis of the loop, or start "
                "nearer to the closed position",
            )
        else:
            problems.add(
                where,
                f"contradicts {others}: a rate of {rate:.3g} (m/s or rad/s) remains; drive each "
                "motion once, and leave a free motion for every drive",
            )
    problems.raise_if_any()


def disagreement(model: Model, q: Array, time: float) -> str:
    """Return which joint is most open at a position, what it conflicts with and the remedy.

    Parameters
    ----------
    model : Model
        The model; repeated rows are looked for at its initial pose.
    q : (nq,) array
        The position.
    time : float
        The time, s, for drives.
    """
    engine = Engine(model, implicit=False)
    engine.q[:], engine.time[0] = q, time
    c = np.abs(engine.constraints()[0])
    rows = [slice(j.row, j.row + j.rows) for j in model.joints]
    gaps = c * engine.row_metres
    far = [gaps[r].max(initial=0.0) for r in rows]
    worst = model.joints[int(np.argmax(far))]
    gap = c[rows[int(np.argmax(far))]].max(initial=0.0)
    text = f"{place(worst)} is open by {gap:.3g} (m or rad)"
    found = repeated_rows(model) if model.redundant else None
    others = [f"'{n}'" for n in (found.joints if found else ()) if n != worst.name]
    if others and found and worst.name in found.joints:
        text += f": it contradicts {', '.join(others)}; "
        if found.weak:
            text += found.weak
        elif found.drives:
            text += "drive each motion once, and leave a free motion for every drive"
        else:
            text += "change a length or an axis of the loop, or free a motion of one of them"
    return text
