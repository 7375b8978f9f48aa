"""Initial state: values and rates of coordinates, and velocities with the least vibration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, warn
from jousto.base.rotations import rotation_matrix
from jousto.mechanism.initial import Initial
from jousto.model.force_numbers import numbers_of, with_number
from jousto.model.gear_springs import NamedLine, gear_line, gear_springs, with_rows
from jousto.model.model import JointModel, LineModel, Model
from jousto.model.native.native import Engine, displaced
from jousto.model.packing.builder import Builder
from jousto.model.rank.redundancy import RANK, SHARE, constraint_matrix, dependent_rows, is_drive
from jousto.model.scales import largest_speed, velocity_metres

SAME = 1e-12  # round-off, relative to the velocities
FITS = 1e-9  # largest violation of constraint rows, relative to the largest velocity
MOST = 2000  # largest number of velocities and rows for dense matrices


PIECE = 0.1  # largest step of a coordinate, rad or relative to the size of the mechanism
ITERATIONS = 30
CLOSED = 1e-12  # closure tolerance / size of the mechanism
FAR = 1e3  # largest useful step / size of the mechanism
REACHED = 1e-9  # largest difference of rates that count as equal, relative to the largest velocity


def quiet_velocities(model: Model, engine: Engine, given: Array) -> Array | None:
    """Return velocities v (nv,) that satisfy joints and drives with the least modal velocities.

    Velocities that violate the constraints (for example of a machine at rest with moving drives)
    are corrected by dv with ``Cq dv = -(Cq v + C_t)``. Of all such dv, those with the least
    ``|dp'|`` are selected, zero if the rigid mechanism can follow, and of these the one of least
    kinetic energy ``dv^T M dv``. The nearest velocities in the mass metric would be those after an
    impact, with vibration of the modes from the start. Mechanisms of more than `MOST` velocities or
    constraint rows keep the nearest velocities, with a warning.

    Parameters
    ----------
    model : Model
    engine : Engine
        Engine at the closed position, with the velocities nearest in the mass metric.
    given : (nv,) array
        Given velocities.

    Returns
    -------
    array or None
        None if no modal velocities would change, if the mechanism is too large, or if velocities
        were given: given velocities keep their momentum, with the resulting modal velocities.
    """
    if np.any(given):
        return None
    modal = modal_velocities(model)
    if not modal.any():
        return None
    nearest = np.array(engine.v)
    metres = velocity_metres(model)
    changed = float(np.abs((nearest * metres)[modal]).max(initial=0.0))
    if changed <= SAME * largest_speed(model, nearest):
        return None
    if model.nv > MOST or model.nrow > MOST:
        warn(
            "start",
            f"velocities that violate the joints were corrected as by an impact, so that the "
            f"modes vibrate from time 0, because {model.nv} velocities and {model.nrow} rows "
            f"exceed the limit {MOST} of the correction without vibration; let drives begin at "
            f"rest (SCurve), give consistent initial velocities, or start from "
            f"jo.simulation.vibration_free_state(model) or, for a rotation about one axis, "
            f"jo.simulation.steady_rotation(model, axis, speed)",
        )
        return None
    Cq = constraint_matrix(model, engine)
    engine.v[:] = given
    asked = -np.array(engine.constraints()[1][: len(Cq)])
    engine.v[:] = nearest
    dv = least_motion(model, engine, Cq, asked)
    if dv is None:
        return None
    engine.v[:] = dv
    fits = engine.residuals()[1] <= FITS * largest_speed(model, dv)
    engine.v[:] = nearest
    return dv if fits else None


def least_motion(model: Model, engine: Engine, Cq: Array, asked: Array) -> Array | None:
    """Return dv (nv,) of least norm with ``Cq dv = asked`` and the least modal velocities.

    Of all least-squares solutions, those with the least ``|dp'|`` are selected, and of these the
    one of least ``dv^T M dv``. The same applies to increments of the position. None if a body has
    no mass.

    Parameters
    ----------
    model : Model
    engine : Engine
        Engine at the position of Cq.
    Cq : (rows, nv) array
        Jacobian for [R' (world), w_local, p'] of every body.
    asked : (rows,) array
    """
    modal = modal_velocities(model)
    try:
        L, coupling = _masses(model, engine, modal)
    except np.linalg.LinAlgError:  # a body without mass
        return None
    # rows of length 1 in the mass metric of the rigid motions, dv = L^-T x
    weighted = scipy.linalg.solve_triangular(L, Cq[:, ~modal].T, lower=True).T
    length = np.linalg.norm(weighted, axis=1)
    length = np.where(length > 0.0, length, 1.0)
    weighted, elastic, asked = (
        weighted / length[:, None],
        Cq[:, modal] / length[:, None],
        asked / length,
    )
    # the part that rigid motions cannot provide is assigned to the modes
    U, s, Vt = np.linalg.svd(weighted, full_matrices=True)
    rank = int((s > RANK).sum())
    left = U[:, rank:].T
    need = left @ asked
    dp = np.zeros(int(modal.sum()))
    if np.abs(need).max(initial=0.0) > SAME * float(np.abs(asked).max(initial=0.0)):
        dp = scipy.linalg.lstsq(left @ elastic, need, cond=RANK)[0]
    # least dv^T M dv = |L^T dv + L^-1 M_rp dp|^2 + a term of dp only
    shift = scipy.linalg.solve_triangular(L, coupling @ dp, lower=True)
    wanted = asked - elastic @ dp + weighted @ shift
    x = Vt[:rank].T @ ((U[:, :rank].T @ wanted) / s[:rank])
    dv = np.zeros(model.nv)
    dv[modal] = dp
    dv[~modal] = scipy.linalg.solve_triangular(L, x - shift, lower=True, trans="T")
    return dv


def modal_velocities(model: Model) -> NDArray[np.bool_]:
    """Return a mask (nv,) of the modal velocities."""
    modal = np.zeros(model.nv, dtype=bool)
    for body in model.bodies:
        modal[body.iv + 6 : body.iv + 6 + body.n] = True
    return modal


def _masses(model: Model, engine: Engine, modal: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return the Cholesky factor of M_rr, and M_rp; r: [R' (world), w (local)], p: p'."""
    nr, place = int((~modal).sum()), np.cumsum(~modal) - 1
    column = np.cumsum(modal) - 1
    L, coupling = np.zeros((nr, nr)), np.zeros((nr, int(modal.sum())))
    for i, body in enumerate(model.bodies):
        M = np.array(engine.mass_matrix(i))
        A = rotation_matrix(engine.q[body.iq + 3 : body.iq + 7])
        M[:3] = A @ M[:3]  # R'' of the engine's matrix is resolved in the body frame
        M[:, :3] = M[:, :3] @ A.T
        rows = slice(place[body.iv], place[body.iv] + 6)
        L[rows, rows] = np.linalg.cholesky(M[:6, :6])
        if body.n:
            first = column[body.iv + 6]
            coupling[rows, first : first + body.n] = M[:6, 6:]
    return L, coupling


