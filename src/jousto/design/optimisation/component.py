"""Vibration of one flexible part alone, under the loads of a rigid run (Altarriba 2010, S11).

The part moves by a small motion c about the rigid run, ``w = Z c``, with the small motions w of its
frame, its modal coordinates p and, if it carries them, of the bodies beyond it. Z spans what the
joints admit. ``Z^T M Z c'' + Z^T D Z c' + Z^T K Z c = Z^T F(t)``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as sl

from jousto.base.arrays import Array
from jousto.model.model import JointModel, Model
from jousto.model.native.native import Engine
from jousto.recovery.loads.attribution import coupling_kind, joint_markers
from jousto.recovery.shape import rotation_matrices

RANK = 1e-9
"""Singular value of constraint rows / largest one, below which a row is redundant."""
SHARE = 0.05
"""Share of the strain energy from which a mode counts."""
RIGID = 1e-10
"""Squared frequency / largest one, below which a motion does not deform the part."""


@dataclass(frozen=True, eq=False)
class Component:
    """Modes of a held part: ``s'' + D s' + w2 s = shapes^T F(t)``, ``p = shapes_p s``.

    Attributes
    ----------
    shapes : (6 + n, m) array
        Motion of the frame of the part and of its modal coordinates in each mode.
    w2 : (m,) array
        Squared circular frequencies, rad2/s2.
    D : (m, m) array
        Damping, 1/s.
    """

    shapes: Array
    w2: Array
    D: Array


def component(model: Model, k: int, q: Array, held: str, beyond: bool) -> Component:
    """Return the modes of a flexible body as its joints hold it in the rigid machine.

    Parameters
    ----------
    model : Model
        Flexible machine.
    k : int
        Index of the body.
    q : (nq,) array
        Positions at which the constraints are linearised.
    held : {"motion", "force", "machine"}
        "motion": the joints that carry the body follow the rigid run, as many of their rows as are
        statically determinate; "force": the body is free; "machine": the body in the machine whose
        other bodies are rigid and move with it.
    beyond : bool
        Whether the bodies beyond it, which are rigid, move with it.
    """
    engine = Engine(replace(model, tree=()))
    engine.q[:] = q
    engine.v[:] = 0.0
    rows = constraint_rows(engine, model)
    carriers = sorted(carrying_joints(model, k))
    others = [i for i in range(len(model.bodies)) if i != k]
    if held != "machine":
        others = bodies_beyond(model, k, carriers) if beyond else []
    # columns: frame and modes of the body, then frames of the bodies that move with it
    columns = [*body_columns(model, k, True)]
    for i in others:
        columns += body_columns(model, i, False)
    inner = inner_joints(model, {k, *others}, held == "machine")
    C = [np.zeros((0, len(columns)))]
    C += [rows[joint_rows(model, j)][:, columns] for j in sorted(inner)]
    if held == "motion":
        C.append(held_rows(model, rows, k, carriers)[:, columns])
    found = np.vstack(C)
    Z = sl.null_space(found, rcond=RANK) if len(found) else np.eye(len(columns))
    M = sl.block_diag(part_mass(engine, k), *(part_mass(engine, i)[:6, :6] for i in others))
    return held_modes(model, k, M, Z)


def held_modes(model: Model, k: int, M: Array, Z: Array) -> Component:
    """Return the modes with strain energy in the space of motions Z."""
    body, n = model.bodies[k], model.bodies[k].n
    p = slice(6, 6 + n)
    K = Z[p].T @ (np.real(body.K)[:, None] * Z[p])
    w2, c = sl.eigh(K, Z.T @ M @ Z)
    elastic = w2 > RIGID * max(float(w2.max(initial=0.0)), 0.0)
    shapes = (Z @ c[:, elastic])[: 6 + n]
    D = shapes[6:].T @ (np.real(body.D)[:, None] * shapes[6:])
    return Component(shapes, w2[elastic], D)


def part_mass(engine: Engine, k: int) -> Array:
    """Return the mass matrix (6 + n, 6 + n) of a body for ``[R'' (body frame), w', p'']``."""
    return np.asarray(np.real(engine.mass_matrix(k)))


def constraint_rows(engine: Engine, model: Model) -> Array:
    """Return the constraint matrix (nrow, nv), R' of each body resolved in its own frame.

    Rows are divided by the length of their unit, so that angles and lengths are comparable.
    """
    if not model.nrow:
        return np.zeros((0, model.nv))
    C = np.real(engine.newton_matrix(0.0, 1.0, 0.0)[model.nv :, : model.nv])
    for body in model.bodies:
        A = rotation_matrices(np.real(engine.q[body.iq + 3 : body.iq + 7])[None])[0]
        C[:, body.iv : body.iv + 3] = C[:, body.iv : body.iv + 3] @ A
    return np.asarray(C * np.asarray(engine.row_metres)[:, None])


def bodies_of(model: Model, joint: JointModel) -> set[int]:
    """Return the indices of the bodies of a joint; -1 is the ground."""
    return {model.markers[m].body for m in joint_markers(model, joint)}


def holding(joint: JointModel) -> bool:
    """Return whether a joint holds bodies together: no gear, no sticking friction."""
    plain = bool(joint.coincident or joint.perpendicular)
    return joint.lock < 0 and (plain or coupling_kind(joint) == "drive" or len(joint.lines) > 1)


def distances(model: Model) -> list[float]:
    """Return the number of joints between each body and the ground; infinity without a path."""
    found = [float("inf")] * len(model.bodies)
    edges = [bodies_of(model, joint) for joint in model.joints if holding(joint)]
    front, step = {-1}, 0.0
    while front:
        step += 1.0
        near = {b for edge in edges if edge & front for b in edge - {-1}}
        front = {b for b in near if found[b] == float("inf")}
        for b in front:
            found[b] = step
    return found


def carrying_joints(model: Model, k: int) -> set[int]:
    """Return the joints between a body and bodies that are nearer to the ground, or the ground."""
    far = distances(model)
    found = set()
    for j, joint in enumerate(model.joints):
        pair = bodies_of(model, joint)
        other = pair - {k}
        if k in pair and holding(joint) and other:
            if all(i < 0 or far[i] < far[k] for i in other):
                found.add(j)
    return found


def bodies_beyond(model: Model, k: int, carriers: Sequence[int]) -> list[int]:
    """Return the bodies that hang on a body by its other joints."""
    edges = [
        bodies_of(model, joint) - {-1}
        for j, joint in enumerate(model.joints)
        if j not in carriers and -1 not in bodies_of(model, joint)
    ]
    far, found, front = distances(model), {k}, {k}
    while front:
        near = {b for edge in edges if edge & front for b in edge}
        front = {b for b in near - found if far[b] > far[k]}
        found |= front
    return sorted(found - {k})


def inner_joints(model: Model, moving: set[int], ground: bool) -> set[int]:
    """Return the joints whose bodies all move with a part; with the ground if it holds them."""
    still = {-1} if ground else set()
    return {
        j
        for j, joint in enumerate(model.joints)
        if joint.lock < 0 and bodies_of(model, joint) <= moving | still
    }


def body_columns(model: Model, k: int, modes: bool) -> range:
    """Return the columns of the velocities of a body, with or without its modes."""
    body = model.bodies[k]
    return range(body.iv, body.iv + 6 + (body.n if modes else 0))


def joint_rows(model: Model, j: int) -> slice:
    """Return the constraint rows of a joint."""
    return slice(model.joints[j].row, model.joints[j].row + model.joints[j].rows)


def held_rows(model: Model, rows: Array, k: int, carriers: Sequence[int]) -> Array:
    """Return the rows of the carrying joints that hold the frame of a body determinately.

    Of redundant rows, such as both ends of a rod along its axis, one is chosen by pivoted QR; loads
    of the other one are frozen.
    """
    C = np.vstack([np.zeros((0, model.nv)), *(rows[joint_rows(model, j)] for j in carriers)])
    if not len(C):
        return C
    frame = C[:, body_columns(model, k, False)]
    _, R, order = sl.qr(frame.T, mode="economic", pivoting=True)
    size = np.abs(np.diag(R))
    rank = int(np.sum(size > RANK * size.max(initial=0.0)))
    return np.asarray(C[np.sort(order[:rank])])


def mass_ratio(held: Component, free: Component, F: Array) -> float:
    """Return ``m / (M + m0)``: the mass of held modes over that in the free machine, less 1.

    The largest ratio of the modes that have a twentieth of the strain energy under the loads. The
    mass of a shape p is ``p^T (S S^T)^-1 p`` with the shapes S of the modes. Of a shape that the
    machine does not admit, since a closed loop holds the part, the admitted part counts.

    Parameters
    ----------
    held, free : Component
        The part with its carriers held, and in the rigid machine.
    F : (nt, 6 + n) array
        Loads on the part.
    """
    if not len(held.w2) or not len(free.w2):
        return 0.0
    energy = ((F @ held.shapes) ** 2 / held.w2).max(axis=0)
    bent = energy >= SHARE * energy.sum()
    p, S = held.shapes[6:, bent], free.shapes[6:]
    p = S @ np.linalg.lstsq(S, p, rcond=RANK)[0]
    alone, carried = shape_masses(held, p), shape_masses(free, p)
    admitted = carried > RANK
    ratio = alone[admitted] / carried[admitted] - 1.0
    return float(np.max(ratio, initial=0.0)) if energy.any() else 0.0


def shape_masses(one: Component, p: Array) -> Array:
    """Return the mass (k,) of modal shapes (n, k) in the modes of a part."""
    S = one.shapes[6:]
    inverse = np.linalg.pinv(S @ S.T, rcond=RANK, hermitian=True)
    return np.asarray(np.einsum("ij,ij->j", p, inverse @ p))


def response(one: Component, time: Array, F: Array, start: Array, rate: Array) -> Array:
    """Return the motion s (m, nt) under loads that are cubic between instants.

    Exact for the loads, by the exponential of the state matrix over each interval. The cubics have
    the values at both ends, and slopes without overshoot (F. N. Fritsch, J. Butland, SIAM J. Sci.
    Stat. Comput. 5 (1984) 300-304).

    Parameters
    ----------
    one : Component
    time : (nt,) array
        s.
    F : (nt, 6 + n) array
        Loads on the part.
    start, rate : (m,) array
        Motion and velocity at the first instant.
    """
    m = len(one.w2)
    x = np.zeros((len(time), 2 * m))
    x[0] = np.concatenate([start, rate])
    c = cubics(time, F @ one.shapes)
    kinds: dict[float, tuple[Array, Array]] = {}
    for i, h in enumerate(np.diff(time)):
        key = float(f"{h:.12e}")
        if key not in kinds:
            kinds[key] = step_matrices(one, key)
        E, G = kinds[key]
        x[i + 1] = E @ x[i] + G @ c[i].ravel()
    return np.asarray(x[:, :m].T)


def cubics(time: Array, f: Array) -> Array:
    """Return the coefficients (nt - 1, 4, m) of ``sum_k c_k t^k`` between instants.

    Slopes are harmonic means of the difference quotients on both sides, 0 at extremes.
    """
    h = np.diff(time)[:, None]
    d = np.diff(f, axis=0) / h
    slope = np.zeros_like(f)
    if len(d):
        slope[0], slope[-1] = d[0], d[-1]
        before, after = 2.0 * h[1:] + h[:-1], h[1:] + 2.0 * h[:-1]
        product = d[:-1] * d[1:]
        mean = before * d[1:] + after * d[:-1]
        same = product > 0.0
        slope[1:-1][same] = (product * (before + after))[same] / mean[same]
    left, right = slope[:-1], slope[1:]
    second = (3.0 * d - 2.0 * left - right) / h
    return np.stack([f[:-1], left, second, (left + right - 2.0 * d) / h**2], axis=1)


def step_matrices(one: Component, h: float) -> tuple[Array, Array]:
    """Return E (2m, 2m) and G (2m, 4m) of ``x(h) = E x + G c`` under ``f(t) = sum_k c_k t^k``.

    One exponential: the load is the first state of a chain of integrators with the initial values
    ``k! c_k`` (C. Van Loan, IEEE Trans. Autom. Control 23 (1978) 395-404).
    """
    m = len(one.w2)
    unit = np.eye(m)
    X = np.zeros((6 * m, 6 * m))
    X[:m, m : 2 * m] = unit
    X[m : 2 * m, :m], X[m : 2 * m, m : 2 * m] = -np.diag(one.w2), -one.D
    for block in range(1, 5):
        X[block * m : (block + 1) * m, (block + 1) * m : (block + 2) * m] = unit
    found = sl.expm(X * h)[: 2 * m]
    return found[:, : 2 * m], found[:, 2 * m :] * np.repeat([1.0, 1.0, 2.0, 6.0], m)
