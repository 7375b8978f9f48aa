"""A flexible shaft with an unbalanced disc runs up through its critical speed.

The benchmark "rotating shaft" of IFToMM's library (O. Bauchau), numbers as in MBDyn's
`tests/benchmarks/rotatingshaft`: a tube of 6 m between a driven and a guided end that cannot
tilt, a disc of 70.573 kg in the middle whose centre of mass is 0.05 m off the axis, gravity; the
speed rises to 0.8 * 60 rad/s in 0.5 s, stays, rises from 1 to 1.25 s to 1.2 * 60 rad/s and stays,
the critical speed being near 60 rad/s. Reference: Laval's rotor (A. Foeppl 1895; Jeffcott, Phil.
Mag. 37 (1919)) with the shaft's own mass and shear, deflection ``w = sum a_k (1 - cos 2 pi k
x/L)``, rotation ``f = sum b_k sin 2 pi k x/L``, complex in both planes, small.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.linalg import eigh

import jousto as jo

L, M_DISC, OFF, G = 6.0, 70.573, 0.05, 9.81
EA, GA, GJ, EI = 313.4e6, 60.5e6, 272.7e3, 354.5e3
RADII = (0.045, 0.05)
LINE_MASS = np.pi * 7800 * (RADII[1] ** 2 - RADII[0] ** 2)
LINE_INERTIA = np.pi / 4 * 7800 * (RADII[1] ** 4 - RADII[0] ** 4)
SECTION = jo.mechanism.BeamSection(
    np.diag([EA, GA, GA, GJ, EI, EI]), LINE_MASS, LINE_INERTIA * np.diag([2.0, 1.0, 1.0])
)
OMEGA = 60.0
DISC = M_DISC * np.array([0.24**2 / 2, 0.24**2 / 4 + 0.05**2 / 12, 0.24**2 / 4 + 0.05**2 / 12])


def speed(t):
    """Speed of the benchmark, rad/s."""
    t = np.asarray(t, dtype=float)
    first = 0.4 * OMEGA * (1 - np.cos(np.pi * np.clip(t, 0, 0.5) / 0.5))
    second = 0.2 * OMEGA * (1 - np.cos(np.pi * (np.clip(t, 1, 1.25) - 1) / 0.25))
    return first + second


TIMES = np.linspace(0.0, 2.6, 521)
ANGLE = CubicSpline(TIMES, speed(TIMES)).antiderivative()


def shaft(elements, off=OFF, **options):
    beam = jo.BeamBody("shaft", [(0, 0, 0), (L, 0, 0)], SECTION, elements=elements, **options)
    disc = jo.RigidBody(
        "disc", M_DISC, inertia=np.diag(DISC), center=(0, 0, off), position=(L / 2, 0, 0)
    )
    root = jo.Revolute("root", jo.ground["origin"], beam["start"], axis=(1, 0, 0))
    return jo.Mechanism(
        beam,
        disc,
        root,
        jo.Cylindrical("guide", jo.ground.at((L, 0, 0)), beam["end"], axis=(1, 0, 0)),
        jo.Fixed("hub", beam.node(elements // 2), disc["origin"]),
        jo.Drive("motor", root.angle, jo.Table(TIMES, ANGLE(TIMES), "cubic")),
        jo.Gravity((0, 0, -G)),
        jo.PositionSensor("middle", beam.node(elements // 2)),
    )


@cache
def laval(count=6):
    """Mass and stiffness in a_k, b_k, and the deflection of the disc per coordinate."""
    k = np.arange(1, count + 1)
    n = 2 * np.pi * k / L
    M = np.zeros((2 * count, 2 * count))
    M[:count, :count] = LINE_MASS * L * (1 + 0.5 * np.eye(count))
    M[count:, count:] = LINE_INERTIA * L / 2 * np.eye(count)
    disc = np.concatenate([1 - np.cos(np.pi * k), np.zeros(count)])
    M += M_DISC * np.outer(disc, disc)
    K = np.zeros_like(M)
    K[:count, :count] = np.diag(GA * L / 2 * n**2)
    K[:count, count:] = -np.diag(GA * L / 2 * n)
    K[count:, :count] = K[:count, count:]
    K[count:, count:] = np.diag(GA * L / 2 + EI * L / 2 * n**2)
    weight = np.concatenate([np.full(count, LINE_MASS * L), np.zeros(count)]) + M_DISC * disc
    return M, K, disc, weight


def deflection(times, off=OFF):
    """y + i z of the middle from rest under its weight; the mass starts above the axis (z)."""
    M, K, disc, weight = laval()
    squares, modes = eigh(K, M)
    kept = squares < (2e3) ** 2
    squares, modes = squares[kept], modes[:, kept]
    push, load = modes.T @ (M_DISC * off * disc), modes.T @ weight
    d, w = disc @ modes, np.sqrt(squares)
    m = len(w)

    def rate(t, y):
        z, dz = y[:m], y[m:]
        psi, omega = ANGLE(t), speed(t)
        spin = (speed(t + 1e-6) - speed(t - 1e-6)) / 2e-6
        force = 1j * np.exp(1j * psi) * (omega**2 - 1j * spin) * push - 1j * G * load
        return np.concatenate([dz, force - squares * z])

    start = np.concatenate([-1j * G * load / squares, np.zeros(m)])
    done = solve_ivp(rate, (0, times[-1]), start, "DOP853", t_eval=times, rtol=1e-8, atol=1e-10)
    # what the fast modes carry at rest
    rest = -1j * G * disc @ np.linalg.solve(K, weight)
    return d @ done.y[:m] + rest - d @ start[:m]


def test_the_first_frequency_is_that_of_laval_and_of_the_benchmark():
    M, K, *_ = laval(20)
    exact = np.sqrt(eigh(K, M, eigvals_only=True)[0])
    assert exact == pytest.approx(OMEGA, rel=0.06)
    model = jo.compile(shaft(16, off=0.0, mass=0.5, bending=True))
    w = 2 * np.pi * jo.modes(model).frequencies
    assert w[0] == pytest.approx(exact, rel=2e-3)
    assert w[1] == pytest.approx(exact, rel=2e-3)


def run_up(elements, t_end, step, **options):
    model = jo.compile(shaft(elements, **options))
    state = jo.equilibrium(model)
    run = jo.simulate(model, t_end, solver=jo.GeneralizedAlpha(step=step, rho=0.9), state=state)
    return run, run["middle"][:, 1] + 1j * run["middle"][:, 2]


def test_below_the_critical_speed_it_whirls_as_laval_says():
    run, z = run_up(8, 0.6, 4e-3, mass=0.5, bending=True)
    exact = deflection(run.time)
    assert np.abs(z[0] - exact[0]) < 2e-5
    assert np.abs(z - exact).max() < 0.03 * np.abs(exact).max()


@pytest.mark.slow
def test_it_runs_through_the_critical_speed_as_laval_says():
    run, z = run_up(16, 2.5, 1e-3, mass=0.5, bending=True)
    exact = deflection(run.time)
    largest = np.abs(exact).max()
    assert largest > 0.15  # it is a hard ride
    assert np.abs(z - exact).max() < 0.1 * largest
    assert np.abs(z).max() == pytest.approx(largest, rel=0.05)
    assert run.residuals.position.max() < 1e-8
    assert np.abs(run.energy.error).max() < 0.01 * run.energy.kinetic.max()