def started(model: Model, initials: Sequence[Initial], builder: Builder) -> Model:
    """Return the model with the pose and the velocities that given values and rates require.

    The pose follows from ``C(q, 0) = 0`` together with the coordinates, the velocities from
    ``Cq v = -C_t`` together with the rates: increments and velocity changes with the least modal
    part, and of these those of least kinetic energy.

    Parameters
    ----------
    model : Model
        Model at the declared pose of the bodies.
    initials : sequence of Initial
    builder : Builder
        Builder with the coordinates of the model.

    Raises
    ------
    InputError
        If a value cannot be reached or rates contradict the joints, the drives or one another.
    """
    if model.nv > MOST:
        raise InputError(
            Problem(
                f"initial {initials[0].name!r}",
                f"the mechanism has {model.nv} velocities, more than {MOST}, the limit for "
                f"initial values of coordinates; give the bodies their pose and velocities instead",
            )
        )
    values = [s for s in initials if s.value is not None]
    rates = [s for s in initials if s.rate is not None]
    if values:
        before = gear_angles(model)
        model.q0[:] = _pose(with_rows(model, held_lines(values, builder)), values)
        model = with_gears(model, gear_angles(model) - before)
    if rates:
        gears = _free_gears(model, {builder.declared(s.coordinate) for s in rates})
        lines = [*gears.values(), *held_lines(rates, builder)]
        model.v0[:] = _velocities(with_rows(model, lines), rates)
    return model


def gear_angles(model: Model) -> Array:
    """Return ``s - phi / N`` of each gear spring at the start, m or rad, within half a turn."""
    gears = gear_springs(model)
    if not gears:
        return np.zeros(0)
    rows = with_rows(model, [(force.name, gear_line(force)) for force in gears])
    return np.array(Engine(rows, implicit=False).constraints()[0][model.permanent :])


def with_gears(model: Model, moved: Array) -> Model:
    """Return the model whose gear springs have the same wind-up after their coordinates moved."""
    gears = iter(moved.tolist())
    forces = [
        replace(force, data=with_number(force, "free", numbers_of(force).free + next(gears)))
        if force.kind == "gear spring"
        else force
        for force in model.forces
    ]
    return replace(model, forces=tuple(forces)) if len(moved) else model


def _free_gears(model: Model, given: set[int]) -> dict[int, NamedLine]:
    """Return the gears, by motor, through which the rate of a joint sets that of its motor."""
    lines = [line for joint in model.joints for line in joint.lines]
    driven = {line.coordinates[0] for line in lines if len(line.coordinates) == 1}
    return {
        force.other: (force.name, gear_line(force))
        for force in gear_springs(model)
        if force.coordinate in given and force.other not in given | driven
    }


def held_lines(initials: Sequence[Initial], builder: Builder) -> list[NamedLine]:
    """Return the row ``s = 0`` of each coordinate."""
    return [(s.name, LineModel((builder.declared(s.coordinate),), (1.0,))) for s in initials]


