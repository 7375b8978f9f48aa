"""Redundant and contradictory constraint rows: detection and remedies."""

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
from jousto.model.scales import largest_speed, speed_scale, velocity_metres

RANK = 1e-9  # singular values of unit rows in the mass metric below this are zero
WEAK = 2e-7
"""Singular value of independent unit rows below which a solution of redundant rows is inaccurate.

It occurs if a moment of inertia is 1e-12 of the largest one of its body: the engine increases the
diagonal by ``e = 1e-8 sqrt(1e-12)`` of it, and its three steps leave an error ``(e / (e + s^2))^3``
of a multiplier, here 1 %."""
SHARE = 1e-6  # smallest relative weight of a row in a dependency
NEARBY = 1e-2  # distance of the neighbouring position, rad or relative to the size of the mechanism
STILL = 1e-6  # smallest motion, rad or relative to the size of the mechanism
# smallest gap of contradicting joints, relative to the size of the mechanism or to its speed
OPEN = 1e-8
LISTED = 24  # largest number of names in a message
TOGETHER = 100  # number of rows that are left out before the basis is computed again
DENSE = 400  # largest number of rows for one singular value decomposition


@dataclass(frozen=True)
class Redundancy:
    """Redundant constraint rows.

    Attributes
    ----------
    joints : tuple of str
        Joints, couplings and drives with rows in a dependency; their reactions are not unique.
    count : int
        Number of redundant rows.
    mobility : int
        Number of free motions, modal coordinates included.
    advice : tuple of str
        Replacements that make all rows independent without an additional free motion, if found;
        never of a joint whose coordinate is used.
    only_here : bool
        Whether the rows are independent at neighbouring positions: the initial position is
        singular.
    drives : tuple of str
        Drives among the joints.
    driven : int
        Number of rows of all drives, which prescribe motions left free by the joints.
    weak : str
        Message about a body whose inertias differ so much that its independent rows look redundant,
        with the remedy; empty if there is none.
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
        """Message: redundant rows, their effect and the remedy."""
        names = _some([f"'{name}'" for name in self.joints], ", ")
        if self.only_here:
            return (
                f"the initial position is singular: {self.count} of the constraint rows of "
                f"{names} are redundant there, and the motion may continue in more than one way; "
                f"start from another position or give initial velocities for one of these ways"
            )
        free = self.mobility + self.driven
        motion = "the motion is right, but" if free else "nothing can move, and"
        if self.drives:
            drives = ", ".join(f"'{name}'" for name in self.drives)
            motion = (
                f"a motion is driven twice ({drives})"
                if len(self.drives) > 1
                else f"the drive {drives} prescribes a motion that joints already prevent or "
                f"prescribe"
            )
            motion += ": the run stops if they disagree, and"
        text = (
            f"{self.count} of the constraint rows of {names} are redundant; {motion} the "
            f"reactions of these joints are not unique (computed: those of least norm)"
        )
        if self.weak:
            text += f"; {self.weak}"
        if self.advice:
            text += f"; to make them unique, {_some(self.advice, ' and ')}"
        return text


def _some(items: Sequence[str], between: str) -> str:
    """Return items joined as text; if there are many, only the first ones."""
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
    """Return Cq L^-T with M = L L^T and rows of length 1, so that S has a unit diagonal."""
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
    """Return the motions (f, nv) left free by unit rows, orthonormal."""
    _, s, Vt = np.linalg.svd(G)
    return np.asarray(Vt[int((s > RANK).sum()) :])


def dependent_rows(model: Model, engine: Engine) -> Array:
    """Return an orthonormal basis Y (rows, d) of dependencies at the engine's state, Y^T Cq = 0."""
    rows = model.permanent
    if rows <= DENSE:
        U, s, _ = np.linalg.svd(unit_rows(model, engine))
        return np.asarray(U[:, int((s > RANK).sum()) :])
    return dependencies(joint_fronts(model, engine, rows), len(model.bodies), RANK)


