"""Accelerations and multipliers against the dense saddle-point system, written anew in NumPy.

``[M Cq^T; Cq 0] [a; lam] = [Q; gamma]`` (Rantalainen 2007, eq. 3.103). M and Q are sums over
particles; the constraint equations C are written here as functions of complex numbers, so that Cq
comes from complex steps (Squire and Trapp, SIAM Rev. 40, 1998) and gamma, the second derivative of
C along the motion without acceleration, from Cauchy's integral on a circle. No formula for a
Jacobian, a gamma or an elimination is shared with the engine.
"""

from __future__ import annotations

from functools import cache, partial

import numpy as np
import pytest

import jousto as jo
from verification.mechanisms import chain, loop, particles_of, rod
from verification.particles import exponential, rotation, skew

# rows after r_b - r_a = 0: (axis of a) . (axis of b) = 0 of the aligned frames, z is the axis
ROWS = {
    jo.Spherical: (),
    jo.Revolute: ((0, 2), (1, 2)),
    jo.Fixed: ((0, 2), (1, 2), (0, 1)),
}


def star():
    """A rigid hub with three flexible arms on three kinds of joints, and a stone on each."""
    hub = jo.RigidBody("hub", 20.0, (1.0, 1.5, 2.0), center=(0.05, 0.1, 0.0))
    joints = [jo.Revolute("pivot", jo.ground["origin"], hub["origin"], axis=(0.3, 1.0, 0.2))]
    bodies = [hub]
    kinds = (jo.Revolute, jo.Spherical, jo.Fixed)
    for i, kind in enumerate(kinds):
        turn = jo.Rotate((0, 1, 0.1), degrees=120.0 * i + 10.0)
        rim = turn.matrix @ [0.3, 0.0, 0.0]
        arm = jo.FlexibleBody(
            f"arm {i}", rod(), position=rim, orientation=turn, modal_coordinates=0.02 * DEFORMED
        )
        at = np.asarray(arm["end"].r)
        stone = jo.RigidBody(
            f"stone {i}", 3.0 + i, (0.1, 0.2, 0.25), center=(0, 0.1, 0.1), position=at
        )
        start = np.asarray(arm["start"].r)
        joints.append(kind(f"shoulder {i}", hub.at(start), arm["start"]))
        joints.append(kinds[i - 1](f"wrist {i}", stone["origin"], arm["end"]))
        bodies += [arm, stone]
    wave = jo.Harmonic(frequency=0.7, amplitude=2.0, phase=0.4, offset=0.5)
    elbow = bodies[1]["node4"].turned(jo.Rotate((1, 2, 3), degrees=50.0))
    return jo.Mechanism(
        *bodies,
        *joints,
        jo.Force("f1", elbow, (30.0, -20.0, 10.0), follow=True, signal=wave),
        jo.Torque("t1", elbow, (3.0, 5.0, -4.0), follow=True),
        jo.Force("f2", bodies[2]["center"], (10.0, 5.0, -7.0), signal=jo.Step(0.2, 0.0, 3.0)),
        jo.Torque("t2", bodies[3]["end"], (-2.0, 1.0, 4.0), signal=jo.Table((0, 1), (0.0, 2.0))),
        jo.Gravity((1.0, -9.0, 2.0)),
        *[jo.ReactionSensor(joint.name, joint) for joint in joints],
        name="star",
    )


DEFORMED = np.array([1.0, -2.0, 1.5, 0.5, -1.0, 0.7, 1.2, -0.4])
MECHANISMS = {
    "revolute chain": partial(chain, "revolute"),
    "spherical chain": partial(chain, "spherical", damping=0.03),
    "fixed joint, loads": partial(chain, "fixed", loads=True),
    "star": star,
    "loop": loop,
}


@cache
def built(name):
    mechanism = MECHANISMS[name]()
    return mechanism, jo.compile(mechanism)


class Poses:
    """Positions and axes of every body, moved by increments [dR, dtheta (local), dp]."""

    def __init__(self, model, q):
        self.bodies = [
            (b.iv, b.n, q[b.iq : b.iq + 3], rotation(q[b.iq + 3 : b.iq + 7]), q[b.iq + 7 :][: b.n])
            for b in model.bodies
        ]

    def marker(self, index, marker, x):
        """World position and axes of a marker after the increments x."""
        if index < 0:
            return marker.position_local, marker.axes
        iv, n, R, A, p = self.bodies[index]
        p = p + x[iv + 6 : iv + 6 + n]
        A = A @ exponential(x[iv + 3 : iv + 6])
        r = R + x[iv : iv + 3] + A @ (marker.position_local + marker.Phi @ p)
        return r, A @ exponential(marker.Psi @ p) @ marker.axes


