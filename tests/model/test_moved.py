"""Drives that begin elsewhere than bodies stand: the bodies are moved, and compile says so."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import jousto as jo


def cart(begins: float, scale: float = 1.0, at: float = 0.0) -> jo.Mechanism:
    body = jo.RigidBody(
        "cart", 1.0, (1e-1 * scale**2,) * 3, position=(at, 0, 0), markers={"corner": (scale, 0, 0)}
    )
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    motor = jo.Drive("motor", rail.displacement, jo.SCurve((0, 1), (begins, begins + scale)))
    return jo.Mechanism(body, rail, motor, name="trolley")


def test_a_cart_that_is_moved_to_its_drive_is_told() -> None:
    told = (
        r"'trolley': drive 'motor' begins at 0\.5 m, but rail\.displacement stands at 0 m; "
        r".* moved 'cart' by 0\.5 m; let signals begin at"
    )
    with pytest.warns(jo.JoustoWarning, match=told):
        model = jo.compile(cart(0.5))
    assert model.q0[0] == pytest.approx(0.5, rel=1e-12)  # one projection onto a linear row


def test_a_rotation_is_told_in_degrees_and_with_what_hangs_on_it() -> None:
    """A bob at the end of an arm of 2 m: both turn by 0.3 rad, the bob moves by the chord."""
    arm = jo.RigidBody("arm", 1.0, (0.1, 0.1, 0.1), center=(1, 0, 0), markers={"end": (2, 0, 0)})
    bob = jo.RigidBody("bob", 1.0, (0.1, 0.1, 0.1), position=(2, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], arm["origin"], axis=(0, 0, 1))
    held = jo.Fixed("held", arm["end"], bob["origin"])
    motor = jo.Drive("motor", hinge.angle, jo.SCurve((0, 1), (0.3, 1)))
    chord = 2 * 2.0 * np.sin(0.15)  # 0.5978 m
    turned = np.degrees(0.3)  # 17.19
    bob_moved = rf"'bob' by {chord:.4g} m and by {turned:.4g} degrees"
    told = rf"moved {bob_moved}, 'arm' by {turned:.4g} degrees; "
    with pytest.warns(jo.JoustoWarning, match=told):
        jo.compile(jo.Mechanism(arm, bob, hinge, held, motor))


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e3])
def test_the_limit_follows_the_size(scale: float) -> None:
    """1e-6 of the size is what joints are closed by without a word."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        jo.compile(cart(0.5e-6 * scale, scale))
        jo.compile(cart((0.1 + 0.2) * scale, scale, at=0.3 * scale))  # 0.30000000000000004
    with pytest.warns(jo.JoustoWarning, match="begins at"):
        jo.compile(cart(2e-6 * scale, scale))


def test_an_initial_elsewhere_hides_nothing() -> None:
    """The value of a pendulum does not say where the cart that carries it is to stand."""
    trolley = cart(0.5)
    (body,) = trolley.bodies
    bob = jo.RigidBody("bob", 1.0, (0.1, 0.1, 0.1), center=(0, 0, -1))
    hinge = jo.Revolute("hinge", body["origin"], bob["origin"], axis=(0, 1, 0))
    with pytest.warns(jo.JoustoWarning, match=r"'motor' begins at 0\.5 m"):
        jo.compile(jo.Mechanism(*trolley.items, bob, hinge, jo.Initial(hinge.angle, value=0.2)))
