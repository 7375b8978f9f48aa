"""Machines side by side in the lanes of a vector: each moves as it does alone."""

from __future__ import annotations

import ctypes
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.model.model import ForceModel, SignalModel
from jousto.model.native import ensemble, library
from jousto.model.native.ensemble import Ensemble, structure
from jousto.model.native.native import Engine, displaced
from jousto.model.tree import with_core
from jousto.simulation.running.batched_runs import run_in_lanes as side_by_side
from jousto.simulation.running.repeated_runs import Repeated
from jousto.simulation.solvers.runge_kutta import RungeKutta
from model import test_forces, test_joints, test_sensors, test_tree

STEP, STEPS, EVERY = 1e-3, 60, 10
EVALUATIONS, DIAGNOSTICS = (
    9,
    14,
)  # the place of one of the, and how many numbers between the multipliers and the sensors
SOLVERS = {
    "rk4": jo.RK4(step=STEP),
    "ros2": jo.ROS2(step=STEP),
    "ssprk3": jo.simulation.SSPRK3(step=STEP),
    "ros3a": jo.simulation.ROS3A(step=STEP),
    "ros2, free": jo.ROS2(
        step=STEP, projection=False, baumgarte=jo.simulation.Baumgarte(50.0, 50.0)
    ),
}

pytestmark = [
    pytest.mark.skipif(ensemble.machines() == 1, reason="no build of lanes for this processor"),
    pytest.mark.filterwarnings("ignore::jousto.JoustoWarning"),
]


@pytest.fixture(params=list(library.LANES), autouse=True)
def level(request, monkeypatch):
    """Every build of lanes that this processor runs."""
    if library._level() < library.LANES[request.param]:
        pytest.skip("this processor cannot run it")
    monkeypatch.setattr(library, "LANES", {request.param: library.LANES[request.param]})
    if folder := os.environ.get("SANITIZED_LANES"):  # `make sanitize`
        place = Path(folder) / f"jousto_lanes_{request.param}.so"
        known = library._path
        monkeypatch.setattr(
            library, "_path", lambda name: place if "lanes" in name else known(name)
        )
        library._open.cache_clear()
        monkeypatch.setattr(ensemble, "_aligned", exactly)
    library.lanes.cache_clear()
    yield request.param
    library.lanes.cache_clear()


def exactly(count, machines):
    """Return zeros (count, machines) without a byte to spare, so that a sanitizer sees the end."""
    allocate = ctypes.CDLL(None).aligned_alloc
    allocate.restype, allocate.argtypes = ctypes.c_void_p, [ctypes.c_size_t, ctypes.c_size_t]
    room = max(count, 1) * machines
    memory = (ctypes.c_double * room).from_address(allocate(8 * machines, 8 * room))
    found = np.frombuffer(memory)[: count * machines].reshape(count, machines)
    found[:] = 0.0
    return found


def varied(model, k):
    """The same machine with other masses, stiffnesses, loads, signals and gravity."""
    f, g = 1.0 + 0.03 * k, 1.0 - 0.02 * k
    bodies = tuple(
        replace(b, mass=b.mass * f, S0=b.S0 * f, J0=b.J0 * f, K=b.K * g, D=b.D * f)
        for b in model.bodies
    )
    forces = tuple(replace(force, data=force.data * f) for force in model.forces)
    signals = tuple(replace(signal, data=signal.data * g) for signal in model.signals)
    return replace(model, bodies=bodies, forces=forces, signals=signals, gravity=model.gravity * g)


def varied_tree(model, k):
    """The same, in joint coordinates."""
    return varied(model, k).keeping_tree(model)


def started(models, start):
    """Engines of the models, each where `start` puts it."""
    engines = [Engine(model) for model in models]
    for k, engine in enumerate(engines):
        start(engine, k)
    return engines


def disturb(engine, k):
    """Somewhere on the constraints, everything moving; elastic bodies fall from where they are."""
    model, rng = engine.model, np.random.default_rng(3 + k)
    if any(body.n for body in model.bodies):
        return
    move = 0.05 * rng.normal(size=model.nv)
    engine.q[:] = test_joints.displaced(model, model.q0, move)
    engine.v[:] = 10.0 * move
    engine.assemble()


