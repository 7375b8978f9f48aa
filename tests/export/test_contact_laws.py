"""Laws of contact in an exported program: table, cylinders, rolling, smooth friction."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import CC, STEP, expected, rows_of
from jousto.mechanism import (
    Contact,
    HalfSpace,
    Impedance,
    JohnsonLine,
    Regularised,
    Sphere,
    TableLaw,
)

pytestmark = pytest.mark.skipif(
    CC is None or sys.platform == "win32", reason="no C compiler to compile the programs with"
)


@pytest.mark.filterwarnings("ignore:.*moves freely")
def test_a_program_has_the_laws(tmp_path: Path) -> None:
    """Three balls that fall, bounce, slip, roll and spin, each with a law of its own."""
    balls = [
        jo.RigidBody(
            f"b{i}",
            1.0,
            (0.001,) * 3,
            position=(0.5 * i, 0, 0.055),
            velocity=(0.4, 0.2, 0),
            angular_velocity=(0, 4, 30.0),
        )  # fmt: skip
        for i in range(3)
    ]
    laws = (
        TableLaw([0, 1e-3, 2e-3], [0, 300, 1000], restitution=0.4),
        JohnsonLine(1e8, 0.01, 0.1, restitution=0.4),
        Impedance(5e3, 0.5, 0.9, 2e-3, restitution=0.4),
    )
    more = ({"rolling": 2e-3, "drilling": 4e-3}, {"friction": Regularised(0.05)}, {})
    contacts = [
        Contact(
            f"c{i}",
            jo.ground["origin"],
            HalfSpace(),
            balls[i]["origin"],
            Sphere(0.05),
            laws[i],
            mu_kinetic=0.3,
            **more[i],
        )  # fmt: skip
        for i in range(3)
    ]
    sensors = [jo.AngularVelocitySensor(f"w{i}", one["origin"]) for i, one in enumerate(balls)]
    model = jo.compile(jo.Mechanism(*balls, *contacts, jo.Gravity((0, 0, -9.81)), *sensors))
    solver = jo.RK4(step=STEP)
    found = rows_of(model, solver, tmp_path, "0.4", "10")
    want = expected(model, jo.simulate(model, 0.4, solver=solver, output_step=0.04))
    assert np.abs(found - want).max() < 1e-9
    assert np.ptp(want[:, 3]) > 5.0  # the spin has slowed down
