"""Trees in joint coordinates against the rows of their joints in the positions of all bodies."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import jousto as jo
from jousto.base.errors import SimulationError
from jousto.model.native.native import Engine, displaced

Array = NDArray[np.float64]
KINDS = ("revolute", "prismatic", "cylindrical", "universal", "spherical", "fixed")


def marker(body: Any, point: Array) -> Any:
    """A marker at a point of the world."""
    if body is jo.ground:
        return jo.ground.at(point)
    e = np.roll(np.asarray(body.orientation), -1)
    return body.at(Rotation.from_quat(e).inv().apply(point - body.position))


def joint(kind: str, name: str, a: Any, b: Any, rng: np.random.Generator) -> Any:
    point, axis = rng.normal(size=3), rng.normal(size=3)
    A, B = marker(a, point), marker(b, point)
    if kind == "spherical":
        return jo.Spherical(name, A, B)
    if kind == "fixed":
        return jo.Fixed(name, A, B)
    if kind == "universal":
        across = np.cross(axis, rng.normal(size=3))
        return jo.Universal(name, A, B, axis_a=axis, axis_b=across)
    made = {"revolute": jo.Revolute, "prismatic": jo.Prismatic, "cylindrical": jo.Cylindrical}[kind]
    return made(name, A, B, axis=axis)


def coordinates(joints: list[Any]) -> list[Any]:
    return [c for one in joints for c in one.coordinates]


def tree(seed: int, count: int = 8, kinds: tuple[str, ...] = KINDS, drives: bool = False) -> Any:
    """A mechanism of a random tree; one in three has a free root, joints have any side first."""
    rng = np.random.default_rng(seed)
    bodies = []
    for i in range(count):
        L = 0.3 * rng.normal(size=(3, 3))
        bodies.append(
            jo.RigidBody(
                f"body{i}",
                rng.uniform(0.5, 3.0),
                np.trace(L @ L.T) * np.eye(3) - L @ L.T + 0.05 * np.eye(3),
                center=0.3 * rng.normal(size=3),
                position=rng.normal(size=3),
                orientation=Rotation.random(random_state=rng).as_quat()[[3, 0, 1, 2]],
            )
        )
    joints: list[Any] = []
    for i in range(count):
        parent = jo.ground if i == 0 else bodies[int(rng.integers(i))]
        if i == 0 and seed % 3 == 0:
            continue
        pair = (parent, bodies[i]) if rng.random() < 0.6 else (bodies[i], parent)
        kind = kinds[int(rng.integers(len(kinds)))]
        if drives and i == 1:
            kind = "cylindrical"
        joints.append(joint(kind, f"joint{i}", *pair, rng))
    free = coordinates(joints)
    items: list[Any] = [*bodies, *joints, jo.Gravity(rng.normal(size=3))]
    for i, c in enumerate(free[::2]):
        items.append(jo.Spring(f"spring{i}", c, stiffness=5.0, damping=0.4, free=0.1, preload=0.3))
    a, b = bodies[0].at(rng.normal(size=3)), bodies[-1].at(rng.normal(size=3))
    items += [
        jo.Spring.between("strut", a, b, 4.0, damping=0.3, free=0.2),
        jo.Torque("torque", bodies[1].at((0, 0, 0)), rng.normal(size=3), follow=True),
        jo.Force("force", bodies[2].at(rng.normal(size=3)), rng.normal(size=3)),
        jo.Bushing(
            "bushing",
            jo.ground.at(rng.normal(size=3)),
            bodies[3].at((0, 0, 0)),
            (9, 8, 7, 2, 3, 4),
            0.3,
        ),
        *(jo.ReactionSensor(f"of_{one.name}", one) for one in joints),
    ]
    if free[1::2]:
        items.append(
            jo.Servo("servo", free[1], jo.Harmonic(frequency=0.3, amplitude=0.4), kp=3.0, kd=0.2)
        )
    if drives:
        driven = next(
            c for one in joints if not isinstance(one, jo.Universal) for c in one.coordinates
        )
        offset = driven.initial
        items.append(
            jo.Drive("drive", driven, jo.Harmonic(frequency=0.2, amplitude=0.5, offset=offset))
        )
    return jo.Mechanism(*items, name="tree")


def moved(model: Any, seed: int, time: float = 0.3) -> tuple[Array, Array]:
    """A random position and velocity that the joints allow."""
    rng = np.random.default_rng(seed)
    engine = Engine(model)
    engine.time[0] = time
    engine.q[:] = displaced(model, engine.q, 0.1 * rng.normal(size=model.nv))
    engine.v[:] = rng.normal(size=model.nv)
    engine.assemble()
    return engine.q.copy(), engine.v.copy()


def compared(mechanism: Any, seed: int, complex_scalars: bool = False) -> tuple[float, float]:
    """Largest relative differences of accelerations and of multipliers."""
    model = jo.compile(mechanism, core="joint")
    q, v = moved(model, seed)
    found = []
    for own in (False, True):
        engine = Engine(model, complex_scalars=complex_scalars)
        engine.q[:], engine.v[:], engine.time[0] = q, v, 0.3
        a, lam = engine.tree_accelerations() if own else engine.accelerations()
        found.append((a.real.copy(), lam.real.copy()))
    (a, lam), (b, mu) = found
    scale = max(1.0, np.abs(lam).max(initial=0.0))
    return np.abs(a - b).max() / max(1.0, np.abs(a).max()), np.abs(lam - mu).max(
        initial=0.0
    ) / scale


# positions closed to 1e-12 by assembly, accelerations of bodies at the end of a branch of eight
@pytest.mark.parametrize("drives", [False, True])
@pytest.mark.parametrize("seed", range(6))
def test_random_trees(seed: int, drives: bool) -> None:
    a, lam = compared(tree(seed, drives=drives), seed)
    assert a < 1e-11
    assert lam < 1e-11


def final(model: Any, solver: Any) -> tuple[Array, dict[str, Array]]:
    run = jo.simulate(model, 0.2, solver=solver, output_step=0.1)
    return run.q, {name: run[name] for name in run.sensors}


# both are of the order of the method: their difference falls with its power of the step
@pytest.mark.parametrize(("solver", "least"), [(jo.RK4, 13.0), (jo.ROS2, 3.5)], ids=["RK4", "ROS2"])
@pytest.mark.parametrize("seed", [2, 3])
def test_runs_agree_at_the_order_of_the_method(seed: int, solver: Any, least: float) -> None:
    mechanism = tree(seed, drives=seed == 2)
    models = [jo.compile(mechanism, core=core) for core in ("joint", "maximal")]
    apart = []
    for step in (8e-3, 4e-3):
        one, other = (final(model, solver(step=step)) for model in models)
        apart.append(np.abs(one[0] - other[0]).max())
    assert apart[0] < 1e-4
    assert apart[0] > least * apart[1]


def test_error_control_agrees() -> None:
    mechanism = tree(4)
    models = [jo.compile(mechanism, core=core) for core in ("joint", "maximal")]
    solver = jo.simulation.DormandPrince(tolerance=1e-8)
    (q, one), (p, other) = (final(model, solver) for model in models)
    np.testing.assert_allclose(q, p, atol=1e-6)
    for name, values in one.items():
        np.testing.assert_allclose(values, other[name], atol=1e-5 * np.abs(values).max() + 1e-6)


@pytest.mark.parametrize("solver", [jo.RK4(step=1e-3), jo.ROS2(step=1e-3)], ids=["RK4", "ROS2"])
def test_a_run_continues_to_the_last_digit(solver: Any) -> None:
    model = jo.compile(tree(5, drives=True), core="joint")
    whole = jo.simulate(model, 0.2, solver=solver, output_step=0.05)
    first = jo.simulate(model, 0.1, solver=solver, output_step=0.05)
    rest = jo.simulate(model, 0.2, solver=solver, output_step=0.05, state=first.state())
    np.testing.assert_array_equal(rest.q[-1], whole.q[-1])
    np.testing.assert_array_equal(rest.v[-1], whole.v[-1])


def assert_rewinds(model: Any, method: str) -> None:
    """Three steps are the same again after the engine has gone back."""
    engine = Engine(model)
    solver = engine.native_solver(method, 1e-3, True)
    engine.step(solver)
    rewind = engine.mark()
    found = []
    for _ in range(2):
        for _ in range(3):
            engine.step(solver)
        found.append(engine.q.copy())
        rewind()
    np.testing.assert_array_equal(*found)


def test_a_rewound_engine_runs_the_same_again() -> None:
    assert_rewinds(jo.compile(tree(6), core="joint"), "rk4")


def released() -> Any:
    """A rod that an event lets go."""
    rod = jo.RigidBody("rod", 1.0, (0.1, 0.1, 0.1), center=(0.5, 0, 0))
    pivot = jo.Revolute("pivot", jo.ground.at((0, 0, 0)), rod.at((0, 0, 0)), axis=(0, 0, 1))
    low = jo.mechanism.Event("low", pivot.angle, -0.5, releases=pivot)
    return jo.Mechanism(rod, pivot, low)


def test_what_is_no_tree_says_why() -> None:
    with pytest.raises(jo.InputError, match="event 'low' releases 'pivot'"):
        jo.compile(released(), core="joint")
    assert not jo.compile(released()).links
    assert "releases" in jo.doctor(released()).core


def test_an_unknown_core_is_refused() -> None:
    with pytest.raises(jo.InputError, match="core is 'fast', must be 'auto', 'joint' or 'maximal'"):
        jo.compile(released(), core="fast")


def test_ros2_takes_springs_of_joints_in_its_matrix() -> None:
    """A hinge spring of 1e5 rad/s at a step of 1 ms: the angle stays where it is held."""
    rod = jo.RigidBody("rod", 1.0, (0.1, 0.1, 0.1), center=(0.5, 0, 0))
    pivot = jo.Revolute("pivot", jo.ground.at((0, 0, 0)), rod.at((0, 0, 0)), axis=(0, 0, 1))
    hold = jo.Spring("hold", pivot.angle, stiffness=3.5e9, free=0.0)
    mechanism = jo.Mechanism(rod, pivot, hold, jo.Gravity((0, -9.81, 0)))
    engine = Engine(jo.compile(mechanism, core="joint"))
    solver = engine.native_solver("ros2", 1e-3, True)
    for _ in range(100):
        engine.step(solver)
    # m g c over the stiffness, to which the L-stable method goes at once
    assert engine.joint[0] == pytest.approx(-9.81 * 0.5 / 3.5e9, rel=1e-6)


def test_a_model_that_was_changed_no_longer_runs_as_its_tree() -> None:
    model = jo.compile(tree(1), core="joint")
    assert model.links
    assert not replace(model, joints=model.joints[:-1]).links


def test_a_smooth_drive_moves_a_link_and_one_that_may_jump_is_a_row() -> None:
    rod = jo.RigidBody("rod", 1.0, (0.1, 0.1, 0.1), center=(0.5, 0, 0))
    pivot = jo.Revolute("pivot", jo.ground.at((0, 0, 0)), rod.at((0, 0, 0)), axis=(0, 0, 1))

    def driven(signal: Any) -> Any:
        return jo.Mechanism(rod, pivot, jo.Drive("motor", pivot.angle, signal))

    smooth = jo.compile(driven(jo.SCurve((0.0, 1.0), (0.0, 2.0))), core="joint")
    kinked = jo.compile(driven(jo.Ramp(0.0, 1.0, 0.0, 2.0)), core="joint")
    assert [model.links[0].drive for model in (smooth, kinked)] == [1, -1]


@pytest.mark.parametrize("k", range(3))
@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
def test_the_body_that_diverges_is_named(k: int) -> None:
    """A joint rate beyond 1e15 1/s: the body behind this joint."""
    bodies = [jo.RigidBody(f"b{i}", 1.0, (1.0,) * 3, position=(i, 0, 0)) for i in range(3)]
    ends = [jo.ground["origin"], *(one.at((1, 0, 0)) for one in bodies)]
    pins = [
        jo.Revolute(f"p{i}", a, b["origin"], axis=(1, 0, 0))
        for i, (a, b) in enumerate(zip(ends, bodies, strict=False))
    ]
    model = jo.compile(jo.Mechanism(*bodies, *pins), core="joint")
    engine = Engine(model)
    for body in model.bodies[k:]:
        engine.v[body.iv + 3] = 2e15  # all turn with the first one about a common axis
    with pytest.raises(SimulationError) as error:
        engine.step(engine.native_solver("rk4", 1e-3, True))
    assert error.value.body == f"b{k}"
