"""A steep damper table: what an explicit step makes of it, and that the user is told."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import jousto as jo

MASS, RUB = 2.0, 30.0
SLOPE = RUB / 1e-4  # N s/m: dry friction of 30 N, smoothed over 0.1 mm/s


def brake() -> jo.Model:
    """A sled of 2 kg, pulled with 50 N for 20 ms, that a table of the speed brakes with 30 N."""
    sled = jo.RigidBody("sled", mass=MASS, inertia=(1, 1, 1))
    slide = jo.Prismatic("slide", jo.ground["origin"], sled["origin"], axis=(1, 0, 0))
    table = jo.Table((-10.0, -1e-4, 1e-4, 10.0), (RUB, RUB, -RUB, -RUB))
    return jo.compile(
        jo.Mechanism(
            sled,
            slide,
            jo.Spring("brake", slide.displacement, damper_table=table),
            jo.JointForce(
                "pull", slide.displacement, jo.Table((0, 0.02, 0.021, 9), (50, 50, 0, 0))
            ),
            jo.RateSensor("speed", slide.displacement),
        )
    )


@pytest.mark.filterwarnings("ignore:.*error of the energy balance")
@pytest.mark.parametrize("solver", [jo.RK4(step=1e-3), jo.ROS2(step=1e-3)], ids=["RK4", "ROS2"])
def test_a_step_that_cannot_follow_the_table_is_told(solver: jo.RK4 | jo.ROS2) -> None:
    # explicit methods of order 2 and 4 bear z = rate * step up to 2 and 2.7853 (Hairer and Wanner,
    # Solving ODEs II, IV.2)
    limit = (2.7853 if isinstance(solver, jo.RK4) else 2.0) * MASS / SLOPE
    with pytest.warns(jo.JoustoWarning, match=r"damper_table of 'brake'.*1\.5e\+05 1/s") as said:
        run = jo.simulate(brake(), 0.1, solver=solver)
    (message,) = [str(w.message) for w in said if "damper_table" in str(w.message)]
    told = float(message.split("a step below ")[1].split(" s")[0])
    # shortened by tenths until it holds, and printed with two digits
    assert 0.85 * limit < told <= 1.01 * limit
    assert "smaller step" in message and "StickSlip" in message
    # and it does chatter: at rest since (50 - 30) 0.02 / 30 s after the pull
    assert np.abs(run["speed"][-20:]).max() > 1e-3


def test_a_step_that_follows_it_is_left_alone() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = jo.simulate(brake(), 0.1, solver=jo.RK4(step=1e-5))
    # the residual speed falls with the rate of 1.5e5 1/s
    assert np.abs(run["speed"][-20:]).max() < 1e-6
