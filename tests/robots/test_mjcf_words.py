"""Words of MJCF: all are declared, and each does what MuJoCo does or is reported."""

# ruff: noqa: E501

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.robots import Tree, mechanism
from jousto.robots.readers.mjcf_words import MJCF
from jousto.robots.readers.words import TREATMENTS
from robots.peers import peer, read, refusal, same_motion, same_tree, told, write

WORDS = Path(__file__).parent / "words" / "mjcf.txt"
QUIET = '<option><flag contact="disable"/></option>'
ARM = """<body name="arm" pos="0.1 0 1"><joint name="a" axis="0 1 0" {joint}/>
<inertial pos="0.2 0.01 0" mass="2" diaginertia="0.01 0.03 0.04"/>
<body name="fore" pos="0.5 0 0"><joint name="b" axis="0 1 0.3" {joint}/>
<inertial pos="0.1 0 0.02" mass="0.8" diaginertia="0.002 0.004 0.005"/></body></body>"""


def model(body: str, head: str = "", tail: str = "") -> str:
    return f"<mujoco>{head}{QUIET}<worldbody>{body}</worldbody>{tail}</mujoco>"


def arm(joint: str = "", head: str = "", tail: str = "") -> str:
    return model(ARM.format(joint=joint), head, tail)


# -- the list -------------------------------------------------------------------------------


def declared(text: str) -> list[tuple[str, str]]:
    """Return the words of a schema as MuJoCo prints it, each with its path."""
    stack: list[str] = []
    found = []
    for line in text.splitlines():
        begins = re.match(r"^( *)(\S+) \((.)\)\s*(.*)$", line)
        words = line.split()
        if begins:
            name = begins[2].replace("(world)body", "worldbody/body")
            stack = [*stack[: len(begins[1]) // 3], name]
            words = begins[4].split()
        found += [("/".join(stack), word) for word in words]
    return found


def listed() -> list[tuple[str, str]]:
    lines = [line.partition(":") for line in WORDS.read_text(encoding="utf-8").splitlines()]
    return [(path, word) for path, _, words in lines for word in words.split()]


def test_every_word_of_the_format_is_done_or_reported() -> None:
    """1,900 words of MuJoCo 4.0's own schema."""
    words = listed()
    assert len(words) > 1800
    without = [word for word in words if MJCF.treatment(word[0].split("/"), word[1]) is None]
    assert without == []
    used = {MJCF.treatment(path.split("/"), word).treatment for path, word in words}
    assert used == set(TREATMENTS)


def test_the_list_is_that_of_mujoco() -> None:
    mujoco = pytest.importorskip("mujoco")
    assert set(declared(mujoco.mj_printSchema(False, True))) == set(listed())


def test_a_word_that_nobody_knows_is_told(tmp_path: Path) -> None:
    text = arm('dampping="1"').replace("</worldbody>", "<spaceship/></worldbody>")
    said = told(write(tmp_path, text))
    assert "model.xml:1: joint 'a': 'dampping' is not read; did you mean 'damping'?" in said
    assert "<spaceship> is ignored" in said


# -- what is warned of and refused ------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (arm(head='<option density="1.2"/>'), "option: density: drag and lift of the medium"),
        (arm(head='<option viscosity="1" wind="1 0 0"/>'), "viscosity, wind (2 places): drag"),
        (arm('solreflimit="0.1 1"'), "solreflimit (2 places): the softness of constraints"),
        (arm('type="ball" frictionloss="1"'), "frictionloss (2 places): of a ball joint"),
        (
            model('<body><joint type="free" damping="1"/><geom size="1"/></body>'),
            "damping: of a free joint is left out",
        ),
        (
            arm(tail='<actuator><muscle name="m" joint="a"/></actuator>'),
            "muscle 'm': <muscle>: makes no force here",
        ),
        (
            arm(
                tail='<tendon><fixed name="t" stiffness="3"><joint joint="a" coef="1"/></fixed></tendon>'
                '<actuator><motor tendon="t"/></actuator>'
            ),
            "an actuator of a tendon: makes no force here",
        ),
        (
            arm(tail='<tendon><fixed stiffness="3"><joint joint="a" coef="1"/></fixed></tendon>'),
            "stiffness: springs, dampers, friction, limits and rotors of tendons are left out",
        ),
        (
            arm(tail='<equality><joint joint1="a" joint2="b" polycoef="0 1 2"/></equality>'),
            "a polynomial of higher order: is ignored: the bodies that it ties move freely",
        ),
        (
            arm().replace('name="arm"', 'name="arm" mocap="true"'),
            "mocap: it is fixed at its place in the file",
        ),
    ],
)
def test_what_changes_the_motion_is_warned_of(text: str, said: str, tmp_path: Path) -> None:
    found = told(write(tmp_path, text))
    assert said in found and re.search(r"model\.xml:[1-4]: ", found)


