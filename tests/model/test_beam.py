"""The geometrically exact beam element: strains, forces, tangents, laws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from jousto.model.model import BeamModel, SensorModel
from jousto.model.native.native import displaced

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
KINDS = [
    {},
    {"beta": 0.07},
    {"share": 1.0},
    {"share": 0.5, "alpha": 0.9},
    {"share": 0.0, "alpha": 0.9},
    {"beta": 0.07, "share": 1.0, "alpha": 0.9},
    {"helical": 1},
    {"helical": 1, "beta": 0.07},
    {"polar": 0.7},
    {"polar": 0.7, "beta": 0.07},
    {"polar": 0.7, "helical": 1},
    {"polar": 0.7, "helical": 1, "beta": 0.07, "share": 1.0},
]


def stiffness(rng, coupled=True):
    """Return a positive definite section stiffness (6, 6)."""
    C = np.diag([900.0, 300.0, 400.0, 20.0, 30.0, 25.0])
    if coupled:
        X = 0.4 * rng.normal(size=(6, 6)) * np.sqrt(np.diag(C))[:, None]
        C = C + X @ X.T
    return C


def element(
    a,
    b,
    *,
    L=1.0,
    u=None,
    B=None,
    C=None,
    e0=None,
    beta=0.0,
    alpha=0.0,
    share=0.0,
    m=0.0,
    J=None,
    helical=0,
    polar=0.0,
):
    """Return the element between bodies a and b, and its data as in jousto.h."""
    u = np.zeros((2, 3)) if u is None else u
    B = np.array([np.eye(3)] * 2) if B is None else B
    data = np.zeros(80)
    data[78:80] = helical, polar
    data[0] = L
    data[1:4], data[13:16] = u
    data[4:13], data[16:25] = B[0].ravel(), B[1].ravel()
    data[25:61] = np.ravel(C)
    data[61:67] = 0.0 if e0 is None else e0
    data[67:71] = beta, alpha, share, m
    if J is not None:
        data[71:77] = J
    return BeamModel(f"element {a + 1}", "beam", a, b, data)


def bodies(count, rng):
    """Return a model of free rigid bodies with eccentric masses, in a row along x."""
    parts = [
        jo.RigidBody(
            f"node{i}",
            2.0 + i,
            (0.3, 0.4, 0.5),
            center=rng.normal(size=3) * 0.1,
            position=(i, 0, 0),
        )
        for i in range(count)
    ]
    return jo.compile(jo.Mechanism(*parts, jo.Gravity((0.0, -9.81, 0.0))))


def bent(model, rng, turn=1.0, size=0.3):
    """Return an engine with large rotations, strains, velocities and accelerations."""
    engine = jo.model.Engine(model)
    whole = Rotation.random(random_state=rng)
    for b in model.bodies:
        bend = Rotation.from_rotvec(turn * rng.uniform(-1.0, 1.0, 3))
        place = whole.apply([b.iq / 7 * 1.05, 0, 0]) + size * rng.normal(size=3)
        engine.q[b.iq : b.iq + 3] = place
        engine.q[b.iq + 3 : b.iq + 7] = np.roll((whole * bend).as_quat(), 1)
    engine.v[:] = rng.normal(size=model.nv)
    engine.a[:] = rng.normal(size=model.nv)
    return engine


def beams(rng, count=3, **kind):
    """Return a model of a chain of elements with everything random; its bodies damp their mass."""
    model = bodies(count, rng)
    alpha = kind.get("alpha", 0.0)
    model = replace(model, bodies=tuple(replace(b, alpha=alpha) for b in model.bodies))
    links = [
        element(
            i,
            i + 1,
            L=rng.uniform(0.7, 1.3),
            u=0.2 * rng.normal(size=(2, 3)),
            B=Rotation.from_rotvec(0.3 * rng.normal(size=(2, 3))).as_matrix(),
            C=stiffness(rng),
            e0=0.1 * rng.normal(size=6),
            m=1.7,
            J=(0.5, 0.3, 0.4, 0.02, -0.03, 0.05),
            **kind,
        )
        for i in range(count - 1)
    ]
    return replace(model, beams=tuple(links))


def rotation(e):
    """Return the rotation matrix of (complex) Euler parameters, scalar first."""
    e0, v = e[0], e[1:]
    cross = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    return (e0 * e0 - v @ v) * np.eye(3) + 2 * np.outer(v, v) + 2 * e0 * cross


def strains(model, beam, q):
    """Return the strains by the formulas of theory, with matrix functions; complex q is welcome."""
    x, ends = beam.data, []
    for body, u, B in ((beam.a, x[1:4], x[4:13]), (beam.b, x[13:16], x[16:25])):
        at = model.bodies[body].iq
        A = rotation(q[at + 3 : at + 7])
        ends.append((q[at : at + 3] + A @ u, A @ B.reshape(3, 3)))
    (ra, Qa), (rb, Qb) = ends
    R = Qa.T @ Qb
    axis = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    sine, cosine = np.sqrt(axis @ axis), (np.trace(R) - 1.0) / 2.0
    angle = np.arctan2(sine.real, cosine.real)
    if np.iscomplexobj(q):
        rate = cosine.real * sine.imag - sine.real * cosine.imag
        angle = angle + 1j * rate / (sine.real**2 + cosine.real**2)
    phi = axis * angle / sine
    n = axis / sine
    cross = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    half = np.eye(3) + np.sin(angle / 2) * cross + (1 - np.cos(angle / 2)) * cross @ cross
    d = (Qa @ half).T @ (rb - ra) / x[0]
    if x[78]:  # arc over chord, across the rotation vector
        d = (d - n * (n @ d)) * (angle / 2) / np.sin(angle / 2) + n * (n @ d)
    gamma = d - np.array([1.0, 0, 0])
    e = np.concatenate([gamma, phi / x[0]]) - x[61:67]
    e[0] = e[0] + x[79] / 2 * ((phi[0] / x[0]) ** 2 - x[64] ** 2)  # of leaning fibres
    return e


def energy(model, q):
    """Return the strain energy of all elements by a plain formula."""
    U = 0.0
    for beam in model.beams:
        e = strains(model, beam, q)
        U = U + 0.5 * beam.data[0] * e @ beam.data[25:61].reshape(6, 6) @ e
    return U


def assert_tangent(engine, tolerance=1e-12):
    """Newton's matrix agrees with complex steps, term by term."""
    t = engine.tangent()
    for weights, wanted in (((1, 0, 0), t.M), ((0, 1, 0), t.D), ((0, 0, 1), t.K)):
        found = engine.newton_matrix(*map(float, weights))
        np.testing.assert_allclose(found, wanted, rtol=0, atol=tolerance * np.abs(wanted).max())


