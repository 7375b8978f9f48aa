"""Conservation laws and closed-form motions of free and pivoted bodies.

Momenta are sums over independent particles (`particles`), not the engine's own mass matrix.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipj

import jousto as jo
from verification.mechanisms import body_states, march, orders, particles_of, rod
from verification.particles import rotation

pytestmark = pytest.mark.filterwarnings("ignore:.*has no joint to another body")


def spinning(**state):
    return jo.FlexibleBody(
        "free",
        rod(),
        position=(0.3, -0.2, 0.5),
        orientation=jo.Rotate((1, 2, 3), degrees=50.0),
        velocity=(0.5, -1.0, 2.0),
        angular_velocity=(3.0, -4.0, 5.0),
        modal_velocities=0.3 * np.cos(np.arange(8)),
        **state,
    )


def momenta(body, model, run):
    particles = particles_of(body)
    return np.array(
        [
            np.concatenate(particles.momentum(*body_states(model, q, v)[0]))
            for q, v in zip(run.q, run.v, strict=True)
        ]
    )


@pytest.mark.parametrize(
    ("method", "steps"), [(jo.RK4, (500, 1000)), (jo.ROS2, (2000, 4000))], ids=["RK4", "ROS2"]
)
@pytest.mark.parametrize("zeta", [0.0, 0.05], ids=["undamped", "damped"])
def test_momenta_of_a_free_flexible_body_are_constant(method, steps, zeta):
    # internal forces, damping included, change neither momentum
    body = spinning(damping=zeta)
    model = jo.compile(jo.Mechanism(body))
    linear, angular = [], []
    for n in steps:
        run = march(model, method(step=0.25 / n), 0.25, 0.25 / 10)
        L = momenta(body, model, run)
        change = np.abs(L - L[0]) / np.abs(L[0]).max()
        linear.append(change[:, :3].max())
        angular.append(change[:, 3:].max())
    for errors in (linear, angular):
        assert errors[-1] < 1e-4
        # constant to the method's order, or already at round-off
        assert errors[-1] < 1e-12 or orders(errors)[-1] > method.order - 0.3, errors


def test_initial_momenta_are_those_of_the_declared_state():
    # velocity and angular velocity are given in the world frame
    body = spinning()
    model = jo.compile(jo.Mechanism(body))
    particles = particles_of(body)
    A = rotation(np.asarray(body.orientation))
    q = np.concatenate([[0.3, -0.2, 0.5], np.asarray(body.orientation), np.zeros(8)])
    v = np.concatenate([[0.5, -1.0, 2.0], A.T @ [3.0, -4.0, 5.0], 0.3 * np.cos(np.arange(8))])
    np.testing.assert_allclose(model.q0, q, rtol=0, atol=1e-15)
    np.testing.assert_allclose(model.v0, v, rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        jo.model.Engine(model).energy()[0], particles.kinetic(q, v), rtol=1e-12
    )


@pytest.mark.parametrize("method", [jo.RK4, jo.ROS2])
def test_a_body_dropped_at_rest_falls_along_the_parabola_undeformed(method):
    # gravity is a frame acceleration: exact, no deformation; both methods integrate t^2 exactly
    g = np.array([1.0, -9.81, 2.0])
    body = jo.FlexibleBody(
        "free", rod(), position=(0.1, 0.2, 0.3), orientation=jo.Rotate((1, 1, 0), degrees=30)
    )
    model = jo.compile(jo.Mechanism(body, jo.Gravity(g)))
    run = march(model, method(step=1e-3), 1.0, 0.1)
    expected = np.array([0.1, 0.2, 0.3]) + 0.5 * g * run.time[:, None] ** 2
    np.testing.assert_allclose(run.q[:, :3], expected, rtol=0, atol=1e-12)
    np.testing.assert_allclose(run.v[:, :3], g * run.time[:, None], rtol=0, atol=1e-12)
    assert np.abs(run.q[:, 7:]).max() == 0.0


def test_the_centre_of_mass_of_a_spinning_body_falls_along_the_parabola():
    g = np.array([0.0, -9.81, 0.0])
    body = spinning()
    model = jo.compile(jo.Mechanism(body, jo.Gravity(g)))
    particles = particles_of(body)
    share = particles.m / particles.m.sum()
    errors = []
    for n in (500, 1000):
        run = march(model, jo.RK4(step=0.25 / n), 0.25)
        centre = np.array([share @ particles.positions(q) for q in run.q])
        speed = share @ particles.velocities(run.q[0], run.v[0])
        t = run.time[-1]
        errors.append(np.abs(centre[-1] - centre[0] - speed * t - 0.5 * g * t**2).max())
    # the centre is a nonlinear function of the state: fourth order, not exact
    assert errors[-1] < 1e-7
    assert errors[-1] < 1e-12 or orders(errors)[-1] > 3.7


def test_torque_free_asymmetric_top_follows_the_jacobi_elliptic_functions():
    # Landau & Lifshitz, Mechanics, section 37, with L^2 > 2 E I2
    I = np.array([1.0, 2.0, 2.5])
    w0 = np.array([0.7, 0.0, 2.0])  # at t = 0 the middle component is zero
    body = jo.RigidBody("top", 3.0, I, angular_velocity=w0)
    model = jo.compile(jo.Mechanism(body))
    run = march(model, jo.RK4(step=1e-3), 10.0, 0.1)

    E2, L2 = float(I @ w0**2), float(I**2 @ w0**2)  # 2 E, L^2
    assert L2 > E2 * I[1]
    rate = np.sqrt((I[2] - I[1]) * (L2 - E2 * I[0]) / I.prod())
    k2 = (I[1] - I[0]) * (E2 * I[2] - L2) / ((I[2] - I[1]) * (L2 - E2 * I[0]))
    sn, cn, dn, _ = ellipj(rate * run.time, k2)
    w = np.stack(
        [
            np.sqrt((E2 * I[2] - L2) / (I[0] * (I[2] - I[0]))) * cn,
            np.sqrt((E2 * I[2] - L2) / (I[1] * (I[2] - I[1]))) * sn,
            np.sqrt((L2 - E2 * I[0]) / (I[2] * (I[2] - I[0]))) * dn,
        ],
        axis=1,
    )
    # h^4 = 1e-12 times the fifth derivative and ten seconds
    np.testing.assert_allclose(run.v[:, 3:6], w, rtol=0, atol=1e-10)
    # the angular momentum stands still in the world
    L = np.array([rotation(q[3:7]) @ (I * v[3:6]) for q, v in zip(run.q, run.v, strict=True)])
    np.testing.assert_allclose(L, np.tile(I * w0, (101, 1)), rtol=0, atol=1e-10)


@pytest.mark.parametrize(
    ("method", "step", "tolerance"), [(jo.RK4, 2e-4, 2e-8), (jo.ROS2, 1e-4, 2e-4)]
)
def test_heavy_top_in_steady_precession(method, step, tolerance):
    # Goldstein, Classical Mechanics, section 5.7: C w3 Omega - A Omega^2 cos = m g l, with A, C
    # about the pivot and w3 the spin about the axis of the body
    mass, arm, g = 2.0, 0.4, 9.81
    A, C, theta, precession = 0.1 + mass * arm**2, 0.05, np.radians(35.0), 3.0
    w3 = (mass * g * arm + A * precession**2 * np.cos(theta)) / (C * precession)
    axis = np.array([np.sin(theta), 0.0, np.cos(theta)])
    spin = precession * np.array([0.0, 0.0, 1.0])
    spin = spin + (w3 - precession * np.cos(theta)) * axis
    body = jo.RigidBody(
        "top",
        mass,
        (0.1, 0.1, C),
        center=(0.0, 0.0, arm),
        orientation=jo.Rotate((0, 1, 0), degrees=np.degrees(theta)),
        angular_velocity=spin,
    )
    model = jo.compile(
        jo.Mechanism(
            body,
            jo.Spherical("pivot", jo.ground["origin"], body["origin"]),
            jo.Gravity((0, 0, -g)),
            jo.PositionSensor("centre", body["center"]),
        )
    )
    run = march(model, method(step=step), 2.0, 0.05)
    phase = precession * run.time
    expected = np.stack(
        [np.sin(theta) * np.cos(phase), np.sin(theta) * np.sin(phase), np.cos(theta) + 0 * phase],
        axis=1,
    )
    # the spin w of 60 rad/s sets the phase error, about w t (h w)^p / 60
    np.testing.assert_allclose(run.sensors["centre"], arm * expected, rtol=0, atol=tolerance)
