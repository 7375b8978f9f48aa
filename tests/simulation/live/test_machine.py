"""A live machine: inputs, the hand, and the same again to the last bit."""

from __future__ import annotations

import time
from pathlib import Path

import h5py
import numpy as np
import pytest

import jousto as jo
from jousto.model.model import Model
from jousto.simulation.live.drag_spring import (
    Grip,
    mobility,
    point_position,
    shapes_at,
    with_grip,
    with_hand,
)
from jousto.simulation.live.machine import LiveMachine
from jousto.simulation.live.real_time_clock import Pace
from jousto.simulation.live.recorder import Recorder, repeat

STEP = 1e-3


def oscillator(mass: float = 2.0, k: float = 300.0, c: float = 20.0) -> Model:
    """A mass on a slide along x, with a spring and a damper to the ground."""
    cart = jo.RigidBody("cart", mass, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    spring = jo.Spring("spring", rail.displacement, k, c)
    push = jo.JointForce("push", rail.displacement, jo.Input("force"))
    place = jo.CoordinateSensor("place", rail.displacement)
    return jo.compile(jo.Mechanism(cart, rail, spring, push, place))


def cantilever() -> Model:
    """A clamped beam with modes that no joint but the clamp holds."""
    steel = jo.Material(E=210e9, nu=0.3, rho=7850)
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.03), 8, steel)
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=4))
    arm = jo.FlexibleBody("arm", reduced, damping=jo.Rayleigh(0.0, 1e-3))
    clamp = jo.Fixed("clamp", jo.ground["origin"], arm["start"])
    tip = jo.PositionSensor("tip", arm["end"])
    return jo.compile(jo.Mechanism(arm, clamp, tip))


def same(first: Path, second: Path) -> list[str]:
    """Return the names of what differs between two results files."""
    differ = []

    def text(item: h5py.Dataset) -> str:
        return repr(np.asarray(item[()]).tolist())

    with h5py.File(first) as a, h5py.File(second) as b:

        def compare(name: str, item: object) -> None:
            # repr tells all bits of a number
            if isinstance(item, h5py.Dataset) and text(item) != text(b[name]):
                differ.append(name)

        a.visititems(compare)
        assert "state/q" in a
    return differ


def test_the_pull_holds_a_mass_where_springs_in_series_hold_it() -> None:
    k = 300.0
    machine = LiveMachine(oscillator(k=k), jo.ROS2(STEP))
    grip = machine.pull(0, np.zeros(3))
    machine.aim(np.array([0.5, 0.0, 0.0]))
    machine.step(20_000)  # 20 s: all has settled
    exact = 0.5 * grip.stiffness / (grip.stiffness + k)
    # the transient is below exp(-(20 + c) t / 2 m), far below rounding
    assert machine.engine.q[0] == pytest.approx(exact, rel=1e-9)


def test_the_stiffness_comes_from_the_mass_that_moves() -> None:
    mass = 2.0
    machine = LiveMachine(oscillator(mass), jo.ROS2(STEP))
    grip = machine.pull(0, np.zeros(3))
    omega = 2 * np.pi * 1.5
    assert grip.stiffness == pytest.approx(mass * omega**2, rel=1e-9)
    slow = machine.pull(0, np.zeros(3), speed=0.1)  # a tenth of the speed: ten times as fast
    assert slow.stiffness == pytest.approx(100 * grip.stiffness, rel=1e-9)
    fast = LiveMachine(oscillator(mass), jo.ROS2(STEP)).pull(0, np.zeros(3), speed=1e-6)
    assert np.sqrt(fast.stiffness / mass) * STEP == pytest.approx(0.2, rel=1e-9)


