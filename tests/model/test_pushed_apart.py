"""Shapes that overlap at the start are moved apart: closed forms, and a general optimiser."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
import pytest
import scipy

import jousto as jo
from jousto.mechanism import CollisionShape, Contacts, Cuboid, HalfSpace, PowerLaw, Sphere

R = 0.05
LAW = PowerLaw(1e6)
BALL = Sphere(R)
FLOOR = CollisionShape("floor", jo.ground["origin"], HalfSpace())


def ball(name: str, at: Any, mass: float = 1.0) -> Any:
    return jo.RigidBody.sphere(name, radius=R, mass=mass, position=at)


def apart(*bodies: Any, shape: Any = BALL, more: Any = (), **options: Any) -> Contacts:
    shapes = [CollisionShape(one.name, one["origin"], shape) for one in bodies]
    return Contacts("c", [*more, *shapes], law=LAW, overlap="apart", **options)


def places(model: Any) -> Any:
    return model.q0.reshape(-1, 7)[:, :3]


def compiled(*parts: Any, says: str = "moved apart") -> Any:
    with pytest.warns(jo.JoustoWarning, match=says):
        return jo.compile(jo.Mechanism(*parts))


def test_two_balls_share_the_way_by_their_masses():
    a, b = ball("a", (0, 0, 0), 1.0), ball("b", (0.06, 0.06, 0), 3.0)
    depth = 2 * R - 0.06 * np.sqrt(2)
    x = places(compiled(a, b, apart(a, b), says="'a' and 'b' by 0.0151 m; body 'a' .* by 0.0114 m"))
    n = np.array([1, 1, 0]) / np.sqrt(2)
    assert np.abs(x[0] + 0.75 * depth * n).max() < 1e-15
    assert np.abs(x[1] - (0.06 * np.sqrt(2) + 0.25 * depth) * n).max() < 1e-15


def test_a_stack_of_boxes_rises_to_its_height():
    size = (0.1, 0.1, 0.1)
    boxes = [
        jo.RigidBody(f"b{i}", 1.0, (1e-3, 2e-3, 2.5e-3), position=(0, 0, 0.048 + 0.097 * i))
        for i in range(4)
    ]
    model = compiled(*boxes, apart(*boxes, shape=Cuboid(size), more=[FLOOR]), says="4 pairs")
    assert np.abs(places(model)[:, 2] - (0.05 + 0.1 * np.arange(4))).max() < 1e-12
    assert np.abs(model.q0.reshape(-1, 7)[:, 4:]).max() < 1e-12  # none turns


def test_balls_in_a_corner_against_a_general_optimiser():
    """Least sum of m |dx|^2 with all distances, by sequential quadratic programming."""
    at = np.array([(0.04, 0.01, 0.05), (0.10, 0.03, 0.06), (0.06, 0.07, 0.12), (0.15, 0.1, 0.04)])
    mass = np.array([1.0, 2.0, 0.5, 1.5])
    balls = [ball(f"b{i}", x, m) for i, (x, m) in enumerate(zip(at, mass, strict=True))]
    model = compiled(*balls, apart(*balls, more=[FLOOR]))
    begin = at.copy()

    def gaps(x: Any) -> Any:
        x = x.reshape(-1, 3)
        pairs = [np.linalg.norm(x[i] - x[k]) - 2 * R for i, k in combinations(range(4), 2)]
        return np.array([*pairs, *(x[:, 2] - R)])

    def effort(x: Any) -> float:
        return float((mass[:, None] * (x.reshape(-1, 3) - begin) ** 2).sum())

    found = scipy.optimize.minimize(
        lambda x: 1e4 * effort(x), at.ravel(), method="SLSQP",
        constraints={"type": "ineq", "fun": gaps}, options={"ftol": 1e-14, "maxiter": 200},
    )  # fmt: skip
    own = places(model)
    assert gaps(own.ravel()).min() > -1e-13
    assert effort(own.ravel()) == pytest.approx(effort(found.x), rel=1e-7)
    assert np.abs(own.ravel() - found.x).max() < 1e-6


def test_a_joint_is_kept_and_a_given_value_too():
    """A ball on a slide of 30 deg to the floor rises by the depth, so it moves by 2 depth."""
    axis = np.array([np.cos(np.pi / 6), 0, np.sin(np.pi / 6)])
    one, other = ball("one", 0.06 * axis + (0, 0, 0.01)), ball("other", (0.5, 0, 0.5))
    slide = jo.Prismatic("slide", jo.ground.at((0, 0, 0.01)), one["origin"], axis=axis)
    touch = apart(one, other, more=[FLOOR])
    model = compiled(one, other, slide, touch)
    x = places(model)
    assert np.abs(x[0] - (0.08 * axis + (0, 0, 0.01))).max() < 1e-13
    assert np.abs(x[1] - (0.5, 0, 0.5)).max() == 0.0
    held = jo.Initial(slide.displacement, value=0.06)
    with pytest.raises(jo.InputError, match="cannot be moved apart, .* by 0.01 m: joints"):
        jo.compile(jo.Mechanism(one, other, slide, touch, held))


def test_a_drive_in_motion_starts_at_the_new_place_with_its_speed():
    arm = jo.RigidBody("arm", 1.0, (1e-3, 1e-3, 1e-3), position=(0, 0, 0.3))
    pin = jo.Revolute("pin", jo.ground.at((0, 0, 0.3)), arm["origin"], axis=(0, 1, 0))
    drive = jo.Drive("drive", pin.angle, jo.ConstantSpeed(2.0))
    free = ball("free", (0.04, 0, 0.3))
    shapes = [
        CollisionShape("hub", arm["origin"], Sphere(R)),
        CollisionShape("free", free["origin"], Sphere(R)),
    ]
    touch = Contacts("c", shapes, law=LAW, overlap="apart")
    model = compiled(arm, free, pin, drive, touch)
    assert np.abs(places(model)[1] - (0.1, 0, 0.3)).max() < 1e-13
    assert abs(model.v0[4] - 2.0) < 1e-12


def test_what_cannot_move_is_refused():
    down = jo.ground.at((0, 0, 0.08), axes=jo.Rotate((1, 0, 0), degrees=180))
    wall = CollisionShape("wall", down, HalfSpace())
    one = ball("one", (0, 0, 0.04))
    with pytest.raises(
        jo.InputError, match="cannot be moved apart, 'floor' and 'one' by 0.01 m, 'wall' .* hold"
    ):
        jo.compile(jo.Mechanism(one, apart(one, more=[FLOOR, wall])))
    pinned = ball("pinned", (0, 0, 0.04))
    weld = jo.Fixed("weld", jo.ground.at((0, 0, 0.04)), pinned["origin"])
    free = ball("free", (0.5, 0, 0.5))
    with pytest.raises(jo.InputError, match="'floor' and 'pinned' by 0.01 m"):
        jo.compile(jo.Mechanism(pinned, free, weld, apart(pinned, free, more=[FLOOR], joined=True)))


def test_far_from_the_origin_and_small():
    """Round-off of places at 1 km is above that of balls of 1 mm."""
    a = jo.RigidBody.sphere("a", radius=1e-3, mass=1e-5, position=(1000, 0, 0))
    b = jo.RigidBody.sphere("b", radius=1e-3, mass=1e-5, position=(1000.0015, 0, 0))
    x = places(compiled(a, b, apart(a, b, shape=Sphere(1e-3))))
    assert abs(x[1, 0] - x[0, 0] - 2e-3) < 1e-9


def test_only_bodies_that_overlap_are_coupled():
    """340 bodies have 2040 velocities, more than the limit for those that are coupled."""
    balls = [
        jo.RigidBody(f"b{i}", 1.0, (1, 1, 1), position=(0.095 * (i % 2) + 0.3 * (i // 2), 0, 1))
        for i in range(340)
    ]
    x = places(compiled(*balls, apart(*balls), says="170 pairs"))
    assert np.abs(np.diff(x[:, 0])[::2] - 2 * R).max() < 1e-12


def test_nothing_overlaps_nothing_moves():
    a, b = ball("a", (0, 0, 0)), ball("b", (0.2, 0, 0))
    assert np.array_equal(
        places(jo.compile(jo.Mechanism(a, b, apart(a, b)))), [(0, 0, 0), (0.2, 0, 0)]
    )
