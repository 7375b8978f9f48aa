"""Joints as data, coordinates, couplings, signals and force elements."""

from __future__ import annotations

import numpy as np
import pytest

from jousto.base.declare import kinds
from jousto.base.errors import InputError, JoustoWarning
from jousto.base.rotations import Rotate
from jousto.mechanism.bodies.body import FlexibleBody, RigidBody, ground
from jousto.mechanism.forces.friction import Friction
from jousto.mechanism.forces.loads import Gravity
from jousto.mechanism.forces.springs import Bushing, Servo, Spring
from jousto.mechanism.joints.base import align_frames
from jousto.mechanism.joints.coupling import Drive, Gear
from jousto.mechanism.joints.hinges import Revolute, Screw, Universal
from jousto.mechanism.joints.points import Rod
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.scalar import (
    CoordinateSensor,
    EnergySensor,
    RateSensor,
    SignalSensor,
)
from jousto.mechanism.signals.base import Input
from jousto.mechanism.signals.harmonic import Harmonic
from jousto.mechanism.signals.piecewise import Ramp, SCurve, Step, Table

G = Gravity((0, -9.81, 0))
ROWS = {
    "Spherical": 3, "Revolute": 5, "Fixed": 6, "Prismatic": 5, "Cylindrical": 4, "Universal": 4,
    "Planar": 3, "PointOnLine": 2, "PointOnPlane": 1, "ConstantOrientation": 3, "Rod": 1,
    "Screw": 5, "ParallelAxes": 2, "Perpendicular": 1,
    "RollingDisc": 3, "RollingWheel": 2, "KnifeEdge": 1, "RailWheel": 2,
}  # fmt: skip


def body(name="b", **kwargs):
    return RigidBody(name, 1.0, (1, 1, 1), markers={"tip": (1, 0, 0)}, **kwargs)


@pytest.mark.parametrize(
    "cls", kinds("joints", "jousto.mechanism.joints").values(), ids=lambda c: c.__name__
)
def test_rows_of_joints(cls):
    more = {"pitch": 0.01} if cls is Screw else {}
    if "Rolling" in cls.__name__ or cls.__name__ == "RailWheel":
        more = {"radius": 0.1, "axle": (0, 1, 0)}
    if cls.__name__ == "KnifeEdge":
        more = {"across": (0, 1, 0)}
    joint = cls("j", ground["origin"], body()["tip" if cls is Rod else "origin"], **more)
    assert joint.rows == len(joint.row_names) == ROWS[cls.__name__]


def test_frames_of_many_joints_are_those_of_each(rng, rod):
    """At once or one by one: both sides have the axis for z, by the smallest turn of side a.

    Axes at random, none, along z, against it, nearly against it; every sixth joint is on a bent
    modal body.
    """
    bent = FlexibleBody("rod", rod, modal_coordinates=np.full(rod.n, 1e-3))
    joints = []
    for i in range(60):
        a = body(f"a{i}", orientation=Rotate(rng.normal(size=3), degrees=70))
        b = body(f"b{i}", orientation=Rotate((1, 2, 3), degrees=40))["origin"]
        side = a["tip"].turned(Rotate((3, 2, 1), degrees=50))
        z = side.A[:, 2]
        axis = (rng.normal(size=3), None, 2.0 * z, -z, 1e-4 * rng.normal(size=3) - z)[i % 5]
        joints.append(Revolute(f"j{i}", side, bent["end"] if i % 6 == 5 else b, axis))
    align_frames(joints)
    for joint in joints:
        axis = joint.a.A[:, 2] if joint.axis is None else joint.axis
        alone = Revolute("alone", joint.a, joint.b, joint.axis)  # works out its own frames
        for side, other in zip(joint.frames, alone.frames, strict=True):
            np.testing.assert_allclose(side.A[:, 2], axis / np.linalg.norm(axis), atol=1e-11)
            np.testing.assert_allclose(side.axes, other.axes, atol=1e-11)
            assert not side.axes.flags.writeable
        np.testing.assert_allclose(joint.frames[0].A, joint.frames[1].A, atol=1e-14)


