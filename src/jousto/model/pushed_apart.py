"""Initial position without overlap: bodies whose shapes overlap are moved apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy

from jousto.base.arrays import Array, Ints
from jousto.base.errors import InputError, Problem, count, warn
from jousto.base.rotations import euler_parameters, rotation_matrix
from jousto.mechanism.forces.contact_set import Contacts
from jousto.mechanism.mechanism import Mechanism
from jousto.model.gear_springs import NamedLine, with_rows
from jousto.model.initial_conditions import gear_angles, with_gears
from jousto.model.model import BodyModel, Model
from jousto.model.native.header import named
from jousto.model.native.native import Engine, displaced
from jousto.model.overlaps import SHOWN, TOUCHING, Overlap, apart_sets, overlaps
from jousto.model.rank.redundancy import RANK, constraint_matrix

MOST = 2000
"""Largest number of velocities of bodies that are coupled by joints and overlaps."""
ITERATIONS = 100
LEAST = 1e-6
"""Last displacement over the deepest overlap."""
CLOSED = 1e-12
"""Largest remaining depth and violation of joints over the size of the mechanism."""
FAR = 1e4
"""Displacement over the depth, in the mass metric, above which bodies cannot be moved apart."""


@dataclass(frozen=True)
class Gaps:
    """Points at which shapes of sets touch, or nearly do.

    Attributes
    ----------
    gap, size : (k,) arrays
        Distance, m, and size of the smaller shape, m.
    rows : (k, nv) sparse array
        Change of the gap with [dR (world), dtheta (body frame)] of every body.
    """

    gap: Array
    size: Array
    rows: Any


def pushed_apart(mechanism: Mechanism, model: Model, held: Sequence[NamedLine]) -> Model:
    """Return the model with bodies moved apart whose shapes overlap, in sets that ask for it.

    The joints stay closed, coordinates with given values keep them, and modal coordinates do not
    change. The displacement x from the declared position is the least one in the metric of the
    masses: each step solves ``min (x + dx)^T M (x + dx)`` with ``Cq dx = -C`` and ``N dx >= -g``
    (Lawson, Hanson, Solving least squares problems, 1974, chapter 23) until dx vanishes. A light
    body yields to a heavy one.

    Parameters
    ----------
    mechanism : Mechanism
    model : Model
        Model with closed joints.
    held : sequence of (str, LineModel)
        Rows of coordinates whose values are given.

    Raises
    ------
    InputError
        If the shapes cannot be moved apart.

    Warns
    -----
    JoustoWarning
        With the pairs, their depth and the largest displacement of a body.
    """
    asked = apart_sets(mechanism)
    if not asked:
        return model
    found = [one for one in overlaps(model) if one.contact in asked]
    if not found:
        return model
    gears, begin = gear_angles(model), np.array(model.q0)
    goal = np.array(Engine(with_rows(model, held)).constraints()[0][model.permanent :])
    for _ in range(ITERATIONS):
        gaps = _gaps(mechanism, model, asked)
        C, Cq = _rows(model, held, goal, found)
        step = _step(model, _way(model, begin), gaps, C, Cq, found)
        depth = -gaps.gap / np.maximum(gaps.size, model.size)
        closed = (depth <= CLOSED).all() and np.abs(C).max(initial=0.0) <= CLOSED
        if closed and _farthest(model, step)[1] <= LEAST * found[0].depth:
            break
        model = replace(model, q0=displaced(model, model.q0, step))
    else:
        raise InputError(_impossible(found, "each step apart makes them overlap again"))
    _tell(model, begin, found)
    return with_gears(model, gear_angles(model) - gears)


def _gaps(mechanism: Mechanism, model: Model, asked: set[str]) -> Gaps:
    """Return the gaps of the sets that move bodies apart."""
    sets = {force.name: force for force in mechanism.forces if isinstance(force, Contacts)}
    markers = {force.name: force.touches for force in model.forces if force.slots}
    touches = named("jo_touch", Engine(model, implicit=False).contacts())
    gap, size = list[float](), list[float]()
    values, columns, starts = list[Array](), list[Ints](), [0]
    turn = [rotation_matrix(model.q0[body.iq + 3 : body.iq + 7]) for body in model.bodies]
    for i, place in enumerate(touches.force):
        on, of = (int(k) for k in touches.shapes[i])
        name = model.forces[int(place)].name
        if on < 0 or name not in asked:
            continue
        shapes = sets[name].shapes
        for shape, sign in ((on, -1.0), (of, 1.0)):
            body = model.markers[markers[name][shape]].body
            if body < 0:
                continue
            one, n = model.bodies[body], touches.normal[i]
            arm = touches.place[i] - model.q0[one.iq : one.iq + 3]
            values.append(sign * np.concatenate([n, turn[body].T @ np.cross(arm, n)]))
            columns.append(one.iv + np.arange(6))
        gap.append(float(touches.gap[i]))
        size.append(min(shapes[on].size, shapes[of].size))
        starts.append(6 * len(values))
    numbers = np.concatenate([np.zeros(0), *values])
    at = np.concatenate([np.zeros(0, np.int64), *columns])
    rows = scipy.sparse.csr_array((numbers, at, starts), shape=(len(gap), model.nv))
    return Gaps(np.array(gap), np.array(size), rows)


def _rows(
    model: Model, held: Sequence[NamedLine], goal: Array, found: Sequence[Overlap]
) -> tuple[Array, Array]:
    """Return C over the size of the mechanism, of joints and held coordinates, and Cq likewise."""
    if not model.permanent and not held:
        return np.zeros(0), np.zeros((0, model.nv))
    if model.nv > MOST:
        raise InputError(_impossible(found, f"{model.nv} velocities with joints exceed {MOST}"))
    rows = with_rows(model, held)
    engine = Engine(rows, implicit=False)
    C = np.array(engine.constraints()[0])
    C[model.permanent :] -= goal
    metres = engine.row_metres / model.size
    return C * metres, constraint_matrix(rows, engine) * metres[:, None]


def _way(model: Model, begin: Array) -> Array:
    """Return the displacement [dR (world), dtheta (body frame)] (nv,) of bodies from `begin`."""
    x = np.zeros(model.nv)
    for body in model.bodies:
        place, turn = slice(body.iq, body.iq + 3), slice(body.iq + 3, body.iq + 7)
        x[body.iv : body.iv + 3] = model.q0[place] - begin[place]
        A = rotation_matrix(begin[turn]).T @ rotation_matrix(model.q0[turn])
        e = euler_parameters(A)
        e = e if e[0] >= 0.0 else -e
        sine = float(np.linalg.norm(e[1:]))
        x[body.iv + 3 : body.iv + 6] = 2.0 * np.arctan2(sine, e[0]) / sine * e[1:] if sine else 0.0
    return x


def _farthest(model: Model, x: Array) -> tuple[int, float]:
    """Return the body with the largest displacement, and its size, m."""
    ways = [float(np.linalg.norm(x[body.iv : body.iv + 3])) for body in model.bodies]
    most = int(np.argmax(ways))
    return most, ways[most]


def _step(
    model: Model, way: Array, gaps: Gaps, C: Array, Cq: Array, found: Sequence[Overlap]
) -> Array:
    """Return the change (nv,) of the way, so that the joints close and the gaps open."""
    step = np.zeros(model.nv)
    still = np.diff(gaps.rows.indptr) == 0
    if (gaps.gap[still] < -TOUCHING * gaps.size[still]).any():
        raise InputError(_impossible(found, "none of the bodies of a pair can move"))
    engine = Engine(model, implicit=False)
    for part in _coupled(model, Cq, gaps.rows):
        columns = np.concatenate([body.iv + np.arange(6) for _, body in part.bodies])
        gap, before = gaps.gap[part.gaps], way[columns]
        if not ((gap < 0.0).any() or before.any()):
            continue
        if len(columns) > MOST:
            coupled = f"joints and overlaps couple {len(columns)} velocities, more than {MOST}"
            raise InputError(_impossible(found, coupled))
        back = np.zeros((len(columns), len(columns)))
        for k, (place, body) in enumerate(part.bodies):
            own = slice(6 * k, 6 * k + 6)
            back[own, own] = _whitened(model, engine, place, body, found)
        A, G = Cq[np.ix_(part.rows, columns)], gaps.rows[part.gaps][:, columns].toarray()
        x = _least(A @ back, A @ before - C[part.rows], G @ back, G @ before - gap)
        if x is None:
            raise InputError(_impossible(found, "joints, or bodies that cannot move, hold them"))
        step[columns] = back @ x - before
    return step


@dataclass(frozen=True)
class Part:
    """Bodies that joints and contacts couple, and the numbers of their rows and gaps."""

    bodies: list[tuple[int, BodyModel]]
    rows: Ints
    gaps: Ints


def _coupled(model: Model, Cq: Array, N: Any) -> list[Part]:
    """Return the sets of bodies that rows of joints and gaps couple with one another."""
    n = len(model.bodies)
    of = np.repeat(np.arange(n), [6 + body.n for body in model.bodies])
    every = scipy.sparse.vstack([scipy.sparse.coo_array(Cq), N]).tocoo()
    at, column = every.coords
    pairs = scipy.sparse.coo_array((np.ones(len(at)), (at, of[column])), shape=(every.shape[0], n))
    label = scipy.sparse.csgraph.connected_components((pairs.T @ pairs).tocsr(), directed=False)[1]
    bodies: dict[int, list[tuple[int, BodyModel]]] = {}
    rows: dict[int, dict[int, None]] = {}
    for place in np.unique(of[column]).tolist():
        bodies.setdefault(int(label[place]), []).append((place, model.bodies[place]))
    for row, k in zip(at.tolist(), label[of[column]].tolist(), strict=True):
        rows.setdefault(k, {})[row] = None
    numbers = {k: np.array(list(own), dtype=np.int64) for k, own in rows.items()}
    first = len(Cq)
    return [
        Part(some, numbers[k][numbers[k] < first], numbers[k][numbers[k] >= first] - first)
        for k, some in bodies.items()
    ]


def _whitened(
    model: Model, engine: Engine, place: int, body: BodyModel, found: Sequence[Overlap]
) -> Array:
    """Return L^-T (6, 6) with ``M = L L^T``: displacements of unit norm in the mass metric."""
    M = np.array(engine.mass_matrix(place))[:6, :6]
    A = rotation_matrix(model.q0[body.iq + 3 : body.iq + 7])
    M[:3] = A @ M[:3]  # R'' of the engine's matrix is resolved in the body frame
    M[:, :3] = M[:, :3] @ A.T
    try:
        return np.asarray(np.linalg.inv(np.linalg.cholesky(M)).T)
    except np.linalg.LinAlgError:
        raise InputError(_impossible(found, f"body {body.name!r} has no mass")) from None


def _least(A: Array, b: Array, G: Array, h: Array) -> Array | None:
    """Return x of least norm with ``A x = b`` and ``G x >= h``; None if there is none.

    Without equations it is the least distance problem, solved by nonnegative least squares.
    """
    U, s, Vt = np.linalg.svd(A, full_matrices=True)
    rank = int((s > RANK * s.max(initial=0.0)).sum())
    start = Vt[:rank].T @ ((U[:, :rank].T @ b) / s[:rank])
    free = Vt[rank:].T
    G, h = G @ free, h - G @ start
    length = np.linalg.norm(G, axis=1)
    fixed = length <= RANK * length.max(initial=0.0)  # gaps that no motion changes
    scale = float(h.max(initial=0.0))
    if scale <= 0.0:
        return np.asarray(start)
    if (h[fixed] > CLOSED * scale).any():
        return None
    G, h = G[~fixed] / length[~fixed, None], h[~fixed] / (scale * length[~fixed])
    unit = 1.0 / max(float(h.max(initial=0.0)), 1e-300)
    E = np.concatenate([G.T, unit * h[None, :]])
    f = np.zeros(len(E))
    f[-1] = 1.0
    u, _ = scipy.optimize.nnls(E, f)
    r = E @ u - f
    y = -r[:-1] / r[-1] if r[-1] else np.full(len(r) - 1, np.inf)
    if not np.abs(y).max(initial=0.0) <= FAR or (G @ y < unit * h - LEAST).any():
        return None  # no motion opens all gaps
    return np.asarray(start + free @ (y * scale / unit))


def _impossible(found: Sequence[Overlap], reason: str) -> Problem:
    """Return the problem of shapes that cannot be moved apart."""
    listed = ", ".join(map(str, found[:SHOWN])) + (", ..." if len(found) > SHOWN else "")
    return Problem(
        f"contacts {found[0].contact!r}",
        f"{count(len(found), 'pair')} of shapes overlap at the start and cannot be moved apart, "
        f"{listed}: {reason}; move the bodies yourself, or exclude the pairs with Apart",
        path=("overlap",),
    )


def _tell(model: Model, begin: Array, found: Sequence[Overlap]) -> None:
    """Warn with the pairs, their depth and the largest displacement."""
    most, way = _farthest(model, _way(model, begin))
    listed = ", ".join(map(str, found[:SHOWN])) + (", ..." if len(found) > SHOWN else "")
    warn(
        f"contacts {found[0].contact!r}",
        f"{count(len(found), 'pair')} of shapes overlapped at the start and were moved apart: "
        f"{listed}; body {model.bodies[most].name!r} moved farthest, by {way:.3g} m",
    )
