"""Sets of polytopes, and sets in the matrix of ROS2: the same motion as of one contact a pair."""

from __future__ import annotations

from itertools import combinations, product
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from jousto.mechanism import (
    Apart,
    Capsule,
    CollisionShape,
    Contact,
    Contacts,
    ConvexHull,
    Cuboid,
    HalfSpace,
    HeightField,
    PowerLaw,
    Sphere,
    SpringDamper,
    TriangleMesh,
)

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

G = 9.81
FLOOR = jo.ground["origin"]
WEDGE = ConvexHull([(0, 0, 0), (0.5, 0, 0), (0, 0.4, 0), (0.5, 0.4, 0), (0, 0, 0.3), (0, 0.4, 0.3)])
GRAVITY = jo.Gravity((0, 0, -G))
Part = tuple[Any, Any]


def shapes_of(parts: list[Part], **more: Any) -> list[CollisionShape]:
    return [CollisionShape(body.name, body["origin"], shape, **more) for body, shape in parts]


def as_set(floor: Any, parts: list[Part], law: Any, **more: Any) -> list[Any]:
    shapes = [CollisionShape("floor", FLOOR, floor), *shapes_of(parts)]
    return [Contacts("c", shapes, law=law, **more)]


def as_pairs(floor: Any, parts: list[Part], law: Any, **more: Any) -> list[Any]:
    single = [
        Contact(f"f{body.name}", FLOOR, floor, body["origin"], shape, law, **more)
        for body, shape in parts
    ]
    return single + [
        Contact(f"{a.name}{b.name}", a["origin"], x, b["origin"], y, law, **more)
        for (a, x), (b, y) in combinations(parts, 2)
    ]


def thrown() -> list[Part]:
    rng = np.random.default_rng(8)
    shapes = [Cuboid((0.2, 0.3, 0.1)), WEDGE, Capsule(0.1, 0.3), Sphere(0.1)]
    return [
        (
            jo.RigidBody(
                f"b{i}", 1.0, (0.01, 0.012, 0.015), position=(0.1 * i, 0, 0.5 + 0.7 * i),
                velocity=rng.normal(size=3), angular_velocity=rng.normal(size=3) * 3,
            ),
            shape,
        )
        for i, shape in enumerate(shapes)
    ]  # fmt: skip


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("solver", [jo.RK4(1e-3), jo.GeneralizedAlpha(1e-3), jo.ROS2(1e-3)])
def test_same_motion_as_one_contact_a_pair(core, solver):
    """A box, a hull, a capsule and a ball fall on the floor and on one another."""
    law = PowerLaw(1e6, 1.0, restitution=0.6)
    found = []
    for declare in (as_set, as_pairs):
        parts = thrown()
        touch = declare(HalfSpace(), parts, law, mu_kinetic=0.3)
        place = [jo.PositionSensor(f"p{i}", body["origin"]) for i, (body, _) in enumerate(parts)]
        machine = jo.Mechanism(*(body for body, _ in parts), *touch, GRAVITY, *place)
        run = jo.simulate(jo.compile(machine, core=core), 0.6, solver=solver)
        found.append(np.array([run[f"p{i}"] for i in range(len(parts))]))
        assert run.attributes["contacts"] == "missed: 0 (proven)"
    # other crossings are located first, so that steps end at other instants
    assert np.abs(found[0] - found[1]).max() < (1e-6 if isinstance(solver, jo.RK4) else 2e-3)
    assert found[0][:, -1, 2].min() > -0.01


@pytest.mark.parametrize("solver", [jo.RK4(1e-3), jo.ROS2(1e-3)])
def test_same_impulses_as_one_contact_a_pair(solver):
    law = PowerLaw(1e6, restitution=0.5)
    found = []
    for declare in (as_set, as_pairs):
        parts = thrown()
        touch = declare(HalfSpace(), parts, law, mu_kinetic=0.3, resolve="impulse")
        model = jo.compile(jo.Mechanism(*(body for body, _ in parts), *touch, GRAVITY))
        run = jo.simulate(model, 0.6, solver=solver)
        found.append([(x.time, x.impulse) for x in run.events if x.change == "closes"])
    assert len(found[0]) > 5
    assert np.allclose(*found, rtol=1e-7, atol=0)


