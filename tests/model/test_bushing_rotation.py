"""Rotations of a bushing, small and large, against power series of matrices.

The engine takes short series where angles are small, and closed forms elsewhere. Here the rotation
vector t is given, the rotation is exp(t~) and its derivative the left Jacobian
``sum t~^k / (k + 1)!`` (T. D. Barfoot, State Estimation for Robotics, 2017, chapter 7), summed to
its end.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from verification.particles import skew

AXIS = np.array([2.0, -3.0, 6.0]) / 7.0
# both sides of the angles at which the engine changes its formula, 0.063 and 0.1 rad
ANGLES = [1e-9, 1e-4, 0.03, 0.0632, 0.0633, 0.0999, 0.1001, 0.7, 3.0]
STIFFNESS = np.array(
    [
        [9.0, 0.0, 0.0, 1.0, 0.5, 0.2],
        [0.0, 7.0, 0.0, 0.3, 1.0, 0.4],
        [0.0, 0.0, 8.0, 0.1, 0.6, 1.0],
        [1.0, 0.3, 0.1, 30.0, 4.0, 5.0],
        [0.5, 1.0, 0.6, 4.0, 40.0, 6.0],
        [0.2, 0.4, 1.0, 5.0, 6.0, 50.0],
    ]
)
INERTIA = np.array([0.3, 0.35, 0.4])
SPIN = np.array([0.8, 0.3, -0.5])


def left_jacobian(t: np.ndarray) -> np.ndarray:
    """Derivative of exp(t~): ``(exp(t~))' = (J t')~ exp(t~)``."""
    term, total = np.eye(3), np.eye(3)
    for k in range(1, 60):
        term = term @ skew(t) / (k + 1)
        total = total + term
    return total


def accelerations(angle: float, stiffness: np.ndarray, damping: np.ndarray, spin: np.ndarray):
    """Return accelerations (6,) of a body turned by the angle, and its rotation from the ground."""
    turn = Rotation.from_rotvec(angle * AXIS)
    body = jo.RigidBody(
        "body",
        2.0,
        tuple(INERTIA),
        orientation=turn.as_quat(scalar_first=True),
        angular_velocity=spin,
    )
    bush = jo.Bushing("bush", jo.ground["origin"], body["origin"], stiffness, damping)
    return jo.model.Engine(jo.compile(jo.Mechanism(body, bush))).accelerations()[
        0
    ], turn.as_matrix()


@pytest.mark.parametrize("angle", ANGLES)
def test_the_torque_does_the_work_of_the_rotation_vector(angle: float) -> None:
    t = angle * AXIS
    found, A = accelerations(angle, STIFFNESS, np.zeros((6, 6)), np.zeros(3))
    load = -STIFFNESS[:, 3:] @ t
    # load . t' = torque . w with w = J t'
    torque = np.linalg.solve(left_jacobian(t).T, load[3:])
    expected = np.concatenate([load[:3] / 2.0, A.T @ torque / INERTIA])
    # round-off of some dozens of sums and of the orientation
    assert found == pytest.approx(expected, rel=0.0, abs=1e-14 * np.abs(expected).max())


@pytest.mark.parametrize("angle", ANGLES)
def test_damping_takes_the_angular_velocity(angle: float) -> None:
    found, A = accelerations(angle, np.zeros((6, 6)), STIFFNESS, SPIN)
    load = -STIFFNESS[:, 3:] @ SPIN
    # Euler's equations in the axes of the body
    w = A.T @ SPIN
    torque = A.T @ load[3:] - np.cross(w, INERTIA * w)
    expected = np.concatenate([load[:3] / 2.0, torque / INERTIA])
    assert found == pytest.approx(expected, rel=0.0, abs=1e-14 * np.abs(expected).max())


BEGUN = [0.0, 45.0, 90.0, 170.0]


@pytest.mark.parametrize("degrees", BEGUN)
@pytest.mark.parametrize("core", ["maximal", "joint"])
@pytest.mark.parametrize("solver", [jo.RK4(1e-3), jo.GeneralizedAlpha(1e-3)], ids=["RK4", "alpha"])
def test_an_isotropic_damper_brakes_a_ball_as_it_turns_at_any_attitude(degrees, core, solver):
    """``I w' = -c w``: ``w = w0 exp(-c t / I)``, about the axis of w0 for ever."""
    mechanism = braked(degrees)
    run = jo.simulate(jo.compile(mechanism, core=core), 2.0, solver=solver)
    # 3 rad/s exp(-1); order 2 of generalised alpha at 1 ms: (c h / I)^2 / 12 a time constant
    assert run["spin"][-1] == pytest.approx([0.0, 0.0, 3.0 * np.exp(-1.0)], abs=1e-6)
    lost = 0.5 * 0.1 * 9.0 * (1.0 - np.exp(-2.0))
    assert run.energy.dissipated[-1] == pytest.approx(lost, rel=1e-6)


def braked(degrees: float) -> jo.Mechanism:
    """A ball of 0.1 kg m2 on a pivot with a damper of 0.05 N m s, turned about an oblique axis."""
    ball = jo.RigidBody(
        "ball",
        1.0,
        (0.1, 0.1, 0.1),
        orientation=jo.Rotate((1.0, 2.0, -0.5), degrees=degrees),
        angular_velocity=(0, 0, 3.0),
    )
    pivot = jo.Spherical("pivot", jo.ground["origin"], ball["origin"])
    damping = (0, 0, 0, 0.05, 0.05, 0.05)
    damper = jo.Bushing("damper", jo.ground["origin"], ball["origin"], np.zeros(6), damping)
    return jo.Mechanism(ball, pivot, damper, jo.AngularVelocitySensor("spin", ball["origin"]))


@pytest.mark.parametrize(
    "degrees", [pytest.param(d, marks=pytest.mark.slow) if d < 170 else d for d in BEGUN]
)
def test_both_formulations_brake_alike(degrees):
    assert jo.verify(braked(degrees), 0.5, step=1e-2).agrees


def test_newtons_matrix_does_not_jump_where_its_formula_changes():
    """Between angles 2e-12 rad apart, on both sides of 0.1 rad; round-off is 1e-13."""
    found = []
    for angle in (0.1 - 1e-12, 0.1 + 1e-12):
        turn = Rotation.from_rotvec(angle * AXIS).as_quat(scalar_first=True)
        body = jo.RigidBody("body", 2.0, tuple(INERTIA), position=(0.3, 0.2, 0.1), orientation=turn)
        bush = jo.Bushing("bush", jo.ground["origin"], body["origin"], STIFFNESS, np.zeros((6, 6)))
        engine = jo.model.Engine(jo.compile(jo.Mechanism(body, bush)))
        found.append(engine.newton_matrix(0.0, 0.0, 1.0).copy())
    np.testing.assert_allclose(found[0], found[1], rtol=0, atol=1e-10 * np.abs(found[1]).max())
