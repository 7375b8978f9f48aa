"""Joints and couplings one at a time against closed forms of their motion."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification.mechanisms import march

G = 9.81
Z = (0.0, 0.0, 1.0)
DOWN = jo.Gravity((0.0, 0.0, -G))


def accelerations(*items):
    """Accelerations of every body (k, 6) at the start."""
    model = jo.compile(jo.Mechanism(*items))
    return np.asarray(jo.model.Engine(model).accelerations()[0]).reshape(-1, 6)


def test_a_nut_falls_along_its_screw():
    # T = (m + J (2 pi / p)^2) s'^2 / 2, V = m g s
    mass, J, pitch = 2.0, 0.003, 0.15
    nut = jo.RigidBody("nut", mass, (0.01, 0.01, J))
    screw = jo.Screw("screw", jo.ground["origin"], nut["origin"], pitch, Z)
    a = accelerations(nut, screw, DOWN)[0]
    expected = -G * mass / (mass + J * (2 * np.pi / pitch) ** 2)
    np.testing.assert_allclose(a[2], expected, rtol=1e-12)
    np.testing.assert_allclose(a[5], expected * 2 * np.pi / pitch, rtol=1e-12)


def test_a_block_slides_down_an_incline():
    slope = np.radians(25.0)
    axis = np.array([np.cos(slope), 0.0, -np.sin(slope)])
    block = jo.RigidBody("block", 3.0, (0.1, 0.2, 0.3))
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis)
    place = jo.PositionSensor("place", block["origin"])
    model = jo.compile(jo.Mechanism(block, slide, DOWN, place))
    run = march(model, jo.RK4(step=0.01), 1.0)
    expected = 0.5 * G * np.sin(slope) * axis
    np.testing.assert_allclose(run.sensors["place"][-1], expected, rtol=1e-11, atol=1e-13)


def test_a_torque_on_one_gear_turns_both():
    Ja, Jb, ratio, torque = 0.02, 0.5, -0.4, 3.0
    a, b = (jo.RigidBody(n, 1.0, (J, J, J)) for n, J in (("a", Ja), ("b", Jb)))
    pivots = [jo.Revolute(f"{w.name} pivot", jo.ground["origin"], w["origin"], Z) for w in (a, b)]
    gear = jo.Gear("gear", pivots[0].angle, pivots[1].angle, ratio)
    spin = accelerations(a, b, *pivots, gear, jo.Torque("push", a["origin"], (0, 0, torque)))
    expected = torque / (Ja + ratio**2 * Jb)
    np.testing.assert_allclose(spin[:, 5], [expected, ratio * expected], rtol=1e-12)


def test_a_rack_falls_and_turns_its_pinion():
    J, mass, radius = 0.04, 2.0, 0.1
    pinion = jo.RigidBody("pinion", 1.0, (J, J, J))
    rack = jo.RigidBody("rack", mass, (0.1, 0.1, 0.1))
    pivot = jo.Revolute("pivot", jo.ground["origin"], pinion["origin"], (0.0, 1.0, 0.0))
    slide = jo.Prismatic("slide", jo.ground["origin"], rack["origin"], Z)
    mesh = jo.Rack("mesh", pivot.angle, slide.displacement, radius)
    a = accelerations(pinion, rack, pivot, slide, mesh, DOWN)
    expected = -mass * G / (mass + J / radius**2)
    np.testing.assert_allclose(a[1, 2], expected, rtol=1e-12)
    np.testing.assert_allclose(a[0, 4], expected / radius, rtol=1e-12)


# two shafts held at both bearings repeat two rows
@pytest.mark.filterwarnings("ignore:.*constraint rows:jousto.JoustoWarning")
@pytest.mark.parametrize("angle", [20.0, 45.0])
def test_a_cardan_shaft_turns_unevenly(angle):
    # the driving fork, square to the plane of both shafts at phi = 0, and the driven one stay
    # square: (-sin phi, cos phi) . (cos b cos psi, sin psi) = 0, so tan psi = cos b tan phi
    b, rate = np.radians(angle), 2.0
    out = np.array([np.sin(b), 0.0, np.cos(b)])
    shafts = [jo.RigidBody(n, 1.0, (0.1, 0.1, 0.1)) for n in ("in", "out")]
    pivots = [
        jo.Revolute("in pivot", jo.ground["origin"], shafts[0]["origin"], Z),
        jo.Cylindrical("out pivot", jo.ground["origin"], shafts[1]["origin"], out),
    ]
    cross = jo.Universal(
        "cross", shafts[0]["origin"], shafts[1]["origin"], (0, 1, 0), np.cross((0, 1, 0), out)
    )
    drive = jo.Drive("drive", pivots[0].angle, jo.Ramp(0.0, 10.0, 0.0, 10.0 * rate))
    sensors = [jo.AngularVelocitySensor(s.name, s["origin"]) for s in shafts]
    mechanism = jo.Mechanism(*shafts, *pivots, cross, drive, *sensors)
    run = march(jo.compile(mechanism), jo.RK4(step=1e-3), 3.0, 0.1)
    phi = rate * run.time
    expected = rate * np.cos(b) / (1 - np.sin(b) ** 2 * np.sin(phi) ** 2)
    np.testing.assert_allclose(run.sensors["out"] @ out, expected, rtol=1e-12)
