"""Contacts of many bodies whose pairs are found in the run: conservation, nothing missed."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import (
    Apart,
    Capsule,
    CollisionShape,
    Contact,
    Contacts,
    Cuboid,
    HalfSpace,
    PowerLaw,
    Sphere,
    SpringDamper,
    Surface,
    SurfacePair,
    Torus,
)
from jousto.mechanism.contacts.pair_tables import joined_bodies

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

G = 9.81
R = 0.05
LAW = PowerLaw(1e7, restitution=0.7)
SOLVERS = [
    jo.RK4(1e-3),
    jo.simulation.SSPRK3(1e-3),
    jo.GeneralizedAlpha(1e-3),
    jo.simulation.DormandPrince(tolerance=1e-12),
]
FLOOR = CollisionShape("floor", jo.ground["origin"], HalfSpace())


def ball(name: str, at: Any, v: Any = (0, 0, 0), mass: float = 1.0) -> Any:
    return jo.RigidBody.sphere(name, radius=R, mass=mass, position=at, velocity=v)


def shapes_of(balls: Any, **more: Any) -> list[CollisionShape]:
    return [CollisionShape(one.name, one["origin"], Sphere(R), **more) for one in balls]


def positions(balls: Any) -> list[Any]:
    return [jo.PositionSensor(f"p {one.name}", one["origin"]) for one in balls]


def heap() -> list[Any]:
    return [ball(f"b{i}", (0.02 * i, 0, 0.3 + 0.11 * i)) for i in range(3)]


# -- one law, written once ------------------------------------------------------------------------


@pytest.mark.parametrize("solver", SOLVERS, ids=lambda s: type(s).__name__)
def test_same_motion_as_one_contact_a_pair(solver):
    """Balls that fall on the floor and on one another, with friction."""
    found = []
    for many in (True, False):
        balls = heap()
        floor = jo.ground["origin"], HalfSpace()
        if many:
            shapes = [FLOOR, *shapes_of(balls)]
            touch: list[Any] = [Contacts("c", shapes, law=LAW, mu_kinetic=0.3)]
        else:
            touch = [
                Contact(f"f{i}", *floor, one["origin"], Sphere(R), LAW, mu_kinetic=0.3)
                for i, one in enumerate(balls)
            ] + [
                Contact(f"{a.name}{b.name}", a["origin"], Sphere(R), b["origin"], Sphere(R), LAW,
                        mu_kinetic=0.3)
                for a, b in combinations(balls, 2)
            ]  # fmt: skip
        machine = jo.Mechanism(*balls, *touch, jo.Gravity((0, 0, -G)), *positions(balls))
        run = jo.simulate(jo.compile(machine), 0.4, solver=solver)
        found.append([run[f"p {one.name}"] for one in balls])
        assert run.attributes["contacts"] == "missed: 0 (proven)"
    # other crossings are located first, so that steps end at other instants
    assert np.abs(np.array(found[0]) - found[1]).max() < 1e-9
    assert np.ptp(np.array(found[0])[:, :, 2]) > 0.3


def test_an_explicit_step_of_ros2_holds_balls_on_the_floor():
    """Slots are not in its matrix, so that its steps are as short as those of RK4."""
    balls = [ball(f"b{i}", (0.2 * i, 0, R)) for i in range(3)]
    touch = Contacts("c", [FLOOR, *shapes_of(balls)], law=SpringDamper(1e6, 500.0))
    v = jo.VelocitySensor("v", balls[1]["origin"])
    machine = jo.Mechanism(*balls, touch, jo.Gravity((0, 0, -G)), *positions(balls), v)
    run = jo.simulate(jo.compile(machine), 0.1, solver=jo.ROS2(2e-3))
    assert run["p b1"][-1, 2] == pytest.approx(R - G / 1e6, rel=1e-7)
    assert abs(run["v"][-1, 2]) < 1e-9


@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_pendulums_touch_in_both_cores(core):
    """Newton's cradle of two bobs: with e = 1 and equal masses they exchange their velocities."""
    law = PowerLaw(1e9, restitution=1.0)
    rods = [
        jo.RigidBody(f"rod{i}", 1.0, (1e-4,) * 3, position=(2 * R * i, 0, 0), center=(0, 0, -1.0))
        for i in range(2)
    ]
    pivots = [
        jo.Revolute(f"j{i}", jo.ground.at((2 * R * i, 0, 0)), rod["origin"], axis=(0, 1, 0))
        for i, rod in enumerate(rods)
    ]
    shapes = [CollisionShape(rod.name, rod.at((0, 0, -1.0)), Sphere(R)) for rod in rods]
    angles = [jo.CoordinateSensor(f"a{i}", one.angle) for i, one in enumerate(pivots)]
    start = jo.Initial(pivots[0].angle, value=0.3)
    machine = jo.Mechanism(
        *rods, *pivots, Contacts("c", shapes, law=law), jo.Gravity((0, 0, -G)), *angles, start
    )
    model = jo.compile(machine, core=core)
    run = jo.simulate(model, 1.2, solver=jo.RK4(1e-4))
    # the first one rests after it, the second one rises as high on the other side
    assert run["a1"][:, 0].min() == pytest.approx(-0.3, abs=2e-3)
    assert np.abs(run["a0"][run.time > 0.6, 0]).max() < 0.02


