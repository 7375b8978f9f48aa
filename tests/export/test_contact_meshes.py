"""Contact with a surface of triangles in an exported program."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import CC, STEP, expected, rows_of
from jousto.mechanism import Contact, HeightField, PowerLaw, Sphere

pytestmark = pytest.mark.skipif(
    CC is None or sys.platform == "win32", reason="no C compiler to compile the programs with"
)


@pytest.mark.filterwarnings("ignore:.*moves freely")
def test_a_program_follows_the_triangles(tmp_path: Path) -> None:
    """A ball on hills: 1e-9, since each touch enlarges the round-off."""
    r = 0.05
    ball = jo.RigidBody.sphere("b", radius=r, mass=1.0, position=(0, 0, 0.2), velocity=(1, 0.3, 0))
    hills = HeightField(0.05 * np.random.default_rng(1).uniform(size=(9, 9)), 2.0, 2.0)
    law = PowerLaw(1e6, restitution=0.7)
    touch = Contact("c", jo.ground["origin"], hills, ball["origin"], Sphere(r), law, mu_kinetic=0.3)
    place = jo.PositionSensor("p", ball["origin"])
    model = jo.compile(jo.Mechanism(ball, touch, jo.Gravity((0, 0, -9.81)), place))
    solver = jo.RK4(step=STEP)
    found = rows_of(model, solver, tmp_path, "0.4", "10")
    want = expected(model, jo.simulate(model, 0.4, solver=solver, output_step=0.04))
    assert np.abs(found - want).max() < 1e-9
    assert np.abs(np.diff(want[:, -1])).max() > 0.01
