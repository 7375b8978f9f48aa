"""Motion: poses, Jacobians and accelerations of the steps of a tree in the world frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from jousto.base.arrays import Array, skew
from jousto.base.errors import InputError, Problem
from jousto.base.rotations import rotation_matrix
from jousto.robots.description import Frame
from jousto.robots.kinematics.joint_chain import Step


class Motion(NamedTuple):
    """Axes A and origins r of steps in the world, their Jacobians Jr, Jw, and at v: w, ar, aw.

    w is the angular velocity; ar and aw are the linear and angular accelerations.
    """

    A: Array
    r: Array
    Jr: Array
    Jw: Array
    w: Array
    ar: Array
    aw: Array


def in_motion(
    steps: Sequence[Step],
    G: Array,
    q: Array,
    v: Array | None = None,
    a: Array | None = None,
    *,
    jacobians: bool = True,
) -> Motion:
    """Return the motion of steps in the world frame, with accelerations if v and a are given.

    Parameters
    ----------
    steps : sequence of Step
        Steps from the ground outward.
    G : (n, nv) array
        Matrix from the free velocities to all velocities; Jacobians are by the free ones.
    q, v, a : arrays
        All positions, velocities and accelerations, including the eliminated ones.
    """
    n, nv = len(steps), len(G)
    A, r = np.zeros((n, 3, 3)), np.zeros((n, 3))
    Jr, Jw = np.zeros((n, 3, nv)), np.zeros((n, 3, nv))
    w, ar, aw = (np.zeros((n, 3)) for _ in range(3))
    for i, step in enumerate(steps):
        p = step.parent
        base = Frame() if p < 0 else Frame(r[p], A[p])
        joint = base @ step.before
        moved, turn, slide = _motion(step.kind, step.sign, joint, q[step.q :])
        end = moved @ step.after
        A[i], r[i] = end.A, end.r
        size = turn.shape[1]
        out = end.r - moved.r  # vector from the moved point of the joint
        if jacobians:
            if p >= 0:
                Jw[i] = Jw[p]
                Jr[i] = Jr[p] - skew(end.r - r[p]) @ Jw[p]
            columns = slice(step.v, step.v + size)
            Jw[i][:, columns] += turn
            Jr[i][:, columns] += slide - skew(out) @ turn
        if v is None or a is None:
            continue
        wp = w[p] if p >= 0 else np.zeros(3)
        dv, da = v[step.v : step.v + size], a[step.v : step.v + size]
        wj, sv = turn @ dv, slide @ dv
        w[i] = wp + wj
        aw[i] = (aw[p] if p >= 0 else 0.0) + turn @ da + cross(wp, wj)
        arm = moved.r - (r[p] if p >= 0 else np.zeros(3))
        if step.kind != "free":
            lead = (ar[p], aw[p]) if p >= 0 else (np.zeros(3), np.zeros(3))
            ar[i] = lead[0] + cross(lead[1], arm) + cross(wp, cross(wp, arm))
            ar[i] += slide @ da + 2.0 * cross(wp, sv)
            ar[i] += cross(aw[i], out) + cross(w[i], cross(w[i], out))
        else:
            ar[i] = slide @ da
    if jacobians:
        Jr, Jw = Jr @ G, Jw @ G
    return Motion(A, r, Jr, Jw, w, ar, aw)


def _motion(kind: str, sign: int, joint: Frame, q: Array) -> tuple[Frame, Array, Array]:
    """Return a frame after its motion, and its Jacobians of rotation and translation (3, size)."""
    none = np.zeros((3, 1))
    z = joint.A[:, 2:]
    if kind == "turn":
        angle = sign * q[0]
        c, s = np.cos(angle), np.sin(angle)
        R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return Frame(joint.r, joint.A @ R), sign * z, none
    if kind == "slide":
        return Frame(joint.r + sign * q[0] * z[:, 0], joint.A), none, sign * z
    if kind == "ball":
        R = rotation_matrix(unit(q[:4]))
        zero = np.zeros((3, 3))
        if sign > 0:
            moved = Frame(joint.r, joint.A @ R)
            return moved, moved.A, zero
        # b is the parent of a, so the angular velocity of b relative to a has the opposite sign and
        # is resolved in axes of b
        return Frame(joint.r, joint.A @ R.T), -joint.A, zero
    if kind == "free":
        R = rotation_matrix(unit(q[3:7]))
        zero = np.zeros((3, 3))
        return Frame(q[:3].copy(), R), np.hstack([zero, R]), np.hstack([np.eye(3), zero])
    return joint, np.zeros((3, 0)), np.zeros((3, 0))


def cross(a: Array, b: Array) -> Array:
    """Return a x b of two vectors, in a tenth of the time of numpy.cross."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def unit(e: Array) -> Array:
    """Return normalised Euler parameters."""
    length = float(np.linalg.norm(e))
    if not length > 1e-6:
        message = "Euler parameters in q are zero; (1, 0, 0, 0) is no rotation"
        raise InputError(Problem("Tree", message))
    return np.asarray(e / length)
