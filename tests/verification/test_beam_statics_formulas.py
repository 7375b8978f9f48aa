"""The formulas of the beam element, stated anew in NumPy, against closed forms of elastic curves.

`beam_chain` shares no line with the engine: what passes here are the equations themselves, and the
closed forms that the engine is held against in the other tests of beams.
"""

from __future__ import annotations

import numpy as np
import pytest

from verification import beam_chain as bc

# P L^2/E I, w/L, u/L to ten decimals, computed independently with elliptic integrals
TABLE = (
    (1.0, 0.3017207738, 0.0564332363),
    (2.0, 0.4934574804, 0.1606417208),
    (5.0, 0.7137915236, 0.3876283607),
    (10.0, 0.8106090249, 0.5549955978),
)
THIN = np.diag([1e5, 1e5, 1e5, 1.0, 1.0, 1.0])  # E I = 1, nearly no shear
TENTH = np.array([1.0, 1.0, 10.0])


@pytest.mark.parametrize(("load", "w", "u"), TABLE)
def test_elastica_by_elliptic_integrals(load: float, w: float, u: float) -> None:
    assert bc.elastica(load)[:2] == pytest.approx((w, u), abs=1e-10)
    # small loads: P L^3/3 E I
    assert bc.elastica(1e-4)[0] == pytest.approx(1e-4 / 3.0, rel=1e-6)


def test_buckled_column_of_timoshenko_and_gere() -> None:
    # their table 2-4: end slope in degrees, P/Pcr, x/L, y/L
    table = ((20, 1.015, 0.970, 0.220), (60, 1.152, 0.741, 0.593), (120, 1.884, 0.123, 0.803))
    for degrees, load, x, y in table:
        found = bc.buckled(np.radians(degrees))
        assert found == pytest.approx((load, x, y), abs=2e-3)
    assert bc.lateral() == pytest.approx(4.013, abs=5e-4)


@pytest.mark.parametrize("elements", [1, 2, 5])
@pytest.mark.parametrize("helical", [False, True])
def test_end_moment_bends_to_an_arc(elements: int, helical: bool) -> None:
    turn = 0.6 * np.pi  # of the end: below half a turn for one element
    chain = bc.straight(1.0, elements, THIN)
    chain.helical = helical
    norms = chain.solve(np.zeros(3), np.array([0.0, 0.0, turn]), steps=3)
    assert len(norms) < 12
    part = turn / elements
    # elements as long as their arc, or as their chord
    ratio = 1.0 if helical else (part / 2) / np.sin(part / 2)
    exact = ratio * np.array([np.sin(turn), 1.0 - np.cos(turn), 0.0]) / turn
    assert np.abs(chain.r[-1] - exact).max() < 1e-7


@pytest.mark.parametrize(
    ("helical", "bending", "order"), [(False, False, 2), (False, True, 2), (True, True, 4)]
)
@pytest.mark.parametrize("load", [pytest.param(1.0, marks=pytest.mark.slow), 10.0])
def test_order_of_convergence_on_the_elastica(
    helical: bool, bending: bool, order: int, load: float
) -> None:
    ends = {}
    for n in (2, 4, 8, 16):
        chain = bc.straight(1.0, n, THIN)
        chain.helical, chain.bending = helical, bending
        chain.__post_init__()
        chain.solve(np.array([0.0, load, 0.0]), steps=4)
        ends[n] = chain.r[-1]
    # shear and tension of the thin beam are there for all
    change = [np.linalg.norm(ends[n] - ends[n // 2]) for n in (4, 8, 16)]
    assert np.log2(change[1] / change[2]) == pytest.approx(order, abs=0.3)
    w, u, _ = bc.elastica(load)
    # exact curves neither shear nor stretch: P/GA and P/EA, 1e-5 and 1e-4
    error = np.linalg.norm(ends[16] - [1.0 - u, w, 0.0])
    assert error < (3e-3 if order == 2 else 1.2e-5 * load)


def test_forces_are_those_of_the_energy_and_objective() -> None:
    rng = np.random.default_rng(1)
    chain = bc.bend(1.0, 1.0, 3, np.diag([3.0, 2.0, 2.5, 1.0, 1.5, 0.5]))
    chain.r += 0.1 * rng.standard_normal(chain.r.shape)
    chain.q = bc.times(chain.q, bc.exponential(0.2 * rng.standard_normal((4, 3))))
    inner, tangent = chain.forces()
    assert np.abs(tangent - np.swapaxes(tangent, 1, 2)).max() < 1e-8
    before = chain.strain()
    turn = bc.exponential(np.array([0.7, -1.9, 0.4]))
    chain.r = chain.r @ bc.matrix(turn).T + TENTH
    chain.q = bc.times(np.broadcast_to(turn, chain.q.shape), chain.q)
    assert np.abs(chain.strain() - before).max() < 1e-14
    turned, _ = chain.forces()
    rotated = inner.reshape(-1, 2, 2, 3).copy()
    rotated[:, :, 0] = rotated[:, :, 0] @ bc.matrix(turn).T
    assert np.abs(turned - rotated.reshape(-1, 12)).max() < 1e-13