def alone(engine, solver):
    """Rows of one run after the other, the first at the start."""
    rows = np.zeros((1 + STEPS // EVERY, engine.row_size))
    rows[0] = engine.row()
    native = engine.native_solver(
        solver.method, STEP, solver.projection, *_baumgarte(solver), **solver.options
    )
    status, _ = engine.run(native, STEPS, EVERY, rows[1:])
    return rows if status == "ok" else rows * np.nan


def _baumgarte(solver):
    return (0.0, 0.0) if solver.baumgarte is None else (50.0, 50.0)


def together(models, start, solver):
    """The same rows from lanes."""
    engines = started(models, start)
    native = engines[0].native_solver(
        solver.method, STEP, solver.projection, *_baumgarte(solver), **solver.options
    )
    joint = Ensemble(engines)
    first = joint.row()
    return np.concatenate([first[:, None], joint.run(native, STEPS, EVERY)], axis=1)


def assert_equal_rows(model, found, wanted):
    """Round-off, which 60 steps let grow a little; velocities of modes are 1e4 1/s times more."""
    state = 1 + model.nq + model.nv
    size = np.abs(wanted[:, :state]).max()
    np.testing.assert_allclose(found[:, :state], wanted[:, :state], rtol=0, atol=1e-11 * size)
    # reactions, energies, sensors: accelerations differ by more, as the stiffest mode does
    counted = 1 + model.nq + model.nv + model.nrow + EVALUATIONS  # closing the joints counts, too
    rest = np.abs(wanted[:, state:]).max(axis=0)
    # a rounded position is an elastic coordinate that is wrong by as much, and a force by K of it
    slack = np.full(len(rest), 1e-11 * max(1.0, size))
    stiffest = max((b.K.max() for b in model.bodies if b.n), default=0.0)
    slack[: model.nrow] += np.finfo(float).eps * stiffest * size
    error = np.abs(found[:, state:] - wanted[:, state:]).max(axis=0)
    error[counted - state] = 0.0
    assert (error <= 1e-9 * rest + slack).all()


def assert_lanes(model, solver, start=disturb, vary=varied):
    models = [vary(model, k) for k in range(ensemble.machines())]
    found = together(models, start, solver)
    wanted = [alone(engine, solver) for engine in started(models, start)]
    assert np.isfinite(wanted).all()
    for own, rows in zip(found, wanted, strict=True):
        assert_equal_rows(model, own, rows)
    assert np.ptp([rows[-1] for rows in wanted], axis=0).max() > 1e-3  # they do differ


@pytest.mark.parametrize("flexible", [False, True], ids=["rigid", "flexible"])
@pytest.mark.parametrize("name", test_joints.NAMES)
def test_every_joint(name, flexible):
    solver = SOLVERS["ros2" if flexible else "rk4"]
    assert_lanes(test_joints.build(name, flexible), solver)


@pytest.mark.parametrize("solver", SOLVERS)
def test_every_method(solver):
    flexible = not isinstance(SOLVERS[solver], RungeKutta)  # whose step would have to be shorter
    assert_lanes(test_joints.build("Universal", flexible), SOLVERS[solver])


TIMES = np.array([0.0, 0.013, 0.02, 0.041])
TABLE = SignalModel("table", np.concatenate([TIMES, [1.0, -2.0, 3.0, 0.5]]), count=4)
PIECES = SignalModel("pieces", np.concatenate([TIMES, np.arange(9.0)]), count=4, degree=2)
FORCES = {
    "distance": test_forces.spring(0, 4.0),
    "along": test_forces.spring(1, 4.0),
    "angle": test_forces.spring(2, 0.3),
    "limited": ForceModel("s", "along", np.array([300.0, 20.0, 0.7, 5.0, 20.0]), coordinate=2),
    "gear spring": test_forces.gear(),
    "bushing": test_forces.bushing(1.0),
    "modal load": ForceModel("push", "modal load", np.arange(6.0) - 2.0, body=1),
    "load": ForceModel("push", "load", np.arange(6.0) - 2.0, b=1, follow=True, signal=0),
    "pieces": ForceModel("push", "load", np.arange(6.0) - 2.0, b=1, signal=1),
    "step": ForceModel("push", "load", np.arange(6.0) - 2.0, b=1, signal=2),
    "product": ForceModel("push", "load", np.arange(6.0) - 2.0, b=1, signal=4),
    # the table as a spring: lanes are in different intervals of the distance
    "spring": ForceModel("s", "along", np.zeros(5), coordinate=0, spring=5),
}
SIGNALS = (
    TABLE,
    PIECES,
    SignalModel("step", np.array([0.02, 1.0, 4.0])),
    SignalModel("harmonic", np.array([0.1, 1.0, 40.0, 0.3])),
    SignalModel("product", np.zeros(0), children=(0, 3)),
    SignalModel("table", np.array([0.5, 0.55, 0.6, 0.65, 30.0, -10.0, 25.0, 5.0]), count=4),
)


@pytest.mark.parametrize("turn", [0.003, 0.2, 1.0])
@pytest.mark.parametrize("name", FORCES)
def test_every_force(name, turn):
    model = replace(test_forces.two_bodies(FORCES[name]), signals=SIGNALS)

    def start(engine, k):
        """Turned by more in every lane, through where formulas change."""
        angle = turn * (0.5 + 0.25 * k)
        engine.q[10:14] = [1.0, 0.4 * angle, -0.6 * angle, 0.9 * angle]
        engine.q[10:14] /= np.linalg.norm(engine.q[10:14])
        engine.v[:] = np.random.default_rng(k).normal(size=model.nv)

    assert_lanes(model, SOLVERS["rk4"], start)


@pytest.mark.parametrize("stiffening", [False, True], ids=["linear", "stiffening"])
def test_sensors_and_stiffening(stiffening):
    reduced = test_sensors.stiff_rod() if stiffening else test_sensors.rod()
    assert_lanes(jo.compile(test_sensors.moving(reduced)), SOLVERS["ros2"])


def test_angles_are_counted_in_every_lane():
    """A wheel turns once or several times, each lane at its own speed."""
    wheel = jo.RigidBody("wheel", 1.0, (0.1, 0.1, 0.2))
    hinge = jo.Revolute("hinge", jo.ground["origin"], wheel["origin"])
    angle = jo.CoordinateSensor("angle", hinge.angle)
    spring = jo.Spring("spring", hinge.angle, stiffness=0.2, damping=0.01)
    model = jo.compile(jo.Mechanism(wheel, hinge, spring, angle), core="maximal")

    def start(engine, k):
        engine.v[5] = 60.0 * (k + 1)

    assert_lanes(model, SOLVERS["rk4"], start)
    rows = together([model] * ensemble.machines(), start, SOLVERS["rk4"])
    turned = rows[:, -1, 1 + model.nq + model.nv + model.nrow + DIAGNOSTICS]
    assert turned[-1] > 4.0 * np.pi


@pytest.mark.parametrize("bad", [np.nan, 1e12, 1e200])
def test_a_lane_that_fails_spoils_no_other(bad):
    model = test_joints.build("Revolute", False)

    def start(engine, k):
        disturb(engine, k)
        if k == 1:
            engine.v[8] = bad

    models = [varied(model, k) for k in range(ensemble.machines())]
    found = together(models, start, SOLVERS["rk4"])
    assert not np.isfinite(found[1, -1, : 1 + model.nq + model.nv]).all()
    for k, engine in enumerate(started(models, start)):
        if k != 1:
            assert_equal_rows(model, found[k], alone(engine, SOLVERS["rk4"]))


def test_a_lane_without_inertia_spoils_no_other():
    """The matrix of its second link cannot be factored."""
    model = test_joints.build("Revolute", False)
    body = replace(model.bodies[1], J0=0.0 * model.bodies[1].J0)  # no inertia about its hinge
    light = replace(model, bodies=(model.bodies[0], body))
    models = [light if k == 1 else varied(model, k) for k in range(ensemble.machines())]
    found = together(models, disturb_but(1), SOLVERS["rk4"])
    assert not np.isfinite(found[1, -1]).all()
    for k, engine in enumerate(started(models, disturb_but(1))):
        if k != 1:
            assert_equal_rows(model, found[k], alone(engine, SOLVERS["rk4"]))


def disturb_but(lane):
    return lambda engine, k: None if k == lane else disturb(engine, k)


CRANK = (
    0.25  # m, and the rod is as long: straight back its end is in the pivot and may go either way
)


def slider_crank():
    bodies = [jo.RigidBody(name, 1.0, (0.01, 0.02, 0.02), markers={
        "a": (-CRANK / 2, 0, 0), "b": (CRANK / 2, 0, 0)}, position=((k + 0.5) * CRANK, 0, 0))
        for k, name in enumerate(("crank", "rod"))]  # fmt: skip
    crank, rod = bodies
    items = (
        jo.Revolute("pivot", jo.ground["origin"], crank["a"], (0, 0, 1)),
        jo.Revolute("pin", crank["b"], rod["a"], (0, 0, 1)),
        jo.PointOnPlane("guide", jo.ground["origin"], rod["b"], (0, 1, 0)),
    )
    place = jo.PositionSensor("end", rod["b"])
    mechanism = jo.Mechanism(*bodies, *items, place, jo.Gravity((0, -9.81, 0)))
    return jo.compile(mechanism, core="maximal")  # as the lanes run it


def turned(engine, angle):
    """Put crank and rod at an angle and its opposite, at rest."""
    half, at = CRANK / 2, np.array([np.cos(angle), np.sin(angle)])
    for k, (place, turn) in enumerate(((half * at, angle), (half * at * [3, 1], -angle))):
        engine.q[7 * k : 7 * k + 3] = [*place, 0.0]
        engine.q[7 * k + 3 : 7 * k + 7] = [np.cos(turn / 2), 0.0, 0.0, np.sin(turn / 2)]
    engine.v[:] = 0.0


def test_a_singular_joint_in_one_lane_spoils_no_other():
    """Its run alone passes with the multipliers of least norm, which lanes do not have."""
    model, solver = slider_crank(), jo.RK4(step=STEP)

    def start(engine, k):
        turned(engine, 0.5 * np.pi if k == 1 else 0.3 + 0.1 * k)

    single = started([model] * ensemble.machines(), start)
    wanted = [alone(engine, solver) for engine in single]
    assert single[1].counts.singular > 0 and np.isfinite(wanted[1]).all()
    found = together([varied(model, 0)] * ensemble.machines(), start, solver)
    assert not np.isfinite(found[1, -1]).all()
    for k, rows in enumerate(wanted):
        if k != 1:
            assert single[k].counts.singular == 0
            assert_equal_rows(model, found[k], rows)
    # a study has all of them: this one from a run of its own
    engines = started([model] * ensemble.machines(), start)
    states = [jo.simulation.State(e.q, e.v, np.zeros(model.nrow), 0.0) for e in engines]
    runs = [Repeated(model, STEPS * STEP, solver=solver, state=state) for state in states]
    solutions = side_by_side([(run, {}) for run in runs])
    assert [k for k, one in enumerate(solutions) if one is None] == [1]


# -- trees in joint coordinates -------------------------------------------------------------------


def swung(engine, k):
    """Somewhere in each lane, all joints turned and moving; hinges of one lane by many turns."""
    rng, model = np.random.default_rng(5 + k), engine.model
    engine.q[:] = displaced(model, engine.q, 0.4 * rng.normal(size=model.nv))
    engine.v[:] = rng.normal(size=model.nv)
    engine.time[:] = 0.0
    engine.assemble()


def rigid_tree(seed, drives=False):
    """A random tree without its servo, whose force has a memory."""
    items = test_tree.tree(seed, drives=drives).items
    return jo.Mechanism(*(one for one in items if not isinstance(one, jo.Servo)))


def assert_tree_lanes(model, solver, start=swung):
    assert model.links and structure(model)
    assert_lanes(model, solver, start, varied_tree)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("seed", [1, 2, 3, 6])
def test_every_joint_of_a_tree(seed, solver):
    """Hinges, slides, balls, universal, cylindrical and fixed joints, reversed ones, free roots."""
    assert_tree_lanes(jo.compile(rigid_tree(seed), core="joint"), SOLVERS[solver])


@pytest.mark.parametrize("solver", ["rk4", "ros2"])
def test_driven_joints_of_a_tree(solver):
    assert_tree_lanes(jo.compile(rigid_tree(4, drives=True), core="joint"), SOLVERS[solver])


@pytest.mark.parametrize("solver", ["rk4", "ros2"])
@pytest.mark.parametrize("limit", [0.0, 0.2, 1e3])
def test_springs_of_a_tree_with_limits_that_some_lanes_reach(limit, solver):
    model = jo.compile(rigid_tree(2), core="joint")
    forces = tuple(
        replace(f, data=np.array([*f.data[:4], limit])) if f.kind == "along" else f
        for f in model.forces
    )
    assert any(f.kind == "along" for f in forces)
    assert_tree_lanes(replace(model, forces=forces).keeping_tree(model), SOLVERS[solver])


@pytest.mark.parametrize("solver", ["rk4", "ros2"])
def test_elastic_joints_of_a_tree(solver):
    arm = jo.RigidBody("arm", 2.0, (0.1, 0.2, 0.2), center=(0.3, 0, 0))
    hand = jo.RigidBody("hand", 1.0, (0.1, 0.1, 0.1), position=(0.6, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], arm["origin"], (0, 1, 0))
    wrist = jo.Revolute("wrist", arm.at((0.6, 0, 0)), hand["origin"], (0, 1, 0))
    gears = [
        jo.mechanism.ElasticJoint(f"gear{i}", joint.angle, 50.0, 1e-4, 300.0, damping=0.1)
        for i, joint in enumerate((hinge, wrist))
    ]
    bodies = (arm, hand, hinge, wrist, *gears)
    model = jo.compile(jo.Mechanism(*bodies, jo.Gravity((0, 0, -9.81))), core="joint")
    assert_tree_lanes(model, SOLVERS[solver], lambda engine, k: engine.assemble())


def test_angles_of_a_tree_are_counted_in_every_lane():
    wheel = jo.RigidBody("wheel", 1.0, (0.1, 0.1, 0.2))
    hinge = jo.Revolute("hinge", jo.ground["origin"], wheel["origin"])
    angle = jo.CoordinateSensor("angle", hinge.angle)
    model = jo.compile(jo.Mechanism(wheel, hinge, angle), core="joint")

    def start(engine, k):
        engine.v[5] = 60.0 * (k + 1)

    assert_tree_lanes(model, SOLVERS["rk4"], start)
    rows = together([model] * ensemble.machines(), start, SOLVERS["rk4"])
    assert rows[-1, -1, 1 + model.nq + model.nv + model.nrow + DIAGNOSTICS] > 4.0 * np.pi


@pytest.mark.parametrize("bad", [np.nan, 1e18, 1e200])
def test_a_tree_that_fails_spoils_no_other(bad):
    model = jo.compile(rigid_tree(2), core="joint")

    def start(engine, k):
        swung(engine, k)
        if k == 1:
            engine.v[8] = bad

    models = [varied_tree(model, k) for k in range(ensemble.machines())]
    found = together(models, start, SOLVERS["rk4"])
    assert not np.isfinite(found[1, -1, : 1 + model.nq + model.nv]).all()
    for k, engine in enumerate(started(models, start)):
        if k != 1:
            assert_equal_rows(model, found[k], alone(engine, SOLVERS["rk4"]))


@pytest.mark.parametrize("joint", [jo.Revolute, jo.Spherical])
def test_a_tree_without_inertia_spoils_no_other(joint):
    """D of the last link is 0 in one lane."""
    place = (-0.5, 0.0, 0.0)
    arm, end = (jo.RigidBody(x, 1.0, (0.1, 0.2, 0.3), position=place) for x in ("arm", "end"))
    items = (
        jo.Revolute("hinge", jo.ground["origin"], arm.at((0.5, 0, 0)), (0, 1, 0)),
        joint("last", arm["origin"], end["origin"]),
    )
    model = jo.compile(jo.Mechanism(arm, end, *items, jo.Gravity((0, 0, -9.81))), core="joint")
    hollow = replace(model.bodies[1], J0=0.0 * model.bodies[1].J0)
    light = replace(model, bodies=(model.bodies[0], hollow)).keeping_tree(model)
    models = [light if k == 1 else varied_tree(model, k) for k in range(ensemble.machines())]
    found = together(models, disturb_but(1), SOLVERS["rk4"])
    assert not np.isfinite(found[1, -1]).all()
    for k, engine in enumerate(started(models, disturb_but(1))):
        if k != 1:
            assert_equal_rows(model, found[k], alone(engine, SOLVERS["rk4"]))


def on_a_boom():
    """A chain of rigid links on a flexible boom."""
    part = jo.Part.beam(1.0, test_sensors.SECTION, 4, test_sensors.SOFT)
    boom = jo.FlexibleBody("boom", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2)))
    items = [boom, jo.Revolute("pivot", jo.ground["origin"], boom["start"], (0, 1, 0))]
    before = boom["end"]
    for i in range(3):
        link = jo.RigidBody(f"link{i}", 0.1, (1e-3, 1e-3, 1e-3), position=(1.0 + 0.1 * i, 0, 0))
        items += [link, jo.Revolute(f"hinge{i}", before, link["origin"], (0, 1, 0))]
        before = link.at((0.1, 0, 0))
    return jo.Mechanism(*items, jo.Gravity((0, 0, -9.81)))


