"""Spin-up of an exact beam, data and references as in `spin_up`.

Simo and Vu-Quoc, J. Appl. Mech. 53 (1986) 855-863: 6 rad/s after 15 s, steady stretch 5.14e-4 m.
The deflection is that of a chain of rigid links (`spin_up.links`), -0.5738 m at 6.76 s.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification import spin_up
from verification.spin_up import EA, EI, GA, LINE_INERTIA, LINE_MASS, SPEED, STRETCH, L, seen, turn

SECTION = jo.mechanism.BeamSection(
    np.diag([EA, GA, GA, EI, 4 * EI, EI]),
    LINE_MASS,
    LINE_INERTIA * np.diag([2.0, 1.0, 1.0]),
)


def rotor(elements, **options):
    beam = jo.BeamBody("beam", [(0, 0, 0), (L, 0, 0)], SECTION, elements=elements, **options)
    root = jo.Revolute("root", jo.ground["origin"], beam["start"], axis=(0, 0, 1))
    motor = jo.Drive("motor", root.angle, spin_up.signal())
    return jo.compile(jo.Mechanism(beam, root, motor, jo.PositionSensor("tip", beam["end"])))


def spun(elements, t_end, step, **options):
    run = jo.simulate(
        rotor(elements, **options), t_end, solver=jo.GeneralizedAlpha(step=step, rho=0.6)
    )
    return run, seen(run["tip"], turn(run.time)[0])


def test_the_beam_bends_like_a_chain_of_rigid_links():
    run, u = spun(12, 7.5, 0.01, mass="consistent")
    lowest = np.argmin(u[:, 1])
    assert u[lowest, 1] == pytest.approx(-0.5738, rel=2e-3)
    assert run.time[lowest] == pytest.approx(6.76, abs=0.06)


@pytest.mark.slow
def test_it_converges_to_the_links():
    times = np.arange(0.0, 9.0025, 0.005)
    coarse, fine = (spin_up.links(n, times) for n in (8, 16))
    exact = fine + (fine - coarse) / 3
    misses = []
    for n in (5, 10, 20):
        _, u = spun(n, 9.0, 0.005, mass=0.5)
        misses.append(np.abs(u - exact)[:, 1].max())
    # the links neither stretch nor shear, and the step is finite: that much is left
    assert misses[0] > 3 * misses[1]
    assert misses[2] < 1.5e-3, misses


def test_in_the_end_the_stretch_is_that_of_the_closed_form():
    # at rest in the turning frame: start there, with the tip moving round
    n = 10
    beam = jo.BeamBody(
        "beam", [(0, 0, 0), (L, 0, 0)], SECTION, elements=n, angular_velocity=(0, 0, SPEED)
    )
    root = jo.Revolute("root", jo.ground["origin"], beam["start"], axis=(0, 0, 1))
    tip = jo.PositionSensor("tip", beam["end"])
    motor = jo.Drive("motor", root.angle, jo.Ramp(0.0, 1e3, 0.0, 1e3 * SPEED))
    model = jo.compile(jo.Mechanism(beam, root, motor, tip))
    # it stretches at once and rings about the new length, which is the mean
    period = 4 * L * np.sqrt(LINE_MASS / EA)
    run = jo.simulate(model, 20 * period, solver=jo.GeneralizedAlpha(step=period / 200, rho=1.0))
    length = np.linalg.norm(run["tip"], axis=1)
    # n nodes carry the load instead of the line: 1 - 1/(4 n^2) of the integral of x^2
    mean = np.mean(length[1:]) - L
    assert STRETCH == pytest.approx(5.14e-4, abs=5e-7)
    assert mean == pytest.approx(STRETCH, rel=6e-3)
