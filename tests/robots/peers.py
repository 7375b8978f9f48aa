"""Robots beside MuJoCo: the same motion of the same file."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.robots import Robot, Tree, mechanism, read_mjcf

STEP = 1e-4  # s, of MuJoCo's Runge-Kutta method; the package's own of the same order takes 0.5 ms


def write(folder: Path, text: str, name: str = "model.xml") -> Path:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path


def read(path: Path, **options: Any) -> Robot:
    """Return a robot without its warnings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        return read_mjcf(path, **options)


def told(path: Path, **options: Any) -> str:
    """Return the warnings about a file."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        read_mjcf(path, **options)
    return "\n".join(str(one.message) for one in found)


def refusal(path: Path, **options: Any) -> str:
    """Return why a file is refused."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        with pytest.raises(jo.InputError) as error:
            read_mjcf(path, **options)
    return str(error.value)


def peer(path: Path) -> Any:
    """Return MuJoCo's model of a file."""
    mujoco = pytest.importorskip("mujoco")
    here = Path.cwd()
    os.chdir(path.parent)  # it leaves a log in the working folder
    try:
        return mujoco.MjModel.from_xml_path(str(path))
    finally:
        os.chdir(here)


def near(found: Any, wanted: Any, share: float) -> None:
    np.testing.assert_allclose(found, wanted, rtol=0, atol=share * np.abs(wanted).max())


def same_tree(path: Path, seed: int = 0, share: float = 1e-12) -> Robot:
    """Compare positions at the start, mass matrix and bias forces; return the robot."""
    mujoco = pytest.importorskip("mujoco")
    robot, model = read(path), peer(path)
    data, tree = mujoco.MjData(model), Tree(robot)
    assert (tree.nq, tree.nv) == (model.nq, model.nv)
    near(tree.initial, np.array(model.qpos0), 1e-14)
    rng = np.random.default_rng(seed)
    for _ in range(3):
        q, v = tree.moved(tree.initial, rng.normal(size=tree.nv)), rng.normal(size=tree.nv)
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_forward(model, data)
        M = np.zeros((model.nv, model.nv))
        for row, unit in zip(M, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, data, row, unit)
        near(tree.mass_matrix(q), M, share)
        near(tree.bias_forces(q, v), np.array(data.qfrc_bias), share)
        for link in robot.links[1:]:
            if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, link.name) >= 0:
                near(tree.pose(link.name, q).r, np.array(data.body(link.name).xpos), 1e-12)
    return robot


def same_motion(
    path: Path,
    t_end: float,
    *,
    joints: tuple[str, ...],
    share: float,
    controls: Mapping[str, float] | None = None,
    at: Mapping[str, float] | None = None,
) -> None:
    """Compare joints after a time, the largest difference by the largest travel of a joint."""
    mujoco = pytest.importorskip("mujoco")
    model = peer(path)
    model.opt.timestep, model.opt.integrator = STEP, mujoco.mjtIntegrator.mjINT_RK4
    data = mujoco.MjData(model)
    for name, value in (at or {}).items():
        data.joint(name).qpos[0] = value
    for name, value in (controls or {}).items():
        data.actuator(name).ctrl[0] = value
    for _ in range(round(t_end / STEP)):
        mujoco.mj_step(model, data)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        machine = jo.compile(mechanism(read_mjcf(path), at=at, stops=False))
        run = jo.simulate(machine, t_end, solver=jo.RK4(5 * STEP), inputs=dict(controls or {}))
    found = np.array([run[name][-1, 0] for name in joints])
    wanted = np.array([data.joint(name).qpos[0] for name in joints])
    travel = np.array([np.ptp(run[name][:, 0]) for name in joints])
    assert travel.max() > 1e-3  # something moves
    error = np.abs(found - wanted).max() / travel.max()
    assert error < share, f"{error:.2e} of the travel"
