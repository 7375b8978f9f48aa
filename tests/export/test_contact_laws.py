"""Laws of contact in an exported program: table, cylinders, rolling, smooth friction."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import CC, STEP, expected, rows_of
from jousto.export.program import program
from jousto.mechanism import (
    Contact,
    HalfSpace,
    Impedance,
    JohnsonLine,
    PowerLaw,
    Regularised,
    Sphere,
    StickSlip,
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


def test_points_held_by_rows_in_a_program(tmp_path: Path) -> None:
    """A ball is thrown, slips and rolls: the program has the rows and both coefficients."""
    ball = jo.RigidBody.sphere(
        "ball", radius=0.1, mass=1.0, position=(0, 0, 0.1 - 1e-7), velocity=(1, 0, 0)
    )
    touch = Contact(
        "touch", jo.ground["origin"], HalfSpace(), ball["origin"], Sphere(0.1), PowerLaw(1e8),
        mu_kinetic=0.2, mu_static=0.3, friction=StickSlip(),
    )  # fmt: skip
    v = jo.VelocitySensor("v", ball["origin"])
    model = jo.compile(jo.Mechanism(ball, touch, jo.Gravity((0, 0, -9.81)), v))
    solver = jo.ROS2(1e-3)
    names = {port.name for port in program(model, solver, name="plant").ports.parameters}
    assert {"touch.slip.mu_kinetic", "touch.slip.mu_static"} <= names
    assert not {"touch.mu_kinetic", "touch.mu_static", "touch.slip.mass"} & names
    rows = rows_of(model, solver, tmp_path, "0.3", "10")
    run = jo.simulate(model, 0.3, solver=solver, output_step=0.03)
    np.testing.assert_allclose(rows, expected(model, run), rtol=0, atol=1e-12)
    assert run["v"][-1, 0] == pytest.approx(5 / 7, abs=1e-9)
