"""SDF files: the same robot as a URDF file, and what is refused."""

# ruff: noqa: E501

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.robots import Tree, mechanism, read_robot, read_sdf, read_urdf
from jousto.robots.readers.formats import FORMATS
from jousto.robots.readers.words import Format
from robots.machines import SCARA, SCARA_SDF


def write(folder: Path, text: str, name: str = "robot.sdf") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_the_same_robot_as_a_urdf_file(tmp_path: Path) -> None:
    one = Tree(read_sdf(write(tmp_path, SCARA_SDF)))
    two = Tree(read_urdf(write(tmp_path, SCARA, "robot.urdf")))
    assert one.velocities == two.velocities
    rng = np.random.default_rng(0)
    q, v, a = rng.normal(size=(3, 4))
    # rounding of numbers of size 100, and the 16 digits of the quaternion
    np.testing.assert_allclose(one.mass_matrix(q), two.mass_matrix(q), atol=1e-13)
    np.testing.assert_allclose(
        one.inverse_dynamics(q, v, a), two.inverse_dynamics(q, v, a), atol=1e-12
    )
    np.testing.assert_allclose(one.lower[[0, 2]], two.lower[[0, 2]])
    assert one.pose("tip", q).r[2] == pytest.approx(two.pose("spindle", q).r[2] - 0.2, abs=1e-14)


def test_what_hangs_on_nothing_moves_freely(tmp_path: Path) -> None:
    text = """<sdf version="1.7"><model name="m"><pose>1 2 3 0 0 0</pose><link name="a">
    <inertial><mass>2</mass></inertial></link><link name="b"><pose>0 0 1 0 0 0</pose><inertial><mass>1</mass></inertial></link>
    <joint name="u" type="universal"><parent>a</parent><child>b</child><axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint>
    </model></sdf>"""
    path = write(tmp_path, text)
    tree = Tree(read_sdf(path))
    assert tree.nv == 8 and tree.velocities[-2:] == ("u 1.angle", "u 2.angle")
    np.testing.assert_array_equal(tree.pose("a", tree.initial).r, [1, 2, 3])
    held = Tree(read_sdf(path, fixed_base=True))
    assert held.nv == 2
    turn = held.pose("b", [0.3, 0.5]).A
    x, y = (jo.Rotate(axis, radians=q).matrix for axis, q in (((1, 0, 0), 0.3), ((0, 1, 0), 0.5)))
    np.testing.assert_allclose(turn, x @ y, atol=1e-15)


@pytest.mark.parametrize(
    ("inner", "said"),
    [
        (
            '<joint name="j" type="skrew"><parent>a</parent><child>b</child></joint>',
            "type is 'skrew'",
        ),
        (
            '<joint name="j" type="screw"><parent>a</parent><child>b</child><screw_thread_pitch>0</screw_thread_pitch></joint>',
            "the pitch of the screw is 0",
        ),
        (
            '<joint name="j" type="gearbox"><parent>a</parent><child>b</child><gearbox_reference_body>c</gearbox_reference_body></joint>',
            "a gearbox needs a revolute joint between its reference body 'c' and its parent 'a'",
        ),
        ("<include><uri>model://x</uri></include>", "<include> is not read; put the model itself"),
        ('<link name="c"><inertial auto="true"/></link>', "auto requests the mass from the shapes"),
        (
            '<joint name="j" type="ball"><parent>a</parent><child>c</child></joint>',
            "child: no link 'c'",
        ),
        (
            '<frame name="f"><pose relative_to="g"/></frame><link name="c"><pose relative_to="f"/></link>',
            "no link, joint or frame 'g'",
        ),
        (
            '<link name="c"><pose relative_to="d"/></link><link name="d"><pose relative_to="c"/></link>',
            "goes in a circle",
        ),
        ('<link name="c"><pose>0 0 0</pose></link>', "pose has 3 numbers, must be 6 numbers"),
    ],
)
@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
def test_what_cannot_run_is_refused(inner: str, said: str, tmp_path: Path) -> None:
    text = (
        f'<sdf version="1.7"><model name="m"><link name="a"/><link name="b"/>{inner}</model></sdf>'
    )
    with pytest.raises(jo.InputError, match=said):
        read_sdf(write(tmp_path, text))


def test_the_root_element_tells_the_format(tmp_path: Path) -> None:
    assert len(read_robot(write(tmp_path, SCARA_SDF, "a.xml")).joints) == 4
    assert len(read_robot(write(tmp_path, SCARA, "b.xml")).joints) == 4
    with pytest.raises(jo.InputError, match=r"c\.xml:1: begins with <html>; URDF, MJCF and SDF"):
        read_robot(write(tmp_path, "<html/>", "c.xml"))


