"""Bodies that can move, to first order at a position and at neighbouring positions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import SimulationError
from jousto.base.rotations import rotation_matrix
from jousto.model.hubs import order_joints
from jousto.model.loop_joints import cut_joints, is_moving
from jousto.model.model import JointModel, Model
from jousto.model.native.native import Engine, displaced
from jousto.model.rank.redundancy import DENSE, NEARBY, is_drive, null_space, unit_rows
from jousto.model.scales import velocity_metres

# ratio of the smallest motion and a unit motion in the mass metric; smaller motions are round-off
MOVES = 1e-6
SMALL = 3 * DENSE  # largest number of velocities for one singular value decomposition
# number of random velocities; a movable body is at rest in all of them with probability 0
SAMPLES = 3
# number of projections, since a single one leaves a small part of weak rows if rows are redundant
AGAIN = 8


def moving(model: Model, q: Array) -> set[str]:
    """Return the bodies that can move at a position, to first order.

    In a tree without other rows, a body moves with the links between it and the ground. Otherwise
    the free motions are ``(1 - G^+ G) x``. They are all computed for small models; for large ones
    the engine projects random x, with an effort linear in the size of the mechanism.

    Parameters
    ----------
    model : Model
    q : (nq,) array
        A position with closed joints.
    """
    if model.links and not model.mixed and not cut_joints(model, model.links):
        return _led(model)
    engine = Engine(model, implicit=False)
    engine.q[:] = q
    if model.nv <= SMALL:
        free = null_space(unit_rows(model, engine))  # in coordinates of unit mass
        found = np.abs(free).max(axis=0, initial=0.0)
    else:
        found = _projected(model, engine)
    return {b.name for b in model.bodies if found[b.iv : b.iv + 6 + b.n].max(initial=0.0) > MOVES}


def _led(model: Model) -> set[str]:
    """Return the bodies of a tree that have an undriven link between them and the ground."""
    moves: list[bool] = []
    for link in model.links:
        before = link.parent >= 0 and moves[link.parent]
        moves.append(before or is_moving(link))
    found = zip(model.links, moves, strict=True)
    return {model.bodies[link.body].name for link, free in found if free and link.body >= 0}


def _projected(model: Model, engine: Engine) -> Array:
    """Return the largest magnitudes (nv,) of random free motions, in units of unit mass."""
    random = np.random.default_rng(0)
    masses = _MassFactors(model, engine)

    def project(v: Array) -> Array:
        engine.v[:] = v
        for _ in range(AGAIN if model.redundant else 1):
            engine.assemble()
        return np.array(engine.v)

    rest = project(np.zeros(model.nv))  # velocities caused by drives
    largest = np.zeros(model.nv)
    for _ in range(SAMPLES):
        x = masses.to_velocities(random.standard_normal(model.nv))
        free = masses.to_unit_mass(project(x) - rest)
        largest = np.maximum(largest, np.abs(free))
    return largest


class _MassFactors:
    """Cholesky factors ``M = L L^T`` of all bodies; factors of equal size in one array.

    Velocities are [R' (world), w (local), p'] of every body; M is resolved in the body frame.
    """

    def __init__(self, model: Model, engine: Engine) -> None:
        sizes: dict[int, list[int]] = {}
        for i, body in enumerate(model.bodies):
            sizes.setdefault(6 + body.n, []).append(i)
        self._groups: list[tuple[NDArray[np.intp], Array, Array]] = []
        for size, places in sizes.items():
            M = np.stack([engine.mass_matrix(i) for i in places])
            A = [rotation_matrix(engine.q[model.bodies[i].iq + 3 :][:4]) for i in places]
            columns = np.array([model.bodies[i].iv for i in places])[:, None] + np.arange(size)
            self._groups.append((columns, np.linalg.cholesky(M), np.stack(A)))

    def to_velocities(self, x: Array) -> Array:
        """Return velocities (nv,) from coordinates with unit mass matrix, ``L^-T x``."""
        v = np.zeros_like(x)
        for columns, L, A in self._groups:
            part = np.linalg.solve(np.swapaxes(L, 1, 2), x[columns][..., None])
            part[:, :3] = A @ part[:, :3]
            v[columns] = part[..., 0]
        return v

    def to_unit_mass(self, v: Array) -> Array:
        """Return coordinates with unit mass matrix (nv,) from velocities, ``L^T v``."""
        x = np.zeros_like(v)
        for columns, L, A in self._groups:
            part = v[columns][..., None]
            part[:, :3] = np.swapaxes(A, 1, 2) @ part[:, :3]
            x[columns] = (np.swapaxes(L, 1, 2) @ part)[..., 0]
        return x


def without_drives(model: Model) -> Model:
    """Return the model without rows that depend on signals, and without sticking friction."""
    kept: list[JointModel] = []
    row = 0
    for joint in model.joints:
        if joint.lock < 0 and not is_drive(joint):
            kept.append(replace(joint, row=row))
            row += joint.rows
    elimination = model.elimination
    if len(kept) < len(model.joints):
        elimination = order_joints(kept, model.markers, model.bodies)
    return replace(
        model,
        joints=tuple(kept),
        elimination=elimination,
        frictions=(),
        switched=(),
        forces=(),
        sensors=(),
        events=(),
        meters=(),
        signals=(),
    )


def neighbour(model: Model) -> Array | None:
    """Return a nearby position (nq,) along a free motion, None without such a motion."""
    engine = Engine(replace(model, redundant=True), implicit=False)
    metres = velocity_metres(model) / model.size
    engine.v[:] = np.random.default_rng(0).standard_normal(model.nv) / metres
    try:
        engine.assemble()
        size = float(np.abs(engine.v * metres).max(initial=0.0))
        if size < MOVES:
            return None
        engine.q[:] = displaced(model, engine.q, engine.v * (NEARBY / size))
        engine.assemble()
    except SimulationError:
        return None
    return np.array(engine.q)
