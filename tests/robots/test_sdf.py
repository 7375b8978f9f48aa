"""SDF files: the same robot as a URDF file, and what is refused."""

# ruff: noqa: E501

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.robots import Tree, read_robot, read_sdf, read_urdf
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
            '<joint name="j" type="screw"><parent>a</parent><child>b</child></joint>',
            "type is 'screw'",
        ),
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
        ('<model name="n"/>', "a <model> within a model is not read"),
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
