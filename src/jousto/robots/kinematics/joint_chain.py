"""Chains of elementary motions: rotation about z, translation along z, ball, free body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.rotations import euler_parameters
from jousto.robots.description import Frame
from jousto.robots.kinematics.topology import Parts, Tie


@dataclass(frozen=True, eq=False)
class Step:
    """Elementary motion relative to a parent step.

    Parameters
    ----------
    parent : int
        Index of the parent step; -1 for the ground.
    before, after : Frame
        Frame of the motion in the parent, and frame of this step in the moved frame.
    kind : {"fixed", "turn", "slide", "ball", "free"}
        Kind of motion, about or along z.
    sign : int
        1, or -1 if the coordinate is the motion of the parent relative to this step.
    q, v : int
        First index in the positions and in the velocities of the tree.
    body : int
        Index of the body of this step; -1 for none.
    """

    parent: int
    before: Frame
    kind: str
    after: Frame
    sign: int
    q: int
    v: int
    body: int


def build_steps(parts: Parts) -> tuple[tuple[Step, ...], tuple[int, ...], Names]:
    """Return elementary motions from the ground outward, that of each body, and the coordinates."""
    joined: dict[int, list[int]] = {}
    for k, joint in enumerate(parts.joints):
        for end in {joint.a, joint.b}:
            joined.setdefault(end, []).append(k)
    free = free_bodies(parts, joined)
    names = Names(parts, free)
    steps: list[Step] = []
    at: dict[int, int] = {-1: -1}
    used: set[int] = set()
    waiting = [(-1, k) for k in reversed(joined.get(-1, []))]
    # a component without a joint to the ground begins with its first body as a free body
    starts = list(free)
    while waiting or starts:
        if not waiting:
            body = starts.pop(0)
            q, v = names.places[f"free {body}"]
            steps.append(Step(-1, Frame(), "free", Frame(), 1, q, v, body))
            at[body] = len(steps) - 1
            waiting = [(body, k) for k in reversed(joined.get(body, []))]
            continue
        near, k = waiting.pop()
        if k in used:
            continue
        used.add(k)
        joint = parts.joints[k]
        far = joint.b if near == joint.a else joint.a
        steps += joint_steps(joint, at[near], names, len(steps), far, forward=near == joint.a)
        at[far] = len(steps) - 1
        waiting += [(far, i) for i in reversed(joined.get(far, [])) if i not in used]
    return tuple(steps), tuple(at[i] for i in range(len(parts.bodies))), names


def free_bodies(parts: Parts, joined: dict[int, list[int]]) -> list[int]:
    """Return the first body of each component of the machine without a joint to the ground."""
    found, seen = [], set()
    for start in (-1, *range(len(parts.bodies))):
        if start in seen:
            continue
        if start >= 0:
            found.append(start)
        waiting = [start]
        while waiting:
            body = waiting.pop()
            if body in seen:
                continue
            seen.add(body)
            for k in joined.get(body, []):
                waiting += [parts.joints[k].a, parts.joints[k].b]
    return found


def joint_steps(
    joint: Tie, parent: int, names: Names, first: int, far: int, *, forward: bool
) -> list[Step]:
    """Return the steps of one joint, from its proximal to its distal body."""
    moves = list(zip(joint.moves, joint.names, strict=True))
    near_frame, far_frame = joint.frame_a, joint.frame_b
    sign = 1
    if not forward:
        near_frame, far_frame, sign = far_frame, near_frame, -1
        moves = [((c.T, kind, a.T), name) for (a, kind, c), name in reversed(moves)]
    if not moves:
        return [Step(parent, near_frame, "fixed", far_frame.inverted(), 1, 0, 0, far)]
    steps = []
    for i, ((ahead, kind, behind), name) in enumerate(moves):
        before, after = Frame(A=ahead), Frame(A=behind)
        before = near_frame @ before if i == 0 else before
        last = i == len(moves) - 1
        after = after @ far_frame.inverted() if last else after
        q, v = names.places[name]
        steps.append(Step(parent, before, kind, after, sign, q, v, far if last else -1))
        parent = first + i
    return steps


class Names:
    """Names and indices of the coordinates: free bodies, then joints in their order.

    Attributes
    ----------
    places : dict of str to (int, int)
        First index of each coordinate in positions and velocities.
    positions, velocities : list of str
        Name of each component.
    scalar : dict of str to (int, int)
        Indices of the scalar coordinates.
    """

    def __init__(self, parts: Parts, free: list[int]) -> None:
        self.places: dict[str, tuple[int, int]] = {}
        self.positions: list[str] = []
        self.velocities: list[str] = []
        self.scalar: dict[str, tuple[int, int]] = {}
        self.initial: list[float] = []
        for body in free:
            name, pose = parts.bodies[body].name, parts.bodies[body].pose
            self.add(f"free {body}", name, "free")
            self.initial += [*pose.r, *quaternion(pose.A)]
        for joint in parts.joints:
            ball = any(kind == "ball" for _, kind, _ in joint.moves)
            for name in joint.names:
                self.add(name, name, "ball" if ball else "turn")
            self.initial += quaternion(relative_axes(parts, joint)) if ball else joint.initial

    def add(self, key: str, name: str, kind: str) -> None:
        """Add a coordinate."""
        if key in self.places:
            raise InputError(Problem(name, "two coordinates have this name; rename a joint"))
        self.places[key] = (len(self.positions), len(self.velocities))
        if kind in ("free", "ball"):
            if kind == "free":
                self.positions += [f"{name}.{x}" for x in "xyz"]
                self.velocities += [f"{name}.v{x}" for x in "xyz"]
            self.positions += [f"{name}.e{i}" for i in range(4)]
            self.velocities += [f"{name}.w{x}" for x in "xyz"]
        else:
            self.scalar[name] = self.places[key]
            self.positions.append(name)
            self.velocities.append(name)


def quaternion(A: Array) -> list[float]:
    """Return the Euler parameters of a rotation matrix."""
    return [float(x) for x in euler_parameters(A)]


def relative_axes(parts: Parts, joint: Tie) -> Array:
    """Return the axes of frame b in frame a (3, 3) at the initial pose."""
    a, b = (
        (Frame() if body < 0 else parts.bodies[body].pose) @ frame
        for body, frame in ((joint.a, joint.frame_a), (joint.b, joint.frame_b))
    )
    return np.asarray(a.A.T @ b.A)


def free_coordinates(parts: Parts, names: Names) -> tuple[list[str], Array, Array]:
    """Return the free scalar coordinates, with G and c of all ones, ``s = G s_free + c``.

    Raises
    ------
    InputError
        If couplings contradict each other.
    """
    scalar = list(names.scalar)
    index = {name: i for i, name in enumerate(scalar)}
    K, rhs = np.zeros((len(parts.relations), len(scalar))), np.zeros(len(parts.relations))
    for row, found in enumerate(parts.relations):
        for name, factor in zip(found.names, found.factors, strict=True):
            K[row, index[name]] += factor
        rhs[row] = found.offset
    wanted = [index[found.names[-1]] for found in parts.relations]
    order = [*dict.fromkeys(wanted), *(i for i in range(len(scalar)) if i not in wanted)]
    dependent: dict[int, int] = {}
    for row, found in enumerate(parts.relations):
        scale = np.abs(K[row]).max()
        best = [i for i in order if abs(K[row, i]) > 1e-12 * max(scale, 1e-300)]
        if not best or scale < 1e-13:
            if abs(rhs[row]) > 1e-9:
                message = "contradicts the other couplings; remove one"
                raise InputError(Problem(f"coupling {found.name!r}", message))
            continue
        i = best[0]
        rhs[row] /= K[row, i]
        K[row] /= K[row, i]
        for other in range(len(K)):
            if other != row:
                rhs[other] -= K[other, i] * rhs[row]
                K[other] -= K[other, i] * K[row]
        dependent[i] = row
    kept = [i for i in range(len(scalar)) if i not in dependent]
    G, c = np.zeros((len(scalar), len(kept))), np.zeros(len(scalar))
    for j, i in enumerate(kept):
        G[i, j] = 1.0
    for i, row in dependent.items():
        G[i] = -K[row, kept]
        c[i] = rhs[row]
    return [scalar[i] for i in kept], G, c
