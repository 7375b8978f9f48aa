"""Contact with surfaces of triangles: planes, edges, valleys, shells, nothing missed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial import Delaunay
from scipy.spatial.transform import Rotation

import jousto as jo
from jousto.mechanism import (
    Capsule,
    Contact,
    ConvexHull,
    Cuboid,
    ForceStateSensor,
    HalfSpace,
    HeightField,
    Hertz,
    PowerLaw,
    Sphere,
    Torus,
    TriangleMesh,
)
from jousto.mechanism.bodies.shapes import box, sphere
from jousto.mechanism.contacts.crossings import crossing_pairs
from jousto.mechanism.contacts.triangles import LEAF, Triangles, _boxes
from jousto.model import shape_distance

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

G = 9.81
STIFF = PowerLaw(1e7, 1.0, restitution=0.5)


def plane(rng: Any, count: int = 40, size: float = 1.0, thickness: float = 0.0) -> TriangleMesh:
    """A square of random triangles at z = 0, in random order, each beginning anywhere."""
    side = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=float)
    x = size * np.concatenate([side, rng.uniform(-1, 1, (count, 2))])
    triangles = Delaunay(x).simplices
    triangles = rng.permutation(triangles)
    for one in triangles:
        one[:] = np.roll(one, rng.integers(3))
        if np.linalg.det([x[one[1]] - x[one[0]], x[one[2]] - x[one[0]]]) < 0.0:
            one[:] = one[::-1]
    return TriangleMesh.of(np.column_stack([x, np.zeros(len(x))]), triangles, thickness=thickness)


def solid(lengths: Any, at: Any = (0, 0, 0), turn: Any = None) -> Any:
    """Triangles of a box."""
    x = box(np.asarray(lengths, dtype=float)).triangles
    return (x if turn is None else x @ np.asarray(turn).T) + np.asarray(at)


def profile(points: Any, wide: float = 1.0) -> TriangleMesh:
    """The ground under a line in the plane of x and z, extended along y."""
    x = np.asarray(points, dtype=float)
    n = len(x)
    low = x[:, 1].min() - 1.0
    ring = np.concatenate([x, [[x[-1, 0], low], [x[0, 0], low]]])
    left, right = (np.insert(ring, 1, y, axis=1) for y in (wide, -wide))
    index = np.arange(n + 2)
    after = np.roll(index, -1)
    sides = [
        np.stack([index, index + n + 2, after + n + 2], axis=1),
        np.stack([index, after + n + 2, after], axis=1),
    ]
    # caps: strips down to the base, which is level
    feet = np.insert(np.column_stack([x[:, 0], np.full(n, low)]), 1, wide, axis=1)
    caps = []
    for i in range(n - 1):
        a, b = left[i], left[i + 1]
        c, d = feet[i + 1], feet[i]
        for tri in ([a, b, c], [a, c, d]):
            tri = np.array(tri)
            caps += [tri, (tri * [1, -1, 1])[::-1]]
    lower = []
    for i in range(n - 1):
        a, b = feet[i], feet[i + 1]
        lower += [[a, b, b * [1, -1, 1]], [a, b * [1, -1, 1], a * [1, -1, 1]]]
    points = np.concatenate([left, right])
    top = [t for part in sides for t in part[: n - 1]]
    ends = []
    for i, out in ((0, -1), (n - 1, 1)):
        a, b = left[i], right[i]
        c, d = b * [1, 1, 0] + [0, 0, low], a * [1, 1, 0] + [0, 0, low]
        quad = [[a, d, c], [a, c, b]] if out < 0 else [[a, c, d], [a, b, c]]
        ends += quad
    return TriangleMesh(
        np.concatenate([points[np.array(top)], np.array(caps), np.array(lower), np.array(ends)])
    )


def ball(at: Any, r: float = 0.05, mass: float = 1.0, **more: Any) -> Any:
    return jo.RigidBody.sphere("ball", radius=r, mass=mass, position=at, **more)


def rolling(shape: Any, at: Any, v: Any, solver: Any, t: float, **more: Any) -> Any:
    """A ball of 1 kg that begins to roll on a surface; results every step."""
    r = more.pop("r", 0.05)
    mass = more.pop("mass", 1.0)
    law, mu = more.pop("law", STIFF), more.pop("mu", 0.5)
    core, gravity = more.pop("core", "auto"), more.pop("gravity", (0, 0, -G))
    body = ball(at, r, mass, velocity=v, angular_velocity=more.pop("w", (-v[1] / r, v[0] / r, 0)))
    contact = Contact(
        "c", jo.ground["origin"], shape, body["origin"], Sphere(r), law, mu_kinetic=mu
    )
    sensors = [
        jo.PositionSensor("x", body["origin"]),
        jo.VelocitySensor("v", body["origin"]),
        jo.ForceSensor("F", contact),
        ForceStateSensor("phase", contact, "phase"),
    ]
    model = jo.compile(jo.Mechanism(body, contact, jo.Gravity(gravity), *sensors), core=core)
    return jo.simulate(model, t, solver=solver)


# -- planes ---------------------------------------------------------------------------------------


def test_any_triangles_of_a_plane_have_its_distance():
    """200 random triangulations: distance and normal to rounding, over edges and corners too."""
    rng = np.random.default_rng(1)
    for _ in range(200):
        floor = plane(rng, int(rng.integers(0, 60)))
        corners = floor.mesh.vertices[:, :2]
        edge = 0.5 * (corners[floor.mesh.corners[0, 0]] + corners[floor.mesh.corners[0, 1]])
        for x, y in [*(0.98 * rng.uniform(-1, 1, (5, 2))), *(0.9 * corners[:3]), 0.99 * edge]:
            gap, normal = shape_distance(floor, Sphere(0.05), (x, y, 0.07))
            assert abs(gap - 0.02) < 1e-15
            assert np.abs(normal - (0, 0, 1)).max() < 1e-15


@pytest.mark.parametrize("solver", [jo.RK4(1e-3), jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)])
@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_a_ball_rolls_over_triangles_as_over_a_plane(solver, core):
    """Force = weight, height constant to 1e-12 m, and the path that of a half-space."""
    rng = np.random.default_rng(2)
    at = (-0.7, 0.1, 0.05 - G / 1e7)
    want = rolling(HalfSpace(), at, (1.3, 0.2, 0), solver, 1.0, core=core)
    for closed in (False, True):
        floor = plane(rng, 200) if not closed else HeightField(np.zeros((13, 9)), 2.0, 2.0)
        run = rolling(floor, at, (1.3, 0.2, 0), solver, 1.0, core=core)
        assert np.ptp(run["x"][:, 2]) < 1e-12
        assert np.abs(run["F"][1:, 2] - G).max() < 1e-7
        assert np.abs(run["x"] - want["x"]).max() < 1e-12


def test_tilted_triangles_of_any_form_are_one_plane():
    """Triangles as narrow as 1e-8 of their length, in a plane of any direction."""
    rng = np.random.default_rng(3)
    for _ in range(20):
        x = np.concatenate([rng.uniform(-1, 1, (30, 2)), [(-1, -1), (1, -1), (1, 1), (-1, 1)]])
        x[:6] = x[6:12] + 1e-8 * rng.normal(size=(6, 2))
        turn = Rotation.random(random_state=rng).as_matrix()
        p = np.column_stack([x, np.zeros(len(x))]) @ turn.T
        floor = TriangleMesh.of(p, _upward(p, Delaunay(x).simplices, turn[:, 2]))
        for _ in range(10):
            place = turn @ (*rng.uniform(-0.7, 0.7, 2), 0.07)
            gap, normal = shape_distance(floor, Sphere(0.05), place)
            assert abs(gap - 0.02) < 1e-14
            assert np.abs(normal - turn[:, 2]).max() < 1e-14


def test_a_point_just_below_a_tilted_plane_has_its_normal():
    """1e-9 m deep over an edge, a corner or a face: force and direction as over a plane."""
    rng = np.random.default_rng(12)
    for _ in range(10):
        turn = Rotation.random(random_state=rng).as_matrix()
        slab = TriangleMesh(HeightField(np.zeros((5, 5)), 1.0, 1.0).triangles @ turn.T)
        (x, y), depth = rng.integers(-1, 2, 2) * 0.25 + rng.choice([0, 0.125]), 1e-9
        body = ball(tuple(turn @ (x, y, -depth)))
        law = PowerLaw(1e9, 1.0, restitution=1.0)
        contact = Contact("c", jo.ground["origin"], slab, body["origin"], Sphere(0.0), law)
        force = np.array(
            jo.model.Engine(jo.compile(jo.Mechanism(body, contact))).accelerations()[0]
        )
        assert np.linalg.norm(force[:3]) == pytest.approx(1.0, rel=1e-6)
        assert np.abs(force[:3] / np.linalg.norm(force[:3]) - turn[:, 2]).max() < 1e-14


def _upward(p: Any, triangles: Any, n: Any) -> Any:
    a, b, c = (p[triangles[:, i]] for i in range(3))
    down = np.cross(b - a, c - a) @ n < 0.0
    return np.where(down[:, None], triangles[:, ::-1], triangles)


# -- edges and valleys ----------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_ball_parts_from_an_edge_above_a_speed(share):
    """50 mm over 10 degrees down: it stays below v^2 = g R (17 cos a - 10) / 7 = 0.687316 m/s."""
    a, v = np.radians(10), 0.6873156322651
    assert v == pytest.approx(np.sqrt(G * 0.05 * (17 * np.cos(a) - 10) / 7), rel=1e-12)
    ground = profile([(-1, 0), (0, 0), (2 * np.cos(a), -2 * np.sin(a))])
    law = PowerLaw(1e10, 1.0, restitution=0.5)
    at = (-0.01, 0, 0.05 - G / 1e10)
    run = rolling(ground, at, (share * v, 0, 0), jo.RK4(1e-5), 0.04, mu=5.0, law=law)
    gap = max(closest(ground.triangles, x) for x in run["x"][::10]) - 0.05
    assert gap > 2e-7 if share > 1 else gap < 2e-8  # the contact itself is 1e-9 m deep


def test_a_ball_goes_up_a_slope():
    """Without friction and bounce 1 m/s becomes cos 10 deg = 0.984807753 m/s."""
    a = np.radians(10)
    ground = profile([(-1, 0), (0, 0), (2 * np.cos(a), 2 * np.sin(a))])
    law = PowerLaw(1e9, 1.0, restitution=1e-3)
    at = (-0.05, 0, 0.05)
    run = rolling(ground, at, (1, 0, 0), jo.RK4(1e-4), 0.06, mu=0.0, law=law, gravity=(0, 0, 0))
    assert np.linalg.norm(run["v"][-1]) == pytest.approx(0.984807753012, abs=2e-4)


@pytest.mark.parametrize(("half", "wall"), [(45.0, 0.341566659877), (30.0, 0.4830482028525)])
@pytest.mark.parametrize("solver", [jo.RK4(2e-4), jo.GeneralizedAlpha(2e-4)])
def test_a_ball_rolls_down_a_groove(half, wall, solver):
    """Two contacts at once: 10 mm, 50 g, slope 10 deg; acceleration and force of the walls."""
    turn, s = np.radians(half), np.radians(10)
    r, mass, K = 0.01, 0.05, 1e7
    x = 0.1 * np.sin(turn)
    groove = profile([(-x, 0.1 * np.cos(turn)), (0, 0), (x, 0.1 * np.cos(turn))], wide=0.5)
    sunk = wall / K / np.sin(turn)
    at = (0, -0.4, r / np.sin(turn) - sunk)
    gravity = (0, G * np.sin(s), -G * np.cos(s))
    law = PowerLaw(K, 1.0, restitution=0.5)
    run = rolling(
        groove, at, (0, 0, 0), solver, 0.2, r=r, mass=mass, law=law, gravity=gravity, mu=0.8
    )
    reach = r * np.sin(turn)
    a = G * np.sin(s) / (1 + 0.4 * (r / reach) ** 2)
    if half == 45.0:
        assert a == pytest.approx(0.9463825682848, rel=1e-12)
    assert run["v"][-1, 1] == pytest.approx(a * 0.2, rel=2e-4)
    # the force of both walls is the weight across the groove
    assert run["F"][-1, 2] == pytest.approx(2 * wall * np.sin(turn), rel=1e-6)
    assert mass * G * np.cos(s) / (2 * np.sin(turn)) == pytest.approx(wall, rel=1e-12)
    assert np.ptp(run["x"][5:, 2]) < 1e-9


def test_the_force_has_no_peak_where_edges_are_passed():
    """Over a hill of facets of 1.5 degrees, rolling: no impact at the edges."""
    angle = np.radians(np.arange(-60, 61, 1.5) + 0.75)
    hill = profile(np.column_stack([np.sin(angle), np.cos(angle)]))
    K = 1e7
    at = (0.0, 0, np.cos(np.radians(0.75)) + 0.05 - G / K)
    run = rolling(hill, at, (0.2, 0, 0), jo.RK4(1e-4), 0.6, mu=0.5)
    F = np.linalg.norm(run["F"][5:, :3], axis=1)
    speed = np.linalg.norm(run["v"][5:], axis=1)
    passed = np.degrees(np.arctan2(run["x"][-1, 0], run["x"][-1, 2])) / 1.5
    assert passed > 4 and speed.max() < 0.6
    # at an edge the radius of the path falls to that of the ball: the force by m v^2 / r at most,
    # and by as much again while the contact springs
    steady = G * run["x"][5:, 2] / np.hypot(run["x"][5:, 0], run["x"][5:, 2])
    assert (np.abs(F - steady) < 2.1 * speed**2 / 0.05 + 0.05).all()
    distance = [closest(hill.triangles, x) for x in run["x"][::50]]
    assert np.abs(np.array(distance) - 0.05).max() < 3e-6


def test_bristle_persists_from_triangle_to_triangle():
    """A point slides over fine triangles on a line, and stops as on a plane: v^2 / 2 mu g."""
    rng = np.random.default_rng(6)
    for heading in (0.0, 0.3, 1.1):
        e = np.array([np.cos(heading), np.sin(heading), 0.0])
        run = rolling(
            plane(rng, 500), (0, 0, 0.05 - G / 1e7), tuple(2 * e), jo.RK4(2e-4), 0.6, w=(0, 0, 0)
        )
        want = rolling(
            HalfSpace(), (0, 0, 0.05 - G / 1e7), tuple(2 * e), jo.RK4(2e-4), 0.6, w=(0, 0, 0)
        )
        assert np.abs(run["x"] - want["x"]).max() < 1e-12


# -- distances and tangents -----------------------------------------------------------------------


def closest(triangles: Any, c: Any) -> float:
    """Distance of a place from triangles by their planes, edges and corners, one by one."""
    a, b, d = np.moveaxis(triangles, 1, 0)
    n = np.cross(b - a, d - a)
    n /= np.linalg.norm(n, axis=1)[:, None]
    height = np.einsum("ti,ti->t", c - a, n)
    foot = c - height[:, None] * n
    inside = np.ones(len(a), dtype=bool)
    best = np.full(len(a), np.inf)
    for p, q in ((a, b), (b, d), (d, a)):
        inside &= np.einsum("ti,ti->t", np.cross(q - p, foot - p), n) >= 0
        t = np.clip(np.einsum("ti,ti->t", c - p, q - p) / ((q - p) ** 2).sum(axis=1), 0, 1)
        best = np.minimum(best, np.linalg.norm(p + t[:, None] * (q - p) - c, axis=1))
    return float(np.where(inside, np.abs(height), best).min())


def test_distance_by_looking_at_all_triangles():
    """A bumpy ball, not convex: 1000 places inside and outside, to 1e-14."""
    rng = np.random.default_rng(4)
    x = sphere(1.0).triangles
    x = x * (1 + 0.3 * np.sin(3 * x[..., :1]) * np.cos(4 * x[..., 1:2]))
    mesh = TriangleMesh(x)
    assert mesh.mesh.closed
    inside = 0
    for _ in range(1000):
        c = rng.uniform(-1.4, 1.4, 3)
        gap, normal = shape_distance(mesh, Sphere(0.1), c)
        s = 1 + 0.3 * np.sin(3 * c[0] / np.linalg.norm(c)) * np.cos(4 * c[1] / np.linalg.norm(c))
        if abs(np.linalg.norm(c) - s) > 0.05:
            assert (gap + 0.1 < 0) == (np.linalg.norm(c) < s)
        inside += gap + 0.1 < 0
        assert abs(abs(gap + 0.1) - closest(x, c)) < 1e-14
        assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-14)
    assert 100 < inside < 900


STAR = TriangleMesh(
    np.concatenate([solid((0.6, 0.25, 0.25)), solid((0.3, 0.3, 0.3), (0.0, 0.0, 0.6))])
)
SHELL = TriangleMesh(
    np.array([[(0, 0, 0), (0.5, 0, 0), (0, 0.5, 0)], [(0, 0, 0), (0, -0.5, 0.2), (0.5, 0, 0)]]),
    thickness=0.02,
)
PAIRS = [
    (STAR, Sphere(0.2)),
    (STAR, Cuboid((0.3, 0.4, 0.5))),
    (STAR, Capsule(0.1, 0.4)),
    (SHELL, Sphere(0.15)),
    (SHELL, Cuboid((0.3, 0.4, 0.5))),
    (HalfSpace(), STAR),
]


@pytest.mark.parametrize("pair", PAIRS, ids=lambda p: " ".join(type(x).__name__ for x in p))
@pytest.mark.parametrize("mu", [0.0, 0.4])
def test_tangent_is_the_derivative(pair, mu):
    """Newton's matrix against complex steps, for overlapping bodies in general motion."""
    rng = np.random.default_rng(5)
    found = 0
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
        phase = np.array(engine.states).reshape(-1, 8)[:, 0]
        if not phase.any() or (mu and (phase == 1).any()):
            continue  # a bristle that sticks is moved by its states
        engine.accelerations()
        exact = engine.tangent()
        for M, weights in ((exact.K, (0.0, 0.0, 1.0)), (exact.D, (0.0, 1.0, 0.0))):
            N = engine.newton_matrix(*weights)[: len(M), : len(M)]
            assert np.abs(M - N).max() <= 1e-11 * np.abs(M).max()
        found += 1
    assert found > 5


