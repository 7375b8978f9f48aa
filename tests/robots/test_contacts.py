"""Contacts of robots from their files: shapes, masks, excluded pairs, what is not read."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import Contact, Contacts
from jousto.model.native.header import named
from jousto.robots import mechanism, read_mjcf, read_urdf

DATA = Path(__file__).parents[2] / "examples" / "data"

pytestmark = pytest.mark.filterwarnings("ignore:.*contact is off", "ignore:.*moves freely")


def contacts_in(machine: jo.Mechanism) -> Contacts:
    found = [force for force in machine.forces if isinstance(force, Contacts)]
    assert len(found) == 1
    return found[0]


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def pairs_of(machine: jo.Mechanism) -> set[frozenset[str]]:
    """Pairs of shapes that may touch, from the tables of the engine for bodies close together."""
    contacts = contacts_in(machine)
    model = jo.compile(machine)
    found = named("jo_touch", jo.model.Engine(model).contacts()).shapes.astype(int)
    names = [one.name for one in contacts.shapes]
    return {frozenset((names[a], names[b])) for a, b in found}


@pytest.mark.filterwarnings("ignore:.*pass through each other")
def test_quadruped_has_its_floor_feet_and_filters():
    robot = read_mjcf(DATA / "quadruped.xml")
    machine = mechanism(robot, contact=True)
    contacts = contacts_in(machine)
    by_kind: dict[str, list[Any]] = {}
    for one in contacts.shapes:
        by_kind.setdefault(one.shape.tag, []).append(one)
    assert {kind: len(some) for kind, some in by_kind.items()} == {
        "half-space": 1,
        "cuboid": 1,
        "capsule": 8,
        "sphere": 4,
    }
    assert {one.name for one in by_kind["sphere"]} == {"fl_foot", "fr_foot", "hl_foot", "hr_foot"}
    assert {one.shape.radius for one in by_kind["sphere"]} == {0.025}
    assert by_kind["half-space"][0].marker.body.name == "ground"
    assert {one.surface.mu_kinetic for one in contacts.shapes} == {0.8}
    # legs hang down: each foot and the lower end of each shank is near the floor, a foot on its
    # shank is on one body, and a thigh and its shank have a joint
    assert pairs_of(machine) == {
        frozenset(("floor", f"{leg}_foot")) for leg in ("fl", "fr", "hl", "hr")
    }


@pytest.mark.filterwarnings("ignore:.*pass through each other")
def test_quadruped_falls_on_its_feet():
    """The feet carry the weight: the ground force averages it while the trunk comes to rest."""
    robot = read_mjcf(DATA / "quadruped.xml")
    bent = {f"{x}{y}_{z}": np.radians(a) for x in "fh" for y in "lr" for z, a in
            (("hip", 25), ("knee", -50))}  # fmt: skip
    machine = mechanism(robot, at=bent, contact=True)
    run = jo.simulate(jo.compile(machine), 0.15, solver=jo.RK4(2e-4))
    assert run.attributes["contacts"] == "missed: 0 (proven)"
    free = mechanism(robot, at=bent)
    fall = jo.simulate(jo.compile(free), 0.15, solver=jo.RK4(2e-4))
    assert run.q[-1, 2] > fall.q[-1, 2] + 0.02


MASKS = """<mujoco><worldbody>
<geom name="floor" type="plane" size="1 1 1" contype="2" conaffinity="0"/>
<body name="a" pos="0 0 .1"><freejoint/>
<geom name="a" size=".1" contype="1" conaffinity="{a}"/></body>
<body name="b" pos=".2 0 .1"><freejoint/>
<geom name="b" size=".1" contype="{b}" conaffinity="0"/></body>
</worldbody>{more}</mujoco>"""


@pytest.mark.parametrize(
    ("a", "b", "more", "pairs"),
    [
        (3, 1, "", {"a floor", "a b"}),
        (2, 1, "", {"a floor"}),
        (1, 1, "", {"a b"}),
        (3, 1, '<contact><exclude body1="a" body2="b"/></contact>', {"a floor"}),
    ],
)
def test_masks_and_excluded_bodies(tmp_path, a, b, more, pairs):
    path = write(tmp_path / "model.xml", MASKS.format(a=a, b=b, more=more))
    found = pairs_of(mechanism(read_mjcf(path), contact=True))
    assert {" ".join(sorted(pair)) for pair in found} == pairs


def test_bodies_without_a_joint_to_their_parent_are_one_body(tmp_path):
    text = """<mujoco><worldbody><body name="a" pos="0 0 1"><freejoint/><geom name="a" size=".1"/>
    <body name="b" pos="0 0 .2"><geom name="b" size=".1"/><body name="c" pos="0 0 .2"><joint/>
    <geom name="c" size=".1"/><body name="d" pos="0 0 .2"><joint/><geom name="d" size=".1"/></body>
    </body></body></body></worldbody></mujoco>"""
    machine = mechanism(read_mjcf(write(tmp_path / "model.xml", text)), contact=True)
    assert pairs_of(machine) == set()  # only neighbours are near


PAIRED = """<mujoco><worldbody>
<geom name="floor" type="plane" size="1 1 1" contype="0" conaffinity="0" friction=".5"/>
<body name="a" pos="0 0 .1"><freejoint/>
<geom name="a" size=".1" contype="0" conaffinity="0" friction=".7"/></body>
<body name="b" pos="1 0 .1"><freejoint/><geom name="b" size=".1" contype="0"/></body>
</worldbody><contact><pair geom1="a" geom2="floor"{words}/>{more}</contact></mujoco>"""


def test_a_pair_of_the_file_touches_whatever_its_masks(tmp_path):
    """a rests on the floor, b falls through it."""
    path = write(tmp_path / "model.xml", PAIRED.format(words="", more=""))
    machine = mechanism(read_mjcf(path), contact=True)
    (pair,) = [one for one in machine.forces if isinstance(one, Contact)]
    assert (pair.name, pair.mu_kinetic) == ("a floor", 0.7)
    run = jo.simulate(jo.compile(machine), 0.3, solver=jo.ROS2(2e-3))
    a, b = run.q[-1, 2], run.q[-1, 9]
    assert abs(a - 0.1) < 1e-4
    assert b == pytest.approx(0.1 - 9.81 * 0.3**2 / 2, abs=1e-9)


def test_friction_and_words_of_a_pair(tmp_path):
    text = PAIRED.format(words=' friction=".3 .3 .02" condim="4" solref="0.1"', more="")
    robot = read_mjcf(write(tmp_path / "model.xml", text))
    with pytest.warns(jo.JoustoWarning, match=": solref of the file are not read"):
        machine = mechanism(robot, contact=True)
    (pair,) = [one for one in machine.forces if isinstance(one, Contact)]
    assert (pair.mu_kinetic, pair.drilling, pair.rolling) == (0.3, 0.02, 0.0)
    text = PAIRED.format(words="", more='<pair geom1="a" geom2="c"/>')
    robot = read_mjcf(write(tmp_path / "model.xml", text))
    with pytest.warns(jo.JoustoWarning, match="pass through each other: a - c"):
        mechanism(robot, contact=True)


def test_a_body_with_several_joints_does_not_touch_its_parent(tmp_path):
    """Between them is a link without mass; the shapes overlap."""
    text = """<mujoco><worldbody><body name="a" pos="0 0 1"><freejoint/><geom name="a" size=".1"/>
    <body name="b" pos="0 0 .1"><joint axis="1 0 0"/><joint axis="0 1 0"/>
    <geom name="b" size=".1"/></body></body></worldbody></mujoco>"""
    robot = read_mjcf(write(tmp_path / "model.xml", text))
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*has no mass")
        machine = mechanism(robot, contact=True)
    assert pairs_of(machine) == set()


HUMANOID = DATA / "humanoid.xml"


@pytest.mark.filterwarnings("ignore:.*has no mass", "ignore:.*energy balance")
@pytest.mark.parametrize("share", [0.0, 0.97, 1.03])
def test_humanoid_stands_or_falls_by_its_zero_moment_point(share):
    """With given angles, on a slope that moves the zero-moment point from the ankle to the toes.

    It stands in steps of 2 ms without creep while the point is within the feet, else it falls.
    """
    robot = read_mjcf(HUMANOID)
    angles = {joint.name: 0.0 for joint in robot.joints if joint.kind == "revolute"}
    whole = mechanism(robot)
    mass = sum(one.mass for one in whole.bodies)
    centre = sum(one.mass * (one.position + one.center) for one in whole.bodies) / mass
    toes = 0.17  # m
    turn = share * np.arctan2(toes - centre[0], centre[2])
    gravity = 9.81 * np.array([np.sin(turn), 0.0, -np.cos(turn)])
    machine = mechanism(robot, gravity=gravity, drives=angles, contact=True)
    t = 5.0 if share > 1 else 10.0
    run = jo.simulate(jo.compile(machine), t, solver=jo.ROS2(2e-3), output_step=1e-2)
    assert run.attributes["contacts"] == "missed: 0 (proven)"
    late = run.time > t - 1.0
    assert (run.q[-1, 2] < 0.5) == (share > 1)
    if share < 1:
        assert np.ptp(run.q[late][:, :3], axis=0).max() < 1e-9
    if not share:
        assert run.work.steps[-1] < 1.2 * t / 2e-3


def test_larger_friction_of_both(tmp_path):
    text = MASKS.replace('size=".1" contype="1"', 'size=".1" friction=".3" contype="1"')
    path = write(tmp_path / "model.xml", text.format(a=3, b=1, more=""))
    laws = contacts_in(mechanism(read_mjcf(path), contact=True)).laws
    assert laws["friction 1", "friction 0.3"].friction == (1.0, 1.0)


@pytest.mark.parametrize(
    ("condim", "mu", "lengths"),
    [(1, 1.0, (0.0, 0.0)), (3, 1.0, (0.0, 0.0)), (4, 1.0, (0.0, 0.02)), (6, 1.0, (0.003, 0.02))],
)
def test_condim_and_all_numbers_of_friction(tmp_path, condim, mu, lengths):
    """The larger one of each number of both counts; the floor has condim 3."""
    words = f'size=".1" friction=".3 .02 .003" condim="{condim}" contype="1"'
    text = MASKS.replace('size=".1" contype="1"', words)
    path = write(tmp_path / "model.xml", text.format(a=3, b=1, more=""))
    laws = contacts_in(mechanism(read_mjcf(path), contact=True)).laws
    name = f"friction 0.3 0.02 0.003, condim {condim}"
    (pair,) = [x for key, x in laws.items() if set(key) == {"friction 1", name}]
    assert (pair.friction, pair.lengths) == ((mu, mu), lengths)
    own = laws[name, name]
    assert (own.friction[0], own.lengths) == (0.3 if condim > 1 else 0.0, lengths)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ('margin="0.01" solref="0.02 1"', "margin, solref of the file are not read"),
    ],
)
def test_what_is_not_read_is_said(tmp_path, words, said):
    body = f'<body pos="3 0 1"><freejoint/><geom size=".1 .1 .1" {words}/></body></worldbody>'
    text = MASKS.format(a=3, b=1, more="").replace("</worldbody>", body)
    robot = read_mjcf(write(tmp_path / "model.xml", text))
    with pytest.warns(jo.JoustoWarning, match=said):
        mechanism(robot, contact=True)


def test_kinds_that_do_not_touch_are_named(tmp_path):
    """Ellipsoids and cylinders touch each other and boxes, not a height field."""
    geoms = "".join(
        f'<body pos="0 0 {i + 2}"><freejoint/><geom type="{kind}" size=".1 .1 .1"/></body>'
        for i, kind in enumerate(("ellipsoid", "cylinder", "box"))
    )
    text = f"""<mujoco><asset><hfield name="h" nrow="2" ncol="2" size="2 1 .3 .1"
    elevation="0 0 0 1"/></asset><worldbody><geom type="hfield" hfield="h"/>
    {geoms}</worldbody></mujoco>"""
    robot = read_mjcf(write(tmp_path / "model.xml", text))
    with pytest.warns(jo.JoustoWarning, match="pass through each other") as said:
        mechanism(robot, contact=True)
    (message,) = (str(one.message) for one in said if "pass through" in str(one.message))
    assert "height-field - ellipsoid" in message or "ellipsoid - height-field" in message
    assert "box" not in message and "cuboid" not in message and "ellipsoid - cyl" not in message


URDF = """<robot name="r"><link name="base"/><joint name="j" type="revolute"><parent link="base"/>
<child link="arm"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<link name="arm"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><origin xyz="0.5 0 0"/><geometry><sphere radius="0.1"/></geometry></collision>
<collision><geometry><cylinder radius="0.1" length="0.3"/></geometry></collision>
{more}</link></robot>"""


def test_collisions_of_urdf(tmp_path):
    robot = read_urdf(write(tmp_path / "r.urdf", URDF.format(more="")))
    arm = next(link for link in robot.links if link.name == "arm")
    assert [(one.name, one.shape.tag) for one in arm.collisions] == [
        ("arm 1", "sphere"),
        ("arm 2", "cylinder"),
    ]
    assert arm.collisions[0].frame.r == pytest.approx([0.5, 0, 0])
    assert robot.untouching == ()
    mesh = "<collision><geometry><mesh filename='a.stl'/></geometry></collision>"
    assert read_urdf(write(tmp_path / "r.urdf", URDF.format(more=mesh))).untouching == (
        "mesh 'a.stl' is not there",
    )


def test_a_robot_without_shapes_says_that_contact_has_no_effect(tmp_path):
    inertial = "<inertial mass='1' pos='0 0 0' diaginertia='1 1 1'/>"
    text = f"<mujoco><worldbody><body><joint/>{inertial}</body></worldbody></mujoco>"
    robot = read_mjcf(write(tmp_path / "model.xml", text))
    with pytest.warns(jo.JoustoWarning, match="contact has no effect"):
        mechanism(robot, contact=True)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mechanism(robot)