def constraints(mechanism, poses, x):
    index = {id(body): i for i, body in enumerate(mechanism.bodies)}
    rows = []
    for joint in mechanism.joints:
        (ra, Aa), (rb, Ab) = (poses.marker(index.get(id(m.body), -1), m, x) for m in joint.frames)
        rows += [rb - ra, [Aa[:, i] @ Ab[:, j] for i, j in ROWS[type(joint)]]]
    return np.concatenate(rows)


def dense(mechanism, model, q, v, time):
    """Accelerations and multipliers of the saddle-point system."""
    nv = model.nv
    M, Q = np.zeros((nv, nv)), np.zeros(nv)
    for body, b in zip(mechanism.bodies, model.bodies, strict=True):
        at = slice(b.iv, b.iv + 6 + b.n)
        qb, vb = q[b.iq : b.iq + 7 + b.n], v[at]
        particles = particles_of(body)
        K = np.asarray(body.reduced.stiffness) if b.n else np.zeros(0)
        D = np.asarray(body.modal_damping) if b.n else np.zeros(0)
        T = np.eye(6 + b.n)
        T[:3, :3] = rotation(qb[3:7]).T  # R' to the body frame
        M[at, at] = T.T @ particles.mass_matrix(qb[7:]) @ T
        Q[at] = T.T @ particles.forces(qb, vb, np.asarray(mechanism.gravity), K, D)

    poses = Poses(model, q)
    eye = 1e-30j * np.eye(nv)
    index = {id(body): i for i, body in enumerate(mechanism.bodies)}
    for load in mechanism.forces:
        here = partial(poses.marker, index[id(load.marker.body)], load.marker)
        A = here(np.zeros(nv))[1]
        F = load.vector * (1.0 if load.signal is None else load.signal(time))
        F = A @ F if load.follow else F
        for k, step in enumerate(eye):  # virtual work of the load in each coordinate
            r, turned = here(step)
            spin = (turned.imag @ A.T) / 1e-30
            rate = r.imag / 1e-30
            if isinstance(load, jo.Torque):
                rate = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
            Q[k] += rate @ F

    C = partial(constraints, mechanism, poses)
    Cq = np.stack([C(step).imag / 1e-30 for step in eye], axis=1)
    # C'' at a = 0 on the circle t = radius exp(i phi): exact but for terms of order 32
    radius, points = 0.1, 32
    circle = np.exp(2j * np.pi * np.arange(points) / points)
    second = sum(C(radius * z * v) / z**2 for z in circle) * 2 / (points * radius**2)
    nrow = len(Cq)
    saddle = np.block([[M, Cq.T], [Cq, np.zeros((nrow, nrow))]])
    solution = np.linalg.solve(saddle, np.concatenate([Q, -second.real]))
    return solution[:nv], solution[nv:], Cq, C(np.zeros(nv))