def test_tangent_couples_all_bodies_that_may_touch():
    """Newton's matrix against complex steps: pairs of the middle ball with both others overlap."""
    rng = np.random.default_rng(3)
    balls = [
        jo.RigidBody(
            f"b{i}", 1.0, (1e-3, 2e-3, 2.5e-3), position=(0.09 * i, 0.01 * i, 0),
            velocity=rng.normal(size=3), angular_velocity=rng.normal(size=3),
        )
        for i in range(3)
    ]  # fmt: skip
    touch = Contacts("c", shapes_of(balls), law=PowerLaw(1e4, restitution=0.7), overlap="start")
    engine = jo.model.Engine(jo.compile(jo.Mechanism(*balls, touch)))
    engine.accelerations()
    assert len(engine.contacts()) == 2
    exact = engine.tangent()
    for M, weights in ((exact.K, (0.0, 0.0, 1.0)), (exact.D, (0.0, 1.0, 0.0))):
        N = engine.newton_matrix(*weights)[: len(M), : len(M)]
        assert np.abs(M[:6, 6:12]).max() > 0
        assert np.abs(M - N).max() <= 1e-12 * np.abs(M).max()


# -- conservation ---------------------------------------------------------------------------------


def walls(size: float) -> list[CollisionShape]:
    """Six half-spaces around a box of half-width `size`."""
    found = []
    for axis in range(3):
        for sign in (1, -1):
            at = np.zeros(3)
            at[axis] = -sign * size
            z = np.zeros(3)
            z[axis] = sign
            x = np.roll(z, 1)
            turn = np.stack([x, np.cross(z, x), z], axis=1)
            marker = jo.ground.at(at, turn)
            found.append(CollisionShape(f"wall {axis} {sign}", marker, HalfSpace(), group="walls"))
    return found


def swarm(count: int, seed: int, size: float, speed: float) -> list[Any]:
    rng = np.random.default_rng(seed)
    grid = np.array(list(np.ndindex(3, 3, 3)))[rng.permutation(27)[:count]] - 1
    return [
        ball(f"b{i}", 0.66 * size * at, speed * rng.normal(size=3), 0.2 + rng.random())
        for i, at in enumerate(grid)
    ]


