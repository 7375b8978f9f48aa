"""Contacts with little or no restitution: a touch that ends the approach, with all its energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import Contact, HalfSpace, Hertz, PowerLaw, Sphere, Surface
from jousto.mechanism.contacts.laws import SOFTEST, damping_of

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely")
R, V, MASSES = 0.05, 2.0, (1.0, 0.3)
METHODS = {
    "RK4": jo.RK4(1e-3),
    "ROS2": jo.ROS2(1e-3),
    "GeneralizedAlpha": jo.GeneralizedAlpha(1e-3),
    "DormandPrince": jo.simulation.DormandPrince(tolerance=1e-8),
}


def hit(law: Any, solver: Any, resolve: str = "cut") -> Any:
    """Two free balls, the lighter one at 2 m/s towards the other one, which is at rest."""
    balls = [
        jo.RigidBody.sphere(name, radius=R, mass=mass, position=(x, 0, 0), velocity=(v, 0, 0))
        for name, mass, x, v in zip("ab", MASSES, (0, 2 * R + 0.01 * V), (0, -V), strict=True)
    ]
    touch = Contact(
        "hit", balls[0]["origin"], Sphere(R), balls[1]["origin"], Sphere(R), law, resolve=resolve
    )
    speeds = [jo.VelocitySensor(f"v{ball.name}", ball["origin"]) for ball in balls]
    return jo.simulate(jo.compile(jo.Mechanism(*balls, touch, *speeds)), 0.05, solver=solver)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("e", "n", "K"), [(0.01, 1.0, 1e6), (0.03, 1.5, 1e8), (0.0, 3.0, 1e13)])
def test_both_go_on_together(method, e, n, K):
    """v+ = (m1 v1 + m2 v2 -+ e m v) / (m1 + m2); the energy of the approach is lost, and booked."""
    run = hit(PowerLaw(K, n, restitution=e), METHODS[method])
    apart = run["va"][-1, 0] - run["vb"][-1, 0]
    assert -apart / V == pytest.approx(max(e, SOFTEST), abs=1e-4)
    mass = MASSES[0] * MASSES[1] / sum(MASSES)
    lost = 0.5 * mass * V**2
    assert run.energy.dissipated[-1] == pytest.approx(lost, rel=1e-3 + 4e-3 * ("R" in method))
    assert np.diff(run.energy.total).max() < 1e-12 * lost
    assert run.contacts.findings == ()


@pytest.mark.parametrize("method", METHODS)
def test_an_impulse_has_no_rebound_at_all(method):
    run = hit(PowerLaw(1e8, restitution=0.0), METHODS[method], "impulse")
    together = -V * MASSES[1] / sum(MASSES)
    assert run["va"][-1, 0] == pytest.approx(together, rel=1e-11)
    assert run["vb"][-1, 0] == pytest.approx(together, rel=1e-11)


@pytest.mark.parametrize("resolve", ["cut", "impulse"])
def test_a_ball_stays_where_it_falls(resolve):
    ball = jo.RigidBody.sphere("ball", radius=R, mass=1.0, position=(0, 0, 0.15))
    law, floor = PowerLaw(1e8, restitution=0.0), jo.ground["origin"]
    touch = Contact("c", floor, HalfSpace(), ball["origin"], Sphere(R), law, resolve=resolve)
    height = jo.PositionSensor("z", ball["origin"])
    model = jo.compile(jo.Mechanism(ball, touch, height, jo.Gravity((0, 0, -9.81))))
    z = jo.simulate(model, 0.5, solver=jo.ROS2(1e-3))["z"][:, 2]
    after = z[int(np.argmin(z)) :]
    assert after.max() - R < (SOFTEST * np.sqrt(2 * 9.81 * 0.1)) ** 2 / (2 * 9.81)
    assert after[-1] - R == pytest.approx(-((9.81 / 1e8) ** (2 / 3)), rel=1e-6)


def test_laws_and_surfaces_take_it():
    assert PowerLaw(1e6, restitution=0.0).damping == damping_of(SOFTEST)
    clay = Surface("clay", 1e7, restitution=0.0)
    law = clay.law_with(Surface("steel", 210e9, restitution=0.8))
    assert isinstance(law, Hertz) and law.restitution == 0.0
    with pytest.raises(jo.InputError, match="restitution"):
        PowerLaw(1e6, restitution=-0.1)
