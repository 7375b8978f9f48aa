"""Shapes that overlap at the start: what the law holds there is said, deep starts are refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import (
    Capsule,
    CollisionShape,
    Contact,
    Contacts,
    Cuboid,
    HalfSpace,
    PowerLaw,
    Sphere,
)
from jousto.model.overlaps import overlaps

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")
R, M, G, K = 0.1, 0.5, 9.81, 1e5


def sunk(depth: float, stiffness: float = K, *, many: bool = False) -> jo.Mechanism:
    """A ball whose lowest point is below the floor."""
    ball = jo.RigidBody.sphere("ball", radius=R, mass=M, position=(0, 0, R - depth))
    law, floor = PowerLaw(stiffness, restitution=1.0), jo.ground["origin"]
    touch: Any = Contact("touch", floor, HalfSpace(), ball["origin"], Sphere(R), law)
    if many:
        shapes = [
            CollisionShape("floor", floor, HalfSpace()),
            CollisionShape("ball", ball["origin"], Sphere(R)),
        ]
        touch = Contacts("touch", shapes, law=law, overlap="start")
    height = jo.PositionSensor("z", ball["origin"])
    return jo.Mechanism(ball, touch, height, jo.Gravity((0, 0, -G)))


@pytest.mark.parametrize("many", [False, True], ids=["contact", "set"])
def test_a_start_that_throws_is_reported_with_its_height(many):
    """E = K d^2.5 / 2.5, and without loss the ball rises to E / m g above its start."""
    depth = 0.02
    energy = K * depth**2.5 / 2.5
    with pytest.warns(jo.JoustoWarning, match=r"by 0.02 m \(20 % of the smaller shape\)"):
        model = jo.compile(sunk(depth, many=many))
    (found,) = overlaps(model)
    assert found.energy == pytest.approx(energy, rel=1e-9)
    assert found.speed == pytest.approx(np.sqrt(2 * energy / M), rel=1e-9)
    assert found.height == pytest.approx(energy / (M * G), rel=1e-9)
    run = jo.simulate(model, 0.5, solver=jo.RK4(1e-3), output_step=1e-3)
    assert run["z"][:, 2].max() - (R - depth) == pytest.approx(found.height, rel=1e-4)
    text = str(jo.doctor(model))
    assert f"law holds {energy:.3g} J" in text and f"{found.height:.3g} m high" in text


def test_a_stiff_law_throws_from_a_small_depth():
    with pytest.warns(jo.JoustoWarning, match=r"1 % of the smaller shape.* 12.6 J: up to 7.11 m/s"):
        jo.compile(sunk(1e-3, 1e9))


def test_two_free_bodies_share_the_energy():
    balls = [
        jo.RigidBody.sphere(name, radius=R, mass=mass, position=(x, 0, 0))
        for name, mass, x in (("a", 1.0, 0.0), ("b", 0.25, 2 * R - 0.02))
    ]
    law = PowerLaw(K, restitution=1.0)
    touch = Contact("t", balls[0]["origin"], Sphere(R), balls[1]["origin"], Sphere(R), law)
    v = jo.VelocitySensor("v", balls[1]["origin"])
    with pytest.warns(jo.JoustoWarning, match="overlap at the start"):
        model = jo.compile(jo.Mechanism(*balls, touch, v))
    run = jo.simulate(model, 0.1, solver=jo.RK4(1e-3))
    assert overlaps(model)[0].speed == pytest.approx(run["v"][-1, 0], rel=1e-4)


@pytest.mark.parametrize("share", [0.1, 0.5])
def test_a_soft_ball_at_rest_starts_without_a_word(share):
    """m g = K d^1.5: nothing is thrown, whatever the depth."""
    depth = share * R
    model = jo.compile(sunk(depth, M * G / depth**1.5))
    run = jo.simulate(model, 0.2, solver=jo.RK4(1e-3))
    assert np.abs(run["z"][:, 2] - (R - depth)).max() < 1e-9
    assert "high" not in str(jo.doctor(model))


def test_a_start_beyond_a_third_is_refused():
    with pytest.warns(jo.JoustoWarning, match="50 % of the smaller shape"):
        model = jo.compile(sunk(0.05))
    with pytest.raises(jo.InputError, match="by more than a third .*'ground' and 'ball' by 0.05 m"):
        jo.simulate(model, 0.1, solver=jo.RK4(1e-3))
    above = model.q0 + 0.06 * np.eye(model.nq)[2]
    apart = jo.simulation.State(above, np.zeros(model.nv), np.zeros(model.nrow))
    jo.simulate(model, 0.01, solver=jo.RK4(1e-3), state=apart)


@pytest.mark.filterwarnings("ignore:.*overlap at the start")
@pytest.mark.parametrize("shape", [Sphere(R), Cuboid((R, R, R)), Capsule(R, 2 * R)])
def test_bodies_in_one_place_are_refused(shape):
    bodies = [jo.RigidBody(f"b{i}", 1.0, (0.01,) * 3) for i in range(4)]
    shapes = [CollisionShape(one.name, one["origin"], shape) for one in bodies]
    touch = Contacts("heap", shapes, law=PowerLaw(K), overlap="start")
    model = jo.compile(jo.Mechanism(*bodies, touch))
    with pytest.raises(jo.InputError, match="'heap': shapes overlap .* by more than a third"):
        jo.simulate(model, 0.1, solver=jo.RK4(1e-3))
