"""The engine's M, Q, energy and accelerations of one body against sums over particles.

Rantalainen 2007, eqs. 3.40-3.67, say what the invariants stand for: integrals over the body. Here
the integrals are taken particle by particle (`particles`: own Gauss rule, own Hermite polynomials,
own section particles) at random states with random mass-orthonormal modes. 1e-12 relative is
round-off of sums of a few hundred terms; nothing is truncated in either of the two.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification.particles import beam_particles, rigid_particles, rotation, skew

pytestmark = pytest.mark.filterwarnings("ignore:.*(has no joint to another|nothing will move)")

NODES = np.array(
    [[0, 0, 0], [0.6, 0, 0], [1.1, 0.1, 0], [1.1, 0.5, 0.3], [1.1, 0.5, 0.9], [0.9, 0.2, 1.4]]
)
ELEMENTS = np.array([[0, 1], [1, 2], [2, 3], [3, 4], [4, 5]])
SECTION = jo.Rectangle(0.08, 0.05)
MATERIAL = jo.Material(E=3e9, nu=0.3, rho=4000.0)
N = 7


def random_modes(M, rng, n=N):
    """Mass-orthonormal random columns, as large at every node."""
    X = rng.normal(size=(M.shape[0], n))
    L = np.linalg.cholesky(X.T @ (M @ X))
    return X @ np.linalg.inv(L).T


def random_state(model, rng):
    q = rng.normal(size=model.nq)
    q[3:7] /= np.linalg.norm(q[3:7])
    q[7:] *= 0.3
    return q, rng.normal(size=model.nv) * 2.0


def flexible(lumped, rotary, rng, **options):
    part = jo.Part.frame(
        NODES,
        ELEMENTS,
        sections=SECTION,
        materials=MATERIAL,
        lumped=lumped,
        rotary_inertia=rotary,
        theory=jo.parts.EulerBernoulli(),
    )
    X = random_modes(part.M, rng)
    reduced = jo.reduction.from_modes(part, X, rng.uniform(1, 5, N))
    return jo.FlexibleBody("frame", reduced, damping=list(rng.uniform(0, 0.3, N)), **options)


def particles_of(body, lumped, rotary):
    return beam_particles(body, SECTION, MATERIAL, lumped=lumped, rotary=rotary)


def engine_at(body, rng, gravity=(1.0, -9.0, 3.0)):
    model = jo.compile(jo.Mechanism(body, jo.Gravity(gravity)))
    engine = jo.model.Engine(model)
    q, v = random_state(model, rng)
    engine.q[:], engine.v[:] = q, v
    return engine, q, v


def compare(engine, particles, q, v, K, D, gravity):
    M = particles.mass_matrix(q[7:])
    Q = particles.forces(q, v, np.asarray(gravity), K, D)
    found = engine.mass_matrix(0)
    np.testing.assert_allclose(found, M, rtol=0, atol=1e-12 * np.abs(M).max())
    a = np.linalg.solve(M, Q)
    a[:3] = rotation(q[3:7]) @ a[:3]
    acceleration = engine.accelerations()[0]
    # a solve amplifies round-off by the condition of M
    tolerance = 1e-12 * np.abs(a).max() * max(1.0, np.linalg.cond(M) / 1e3)
    np.testing.assert_allclose(acceleration, a, rtol=0, atol=tolerance)
    # Q itself: M a with the engine's acceleration
    local = np.concatenate([rotation(q[3:7]).T @ acceleration[:3], acceleration[3:]])
    np.testing.assert_allclose(M @ local, Q, rtol=0, atol=1e-12 * np.abs(Q).max())
    np.testing.assert_allclose(engine.energy()[0], particles.kinetic(q, v), rtol=1e-12)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("rotary", [True, False], ids=["rotary", "no rotary"])
@pytest.mark.parametrize("lumped", [True, False], ids=["lumped", "consistent"])
def test_modal_body_equals_the_sum_over_its_particles(lumped, rotary, seed):
    rng = np.random.default_rng(seed)
    body = flexible(lumped, rotary, rng)
    particles = particles_of(body, lumped, rotary)
    # the particles know nothing of the FE mass matrix, but give the same modal mass
    np.testing.assert_allclose(
        particles.mass_matrix(np.zeros(N))[6:, 6:], np.eye(N), rtol=0, atol=1e-12
    )
    engine, q, v = engine_at(body, rng)
    K, D = np.asarray(body.reduced.stiffness), np.asarray(body.modal_damping)
    compare(engine, particles, q, v, K, D, (1.0, -9.0, 3.0))
    energy = engine.energy()
    np.testing.assert_allclose(energy[1], 0.5 * K @ q[7:] ** 2, rtol=1e-12)
    height = particles.m @ particles.positions(q)
    np.testing.assert_allclose(energy[2], -height @ [1.0, -9.0, 3.0], rtol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_rigid_body_equals_the_sum_over_its_particles(seed):
    rng = np.random.default_rng(seed)
    G = np.diag(rng.uniform(0.1, 1.0, 3))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    G = turn @ G @ turn.T
    J = np.trace(G) * np.eye(3) - G
    body = jo.RigidBody("stone", 3.7, J, center=rng.normal(size=3))
    particles = rigid_particles(3.7, J, np.asarray(body.center))
    engine, q, v = engine_at(body, rng)
    compare(engine, particles, q, v, np.zeros(0), np.zeros(0), (1.0, -9.0, 3.0))


def test_matrices_of_another_program_give_the_same_body():
    # no mass points are known, only M: its bilinear forms give the same mass matrix at p = 0
    rng = np.random.default_rng(5)
    own = flexible(False, False, rng)
    part = jo.Part.frame(
        NODES,
        ELEMENTS,
        sections=SECTION,
        materials=MATERIAL,
        rotary_inertia=False,
        theory=jo.parts.EulerBernoulli(),
    )
    foreign = jo.Part.from_matrices(part.M, part.K, NODES, dofs_per_node=6)
    X = np.concatenate([own.reduced.modes, own.reduced.rotations], axis=1).reshape(-1, N)
    body = jo.FlexibleBody("frame", jo.reduction.from_modes(foreign, X, own.reduced.frequencies))
    M = particles_of(own, False, False).mass_matrix(np.zeros(N))
    found = jo.model.Engine(jo.compile(jo.Mechanism(body))).mass_matrix(0)
    np.testing.assert_allclose(found, M, rtol=0, atol=1e-12 * np.abs(M).max())


def approximate_mass_matrix(particles, p, dropped):
    """M(p) with I5 or I9 left out, from its invariants (Rantalainen 2007, eqs. 3.49-3.67)."""
    M = particles.mass_matrix(p)
    at_zero = particles.mass_matrix(0 * p)
    if "I5" in dropped:  # M_wp = I4 + sum p_j I5_j
        M[3:6, 6:], M[6:, 3:6] = at_zero[3:6, 6:], at_zero[6:, 3:6]
    if "I9" in dropped:  # J = I7 + sum (I8_j + I8_j^T) p_j + sum sum I9_jk p_j p_k
        moved = np.array([skew(x) for x in particles.Phi @ p])
        M[3:6, 3:6] -= np.einsum("k,kba,kbc->ac", particles.m, moved, moved)
    return M


@pytest.mark.parametrize("dropped", [(), ("I5",), ("I9",), ("I5", "I9")])
def test_dropped_invariants_are_dropped_and_the_rest_stays_a_lagrangian_system(dropped):
    # section 3.6.2 of the thesis. What is left must still be Lagrange's (Boltzmann-Hamel)
    # equations of T = v^T M(p) v / 2, else the approximate body would create energy:
    #   P = M v;  P_R' + w x P_R = 0;  P_w' + w x P_w + V x P_R = 0;  P_p' - dT/dp = 0
    rng = np.random.default_rng(7)
    body = flexible(False, True, rng, drop_invariants=dropped)
    particles = particles_of(body, False, True)
    engine, q, v = engine_at(body, rng)
    q[7:] *= 0.05  # the approximation needs small deformations to keep M positive
    engine.q[:] = q
    A, p, w, pd = rotation(q[3:7]), q[7:], v[3:6], v[6:]

    def M_at(p):
        return approximate_mass_matrix(particles, p, dropped)

    M = M_at(p)
    np.testing.assert_allclose(engine.mass_matrix(0), M, rtol=0, atol=1e-12 * np.abs(M).max())
    assert dropped == () or np.abs(M - particles.mass_matrix(p)).max() > 1e-6

    V = A.T @ v[:3]
    x = np.concatenate([V, w, pd])
    P = M @ x
    # M(p) is a quadratic polynomial: central differences are exact
    slope = [(M_at(p + e) - M_at(p - e)) / 2 for e in np.eye(N)]
    Q = -np.einsum("jab,j,b->a", slope, pd, x)
    Q[:3] -= np.cross(w, P[:3])
    Q[3:6] -= np.cross(w, P[3:6]) + np.cross(V, P[:3])
    Q[6:] += 0.5 * np.einsum("jab,a,b->j", slope, x, x)
    Q += M[:, :3] @ (np.cross(w, V) + A.T @ [1.0, -9.0, 3.0])  # A^T R'' = V' + w x V
    Q[6:] -= body.reduced.stiffness * p + body.modal_damping * pd
    a = engine.accelerations()[0]
    local = np.concatenate([A.T @ a[:3], a[3:]])
    np.testing.assert_allclose(M @ local, Q, rtol=0, atol=1e-11 * np.abs(Q).max())
