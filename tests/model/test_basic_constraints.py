"""Joints composed of the basic constraints s, d1, d2, p1, p2 (Rantalainen 2007, eq. 3.90-3.97)."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo

G = (1.0, -9.81, 2.0)
Z = np.array([0.3, 0.5, 1.0]) / np.linalg.norm([0.3, 0.5, 1.0])
X = np.cross((0.0, 1.0, 0.0), Z) / np.linalg.norm(np.cross((0.0, 1.0, 0.0), Z))
Y = np.cross(Z, X)


def axes(name, a, b):
    return jo.mechanism.ParallelAxes(name, a, b, Z)


def crossed(name, a, b):
    return jo.mechanism.Perpendicular(name, a, b, X, Y)


def line(name, a, b):
    return jo.PointOnLine(name, a, b, Z)


def plane(name, a, b):
    return jo.PointOnPlane(name, a, b, Z)


COMPOSED = {
    "revolute": (lambda a, b: jo.Revolute("j", a, b, Z), (jo.Spherical, axes)),
    "universal": (lambda a, b: jo.Universal("j", a, b, X, Y), (jo.Spherical, crossed)),
    "cylindrical": (lambda a, b: jo.Cylindrical("j", a, b, Z), (axes, line)),
    "prismatic": (lambda a, b: jo.Prismatic("j", a, b, Z), (axes, crossed, line)),
    "planar": (lambda a, b: jo.Planar("j", a, b, Z), (axes, plane)),
    "fixed": (lambda a, b: jo.Fixed("j", a, b), (jo.Spherical, axes, crossed)),
}


def machine(make):
    """Return the model of a flexible arm on a ball joint that holds a rigid hand by joints."""
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.03), 4, jo.Material(E=2e9, nu=0.3, rho=1000.0))
    reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2))
    arm = jo.FlexibleBody("arm", reduced, damping=0.05)
    hand = jo.RigidBody("hand", 0.6, (0.01, 0.06, 0.05), center=(0.2, 0.1, 0), position=(1, 0, 0))
    pivot = jo.Spherical("pivot", jo.ground["origin"], arm["start"])
    joints = make(arm["end"], hand["origin"])
    sensors = [jo.ReactionSensor(f"r {joint.name}", joint) for joint in joints]
    return jo.compile(
        jo.Mechanism(arm, hand, pivot, *joints, jo.Gravity(G), *sensors,
                     jo.PositionSensor("place", hand.at((0.3, 0.2, 0.1))))
    )  # fmt: skip


@pytest.mark.parametrize("name", COMPOSED)
def test_basic_constraints_make_up_a_joint(name):
    """The same rows in several joints: motion, and the sum of the reactions about b."""
    whole, basic = COMPOSED[name]
    runs = [
        jo.simulate(machine(make), 0.2, solver=jo.RK4(step=5e-4), output_step=0.02)
        for make in (
            lambda a, b: [whole(a, b)],
            lambda a, b: [kind(f"c{i}", a, b) for i, kind in enumerate(basic)],
        )
    ]
    assert np.ptp(runs[0]["place"], axis=0).max() > 0.05
    # the constraint matrices differ in the order of rows only: round-off, grown by 400 steps
    np.testing.assert_allclose(runs[1]["place"], runs[0]["place"], rtol=0, atol=1e-9)
    expected = runs[0]["r j"]
    total = sum(runs[1][f"r c{i}"] for i in range(len(basic)))
    np.testing.assert_allclose(total, expected, rtol=0, atol=1e-7 * np.abs(expected).max())


def test_parallel_axes_hold_a_spinning_top_upright_by_a_moment_alone():
    """A shaft that spins by W in a frame turning by V about x: moment J W V, and no force.

    Its axis z keeps parallel to that of the frame, whose turn is driven; the shaft falls freely.
    """
    V, W, J = 0.7, 30.0, 0.4
    frame = jo.RigidBody("frame", 1.0, (1, 1, 1), angular_velocity=(V, 0, 0))
    shaft = jo.RigidBody("shaft", 2.0, (0.2, 0.2, J), angular_velocity=(V, 0, W))
    yoke = jo.Revolute("yoke", jo.ground["origin"], frame["origin"], (1, 0, 0))
    even = jo.Drive("even", yoke.angle, jo.Ramp(-100.0, 100.0, before=-100 * V, after=100 * V))
    hold = jo.mechanism.ParallelAxes("hold", frame["origin"], shaft["origin"])
    sensors = (
        jo.ReactionSensor("moment", hold, resolved_in=frame["origin"]),
        jo.CoordinateSensor("turn", hold.angle),
        jo.PositionSensor("place", shaft["origin"]),
    )
    items = (frame, shaft, yoke, even, hold, jo.Gravity((0, -9.81, 0)), *sensors)
    run = jo.simulate(jo.compile(jo.Mechanism(*items)), 0.1, solver=jo.RK4(step=1e-3))
    expected = np.zeros((len(run.time), 6))
    expected[:, 4] = -J * W * V  # J W z turns towards -y: x cross z
    np.testing.assert_allclose(run["moment"], expected, atol=1e-8)
    np.testing.assert_allclose(run["turn"][:, 0], W * run.time, atol=1e-8)
    np.testing.assert_allclose(run["place"][:, 1], -4.905 * run.time**2, atol=1e-10)


def test_axes_that_are_not_at_a_right_angle_are_refused():
    ball = jo.RigidBody("ball", 1.0, (1, 1, 1))
    with pytest.raises(jo.InputError, match="the axes are at 45 deg to each other, must be at 90"):
        jo.mechanism.Perpendicular("p", jo.ground["origin"], ball["origin"], (1, 0, 0), (1, 1, 0))
