"""Positions of the nodes of a moving body."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from jousto.recovery.shape import positions, rotation_matrices


@pytest.fixture(scope="module")
def run() -> jo.Solution:
    part = jo.Part.beam(1.0, jo.Circle(0.02), 4, jo.Material(2.5e9, 0.4, 1140.0))
    rod = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4)).keep(range(4))
    arm = jo.FlexibleBody("arm", rod, orientation=jo.Rotate((1, 2, 3), degrees=40.0))
    ball = jo.RigidBody("ball", 0.2, (1e-3, 1e-3, 2e-3), position=arm["end"].r)
    model = jo.compile(
        jo.Mechanism(
            arm,
            ball,
            jo.Spherical("pivot", jo.ground["origin"], arm["start"]),
            jo.Spherical("hook", arm["end"], ball["origin"]),
            jo.Gravity((0, 0, -9.81)),
            *(jo.PositionSensor(f"node{k}", arm[f"node{k}"]) for k in range(1, 6)),
            jo.PositionSensor("ball", ball["origin"]),
        )
    )
    return jo.simulate(model, 0.3, solver=jo.RK4(1e-3), output_step=0.01)


def test_rotation_matrices(rng: np.random.Generator) -> None:
    e = rng.normal(size=(7, 2, 4))
    flat = e.reshape(-1, 4)
    expected = Rotation.from_quat(flat[:, [1, 2, 3, 0]]).as_matrix()
    np.testing.assert_allclose(rotation_matrices(e).reshape(-1, 3, 3), expected, atol=1e-14)


def test_positions_are_those_the_engine_measures(run: jo.Solution) -> None:
    x = positions(run, "arm")
    assert x.shape == (31, 5, 3)
    for k in range(5):
        np.testing.assert_allclose(x[:, k], run[f"node{k + 1}"], atol=1e-14)
    # the rigid body's star begins at its centre of mass
    np.testing.assert_allclose(positions(run, "ball")[:, 0], run["ball"], atol=1e-14)


def test_interpolation_and_its_ends(run: jo.Solution) -> None:
    x = positions(run, "arm")
    at = positions(run, run.bodies[0], [0.0, 0.025, 0.3])
    np.testing.assert_allclose(at, [x[0], 0.5 * (x[2] + x[3]), x[-1]], atol=1e-14)


def test_scale_moves_along_the_deformation(run: jo.Solution) -> None:
    x0, x1, x3 = (positions(run, "arm", scale=s) for s in (0.0, 1.0, 3.0))
    np.testing.assert_allclose(x3 - x0, 3.0 * (x1 - x0), atol=1e-14)
    # without deformation distances stay
    lengths = np.linalg.norm(np.diff(x0, axis=1), axis=2)
    np.testing.assert_allclose(lengths, 0.25, atol=1e-14)
    assert np.abs(x1 - x0).max() > 1e-4


@pytest.mark.parametrize("times", [[0.31], [-0.01], [np.nan]])
def test_times_outside_the_run(run: jo.Solution, times: list[float]) -> None:
    with pytest.raises(jo.InputError, match="outside the run of 0 to 0.3 s"):
        positions(run, "arm", times)


def test_unknown_body(run: jo.Solution) -> None:
    with pytest.raises(jo.InputError, match="no body 'arn'; did you mean 'arm'"):
        positions(run, "arn")
