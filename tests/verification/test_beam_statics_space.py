"""Static beams in space against closed forms, published tables and an experiment's benchmark."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.integrate as si
from scipy.spatial.transform import Rotation

import jousto as jo
from verification import beam_chain as bc
from verification.beam_statics import ZERO, arc, cantilever, rest, section, straight, tip

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")

# 45 degree bend, R = 100, 1 x 1, E = 1e7, nu = 0, shear factor 5/6, GJ of the polar moment 1/6:
# Bathe and Bolourchi, International Journal for Numerical Methods in Engineering 14 (1979) 961-986
BEND = section(1e7, 5e6 * 5 / 6, 5e6 * 5 / 6, 5e6 / 6, 1e7 / 12, 1e7 / 12)
# end places of Simo and Vu-Quoc, Computer Methods in Applied Mechanics and Engineering 58 (1986)
# 79-116, 8 elements, with the radius along the first coordinate
SIMO = {300: (58.84, 22.33, 40.08), 450: (52.32, 18.62, 48.39), 600: (47.23, 15.79, 53.37)}


@pytest.mark.parametrize("load", [300, 450, 600])
def test_45_degree_bend_of_simo_and_vu_quoc(load: int) -> None:
    end = tip(cantilever(arc(100.0, np.pi / 4, 8, BEND), (0.0, 0.0, load)), 6)
    # along the first tangent and across it: theirs have chords of the same length
    assert end == pytest.approx(SIMO[load], abs=0.08)


def test_45_degree_bend_of_others() -> None:
    ends = {
        (n, b): tip(
            cantilever(arc(100.0, np.pi / 4, n, BEND, bending=b), (0.0, 0.0, 600.0)), 12 if b else 6
        )
        for n, b in ((8, False), (16, False), (32, False), (4, True), (8, True), (16, True))
    }
    start = 100.0 * np.array([np.sin(np.pi / 4), 1.0 - np.cos(np.pi / 4), 0.0])
    u = ends[16, True] - start
    # Bathe and Bolourchi: 13.4, 23.5, 53.4; Wang, Sprague, Jonkman and Johnson (2015,
    # NREL/CP-5000-63165): 13.5, 23.7, 53.4
    assert np.abs(u) == pytest.approx((23.5, 13.4, 53.4), abs=0.25)
    assert np.abs(u) == pytest.approx((23.7, 13.5, 53.4), abs=0.2)
    # second order, and the same limit
    fall = [np.linalg.norm(ends[2 * n, False] - ends[n, False]) for n in (8, 16)]
    assert np.log2(fall[0] / fall[1]) == pytest.approx(2.0, abs=0.1)
    plain = ends[32, False] + (ends[32, False] - ends[16, False]) / 3.0
    assert np.abs(plain - ends[16, True]).max() < 0.01
    assert np.abs(plain - ends[8, True]).max() < 0.04


def test_45_degree_bend_of_exudyn() -> None:
    # EXUDYN's geometricallyExactBeamCurvedTest, 32 elements: GA = G A and J = 0.141 there
    sec = section(1e7, 5e6, 5e6, 5e6 * 0.141, 1e7 / 12, 1e7 / 12)
    end = tip(cantilever(arc(100.0, np.pi / 4, 32, sec), (0.0, 0.0, 600.0)), 6)
    assert end == pytest.approx((46.90, 15.56, 53.60), abs=0.006)


def test_no_path_is_special() -> None:
    # forces and an end moment about the fixed axis of a hinge-free end in any order of loads
    beam = arc(100.0, np.pi / 4, 6, BEND)
    side = jo.Force("side", beam["end"], (80.0, -120.0, 0.0), signal=jo.Input("side"))
    model = cantilever(beam, (0.0, 0.0, 600.0), ZERO, side)
    grow = np.linspace(0.0, 1.0, 9)[1:]
    one, zero = np.ones(8), np.zeros(8)
    ways = [
        np.stack([grow, grow], 1),
        np.concatenate([np.stack([grow, zero], 1), np.stack([one, grow], 1)]),
        np.concatenate([np.stack([zero, grow], 1), np.stack([grow, one], 1)]),
        # far beyond and back, through a reversed load
        np.concatenate([np.stack([-grow, 2 * grow], 1), np.stack([2 * grow - 1, 2 - grow], 1)]),
    ]
    ends = [tip(model, way) for way in ways]
    assert np.ptp(np.array(ends), axis=0).max() < 1e-9
    back = np.concatenate([ways[0], ways[0][::-1], np.zeros((1, 2))])
    assert np.abs(tip(model, back) - beam.nodes[-1]).max() < 1e-9


def test_rigid_motion_strains_nothing() -> None:
    beam = arc(100.0, np.pi / 4, 6, BEND)
    model = cantilever(beam, (0.0, 50.0, 600.0), (0.0, 0.0, 0.0))
    state, _ = rest(model, 6)
    engine = jo.model.Engine(model)
    engine.input[:] = 0.0
    engine.q[:] = state.q
    before = engine.residual().reshape(-1, 2, 3)
    turn = Rotation.from_rotvec([1.3, -2.2, 0.7])
    for b in model.bodies:
        engine.q[b.iq : b.iq + 3] = turn.apply(engine.q[b.iq : b.iq + 3]) + [10.0, -20.0, 5.0]
        old = Rotation.from_quat(np.roll(engine.q[b.iq + 3 : b.iq + 7], -1))
        engine.q[b.iq + 3 : b.iq + 7] = np.roll((turn * old).as_quat(), 1)
    after = engine.residual().reshape(-1, 2, 3)
    # forces turn with it, moments in the frames of the nodes stay
    scale = np.abs(before).max()
    assert np.abs(after[:, 0] - turn.apply(before[:, 0])).max() < 1e-11 * scale
    assert np.abs(after[:, 1] - before[:, 1]).max() < 1e-11 * scale


def test_newton_converges_quadratically() -> None:
    model = cantilever(arc(100.0, np.pi / 4, 8, BEND), (0.0, 0.0, 600.0))
    for steps in (4, 6, 10):
        _, sizes = rest(model, steps)
        print(f"{steps} load steps:", *(f"{x:.1e}" for x in sizes))
        assert len(sizes) <= 7
        # each step is at most the square of the one before times the slenderness (R/h)^2
        for before, after in zip(sizes[-3:-1], sizes[-2:], strict=True):
            assert after < 1e4 * before**2


def helices(GJ: float) -> dict[tuple[int, bool], float]:
    """Errors of the end by elements, and whether these bend inside.

    A moment oblique to the axis winds a straight rod into a helix.
    """
    moment = 0.7 * 2.0 * np.pi * np.array([np.cos(1.2), 0.0, np.sin(1.2)])
    exact = bc.helix(moment, 1.0, 1.0)
    error = {}
    for n in (16, 32):
        for bending in (False, True):
            beam = straight(1.0, n, section(1e3, 1e3, 1e3, GJ, 1.0, 1.0), bending=bending)
            end = tip(cantilever(beam, torque=moment), 16)
            error[n, bending] = float(np.abs(end - exact).max())
    return error


def test_helix_of_a_dead_moment() -> None:
    error = helices(1.0)
    assert np.log2(error[16, False] / error[32, False]) == pytest.approx(2.0, abs=0.1)
    # one screw motion from end to end of a rod of 1 m: exact but for round-off
    assert error[16, True] < 1e-11


def test_helix_of_a_dead_moment_on_a_rod_soft_in_torsion() -> None:
    error = helices(0.3)
    assert np.log2(error[16, False] / error[32, False]) == pytest.approx(2.0, abs=0.1)
    assert np.log2(error[16, True] / error[32, True]) == pytest.approx(2.0, abs=0.1)
    assert error[32, True] < error[32, False]


# MacNeal and Harder, Finite Elements in Analysis and Design 1 (1985) 3-20


def twisted(elements: int, **more: bool) -> jo.BeamBody:
    """Twisted beam: length 12, 1.1 x 0.32, 90 degrees, E = 29e6, nu = 0.22."""
    steel = jo.Material(E=29e6, nu=0.22, rho=1.0)
    return straight(
        12.0, elements, jo.Rectangle(1.1, 0.32), material=steel, twist=np.pi / 2, **more
    )


def test_twisted_beam_of_macneal_and_harder() -> None:
    sec, E, G = jo.Rectangle(1.1, 0.32), 29e6, 29e6 / 2.44

    def flexible(s: float, across: float) -> float:
        a = np.pi / 2 * s / 12.0 - across
        bend = np.cos(a) ** 2 / (E * sec.Iz) + np.sin(a) ** 2 / (E * sec.Iy)
        return (12.0 - s) ** 2 * bend + 1.0 / (5 / 6 * G * sec.A)

    for force, across, published in (
        ((0.0, 1.0, 0.0), 0.0, 0.001754),
        ((0.0, 0.0, 1.0), np.pi / 2, 0.005424),
    ):
        exact = si.quad(flexible, 0.0, 12.0, args=(across,))[0]
        assert exact == pytest.approx(published, rel=4e-3)  # theirs has another shear
        k = int(np.argmax(force))
        for elements, bending, error in ((24, False, 2e-3), (12, True, 2e-3), (24, True, 4e-4)):
            end = tip(cantilever(twisted(elements, bending=bending), force), 1)
            # loads of 1 deflect 5e-4 of the length: linear to 1e-6
            assert end[k] == pytest.approx(exact, rel=error)


def test_curved_beam_of_macneal_and_harder() -> None:
    # quarter circle, radii 4.12 and 4.32, thickness 0.1, E = 1e7, nu = 0.25; end loads 1
    R, E, G = 4.22, 1e7, 4e6
    sec = jo.Rectangle(0.2, 0.1)
    steel = jo.Material(E=E, nu=0.25, rho=1.0)
    shear = 5 / 6 * G * sec.A
    # Castigliano: a slender arc; the published values are of curved thick beams
    inward = np.pi / 4 * (R**3 / (E * sec.Iz) + R / (E * sec.A) + R / shear)
    out = (
        R**3 * (np.pi / 4 / (E * sec.Iy) + (3 * np.pi / 4 - 2) / (G * sec.J))
        + np.pi / 2 * R / shear
    )
    assert inward == pytest.approx(0.08734, rel=0.02)
    assert out == pytest.approx(0.5022, rel=0.005)
    for force, exact in (((1e-3, 0.0, 0.0), inward), ((0.0, 0.0, 1e-3), out)):
        k = int(np.argmax(force))
        for elements, bending, error in ((12, False, 1e-2), (6, True, 1e-3), (12, True, 2e-4)):
            beam = arc(R, np.pi / 2, elements, sec, material=steel, bending=bending)
            end = tip(cantilever(beam, force), 1) - beam.nodes[-1]
            assert end[k] / 1e-3 == pytest.approx(exact, rel=error)
