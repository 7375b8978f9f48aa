"""Gear springs of a model: their rows, their stiffness, and the step of explicit methods."""

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
REACH = 2.8
"""Step times the largest frequency up to which RK4 is stable, rounded."""


def gear_springs(model: Model) -> list[ForceModel]:
    """Return the gear springs."""
    return [force for force in model.forces if force.kind == "gear spring"]


def gear_line(force: ForceModel) -> LineModel:
    """Return ``s - phi / N`` of a gear spring."""
    return LineModel((force.coordinate, force.other), (1.0, -1.0 / numbers_of(force).ratio))


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
        switched=(),
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


def explicit_step(model: Model) -> float | None:
    """Return the step below which RK4 is stable with the gear springs, s; None without any.

    The deformations e of the gears at the start, and the coordinates of springs, dampers and
    servos along their shafts, follow ``e'' = -H (K e + D e')`` with the inverse inertia H that the
    joints leave; two inertias I, B have ``H = 1/I + 1/B``. The largest frequency w of this motion
    limits the step to ``2.8 / w``, and fast decay likewise. Machines of more than `MOST`
    velocities are not examined.
    """
    gears = gear_springs(model)
    if not gears or model.nv > MOST:
        return None
    along = _along_shafts(model, gears)
    lines = [(force.name, gear_line(force)) for force in gears]
    lines += [(force.name, LineModel((force.coordinate,), (1.0,))) for force in along]
    k = np.array([_stiffness(model, force) for force in (*gears, *along)])
    c = np.array([_damping(model, force) for force in (*gears, *along)])
    H = _inverse_inertia(model, lines)
    n = len(k)
    rates = np.block([[np.zeros((n, n)), np.eye(n)], [-H * k, -H * c]])
    return min((_stable(z) for z in np.linalg.eigvals(rates) if z != 0.0), default=None)


def _stable(z: complex) -> float:
    """Return the largest step h for which RK4 does not let ``exp(z t)`` grow, s.

    ``|1 + x + x^2/2 + x^3/6 + x^4/24| <= 1`` with ``x = h z``: ``|x|`` is at most `REACH`, and less
    between vibration and decay.
    """
    sizes = np.linspace(0.01, 1.0, 100) * REACH
    x = sizes * z / abs(z)
    grows = np.abs(1 + x * (1 + x / 2 * (1 + x / 3 * (1 + x / 4)))) > 1.0 + RANK
    first = int(np.argmax(grows)) if grows.any() else len(sizes)
    return float(sizes[max(first - 1, 0)] / abs(z))


def _along_shafts(model: Model, gears: Sequence[ForceModel]) -> list[ForceModel]:
    """Return the springs, dampers and servos along the coordinates of gear springs."""
    shafts = {place for gear in gears for place in gear.coordinates}
    return [x for x in model.forces if x.kind == "along" and x.coordinate in shafts]


def _stiffness(model: Model, force: ForceModel) -> float:
    """Return the largest stiffness of a force along a coordinate, N m/rad or N/m."""
    return float(np.real(numbers_of(force).stiffness)) + _steepest(model, force.spring)


def _damping(model: Model, force: ForceModel) -> float:
    """Return the largest damping of a force along a coordinate, N m s/rad or N s/m."""
    return float(np.real(numbers_of(force).damping)) + _steepest(model, force.damper)


def _steepest(model: Model, signal: int) -> float:
    """Return the steepest descent of a table, 0 for other signals and for none (-1)."""
    if signal < 0 or model.signals[signal].kind != "table":
        return 0.0
    x, f = np.real(model.signals[signal].data).reshape(2, -1)
    return max(0.0, float((-np.diff(f) / np.diff(x)).max(initial=0.0)))


def _inverse_inertia(model: Model, lines: Sequence[NamedLine]) -> Array:
    """Return ``G M^-1 G^T`` (n, n) of rows G for the motions that the joints leave."""
    rows = with_rows(model, lines)
    engine = Engine(rows, implicit=False)
    L = np.linalg.cholesky(_mass_matrix(rows, engine))
    C = scipy.linalg.solve_triangular(L, constraint_matrix(rows, engine).T, lower=True)
    joints, G = C[:, : model.permanent], C[:, model.permanent :]
    if joints.shape[1]:
        length = np.linalg.norm(joints, axis=0)
        joints = joints / np.where(length > 0.0, length, 1.0)
        G = G - joints @ scipy.linalg.lstsq(joints, G, cond=RANK)[0]
    return np.asarray(G.T @ G)


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
