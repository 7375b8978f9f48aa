"""Contact by the words of robot files: at rest where MuJoCo has it, springs and rebound of SDF."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from tests.robots.peers import write

import jousto as jo
from jousto.mechanism import Contact, Contacts, Impedance, PowerLaw, SpringDamper
from jousto.robots import mechanism, read_mjcf, read_sdf, read_urdf

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*contact is off", "ignore:.*moves freely", "ignore:.*pass through each other"
)

GROUND = '<geom name="floor" type="plane" size="1 1 1" {floor}/>'
RESTING = [
    ("", "", '<geom size=".1"/>'),
    ("", "", '<geom size=".1" friction=".4" priority="1"/>'),
    ('cone="elliptic"', "", '<geom size=".1" friction=".4"/>'),
    ('impratio="3"', 'condim="6" friction=".5"', '<geom size=".1" friction=".5"/>'),
    ("", "", '<geom type="box" size=".1 .08 .05"/>'),
    ("", "", '<geom type="box" size=".1 .08 .05" solref=".05 .5" solimp=".3 .9 .01 .3 3"/>'),
    ("", 'margin=".002"', '<geom type="capsule" size=".1 .2" margin=".004" euler="0 90 0"/>'),
    ("", "", '<geom size=".1" margin=".003" gap=".001" solref=".01 1" solmix="3"/>'),
    ("", 'solref="-5000 -40"', '<geom size=".1" solref="-8000 -20"/>'),
    ("", 'solref="-5000 -40"', '<geom size=".1"/>'),
    ("", 'solimp=".7 .7 0"', '<geom size=".1" solimp=".9 .5 .001"/>'),
]


def contacts_in(machine: jo.Mechanism) -> Contacts:
    return next(force for force in machine.forces if isinstance(force, Contacts))


def laws(machine: jo.Mechanism) -> Any:
    """Law between the shapes on the two links of a robot."""
    (law,) = [x for (a, b), x in contacts_in(machine).laws.items() if a != b]
    return law


@pytest.mark.parametrize(("option", "floor", "geom"), RESTING)
def test_bodies_rest_at_the_height_of_mujoco(tmp_path, option, floor, geom):
    """Mixing, priority, cones, margins, both forms of solref, and all of solimp."""
    mujoco = pytest.importorskip("mujoco")
    path = write(
        tmp_path,
        f'<mujoco><option timestep="0.002" {option}/><worldbody>{GROUND.format(floor=floor)}'
        f'<body name="b" pos="0 0 .11"><freejoint/>{geom}</body></worldbody></mujoco>',
    )
    m = mujoco.MjModel.from_xml_path(str(path))
    d = mujoco.MjData(m)
    mujoco.mj_step(m, d, 1500)
    m.opt.timestep = 5e-4
    mujoco.mj_step(m, d, 500)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        machine = mechanism(read_mjcf(path), contact="file")
    z = jo.PositionSensor("z", machine.bodies[0]["origin"])
    model = jo.compile(jo.Mechanism(*machine.items, z))
    run = jo.simulate(model, 1e-3, state=jo.equilibrium(model))
    assert run["z"][-1, 2] == pytest.approx(float(d.qpos[2]), abs=1e-9)


@pytest.mark.parametrize("ratio", [0.0, 0.1, 0.6, 1.0, 1.5])
def test_bodies_rebound_as_in_mujoco(tmp_path, ratio):
    """Without gravity, by the damping ratio of solref."""
    mujoco = pytest.importorskip("mujoco")
    words = f'solref="-10000 {-200 * ratio}"'
    path = write(
        tmp_path,
        f'<mujoco><option timestep="0.0001" gravity="0 0 0"/><worldbody>'
        f'{GROUND.format(floor=words)}<body name="b" pos="0 0 .12"><freejoint/>'
        f'<geom size=".1" {words}/></body></worldbody></mujoco>',
    )
    m = mujoco.MjModel.from_xml_path(str(path))
    d = mujoco.MjData(m)
    d.qvel[2] = -2.0
    mujoco.mj_step(m, d, 1500)
    law = laws(mechanism(read_mjcf(path), contact="file")).law
    assert isinstance(law, Impedance)
    assert law.restitution == pytest.approx(float(d.qvel[2]) / 2.0, abs=2e-3)


def test_mass_in_play_is_that_of_mujoco(tmp_path):
    """Of links on joints, with rotors; a pair of the file has its own softness."""
    mujoco = pytest.importorskip("mujoco")
    path = write(
        tmp_path,
        """<mujoco><default><geom friction="1"/></default><worldbody>
        <geom name="floor" type="plane" size="1 1 1" pos="0 0 -1"/>
        <body name="a" pos="0 0 1"><joint axis="0 1 0" armature="0.02"/><geom size=".05" mass="2"
        pos=".1 0 0"/><body name="b" pos=".4 0 0"><joint axis="0 0 1"/><geom name="tip"
        size=".05" pos=".2 .1 0" mass="1"/></body></body></worldbody>
        <contact><pair geom1="floor" geom2="tip" solref=".04 .5" friction="1"/></contact>
        </mujoco>""",
    )
    m = mujoco.MjModel.from_xml_path(str(path))
    machine = mechanism(read_mjcf(path), contact="file")
    k = (0.95 * 0.02) ** -2  # of the defaults; pyramids of friction 1 change nothing
    for name in "ab":
        law = contacts_in(machine).laws["world", name].law
        w = float(m.body_invweight0[m.body(name).id, 0])
        assert law.stiffness == pytest.approx(k / w, rel=1e-9)
    (pair,) = [force for force in machine.forces if isinstance(force, Contact)]
    assert pair.law.stiffness == pytest.approx(k / w, rel=1e-9)  # 0.04 times 0.5 is 0.02


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ('solref="a b"', "solref is 'a b', must be numbers"),
        ('solref=".1 1 2"', "solref has 3 numbers, at most 2"),
        ('solimp="1 2 3 4 5 6"', "solimp has 6 numbers, at most 5"),
        ('margin="-1"', "margin is -1, must not be negative"),
        ('solmix="-1"', "solmix is -1, must not be negative"),
    ],
)
def test_wrong_words_are_reported(tmp_path, words, said):
    text = (
        f'<mujoco><worldbody><body><freejoint/><geom size="1" {words}/></body></worldbody></mujoco>'
    )
    with pytest.raises(jo.InputError, match=said):
        read_mjcf(write(tmp_path, text))


def test_doubtful_words_are_said(tmp_path):
    for words, said in (
        ('solref="-1 1"', "mixes a positive and a negative number"),
        ('solref="0 0"', "has no stiffness"),
        ('solimp=".9 .5"', "falls with the depth"),
    ):
        geom = f'<geom size="1" {words}/>'
        text = f"<mujoco><worldbody><body><freejoint/>{geom}</body></worldbody></mujoco>"
        with pytest.warns(jo.JoustoWarning, match=said):
            read_mjcf(write(tmp_path, text))


SDF = """<sdf version="1.9"><model name="m"><link name="floor"><inertial><mass>1</mass>
</inertial><collision name="c"><geometry><plane/>
</geometry>{floor}</collision></link><joint name="j" type="fixed"><parent>world</parent><child>floor
</child></joint><link name="ball"><self_collide>true</self_collide><pose>0 0 0.1 0 0 0</pose>
<inertial><mass>2</mass></inertial><collision name="c"><geometry><sphere><radius>0.1</radius>
</sphere></geometry><surface>{ball}</surface></collision></link></model></sdf>"""
SPRING = "<contact><ode><kp>{0}</kp>{1}</ode></contact>"
BOUNCE = "<bounce><restitution_coefficient>{0}</restitution_coefficient>{1}</bounce>"
ZERO = "<threshold>0</threshold>"


@pytest.mark.parametrize(
    ("floor", "ball", "expected"),
    [
        ("", SPRING.format(3e4, "<kd>50</kd>"), SpringDamper(3e4, 50.0)),
        (
            SPRING.format(2e4, "<kd>5</kd>"),
            SPRING.format(3e4, "<kd>4</kd>"),
            SpringDamper(1.2e4, 9),
        ),
        (BOUNCE.format(0.5, ZERO), BOUNCE.format(0.8, ZERO) + SPRING.format(4e4, ""), (4e4, 0.5)),
        ("", BOUNCE.format(0.8, ZERO) + SPRING.format(4e4, ""), (4e4, 0.2)),
    ],
)
def test_springs_and_rebound_of_sdf(tmp_path, floor, ball, expected):
    """In series, dampers in parallel, the smaller restitution; 0.2 where there is none."""
    surface = floor and f"<surface>{floor}</surface>"
    text = SDF.format(floor=surface, ball=ball)
    machine = mechanism(read_sdf(write(tmp_path, text, "m.sdf")), contact="file")
    law = laws(machine).law
    if isinstance(expected, tuple):
        assert isinstance(law, PowerLaw)
        assert (law.stiffness, law.restitution) == pytest.approx(expected)
        return
    assert (law.stiffness, law.damping) == pytest.approx((expected.stiffness, expected.damping))


def test_words_of_sdf_that_have_no_effect_are_said(tmp_path):
    text = SDF.format(floor="", ball=BOUNCE.format(0.5, ""))
    with pytest.warns(jo.JoustoWarning, match="has no effect without a threshold"):
        robot = read_sdf(write(tmp_path, text, "m.sdf"))
    with pytest.warns(jo.JoustoWarning, match="bounce of the file are not read.*contact='file'"):
        mechanism(robot, contact=True)


def test_friction_of_sdf_and_urdf_is_the_smaller_one(tmp_path):
    """And a round patch of radius a with Hertz's pressure resists drilling by 3 pi/16 mu N a."""
    mu = "<friction><ode><mu>{0}</mu></ode>{1}</friction>"
    torsion = (
        "<torsional><coefficient>0.5</coefficient><patch_radius>0.02</patch_radius></torsional>"
    )
    text = SDF.format(
        floor=f"<surface>{mu.format(0.7, '')}</surface>", ball=mu.format(0.3, torsion)
    )
    machine = mechanism(read_sdf(write(tmp_path, text, "m.sdf")), contact=True)
    found = laws(machine)
    assert found.friction == (0.3, 0.3)
    assert found.lengths == pytest.approx((0.0, 3 * np.pi / 16 * 0.01))


