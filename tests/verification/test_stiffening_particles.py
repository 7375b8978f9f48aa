"""The quadratic displacement field of stiffening against sums over particles.

A particle of a lumped frame is fixed to its node at s, which moves by ``Phi p + chi(p, p)/2`` and
turns by the rotation vector ``Psi p + chi^r(p, p)/2``; to second order in p the particle is at

``u0 + s + (Phi + Psi x s) p + 1/2 (chi(p, p) + chi^r(p, p) x s + theta x (theta x s))``.

Its kinetic energy is kept to second order in (p, p') together; all there is of second order beyond
the linear body are ``tr(N) E - N`` of ``N = sum m u0 u2^T`` in J, u2 the quadratic part: the rest
has to vanish by the choice of chi. Bodies of more than 32 modes take another path in the engine.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import jousto as jo
from verification.mechanisms import orders
from verification.particles import beam_particles, rotation, skew
from verification.test_brute_force import MATERIAL, SECTION

pytestmark = pytest.mark.filterwarnings("ignore:.*(has no joint to another|nothing will move)")

GRAVITY = np.array([1.0, -9.0, 3.0])
NODES = np.array(
    [[0, 0, 0], [0.6, 0, 0], [1.1, 0.1, 0], [1.1, 0.5, 0.3], [1.1, 0.5, 0.9], [0.9, 0.2, 1.4]]
    + [[0.7, 0.1, 1.8], [0.2, 0.1, 2.0]]
)
ELEMENTS = np.stack([np.arange(7), np.arange(1, 8)], axis=1)
CASES = {"point masses": (12, False), "32 modes at most": (20, True), "tiles": (40, True)}


class Stiffened:
    """A free stiffened frame, its particles and their quadratic parts u2 (k, 3, n, n)."""

    def __init__(self, modes, rotary):
        part = jo.Part.frame(
            NODES,
            ELEMENTS,
            sections=SECTION,
            materials=MATERIAL,
            lumped=True,
            rotary_inertia=rotary,
            theory=jo.parts.EulerBernoulli(),
        )
        self.reduced = jo.reduce(part, jo.FreeFree(modes=modes), stiffening=True)
        self.body = jo.FlexibleBody("frame", self.reduced, damping=0.01)
        self.particles = beam_particles(self.body, SECTION, MATERIAL, lumped=True, rotary=rotary)
        self.n, self.model = modes, jo.compile(jo.Mechanism(self.body, jo.Gravity(GRAVITY)))
        field, Psi = self.reduced.stiffening, self.reduced.rotations
        self.u2 = []
        for x in self.particles.u0:
            node = int(np.argmin(np.linalg.norm(NODES - x, axis=1)))
            s = skew(x - NODES[node])
            pull = np.einsum("aj,bk,cab->cjk", Psi[node], Psi[node], nested(x - NODES[node]))
            turned = np.einsum("ab,bjk->ajk", -s, field.rotations[node])
            self.u2.append(field.translations[node] + turned + 0.5 * (pull + pull.swapaxes(1, 2)))
        self.u2 = np.array(self.u2)

    def state(self, size=0.02):
        rng = np.random.default_rng(3)
        q = rng.normal(size=self.model.nq)
        q[3:7] /= np.linalg.norm(q[3:7])
        q[7:] *= size / np.sqrt(self.n)
        return q, rng.normal(size=self.model.nv)

    def mass_matrix(self, p):
        """M (6+n, 6+n): that of the linear body, and J to second order."""
        M = self.particles.mass_matrix(p)
        bend = np.einsum("kcij,i,j->kc", self.u2, p, p)
        N = np.einsum("k,ka,kb->ab", self.particles.m, self.particles.u0, bend)
        M[3:6, 3:6] += np.trace(N) * np.eye(3) - 0.5 * (N + N.T)
        return M

    def kinetic(self, p, x):
        """Energy of particles that go along with the quadratic field, x = [A^T R', w, p']."""
        u = self.particles.shape(p) + 0.5 * np.einsum("kcij,i,j->kc", self.u2, p, p)
        rate = self.particles.Phi @ x[6:] + np.einsum("kcij,i,j->kc", self.u2, p, x[6:])
        speed = x[:3] + np.cross(x[3:6], u) + rate
        return 0.5 * float(np.einsum("k,ka,ka", self.particles.m, speed, speed))


def nested(s):
    """Tensor of ``theta x (eta x s) = eta (theta . s) - s (theta . eta)``: [c, theta, eta]."""
    E = np.eye(3)
    return np.einsum("ce,t->cte", E, s) - np.einsum("c,te->cte", s, E)


@cache
def stiffened(case):
    return Stiffened(*CASES[case])


@pytest.mark.parametrize("case", CASES)
def test_the_quadratic_field_carries_no_momentum(case):
    body = stiffened(case)
    m, u0 = body.particles.m, body.particles.u0
    size = np.einsum("k,kcij->cij", m, np.abs(body.u2)).max()
    assert np.abs(np.einsum("k,kcij->cij", m, body.u2)).max() < 1e-10 * size
    turn = np.einsum("k,kcij->cij", m, np.cross(u0[:, :, None, None], body.u2, axis=1))
    assert np.abs(turn).max() < 1e-10 * size


@pytest.mark.parametrize("case", CASES)
def test_mass_matrix_and_accelerations(case):
    # Lagrange's (Boltzmann-Hamel) equations of T = x^T M(p) x / 2, M of second degree in p:
    #   P = M x;  P_R' + w x P_R = 0;  P_w' + w x P_w + V x P_R = 0;  P_p' - dT/dp = 0
    body = stiffened(case)
    engine = jo.model.Engine(body.model)
    q, v = body.state()
    engine.q[:], engine.v[:] = q, v
    A, p, w, pd = rotation(q[3:7]), q[7:], v[3:6], v[6:]
    M = body.mass_matrix(p)
    np.testing.assert_allclose(engine.mass_matrix(0), M, rtol=0, atol=1e-12 * np.abs(M).max())
    assert np.abs(M - body.particles.mass_matrix(p)).max() > 1e-7 * np.abs(M).max()
    x = np.concatenate([A.T @ v[:3], w, pd])
    np.testing.assert_allclose(engine.energy()[0], 0.5 * x @ M @ x, rtol=1e-12)

    # central differences of a polynomial of second degree are exact at any step
    h = 0.02
    slope = []
    for e in np.eye(body.n):
        slope.append((body.mass_matrix(p + h * e) - body.mass_matrix(p - h * e)) / (2 * h))
    P, Q = M @ x, -np.einsum("jab,j,b->a", slope, pd, x)
    Q[:3] -= np.cross(w, P[:3])
    Q[3:6] -= np.cross(w, P[3:6]) + np.cross(x[:3], P[:3])
    Q[6:] += 0.5 * np.einsum("jab,a,b->j", slope, x, x)
    Q += M[:, :3] @ (np.cross(w, x[:3]) + A.T @ GRAVITY)  # A^T R'' = V' + w x V
    Q[6:] -= body.reduced.stiffness * p + body.body.modal_damping * pd
    a = engine.accelerations()[0]
    local = np.concatenate([A.T @ a[:3], a[3:]])
    np.testing.assert_allclose(M @ local, Q, rtol=0, atol=1e-11 * np.abs(Q).max())


@pytest.mark.parametrize("case", CASES)
def test_kinetic_energy_is_kept_to_second_order(case):
    body = stiffened(case)
    engine = jo.model.Engine(body.model)
    q, v = body.state(size=1.0)
    errors, linear = [], []
    q[7 + 6 :] = v[6 + 6 :] = 0.0  # six modes: higher ones have large terms of fourth order
    for size in (0.016, 0.008, 0.004):
        scaled, rates = np.array(q), np.array(v)
        scaled[7:] *= size
        rates[6:] *= size
        engine.q[:], engine.v[:] = scaled, rates
        x = np.concatenate([rotation(q[3:7]).T @ v[:3], v[3:6], rates[6:]])
        exact = body.kinetic(scaled[7:], x)
        errors.append(abs(engine.energy()[0] - exact))
        linear.append(abs(0.5 * x @ body.particles.mass_matrix(scaled[7:]) @ x - exact))
    assert orders(errors)[-1] == pytest.approx(3.0, abs=0.2), errors
    assert orders(linear)[-1] == pytest.approx(2.0, abs=0.2), linear
    assert errors[-1] < 0.1 * linear[-1]
