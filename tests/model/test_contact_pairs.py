"""Contact of convex polytopes: distances, tangents, stacks, tipping, nothing missed."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.optimize import nnls
from scipy.spatial import ConvexHull as Qhull
from scipy.spatial.transform import Rotation

import jousto as jo
from jousto.mechanism import (
    Capsule,
    Contact,
    ConvexHull,
    Cuboid,
    HalfSpace,
    PowerLaw,
    Sphere,
    SpringDamper,
)
from jousto.model import shape_distance

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

G = 9.81
LINEAR = PowerLaw(1e6, 1.0, restitution=0.5)
WEDGE = ConvexHull([(0, 0, 0), (0.5, 0, 0), (0, 0.4, 0), (0.5, 0.4, 0), (0, 0, 0.3), (0, 0.4, 0.3)])


def random_shape(rng: Any, kind: str) -> Any:
    if kind == "cuboid":
        return Cuboid(rng.uniform(0.1, 1.0, 3))
    if kind == "capsule":
        return Capsule(rng.uniform(0.05, 0.3), rng.uniform(0.1, 1.0))
    if kind == "sphere":
        return Sphere(rng.uniform(0.05, 0.3))
    return ConvexHull(rng.normal(size=(rng.integers(6, 60), 3)) * 0.3)


def random_pose(rng: Any) -> tuple[Any, Any]:
    r = rng.normal(size=3)
    r *= rng.uniform(0.3, 1.6) / np.linalg.norm(r)
    return r, Rotation.random(random_state=rng).as_matrix()


def of_difference(a: Any, b: Any, r: Any, R: Any) -> float:
    """The signed distance by the hull of differences of vertices: Qhull and least squares."""
    one, other = a.polytope, b.polytope
    x = (r + other.vertices @ R.T)[:, None] - one.vertices
    x = x.reshape(-1, 3)
    radii = one.radius + other.radius
    if np.linalg.matrix_rank(x - x[0], tol=1e-12) == 3:
        hull = Qhull(x)
        inside = hull.equations[:, 3].max()
        if inside < 0:
            return inside - radii
        x = x[hull.vertices]
    # min |x^T w| with w >= 0, sum w = 1, by a heavy last row (Lawson and Hanson 1974, chapter 23)
    heavy = 1e4
    w, _ = nnls(np.vstack([x.T, np.full(len(x), heavy)]), np.array([0, 0, 0, heavy]), maxiter=2000)
    return float(np.linalg.norm(x.T @ (w / w.sum()))) - radii


KINDS = [
    ("cuboid", "cuboid"), ("cuboid", "hull"), ("hull", "hull"), ("capsule", "cuboid"),
    ("capsule", "capsule"), ("capsule", "hull"), ("hull", "sphere"), ("cuboid", "sphere"),
]  # fmt: skip


@pytest.mark.parametrize("kinds", KINDS, ids="-".join)
def test_distance_by_the_hull_of_differences(kinds):
    rng = np.random.default_rng(4)
    found = np.zeros(2, dtype=int)
    for _ in range(25):
        a, b = (random_shape(rng, kind) for kind in kinds)
        r, R = random_pose(rng)
        gap, normal = shape_distance(a, b, r, R)
        assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-14)
        exact = of_difference(a, b, r, R)
        core = exact + a.polytope.radius + b.polytope.radius
        if core < -0.1:
            continue  # the least of all directions may be one far from the closest points
        found[int(core < 0)] += 1
        assert gap == pytest.approx(exact, abs=1e-12 if core < 0 else 3e-7), (a, b)
    assert found[0] > 5
    assert found[1] > 0 or not {"capsule", "sphere"}.isdisjoint(kinds)


def of_coal(coal: Any, shape: Any) -> Any:
    if isinstance(shape, Cuboid):
        return coal.Box(*shape.lengths)
    if isinstance(shape, Capsule):
        return coal.Capsule(shape.radius, shape.length)
    if isinstance(shape, Sphere):
        return coal.Sphere(shape.radius)
    points = coal.StdVec_Vec3s()
    for x in shape.polytope.vertices:
        points.append(x)
    return coal.Convex.convexHull(points, True, "")


@pytest.mark.parametrize(
    "count", [40, pytest.param(1250, marks=pytest.mark.slow)], ids=["few", "10000 in all"]
)
@pytest.mark.parametrize("kinds", KINDS, ids="-".join)
def test_distance_beside_coal(kinds, count):
    """Random pairs beside the library coal (BSD), distance and normal."""
    coal = pytest.importorskip("coal")
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = 1e-13
    request.gjk_max_iterations = request.epa_max_iterations = 1000
    rng = np.random.default_rng(7)
    for _ in range(count):
        a, b = (random_shape(rng, kind) for kind in kinds)
        r, R = random_pose(rng)
        gap, normal = shape_distance(a, b, r, R)
        result = coal.DistanceResult()
        here, there = coal.Transform3s(), coal.Transform3s(R, r)
        exact = coal.distance(of_coal(coal, a), here, of_coal(coal, b), there, request, result)
        if exact + a.polytope.radius + b.polytope.radius < -0.1:
            continue
        assert gap == pytest.approx(exact, abs=1e-9), (a, b, r, R)
        if exact > 1e-3:
            assert np.abs(normal - result.normal).max() < 1e-7


PAIRS = [
    (Cuboid((0.3, 0.4, 0.5)), Cuboid((0.2, 0.5, 0.3))),
    (Cuboid((0.3, 0.4, 0.5)), WEDGE),
    (Capsule(0.1, 0.4), Capsule(0.15, 0.3)),
    (Cuboid((0.3, 0.4, 0.5)), Capsule(0.1, 0.4)),
    (Capsule(0.1, 0.4), WEDGE),
    (WEDGE, Sphere(0.1)),
    (HalfSpace(), WEDGE),
]


@pytest.mark.parametrize("pair", PAIRS, ids=lambda p: " ".join(type(x).__name__ for x in p))
@pytest.mark.parametrize("mu", [0.0, 0.4])
def test_tangent_is_the_derivative(pair, mu):
    """Newton's matrix against complex steps, for overlapping bodies in general motion."""
    rng = np.random.default_rng(5)
    found, features = 0, set()
    for _ in range(100):
        turn = Rotation.random(2, random_state=rng).as_quat(scalar_first=True)
        v, w = rng.normal(size=(2, 2, 3))
        a = jo.RigidBody("a", 2.0, (0.1, 0.2, 0.25), orientation=turn[0], velocity=v[0])
        apart = rng.normal(size=3)
        apart *= rng.uniform(0.05, 0.5) / np.linalg.norm(apart)
        b = jo.RigidBody(
            "b", 1.0, (0.05, 0.06, 0.07), position=apart, orientation=turn[1],
            velocity=v[1], angular_velocity=w[1],
        )  # fmt: skip
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
            assert np.abs(M - N).max() <= 1e-11 * np.abs(M).max()
        found += 1
        features |= set((states[phase > 0, 6] // 1024**4).astype(int))
    assert found > 5
    assert features


# -- faces ----------------------------------------------------------------------------------------


def stack(count: int, size: tuple[float, float, float], shift: Any = 0.0, **more: Any) -> Any:
    """Bodies of 2 kg on each other and on a plate, at rest; each is shifted by (count,) m."""
    bodies: list[Any] = []
    contacts = []
    x = np.broadcast_to(shift, (count,))
    z, under, shape = 0.0, jo.ground.at((0, 0, -0.05)), Cuboid((4, 4, 0.1))
    m = 2.0
    J = [m * (sum(s * s for s in size) - s * s) / 12 for s in size]
    for i in range(count):
        z -= (count - i) * m * G / 4e6
        body = jo.RigidBody(f"b{i}", m, J, position=(x[i], 0, z + size[2] / 2))
        law = PowerLaw(1e6, 1.0, restitution=0.5)
        contacts.append(Contact(f"c{i}", under, shape, body["origin"], Cuboid(size), law, **more))
        z += size[2]
        under, shape = body["origin"], Cuboid(size)
        bodies.append(body)
    return bodies, contacts


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("solver", [jo.RK4(1e-4), jo.GeneralizedAlpha(1e-3), jo.ROS2(1e-3)])
def test_stack_of_five_stands_still(core, solver):
    """Five boxes of 2 kg, 1e6 N/m a corner: 24.525 N and 2.4525e-5 m at the lowest corners."""
    bodies, contacts = stack(5, (0.2, 0.2, 0.1), mu_kinetic=0.3)
    force = jo.ForceSensor("f", contacts[0])
    place = [jo.PositionSensor(f"p{i}", b["origin"]) for i, b in enumerate(bodies)]
    gravity = jo.Gravity((0, 0, -G))
    model = jo.compile(jo.Mechanism(*bodies, *contacts, gravity, force, *place), core=core)
    run = jo.simulate(model, 0.1, solver=solver)
    assert run["f"][-1, 2] / 4 == pytest.approx(24.525, rel=1e-9)
    assert 0.05 - run["p0"][-1, 2] == pytest.approx(2.4525e-5, rel=1e-9)
    for i in range(5):
        assert np.abs(run[f"p{i}"] - run[f"p{i}"][0]).max() < 1e-14


def test_lowest_frequency_of_the_stack():
    """402.527148826 1/s: masses of 2 kg on springs of 4e6 N/m."""
    bodies, contacts = stack(5, (0.2, 0.2, 0.1))
    guides = [
        jo.Prismatic(f"g{i}", jo.ground.at(b.position), b["origin"], axis=(0, 0, 1))
        for i, b in enumerate(bodies)
    ]
    model = jo.compile(jo.Mechanism(*bodies, *contacts, *guides, jo.Gravity((0, 0, -G))))
    engine = jo.model.Engine(model)
    engine.accelerations()
    z = np.arange(5) * 6 + 2
    K = -np.asarray(engine.tangent().K)[np.ix_(z, z)]
    lowest = np.sqrt(np.abs(np.linalg.eigvals(K / 2.0)).min())
    assert lowest == pytest.approx(402.527148826, rel=1e-11)
    assert lowest == pytest.approx(2 * np.sqrt(4e6 / 2) * np.sin(np.pi / 22), rel=1e-11)


@pytest.mark.parametrize(("beyond", "tips"), [(-0.1, False), (0.1, True)])
def test_block_tips_over_its_edge(beyond, tips):
    """0.1 x 0.2: at 26.56505117708 degrees, on a plate and on a half-space of hulls."""
    angle = np.radians(26.56505117708 + beyond)
    for on, at in ((Cuboid((2, 2, 0.1)), (0, 0, -0.05)), (HalfSpace(), (0, 0, 0))):
        block = ConvexHull(list(product((-0.05, 0.05), (-0.05, 0.05), (-0.1, 0.1))))
        body = jo.RigidBody("b", 1.0, (0.0042, 0.0042, 0.0017), position=(0, 0, 0.1))
        law = SpringDamper(1e9, 1e5)  # no overshoot as it is released
        touch = Contact("c", jo.ground.at(at), on, body["origin"], block, law, mu_kinetic=2.0)
        ramp = jo.Gravity((G * np.sin(angle), 0, -G * np.cos(angle)))
        x = jo.PositionSensor("x", body["origin"])
        model = jo.compile(jo.Mechanism(body, touch, ramp, x))
        run = jo.simulate(model, 0.6, solver=jo.GeneralizedAlpha(1e-3))
        assert (np.ptp(run["x"][:, 0]) > 5e-5) == tips, (on.tag, np.ptp(run["x"][:, 0]))


@pytest.mark.parametrize(("share", "falls"), [(0.98, False), (1.02, True)])
def test_bricks_overhang_by_the_harmonic_series(share, falls):
    """Four bricks: the top one ends 1.041666666667 of a half length beyond the table, at most."""
    overhang = 0.5 * share * np.cumsum([1 / 4, 1 / 3, 1 / 2, 1.0])
    bodies, contacts = stack(4, (1.0, 0.5, 0.1), overhang - 0.5, mu_kinetic=0.5)
    table = Cuboid((4, 4, 0.1))
    first = contacts[0]
    contacts[0] = Contact(
        "c0", jo.ground.at((-2, 0, -0.05)), table, first.b, first.shape_b, first.law, mu_kinetic=0.5
    )
    assert overhang[-1] == pytest.approx(1.041666666667 * share)
    top = jo.PositionSensor("top", bodies[-1]["origin"])
    model = jo.compile(jo.Mechanism(*bodies, *contacts, jo.Gravity((0, 0, -G)), top))
    run = jo.simulate(model, 0.7, solver=jo.GeneralizedAlpha(1e-3))
    assert (run["top"][0, 2] - run["top"][-1, 2] > 2e-3) == falls


def test_legs_of_a_table():
    """1 x 0.6 m, 100 N at (0.1, 0.05): 34.16666666667 N in the nearest leg."""
    legs = [(x, y) for x in (-0.5, 0.5) for y in (-0.3, 0.3)]
    plate = ConvexHull([(x, y, z) for x, y in legs for z in (0.0, 0.1)])
    body = jo.RigidBody("t", 1.0, (1, 1, 1), center=(0.1, 0.05, 0), position=(0, 0, -25e-9))
    law = PowerLaw(1e9, 1.0, restitution=0.2)
    touch = Contact("c", jo.ground["origin"], HalfSpace(), body["origin"], plate, law)
    load = jo.Gravity((0, 0, -100.0))
    place = [jo.PositionSensor(f"l{i}", body.at((x, y, 0))) for i, (x, y) in enumerate(legs)]
    model = jo.compile(jo.Mechanism(body, touch, load, *place))
    run = jo.simulate(model, 3.0, solver=jo.GeneralizedAlpha(1e-2, rho=0.0))
    force = [-1e9 * run[f"l{i}"][-1, 2] for i in range(4)]
    exact = [25 * (1 + 0.1 * x / 0.25 + 0.05 * y / 0.09) for x, y in legs]
    assert max(exact) == pytest.approx(34.16666666667)
    assert force == pytest.approx(exact, rel=1e-6)


def test_weights_of_a_part_of_a_face():
    """A box half over another one: half of the stiffness, in the middle of the half."""
    top = Cuboid((0.2, 0.2, 0.1))
    sunk = 2 * G / (2 * 1e6)
    body = jo.RigidBody("b", 2.0, (1, 1, 1), position=(0.1, 0, 0.1 - sunk), center=(-0.05, 0, 0))
    touch = Contact("c", jo.ground["origin"], top, body["origin"], top, LINEAR)
    place = jo.PositionSensor("p", body["origin"])
    model = jo.compile(jo.Mechanism(body, touch, jo.Gravity((0, 0, -G)), place))
    run = jo.simulate(model, 0.2, solver=jo.RK4(1e-4))
    assert np.abs(run["p"] - run["p"][0]).max() < 1e-12


@pytest.mark.parametrize("heading", [0.0, 20.0, 45.0])
def test_box_slides_on_a_box(heading):
    """2 m/s, mu 0.4: it stops after v^2 / 2 mu g, and then it does not creep."""
    e = np.array([np.cos(np.radians(heading)), np.sin(np.radians(heading)), 0.0])
    K, m = 1e8, 1.0
    body = jo.RigidBody(
        "b", m, (0.01,) * 3, center=(0, 0, -0.05), velocity=2 * e,
        position=(0, 0, 0.05 - m * G / (4 * K)),
    )  # fmt: skip
    touch = Contact(
        "c", jo.ground.at((0, 0, -0.5)), Cuboid((9, 9, 1)), body["origin"], Cuboid((0.2, 0.2, 0.1)),
        PowerLaw(K, 1.0), mu_kinetic=0.4,
    )  # fmt: skip
    x, v = jo.PositionSensor("x", body["origin"]), jo.VelocitySensor("v", body["origin"])
    model = jo.compile(jo.Mechanism(body, touch, jo.Gravity((0, 0, -G)), x, v))
    run = jo.simulate(model, 1.0, solver=jo.GeneralizedAlpha(1e-3))
    assert run["x"][-1] @ e == pytest.approx(4 / (2 * 0.4 * G), rel=1e-4)
    assert np.abs(run["v"][-1]).max() < 1e-12


def test_bristles_stay_as_a_box_is_pushed_over_an_edge():
    """Its corners change, from vertices to crossings of edges; force and energy do not jump."""
    K = 1e6
    body = jo.RigidBody("b", 2.0, (0.01,) * 3, position=(0, 0, 0.1 - 2 * G / (4 * K)))
    touch = Contact(
        "c", jo.ground["origin"], Cuboid((0.3, 0.3, 0.1)), body["origin"], Cuboid((0.2, 0.2, 0.1)),
        PowerLaw(K, 1.0), mu_kinetic=0.3,
    )  # fmt: skip
    slide = jo.RigidBody("s", 1.0, (0.01,) * 3)
    rail = jo.Prismatic("r", jo.ground["origin"], slide["origin"], axis=(1, 0, 0))
    guide = jo.Prismatic("g", slide["origin"], body["origin"], axis=(0, 0, 1))
    drive = jo.Drive(
        "d",
        rail.displacement,
        jo.Harmonic(amplitude=0.04, frequency=0.5, phase=-np.pi / 2, offset=0.04),
    )
    force = jo.ForceSensor("f", touch)
    model = jo.compile(
        jo.Mechanism(body, slide, touch, rail, guide, drive, force, jo.Gravity((0, 0, -G)))
    )
    run = jo.simulate(model, 1.0, solver=jo.GeneralizedAlpha(1e-3))
    moving = (run.time > 0.05) & (run.time < 0.95)
    assert run["f"][:, 2] == pytest.approx(2 * G, rel=1e-3)
    assert run["f"][moving, 0] == pytest.approx(-0.3 * 2 * G, rel=1e-3)


# -- nothing missed -------------------------------------------------------------------------------


def test_rod_swung_into_a_pin():
    """0.4 m, 10 mm thick, 300 rad/s, step 5 ms: the pin of 2 mm at (0.21, 0.15) is met."""
    rod = jo.RigidBody(
        "rod", 2.0, (1e-3, 2 * 0.4**2 / 12, 2 * 0.4**2 / 12), center=(0.2, 0, 0),
        angular_velocity=(0, 0, 300.0),
    )  # fmt: skip
    pivot = jo.Revolute("p", jo.ground["origin"], rod["origin"], axis=(0, 0, 1))
    touch = Contact(
        "c", jo.ground.at((0.21, 0.15, 0)), Capsule(2e-3, 0.1), rod.at((0.2, 0, 0)),
        Cuboid((0.4, 0.01, 0.02)), PowerLaw(1e10, 1.0, restitution=0.5),
    )  # fmt: skip
    since = jo.mechanism.ForceStateSensor("since", touch, "since")
    model = jo.compile(jo.Mechanism(rod, pivot, touch, since))
    run = jo.simulate(model, 5e-3, solver=jo.RK4(5e-3))
    assert run["since"][-1, 0] == pytest.approx(1.977072365899e-3, rel=1e-9)


def test_random_boxes_miss_no_plate():
    """Boxes shot at or past a thin plate, with steps far longer than the flight through it."""
    rng = np.random.default_rng(2)
    hit = 0
    for _ in range(25):
        speed, miss = rng.uniform(5, 80), rng.uniform(0.0, 0.4)
        body = jo.RigidBody(
            "s", 1.0, (1e-4,) * 3, position=(-1, miss, 0), velocity=(speed, 0, 0),
            orientation=Rotation.random(random_state=rng).as_quat(scalar_first=True),
        )  # fmt: skip
        plate = Cuboid((2e-3, 0.4, 0.4))
        box = Cuboid((0.02, 0.03, 0.04))
        touch = Contact("c", jo.ground["origin"], plate, body["origin"], box, PowerLaw(1e12))
        since = jo.mechanism.ForceStateSensor("since", touch, "since")
        model = jo.compile(jo.Mechanism(body, touch, since))
        R = np.asarray(Rotation.from_quat(body.orientation, scalar_first=True).as_matrix())
        exact = miss - np.abs(R[1]) @ (0.01, 0.015, 0.02) < 0.2
        run = jo.simulate(model, 2 / speed, solver=jo.RK4(rng.uniform(0.01, 1.0) / speed))
        assert (run["since"][-1, 0] > 0) == exact, (speed, miss)
        hit += exact
    assert 5 < hit < 20


@pytest.mark.parametrize("solver", [jo.RK4(1e-3), jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)])
def test_thrown_boxes_never_gain_energy(solver):
    rng = np.random.default_rng(8)
    floor = (jo.ground.at((0, 0, -0.5)), Cuboid((9, 9, 1)))
    shapes = [Cuboid((0.2, 0.3, 0.1)), WEDGE, Capsule(0.1, 0.3)]
    bodies = [
        jo.RigidBody(
            f"b{i}", 1.0, (0.01, 0.012, 0.015), position=(0.1 * i, 0, 0.5 + 0.6 * i),
            velocity=rng.normal(size=3), angular_velocity=rng.normal(size=3) * 3,
        )
        for i in range(3)
    ]  # fmt: skip
    law = PowerLaw(1e6, 1.0, restitution=0.6)
    touch = [
        Contact(f"f{i}", *floor, b["origin"], shape, law, mu_kinetic=0.3)
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
    run = jo.simulate(model, 1.5, solver=solver)
    energy = run.energy
    total = energy.kinetic + energy.potential + energy.springs
    scale = energy.kinetic.max()
    assert total[-1] < total[0] - 0.1 * scale
    assert np.diff(total).max() < 1e-3 * scale
    assert np.abs(energy.error).max() < 0.01 * scale
    for i in range(3):
        assert run[f"p{i}"][:, 2].min() > -0.01


# -- what is refused ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], "has 3 points, needs 4"),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0.3, 0.2, 0)], "is flat"),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, float("nan"))], "points"),
        (Rotation.random(1200, random_state=1).apply((0, 0, 1.0)), "take fewer points"),
    ],
)
def test_hulls_that_are_refused(points, message):
    with pytest.raises(jo.InputError, match=message):
        ConvexHull(points)


