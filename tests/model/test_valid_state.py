"""Whatever an engine has computed before, it finds what a fresh engine finds at the same state."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError, SimulationError
from jousto.model.native.header import places
from jousto.model.native.native import Engine, displaced
from model.test_beam_motion import flying
from model.test_tree import tree
from model.test_tree_friction import rubbing
from model.test_tree_ports import machine

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")

STATE = (
    *("q", "v", "a", "lam", "time", "input", "turn", "happened", "locked", "held", "slip"),
    *("direction", "states", "state_rates", "joint", "meters"),
)
METHODS = ("rk4", "ros2", "alpha", "dopri")
STEP = 2.0**-10  # s
ORDERS = 6  # random orders of each model
LENGTH = 30  # calls of an order
# of a row: what tells of the way to the state
HISTORY = (
    "dissipated",
    "friction",
    "work",
    "evaluations",
    "iterations",
    "steps",
    "rejected",
    "step",
)


def swing() -> Any:
    """A pendulum of two links with a controller, an input, a spring that breaks and a meter."""
    z = (0, 0, 1)
    upper = jo.RigidBody("upper", 2.0, (0.02, 0.2, 0.2), center=(0.5, 0, 0))
    lower = jo.RigidBody("lower", 1.0, (0.01, 0.1, 0.1), center=(0.4, 0, 0), position=(1, 0, 0))
    pivot = jo.Revolute("pivot", jo.ground["origin"], upper["origin"], axis=z)
    elbow = jo.Revolute("elbow", upper.at((1, 0, 0)), lower["origin"], axis=z)
    angle = jo.CoordinateSensor("angle", pivot.angle)
    hold = jo.Spring("hold", elbow.angle, stiffness=20.0, damping=0.5)
    gate = jo.mechanism.Event("gate", angle, -0.001, "falling", releases=hold)
    curve = jo.SN(S_D=100e6, N_D=1e6, k=5)
    return jo.Mechanism(
        *(upper, lower, pivot, elbow, angle, hold, gate, jo.Gravity((0, -9.81, 0))),
        jo.mechanism.PID("pid", elbow.angle, jo.Constant(0.3), kp=5.0, ki=2.0, kd=0.3),
        jo.Torque("motor", lower.at((0.1, 0, 0)), z, signal=jo.Input("volts", 1.0)),
        jo.mechanism.DamageSensor("life", angle, curve, residue="half", factor=1e8),
        jo.ReactionSensor("reaction", pivot),
        jo.AccelerationSensor("shock", lower.at((0.8, 0, 0))),
        name="swing",
    )


MODELS: dict[str, Callable[[], Any]] = {
    "joint coordinates": lambda: jo.compile(tree(1), core="joint"),
    "free root": lambda: jo.compile(tree(3, drives=True), core="joint"),
    "maximal": lambda: jo.compile(tree(2), core="maximal"),
    "mixed": lambda: jo.compile(machine(1), core="joint"),
    "mixed, driven": lambda: jo.compile(machine(2, drives=True), core="joint"),
    "beams": lambda: flying(0.0, beta=1e-3),
    "beams that couple masses": lambda: flying(1.0),
    "friction": lambda: jo.compile(rubbing(1), core="joint"),
    "friction, maximal": lambda: jo.compile(rubbing(4), core="maximal"),
    "events": lambda: jo.compile(swing(), core="joint"),
    "events, maximal": lambda: jo.compile(swing(), core="maximal"),
}


def solver_of(engine: Engine, method: str) -> Any:
    options = jo.GeneralizedAlpha(STEP).options if method == "alpha" else {}
    return engine.native_solver(method, STEP, True, **options)


def adaptive(engine: Engine) -> Any:
    return engine.native_solver(
        "dopri", STEP, True, **jo.simulation.DormandPrince(1e-6, output=STEP).options
    )


def fresh(engine: Engine) -> Engine:
    """A new engine at the state of another one."""
    new = Engine(engine.model)
    for name in STATE:
        getattr(new, name)[:] = getattr(engine, name)
    return new


def state(engine: Engine) -> dict[str, Any]:
    return {name: getattr(engine, name).copy() for name in STATE if name not in ("a", "lam")}


def of_state(engine: Engine, row: Any) -> Any:
    """A row without what tells of the way to its state."""
    names = list(places("jo_diagnostics"))
    first = 1 + engine.model.nq + engine.model.nv + engine.model.nrow
    return np.delete(row, [first + names.index(word) for word in HISTORY])


# -- what is asked of both engines: each returns what shall be the same --------------------------


def accelerations(engine: Engine) -> list[Any]:
    a, lam = engine.accelerations()
    return [a.copy(), lam.copy(), engine.power.copy(), engine.sensors()]


def tree_accelerations(engine: Engine) -> list[Any]:
    if not engine.model.links:
        return []
    a, lam = engine.tree_accelerations()
    return [a.copy(), lam.copy(), engine.joint.copy()]


def row(engine: Engine) -> list[Any]:
    return [of_state(engine, engine.row())]


def residual(engine: Engine) -> list[Any]:
    return [engine.residual(), *engine.constraints()]


def energies(engine: Engine) -> list[Any]:
    return [engine.energy(), engine.mass_matrix(0)]


def matrix(engine: Engine) -> list[Any]:
    return [engine.newton_matrix(1.0, STEP, STEP**2)]


def steps(method: str, rows: int) -> Callable[[Engine], list[Any]]:
    """One step, or so many with their rows, by a method that starts anew.

    Times are multiples of a power of 2, so that their sums are exact.
    """

    def go(engine: Engine) -> list[Any]:
        engine.restart()
        engine.steps_done = 0
        engine.time[:] = np.round(engine.time / STEP) * STEP
        solver = solver_of(engine, method)
        if not rows:
            engine.step(solver)
            return [*state(engine).values(), engine.happenings()]
        out = np.zeros((rows + 1, engine.row_size))
        status, written = engine.run(solver, rows, 1, out)
        assert status in ("ok", "event", "friction failed", "no convergence"), status
        return [of_state(engine, x) for x in out[:written]]

    return go


def step_by_step(method: str) -> Callable[[Engine], list[Any]]:
    """Two steps, each by an engine of its own."""

    def go(engine: Engine) -> list[Any]:
        first = steps(method, 1)(engine)
        return [*first, *steps(method, 1)(fresh(engine))]

    return go


def followed(engine: Engine) -> list[Any]:
    engine.steps_done = 0
    out = np.zeros((3, engine.row_size))
    _, written = engine.follow(adaptive(engine), 2, 1000, out)
    return [of_state(engine, x) for x in out[:written]]


# what an engine is asked, and what a fresh one
ASKED = [
    *((ask, ask) for ask in (accelerations, tree_accelerations, row, residual, energies, matrix)),
    (followed, followed),
    *((steps(method, n), steps(method, n)) for method in METHODS for n in (0, 2)),
    *((steps(method, 2), step_by_step(method)) for method in ("rk4", "ros2")),
]


def outcome(ask: Callable[[Engine], list[Any]], engine: Engine) -> list[Any] | str:
    try:
        return ask(engine)
    except (InputError, SimulationError) as error:
        return str(error)


def same(found: list[Any] | str, expected: list[Any] | str) -> bool:
    if isinstance(found, str) or isinstance(expected, str):
        return found == expected
    pairs = list(zip(found, expected, strict=True))
    return all(
        np.ascontiguousarray(a).tobytes() == np.ascontiguousarray(b).tobytes() for a, b in pairs
    )


# -- what happens in between ----------------------------------------------------------------------


def place(engine: Engine, rng: np.random.Generator) -> None:
    """Another state, input and time."""
    nv = engine.model.nv
    engine.q[:] = displaced(engine.model, engine.q, 1e-3 * rng.normal(size=nv))
    engine.v[:] += 1e-2 * rng.normal(size=nv)
    engine.input[:] += 0.1
    engine.time[0] += 0.01 * rng.random()


def reset(engine: Engine, _: np.random.Generator) -> None:
    engine.q[:], engine.v[:] = engine.model.q0, engine.model.v0


def go_on(engine: Engine, rng: np.random.Generator) -> None:
    """Some steps of a method that remembers its last ones."""
    solver = solver_of(engine, str(rng.choice(METHODS)))
    for _ in range(int(rng.integers(1, 4))):
        engine.step(solver)


def run_on(engine: Engine, rng: np.random.Generator) -> None:
    solver = solver_of(engine, str(rng.choice(METHODS)))
    engine.run(solver, 2, 1, np.zeros((4, engine.row_size)))


def assemble(engine: Engine, _: np.random.Generator) -> None:
    engine.assemble()


def forget(engine: Engine, _: np.random.Generator) -> None:
    engine.restart()


BETWEEN = [place, reset, go_on, run_on, assemble, forget]


@pytest.mark.parametrize("name", MODELS)
def test_any_order_of_calls_finds_what_a_fresh_engine_finds(name: str) -> None:
    model = MODELS[name]()
    for seed in range(ORDERS):
        rng = np.random.default_rng(seed)
        engine, order, marks = Engine(model), list[str](), list[Callable[[], None]]()
        for _ in range(LENGTH):
            choice = rng.random()
            if choice < 0.1:
                marks.append(engine.mark())
                order.append("mark")
            elif choice < 0.2 and marks:
                marks[int(rng.integers(len(marks)))]()
                order.append("rewind")
            elif choice < 0.5:
                change = BETWEEN[int(rng.integers(len(BETWEEN)))]
                order.append(change.__name__)
                try:
                    change(engine, rng)
                except (InputError, SimulationError):
                    order.append("failed")
            else:
                i = int(rng.integers(len(ASKED)))
                ask, answer = ASKED[i]
                order.append(f"{ask.__name__} {i}")
                expected = outcome(answer, fresh(engine))
                found = outcome(ask, engine)
                assert same(found, expected), f"seed {seed}: {', '.join(order)}"


@pytest.mark.parametrize("name", MODELS)
def test_what_is_asked_twice_with_another_state_in_between_is_what_a_fresh_engine_finds(
    name: str,
) -> None:
    model, rng = MODELS[name](), np.random.default_rng(1)
    for ask, answer in ASKED:
        engine = Engine(model)
        outcome(ask, engine)
        place(engine, rng)
        expected = outcome(answer, fresh(engine))
        assert same(outcome(ask, engine), expected), ask.__name__


@pytest.mark.parametrize("method", ["rk4", "ros2"])
@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_evaluations_do_not_depend_on_the_number_of_calls(core: str, method: str) -> None:
    """The acceleration that a row needs is the first of the next step, in the next call as well."""
    model = jo.compile(tree(1), core=core)
    counts = []
    for calls in (1, 4):
        engine = Engine(model)
        for _ in range(calls):
            engine.run(solver_of(engine, method), 8 // calls, 1, np.zeros((9, engine.row_size)))
        counts.append(engine.counts.evaluations)
    assert counts[0] == counts[1] >= 16


@pytest.mark.filterwarnings("ignore:.*redundant")
@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_reactions_of_redundant_loops_count_as_no_evaluation(core: str) -> None:
    """RK4 takes four evaluations a step, and one for the last row."""
    engine, steps_ = Engine(jo.compile(parallelogram(), core=core)), 5
    assert engine.model.redundant
    engine.run(solver_of(engine, "rk4"), steps_, 1, np.zeros((steps_ + 1, engine.row_size)))
    assert engine.counts.evaluations == 4 * steps_ + 1


def parallelogram() -> Any:
    """Two cranks and a coupler with four hinges: planar, so that three rows are redundant."""
    z, sizes = (0, 0, 1), {"mass": 1.0, "inertia": (0.1,) * 3}
    up: dict[str, Any] = {**sizes, "center": (0, 0.5, 0), "markers": {"end": (0, 1, 0)}}
    left, right = jo.RigidBody("left", **up), jo.RigidBody("right", position=(1, 0, 0), **up)
    top = jo.RigidBody("top", **sizes, position=(0, 1, 0), markers={"end": (1, 0, 0)})
    first = jo.Revolute("p", jo.ground["origin"], left["origin"], axis=z)
    return jo.Mechanism(
        *(left, top, right, first, jo.Initial(first.angle, rate=2.0)),
        jo.Revolute("q", left["end"], top["origin"], axis=z),
        jo.Revolute("r", top["end"], right["end"], axis=z),
        jo.Revolute("s", jo.ground.at((1, 0, 0)), right["origin"], axis=z),
    )