def test_universal_angles_are_those_of_the_cross():
    """b = turn by s about z, then by t about the turned x axis: angles s and t."""
    s, t = 0.3, 0.7
    turned = (
        Rotate((0, 0, 1), degrees=np.degrees(s)).matrix
        @ Rotate((1, 0, 0), degrees=np.degrees(t)).matrix
    )
    # h_b is the z axis of b, h_a at t = 0 its y axis
    axes = turned @ np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]], dtype=float)
    b = body(orientation=axes)
    joint = Universal("u", ground["origin"], b["origin"], as_placed=False)
    assert joint.angle1.initial == pytest.approx(s, abs=1e-14)
    assert joint.angle2.initial == pytest.approx(t, abs=1e-14)
    placed = Universal("u", ground["origin"], b["origin"])
    assert abs(placed.angle1.initial) + abs(placed.angle2.initial) < 1e-14


@pytest.mark.parametrize(
    "signal",
    [
        Harmonic(frequency=0.4, amplitude=2, phase=0.2),
        SCurve((0, 1, 3), (0, 2, -1)),
        Table((0, 1, 2, 4), (0, 1, -1, 3), "cubic"),
        Ramp(0.2, 3.5, 1, 4) * Harmonic(frequency=1) - 2.0,
    ],
)
def test_rates_are_derivatives(signal):
    t, h = np.array([0.35, 1.4, 2.6]), 1e-4
    rate = (signal(t + h) - signal(t - h)) / (2 * h)
    bend = (signal(t + h) - 2 * signal(t) + signal(t - h)) / h**2
    np.testing.assert_allclose(signal.rate(t), rate, atol=2e-5)
    np.testing.assert_allclose(signal.acceleration(t), bend, atol=2e-4)


def test_table_from_csv(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("# motion\ntime,angle\n0,1\n2,3\n")
    assert Table.from_csv(path, time="time", value="angle")(1.0) == 2.0
    with pytest.raises(InputError, match="no column 'angel'; did you mean 'angle'"):
        Table.from_csv(path, value="angel")


def test_two_drives_and_a_jump():
    b = body()
    hinge = Revolute("hinge", ground["origin"], b["origin"])
    one = Drive("one", hinge.angle, Step(1.0))
    with pytest.warns(JoustoWarning, match="drive 'one': its signal jumps at t = 1 s"):
        assert Mechanism(b, hinge, one, G).mobility == 0
    two = Drive("two", hinge.angle, 0.0)
    with pytest.raises(InputError, match="drive 'two': drives hinge.angle, which drive 'one'"):
        Mechanism(b, hinge, one, two, G)


def test_a_factor_that_jumps_where_the_other_is_zero_makes_no_jump():
    ramp = Ramp(0.0, 2.0, -1.0, 1.0)
    assert (Step(1.0) * ramp).jumps == ()
    assert (Step(1.0) * ramp).kinks == (0.0, 1.0, 2.0)
    assert (Step(1.5) * ramp).jumps == (1.5,)
    assert (Step(1.0) * Input("u")).jumps == (1.0,)


BAD = [
    (lambda j: Friction("f", j, 0.3, 0.2, radius=0.1), "mu_static is 0.2, must not be below"),
    (lambda j: Friction("f", j, 0.3, radius=0.0), "radius is 0 m, must be a positive number"),
    (lambda j: Servo("s", j.angle, 0.0, kp=-1), "kp is -1, must not be negative"),
    (lambda j: Gear("g", j.angle, j.angle, 2.0), "couples hinge.angle with itself"),
    (lambda j: Bushing("b", j.a, j.b, (1, 1, 1, 1, 1, -1)), "negative eigenvalue -1"),
    (lambda j: Spring("s", j), "is the joint 'hinge'; name a coordinate of it, hinge.angle"),
]


@pytest.mark.parametrize(("make", "text"), BAD)
def test_bad_elements_say_why(make, text):
    hinge = Revolute("hinge", ground["origin"], body()["origin"])
    with pytest.raises(InputError) as error:
        make(hinge)
    assert text in str(error.value)


def test_sensors_of_one_number():
    hinge = Revolute("hinge", ground["origin"], body()["origin"])
    assert CoordinateSensor("s", hinge.angle).unit == "rad"
    assert RateSensor("s", hinge.angle).description == "rate of hinge.angle"
    with pytest.raises(InputError, match="did you mean 'kinetic'"):
        EnergySensor("e", "kinetik")
    with pytest.raises(InputError, match="signal is .3., must be a number or a signal"):
        SignalSensor("s", "3")


@pytest.mark.parametrize("named", [{}, {"stiffness": 1e3}])
def test_a_spring_of_two_markers_says_the_right_call(named):
    ball = RigidBody("ball", 1.0, (1, 1, 1), position=(1, 0, 0))
    with pytest.raises(InputError, match=r"two markers .*Spring.between\(name, a, b, stiffness"):
        Spring("s", ground["origin"], ball["origin"], **named)
