"""Twist of frames of linear beams under tension, pressure and spin: fibres that lean.

A twist rx' inclines the fibre at a distance r from the axis, so that tension N resists it with
``N (Iy + Iz)/A rx'`` (Wagner 1929; Biot, J. Appl. Phys. 10 (1939) 860-864), and the sections of a
blade turn towards the plane of rotation (Houbolt and Brooks, NACA report 1346, 1958).
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg as sl
from scipy.sparse.linalg import spsolve

import jousto as jo
from verification.boxes import block
from verification.hubs import on_a_hub
from verification.solids import solid

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
L, B, T = 0.5, 0.020, 0.0005
STRIP = jo.Rectangle(B, T)  # flat: the width along y
AREA, IY, IZ = B * T, B * T**3 / 12, T * B**3 / 12
IP, GJ = IY + IZ, STEEL.G * STRIP.J
PULL = 200e6 * AREA


@pytest.mark.parametrize("n", [1, 4])
def test_a_strip_under_tension_twists_half_as_far(n):
    """Of the part's matrices: ``T L/(GJ + N Ip/A)``, with any number of elements."""
    part = jo.Part.beam(L, STRIP, n, STEEL)
    free = np.arange(6, 6 * (n + 1))
    K, f, d = part.K.toarray(), np.zeros(6 * (n + 1)), np.zeros(6 * (n + 1))
    f[6 * n] = PULL
    d[free] = np.linalg.solve(K[np.ix_(free, free)], f[free])
    K += part.geometric_stiffness(d).toarray()
    f[:] = 0.0
    f[6 * n + 3] = 1e-4
    d[free] = np.linalg.solve(K[np.ix_(free, free)], f[free])
    assert d[6 * n + 3] == pytest.approx(1e-4 * L / (GJ + PULL * IP / AREA), rel=1e-9)
    assert d[6 * n + 3] < 0.51 * 1e-4 * L / GJ


def body(*, section: jo.Section = STRIP, stiffening: bool = True) -> tuple[jo.FlexibleBody, list]:
    """A modal body clamped at its start, whose end slides and turns along and about its axis."""
    part = jo.Part.beam(L, section, 4, STEEL)
    method = jo.CraigBampton(interfaces=("start", "end"), modes=0)
    strip = jo.FlexibleBody("strip", jo.reduce(part, method, stiffening=stiffening))
    guide = jo.Cylindrical("guide", jo.ground.at((L, 0, 0)), strip["end"], axis=(1, 0, 0))
    return strip, [jo.Fixed("clamp", jo.ground["origin"], strip["start"]), guide]


@pytest.mark.parametrize("stiffening", [True, False])
def test_a_modal_body_under_tension(stiffening):
    """The same of a body in a mechanism; without stiffening tension does not matter."""
    strip, joints = body(stiffening=stiffening)
    loads = [
        jo.Force("pull", strip["end"], (PULL, 0, 0)),
        jo.Torque("turn", strip["end"], (1e-4, 0, 0)),
    ]
    angle = jo.OrientationSensor("angle", strip["end"])
    model = jo.compile(jo.Mechanism(strip, *joints, *loads, angle))
    rest = jo.equilibrium(model)
    e = jo.simulate(model, 1e-7, solver=jo.RK4(step=1e-7), state=rest)["angle"][0]
    expected = 1e-4 * L / (GJ + (PULL * IP / AREA if stiffening else 0.0))
    assert 2 * np.arctan2(e[1], e[0]) == pytest.approx(expected, rel=1e-6)


def test_a_cross_buckles_by_torsion():
    """N = GJ A/Ip, four flanges b x t (Timoshenko and Gere, *Theory of Elastic Stability*, 5.3)."""
    b, t = 0.05, 0.002
    area, inertia, torsion = 4 * b * t, 2 * t * b**3 / 3, 4 * b * t**3 / 3
    cross = jo.sections.GeneralSection(A=area, Iy=inertia, Iz=inertia, J=torsion, ky=0.5, kz=0.5)
    column, joints = body(section=cross)
    press = jo.Force("press", column["end"], (-1, 0, 0), signal=jo.Input("P"))
    model = jo.compile(jo.Mechanism(column, *joints, press))
    exact = STEEL.G * torsion * area / (2 * inertia)
    assert exact < 0.05 * 4 * np.pi**2 * STEEL.E * inertia / L**2  # Euler's load is far
    assert jo.simulation.buckling(model, "P", 1).loads == pytest.approx([exact], rel=1e-6)


