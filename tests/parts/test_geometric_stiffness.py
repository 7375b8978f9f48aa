"""Geometric stiffness of beams against closed forms of stability."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

from jousto.base.errors import InputError
from jousto.materials.material import Material
from jousto.parts.frames.element import EulerBernoulli, Timoshenko
from jousto.parts.frames.members import Member
from jousto.parts.part import Part
from jousto.sections.section import Circle, Rectangle

Array = NDArray[np.float64]
STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
SECTION = Rectangle(0.02, 0.03)
SLENDER = EulerBernoulli()


def held(part: Part, fixed: Sequence[tuple[int, str]]) -> NDArray[np.intp]:
    """Free degrees of freedom; supports as (node, "xyzrst"), rst being rotations."""
    gone = [6 * node + "xyzrst".index(c) for node, letters in fixed for c in letters]
    return np.setdiff1d(np.arange(part.K.shape[0]), gone)


def critical(part: Part, fixed: Sequence[tuple[int, str]], load: Array) -> float:
    """Least factor of a load at which the part buckles: (K + c Kg) x = 0."""
    free = held(part, fixed)
    K = part.K.toarray()[np.ix_(free, free)]
    d = np.zeros(part.K.shape[0])
    d[free] = np.linalg.solve(K, load[free])
    Kg = part.geometric_stiffness(d).toarray()[np.ix_(free, free)]
    return float(1.0 / scipy.linalg.eigh(-Kg, K, eigvals_only=True)[-1])


def load(part: Part, node: int, dof: int, value: float = 1.0) -> Array:
    f = np.zeros(part.K.shape[0])
    f[6 * node + dof] = value
    return f


@pytest.mark.parametrize(
    ("supports", "factor"),
    [("cantilever", 0.25), ("pinned", 1.0)],
)
def test_euler_column(supports: str, factor: float) -> None:
    """pi^2 E I/(4 L^2) and pi^2 E I/L^2 about the weak axis, with the fourth order of h."""
    length, errors = 2.0, []
    exact = factor * np.pi**2 * STEEL.E * min(SECTION.Iy, SECTION.Iz) / length**2
    for n in (1, 2, 4) if supports == "cantilever" else (2, 4, 8):
        part = Part.beam(length, SECTION, n, STEEL, theory=SLENDER)
        fixed = {"cantilever": [(0, "xyzrst")], "pinned": [(0, "xyzr"), (n, "yz")]}[supports]
        errors.append(critical(part, fixed, load(part, n, 0, -1.0)) / exact - 1.0)
    assert np.all(np.array(errors) > 0.0)
    assert errors[-1] < 1e-4
    assert np.log2(errors[1] / errors[2]) > 3.8


def test_column_with_shear_deformation() -> None:
    """Engesser: 1/P = 1/P_Euler + 1/(k G A) for the pin-ended column.

    Timoshenko and Gere, *Theory of Elastic Stability* (1961), art. 2.17.
    """
    length, n = 0.4, 16
    section, k = Circle(0.05), 0.85
    part = Part.beam(length, section, n, STEEL, theory=Timoshenko(ky=k, kz=k))
    euler = np.pi**2 * STEEL.E * section.Iy / length**2
    exact = 1.0 / (1.0 / euler + 1.0 / (k * STEEL.G * section.A))
    found = critical(part, [(0, "xyzr"), (n, "yz")], load(part, n, 0, -1.0))
    assert found == pytest.approx(exact, rel=1e-3)
    assert exact < 0.98 * euler


def test_direction_in_space_does_not_matter() -> None:
    a, direction = np.array([0.3, -0.2, 0.5]), np.array([2.0, -1.0, 2.0]) / 3.0
    part = Part.from_members([Member(a, a + 2.0 * direction, SECTION, STEEL, elements=4)])
    f = np.zeros(30)
    f[24:27] = -direction
    straight = Part.beam(2.0, SECTION, 4, STEEL)
    expected = critical(straight, [(0, "xyzrst")], load(straight, 4, 0, -1.0))
    assert critical(part, [(0, "xyzrst")], f) == pytest.approx(expected, rel=1e-9)


def test_lateral_buckling_in_pure_bending() -> None:
    """M = pi/L sqrt(E I_weak G J) of a narrow beam on forks, bent in its stiff plane.

    Timoshenko and Gere (1961), art. 6.3; deflections before buckling are left out in both.
    """
    section, length, errors = Rectangle(0.1, 0.01), 2.0, []
    Iz, J = max(section.Iy, section.Iz), section.J
    Iy = min(section.Iy, section.Iz)
    assert Iz == section.Iy or Iz == section.Iz
    exact = np.pi / length * np.sqrt(STEEL.E * Iy * STEEL.G * J)
    stiff = 5 if section.Iz > section.Iy else 4
    for n in (4, 8, 16):
        part = Part.beam(length, section, n, STEEL, theory=SLENDER)
        f = load(part, 0, stiff, 1.0) + load(part, n, stiff, -1.0)
        found = critical(part, [(0, "xyzr"), (n, "yzr")], f)
        errors.append(abs(found / exact - 1.0))
    assert errors[-1] < 5e-3
    assert errors[2] < 0.3 * errors[1] < 0.1 * errors[0]


def test_rigid_arm_is_a_stiff_beam() -> None:
    """A column on a rigid arm of a quarter of its length, against the closed form.

    Rigid length a at the tip, L flexible, force along the axis at the end of the arm:
    tan(k L) = 1/(k a), the shape being a sine that ends in a straight line.
    """
    a, L, n = 0.5, 1.5, 8
    nodes = np.zeros((n + 1, 3))
    nodes[:, 0] = np.linspace(0.0, L, n + 1)
    nodes[n, 0] = L + a
    offsets = np.zeros((n, 2, 3))
    offsets[n - 1, 1, 0] = -a
    part = Part.frame(
        nodes,
        [[i, i + 1] for i in range(n)],
        sections=SECTION,
        materials=STEEL,
        offsets=offsets,
        theory=SLENDER,
    )
    from scipy.optimize import brentq

    k = brentq(lambda k: np.sin(k * L) * k * a - np.cos(k * L), 1e-3, np.pi / (2.0 * L))
    found = critical(part, [(0, "xyzrst")], load(part, n, 0, -1.0))
    assert found == pytest.approx(k**2 * STEEL.E * min(SECTION.Iy, SECTION.Iz), rel=1e-4)


def test_matrices_have_none() -> None:
    beam = Part.beam(1.0, SECTION, 2, STEEL)
    part = Part.from_matrices(beam.M, beam.K, beam.nodes)
    with pytest.raises(InputError, match="only parts of beams"):
        part.geometric_stiffness(np.zeros(18))
    with pytest.raises(InputError, match="displacements"):
        beam.geometric_stiffness(np.zeros(17))
