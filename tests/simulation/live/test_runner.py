"""The thread that steps a live machine: its clock, its orders, its records."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np
import pytest

import jousto as jo
from jousto.model.model import Model
from jousto.simulation.live.machine import LiveMachine
from jousto.simulation.live.ranges import input_ranges, parse_ranges
from jousto.simulation.live.real_time_clock import EDGES, SLOWEST, Pace
from jousto.simulation.live.recorder import repeat
from jousto.simulation.live.runner import Runner

STEP = 1e-3
PATIENCE = 60.0  # s, for machines that are busy


class Watch:
    """A clock that moves when somebody sleeps or works."""

    def __init__(self) -> None:
        self.now = 100.0

    def clock(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        assert seconds > 0.0
        self.now += seconds


def paced(speed: float = 1.0) -> tuple[Watch, Pace]:
    watch = Watch()
    return watch, Pace(STEP, speed, clock=watch.clock, sleep=watch.sleep)


def work(watch: Watch, pace: Pace, *seconds: float) -> None:
    for spent in seconds:
        pace.wait()
        watch.now += spent
        pace.done()


def test_steps_begin_at_their_time() -> None:
    watch, pace = paced()
    work(watch, pace, *[2e-4] * 1000)
    # the last of 1000 steps begins after 999 of them; rounding of sums of 1e3 terms near 100
    assert watch.now - 100.0 == pytest.approx(0.999 + 2e-4, abs=1e-9)
    assert pace.late[0] == 1000
    assert sum(pace.late) == 1000
    assert pace.missed == 0
    assert pace.worst == pytest.approx(2e-4, rel=1e-6)


def test_half_speed_takes_twice_the_time() -> None:
    watch, pace = paced(0.5)
    work(watch, pace, *[1e-4] * 3000)
    assert watch.now - 100.0 == pytest.approx(2 * 2.999 + 1e-4, abs=1e-9)
    assert pace.factor == pytest.approx(0.5, rel=0.01)  # a window of a second, cut at steps


def test_late_steps_are_counted_and_caught_up() -> None:
    watch, pace = paced()
    work(watch, pace, 4.5e-3, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4)
    # after 4.5 ms the steps due at 1 .. 4 ms follow at once: 3.5, 2.6, 1.7, 0.8 ms late
    expected = [0] * 8
    for late in (0.0, 3.5e-3, 2.6e-3, 1.7e-3, 0.8e-3, 0.0, 0.0):
        expected[sum(late >= edge for edge in EDGES)] += 1
    assert pace.late == expected
    assert pace.latest == pytest.approx(3.5e-3, abs=1e-9)
    assert pace.missed == 4  # those that ended after the next one was due
    assert pace.given_up == 0
    assert watch.now - 100.0 == pytest.approx(6.1e-3, abs=1e-9)


def test_a_machine_that_is_too_slow_gives_up_what_is_missing() -> None:
    watch, pace = paced()
    work(watch, pace, *[2e-3] * 1000)
    assert pace.given_up == 1000 // 251  # each step leaves it a millisecond further behind
    assert pace.latest < 0.26
    assert pace.factor == pytest.approx(0.5, rel=0.01)


def test_as_fast_as_it_can_never_sleeps() -> None:
    watch, pace = paced(0.0)
    work(watch, pace, *[1e-4] * 1000)
    assert watch.now - 100.0 == pytest.approx(0.1, abs=1e-9)
    assert pace.factor == pytest.approx(10.0, rel=0.1)
    assert sum(pace.late) == 0


def test_a_pause_is_not_late() -> None:
    watch, pace = paced()
    work(watch, pace, 1e-4, 1e-4)
    watch.now += 5.0
    pace.start()
    work(watch, pace, 1e-4, 1e-4)
    assert pace.late[0] == 4


def machine(*, stop: float = 0.0, k: float = 300.0) -> LiveMachine:
    return LiveMachine(model(stop=stop, k=k), jo.ROS2(STEP))


def model(*, stop: float = 0.0, k: float = 300.0) -> Model:
    cart = jo.RigidBody("cart", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    spring = jo.Spring("spring", rail.displacement, k, 20.0)
    push = jo.JointForce("push", rail.displacement, jo.Input("force"))
    place = jo.CoordinateSensor("place", rail.displacement)
    events = [jo.mechanism.Event("gate", place, stop, stop=True)] if stop else []
    return jo.compile(jo.Mechanism(cart, rail, spring, push, place, *events))


@pytest.fixture
def run() -> Iterator[Callable[..., Runner]]:
    made: list[Runner] = []

    def start(what: LiveMachine, **how: object) -> Runner:
        made.append(Runner(what, **how))  # type: ignore[arg-type]
        return made[-1]

    yield start
    for runner in made:
        runner.close()


def until(true: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < end
        time.sleep(0.002)


def test_play_pause_step_and_reset(run: Callable[..., Runner]) -> None:
    runner = run(machine(), speed=0, playing=False)
    assert runner.glance.time == 0.0
    runner.play()
    until(lambda: runner.glance.time > 0.5)
    runner.pause()
    time_then = runner.glance.time
    runner.step()
    assert runner.glance.time == pytest.approx(time_then, abs=0.0101)
    assert runner.glance.time > time_then - 1e-12
    assert not runner.glance.playing
    runner.reset()
    assert runner.glance.time == 0.0


def test_an_event_pauses_with_a_sentence(run: Callable[..., Runner]) -> None:
    runner = run(machine(stop=0.01), speed=0, playing=False)
    runner.do(lambda m: m.set("force", 6.0))
    runner.play()
    until(lambda: not runner.glance.playing)
    assert "stopped by event 'gate'" in runner.glance.message
    then = runner.glance.time
    runner.play()
    until(lambda: runner.glance.time > then + 0.01)
    assert runner.glance.message == ""


def test_divergence_pauses_and_reset_helps(run: Callable[..., Runner], tmp_path: Path) -> None:
    # not ROS2, which has springs along the coordinates of a tree in its matrix
    runner = run(LiveMachine(model(k=1e12), jo.RK4(STEP)), speed=0, playing=False)
    runner.do(lambda m: m.set("force", 1.0))
    runner.record(tmp_path / "run.h5")
    runner.play()
    until(lambda: not runner.glance.playing)
    assert "likely cause" in runner.glance.message
    assert runner.glance.recording == ""
    assert "failed" in jo.load(tmp_path / "run.h5").attributes["ended"]
    runner.reset()
    assert runner.glance.message == ""
    assert runner.glance.time == 0.0


def test_errors_belong_to_whoever_asked(run: Callable[..., Runner]) -> None:
    runner = run(machine(), speed=0)
    with pytest.raises(jo.InputError, match="no input 'forse'"):
        runner.do(lambda m: m.set("forse", 1.0))
    with pytest.raises(jo.InputError, match="speed"):
        runner.speed(-1.0)
    then = runner.glance.time
    until(lambda: runner.glance.time > then)  # it runs on


@pytest.mark.parametrize("speed", [1e-12, 1e-320, 1e300, -1.0, float("nan"), float("inf")])
def test_a_speed_beyond_its_bounds_is_refused(run: Callable[..., Runner], speed: float) -> None:
    """A step of 1 ms at 1e-12 would be due in 31 years; 1e-3 / 1e-320 is no number."""
    runner = run(machine(), speed=0)
    with pytest.raises(jo.InputError, match="speed is .*from 1e-06 to 1e\\+06"):
        runner.speed(speed)
    with pytest.raises(jo.InputError, match="speed is"):
        Runner(machine(), speed=speed)
    then = runner.glance.time
    until(lambda: runner.glance.time > then)


def test_orders_do_not_wait_for_a_step_that_is_due_much_later(run: Callable[..., Runner]) -> None:
    runner = run(machine(), speed=1.0)
    runner.speed(SLOWEST)  # the next step but one is due in 1000 s
    for value in (1.0, 2.0):
        began = time.monotonic()
        runner.do(lambda m, value=value: m.set("force", value))
        assert time.monotonic() - began < PATIENCE
        assert runner.glance.inputs["force"] == value
    runner.speed(0)
    then = runner.glance.time
    until(lambda: runner.glance.time > then)


def test_an_error_that_nobody_foresaw_stops_the_machine_and_not_its_thread(
    run: Callable[..., Runner],
) -> None:
    runner = run(machine(), speed=0, playing=False)

    def fail(*given: object) -> None:
        raise OverflowError("too large")

    runner.do(lambda m: setattr(m, "step", fail))
    runner.play()
    until(lambda: not runner.glance.playing)
    assert "too large" in runner.glance.message
    runner.do(lambda m: delattr(m, "step"))
    runner.play()
    until(lambda: runner.glance.time > 0.0)


def test_a_record_while_it_runs_is_the_same_again(
    run: Callable[..., Runner], tmp_path: Path
) -> None:
    """Orders come whenever they come; the file says when they took effect."""
    live = machine()
    runner = run(live, speed=0)
    until(lambda: runner.glance.time > 0.1)
    runner.record(tmp_path / "live.h5")
    began = runner.glance.time
    for k in range(20):
        runner.do(lambda m, k=k: m.set("force", 0.5 * k))
        if k == 5:
            runner.do(lambda m: m.pull(0, np.array([0.1, 0.0, 0.0])))
        if 5 < k < 12:
            runner.do(lambda m, k=k: m.aim(np.array([0.01 * k, 0.0, 0.0])))
        if k == 12:
            runner.do(lambda m: m.release())
        until(lambda goal=runner.glance.time + 0.02: runner.glance.time > goal)
    runner.record(None)
    recorded = jo.load(tmp_path / "live.h5")
    assert recorded.complete
    assert 0.1 < recorded.time[0] <= began
    assert len(np.unique(recorded.inputs["force"])) == 20
    assert recorded.inputs["hand body"].max() == 0.0
    again = repeat(recorded, model(), jo.ROS2(STEP))
    assert recorded.q.tobytes() == again.q.tobytes()
    assert recorded.v.tobytes() == again.v.tobytes()
    assert recorded["place"].tobytes() == again["place"].tobytes()
    assert recorded.energy.work.tobytes() == again.energy.work.tobytes()


def test_rows_are_in_the_file_while_it_runs(run: Callable[..., Runner], tmp_path: Path) -> None:
    runner = run(machine(), speed=0)
    runner.record(tmp_path / "live.h5")
    path = tmp_path / "live.h5"

    def stored() -> int:
        with h5py.File(path) as file:
            return int(file["rows"][()])

    until(lambda: stored() > 50)
    assert runner.glance.recording == str(path)
    assert jo.load(path).nt > 50  # a program killed now leaves this


def test_a_reset_goes_on_in_another_file(run: Callable[..., Runner], tmp_path: Path) -> None:
    runner = run(machine(), speed=0)
    runner.record(tmp_path / "live.h5")
    until(lambda: runner.glance.time > 0.1)
    runner.reset()
    assert runner.glance.recording == str(tmp_path / "live-2.h5")
    runner.close()
    first, second = jo.load(tmp_path / "live.h5"), jo.load(tmp_path / "live-2.h5")
    assert first.complete
    assert second.time[0] == 0.0


def test_another_machine_takes_over_the_state(run: Callable[..., Runner]) -> None:
    runner = run(machine(), speed=0, playing=False)
    runner.do(lambda m: m.set("force", 6.0))
    for _ in range(5):
        runner.step()
    q = runner.glance.q.copy()

    def heavier(old: LiveMachine) -> LiveMachine:
        new = machine(k=500.0)
        new.carry(old.state(), old.inputs)
        return new

    runner.replace(heavier, "")
    assert runner.glance.time == pytest.approx(0.05)
    np.testing.assert_allclose(runner.glance.q, q, rtol=0, atol=1e-12)
    assert runner.glance.inputs["force"] == 6.0


def test_closing_ends_the_thread(run: Callable[..., Runner]) -> None:
    before = threading.active_count()
    runner = run(machine(), speed=0)
    runner.close()
    runner.close()
    assert threading.active_count() == before
    with pytest.raises(jo.InputError, match="closed"):
        runner.play()


def test_ranges_follow_what_inputs_act_on() -> None:
    cart = jo.RigidBody("cart", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    push = jo.JointForce("push", rail.displacement, jo.Input("force"))
    servo = jo.Servo("servo", rail.displacement, jo.Input("where", 0.25) + 1.0, 10.0)
    wind = jo.Force("wind", cart["origin"], (0, 1, 0), signal=jo.Input("wind"))
    compiled = jo.compile(jo.Mechanism(cart, rail, push, servo, wind, jo.Gravity((0, 0, -10))))
    force, where, gust = input_ranges(compiled, {"wind": (-3.0, 5.0)})
    assert (force.unit, where.unit, gust.unit) == ("N", "m", "1")
    assert (force.low, force.high) == (-40.0, 40.0)  # twice the weight
    assert where.value == 0.25
    assert where.low < 0.25 < where.high
    assert (gust.low, gust.high) == (-3.0, 5.0)
    with pytest.raises(jo.InputError, match="no input 'wnd'.*wind"):
        input_ranges(compiled, {"wnd": (0.0, 1.0)})
    with pytest.raises(jo.InputError, match="must have low < high"):
        input_ranges(compiled, {"wind": (1.0, 1.0)})
    with pytest.raises(jo.InputError, match=r"NAME=LOW\.\.HIGH"):
        parse_ranges(["wind=3"])