@pytest.mark.parametrize("e", [1.0, 0.6])
def test_spheres_in_a_box_never_gain_energy(e):
    balls = swarm(12, 1, 0.3, 3.0)
    law = PowerLaw(1e7, restitution=e)
    touch = Contacts("c", [*walls(0.3), *shapes_of(balls)], law=law)
    run = jo.simulate(
        jo.compile(jo.Mechanism(*balls, touch)), 0.4, solver=jo.simulation.DormandPrince(1e-10)
    )
    total = run.energy.kinetic + run.energy.springs
    assert run.attributes["contacts"] == "missed: 0 (proven)"
    assert (np.diff(total) < 1e-8 * total[0]).all()
    balance = total + run.energy.dissipated + run.energy.friction
    assert np.abs(balance - total[0]).max() < 1e-7 * total[0]
    assert (total[-1] < 0.9 * total[0]) == (e < 1)


def test_closed_system_keeps_its_momentum():
    """A ball flies into a row of others; no force from outside."""
    balls = [ball(f"b{i}", (0.13 * i, 0.01 * i, 0), (4.0 * (i == 0), 0, 0)) for i in range(6)]
    touch = Contacts("c", shapes_of(balls), law=LAW, mu_kinetic=0.3)
    speed = [jo.VelocitySensor(f"v{i}", one["origin"]) for i, one in enumerate(balls)]
    run = jo.simulate(jo.compile(jo.Mechanism(*balls, touch, *speed)), 0.5, solver=jo.RK4(1e-3))
    momentum = sum(run[f"v{i}"] for i in range(6))
    assert np.abs(momentum - [4.0, 0, 0]).max() < 1e-13
    assert run["v5"][-1, 0] > 0.1


# -- nothing missed -------------------------------------------------------------------------------


@pytest.mark.parametrize("solver", [jo.RK4(1e-3), jo.GeneralizedAlpha(2e-3), SOLVERS[3]])
def test_a_shot_does_not_pass_a_thin_plate(solver):
    """10 g at 100 m/s, a free plate of 2 mm and 1 kg: the speeds after a central hit."""
    e, m, M = 0.6, 0.01, 1.0
    shot = jo.RigidBody.sphere("shot", radius=5e-3, mass=m, position=(0, 0, 0.237),
                               velocity=(0, 0, -100))  # fmt: skip
    plate = jo.RigidBody("plate", M, (0.01,) * 3)
    shapes = [
        CollisionShape("plate", plate["origin"], Cuboid((0.4, 0.4, 2e-3))),
        CollisionShape("shot", shot["origin"], Sphere(5e-3)),
    ]
    law = PowerLaw(1e9, restitution=e)
    v = jo.VelocitySensor("v", shot["origin"])
    model = jo.compile(jo.Mechanism(shot, plate, Contacts("c", shapes, law=law), v))
    run = jo.simulate(model, 0.01, solver=solver)
    assert run.attributes["contacts"] == "missed: 0 (proven)"
    exact = -100 + (1 + e) * 100 * M / (m + M)
    assert run["v"][-1, 2] == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("seed", range(12))
def test_fast_spheres_meet_at_any_step(seed):
    """Two spheres on a collision course by the closed form touch, others do not."""
    rng = np.random.default_rng(seed)
    n = rng.normal(size=3)
    n /= np.linalg.norm(n)
    side = np.cross(n, rng.normal(size=3))
    side *= rng.uniform(0, 4 * R) / np.linalg.norm(side)
    speed, step = 10 ** rng.uniform(0, 3), 10 ** rng.uniform(-4, -2)
    far = 2.5 * R + rng.uniform(0.2, 0.9) * speed * step * 5
    a, b = ball("a", (0, 0, 0)), ball("b", far * n + side, -speed * n)
    touch = Contacts("c", shapes_of([a, b]), law=PowerLaw(1e8, restitution=1.0))
    v = jo.VelocitySensor("v", a["origin"])
    model = jo.compile(jo.Mechanism(a, b, touch, v))
    end = np.ceil((far + 3 * R) / speed / step) * step
    run = jo.simulate(model, end, solver=jo.RK4(step))
    hit = np.linalg.norm(side) < 2 * R
    assert run.attributes["contacts"] == "missed: 0 (proven)"
    assert (np.linalg.norm(run["v"][-1]) > 0) == hit