@pytest.mark.parametrize("turn", [1e-9, 1e-3, 0.2, 0.7, 1.2])
@pytest.mark.parametrize("helical", [0, 1])
@pytest.mark.parametrize("polar", [0.0, 0.7])
def test_forces_are_the_gradient_of_the_strain_energy(turn, helical, polar):
    rng = np.random.default_rng(int(1e6 * turn) + 1)
    model = beams(rng, helical=helical, polar=polar)
    engine = bent(model, rng, turn)
    engine.v[:] = engine.a[:] = 0.0
    without = jo.model.Engine(replace(model, beams=()))
    without.q[:] = engine.q
    found = engine.residual() - without.residual()
    wanted = np.zeros(model.nv)
    for j, unit in enumerate(np.eye(model.nv)):
        moved = displaced(model, engine.q.astype(complex), 1e-20j * unit)
        wanted[j] = energy(model, moved).imag / 1e-20
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-10 * np.abs(wanted).max())
    U = engine.energy()[1]
    assert pytest.approx(energy(model, engine.q), rel=1e-12) == U


@pytest.mark.parametrize("turn", [0.0, 1e-9, 1e-3, 0.2, 0.7, 1.0])
@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_tangents_are_exact(kind, turn):
    rng = np.random.default_rng(int(1e6 * turn) + 7)
    engine = bent(beams(rng, **kind), rng, turn)
    assert_tangent(engine)


@pytest.mark.parametrize("angle", [1.0, 2.0, 2.9])
def test_strains_and_tangents_at_large_rotations_between_the_ends(angle):
    rng = np.random.default_rng(5)
    model = replace(bodies(2, rng), beams=(element(0, 1, C=stiffness(rng)),))
    engine = bent(model, rng)
    axis = rng.normal(size=3)
    start = Rotation.from_quat(np.roll(engine.q[3:7], -1))
    turn = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
    engine.q[10:14] = -np.roll((start * turn).as_quat(), 1)  # the other sign: the same rotation
    phi = section(engine, 0)[3:6]
    np.testing.assert_allclose(phi, angle * axis / np.linalg.norm(axis), rtol=1e-13)
    assert_tangent(engine, 1e-11)