# -- nothing missed -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "plate",
    [
        TriangleMesh(solid((2e-3, 1, 1))),
        TriangleMesh(
            np.array([[(0, -0.5, -0.5), (0, 0.5, -0.5), (0, 0.5, 0.5)],
                      [(0, -0.5, -0.5), (0, 0.5, 0.5), (0, -0.5, 0.5)]]),
            thickness=2e-3,
        ),
    ],
    ids=["solid", "shell"],
)  # fmt: skip
@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("solver", [jo.RK4(1e-3), jo.ROS2(1e-3), jo.RK4(5e-3)])
def test_shot_at_a_thin_plate(plate, side, solver):
    """100 m/s at a free plate of 2 mm, step 1 ms, from either side."""
    shot = jo.RigidBody(
        "s", 0.01, (1e-7,) * 3, position=(side * 0.237, 0, 0), velocity=(-100 * side, 0, 0)
    )
    body = jo.RigidBody("p", 1.0, (0.1,) * 3)
    contact = Contact(
        "c", body["origin"], plate, shot["origin"], Sphere(5e-3), PowerLaw(1e9, restitution=0.6)
    )
    sensors = (jo.VelocitySensor("v", shot["origin"]), jo.VelocitySensor("V", body["origin"]))
    touched = ForceStateSensor("since", contact, "since")
    model = jo.compile(jo.Mechanism(shot, body, contact, touched, *sensors))
    run = jo.simulate(model, 0.01, solver=solver)
    tight = 1e-5 if isinstance(solver, jo.RK4) else 3e-3
    assert run["since"][-1, 0] == pytest.approx(2.31e-3, rel=1e-9)
    assert run["v"][-1, 0] == pytest.approx(side * 58.4158415842, rel=tight)
    assert run["V"][-1, 0] == pytest.approx(-side * 1.58415841584, rel=tight)


