"""Joint reactions against Newton and Euler on the free bodies, and against closed forms.

For every body: the sum of reactions, loads and weight is the rate of change of its linear
momentum, and their moments that of its angular momentum. Both rates are sums of ``m r''`` over
particles (`particles`), which know nothing of multipliers.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification.mechanisms import (
    SECTION,
    SOFT,
    G,
    body_states,
    chain,
    loop,
    march,
    particles_of,
    rod,
)
from verification.particles import exponential, rotation

MECHANISMS = {
    "revolute chain": lambda: chain("revolute"),
    "spherical chain": lambda: chain("spherical", damping=0.02),
    "fixed joint": lambda: chain("fixed"),
    "fixed joint, loads": lambda: chain("fixed", loads=True),
    "loop": loop,
}


def marker_pose(marker, q):
    """World position and axes of a marker of a body in the state q (7+n,)."""
    A = rotation(q[3:7])
    r = q[:3] + A @ (marker.position_local + marker.Phi @ q[7:])
    return r, A @ exponential(marker.Psi @ q[7:]) @ marker.axes


@pytest.mark.parametrize("name", MECHANISMS)
def test_newton_and_euler_hold_for_every_body(name):
    mechanism = MECHANISMS[name]()
    model = jo.compile(mechanism)
    run = march(model, jo.RK4(step=2.5e-4), 1.0, 0.1)
    engine = jo.model.Engine(model)
    order = {id(body): i for i, body in enumerate(mechanism.bodies)}
    for k in range(len(run.time)):
        engine.q[:], engine.v[:], engine.time[:] = run.q[k], run.v[k], run.time[k]
        a = engine.accelerations()[0]
        states = body_states(model, run.q[k], run.v[k])
        for i, body in enumerate(mechanism.bodies):
            q, v = states[i]
            b = model.bodies[i]
            particles = particles_of(body)
            r = particles.positions(q)
            inertial = particles.m[:, None] * (
                particles.accelerations(q, v, a[b.iv : b.iv + 6 + b.n]) - np.asarray(G)
            )
            centre = particles.m @ r / particles.m.sum()
            forces = [inertial.sum(axis=0)]
            moments = [np.cross(r - centre, inertial).sum(axis=0)]
            for joint in mechanism.joints:
                for sign, marker in ((-1, joint.a), (1, joint.b)):
                    if order.get(id(marker.body)) == i:
                        F, M = np.split(sign * run.sensors[joint.name][k], 2)
                        at = marker_pose(marker, q)[0]
                        forces.append(-F)
                        moments.append(-M - np.cross(at - centre, F))
            for load in mechanism.forces:
                if order[id(load.marker.body)] == i:
                    at, axes = marker_pose(load.marker, q)
                    factor = 1.0 if load.signal is None else load.signal(run.time[k])
                    F = factor * (axes @ load.vector if load.follow else load.vector)
                    if isinstance(load, jo.Torque):
                        moments.append(-F)
                    else:
                        forces.append(-F)
                        moments.append(-np.cross(at - centre, F))
            # 1e-9 of the largest term: required; round-off of the solve gives about 1e-13
            for terms in (forces, moments):
                assert np.abs(sum(terms)).max() < 1e-9 * np.abs(terms).max()


def test_rigid_pendulum_reaction_in_closed_form():
    # compound pendulum with products of inertia, released at rest: energy gives the speed,
    # J alpha + w x J w = moment about the pivot gives the reaction moment across the hinge
    mass, c, g = 3.0, 0.7, 9.81
    J = np.array([[0.4, 0.05, -0.08], [0.05, 0.5, 0.06], [-0.08, 0.06, 0.3]])  # about the centre
    body = jo.RigidBody("pendulum", mass, J, center=(c, 0.0, 0.0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    model = jo.compile(
        jo.Mechanism(body, hinge, jo.Gravity((0, -g, 0)), jo.ReactionSensor("reaction", hinge))
    )
    run = march(model, jo.RK4(step=1e-3), 2.0, 0.05)
    # angle from the world's x axis; the body turns about z only
    e = run.q[:, 3:7]
    angle = 2 * np.arctan2(e[:, 3], e[:, 0])
    np.testing.assert_allclose(run.q[:, 4:6], 0.0, atol=1e-14)
    Jz = J[2, 2] + mass * c**2
    speed2 = -2 * mass * g * c * np.sin(angle) / Jz
    alpha = -mass * g * c * np.cos(angle) / Jz
    radial = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    tangent = np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1)
    acceleration = c * (alpha[:, None] * tangent - speed2[:, None] * radial)
    force = mass * (acceleration - np.array([0.0, -g, 0.0]))
    # energy error of RK4 at this step: 1e-12
    np.testing.assert_allclose(run.sensors["reaction"][:, :3], force, rtol=0, atol=1e-9 * mass * g)
    # products of inertia about the pivot: the centre lies on x, so xz and yz are those about it
    M_radial = J[0, 2] * alpha - J[1, 2] * speed2
    M_tangent = J[1, 2] * alpha + J[0, 2] * speed2
    moment = M_radial[:, None] * radial + M_tangent[:, None] * tangent
    np.testing.assert_allclose(run.sensors["reaction"][:, 3:], moment, rtol=0, atol=1e-8)


def test_static_cantilever_reaction():
    # clamped rod in gravity with a force at its tip, damped until it rests. Force: all there is;
    # moment about the clamp: of the deformed shape, which for a small deflection is that of the
    # straight one; tip deflection F L^3 / 3EI + w L^4 / 8EI (Euler-Bernoulli)
    L, F = 1.0, np.array([0.0, -20.0, 35.0])
    body = jo.FlexibleBody("cantilever", rod(), damping=1.0)
    clamp = jo.Fixed("clamp", jo.ground["origin"], body["start"])
    mechanism = jo.Mechanism(
        body,
        clamp,
        jo.Force("tip", body["end"], F),
        jo.Gravity(G),
        jo.ReactionSensor("clamp", clamp),
        jo.PositionSensor("tip", body["end"]),
    )
    model = jo.compile(mechanism)
    run = march(model, jo.ROS2(step=1e-3), 15.0)
    assert np.abs(run.v[-1]).max() < 1e-10  # at rest
    weight = SOFT.rho * SECTION.A * L * G
    reaction = run.sensors["clamp"][-1]
    np.testing.assert_allclose(reaction[:3], -(F + weight), rtol=0, atol=1e-9 * abs(weight[1]))
    particles = particles_of(body)
    r = particles.positions(run.q[-1])
    tip = run.sensors["tip"][-1]
    moment = np.cross(r, particles.m[:, None] * G).sum(axis=0) + np.cross(tip, F)
    np.testing.assert_allclose(reaction[3:], -moment, rtol=0, atol=1e-9 * np.abs(moment).max())
    straight = np.cross([L, 0, 0], F) + np.cross([L / 2, 0, 0], weight)
    # the arms change by the deflection of 1 %, and their moments with them
    np.testing.assert_allclose(reaction[3:], -straight, rtol=0, atol=5e-3 * np.abs(moment).max())
    q = weight[1] / L
    deflection = [
        F[1] * L**3 / (3 * SOFT.E * SECTION.Iz) + q * L**4 / (8 * SOFT.E * SECTION.Iz),
        F[2] * L**3 / (3 * SOFT.E * SECTION.Iy),
    ]
    # interface modes are exact for the tip force; the line load needs fixed-interface modes, of
    # which two are kept (one in each plane)
    np.testing.assert_allclose(tip[1:], deflection, rtol=3e-4)
