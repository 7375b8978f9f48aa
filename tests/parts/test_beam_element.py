"""Beam elements: matrices as published, rigid motion, exact static solutions."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from jousto.materials.material import Material
from jousto.parts.frames.element import (
    BeamElements,
    EulerBernoulli,
    Theory,
    Timoshenko,
    shape_functions,
)
from jousto.parts.frames.members import Member
from jousto.parts.mass import PointMass
from jousto.parts.part import Part
from jousto.sections.profiles import IBeam
from jousto.sections.section import Rectangle

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
SECTION = IBeam(height=0.2, width=0.1, web=0.0056, flange=0.0085, fillet=0.012)
STUBBY = Rectangle(0.2, 0.3)
THEORIES = (EulerBernoulli(), Timoshenko())


def shear_parameters(section: object, L: float, theory: Theory) -> tuple[float, float]:
    if isinstance(theory, EulerBernoulli):
        return 0.0, 0.0
    s = section
    G = STEEL.G
    return (
        12 * STEEL.E * s.Iz / (G * s.ky * s.A * L**2),  # type: ignore[attr-defined]
        12 * STEEL.E * s.Iy / (G * s.kz * s.A * L**2),  # type: ignore[attr-defined]
    )


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("section", [SECTION, STUBBY])
def test_stiffness_as_published(section: IBeam | Rectangle, theory: Theory) -> None:
    # Przemieniecki, Theory of Matrix Structural Analysis (1968), chapter 5, lower triangle
    L, E, G = 0.7, STEEL.E, STEEL.G
    A, Iy, Iz, J = section.A, section.Iy, section.Iz, section.J
    Py, Pz = shear_parameters(section, L, theory)
    k = np.zeros((12, 12))
    k[0, 0] = k[6, 6] = E * A / L
    k[6, 0] = -E * A / L
    k[1, 1] = k[7, 7] = 12 * E * Iz / (L**3 * (1 + Py))
    k[7, 1] = -12 * E * Iz / (L**3 * (1 + Py))
    k[2, 2] = k[8, 8] = 12 * E * Iy / (L**3 * (1 + Pz))
    k[8, 2] = -12 * E * Iy / (L**3 * (1 + Pz))
    k[3, 3] = k[9, 9] = G * J / L
    k[9, 3] = -G * J / L
    k[4, 2] = k[10, 2] = -6 * E * Iy / (L**2 * (1 + Pz))
    k[8, 4] = k[10, 8] = 6 * E * Iy / (L**2 * (1 + Pz))
    k[5, 1] = k[11, 1] = 6 * E * Iz / (L**2 * (1 + Py))
    k[7, 5] = k[11, 7] = -6 * E * Iz / (L**2 * (1 + Py))
    k[4, 4] = k[10, 10] = (4 + Pz) * E * Iy / (L * (1 + Pz))
    k[5, 5] = k[11, 11] = (4 + Py) * E * Iz / (L * (1 + Py))
    k[10, 4] = (2 - Pz) * E * Iy / (L * (1 + Pz))
    k[11, 5] = (2 - Py) * E * Iz / (L * (1 + Py))
    k = k + np.tril(k, -1).T
    K = Part.beam(L, section, 1, STEEL, theory=theory).K.toarray()
    assert_allclose(K, k, rtol=1e-13, atol=1e-13 * k.max())


@pytest.mark.parametrize("rotary", [True, False])
@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("section", [SECTION, STUBBY])
def test_consistent_mass_as_published(
    section: IBeam | Rectangle, theory: Theory, rotary: bool
) -> None:
    # Przemieniecki (1968), chapter 11: with rotary inertia r^2 = I/A and shear parameter P
    L, rho, A = 0.7, STEEL.rho, section.A
    m = np.zeros((12, 12))
    m[0, 0] = m[6, 6] = 1 / 3
    m[0, 6] = m[6, 0] = 1 / 6
    Ip = rotary * (section.Iy + section.Iz) / A
    m[3, 3] = m[9, 9] = Ip / 3
    m[3, 9] = m[9, 3] = Ip / 6
    Py, Pz = shear_parameters(section, L, theory)
    for v, t, P, r2, sign in (
        (1, 5, Py, rotary * section.Iz / A / L**2, 1.0),
        (2, 4, Pz, rotary * section.Iy / A / L**2, -1.0),
    ):
        f = (1 + P) ** 2
        m1 = (13 / 35 + 7 * P / 10 + P**2 / 3 + 6 / 5 * r2) / f
        m2 = (11 / 210 + 11 * P / 120 + P**2 / 24 + (1 / 10 - P / 2) * r2) * L / f
        m3 = (9 / 70 + 3 * P / 10 + P**2 / 6 - 6 / 5 * r2) / f
        m4 = -(13 / 420 + 3 * P / 40 + P**2 / 24 - (1 / 10 - P / 2) * r2) * L / f
        m5 = (1 / 105 + P / 60 + P**2 / 120 + (2 / 15 + P / 6 + P**2 / 3) * r2) * L**2 / f
        m6 = -(1 / 140 + P / 60 + P**2 / 120 + (1 / 30 + P / 6 - P**2 / 6) * r2) * L**2 / f
        block = np.array(
            [
                [m1, sign * m2, m3, sign * m4],
                [sign * m2, m5, -sign * m4, m6],
                [m3, -sign * m4, m1, -sign * m2],
                [sign * m4, m6, -sign * m2, m5],
            ]
        )
        i = [v, t, v + 6, t + 6]
        m[np.ix_(i, i)] = block
    M = Part.beam(L, section, 1, STEEL, theory=theory, rotary_inertia=rotary).M.toarray()
    assert_allclose(M, rho * A * L * m, rtol=1e-12, atol=1e-14 * rho * A * L)


@pytest.mark.parametrize("rotary", [True, False])
def test_lumped_mass(rotary: bool) -> None:
    L, s, rho = 0.7, SECTION, STEEL.rho
    M = Part.beam(L, s, 1, STEEL, lumped=True, rotary_inertia=rotary).M.toarray()
    half = rho * s.A * L / 2
    turning = rotary * rho * L / 2 * np.array([s.Iy + s.Iz, s.Iy, s.Iz])
    node = np.concatenate([[half] * 3, turning])
    assert_allclose(M, np.diag(np.tile(node, 2)), rtol=1e-12, atol=1e-20)


def random_frame(seed: int, theory: Theory, lumped: bool) -> Part:
    """A bent, branched frame with offsets, odd orientations and a point mass."""
    rng = np.random.default_rng(seed)
    nodes = rng.normal(size=(6, 3))
    elements = [(0, 1), (1, 2), (2, 3), (1, 4), (4, 5), (5, 3)]
    return Part.frame(
        nodes,
        elements,
        sections=[SECTION, STUBBY] * 3,
        materials=STEEL,
        orientations=rng.normal(size=(6, 3)),
        offsets=0.2 * rng.normal(size=(6, 2, 3)),
        theory=theory,
        lumped=lumped,
        point_masses=[PointMass(2, 30.0, inertia=(1.0, 2.0, 2.5), offset=rng.normal(size=3))],
    )


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("seed", range(4))
def test_rigid_motion_stores_no_energy(seed: int, theory: Theory) -> None:
    part = random_frame(seed, theory, False)
    R = part.rigid_modes()
    forces = part.K @ R
    assert np.abs(forces).max() < 1e-13 * part.K.max() * np.abs(R).max()
    # and nothing else does
    values = np.linalg.eigvalsh(part.K.toarray())
    assert np.sum(np.abs(values) < 1e-12 * values[-1]) == 6


@pytest.mark.parametrize("lumped", [True, False])
@pytest.mark.parametrize("theory", THEORIES)
def test_rotated_part_has_rotated_matrices(theory: Theory, lumped: bool) -> None:
    rng = np.random.default_rng(5)
    A = Rotation.random(random_state=3).as_matrix()
    nodes, up, arms = rng.normal(size=(3, 3)), rng.normal(size=(2, 3)), rng.normal(size=(2, 2, 3))

    def make(turn: np.ndarray) -> Part:
        return Part.frame(
            nodes @ turn.T,
            [(0, 1), (1, 2)],
            sections=SECTION,
            materials=STEEL,
            orientations=up @ turn.T,
            offsets=arms @ turn.T,
            theory=theory,
            lumped=lumped,
        )

    one, two = make(np.eye(3)), make(A)
    T = np.kron(np.eye(6), A)
    for X, Y in ((one.K, two.K), (one.M, two.M)):
        assert_allclose(Y.toarray(), T @ X.toarray() @ T.T, atol=1e-12 * X.max())


def tip_displacement(part: Part, load: np.ndarray) -> np.ndarray:
    """Return all displacements of a part clamped at its first node and loaded at its last."""
    ndof = part.K.shape[0]
    d, f = np.zeros(ndof), np.zeros(ndof)
    f[-6:] = load
    d[6:] = np.linalg.solve(part.K.toarray()[6:, 6:], f[6:])
    return d


@pytest.mark.parametrize("elements", [1, 3])
@pytest.mark.parametrize("seed", [None, 1, 2])
@pytest.mark.parametrize("theory", THEORIES)
def test_cantilever_closed_forms(theory: Theory, seed: int | None, elements: int) -> None:
    L, s, E, G = 1.3, STUBBY, STEEL.E, STEEL.G
    A = np.eye(3) if seed is None else Rotation.random(random_state=seed).as_matrix()
    part = Part.from_members(
        [Member((0, 0, 0), L * A[:, 0], s, STEEL, elements=elements, orientation=A[:, 2])],
        theory=theory,
    )
    N, Vy, Vz, T, My, Mz = load = np.array([3e5, 2e4, -5e4, 7e3, 4e3, -6e3])
    d = tip_displacement(part, np.concatenate([A @ load[:3], A @ load[3:]]))
    tip = np.concatenate([A.T @ d[-6:-3], A.T @ d[-3:]])
    shear = isinstance(theory, Timoshenko) * L / (G * s.A * 5 / 6)
    expected = [
        N * L / (E * s.A),
        Vy * L**3 / (3 * E * s.Iz) + Mz * L**2 / (2 * E * s.Iz) + Vy * shear,
        Vz * L**3 / (3 * E * s.Iy) - My * L**2 / (2 * E * s.Iy) + Vz * shear,
        T * L / (G * s.J),
        My * L / (E * s.Iy) - Vz * L**2 / (2 * E * s.Iy),
        Mz * L / (E * s.Iz) + Vy * L**2 / (2 * E * s.Iz),
    ]
    assert_allclose(tip, expected, rtol=1e-10)


@pytest.mark.parametrize("phi", [0.0, 0.3, 12.0])
def test_shape_functions_solve_the_static_equations(phi: float) -> None:
    # cantilever of one element with tip force P and moment m: closed form at every xi
    L, EI, P, m = 1.7, 2.0, 3.0, -1.0
    GkA = 12 * EI / (phi * L**2) if phi else np.inf
    one = np.ones(1)
    beams = BeamElements(
        np.zeros((1, 3)),
        np.eye(3)[None],
        L * one,
        np.zeros((1, 2, 3)),
        one,
        one,
        EI * one,
        EI * one,
        np.full((1, 2), phi),
    )

    def exact(x: float) -> tuple[float, float]:
        slope = (P * (L * x - x**2 / 2) + m * x) / EI
        v = (P * (L * x**2 / 2 - x**3 / 6) + m * x**2 / 2) / EI + P * x / GkA
        return v, slope

    v, slope = exact(L)
    d = np.zeros(12)
    d[[7, 11]] = v, slope  # xy plane
    d[[8, 10]] = v, -slope  # xz plane
    d[[6, 9]] = 0.4, 0.5
    for xi in (0.0, 0.21, 0.5, 0.83, 1.0):
        u = shape_functions(beams, xi)[0] @ d
        v, slope = exact(xi * L)
        assert_allclose(u, [0.4 * xi, v, v, 0.5 * xi, -slope, slope], rtol=1e-12, atol=1e-15)


def test_shape_functions_carry_rigid_motion() -> None:
    part = random_frame(1, Timoshenko(), False)
    points = part.mass_points
    assert points is not None
    R = part.rigid_modes()
    moved = (points.N @ R).reshape(len(points), 3, 6)
    turned = (points.N_rot @ R).reshape(len(points), 3, 6)
    for x, U, W in zip(points.position, moved, turned, strict=True):
        assert_allclose(U[:, :3], np.eye(3), atol=1e-13)
        assert_allclose(U[:, 3:], np.cross(np.eye(3), x).T, atol=1e-12)
        assert_allclose(W, np.hstack([np.zeros((3, 3)), np.eye(3)]), atol=1e-12)


def test_eccentric_end_bends() -> None:
    # node above the end of the beam: an axial force there acts with the arm a
    L, a, F, s = 1.0, 0.25, 1e4, STUBBY
    part = Part.frame(
        [(0, 0, 0), (L, a, 0)],
        [(0, 1)],
        sections=s,
        materials=STEEL,
        offsets=[[(0, 0, 0), (0, -a, 0)]],
        orientations=(0, 0, 1),
    )
    d = tip_displacement(part, np.array([F, 0, 0, 0, 0, 0]))
    EI = STEEL.E * s.Iz
    expected = [F * L / (STEEL.E * s.A) + a**2 * F * L / EI, -a * F * L**2 / (2 * EI)]
    assert_allclose(d[6:8], expected, rtol=1e-10)
    assert_allclose(d[11], -a * F * L / EI, rtol=1e-10)


def test_timoshenko_coefficients_override_the_section() -> None:
    L, s, P = 0.4, STUBBY, 1e3
    tips = []
    for theory in (Timoshenko(), Timoshenko(ky=0.5, kz=0.4)):
        part = Part.beam(L, s, 2, STEEL, theory=theory)
        tips.append(tip_displacement(part, np.array([0, P, P, 0, 0, 0]))[-5:-3])
    shear = P * L / (STEEL.G * s.A) * np.array([2 - 6 / 5, 2.5 - 6 / 5])
    assert_allclose(tips[1] - tips[0], shear, rtol=1e-9)


def test_default_orientation() -> None:
    # section height stands upright; along z it points towards x
    for direction, height in (((1, 0, 0), 2), ((0, 1, 0), 2), ((1, 1, 0), 2), ((0, 0, 1), 0)):
        part = Part.from_members([Member((0, 0, 0), direction, Rectangle(0.1, 0.2), STEEL)])
        assert part.stress is not None
        top = part.stress.positions[part.stress.index("e1.a.top")]
        assert_allclose(top, 0.1 * np.eye(3)[height], atol=1e-15)
