"""Derivatives of machines that touch, beside closed forms: rest, bounce, slide, frequency."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import Contact, HalfSpace, PowerLaw, Sphere

G = 9.81
pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely")


def ball(mass: Any, K: Any, e: Any = 0.7, height: Any = 0.0, mu: Any = 0.0) -> jo.Mechanism:
    """A ball of 100 mm, at a height over a floor."""
    body = jo.RigidBody.sphere("ball", radius=0.1, mass=mass, position=(0, 0, 0.1 + height))
    law = PowerLaw(K, restitution=e)
    touch = Contact(
        "touch", jo.ground["origin"], HalfSpace(), body["origin"], Sphere(0.1), law, mu_kinetic=mu
    )
    return jo.Mechanism(body, touch, jo.Gravity((0, 0, -G)), jo.PositionSensor("p", body["origin"]))


def frequency(m: float, K: float) -> float:
    """Of a ball at rest on ``N = K d^1.5``, Hz: stiffness ``1.5 K sqrt(d)``."""
    return float(np.sqrt(1.5 * K * (m * G / K) ** (1 / 3) / m) / (2 * np.pi))


@pytest.mark.parametrize("check", [True, False])
def test_frequency_at_rest(check: bool) -> None:
    """By complex steps at the depth of the equilibrium, not of the initial position."""
    m, K = 2.0, 1e6
    parameter = jo.Parameter("mass", m, unit="kg")
    study = jo.study(lambda mass: ball(mass, K), parameter, "frequency(6, rest)")
    found = jo.design.gradient(study, check=check)
    assert found.values[0] == pytest.approx(frequency(m, K), rel=1e-9)
    assert found.jacobian[0, 0] == pytest.approx(-frequency(m, K) / (3.0 * m), rel=1e-9)
    assert found.how == (("complex step",),)


def test_rest_with_friction_takes_differences() -> None:
    """Where a bristle stands depends on the way there; here it is not stretched."""
    parameter = jo.Parameter("mass", 2.0, unit="kg")
    study = jo.study(lambda mass: ball(mass, 1e6, mu=0.3), parameter, "frequency(6, rest)")
    found = jo.design.gradient(study)
    assert "the rest on contact 'touch' depends on the way to it" in found.how[0][0]


def test_a_body_at_rest() -> None:
    """Depth ``(m g / K)^(2/3)`` in a run that starts in equilibrium."""
    m, K = 1.0, 1e6
    depth = (m * G / K) ** (2 / 3)
    study = jo.study(
        ball,
        [jo.Parameter("mass", m), jo.Parameter("K", K)],
        "last(p.z)",
        t_end=0.01,
        solver=jo.ROS2(1e-3),
        state=jo.equilibrium,
    )
    found = jo.design.gradient(study)
    np.testing.assert_allclose(
        found.jacobian[0], [-2 / 3 * depth / m, 2 / 3 * depth / K], rtol=1e-6
    )
    assert "contact 'touch' closes, opens, sticks and slips" in found.how[0][0]


def test_a_bounce() -> None:
    """The instant of the touch, ``h / v``, and the speed after it, ``e v``, without gravity.

    The number of steps in a touch makes the speed noisy by 1e-6, so that steps of 6e-6 of the
    parameter would have had errors of some per cent.
    """
    h, e, v = 0.2, 0.7, 2.0

    def thrown(e: Any, speed: Any) -> jo.Mechanism:
        body = jo.RigidBody.sphere(
            "ball", radius=0.1, mass=0.5, position=(0, 0, 0.1 + h), velocity=(0, 0, -speed)
        )
        law = PowerLaw(1e9, restitution=e)
        floor = jo.ground["origin"]
        return jo.Mechanism(
            body, Contact("touch", floor, HalfSpace(), body["origin"], Sphere(0.1), law)
        )

    study = jo.study(
        thrown,
        [jo.Parameter("e", e), jo.Parameter("speed", v)],
        {
            "touch": lambda run: float(run.contacts[0].touch),
            "rebound": lambda run: float(run.contacts[0].rebound),
        },
        t_end=0.12,
        solver=jo.RK4(1e-3),
    )
    found = jo.design.gradient(study)
    np.testing.assert_allclose(found.jacobian[0], [0.0, -h / v**2], rtol=3e-6, atol=1e-8)
    np.testing.assert_allclose(found.jacobian[1], [v, e], rtol=2e-3)


def test_a_slide() -> None:
    """Up a ramp until it stops: ``v^2 / 2 g (sin a + mu cos a)``."""
    a, K = np.radians(15.0), 1e9
    s, c = np.sin(a), np.cos(a)

    def block(mu: Any, v: Any) -> jo.Mechanism:
        body = jo.RigidBody(
            "block", 1.0, (0.01,) * 3, position=(0, 0, -G * c / K), velocity=(v, 0, 0)
        )
        law = PowerLaw(K, 1.0)
        touch = Contact(
            *("touch", jo.ground["origin"], HalfSpace(), body["origin"], Sphere(0.0), law),
            mu_kinetic=mu,
            mu_static=0.5,
        )
        x = jo.PositionSensor("x", body["origin"])
        return jo.Mechanism(body, touch, jo.Gravity((-G * s, 0, -G * c)), x)

    v, mu = 3.0, 0.3
    study = jo.study(
        block,
        [jo.Parameter("mu", mu), jo.Parameter("v", v)],
        "last(x.x)",
        t_end=0.7,
        solver=jo.ROS2(1e-3),
    )
    found = jo.design.gradient(study)
    length = v * v / (2 * G * (s + mu * c))
    wanted = [-length * c / (s + mu * c), 2 * length / v]
    np.testing.assert_allclose(found.jacobian[0], wanted, rtol=2e-4)
