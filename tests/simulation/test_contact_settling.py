"""Warnings of the energy balance: none of machines that only settle on their contacts."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import Contact, Cuboid, HalfSpace, PowerLaw, Sphere

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely")
G, FLOOR = 9.81, jo.ground["origin"]
METHODS = [jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)]


def named(solver: Any) -> str:
    return type(solver).__name__


@pytest.mark.parametrize("solver", METHODS, ids=named)
@pytest.mark.parametrize("K", [1e7, 1e9])
def test_a_block_that_settles_on_a_slope_is_quiet(solver, K):
    """Its bristles stretch by F / k; the exchange of 1e-7 J is no motion of a block of 1 kg."""
    block = jo.RigidBody("block", 1.0, (0.01, 0.012, 0.015), position=(0, 0, 0.05 - G / 4 / K))
    law = PowerLaw(K, 1.0)
    touch = Contact(
        "touch", FLOOR, HalfSpace(), block["origin"], Cuboid((0.4, 0.3, 0.1)), law, mu_kinetic=0.3
    )
    model = jo.compile(jo.Mechanism(block, touch, jo.Gravity((1, 0, -G))))
    run = jo.simulate(model, 0.2, solver=solver)  # a warning is an error here
    assert run.energy.kinetic.max() < 1e-9


def test_a_ball_under_a_force_settles_quietly():
    """Without gravity the scale is what the contact stores."""
    K, F = 1e9, 100.0
    depth = (F / K) ** (2 / 3) * (1 + 1e-4)
    ball = jo.RigidBody.sphere("ball", radius=0.1, mass=1.0, position=(0, 0, 0.1 - depth))
    touch = Contact("touch", FLOOR, HalfSpace(), ball["origin"], Sphere(0.1), PowerLaw(K))
    push = jo.Force("push", ball["origin"], (0, 0, -F))
    run = jo.simulate(jo.compile(jo.Mechanism(ball, touch, push)), 0.2, solver=jo.ROS2(1e-3))
    assert np.abs(run.energy.error).max() > 0.0


def test_a_bounce_in_few_steps_is_warned_of():
    ball = jo.RigidBody.sphere("ball", radius=0.05, mass=1.0, position=(0, 0, 0.2))
    law = PowerLaw(1e6, 1.0, restitution=0.2)
    touch = Contact(
        "touch", FLOOR, HalfSpace(), ball["origin"], Sphere(0.05), law, resolve="report"
    )
    model = jo.compile(jo.Mechanism(ball, touch, jo.Gravity((0, 0, -G))))
    with pytest.warns(jo.JoustoWarning, match="energy balance"):
        jo.simulate(model, 0.3, solver=jo.ROS2(1e-3))
