"""Cylinders and ellipsoids on other convex shapes: distances, tangents, closed forms, energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from jousto.mechanism import (
    Capsule,
    CollisionShape,
    Contact,
    Contacts,
    ConvexHull,
    Cuboid,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    PowerLaw,
    Surface,
    Torus,
    TriangleMesh,
)
from jousto.model import shape_distance
from jousto.model.contact_points import features_of

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

G, K = 9.81, 1e7
RADIUS, LENGTH = 0.05, 0.2
TIP = np.degrees(np.arctan(RADIUS / (0.5 * LENGTH)))
WEDGE = ConvexHull([(0, 0, 0), (0.5, 0, 0), (0, 0.4, 0), (0.5, 0.4, 0), (0, 0, 0.3), (0, 0.4, 0.3)])
FLOOR = (jo.ground.at((0, 0, -0.5)), Cuboid((9, 9, 1)))


def turned(*angles: float) -> Any:
    """A quaternion from turns about x, y and z, deg."""
    return tuple(Rotation.from_euler("xyz", angles, degrees=True).as_quat(scalar_first=True))


# -- distance -------------------------------------------------------------------------------------


def random_shape(rng: Any, kind: str) -> Any:
    if kind == "cuboid":
        return Cuboid(rng.uniform(0.1, 1.0, 3))
    if kind == "capsule":
        return Capsule(rng.uniform(0.05, 0.3), rng.uniform(0.1, 1.0))
    if kind == "cylinder":
        return Cylinder(rng.uniform(0.05, 0.3), rng.uniform(0.1, 1.0))
    if kind == "ellipsoid":
        return Ellipsoid(rng.uniform(0.1, 1.0, 3))
    return ConvexHull(rng.normal(size=(rng.integers(6, 30), 3)) * 0.3)


def height(shape: Any, n: Any) -> float:
    """The largest n . x of a shape in its frame."""
    if isinstance(shape, Cylinder):
        return shape.radius * np.hypot(n[0], n[1]) + 0.5 * shape.length * abs(n[2])
    if isinstance(shape, Ellipsoid):
        return float(np.linalg.norm(0.5 * np.array(shape.lengths) * n))
    return float((shape.polytope.vertices @ n).max() + shape.polytope.radius)


def of_coal(coal: Any, shape: Any) -> Any:
    if isinstance(shape, Cuboid):
        return coal.Box(*shape.lengths)
    if isinstance(shape, Capsule):
        return coal.Capsule(shape.radius, shape.length)
    if isinstance(shape, Cylinder):
        return coal.Cylinder(shape.radius, shape.length)
    if isinstance(shape, Ellipsoid):
        return coal.Ellipsoid(*shape.size)
    points = coal.StdVec_Vec3s()
    for x in shape.polytope.vertices:
        points.append(x)
    return coal.Convex.convexHull(points, True, "")


KINDS = [
    *(("cylinder", other) for other in ("cuboid", "capsule", "hull", "cylinder", "ellipsoid")),
    *(("ellipsoid", other) for other in ("cuboid", "capsule", "hull", "cylinder", "ellipsoid")),
]


@pytest.mark.parametrize(
    "count", [30, pytest.param(1000, marks=pytest.mark.slow)], ids=["few", "10000 in all"]
)
@pytest.mark.parametrize("kinds", KINDS, ids="-".join)
def test_distance_beside_coal(kinds, count):
    """Random pairs, also deep ones, between a bound of their heights and what coal finds.

    ``s(n) = -h_b(-n) - h_a(n)`` is at most the distance for every n, and coal's is that of two
    places or a displacement that parts them, hence at least the distance. It is often larger: of
    ellipsoids by some 1e-7, and where it does not converge.
    """
    coal = pytest.importorskip("coal")
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = 1e-13
    request.gjk_max_iterations = request.epa_max_iterations = 1000
    rng = np.random.default_rng(7)
    same = 0
    for _ in range(count):
        a, b = (random_shape(rng, kind) for kind in kinds)
        r = rng.normal(size=3)
        r *= rng.uniform(0.3, 1.6) / np.linalg.norm(r)
        R = Rotation.random(random_state=rng).as_matrix()
        gap, normal = shape_distance(a, b, r, R)
        assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-14)
        bound = normal @ r - height(b, -R.T @ normal) - height(a, normal)
        assert gap == pytest.approx(bound, abs=1e-14)
        result = coal.DistanceResult()
        here, there = coal.Transform3s(), coal.Transform3s(R, r)
        other = coal.distance(of_coal(coal, a), here, of_coal(coal, b), there, request, result)
        if not np.isfinite(other) or abs(other) > 10.0 or (other < 0) != (gap < 0):
            continue  # it has given up
        assert gap > other - 1e-10, (a, b, r, R)
        same += gap < other + 1e-6
    assert same > 0.4 * count


@pytest.mark.parametrize("shift", [0.0, 0.02])
def test_ellipsoids_on_one_axis(shift):
    """End on end: the distance of the centres less both half axes, beside it by Lagrange."""
    a, b = Ellipsoid((0.4, 0.6, 0.2)), Ellipsoid((0.2, 0.3, 0.5))
    gap, normal = shape_distance(a, b, (0, 0, 0.34), np.eye(3))
    assert gap == pytest.approx(0.34 - 0.1 - 0.25, abs=1e-15)
    np.testing.assert_allclose(normal, (0, 0, 1), atol=1e-14)
    gap, n = shape_distance(a, b, (shift, 0, 0.4), np.eye(3))
    x = np.array(a.size) ** 2 * n / np.linalg.norm(np.array(a.size) * n)
    y = (shift, 0, 0.4) - np.array(b.size) ** 2 * n / np.linalg.norm(np.array(b.size) * n)
    np.testing.assert_allclose(y - x, gap * n, atol=1e-15)


# -- tangents -------------------------------------------------------------------------------------

DISC, EGG = Cylinder(0.12, 0.4), Ellipsoid((0.3, 0.5, 0.2))
PAIRS = [
    (Cuboid((0.3, 0.4, 0.5)), DISC),
    (DISC, Cylinder(0.2, 0.1)),
    (Capsule(0.1, 0.4), DISC),
    (DISC, WEDGE),
    (EGG, DISC),
    (Ellipsoid((0.3, 0.2, 0.25)), EGG),
    (EGG, WEDGE),
    (Capsule(0.1, 0.4), EGG),
]


def bodies_that_overlap(rng: Any) -> tuple[jo.RigidBody, jo.RigidBody]:
    """Two bodies near each other in general motion, every second time with nearly parallel axes."""
    turn = Rotation.random(2, random_state=rng)
    quarters = Rotation.from_euler("xyz", rng.integers(0, 4, 3) * 90, degrees=True)
    beside = turn[0] * quarters * Rotation.from_rotvec(rng.normal(size=3) * 0.02)
    other = beside if rng.random() < 0.5 else turn[1]
    v, w = rng.normal(size=(2, 2, 3))
    apart = rng.normal(size=3)
    apart *= rng.uniform(0.05, 0.5) / np.linalg.norm(apart)
    a = jo.RigidBody(
        "a", 2.0, (0.1, 0.2, 0.25), orientation=turn[0].as_quat(scalar_first=True), velocity=v[0]
    )
    b = jo.RigidBody(
        "b", 1.0, (0.05, 0.06, 0.07), position=apart, velocity=v[1], angular_velocity=w[1],
        orientation=other.as_quat(scalar_first=True),
    )  # fmt: skip
    return a, b


@pytest.mark.parametrize("mu", [0.0, 0.4])
@pytest.mark.parametrize("pair", PAIRS, ids=lambda p: " ".join(type(x).__name__ for x in p))
def test_tangent_is_the_derivative(pair, mu):
    """Newton's matrix against complex steps, of all features that are found."""
    rng = np.random.default_rng(5)
    found, features = 0, set()
    for _ in range(24):
        a, b = bodies_that_overlap(rng)
        law = PowerLaw(1e4, restitution=0.7)
        contact = Contact("c", a["origin"], pair[0], b["origin"], pair[1], law, mu_kinetic=mu)
        engine = jo.model.Engine(jo.compile(jo.Mechanism(a, b, contact)))
        states = np.array(engine.states).reshape(-1, 8)
        phase = states[:, 0]
        if not phase.any() or (mu and (phase == 1).any()):
            continue  # a bristle that sticks is moved by its states
        engine.accelerations()
        exact = engine.tangent()
        for M, weights in ((exact.K, (0.0, 0.0, 1.0)), (exact.D, (0.0, 1.0, 0.0))):
            N = engine.newton_matrix(*weights)[: len(M), : len(M)]
            assert np.abs(M - N).max() <= 1e-12 * np.abs(M).max()
        found += 1
        features |= set((states[phase > 0, 6] // 1024**4).astype(int))
    assert found > 2
    assert len(features) > 1 or pair[0].tag == pair[1].tag == "ellipsoid"


# -- closed forms ---------------------------------------------------------------------------------


def on_a_box(
    shape: Any, inertia: Any, slope: float, mu: float, core: Any = "joint", **more: Any
) -> Any:
    """A body of 1 kg on a box, with the slope as an inclination of gravity, rad."""
    body = jo.RigidBody("b", 1.0, inertia, **more)
    law = PowerLaw(K, 1.0, restitution=0.3)
    touch = Contact("t", *FLOOR, body["origin"], shape, law, mu_kinetic=mu)
    gravity = jo.Gravity((G * np.sin(slope), 0, -G * np.cos(slope)))
    sensors = (
        jo.PositionSensor("x", body["origin"]),
        jo.VelocitySensor("v", body["origin"]),
        jo.AngularVelocitySensor("w", body["origin"]),
    )
    return jo.compile(jo.Mechanism(body, touch, gravity, *sensors), core=core)


ACROSS = 0.25 * RADIUS**2 + LENGTH**2 / 12
SOLID = (ACROSS, ACROSS, 0.5 * RADIUS**2)
ROD = Cylinder(RADIUS, LENGTH)


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("solver", [jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)])
def test_it_rolls_down_a_box(solver, core):
    """a = 2/3 g sin(slope), on two points that stay level."""
    slope = np.radians(20)
    sunk = G * np.cos(slope) / (2 * K)
    model = on_a_box(
        ROD, SOLID, slope, 0.5, core, position=(0, 0, RADIUS - sunk), orientation=turned(90, 0, 0)
    )
    run = jo.simulate(model, 0.3, solver=solver)
    assert run["v"][-1, 0] == pytest.approx(2 / 3 * G * np.sin(slope) * 0.3, rel=1e-5)
    assert run["w"][-1, 1] * RADIUS == pytest.approx(run["v"][-1, 0], rel=1e-5)
    assert np.ptp(run["x"][:, 2]) < 1e-12
    assert np.abs(run.energy.error).max() < 1e-8
    assert run.attributes["contacts"] == "missed: 0 (proven)"


@pytest.mark.parametrize("turn", [0.0, 37.0])
@pytest.mark.parametrize(("beyond", "falls"), [(-0.5, False), (0.5, True)])
def test_it_tips_over_on_a_box(beyond, falls, turn):
    """On its end: at atan(radius / half the length), whatever turn it has."""
    slope = np.radians(TIP + beyond)
    model = on_a_box(
        ROD, SOLID, slope, 1.0, position=(0, 0, 0.5 * LENGTH), orientation=turned(0, 0, turn)
    )
    run = jo.simulate(model, 0.3, solver=jo.ROS2(5e-4))
    assert (np.abs(run["w"][-1]).max() > 0.02) == falls
    assert run.attributes["contacts"] == "missed: 0 (proven)"


@pytest.mark.parametrize(("beyond", "falls"), [(-0.004, False), (0.004, True)])
def test_it_falls_over_the_border_of_a_box(beyond, falls):
    """Its middle on or beyond the border of the box on which it stands."""
    body = jo.RigidBody("b", 1.0, SOLID, position=(4.5 + beyond, 0, 0.5 * LENGTH - 1e-6))
    law = PowerLaw(K, 1.0, restitution=0.3)
    touch = Contact("t", *FLOOR, body["origin"], ROD, law, mu_kinetic=0.5)
    w = jo.AngularVelocitySensor("w", body["origin"])
    model = jo.compile(jo.Mechanism(body, touch, jo.Gravity((0, 0, -G)), w))
    run = jo.simulate(model, 0.4, solver=jo.ROS2(1e-3))
    assert (run["w"][-1, 1] > 0.1) == falls


def test_an_ellipsoid_rocks_on_a_box():
    """w^2 = m g (R - c) / (I + m c^2), R = a^2 / c, about both axes."""
    a, b, c = 0.1, 0.08, 0.05
    inertia = np.array([b * b + c * c, a * a + c * c, a * a + b * b]) / 5
    sunk = 1e-7
    body = jo.RigidBody("b", 1.0, inertia, position=(0, 0, c - sunk))
    law = PowerLaw(G / sunk, 1.0, restitution=1.0)
    egg = Ellipsoid((2 * a, 2 * b, 2 * c))
    touch = Contact("t", *FLOOR, body["origin"], egg, law, mu_kinetic=9.0)
    model = jo.compile(jo.Mechanism(body, touch, jo.Gravity((0, 0, -G))))
    found = jo.modes(model, jo.equilibrium(model)).frequencies
    wanted = [
        np.sqrt(G * (r * r / c - c) / (i + c * c)) / (2 * np.pi)
        for r, i in ((b, inertia[0]), (a, inertia[1]))
    ]
    np.testing.assert_allclose(found[1:3], wanted, rtol=2e-6)


@pytest.mark.parametrize("under", ["side by side", "crossed"])
def test_a_cylinder_on_a_cylinder(under):
    """Sides that are parallel share the load at both ends, those that cross at one point."""
    parallel = under == "side by side"
    sunk = 2 * RADIUS - G / ((2 if parallel else 1) * K)
    body = jo.RigidBody(
        "b", 1.0, SOLID, position=(0, 0, sunk), orientation=turned(90, 0, 0 if parallel else 90)
    )
    base = jo.ground.at((0, 0, 0), turned(90, 0, 0))
    law = PowerLaw(K, 1.0, restitution=0.3)
    touch = Contact("t", base, ROD, body["origin"], ROD, law)
    x = jo.PositionSensor("x", body["origin"])
    model = jo.compile(jo.Mechanism(body, touch, jo.Gravity((0, 0, -G)), x))
    run = jo.simulate(model, 0.01, solver=jo.RK4(1e-4))
    assert np.abs(run["x"] - run["x"][0]).max() < 1e-12


# -- nothing missed, energy -----------------------------------------------------------------------


def test_random_rods_miss_no_plate():
    """Shot at or past a thin plate, with steps far longer than the flight through it."""
    rng = np.random.default_rng(2)
    hit = 0
    for shape in (Cylinder(0.01, 0.05), Ellipsoid((0.02, 0.05, 0.03))) * 5:
        speed, miss = rng.uniform(5, 80), rng.uniform(0.0, 0.4)
        turn = Rotation.random(random_state=rng)
        body = jo.RigidBody(
            "s", 1.0, (1e-4,) * 3, position=(-1, miss, 0), velocity=(speed, 0, 0),
            orientation=turn.as_quat(scalar_first=True),
        )  # fmt: skip
        plate = Cuboid((2e-3, 0.4, 0.4))
        touch = Contact("c", jo.ground["origin"], plate, body["origin"], shape, PowerLaw(1e12))
        since = jo.mechanism.ForceStateSensor("since", touch, "since")
        model = jo.compile(jo.Mechanism(body, touch, since))
        exact = miss - height(shape, turn.inv().apply((0, -1, 0))) < 0.2
        run = jo.simulate(model, 2 / speed, solver=jo.RK4(rng.uniform(0.01, 1.0) / speed))
        assert (run["since"][-1, 0] > 0) == exact, (speed, miss)
        hit += exact
    assert 2 < hit < 9


@pytest.mark.parametrize("solver", [jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)])
def test_thrown_bodies_never_gain_energy(solver):
    rng = np.random.default_rng(8)
    shapes = [ROD, Ellipsoid((0.2, 0.3, 0.1)), WEDGE]
    bodies = [
        jo.RigidBody(
            f"b{i}", 1.0, (0.01, 0.012, 0.015), position=(0.1 * i, 0, 0.5 + 0.6 * i),
            velocity=rng.normal(size=3), angular_velocity=rng.normal(size=3) * 3,
        )
        for i in range(3)
    ]  # fmt: skip
    law = PowerLaw(1e6, 1.0, restitution=0.6)
    touch = [
        Contact(f"f{i}", *FLOOR, b["origin"], shape, law, mu_kinetic=0.3)
        for i, (b, shape) in enumerate(zip(bodies, shapes, strict=True))
    ]
    touch += [
        Contact(
            f"c{i}{k}", bodies[i]["origin"], shapes[i], bodies[k]["origin"], shapes[k], law,
            mu_kinetic=0.3,
        )
        for i in range(3) for k in range(i)
    ]  # fmt: skip
    heights = [jo.PositionSensor(f"p{i}", b["origin"]) for i, b in enumerate(bodies)]
    model = jo.compile(jo.Mechanism(*bodies, *touch, jo.Gravity((0, 0, -G)), *heights))
    run = jo.simulate(model, 1.0, solver=solver)
    energy = run.energy
    total = energy.kinetic + energy.potential + energy.springs
    scale = energy.kinetic.max()
    assert total[-1] < total[0] - 0.1 * scale
    assert np.diff(total).max() < 1e-3 * scale
    assert np.abs(energy.error).max() < 0.01 * scale
    for i in range(3):
        assert run[f"p{i}"][:, 2].min() > -0.01