def test_a_stopped_run_continues_bit_for_bit():
    balls = swarm(8, 5, 0.3, 3.0)
    touch = Contacts("c", [*walls(0.3), *shapes_of(balls)], law=LAW, mu_kinetic=0.2)
    model = jo.compile(jo.Mechanism(*balls, touch, *positions(balls)))
    whole = jo.simulate(model, 0.2, solver=jo.RK4(1e-3))
    half = jo.simulate(model, 0.1, solver=jo.RK4(1e-3))
    rest = jo.simulate(model, 0.2, solver=jo.RK4(1e-3), state=half.state())
    for one in balls:
        assert (rest[f"p {one.name}"][-1] == whole[f"p {one.name}"][-1]).all()


# -- who touches whom -----------------------------------------------------------------------------


def touched(*items: Any, **options: Any) -> bool:
    """Whether two balls of one machine at 1 m/s change their velocity."""
    a, b = ball("a", (0, 0, 0)), ball("b", (0.2, 0, 0), (-1, 0, 0))
    shapes = [
        CollisionShape("one", a["origin"], Sphere(R), group="left"),
        CollisionShape("other", b["origin"], Sphere(R), group="right"),
    ]
    more = [item(a, b) for item in items]
    v = jo.VelocitySensor("v", b["origin"])
    model = jo.compile(jo.Mechanism(a, b, *more, Contacts("c", shapes, law=LAW, **options), v))
    return bool(abs(jo.simulate(model, 0.2, solver=jo.RK4(1e-3))["v"][-1, 0] + 1) > 1e-3)


def slide(a: Any, b: Any) -> Any:
    return jo.Prismatic("slide", a["origin"], b["origin"], axis=(1, 0, 0))


def test_pairs_that_are_apart_do_not_touch():
    assert touched()
    assert not touched(apart=[Apart("one", "other")])
    assert not touched(apart=[Apart("left", "right")])
    assert not touched(apart=[Apart("one", "right")])


def test_bodies_with_a_joint_do_not_touch_unless_asked():
    assert not touched(slide)
    assert touched(slide, joined=True)


def test_what_is_welded_to_the_ground_is_no_parent():
    """0 is welded to the ground, 1 hangs on it, 2 on 1, 3 is welded to 2."""
    joints = [(-1, 0, True), (0, 1, False), (1, 2, False), (2, 3, True)]
    assert joined_bodies(joints) == [(-1, 0), (1, 2), (1, 3), (2, 3)]


def test_shapes_of_one_body_do_not_touch():
    a = ball("a", (0, 0, 1))
    shapes = [CollisionShape(f"s{i}", a.at((0.01 * i, 0, 0)), Sphere(R)) for i in range(3)]
    model = jo.compile(jo.Mechanism(a, Contacts("c", [FLOOR, *shapes], law=LAW)))
    assert len(jo.model.Engine(model).contacts()) == 0


# -- surfaces -------------------------------------------------------------------------------------


def test_law_of_two_surfaces():
    """Hertz between both, the smaller restitution, the geometric mean of the friction."""
    steel = Surface("steel", 210e9, 0.3, restitution=0.8, mu_kinetic=0.4, mu_static=0.9)
    brass = Surface("brass", 100e9, 0.35, restitution=0.6, mu_kinetic=0.1)
    a, b = ball("a", (0, 0, 0)), ball("b", (1, 0, 0))
    shapes = [
        CollisionShape("a", a["origin"], Sphere(R), surface=steel),
        CollisionShape("b", b["origin"], Sphere(R), surface=brass),
    ]
    found = Contacts("c", shapes).laws["steel", "brass"]
    assert found.law.modulus == pytest.approx(1 / ((1 - 0.09) / 210e9 + (1 - 0.1225) / 100e9))
    assert found.law.restitution == 0.6
    assert found.friction == pytest.approx((0.2, 0.3))
    pair = SurfacePair("brass", "steel", mu_kinetic=0.5)
    assert Contacts("c", shapes, pairs=[pair]).laws["steel", "brass"].friction == (0.5, 0.5)


