"""Critical planes: enclosing circles, closed forms of tension with torsion, damage per plane."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import jousto as jo
from jousto.fatigue.multiaxial.enclosing_ball import enclosing_ball, enclosing_circles
from jousto.fatigue.multiaxial.planes import normals, on_planes

T = np.linspace(0.0, 2.0 * np.pi, 361)


def tension_torsion(sigma: float, tau: float, phase: float, mean: float = 0.0) -> np.ndarray:
    s = np.zeros((len(T), 6))
    s[:, 0] = sigma * np.sin(T) + mean
    s[:, 3] = tau * np.sin(T + phase)
    return s


def test_known_circles_and_balls() -> None:
    # right triangle: the hypotenuse is the diameter; equilateral: 1/sqrt(3); a point; a segment
    sets = np.array(
        [
            [[0, 0], [4, 0], [0, 3], [1, 1]],
            [[0, 0], [1, 0], [0.5, 3**0.5 / 2], [0.5, 0.2]],
            [[2, 2], [2, 2], [2, 2], [2, 2]],
            [[-1, -1], [0, 0], [1, 1], [0.5, 0.5]],
        ],
        dtype=float,
    )
    centre, radius = enclosing_circles(sets)
    assert radius == pytest.approx([2.5, 1 / 3**0.5, 0.0, 2**0.5], abs=1e-9)
    assert centre[0] == pytest.approx([2.0, 1.5])
    # corners of a cube in five dimensions and of a simplex
    cube = np.array(np.meshgrid(*[[-1.0, 1.0]] * 5)).reshape(5, -1).T
    centre, r = enclosing_ball(cube + 3.0)
    assert (r, centre) == (pytest.approx(5**0.5), pytest.approx(np.full(5, 3.0)))
    _, r = enclosing_ball(np.eye(5))
    assert r == pytest.approx(math.sqrt(0.8))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 60))
def test_circles_hold_all_and_cannot_be_smaller(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(3, count, 2)) * rng.uniform(0, 5, 2)
    centre, radius = enclosing_circles(points)
    away = np.linalg.norm(points - centre[:, None], axis=2)
    assert np.all(away.max(axis=1) <= radius * (1 + 1e-8) + 1e-9)
    for p, c, r, d in zip(points, centre, radius, away, strict=True):
        # the points on the circle lie around its centre: no half-plane holds all of them
        rim = p[d > r - 1e-6 * max(r, 1e-12)] - c
        angle = np.sort(np.arctan2(rim[:, 1], rim[:, 0]))
        gaps = np.diff(np.append(angle, angle[0] + 2 * np.pi))
        assert gaps.max() <= np.pi + 1e-3 or (r == 0.0 and np.all(p == p[0]))
    ball = enclosing_ball(points[0])
    assert ball[1] == pytest.approx(radius[0], rel=1e-6, abs=1e-9)


def test_stress_on_planes() -> None:
    rng = np.random.default_rng(1)
    s = rng.normal(size=(4, 6))
    n = normals(0.4)
    assert np.linalg.norm(n, axis=1) == pytest.approx(np.ones(len(n)))
    sn, t = on_planes(s, n)
    for i, v in enumerate(s):
        S = np.array([[v[0], v[3], v[5]], [v[3], v[1], v[4]], [v[5], v[4], v[2]]])
        traction = n @ S
        assert sn[:, i] == pytest.approx(np.einsum("mi,mi->m", traction, n))
        length = np.linalg.norm(traction - sn[:, i, None] * n, axis=1)
        assert np.linalg.norm(t[:, i], axis=1) == pytest.approx(length)


@pytest.mark.parametrize("k", [0.0, 0.2, 0.5])
def test_findley_in_phase(k: float) -> None:
    # Mohr's circle: f = k sigma/2 + sqrt(sigma^2/4 + tau^2) sqrt(1 + k^2)
    for sigma, tau in ((100e6, 0.0), (0.0, 80e6), (100e6, 60e6)):
        found = jo.fatigue.critical_plane(tension_torsion(sigma, tau, 0.0), jo.fatigue.Findley(k))
        want = 0.5 * k * sigma + math.hypot(sigma / 2, tau) * math.sqrt(1 + k * k)
        assert found.value == pytest.approx(want, rel=1e-5)
    # tension alone: the angle of the plane is tan(2 theta) = 1/k
    found = jo.fatigue.critical_plane(tension_torsion(100e6, 0.0, 0.0), jo.fatigue.Findley(k))
    theta = math.acos(abs(found.normal[0]))
    assert 2 * theta == pytest.approx(math.atan2(1.0, k), abs=2e-3)
    assert jo.fatigue.Findley(k).equivalent(found.value) == pytest.approx(100e6, rel=1e-5)


@pytest.mark.parametrize("phase", [0.0, 30.0, 60.0, 90.0])
def test_findley_out_of_phase(phase: float) -> None:
    # on planes through the axis of the shaft's radius all is harmonic: with complex amplitudes
    # s_n = s cos^2 a + t e^(i phi) sin 2a, t_n = -s/2 sin 2a + t e^(i phi) cos 2a
    sigma, tau, k = 100e6, 50e6, 0.3
    e = tau * np.exp(1j * math.radians(phase))
    a = np.linspace(0.0, np.pi, 20001)
    sn = np.abs(sigma * np.cos(a) ** 2 + e * np.sin(2 * a))
    tn = np.abs(-0.5 * sigma * np.sin(2 * a) + e * np.cos(2 * a))
    want = (tn + k * sn).max()
    found = jo.fatigue.critical_plane(
        tension_torsion(sigma, tau, math.radians(phase)), jo.fatigue.Findley(k)
    )
    # samples every degree miss the peak of a sine by 4e-5
    assert found.value == pytest.approx(want, rel=1e-4)
    assert abs(found.normal[2]) < 0.02


def test_findley_a_quarter_of_a_turn_out_of_phase() -> None:
    # tau = sigma/2: the shear amplitude is sigma/2 on all planes along the shaft's radius, and the
    # critical one is the cross-section, f = sigma (1/2 + k); samples as above
    sigma, k = 100e6, 0.3
    found = jo.fatigue.critical_plane(
        tension_torsion(sigma, 50e6, 0.5 * math.pi), jo.fatigue.Findley(k)
    )
    assert found.value == pytest.approx(sigma * (0.5 + k), rel=1e-4)
    assert abs(found.normal[0]) == pytest.approx(1.0, abs=1e-3)


def test_mean_stress_opens_the_plane() -> None:
    # tension with mean: t_a + k (s_m + s_a) cos^2 theta: closed form of Mohr's circle
    k, sa, sm = 0.3, 100e6, 60e6
    found = jo.fatigue.critical_plane(tension_torsion(sa, 0.0, 0.0, sm), jo.fatigue.Findley(k))
    top = k * (sa + sm)
    assert found.value == pytest.approx(0.5 * top + 0.5 * math.hypot(sa, top), rel=1e-5)


def turned_history() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A history of stress, the same in other axes, and the rotation between."""
    s = tension_torsion(100e6, 70e6, 1.0, 40e6)
    Q = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    S = np.array(
        [[s[:, 0], s[:, 3], s[:, 5]], [s[:, 3], s[:, 1], s[:, 4]], [s[:, 5], s[:, 4], s[:, 2]]]
    )
    R = np.einsum("ai,ijt,bj->abt", Q, S, Q)
    r = np.stack([R[0, 0], R[1, 1], R[2, 2], R[0, 1], R[1, 2], R[0, 2]], axis=1)
    return s, r, Q