# -- sets, and what is refused --------------------------------------------------------------------


def test_a_set_finds_them():
    """A cylinder rolls off a box, an ellipsoid falls on it: the same as by single contacts."""
    rod = jo.RigidBody(
        "rod", 1.0, SOLID, position=(0, 0, RADIUS - G / 2e5), velocity=(1, 0, 0),
        orientation=turned(90, 0, 0), angular_velocity=(0, 0, 1 / RADIUS),
    )  # fmt: skip
    egg = jo.RigidBody("egg", 1.0, (1e-3, 2e-3, 2e-3), position=(0.3, 0, 0.2))
    shapes = [
        CollisionShape("floor", *FLOOR),
        CollisionShape("rod", rod["origin"], ROD),
        CollisionShape("egg", egg["origin"], Ellipsoid((0.3, 0.2, 0.1))),
    ]
    law = PowerLaw(1e5, 1.0, restitution=0.3)
    places = [jo.PositionSensor(b.name, b["origin"]) for b in (rod, egg)]
    single = [
        Contact(f"{a.name}{b.name}", a.marker, a.shape, b.marker, b.shape, law, mu_kinetic=0.5)
        for i, b in enumerate(shapes)
        for a in shapes[:i]
    ]
    every = Contacts("set", shapes, law=law, mu_kinetic=0.5, overlap="start")
    runs = []
    for touch in ([every], single):
        items = [rod, egg, *touch, jo.Gravity((0, 0, -G)), *places]
        runs.append(jo.simulate(jo.compile(jo.Mechanism(*items)), 0.22, solver=jo.ROS2(1e-3)))
    for one in ("rod", "egg"):
        np.testing.assert_allclose(runs[0][one][-1], runs[1][one][-1], atol=2e-6)
    assert runs[0]["egg"][-1, 2] < 0.11