def test_the_energy_balance_counts_the_work_of_the_hand(tmp_path: Path) -> None:
    machine = LiveMachine(oscillator(), jo.RK4(STEP), interval=STEP)
    record = Recorder(tmp_path / "run.h5", machine)
    machine.pull(0, np.zeros(3), np.array([0.3, 0.0, 0.0]))
    for k in range(1000):
        machine.aim(np.array([0.3 * np.cos(3e-3 * k), 0.0, 0.0]))
        record.add(machine.step(), machine.events())
    run = record.close()
    assert run.energy.work.max() > 1.0  # J
    # RK4: of the order of (omega step)^4, with jumps of the target between steps only
    assert np.abs(run.energy.error).max() < 1e-6 * np.abs(run.energy.work).max()


def test_a_pull_acts_on_the_modes_through_the_shapes_of_the_point() -> None:
    model = with_hand(cantilever())
    body = model.bodies[0]
    point = np.array([0.75, 0.0, 0.0])  # a node of the eighths
    grip = Grip(0, (0.75, 0.0, 0.0), 1.0, 0.0)
    engine = jo.model.Engine(with_grip(model, grip))
    places = [model.inputs.index(f"hand {axis}") for axis in "xyz"]
    engine.input[places] = point_position(model, engine.q, 0, point) + [
        0.0,
        0.0,
        2.0,
    ]  # 2 N upwards
    node = int(np.argmin(np.linalg.norm(model.shapes[0].nodes - point, axis=1)))
    free = jo.model.Engine(model)
    difference = free.residual() - engine.residual()
    np.testing.assert_allclose(difference[:3], [0, 0, 2.0], atol=1e-12)
    np.testing.assert_allclose(
        difference[6 : 6 + body.n], 2.0 * model.shapes[0].modes[node, 2], rtol=1e-12, atol=1e-12
    )


def test_a_pulled_cantilever_bends_as_the_beam_formula_says() -> None:
    machine = LiveMachine(cantilever(), jo.GeneralizedAlpha(STEP))
    grip = machine.pull(0, np.array([1.0, 0.0, 0.0]))
    machine.aim(np.array([1.0, 0.0, 0.05]))
    machine.step(6000)
    z = float(point_position(machine.model, machine.engine.q, 0, np.array([1.0, 0, 0]))[2])
    k = 3 * 210e9 * 0.02 * 0.03**3 / 12  # 3 E I / l^3, l = 1 m
    k_other = 3 * 210e9 * 0.03 * 0.02**3 / 12
    exact = [0.05 * grip.stiffness / (grip.stiffness + s) for s in (k, k_other)]
    # static modes of the interfaces bend exactly but for shear, below 1 % of this slender beam
    assert min(abs(z / x - 1) for x in exact) < 0.01


def test_shapes_between_nodes_are_linear() -> None:
    shape = cantilever().shapes[0]
    a, b = shapes_at(shape, np.array([0.25, 0, 0])), shapes_at(shape, np.array([0.375, 0, 0]))
    between = shapes_at(shape, np.array([0.25 + 0.4 * 0.125, 0.003, 0]))
    np.testing.assert_allclose(between, 0.6 * a + 0.4 * b, rtol=0, atol=1e-12 * np.abs(b).max())


def test_shapes_on_a_triangle_are_linear() -> None:
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    modes = np.stack([np.eye(3), 2 * np.eye(3), 5 * np.eye(3)])[:, :, :1]
    shape = jo.model.model.Shape("flexible", corners, np.array([[0, 1, 2]]), modes)
    point = np.array([0.2, 0.3, 0.4])  # above it
    assert shapes_at(shape, point)[0, 0] == pytest.approx(0.5 + 0.4 + 1.5)
    beyond = np.array([2.0, 2.0, 0.0])  # next to the middle of the long side
    assert shapes_at(shape, beyond)[0, 0] == pytest.approx(3.5)