# -- more joints, models within models, loops -------------------------------------------------

BODY = "<inertial><pose>{x} 0 0.1 0 0 0</pose><mass>{m}</mass><inertia><ixx>.02</ixx><iyy>.03</iyy><izz>.04</izz></inertia></inertial>"


def model(inner: str) -> str:
    return f'<sdf version="1.9"><world name="w"><gravity>0 0 -9.81</gravity><model name="m">{inner}</model></world></sdf>'


def link(
    name: str, pose: str = "0 0 0 0 0 0", m: float = 1.0, x: float = 0.0, more: str = ""
) -> str:
    return f'<link name="{name}"><pose>{pose}</pose>{BODY.format(m=m, x=x)}{more}</link>'


def joint(name: str, kind: str, parent: str, child: str, more: str = "") -> str:
    return f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{more}</joint>'


AXIS = "<axis><xyz>{}</xyz></axis>"


def test_a_model_within_is_the_same_as_one_written_out(tmp_path: Path) -> None:
    inner = f"""<model name="tool"><pose relative_to="arm">0.4 0 0.1 0 0.3 0</pose>{link("body", "0.1 0 0 0 0 0.2", 2.0)}
    {link("tip", "0.3 0 0 0 0 0", 0.5)}<frame name="end" attached_to="tip"><pose>0.1 0 0 0 0 0</pose></frame>
    {joint("turn", "revolute", "body", "tip", "<axis><xyz expressed_in='__model__'>0 1 0</xyz></axis>")}</model>"""
    text = model(
        link("arm")
        + inner
        + joint("base", "revolute", "world", "arm", AXIS.format("0 0 1"))
        + joint("flange", "prismatic", "arm", "tool::body", AXIS.format("1 0 0"))
    )
    one = Tree(read_sdf(write(tmp_path, text)))
    flat = model(
        link("arm")
        + joint("base", "revolute", "world", "arm", AXIS.format("0 0 1"))
        + '<frame name="tool"><pose relative_to="arm">0.4 0 0.1 0 0.3 0</pose></frame>'
        + link("body", "0.1 0 0 0 0 0.2", 2.0).replace("<pose>", "<pose relative_to='tool'>", 1)
        + link("tip", "0.3 0 0 0 0 0", 0.5).replace("<pose>", "<pose relative_to='tool'>", 1)
        + joint(
            "turn", "revolute", "body", "tip", "<axis><xyz expressed_in='tool'>0 1 0</xyz></axis>"
        )
        + joint("flange", "prismatic", "arm", "body", AXIS.format("1 0 0"))
    )
    two = Tree(read_sdf(write(tmp_path, flat)))
    assert one.nv == two.nv == 3 and "tool::turn.angle" in one.velocities
    q, v, a = np.random.default_rng(1).normal(size=(3, 3))
    # rounding of numbers of size 30
    np.testing.assert_allclose(
        one.inverse_dynamics(q, v, a), two.inverse_dynamics(q, v, a), atol=1e-13
    )
    assert "tool::end" in one.frames


def test_a_screw(tmp_path: Path) -> None:
    """A nut of 1 kg and 0.04 kg m2 on an upright spindle: (I + m l^2) phi'' = -m g l, l = p / 2 pi."""
    pitch = "<screw_thread_pitch>0.2</screw_thread_pitch>"
    text = model(
        link("nut") + joint("thread", "screw", "world", "nut", AXIS.format("0 0 1") + pitch)
    )
    robot = read_sdf(write(tmp_path, text))
    run = jo.simulate(jo.compile(mechanism(robot)), 0.5)
    lead = 0.2 / (2 * np.pi)
    wanted = -0.5 * 9.81 * lead / (0.04 + lead**2) * 0.25
    assert run["thread"][-1, 0] == pytest.approx(wanted, rel=1e-6)
    tree = Tree(robot)
    assert tree.mass_matrix(tree.initial)[0, 0] == pytest.approx(0.04 + lead**2, rel=1e-12)
    # Gazebo Classic counts rad/m of a left-hand thread
    old = text.replace(pitch, f"<thread_pitch>{-2 * np.pi / 0.2}</thread_pitch>")
    assert read_sdf(write(tmp_path, old)).joints[0].pitch == pytest.approx(0.2)