def test_hertz_between_surfaces_is_that_of_one_contact():
    material = Surface("s", 210e9, 0.3, restitution=1.0)
    r, m = 0.01, 7850 * 4 / 3 * np.pi * 0.01**3
    body = jo.RigidBody.sphere("ball", radius=r, mass=m, position=(0, 0, r), velocity=(0, 0, -1))
    shapes = [
        CollisionShape("floor", jo.ground["origin"], HalfSpace(), surface=material),
        CollisionShape("ball", body["origin"], Sphere(r), surface=material),
    ]
    p = jo.PositionSensor("p", body["origin"])
    model = jo.compile(jo.Mechanism(body, Contacts("c", shapes), p))
    run = jo.simulate(model, 7.2e-5, solver=jo.RK4(2e-8))
    assert (r - run["p"][:, 2]).max() == pytest.approx(2.348078729e-5, rel=1e-8)


# -- refused --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "without a surface with E"),
        ({"law": LAW, "apart": [Apart("flor", "b0")]}, "no shape or group 'flor'.*'floor'"),
        ({"law": LAW, "pairs": [SurfacePair("a", "b", mu_kinetic=1.0)]}, "no surface 'a'"),
        ({"law": LAW, "most": 0}, "most"),
        ({"law": LAW, "mu_kinetic": 0.5, "mu_static": 0.4}, "mu_static 0.4 is below"),
    ],
)
def test_invalid_sets_are_refused(options, words):
    with pytest.raises(jo.InputError, match=words):
        Contacts("c", [FLOOR, *shapes_of(heap())], **options)


def test_kinds_that_cannot_touch_are_refused():
    a, b = heap()[:2]
    shapes = [
        CollisionShape("a", a["origin"], Torus(0.1, 0.02), group="a"),
        CollisionShape("b", b["origin"], Cuboid((0.1, 0.1, 0.1)), group="b"),
    ]
    with pytest.raises(jo.InputError, match="cannot touch in this version"):
        Contacts("c", shapes, law=LAW)
    Contacts("c", [*shapes, FLOOR], law=LAW, apart=[Apart("a", "b"), Apart("a", "floor")])


def test_overlap_at_the_start_is_refused():
    balls = [ball("a", (0, 0, 0)), ball("b", (0.099, 0, 0))]
    with pytest.raises(jo.InputError, match="'a' and 'b' by 0.001 m"):
        jo.compile(jo.Mechanism(*balls, Contacts("c", shapes_of(balls), law=LAW)))
    touch = Contacts("c", shapes_of(balls), law=LAW, overlap="start")
    jo.compile(jo.Mechanism(*balls, touch))


def test_a_run_without_a_free_slot_says_what_to_do():
    balls = [ball(f"b{i}", (0.2 * i, 0, R)) for i in range(8)]
    touch = Contacts("c", [FLOOR, *shapes_of(balls)], law=LAW, most=5)
    model = jo.compile(jo.Mechanism(*balls, touch, jo.Gravity((0, 0, -G))))
    with pytest.raises(jo.SimulationError, match=r"more than 5 pairs .* most=10 or more"):
        jo.simulate(model, 0.1, solver=jo.RK4(1e-3))