def torsion_of_a_blade(speed: float, modes: int = 12) -> np.ndarray:
    """Lowest angular frequencies of a flat blade clamped on the axis it turns about, Galerkin.

    ``((GJ + N Ip/A) phi')' - rho W^2 (Iz - Iy) phi + rho Ip w^2 phi = 0``, N = rho A W^2 (L^2 -
    x^2)/2 (Houbolt and Brooks, eq. 27 without warping, pretwist and coupling), in sines of the
    blade at rest.
    """
    x, weight = np.polynomial.legendre.leggauss(200)
    x, weight = 0.5 * L * (x + 1), 0.5 * L * weight
    k = (2 * np.arange(modes) + 1) * np.pi / (2 * L)
    phi, slope = np.sin(np.outer(k, x)), k[:, None] * np.cos(np.outer(k, x))
    stiff = GJ + STEEL.rho * speed**2 * (L**2 - x**2) / 2 * IP
    K = (slope * weight * stiff) @ slope.T
    K += STEEL.rho * speed**2 * (IZ - IY) * (phi * weight) @ phi.T
    return np.sqrt(sl.eigvalsh(K, STEEL.rho * IP * (phi * weight) @ phi.T))


@pytest.mark.parametrize("speed", [100.0, 400.0])
def test_a_spun_strip_gains_torsional_frequency(speed):
    """Linear twist within an element errs by ``(pi h/2 L)^2/24`` at rest, and so it does spun."""
    exact, errors = torsion_of_a_blade(speed)[0], []
    for n in (4, 8, 16):
        part = jo.Part.beam(L, STRIP, n, STEEL)
        method = jo.CraigBampton(interfaces=("start",), modes=6 * n - 2)
        blade = jo.reduce(part, method, stiffening=True)
        assert blade.rotations is not None
        turn, move = np.abs(blade.rotations[:, 0]).max(0), np.abs(blade.modes).max((0, 1))
        twisting = blade.keep(np.flatnonzero(B * turn > 0.9 * move))
        assert twisting.n == n
        found = on_a_hub(twisting, "start", speed)
        errors.append(found[found > 1.0][0] / exact - 1)
    assert errors[2] == pytest.approx(0.0, abs=(np.pi / 32) ** 2 / 24)
    assert np.log2(errors[:2]) - np.log2(errors[1:]) == pytest.approx([2.0, 2.0], abs=0.05)
    # W of the fibres, W of the sections that turn towards the plane of rotation: 2 W^2 together
    rest = np.pi / (2 * L) * np.sqrt(GJ / (STEEL.rho * IP))
    assert exact**2 - rest**2 == pytest.approx(2 * speed**2, rel=0.05)


def test_solids_twist_alike():
    """The same strip of solids, which know nothing of sections: between the quarters of it.

    Clamped edges do not let the fibres lean and twist less: they act within the width of the strip.
    """
    grid = block(
        "hexahedron20",
        (L, B, T),
        (32, 4, 1),
        bend=lambda x: x - np.array([0.0, B / 2, T / 2]),
    )
    part = solid(grid, STEEL)
    x = part.nodes
    free = np.flatnonzero(np.repeat(x[:, 0] > 1e-9, 3))
    K = part.K.tocsc()
    end = grid.plane(0, L)
    angles = []
    for tension in (0.0, PULL):
        d = np.zeros(K.shape[0])
        d[0::3] = tension / (STEEL.E * AREA) * x[:, 0]
        for axis in (1, 2):
            d[axis::3] = -STEEL.nu * tension / (STEEL.E * AREA) * x[:, axis]
        full = (K + part.geometric_stiffness(d)).tocsc()[free][:, free]
        load = np.zeros(K.shape[0])
        load[3 * end + 2] = x[end, 1]  # any torque: only the ratio counts
        w = np.zeros(K.shape[0])
        w[free] = spsolve(full, load[free])
        turn = [
            np.polyfit(x[at, 1], w[3 * at + 2], 1)[0]
            for at in (grid.plane(0, L / 4), grid.plane(0, 3 * L / 4))
        ]
        angles.append(turn[1] - turn[0])
    assert angles[1] / angles[0] == pytest.approx(GJ / (GJ + PULL * IP / AREA), rel=0.01)
