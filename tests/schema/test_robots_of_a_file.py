"""Robots in model files: names that others refer to, and everything that may be wrong with them."""

from __future__ import annotations

import json
import random
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from robots.damage import damaged
from robots.machines import ARM
from schema.test_fuzz import only_ours, spoilt

MODEL = """bodies:
  - {name: cart, mass: 9, inertia: [1, 1, 1], markers: {top: [0, 0, 100 mm]}}
robots:
  - {name: arm, file: arm.urdf, base: cart.top, at: {j2: -30 deg, j3: 0.5}, stops: no}
  - {name: other, file: arm.urdf, base: arm_tcp, prefix: "o ", losses: no, at: {j2: 10 deg},
     position: [0, 0, 10 mm], orientation: {axis: [1, 0, 0], angle_deg: 90}}
joints:
  - {type: prismatic, name: slide, a: ground.origin, b: cart.origin, axis: [1, 0, 0]}
forces:
  - {type: servo, name: motor, coordinate: arm_j2.angle, reference: 20 deg, kp: 4 kN m/rad, kd: 400}
  - {type: force, name: pull, marker: o tcp.origin, vector: [0, 0, 10]}
  - {type: force, name: push, marker: {body: arm_tool, at: [0, 0, 10 mm]}, vector: [0, 0, 10]}
couplings:
  - {type: coupling, name: both, coordinates: [arm_j4.angle, o j4.angle], factors: [1, 1]}
sensors:
  - {type: position, name: tip, marker: arm_l6.tcp}
  - {type: orientation, name: axes, marker: arm_tcp.origin}
  - {type: reaction, name: foot, joint: arm_base}
events:
  - {name: far, watch: o j2, threshold: 1 rad}
  - {name: high, watch: arm_j2.angle, threshold: 30 deg}
gravity: [0, 0, -9.81]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with the file of the robot."""
    (tmp_path / "arm.urdf").write_text(ARM, encoding="utf-8")
    return tmp_path


def told(text: str, folder: Path) -> list[str]:
    """Return what is wrong with a model, without the name of the file."""
    with pytest.raises(jo.InputError) as error:
        jo.schema.read.parse_model(text, name="m", folder=folder)
    text = str(error.value).replace(f"{folder}/", "")
    return [line.removeprefix("m:") for line in text.splitlines()]