def test_an_implicit_method_refuses_more_bodies_than_it_couples():
    balls = [ball(f"b{i}", (0.2 * i, 0, 1)) for i in range(151)]
    model = jo.compile(jo.Mechanism(*balls, Contacts("c", shapes_of(balls), law=LAW)))
    with pytest.raises(jo.InputError, match="151 bodies may touch one another"):
        jo.simulate(model, 0.1, solver=jo.GeneralizedAlpha(1e-3))
    shapes = [FLOOR, *shapes_of(balls, group="balls")]
    apart = Contacts("c", shapes, law=LAW, apart=[Apart("balls", "balls")])
    jo.simulate(jo.compile(jo.Mechanism(*balls, apart)), 2e-3, solver=jo.GeneralizedAlpha(1e-3))


# -- size -----------------------------------------------------------------------------------------


def test_tables_grow_with_the_number_of_shapes():
    sizes = []
    for count in (20, 40, 80):
        balls = [ball(f"b{i}", (0.2 * i, 0, 1)) for i in range(count)]
        model = jo.compile(jo.Mechanism(*balls, Contacts("c", [FLOOR, *shapes_of(balls)], law=LAW)))
        sizes.append(sum(np.size(force.data) for force in model.forces))
    assert sizes[2] - sizes[1] == 2 * (sizes[1] - sizes[0])


def test_boxes_and_capsules_rest_on_the_floor():
    """Forces of the corners and ends: the weight."""
    law = SpringDamper(1e5, 100.0)
    box = jo.RigidBody("box", 2.0, (0.01,) * 3, position=(0, 0, 0.05))
    rod = jo.RigidBody("rod", 1.0, (0.01,) * 3, position=(1, 0, 0.05))
    turned = rod["origin"].turned(jo.Rotate((0, 1, 0), degrees=90))
    shapes = [
        FLOOR,
        CollisionShape("box", box["origin"], Cuboid((0.1, 0.1, 0.1)), group="box"),
        CollisionShape("rod", turned, Capsule(0.05, 0.3), group="rod"),
    ]
    touch = Contacts("c", shapes, law=law, apart=[Apart("box", "rod")])
    model = jo.compile(jo.Mechanism(box, rod, touch, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 1.0, solver=jo.GeneralizedAlpha(1e-3))
    z = run.q[-1, [2, 9]]
    assert z[0] == pytest.approx(0.05 - 2 * G / 4 / 1e5, abs=1e-9)
    assert z[1] == pytest.approx(0.05 - G / 2 / 1e5, abs=1e-9)


def test_a_model_file_declares_the_same_set(tmp_path):
    text = """
bodies:
  - {name: ball, type: sphere, radius: 50 mm, mass: 1, position: [0, 0, 0.3]}
  - {name: other, type: sphere, radius: 50 mm, mass: 1, position: [0.02, 0, 0.5]}
forces:
  - type: contacts
    name: contacts
    law: {type: power-law, stiffness: 1e6, restitution: 0.5}
    mu_kinetic: 0.3
    shapes:
      - {name: floor, marker: ground.origin, shape: {type: half-space}}
      - {name: ball, marker: ball.origin, shape: {type: sphere, radius: 50 mm}}
      - name: other
        marker: other.origin
        shape: {type: sphere, radius: 50 mm}
        surface: {name: steel, E: 210 GPa, restitution: 0.8}
        group: above
    pairs: [{a: steel, b: steel, mu_kinetic: 0.1}]
    apart: [{a: ball, b: above}]
    most: 40
"""
    path = tmp_path / "model.yaml"
    path.write_text(text, encoding="utf-8")
    (found,) = jo.read_model(path).mechanism.forces
    assert isinstance(found, Contacts)
    assert [one.name for one in found.shapes] == ["floor", "ball", "other"]
    assert found.shapes[2].surface == Surface("steel", 210e9, restitution=0.8)
    assert found.shapes[1].shape == Sphere(0.05)
    assert (found.apart, found.slots) == ((Apart("ball", "above"),), 40)
    assert found.laws["steel", "steel"].friction == (0.1, 0.1)
    assert found.laws["", "steel"].law == PowerLaw(1e6, restitution=0.5)