def test_mobility_of_a_free_body_is_its_mass_and_inertia() -> None:
    body = jo.RigidBody("body", 4.0, (0.5, 0.6, 0.7), position=(1, 2, 3))
    free = jo.JointForce("idle", jo.Distance(jo.ground["origin"], body["origin"]), 0.0)
    model = jo.compile(jo.Mechanism(body, free))
    machine = LiveMachine(model, jo.RK4(STEP))
    model, state = machine.model, machine.state()
    W = mobility(model, state, 0, np.array([0.3, 0.0, 0.0]))
    exact = np.diag([1 / 4, 1 / 4 + 0.3**2 / 0.7, 1 / 4 + 0.3**2 / 0.6])
    np.testing.assert_allclose(W, exact, atol=1e-9)


def test_rows_are_those_of_simulate_with_the_recorded_inputs(tmp_path: Path) -> None:
    model = oscillator()
    machine = LiveMachine(model, jo.ROS2(STEP))
    record = Recorder(tmp_path / "live.h5", machine)
    for force in (0.0, 3.0, -1.0, 0.5):
        machine.set("force", force)
        machine.step(5)  # takes effect at the next row
        record.add(machine.step(95), machine.events())
    live = record.close()
    with h5py.File(live.path) as file:
        assert file["rows"][()] == live.nt
    fed = jo.simulate(
        model,
        float(live.time[-1]),
        solver=jo.ROS2(STEP),
        output_step=machine.interval,
        inputs={"force": live.inputs["force"][1:]},
    )
    assert np.ptp(live.inputs["force"]) == 4.0
    assert live.q.tobytes() == fed.q.tobytes()
    assert live.v.tobytes() == fed.v.tobytes()
    assert live["place"].tobytes() == fed["place"].tobytes()


@pytest.mark.parametrize("solver", [jo.ROS2(STEP), jo.GeneralizedAlpha(STEP)])
def test_a_record_with_pulls_runs_again_to_the_last_bit(tmp_path: Path, solver: object) -> None:
    model = cantilever()
    machine = LiveMachine(model, solver)
    machine.step(37)  # a record may begin anywhere, between rows too
    record = Recorder(tmp_path / "live.h5", machine)
    for k in range(6):
        if k == 1:
            machine.pull(0, np.array([0.8, 0.01, 0.0]))
        if k in (2, 3):
            machine.aim(np.array([0.8, 0.0, 0.01 * k]))
        if k == 4:
            machine.release()
        if k == 5:
            machine.pull(0, np.array([0.3, 0.0, 0.0]), np.array([0.3, 0.01, 0.0]))
        record.add(machine.step(100), machine.events())
    live = record.close()
    again = repeat(live, model, solver, path=tmp_path / "again.h5")
    assert again.nt == live.nt == 61
    assert np.ptp(live["tip"][:, 2]) > 1e-5
    assert same(tmp_path / "live.h5", tmp_path / "again.h5") == []


def test_a_record_that_is_not_of_a_live_run_is_refused() -> None:
    model = oscillator()
    run = jo.simulate(model, 0.1, solver=jo.ROS2(STEP), inputs={"force": 0.0})
    with pytest.raises(jo.InputError, match="not those of a live run"):
        repeat(run, model, jo.ROS2(STEP))


