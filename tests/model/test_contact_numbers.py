"""Contact beside closed forms: bounces, ramps, waves in a bar."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import (
    Contact,
    Cuboid,
    HalfSpace,
    PowerLaw,
    Sphere,
    SpringDamper,
)

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely")
G = 9.81


def dropped(law: Any, gap: float, speed: float, mass: float, solver: Any, t: float) -> Any:
    r = 0.05
    ball = jo.RigidBody.sphere(
        "ball", radius=r, mass=mass, position=(0, 0, r + gap), velocity=(0, 0, -speed)
    )
    touch = Contact("c", jo.ground["origin"], HalfSpace(), ball["origin"], Sphere(r), law)
    place, v = jo.PositionSensor("z", ball["origin"]), jo.VelocitySensor("v", ball["origin"])
    items = [ball, touch, place, v] + ([jo.Gravity((0, 0, -G))] if speed == 0 else [])
    return jo.simulate(jo.compile(jo.Mechanism(*items)), t, solver=solver)


def test_force_and_duration_of_hunt_and_crossley() -> None:
    """1 kg, 1e8 N/m^1.5, 2 m/s, e = 0.5; the same damping at 0.5 m/s."""
    law = PowerLaw(1e8, restitution=0.5)
    (event,) = dropped(law, 1e-3, 2.0, 1.0, jo.RK4(1e-6), 3e-3).contacts
    assert event.force == pytest.approx(3870.048778, rel=1e-5)
    assert event.depth == pytest.approx(9.315715552e-4, rel=1e-5)
    assert event.part - event.touch == pytest.approx(1.979364737e-3, rel=1e-6)
    fixed = PowerLaw(1e8, restitution=0.5, slowest=2.0)
    run = dropped(fixed, 1e-4, 0.5, 1.0, jo.RK4(1e-6), 5e-3)
    assert run["v"][-1, 2] / 0.5 == pytest.approx(0.8065208766, rel=1e-6)


def test_a_bounce_from_one_metre() -> None:
    """0.1 kg, 1e7 N/m^1.5, e = 0.8: the second touch and the top between, with 20 steps a touch."""
    run = dropped(PowerLaw(1e7, restitution=0.8), 1.0, 0.0, 0.1, jo.RK4(2e-5), 1.2)
    _, second = run.contacts
    assert second.touch == pytest.approx(1.175044961, abs=1e-6)
    between = (run.time > 0.5) & (run.time < 1.1)
    assert run["z"][between, 2].max() - 0.05 == pytest.approx(0.6391742777, abs=1e-6)


@pytest.mark.filterwarnings("ignore:.*energy balance")
@pytest.mark.parametrize("count", [60, pytest.param(1000, marks=pytest.mark.slow)])
def test_elastic_bounces_keep_their_apex(count: int) -> None:
    """Bounces of a point on a spring k from h = 1 mm: each apex is h, at multiples of their period.

    ``2 v / g + (pi + 2 atan(g / (w v))) / w``, v^2 = 2 g h, w^2 = k / m: a flight, and a touch
    about the depth of rest.
    """
    h, w = 1e-3, 1e3  # of 1 kg, 1e6 N/m
    v = np.sqrt(2 * G * h)
    period = 2 * v / G + (np.pi + 2 * np.arctan(G / (w * v))) / w
    body = jo.RigidBody("b", 1.0, (1e-3,) * 3, position=(0, 0, h))
    law = PowerLaw(w**2, 1.0, restitution=1.0)
    touch = Contact("c", jo.ground["origin"], HalfSpace(), body["origin"], Sphere(0.0), law)
    z = jo.PositionSensor("z", body["origin"])
    model = jo.compile(jo.Mechanism(body, touch, z, jo.Gravity((0, 0, -G))))
    solver = jo.simulation.DormandPrince(tolerance=1e-11)
    run = jo.simulate(model, count * period, solver=solver, output_step=period)
    assert len(run.contacts) == count
    assert run["z"][:, 2] == pytest.approx(np.full(count + 1, h), rel=1e-6)
    energy = run.energy.kinetic + run.energy.potential + run.energy.springs
    assert energy.max() <= energy[0] * (1 + 1e-12)


def test_a_stiff_shot_has_the_depth_of_its_energy() -> None:
    """10 g at 100 m/s on a free plate of 1 kg, 1e9 N/m^1.5, elastic, step 1 ms."""
    shot = jo.RigidBody.sphere(
        "shot", radius=5e-3, mass=0.01, position=(0.237, 0, 0), velocity=(-100, 0, 0)
    )
    plate = jo.RigidBody("plate", 1.0, (0.1,) * 3)
    law = PowerLaw(1e9, restitution=1.0)
    hit = Contact(
        *("hit", plate["origin"], Cuboid((2e-3, 1, 1)), shot["origin"], Sphere(5e-3)), law
    )
    run = jo.simulate(jo.compile(jo.Mechanism(shot, plate, hit)), 0.01, solver=jo.RK4(1e-3))
    (event,) = run.contacts
    assert event.depth == pytest.approx(1.725978794705e-3, rel=2e-3)
    assert run.attributes["contacts"].startswith("missed: 0")


def test_a_block_stops_on_its_ramp_at_an_instant() -> None:
    """15 degrees, mu = 0.4 / 0.3, 3 m/s up: 0.557441096 s."""
    a = np.radians(15)
    block = jo.RigidBody("block", 1.0, (0.01,) * 3, position=(0, 0, 0.05), velocity=(3, 0, 0))
    touch = Contact(
        *("touch", jo.ground["origin"], HalfSpace(), block["origin"], Cuboid((0.4, 0.4, 0.1))),
        PowerLaw(1e8, 1.0),
        mu_kinetic=0.3,
        mu_static=0.4,
    )
    v = jo.VelocitySensor("v", block["origin"])
    stands = jo.mechanism.Event("stands", v, 0.0, "falling", component="x")
    ramp = jo.Gravity((-G * np.sin(a), 0, -G * np.cos(a)))
    model = jo.compile(jo.Mechanism(block, touch, ramp, v, stands))
    run = jo.simulate(model, 0.6, solver=jo.GeneralizedAlpha(1e-4))
    first = next(event for event in run.events if event.name == "stands")
    assert first.time == pytest.approx(0.5574410960, abs=2e-5)


@pytest.mark.parametrize(("k", "duration", "back"), [(2e7, 7.180615365e-4, 0.9755545884)])
def test_a_bar_strikes_a_spring(k: float, duration: float, back: float) -> None:
    """Waves in a steel bar of 1 m and 1 cm2 at 1 m/s on a massless spring."""
    side, rho = 0.01, 7850.0
    steel = jo.Material(E=210e9, nu=0.3, rho=rho)
    section, ends = jo.Rectangle(side, side), [(0, 0, 0), (0, 0, 1)]
    bar = jo.BeamBody("bar", ends, section, steel, elements=60, velocity=(0, 0, -1))
    touch = Contact(
        *("touch", jo.ground["origin"], HalfSpace(), bar["start"], Sphere(0.0)),
        SpringDamper(k, 0.0),
    )
    run = jo.simulate(jo.compile(jo.Mechanism(bar, touch)), 1e-3, solver=jo.RK4(5e-7))
    (event,) = run.contacts
    assert event.part - event.touch == pytest.approx(duration, rel=2e-3)
    # momentum before and after: the impulse
    mass = rho * side**2
    assert event.impulse == pytest.approx(mass * (1 + back), rel=2e-3)
