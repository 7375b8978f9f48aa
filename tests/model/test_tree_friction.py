"""Friction in trees of joint coordinates: against the positions of all bodies and closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import jousto as jo
from jousto.model.native.native import Engine, displaced
from jousto.model.tree import with_core
from model.test_tree import final, tree
from verification.friction import PinPendulum
from verification.test_friction import pendulum

pytestmark = pytest.mark.filterwarnings("ignore:.*nothing will move", "ignore:.*step")

Array = NDArray[np.float64]
STICKS = jo.mechanism.StickSlip()
SMOOTH = jo.mechanism.Regularised(0.5)
RUBBING = jo.Revolute | jo.Prismatic | jo.Cylindrical
KINDS = ("revolute", "prismatic", "cylindrical", "spherical")
G = 9.81


def friction(name: str, joint: Any, law: Any, rng: np.random.Generator) -> Any:
    """Friction of random sizes, pressed by all that can press it."""
    sizes: dict[str, float] = {"preload": rng.uniform(0.5, 2.0), "bearing_length": 0.4}
    if not isinstance(joint, jo.Prismatic):
        sizes["radius"] = 0.05
    if not isinstance(joint, jo.Cylindrical):
        sizes["collar_radius"] = 0.3
    return jo.Friction(name, joint, 0.06, 0.09, law=law, **sizes)


def rubbing(seed: int, law: Any = None, **asked: Any) -> Any:
    """A random tree in which each joint rubs that can; without a law every other one sticks."""
    mechanism = tree(seed, **asked)
    rng = np.random.default_rng(seed)
    joints = [one for one in mechanism.joints if isinstance(one, RUBBING)]
    drives = [one for one in mechanism.items if isinstance(one, jo.Drive)]
    driven = {id(drive.coordinate) for drive in drives}
    items = []
    for i, one in enumerate(joints):
        moved = any(id(c) in driven for c in one.coordinates)
        mine = SMOOTH if moved else law or (STICKS, SMOOTH)[i % 2]
        items.append(friction(f"rub{i}", one, mine, rng))
    return jo.Mechanism(*mechanism.items, *items, name="rubbing")


def put(engine: Engine, seed: int, stuck: float) -> None:
    """A random state that the joints allow: this share of what can stick does, the rest slips."""
    rng = np.random.default_rng(seed)
    model = engine.model
    engine.q[:] = displaced(model, engine.q, 0.1 * rng.normal(size=model.nv))
    engine.v[:] = rng.normal(size=model.nv)
    engine.time[0] = 0.3
    for i, f in enumerate(model.frictions):
        lock = model.joints[f.lock].lock
        if f.sticks and rng.random() < stuck:
            engine.locked[lock] = 1
            engine.held[2 * lock : 2 * lock + 2] = 0.1 * rng.normal(size=2)
        elif f.sticks and rng.random() < 0.5 and f.other < 0:
            engine.slip[i] = rng.choice([-1, 1])
    engine.assemble()


@pytest.mark.parametrize("stuck", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("seed", range(1, 7))
def test_accelerations_reactions_and_friction_are_those_of_the_bodies(
    seed: int, stuck: float
) -> None:
    model = jo.compile(rubbing(seed, STICKS if stuck else None, drives=seed % 2 > 0), core="joint")
    engine = Engine(model)
    put(engine, seed, stuck)
    assert stuck < 1.0 or engine.locked.any()
    found = []
    for own in (False, True):
        a, lam = engine.tree_accelerations() if own else engine.accelerations()
        found.append((a.copy(), lam.copy(), engine.rub.copy()))
    assert np.abs(found[0][2]).max() > 1e-2  # it rubs
    for one, other in zip(*found, strict=True):
        # the joints are closed to 1e-12; friction to 1e-12 of itself, and its reaction follows
        np.testing.assert_allclose(one, other, rtol=0.0, atol=2e-11 * np.abs(one).max())


def test_more_frictions_than_are_worked_out_beforehand() -> None:
    """Nine forces: each iteration asks the tree for the change of the reactions."""
    mechanism = rubbing(11, STICKS, count=14, kinds=("revolute", "prismatic", "cylindrical"))
    engine = Engine(jo.compile(mechanism, core="joint"))
    put(engine, 11, 0.0)
    found = []
    for own in (False, True):
        a, _ = engine.tree_accelerations() if own else engine.accelerations()
        found.append((a.copy(), engine.rub.copy()))
    assert (found[0][1] != 0.0).sum() > 8
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-10 * np.abs(one).max())


@pytest.mark.parametrize("stuck", [0.0, 0.6])
def test_derivatives_by_complex_numbers(stuck: float) -> None:
    """Of accelerations and friction with the velocities, in a direction that the joints allow."""
    model = jo.compile(rubbing(7, STICKS if stuck else None), core="joint")
    plain = Engine(model)
    put(plain, 7, stuck)
    other = Engine(model)
    put(other, 8, 0.0)
    other.q[:], other.locked[:], other.held[:] = plain.q, plain.locked, plain.held
    other.assemble()
    found = []
    for own in (False, True):
        engine = Engine(model, complex_scalars=True)
        engine.q[:], engine.time[0] = plain.q, 0.3
        engine.v[:] = plain.v + 1e-30j * (other.v - plain.v)
        engine.locked[:], engine.held[:], engine.slip[:] = plain.locked, plain.held, plain.slip
        a, lam = engine.tree_accelerations() if own else engine.accelerations()
        found.append([x.imag.copy() / 1e-30 for x in (a, lam, engine.rub)])
    for one, two in zip(*found, strict=True):
        assert np.abs(one).max() > 1e-2
        np.testing.assert_allclose(one, two, rtol=0.0, atol=1e-9 * np.abs(one).max())


@pytest.mark.parametrize(("solver", "least"), [(jo.RK4, 13.0), (jo.ROS2, 3.5)], ids=["RK4", "ROS2"])
@pytest.mark.parametrize("seed", [2, 3])
def test_smooth_runs_agree_at_the_order_of_the_method(seed: int, solver: Any, least: float) -> None:
    mechanism = rubbing(seed, SMOOTH, drives=seed == 2)
    models = [jo.compile(mechanism, core=core) for core in ("joint", "maximal")]
    apart = []
    for step in (8e-3, 4e-3):
        one, other = (final(model, solver(step=step)) for model in models)
        apart.append(np.abs(one[0] - other[0]).max())
    assert apart[0] < 1e-4
    assert apart[0] > least * apart[1]


def transitions(model: Any, duration: float, method: str, step: float) -> tuple[Array, Array]:
    """Times, frictions and slips (k, 3) of all that begins to slip or to stick; the end."""
    engine = Engine(model)
    steps = round(duration / step)
    rows = np.zeros((steps, engine.row_size))
    status, _ = engine.run(engine.native_solver(method, step, True), steps, 1, rows)
    assert status == "ok"
    return engine.happenings(), rows[-1, 1 : 1 + model.nq]


@pytest.mark.parametrize("seed", [1, 2, 7, 12])
def test_sticking_and_slipping_happen_when_they_do_with_the_bodies(seed: int) -> None:
    mechanism = rubbing(seed, STICKS, kinds=KINDS)
    ends = [
        transitions(jo.compile(mechanism, core=core), 1.0, "rk4", 2e-3)
        for core in ("joint", "maximal")
    ]
    (one, q), (other, p) = ends
    assert len(one) >= 2
    np.testing.assert_array_equal(one[:, 1:], other[:, 1:])
    # at this step the error of either core, of order four, is below that
    np.testing.assert_allclose(one[:, 0], other[:, 0], rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(q, p, rtol=0.0, atol=1e-7)


def test_error_control_finds_the_same() -> None:
    mechanism = rubbing(2, STICKS)
    solver = jo.simulation.DormandPrince(tolerance=1e-9)
    (q, _), (p, _) = (
        final(jo.compile(mechanism, core=core), solver) for core in ("joint", "maximal")
    )
    np.testing.assert_allclose(q, p, rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("solver", [jo.RK4(step=1e-3), jo.ROS2(step=1e-3)], ids=["RK4", "ROS2"])
def test_the_energy_that_is_lost_is_that_of_the_friction(solver: Any) -> None:
    run = jo.simulate(jo.compile(rubbing(4, STICKS), core="joint"), 1.0, solver=solver)
    assert run.energy.friction[-1] > 0.1
    small = 1e-6 if isinstance(solver, jo.RK4) else 1e-3  # by the order of the method
    assert np.abs(run.energy.error).max() < small * run.energy.friction[-1]


@pytest.mark.parametrize("solver", [jo.RK4(step=1e-3), jo.ROS2(step=1e-3)], ids=["RK4", "ROS2"])
def test_a_run_continues_to_the_last_digit(solver: Any) -> None:
    model = jo.compile(rubbing(2, STICKS), core="joint")
    whole = jo.simulate(model, 0.6, solver=solver, output_step=0.05)
    first = jo.simulate(model, 0.3, solver=solver, output_step=0.05)
    rest = jo.simulate(model, 0.6, solver=solver, output_step=0.05, state=first.state())
    np.testing.assert_array_equal(rest.q[-1], whole.q[-1])
    np.testing.assert_array_equal(rest.v[-1], whole.v[-1])


def test_a_rewound_engine_runs_the_same_again() -> None:
    engine = Engine(jo.compile(rubbing(2, STICKS), core="joint"))
    solver = engine.native_solver("rk4", 2e-3, True)
    for _ in range(50):
        engine.step(solver)
    rewind = engine.mark()
    for _ in range(100):
        engine.step(solver)
    q, slip = engine.q.copy(), engine.slip.copy()
    rewind()
    for _ in range(100):
        engine.step(solver)
    np.testing.assert_array_equal(engine.q, q)
    np.testing.assert_array_equal(engine.slip, slip)


def test_what_sticks_is_kept_by_a_caller_who_moves_the_rest() -> None:
    """A state of q and v that opens a held joint is closed in the metric of the masses."""
    mechanism = rubbing(2, STICKS)
    found = []
    for core in ("joint", "maximal"):
        engine = Engine(jo.compile(mechanism, core=core))
        put(engine, 2, 1.0)
        assert engine.locked.any()
        engine.v += 0.01 * np.random.default_rng(1).normal(size=engine.model.nv)
        engine.step(engine.native_solver("rk4", 1e-5, True))
        found.append((engine.q.copy(), engine.v.copy()))
    (q, v), (p, w) = found
    np.testing.assert_allclose(q, p, rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(v, w, rtol=0.0, atol=1e-3)


# -- closed forms -----------------------------------------------------------------------------


def slide(speed: float, angle: float = 0.0, *, turned: bool = False) -> Any:
    """A block of 2 kg on a slide along x that rises by an angle, at x = 0; mu 0.3 and 0.4."""
    x = np.array([np.cos(angle), np.sin(angle), 0.0])
    block = jo.RigidBody("block", 2.0, (0.1, 0.1, 0.1), velocity=speed * x)
    sides = (jo.ground["origin"], block["origin"])
    way = jo.Prismatic("way", *(sides[::-1] if turned else sides), axis=x)
    rub = jo.Friction("rub", way, 0.3, 0.4, law=STICKS)
    return jo.Mechanism(block, way, rub, jo.Gravity((0, -G, 0)))


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("solver", [jo.RK4(step=0.01), jo.ROS2(step=0.01)], ids=["RK4", "ROS2"])
def test_a_block_stops_where_its_energy_is_spent(solver: Any, turned: bool) -> None:
    run = jo.simulate(jo.compile(slide(2.0, turned=turned), core="joint"), 1.0, solver=solver)
    assert run.q[-1][0] == pytest.approx(2.0**2 / (2.0 * 0.3 * G), rel=1e-9)
    assert run.v[-1][0] == 0.0
    assert run.energy.friction[-1] == pytest.approx(0.5 * 2.0 * 2.0**2, rel=1e-9)


@pytest.mark.parametrize("share", [0.999, 1.001])
def test_a_block_on_a_slope_holds_up_to_its_static_friction(share: float) -> None:
    angle = np.arctan(0.4 * share)
    run = jo.simulate(jo.compile(slide(0.0, angle), core="joint"), 1.0, solver=jo.RK4(step=0.01))
    rate = 0.0 if share < 1.0 else G * (np.sin(angle) - 0.3 * np.cos(angle))
    assert np.linalg.norm(run.q[-1][:3]) == pytest.approx(0.5 * rate, rel=1e-9)


def test_a_block_that_slides_up_turns_round_or_stays() -> None:
    """Up to v^2 / 2 g (sin + mu cos); steeper than the static friction holds it comes down."""
    for tangent in (0.35, 0.5):
        angle = np.arctan(tangent)
        model = jo.compile(slide(1.0, angle), core="joint")
        up = G * (np.sin(angle) + 0.3 * np.cos(angle))
        down = G * (np.sin(angle) - 0.3 * np.cos(angle)) if tangent > 0.4 else 0.0
        run = jo.simulate(model, 1.0, solver=jo.RK4(step=0.01))
        end = 0.5 / up - 0.5 * down * (1.0 - 1.0 / up) ** 2
        along = run.q[-1][:2] @ [np.cos(angle), np.sin(angle)]
        assert along == pytest.approx(end, rel=1e-8)


def test_a_pendulum_on_a_pin_turns_when_the_reference_says() -> None:
    model = with_core(pendulum(STICKS), "joint")
    assert model.links
    found, _ = transitions(model, 5.0, "rk4", 5e-3)
    exact = np.array(PinPendulum().turning_points(np.pi / 2, 4))
    np.testing.assert_allclose(found[:, 0], exact[:, 0], rtol=0.0, atol=3e-8)
    np.testing.assert_array_equal(found[:, 2], [1, -1, 1, -1])


@pytest.mark.parametrize("share", [0.999, 1.001])
def test_a_pendulum_hangs_askew_up_to_the_static_friction_of_its_pin(share: float) -> None:
    """m g l sin(angle) against mu r m g."""
    length, radius, static = 0.5, 0.05, 0.4
    angle = share * np.arcsin(static * radius / length)
    way = np.array([np.sin(angle), -np.cos(angle), 0.0])
    bob = jo.RigidBody("bob", 1.0, (0.1, 0.1, 0.1), position=length * way)
    pin = jo.Revolute("pin", jo.ground["origin"], bob.at(-length * way), axis=(0, 0, 1))
    rub = jo.Friction("rub", pin, 0.3, static, radius=radius, law=STICKS)
    model = jo.compile(jo.Mechanism(bob, pin, rub, jo.Gravity((0, -G, 0))), core="joint")
    run = jo.simulate(model, 0.5, solver=jo.RK4(step=0.01))
    moved = np.abs(run.q[-1] - run.q[0]).max()
    assert moved == 0.0 if share < 1.0 else moved > 1e-4
