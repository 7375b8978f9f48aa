"""Lateral buckling of a thin beam, driven by a crank: a benchmark for flexible multibody programs.

A problem of the benchmark library of IFToMM (O. Bauchau); the numbers as in MBDyn's
`tests/benchmarks/lateralbuckling` (P. Masarati). A blade of 1 m, 0.1 by 0.01 m, clamped at its
root, is lifted at its tip by a link of 0.25 m and a crank of 0.05 m, which turns by half a turn
in 0.4 s; the link stands 0.1 mm beside the blade, so that it buckles to that side. The critical
tip load is ``4.0126 sqrt(EI GJ)/L^2`` (Timoshenko and Gere, Theory of Elastic Stability,
section 6.3). Further numbers: EXUDYN 1.13.6, its geometrically exact beam on SE(3), 20
elements, 0.5 ms, generalised alpha (0.6).
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo

BLADE = jo.mechanism.BeamSection(
    np.diag([73e6, 5.025e6, 23.40e6, 877.2, 60830, 608.3]),
    2.68,
    1e-6 * np.diag([2255.33, 2233, 22.33]),
)
LINK = jo.mechanism.BeamSection(
    np.diag([33.02e6, 10.81e6, 10.81e6, 914.5, 1189, 1189]), 1.212, 43.65e-6 * np.diag([2.0, 1, 1])
)
CRANK = jo.mechanism.BeamSection(
    np.diag([132.1e6, 43.22e6, 43.22e6, 14630, 19020, 19020]), 4.85, 698.3e-6 * np.diag([2.0, 1, 1])
)
ASIDE, T = 1e-4, 0.4
# half a turn, beginning and ending gently
TIMES = np.linspace(0, 0.5, 201)
TURN = jo.Table(TIMES, np.pi / 2 * (1 - np.cos(np.pi * np.minimum(TIMES, T) / T)), "cubic")


def lifted(elements, aside=ASIDE, **options):
    blade = jo.BeamBody("blade", [(0, 0, 0), (1, 0, 0)], BLADE, elements=elements, **options)
    y = aside
    link = jo.BeamBody("link", [(1, y, 0), (1, y, -0.25)], LINK, elements=3, up=(1, 0, 0))
    crank = jo.BeamBody("crank", [(0.95, y, -0.25), (1, y, -0.25)], CRANK, elements=2)
    tip = blade.node(-1, at=(0, y, 0))
    shaft = jo.Revolute("shaft", jo.ground.at((0.95, y, -0.25)), crank["start"], axis=(0, -1, 0))
    middle = blade.node(elements // 2)
    return jo.Mechanism(
        blade,
        link,
        crank,
        jo.Fixed("root", jo.ground["origin"], blade["start"]),
        jo.Spherical("ball", tip, link["start"]),
        jo.Revolute("pin", link["end"], crank["end"], axis=(0, 1, 0)),
        shaft,
        jo.Drive("motor", shaft.angle, TURN),
        jo.PositionSensor("middle", middle),
        jo.PositionSensor("tip", blade["end"]),
    )


def run_of(elements, t_end, step, **options):
    model = jo.compile(lifted(elements, **options))
    return jo.simulate(model, t_end, solver=jo.GeneralizedAlpha(step=step, rho=0.6))


# time, middle y and z, tip z, m; the extreme of the middle is -0.0449 at 0.1805 s
EXUDYN = np.array(
    [
        (0.10, -5.8e-5, 0.00694, 0.02211),
        (0.15, -0.03371, 0.00847, 0.04055),
        (0.20, -0.03236, 0.00959, 0.04571),
    ]
)


def test_the_turn_is_half_a_turn():
    times = np.array([0.0, 0.2, 0.4, 0.5])
    np.testing.assert_allclose(TURN(times), [0, np.pi / 2, np.pi, np.pi], atol=1e-7)


def test_the_blade_buckles_aside_when_its_load_passes_the_critical_one():
    run = run_of(10, 0.2, 1e-3, bending=True)
    y = run["middle"][:, 1]
    # deflection of the tip at the critical load, in the stiff direction
    critical = 4.0126 * np.sqrt(608.3 * 877.2)
    lift = critical / (3 * 60830)
    before = run["tip"][:, 2] < 0.9 * lift
    assert np.abs(y[before]).max() < 1e-4
    assert np.abs(y).max() == pytest.approx(0.045, rel=0.05)
    assert run.time[np.argmax(np.abs(y))] == pytest.approx(0.1805, abs=0.003)
    # it buckles away from the side on which the link stands
    assert y[np.argmax(np.abs(y))] < 0


def test_without_the_link_aside_it_stays_in_its_plane():
    run = run_of(6, 0.2, 2e-3, aside=0.0)
    assert np.abs(run["middle"][:, 1]).max() < 1e-6  # round-off grows


@pytest.mark.slow
def test_another_program_buckles_alike():
    misses = []
    for n, step in ((10, 1e-3), (20, 5e-4)):
        run = run_of(n, 0.25, step)
        rows = np.searchsorted(run.time, EXUDYN[:, 0] - 1e-9)
        found = np.stack(
            [run["middle"][rows, 1], run["middle"][rows, 2], run["tip"][rows, 2]], axis=-1
        )
        misses.append(np.abs(found - EXUDYN[:, 1:]).max())
    assert misses[-1] < 2e-3, misses
    peak = run["middle"][:, 1].min()
    assert peak == pytest.approx(-0.0449, abs=1e-3)
