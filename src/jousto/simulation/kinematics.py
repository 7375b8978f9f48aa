"""kinematics, inverse_dynamics: motion of fully driven mechanisms, and forces of their drives."""

from __future__ import annotations

import time as clock
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, SimulationError
from jousto.model.model import Model
from jousto.model.native.header import places
from jousto.model.native.native import Engine, displaced
from jousto.model.packing.foreign import without_fmus
from jousto.model.rank.redundancy import RANK, null_space, repeated_rows, unit_rows
from jousto.simulation.controllers import without_controllers
from jousto.simulation.results.memory import Keeper
from jousto.simulation.results.solution import Solution
from jousto.simulation.statics.quasi_static_shape import Bending

TURN = 0.5  # largest rotation of a body between two assembled positions, rad
STRAY = 0.2  # largest rotation between the predicted and the assembled position, rad
SHORTEST = 1e-7  # shortest time step over the span of the instants
CLOSED = 1e-9  # gap over the size of the mechanism, below which a joint is closed
SOFT = "the elastic bodies are too soft for a quasi-static shape in this motion, run simulate"
UNKNOWN = ("dissipated", "friction", "work")  # integrals over time, not computed


@explained
def kinematics(model: Model, times: ArrayLike, *, path: str | Path | None = None) -> Solution:
    """Return the motion of a fully driven mechanism at given times, without integration.

    At each instant the positions solve ``C(q, t) = 0``, the velocities ``Cq v = -C_t``, and the
    accelerations and multipliers the equations of motion, so that errors do not accumulate. The
    positions are predicted from the previous ones; long intervals are divided to stay on the same
    branch and to count revolutions. Elastic bodies bend under the loads and the inertia of the
    motion, ``M a + Cq^T lam = Q`` with the smallest p' and p'' that satisfy the drives, but do not
    vibrate. This is accurate if the drives are smooth and slow compared with the lowest mode;
    otherwise use `simulate`.

    Parameters
    ----------
    model : Model
        From `compile`; drives, joints and couplings prescribe every motion.
    times : array_like
        Instants, s, increasing.
    path : path, optional
        Results file (HDF5), overwritten; None keeps the results with the returned object, whose
        ``save(path)`` writes them.

    Returns
    -------
    Solution
        Results at the instants, with sensors and multipliers. The terms dissipated, friction and
        work of the energy balance are integrals over time and are nan.

    Raises
    ------
    InputError
        If the times are invalid, a motion has no drive, or the file cannot be written.
    SimulationError
        If the mechanism cannot follow its drives: it is fully extended, or a drive jumps.
    """
    instants = _instants(model, times)
    _check_driven(model)
    return _write(model, instants, path)


@explained
def inverse_dynamics(model: Model, times: ArrayLike, *, path: str | Path | None = None) -> Solution:
    """Return the motion and the drive forces of a fully driven mechanism at given times.

    The solution is that of `kinematics`: the forces at an instant follow from the motion at this
    instant; elastic bodies bend but do not vibrate. The force of the drive with the row
    ``r = joint.row`` in ``model.joints`` along its coordinate is
    ``-solution.multipliers[:, r]``, N or N m; ``ReactionSensor(name, drive)`` gives the same by
    name. For forces with vibrations use `simulate`.

    Parameters
    ----------
    model, times, path
        As for `kinematics`.

    Returns
    -------
    Solution
        As from `kinematics`.

    Raises
    ------
    InputError, SimulationError
        As for `kinematics`; InputError also if there is no drive.
    """
    _instants(model, times)
    if not any(line.signal >= 0 for joint in model.joints for line in joint.lines):
        raise InputError(
            Problem(
                "inverse_dynamics", "the mechanism has no drive; add Drive(name, coordinate, s)"
            )
        )
    return kinematics(model, times, path=path)


def _instants(model: Any, times: Any) -> Array:
    problems = Problems()
    where = "kinematics"
    if not isinstance(model, Model):
        problems.add(where, f"model is a {type(model).__name__}, must be a Model from compile")
    found = np.zeros(0)
    try:
        found = np.atleast_1d(np.asarray(times, dtype=np.float64))
    except (TypeError, ValueError):
        problems.add(where, "times must be numbers, s")
    else:
        if found.ndim != 1 or not len(found) or not np.isfinite(found).all():
            problems.add(where, "times must be a list of finite numbers, not empty, s")
        elif (np.diff(found) <= 0.0).any():
            k = int(np.argmax(np.diff(found) <= 0.0))
            problems.add(
                where,
                f"times must increase, but {found[k]:g} s is followed by {found[k + 1]:g} s",
            )
    problems.raise_if_any()
    return found