def stacked(count: int) -> list[Part]:
    """Boxes of 2 kg on each other, at rest on springs of 4e6 N/m."""
    z, parts = 0.0, []
    for i in range(count):
        z -= (count - i) * 2 * G / 4e6
        body = jo.RigidBody(f"b{i}", 2.0, (0.01,) * 3, position=(0, 0, z + 0.05))
        parts.append((body, Cuboid((0.2, 0.2, 0.1))))
        z += 0.1
    return parts


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("solver", [jo.RK4(1e-4), jo.GeneralizedAlpha(1e-3), jo.ROS2(1e-3)])
def test_stack_of_five_stands_still(core, solver):
    parts = stacked(5)
    law = PowerLaw(1e6, 1.0, restitution=0.5)
    touch = as_set(HalfSpace(), parts, law, mu_kinetic=0.3, overlap="start")
    place = [jo.PositionSensor(f"p{i}", body["origin"]) for i, (body, _) in enumerate(parts)]
    machine = jo.Mechanism(*(body for body, _ in parts), *touch, GRAVITY, *place)
    run = jo.simulate(jo.compile(machine, core=core), 0.1, solver=solver)
    assert 0.05 - run["p0"][-1, 2] == pytest.approx(2.4525e-5, rel=1e-9)
    for i in range(5):
        assert np.abs(run[f"p{i}"] - run[f"p{i}"][0]).max() < 1e-13


def test_lowest_frequency_of_the_stack():
    """Newton's matrix of a set of boxes on guides: masses of 2 kg on springs of 4e6 N/m."""
    parts = stacked(5)
    touch = as_set(
        HalfSpace(), parts, PowerLaw(1e6, 1.0, restitution=0.5), overlap="start"
    )  # fmt: skip
    guides = [
        jo.Prismatic(f"g{i}", jo.ground.at(b.position), b["origin"], axis=(0, 0, 1))
        for i, (b, _) in enumerate(parts)
    ]
    model = jo.compile(jo.Mechanism(*(b for b, _ in parts), *touch, *guides, GRAVITY))
    engine = jo.model.Engine(model)
    engine.accelerations()
    z = np.arange(5) * 6 + 2
    K = engine.newton_matrix(0.0, 0.0, 1.0)[np.ix_(z, z)]
    lowest = np.sqrt(np.abs(np.linalg.eigvals(K / 2.0)).min())
    assert lowest == pytest.approx(2 * np.sqrt(4e6 / 2) * np.sin(np.pi / 22), rel=1e-11)


def test_tangent_of_a_set_of_polytopes():
    """Newton's matrix against complex steps: the middle box overlaps with both others."""
    rng = np.random.default_rng(3)
    turn = Rotation.random(3, random_state=rng).as_quat(scalar_first=True)
    shapes = [Cuboid((0.1, 0.12, 0.14)), WEDGE, Capsule(0.05, 0.1)]
    bodies = [
        jo.RigidBody(
            f"b{i}", 1.0, (1e-3, 2e-3, 2.5e-3), position=at, orientation=turn[i],
            velocity=rng.normal(size=3), angular_velocity=rng.normal(size=3),
        )
        for i, at in enumerate([(0, 0, 0), (-0.05, -0.05, -0.05), (0.07, 0.01, 0)])
    ]  # fmt: skip
    named = shapes_of(list(zip(bodies, shapes, strict=True)))
    touch = Contacts("c", named, law=PowerLaw(1e4, restitution=0.7), overlap="start")
    engine = jo.model.Engine(jo.compile(jo.Mechanism(*bodies, touch)))
    engine.accelerations()
    assert (engine.contacts()[:, 3] > 0).sum() >= 2
    exact = engine.tangent()
    for M, weights in ((exact.K, (0.0, 0.0, 1.0)), (exact.D, (0.0, 1.0, 0.0))):
        N = engine.newton_matrix(*weights)[: len(M), : len(M)]
        assert np.abs(M[:6, 6:12]).max() > 0
        assert np.abs(M - N).max() <= 1e-11 * np.abs(M).max()


# -- the matrix of ROS2 ---------------------------------------------------------------------------


@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_rest_takes_one_step_and_does_not_creep(core):
    """Two boxes, one on the other, on 15 degrees with steps of 10 ms: 100 s in as many steps."""
    parts = stacked(2)
    law = PowerLaw(1e6, 1.0, restitution=0.5)
    touch = as_set(HalfSpace(), parts, law, mu_kinetic=0.4, overlap="start")
    place = [jo.PositionSensor(f"p{i}", body["origin"]) for i, (body, _) in enumerate(parts)]
    turn = np.radians(15)
    gravity = jo.Gravity((-G * np.sin(turn), 0, -G * np.cos(turn)))
    model = jo.compile(jo.Mechanism(*(b for b, _ in parts), *touch, gravity, *place), core=core)
    run = jo.simulate(model, 20.0, solver=jo.ROS2(1e-2))
    late = run.time > 5.0
    assert run.work.steps[-1] - run.work.steps[np.argmax(late)] == late.sum() - 1
    for i in range(2):
        assert np.ptp(run[f"p{i}"][late], axis=0).max() < 1e-12


