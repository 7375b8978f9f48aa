"""Force laws with kinks: implicit methods leap from one branch to the other and must not stop."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo

MASS, SPEED, FORCE, STEP = 1.0, 0.3, 5.0, 1e-3
STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
DIAMETER, LENGTH = 1e-3, 0.1
BEAM_MASS = STEEL.rho * np.pi / 4 * DIAMETER**2 * LENGTH


def sled(slope: float, beam: str = "none", sleds: int = 1) -> jo.Model:
    """Sleds of 1 kg at 0.3 m/s, each braked by 5 N in full from 5 N / slope on, as dry friction is.

    A thin exact beam stands beside them or rides along, in the direction of the motion.
    """
    saturated = FORCE / slope
    law = jo.Table((-10.0, -saturated, saturated, 10.0), (FORCE, FORCE, -FORCE, -FORCE))
    items: list[Any] = []
    for i in range(sleds):
        body = jo.RigidBody(
            f"sled{i}", MASS, (1, 1, 1), position=(0, i, 0), velocity=(SPEED * (1 + i), 0, 0)
        )
        rail = jo.ground.at((0, i, 0))
        slide = jo.Prismatic(f"slide{i}", rail, body["origin"], axis=(1, 0, 0))
        brake = jo.Spring(f"brake{i}", slide.displacement, damper_table=law)
        items += [body, slide, brake, jo.PositionSensor(f"place{i}", body["origin"])]
    if beam != "none":
        holder = jo.ground if beam == "ground" else items[0]
        speed = 0.0 if beam == "ground" else SPEED
        wire = jo.BeamBody(
            "wire",
            [[0, 0, 0], [LENGTH, 0, 0]],
            jo.Circle(DIAMETER),
            STEEL,
            elements=4,
            velocity=(speed, 0, 0),
        )
        items += [wire, jo.Fixed("held", holder["origin"], wire["start"])]
    return jo.compile(jo.Mechanism(*items))


def path(slope: float, mass: float = MASS, speed: float = SPEED) -> float:
    """Way to rest in m: m v' = -5 N down to the speed of the kink, then exponential decay."""
    kink = FORCE / slope
    return mass * (speed**2 - kink**2) / (2.0 * FORCE) + mass * kink / slope


# the brake ends somewhere within a step: the speed is uncertain by F h / m, over that step
TOLERANCE = FORCE * STEP**2 / MASS


@pytest.mark.parametrize("slope", [1e3, 1e4, 1e5, 1e7])
@pytest.mark.parametrize(
    "solver",
    [
        jo.GeneralizedAlpha(step=STEP),
        jo.GeneralizedAlpha(step=STEP, tangent="exact", rho=1.0),
        jo.GeneralizedAlpha(step=STEP, projection=False),
        jo.simulation.Newmark(step=STEP),
    ],
    ids=["alpha", "exact", "index 3", "newmark"],
)
def test_a_brake_that_saturates(
    solver: jo.GeneralizedAlpha | jo.simulation.Newmark, slope: float
) -> None:
    run = jo.simulate(sled(slope), 0.2, solver=solver)
    assert abs(run["place0"][-1, 0] - path(slope)) < TOLERANCE


@pytest.mark.parametrize("slope", [1e3, 1e4, 1e5])
@pytest.mark.parametrize("beam", ["ground", "sled"])
def test_the_default_with_an_exact_beam_aboard(beam: str, slope: float) -> None:
    run = jo.simulate(sled(slope, beam), 0.2, output_step=STEP)
    mass = MASS + (BEAM_MASS if beam == "sled" else 0.0)
    assert abs(run["place0"][-1, 0] - path(slope, mass)) < TOLERANCE


def test_several_that_reach_their_kinks_at_different_times() -> None:
    """Sleds on rails of their own: each ends where it would alone."""
    run = jo.simulate(sled(1e5, sleds=4), 0.4, solver=jo.GeneralizedAlpha(step=STEP))
    for i in range(4):
        wanted = path(1e5, speed=SPEED * (1 + i))
        assert abs(run[f"place{i}"][-1, 0] - wanted) < TOLERANCE