# -- stress ---------------------------------------------------------------------------------------


def test_stress_gauges_and_bridges():
    part = jo.Part.beam(1.0, test_sensors.SECTION, 4, test_sensors.SOFT)
    reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2))
    body = jo.FlexibleBody("rod", reduced, damping=0.01)
    site, other = list(reduced.stress.labels)[:2]
    top, low = jo.gauges.Gauge("top", body, site), jo.gauges.Gauge("low", body, other)
    sensors = [
        *(kind(kind.__name__, body, [site]) for kind in (
            jo.StressSensor, jo.VonMisesSensor, jo.mechanism.PrincipalStressSensor)),
        top, low, jo.gauges.Rosette("rosette", body, site),
        jo.gauges.Bridge("quarter", top), jo.gauges.Bridge("half", (top, low)),
    ]  # fmt: skip
    pivot = jo.Revolute("pivot", jo.ground["origin"], body["start"], (0, 1, 0))
    model = jo.compile(jo.Mechanism(body, pivot, jo.Gravity((0, 0, -9.81)), *sensors))

    def start(engine, k):
        engine.q[7:] = 1e-3 * np.random.default_rng(k).normal(size=model.nq - 7)
        engine.assemble()

    assert_lanes(model, SOLVERS["ros2"], start)


def test_a_run_in_pieces_is_the_run():
    models = [varied(test_joints.build("Revolute", False), k) for k in range(ensemble.machines())]
    solver = SOLVERS["ros2"]
    engines = started(models, disturb)
    native = engines[0].native_solver("ros2", STEP, True)
    joint = Ensemble(engines)
    first = joint.row()[:, None]
    rows = [first, joint.run(native, 25, EVERY), joint.run(native, 35, EVERY)]
    np.testing.assert_array_equal(np.concatenate(rows, axis=1), together(models, disturb, solver))


