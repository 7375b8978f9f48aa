"""Shapes that touch, as the viewer draws them: each kind, where its marker is."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import (
    Bore,
    Capsule,
    CollisionShape,
    Contact,
    Contacts,
    ConvexHull,
    Cuboid,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    HeightField,
    HollowSphere,
    PowerLaw,
    Sphere,
    Torus,
    TriangleMesh,
)
from jousto.mechanism.contacts.shapes import Shape
from jousto.scene.make import make_scene

LAW = PowerLaw(1e5, 1.0)
CORNERS = [(0, 0, 0), (0.3, 0, 0), (0, 0.2, 0), (0, 0, 0.1)]
WEDGE = np.array(CORNERS)
FACES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
HILL = np.array([[0.0, 0.1], [0.2, 0.4], [0.0, 0.0]])
DRAWN: list[tuple[Shape, Any]] = [
    (Sphere(0.1), [(-0.1,) * 3, (0.1,) * 3]),
    (Capsule(0.05, 0.3), [(-0.05, -0.05, -0.2), (0.05, 0.05, 0.2)]),
    (Cuboid((0.4, 0.3, 0.2)), [(-0.2, -0.15, -0.1), (0.2, 0.15, 0.1)]),
    (ConvexHull(CORNERS), [(0, 0, 0), (0.3, 0.2, 0.1)]),
    (Cylinder(0.1, 0.5), [(-0.1, -0.1, -0.25), (0.1, 0.1, 0.25)]),
    (Torus(0.2, 0.05), [(-0.25, -0.25, -0.05), (0.25, 0.25, 0.05)]),
    (Ellipsoid((0.6, 0.4, 0.2)), [(-0.3, -0.2, -0.1), (0.3, 0.2, 0.1)]),
    (HalfSpace(), [(-2, -2, 0), (2, 2, 0)]),
    (HollowSphere(0.2), [(-0.2, -0.2, -0.2), (0.2, 0.2, 0)]),
    (Bore(0.1), [(-0.1, -0.1, -0.1), (0.1, 0.1, 0.1)]),
    (TriangleMesh.of(WEDGE, FACES), [(0, 0, 0), (0.3, 0.2, 0.1)]),
    (HeightField(HILL, length=2.0, width=1.0, base=0.1), [(-1, -0.5, -0.1), (1, 0.5, 0.4)]),
]


def kind(value: Any) -> str:
    return value.tag if isinstance(value, Shape) else ""


def test_every_shape_is_here() -> None:
    """A shape that a user can declare is drawn below."""
    known = {TriangleMesh.tag, HeightField.tag, *(cls.tag for cls in Shape.__subclasses__())}
    assert known - {""} == {shape.tag for shape, _ in DRAWN}


@pytest.mark.parametrize("shape, extent", DRAWN, ids=kind)
def test_shape_is_drawn_with_its_extent(shape: Shape, extent: Any) -> None:
    """Extents follow from the sizes; round shapes are drawn by 16 parts or more (2 %)."""
    triangles = shape.triangles.reshape(-1, 3)
    size = float(np.abs(extent).max())
    found = np.array([triangles.min(axis=0), triangles.max(axis=0)])
    assert found == pytest.approx(np.array(extent), abs=0.02 * size)


def test_shapes_are_drawn_at_their_markers() -> None:
    """A box on a turned marker of a body, and the floor, single and in a set."""
    crate = jo.RigidBody("crate", 1.0, (0.01,) * 3, position=(1, 0, 0.5))
    turned = crate.at((0, 0, 0.2), axes=[(0, 0, 1), (1, 0, 0), (0, 1, 0)])
    floor = jo.ground["origin"]
    box = Cuboid((0.4, 0.3, 0.2))
    single = Contact("feet", floor, HalfSpace(), turned, box, LAW)
    shapes = [CollisionShape("floor", floor, HalfSpace()), CollisionShape("box", turned, box)]
    for contact in (single, Contacts("set", shapes, law=LAW)):
        scene = make_scene(jo.Mechanism(crate, contact))
        bodies = {body.name: body for body in scene.bodies if body.kind == "contact"}
        assert set(bodies) == {"contact shapes of crate", "contact shapes of the ground"}
        # local x, y, z of the box are y, z, x of the body
        found = bodies["contact shapes of crate"].positions
        assert np.abs(found - (0, 0, 0.2)).max(axis=0) == pytest.approx([0.1, 0.2, 0.15])
        assert bodies["contact shapes of crate"].place == scene.bodies[0].place
        assert bodies["contact shapes of the ground"].positions[:, 2].tolist() == [0.0] * 6


def test_a_wheel_and_its_rail_are_drawn() -> None:
    """The wheel touches the rail at its top, the flange stands beyond the play."""
    radius, play = 0.46, 7e-3
    axle = jo.RigidBody("axle", 1.0, (1, 1, 1), position=(0, 0, radius))
    contact = jo.mechanism.RailContact(
        *("left", jo.ground["origin"], axle["origin"], radius, -0.05), play=play, axle=(0, 1, 0)
    )
    scene = make_scene(jo.Mechanism(axle, contact))
    bodies = {body.name: body for body in scene.bodies if body.kind == "contact"}
    wheel = bodies["contact shapes of axle"].positions
    rail = bodies["contact shapes of the ground"].positions
    assert rail[:, 2].max() == 0.0 and np.ptp(rail[:, 1]) == pytest.approx(0.072)
    assert np.linalg.norm(wheel[:, [0, 2]], axis=1).max() == pytest.approx(radius + 0.028)
    # the flange is on the side where the radius grows, and does not enter the rail
    high = wheel[np.linalg.norm(wheel[:, [0, 2]], axis=1) > radius + 0.02]
    assert high[:, 1].max() < -0.036 - play