def test_an_event_stops_and_the_machine_runs_on() -> None:
    cart = jo.RigidBody("cart", 1.0, (1, 1, 1), velocity=(1, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    push = jo.JointForce("push", rail.displacement, jo.Input("force"))
    place = jo.CoordinateSensor("place", rail.displacement)
    gate = jo.mechanism.Event("gate", place, 0.5, stop=True)
    machine = LiveMachine(jo.compile(jo.Mechanism(cart, rail, push, place, gate)), jo.RK4(STEP))
    machine.step(2000)
    assert machine.stopped == "gate"
    assert machine.time == pytest.approx(0.5, abs=1e-9)
    machine.step(100)
    assert machine.stopped == ""
    assert machine.time == pytest.approx(0.6, abs=1e-9)


def test_divergence_is_a_sentence_and_reset_helps() -> None:
    machine = LiveMachine(oscillator(mass=1e-6, k=1e9, c=0.0), jo.RK4(STEP))
    machine.set("force", 1.0)
    with pytest.raises(jo.SimulationError, match="likely cause"):
        machine.step(10_000)
    machine.reset()
    assert machine.time == 0.0
    assert np.isfinite(machine.row).all()
    machine.step(1)


def test_an_unknown_input_names_the_nearest() -> None:
    machine = LiveMachine(oscillator(), jo.ROS2(STEP))
    with pytest.raises(jo.InputError, match="no input 'forse'.*force"):
        machine.set("forse", 1.0)
    with pytest.raises(jo.InputError, match="finite"):
        machine.set("force", np.nan)
    with pytest.raises(jo.InputError, match="body 3 does not exist"):
        machine.pull(3, np.zeros(3))


def test_adaptive_methods_are_refused() -> None:
    with pytest.raises(jo.InputError, match="fixed step"):
        LiveMachine(oscillator(), jo.simulation.DormandPrince())


def test_sensors_keep_their_frames_beside_the_hand() -> None:
    """The hand's frames come before those of sensors, whose places move on."""
    body = jo.RigidBody(
        "body", 1.0, (1, 2, 3), angular_velocity=(0.1, 0.2, 0.3), position=(1, 0, 0)
    )
    other = jo.RigidBody("other", 1.0, (1, 2, 3), velocity=(0.5, 0, 0))
    tie = jo.JointForce("idle", jo.Distance(body["origin"], other["origin"]), 0.0)
    sensors = (
        jo.PositionSensor(
            "r", body.at((0, 1, 0)), relative_to=other["origin"], resolved_in=other["origin"]
        ),
        jo.OrientationSensor("e", body["origin"]),
        jo.VelocitySensor("v", body.at((0, 0, 2)), resolved_in=body["origin"]),
    )
    model = jo.compile(jo.Mechanism(body, other, tie, *sensors))
    plain, handed = jo.model.Engine(model), jo.model.Engine(with_hand(model))
    for engine in (plain, handed):
        engine.row()
    assert np.abs(plain.sensors()).max() > 0.5
    np.testing.assert_array_equal(plain.sensors(), handed.sensors())


def test_steps_that_the_engine_times_are_the_same_and_counted_once() -> None:
    plain, paced = (LiveMachine(oscillator(), jo.ROS2(STEP)) for _ in range(2))
    pace = Pace(STEP, speed=2.0)
    assert pace.native
    for k in range(12):
        for machine, how in ((plain, None), (paced, pace)):
            machine.set("force", 3.0 * k)
            rows = machine.step(7, how)  # across the rows at every tenth step
            if how is None:
                wanted = rows
        assert rows.tobytes() == wanted.tobytes()
    assert paced.state().q.tobytes() == plain.state().q.tobytes()
    assert sum(pace.late) == 12 * 7
    assert pace.worst > 0.0
    assert pace.latest >= 0.0


def test_steps_that_the_engine_times_last_as_long_as_the_watch_says() -> None:
    machine, pace = LiveMachine(oscillator(), jo.ROS2(STEP)), Pace(STEP, speed=0.5)
    began = time.monotonic()
    machine.step(20, pace)
    # the last of 20 steps begins 19 steps after the first, each of 2 ms: never before
    assert time.monotonic() - began >= 19 * 2e-3


def test_what_is_too_late_is_given_up_by_the_engine_too() -> None:
    machine, pace = LiveMachine(oscillator(), jo.ROS2(STEP)), Pace(STEP)
    machine.step(1, pace)
    time.sleep(0.3)  # somebody held it up for longer than a quarter of a second
    machine.step(9, pace)
    assert pace.given_up >= 1
    assert sum(pace.late) == 10
    assert pace.latest >= 0.29  # a step that was due a millisecond after the first
