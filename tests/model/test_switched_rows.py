"""Rigid stops and locks: closed forms, momentum, energy, every method, both cores, bad input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import Event, Lock, RigidStop, StickSlip

G = 9.81
METHODS = {
    "RK4": (jo.RK4(5e-4), 1e-9),
    "ROS2": (jo.ROS2(1e-4), 2e-7),
    "alpha": (jo.GeneralizedAlpha(1e-4, rho=0.9, tolerance=1e-10), 2e-7),
    "DormandPrince": (jo.simulation.DormandPrince(tolerance=1e-11), 1e-8),
}
CORES = ("maximal", "joint")
pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely")


def pendulum(angle: float, core: str, e: float) -> Any:
    """A rod like a point on a thread of 1 m, released at an angle, deg; a stop at the bottom."""
    a = np.radians(angle)
    rod = jo.RigidBody(
        "rod",
        1.0,
        (0.25, 0.25, 0.25),
        center=(0, 0, -0.5),
        orientation=(np.cos(a / 2), 0, np.sin(a / 2), 0),
    )
    hinge = jo.Revolute("hinge", jo.ground["origin"], rod["origin"], axis=(0, 1, 0))
    limit = RigidStop("stop", hinge.angle, lower=-a, restitution=e)
    sensors = (jo.CoordinateSensor("angle", hinge.angle), jo.RateSensor("rate", hinge.angle))
    return jo.compile(
        jo.Mechanism(
            *(rod, hinge, limit, jo.Gravity((0, 0, -G)), *sensors),
            jo.ReactionSensor("held", limit),
        ),
        core=core,
    )


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("name", METHODS)
def test_a_pendulum_strikes_a_stop_at_the_times_of_the_elliptic_integrals(
    name: str, core: str
) -> None:
    # quarter periods K(sin 30 deg) sqrt(L / g), and two with half of the speed
    solver, small = METHODS[name]
    model = pendulum(60.0, core, 0.5)
    run = jo.simulate(model, 1.7, solver=solver)
    first, second = run.events
    assert first.time == pytest.approx(0.5382186667, abs=max(small, 1e-10))
    assert second.time == pytest.approx(1.557500505, abs=max(4 * small, 1e-9))
    assert (first.name, first.change) == ("stop", "closes")
    # angular momentum (1 + e) J w with w^2 = g / L at 60 deg, J = 0.5 kg m2
    assert first.impulse == pytest.approx(0.75 * np.sqrt(G), rel=max(10 * small, 1e-9))
    assert run["angle"].min() > -np.pi / 3 - 1e-9
    scale = 0.25 * G
    assert np.abs(run.energy.error).max() < max(1e3 * small, 1e-8) * scale


def struck_elbow(first: float, core: str, solver: Any, *more: Any) -> Any:
    """Run straight rods of 2 kg and 1 m, whose elbow strikes its stop at 3 rad/s; e = 0.

    They are bent by BENT at first. `more` makes items from the coordinate of the shoulder.
    """
    inertia = (1e-3, 2 / 12, 2 / 12)
    upper = jo.RigidBody("upper", 2.0, inertia, center=(0.5, 0, 0))
    lower = jo.RigidBody(
        *("lower", 2.0, inertia),
        center=(0.5, 0, 0),
        position=(1, 0, 0),
        orientation=(np.cos(BENT / 2), 0, 0, -np.sin(BENT / 2)),
    )
    shoulder = jo.Revolute("shoulder", jo.ground["origin"], upper["origin"])
    elbow = jo.Revolute("elbow", upper.at((1, 0, 0)), lower["origin"])
    machine = jo.Mechanism(
        *(upper, lower, shoulder, elbow),
        RigidStop("stop", elbow.angle, upper=BENT, restitution=0.0),
        *(jo.RateSensor("one", shoulder.angle), jo.RateSensor("two", elbow.angle)),
        *(jo.Initial(shoulder.angle, rate=first), jo.Initial(elbow.angle, rate=3.0)),
        *(make(shoulder.angle) for make in more),
    )
    return jo.simulate(jo.compile(machine, core=core), 0.01, solver=solver)


BENT = 1e-4  # rad


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("name", METHODS)
def test_an_elbow_that_strikes_its_stop_turns_both_rods(name: str, core: str) -> None:
    # rates 1 and 3 rad/s: closed form
    run = struck_elbow(1.0, core, METHODS[name][0])
    struck, *_ = run.events  # straight, the stop carries nothing: it may open by rounding
    assert run["one"][-1] == pytest.approx(1.9375, rel=3 * BENT)
    assert run["two"][-1] == pytest.approx(0.0, abs=1e-9)
    assert struck.impulse == pytest.approx(0.4375, rel=3 * BENT)
    lost = run.energy.kinetic[0] - run.energy.kinetic[-1]
    assert lost == pytest.approx(0.65625, rel=3 * BENT)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_stop_at_rest_opens_in_the_impact_of_another_one_but_carries_it_too(
    side: float, core: str
) -> None:
    # the impact turns the shoulder by + 0.9375 rad/s: off a lower stop, not through an upper one
    limit = {"lower": 0.0} if side < 0 else {"upper": 0.0}
    run = struck_elbow(
        0.0,
        core,
        jo.RK4(1e-5),
        lambda s: RigidStop("rest", s, **limit, restitution=0.7),
        lambda s: jo.JointForce("press", s, jo.Step(0.0, after=side * 50.0)),
    )
    at = next(x.time for x in run.events if x.name == "stop")
    after = np.searchsorted(run.time, at) + 1
    assert run["one"][after - 3] == pytest.approx(0.0, abs=1e-12)  # pressed on its stop
    expected = 0.9375 if side < 0 else 0.0
    assert run["one"][after] == pytest.approx(expected, abs=5e-3)
    assert run["two"][after] == pytest.approx(0.0, abs=5e-3)


def sliders() -> Any:
    """Masses of 2 kg at 3 m/s and of 1 kg at rest, on one line."""
    one = jo.RigidBody("one", 2.0, (0.1,) * 3, velocity=(3, 0, 0))
    two = jo.RigidBody("two", 1.0, (0.1,) * 3, position=(0.3, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], one["origin"], axis=(1, 0, 0))
    ride = jo.Prismatic("ride", one["origin"], two["origin"], axis=(1, 0, 0), as_placed=True)
    return one, two, rail, ride


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("name", METHODS)
def test_two_masses_keep_their_momentum(name: str, e: float, core: str) -> None:
    solver, _ = METHODS[name]
    one, two, rail, ride = sliders()
    s = ride.displacement
    stop = RigidStop("stop", s, lower=float(s.initial) - 0.1, restitution=e)
    sensors = jo.VelocitySensor("a", one["origin"]), jo.VelocitySensor("b", two["origin"])
    model = jo.compile(jo.Mechanism(one, two, rail, ride, stop, *sensors), core=core)
    run = jo.simulate(model, 0.1, solver=solver)
    a, b = run["a"][:, 0], run["b"][:, 0]
    np.testing.assert_allclose(2 * a + b, 6.0, rtol=1e-13)
    assert b[-1] - a[-1] == pytest.approx(3 * e, abs=1e-12)
    assert run.events[0].time == pytest.approx(0.1 / 3, abs=1e-11)
    assert run.events[0].impulse == pytest.approx((1 + e) * 3 / 1.5, rel=1e-12)
    lost = run.energy.kinetic[0] - run.energy.kinetic[-1]
    assert lost == pytest.approx((1 - e * e) * 0.5 * 9 / 1.5, abs=1e-12)
    assert np.abs(run.energy.error).max() < 1e-12 * 9


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("name", METHODS)
def test_a_mass_that_rests_on_its_stop_leaves_when_it_is_pulled(name: str, core: str) -> None:
    # pressed by F cos(w t) from the start: it leaves at a quarter period, x = F/(m w^2) (...)
    solver, small = METHODS[name]
    mass = jo.RigidBody("mass", 2.0, (0.1,) * 3)
    rail = jo.Prismatic("rail", jo.ground["origin"], mass["origin"], axis=(1, 0, 0))
    s, w, F = rail.displacement, 10.0, 8.0
    stop = RigidStop("stop", s, upper=0.0, restitution=0.6)
    push = jo.Harmonic(amplitude=F, frequency=w / (2 * np.pi), phase=0.5 * np.pi)
    motor = jo.JointForce("motor", s, push)
    sensors = jo.CoordinateSensor("s", s), jo.ReactionSensor("held", stop)
    model = jo.compile(jo.Mechanism(mass, rail, stop, motor, *sensors), core=core)
    run = jo.simulate(model, 0.3, solver=solver, output_step=1e-2)
    left = 0.5 * np.pi / w
    assert run.events[-1].change == "opens"
    assert run.events[-1].time == pytest.approx(left, abs=max(10 * small, 1e-9))
    t = run.time
    before, after = t < left - 1e-6, t > left + 1e-6
    np.testing.assert_allclose(
        run["held"][before][1:, 0], -F * np.cos(w * t[before][1:]), atol=1e-5
    )
    np.testing.assert_array_equal(run["held"][after], 0.0)
    # from rest at `left`: s'' = F/m cos(w t)
    exact = -F / (2.0 * w * w) * (np.cos(w * t) + w * (t - left))
    np.testing.assert_allclose(run["s"][after][:, 0], exact[after], atol=max(1e2 * small, 1e-8))


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("name", METHODS)
def test_a_lock_joins_two_masses_until_it_opens(name: str, core: str) -> None:
    # 2 kg at 3 m/s meet 1 kg: 2 m/s together; a spring is stretched meanwhile
    solver, _ = METHODS[name]
    one, two, rail, ride = sliders()
    s = ride.displacement
    meet = Event("meet", s, float(s.initial) - 0.1, "falling")
    clock = jo.SignalSensor("clock", jo.Ramp(0.0, 1.0))
    part = Event("part", clock, 0.2, "rising")
    lock = Lock("latch", s, meet, part)
    sensors = jo.VelocitySensor("a", one["origin"]), jo.VelocitySensor("b", two["origin"])
    push = jo.Force("push", two["origin"], (6.0, 0, 0))
    items = (one, two, rail, ride, lock, meet, part, clock, push, *sensors)
    model = jo.compile(jo.Mechanism(*items), core=core)
    run = jo.simulate(model, 0.4, solver=solver)
    meeting = next(x for x in run.events if x.name == "meet").time
    closed = next(x for x in run.events if x.name == "latch")
    b0 = 6.0 * meeting
    both = (6.0 + b0) / 3.0
    assert closed.time == meeting
    assert closed.impulse == pytest.approx(2.0 * (3.0 - both), rel=1e-11)
    t, a, b = run.time, run["a"][:, 0], run["b"][:, 0]
    locked = (t > meeting + 1e-6) & (t < 0.2 - 1e-6)
    assert np.abs(a - b)[locked].max() < 1e-12
    np.testing.assert_allclose(a[locked], both + 2.0 * (t[locked] - meeting), rtol=1e-11)
    apart = t > 0.2 + 1e-6
    np.testing.assert_allclose(a[apart], both + 2.0 * (0.2 - meeting), rtol=1e-11)
    assert run.events[-1].change == "opens"
    assert np.abs(run.energy.error).max() < 1e-10


def test_both_cores_agree_on_a_chain_that_beats_its_stops() -> None:
    """Five links with two stops each: equal impacts, until rows of ever faster ones end."""
    links: list[Any] = []
    items: list[Any] = []
    at = jo.ground["origin"]
    for k in range(5):
        link = jo.RigidBody(
            f"link {k}", 1.0, (0.01, 0.1, 0.1), center=(0.5, 0, 0), position=(k, 0, 0)
        )
        joint = jo.Revolute(f"joint {k}", at, link["origin"], axis=(0, 1, 0))
        stop = RigidStop(f"stop {k}", joint.angle, -0.3, 0.25, restitution=0.4)
        at = link.at((1, 0, 0))
        links.append(link)
        items += [joint, stop]
    machine = jo.Mechanism(*links, *items, jo.Gravity((0, 0, -G)))
    runs = [jo.simulate(jo.compile(machine, core=core), 0.8, solver=jo.RK4(1e-3)) for core in CORES]
    first = [[x for x in run.events if x.time < 0.444] for run in runs]
    assert len(first[0]) > 10
    for one, other in zip(*first, strict=True):
        assert (one.name, one.change) == (other.name, other.change)
        assert one.time == pytest.approx(other.time, abs=1e-8)
        assert one.impulse == pytest.approx(other.impulse, abs=1e-6)
    for run in runs:
        assert np.abs(run.energy.error).max() < 1e-6 * G
        kept = run.energy.kinetic + run.energy.potential
        assert np.diff(kept).max() < 1e-6 * G


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
def test_a_cable_carrier_comes_to_rest_on_its_stops(e: float, core: str) -> None:
    """Eight links that beat, open and close each other's stops: no energy is created."""
    links: list[Any] = []
    items: list[Any] = []
    at = jo.ground["origin"]
    for k in range(8):
        link = jo.RigidBody(
            f"link {k}", 0.1, (1e-4,) * 3, center=(0.05, 0, 0), position=(0.1 * k, 0, 0)
        )
        joint = jo.Revolute(f"joint {k}", at, link["origin"], axis=(0, 1, 0))
        at = link.at((0.1, 0, 0))
        links.append(link)
        items += [joint, RigidStop(f"stop {k}", joint.angle, -0.3, 0.3, restitution=e)]
    model = jo.compile(jo.Mechanism(*links, *items, jo.Gravity((0, 0, -G))), core=core)
    run = jo.simulate(model, 1.0, solver=jo.RK4(1e-3))
    kept = run.energy.kinetic + run.energy.potential
    assert np.diff(kept).max() < 1e-3 * np.ptp(run.energy.potential)
    if e < 1.0:
        assert kept[-1] < kept[0] - 1.0