def test_others_refer_to_what_a_robot_brings(folder: Path) -> None:
    """The machine of the file is that of the constructor, step by step."""
    read = jo.schema.read.parse_model(MODEL, folder=folder).mechanism
    cart = next(body for body in read.bodies if body.name == "cart")
    one = jo.robots.RobotInMechanism(
        *("arm", folder / "arm.urdf", cart["top"]),
        at={"j2": np.radians(-30), "j3": 0.5},
        stops=False,
    )
    two = jo.robots.RobotInMechanism(
        *("other", folder / "arm.urdf", one["tcp"]),
        prefix="o ",
        losses=False,
        at={"j2": np.radians(10)},
        position=(0, 0, 0.01),
        orientation=jo.Rotate((1, 0, 0), degrees=90),
    )
    slide = jo.Prismatic("slide", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    joints = one.joints["j2"].angle, one.joints["j4"].angle, two.joints["j4"].angle
    motor = jo.Servo("motor", joints[0], np.radians(20), 4e3, 400)
    pull = jo.Force("pull", two["tcp"], (0, 0, 10))
    tool = one["tool"]
    at = tool.position_local + tool.axes @ (0, 0, 0.01)
    push = jo.Force("push", tool.body.at(at), (0, 0, 10))
    both = jo.Coupling("both", joints[1:], (1, 1))
    tip = jo.PositionSensor("tip", one.bodies["l6"]["tcp"])
    axes = jo.OrientationSensor("axes", one["tcp"])
    foot = jo.ReactionSensor("foot", one.joints["base"])
    watched = next(x for x in two.items if x.name == "o j2" and isinstance(x, jo.CoordinateSensor))
    far = jo.mechanism.Event("far", watched, 1.0)
    high = jo.mechanism.Event("high", joints[0], np.radians(30))
    items = (motor, pull, push, both, tip, axes, foot, far, high, jo.Gravity((0, 0, -9.81)))
    made = jo.Mechanism(cart, one, two, slide, *items)
    runs = [jo.simulate(jo.compile(x), 0.05, solver=jo.RK4(1e-3)) for x in (read, made)]
    for name in (sensor.name for sensor in made.sensors):
        scale = np.abs(runs[1][name]).max()
        # the same numbers in another order of the bodies: round-off over 50 steps
        assert runs[0][name] == pytest.approx(runs[1][name], abs=1e-9 * max(scale, 1.0)), name
    assert np.ptp(runs[0]["arm_j2"]) > 1e-3


def test_robots_alone_are_a_machine(folder: Path) -> None:
    text = 'robots: [{name: arm, file: arm.urdf, prefix: ""}]\nsensors: [{type: position, name: x, '
    made = jo.schema.read.parse_model(f"{text}marker: tcp.origin}}]", folder=folder).mechanism
    names = {"base", "l1", "l2", "l3", "l4", "l5", "l6"}
    assert {body.name for body in made.bodies} == names
    path = folder / "arm.urdf"
    alone = jo.robots.mechanism(jo.robots.read_urdf(path))
    assert {x.name for x in made.joints} == {x.name for x in alone.joints}


def test_everything_wrong_is_told_at_once(folder: Path) -> None:
    text = """bodies:
  - {name: cart, mass: 9, inertia: [1, 1, 1], markers: {top: [0, 0, 100 mm]}}
robots:
  - {name: arm, file: arm.urdf, base: cart.topp, at: {j2: -30 m, jj: 1}}
  - {name: hand, file: arm2.urdf, base: arm_tool}
  - {name: h2, file: arm.urdf, base: carte}
  - {name: h3, file: arm.urdf, base: cart, at: {j1: 3 rad, j4: 4}}
  - {name: h4, file: arm.urdf, base: cart, prefix: x}
  - {name: h5, file: arm.urdf, base: cart, prefix: x}
  - {name: h6, file: arm.urdf, prefx: x}
  - {name: h7, file: arm.urdf, base: h7_tool}
  - {name: h8, file: arm.urdf, base: h9_tool}
  - {name: h9, file: arm.urdf, base: h8_tool}
forces:
  - {type: servo, name: motor, coordinate: arm_j2.angle, reference: 1 rad, kp: 400}
sensors:
  - {type: position, name: t1, marker: xtool.orgin}
  - {type: position, name: t2, marker: xtol.origin}
  - {type: position, name: t3, marker: xl6.tcpp}
"""
    assert told(text, folder) == [
        "4: robots.0.base: body 'cart': no marker 'topp'; did you mean 'top'?",
        "4: robots.0.at.j2: expects an angle (rad), got -30 m (a length)",
        "4: robots.0.at.jj: no such joint; known: j1, j2, j3, j4, j5, j6",
        "5: robots.1.file: arm2.urdf: no such file 'arm2.urdf'",
        "6: robots.2.base: no body 'carte'; did you mean 'cart'?",
        "7: robots.3.at.j1: 3 rad is outside the limits -2.9 and 2.9; start between them, or "
        "give stops=False",
        "7: robots.3.at.j4: is 4 rad, must be within half a turn",
        "9: robots.5: the names of its bodies and joints begin with 'x', as those of robot 'h4'; "
        "give it another prefix",
        "10: robots.6.prefx: unknown key 'prefx'; did you mean 'prefix'?",
        "11: robots.7.base: 'h7_tool' depends on this robot itself",
        "13: robots.9.base: 'h8_tool' depends on this robot itself",
        "17: sensors.0.marker: frame 'xtool': no point 'orgin'; a frame has its origin alone",
        "18: sensors.1.marker: no body 'xtol'; did you mean 'xtool'?",
        "19: sensors.2.marker: body 'xl6': no marker 'tcpp'; did you mean 'tcp'?",
    ]


def test_what_is_wrong_in_the_file_of_the_robot_is_told_with_its_lines(folder: Path) -> None:
    (folder / "bad.urdf").write_text(ARM.replace('child link="l4"', 'child link="l9"'))
    said = told("robots: [{name: arm, file: bad.urdf}]", folder)
    assert said[0].startswith("1: robots.0.file: bad.urdf:") and "no link 'l9'" in said[0]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.filterwarnings("ignore")
def test_spoilt_models_with_robots(seed: int, folder: Path) -> None:
    data = jo.schema.file.document.parse_document(MODEL).data
    rng = random.Random(seed)
    accepted = sum(only_ours(json.dumps(spoilt(data, rng)), folder) for _ in range(15))
    assert accepted < 15


@pytest.mark.filterwarnings("ignore")
def test_models_with_spoilt_robots(folder: Path) -> None:
    rng = np.random.default_rng(3)
    accepted = 0
    for _ in range(25):
        (folder / "arm.urdf").write_bytes(damaged(ARM, rng))
        accepted += only_ours(MODEL, folder)
    assert accepted < 25