def test_pairs_that_have_no_distance():
    with pytest.raises(jo.InputError, match="shape_b is a half-space"):
        shape_distance(Sphere(0.1), HalfSpace())


@pytest.mark.parametrize("turn", [0.0, 1e-12, 1e-6])
@pytest.mark.parametrize(
    ("under", "beside", "share"),
    [
        (Cuboid((0.1,) * 3), 0.052, 1.0),  # round the edge of a box, whose edge is parallel
        (Cuboid((0.1, 0.05, 0.1)), 0.052, 0.05 / 0.06),  # a box that is narrower
        (Capsule(0.05, 0.1), 0.01, 1.0),
        (Capsule(0.05, 0.04), 0.01, 1.0),  # the shorter one counts
    ],
    ids=["box", "narrow", "capsule", "short"],
)
def test_a_capsule_along_an_edge_touches_at_both_ends(under, beside, share, turn):
    """Two parallel edges: v sqrt(m / 2 K) deep with both ends, and nothing falls through."""
    half = np.pi / 4
    lying = (np.cos(half), np.sin(half), 0, 0)  # the axis of the capsule along y
    a = jo.ground["origin"]
    if isinstance(under, Capsule):
        a = jo.RigidBody("pole", 1.0, (1, 1, 1), orientation=lying)["origin"]
    along = (np.cos(half + turn), np.sin(half + turn), 0, 0)
    rod = jo.RigidBody(
        "rod", 1.0, (1e-3,) * 3, position=(beside, 0, 0.08), velocity=(0, 0, -1), orientation=along
    )
    contact = Contact(
        "c", a, under, rod["origin"], Capsule(0.02, 0.06), PowerLaw(1e6, 1.0, restitution=1.0)
    )
    items = [rod, contact, jo.VelocitySensor("v", rod["origin"])]
    if a.body is not jo.ground:
        items += [a.body, jo.Fixed("held", jo.ground["origin"], a)]
    run = jo.simulate(jo.compile(jo.Mechanism(*items)), 0.03, solver=jo.RK4(1e-4))
    (event,) = run.contacts
    assert np.linalg.norm(run["v"][-1]) == pytest.approx(1.0, rel=1e-5)
    assert run["v"][-1, 2] > 0.8
    assert event.depth == pytest.approx(event.approach * np.sqrt(1 / (2e6 * share)), rel=2e-3)
    assert np.abs(run.energy.error).max() < 1e-5