def test_a_gearbox(tmp_path: Path) -> None:
    """Wheels of 0.04 kg m2 about x with ratio 3: M = I1 9 + I2 in the second angle."""
    gear = "<gearbox_ratio>3</gearbox_ratio><gearbox_reference_body>case</gearbox_reference_body>"
    text = model(
        link("case")
        + link("one")
        + link("two")
        + joint("hold", "fixed", "world", "case")
        + joint("a", "revolute", "case", "one", AXIS.format("0 0 1"))
        + joint("b", "revolute", "case", "two", AXIS.format("0 0 -1"))
        + joint(
            "gear",
            "gearbox",
            "one",
            "two",
            AXIS.format("0 0 1") + "<axis2><xyz>0 0 1</xyz></axis2>" + gear,
        )
    )
    tree = Tree(read_sdf(write(tmp_path, text)))
    assert tree.velocities == ("b.angle",)
    assert tree.mass_matrix([0.0])[0, 0] == pytest.approx(0.04 * 9 + 0.04, rel=1e-12)
    # theta1 = -3 theta2, and b counts the other way
    assert tree.coordinate("a.angle", [0.1]) == pytest.approx(0.3, abs=1e-14)


def test_revolute2_is_two_hinges_in_series(tmp_path: Path) -> None:
    axes = AXIS.format("1 0 0") + "<axis2><xyz>0 1 0</xyz></axis2>"
    text = model(link("a") + joint("j", "revolute2", "world", "a", axes))
    turn = Tree(read_sdf(write(tmp_path, text))).pose("a", [0.3, 0.5]).A
    x, y = (jo.Rotate(axis, radians=q).matrix for axis, q in (((1, 0, 0), 0.3), ((0, 1, 0), 0.5)))
    np.testing.assert_allclose(turn, x @ y, atol=1e-15)


def test_a_link_without_gravity(tmp_path: Path) -> None:
    hinge = joint("h", "revolute", "world", "a", AXIS.format("0 1 0"))
    free = model(link("a", x=0.3, more="<gravity>false</gravity>") + hinge)
    run = jo.simulate(jo.compile(mechanism(read_sdf(write(tmp_path, free)))), 0.5)
    assert np.abs(run["h"]).max() < 1e-12
    falls = jo.simulate(
        jo.compile(mechanism(read_sdf(write(tmp_path, model(link("a", x=0.3) + hinge))))), 0.5
    )
    assert np.abs(falls["h"]).max() > 0.1


def test_a_joint_that_closes_a_loop(tmp_path: Path) -> None:
    """A parallelogram of two cranks and a rod: the cranks turn alike."""
    y = AXIS.format("0 1 0")
    text = model(
        link("left", x=0.1)
        + link("right", "0 0 1 0 0 0", x=0.1)
        + '<link name="rod"><pose>0.5 0 0 0 0 0</pose>'
        + BODY.format(m=1, x=0)
        + "</link>"
        + joint("a", "revolute", "world", "left", y)
        + joint("b", "revolute", "world", "right", y)
        + joint("c", "revolute", "left", "rod", y)
        + '<joint name="d" type="revolute"><pose relative_to="rod">0 0 1 0 0 0</pose><parent>right</parent><child>rod</child>'
        + y
        + "</joint>"
    )
    robot = read_sdf(write(tmp_path, text))
    assert [x.name for x in robot.loops] == ["d"] and Tree(robot).cut == ("d",)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)  # the loop of a plane holds itself
        run = jo.simulate(jo.compile(mechanism(robot)), 0.4)
    assert np.abs(run["a"]).max() > 0.5
    np.testing.assert_allclose(run["a"], run["b"], atol=1e-8)


WORDS = Path(__file__).parent / "words"


@pytest.mark.parametrize("words", FORMATS, ids=lambda words: words.name)
def test_every_word_of_a_format_is_done_or_reported(words: Format) -> None:
    """The lists are those of the formats: SDF 1.12 as sdformat declares it, urdf.xsd of urdfdom."""
    lines = (WORDS / f"{words.name.lower()}.txt").read_text(encoding="utf-8").splitlines()
    listed = [
        (path, word) for path, _, all_ in (x.partition(":") for x in lines) for word in all_.split()
    ]
    assert len(listed) > 80
    assert [x for x in listed if words.treatment(x[0].split("/"), x[1]) is None] == []


@pytest.mark.parametrize(
    ("inner", "said"),
    [
        (
            "<velocity_decay><linear>0.1</linear></velocity_decay>",
            "<linear>: the decay of velocities is left out",
        ),
        ("<kinematic>true</kinematic>", "<kinematic>: it moves by its forces here"),
        ("<enable_wind>true</enable_wind>", "wind and the forces of fluids are left out"),
        ("<spaceship/>", "<spaceship> is ignored"),
        (
            "<collision/></link><link name='b'><collision/>",
            "<collision>: contact is off: links that touch pass through each other",
        ),
    ],
)
def test_what_changes_the_motion_is_warned_of(inner: str, said: str, tmp_path: Path) -> None:
    path = write(tmp_path, model(link("a", more=inner)))
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        read_sdf(path)
    assert said in "\n".join(str(one.message) for one in found)