def test_what_changes_nothing_is_quiet(tmp_path: Path) -> None:
    head = '<option density="0" wind="0 0 0" timestep="0.01"/><size nstack="9"/><visual/>'
    sensors = '<sensor><jointpos joint="a"/></sensor>'
    assert told(write(tmp_path, arm('user="1" group="2"', head, sensors))) == ""


def test_contact_is_warned_of_once_where_bodies_can_touch(tmp_path: Path) -> None:
    ball = '<body pos="0 0 1"><freejoint/><geom size="0.1"/></body>'
    floor = '<geom type="plane" size="1 1 1"/>'
    text = f"<mujoco><worldbody>{floor}{ball}{ball}</worldbody></mujoco>"
    said = told(write(tmp_path, text))
    assert said.count("contact is off: bodies that touch pass through each other") == 1
    assert told(write(tmp_path, text.replace(floor, "").replace(ball, "", 1))) == ""
    pair = '</worldbody><contact><pair geom1="a" geom2="b"/></contact>'
    masks = text.replace('size="0.1"', 'size="0.1" contype="0" conaffinity="0"')
    said = told(write(tmp_path, masks.replace("</worldbody>", pair)))
    assert said.count("<pair>: contact is off") == 1
    masks = text.replace('size="0.1"', 'size="0.1" contype="0" conaffinity="0"')
    assert told(write(tmp_path, masks)) == ""


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (arm('stiffness="1 2"'), "terms of higher order are not read"),
        (
            arm(head='<compiler coordinate="global"/>'),
            "coordinate is 'global', which MuJoCo no longer reads",
        ),
        (model("<body><flexcomp/></body>"), "<flexcomp> is deformable"),
        (arm(tail='<actuator><motor joint="c"/></actuator>'), "motor: no joint 'c'"),
        (arm(tail='<equality><connect body1="x" anchor="0 0 0"/></equality>'), "no body 'x'"),
        (
            model(
                '<body><joint/><geom type="mesh" mesh="m"/></body>',
                '<asset><mesh name="m" file="no.stl"/></asset>',
            ),
            "the mass is that of the mesh 'm', which is not read: 'no.stl' is not there",
        ),
        (
            model(
                '<body><joint/><geom type="mesh" mesh="m"/></body>',
                '<asset><mesh name="m" builtin="sphere" params="1"/></asset>',
            ),
            "the mass is that of the mesh 'm', which is not read",
        ),
    ],
)
def test_what_cannot_be_is_refused(text: str, said: str, tmp_path: Path) -> None:
    assert said in refusal(write(tmp_path, text))


# -- what is done, beside MuJoCo --------------------------------------------------------------


def test_later_sections_add_to_earlier_ones(tmp_path: Path) -> None:
    text = arm(
        head="""<option gravity="1 2 -3"/><option timestep="0.001"/><compiler angle="radian"/><compiler autolimits="true"/>
    <default><joint damping="0.5"/><default class="x"><joint stiffness="2"/></default></default>
    <default><joint armature="0.1"/></default>"""
    )
    robot = same_tree(write(tmp_path, text))
    np.testing.assert_array_equal(robot.gravity, [1, 2, -3])
    assert (robot.joints[0].damping, robot.joints[0].armature) == (0.5, 0.1)


@pytest.mark.parametrize(
    ("head", "joint", "tail"),
    [
        ('<option><flag gravity="disable"/></option>', 'springref="30" stiffness="2"', ""),
        ('<option><flag spring="disable"/></option>', 'springref="30" stiffness="2"', ""),
        ('<option><flag damper="disable"/></option>', 'damping="0.3"', ""),
        (
            '<option><flag actuation="disable"/></option>',
            "",
            '<actuator><motor joint="a"/></actuator>',
        ),
        ("", 'ref="40" springref="10" stiffness="3" damping="0.1"', ""),
        ("", 'type="slide" ref="0.3" springref="-0.1" stiffness="40"', ""),
        ("", 'springdamper="0.05 0.6"', ""),
        ("", "", '<actuator><motor name="u" joint="a" gear="3"/></actuator>'),
        ("", "", '<actuator><position name="u" joint="a" kp="40" kv="2" gear="1.5"/></actuator>'),
        (
            "",
            "",
            '<actuator><position name="u" joint="b" kp="9" dampratio="0.7" gear="2"/></actuator>',
        ),
        ("", "", '<actuator><velocity name="u" joint="b" kv="4" gear="2"/></actuator>'),
        (
            "",
            "",
            '<actuator><general name="u" joint="a" gainprm="5" biastype="affine" biasprm="1 -20 -2" '
            'armature="0.05" damping="0.4" gear="2"/></actuator>',
        ),
        (
            '<default><position kp="30" ctrlrange="-1 1"/><general gear="2"/></default>',
            "",
            '<actuator><position name="u" joint="a"/></actuator>',
        ),
    ],
)
def test_the_motion_is_that_of_mujoco(head: str, joint: str, tail: str, tmp_path: Path) -> None:
    path = write(tmp_path, arm(joint, head, tail))
    controls = {"u": 0.7} if 'name="u"' in tail else None
    # motions of 10 Hz at 0.5 ms, of order 4: (2 pi 10 Hz 0.5 ms)^4 = 1e-6, a tenth of it each
    same_motion(path, 0.3, joints=("a", "b"), share=1e-7, controls=controls)