def section(engine, beam):
    """Return strains and resultants (12,) of an element by its sensor."""
    sensor = SensorModel("s", "section", beam, 0, 12, "", "", "", ("",) * 12)
    twin = jo.model.Engine(replace(engine.model, sensors=(sensor,)))
    twin.q[:], twin.v[:] = engine.q, engine.v
    twin.accelerations()
    return twin.sensors()


def test_the_section_sensor_measures_strains_and_resultants():
    """s = C (e + beta e'), e' by a complex step along the motion."""
    rng = np.random.default_rng(9)
    model = beams(rng, beta=0.07)
    engine = bent(model, rng, 0.5)
    moved = displaced(model, engine.q.astype(complex), 1e-20j * engine.v)
    for i, beam in enumerate(model.beams):
        e = strains(model, beam, moved)
        wanted = beam.data[25:61].reshape(6, 6) @ (e.real + 0.07 * e.imag / 1e-20)
        found = section(engine, i)
        np.testing.assert_allclose(found[:6], e.real, atol=1e-13)
        np.testing.assert_allclose(found[6:], wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())


def kinetic(beam, model, q, v, share):
    """Return the kinetic energy that `share` adds to that of the bodies."""
    x, ends = beam.data, []
    for body, u, B in ((beam.a, x[1:4], x[4:13]), (beam.b, x[13:16], x[16:25])):
        at, iv = model.bodies[body].iq, model.bodies[body].iv
        w = v[iv + 3 : iv + 6]
        wu = np.array(
            [w[1] * u[2] - w[2] * u[1], w[2] * u[0] - w[0] * u[2], w[0] * u[1] - w[1] * u[0]]
        )
        ends.append((v[iv : iv + 3] + rotation(q[at + 3 : at + 7]) @ wu, B.reshape(3, 3).T @ w))
    xx, yy, zz, yz, xz, xy = x[71:77]
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    (va, Wa), (vb, Wb) = ends
    dv, dW = vb - va, Wb - Wa
    return -share / 12.0 * (x[70] * dv @ dv + dW @ J @ dW)


def whole(model, q, v, share):
    """Return the kinetic energy of the bodies, ``m V.V/2 + V.(w x S) + w.J w/2``, and elements."""
    T = sum(kinetic(beam, model, q, v, share) for beam in model.beams)
    for b in model.bodies:
        xx, yy, zz, yz, xz, xy = b.J0
        J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        V = rotation(q[b.iq + 3 : b.iq + 7]).T @ v[b.iv : b.iv + 3]
        w = v[b.iv + 3 : b.iv + 6]
        T += 0.5 * (b.mass[0] * V @ V + w @ J @ w) + V @ np.cross(w, b.S0)
    return T


def momenta(function, q, v):
    """Return the derivatives of a quadratic function of v, exact by central differences."""
    return np.array([0.5 * (function(q, v + e) - function(q, v - e)) for e in np.eye(len(v))])


def test_the_inertia_is_that_of_lagrange():
    """d/dt dT/dw + w x dT/dw - dT/dtheta (Euler-Poincare) of the energy that `share` adds."""
    rng = np.random.default_rng(3)
    model = beams(rng, share=0.7)
    engine = bent(model, rng)
    plain = jo.model.Engine(
        replace(model, beams=tuple(replace(b, data=without_inertia(b)) for b in model.beams))
    )
    for name in ("q", "v", "a"):
        getattr(plain, name)[:] = getattr(engine, name)
    found = engine.residual() - plain.residual()

    def T(q, v):
        return sum(kinetic(beam, model, q, v, 0.7) for beam in model.beams)

    h, q, v = 1e-20, engine.q.copy(), engine.v.copy()
    p = momenta(T, q, v)
    later = displaced(model, q.astype(complex), 1j * h * v)
    wanted = momenta(T, later, v + 1j * h * engine.a).imag / h
    for j, unit in enumerate(np.eye(model.nv)):
        wanted[j] -= T(displaced(model, q.astype(complex), 1j * h * unit), v).imag / h
    for b in model.bodies:
        at = slice(b.iv + 3, b.iv + 6)
        wanted[at] += np.cross(v[at], p[at])
    assert np.abs(wanted).max() > 1.0
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())
    energies = engine.energy() - plain.energy()
    np.testing.assert_allclose(energies, [T(q, v), 0, 0, 0], atol=1e-10)


