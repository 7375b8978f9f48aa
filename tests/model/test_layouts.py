"""Small and large bodies lie differently in memory; both must follow the particles."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.base.arrays import skew
from jousto.base.rotations import rotation_matrix
from jousto.model.compile import axial, half_inertia_rate
from jousto.model.elimination_order import eliminate
from jousto.model.model import BodyModel, Model

SYMMETRIC = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


def cloud(rng, n, particles):
    """Particles with mass-orthonormal mode shapes."""
    mass = rng.uniform(1, 2, particles)
    u0 = rng.normal(size=(particles, 3))
    Phi = rng.normal(size=(particles, 3, n))
    L = np.linalg.cholesky(np.einsum("k,kaj,kal->jl", mass, Phi, Phi))
    return mass, u0, np.einsum("kaj,lj->kal", Phi, np.linalg.inv(L))


def body_model(mass, u0, Phi, K, D):
    U0 = np.einsum("k,ka,kb->ab", mass, u0, u0)
    J = np.trace(U0) * np.eye(3) - U0
    N0 = np.einsum("k,ka,kbj->jab", mass, u0, Phi)
    E = np.einsum("k,kaj,kbl->ljab", mass, Phi, Phi)  # E[j, k] = int phi_k phi_j^T dm
    return BodyModel(
        name="cloud",
        iq=0,
        iv=0,
        mass=np.array([mass.sum()]),
        S0=mass @ u0,
        J0=np.array([J[i, j] for i, j in SYMMETRIC]),
        I3=np.einsum("k,kaj->aj", mass, Phi),
        B0=axial(N0),
        D0=half_inertia_rate(N0),
        ED=half_inertia_rate(E),
        EB=axial(E),
        K=K,
        D=D,
    )


@pytest.mark.parametrize("complex_scalars", [False, True])
@pytest.mark.parametrize("n", [1, 3, 4, 5, 31, 32, 33, 41])
def test_mass_matrix_and_accelerations_are_those_of_the_particles(rng, n, complex_scalars):
    mass, u0, Phi = cloud(rng, n, 3 + n)
    K, D = rng.uniform(1, 10, n), rng.uniform(0.1, 1, n)
    g = np.array([1.0, -9.0, 3.0])
    e = rng.normal(size=4)
    q = np.concatenate([rng.normal(size=3), e / np.linalg.norm(e), 0.3 * rng.normal(size=n)])
    v = rng.normal(size=6 + n)
    body = body_model(mass, u0, Phi, K, D)
    model = Model("cloud", g, (body,), (), 0, (), (), (), (), eliminate([], []), q, v)
    engine = jo.model.Engine(model, complex_scalars=complex_scalars)
    a, _ = engine.accelerations()

    p, pd, w = q[7:], v[6:], v[3:6]
    A = rotation_matrix(q[3:7])
    u = u0 + Phi @ p
    jacobian = np.concatenate(
        [np.tile(np.eye(3), (len(mass), 1, 1)), np.stack([-skew(x) for x in u]), Phi], axis=2
    )
    M = np.einsum("k,kai,kaj->ij", mass, jacobian, jacobian)
    bias = np.cross(w, np.cross(w, u)) + 2 * np.cross(w, Phi @ pd)
    Q = np.einsum("k,kai,ka->i", mass, jacobian, A.T @ g - bias)
    Q[6:] -= K * p + D * pd
    expected = np.linalg.solve(M, Q)
    expected[:3] = A @ expected[:3]
    scale = np.abs(expected).max()
    np.testing.assert_allclose(engine.mass_matrix(0), M, atol=1e-12 * np.abs(M).max())
    np.testing.assert_allclose(a, expected, atol=1e-11 * scale)