def _check_driven(model: Model) -> None:
    """Raise an error for forces that depend on the previous motion, and for undriven motions."""
    without_fmus(model, "kinematics", "moves by forces")
    without_controllers(model, "kinematics")
    problems = Problems()
    for friction in model.frictions:
        if friction.sticks:
            problems.add(
                f"friction '{friction.name}'",
                "sticks and slips, which kinematics does not support; give it law=Regularised(), "
                "or run simulate",
            )
    for force in model.forces:
        if force.law.yields:
            problems.add(
                f"force '{force.name}'",
                "yields, so that its force depends on all of the motion before, which kinematics "
                "does not follow between the instants; run simulate",
            )
    problems.raise_if_any()
    Cq = unit_rows(model, Engine(model)) if model.permanent else np.zeros((0, model.nv))
    N = null_space(Cq)
    modal = [body.iv + 6 + j for body in model.bodies for j in range(body.n)]
    bending = int((np.linalg.svd(N[:, modal], compute_uv=False) > RANK).sum()) if modal else 0
    free = len(N) - bending
    if free:
        raise InputError(
            Problem(
                f"kinematics {model.name!r}",
                f"the mechanism has {free} motion{'s' * (free > 1)} without a drive at the initial "
                "pose; add a Drive for each, or run simulate, which computes the motion from the "
                "forces",
            )
        )


def _write(model: Model, instants: Array, path: str | Path | None) -> Solution:
    gaps = np.diff(instants)
    attributes = {
        "solver": "kinematics",
        "step": float(gaps.min()) if len(gaps) else 0.0,
        "t_end": float(instants[-1]),
        "gravity": model.gravity,
        "evaluations_per_step": 1,
    }
    first = 1 + model.nq + model.nv + model.nrow
    unknown = [first + places("jo_diagnostics")[name].start for name in UNKNOWN]
    keeper = Keeper(path, model, len(instants), attributes)
    started = clock.perf_counter()

    def close(ended: str) -> Solution:
        facts = {"ended": ended, "wall_time": clock.perf_counter() - started}
        return keeper.close(ended == "completed", facts)

    try:
        for row in positions(model, instants):
            row[unknown] = np.nan
            keeper.append(row[None])
    except BaseException as error:
        close(f"failed: {error}")
        keeper.discard()
        raise
    return close("completed")


def positions(model: Model, instants: Array) -> Iterator[Array]:
    """Yield the engine's row of each instant, starting from the initial pose at time 0."""
    engine = Engine(model)
    bending = Bending(model) if any(body.n for body in model.bodies) else None
    if not _close(engine, bending):
        raise SimulationError(f"the quasi-static deformation did not converge; {SOFT}", time=0.0)
    span = max(float(np.abs(instants).max()), float(np.ptp(instants)))
    piece = np.inf
    for instant in instants:
        while engine.time[0] != instant:
            left = float(instant - engine.time[0])
            h = float(np.sign(left)) * min(abs(left), piece, _reach(model, engine.v))
            while not _advance(
                model, engine, bending, instant if h == left else engine.time[0] + h
            ):
                h *= 0.5
                if abs(h) < SHORTEST * span:
                    raise SimulationError(
                        f"the mechanism cannot follow its drives past {engine.time[0]:.6g} s: "
                        + _obstacle(model)
                        + (f"; or {SOFT}" if bending else ""),
                        time=float(engine.time[0]),
                    )
            piece = 2.0 * abs(h)
        yield np.array(engine.row())


def _obstacle(model: Model) -> str:
    """Return why a mechanism cannot follow its drives, with the remedy."""
    found = repeated_rows(model) if model.redundant else None
    if found and found.drives:
        names = ", ".join(f"'{name}'" for name in found.joints)
        return f"{names} contradict one another from there on; give each motion one drive only"
    return (
        "it is fully extended or at a dead centre there, or a drive jumps; keep the drives within "
        "the limits of the lengths"
    )


def _reach(model: Model, v: Array) -> float:
    """Return the time in which the fastest body rotates by TURN, s."""
    fastest = max(float(np.linalg.norm(v[b.iv + 3 : b.iv + 6])) for b in model.bodies)
    return TURN / max(fastest, 1e-300)


def _close(engine: Engine, bending: Bending | None) -> bool:
    """Solve for q, v, a and lam at the time of the engine; False if the bending diverges."""
    if bending is None:
        engine.assemble()
    elif not bending.settle(engine):
        return False
    else:
        engine.assemble()  # positions are closed already; updates the revolution counters
    engine.accelerations()
    return True


def _advance(model: Model, engine: Engine, bending: Bending | None, instant: float) -> bool:
    """Assemble at an instant; if the step is too long, restore the state and return False."""
    views = (engine.q, engine.v, engine.a, engine.lam, engine.time, engine.turn)
    kept = [view.copy() for view in views]
    h = float(instant - engine.time[0])
    guess = displaced(model, engine.q, h * engine.v + 0.5 * h * h * engine.a)
    engine.q[:] = guess
    engine.time[0] = instant
    good = False
    try:
        good = (
            _close(engine, bending)
            and engine.residuals()[0] <= CLOSED * model.size
            and _turned(model, guess, engine.q) < STRAY
            and _turned(model, kept[0], engine.q) < 2.0 * TURN
        )
    except SimulationError:
        good = False
    if not good:
        for view, value in zip(views, kept, strict=True):
            view[:] = value
    return good


def _turned(model: Model, one: Array, other: Array) -> float:
    """Return the largest rotation angle of a body between two positions, rad."""
    largest = 0.0
    for body in model.bodies:
        parameters = slice(body.iq + 3, body.iq + 7)
        e, f = one[parameters], other[parameters]
        apart = min(float(np.linalg.norm(e - f)), float(np.linalg.norm(e + f)))  # 2 sin(angle / 4)
        largest = max(largest, 4.0 * float(np.arcsin(min(0.5 * apart, 1.0))))
    return largest
