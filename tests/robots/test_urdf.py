"""URDF files: what they say, what is refused, what is odd, and what they may not do."""

# ruff: noqa: E501

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from jousto.robots import Tree, mechanism, read_urdf
from robots.machines import ARM

BALL = '<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
HINGE = '<joint name="h" type="continuous"><parent link="a"/><child link="b"/>{}</joint>'
LINKS = f'<link name="a"/><link name="b">{BALL}</link>'

Write = Callable[..., Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write(text: str, *, whole: bool = False) -> Path:
        path = tmp_path / "robot.urdf"
        path.write_text(text if whole else f'<robot name="r">{text}</robot>', encoding="utf-8")
        return path

    return write


def sentences(path: Path, **options: Any) -> str:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        with pytest.raises(jo.InputError) as error:
            read_urdf(path, **options)
    return str(error.value)


def test_turns_and_inertia_are_those_of_the_format(write: Write) -> None:
    # scipy's "xyz" are fixed axes: roll about x first, yaw about z last
    A = Rotation.from_euler("xyz", [0.3, -0.2, 0.5]).as_matrix()
    robot = read_urdf(write(ARM, whole=True))
    assert repr(robot) == "<Robot 'arm': 7 links, 6 moving joints>"
    link = robot.links[1]
    local = np.array([[31, 1, -2], [1, 29, 0.5], [-2, 0.5, 12]]) * 1e-3
    np.testing.assert_allclose(link.inertia, A @ local @ A.T, atol=1e-15)
    np.testing.assert_array_equal(link.center, [0.01, -0.02, 0.11])
    joint = robot.joints[2]
    turn = Rotation.from_euler("xyz", [0.1, 0.9, -0.2]).as_matrix()
    np.testing.assert_allclose(joint.origin.A, turn, atol=1e-15)
    assert (joint.lower, joint.upper, joint.effort, joint.velocity) == (-2.2, 2.2, 100.0, 3.0)
    assert (robot.joints[0].damping, robot.joints[0].friction) == (0.5, 0.3)
    # an axis that is left out is x
    np.testing.assert_array_equal(robot.joints[3].axis, [1, 0, 0])
    # 9 kg of the base and 0.7 kg of the tool, which is merged
    assert robot.mass == pytest.approx(9 + 4.1 + 5.2 + 2.6 + 1.3 + 0.9 + 0.4 + 0.7)
    assert set(robot.links[-1].frames) == {"tool", "tcp"}
    kept = read_urdf(write(ARM, whole=True), merge=False)
    assert len(kept.links) == 9 and kept.mass == pytest.approx(robot.mass)


def test_a_joint_that_follows_is_a_coupling(write: Write) -> None:
    text = f"""{LINKS}<link name="c">{BALL}</link>{HINGE.format("")}
    <joint name="f" type="prismatic"><parent link="b"/><child link="c"/>
    <limit lower="-1" upper="1" effort="5" velocity="1"/>
    <mimic joint="h" multiplier="0.5" offset="0.2"/></joint>"""
    robot = read_urdf(write(text))
    tree = Tree(robot)
    assert tree.velocities == ("h.angle",)
    # b turns, c with it and along it: I = 1 + 1 + 2 kg 0.25 m2
    assert tree.mass_matrix([0.3]) == pytest.approx(np.array([[2.5]]), abs=1e-14)
    assert tree.pose("c", [0.3]).r == pytest.approx([0.35, 0.0, 0.0], abs=1e-15)
    # the limits of the follower are those of what leads: (+-1 - 0.2) / 0.5
    assert (tree.lower[0], tree.upper[0]) == pytest.approx((-2.4, 1.6))
    machine = mechanism(robot, at={"h": 0.4})
    run = jo.simulate(jo.compile(machine), 0.01)
    assert run["f"][-1, 0] == pytest.approx(0.5 * run["h"][-1, 0] + 0.2, abs=1e-9)


def test_everything_wrong_is_said_at_once(write: Write) -> None:
    bad = """
<link name="a"/>
<link name="flat"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="3" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="minus"><inertial><mass value="1"/><inertia ixx="-1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="empty"/>
<link name="nan"><inertial><mass value="nan"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="1" type="revolute"><parent link="a"/><child link="flat"/><limit lower="2" upper="1" effort="1" velocity="1"/></joint>
<joint name="2" type="revolut"><parent link="a"/><child link="minus"/></joint>
<joint name="3" type="continuous"><parent link="a"/><child link="emty"/></joint>
<joint name="4" type="continuous"><parent link="a"/><child link="nan"/><axis xyz="0 0 0"/></joint>
<joint name="4" type="fixed"><parent link="a"/><child link="flat"/></joint>
"""
    said = sentences(write(bad))
    for part in (
        "joint '1': lower limit 2 is above the upper limit 1",
        "type is 'revolut', must be one of revolute, continuous",
        "child: no link 'emty'; did you mean 'empty'?",
        "mass: value is 'nan', must be finite",
        "axis is (0, 0, 0), must have a direction",
        "2 joints have the name '4'; rename them",
        "link 'flat' is also the child of joint '1'",
    ):
        assert part in said
    assert "no parent" not in said  # 'empty' is what 'emty' means
    # each with its line in the file
    assert said.splitlines()[0].startswith("robot.urdf:6: ")


def test_masses_that_no_body_has(write: Write) -> None:
    flat, minus = BALL.replace('izz="1"', 'izz="3"'), BALL.replace('ixx="1"', 'ixx="-1"')
    links = f'<link name="a"/><link name="flat">{flat}</link><link name="minus">{minus}</link>'
    joints = "".join(
        f'<joint name="{i}" type="continuous"><parent link="a"/><child link="{name}"/></joint>'
        for i, name in enumerate(("flat", "minus", "empty"))
    )
    ball = '<visual><geometry><sphere radius="1"/></geometry></visual>'
    said = sentences(write(f'{links}<link name="empty">{ball}</link>{joints}'))
    for part in (
        "link 'flat': inertia violates the triangle inequality: principal moments 1, 1, 3",
        "link 'minus': inertia is not positive",
        "link 'empty': moves with joint '2', but neither it nor its children have a mass",
    ):
        assert part in said


@pytest.mark.parametrize(
    ("joints", "said"),
    [
        (HINGE.format("") + HINGE.format("").replace('"h"', '"i"'), "which closes a loop"),
        (
            HINGE.format("")
            + '<joint name="i" type="fixed"><parent link="b"/><child link="a"/></joint>',
            "all links have a parent: the joints form a circle",
        ),
        ('<joint name="i" type="fixed"><parent link="b"/><child link="b"/></joint>', "with itself"),
        (HINGE.format('<mimic joint="h"/>'), "'h' follows 'h', itself"),
        (HINGE.format('<mimic joint="x"/>'), "mimic: no joint 'x'"),
        (HINGE.format('<origin xyz="0 0"/>'), "xyz has 2 numbers, must be 3 numbers"),
        (HINGE.format('<dynamics damping="-1"/>'), "damping is -1, must not be negative"),
        (HINGE.format("") + "<xacro:arm/>", "is a macro; run xacro first"),
        ('<joint name="h" type="fixed"><parent link="a"/></joint>', "<child link=...> is missing"),
    ],
)
def test_what_cannot_run_is_refused(joints: str, said: str, write: Write) -> None:
    assert said in sentences(write(LINKS + joints))


def test_what_is_odd_is_told(write: Write, tmp_path: Path) -> None:
    heavy = BALL.replace('"2"', '"2e6"')
    thin = BALL.replace('"2"', '"0.0001"')
    text = f"""<link name="a"><visual><geometry><mesh filename="gone.stl"/></geometry></visual>
    <visual><geometry><mesh filename="package://other/x.stl"/></geometry></visual>
    <visual><geometry><mesh filename="http://a.b/x.stl"/></geometry></visual></link>
    <link name="b">{heavy}</link><link name="c.d">{thin}</link>
    <joint name="h" type="revolute"><parent link="a"/><child link="b"/></joint>
    <joint name="i" type="continuous"><parent link="b"/><child link="c.d"/><origin xyz="1 0 0"/></joint>
    <link name="e">{BALL}</link>
    <joint name="k" type="revolute"><parent link="b"/><child link="e"/><limit lower="-114" upper="90"/></joint>
    <spaceship/><transmission/>"""
    with pytest.warns(jo.JoustoWarning) as found:
        robot = read_urdf(write(text))
    said = "\n".join(str(one.message) for one in found)
    for part in (
        "the mesh 'gone.stl' is not there; the shape is ignored",
        "is in package 'other'; give its folder, packages={'other': folder}",
        "is at http://, must be a file",
        "link 'b': mass is 2e+06 kg; was it given in g?",
        "its radius of gyration is 122 m, the robot itself 1 m long",
        "'c.d' is renamed to 'c_d'",
        "limits are -114 and 90 rad, 18 turns; were they given in degrees?",
        "a revolute joint has no <limit>; its motion is not limited",
        "<spaceship> is ignored",
    ):
        assert part in said
    assert len(robot.odd) == len(found)


def test_shapes_are_drawn_and_stand_in_the_link(write: Write, tmp_path: Path) -> None:
    import meshio

    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    (tmp_path / "meshes").mkdir()
    meshio.Mesh(points, [("triangle", faces)]).write(tmp_path / "meshes" / "tip.stl")
    text = f"""<link name="a"/><link name="b">{BALL}
    <visual><origin xyz="0 0 2"/><geometry><box size="1 2 3"/></geometry></visual>
    <visual><origin xyz="5 0 0"/><geometry><mesh filename="package://mine/tip.stl" scale="0.1 0.1 0.1"/></geometry></visual>
    <visual><geometry><cylinder radius="0.1" length="4"/></geometry></visual>
    <visual><geometry><sphere radius="0.5"/></geometry></visual></link>{HINGE.format("")}"""
    robot = read_urdf(write(text), packages={"mine": tmp_path / "meshes"})
    box, tip, rod, ball = robot.links[1].shapes
    np.testing.assert_allclose([box.min((0, 1)), box.max((0, 1))], [[-0.5, -1, 0.5], [0.5, 1, 3.5]])
    np.testing.assert_allclose(tip.max((0, 1)), [5.1, 0.1, 0.1], atol=1e-6)  # STL has 32 bits
    assert np.ptp(rod, axis=(0, 1))[2] == pytest.approx(4.0)
    assert np.abs(ball).max() == pytest.approx(0.5)
    body = mechanism(robot).bodies[0]
    assert len(body.outline) == sum(len(shape) for shape in robot.links[1].shapes)


def test_no_entities_and_no_files_from_elsewhere(write: Write, tmp_path: Path) -> None:
    bomb = '<!DOCTYPE r [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]><robot name="&b;"/>'
    assert "has a DOCTYPE, which could include other files" in sentences(write(bomb, whole=True))
    outside = '<!DOCTYPE r SYSTEM "file:///etc/hostname"><robot name="r"/>'
    assert "has a DOCTYPE" in sentences(write(outside, whole=True))
    deep = "<a>" * 3000
    assert "within each other" in sentences(write(deep, whole=True))
    assert "is not valid XML" in sentences(write("<robot", whole=True))
    assert "no such file" in sentences(tmp_path / "none.urdf")
    assert "is a folder" in sentences(tmp_path)
    home = tmp_path / "home"
    home.mkdir()
    (tmp_path / "secret.stl").write_text("solid", encoding="utf-8")
    (home / "link.stl").symlink_to(tmp_path / "secret.stl")
    for name in (
        "../secret.stl",
        "link.stl",
        str(tmp_path / "secret.stl"),
        f"file://{tmp_path}/secret.stl",
    ):
        path = home / "robot.urdf"
        path.write_text(
            f'<robot name="r"><link name="a"><visual><geometry><mesh filename="{name}"/></geometry>'
            "</visual></link></robot>",
            encoding="utf-8",
        )
        with pytest.warns(jo.JoustoWarning, match="lies outside the folder of the robot"):
            read_urdf(path)


def test_inertia_that_counts_is_the_one_that_moves(write: Write) -> None:
    flat = BALL.replace('izz="1"', 'izz="2.5"').replace('"2"', '"1"', 1)
    weld = '<joint name="w" type="fixed"><parent link="b"/><child link="c"/></joint>'
    path = write(f'{LINKS}<link name="c">{flat}</link>{HINGE.format("")}{weld}')
    # 1 + 1, 1 + 1 and 1 + 2.5 belong to a body, although 1, 1 and 2.5 do not
    with pytest.warns(jo.JoustoWarning, match="without effect, since it is fixed to other links"):
        robot = read_urdf(path)
    np.testing.assert_allclose(np.diag(robot.links[1].inertia), [2.0, 2.0, 3.5])
    assert "link 'c': inertia violates the triangle inequality" in sentences(path, merge=False)


def test_inertia_is_repaired_where_that_is_asked_for(write: Write) -> None:
    flat = BALL.replace('izz="1"', 'izz="3"')
    path = write(f'<link name="a"/><link name="b">{flat}</link>{HINGE.format("")}')
    with pytest.warns(jo.JoustoWarning, match="principal moments 1, 1, 3 .*; repaired"):
        robot = read_urdf(path, repair=True)
    # second moments (tr J / 2 - J) of 1.5, 1.5 and -0.5: the last becomes a millionth
    np.testing.assert_allclose(np.diag(robot.links[1].inertia), [1.5, 1.5, 3.0], rtol=1e-5)
    mechanism(robot)


def test_what_moves_nothing_is_held(write: Write) -> None:
    more = '<joint name="i" type="continuous"><parent link="b"/><child link="c"/></joint>'
    with pytest.warns(jo.JoustoWarning, match="joint 'i': moves no link with a mass"):
        robot = read_urdf(write(f'{LINKS}<link name="c"/>{HINGE.format("")}{more}'))
    assert Tree(robot).velocities == ("h.angle",) and "c" in Tree(robot).frames


def test_joints_start_within_their_limits(write: Write) -> None:
    hinge = HINGE.format('<limit lower="0.4" upper="1.2" effort="1" velocity="1"/>')
    robot = read_urdf(write(LINKS + hinge.replace("continuous", "revolute")))
    run = jo.simulate(jo.compile(mechanism(robot)), 0.01)
    assert run["h"][0, 0] == pytest.approx(0.4, abs=1e-12)
    with pytest.raises(
        jo.InputError, match=r"at\['h'\]: 0.1 rad is outside the limits 0.4 and 1.2"
    ):
        mechanism(robot, at={"h": 0.1})
    free = mechanism(robot, at={"h": 0.1}, stops=False)
    assert jo.simulate(jo.compile(free), 0.01)["h"][0, 0] == pytest.approx(0.1, abs=1e-12)


@pytest.mark.parametrize("links", [1, 2])
def test_a_child_that_is_misspelt_is_told_once(links: int, write: Write) -> None:
    """The link that stays without a parent is no second problem; another one is."""
    joint = HINGE.format("").replace('child link="b"', 'child link="bb"')
    spare = '<link name="c"><inertial><mass value="1"/></inertial></link>' * (links - 1)
    with pytest.raises(jo.InputError) as error:
        read_urdf(write(LINKS + spare + joint))
    assert "child: no link 'bb'" in str(error.value)
    assert ("links have no parent" in str(error.value)) == (links > 1)
    assert len([x for x in error.value.problems if "no link" in x.message]) == 1


def test_misspelt_attributes_and_degrees_are_told(write: Write) -> None:
    inner = (
        '<origin xyz="0 0 1" rpy="0 90 0"/><dynamics dampening="0.5" vendor:heat="1"/>'
        '<limit min="-1" max="1" velocity="2" effort="3"/>'
    )
    text = f'<robot name="r" xmlns:vendor="http://x">{LINKS}{HINGE.format(inner)}</robot>'
    with pytest.warns(jo.JoustoWarning) as said:
        read_urdf(write(text, whole=True))
    told = "\n".join(str(one.message) for one in said)
    assert "dynamics: 'dampening' is not read; did you mean 'damping'?" in told
    assert "limit: 'min' is not read" in told and "limit: 'max' is not read" in told
    assert "rpy is '0 90 0', read as rad" in told
    assert "heat" not in told and len(said) == 4


def test_inertia_without_mass_counts_where_it_is_fixed_to_a_mass(write: Write) -> None:
    """The rotor of a motor, whose mass is in its housing: Pinocchio adds its inertia, too."""
    rotor = BALL.replace('mass value="2"', 'mass value="0"').replace('izz="1"', 'izz="0.5"')
    weld = '<joint name="w" type="fixed"><parent link="b"/><child link="c"/><origin rpy="0.3 0 0"/></joint>'
    hinge = HINGE.format('<axis xyz="0 1 1"/>')
    path = write(f'{LINKS}<link name="c">{rotor}</link>{hinge}{weld}')
    robot = read_urdf(path)
    A = Rotation.from_euler("x", 0.3).as_matrix()
    wanted = np.eye(3) + A @ np.diag([1, 1, 0.5]) @ A.T
    np.testing.assert_allclose(robot.links[1].inertia, wanted, atol=1e-15)
    pinocchio = pytest.importorskip("pinocchio")
    model = pinocchio.buildModelFromUrdf(str(path))
    M = pinocchio.crba(model, model.createData(), np.zeros(model.nq))
    np.testing.assert_allclose(Tree(robot).mass_matrix([0.0]), M, atol=1e-14)
    # alone it counts for nothing, and is told
    lone = f'<link name="a"/><link name="b">{rotor}</link>{HINGE.format("")}'
    with pytest.warns(jo.JoustoWarning) as found:
        read_urdf(write(lone))
    assert "link 'b': has inertia but no mass" in "\n".join(str(one.message) for one in found)


def test_masses_below_zero_are_refused_wherever_they_are(write: Write) -> None:
    minus = BALL.replace('mass value="2"', 'mass value="-2"')
    weld = '<joint name="w" type="fixed"><parent link="b"/><child link="c"/></joint>'
    text = f'{LINKS}<link name="c">{minus}</link>{HINGE.format("")}{weld}'
    said = sentences(write(text))
    assert said.count("mass is -2 kg, must not be negative") == 1 and "link 'c'" in said
    assert "mass is -2 kg" in sentences(write(text), merge=False)
    # on what stands still, too
    assert "mass is -2 kg" in sentences(write(f'<link name="a">{minus}</link>'))


def test_meshes_may_be_left_out(write: Write) -> None:
    text = '<link name="a"><visual><geometry><mesh filename="gone.stl"/></geometry></visual></link>'
    robot = read_urdf(write(text), meshes=False)  # no warning
    assert robot.links[0].shapes == ()


COLLADA = """<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><created>2020-01-01T00:00:00</created><modified>2020-01-01T00:00:00</modified><unit name="cm" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="pa" count="12">0 0 0 10 0 0 0 20 0 0 0 30</float_array>
<technique_common><accessor source="#pa" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="2"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2 0 1 3</p></triangles></mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><translate>100 0 0</translate><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""
# 4 points, 2 texture coordinates, 1 normal
OBJ = """v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nvt 0 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/1/1\nf 1/1/1 2/2/1 4/1/1\nf 2//1 3//1 4//1\n"""


@pytest.mark.parametrize(
    ("name", "text", "low", "high", "count"),
    [("x.dae", COLLADA, [1, 0, 0], [1.1, 0.2, 0.3], 2), ("x.obj", OBJ, [0, 0, 0], [1, 2, 3], 3)],
)
def test_shapes_of_collada_and_obj_files(
    name: str,
    text: str,
    low: list[float],
    high: list[float],
    count: int,
    write: Write,
    tmp_path: Path,
) -> None:
    pytest.importorskip("collada")
    pytest.importorskip("trimesh")
    (tmp_path / name).write_text(text, encoding="utf-8")
    visual = f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
    (shape,) = read_urdf(write(f'<link name="a">{visual}</link>')).links[0].shapes
    assert shape.shape == (count, 3, 3)
    np.testing.assert_allclose(shape.min((0, 1)), low, atol=1e-6)  # 32 bits
    np.testing.assert_allclose(shape.max((0, 1)), high, atol=1e-6)


def test_a_collada_file_reaches_for_no_other(write: Write, tmp_path: Path) -> None:
    pytest.importorskip("collada")
    bomb = '<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/hostname">]>' + COLLADA.partition("?>")[2]
    (tmp_path / "x.dae").write_text(bomb, encoding="utf-8")
    (tmp_path / "y.stl").write_text(
        "version https://git-lfs.github.com/spec/v1\n", encoding="utf-8"
    )
    for name, said in (("x.dae", "has a DOCTYPE"), ("y.stl", "is a pointer of Git LFS")):
        visual = f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
        with pytest.warns(jo.JoustoWarning, match=said):
            read_urdf(write(f'<link name="a">{visual}</link>'))


def test_words_for_gazebo_that_change_the_motion_are_told(write: Write) -> None:
    more = '<gazebo reference="b"><turnGravityOff>true</turnGravityOff><mu1>3</mu1></gazebo>'
    with pytest.warns(jo.JoustoWarning) as found:
        read_urdf(write(f"{LINKS}{HINGE.format('')}{more}"))
    (one,) = found
    assert "robot.urdf:1: turnGravityOff: <turnGravityOff>: the weight acts on this link" in str(
        one.message
    )


SIMPLE = """<transmission name="t"><type>transmission_interface/SimpleTransmission</type>
  <joint name="{joint}"><hardwareInterface>EffortJointInterface</hardwareInterface></joint>
  <actuator name="m"><mechanicalReduction>{n}</mechanicalReduction>
  <motorTorqueConstant>1</motorTorqueConstant></actuator></transmission>"""
CONTROL = """<ros2_control name="c" type="system"><hardware><plugin>x/Y</plugin></hardware>
  <joint name="h"><command_interface name="effort"/></joint>
  <transmission name="t"><plugin>transmission_interface/SimpleTransmission</plugin>
  <actuator name="m" role="actuator1"/><joint name="h" role="joint1">
  <mechanical_reduction>{n}</mechanical_reduction><offset>0.3</offset></joint>
  </transmission></ros2_control>"""


WHOLE = """<transmission name="t" type="pr2_mechanism_model/SimpleTransmission">
  <joint name="{joint}"/><actuator name="m"/><mechanicalReduction>{n}</mechanicalReduction>
  </transmission>"""


STIFF = {"stiffness": 1e4, "damping": 20.0}


@pytest.mark.parametrize("form", [SIMPLE, CONTROL, WHOLE])
@pytest.mark.filterwarnings("error::jousto.JoustoWarning")
def test_a_transmission_is_a_motor_with_its_gear(form: str, write: Write) -> None:
    """I = 1 kg m2 about the axis: u = 0.02 N m at the motor of a reduction -50 gives -1 rad/s2."""
    robot = read_urdf(write(LINKS + HINGE.format("") + form.format(joint="h", n=-50)))
    (motor,) = robot.actuators
    assert (motor.name, motor.joint, motor.gear) == ("m", "h", -50.0)
    model = jo.compile(mechanism(robot, gravity=(0, 0, 0)))
    run = jo.simulate(model, 1.0, inputs={"m": 0.02})
    assert run["h"][-1, 0] == pytest.approx(-0.5, rel=1e-9)
    off = jo.compile(mechanism(robot, actuators=False))
    on = jo.compile(mechanism(robot))
    assert len(on.forces) == len(off.forces) + 1
    geared = mechanism(robot, gravity=(0, 0, 0), elastic={"h": {"rotor_inertia": 1e-9, **STIFF}})
    run = jo.simulate(jo.compile(geared), 1.0, inputs={"m": 0.02}, solver=jo.ROS2(1e-3))
    assert run["h"][-1, 0] == pytest.approx(-0.5, rel=1e-4)
    pushed = mechanism(robot, gravity=(0, 0, 0), efforts={"h": 2.0})
    assert jo.simulate(jo.compile(pushed), 1.0)["h"][-1, 0] == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (SIMPLE.format(joint="k", n=50), "no joint 'k'; known: h"),
        (SIMPLE.format(joint="h", n=0), "mechanicalReduction is 0, must not be zero"),
        (SIMPLE.format(joint="h", n="much"), "mechanicalReduction is 'much', must be a number"),
        (SIMPLE.format(joint="h", n=2) * 2, "2 motors have the name 'm'; rename one"),
        (
            SIMPLE.format(joint="h", n=2).replace("</joint>", '</joint><joint name="h"/>'),
            "a simple transmission has 2 joints and 1 actuators, must have one of each",
        ),
    ],
)
def test_a_transmission_that_is_wrong_is_refused(text: str, said: str, write: Write) -> None:
    assert said in sentences(write(LINKS + HINGE.format("") + text))


def test_other_transmissions_are_told(write: Write) -> None:
    """A differential, and one of a fixed joint, make no force, and the warning says so."""
    other = SIMPLE.format(joint="h", n=2).replace("Simple", "Differential")
    fixed = (
        '<link name="c"/><joint name="k" type="fixed"><parent link="b"/><child link="c"/></joint>'
    )
    at = SIMPLE.format(joint="k", n=2).replace('"m"', '"m2"')
    with pytest.warns(jo.JoustoWarning) as found:
        robot = read_urdf(write(LINKS + HINGE.format("") + fixed + other + at))
    said = "\n".join(str(one.message) for one in found)
    assert "DifferentialTransmission'" in said and "a transmission of a fixed joint" in said
    assert "makes no force here; put one on its joints with efforts=" in said
    assert robot.actuators == ()
