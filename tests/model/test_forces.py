"""Springs, bushings, loads and user functions: virtual work, energy balance, failures."""

from __future__ import annotations

import ctypes
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism.signals.base import Constant, Input
from jousto.mechanism.signals.harmonic import Harmonic
from jousto.mechanism.signals.piecewise import Ramp, SCurve, Table
from jousto.model.model import CoordinateModel, ForceModel, MarkerModel, SensorModel
from jousto.model.native.native import displaced
from jousto.model.packing.builder import Builder

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*nothing will move")

RNG = np.random.default_rng(5)
K = np.diag([900.0, 700.0, 500.0, 30.0, 40.0, 50.0]) + 5.0
DAMPING = 0.02 * K
PRELOAD = np.array([3.0, -2.0, 1.0, 0.4, 0.3, -0.2])


def bushing(damping=0.0):
    data = np.concatenate([K.ravel(), damping * DAMPING.ravel(), PRELOAD])
    return ForceModel("bush", "bushing", data, a=0, b=1)


def spring(coordinate, damping=0.0):
    data = np.array([300.0, damping, 0.7, 5.0, 0.0])
    return ForceModel("spring", "along", data, coordinate=coordinate)


def gear(damping=0.4):
    """Return a gear spring between a displacement and an angle."""
    return ForceModel(
        "gear", "gear spring", np.array([300.0, damping, -3.0, 0.1]), coordinate=1, other=2
    )


def two_bodies(*forces, spin=0.0):
    """Two free bodies, not aligned, and coordinates 0 distance, 1 along z, 2 angle."""
    turn = np.array([0.9, 0.2, -0.3, 0.1])
    a = jo.RigidBody("a", 2.0, (0.08, 0.2, 0.25), center=(0.1, 0, 0))
    b = jo.RigidBody(
        "b",
        1.0,
        (0.03, 0.12, 0.13),
        position=(0.6, 0.3, 0.2),
        orientation=turn / np.linalg.norm(turn),
        angular_velocity=(0, 0, spin),
    )
    model = jo.compile(jo.Mechanism(a, b))
    points = [(0, (0.2, 0.1, 0.0)), (1, (-0.1, 0.05, 0.15))]
    markers = tuple(MarkerModel(i, True, np.array(u), np.eye(3), None, None) for i, u in points)
    kinds = ("distance", "along", "angle")
    coordinates = tuple(CoordinateModel(kind, kind, 0, 1) for kind in kinds)
    return replace(model, markers=markers, active=2, coordinates=coordinates, forces=forces)


def virtual_work(engine, dx):
    """Work of the applied forces on the displacement dx of bodies at rest."""
    a, _ = engine.accelerations()
    work = 0.0
    for i, body in enumerate(engine.model.bodies):
        A = jo.base.rotations.rotation_matrix(engine.q[body.iq + 3 : body.iq + 7])
        part = slice(body.iv, body.iv + 6)
        local, moved = a[part].copy(), dx[part].copy()
        local[:3], moved[:3] = A.T @ local[:3], A.T @ moved[:3]
        work += moved @ engine.mass_matrix(i) @ local
    return work


@pytest.mark.parametrize("force", [bushing(), spring(0), spring(1), spring(2), gear(0.0)])
def test_forces_are_the_gradient_of_the_stored_energy(force):
    model = two_bodies(force)
    real, exact = jo.model.Engine(model), jo.model.Engine(model, complex_scalars=True)
    for dx in RNG.normal(size=(4, model.nv)):
        exact.q[:] = displaced(model, model.q0.astype(complex), 1e-30j * dx)
        gradient = exact.energy()[3].imag / 1e-30
        assert abs(gradient) > 0.1
        np.testing.assert_allclose(virtual_work(real, dx), -gradient, rtol=1e-11)


def test_a_force_between_bodies_neither_pushes_nor_turns_the_whole():
    given = np.array([3.0, -1.0, 2.0, 0.5, 0.2, -0.7])
    model = two_bodies(ForceModel("f", "user", np.zeros(1), a=0, b=1, function=lambda t, x: given))
    engine = jo.model.Engine(model)
    for axis in np.eye(3):
        push, turn = np.zeros(model.nv), np.zeros(model.nv)
        for body in model.bodies:
            e = model.q0[body.iq + 3 : body.iq + 7]
            push[body.iv : body.iv + 3] = axis
            turn[body.iv : body.iv + 3] = np.cross(axis, model.q0[body.iq : body.iq + 3])
            turn[body.iv + 3 : body.iv + 6] = jo.base.rotations.rotation_matrix(e).T @ axis
        assert abs(virtual_work(engine, push)) < 1e-13
        assert abs(virtual_work(engine, turn)) < 1e-13