def test_a_shell_keeps_its_side_when_the_centre_has_passed():
    """A soft contact on a thin shell: the ball goes in deeper than its radius, and comes back."""
    shell = plane(np.random.default_rng(1), 20, thickness=1e-3)
    body = ball((0.1, 0.2, 0.1), 0.01, velocity=(0, 0, -5.0))
    law = PowerLaw(2e4, 1.0, restitution=1.0)
    contact = Contact("c", jo.ground["origin"], shell, body["origin"], Sphere(0.01), law)
    sensors = (jo.PositionSensor("x", body["origin"]), jo.VelocitySensor("v", body["origin"]))
    model = jo.compile(jo.Mechanism(body, contact, *sensors))
    run = jo.simulate(model, 0.06, solver=jo.RK4(1e-4))
    assert run["x"][:, 2].min() == pytest.approx(0.0105 - 5.0 / np.sqrt(2e4), abs=1e-4)
    assert run["x"][:, 2].min() < -0.02
    assert run["v"][-1, 2] == pytest.approx(5.0, rel=1e-5)


@pytest.mark.parametrize("step", [1e-3, 1e-2])
def test_a_ball_that_rolls_is_stopped_by_a_thin_wall(step):
    """On the floor of the same surface at 20 m/s: a wall of 1 mm across its way is not passed."""
    wall = solid((1e-3, 1, 0.2), (0.5, 0, 0.1))
    floor = solid((2, 1, 0.2), (0.2, 0, -0.1))
    yard = TriangleMesh(np.concatenate([floor, wall + [0, 0, 1e-9]]))
    run = rolling(
        yard, (-0.5, 0, 0.02 - G / 1e7), (20, 0, 0), jo.RK4(step), 0.08, r=0.02, mu=0.0,
        law=PowerLaw(1e7, 1.0, restitution=0.8),
    )  # fmt: skip
    assert run["x"][:, 0].max() < 0.4995 - 0.02 + 0.01
    assert run["v"][-1, 0] == pytest.approx(-16.0, rel=1e-4)


