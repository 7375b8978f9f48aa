"""An ellipsoid on a plane: the gap of coal, rocking in closed form, energy of bounces, sets."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.rotations import rotation_matrix
from jousto.mechanism import CollisionShape, Contact, Contacts, Ellipsoid, HalfSpace, PowerLaw
from jousto.model.native.header import named

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

G = 9.81
A, B, C = 0.1, 0.08, 0.05  # m
SHAPE = Ellipsoid((2 * A, 2 * B, 2 * C))
INERTIA = np.array([B * B + C * C, A * A + C * C, A * A + B * B]) / 5  # 1 kg


def body(height: float, e: Any = (1, 0, 0, 0), **more: Any) -> jo.RigidBody:
    q = np.asarray(e, dtype=float) / np.linalg.norm(e)
    return jo.RigidBody("b", 1.0, INERTIA, position=(0, 0, height), orientation=q, **more)


def test_gap_is_that_of_coal():
    """In any attitude, in a set: z - sqrt(n . R D^2 R^T n), and coal's distance."""
    coal = pytest.importorskip("coal")
    rng = np.random.default_rng(4)
    for _ in range(50):
        e = rng.normal(size=4)
        one = body(0.045, e)
        shapes = [
            CollisionShape("floor", jo.ground["origin"], HalfSpace()),
            CollisionShape("b", one["origin"], SHAPE),
        ]
        touch = Contacts("set", shapes, law=PowerLaw(1e6), overlap="start")
        engine = jo.model.Engine(jo.compile(jo.Mechanism(one, touch, jo.Gravity((0, 0, -G)))))
        (gap,) = named("jo_touch", engine.contacts()).gap
        R = rotation_matrix(e / np.linalg.norm(e))
        assert gap == pytest.approx(0.045 - np.linalg.norm(R[2] * [A, B, C]), abs=1e-15)
        place = coal.Transform3s(R, np.array([0, 0, 0.045]))
        plane = coal.Halfspace(np.array([0.0, 0.0, 1.0]), 0.0)
        args = coal.Ellipsoid(A, B, C), place, plane, coal.Transform3s.Identity()
        theirs = coal.distance(*args, coal.DistanceRequest(), coal.DistanceResult())
        assert gap == pytest.approx(theirs, abs=1e-12)


def test_it_rocks_at_the_frequency_of_rolling():
    """w^2 = m g (R - c) / (I + m c^2), R = a^2 / c, about both axes; depth 1e-6 of its size."""
    sunk = 1e-7
    one = body(C - sunk)
    law = PowerLaw(G / sunk, 1.0, restitution=1.0)
    touch = Contact(
        "t", jo.ground["origin"], HalfSpace(), one["origin"], SHAPE, law, mu_kinetic=9.0
    )
    model = jo.compile(jo.Mechanism(one, touch, jo.Gravity((0, 0, -G))))
    found = jo.modes(model, jo.equilibrium(model)).frequencies
    wanted = [
        np.sqrt(G * (r * r / C - C) / (i + C * C)) / (2 * np.pi)
        for r, i in ((B, INERTIA[0]), (A, INERTIA[1]))
    ]
    np.testing.assert_allclose(found[1:3], wanted, rtol=2e-6)
    assert found[0] == pytest.approx(0, abs=1e-3)  # about the vertical


def test_bounces_keep_their_energy():
    """Thrown and spinning, smooth and elastic: no energy is lost or gained, none missed."""
    one = body(0.3, (0.9, 0.2, 0.3, -0.1), velocity=(0.3, 0, 0), angular_velocity=(20, -9, 5))
    law = PowerLaw(1e6, 1.5, restitution=1.0)
    touch = Contact("t", jo.ground["origin"], HalfSpace(), one["origin"], SHAPE, law)
    model = jo.compile(jo.Mechanism(one, touch, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 1.5, solver=jo.RK4(1e-3))
    assert np.abs(run.energy.error).max() < 2e-5 * 3.1  # of its energy, J, with 20 steps a touch
    assert run.attributes["contacts"] == "missed: 0 (proven)"