@pytest.mark.parametrize("step", [1e-3, 10.0])
def test_a_bouncing_ball_keeps_its_energy_at_any_step(step: float) -> None:
    ball = jo.RigidBody("ball", 2.0, (1.0,) * 3)
    rail = jo.Prismatic("rail", jo.ground["origin"], ball["origin"], axis=(0, 0, 1))
    floor = RigidStop("floor", rail.displacement, lower=-2.0, restitution=1.0)
    run = jo.simulate(
        jo.compile(jo.Mechanism(ball, rail, floor, jo.Gravity((0, 0, -G)))),
        20.0,
        solver=jo.RK4(step),
    )
    fall = np.sqrt(2 * 2.0 / G)
    assert len(run.events) == int((20.0 - fall) / (2 * fall)) + 1
    times = [event.time for event in run.events]
    np.testing.assert_allclose(times, fall * (1 + 2 * np.arange(len(times))), rtol=1e-10)
    assert run.energy.dissipated[-1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("core", CORES)
def test_a_joint_that_sticks_slides_when_it_is_hit(core: str) -> None:
    # 2 kg stick, 1 kg that rides on them hits their stop at 3 m/s: as if there were no friction
    one = jo.RigidBody("one", 2.0, (0.1,) * 3)
    two = jo.RigidBody("two", 1.0, (0.1,) * 3, position=(0.3, 0, 0), velocity=(-3, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], one["origin"], axis=(1, 0, 0))
    ride = jo.Prismatic("ride", one["origin"], two["origin"], axis=(1, 0, 0))
    s = ride.displacement
    model = jo.compile(
        jo.Mechanism(
            *(one, two, rail, ride, jo.Gravity((0, 0, -G))),
            jo.Friction("rub", rail, 0.02, 0.03, law=StickSlip()),
            RigidStop("stop", s, lower=float(s.initial) - 0.03, restitution=0.5),
            *(jo.VelocitySensor("a", one["origin"]), jo.VelocitySensor("b", two["origin"])),
        ),
        core=core,
    )
    run = jo.simulate(model, 0.02, solver=jo.RK4(1e-3))
    (struck,) = (event for event in run.events if event.name == "stop")
    assert struck.time == pytest.approx(0.01, abs=1e-11)
    assert struck.impulse == pytest.approx(3.0, rel=1e-12)
    assert run["a"][-1, 0] == pytest.approx(-1.5 + 0.02 * 3 * G / 2 * 0.01, rel=1e-9)
    assert run["b"][-1, 0] == pytest.approx(0.0, abs=1e-12)


def test_the_last_event_says_whether_a_lock_holds() -> None:
    """It ends before it begins, and begins twice: the end unlocks it all the same."""
    body = jo.RigidBody("body", 1.0, (1.0,) * 3)
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    clock = jo.SignalSensor("clock", jo.Harmonic(frequency=1.0))
    begin, end = Event("begin", clock, 0.5, "rising"), Event("end", clock, 0.5, "falling")
    again = Event("again", clock, -0.5, "falling")
    lock, other = (
        Lock("lock", rail.displacement, begin, end),
        Lock("lock", rail.displacement, end, again),
    )
    for item, held in ((lock, [(1 / 12, 5 / 12)]), (other, [(5 / 12, 7 / 12)])):
        push = jo.JointForce("push", rail.displacement, 1.0)
        rate = jo.RateSensor("rate", rail.displacement)
        items = (body, rail, clock, begin, end, again, item, push, rate)
        run = jo.simulate(jo.compile(jo.Mechanism(*items)), 2.0, solver=jo.RK4(1e-3))
        changes = [(x.time, x.change) for x in run.events if x.name == "lock"]
        expected = [
            (first + k, word)
            for k in range(2)
            for a, b in held
            for first, word in ((a, "closes"), (b, "opens"))
        ]
        assert [word for _, word in changes] == [word for _, word in expected]
        np.testing.assert_allclose(
            [t for t, _ in changes], [t for t, _ in expected], rtol=0, atol=1e-9
        )


def test_bad_stops_are_refused_with_a_remedy() -> None:
    one, two, rail, ride = sliders()
    s = rail.displacement
    with pytest.raises(jo.InputError, match="value 2 is beyond a limit of rigid stop 'stop'"):
        jo.Mechanism(
            one, two, rail, ride, RigidStop("stop", s, upper=1.0), jo.Initial(s, value=2.0)
        )
    with pytest.raises(jo.InputError, match="no limit"):
        RigidStop("stop", s)
    with pytest.raises(jo.InputError, match="not below"):
        RigidStop("stop", s, 1.0, 0.5)
    with pytest.raises(jo.InputError, match="starts at 0 m, beyond the lower limit"):
        RigidStop("stop", s, lower=0.1)
    with pytest.raises(jo.InputError, match="restitution"):
        RigidStop("stop", s, lower=-1.0, restitution=1.2)
    stop = RigidStop("stop", s, lower=-1.0)
    other = RigidStop("other", s, upper=1.0)
    drive = jo.Drive("drive", s, jo.Ramp(0.0, 1.0))
    for item, word in ((other, "rigid stop 'stop' may hold"), (drive, "drive 'drive' prescribes")):
        with pytest.raises(jo.InputError, match=word):
            jo.Mechanism(one, two, rail, ride, stop, item)
    rub = jo.Friction("rub", rail, 0.2, law=StickSlip())
    with pytest.raises(jo.InputError, match="stick-slip friction 'rub' may hold"):
        jo.Mechanism(one, two, rail, ride, stop, rub)
    shut = Event("shut", s, 0.5)
    with pytest.raises(jo.InputError, match="same event"):
        Lock("lock", s, shut, shut)
    with pytest.raises(jo.InputError, match="follows event 'shut', which is not in the mechanism"):
        jo.Mechanism(one, two, rail, ride, Lock("lock", s, shut))
    with pytest.raises(jo.InputError, match="ends="):
        jo.Mechanism(one, two, rail, ride, stop, Event("e", s, 0.5, releases=stop))