def test_random_flights_at_a_body_of_triangles():
    """Balls shot at or past a bumpy body: each touch is at the distance 0, and none is missed."""
    rng = np.random.default_rng(7)
    x = sphere(0.1).triangles
    x = x * (1 + 2.0 * x[..., :1] * x[..., 1:2] / 0.01)
    mesh = TriangleMesh(x)
    hit = 0
    for _ in range(30):
        speed, r = rng.uniform(5, 80), 0.01
        start = rng.normal(size=3)
        start *= 1.0 / np.linalg.norm(start)
        aim = rng.uniform(-0.12, 0.12, 3)
        e = (aim - start) / np.linalg.norm(aim - start)
        places = np.linspace(0.8, 1.2, 120)
        far = np.array([closest(x, start + s * e) for s in places]) - r
        if abs(far.min()) < 1e-3:
            continue  # too close to tell by samples
        low, high = places[max(np.argmax(far < 0) - 1, 0)], places[np.argmax(far < 0)]
        for _ in range(50 * (far.min() < 0)):
            middle = 0.5 * (low + high)
            inside = closest(x, start + middle * e) < r
            low, high = (low, middle) if inside else (middle, high)
        until = high * (1 + 1e-6) if far.min() < 0 else 2.0
        body = ball(tuple(start), r, velocity=tuple(speed * e))
        contact = Contact("c", jo.ground["origin"], mesh, body["origin"], Sphere(r), PowerLaw(1e11))
        since = ForceStateSensor("since", contact, "since")
        model = jo.compile(jo.Mechanism(body, contact, since))
        step = rng.uniform(0.01, 1.0) / speed
        run = jo.simulate(model, until / speed, solver=jo.RK4(step))
        assert run.attributes["contacts"] == "missed: 0 (proven)"
        assert run["since"][-1, 0] == pytest.approx(high / speed if far.min() < 0 else 0, abs=1e-10)
        hit += far.min() < 0
    assert hit > 5