ON_PLANES = (
    jo.fatigue.Findley(0.3),
    jo.fatigue.FatemiSocie(S_y=400e6, E=210e9),
    jo.fatigue.NormalStress(),
)


@pytest.mark.parametrize("criterion", [*ON_PLANES, jo.fatigue.DangVan(0.36, 155e6)], ids=repr)
def test_turning_the_axes_does_not_change_the_value(criterion: object) -> None:
    s, r, _ = turned_history()
    a, b = jo.fatigue.critical_plane(s, criterion), jo.fatigue.critical_plane(r, criterion)
    # samples of the planes: the search ends 1e-3 rad from the top, 1e-6 of the value
    assert a.value == pytest.approx(b.value, rel=2e-5)


@pytest.mark.parametrize("criterion", ON_PLANES, ids=repr)
def test_turning_the_axes_turns_the_plane(criterion: object) -> None:
    s, r, Q = turned_history()
    a, b = jo.fatigue.critical_plane(s, criterion), jo.fatigue.critical_plane(r, criterion)
    assert abs(b.normal @ Q @ a.normal) == pytest.approx(1.0, abs=1e-3)


def test_normal_stress_plane_is_the_principal_one() -> None:
    found = jo.fatigue.critical_plane(tension_torsion(100e6, 60e6, 0.0), jo.fatigue.NormalStress())
    assert found.value == pytest.approx(50e6 + math.hypot(50e6, 60e6), rel=1e-6)


