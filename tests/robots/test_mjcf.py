"""MJCF files: against MuJoCo, against closed forms, and what is refused."""

# ruff: noqa: E501

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.robots import Tree, mechanism, read_mjcf
from robots import peers
from robots.machines import CREATURE

NO_CONTACT = '<option><flag contact="disable"/></option>'


def write(folder: Path, text: str) -> Path:
    path = folder / "model.xml"
    path.write_text(text, encoding="utf-8")
    return path


def near(found: np.ndarray, wanted: np.ndarray) -> None:
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())


def test_against_mujoco(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    tree = Tree(read_mjcf(write(tmp_path, CREATURE)))
    model = mujoco.MjModel.from_xml_string(CREATURE)
    data = mujoco.MjData(model)
    assert (tree.nq, tree.nv) == (model.nq, model.nv)
    np.testing.assert_allclose(tree.initial, model.qpos0, atol=1e-15)
    rng = np.random.default_rng(2)
    for _ in range(4):
        q = tree.moved(tree.initial, rng.normal(size=tree.nv))
        v, a = rng.normal(size=(2, tree.nv))
        data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
        mujoco.mj_forward(model, data)
        M = np.zeros((model.nv, model.nv))
        for row, unit in zip(M, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, data, row, unit)
        near(tree.mass_matrix(q), M)
        near(tree.bias_forces(q, v), np.array(data.qfrc_bias))
        for name in ("trunk", "foot", "left"):
            near(tree.pose(name, q).r, np.array(data.body(name).xpos))
            near(tree.pose(name, q).A, np.array(data.body(name).xmat).reshape(3, 3))
        near(tree.pose("trunk.eye", q).A, np.array(data.site("eye").xmat).reshape(3, 3))
        J, W = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        mujoco.mj_jacBody(model, data, J, W, model.body("foot").id)
        near(tree.jacobian("foot", q), np.concatenate([J, W]))


def test_a_pendulum_of_a_capsule(tmp_path: Path) -> None:
    # a capsule r = 0.1, length 1 m between the centres of its ends, hung at one of these
    text = """<mujoco><worldbody><body><joint axis="0 1 0" range="-90 90"/>
    <geom type="capsule" fromto="0 0 0 0 0 -1" size="0.1"/></body></worldbody></mujoco>"""
    tree = Tree(read_mjcf(write(tmp_path, text)))
    r, long = 0.1, 1.0
    rod, ball = np.pi * r**2 * long * 1000, 4 / 3 * np.pi * r**3 * 1000
    # half spheres of the ball: m (2/5 r^2 +- 3/4 r x + x^2) about a point x before the disc's centre
    inertia = (
        rod * (r**2 / 4 + long**2 / 3) + ball * 0.4 * r**2 + ball / 2 * (0.75 * r * long + long**2)
    )
    assert tree.mass_matrix([0.2])[0, 0] == pytest.approx(inertia, rel=1e-12)
    # the angle is in degrees
    assert (tree.lower[0], tree.upper[0]) == pytest.approx((-np.pi / 2, np.pi / 2))
    g = (rod + ball) * 9.81 * 0.5 * np.sin(0.2)
    assert tree.gravity_forces([0.2])[0] == pytest.approx(g, rel=1e-12)


def test_several_joints_on_one_body_become_a_mechanism(tmp_path: Path) -> None:
    text = """<mujoco><worldbody><body name="cart"><joint name="x" type="slide" axis="1 0 0" armature="0.5"/>
    <joint name="turn" axis="0 1 0"/><geom type="sphere" size="0.1" pos="0 0 -1"/></body></worldbody></mujoco>"""
    robot = read_mjcf(write(tmp_path, text))
    with pytest.warns(jo.JoustoWarning, match="link 'cart 1': has no mass; as a body it gets"):
        machine = mechanism(robot)
    one, two = Tree(robot), Tree(machine)
    assert one.velocities == two.velocities[:2] and two.nv == 2  # the rotor follows
    m = 4 / 3 * np.pi * 1e-3 * 1000
    M = np.array([[m + 0.5, -m], [-m, m * (1 + 0.4 * 0.01)]])
    np.testing.assert_allclose(one.mass_matrix([0.3, 0.0]), M, atol=1e-14)
    # a millionth of the mass, and of the inertia, between the joints
    np.testing.assert_allclose(two.mass_matrix([0.3, 0.0]), M, atol=3e-6 * m)
    run = jo.simulate(jo.compile(machine), 0.2)
    # what stands straight down stays there: no force along x
    assert np.abs(run["x"]).max() < 1e-9


def test_what_changes_the_file_is_refused(tmp_path: Path) -> None:
    body = '<body name="b"><joint name="j"/><geom size="0.1"/>{}</body>'
    for inner, said in (
        ("<composite/>", "<composite> is not read; write the model out in full"),
        ('<joint type="slider"/>', "type is 'slider', must be one of hinge, slide, ball, free"),
        ('<geom class="x" size="1"/>', "no class 'x' of defaults"),
        ('<geom type="mesh" mesh="m"/>', "no mesh 'm' among the assets"),
        ('<joint name="k" limited="true"/>', "range is missing"),
        ("<freejoint/>", "has other joints beside its free one"),
        ('<geom size="0.1" quat="0 0 0 0"/>', "quat is zero"),
    ):
        text = f"<mujoco><worldbody>{body.format(inner)}</worldbody></mujoco>"
        with pytest.raises(jo.InputError, match=said.replace("(", r"\(")):
            read_mjcf(write(tmp_path, text))
    text = f"""<mujoco><worldbody>{body.format('<body><joint name="k"/><geom size="0.1"/></body>')}
    </worldbody><actuator/><tendon/><equality><joint joint1="k" joint2="j" polycoef="0.1 -2 0 0 0"/>
    </equality></mujoco>"""
    tree = Tree(read_mjcf(write(tmp_path, text)))
    assert tree.velocities == ("j.angle",)
    # the second turns back twice as far
    angle = 0.3 + 0.1 - 2 * 0.3
    assert tree.pose("body2", [0.3]).A[0, 0] == pytest.approx(np.cos(angle), abs=1e-14)


# -- several files --------------------------------------------------------------------------

LEG = '<body name="leg" pos="0 {y} 0"><joint name="hip" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.4" size=".03"/></body>'


def test_included_files_stand_in_their_place(tmp_path: Path) -> None:
    peers.write(
        tmp_path,
        '<mujocoinclude><default><geom density="500"/></default></mujocoinclude>',
        "parts/defaults.xml",
    )
    peers.write(tmp_path, '<mujoco><include file="inner.xml"/></mujoco>', "parts/legs.xml")
    peers.write(tmp_path, f"<any>{LEG.format(y=0.1)}</any>", "parts/inner.xml")
    text = f"""<mujoco>{NO_CONTACT}<include file="parts/defaults.xml"/><worldbody><body name="trunk" pos="0 0 1"><freejoint/>
    <geom type="box" size=".1 .2 .05"/><include file="parts/legs.xml"/></body></worldbody></mujoco>"""
    robot = peers.same_tree(peers.write(tmp_path, text))
    assert [joint.name for joint in robot.joints] == ["joint1", "hip"]
    # what is wrong is told with the file it stands in
    peers.write(tmp_path, "<any>\n<geom size='x'/></any>", "parts/inner.xml")
    assert "inner.xml:2: geom: size is 'x', must be a number" in peers.refusal(
        tmp_path / "model.xml"
    )


def test_no_file_from_elsewhere_and_no_circle(tmp_path: Path) -> None:
    home = tmp_path / "home"
    peers.write(tmp_path, "<any/>", "secret.xml")
    path = peers.write(
        home, '<mujoco><include file="../secret.xml"/><include file="/etc/passwd"/></mujoco>'
    )
    said = peers.refusal(path)
    assert said.count("lies outside the folder of the robot") == 2
    (home / "link.xml").symlink_to(tmp_path / "secret.xml")
    path = peers.write(home, '<mujoco><include file="link.xml"/></mujoco>')
    assert "lies outside the folder of the robot" in peers.refusal(path)
    peers.write(home, '<any><include file="b.xml"/></any>', "a.xml")
    peers.write(home, '<any><include file="a.xml"/></any>', "b.xml")
    path = peers.write(home, '<mujoco><include file="a.xml"/></mujoco>')
    assert "b.xml:1: include: the file 'a.xml' includes itself in a circle" in peers.refusal(path)
    peers.write(home, "<any/>", "c.xml")
    path = peers.write(home, '<mujoco><include file="c.xml"/><include file="c.xml"/></mujoco>')
    assert "'c.xml' is included already" in peers.refusal(path)
    path = peers.write(home, '<mujoco><include file="none.xml"/></mujoco>')
    assert "the file 'none.xml' is not there" in peers.refusal(path)


def test_replicas(tmp_path: Path) -> None:
    text = f"""<mujoco>{NO_CONTACT}<worldbody><body name="hub" pos="0 0 1"><joint name="spin"/><geom size=".1" pos=".01 0 0"/>
    <replicate count="3" euler="0 0 40" offset="0.01 0 0.02" sep="-"><frame pos=".2 0 0">{LEG.format(y=0.1)}</frame>
    <replicate count="11" offset="0 0 -.1"><geom name="bead" size=".02" pos=".3 0 0"/></replicate></replicate></body></worldbody>
    <actuator><motor name="m" joint="hip" gear="2"/></actuator>
    <equality><joint joint1="hip" polycoef="0.1" active="false"/></equality></mujoco>"""
    path = peers.write(tmp_path, text)
    robot = peers.same_tree(path)
    assert [joint.name for joint in robot.joints] == ["spin", "hip-0", "hip-1", "hip-2"]
    assert [motor.name for motor in robot.actuators] == ["m-0", "m-1", "m-2"]
    peers.same_motion(path, 0.3, joints=("spin", "hip-1"), share=1e-7, controls={"m-1": 0.5})
    assert "count is 1.5, must be a whole number" in peers.refusal(
        peers.write(tmp_path, text.replace('count="3"', 'count="1.5"'))
    )
    assert "makes more than 200000 elements" in peers.refusal(
        peers.write(tmp_path, text.replace('count="3"', 'count="1e9"'))
    )


def test_attached_models_keep_their_own_settings(tmp_path: Path) -> None:
    arm = f"""<mujoco model="arm"><compiler angle="radian" meshdir="shapes"/><default><geom density="300"/><joint damping=".2"/></default>
    <worldbody><body name="base" euler="0 0.3 0"><geom size=".1"/>{LEG.format(y=0.1)}</body><body name="other"><geom size="1"/></body></worldbody>
    <actuator><position name="servo" joint="hip" kp="30" kv="1"/></actuator></mujoco>"""
    peers.write(tmp_path, arm, "arms/arm.xml")
    text = f"""<mujoco>{NO_CONTACT}<asset><model file="arms/arm.xml" name="one"/></asset><worldbody><body name="cart" pos="0 0 1">
    <joint name="x" type="slide" axis="1 0 0"/><geom type="box" size=".2 .1 .1"/>
    <frame pos="0 0 .2" euler="0 0 90"><attach model="one" body="base" prefix="left/"/></frame>
    <body name="own" pos=".1 0 0"><joint name="j" axis="1 0 0"/><geom size=".05" pos="0 .1 0"/></body>
    <attach body="own" prefix="copy "/></body></worldbody></mujoco>"""
    path = peers.write(tmp_path, text)
    robot = peers.same_tree(path)
    assert [joint.name for joint in robot.joints] == ["x", "left_hip", "j", "copy j"]
    assert robot.actuators[0].joint == "left_hip"
    wrong = text.replace('name="one"', 'name="two"')
    assert "no model 'one' among the assets" in peers.refusal(peers.write(tmp_path, wrong))
    wrong = text.replace('body="base"', 'body="bse"')
    assert "no body 'bse' in the attached model" in peers.refusal(peers.write(tmp_path, wrong))
    peers.write(tmp_path, text.replace("arms/arm.xml", "model.xml"), "model.xml")
    assert "attaches itself in a circle" in peers.refusal(tmp_path / "model.xml")


# -- loops ----------------------------------------------------------------------------------

FOUR_BAR = """<mujoco><option gravity="3 0 -9.81"><flag contact="disable"/></option><worldbody>
<body name="crank" pos="0 0 0"><joint name="a" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 .2" size=".01"/>
<body name="rod" pos="0 0 .2"><joint name="b" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .5 0 .2" size=".01"/><site name="tip" pos=".5 0 .2"/></body></body>
<body name="rocker" pos=".5 0 0"><joint name="c" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 .4" size=".01"/><site name="top" pos="0 0 .4" {}/></body>
</worldbody><equality>{}</equality></mujoco>"""


@pytest.mark.parametrize(
    "tie",
    [
        '<connect name="pin" body1="rod" body2="rocker" anchor=".5 0 .2" solref="0.0004 1" solimp=".99 .999 1e-5"/>',
        '<connect name="pin" site1="tip" site2="top" solref="0.0004 1" solimp=".99 .999 1e-5"/>',
    ],
)
def test_a_point_that_is_tied_closes_a_loop(tie: str, tmp_path: Path) -> None:
    path = peers.write(tmp_path, FOUR_BAR.format("", tie))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        robot = read_mjcf(path)
        tree = Tree(robot)
        assert tree.cut == ("pin",)
        # MuJoCo ties by a stiff spring and damper: its loop opens by 1e-4 of the size
        peers.same_motion(path, 0.2, joints=("a", "c"), share=3e-3)


def test_a_weld_holds_a_body(tmp_path: Path) -> None:
    text = """<mujoco><worldbody><body name="hook" pos="0 0 2"><joint name="h" axis="1 0 0"/><geom size=".1" pos="0 .2 0"/></body>
    <body name="load" pos="0 .5 1"><freejoint/><geom size=".05"/></body></worldbody>
    <equality><weld name="w" body1="hook" body2="load" relpose="{}"/></equality></mujoco>"""
    path = peers.write(tmp_path, text.format("0 0 0 0 0 0 0"))
    robot = peers.read(path)
    run = jo.simulate(jo.compile(mechanism(robot)), 0.2)
    # one body: a ball of 4.19 kg at 0.2 m and one of 0.524 kg at (0.5, -1) m about the axis
    m, n = (4 / 3 * np.pi * r**3 * 1000 for r in (0.1, 0.05))
    inertia = m * (0.4 * 0.01 + 0.04) + n * (0.4 * 0.0025 + 1.25)
    torque = -9.81 * (m * 0.2 + n * 0.5)
    t = run.time[:20]
    angle = 0.5 * torque / inertia * t**2
    # a short fall: the arm changes with the square of the angle
    np.testing.assert_allclose(run["h"][:20, 0], angle, rtol=0, atol=2e-3 * abs(angle[-1]))


def test_flags_leave_ties_out(tmp_path: Path) -> None:
    tie = '<connect body1="rod" body2="rocker" anchor=".5 0 .2"/>'
    text = FOUR_BAR.format("", tie).replace(
        'contact="disable"', 'contact="disable" equality="disable"'
    )
    assert peers.read(peers.write(tmp_path, text)).loops == ()


LIMITED = """<mujoco><option gravity="0 0 0"/><worldbody><body><joint name="j" type="slide" axis="1 0 0" {}/>
    <geom size=".1" mass="2"/></body></worldbody><actuator><{} name="u" joint="j"/></actuator></mujoco>"""


@pytest.mark.parametrize(
    ("joint", "actuator", "gear"),
    [
        ("", 'position kp="200" forcerange="-10 10"', 2.0),
        ('actuatorfrcrange="-10 10"', 'position kp="200"', 2.0),
        ('actuatorfrcrange="-10 10"', 'position kp="200" forcerange="-7 7"', 1.0),
    ],
)
def test_servos_keep_the_limits_of_forces(
    joint: str, actuator: str, gear: float, tmp_path: Path
) -> None:
    mujoco = pytest.importorskip("mujoco")
    text = LIMITED.format(joint, f'{actuator} gear="{gear}"')
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.ctrl[0] = 100.0
    mujoco.mj_forward(model, data)
    limited = jo.compile(mechanism(peers.read(peers.write(tmp_path, text))))
    run = jo.simulate(limited, 0.01, inputs={"u": 100.0})
    # from rest under a constant force: x = a t^2 / 2
    assert run["j"][-1, 0] == pytest.approx(0.5 * data.qacc[0] * 0.01**2, rel=1e-6)


@pytest.mark.parametrize(
    ("joint", "actuator", "word"),
    [
        ("", 'motor forcerange="-10 10"', "forcerange"),
        ("", 'velocity kv="5" forcerange="-10 10"', "forcerange"),
        ('actuatorfrcrange="-10 10"', "motor", "actuatorfrcrange"),
    ],
)
def test_limits_that_nothing_keeps_are_told(
    joint: str, actuator: str, word: str, tmp_path: Path
) -> None:
    path = peers.write(tmp_path, LIMITED.format(joint, actuator))
    with pytest.warns(jo.JoustoWarning, match=f"'u': {word}: is kept by position servos alone"):
        jo.robots.read_robot(path)


def test_servos_and_motors_are_inputs(tmp_path: Path) -> None:
    text = """<mujoco><worldbody><body><joint name="j" axis="0 1 0"/><geom size=".1" pos=".3 0 0"/></body></worldbody>
    <actuator><position name="servo" joint="j" kp="200" kv="20" forcerange="-40 40"/></actuator></mujoco>"""
    robot = peers.read(peers.write(tmp_path, text))
    model = jo.compile(mechanism(robot))
    assert tuple(model.inputs) == ("servo",)
    run = jo.simulate(model, 3.0, inputs={"servo": 0.5})
    m = 4 / 3 * np.pi * 1e-3 * 1000
    q = run["j"][-1, 0]
    # kp (0.5 - q) carries the weight
    assert 200 * (0.5 - q) == pytest.approx(-m * 9.81 * 0.3 * np.cos(q), rel=1e-3)
    assert tuple(jo.compile(mechanism(robot, actuators=False)).inputs) == ()
    other = jo.compile(mechanism(robot, efforts={"j": jo.Input("mine")}))
    assert tuple(other.inputs) == ("mine",)
    held = jo.robots.RobotInMechanism("arm", robot)
    whole = jo.compile(jo.Mechanism(held, jo.Gravity((0, 0, -9.81))))
    assert tuple(whole.inputs) == ("arm_servo",)
