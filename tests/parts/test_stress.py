"""Stress at section points against the closed forms of a cantilever with end loads."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from jousto.base.errors import InputError
from jousto.materials.material import Material
from jousto.parts.frames.element import EulerBernoulli, Theory, Timoshenko
from jousto.parts.frames.stress import StressOperator, section_forces
from jousto.parts.part import Part
from jousto.sections.profiles import Box, IBeam
from jousto.sections.section import Circle, GeneralSection, Rectangle, Section, SectionPoint, Tube

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
L = 1.2


def cantilever(section: Section, elements: int, theory: Theory, A: np.ndarray) -> Part:
    x = np.linspace(0.0, L, elements + 1)[:, None] * A[:, 0]
    return Part.frame(
        x,
        [(i, i + 1) for i in range(elements)],
        sections=section,
        materials=STEEL,
        orientations=A[:, 2],
        theory=theory,
    )


def solve(part: Part, load: np.ndarray) -> np.ndarray:
    d = np.zeros((part.K.shape[0], 1))
    f = np.zeros(part.K.shape[0] - 6)
    f[-6:] = load
    d[6:, 0] = np.linalg.solve(part.K.toarray()[6:, 6:], f)
    return d


@pytest.mark.parametrize("theory", [EulerBernoulli(), Timoshenko()])
@pytest.mark.parametrize("seed", [None, 4])
@pytest.mark.parametrize(
    "section",
    [
        Rectangle(0.06, 0.1),
        Circle(0.08),
        Tube(0.08, 0.01),
        IBeam(height=0.2, width=0.1, web=0.0056, flange=0.0085),
        Box(0.06, 0.1, web=0.004),
    ],
)
def test_cantilever(section: Section, seed: int | None, theory: Theory) -> None:
    A = np.eye(3) if seed is None else Rotation.random(random_state=seed).as_matrix()
    part = cantilever(section, 2, theory, A)
    N, Vy, Vz, T, My, Mz = load = np.array([2e4, 3e3, -4e3, 500.0, 800.0, -900.0])
    d = solve(part, np.concatenate([A @ load[:3], A @ load[3:]]))
    stress = part.stress
    assert stress is not None
    S = stress.evaluate(d)
    assert S.shape == (len(stress.sites), 6, 1)

    scale = np.abs(S).max()
    for site, x, axes, s in zip(
        stress.sites, stress.positions, stress.axes, S[..., 0], strict=True
    ):
        element, end, name = site.split(".")
        p = next(p for p in section.points if p.name == name)
        along = (int(element[1:]) - 1 + (end == "b")) * L / 2
        assert_allclose(A.T @ x, [along, p.y, p.z], atol=1e-14)
        assert_allclose(axes, A, atol=1e-14)
        # equilibrium of the piece beyond the cut
        arm = L - along
        my, mz = My - Vz * arm, Mz + Vy * arm
        s11 = N / section.A + my * p.z / section.Iy - mz * p.y / section.Iz
        shear = np.array(p.shear) @ [Vy, Vz, T]
        assert_allclose(s, [s11, 0, 0, shear[0], 0, shear[1]], atol=1e-9 * scale)


def test_textbook_numbers() -> None:
    # rectangle b x h: P L/(b h^2/6), 1.5 P/(b h), T/(0.208 a^3); top fibre in tension when pushed
    # down at the tip
    part = cantilever(Rectangle(0.05, 0.05), 1, EulerBernoulli(), np.eye(3))
    assert part.stress is not None
    d = solve(part, np.array([0, 0, -1000.0, 250.0, 0, 0]))[:, 0]
    S = part.stress.evaluate(d)
    at = part.stress.index
    assert_allclose(S[at("e1.a.top"), 0], 1000 * L / (0.05**3 / 6), rtol=1e-10)
    assert_allclose(S[at("e1.b.top"), 0], 0.0, atol=1e-9 * S[at("e1.a.top"), 0])
    assert_allclose(S[at("e1.a.centre"), 5], -1.5 * 1000 / 0.05**2, rtol=1e-9)
    # Timoshenko and Goodier: k2 = 0.208 for the square, three digits
    assert_allclose(S[at("e1.a.top"), 3], -250 / (0.208 * 0.05**3), rtol=2e-3)
    twist = S[at("e1.a.left"), 5] + 1.5 * 1000 / 0.05**2
    assert_allclose(twist, 250 / (0.208 * 0.05**3), rtol=2e-3)


def test_rigid_motion_has_no_stress() -> None:
    part = cantilever(
        Rectangle(0.06, 0.1), 3, Timoshenko(), Rotation.random(random_state=1).as_matrix()
    )
    assert part.stress is not None
    S = part.stress.evaluate(part.rigid_modes())
    assert S.shape == (3 * 2 * 9, 6, 6)
    assert np.abs(S).max() < 1e-11 * abs(part.stress.matrix).max()


def test_offset_ends_are_in_equilibrium() -> None:
    # the force on the node, taken at the end of the beam with its arm
    rng = np.random.default_rng(2)
    arms = 0.2 * rng.normal(size=(1, 2, 3))
    part = Part.frame(
        [(0, 0, 0), (L, 0.1, 0.2)],
        [(0, 1)],
        sections=Circle(0.08),
        materials=STEEL,
        offsets=arms,
    )
    load = rng.normal(size=6) * 1e3
    d = solve(part, load)[:, 0]
    assert part.stress is not None
    S = part.stress.evaluate(d)
    axes = part.stress.axes[0]
    F, M = axes.T @ load[:3], axes.T @ (load[3:] + np.cross(-arms[0, 1], load[:3]))
    r, I = 0.04, Circle(0.08).Iy
    A = Circle(0.08).A
    i = part.stress.index
    assert_allclose(S[i("e1.b.top"), 0], F[0] / A + M[1] * r / I, rtol=1e-9)
    assert_allclose(S[i("e1.b.left"), 0], F[0] / A - M[2] * r / I, rtol=1e-9)
    assert_allclose(S[i("e1.b.left"), 5], 4 * F[2] / (3 * A) + M[0] * r / (2 * I), rtol=1e-9)
    assert_allclose(
        part.stress.positions[i("e1.b.top")],
        [L, 0.1, 0.2] + arms[0, 1] + r * axes[:, 2],
        rtol=1e-12,
    )


def test_section_forces_of_the_beams_balance() -> None:
    from jousto.parts.frames.element import BeamElements

    one = np.ones(1)
    beams = BeamElements(
        np.zeros((1, 3)),
        np.eye(3)[None],
        L * one,
        np.zeros((1, 2, 3)),
        *4 * [one],
        np.zeros((1, 2)),
    )
    f = section_forces(beams)[0] @ np.random.default_rng(0).normal(size=12)
    assert_allclose(f[1, :4], f[0, :4], rtol=1e-12)
    assert_allclose(f[0, 4], f[1, 4] - L * f[0, 2], rtol=1e-12)
    assert_allclose(f[0, 5], f[1, 5] + L * f[0, 1], rtol=1e-12)


def test_mixed_sections_and_selection() -> None:
    bare = GeneralSection(A=1e-3, Iy=1e-6, Iz=1e-6, J=1e-6, ky=0.8, kz=0.8)
    marked = GeneralSection(
        A=1e-3, Iy=1e-6, Iz=1e-6, J=1e-6, ky=0.8, kz=0.8, points=(SectionPoint("rib", 0.01, 0.02),)
    )
    part = Part.frame(
        [(0, 0, 0), (1, 0, 0), (2, 0, 0), (3, 0, 0)],
        [(0, 1), (1, 2), (2, 3)],
        sections=[Circle(0.08), bare, marked],
        materials=STEEL,
    )
    stress = part.stress
    assert stress is not None
    assert stress.sites[:2] == ("e1.a.top", "e1.a.bottom")
    assert stress.sites[-2:] == ("e3.a.rib", "e3.b.rib")
    d = np.random.default_rng(0).normal(size=24)
    picked = stress.select(["e3.b.rib", "e1.a.left"])
    both = [stress.index("e3.b.rib"), stress.index("e1.a.left")]
    assert_allclose(picked.evaluate(d), stress.evaluate(d)[both])
    assert_allclose(picked.positions[0], [3.0, 0.01, 0.02])
    with pytest.raises(InputError, match="no site 'e3.b.ribs'; did you mean 'e3.b.rib'"):
        stress.index("e3.b.ribs")
    assert Part.beam(1.0, bare, 1, STEEL).stress is None


@pytest.mark.parametrize("section", [Circle(0.04), Tube(0.04, 0.004)], ids=["circle", "tube"])
def test_a_round_beam_bent_in_any_plane(section: Section) -> None:
    """``M r / I`` at an end load in any direction; at worst 7.5 degrees from a point: 0.9 %."""
    part = Part.beam(L, section, 3, STEEL)
    assert isinstance(part.stress, StressOperator)
    for degrees in (0.0, 20.0, 37.5, 45.0):
        c, s = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
        f = np.zeros(part.K.shape[0])
        f[-5:-3] = 100.0 * c, 100.0 * s
        d = np.zeros_like(f)
        d[6:] = np.linalg.solve(part.K.toarray()[6:, 6:], f[6:])
        found = np.abs(part.stress.evaluate(d)[:, 0]).max()
        assert 0.991 < found / (100.0 * L * 0.02 / section.Iy) < 1.0 + 1e-9


def test_both_faces_of_a_web() -> None:
    """Shear of the force and of torsion add on one face of the web and subtract on the other."""
    points = {p.name: p for p in IBeam(height=0.2, width=0.1, web=0.006, flange=0.009).points}
    for name in ("web", "web_top", "web_bottom"):
        left, right = points[name], points.get(f"{name}_right")
        assert right is not None
        assert (right.y, right.z) == (-left.y, left.z)
        force, torque = 1.0, 0.01
        sums = [force * p.shear[1][1] + torque * p.shear[1][2] for p in (left, right)]
        # thin walls: T t / J at the faces, about the mean of the shear force alone
        assert np.mean(sums) == pytest.approx(force * left.shear[1][1], rel=1e-12)
        assert abs(sums[0] - sums[1]) == pytest.approx(2.0 * torque * abs(left.shear[1][2]))
        assert left.shear[1][2] == -right.shear[1][2] != 0.0