def test_fatemi_socie() -> None:
    # torsion alone: no normal stress on the plane of largest shear, but others may be worse:
    # g (1 + k tau |sin 2a| / S_y) cos 2a, maximised
    c = jo.fatigue.FatemiSocie(S_y=300e6, E=200e9, nu=0.3, k=1.0)
    a = np.linspace(0, np.pi / 4, 20001)
    for tau in (50e6, 200e6):
        want = (tau / c.G * np.cos(2 * a) * (1 + tau * np.sin(2 * a) / 300e6)).max()
        found = jo.fatigue.critical_plane(tension_torsion(0.0, tau, 0.0), c)
        assert found.value == pytest.approx(want, rel=1e-5)
    # without the normal stress it is the strain-life curve in shear: von Mises equivalent
    m = jo.fatigue.strain_life("sae-1045")
    N = 1e4
    elastic, plastic = m.sf / m.E * (2 * N) ** m.b, m.ef * (2 * N) ** m.c
    gamma = m.sf / 3**0.5 / c.G * (2 * N) ** m.b + 3**0.5 * m.ef * (2 * N) ** m.c
    assert c.cycles(gamma, m) == pytest.approx(N, rel=1e-9)
    assert gamma == pytest.approx(2 * 1.3 / 3**0.5 * elastic * m.E / 200e9 + 3**0.5 * plastic)


def test_dang_van_of_tension_and_torsion() -> None:
    # t + a s_h: s/2 + a s/3 in alternating tension, s/2 + 2 a s/3 in pulsating; tau in torsion
    c = jo.fatigue.DangVan.of(torsion=155e6, bending=250e6)
    both = jo.fatigue.critical_plane(tension_torsion(250e6, 0.0, 0.0), c)
    assert both.value == pytest.approx(155e6, rel=1e-9)
    alone = jo.fatigue.critical_plane(tension_torsion(0.0, 155e6, 0.0), c)
    assert alone.value == pytest.approx(155e6, rel=1e-9)
    pulsating = jo.fatigue.critical_plane(tension_torsion(100e6, 0.0, 0.0, 100e6), c)
    assert pulsating.value == pytest.approx(50e6 + c.a * 200e6 / 3, rel=1e-6)
    assert jo.fatigue.multiaxial(tension_torsion(125e6, 0.0, 0.0), c).safety == pytest.approx([2.0])


def test_findley_of_two_fatigue_limits() -> None:
    c = jo.fatigue.Findley.of(torsion=155e6, bending=250e6)
    limit = 155e6 * math.sqrt(1 + c.k**2)
    assert 125e6 * (c.k + math.sqrt(1 + c.k**2)) == pytest.approx(limit)


def Basquin() -> jo.SN:
    return jo.SN(S_D=100e6, N_D=1e6, k=5.0)


def test_damage_of_alternating_tension() -> None:
    s = np.tile(tension_torsion(120e6, 0.0, 0.0)[:-1:10], (4, 1))
    # from 0 to the first peak and from the last valley to -sin(10 degrees): half cycles of 60 and
    # of 49.6 MPa beside three and a half of 120 MPa
    ends = 0.5 * (0.5**5 + (0.5 * (1.0 - math.sin(math.radians(10.0)))) ** 5)
    for residue, cycles in (("repeat", 4.0), ("half", 3.5 + ends), ("ignore", 3.0)):
        found = jo.fatigue.plane_damage(s, jo.fatigue.NormalStress(), Basquin(), residue=residue)
        assert found.damage[0] == pytest.approx(cycles * 1.2**5 / 1e6, rel=1e-9)
        assert abs(found.normal[0, 0]) == pytest.approx(1.0)
    # Findley's plane lies between those of the net: at most a few per cent of stress away
    found = jo.fatigue.plane_damage(
        s, jo.fatigue.Findley(0.3), Basquin(), residue="repeat", step=5.0
    )
    assert found.damage[0] == pytest.approx(4 * 1.2**5 / 1e6, rel=0.03)
    assert found.life[0] == pytest.approx(1 / found.damage[0])
    assert "repeat" in str(found)


