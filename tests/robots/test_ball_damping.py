"""Damping of balls beside MuJoCo: the torque is -c times the relative angular velocity."""

# ruff: noqa: E501

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from robots import peers

BALL = """<mujoco><option gravity="2 -1 -9.81"><flag contact="disable"/></option><worldbody>
<body name="stick" pos="0 0 1"><joint name="ball" type="ball" damping="{damping}" {more}/>
<inertial pos="0.3 0.05 0" mass="1.5" diaginertia="0.02 0.05 0.06"/><site name="tip" pos="0.6 0 0.1"/></body></worldbody></mujoco>"""


@pytest.mark.parametrize(
    ("damping", "more"), [(0.2, ""), (1.5, ""), (0.2, 'stiffness="1.5"')], ids=str
)
def test_a_damped_ball_swings_beyond_a_right_angle(
    damping: float, more: str, tmp_path: Path
) -> None:
    mujoco = pytest.importorskip("mujoco")
    path = peers.write(tmp_path, BALL.format(damping=damping, more=more))
    model = peers.peer(path)
    model.opt.timestep, model.opt.integrator = peers.STEP, mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(model)
    for _ in range(round(0.6 / peers.STEP)):
        mujoco.mj_step(model, data)
    robot = peers.read(path)
    stick = jo.robots.RobotInMechanism("m", robot)
    tip = jo.PositionSensor("tip", stick["tip"])
    machine = jo.compile(jo.Mechanism(stick, tip, jo.Gravity(robot.gravity)))
    run = jo.simulate(machine, 0.6, solver=jo.RK4(5 * peers.STEP))
    turned = np.arccos(0.5 * (np.trace(np.array(data.body("stick").xmat).reshape(3, 3)) - 1.0))
    assert turned > np.pi / 2 or damping > 1.0
    # motions of 2 Hz, of order 4 at 0.5 ms: (2 pi 2 Hz 0.5 ms)^4 = 2e-9
    np.testing.assert_allclose(run["tip"][-1], np.array(data.site("tip").xpos), atol=1e-7)