def without_inertia(beam):
    """Return the element's data without inertia and damping."""
    data = beam.data.copy()
    data[67:70] = 0.0
    return data


def test_damping_of_the_mass_is_proportional_to_the_momenta():
    """``alpha dT/dv`` of all of the mass: mass centres off the axis, too."""
    rng = np.random.default_rng(4)
    alpha, share = 0.9, 0.6
    engine = bent(beams(rng, alpha=alpha, share=share), rng)
    model = engine.model
    without = jo.model.Engine(beams(np.random.default_rng(4), share=share))
    for name in ("q", "v", "a"):
        getattr(without, name)[:] = getattr(engine, name)

    def T(q, v):
        return whole(model, q, v, share)

    wanted = alpha * momenta(T, engine.q, engine.v)
    found = engine.residual() - without.residual()
    np.testing.assert_allclose(found, wanted, atol=1e-11 * np.abs(wanted).max())


def test_nothing_is_gained_or_lost_but_by_damping():
    """r . v = d(T + U + P)/dt + alpha v.Mv + L beta e'.C e', and no net force or moment inside."""
    rng = np.random.default_rng(6)
    model = beams(rng, share=1.0, alpha=0.3, beta=0.05)
    engine = bent(model, rng, 0.8)
    power = engine.residual() @ engine.v
    twin = jo.model.Engine(model, complex_scalars=True)
    h = 1e-20
    twin.q[:] = displaced(model, engine.q.astype(complex), 1j * h * engine.v)
    twin.v[:] = engine.v + 1j * h * engine.a
    stored = twin.energy().imag.sum() / h
    lost = 0.0
    for beam in model.beams:
        e = strains(model, beam, twin.q).imag / h
        lost += beam.data[0] * 0.05 * e @ beam.data[25:61].reshape(6, 6) @ e
    lost += 2 * 0.3 * whole(model, engine.q, engine.v, 1.0)
    assert lost > 1.0
    assert power == pytest.approx(stored + lost, rel=1e-11)


@pytest.mark.parametrize("kind", KINDS[:2], ids=str)
def test_internal_forces_are_in_equilibrium(kind):
    rng = np.random.default_rng(8)
    engine = bent(beams(rng, **kind), rng)
    model = engine.model
    without = jo.model.Engine(replace(model, beams=()))
    for name in ("q", "v", "a"):
        getattr(without, name)[:] = getattr(engine, name)
    r = engine.residual() - without.residual()
    force, moment = np.zeros(3), np.zeros(3)
    for b in model.bodies:
        F = r[b.iv : b.iv + 3]
        force += F
        A = rotation(engine.q[b.iq + 3 : b.iq + 7])
        moment += np.cross(engine.q[b.iq : b.iq + 3], F) + A @ r[b.iv + 3 : b.iv + 6]
    scale = np.abs(r).max()
    np.testing.assert_allclose(force, 0.0, atol=1e-13 * scale)
    np.testing.assert_allclose(moment, 0.0, atol=1e-12 * scale)


def test_rigid_motion_leaves_strains_and_turns_forces():
    """Objectivity: whatever the motion, the frames in which the forces are given go with it."""
    rng = np.random.default_rng(2)
    engine = bent(beams(rng), rng)
    model = engine.model
    engine.v[:] = engine.a[:] = 0.0
    weightless = jo.model.Engine(replace(model, gravity=np.zeros(3)))
    weightless.q[:] = engine.q
    before, first = weightless.residual(), [section(engine, i) for i in range(len(model.beams))]
    for _ in range(5):
        turn, shift = Rotation.random(random_state=rng), rng.normal(size=3)
        for b in model.bodies:
            weightless.q[b.iq : b.iq + 3] = turn.apply(weightless.q[b.iq : b.iq + 3]) + 10.0 * shift
            old = Rotation.from_quat(np.roll(weightless.q[b.iq + 3 : b.iq + 7], -1))
            weightless.q[b.iq + 3 : b.iq + 7] = np.roll((turn * old).as_quat(), 1)
            before[b.iv : b.iv + 3] = turn.apply(before[b.iv : b.iv + 3])
        scale = np.abs(before).max()
        np.testing.assert_allclose(weightless.residual(), before, rtol=0, atol=1e-12 * scale)
        for i, wanted in enumerate(first):
            np.testing.assert_allclose(section(weightless, i), wanted, rtol=0, atol=1e-11 * 900)