def test_weights_are_compensated(tmp_path: Path) -> None:
    text = arm().replace('name="arm"', 'name="arm" gravcomp="0.5"')
    text = text.replace('name="fore"', 'name="fore" gravcomp="1.5"')
    same_motion(write(tmp_path, text), 0.5, joints=("a", "b"), share=1e-7)
    # all of it: what is let go rests
    robot = read(
        write(
            tmp_path,
            arm()
            .replace('pos="0.1 0 1"', 'gravcomp="1"')
            .replace('name="fore"', 'name="fore" gravcomp="1"'),
        )
    )
    run = jo.simulate(jo.compile(mechanism(robot)), 1.0)
    assert np.abs(run["a"]).max() < 1e-10


def test_spring_and_damper_of_a_time_constant(tmp_path: Path) -> None:
    path = write(tmp_path, arm('springdamper="0.05 0.6"'))
    robot, other = read(path), peer(path)
    for i, joint in enumerate(robot.joints):
        assert joint.stiffness == pytest.approx(other.jnt_stiffness[i], rel=1e-9)
        assert joint.damping == pytest.approx(other.dof_damping[i], rel=1e-9)


MASSES = {
    "settotalmass": (
        '<compiler settotalmass="7"/>',
        '<geom size="0.1" pos="0.1 0 0"/><geom type="box" size="1 2 3" mass="2"/>',
    ),
    "inertiagrouprange": (
        '<compiler inertiagrouprange="1 3"/>',
        '<geom size="0.1" group="1"/><geom type="box" size="1 2 3"/>',
    ),
    "boundmass": (
        '<compiler boundmass="500" boundinertia="3"/>',
        '<geom type="box" size="0.1 0.1 0.2"/>',
    ),
    "balanceinertia": (
        '<compiler balanceinertia="true"/>',
        '<inertial pos="0 0 0" mass="1" diaginertia="1 1 3"/>',
    ),
    "inertiafromgeom": (
        '<compiler inertiafromgeom="true"/>',
        '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><geom size="0.2"/>',
    ),
    "shell box": ("", '<geom type="box" size="0.1 0.2 0.3" density="50" shellinertia="true"/>'),
    "shell sphere": ("", '<geom size="0.2" mass="3" shellinertia="true"/>'),
    "shell cylinder": (
        "",
        '<geom type="cylinder" size="0.1 0.3" density="50" shellinertia="true"/>',
    ),
    "shell capsule": ("", '<geom type="capsule" size="0.1 0.3" density="50" shellinertia="true"/>'),
    "fullinertia": ("", '<inertial pos="0 0 0" mass="1" fullinertia="1 1.2 1.1 0.1 0.2 0.05"/>'),
}


@pytest.mark.parametrize("name", MASSES)
def test_masses_are_those_of_mujoco(name: str, tmp_path: Path) -> None:
    head, inner = MASSES[name]
    text = model(f'<body name="b"><freejoint/>{inner}</body>', head)
    same_tree(write(tmp_path, text), share=1e-10)


def test_a_hollow_ellipsoid(tmp_path: Path) -> None:
    """MuJoCo takes the difference of two ellipsoids 1 um apart, with 1e-5 of its size."""
    text = model(
        '<body name="b"><freejoint/><geom type="ellipsoid" size="0.1 0.2 0.3" density="9" shellinertia="true"/></body>'
    )
    same_tree(write(tmp_path, text), share=1e-4)


# two tetrahedra apart from each other, the second inside out
POINTS = "0 0 0 .3 0 0 0 .3 0 0 0 .3 1 0 0 1.2 0 0 1 .2 0 1 0 .2"
FACES = "0 2 1 0 1 3 0 3 2 1 2 3"
FLIPPED = f"{FACES} 4 5 6 4 7 5 4 6 7 5 7 6"
CUP = f'<mesh name="m" vertex="{POINTS}" face="{FLIPPED}" {{}}/>'
MESHES = {
    "legacy": "",
    "convex": 'inertia="convex"',
    "shell": 'inertia="shell"',
    "scaled": 'scale="1 2 -0.5" refpos="0.1 0 0" refquat="0.9 0.1 0.2 0"',
}


