"""Initial state of a model with complex constants: derivatives of the closed joints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.complexstep import is_stepping, parts, plainly, real_parts
from jousto.base.errors import NotAnalytic
from jousto.base.rotations import rotation_matrix
from jousto.model.initial_conditions import modal_velocities
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.model.rank.redundancy import RANK, constraint_matrix
from jousto.model.scales import largest_speed, position_metres

SMALL = 1e-9  # relative tolerance of comparisons


def has_steps(model: Model) -> bool:
    """Return whether any number of a model carries a derivative (an imaginary part)."""
    return is_stepping() and real_parts(model) is not model


def plain_model(model: Model, along: float = 0.0) -> Model:
    """Return a model without derivatives, see `real_parts`, with the same core."""
    made: Model = real_parts(model, along)
    return made if made is model else made.keeping_tree(model)


def with_start(model: Model, finish: Callable[[Model], Model], initials: Sequence[Any]) -> Model:
    """Return a model with the initial state from `finish`, and the derivatives of that state.

    Parameters
    ----------
    model : Model
        Model with complex constants.
    finish : callable
        Function that returns a real model with its initial state: closed joints, consistent
        velocities.
    initials : sequence of Initial
        Coordinates with given values or rates.

    Raises
    ------
    NotAnalytic
        If the initial state has no derivative by complex steps.
    """
    if not has_steps(model):
        return finish(model)
    if initials:
        raise NotAnalytic("initial values of coordinates are found by iterations")
    with plainly():
        plain = real_parts(model)
        given = plain.v0.copy()
        made = finish(replace(plain, q0=plain.q0.copy(), v0=given.copy()))
    engine = Engine(replace(model, redundant=made.redundant), complex_scalars=True)
    engine.assemble()
    moved = np.abs(engine.q.real - made.q0) * position_metres(plain)
    if moved.max(initial=0.0) > SMALL * plain.size:
        raise NotAnalytic("with complex numbers its joints close at another position")
    v = engine.v
    modal = modal_velocities(plain)
    if not given.any() and np.any(v[modal]):
        v = _quiet(model, engine, np.asarray(model.v0))
    if largest_speed(plain, v.real - made.v0) > SMALL * largest_speed(plain, made.v0):
        raise NotAnalytic("the initial velocities have no derivative by complex steps")
    start: Any = (made.q0 + 1j * engine.q.imag, made.v0 + 1j * v.imag)
    sensors = made.sensors if made.redundant else model.sensors
    return replace(model, q0=start[0], v0=start[1], redundant=made.redundant, sensors=sensors)


def _quiet(model: Model, engine: Engine, given: NDArray[Any]) -> NDArray[Any]:
    """Return v (nv,) that satisfies joints and drives by rigid motions of least kinetic energy.

    ``v = v0 + M^-1 G^T S^+ b`` with ``S = G M^-1 G^T``, G the columns of Cq of the rigid motions.
    """
    nearest = engine.v.copy()
    Cq = constraint_matrix(model, engine)
    engine.v[:] = given
    b = -engine.constraints()[1][: len(Cq)]
    engine.v[:] = nearest
    modal = modal_velocities(model)
    G = Cq.copy()
    G[:, modal] = 0.0
    W = np.zeros_like(G)  # G M^-1
    for i, body in enumerate(model.bodies):
        M = np.array(engine.mass_matrix(i))[:6, :6]
        A = rotation_matrix(engine.q[body.iq + 3 : body.iq + 7])
        M[:3] = A @ M[:3]  # R'' of the engine's matrix is resolved in the body frame
        M[:, :3] = M[:, :3] @ A.T
        columns = slice(body.iv, body.iv + 6)
        W[:, columns] = np.linalg.solve(M, G[:, columns].T).T
    y = least_norm(W @ G.T, b)
    return np.asarray(given + W.T @ y)


def least_norm(S: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    """Return ``y = S^+ b`` of a symmetric matrix of constant rank, with its derivative.

    ``dy = S^+ (db - dS y) + S^+ S^+ dS (b - S y) + (E - S^+ S) dS S^+ y`` (Golub and Pereyra, SIAM
    J. Numer. Anal. 10, 1973, eq. 4.12).

    Raises
    ------
    NotAnalytic
        If b is outside of the range of S: modal velocities are then needed.
    """
    (S0, dS), (b0, db) = parts(S), parts(b)
    size = np.sqrt(np.diag(S0))
    size = np.where(size > 0.0, size, 1.0)
    S0, dS, b0, db = S0 / np.outer(size, size), dS / np.outer(size, size), b0 / size, db / size
    inverse = np.linalg.pinv(S0, rcond=RANK, hermitian=True)
    y = inverse @ b0
    dy = inverse @ (db - dS @ y) + (np.eye(len(y)) - inverse @ S0) @ dS @ inverse @ y
    scales = (np.abs(b0).max(initial=0.0), np.abs(db - dS @ y).max(initial=0.0))
    for rest, scale in zip((b0 - S0 @ y, db - dS @ y - S0 @ dy), scales, strict=True):
        if np.abs(rest).max(initial=0.0) > SMALL * scale:
            raise NotAnalytic("joints and drives need modal velocities at the start")
    return np.asarray((y + 1j * dy) / size)