def test_strains_do_not_depend_on_the_way():
    """A closed way of the state through large rotations brings forces and energy back."""
    rng = np.random.default_rng(12)
    engine = bent(beams(rng), rng, 0.3)
    start = engine.residual().copy(), engine.energy()[1]
    q = engine.q.copy()
    ways = 0.15 * rng.normal(size=(8, engine.model.nv))
    for way in (*ways, *-ways[::-1]):
        engine.q[:] = displaced(engine.model, engine.q, way)
        engine.residual()
    np.testing.assert_allclose(np.abs(engine.q), np.abs(q), atol=1e-13)
    scale = np.abs(start[0]).max()
    np.testing.assert_allclose(engine.residual(), start[0], rtol=0, atol=1e-12 * scale)
    assert engine.energy()[1] == pytest.approx(start[1], rel=1e-12)


def test_in_the_plane_it_is_the_element_of_reissner():
    """Strains and forces of (14-18) by Makinen et al.: one point, linear shape functions."""
    EA, GA, EI, L = 900.0, 400.0, 30.0, 1.3
    rng = np.random.default_rng(1)
    beam = element(0, 1, L=L, C=np.diag([EA, GA, 200.0, 20.0, 20.0, EI]))
    model = replace(bodies(2, rng), beams=(beam,), gravity=np.zeros(3))
    for _ in range(5):
        engine = jo.model.Engine(model)
        (xa, ya, ta), (xb, yb, tb) = rng.uniform(-1.0, 1.0, (2, 3)) + [[0, 0, 0], [L, 0, 0.3]]
        engine.q[:] = [xa, ya, 0, np.cos(ta / 2), 0, 0, np.sin(ta / 2)] + [
            *(xb, yb, 0),
            *(np.cos(tb / 2), 0, 0, np.sin(tb / 2)),
        ]
        c, s = np.cos((ta + tb) / 2), np.sin((ta + tb) / 2)
        dx, dy = (xb - xa) / L, (yb - ya) / L
        eps, gam, kap = dx * c + dy * s - 1.0, dy * c - dx * s, (tb - ta) / L
        N, Q, M = EA * eps, GA * gam, EI * kap
        wanted = []
        for Ni, d in ((0.5, -1 / L), (0.5, 1 / L)):  # N_i and N_i' at the middle
            B = [[c * d, s * d, gam * Ni], [-s * d, c * d, -(1 + eps) * Ni], [0, 0, d]]
            wanted.append(L * np.array([N, Q, M]) @ B)
        engine.v[:] = 0.0
        r = engine.residual()
        # strains are differences of numbers of size one
        round_off = 1e-13 * max(EA, GA, EI)
        np.testing.assert_allclose(r[[0, 1, 5, 6, 7, 11]], np.ravel(wanted), rtol=0, atol=round_off)
        np.testing.assert_allclose(r[[2, 3, 4, 8, 9, 10]], 0.0, atol=round_off)
        np.testing.assert_allclose(section(engine, 0)[6:], [N, Q, 0, 0, 0, M], atol=round_off)


def cantilever(count, C, L=10.0, mass=0.1):
    """Return the model of free nodes and elements of a straight beam along x."""
    h = L / count
    parts = [
        jo.RigidBody(f"node{i}", mass, (0.01, 0.01, 0.01), position=(i * h, 0, 0))
        for i in range(count + 1)
    ]
    model = jo.compile(jo.Mechanism(*parts))
    return replace(model, beams=tuple(element(i, i + 1, L=h, C=C) for i in range(count)))


def solve(engine, load, steps=40, tolerance=1e-9):
    """Clamp the first node, apply dead loads and return the increments of Newton's iteration."""
    history = []
    for _ in range(steps):
        r = (engine.residual() - load)[6:]
        if np.linalg.norm(r) < tolerance:
            break
        dx = np.zeros(engine.model.nv)
        dx[6:] = np.linalg.solve(engine.newton_matrix(0.0, 0.0, 1.0)[6:, 6:], -r)
        history.append(np.linalg.norm(dx))
        engine.q[:] = displaced(engine.model, engine.q, dx)
    return np.array(history)


