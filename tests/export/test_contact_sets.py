"""A set of contacts in an exported program: pairs are found in the program as in the engine."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import CC, STEP, expected, rows_of
from jousto.mechanism import CollisionShape, Contacts, HalfSpace, PowerLaw, Sphere

pytestmark = pytest.mark.skipif(
    CC is None or sys.platform == "win32", reason="no C compiler to compile the programs with"
)


@pytest.mark.filterwarnings("ignore:.*moves freely")
def test_a_program_finds_the_pairs(tmp_path: Path) -> None:
    """Balls on the floor and on one another: 1e-9, since each touch enlarges the round-off."""
    r = 0.05
    balls = [
        jo.RigidBody.sphere(f"b{i}", radius=r, mass=1.0, position=(0.02 * i, 0, 0.3 + 0.11 * i))
        for i in range(3)
    ]
    shapes = [CollisionShape(one.name, one["origin"], Sphere(r)) for one in balls]
    floor = CollisionShape("floor", jo.ground["origin"], HalfSpace())
    law = PowerLaw(1e6, restitution=0.7)
    touch = Contacts("c", [floor, *shapes], law=law, mu_kinetic=0.3)
    places = [jo.PositionSensor(f"p{i}", one["origin"]) for i, one in enumerate(balls)]
    model = jo.compile(jo.Mechanism(*balls, touch, jo.Gravity((0, 0, -9.81)), *places))
    solver = jo.RK4(step=STEP)
    found = rows_of(model, solver, tmp_path, "0.4", "10")
    want = expected(model, jo.simulate(model, 0.4, solver=solver, output_step=0.04))
    assert np.abs(found - want).max() < 1e-9
    assert np.abs(want[:, 1]).max() > 0.05  # the balls have touched