def test_gazebo_words_of_urdf(tmp_path):
    ball = """<link name="{0}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0"
    ixz="0" iyz="0"/></inertial><collision><geometry><sphere radius="0.1"/></geometry></collision>
    </link><joint name="j{0}" type="prismatic"><parent link="base"/><child link="{0}"/><axis
    xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>"""
    words = """<gazebo reference="a"><mu1>0.4</mu1><mu2>0.4</mu2><kp>1e5</kp><kd>10</kd></gazebo>
    <gazebo reference="b"><mu1>0.6</mu1></gazebo>"""
    text = f'<robot name="r"><link name="base"/>{ball.format("a")}{ball.format("b")}{words}</robot>'
    robot = read_urdf(write(tmp_path, text, "r.urdf"))
    found = laws(mechanism(robot, contact="file"))
    assert found.friction == (0.4, 0.4)
    assert (found.law.stiffness, found.law.damping) == pytest.approx((1e5, 10.0))
    wrong = text.replace("<kp>1e5", "<kp>-1")
    with pytest.raises(jo.InputError, match="kp is -1, must not be negative"):
        read_urdf(write(tmp_path, wrong, "r.urdf"))


def test_pictures_are_height_fields(tmp_path):
    """The first row is that of the largest y, as MuJoCo has it; 16 bits keep their steps."""
    mujoco = pytest.importorskip("mujoco")
    image = pytest.importorskip("PIL.Image")
    rng = np.random.default_rng(3)
    grey = rng.integers(10, 240, (4, 5)).astype(np.uint8)
    colours = np.stack([grey, grey // 2, 255 - grey], axis=2)
    pictures = {"grey": grey, "colours": colours, "fine": grey.astype(np.uint16) * 256}
    for name, pixels in pictures.items():
        image.fromarray(pixels).save(tmp_path / f"{name}.png")
        text = f"""<mujoco><asset><hfield name="h" file="{name}.png" size="2 1 .5 .1"/></asset>
        <worldbody><geom type="hfield" hfield="h"/><body pos="0 0 2"><freejoint/><geom size=".1"/>
        </body></worldbody></mujoco>"""
        path = write(tmp_path, text)
        machine = mechanism(read_mjcf(path), contact=True)
        field: Any = contacts_in(machine).shapes[0].shape
        heights = mujoco.MjModel.from_xml_path(str(path)).hfield_data.reshape(4, 5)
        assert field.heights.T == pytest.approx(0.5 * heights, abs=1e-7)
        assert (field.length, field.width) == (4.0, 2.0)


def test_the_law_is_asked_for_by_its_name(tmp_path):
    path = write(tmp_path, SDF.format(floor="", ball=SPRING.format(3e4, "<kd>5</kd>")), "m.sdf")
    text = "robots: [{name: r, file: m.sdf, contact: FILE}]"
    model = write(tmp_path, text.replace("FILE", "file"), "m.yaml")
    (contacts,) = [x for x in jo.read_model(model).mechanism.forces if isinstance(x, Contacts)]
    assert any("SpringDamper" in text for _, text in contacts.facts)
    with pytest.raises(jo.InputError, match="no contact 'fiel'; did you mean 'file'"):
        jo.read_model(write(tmp_path, text.replace("FILE", "fiel"), "m.yaml"))
    with pytest.raises(jo.InputError, match="contact is 'fiel', must be .*did you mean 'file'"):
        mechanism(read_sdf(path), contact="fiel")
