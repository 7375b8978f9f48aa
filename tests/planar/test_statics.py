"""Equilibria of planar frames: exact results, elliptic integrals, limit points, clear errors."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jousto as jo
from jousto.planar.frame import PlanarFrame
from jousto.planar.items import PlanarBeam, PlanarLoad, PlanarSupport
from jousto.planar.methods import Convergence
from jousto.planar.section import PlanarSection
from jousto.planar.statics import arc_length, load_steps, planar_frequencies
from planar.frames import chain

SLENDER = PlanarSection(EA=1e8, GA=1e8, EI=1.0, mass=1.0, rotary=1e-8)
ROUND = PlanarSection(EA=1e6, GA=1e6, EI=1.0, mass=1.0, rotary=1e-8)


@pytest.mark.parametrize("elements", [2, 3, 7])
def test_end_moment_closes_a_circle_exactly(elements: int) -> None:
    """2 pi EI / L, for any number of elements."""
    x = np.linspace(0, 1, elements + 1)
    beams = [PlanarBeam(i, i + 1, ROUND) for i in range(elements)]
    frame = PlanarFrame(
        [(a, 0) for a in x],
        beams,
        [PlanarSupport(0, rotation=True)],
        [PlanarLoad(elements, moment=2 * math.pi)],
    )
    path = load_steps(frame, np.linspace(0, 1, 13))
    # a stretch has a round-off of eps, so a normal force one of eps EA (L = 1 m), which bends the
    # cantilever by eps EA L^3 / 3 EI and turns its end by eps EA L^2 / 2 EI
    eps = np.finfo(float).eps
    assert abs(path.positions[-1, -1]).max() < eps * ROUND.EA / (3 * ROUND.EI)
    assert path.displacements[-1, -1, 2] == pytest.approx(
        2 * math.pi, abs=eps * ROUND.EA / (2 * ROUND.EI)
    )
    assert path.resultants[-1] == pytest.approx(
        np.tile([0, 0, 2 * math.pi], (elements, 1)), abs=1e-6
    )


# P L^2 / EI, w / L, u / L of a cantilever under a dead end load: K. E. Bisshopp, D. C. Drucker,
# Quart. Appl. Math. 3 (1945) 272-275, evaluated to ten digits by elliptic integrals
ELASTICA = [
    (1.0, 0.3017207738, 0.0564332363),
    (2.0, 0.4934574804, 0.1606417208),
    (5.0, 0.7137915236, 0.3876283607),
    (10.0, 0.8106090249, 0.5549955978),
]


def tips(elements: int) -> np.ndarray:
    loads = [PlanarLoad(elements, force=(0.0, 1.0))]
    frame = chain(elements, section=SLENDER, loads=loads)
    factors = [0.5, 1.0, 2.0, 3.5, 5.0, 7.5, 10.0]
    path = load_steps(frame, factors)
    rows = [factors.index(p) for p, *_ in ELASTICA]
    return path.displacements[rows, -1, :2]


def test_elastica_converges_to_the_elliptic_integrals() -> None:
    exact = np.array([(-u, w) for _, w, u in ELASTICA])
    errors = [tips(n) - exact for n in (8, 16, 32)]
    sizes = [float(abs(e).max()) for e in errors]
    # one-point integration: order 2
    assert 3.7 < sizes[0] / sizes[1] < 4.3
    assert 3.8 < sizes[1] / sizes[2] < 4.2
    # Richardson leaves order 4; EA and GA add about P / EA = 1e-7
    assert abs((4 * errors[2] - errors[1]) / 3).max() < 5e-6


def test_newton_converges_quadratically() -> None:
    """The number of right digits of the balance nearly doubles with each correction."""
    thick = PlanarSection(EA=300.0, GA=100.0, EI=1.0)
    frame = chain(6, section=thick, loads=[PlanarLoad(6, force=(0.0, 1.0))])
    (r,) = load_steps(frame, [1.0], convergence=Convergence(residual=1e-11)).residuals
    x = np.log(np.array(r))
    # before rounding is met, the number of digits doubles
    orders = (x[2:] - x[1:-1]) / (x[1:-1] - x[:-2])
    above = np.array(r[2:]) > 1e-11
    assert orders[above].max() > 1.6
    assert len(r) <= 9


def test_following_end_force_does_not_hang_the_iteration() -> None:
    """A follower end load bends a cantilever back: equilibrium of moments about the clamp."""
    n = 8
    frame = chain(n, section=SLENDER, loads=[PlanarLoad(n, force=(0.0, 1.0), follow=True)])
    path = load_steps(frame, np.linspace(0, 10, 11))
    x, y = path.positions[-1, -1]
    th = path.displacements[-1, -1, 2]
    fx, fy = -10.0 * math.sin(th), 10.0 * math.cos(th)
    # half an element from the clamp, by equilibrium of the rest: the moment is that of its strain
    a, b = path.positions[-1, 0], path.positions[-1, 1]
    mx, my = 0.5 * (a + b)
    moment = (x - mx) * fy - (y - my) * fx
    assert path.resultants[-1, 0, 2] == pytest.approx(moment, rel=1e-6)
    assert max(len(h) for h in path.residuals) <= 8


def shallow(height: float) -> PlanarFrame:
    """Half of a von Mises truss of two nearly hinged bars: span 2, rise `height`."""
    bar = PlanarSection(EA=1.0, GA=1.0, EI=1e-9)
    return PlanarFrame(
        [(0.0, 0.0), (1.0, height)],
        [PlanarBeam(0, 1, bar)],
        [PlanarSupport(0), PlanarSupport(1, y=False)],
        [PlanarLoad(1, force=(0.0, -1.0))],
    )


def test_arc_length_passes_the_limit_points_of_a_truss() -> None:
    """Closed form of a bar with engineering strain: P = EA (1/l - 1/l0) y, l^2 = 1 + y^2.

    The rotation is free: the bar turns as a whole, and EI does not matter.
    """
    h = 0.1
    frame = shallow(h)
    y = np.linspace(h, -h, 20001)
    l0 = math.hypot(1.0, h)
    top = float(((1 / np.hypot(1.0, y) - 1 / l0) * y).max())
    path = arc_length(frame, 0.1 * top, until=1.5 * top, max_steps=400)
    height = h + path.displacements[:, 1, 1]
    exact = (1 / np.hypot(1.0, height) - 1 / l0) * height
    assert path.factors == pytest.approx(exact, abs=1e-8 * top)
    # through the snap to the other side, and up to the load asked for
    assert path.factors.min() < -0.95 * top
    assert path.factors[-1] == pytest.approx(1.5 * top)
    assert height[-1] < -h
    # it loses its stability at the first limit and gains it again at the second
    assert path.negative[0] == 0
    assert path.negative.max() == 1
    assert path.negative[-1] == 0
    with pytest.raises(jo.SimulationError, match="does not converge.*arc_length"):
        load_steps(frame, [0.99 * top, 1.02 * top], convergence=Convergence(max_iterations=5))


def test_steps_of_the_load_that_fail_are_halved() -> None:
    """A slender cantilever far bent in one step, which Newton's method does not take.

    Round-off of the normal force, eps EA = 2e-8 times some ten of the load, bends it so much.
    """
    frame = chain(8, section=SLENDER, loads=[PlanarLoad(8, force=(0.0, 1.0))])
    once, slowly = load_steps(frame, [10.0]), load_steps(frame, np.linspace(0.5, 10.0, 20))
    assert once.factors == pytest.approx([10.0])
    assert once.displacements[-1] == pytest.approx(slowly.displacements[-1], abs=2e-6)


def test_euler_load_is_where_the_lowest_frequency_vanishes() -> None:
    """Pinned column: pi^2 EI / L^2, GA and EA corrections of 1e-7 left out; order 2."""
    found = []
    for n in (8, 16):
        nodes = [(i / n, 0.0) for i in range(n + 1)]
        frame = PlanarFrame(
            nodes,
            [PlanarBeam(i, i + 1, ROUND) for i in range(n)],
            [PlanarSupport(0), PlanarSupport(n, x=False)],
            [PlanarLoad(n, force=(-(math.pi**2), 0.0))],
        )
        factors = np.array([0.90, 0.95])
        path = load_steps(frame, factors)
        squares = [planar_frequencies(frame, path, k)[0] ** 2 for k in range(2)]
        # the square of the frequency falls linearly with the load
        found.append(0.90 + 0.05 * squares[0] / (squares[0] - squares[1]))
    errors = np.abs(np.array(found) - 1.0)
    assert errors[1] < 7e-3
    assert 3.5 < errors[0] / errors[1] < 4.5


def test_frequencies_of_a_cantilever() -> None:
    """(1.8751)^2 and (4.6941)^2 sqrt(EI / m) / L^2: Blevins, Formulas for Natural Frequency."""
    exact = np.array([1.87510407, 4.69409113]) ** 2 / (2 * math.pi)
    errors = [planar_frequencies(chain(n, section=ROUND))[:2] / exact - 1 for n in (8, 16)]
    assert abs(errors[1]).max() < 1e-2
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


def test_what_moves_freely_is_named() -> None:
    frame = chain(3, supports=[PlanarSupport(0)])
    with pytest.raises(jo.InputError, match="1 ways; r of node . moves most; add PlanarSupport"):
        load_steps(frame, [1.0])


def test_path_without_load_is_refused() -> None:
    with pytest.raises(jo.InputError, match="no load moves the frame"):
        arc_length(chain(2), 0.1)
    with pytest.raises(jo.InputError, match="first is 0, must be a number other than zero"):
        arc_length(chain(2), 0.0)
    with pytest.raises(jo.InputError, match="first is 0.1 and leads away from until = -1"):
        arc_length(chain(2), 0.1, until=-1.0)
    with pytest.raises(jo.InputError, match="factors is empty; give one"):
        load_steps(chain(2), [])