@pytest.mark.parametrize("count", [2, 10, 160])
def test_bodies_that_do_not_fit_in_the_matrix_take_short_steps(count):
    """160 balls on the floor that may touch one another have no matrix; the rest is the same."""
    balls = [
        jo.RigidBody.sphere(f"b{i}", radius=0.05, mass=1.0, position=(0.2 * i, 0, 0.05))
        for i in range(count)
    ]
    touch = as_set(HalfSpace(), [(b, Sphere(0.05)) for b in balls], SpringDamper(1e6, 500.0))
    places = [jo.PositionSensor(f"p{i}", b["origin"]) for i, b in enumerate(balls)]
    model = jo.compile(jo.Mechanism(*balls, *touch, GRAVITY, *places))
    run = jo.simulate(model, 0.05, solver=jo.ROS2(2e-3))
    for i in range(count):
        assert run[f"p{i}"][-1, 2] == pytest.approx(0.05 - G / 1e6, rel=1e-7)


def test_a_pyramid_of_boxes_in_the_sparse_matrix():
    """Ten boxes in four layers, each on two: the matrix of the pairs present, with fill-in."""
    law, parts = PowerLaw(1e6, 1.0, restitution=0.5, slowest=0.1), []
    for layer in range(4):
        for i in range(4 - layer):
            at = (0.22 * i + 0.11 * layer, 0, 0.05 + 0.1 * layer)
            body = jo.RigidBody(f"b{layer}{i}", 2.0, (0.01,) * 3, position=at)
            parts.append((body, Cuboid((0.2, 0.2, 0.1))))
    parts = parts[::-1]
    touch = as_set(HalfSpace(), parts, law, mu_kinetic=0.5)
    place = [jo.PositionSensor(f"p{b.name}", b["origin"]) for b, _ in parts]
    model = jo.compile(jo.Mechanism(*(b for b, _ in parts), *touch, GRAVITY, *place))
    for solver in (jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)):
        run = jo.simulate(model, 2.0, solver=solver)
        late = run.time > 1.8
        for b, _ in parts:
            assert np.ptp(run[f"p{b.name}"][late], axis=0).max() < 1e-8
        assert abs(run.energy.error[-1]) < 1e-3


# -- nothing missed -------------------------------------------------------------------------------


def test_thin_plates_shot_at_each_other_meet():
    """Plates of 2 mm at 100 m/s with steps of 5 ms: momentum is kept, they do not pass."""
    plate = Cuboid((2e-3, 0.2, 0.2))
    bodies = [
        jo.RigidBody(f"b{i}", 0.1, (1e-4,) * 3, position=(x, 0, 0), velocity=(v, 0, 0))
        for i, (x, v) in enumerate([(0.0, 0.0), (-0.237, 100.0)])
    ]
    law = PowerLaw(1e9, 1.0, restitution=0.6)
    touch = Contacts("c", shapes_of([(b, plate) for b in bodies]), law=law)
    v = [jo.VelocitySensor(f"v{i}", b["origin"]) for i, b in enumerate(bodies)]
    run = jo.simulate(
        jo.compile(jo.Mechanism(*bodies, touch, *v)), 0.01, solver=jo.RK4(5e-3)
    )  # fmt: skip
    assert run.attributes["contacts"] == "missed: 0 (proven)"
    assert run["v0"][-1, 0] == pytest.approx(80.0, rel=1e-3)
    assert run["v1"][-1, 0] == pytest.approx(20.0, rel=1e-3)


def test_equal_shapes_share_their_numbers():
    sizes = []
    for count in (10, 20):
        boxes = [jo.RigidBody(f"b{i}", 1.0, (1, 1, 1), position=(i, 0, 0)) for i in range(count)]
        named = shapes_of([(b, Cuboid((0.1, 0.1, 0.1))) for b in boxes])
        model = jo.compile(jo.Mechanism(*boxes, Contacts("c", named, law=PowerLaw(1e6))))
        sizes.append(np.size(model.forces[0].data))
    assert sizes[1] - sizes[0] == 10 * (16 + 8 * 10)


TERRAIN = HeightField(0.1 * np.random.default_rng(3).uniform(size=(21, 21)), 4.0, 4.0)


def brick(x: float, y: float, z: float) -> TriangleMesh:
    """Return a box about the marker as a surface of triangles."""
    corners = 0.5 * np.array(list(product((-x, x), (-y, y), (-z, z))))
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return TriangleMesh.of(corners, [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])