# -- what may step together -----------------------------------------------------------------------


def test_numbers_do_not_count():
    model = test_joints.build("Universal", True)
    assert structure(model)
    assert structure(model) == structure(varied(model, 2))
    assert structure(model) == structure(test_joints.build("Universal", True))


@pytest.mark.parametrize(
    "other",
    [
        lambda m: replace(m, redundant=not m.redundant),
        lambda m: replace(m, bodies=(replace(m.bodies[0], alpha=0.5), m.bodies[1])),
        lambda m: replace(m, forces=(test_forces.spring(0),)),
        lambda m: replace(m, signals=(*m.signals, TABLE)),
    ],
)
def test_everything_else_does(other):
    model = test_forces.two_bodies(test_forces.spring(1))
    assert structure(model) != structure(other(model)) != ""
    engines = [Engine(model) for _ in range(ensemble.machines())]
    engines[-1] = Engine(other(model))
    with pytest.raises(ValueError, match="one structure"):
        Ensemble(engines)


def test_at_the_same_time_and_as_many_as_there_are_lanes():
    model = test_joints.build("Spherical", False)
    engines = [Engine(model) for _ in range(ensemble.machines())]
    with pytest.raises(ValueError, match="machines"):
        Ensemble(engines[1:])
    engines[0].time[:] = 1.0
    with pytest.raises(ValueError, match="same time"):
        Ensemble(engines)


