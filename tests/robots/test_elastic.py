"""Elastic joints of robots: the same machine as by hand, motors on the other side of the gear."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import ElasticJoint
from jousto.robots.readers.mjcf import read_mjcf

MODEL = """
<mujoco model="arm"><option gravity="0 0 -9.81"/><worldbody>
  <body name="upper">
    <inertial pos="0.25 0 0" mass="4" diaginertia="0.01 0.09 0.09"/>
    <joint name="shoulder" type="hinge" axis="0 1 0" armature="0.5"/>
    <body name="lower" pos="0.5 0 0">
      <inertial pos="0.2 0 0" mass="2" diaginertia="0.004 0.03 0.03"/>
      <joint name="elbow" type="hinge" axis="0 1 0"/>
    </body></body></worldbody>
  <actuator>
    <motor name="push" joint="shoulder" gear="2"/>
    <position name="hold" joint="elbow" kp="300" kv="20" forcerange="-60 60"/>
  </actuator></mujoco>
"""
GEARS: dict[str, dict[str, Any]] = {
    "shoulder": {"ratio": 100, "stiffness": 9e3, "damping": 4.0},
    "elbow": {"ratio": -50, "rotor_inertia": 8e-5, "stiffness": 4e3, "damping": 2.0},
}


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> jo.robots.Robot:
    path = tmp_path_factory.mktemp("arm") / "arm.xml"
    path.write_text(MODEL)
    return read_mjcf(path)


def test_it_is_the_machine_made_by_hand(robot: jo.robots.Robot) -> None:
    """Actuators act through the gear: tau / N on the motor, a servo on N times its angle."""
    machine = jo.robots.mechanism(robot, at={"elbow": 0.3}, elastic=GEARS)
    assert jo.doctor(jo.compile(machine)).core == "joint coordinates (4 of a tree)"
    upper = jo.RigidBody("upper", 4.0, (0.01, 0.09, 0.09), center=(0.25, 0, 0))
    turned = jo.Rotate((0, 1, 0), radians=0.3)
    lower = jo.RigidBody(
        *("lower", 2.0, (0.004, 0.03, 0.03)),
        center=(0.2, 0, 0),
        position=(0.5, 0, 0),
        orientation=turned,
    )
    shoulder = jo.Revolute("shoulder", jo.ground["origin"], upper["origin"], axis=(0, 1, 0))
    elbow = jo.Revolute("elbow", upper.at((0.5, 0, 0)), lower["origin"], axis=(0, 1, 0))
    one = ElasticJoint("one", shoulder.angle, 100, 0.5 / 100**2, 9e3, damping=4.0)
    two = ElasticJoint("two", elbow.angle, -50, 8e-5, 4e3, damping=2.0)
    push = jo.JointForce("push", one.motor, 2.0 * 5.0 / 100)
    wanted = jo.Constant(-50 * (0.8 - 0.3))
    hold = jo.Servo("hold", two.motor, wanted, 300 / 2500, 20 / 2500, 60 / 50)
    read = [jo.CoordinateSensor(x.name, x.angle) for x in (shoulder, elbow)]
    weight = jo.Gravity((0, 0, -9.81))
    hand = jo.Mechanism(upper, lower, shoulder, elbow, one, two, push, hold, *read, weight)
    steps = jo.simulation.DormandPrince(output=0.02, tolerance=1e-10)
    found = jo.simulate(jo.compile(machine), 0.4, solver=steps, inputs={"push": 5.0, "hold": 0.8})
    exact = jo.simulate(jo.compile(hand), 0.4, solver=steps)
    np.testing.assert_allclose(found["shoulder"], exact["shoulder"], atol=1e-7)
    np.testing.assert_allclose(found["elbow"] - 0.3, exact["elbow"], atol=1e-7)


def test_drives_and_efforts_are_those_of_the_joint(robot: jo.robots.Robot) -> None:
    """Behind a stiff gear a driven joint follows its signal; a torque is that of the joint."""
    stiff = {name: {**gear, "stiffness": 2e5} for name, gear in GEARS.items()}
    swing = jo.SCurve((0, 0.4), (0.2, 0.9))
    driven = jo.robots.mechanism(
        robot, drives={"elbow": swing}, efforts={"shoulder": 30.0}, elastic=stiff
    )
    plain = jo.robots.mechanism(robot, drives={"elbow": swing}, efforts={"shoulder": 30.0})
    runs = [jo.simulate(jo.compile(x), 0.4, solver=jo.RK4(5e-5)) for x in (driven, plain)]
    np.testing.assert_allclose(runs[0]["elbow"], swing(runs[0].time)[:, None], atol=5e-4)
    np.testing.assert_allclose(runs[0]["shoulder"], runs[1]["shoulder"], atol=5e-3)


@pytest.mark.parametrize(
    "elastic, message",
    [
        ({"elbw": GEARS["elbow"]}, "elastic\\['elbw'\\]: no such joint; did you mean 'elbow'"),
        ({"elbow": 8e3}, "must be a mapping of arguments of ElasticJoint"),
        ({"elbow": {**GEARS["elbow"], "name": "x"}}, "name is that of the joint; leave it out"),
        ({"elbow": {"ratio": 50, "stiffness": 1.0}}, "missing 1 argument: 'rotor_inertia'"),
        ({"elbow": {**GEARS["elbow"], "ratio": 0}}, "ratio is 0, must not be zero"),
    ],
)
def test_what_is_wrong_is_named(robot: jo.robots.Robot, elastic: Any, message: str) -> None:
    with pytest.raises(jo.InputError, match=message):
        jo.robots.mechanism(robot, elastic=elastic)


def test_a_wrong_ratio_beside_the_rotor_of_a_file_is_named(robot: jo.robots.Robot) -> None:
    joints = tuple(replace(x, armature=0.1) for x in robot.joints)
    elastic = {"elbow": {"ratio": "fast", "rotor_inertia": 1e-4, "stiffness": 1.0}}
    with pytest.raises(jo.InputError, match="ratio is 'fast', must be a number"):
        jo.robots.mechanism(replace(robot, joints=joints), elastic=elastic)