@pytest.mark.parametrize("solver", [jo.RK4(1e-3), jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)])
def test_bodies_on_a_terrain_never_gain_energy(solver):
    rng = np.random.default_rng(8)
    terrain = HeightField(0.05 * rng.uniform(size=(17, 17)), 4.0, 4.0)
    shapes = [Cuboid((0.2, 0.3, 0.1)), Sphere(0.1), Capsule(0.1, 0.3)]
    bodies = [
        jo.RigidBody(
            f"b{i}", 1.0, (0.01, 0.012, 0.015), position=(0.6 * i - 0.6, 0, 0.5),
            velocity=0.5 * rng.normal(size=3), angular_velocity=rng.normal(size=3) * 3,
        )
        for i in range(3)
    ]  # fmt: skip
    law = PowerLaw(1e6, 1.0, restitution=0.6)
    touch = [
        Contact(f"f{i}", jo.ground["origin"], terrain, b["origin"], shape, law, mu_kinetic=0.3)
        for i, (b, shape) in enumerate(zip(bodies, shapes, strict=True))
    ]
    heights = [jo.PositionSensor(f"p{i}", b["origin"]) for i, b in enumerate(bodies)]
    model = jo.compile(jo.Mechanism(*bodies, *touch, jo.Gravity((0, 0, -G)), *heights))
    run = jo.simulate(model, 1.5, solver=solver)
    energy = run.energy
    total = energy.kinetic + energy.potential + energy.springs
    scale = energy.kinetic.max()
    assert total[-1] < total[0] - 0.1 * scale
    assert np.diff(total).max() < 1e-3 * scale
    if not isinstance(solver, jo.GeneralizedAlpha):  # its work of friction in an impact is rough
        assert np.abs(energy.error).max() < 0.01 * scale
    for i in range(3):
        assert run[f"p{i}"][:, 2].min() > -0.01