@pytest.mark.parametrize("name", MESHES)
def test_masses_of_meshes_are_those_of_mujoco(name: str, tmp_path: Path) -> None:
    head = f"<asset>{CUP.format(MESHES[name])}</asset>"
    text = model(
        '<body name="b"><freejoint/><geom type="mesh" mesh="m" pos="1 0 0" euler="10 20 30"/></body>',
        head,
    )
    # MuJoCo keeps corners with 32 bits
    same_tree(write(tmp_path, text), share=1e-6)


def test_a_mesh_without_faces_is_its_hull(tmp_path: Path) -> None:
    head = f'<asset><mesh name="m" vertex="{POINTS}"/></asset>'
    text = model('<body name="b"><freejoint/><geom type="mesh" mesh="m"/></body>', head)
    same_tree(write(tmp_path, text), share=1e-6)


@pytest.mark.parametrize("kind", ["sphere", "capsule", "cylinder", "ellipsoid", "box"])
@pytest.mark.parametrize("fit", ["true", "false"])
def test_shapes_are_fitted_to_meshes(kind: str, fit: str, tmp_path: Path) -> None:
    head = f'<compiler fitaabb="{fit}"/><asset><mesh name="m" vertex="0 0 0 .3 0 0 0 .2 0 0 0 .7"/></asset>'
    text = model(
        f'<body name="b"><freejoint/><geom type="{kind}" mesh="m" fitscale="1.1"/></body>', head
    )
    same_tree(write(tmp_path, text), share=1e-5)


def test_faces_turned_differently_are_told_and_exact_refuses_them(tmp_path: Path) -> None:
    body = '<body name="b"><freejoint/><geom type="mesh" mesh="m"/></body>'
    path = write(tmp_path, model(body, f"<asset>{CUP.format('')}</asset>"))
    # the pyramids over all faces of both, none negative, from one apex
    assert "the mesh 'm' has" in told(path) and "face inwards" in told(path)
    path = write(
        tmp_path,
        model(body, f"<asset>{CUP.format('inertia=' + chr(34) + 'exact' + chr(34))}</asset>"),
    )
    assert "the mesh 'm' has no mass" in refusal(path)


def test_dents_count_as_mujoco_counts_them_with_a_word(tmp_path: Path) -> None:
    """A pyramid with a dented base: the volume it encloses is less than that of its pyramids."""
    points = "0 0 1  1 1 0  -1 1 0  -1 -1 0  1 -1 0  0 0 .8"
    faces = "0 1 2 0 2 3 0 3 4 0 4 1 5 2 1 5 3 2 5 4 3 5 1 4"
    body = '<body name="b"><freejoint/><geom type="mesh" mesh="m"/></body>'
    head = f'<asset><mesh name="m" vertex="{points}" face="{faces}"/></asset>'
    path = write(tmp_path, model(body, head))
    same_tree(path, share=1e-6)
    # base area 4, heights 1 and 0.8
    assert "encloses 0.2667 m3; inertia='exact' takes the enclosed volume" in told(path)
    path = write(tmp_path, model(body, head.replace("name", 'inertia="exact" name')))
    assert read(path).mass == pytest.approx(1000 * 4 / 3 * 0.2, rel=1e-12)


def test_coordinates_count_from_the_reference(tmp_path: Path) -> None:
    text = arm(
        'ref="40" range="-90 90"',
        tail='<equality><joint joint1="b" joint2="a" polycoef="0.1 -2"/></equality>',
    )
    path = write(tmp_path, text.replace('diaginertia="0.002', 'euler="0 0 10" diaginertia="0.002'))
    robot = read(path)
    a, b = robot.joints
    assert a.initial == pytest.approx(np.radians(40))
    assert (a.lower, a.upper) == pytest.approx((-np.pi / 2, np.pi / 2))
    # q_b - 40 deg = 0.1 - 2 (q_a - 40 deg)
    assert b.mimic.offset == pytest.approx(np.radians(40) + 0.1 + 2 * np.radians(40))
    tree = Tree(robot)
    assert tree.initial[0] == pytest.approx(np.radians(40))
    run = jo.simulate(jo.compile(mechanism(robot)), 0.01)
    assert run["a"][0, 0] == pytest.approx(np.radians(40), abs=1e-12)
    same_tree(write(tmp_path, arm('ref="40"')))
