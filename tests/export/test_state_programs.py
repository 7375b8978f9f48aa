"""States in an exported program: the same motion as in the engine."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import CC, PLAIN, compiled, expected, table
from jousto.export.project import write_program
from jousto.mechanism import States, StateSensor, rate

pytestmark = pytest.mark.skipif(
    CC is None or sys.platform == "win32", reason="no C compiler to compile the programs with"
)


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("method", ["RK4", "ROS2", "GeneralizedAlpha"])
def test_a_program_has_states(tmp_path: Path, core: str, method: str) -> None:
    """A motor with a stiff winding and a harmonic voltage."""
    wheel = jo.RigidBody("wheel", 1.0, (1e-4, 1e-4, 1e-4))
    axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"], axis=(0, 0, 1))
    winding = States(
        "winding",
        {"i": 0.5},
        {"i": "(u*smooth_step(time/0.01) - i - 0.05*w)/0.5e-3"},
        inputs={"u": jo.Harmonic(frequency=20.0, amplitude=12.0), "w": rate(axle.angle)},
        forces={axle.angle: "0.05*i - 1e-5*absolute(w)*w"},
    )
    sensors = StateSensor("i", winding["i"], unit="A"), jo.RateSensor("w", axle.angle)
    model = jo.compile(jo.Mechanism(wheel, axle, winding, *sensors, core=core))
    solver = getattr(jo, method)(step=2e-4)
    write_program(model, tmp_path / "motor.c", solver)
    found = table(compiled(tmp_path, "motor.c", flags=(*PLAIN, "-DMAIN")), "0.05", "10")
    want = expected(model, jo.simulate(model, 0.05, solver=solver, output_step=5e-3))
    assert np.abs(found - want).max() < 1e-9 * np.abs(want).max()
    assert np.abs(np.diff(want, axis=0)).max() > 0.01
