"""Rigid trees on flexible bodies, condensed to their ports, against the rows of all joints."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.model.native.native import Engine
from model.test_tree import (
    KINDS,
    assert_rewinds,
    compared,
    coordinates,
    final,
    joint,
    marker,
    moved,
)
from verification.mechanisms import rod

Z = (0.0, 0.0, 1.0)


def kinds(model: Any) -> list[str]:
    return [link.kind for link in model.links]


def rigid(name: str, rng: np.random.Generator, at: Any = None) -> jo.RigidBody:
    L = 0.3 * rng.normal(size=(3, 3))
    return jo.RigidBody(
        name,
        rng.uniform(0.5, 3.0),
        np.trace(L @ L.T) * np.eye(3) - L @ L.T + 0.05 * np.eye(3),
        center=0.3 * rng.normal(size=3),
        position=rng.normal(size=3) if at is None else at,
        orientation=jo.Rotate(rng.normal(size=3), degrees=float(rng.uniform(0, 90))),
    )


def grown(
    root: Any, count: int, rng: np.random.Generator, kinds: tuple[str, ...] = KINDS
) -> tuple[list[Any], list[Any]]:
    """A random tree of rigid bodies on one of them, or on the ground, and its joints."""
    bodies, joints = [root], list[Any]()
    name = "ground" if root is jo.ground else root.name
    for i in range(count):
        parent = bodies[int(rng.integers(len(bodies)))]
        body = rigid(f"{name}-{i}", rng)
        pair = (parent, body) if rng.random() < 0.6 else (body, parent)
        kind = kinds[(i + int(rng.integers(2))) % len(kinds)]
        joints.append(joint(kind, f"of {body.name}", *pair, rng))
        bodies.append(body)
    return bodies[1:], joints


def machine(seed: int, count: int = 7, drives: bool = False, more: tuple[Any, ...] = ()) -> Any:
    """Two booms on a rigid base, which carries a tree as well, one on each of them, one apart."""
    rng = np.random.default_rng(seed)
    booms = [
        jo.FlexibleBody("near", rod(), damping=0.02),
        jo.FlexibleBody("far", rod(modes=4), position=(1.0, 0, 0), damping=0.01),
    ]
    base, tool, hand = (
        rigid("base", rng),
        rigid("tool", rng, (1, 0, 0)),
        rigid("hand", rng, (2, 0, 0)),
    )
    trees = [grown(root, count, rng) for root in (tool, base, hand)] + [grown(jo.ground, 2, rng)]
    inner = [j for _, joints in trees for j in joints]
    start, end = booms[0]["start"], booms[1]["end"]
    holds = [
        joint("prismatic", "rail", jo.ground, base, rng),
        jo.Revolute("foot", marker(base, np.zeros(3)), start, axis=Z)
        if seed % 2
        else jo.Spherical("foot", start, jo.ground.at((0, 0, 0))),
        jo.Universal("knuckle", booms[0]["end"], booms[1]["start"], axis_a=Z, axis_b=(0, 1, 0)),
        jo.Revolute("wrist", booms[0]["end"], tool.at((0, 0, 0)), axis=(1, 1, 0)),
        (jo.Spherical if seed % 3 else jo.Fixed)("clamp", hand.at((0, 0, 0)), end),
    ]
    free = coordinates(inner)
    grown_on = [found for found, _ in trees]  # in no order that the engine has them in
    bodies = [*grown_on[1], base, booms[0], *grown_on[0], booms[1], hand, tool, *grown_on[2]]
    bodies += grown_on[3]
    last, first = trees[0][0][-1], trees[1][0][0]
    items: list[Any] = [*bodies, *holds, *inner, jo.Gravity(rng.normal(size=3))]
    for i, c in enumerate(free[::2]):
        items.append(jo.Spring(f"spring{i}", c, stiffness=5.0, damping=0.4, free=0.1, preload=0.3))
    items += [
        jo.Spring("hold", holds[3].angle, stiffness=30.0, damping=0.4),
        jo.Spring.between("strut", booms[1]["end"], last.at((0.1, 0, 0)), 4.0, damping=0.3),
        jo.Torque("torque", first.at((0, 0, 0)), rng.normal(size=3), follow=True),
        jo.Force("force", last.at(rng.normal(size=3)), rng.normal(size=3)),
        jo.Force("push", booms[0]["end"], rng.normal(size=3)),
        jo.Bushing("bushing", tool.at((0, 0, 0)), last.at((0, 0, 0)), (9, 8, 7, 2, 3, 4), 0.3),
        *(jo.ReactionSensor(f"of_{one.name}", one) for one in (*holds, *inner)),
        jo.PositionSensor("tip", last.at((0.2, 0, 0))),
        jo.AccelerationSensor("shock", last.at((0.2, 0, 0))),
        jo.CoordinateSensor("bend", holds[3].angle),
    ]
    if free[1::2]:
        items.append(
            jo.Servo("servo", free[1], jo.Harmonic(frequency=0.3, amplitude=0.4), kp=3.0, kd=0.2)
        )
    if drives:
        plain = [one for one in inner[1:] if not isinstance(one, jo.Universal)]
        for name, c in (("drive", coordinates(plain)[0]), ("swing", holds[3].angle)):
            turn = jo.Harmonic(frequency=0.2, amplitude=0.3, offset=c.initial)
            items.append(jo.Drive(name, c, turn))
    return jo.Mechanism(*items, *more, name="machine")


# positions closed to 1e-12 by assembly; accelerations at the end of branches on a boom
@pytest.mark.parametrize("drives", [False, True])
@pytest.mark.parametrize("seed", range(6))
def test_random_machines(seed: int, drives: bool) -> None:
    mechanism = machine(seed, drives=drives)
    model = jo.compile(mechanism, core="joint")
    assert len(model.bodies) - kinds(model).count("body") >= 20
    assert any(link.driven >= 0 for link in model.links) == drives
    a, lam = compared(mechanism, seed)
    assert a < 1e-11
    assert lam < 1e-11


def test_derivatives_go_through_ports() -> None:
    """The build with complex numbers, whose vectors are three scalars."""
    a, lam = compared(machine(1, drives=True), 1, complex_scalars=True)
    assert a < 1e-11
    assert lam < 1e-11


def test_derivatives_by_a_mass_are_those_of_differences() -> None:
    model = jo.compile(machine(2), core="joint")
    carried = next(link.body for link in model.links if link.kind == "hinge" and link.body >= 0)
    q, v = moved(model, 2)

    def a(mass: complex, scalars: bool) -> Any:
        override = {("body", carried, "mass"): np.array([mass])}
        engine = Engine(model, complex_scalars=scalars, override=override)
        engine.q[:], engine.v[:], engine.time[0] = q, v, 0.3
        return engine.tree_accelerations()[0].copy()

    mass = float(model.bodies[carried].mass[0])
    exact = a(mass + 1e-30j, True).imag / 1e-30
    h = 1e-4 * mass
    central = (a(mass + h, False) - a(mass - h, False)).real / (2 * h)
    assert np.abs(exact).max() > 1e-3
    # h^2 of the third derivative
    np.testing.assert_allclose(exact, central, rtol=0, atol=1e-6 * np.abs(exact).max())


# both are of the order of the method: their difference falls with its power of the step
@pytest.mark.parametrize(("solver", "least"), [(jo.RK4, 13.0), (jo.ROS2, 3.5)], ids=["RK4", "ROS2"])
@pytest.mark.parametrize("drives", [False, True])
def test_runs_agree_at_the_order_of_the_method(drives: bool, solver: Any, least: float) -> None:
    mechanism = machine(1, count=4, drives=drives)
    models = [jo.compile(mechanism, core=core) for core in ("joint", "maximal")]
    apart = []
    for step in (1e-3, 5e-4):
        one, other = (final(model, solver(step=step)) for model in models)
        apart.append(np.abs(one[0] - other[0]).max())
    assert apart[0] < 1e-4
    assert apart[0] > least * apart[1]
    for name, values in one[1].items():
        scale = np.abs(other[1][name]).max()
        np.testing.assert_allclose(values, other[1][name], rtol=0, atol=1e-3 * scale + 1e-6)


@pytest.mark.parametrize(("solver", "least"), [(jo.RK4, 13.0), (jo.ROS2, 3.5)], ids=["RK4", "ROS2"])
def test_the_error_of_energy_falls_with_the_order(solver: Any, least: float) -> None:
    model = jo.compile(machine(4, count=4, drives=True), core="joint")
    errors = []
    for step in (1e-3, 5e-4):
        run = jo.simulate(model, 0.2, solver=solver(step=step), output_step=0.1)
        errors.append(float(np.abs(run.energy.error).max()))
    assert errors[0] > least * errors[1]


@pytest.mark.parametrize("solver", [jo.RK4(step=1e-3), jo.ROS2(step=1e-3)], ids=["RK4", "ROS2"])
def test_a_run_continues_to_the_last_digit(solver: Any) -> None:
    model = jo.compile(machine(5, count=4, drives=True), core="joint")
    whole = jo.simulate(model, 0.2, solver=solver, output_step=0.05)
    first = jo.simulate(model, 0.1, solver=solver, output_step=0.05)
    rest = jo.simulate(model, 0.2, solver=solver, output_step=0.05, state=first.state())
    np.testing.assert_array_equal(rest.q[-1], whole.q[-1])
    np.testing.assert_array_equal(rest.v[-1], whole.v[-1])


def test_a_state_of_the_other_core_starts_a_run(tmp_path: Path) -> None:
    joint_core, maximal = (
        jo.compile(machine(1, count=3), core=core) for core in ("joint", "maximal")
    )
    solver = jo.RK4(step=5e-4)
    jo.simulate(maximal, 0.1, solver=solver, path=tmp_path / "half.h5")
    rest = jo.simulate(joint_core, 0.2, solver=solver, state=jo.load(tmp_path / "half.h5").state())
    whole = jo.simulate(maximal, 0.2, solver=solver)
    begun = jo.simulate(joint_core, 0.1, solver=solver).state()
    back = jo.simulate(maximal, 0.2, solver=solver, state=begun)
    for run in (rest, back):  # errors of RK4 at 0.5 ms in both
        np.testing.assert_allclose(run.q[-1], whole.q[-1], rtol=0, atol=1e-7)


def test_a_rewound_engine_runs_the_same_again() -> None:
    assert_rewinds(jo.compile(machine(0, count=3), core="joint"), "ros2")


@pytest.mark.parametrize(
    "solver",
    [jo.GeneralizedAlpha(step=1e-3), jo.simulation.DormandPrince(tolerance=1e-7)],
    ids=["alpha", "DormandPrince"],
)
def test_other_methods_run_in_the_positions_of_the_bodies(solver: Any) -> None:
    """The order of elimination alone is another one: equal up to round-off, not to the error."""
    mechanism = machine(2, count=3)
    one, other = (
        final(jo.compile(mechanism, core=core), solver)[0] for core in ("joint", "maximal")
    )
    np.testing.assert_allclose(one, other, rtol=0, atol=1e-12)


def test_joints_that_have_rows_stay_closed() -> None:
    """Steps are wrong by 1e-4, gaps and their rates are closed nevertheless."""
    model = jo.compile(machine(1, count=3), core="joint")
    engine = Engine(model)
    for method in ("rk4", "ros2"):
        solver = engine.native_solver(method, 4e-3 if method == "ros2" else 1e-3, True)
        for _ in range(20):
            engine.step(solver)
        gap, rate = engine.residuals()
        assert gap < 1e-11 * model.size
        assert rate < 1e-9 * model.size


@pytest.mark.filterwarnings("ignore:.*redundant")
def test_reactions_that_are_not_unique_are_those_of_least_norm() -> None:
    """A base on two hinges of one axis carries a boom with a chain, and a chain itself."""
    rng = np.random.default_rng(3)
    base, tool = rigid("base", rng, (0, 0, 0)), rigid("tool", rng, (1, 0, 0))
    boom = jo.FlexibleBody("boom", rod())
    hinges = [
        jo.Revolute(f"hinge{k}", jo.ground.at((0, 0, z)), marker(base, np.array([0, 0, z])), axis=Z)
        for k, z in enumerate((-0.3, 0.4))
    ]
    trees = [grown(root, 3, rng) for root in (base, tool)]
    joints = [
        jo.Spherical("foot", marker(base, np.zeros(3)), boom["start"]),
        jo.Revolute("wrist", boom["end"], tool.at((0, 0, 0)), axis=Z),
        *(joint for _, joints in trees for joint in joints),
    ]
    sensors = [jo.ReactionSensor(f"of_{one.name}", one) for one in (*hinges, *joints)]
    bodies = [base, boom, tool, *(body for found, _ in trees for body in found)]
    mechanism = jo.Mechanism(*bodies, *hinges, *joints, *sensors, jo.Gravity((0, 1, -9.81)))
    found = []
    for core in ("joint", "maximal"):
        model = jo.compile(mechanism, core=core)
        assert model.redundant
        found.append(jo.simulate(model, 1e-4, solver=jo.RK4(step=1e-4)))
    one, other = found
    for sensor in sensors:  # 1e-7 is what the regularisation leaves in another order of the rows
        scale = np.abs(other[sensor.name]).max()
        np.testing.assert_allclose(
            one[sensor.name][-1], other[sensor.name][-1], rtol=0, atol=1e-6 * scale + 1e-6
        )