@pytest.mark.parametrize("count", [4, 7])
def test_newton_converges_quadratically_to_a_full_circle(count):
    """M = 2 pi EI / L about any axis across the beam closes a circle (any number of elements)."""
    EI, L = 100.0, 10.0
    model = cantilever(count, np.diag([1e4, 5e3, 5e3, 80.0, EI, EI]), L)
    engine = jo.model.Engine(model)
    across = np.array([0.0, 0.6, 0.8])
    load = np.zeros(model.nv)
    for part in np.linspace(0.05, 1.0, 20):
        load[-3:] = part * 2 * np.pi * EI / L * across  # torque in the frame of the end
        history = solve(engine, load)
    np.testing.assert_allclose(engine.q[-7:-4], 0.0, atol=1e-11)
    ends = Rotation.from_quat(np.roll(engine.q[-4:], -1))
    assert ends.magnitude() < 1e-11
    last = history[(history < 0.5) & (history > 1e-7)]
    assert len(last) >= 2
    assert len(history) < 8
    follows = history[np.flatnonzero(np.isin(history, last)) + 1]
    assert (follows < 150.0 * last**2 + 1e-12).all(), history  # of the order of EA / EI


def test_half_a_turn_in_one_element_is_an_error_with_its_name():
    model = cantilever(3, np.diag([1e4, 5e3, 5e3, 80.0, 100.0, 100.0]))
    engine = jo.model.Engine(model)
    engine.q[-4:] = [np.cos(1.51), 0.0, 0.0, np.sin(1.51)]
    with pytest.raises(
        jo.SimulationError, match=r"beam 'beam', element 'element 3'.*more elements"
    ):
        engine.residual()


def test_a_jump_over_half_a_turn_in_one_step_is_noticed():
    """Spinning at 2000 rad/s against its neighbour, a node turns by 4 rad in a step of 2 ms."""
    model = cantilever(1, np.zeros((6, 6)))
    engine = jo.model.Engine(model)
    engine.v[-1] = 2000.0
    solver = engine.native_solver("rk4", 1e-3, False)
    engine.step(solver)  # to 2 rad
    assert engine.bent[0, 0] == pytest.approx(2.0, rel=1e-6)
    with pytest.raises(jo.SimulationError, match="3 rad"):
        for _ in range(2):
            engine.step(solver)


def test_bent_keeps_the_largest_rotation_and_tension():
    C = np.diag([1e4, 5e3, 5e3, 80.0, 100.0, 100.0])
    model = cantilever(2, C)
    limit = (1e4 - 5e3) / (1e4 * 5e3)
    for beam in model.beams:
        beam.data[77] = limit
    engine = jo.model.Engine(model)
    engine.v[-6], engine.v[-1] = 100.0, 3.0
    solver = engine.native_solver("rk4", 5e-4, False)
    bend, tension = [], []
    for _ in range(200):
        engine.step(solver)
        y = section(engine, 1)
        bend.append(5.0 * np.linalg.norm(y[3:6]))
        tension.append(limit * y[6])
    np.testing.assert_allclose(engine.bent[1], [max(bend), max(tension)], rtol=1e-3)
    assert bend[-1] < 0.95 * max(bend)
    assert tension[-1] < 0.95 * max(tension)


def momentum(engine):
    """Return linear and angular momentum (about the origin) of rigid bodies."""
    p, H = np.zeros(3), np.zeros(3)
    for i, b in enumerate(engine.model.bodies):
        A = rotation(engine.q[b.iq + 3 : b.iq + 7])
        local = (
            engine.mass_matrix(i)
            @ np.r_[A.T @ engine.v[b.iv : b.iv + 3], engine.v[b.iv + 3 : b.iv + 6]]
        )
        p += A @ local[:3]
        H += np.cross(engine.q[b.iq : b.iq + 3], A @ local[:3]) + A @ local[3:]
    return p, H


def test_free_flight_keeps_momentum_and_energy():
    """Exact in time but for the method: with DOPRI's tolerance all follow."""
    rng = np.random.default_rng(21)
    model = replace(beams(rng, 4), gravity=np.zeros(3))
    changes = []
    for step in (2e-3, 1e-3):
        engine = bent(model, np.random.default_rng(5), 0.3, 0.1)
        (p, H), E = momentum(engine), engine.energy().sum()
        solver = engine.native_solver("dopri", step, False)
        for _ in range(round(0.1 / step)):
            engine.step(solver)
        p1, H1 = momentum(engine)
        np.testing.assert_allclose(p1, p, atol=1e-12 * np.abs(p).max() + 1e-11)
        changes.append([np.abs(H1 - H).max() / np.abs(H).max(), abs(engine.energy().sum() / E - 1)])
    coarse, fine = np.array(changes)
    assert fine.max() < 1e-7
    assert (coarse > 12.0 * fine).all()  # order 5 would give 32