def test_what_decides_by_its_state_steps_alone():
    model = test_forces.two_bodies(test_forces.spring(1))
    user = ForceModel("f", "user", np.zeros(1), a=0, b=1, function=lambda t, x: np.zeros(6))
    assert structure(replace(model, forces=(user,))) == ""
    box = jo.RigidBody("box", 1.0, (1.0, 1.0, 1.0))
    slide = jo.Prismatic("slide", jo.ground["origin"], box["origin"], (1, 0, 0))
    friction = jo.Friction("rub", slide, 0.3)
    assert structure(jo.compile(jo.Mechanism(box, slide, friction))) == ""
    plain = jo.Mechanism(box, slide, jo.Gravity((1, 0, 0)))
    cores = [structure(jo.compile(plain, core=core)) for core in ("maximal", "joint")]
    assert cores[0] != cores[1] != "" != cores[0]
    loop = with_core(slider_crank(), "joint")
    assert loop.links and structure(loop) == ""
    carried = jo.compile(on_a_boom(), core="joint")
    assert carried.mixed and structure(carried) == ""
    for releases in ((), (slide,)):
        limit = jo.mechanism.Event("limit", slide.displacement, 1e-4, "rising", releases=releases)
        stopped = jo.Mechanism(*plain.items, limit)
        assert structure(jo.compile(stopped, core="maximal")) == ""