# -- bodies that rest -----------------------------------------------------------------------------


@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_a_box_on_triangles_stands_as_on_a_plane(core):
    """Its four corners carry it: 1000 s without creep on 10 degrees."""
    s = np.radians(10)
    box_ = jo.RigidBody("b", 1.0, (0.01,) * 3, position=(0, 0, 0.05 - G * np.cos(s) / 4e7))
    floor = plane(np.random.default_rng(9), 50, thickness=0.01)
    touch = Contact(
        "c", jo.ground.at((0, 0, -0.005)), floor, box_["origin"], Cuboid((0.3, 0.2, 0.1)),
        STIFF, mu_kinetic=0.4,
    )  # fmt: skip
    x, F = jo.PositionSensor("x", box_["origin"]), jo.ForceSensor("F", touch)
    gravity = jo.Gravity((G * np.sin(s), 0, -G * np.cos(s)))
    model = jo.compile(jo.Mechanism(box_, touch, gravity, x, F), core=core)
    run = jo.simulate(model, 100.0, solver=jo.GeneralizedAlpha(1e-2))
    late = run.time > 5
    assert np.ptp(run["x"][late], axis=0).max() < 1e-12
    assert run["F"][-1, :3] == pytest.approx([-G * np.sin(s), 0, G * np.cos(s)], abs=1e-9)