@pytest.mark.parametrize("method", ["rk4", "ros2"])
@pytest.mark.parametrize("force", [bushing(1.0), spring(0, 4.0), spring(2, 0.2), gear()])
def test_the_energy_balance_closes_with_the_step(method, force):
    model = two_bodies(force, spin=25.0)
    first = 1 + model.nq + model.nv + model.nrow
    error = []
    for step in (1e-3, 5e-4):
        engine = jo.model.Engine(model)
        solver = engine.native_solver(method, step, True)
        start = engine.row()[first : first + 4].sum()
        for _ in range(round(0.2 / step)):
            engine.step(solver)
        row = engine.row()[first : first + 7]
        assert row[4] > 1e-3
        error.append(abs(row[:5].sum() - row[6] - start))
    assert error[1] < 1e-2
    assert error[1] < 0.3 * error[0]


def user(function):
    return two_bodies(ForceModel("wind", "user", np.zeros(1), a=0, b=1, function=function))


def broken(time, x):
    raise RuntimeError("no wind tunnel")


@pytest.mark.parametrize(
    ("function", "sentence"),
    [
        (broken, "'wind': its function raised RuntimeError: no wind tunnel"),
        (lambda t, x: [np.nan] * 6, "'wind': its function .* not finite"),
        (lambda t, x: [1.0], r"its function returned an array of shape \(1,\), must be \(6,\)"),
    ],
)
def test_a_user_function_that_fails_is_named(function, sentence):
    with pytest.raises(jo.SimulationError, match=sentence):
        jo.model.Engine(user(function)).accelerations()
    with pytest.raises(jo.SimulationError, match=sentence):
        jo.simulate(user(function), t_end=0.1, solver=jo.RK4(step=1e-3))


def test_compiled_and_python_functions_give_the_same_motion():
    signature = ctypes.CFUNCTYPE(
        ctypes.c_int,
        ctypes.c_double,
        ctypes.POINTER(ctypes.c_double),
        ctypes.POINTER(ctypes.c_double),
        ctypes.c_void_p,
    )

    @signature
    def compiled(time, x, y, user):
        for i in range(3):
            y[i] = -10.0 * x[i] - time
        return 0

    def plain(time, x):
        return np.concatenate([-10.0 * x[:3] - time, np.zeros(3)])

    one, two = jo.model.Engine(user(compiled)), jo.model.Engine(user(plain))
    one.time[:] = two.time[:] = 0.5
    np.testing.assert_array_equal(one.accelerations()[0], two.accelerations()[0])
    assert np.abs(one.a).max() > 1.0


@pytest.mark.parametrize(
    "signal",
    [
        Constant(2.5),
        Ramp(0.2, 0.8, 1.0, 3.0),
        SCurve((0.0, 0.5, 0.9), (0.0, 2.0, -1.0)),
        Table((0.0, 0.3, 0.6, 0.9), (1.0, 4.0, -2.0, 0.5), "cubic"),
        Table((0.3,), (4.0,), "cubic"),
        Harmonic(frequency=2.0, amplitude=3.0) * Ramp(0.2, 0.8) - 0.5 + Constant(1.0),
    ],
)
def test_signals_are_the_same_in_the_engine(signal):
    builder = Builder({})
    place = builder.signal(signal)
    sensor = SensorModel("s", "signal", place, 0, 1, "1", "world", "", ("",))
    model = replace(two_bodies(), signals=tuple(builder.signals), sensors=(sensor,))
    engine = jo.model.Engine(model)
    for time in np.linspace(-0.1, 1.1, 25):
        engine.time[:] = time
        np.testing.assert_allclose(engine.sensors()[0], signal(time), atol=1e-13)


def test_inputs_of_one_name_are_one():
    builder = Builder({})
    place = builder.signal(2.0 * Input("u", 0.5) + Input("u", 0.5))
    sensor = SensorModel("s", "signal", place, 0, 1, "1", "world", "", ("",))
    model = replace(two_bodies(), signals=tuple(builder.signals), sensors=(sensor,))
    assert model.inputs == ("u",)
    engine = jo.model.Engine(model)
    assert engine.sensors()[0] == 1.5
    engine.input[0] = 2.0
    assert engine.sensors()[0] == 6.0


def test_a_ramp_has_no_rate_before_and_after_it():
    """A servo that only damps has the force c r' of a reference r."""
    body = jo.RigidBody("body", 2.0, (1.0,) * 3)
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    ramp = jo.Ramp(1.0, 3.0, before=0.5, after=4.5)
    servo = jo.Servo("servo", slide.displacement, ramp, kp=0.0, kd=3.0)
    engine = jo.model.Engine(jo.compile(jo.Mechanism(body, slide, servo)))
    found = []
    for time in (0.5, 1.5, 2.9, 3.5):
        engine.time[0] = time
        found.append(engine.accelerations()[0][0])
    assert found == pytest.approx([0.0, 3.0, 3.0, 0.0], abs=1e-12)


def test_laws_are_known_to_a_process_that_only_reads_models():
    """A model of another process: no module that declares its forces is loaded here."""
    code = (
        "from jousto.mechanism.forces.law import law_of; print(law_of('gear spring').side_by_side)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "True"
