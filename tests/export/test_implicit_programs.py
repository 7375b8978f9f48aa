"""Exported programs with an implicit method read what the equations of motion give at their states.

Rows of `simulate` keep the accelerations and multipliers of the method's steps, which hold the
constraints and miss the equations by the error of a step: of order 2 for generalised alpha (Arnold
and Bruels, Multibody System Dynamics 18, 2007). The tolerance of Newton's method has no part in it.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import CC, STEP, expected, rows_of
from jousto.simulation.state import put

pytestmark = pytest.mark.skipif(
    CC is None or sys.platform == "win32", reason="no C compiler to compile the programs with"
)


@pytest.fixture(scope="module")
def model() -> jo.Model:
    """A flexible arm that swings, and what its pin and its tip feel."""
    steel = jo.Material(E=210e9, nu=0.3, rho=7850)
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.025), 4, steel)
    arm = jo.FlexibleBody("arm", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=3)))
    ball = jo.RigidBody.sphere("ball", 0.05, mass=2.0, position=(1.0, 0, 0))
    pin = jo.Revolute("pin", jo.ground["origin"], arm["start"], axis=(0, 1, 0))
    return jo.compile(
        jo.Mechanism(
            *(arm, ball, pin, jo.Fixed("hold", arm["end"], ball["center"])),
            jo.JointForce("drive", pin.angle, jo.Input("push", 1.5)),
            jo.Gravity((0, 0, -9.81)),
            jo.PositionSensor("tip", ball["center"]),
            jo.AccelerationSensor("felt", ball["center"]),
            jo.ReactionSensor("bearing", pin),
        )
    )


def evaluated(model: jo.Model, run: jo.Solution) -> np.ndarray:
    """Return time and sensors by the equations of motion at the states of a run."""
    rows = []
    for t in run.time:
        engine = jo.model.Engine(model)
        put(engine, run.state(float(t)), "test")
        engine.row()
        rows.append([t, *engine.sensors()])
    return np.array(rows)


@pytest.mark.parametrize("tolerance", [pytest.param(1e-8, marks=pytest.mark.slow), 1e-12])
@pytest.mark.parametrize("tangent", ["modified", "exact"])
def test_a_program_moves_as_the_run_and_reads_its_states(
    model: jo.Model, tangent: str, tolerance: float, tmp_path: Path
) -> None:
    solver = jo.GeneralizedAlpha(STEP, tangent=tangent, tolerance=tolerance)
    found = rows_of(model, solver, tmp_path, "0.1", "5")
    run = jo.simulate(model, 0.1, solver=solver, output_step=0.02)
    want = evaluated(model, run)
    scale = np.maximum(np.abs(want).max(axis=0), 1e-3)  # what vanishes in the plane
    # rounding of other kernels, times the stiffness of the highest mode in accelerations
    assert (np.abs(found - want) <= 1e-9 * scale).all()


def test_accelerations_of_the_steps_come_to_those_with_the_second_order(model: jo.Model) -> None:
    """At any tolerance of Newton's method."""
    missed = []
    for step in (4e-5, 2e-5):  # the highest mode is resolved
        runs = [
            jo.simulate(
                model,
                0.02,
                solver=jo.GeneralizedAlpha(step, tolerance=tolerance),
                output_step=0.002,
            )
            for tolerance in (1e-8, 1e-12)
        ]
        off = [np.abs(evaluated(model, run) - expected(model, run)).max() for run in runs]
        assert off[0] == pytest.approx(off[1], rel=0.05)
        missed.append(off[1])
    assert np.log2(missed[0] / missed[1]) == pytest.approx(2.0, abs=0.3)