def test_a_stopped_run_continues_bit_for_bit():
    terrain = HeightField(0.05 * np.random.default_rng(1).uniform(size=(17, 17)), 4.0, 4.0)
    body = ball((0.1, 0.2, 0.2), velocity=(0.5, 0.3, 0))
    touch = Contact(
        "c", jo.ground["origin"], terrain, body["origin"], Sphere(0.05), STIFF, mu_kinetic=0.3
    )
    x = jo.PositionSensor("x", body["origin"])
    model = jo.compile(jo.Mechanism(body, touch, jo.Gravity((0, 0, -G)), x))
    whole = jo.simulate(model, 1.0, solver=jo.RK4(1e-3))
    half = jo.simulate(model, 0.5, solver=jo.RK4(1e-3))
    rest = jo.simulate(model, 1.0, solver=jo.RK4(1e-3), state=half.state())
    assert np.array_equal(whole["x"][-1], rest["x"][-1])


# -- numbers --------------------------------------------------------------------------------------


def test_tables_grow_with_the_number_of_triangles():
    sizes = []
    for n in (10, 32, 100):
        mesh = HeightField(np.random.default_rng(n).uniform(size=(n, n)), 1.0, 1.0).mesh
        sizes.append(len(mesh.numbers) / len(mesh.corners))
    assert max(sizes) < 26
    assert max(sizes) < 1.3 * min(sizes)


def test_a_file_of_triangles(tmp_path):
    """STL in mm, and the same shape in a model file."""
    import meshio

    x = 1000 * solid((1, 1, 0.2), (0, 0, -0.1))
    cells = [("triangle", np.arange(len(x) * 3).reshape(-1, 3))]
    meshio.write_points_cells(tmp_path / "slab.stl", x.reshape(-1, 3), cells)
    slab = TriangleMesh(tmp_path / "slab.stl", unit="mm")
    assert slab.mesh.closed and len(slab.mesh.corners) == 12
    text = """
bodies:
  - {name: ball, type: sphere, radius: 50 mm, mass: 1, position: [0, 0, 0.1]}
forces:
  - type: contact
    name: c
    a: ground.origin
    b: ball.origin
    shape_a: {type: triangle-mesh, file: slab.stl, unit: mm}
    shape_b: {type: sphere, radius: 50 mm}
    law: {type: power-law, stiffness: 1e7, exponent: 1, restitution: 0.5}
  - type: contact
    name: hills
    a: ground.origin
    b: ball.origin
    shape_a: {type: height-field, heights: [[0, 0], [0, 0]], length: 1 m, width: 2 m}
    shape_b: {type: sphere, radius: 50 mm}
    law: {type: power-law, stiffness: 1e7, exponent: 1, restitution: 0.5}
"""
    path = tmp_path / "model.yaml"
    path.write_text(text, encoding="utf-8")
    found, hills = jo.read_model(path).mechanism.forces
    assert np.array_equal(found.shape_a.triangles, slab.triangles)
    assert hills.shape_a.mesh.closed
    assert hills.shape_a.mesh.volume == pytest.approx(2.0)
    path.write_text(text.replace("slab.stl", "slob.stl"), encoding="utf-8")
    with pytest.raises(jo.InputError, match="no such file"):
        jo.read_model(path)


# -- what is refused ------------------------------------------------------------------------------

CORNERS = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
TETRAHEDRON = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]


