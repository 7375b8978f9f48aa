"""MJCF files: against MuJoCo, against closed forms, and what is refused."""

# ruff: noqa: E501

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.robots import Tree, mechanism, read_mjcf
from robots.machines import CREATURE


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
    with pytest.raises(jo.InputError, match="<include> is not read"):
        read_mjcf(write(tmp_path, '<mujoco><include file="/etc/passwd"/></mujoco>'))
    text = f"""<mujoco><worldbody>{body.format('<body><joint name="k"/><geom size="0.1"/></body>')}
    </worldbody><actuator/><tendon/><equality><joint joint1="k" joint2="j" polycoef="0.1 -2 0 0 0"/>
    <weld body1="b"/></equality></mujoco>"""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        robot = read_mjcf(write(tmp_path, text))
    said = "\n".join(str(one.message) for one in found)
    assert all(f"<{x}> is not read" in said for x in ("actuator", "tendon", "equality weld"))
    tree = Tree(robot)
    assert tree.velocities == ("j.angle",)
    # the second turns back twice as far
    angle = 0.3 + 0.1 - 2 * 0.3
    assert tree.pose("body2", [0.3]).A[0, 0] == pytest.approx(np.cos(angle), abs=1e-14)
