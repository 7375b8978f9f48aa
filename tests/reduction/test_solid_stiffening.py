"""Geometric stiffness and second-order displacements of solids: closed forms and laws."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

from jousto.base.errors import InputError
from jousto.materials.material import Material
from jousto.parts.frames.element import EulerBernoulli
from jousto.parts.interface import Interface
from jousto.parts.mass import PointMass
from jousto.parts.part import Part
from jousto.reduction.fields.stiffening import stiffening
from jousto.reduction.methods import FreeFree
from jousto.reduction.reducer import reduce
from jousto.sections.section import Rectangle
from parts.grids import ALL, grid

Array = NDArray[np.float64]
# no contraction, so that beam theory is met closely
STEEL = Material(E=200e9, nu=0.0, rho=7850.0)


@cache
def bar(kind: str = "hexahedron20", n: int = 10) -> Part:
    """A slender bar 1 m x 20 mm x 10 mm along x, its axis through the origin."""
    return Part.solid(
        grid(kind, (n, 1, 1), (1.0, 0.02, 0.01), bend=lambda x: x - [0, 0.01, 0.005]), STEEL
    )


def clamped(part: Part) -> NDArray[np.intp]:
    """Degrees of freedom that remain when the root is held."""
    return np.flatnonzero(np.repeat(part.nodes[:, 0] > 1e-9, 3))


@pytest.mark.parametrize("kind", ALL)
def test_rigid_rotation_is_one_to_second_order(kind: str) -> None:
    """d = theta x u0 must become exp(theta~) u0: chi = theta x (theta x u0), for any two axes.

    Up to the rigid rotation b that leaves no angular momentum: axial(int u0 chi^T dm) = 0.
    """
    mesh = grid(kind, (2, 1, 1), (0.5, 0.3, 0.2), distort=0.2)
    mesh = mesh.with_set("end", np.flatnonzero(mesh.nodes[:, 0] > 0.5 - 1e-9))
    mesh = mesh.with_set("root", np.flatnonzero(mesh.nodes[:, 0] < 1e-9))
    masses = (PointMass(0, 3.0), PointMass("end", 20.0, (0.5, 0.6, 0.7), (0.1, 0.0, 0.2)))
    ties = (Interface("pin", "root"), Interface("pad", "end", kind="average", at=(0.6, 0, 0)))
    part = Part.solid(mesh, STEEL, point_masses=masses, interfaces=ties)
    x = part.nodes - part.center
    turns = np.stack([np.cross(e, x).ravel() for e in np.eye(3)], axis=1)
    found = stiffening(part, turns)
    G = 0.5 * np.trace(part.inertia) * np.eye(3) - part.inertia  # int u0 u0^T dm
    for j in range(3):
        for k in range(3):
            T = 0.5 * (np.outer(np.eye(3)[j], np.eye(3)[k]) + np.outer(np.eye(3)[k], np.eye(3)[j]))
            T = T - (j == k) * np.eye(3)
            GT = G @ T
            axial = np.array([GT[1, 2] - GT[2, 1], GT[2, 0] - GT[0, 2], GT[0, 1] - GT[1, 0]])
            b = -np.linalg.solve(part.inertia, axial)
            turn = np.cross(b, np.eye(3))  # x @ turn = b x x
            N = GT + G @ turn
            assert found.second_moment[j, k] == pytest.approx(N, abs=1e-10)
            assert found.translations[:-2, :, j, k] == pytest.approx(x @ (T + turn), abs=1e-10)
            # the reference nodes of the ties go along, and turn by b
            at = np.stack([tie.at for tie in part.ties]) - part.center
            assert found.translations[-2:, :, j, k] == pytest.approx(at @ (T + turn), abs=1e-10)
            assert found.rotations[-2:, :, j, k] == pytest.approx(np.tile(b, (2, 1)), abs=1e-10)


@pytest.mark.parametrize("kind", ALL)
def test_duality_with_geometric_stiffness(kind: str) -> None:
    """f . chi(p, p) = -p^T Kg(f) p for any self-equilibrated load f."""
    part = Part.solid(grid(kind, (3, 1, 1), (0.5, 0.1, 0.2), distort=0.2), STEEL)
    R = part.rigid_modes()
    f = np.random.default_rng(5).standard_normal(part.K.shape[0])
    f -= R @ np.linalg.lstsq(R, f, rcond=None)[0]
    d = np.linalg.lstsq(part.K.toarray(), f, rcond=1e-12)[0]
    r = reduce(part, FreeFree(modes=5), stiffening=True)
    assert r.stiffening is not None
    X = r.modes.reshape(-1, r.n)
    Kg = part.geometric_stiffness(d)
    assert abs(Kg - Kg.T).max() < 1e-12 * abs(Kg).max()
    expected = -X.T @ (Kg @ X)
    work = np.einsum("d,djk->jk", f, r.stiffening.translations.reshape(-1, r.n, r.n))
    assert work == pytest.approx(expected, abs=1e-7 * np.abs(expected).max())


def test_tension_of_a_bar() -> None:
    """A bar under the force N turned by a small angle: moment N L theta, energy N L theta^2/2."""
    part = bar()
    u = np.zeros((len(part.nodes), 3))
    u[:, 0] = 1e-3 * part.nodes[:, 0]
    Kg = part.geometric_stiffness(u.ravel())
    turn = part.rigid_modes()[:, 5]
    force = 1e-3 * STEEL.E * 0.02 * 0.01
    # x^T Kg x of a turn about z: s11 (dv/dx)^2 + s11 (du/dx)^2 with du/dx = 0
    assert turn @ Kg @ turn == pytest.approx(force * 1.0, rel=1e-12)


@pytest.mark.parametrize("kind", ["hexahedron20", "wedge15", "tetra10"])
def test_euler_column(kind: str) -> None:
    """A clamped column buckles at ``pi^2 E I/(4 L^2)`` over 1 + its share of shear.

    Engesser's reduction P/(1 + P/(k G A)) is 2e-5 here; quadratic elements at this mesh are within
    a quarter of a per cent.
    """
    part = bar(kind, 16)
    free = clamped(part)
    u = np.zeros((len(part.nodes), 3))
    u[:, 0] = -part.nodes[:, 0] / (STEEL.E * 0.02 * 0.01)  # 1 N
    Kg = part.geometric_stiffness(u.ravel()).toarray()[np.ix_(free, free)]
    K = part.K.toarray()[np.ix_(free, free)]
    found = 1.0 / scipy.linalg.eigh(-Kg, K, eigvals_only=True)[-1]
    exact = np.pi**2 * STEEL.E * Rectangle(0.02, 0.01).Iy / 4.0
    exact = min(exact, np.pi**2 * STEEL.E * Rectangle(0.02, 0.01).Iz / 4.0)
    assert found == pytest.approx(exact, rel=2.5e-3)


@pytest.mark.parametrize(("speed", "flap"), [(0.0, 3.5160), (3.0, 4.7973), (6.0, 7.3604)])
def test_rotating_cantilever(speed: float, flap: float) -> None:
    """First flap frequency of a cantilever that turns about z, in ``sqrt(E I/(rho A L^4))``.

    Published values as in tests/verification/test_rotating_beam.py (Wright et al. 1982): the
    stress of the centrifugal force stiffens, its change with the displacement across (in the plane
    of rotation and along the blade) softens.
    """
    part = bar(n=12)
    free = clamped(part)
    unit = np.sqrt(STEEL.E * 0.02 * 0.01**3 / 12.0 / (STEEL.rho * 0.02 * 0.01))
    M, K = part.M.toarray(), part.K.toarray()
    in_plane = np.tile([1.0, 1.0, 0.0], len(part.nodes))
    spin = (speed * unit) ** 2 * M * in_plane
    pull = (spin @ part.nodes.ravel())[free]
    d = np.zeros(len(M))
    d[free] = np.linalg.solve(K[np.ix_(free, free)], pull)
    total = (K + part.geometric_stiffness(d).toarray() - spin)[np.ix_(free, free)]
    # the thin direction is z
    values, vectors = scipy.linalg.eigh(total, M[np.ix_(free, free)], subset_by_index=[0, 3])
    flaps = [v for v, x in zip(values, vectors.T, strict=True) if np.abs(x[2::3]).max() > 1.0]
    assert np.sqrt(flaps[0]) / unit == pytest.approx(flap, rel=2e-3)


def test_memory_is_refused_before_it_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("jousto.reduction.fields.stiffening.LARGEST_FIELD", 1e5)
    with pytest.raises(InputError, match=r"stiffening of 9 modes .* fewer modes \(up to 5\)"):
        reduce(bar(), FreeFree(modes=9), stiffening=True)


def test_foreshortening_as_a_beam() -> None:
    """A solid bar draws its ends together as a beam of the same section does."""
    part = bar(n=12)
    solid = reduce(part, FreeFree(modes=2), stiffening=True)
    beam = reduce(
        Part.beam(1.0, Rectangle(0.01, 0.02), 12, STEEL, theory=EulerBernoulli()),
        FreeFree(modes=2),
        stiffening=True,
    )
    assert solid.stiffening is not None
    assert beam.stiffening is not None
    np.testing.assert_allclose(solid.frequencies, beam.frequencies, rtol=4e-3)
    ends = [int(np.argmin(np.linalg.norm(part.nodes - [x, 0.01, 0.005], axis=1))) for x in (0, 1)]
    chi, theirs = solid.stiffening.translations, beam.stiffening.translations
    for j in range(2):
        found = chi[ends[1], 0, j, j] - chi[ends[0], 0, j, j]
        wanted = theirs[-1, 0, j, j] - theirs[0, 0, j, j]
        assert found == pytest.approx(wanted, rel=5e-3)