@pytest.mark.parametrize(
    ("points", "triangles", "messages"),
    [
        (CORNERS, np.zeros((0, 3)), ["has no triangles"]),
        (CORNERS, [(0, 1, 4)], ["triangle 0 is", "from 0 to 3"]),
        (CORNERS, [(0, 1, 1.5)], ["whole numbers"]),
        ([*CORNERS[:3], (0, 0, float("nan"))], TETRAHEDRON, ["points"]),
        (CORNERS, [t[::-1] for t in TETRAHEDRON], ["face inwards", "-0.1667 m3"]),
        (CORNERS, [*TETRAHEDRON[:3], TETRAHEDRON[3][::-1]], ["opposite orientation"]),
        (CORNERS, [*TETRAHEDRON, (0, 1, 1)], ["triangle 4 has no area"]),
        (CORNERS, [*TETRAHEDRON, (0, 2, 1)], ["a double with the same corners"]),
        (
            [*CORNERS, (2, 0, 0)],
            [*TETRAHEDRON, (0, 1, 4), (2, 1, 0), (3, 0, 1)],
            ["no area", "a double", "more than two triangles"],
        ),
    ],
)  # fmt: skip
def test_surfaces_that_are_refused(points, triangles, messages):
    with pytest.raises(jo.InputError) as error:
        TriangleMesh.of(points, triangles)
    for message in messages:
        assert message in str(error.value)


@pytest.mark.parametrize("turn", [0.0, 0.3])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_a_surface_that_crosses_itself_is_refused(scale, turn):
    R = Rotation.from_rotvec([turn, 0.5 * turn, turn]).as_matrix()
    one = solid((1, 1, 1))
    apart, inside, touching, crossing = (
        scale * np.concatenate([one, other]) @ R.T
        for other in (
            one + [1.5, 0, 0],
            0.5 * one[:, ::-1],  # a cavity
            one + [1.0, 0.2, 0.3],
            0.5 * one + [0.5, 0.2, 0.1],
        )
    )
    for good in (apart, inside, touching):
        TriangleMesh(good)
    message = r"triangles \d+ and (1[2-9]|2[0-3]) .*cross each other.*intersects itself"
    with pytest.raises(jo.InputError, match=message):
        TriangleMesh(crossing)


def test_crossing_triangles_are_those_of_all_pairs(rng):
    centre = rng.uniform(-1, 1, (150, 1, 3))
    p = centre + 0.3 * rng.uniform(-1, 1, (150, 3, 3))
    mesh = Triangles.of(p)
    expected = set()
    for i in range(len(p)):  # an edge through a triangle: x_a + t d = a + u e + v f
        for k in range(3):
            start, d = p[i, k], p[i, (k + 1) % 3] - p[i, k]
            A = np.stack([p[:, 1] - p[:, 0], p[:, 2] - p[:, 0], np.broadcast_to(-d, (150, 3))], 2)
            A[i] = np.eye(3)
            u, v, t = np.linalg.solve(A, (start - p[:, 0])[..., None])[..., 0].T
            hit = (u > 0) & (v > 0) & (u + v < 1) & (t > 0) & (t < 1)
            hit[i] = False
            expected |= {tuple(sorted((i, int(j)))) for j in np.flatnonzero(hit)}
    order = mesh._order
    q = p[order]
    found = order[crossing_pairs(q, _boxes(q)[0], LEAF, enough=10**6)]
    assert {tuple(sorted(pair)) for pair in found.tolist()} == expected
    assert 20 < len(expected) < 1000 and len(found) == len(expected)


@pytest.mark.parametrize(
    ("on", "of", "message"),
    [
        (STAR, STAR, "cannot touch in this version"),
        (STAR, Torus(0.3, 0.1), "cannot touch in this version"),
        (STAR, ConvexHull(np.array(CORNERS)), None),
        (SHELL, Cuboid((1, 1, 1)), None),
        (TriangleMesh(np.array([CORNERS[:3]])), Cuboid((1, 1, 1)), "without thickness"),
        (TriangleMesh(np.array([CORNERS[:3]])), Sphere(0.0), "without thickness"),
        (HalfSpace(), TriangleMesh(np.array([CORNERS[:3]])), "has 3 points, needs 4"),
    ],
)
def test_pairs_of_surfaces(on, of, message):
    body = ball((0, 0, 3))
    items = ("c", jo.ground["origin"], on, body["origin"], of, STIFF)
    if message is None:
        Contact(*items)
        Contact("c", body["origin"], of, jo.ground["origin"], on, STIFF)
        return
    with pytest.raises(jo.InputError, match=message):
        Contact(*items)


def test_a_height_field_needs_a_cell():
    with pytest.raises(jo.InputError, match="heights are 1 x 3"):
        HeightField([[0, 0, 0]], 1.0, 1.0)


def test_hertz_needs_a_radius():
    with pytest.raises(jo.InputError, match="Hertz"):
        Contact("c", jo.ground["origin"], STAR, ball((0, 0, 3))["origin"], Sphere(0.1), Hertz(1e9))
