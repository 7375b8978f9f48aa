"""Twist of thin sections under tension and pressure, by fibres that lean (Wagner, Biot).

A twist kappa inclines the fibre at a distance r from the shear centre by r kappa, so that a stress
sigma resists with the torque ``sigma Ip kappa``: GJ becomes ``GJ + sigma Ip``, Ip about the shear
centre (M. A. Biot, J. Appl. Phys. 10 (1939) 860-864, who measured it on strips of steel; H. Wagner,
Verdrehung und Knickung von offenen Profilen, 1929). Twist shortens the axis by
``Ip/A kappa^2 / 2``; columns buckle by torsion at ``N = GJ A/Ip``.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
L, B, T = 0.5, 0.020, 0.0005
STRIP = jo.Rectangle(B, T)
AREA, IP = B * T, (B * T**3 + T * B**3) / 12
GJ = STEEL.G * STRIP.J


def held(section: object, material: object = None, **options: object) -> tuple[jo.BeamBody, list]:
    """A beam clamped at its start, whose end slides and turns along and about its axis."""
    beam = jo.BeamBody(
        "strip", [(0, 0, 0), (L, 0, 0)], section, material, elements=4, up=(0, 0, 1), **options
    )
    guide = jo.Cylindrical("guide", jo.ground.at((L, 0, 0)), beam["end"], axis=(1, 0, 0))
    return beam, [jo.Fixed("clamp", jo.ground["origin"], beam["start"]), guide]


def twist(tension: float, torque: float, *section: object, **options: object) -> np.ndarray:
    """Angle of the end, rad, and its displacement, m."""
    beam, joints = held(*section, **options)
    loads = [
        jo.Force("pull", beam["end"], (tension, 0, 0)),
        jo.Torque("turn", beam["end"], (torque, 0, 0)),
    ]
    model = jo.compile(jo.Mechanism(beam, *joints, *loads))
    q = jo.equilibrium(model).q[model.bodies[-1].iq :]
    return np.array([2 * np.arctan2(q[4], q[3]), q[0] - L])


@pytest.mark.parametrize("bending", [False, True])
@pytest.mark.parametrize("stress", [0.0, 50e6, 200e6, 800e6])
def test_biots_strip_resists_twist_by_its_tension(stress, bending):
    """GJ = 0.065 N m2 and 200 MPa Ip = 0.067 N m2: half the twist.

    The fibres' own stretch under small twist is of its square; the strip has stretched by then.
    """
    torque = 1e-4
    angle, _ = twist(stress * AREA, torque, STRIP, STEEL, bending=bending)
    assert angle == pytest.approx(torque * L / (GJ + stress * IP), rel=1e-6)


def test_twist_shortens_a_strip():
    """Without tension the mean stretch of the fibres vanishes: u = -Ip/A kappa^2 L/2."""
    torque = 0.02
    angle, u = twist(0.0, torque, STRIP, STEEL)
    assert angle == pytest.approx(torque * L / GJ, rel=1e-9)
    assert u == pytest.approx(-IP / AREA * (angle / L) ** 2 * L / 2, rel=1e-6)


def test_tension_untwists_a_strip_made_twisted():
    """kappa0 at rest: ``M = GJ (kappa - kappa0) + N Ip/A kappa``."""
    tension = 200e6 * AREA
    kappa = 0.2 / L
    beam, joints = held(STRIP, STEEL, twist=0.2)
    model = jo.compile(jo.Mechanism(beam, *joints, jo.Force("pull", beam["end"], (tension, 0, 0))))
    q = jo.equilibrium(model).q[model.bodies[-1].iq :]
    angle = 2 * np.arctan2(q[4], q[3])
    assert angle == pytest.approx(0.2 + L * kappa * (GJ / (GJ + tension * IP / AREA) - 1), rel=1e-6)


def test_a_round_bar_does_not_mind():
    """sigma/G, 2.5e-3 at 200 MPa: of no account where sections are compact."""
    rod = jo.Circle(0.01)
    torque, tension = 0.1, 200e6 * np.pi * 0.005**2
    angle, _ = twist(tension, torque, rod, STEEL)
    alone = torque * L / (STEEL.G * rod.J)
    assert angle == pytest.approx(alone / (1 + 200e6 / STEEL.G), rel=1e-6)


def test_it_can_be_left_out():
    plain = jo.mechanism.BeamSection.of(STRIP, STEEL, fibres=False)
    angle, u = twist(200e6 * AREA, 1e-4, plain)
    assert angle == pytest.approx(1e-4 * L / GJ, rel=1e-6)


@pytest.mark.parametrize("method", ["linear", "path"])
def test_a_cross_buckles_by_torsion(method):
    """N = GJ A/Ip of a section whose bending is far stiffer (Wagner; Timoshenko and Gere, 5.3)."""
    area, polar, torsion = 4e-4, 8e-4, 20.0
    stiff = (210e9 * area, 7e7, 7e7, torsion, 1e5, 1e5)
    section = jo.mechanism.BeamSection(stiff, 3.0, (2e-3, 1e-3, 1e-3), polar=polar)
    beam, joints = held(section)
    press = jo.Force("press", beam["end"], (-1, 0, 0), signal=jo.Input("P"))
    model = jo.compile(jo.Mechanism(beam, *joints, press))
    to = 1.5 * torsion / polar if method == "path" else None
    found = jo.simulation.buckling(model, "P", 1, method=method, to=to).loads
    # it has shortened by 3e-4 by then
    assert found == pytest.approx([torsion / polar], rel=1e-3)


def test_the_shear_centre_counts():
    """polar = (Iy + Iz)/A + |s - c|^2."""
    made = jo.mechanism.BeamSection.of(STRIP, STEEL, centroid=(0.01, 0.0), shear_center=(0.0, 0.02))
    assert made.polar == pytest.approx(IP / AREA + 0.01**2 + 0.02**2)
    with pytest.raises(jo.InputError, match="polar is -1 m2, must be zero or positive"):
        jo.mechanism.BeamSection((1.0,) * 6, 1.0, (2.0, 1.0, 1.0), polar=-1.0)


def test_section_forces_are_those_of_the_engine():
    """Torque at the ends, the moment applied, and the strain of the axis, from the results."""
    torque, tension = 0.01, 200e6 * AREA
    beam, joints = held(STRIP, STEEL)
    loads = [
        jo.Force("pull", beam["end"], (tension, 0, 0)),
        jo.Torque("turn", beam["end"], (torque, 0, 0)),
    ]
    sensor = jo.mechanism.SectionSensor("end", beam, "end")
    model = jo.compile(jo.Mechanism(beam, *joints, *loads, sensor))
    run = jo.simulate(
        model, 1e-4, solver=jo.GeneralizedAlpha(step=1e-4), state=jo.equilibrium(model)
    )
    forces = jo.recovery.section_forces(run, "strip")
    assert forces.ends[0, -1, 1, [0, 3]] == pytest.approx([tension, torque], rel=1e-6)
    assert run["end"][0, [0, 3]] == pytest.approx([tension, torque], rel=1e-6)
    # the torque of Saint-Venant is what is left for shear
    kappa = torque / (GJ + tension * IP / AREA)
    assert forces.resultants[0, 1, 3] == pytest.approx(GJ * kappa, rel=1e-6)
