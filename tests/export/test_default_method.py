"""A program without a named method takes steps with which its machine runs, as `simulate` does."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import CC, rows_of

pytestmark = pytest.mark.skipif(
    CC is None or sys.platform == "win32", reason="no C compiler to compile the programs with"
)


def braked_swing() -> jo.Model:
    """A bar of steel with a load at its end; its damper is fast beside a step of 1 ms."""
    steel = jo.Material(E=210e9, nu=0.3, rho=7850)
    part = jo.Part.beam(2.0, jo.Rectangle(width=0.04, height=0.02), 8, steel)
    bar = jo.FlexibleBody(
        "bar", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4)), damping=0.01
    )
    load = jo.RigidBody.sphere("load", 0.05, mass=25.0, position=(2.0, 0, 0))
    pin = jo.Revolute("pin", jo.ground["origin"], bar["start"], axis=(0, 1, 0))
    return jo.compile(
        jo.Mechanism(
            *(
                bar,
                load,
                pin,
                jo.Fixed("hold", bar["end"], load["center"]),
                jo.Spring("damper", pin.angle, damping=200.0),
            ),
            jo.Gravity((0, 0, -9.81)),
            jo.CoordinateSensor("angle", pin.angle),
        )
    )


def test_a_damper_that_is_fast_for_a_millisecond(tmp_path: Path):
    model = braked_swing()
    # the reference chooses its own steps by its errors
    exact = jo.simulate(model, 0.5, solver=jo.simulation.DormandPrince(tolerance=1e-9, output=0.1))
    rows = rows_of(model, None, tmp_path, "0.5", "5")
    np.testing.assert_allclose(rows[:, 1], exact["angle"][:, 0], rtol=0, atol=1e-3)
