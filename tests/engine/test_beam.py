"""The geometrically exact beam element: strains, forces, tangents, laws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from jousto.engine.model import BeamModel
from jousto.engine.native import displaced

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
STEP = 1e-30


def stiffness(rng, coupled=True):
    """Return a positive definite section stiffness (6, 6)."""
    C = np.diag([900.0, 300.0, 400.0, 20.0, 30.0, 25.0])
    if coupled:
        X = 0.4 * rng.normal(size=(6, 6)) * np.sqrt(np.diag(C))[:, None]
        C = C + X @ X.T
    return C


def element(
    a, b, *, L=1.0, u=None, B=None, C=None, e0=None, beta=0.0, alpha=0.0, share=0.0, m=0.0, J=None
):
    """Return the element between bodies a and b, and its data as in jousto.h."""
    u = np.zeros((2, 3)) if u is None else u
    B = np.array([np.eye(3)] * 2) if B is None else B
    data = np.zeros(78)
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
    engine = jo.Engine(model)
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
    """Return a model of a chain of elements with everything random."""
    model = bodies(count, rng)
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
    gamma = (Qa @ half).T @ (rb - ra) / x[0] - np.array([1.0, 0, 0])
    return np.concatenate([gamma, phi / x[0]]) - x[61:67]


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
def test_forces_are_the_gradient_of_the_strain_energy(turn):
    rng = np.random.default_rng(int(1e6 * turn) + 1)
    model = beams(rng)
    engine = bent(model, rng, turn)
    engine.v[:] = engine.a[:] = 0.0
    without = jo.Engine(replace(model, beams=()))
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
@pytest.mark.parametrize("kind", [{}, {"beta": 0.07}], ids=str)
def test_tangents_are_exact(kind, turn):
    rng = np.random.default_rng(int(1e6 * turn) + 7)
    engine = bent(beams(rng, **kind), rng, turn)
    assert_tangent(engine)
