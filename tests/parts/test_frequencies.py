"""Natural frequencies against closed forms, with the order of convergence."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
from numpy.testing import assert_allclose
from scipy.optimize import brentq

from jousto.base.errors import JoustoWarning
from jousto.materials.material import Material
from jousto.parts.frames.element import EulerBernoulli, Theory, Timoshenko
from jousto.parts.mass import PointMass
from jousto.parts.part import Part
from jousto.sections.section import Rectangle

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
SECTION = Rectangle(0.1, 0.06)
L = 1.5
UY, RZ = 1, 5


def frequencies(part: Part, dofs: list[int], fixed: list[tuple[int, int]]) -> np.ndarray:
    """Return the angular frequencies of the part moving in some nodal directions only.

    ``fixed`` lists (node, direction) pairs; negative nodes count from the end.
    """
    nn = len(part.nodes)
    keep = [
        6 * i + j
        for i in range(nn)
        for j in dofs
        if (i, j) not in fixed and (i - nn, j) not in fixed
    ]
    K, M = part.K.toarray()[np.ix_(keep, keep)], part.M.toarray()[np.ix_(keep, keep)]
    values = scipy.linalg.eigh(K, M, eigvals_only=True)
    return np.sqrt(np.maximum(values, 0.0))


def beam(elements: int, theory: Theory, rotary: bool = False, lumped: bool = False) -> Part:
    return Part.beam(
        L, SECTION, elements, STEEL, theory=theory, rotary_inertia=rotary, lumped=lumped
    )


# frequency equations of Euler-Bernoulli beams in x = beta L: Blevins, Formulas for Natural
# Frequency and Mode Shape (1979), table 8-1, and intervals that hold one root each
CLAMPED = (lambda x: np.cos(x) - 1.0 / np.cosh(x), [(4, 5), (7, 8), (10, 12)])
SUPPORTS = {
    "pinned": ([(0, UY), (-1, UY)], 0, (np.sin, [(3, 4), (6, 7), (9, 10)])),
    "cantilever": (
        [(0, UY), (0, RZ)],
        0,
        (lambda x: np.cos(x) + 1.0 / np.cosh(x), [(1, 3), (4, 5), (7, 8)]),
    ),
    "free": ([], 2, CLAMPED),
    "clamped": ([(0, UY), (0, RZ), (-1, UY), (-1, RZ)], 0, CLAMPED),
}


def bending_frequencies(support: str) -> np.ndarray:
    """Return the exact angular frequencies of the first three modes."""
    equation, intervals = SUPPORTS[support][2]
    roots = np.array([brentq(equation, *i, xtol=1e-13) for i in intervals])
    return (roots / L) ** 2 * np.sqrt(STEEL.E * SECTION.Iz / (STEEL.rho * SECTION.A))


def test_roots_as_printed() -> None:
    # Blevins (1979), table 8-1
    w = bending_frequencies("cantilever") / np.sqrt(STEEL.E * SECTION.Iz / (STEEL.rho * SECTION.A))
    assert_allclose(np.sqrt(w) * L, [1.87510407, 4.69409113, 7.85475744], rtol=1e-8)
    w = bending_frequencies("free") / np.sqrt(STEEL.E * SECTION.Iz / (STEEL.rho * SECTION.A))
    assert_allclose(np.sqrt(w) * L, [4.73004074, 7.85320462, 10.9956078], rtol=1e-8)


@pytest.mark.parametrize("support", SUPPORTS)
def test_euler_bernoulli_bending(support: str) -> None:
    fixed, rigid, _ = SUPPORTS[support]
    exact = bending_frequencies(support)
    errors = []
    for n in (8, 16):
        w = frequencies(beam(n, EulerBernoulli()), [UY, RZ], fixed)
        errors.append(w[rigid : rigid + 3] / exact - 1.0)
        assert np.all(errors[-1] > 0.0)  # Rayleigh: from above
    # cubic elements: fourth order
    assert_allclose(np.log2(errors[0] / errors[1]), 4.0, atol=0.25)
    assert np.all(errors[1] < 2e-4)


def timoshenko_pinned(mode: int) -> float:
    """Lower root of the frequency equation of a pinned Timoshenko beam.

    ``EI k^4 - m w^2 - rho I (1 + E/(kappa G)) k^2 w^2 + rho^2 I/(kappa G) w^4 = 0`` with
    ``k = mode pi/L``: Timoshenko, Young, Weaver, Vibration Problems in Engineering.
    """
    E, G, rho, I, A = STEEL.E, STEEL.G, STEEL.rho, SECTION.Iz, SECTION.A
    k, kappa = mode * np.pi / L, 5 / 6
    a = rho**2 * I / (kappa * G)
    b = -(rho * A + rho * I * (1 + E / (kappa * G)) * k**2)
    c = E * I * k**4
    return float(np.sqrt((-b - np.sqrt(b**2 - 4 * a * c)) / (2 * a)))


def test_timoshenko_bending() -> None:
    exact = np.array([timoshenko_pinned(i) for i in (1, 2, 3)])
    errors = {}
    for n in (4, 8, 32, 64):
        w = frequencies(beam(n, Timoshenko(), rotary=True), [UY, RZ], [(0, UY), (-1, UY)])
        errors[n] = w[:3] / exact - 1.0
        assert np.all(errors[n] > 0.0)
    # between fourth order (elements much longer than the section is high) and second order
    # (shorter, because the shear force is constant within an element)
    assert np.all(np.log2(errors[4] / errors[8]) > 2.4)
    assert_allclose(np.log2(errors[32] / errors[64]), 2.0, atol=0.1)
    assert np.all(errors[64] < 1e-4)
    # the slender theory is far off at this slenderness: the test would see a missing shear term
    slender = (3 * np.pi / L) ** 2 * np.sqrt(STEEL.E * SECTION.Iz / (STEEL.rho * SECTION.A))
    assert slender / exact[2] > 1.05


@pytest.mark.parametrize("lumped", [False, True])
@pytest.mark.parametrize("kind", ["stretching", "twisting"])
def test_rods(kind: str, lumped: bool) -> None:
    # one end fixed: (2 i - 1) pi/2 c/L
    if kind == "stretching":
        dof, c = 0, np.sqrt(STEEL.E / STEEL.rho)
    else:
        Ip = SECTION.Iy + SECTION.Iz
        dof, c = 3, np.sqrt(STEEL.G * SECTION.J / (STEEL.rho * Ip))
    exact = np.array([1, 3]) * np.pi / 2 * c / L
    errors = []
    for n in (10, 20, 40):
        part = beam(n, EulerBernoulli(), rotary=True, lumped=lumped)
        errors.append(frequencies(part, [dof], [(0, dof)])[:2] / exact - 1.0)
    # consistent mass from above, lumped from below, second order
    assert np.all(np.array(errors) * (-1 if lumped else 1) > 0.0)
    assert_allclose(np.log2(errors[1] / errors[2]), 2.0, atol=0.05)


def test_lumped_bending_converges_to_the_same() -> None:
    exact = bending_frequencies("cantilever")
    errors = []
    for n in (8, 16, 32):
        part = beam(n, EulerBernoulli(), lumped=True)
        # static condensation of the massless rotations
        K, M = part.K.toarray(), part.M.toarray().diagonal()
        v, r = 6 * np.arange(1, n + 1) + UY, 6 * np.arange(1, n + 1) + RZ
        Kvv = K[np.ix_(v, v)] - K[np.ix_(v, r)] @ np.linalg.solve(K[np.ix_(r, r)], K[np.ix_(r, v)])
        w = np.sqrt(scipy.linalg.eigh(Kvv, np.diag(M[v]), eigvals_only=True))
        errors.append(w[:3] / exact - 1.0)
    assert_allclose(np.log2(errors[1] / errors[2]), 2.0, atol=0.15)


def test_tip_mass() -> None:
    # massless cantilever with a tip mass: w^2 = 3 EI/(m L^3)
    light = Material(E=210e9, nu=0.3, rho=0.0)
    part = Part.beam(
        L, SECTION, 3, light, theory=EulerBernoulli(), point_masses=[PointMass("end", 20.0)]
    )
    assert part.mass == pytest.approx(20.0, rel=1e-14)
    K, M = part.K.toarray()[6:, 6:], part.M.toarray()[6:, 6:]
    flexibility = np.linalg.inv(K)
    w2 = 1.0 / (flexibility @ M)[-6 + UY, -6 + UY]
    assert w2 == pytest.approx(3 * light.E * SECTION.Iz / (20.0 * L**3), rel=1e-9)


def test_units_of_mm_t_s() -> None:
    si = beam(4, Timoshenko(), rotary=True)
    with pytest.warns(JoustoWarning):
        steel = Material(E=210e3, nu=0.3, rho=7.85e-9)
    mm = Part.beam(1e3 * L, Rectangle(100.0, 60.0), 4, steel)
    assert mm.mass * 1e3 == pytest.approx(si.mass, rel=1e-13)
    assert_allclose(mm.inertia * 1e-3, si.inertia, rtol=1e-12, atol=1e-12)
    w = [np.sqrt(scipy.linalg.eigvalsh(p.K.toarray(), p.M.toarray())[6:]) for p in (si, mm)]
    assert_allclose(w[1], w[0], rtol=1e-8)
    # a displacement in mm gives MPa
    assert si.stress is not None and mm.stress is not None
    d = np.random.default_rng(0).normal(size=si.K.shape[0])
    d_mm = d.reshape(-1, 2, 3) * np.array([1e3, 1.0])[:, None]
    assert_allclose(
        mm.stress.evaluate(d_mm.ravel()) * 1e6,
        si.stress.evaluate(d),
        rtol=1e-10,
        atol=1e-12 * si.stress.matrix.max(),
    )