@pytest.mark.parametrize("crossed", [True, False])
def test_the_stiffness_of_hertz_is_that_of_the_curvature(crossed):
    """Crossed cylinders K = 4/3 E* sqrt(r); an ellipsoid on a box sqrt(a^2 / c) at its end."""
    surface = Surface("s", 1e7, 0.3, restitution=0.5)
    modulus, load = 1e7 / (2 * (1 - 0.3**2)), 0.01
    radius = RADIUS if crossed else 0.1**2 / 0.05
    egg = Ellipsoid((0.2, 0.2, 0.1))
    sunk = (load / (4 / 3 * modulus * np.sqrt(radius))) ** (2 / 3)
    body = jo.RigidBody(
        "b", 1.0, SOLID, position=(0, 0, (2 * RADIUS if crossed else 0.05) - sunk),
        orientation=turned(90, 0, 90) if crossed else (1, 0, 0, 0),
    )  # fmt: skip
    lying = jo.ground.at((0, 0, 0), turned(90, 0, 0))
    below = (lying, ROD) if crossed else FLOOR
    shapes = [
        CollisionShape("below", *below, surface=surface),
        CollisionShape("b", body["origin"], ROD if crossed else egg, surface=surface),
    ]
    touch = Contacts("set", shapes, overlap="start")
    model = jo.compile(jo.Mechanism(body, touch))
    engine = jo.model.Engine(model)
    engine.accelerations()
    assert engine.a[2] == pytest.approx(load, rel=1e-6)


