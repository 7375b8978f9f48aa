"""A quadruped stands and trots: weight, creep, MuJoCo's stance, one path for all steps.

Numbers: 12.8 kg, position drives kp 400, kv 10, stance hip 25, knee -50 degrees, MuJoCo 4.0.
"""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from robots.peers import peer

EXAMPLES = Path(__file__).parents[2] / "examples"
FILE = EXAMPLES / "data" / "quadruped.xml"
JOINTS = [f"{leg}_{joint}" for leg in ("fl", "fr", "hl", "hr") for joint in ("hip", "knee")]
STANCE = dict(zip(JOINTS, np.radians([25, -50] * 4), strict=True))
WEIGHT = 12.8 * 9.81  # N

pytestmark = pytest.mark.filterwarnings("ignore:.*contact is off", "ignore:.*energy balance")


def example() -> Any:
    """Return the module of the example."""
    spec = importlib.util.spec_from_file_location("quadruped", EXAMPLES / "quadruped.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def gravity(slope: float) -> np.ndarray:
    turn = np.radians(slope)
    return 9.81 * np.array([-np.sin(turn), 0.0, -np.cos(turn)])


@pytest.fixture(scope="module")
def machine() -> Any:
    return example()


@pytest.mark.parametrize("slope", [0.0, 10.0])
def test_feet_carry_the_weight_and_do_not_creep(machine, slope):
    """Nothing slips after 1 s; then the feet follow the servos that settle, at 3 s to rounding."""
    model = machine.quadruped(slope=np.radians(slope))
    run = jo.simulate(model, 4.0, solver=jo.ROS2(2e-3), output_step=1e-2)
    feet = np.array([run[f"{leg} foot"] for leg in machine.SHINS])
    late, end = run.time > 1.0, run.time > 3.0
    assert np.ptp(feet[:, end], axis=1).max() < 1e-14
    assert np.ptp(feet[:, late], axis=1).max() < 1e-7
    force = machine.force(run)[:, :3]
    assert np.abs(force[end].mean(axis=0) / WEIGHT + gravity(slope) / 9.81).max() < 1e-9
    for time in (1.0, 2.5, 4.0):
        phases = {point.phase for point in run.contacts.at(time)}
        assert phases == {"sticks"}


def test_stance_is_that_of_mujoco(machine):
    """Joints within 0.02 degrees; the trunk lower by the difference of the depths of the feet."""
    mujoco = pytest.importorskip("mujoco")
    robot = peer(FILE)
    data = mujoco.MjData(robot)
    data.qpos[2] = 0.4 * np.cos(np.radians(25)) + 0.025
    data.qpos[7:] = data.ctrl[:] = list(STANCE.values())
    for _ in range(2000):
        mujoco.mj_step(robot, data)
    run = machine.stand(0.0)
    angles = np.array([run[name][-1, 0] for name in JOINTS])
    assert np.degrees(np.abs(angles - data.qpos[7:])).max() < 0.02
    floor = 0.42 - 0.4 * np.cos(np.radians(25)) - 0.025
    height = run["trunk"][-1, 2] - floor
    depth = floor + 0.025 - np.mean([run[f"{leg} foot"][-1, 2] for leg in machine.SHINS])
    other = -np.mean([one.dist for one in data.contact])
    assert abs((height - data.qpos[2]) + (depth - other)) < 2e-6


def test_stance_with_the_contacts_and_drives_of_the_file():
    """`contact="file"` and the position actuators of the file, dropped: MuJoCo's trunk."""
    mujoco = pytest.importorskip("mujoco")
    other = peer(FILE)
    data = mujoco.MjData(other)
    data.qpos[2] = 0.387
    data.qpos[7:] = data.ctrl[:] = list(STANCE.values())
    for _ in range(2000):
        mujoco.mj_step(other, data)
    robot = jo.robots.read_mjcf(FILE)
    whole = jo.robots.mechanism(robot, at=STANCE, contact="file")
    model = jo.compile(whole)
    names = [one.name for one in whole.sensors if one.name in STANCE]
    inputs = {f"{name} actuator": angle for name, angle in STANCE.items()}
    run = jo.simulate(model, 3.0, solver=jo.ROS2(2e-3), inputs=inputs, output_step=0.1)
    angles = np.array([run[name][-1, 0] for name in names])
    wanted = dict(zip(JOINTS, data.qpos[7:], strict=True))
    assert np.degrees(np.abs(angles - [wanted[name] for name in names])).max() < 0.05
    assert abs(run.q[-1, 2] - data.qpos[2]) < 5e-6


@pytest.mark.slow
def test_path_of_the_trot_has_a_limit(machine):
    """Steps of 2 and 0.5 ms and their limit within 2 %, and the same order of feet down."""
    model = machine.quadruped(machine.SWING)
    paths, orders = [], []
    for step in (2e-3, 1e-3, 5e-4, 1.25e-4, 5e-5):
        run = machine.trot(model, step)
        paths.append(run["trunk"][-1, 0])
        orders.append([one.contact for one in run.contacts if one.touch > 0.0])
    assert np.ptp(paths) < 0.02 * paths[-1]
    away = np.abs(np.subtract(paths[1:-1], paths[-1]))
    assert (np.diff(away) < 0.0).all() and away[-1] < 0.3 * away[0]
    assert all(order == orders[-1] for order in orders)


@pytest.mark.slow
@pytest.mark.parametrize("solver", [jo.GeneralizedAlpha(2e-3), jo.ROS2(2.5e-4)])
def test_mean_force_of_a_trot_is_the_weight(machine, solver):
    """Over the last four periods; by momentum it is the weight but for the change of speed."""
    model = machine.quadruped(machine.SWING)
    run = jo.simulate(model, 8.0, solver=solver, output_step=solver.step)
    late = run.time > 4.0 - 1e-9
    mean = np.trapezoid(machine.force(run)[late, 2], run.time[late]) / 4.0
    assert abs(mean / WEIGHT - 1.0) < 5e-4