def repeated_rows(model: Model) -> Redundancy | None:
    """Return the redundant rows of a model at its initial pose, None if there are none."""
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
    """Return a message on inertias that make independent rows look redundant."""
    if model.permanent > DENSE:
        return ""
    s = np.linalg.svd(unit_rows(model, Engine(model, implicit=False)), compute_uv=False)
    if s[s > RANK].min(initial=1.0) > WEAK:
        return ""
    ratios = [_inertia_ratio(body) for body in model.bodies]
    least = int(np.argmin(ratios))
    return (
        f"their solution is inaccurate, because inertias differ too much: body "
        f"'{model.bodies[least].name}' has {ratios[least]:.1g} of its largest moment of inertia "
        "about its own axis; give slender bodies a millionth of it there, which changes the "
        "motion as little"
    )


def _inertia_ratio(body: BodyModel) -> float:
    c = body.S0 / body.mass[0]
    xx, yy, zz, yz, xz, xy = body.J0
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    moments = np.linalg.eigvalsh(J - body.mass[0] * (c @ c * np.eye(3) - np.outer(c, c)))
    return float(max(moments[0], 0.0) / max(moments[-1], np.finfo(float).tiny))


def _repeated_nearby(model: Model) -> int:
    """Return the number of redundant rows at a nearby position along a free motion."""
    engine = Engine(replace(model, redundant=True), implicit=False)
    metres = velocity_metres(model) / model.size
    engine.v[:] = np.random.default_rng(0).normal(size=model.nv) / metres
    engine.assemble()
    size = float(np.abs(engine.v * metres).max(initial=0.0))
    if size < STILL:
        return model.permanent  # there is no free motion
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
    """Search for rows that can be left out without adding a free motion.

    Without the rows R the rank is unchanged if the rows R of Y are independent; the remaining
    dependencies are the part of Y that vanishes on R.
    """

    def __init__(self, Y: Array) -> None:
        self._Y = Y
        self._gone = np.zeros((Y.shape[1], 0))  # orthonormal columns to be removed from Y
        self.left = Y.shape[1]

    def free(self, rows: Sequence[int]) -> bool:
        """Return whether rows can be left out."""
        if len(rows) > self.left:
            return False
        return bool(np.linalg.svd(self._rest(self._Y[list(rows)]), compute_uv=False).min() > SHARE)

    def leave_out(self, rows: Sequence[int]) -> None:
        """Leave rows out."""
        rest = self._rest(self._rest(self._Y[list(rows)]))  # twice, to remove round-off
        self._gone = np.hstack([self._gone, np.linalg.qr(rest.T)[0]])
        self.left -= len(rows)
        if self._gone.shape[1] > TOGETHER:
            self._Y = self._rest(self._Y)
            self._gone = self._gone[:, :0]

    def _rest(self, rows: Array) -> Array:
        return np.asarray(rows - (rows @ self._gone) @ self._gone.T)


def _advice(Y: Array, joints: Sequence[JointModel]) -> list[str]:
    """Return advice: drop wholly redundant joints, drives first; then free single rotations."""
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
    """Raise InputError for every joint left open or in conflict after assembly.

    Parameters
    ----------
    model, engine : Model, Engine
        Model and engine after assembly.
    found : Redundancy or None
        Redundant rows.
    """
    problems = Problems()
    c, cdot = (np.abs(x) for x in engine.constraints())
    # the declared speeds count: rows that contradict one another may leave none of them
    metres = engine.row_metres
    speed = max(speed_scale(model, engine.v, engine.a), largest_speed(model, model.v0))
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
                f"another or have the wrong orientation; change a length or an axis of the "
                f"loop, or start "
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
    """Return the joint with the largest gap, the joints in conflict with it, and the remedy.

    Parameters
    ----------
    model : Model
        Model; redundant rows are those at its initial pose.
    q : (nq,) array
        The position.
    time : float
        Time of the drives, s.
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