@pytest.mark.parametrize(
    ("parts", "text"),
    [
        ((2, 3, 1, 0, 1, 2), "face 1, rim 1"),
        ((1, 1, 0, 0, 2, 5), "side, edge 2-5"),
        ((4, 0, 9, 9, 7, 1), "surface, vertex 7"),
    ],
)
def test_parts_have_names(parts, text):
    number = 9 + 5 * parts[0] + parts[1]
    for x in parts[2:]:
        number = 1024 * number + x
    assert features_of(number + 1) == text


@pytest.mark.parametrize("other", [Torus(0.3, 0.1), TriangleMesh.of(np.eye(3), [(0, 1, 2)])])
def test_pairs_that_are_refused(other):
    body = jo.RigidBody("b", 1.0, SOLID)
    with pytest.raises(jo.InputError, match="cannot touch in this version"):
        Contact("t", jo.ground["origin"], other, body["origin"], ROD, PowerLaw(K))


def test_a_half_space_has_its_own_points():
    """The lowest points of a rim and of an ellipsoid: one contact each, as before."""
    body = jo.RigidBody("b", 1.0, SOLID)
    for shape, count in ((ROD, 8), (EGG, 1)):
        touch = Contact("t", jo.ground["origin"], HalfSpace(), body["origin"], shape, PowerLaw(K))
        assert len(touch.pushes) == count
