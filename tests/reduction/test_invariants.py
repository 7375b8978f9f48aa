"""Inertia invariants against direct sums over explicit particles."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from jousto.base.errors import InputError
from jousto.parts.part import Part
from jousto.reduction.fields.invariants import (
    Invariants,
    invariants_from_matrix,
    invariants_from_points,
)
from jousto.reduction.methods import CraigBampton
from jousto.reduction.reducer import reduce
from reduction.bodies import (
    Particles,
    bent,
    dofs,
    lattice,
    particles,
    pendulum,
    skew,
    without_points,
)

BODIES = {
    "lumped": lambda: bent(lumped=True, rotary=False, mass=False),
    "lumped-rotary": lambda: bent(lumped=True, rotary=True),
    "consistent": lambda: bent(lumped=False, rotary=False),
    "consistent-rotary": lambda: bent(lumped=False, rotary=True),
    "pendulum": pendulum,
}


@pytest.fixture(params=BODIES, ids=list(BODIES))
def case(request: pytest.FixtureRequest, rng: np.random.Generator) -> tuple[Invariants, Particles]:
    part = BODIES[request.param]()
    assert part.mass_points is not None
    X = rng.standard_normal((part.M.shape[0], 4))
    return invariants_from_points(part.mass_points, X), particles(part.mass_points, X)


def close(a: object, b: object, rel: float = 1e-12) -> None:
    a, b = np.asarray(a), np.asarray(b)
    assert a.shape == b.shape
    assert np.abs(a - b).max() <= rel * np.abs(b).max()


def test_integrals(case: tuple[Invariants, Particles]) -> None:
    v, c = case
    n = v.n
    u0_ = np.array([skew(u) for u in c.u0])
    phi_ = np.array([[skew(c.phi[i, :, j]) for j in range(n)] for i in range(len(c.m))])
    close(v.I1, c.m.sum())
    close(v.I2, c.m @ c.u0)
    close(v.I3, np.einsum("i,iaj->aj", c.m, c.phi))
    close(v.I4, np.einsum("i,iab,ibj->aj", c.m, u0_, c.phi))
    close(v.I5, np.einsum("i,ijab,ibk->jak", c.m, phi_, c.phi))
    close(v.I6, np.einsum("i,iaj,iak->jk", c.m, c.phi, c.phi))
    close(v.I7, np.einsum("i,iba,ibc->ac", c.m, u0_, u0_))
    close(v.I8, np.einsum("i,iba,ijbc->jac", c.m, u0_, phi_))
    close(v.I9, np.einsum("i,ijba,ikbc->jkac", c.m, phi_, phi_))
    close(v.second_moment, np.einsum("i,ia,ib->ab", c.m, c.u0, c.u0))
    close(v.N0, np.einsum("i,ia,ibj->jab", c.m, c.u0, c.phi))
    close(v.E, np.einsum("i,iaj,ibk->jkab", c.m, c.phi, c.phi))


def test_mass_matrix_and_velocity_terms(
    case: tuple[Invariants, Particles], rng: np.random.Generator
) -> None:
    """Equations of Rantalainen 2007, section 3.6, with A = E, against Newton for each particle."""
    v, c = case
    n = v.n
    scale = 1.0 / np.sqrt(np.abs(v.E).max())
    p, dp, w = (
        scale * rng.standard_normal(n),
        scale * rng.standard_normal(n),
        rng.standard_normal(3),
    )
    w_ = skew(w)

    M = np.zeros((6 + n, 6 + n))
    Q = np.zeros(6 + n)
    for m, u0, phi in zip(c.m, c.u0, c.phi, strict=True):
        u = u0 + phi @ p
        B = np.hstack([np.eye(3), -skew(u), phi])
        M += m * B.T @ B
        Q -= m * B.T @ (w_ @ w_ @ u + 2.0 * w_ @ phi @ dp)

    S = v.I2 + v.I3 @ p
    I8, I9, I5 = v.I8, v.I9, v.I5
    J = v.I7 + np.einsum("jab,j->ab", I8 + I8.transpose(0, 2, 1), p)
    J = J + np.einsum("jkab,j,k->ab", I9, p, p)
    M_wp = v.I4 + np.einsum("jak,j->ak", I5, p)
    close(M[:3, :3], v.I1 * np.eye(3))
    close(M[:3, 3:6], -skew(S))
    close(M[:3, 6:], v.I3)
    close(M[3:6, 3:6], J)
    close(M[3:6, 6:], M_wp)
    close(M[6:, 6:], v.I6)

    spin = I8 + np.einsum("kjab,k->jab", I9, p)
    Q_R = -(w_ @ w_ @ S + 2.0 * w_ @ v.I3 @ dp)
    Q_w = -w_ @ J @ w - 2.0 * np.einsum("j,jab,b->a", dp, spin, w)
    centrifugal = I8.transpose(0, 2, 1) + np.einsum("jkab,k->jab", I9, p)
    coriolis = np.einsum("jak,k->ja", I5, dp)
    Q_p = np.einsum("a,jab,b->j", w, centrifugal, w) + 2.0 * coriolis @ w
    close(Q, np.concatenate([Q_R, Q_w, Q_p]))


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.booleans(), st.booleans())
def test_derived_invariants_are_consistent(seed: int, lumped: bool, rotary: bool) -> None:
    part = bent(lumped=lumped, rotary=rotary, elements=2)
    assert part.mass_points is not None
    X = np.random.default_rng(seed).standard_normal((part.M.shape[0], 3))
    v = invariants_from_points(part.mass_points, X)
    R = part.rigid_modes()
    close(v.I6, X.T @ part.M @ X, 1e-12)
    close(np.vstack([v.I3, v.I4]), R.T @ part.M @ X, 1e-11)
    close(v.I7, R[:, 3:].T @ part.M @ R[:, 3:], 1e-11)
    assert np.array_equal(v.E, v.E.transpose(1, 0, 3, 2))
    assert np.array_equal(v.second_moment, v.second_moment.T)


def test_matrix_path_equals_point_path_for_lumped_mass(rng: np.random.Generator) -> None:
    part = bent(lumped=True, rotary=False, mass=False)
    X = rng.standard_normal((part.M.shape[0], 5))
    assert part.mass_points is not None
    a = invariants_from_points(part.mass_points, X)
    b = invariants_from_matrix(part.M, part.nodes, 6, X)
    compare(a, b, 1e-12)


def test_matrix_path_is_exact_for_isoparametric_mass(rng: np.random.Generator) -> None:
    """``int u_a u_b dm = u_a^T Mbar u_b`` for fields interpolated by one set of functions."""
    part = lattice()
    assert part.mass_points is None
    X = rng.standard_normal((part.M.shape[0], 4))
    v = reduce(part, CraigBampton(("foot",), modes=3)).invariants
    assert v.I6 == pytest.approx(np.eye(v.n), abs=1e-10)
    v = invariants_from_matrix(part.M, part.nodes, 3, X)
    Mbar = part.M.toarray()[::3, ::3]
    x, phi = part.nodes, X.reshape(-1, 3, 4)
    close(v.mass, Mbar.sum())
    close(v.first_moment, Mbar.sum(axis=0) @ x)
    close(v.second_moment, x.T @ Mbar @ x)
    close(v.I3, np.einsum("ik,kaj->aj", Mbar, phi))
    close(v.N0, np.einsum("ia,ik,kbj->jab", x, Mbar, phi))
    close(v.E, np.einsum("iaj,ik,kbl->jlab", phi, Mbar, phi))


def test_matrix_path_of_beams_converges() -> None:
    """Consistent mass of beams has no exact nodal form: the error falls with the elements."""
    errors = []
    for elements in (2, 4, 8, 16):
        part = bent(elements=elements, rotary=False, mass=False)
        reduced = reduce(part, CraigBampton(("start",), modes=3))
        X = dofs(reduced.modes, reduced.rotations)
        v = invariants_from_matrix(part.M, part.nodes, 6, X)
        assert np.abs(np.vstack([v.I3, v.I4])).max() < 1e-10
        close(v.I6, np.eye(v.n), 1e-10)
        errors.append(np.abs(v.E - reduced.invariants.E).max())
    # second order in the element length; of the largest of all entries, which is not always the
    # same one, so that it falls a little faster
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx(2.0, abs=0.35)


def test_modes_do_not_depend_on_the_path() -> None:
    part = bent(lumped=True, rotary=False, mass=False)
    a = reduce(part, CraigBampton(("start",), modes=4))
    b = reduce(without_points(part), CraigBampton(("start",), modes=4))
    compare(a.invariants, b.invariants, 1e-12)


def compare(a: Invariants, b: Invariants, rel: float) -> None:
    close(a.mass, b.mass, rel)
    close(a.first_moment, b.first_moment, rel)
    close(a.second_moment, b.second_moment, rel)
    size = np.sqrt(a.mass)
    assert np.abs(a.I3 - b.I3).max() < rel * size * max(1.0, np.abs(a.E).max() ** 0.5)
    close(a.N0, b.N0, rel)
    close(a.E, b.E, rel)


def test_problems_are_reported_together() -> None:
    E = np.zeros((1, 1, 3, 3))
    E[0, 0, 0, 1] = 1.0
    with pytest.raises(InputError) as error:
        Invariants(
            -1.0, np.zeros(3), np.full((3, 3), np.nan), np.zeros((3, 1)), np.zeros((1, 3)), E
        )
    text = str(error.value)
    for part in ("mass is -1 kg", "second_moment[0, 0] is nan", "N0 has shape (1, 3)", "E[k, j]"):
        assert part in text


def test_mean_axis_modes_carry_no_momentum() -> None:
    part: Part = bent()
    v = reduce(part, CraigBampton(("start", "end"), modes=5)).invariants
    assert np.abs(v.I3).max() < 1e-12 * np.sqrt(v.mass)
    assert np.abs(v.I4).max() < 1e-12 * np.sqrt(np.trace(v.I7))
