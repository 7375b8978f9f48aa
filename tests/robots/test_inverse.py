"""Inverse kinematics: places that can be reached, places that cannot, and limits."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.base.rotations import exp_rotation
from jousto.robots import Tree, inverse_kinematics, read_urdf
from robots.machines import ARM


def planar(limits: dict[str, tuple[float, float]] | None = None) -> Tree:
    """An arm of two rods of 1 m and 0.6 m in the plane."""
    one = jo.RigidBody("one", 1.0, (0.1, 0.1, 0.1), markers={"end": (1, 0, 0)})
    two = jo.RigidBody(
        "two", 1.0, (0.1, 0.1, 0.1), markers={"tip": (0.6, 0, 0)}, position=(1, 0, 0)
    )
    first = jo.Revolute("first", jo.ground["origin"], one["origin"])
    second = jo.Revolute("second", one["end"], two["origin"])
    return Tree(jo.Mechanism(one, two, first, second), limits=limits)


def test_the_elbow_is_that_of_the_law_of_cosines() -> None:
    target = np.array([0.9, 0.8, 0.0])
    cosine = (target @ target - 1.0 - 0.36) / 1.2
    for bend in (1.0, -1.0):
        found = inverse_kinematics(planar(), "two.tip", target, start=[0.2, 0.5 * bend])
        assert found.reached and bool(found)
        # 1e-8 m away, by an elbow that is not straight
        assert found.q[1] == pytest.approx(bend * np.arccos(cosine), abs=1e-6)


def test_limits_choose_the_branch_and_hold() -> None:
    tree = planar({"second.angle": (-2.0, -0.1)})
    found = inverse_kinematics(tree, "two.tip", (0.9, 0.8, 0.0), start=[0.2, 1.0])
    assert found.reached and -2.0 <= found.q[1] <= -0.1


def test_out_of_reach_the_arm_points_there() -> None:
    found = inverse_kinematics(planar(), "two.tip", (3.0, 4.0, 0.0), start=[0.3, 0.4])
    assert not found
    # stretched: the nearest that it comes to, quadratic in the angle
    assert found.distance == pytest.approx(5.0 - 1.6, abs=1e-9)
    assert found.q == pytest.approx([np.arctan2(4.0, 3.0), 0.0], abs=1e-3)
    assert str(found).startswith("not reached: 3.4 m")
    held = inverse_kinematics(planar({"first.angle": (-0.5, 0.5)}), "two.tip", (0.0, 1.6, 0.0))
    assert not held and "with first.angle at the limit" in str(held)


def test_poses_of_a_six_axis_arm(tmp_path: Path) -> None:
    path = tmp_path / "arm.urdf"
    path.write_text(ARM, encoding="utf-8")
    tree = Tree(read_urdf(path))
    rng = np.random.default_rng(4)
    low, high = np.maximum(tree.lower, -3.0), np.minimum(tree.upper, 3.0)
    for _ in range(5):
        wanted = tree.pose("tcp", rng.uniform(low, high))
        found = inverse_kinematics(tree, "tcp", wanted.r, wanted.A)
        assert found.reached, found
        there = tree.pose("tcp", found.q)
        assert np.linalg.norm(there.r - wanted.r) < 1e-8
        # |A - B| is sqrt(2) times the angle, for small ones
        assert np.linalg.norm(there.A - wanted.A) < 2e-8
        assert (found.q >= tree.lower).all() and (found.q <= tree.upper).all()


def test_axes_alone_of_a_free_body() -> None:
    body = jo.RigidBody("body", 1.0, (0.1, 0.1, 0.1), position=(1, 2, 3))
    other = jo.RigidBody("other", 1.0, (0.1, 0.1, 0.1))
    hinge = jo.Revolute("hinge", jo.ground["origin"], other["origin"])
    with pytest.warns(jo.JoustoWarning, match="moves freely"):
        tree = Tree(jo.Mechanism(body, other, hinge))
    A = exp_rotation([0.4, -2.0, 1.0])
    found = inverse_kinematics(tree, body["origin"], axes=A)
    assert found.reached
    np.testing.assert_allclose(tree.pose("body", found.q).A, A, atol=1e-7)


def test_nothing_wanted_is_refused() -> None:
    with pytest.raises(jo.InputError, match="give a position, axes, or both"):
        inverse_kinematics(planar(), "two.tip")
    with pytest.raises(jo.InputError, match="starts is 0, must be a whole number above zero"):
        inverse_kinematics(planar(), "two.tip", (1, 0, 0), starts=0)
