"""A small flexible pendulum that every test of the folder can run."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo

STEEL = jo.Material(E=2.07e11, nu=0.3, rho=7850)


@pytest.fixture(scope="session")
def rod():
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.02), 4, STEEL, lumped=True)
    return jo.reduce(part, jo.CraigBampton(interfaces=("start",), modes=2))


@pytest.fixture(scope="session")
def pendulum(rod):
    arm = jo.FlexibleBody("arm", rod)
    pivot = jo.Spherical("pivot", jo.ground["origin"], arm["start"])
    return jo.compile(
        jo.Mechanism(
            arm,
            pivot,
            jo.Gravity((0.5, -9.81, 1.0)),
            jo.PositionSensor("tip", arm["end"]),
            jo.ReactionSensor("reaction", pivot),
            name="pendulum",
        )
    )


@pytest.fixture(scope="session")
def highest_frequency(rod):
    return float(np.max(rod.frequencies))
