"""Blocks that keep values within steps: sampled control, play, relay, Bouc-Wen spring."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import signal

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import (
    BlockForce,
    BoucWen,
    Integrator,
    Play,
    Relay,
    Sampled,
    States,
    StateSensor,
    cos,
    rate,
    sin,
    time,
)

CORES = ("joint", "maximal")
METHODS = [
    jo.RK4(1e-3),
    jo.ROS2(1e-3),
    jo.GeneralizedAlpha(1e-3),
    jo.simulation.DormandPrince(1e-11),
]


def machine(*items: Any, mass: float = 2.0, core: str = "joint") -> Any:
    cart = jo.RigidBody("cart", mass, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    made = [one(rail.displacement) if callable(one) else one for one in items]
    sensors = (
        jo.CoordinateSensor("x", rail.displacement),
        jo.RateSensor("v", rail.displacement),
    )
    return jo.Mechanism(cart, rail, *made, *sensors, core=core)


def held(core: str = "joint", period: float = 0.02, phase: float = 0.0) -> Any:
    """2 kg with u = -800 x - 60 v, sampled; starts at x = 1 m."""

    def control(s: Any) -> Any:
        inputs = {"x": s, "v": rate(s)}
        return Sampled("c", period, {"u": 0.0}, {"u": "-800*x - 60*v"}, inputs=inputs, phase=phase)

    def force(s: Any) -> Any:
        return BlockForce("f", s, "c.u")

    def start(s: Any) -> Any:
        return jo.Initial(s, value=1.0)

    return machine(control, force, start, StateSensor("u", "c.u"), core=core)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("solver", METHODS, ids=lambda solver: type(solver).__name__)
def test_sampled_control_is_exact(core: str, solver: Any) -> None:
    """-0.0238360972784 m and -0.049564147312 m/s after 0.2 s: powers of one matrix."""
    run = jo.simulate(jo.compile(held(core)), 0.2, solver=solver)
    assert run["x"][-1, 0] == pytest.approx(-0.0238360972784, abs=1e-12)
    assert run["v"][-1, 0] == pytest.approx(-0.049564147312, abs=1e-11)


@pytest.mark.parametrize("step", [1e-3, 3e-3, 0.02, 0.05])
def test_steps_end_at_samples(step: float) -> None:
    """Steps of any length: they are cut at the samples, and the result is the same."""
    run = jo.simulate(jo.compile(held()), 0.6, solver=jo.RK4(step), output_step=0.6)
    a = np.array([[1, 0.02], [0, 1]]) + np.outer([0.02**2 / 2, 0.02], [-800, -60]) / 2
    x = np.linalg.matrix_power(a, 30) @ [1.0, 0.0]
    assert [run["x"][-1, 0], run["v"][-1, 0]] == pytest.approx(x, abs=1e-13)


def test_a_phase_delays_the_first_sample() -> None:
    run = jo.simulate(jo.compile(held(phase=0.01)), 0.03, solver=jo.RK4(1e-3))
    x = run["x"][:, 0]
    assert x[:11] == pytest.approx(1.0, abs=1e-15)
    assert run["u"][:11, 0] == pytest.approx([0.0] * 10 + [-800.0], abs=1e-12)
    assert x[-1] == pytest.approx(1 - 400 * 0.02**2 / 2, abs=1e-12)


def test_a_run_in_parts_is_the_run() -> None:
    """The number of samples and the values belong to the state."""
    model = jo.compile(held())
    whole = jo.simulate(model, 0.2, solver=jo.RK4(1e-3))
    first = jo.simulate(model, 0.05, solver=jo.RK4(1e-3))
    second = jo.simulate(model, 0.2, solver=jo.RK4(1e-3), state=first.state())
    assert second["x"][-1, 0] == pytest.approx(whole["x"][-1, 0], abs=1e-15)
    assert second["u"][0, 0] == first["u"][-1, 0]


def test_several_rates() -> None:
    """A fast counter and a slow one that reads it: at 0, 30, 60 ms it is 1, 4, 7."""
    fast = Sampled("fast", 0.01, {"n": 0.0}, {"n": "n + 1"})
    slow = Sampled("slow", 0.03, {"n": 0.0}, {"n": "fast.n"})
    sensors = StateSensor("fast", "fast.n"), StateSensor("slow", "slow.n")
    run = jo.simulate(jo.compile(machine(fast, slow, *sensors)), 0.07, solver=jo.RK4(5e-3))
    assert run["fast"][:, 0].tolist() == [1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8]
    assert run["slow"][:, 0].tolist() == [1] * 6 + [4] * 6 + [7] * 3


@pytest.mark.parametrize("form", [0, 1])
def test_a_sampled_filter_of_scipy_tick_for_tick(form: int) -> None:
    num, den = signal.butter(3, 0.2)
    system: Any = signal.TransferFunction(num, den, dt=0.01)
    if form:
        system = SimpleNamespace(**dict(zip("ABCD", signal.tf2ss(num, den), strict=True)), dt=0.01)
    block = Sampled.from_system("filter", system, sin(20 * time))
    run = jo.simulate(
        jo.compile(machine(block, StateSensor("y", "filter.y"))), 0.5, solver=jo.RK4(0.01)
    )
    wanted = signal.lfilter(num, den, np.sin(20 * np.arange(51) * 0.01))
    assert run["y"][:, 0] == pytest.approx(wanted, abs=1e-13)


@pytest.mark.parametrize("solver", METHODS, ids=lambda solver: type(solver).__name__)
def test_area_of_a_loop_with_play(solver: Any) -> None:
    """4 r (A - r) = 3e-4 for r = 0.005 and A = 0.02: the integral of y along u over a cycle."""
    w = 2 * math.pi
    play = Play("play", jo.Harmonic(frequency=1.0, amplitude=0.02), 0.005)
    area = Integrator("area", play["y"] * (0.02 * w) * cos(w * time))
    sensors = StateSensor("y", play["y"]), StateSensor("area", area["y"])
    model = jo.compile(machine(play, area, *sensors))
    run = jo.simulate(model, 2.0, solver=solver, output_step=0.25)
    error = 1e-8 if isinstance(solver, jo.ROS2 | jo.GeneralizedAlpha) else 1e-11
    assert run["area"][4, 0] - run["area"][8, 0] == pytest.approx(3e-4, abs=error)
    assert run["y"][4:, 0] == pytest.approx([-0.005, 0.015, 0.005, -0.015, -0.005], abs=1e-9)


@pytest.mark.parametrize("core", CORES)
def test_play_of_a_coordinate_turns_where_the_coordinate_turns(core: str) -> None:
    """An oscillation 0.02 cos(w t): y is held at -0.015 and 0.015 after the turns, to 1e-9."""

    def block(s: Any) -> Any:
        return Play("play", s, 0.005, initial=0.015)

    def start(s: Any) -> Any:
        return jo.Initial(s, value=0.02)

    def spring(s: Any) -> Any:
        return jo.Spring("spring", s, 200.0)

    model = jo.compile(machine(block, start, spring, StateSensor("y", "play.y"), core=core))
    run = jo.simulate(model, 0.9, solver=jo.RK4(1e-2))  # a turn every 0.314 s
    y, t = run["y"][:, 0], run.time
    turned = (t > 0.315) & (t < 0.38)
    assert y[turned] == pytest.approx(-0.015, abs=1e-8)
    assert y[(t > 0.63) & (t < 0.69)] == pytest.approx(0.015, abs=1e-8)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("solver", [jo.RK4(1e-3), jo.simulation.DormandPrince(1e-11)])
def test_a_relay_switches_at_the_instant(core: str, solver: Any) -> None:
    """Two-point control of a lag: switching times by the logarithms of the closed form."""
    room = States("room", {"T": 0.0}, {"T": "(2*h - T)/0.1"}, inputs={"h": "relay.y"})
    relay = Relay("relay", -room["T"], -1.2, -0.8, closed=True)
    sensors = StateSensor("T", room["T"]), StateSensor("on", relay["y"])
    run = jo.simulate(jo.compile(machine(room, relay, *sensors, core=core)), 0.3, solver=solver)
    # heats to 1.2, then cools to 0.8, heats to 1.2 ..
    up, down, again = (0.1 * math.log(x) for x in (2 / 0.8, 1.2 / 0.8, 1.2 / 0.8))
    cycle = down + again
    left = (0.3 - up) % cycle
    wanted = (
        1.2 * math.exp(-left / 0.1) if left < down else 2 - 1.2 * math.exp(-(left - down) / 0.1)
    )
    assert run["T"][-1, 0] == pytest.approx(wanted, abs=1e-8)
    assert set(run["on"][:, 0].tolist()) == {0.0, 1.0}


@pytest.mark.parametrize(
    ("numbers", "largest", "loss"),
    [
        ((300.0, 100.0, 1.0), 2.49999936699e-3, 15.5372971579),
        ((3e4, 1e4, 2.0), 4.99999358311e-3, None),
    ],
)
def test_bouc_wen(numbers: Any, largest: float, loss: float | None) -> None:
    """A prescribed oscillation of 0.02 m; share 0.1, k 1e5; the steady cycle."""

    def spring(s: Any) -> Any:
        return BoucWen("spring", s, 1e5, 0.1, *numbers)

    def drive(s: Any) -> Any:
        return jo.Drive("drive", s, jo.Harmonic(frequency=1.0, amplitude=0.02))

    def lost(s: Any) -> Any:
        return States("lost", {"W": 0.0}, {"W": "-F*v"}, inputs={"F": "spring.force", "v": rate(s)})

    sensors = StateSensor("z", "spring.z"), StateSensor("W", "lost.W", unit="J")
    model = jo.compile(machine(spring, drive, lost, *sensors))
    run = jo.simulate(model, 3.0, solver=jo.RK4(2.5e-5), output_step=0.25)
    assert np.abs(run["z"][9:]).max() == pytest.approx(largest, rel=1e-11)
    if loss is not None:
        assert run["W"][12, 0] - run["W"][8, 0] == pytest.approx(loss, abs=5e-9)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Relay("r", 0.0, 1.0, 1.0), "lower is 1, must be below upper.*take a switch"),
        (lambda: Play("p", 0.0, 0.0), "play"),
        (lambda: Sampled("s", 0.0, {"u": 0.0}, {"u": 1.0}), "period"),
        (lambda: Sampled("s", 0.1, {}, {}), "has no values"),
        (lambda: Sampled("s", 0.1, {"u": 0.0}, {"v": 1.0}), "no value 'v'"),
        (lambda: Sampled("s", 0.1, {"u": 0.0}, {"u": "w"}), "nothing is called 'w'"),
        (lambda: Sampled("s", 0.1, {"u": 0.0}, {"u": 1}, inputs={"u": 1}), "value and an input"),
        (
            lambda: Sampled.from_system("s", signal.TransferFunction([1], [1, 1]), 0.0),
            "continuous; take States.from_system",
        ),
        (
            lambda: States.from_system("s", signal.TransferFunction([1], [1, 1], dt=0.1), 0.0),
            "sampled every 0.1 s; take Sampled.from_system",
        ),
    ],
)
def test_blocks_that_are_refused(build: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        build()


def test_bouc_wen_that_is_refused_or_warned_of() -> None:
    coordinate = machine().joints[0].displacement
    with pytest.raises(InputError, match="must be 1, or 2 and more"):
        BoucWen("b", coordinate, 1e5, 0.1, 300.0, 100.0, 1.5)
    with pytest.raises(InputError, match="z has no bound"):
        BoucWen("b", coordinate, 1e5, 0.1, 100.0, -100.0)
    with pytest.warns(jo.JoustoWarning, match="supply energy"):
        BoucWen("b", coordinate, 1e5, 0.1, 100.0, 300.0)


def test_a_value_without_update_is_refused() -> None:
    with pytest.raises(InputError, match="has no next value of 'v'"):
        jo.compile(machine(Sampled("s", 0.1, {"u": 0.0, "v": 0.0}, {"u": 1.0})))


def test_equilibrium_refuses_what_is_kept() -> None:
    with pytest.raises(InputError, match=r"'c'.*simulate until"):
        jo.equilibrium(jo.compile(held()))


def test_steps_of_bounded_work_must_fit_the_samples() -> None:
    model = jo.compile(held(period=0.01))
    fits = jo.simulate(model, 0.1, solver=jo.RK4(1e-3, events="step"))
    assert fits["x"][-1, 0] != 1.0
    with pytest.raises(InputError, match=r"period of 0.01 s is no multiple.*0.0033333"):
        jo.simulate(model, 0.1, solver=jo.RK4(3e-3, events="step"))