def moved(model, rng):
    """A random state near the initial one; the joints are open, which changes no equation."""
    q, v = model.q0.copy(), rng.normal(size=model.nv)
    for b in model.bodies:
        q[b.iq : b.iq + 3] += 0.1 * rng.normal(size=3)
        e = q[b.iq + 3 : b.iq + 7] + 0.2 * rng.normal(size=4)
        q[b.iq + 3 : b.iq + 7] = e / np.linalg.norm(e)
        q[b.iq + 7 : b.iq + 7 + b.n] += 0.2 * rng.normal(size=b.n)
    return q, v


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", MECHANISMS)
def test_engine_equals_the_dense_saddle_point_system(name, seed):
    mechanism, model = built(name)
    rng = np.random.default_rng(seed)
    q, v = moved(model, rng)
    engine = jo.model.Engine(model)
    engine.q[:], engine.v[:], engine.time[:] = q, v, 0.35
    a, lam, Cq, C = dense(mechanism, model, q, v, 0.35)
    found_a, found_lam = engine.accelerations()
    # round-off times the condition of the constraint matrix (up to 1e4)
    np.testing.assert_allclose(found_a, a, rtol=0, atol=1e-10 * np.abs(a).max())
    np.testing.assert_allclose(found_lam, lam, rtol=0, atol=1e-10 * np.abs(lam).max())
    found_C, found_rate = engine.constraints()
    np.testing.assert_allclose(found_C, C, rtol=0, atol=1e-13)
    np.testing.assert_allclose(found_rate, Cq @ v, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", MECHANISMS)
def test_the_initial_state_satisfies_the_constraints_written_here(name):
    mechanism, model = built(name)
    C = constraints(mechanism, Poses(model, model.q0), np.zeros(model.nv))
    assert np.abs(C).max() < 1e-13


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("name", MECHANISMS)
def test_reaction_sensors_do_the_virtual_work_of_the_multipliers(name, seed):
    # -Cq^T lam of every joint = its force and moment at marker b, and the opposite ones at marker
    # a (the moment of the force about a is there where the joint is open)
    mechanism, model = built(name)
    q, v = moved(model, np.random.default_rng(10 + seed))
    engine = jo.model.Engine(model)
    engine.q[:], engine.v[:] = q, v
    engine.accelerations()
    values = engine.sensors()
    reactions = {s.name: values[s.offset :][:6] for s in model.sensors if s.kind == "reaction"}
    poses, nv = Poses(model, q), model.nv
    eye = 1e-30j * np.eye(nv)
    C = partial(constraints, mechanism, poses)
    Cq = np.stack([C(step).imag / 1e-30 for step in eye], axis=1)
    index = {id(body): i for i, body in enumerate(mechanism.bodies)}
    for joint, rows in zip(mechanism.joints, model.joints, strict=True):
        force, moment = reactions[joint.name][:3], reactions[joint.name][3:]
        lam = engine.lam[rows.row : rows.row + rows.rows]
        expected = -Cq[rows.row : rows.row + rows.rows].T @ lam
        work = np.zeros(nv)
        for sign, marker in zip((-1, 1), joint.frames, strict=True):
            here = partial(poses.marker, index.get(id(marker.body), -1), marker)
            A = here(np.zeros(nv))[1]
            for k, step in enumerate(eye):
                r, turned = (np.asarray(x, dtype=complex) for x in here(step))
                spin = turned.imag @ A.T / 1e-30
                axis = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
                work[k] += sign * (force @ r.imag / 1e-30 + moment @ axis)
        np.testing.assert_allclose(work, expected, rtol=0, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("seed", range(3))
def test_kinematic_sensors_follow_from_the_pose_by_complex_steps(seed):
    # r, A = dR exp(Psi p) A0, r' and A' A^T of a marker on a bent body and on a rigid one
    rng = np.random.default_rng(20 + seed)
    bar = jo.FlexibleBody("bar", rod())
    stone = jo.RigidBody("stone", 2.0, (0.1, 0.2, 0.25), position=(1.0, 0.0, 0.0))
    turned = [bar["node4"].turned(jo.Rotate((1, 2, 3), degrees=70.0)), stone.at((0.1, 0.2, 0.3))]
    sensors = [
        kind(f"{kind.__name__} {i}", marker)
        for i, marker in enumerate(turned)
        for kind in (
            jo.PositionSensor,
            jo.VelocitySensor,
            jo.OrientationSensor,
            jo.AngularVelocitySensor,
        )
    ]
    joint = jo.Spherical("ball", bar["end"], stone["origin"])
    model = jo.compile(jo.Mechanism(bar, stone, joint, jo.Gravity((0, -9.81, 0)), *sensors))
    q, v = moved(model, rng)
    engine = jo.model.Engine(model)
    engine.q[:], engine.v[:] = q, v
    engine.accelerations()
    values = engine.sensors()
    found = {s.name: values[s.offset : s.offset + s.count] for s in model.sensors}
    poses = Poses(model, q)
    for i, marker in enumerate(turned):
        r, A = poses.marker(i, marker, np.zeros(model.nv))
        rate, spin = (x.imag / 1e-30 for x in poses.marker(i, marker, 1e-30j * v))
        W = spin @ A.T
        np.testing.assert_allclose(found[f"PositionSensor {i}"], r, rtol=0, atol=1e-13)
        np.testing.assert_allclose(found[f"VelocitySensor {i}"], rate, rtol=0, atol=1e-12)
        e = found[f"OrientationSensor {i}"]
        np.testing.assert_allclose(rotation(e), A, rtol=0, atol=1e-13)
        assert e[0] >= 0.0
        w = found[f"AngularVelocitySensor {i}"]
        np.testing.assert_allclose(w, [W[2, 1], W[0, 2], W[1, 0]], rtol=0, atol=1e-12)


def test_skew_and_exponential_of_this_file_are_right():
    # against SciPy's rotation vectors: an independent statement of both conventions
    from scipy.spatial.transform import Rotation

    theta = np.array([0.3, -1.2, 0.8])
    A = Rotation.from_rotvec(theta).as_matrix()
    np.testing.assert_allclose(exponential(theta), A, rtol=0, atol=1e-14)
    x, y, z, w = Rotation.from_rotvec(theta).as_quat()
    np.testing.assert_allclose(rotation(np.array([w, x, y, z])), A, rtol=0, atol=1e-14)
    np.testing.assert_allclose(skew(theta) @ [1, 2, 3], np.cross(theta, [1, 2, 3]), atol=1e-15)