def test_damage_of_shear_strain() -> None:
    m = jo.fatigue.strain_life("sae-1045")
    c = jo.fatigue.FatemiSocie(S_y=382e6, E=m.E, nu=0.3, k=0.6)
    s = tension_torsion(0.0, 200e6, 0.0)
    found = jo.fatigue.plane_damage(s, c, m, residue="repeat", step=7.5)
    worst = jo.fatigue.critical_plane(s, c).value
    assert found.life[0] == pytest.approx(float(c.cycles(worst, m)), rel=0.05)


def test_mistakes() -> None:
    s = tension_torsion(1e8, 0.0, 0.0)
    with pytest.raises(jo.InputError, match="0.5"):
        jo.fatigue.Findley.of(torsion=300e6, bending=250e6)
    with pytest.raises(jo.InputError, match="empty"):
        jo.fatigue.critical_plane(np.zeros((0, 6)), jo.fatigue.Findley())
    with pytest.raises(jo.InputError, match="finite"):
        jo.fatigue.critical_plane(np.full((3, 6), np.nan), jo.fatigue.Findley())
    with pytest.raises(jo.InputError) as told:
        jo.fatigue.plane_damage(
            s, jo.fatigue.Findley(), jo.fatigue.strain_life("man-ten"), residue="never", mean=1
        )  # type: ignore[arg-type]
    assert len(told.value.problems) == 3
    with pytest.raises(jo.InputError, match="has no damage"):
        jo.fatigue.plane_damage(s, jo.fatigue.DangVan(0.3, 1e8), Basquin(), residue="half")  # type: ignore[arg-type]
    with pytest.raises(jo.InputError, match="has no limit; compare"):
        _ = jo.fatigue.multiaxial(s, jo.fatigue.Findley()).safety
    with pytest.raises(jo.InputError, match="shape"):
        jo.fatigue.multiaxial(np.zeros((2, 3, 4, 6)), jo.fatigue.Findley())
    assert "worst" not in str(jo.fatigue.multiaxial(s, jo.fatigue.Findley()))


def test_inputs_that_are_none() -> None:
    for nu in (30.0, math.nan, 0.5):
        with pytest.raises(jo.InputError, match="nu is"):
            jo.fatigue.FatemiSocie(350e6, 210e9, nu=nu)
    with pytest.warns(jo.JoustoWarning, match="MPa"):
        jo.fatigue.FatemiSocie(350.0, 210e9)
    with pytest.raises(jo.InputError, match="no sites"):
        jo.fatigue.multiaxial(np.zeros((0, 5, 6)), jo.fatigue.Findley(0.3))
    with pytest.raises(jo.InputError, match="finite"):
        jo.fatigue.hot_spot_stress([120e6, math.nan])
    beam = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 4, jo.Material(E=210e9, nu=0.3, rho=7850.0))
    reduced = jo.reduce(beam, jo.CraigBampton(interfaces=("start", "end"), modes=6))
    with pytest.raises(jo.InputError, match=r"damping has shape \(2,\)"):
        jo.fatigue.random_response(
            reduced,
            [2.0, 80.0],
            [3.0, 3.0],
            base="start",
            direction=(0, 1, 0),
            damping=[0.03, 0.02],
        )


def test_shear_along_a_triangle() -> None:
    # the longest line of an equilateral triangle is sqrt(3)/2 of the diameter of its circle
    s = np.zeros((4, 6))
    turn = np.radians([90.0, 210.0, 330.0, 90.0])
    s[:, 3], s[:, 5] = 100e6 * np.cos(turn), 100e6 * np.sin(turn)
    circle = jo.fatigue.critical_plane(s, jo.fatigue.Findley(0.0)).value
    curve = jo.SN(S_D=100e6, N_D=1e6, k=5)
    counted = jo.fatigue.plane_damage(s, jo.fatigue.Findley(0.0), curve, residue="repeat").damage[0]
    line = 0.5 * 100e6 * (1e6 * counted) ** 0.2
    assert line / circle == pytest.approx(math.sqrt(3.0) / 2.0, abs=0.02)
