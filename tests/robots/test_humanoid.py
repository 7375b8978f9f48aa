"""MuJoCo's humanoid from its file: stands with given angles, or falls by its zero-moment point."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo

FILE = Path(__file__).parents[2] / "examples" / "data" / "mujoco_humanoid.xml"
TOES = 0.14  # m from the ankle to the lowest points ahead

pytestmark = [
    pytest.mark.filterwarnings("ignore::jousto.JoustoWarning"),
    pytest.mark.slow,
]


@pytest.mark.parametrize(
    ("share", "contact"), [(0.0, "file"), (0.0, True), (0.95, True), (1.1, "file")]
)
def test_stands_or_falls_by_its_zero_moment_point(share, contact):
    """On a slope that moves the zero-moment point towards the toes and beyond.

    On the soft contacts of the file it falls before the point has reached the toes.
    """
    robot = jo.robots.read_mjcf(FILE)
    angles = {joint.name: 0.0 for joint in robot.joints if joint.kind == "revolute"}
    whole = jo.robots.mechanism(robot)
    mass = sum(one.mass for one in whole.bodies)
    centre = sum(one.mass * (one.position + one.center) for one in whole.bodies) / mass
    foot = next(one for one in whole.bodies if one.name == "foot_left").position[0]
    turn = share * np.arctan2(foot + TOES - centre[0], centre[2])
    gravity = 9.81 * np.array([np.sin(turn), 0.0, -np.cos(turn)])
    machine = jo.robots.mechanism(robot, gravity=gravity, drives=angles, contact=contact)
    end = 2.5 if share > 1 else 10.0
    run = jo.simulate(jo.compile(machine), end, solver=jo.ROS2(2e-3), output_step=2e-2)
    assert run.attributes["contacts"] == "missed: 0 (proven)"
    assert (run.q[-1, 0] > 0.2) == (share > 1)
    if share < 1:
        late = run.time > end - 1.0
        assert np.ptp(run.q[late][:, :3], axis=0).max() < 1e-9
