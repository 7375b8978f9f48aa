"""Events: crossings are found at the time of the closed form, in order, and each counts once."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipk

import jousto as jo
from jousto.model.native.header import places

G = 9.81
RK4, ROS2 = "rk4", "ros2"


def ball(*items, height=2.0, speed=0.0):
    """A body in free fall; no joint, so that the warnings are expected."""
    body = jo.RigidBody("ball", 1.0, (1e-3,) * 3, position=(0, 0, height), velocity=(0, 0, speed))
    place = jo.PositionSensor("place", body["origin"])
    made = [make(body, place) for make in items]
    with pytest.warns(jo.JoustoWarning, match="moves freely"):
        return jo.compile(jo.Mechanism(body, jo.Gravity((0, 0, -G)), place, *made))


def height_event(name, height, direction="both", stop=False):
    return lambda body, place: jo.mechanism.Event(
        name, place, height, direction, stop, component="z"
    )


def run(model, t_end, *, method=RK4, step=0.01):
    engine = jo.model.Engine(model)
    rows = np.zeros((round(t_end / step) + 1, engine.row_size))
    solver = engine.native_solver(method, step, True)
    status, written = engine.run(solver, round(t_end / step), 1, rows)
    return engine, rows[:written], engine.happenings(), status


@pytest.mark.parametrize("method", [RK4, ROS2])
@pytest.mark.parametrize("step", [0.3, 0.01])
def test_a_falling_body_crosses_a_height_when_it_must(method, step):
    model = ball(height_event("floor", 0.5, "falling"))
    engine, rows, happened, _ = run(model, 0.6, method=method, step=step)
    assert happened[:, 1:].tolist() == [[0, -1]]
    assert happened[0, 0] == pytest.approx(np.sqrt(2 * 1.5 / G), abs=1e-11)
    np.testing.assert_allclose(rows[:, 0], step * np.arange(1, len(rows) + 1), atol=1e-15)
    assert engine.happened.tolist() == [1]
    # a few trials find it: 4 or 2 evaluations each, another at the event
    regular = (4 if method == RK4 else 2) * round(0.6 / step) + (len(rows) if method == ROS2 else 0)
    assert engine.counts.evaluations - regular <= 60


def test_up_and_down_within_one_step_is_no_crossing_but_two_steps_find_both():
    model = ball(height_event("top", 0.4), height=0.0, speed=3.0)  # highest 0.4587 m at 0.306 s
    _, _, happened, _ = run(model, 0.6, step=0.3)
    t = (3.0 + np.array([-1, 1]) * np.sqrt(9.0 - 2 * G * 0.4)) / G
    np.testing.assert_allclose(happened[:, 0], t, atol=1e-11)
    np.testing.assert_array_equal(happened[:, 2], [1, -1])


def test_a_direction_leaves_the_other_crossings_out():
    for direction, sign in (("rising", 1), ("falling", -1)):
        model = ball(height_event("top", 0.4, direction), height=0.0, speed=3.0)
        _, _, happened, _ = run(model, 0.6)
        assert happened[:, 2].tolist() == [sign]


def test_several_events_of_one_step_come_in_their_order():
    heights = (0.3, 1.9, 1.0, 1.0)
    model = ball(*(height_event(f"e{i}", z) for i, z in enumerate(heights)))
    _, rows, happened, _ = run(model, 0.6, step=0.6)
    assert len(rows) == 1
    assert happened[:, 1].tolist() == [1, 2, 3, 0]
    t = np.sqrt(2 * (2.0 - np.array([1.9, 1.0, 1.0, 0.3])) / G)
    np.testing.assert_allclose(happened[:, 0], t, atol=1e-11)
    np.testing.assert_allclose(rows[0, 3], 2.0 - G / 2 * 0.6**2, rtol=1e-13)


@pytest.mark.parametrize("speed", [0.0, 3.0, -3.0])
@pytest.mark.parametrize("height", [2.0, 2.0 - 4e-16, 2.0 + 4e-16])
def test_who_starts_at_the_threshold_does_not_cross_it(speed, height):
    model = ball(height_event("here", 2.0), height=height, speed=speed)
    _, _, happened, _ = run(model, 1.0)
    back = [2 * speed / G] if speed > 0 else []
    np.testing.assert_allclose(happened[:, 0], back, atol=1e-11)


def test_reaching_the_threshold_at_the_end_of_a_step_counts_once():
    t = 0.5
    model = ball(height_event("floor", 2.0 - G / 2 * t**2))
    _, _, happened, _ = run(model, 1.0, step=0.125)
    assert len(happened) == 1
    assert happened[0, 0] == pytest.approx(t, abs=1e-11)


def pendulum(*events, start=1.0):
    """A pendulum of 1 m in the plane; its angle is 0 at the start."""
    rod = jo.RigidBody(
        "rod",
        1.0,
        (1e-6,) * 3,
        center=(0, -1, 0),
        orientation=jo.Rotate((0, 0, 1), degrees=np.degrees(start)),
    )
    hinge = jo.Revolute("hinge", jo.ground["origin"], rod["origin"], (0, 0, 1))
    made = [make(hinge) for make in events]
    return jo.compile(jo.Mechanism(rod, hinge, jo.Gravity((0, -G, 0)), *made))


@pytest.mark.parametrize(
    ("solver", "order"),
    [(jo.RK4, 4), (jo.ROS2, 2), (jo.GeneralizedAlpha, 2), (jo.simulation.Newmark, 2)],
)
def test_a_pendulum_passes_its_lowest_point_at_quarter_periods(solver, order):
    # the angle of the joint is 0 at the start, 1 rad from the lowest point
    model = pendulum(lambda hinge: jo.mechanism.Event("lowest", hinge.angle, -1.0))
    period = 4 * np.sqrt((1.0 + 1e-6) / G) * ellipk(np.sin(0.5) ** 2)
    errors = []
    for step in (0.02, 0.01):
        found = np.array([e.time for e in jo.simulate(model, 5.0, solver=solver(step)).events])
        times = (0.25 + 0.5 * np.arange(len(found))) * period
        assert len(found) == 5
        errors.append(np.abs(found - times).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2)


def test_an_event_that_never_happens_changes_nothing():
    for method in (RK4, ROS2):
        plain = run(pendulum(), 1.0, method=method)[1]
        model = pendulum(lambda hinge: jo.mechanism.Event("never", hinge.angle, 9.0))
        watched = run(model, 1.0, method=method)[1]
        n = model.nq + model.nv + model.nrow + 1
        np.testing.assert_array_equal(watched[:, :n], plain[:, :n])


def test_a_watched_reaction_stops_the_run_where_it_reaches_its_limit():
    rod = jo.RigidBody(
        "rod", 1.0, (0.1,) * 3, center=(0, -1, 0), orientation=jo.Rotate((0, 0, 1), degrees=90.0)
    )
    hinge = jo.Revolute("hinge", jo.ground["origin"], rod["origin"], (0, 0, 1))
    reaction = jo.ReactionSensor("reaction", hinge)
    angle = jo.CoordinateSensor("angle", hinge.angle)
    first = jo.mechanism.Event("first", reaction, 1.5 * G, "rising", component="Fy")
    stop = jo.mechanism.Event("stop", reaction, 1.5 * G, "rising", True, component="Fy")
    model = jo.compile(
        jo.Mechanism(rod, hinge, jo.Gravity((0, -G, 0)), reaction, angle, first, stop)
    )
    _, rows, happened, status = run(model, 2.0, step=0.005)
    assert status == "event"
    assert happened[:, 1].tolist() == [0, 1]
    assert rows[-1, 0] == happened[0, 0]
    sensors = rows[-1, 1 + model.nq + model.nv + model.nrow + len(places("jo_diagnostics")) :]
    assert sensors[1] == pytest.approx(1.5 * G, abs=1e-9)
    # m (g + L (cos w^2 + sin w')) with w^2 = 2 m g L cos / J, w' = - m g L sin / J
    square = np.sin(sensors[6]) ** 2  # cos^2 from the vertical: the angle is 0 at the horizontal
    assert 1.0 + (2.0 * square - (1.0 - square)) / 1.1 == pytest.approx(1.5, abs=1e-8)


def test_the_force_is_switched_at_the_event_and_its_energy_counted():
    body = jo.RigidBody("car", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], (1, 0, 0))
    limit = jo.mechanism.Event("limit", rail.displacement, 0.3, "rising")
    motor = jo.JointForce("motor", rail.displacement, jo.mechanism.Switched(limit, 5.0, -1.0))
    model = jo.compile(jo.Mechanism(body, rail, limit, motor))
    # 5 N over 0.3 m, then 1 N against the motion
    t1 = np.sqrt(2 * 0.3 * 2.0 / 5.0)
    v1 = 2.5 * t1
    for method in (RK4, ROS2):
        _, rows, happened, _ = run(model, 5.0, method=method, step=0.05)
        assert happened[0, 0] == pytest.approx(t1, abs=1e-11)
        assert len(happened) == 1
        x = 0.3 + v1 * (rows[:, 0] - t1) - 0.25 * (rows[:, 0] - t1) ** 2
        late = rows[:, 0] > t1
        np.testing.assert_allclose(rows[late, 1], x[late], atol=1e-11)
        first = 1 + model.nq + model.nv + model.nrow
        energy, work = rows[:, first], rows[:, first + 6]
        np.testing.assert_allclose(work, energy, atol=1e-11)


def test_a_chain_of_events_at_one_instant():
    # the first switches a signal that the second watches
    def chain(body, place):
        first = jo.mechanism.Event("first", place, 1.0, component="z")
        level = jo.SignalSensor("level", jo.mechanism.Switched(first, 0.0, 1.0))
        return first, level, jo.mechanism.Event("second", level, 0.5)

    body = jo.RigidBody("ball", 1.0, (1e-3,) * 3, position=(0, 0, 2.0))
    place = jo.PositionSensor("place", body["origin"])
    with pytest.warns(jo.JoustoWarning, match="moves freely"):
        mechanism = jo.Mechanism(body, jo.Gravity((0, 0, -G)), place, *chain(body, place))
    _, _, happened, _ = run(jo.compile(mechanism), 1.0)
    assert happened[:, 1].tolist() == [0, 1]
    assert happened[0, 0] == happened[1, 0] == pytest.approx(np.sqrt(2 / G), abs=1e-11)


def test_events_without_end_are_told():
    def chirp(time, x):
        """Pull back ever harder: x'' = -100 x / (1 - t)^2 passes 0 without end before 1 s."""
        force = np.zeros(6)
        force[0] = -100.0 * x[0] / (1.0 - time) ** 2 if time < 1.0 - 1e-13 else 0.0
        return force

    body = jo.RigidBody("car", 1.0, (1, 1, 1), position=(1e-3, 0, 0), velocity=(1, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], (1, 0, 0))
    push = jo.UserForce("push", body["origin"], chirp)
    model = jo.compile(
        jo.Mechanism(body, rail, push, jo.mechanism.Event("turn", rail.displacement))
    )
    engine, _, happened, status = run(model, 1.0, step=1.0)
    assert status == "endless"
    assert len(happened) < 100
    assert "many times within one step" in str(engine.problem(status))
    assert engine.problem(status).where == "event 'turn'"


def test_calls_in_pieces_change_nothing():
    model = pendulum(lambda hinge: jo.mechanism.Event("lowest", hinge.angle, -1.0))
    whole, *_ = run(model, 2.0)
    pieces = jo.model.Engine(model)
    rows = np.zeros((1, pieces.row_size))
    solver = pieces.native_solver(RK4, 0.01, True)
    for _ in range(200):
        pieces.run(solver, 1, 1, rows)
    np.testing.assert_array_equal(pieces.q, whole.q)
    assert pieces.happened.tolist() == whole.happened.tolist() == [2]


def test_a_full_log_ends_a_call_early_and_loses_nothing():
    wave = jo.Harmonic(frequency=50.0)
    body = jo.RigidBody("ball", 1.0, (1, 1, 1), velocity=(1, 0, 0))
    sensor = jo.SignalSensor("wave", wave)
    with pytest.warns(jo.JoustoWarning, match="moves freely"):
        mechanism = jo.Mechanism(body, sensor, jo.mechanism.Event("zero", sensor))
    engine = jo.model.Engine(jo.compile(mechanism))
    rows = np.zeros((4000, engine.row_size))
    solver = engine.native_solver(RK4, 1e-3, True)
    times = []
    while engine.steps_done < 4000:
        engine.run(solver, 4000 - engine.steps_done, 1, rows)
        times.extend(engine.happenings()[:, 0])
    np.testing.assert_allclose(times, 0.01 * np.arange(1, len(times) + 1), atol=1e-11)
    assert len(times) in (399, 400)


@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_each_trial_of_an_event_starts_from_the_start_of_its_step(core):
    """x = x0 cos(w t) is at x0 / 2 at t = acos(1/2) / w; the force depends on the position."""
    w = 10.0
    block = jo.RigidBody("block", 2.0, (1.0,) * 3, position=(0.3, 0, 0))
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    spring = jo.Spring("spring", slide.displacement, stiffness=2.0 * w**2, free=0.0)
    x = jo.PositionSensor("x", block["origin"])
    half = jo.mechanism.Event("half", x, 0.15, "falling", component="x")
    model = jo.compile(jo.Mechanism(block, slide, spring, x, half), core=core)
    _, _, happened, _ = run(model, 0.2, step=1e-3)
    # the error of RK4: (w h)^4 / 120 w t of the phase
    assert happened[0, 0] == pytest.approx(np.arccos(0.5) / w, abs=2e-11)