def _pose(model: Model, initials: Sequence[Initial]) -> Array:
    """Return q (nq,) with closed joints and the given values of the coordinates."""
    engine = Engine(model, implicit=False)
    first = model.permanent - len(initials)
    goal = np.array([initial.value for initial in initials])
    # close the joints first if the declared pose is rough
    begin = np.array(engine.constraints()[0][first:])
    way = goal - begin
    sizes = np.abs(way) * engine.row_metres[first:] / model.size
    pieces = max(1, int(np.ceil(np.max(sizes) / PIECE)))
    for piece in range(1, pieces + 1):
        aim = begin + way * (piece / pieces)
        if not _close(model, engine, first, aim):
            raise InputError(_unreachable(model, engine, initials, int(sizes.argmax()), aim))
    return np.array(engine.q)


def _coordinate(joint: JointModel) -> int:
    return joint.lines[0].coordinates[0]


def _close(model: Model, engine: Engine, first: int, aim: Array) -> bool:
    """Close the joints with coordinates at given values; return whether the iteration converged."""
    kinds = (model.coordinates[_coordinate(j)].kind for j in model.joints[-len(aim) :])
    angles = np.array([kind == "angle" for kind in kinds])
    metres = velocity_metres(model)
    before = np.inf
    for _ in range(ITERATIONS):
        c = np.array(engine.constraints()[0])
        miss = c[first:] - aim
        c[first:] = np.where(angles, np.arctan2(np.sin(miss), np.cos(miss)), miss)
        gap = float(np.abs(c * engine.row_metres).max())
        if gap <= CLOSED * model.size:
            return True
        if not gap < 10.0 * before:
            return False
        before = min(gap, before)
        step = least_motion(model, engine, constraint_matrix(model, engine), -c)
        if step is None or not np.abs(step * metres).max() < FAR * model.size:
            return False
        engine.q[:] = displaced(model, engine.q, step)
    return gap <= 1e3 * CLOSED * model.size


def _unreachable(
    model: Model, engine: Engine, initials: Sequence[Initial], which: int, aim: Array
) -> Problem:
    initial = initials[which]
    unit = initial.coordinate.unit
    value = initial.value or 0.0
    asked, reached = f"{value:g} {unit}", f"{aim[which]:.3g} {unit}"
    if unit == "rad":
        asked, reached = f"{np.degrees(value):g} deg", f"{np.degrees(aim[which]):.3g} deg"
    return Problem(
        f"initial {initial.name!r}",
        f"the value {asked} cannot be reached: on the way from the declared pose the joints, "
        f"drives and other values stop at {reached}; give a value within reach, or a declared "
        f"pose nearer to it",
    )


def _velocities(model: Model, initials: Sequence[Initial]) -> Array:
    """Return v (nv,) that satisfies joints, drives and rates, nearest to the given velocities."""
    engine = Engine(model, implicit=False)
    first = model.permanent - len(initials)
    rates = np.array([initial.rate for initial in initials])
    given = np.array(model.v0)
    asked = -np.array(engine.constraints()[1])
    asked[first:] += rates
    Cq = constraint_matrix(model, engine)
    dv = least_motion(model, engine, Cq, asked)
    if dv is None:
        return given
    engine.v[:] = given + dv
    asked = np.concatenate([np.zeros(first), rates]) * engine.row_metres
    miss = np.abs(engine.constraints()[1] * engine.row_metres - asked)
    speeds = (largest_speed(model, v) for v in (engine.v, given))
    scale = max(float(np.abs(asked).max()), *speeds)
    if miss.max() > REACHED * scale:
        raise InputError(_contradictions(model, engine, initials, miss[first:]))
    return np.array(engine.v)


def _contradictions(
    model: Model, engine: Engine, initials: Sequence[Initial], miss: Array
) -> Sequence[Problem]:
    """Return the rates that contradict one another or the joints."""
    share = np.linalg.norm(dependent_rows(model, engine), axis=1)
    problems = Problems()
    joints = model.joints[: -len(initials)]
    taking = [j for j in joints if share[j.row : j.row + j.rows].max(initial=0.0) > SHARE]
    drives = [f"drive '{j.name}'" for j in taking if is_drive(j)]
    rows = share[model.permanent - len(initials) :] > SHARE
    named = [f"the rate of '{s.name}'" for s, row in zip(initials, rows, strict=True) if row]
    for initial, row in zip(initials, rows, strict=True):
        if not row:
            continue
        others = [one for one in named if one != f"the rate of '{initial.name}'"]
        what = " and ".join([*others, *drives]) or "the joints, which prevent this motion"
        problems.add(
            f"initial {initial.name!r}",
            f"the rate {initial.rate:g} {initial.coordinate.unit}/s contradicts {what}; give only "
            f"as many rates as there are free motions",
        )
    if not problems.found:
        problems.add("initial rates", f"violate the joints by {miss.max():.3g} m/s")
    return tuple(problems.found)
