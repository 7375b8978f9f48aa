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
    # every mode moves a little, so that an unstable one can grow
    arm = jo.FlexibleBody("arm", rod, modal_velocities=np.full(rod.n, 1e-3))
    pivot = jo.Spherical("pivot", jo.ground["origin"], arm["start"])
    mechanism = jo.Mechanism(
        arm,
        pivot,
        jo.Gravity((0.5, -9.81, 1.0)),
        jo.PositionSensor("tip", arm["end"]),
        jo.ReactionSensor("reaction", pivot),
        name="pendulum",
    )
    with pytest.warns(jo.JoustoWarning, match="velocities of 'arm' contradict the joints"):
        return jo.compile(mechanism)


@pytest.fixture(scope="session")
def highest_frequency(rod):
    return float(np.max(rod.frequencies))