def on_terrain() -> list[Part]:
    rng = np.random.default_rng(1)
    shapes = [Sphere(0.1), Cuboid((0.2, 0.3, 0.1)), Capsule(0.1, 0.3), Sphere(0.08), WEDGE]
    return [
        (
            jo.RigidBody(
                f"b{i}", 1.0, (0.01, 0.012, 0.015), position=(0.45 * i - 0.9, 0.1, 0.4),
                velocity=rng.normal(size=3) * 0.5,
            ),
            shape,
        )
        for i, shape in enumerate(shapes)
    ]  # fmt: skip


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("solver", [jo.RK4(5e-4), jo.GeneralizedAlpha(1e-3), jo.ROS2(1e-3)])
def test_shapes_on_a_height_field_as_one_contact_a_pair(core, solver):
    law = PowerLaw(1e5, 1.0, restitution=0.3)
    found = []
    for declare in (as_set, as_pairs):
        parts = on_terrain()
        place = [jo.PositionSensor(f"p{i}", body["origin"]) for i, (body, _) in enumerate(parts)]
        touch = declare(TERRAIN, parts, law, mu_kinetic=0.4)
        machine = jo.Mechanism(*(body for body, _ in parts), *touch, GRAVITY, *place)
        run = jo.simulate(jo.compile(machine, core=core), 0.3, solver=solver)
        found.append(np.array([run[f"p{i}"] for i in range(len(parts))]))
        assert len(run.contacts) > 5
    assert np.abs(found[0] - found[1]).max() < 1e-7


def test_a_surface_rests_on_a_plane_and_carries_a_ball():
    """10 N on 4 corners, then 20 N with the ball: depth F / (4 K)."""
    block = jo.RigidBody("block", 10 / G, (0.1,) * 3, position=(0, 0, 0.1))
    ball = jo.RigidBody("ball", 10 / G, (0.1,) * 3, position=(0, 0, 0.25))
    parts = [(block, brick(0.4, 0.4, 0.2)), (ball, Sphere(0.05))]
    sensors = [jo.PositionSensor(body.name, body["origin"]) for body, _ in parts]
    law = SpringDamper(1e4, 200.0)
    machine = jo.Mechanism(block, ball, *as_set(HalfSpace(), parts, law), GRAVITY, *sensors)
    run = jo.simulate(jo.compile(machine), 2.0, solver=jo.ROS2(2e-3))
    assert run["block"][-1, 2] == pytest.approx(0.1 - 20 / 4e4, abs=1e-6)
    assert run["ball"][-1, 2] - run["block"][-1, 2] == pytest.approx(0.15 - 10 / 1e4, abs=1e-6)


def test_equal_surfaces_share_their_numbers():
    surface, sizes = brick(0.1, 0.1, 0.1), []
    for count in (10, 20):
        boxes = [jo.RigidBody(f"b{i}", 1.0, (1, 1, 1), position=(i, 0, 1)) for i in range(count)]
        apart = [Apart("all", "all")]
        named = shapes_of([(b, surface) for b in boxes])
        floor = CollisionShape("floor", FLOOR, HalfSpace(), group="floor")
        contacts = Contacts("c", [floor, *named], law=PowerLaw(1e6), apart=apart)
        sizes.append(np.size(jo.compile(jo.Mechanism(*boxes, contacts)).forces[0].data))
    assert sizes[1] - sizes[0] == 10 * 16


def test_surfaces_that_sets_refuse():
    body = jo.RigidBody("b", 1.0, (1, 1, 1), position=(0, 0, 1))
    sheet = TriangleMesh.of([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    with pytest.raises(jo.InputError, match="pass an open triangle-mesh without thickness"):
        Contacts(
            "c",
            [
                CollisionShape("s", FLOOR, sheet),
                CollisionShape("b", body["origin"], Cuboid((1, 1, 1))),
            ],
            law=PowerLaw(1e6),
        )
    block = CollisionShape("b", body["origin"], brick(1, 1, 1))
    with pytest.raises(jo.InputError, match="height-field and triangle-mesh cannot touch"):
        Contacts("c", [CollisionShape("t", FLOOR, TERRAIN), block], law=PowerLaw(1e6))


@pytest.mark.parametrize("solver", [jo.RK4(5e-4), jo.ROS2(1e-3)])
def test_a_ball_that_slides_off_an_edge_leaves_in_whole_steps(solver):
    """It parts without speed along the normal."""
    ball = jo.RigidBody("b", 1.0, (0.01,) * 3, position=(0.1, 0.1, 0.3), angular_velocity=(1, 2, 3))
    hull = ConvexHull([(0, 0, 0), (0.3, 0, 0), (0, 0.3, 0), (0, 0, 0.3)])
    law = PowerLaw(1e5, 1.0, restitution=0.3)
    touch = Contact("c", FLOOR, hull, ball["origin"], Sphere(0.08), law, mu_kinetic=0.4)
    run = jo.simulate(jo.compile(jo.Mechanism(ball, touch, GRAVITY)), 0.4, solver=solver)
    assert run.attributes["contacts"] == "missed: 0 (proven)"
    assert len(run.contacts) == 3
    assert " 0 after halving" in run.attributes["contact steps"]
