"""Gear springs of a model: their rows, their stiffness, and the fastest motion that they cause."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np
import scipy

from jousto.base.arrays import Array
from jousto.base.rotations import rotation_matrix
from jousto.model.force_numbers import numbers_of
from jousto.model.hubs import order_joints
from jousto.model.model import ForceModel, JointModel, LineModel, Model, SignalModel
from jousto.model.native.native import Engine
from jousto.model.rank.redundancy import RANK, constraint_matrix

NamedLine: TypeAlias = tuple[str, LineModel]
"""A row and its name for messages."""

MOST = 600
"""Largest number of velocities for a dense mass matrix."""


def gear_springs(model: Model) -> list[ForceModel]:
    """Return the gear springs."""
    return [force for force in model.forces if force.kind == "gear spring"]


def gear_line(force: ForceModel) -> LineModel:
    """Return ``s - phi / N`` of a gear spring."""
    return LineModel((force.coordinate, force.other), (1.0, -1.0 / numbers_of(force).ratio))


def largest_stiffness(model: Model, force: ForceModel) -> float:
    """Return the stiffness of the stiffest piece of a gear spring, N m/rad or N/m."""
    k = float(np.real(numbers_of(force).stiffness))
    if force.spring < 0:
        return k
    e, f = np.real(model.signals[force.spring].data).reshape(2, -1)
    return k + max(0.0, float((-np.diff(f) / np.diff(e)).max()))


def with_rows(model: Model, lines: Sequence[NamedLine]) -> Model:
    """Return the model with more rows, after all permanent ones, and without forces."""
    fixed = [joint for joint in model.joints if joint.lock < 0]
    row = model.permanent
    for name, line in lines:
        ends = [model.coordinates[place] for place in line.coordinates]
        sides = tuple(side for s in ends for side in (s.a, s.b))
        fixed.append(JointModel(name, sides, False, (), row, (line,)))
        row += 1
    # friction and its rows have no effect on the initial state
    return replace(
        model,
        joints=tuple(fixed),
        elimination=order_joints(fixed, model.markers, model.bodies),
        frictions=(),
        forces=(),
        sensors=(),
        events=(),
        meters=(),
        signals=_without_events(model),
        redundant=True,
    )


def _without_events(model: Model) -> tuple[SignalModel, ...]:
    """Return the signals before any event."""
    return tuple(
        model.signals[signal.children[0]] if signal.kind == "switched" else signal
        for signal in model.signals
    )


def fastest_gear(model: Model) -> float:
    """Return the highest frequency of the gear springs alone at the start, rad/s; 0 without any.

    ``omega^2`` is the largest eigenvalue of ``K^1/2 G H G^T K^1/2`` with the rows G of the gears,
    their stiffness K, and the inverse mass H of the motions that the joints leave; two inertias
    I, B have ``omega^2 = K (1/I + 1/B)``. Machines of more than `MOST` velocities are not examined.
    """
    gears = gear_springs(model)
    if not gears or model.nv > MOST:
        return 0.0
    rows = with_rows(model, [(force.name, gear_line(force)) for force in gears])
    engine = Engine(rows, implicit=False)
    L = np.linalg.cholesky(_mass_matrix(rows, engine))
    C = scipy.linalg.solve_triangular(L, constraint_matrix(rows, engine).T, lower=True)
    joints, G = C[:, : model.permanent], C[:, model.permanent :]
    if joints.shape[1]:
        length = np.linalg.norm(joints, axis=0)
        joints = joints / np.where(length > 0.0, length, 1.0)
        G = G - joints @ scipy.linalg.lstsq(joints, G, cond=RANK)[0]
    G = G * np.sqrt([largest_stiffness(model, force) for force in gears])
    return float(np.sqrt(np.linalg.eigvalsh(G.T @ G)[-1].clip(0.0)))


def _mass_matrix(model: Model, engine: Engine) -> Array:
    """Return the mass matrix (nv, nv) for [R' (world), w (local), p'] of each body."""
    M = np.zeros((model.nv, model.nv))
    for i, body in enumerate(model.bodies):
        own = np.array(engine.mass_matrix(i))
        A = rotation_matrix(engine.q[body.iq + 3 : body.iq + 7])
        own[:3] = A @ own[:3]  # R'' of the engine's matrix is resolved in the body frame
        own[:, :3] = own[:, :3] @ A.T
        place = slice(body.iv, body.iv + 6 + body.n)
        M[place, place] = own
    return M
