"""Sines and cosines of hinge angles, which the engine works out several at a time."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.model.native.native import Engine

ANGLES = np.concatenate(
    [
        [0.0, -0.0, 1e-300, 1e-9],
        0.25 * np.pi * np.arange(-9, 10),  # where polynomials and quadrants change
        0.25 * np.pi * np.arange(-9, 10) * (1.0 + 1e-15),
        np.random.default_rng(1).uniform(-10.0, 10.0, 101),
        np.random.default_rng(2).uniform(-3e4, 3e4, 101),
        np.random.default_rng(3).uniform(-1e9, 1e9, 21),  # of the library
    ]
)


@pytest.mark.parametrize("gravity", [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])
def test_pendulums_at_all_angles(gravity: tuple[float, float, float]) -> None:
    # inertia 1 + 1 about the hinge: 2 q'' = gy cos q - gx sin q; a rounding of the sine, of the
    # product and of the quotient each, of numbers up to 1: 2^-53 times 4 at most
    bodies = [jo.RigidBody(f"p{k}", 1.0, (1, 1, 1), center=(1, 0, 0)) for k in range(len(ANGLES))]
    joints = [
        jo.Revolute(f"j{k}", jo.ground.at((0, 0, 0)), body.at((0, 0, 0)), (0, 0, 1))
        for k, body in enumerate(bodies)
    ]
    model = jo.compile(jo.Mechanism(*bodies, *joints, jo.Gravity(gravity)), core="joint")
    engine = Engine(model)
    half = 0.5 * np.remainder(ANGLES, 2.0 * np.pi)
    engine.q[3::7], engine.q[6::7] = np.cos(half), np.sin(half)
    engine.joint[: len(ANGLES)] = ANGLES  # so many turns on
    a, _ = engine.tree_accelerations()
    x = engine.joint[: len(ANGLES)].astype(np.longdouble)
    assert np.abs(x - ANGLES).max() < 1e-6  # of 1e9, elsewhere less
    expected = 0.5 * (gravity[1] * np.cos(x) - gravity[0] * np.sin(x))
    assert np.abs(a[5::6] - expected).max() < 4.0 * 2.0**-53
