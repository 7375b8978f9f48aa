"""steady_rotation: relative equilibrium of a mechanism that turns at constant speed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.errors import Problems, SimulationError
from jousto.base.rotations import rotation_matrix
from jousto.model.model import Model
from jousto.simulation.second_order import where_noticed
from jousto.simulation.state import State, take
from jousto.simulation.statics.continuation import NoConvergenceError, Point, at_load
from jousto.simulation.statics.path_following import Walk
from jousto.simulation.statics.residual import SPEED, Balance

TORQUE = 1e-9  # torque over the moments of inertia forces and weight, below which it is round-off
NOISE = 64 * float(np.finfo(float).eps)  # round-off of a force over the largest stiffness
SAME = 1e-9  # variation of a force over a revolution / inertia forces, below which it is constant
FITS = 1e-6  # velocity residual over speed times size, below which joints and drives allow it


@explained
def steady_rotation(
    model: Model,
    axis: ArrayLike,
    speed: float,
    *,
    point: ArrayLike = (0.0, 0.0, 0.0),
    state: State | None = None,
    steps: int = 8,
) -> State:
    """Return the relative equilibrium of a mechanism that turns steadily about an axis.

    All bodies have the velocities ``R' = W x (R - o)``; the positions solve
    ``M a + Cq^T lam = Q`` with the accelerations ``W x (W x (R - o))`` of that motion, by Newton's
    method with the exact tangent (centrifugal, geometric and gyroscopic terms). Without a drive the
    azimuth of the state remains. `modes` with ``damped=True`` about the state returns frequencies
    in the turning frame, which `campbell` draws over the speed. Modal bodies have geometric
    stiffness, also if their parts were reduced without ``stiffening=True``; a run from the state
    needs parts reduced with it.

    Parameters
    ----------
    model : Model
        From `compile`.
    axis : (3,) array_like
        Direction of the axis, world frame.
    speed : float
        Speed, rad/s; if the rotation has a drive, the speed of the drive.
    point : (3,) array_like
        Point on the axis, m, world frame.
    state : State, optional
        Starting point; None: the initial state.
    steps : int
        Number of steps of the speed, from 0, if Newton's method fails at the full speed.

    Raises
    ------
    InputError
        If the axis or the speed is invalid.
    SimulationError
        If there is no such motion: joints or drives prescribe another one, a force depends on the
        azimuth (gravity across the axis), or the rotation needs a torque without a drive.
    """
    where = "steady_rotation"
    problems = Problems()
    problems.number(where, "speed", speed, "rad/s")
    problems.number(where, "steps", steps, "", "1 or more", lambda x: x >= 1)
    problems.raise_if_any()

    def balanced(of: Model) -> Balance:
        return Balance(of, SPEED, state, axis=axis, point=point, speed=float(speed), where=where)

    balance = balanced(model)
    turning = take(balance.at(balance.engine.q, balance.engine.lam, float(speed)))
    stiffening = where_noticed(model, turning, where)
    if stiffening is not model:
        model, balance = stiffening, balanced(stiffening)
    walk = Walk(balance, 0.0, float(speed) or 1.0, int(steps))
    nrow = model.nrow + balance.gauge
    lam = np.concatenate([balance.engine.lam, np.zeros(int(balance.gauge))])[:nrow]
    guess = Point(np.array(balance.engine.q), lam, float(speed))
    try:
        found = at_load(balance, guess, float(speed))
    except NoConvergenceError:
        if speed == 0.0:
            found = walk.begin()
        else:
            walk.run()
            found = walk.points[-1]
    _check(balance, found)
    out, _ = balance.accept(found.q, found.lam, float(speed))
    return replace(out, turn=None if not len(balance.engine.turn) else out.turn)


def _check(balance: Balance, at: Point) -> None:
    """Raise a SimulationError if the mechanism does not turn steadily at a point."""
    model, speed = balance.model, at.value
    engine = balance.at(at.q, at.lam, speed)
    gap = engine.constraints()[1] * engine.row_metres
    rate = max(abs(speed), 1e-300)
    if np.abs(gap).max(initial=0.0) > FITS * rate * model.size:
        row = int(np.argmax(np.abs(gap)))
        name = next(j.name for j in model.joints if j.row <= row < j.row + j.rows)
        raise SimulationError(
            f"joint or drive '{name}' does not allow a rotation of the whole mechanism with "
            f"{speed:g} rad/s about the axis; give the speed, axis and point of the drive, or a "
            "joint that allows the rotation",
            time=float(engine.time[0]),
            body=name,
        )
    assert balance.axis is not None
    M = balance.mass(at.q, at.lam, speed)
    noise = NOISE * float(abs(balance.matrix(at.q, at.lam, speed)).max()) * model.size
    turns = np.concatenate([np.arange(b.iv + 3, b.iv + 6) for b in model.bodies])
    total = sum(float(np.real(b.mass[0])) for b in model.bodies)
    if balance.gauge:
        # missing torque: work of the residual in a rotation of the whole mechanism by 1 rad
        spin = balance.spin(at.q)
        torque = -float(at.lam[-1]) * float(spin @ spin)
        inertia = float(M.diagonal() @ (spin * spin))
        moments = speed * speed * inertia
        moments += float(np.linalg.norm(model.gravity)) * float(np.sqrt(inertia * total))
        if abs(torque) > TORQUE * moments + noise * model.size:
            raise SimulationError(
                f"the rotation needs a torque of {torque:.4g} N m to stay steady, and has no "
                "drive; add a Drive with that speed, or remove the brake",
                time=float(engine.time[0]),
            )
    # compare the accelerations after a rotation of the whole mechanism
    half = 0.5  # half of the rotation angle, rad
    turn = np.concatenate([[np.cos(half)], np.sin(half) * balance.axis])
    Q = rotation_matrix(turn)
    q = np.array(at.q)
    for b in model.bodies:
        q[b.iq : b.iq + 3] = balance.point + Q @ (q[b.iq : b.iq + 3] - balance.point)
        s, v = q[b.iq + 3], q[b.iq + 4 : b.iq + 7].copy()
        q[b.iq + 3] = turn[0] * s - turn[1:] @ v
        q[b.iq + 4 : b.iq + 7] = turn[0] * v + s * turn[1:] + np.cross(turn[1:], v)
    later = balance.at(q, at.lam, speed)
    wanted, time = np.array(later.a), float(later.time[0])
    if speed:
        later.time[0] = time + 2.0 * half / speed
    found = np.array(later.accelerations()[0])  # copy, since the array of the engine changes below
    later.time[0] = time
    change = np.abs(balance.mass(q, at.lam, speed) @ (found - wanted))
    change[turns] /= model.size
    scale = total * (float(np.abs(wanted).max(initial=0.0)) + float(np.linalg.norm(model.gravity)))
    if change.max(initial=0.0) > SAME * scale + noise:
        worst = int(np.argmax(change))
        body = next(b.name for b in model.bodies if b.iv <= worst < b.iv + 6 + b.n)
        raise SimulationError(
            f"no steady rotation: the force on body '{body}' changes with the azimuth; remove "
            "gravity across the axis, loads fixed in space, and springs to the ground beside "
            "the axis",
            time=time,
            body=body,
        )
