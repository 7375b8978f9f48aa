"""Initial state of a machine: declared pose and velocities, or a given state."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array, skew
from jousto.base.errors import InputError, Problem
from jousto.base.rotations import rotation_matrix
from jousto.natural.equations.bodies import FRAME
from jousto.natural.equations.system import Machine
from jousto.simulation.state import State


def declared_state(machine: Machine) -> tuple[Array, Array]:
    """Return the declared coordinates and velocities (N,) of the bodies."""
    q, v = _empty(machine)
    for i, body in enumerate(machine.mechanism.bodies):
        n = len(body.modal_coordinates)
        A, w = rotation_matrix(body.orientation), skew(body.angular_velocity)
        _put(q[i], body.position, A, body.modal_coordinates[:n])
        _put(v[i], body.velocity, w @ A, body.modal_velocities[:n])
    return q.ravel(), v.ravel()


def state_of_engine(machine: Machine, state: State) -> tuple[Array, Array]:
    """Return coordinates and velocities (N,) of a state of the engine.

    Raises
    ------
    InputError
        If the state is that of another machine.
    """
    bodies = machine.mechanism.bodies
    modes = [len(body.modal_coordinates) for body in bodies]
    if len(state.q) != sum(7 + n for n in modes):
        where = f"moving frame of {machine.mechanism.name!r}"
        raise InputError(
            Problem(
                where,
                f"the state has {len(state.q)} positions, the mechanism "
                f"{sum(7 + n for n in modes)}; give a state of this mechanism",
            )
        )
    q, v = _empty(machine)
    iq = iv = 0
    for i, n in enumerate(modes):
        x, u = state.q[iq : iq + 7 + n], state.v[iv : iv + 6 + n]
        A = rotation_matrix(x[3:7])
        _put(q[i], x[:3], A, x[7:])
        _put(v[i], u[:3], A @ skew(u[3:6]), u[6:])
        iq, iv = iq + 7 + n, iv + 6 + n
    return q.ravel(), v.ravel()


def angles(machine: Machine) -> Array:
    """Return the scalar functions (ns,) at the declared pose, the reference of angles."""
    pose = machine.frames.evaluate(declared_state(machine)[0])
    return machine.scalars.values(pose.y, np.zeros(machine.scalars.count))


def _empty(machine: Machine) -> tuple[Array, Array]:
    shape = (len(machine.bodies.mass), machine.bodies.width)
    return np.zeros(shape), np.zeros(shape)


def _put(row: Array, R: Array, A: Array, modes: Array) -> None:
    row[:3] = R
    row[3:FRAME] = A.T.ravel()
    row[FRAME : FRAME + len(modes)] = modes
