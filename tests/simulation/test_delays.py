"""Delays: the method of steps, orders of the methods, jumps, roots, both cores."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError, SimulationError
from jousto.mechanism import (
    BlockForce,
    Delay,
    Sampled,
    States,
    StateSensor,
    rate,
    sin,
    time,
)
from jousto.simulation import DormandPrince

CORES = ("joint", "maximal")


def machine(*items: Any, core: str = "joint") -> Any:
    cart = jo.RigidBody("cart", 1.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    made = [one(rail.displacement) if callable(one) else one for one in items]
    place = jo.CoordinateSensor("place", rail.displacement)
    return jo.compile(jo.Mechanism(cart, rail, *made, place, core=core))


def decay(core: str = "joint", **given: Any) -> Any:
    """x' = -x(t - 1), x = 1 before."""
    late = Delay("late", "s.x", 1.0, **given)
    states = States("s", {"x": 1.0}, {"x": "-d"}, inputs={"d": "late.y"})
    return machine(late, states, StateSensor("x", "s.x"), StateSensor("d", "late.y"), core=core)


def exact(t: float) -> float:
    """Method of steps: the sum of (-1)^k (t - k + 1)^k / k! up to k = floor(t) + 1."""
    return 1.0 + sum(
        (-1) ** k * (t - k + 1) ** k / math.factorial(k) for k in range(1, math.floor(t) + 2)
    )


def test_the_sum_is_the_published_value() -> None:
    assert exact(3.0) == pytest.approx(-1 / 6, abs=1e-15)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("step", [0.05, 0.5, 1.0])
def test_cubic_pieces_are_exact(core: str, step: float) -> None:
    """x(3) = -1/6: RK4 and the interpolation are exact for cubic pieces, whatever the step."""
    run = jo.simulate(decay(core), 3.0, solver=jo.RK4(step))
    assert run["x"][-1, 0] == pytest.approx(-1 / 6, abs=2e-15)
    assert run["d"][-1, 0] == pytest.approx(-0.5, abs=2e-15)


def test_steps_that_do_not_divide_the_delay() -> None:
    run = jo.simulate(decay(), 2.8, solver=jo.RK4(0.7), output_step=0.7)
    assert run["x"][:, 0] == pytest.approx([exact(0.7 * k) for k in range(5)], abs=2e-15)


def test_rk4_keeps_its_order() -> None:
    """Errors at 10 s fall by 2^4 with the step."""
    errors = [
        abs(
            jo.simulate(decay(), 10.0, solver=jo.RK4(h), output_step=10.0)["x"][-1, 0] - exact(10.0)
        )
        for h in (0.2, 0.1, 0.05)
    ]
    orders = [math.log2(a / b) for a, b in zip(errors, errors[1:], strict=False)]
    assert orders == pytest.approx([4.0, 4.0], abs=0.15)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("method", [jo.ROS2, jo.GeneralizedAlpha])
def test_implicit_methods_have_order_2(core: str, method: Any) -> None:
    errors = [
        abs(jo.simulate(decay(core), 3.0, solver=method(h))["x"][-1, 0] + 1 / 6)
        for h in (0.05, 0.025)
    ]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.15)
    assert errors[1] < 1e-4


def test_error_control_includes_the_interpolation() -> None:
    """The pieces are smooth for the method alone, which would take one step for each."""
    for tolerance in (1e-6, 1e-8):
        run = jo.simulate(decay(), 5.0, solver=DormandPrince(tolerance), output_step=0.25)
        wanted = [exact(t) for t in run.time]
        assert run["x"][:, 0] == pytest.approx(wanted, abs=30 * tolerance)
        late = [exact(t - 1) if t >= 1 else 1.0 for t in run.time]
        assert run["d"][:, 0] == pytest.approx(late, abs=30 * tolerance)


def test_a_run_in_parts_is_the_run() -> None:
    """What is kept of the motion before belongs to the state."""
    model = decay()
    whole = jo.simulate(model, 5.0, solver=jo.RK4(0.1))
    first = jo.simulate(model, 2.3, solver=jo.RK4(0.1))
    second = jo.simulate(model, 5.0, solver=jo.RK4(0.1), state=first.state())
    assert second["x"][-1, 0] == pytest.approx(whole["x"][-1, 0], abs=1e-15)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize(("delay", "grows"), [(1.45, False), (1.56, True)])
def test_stability_of_an_oscillator(core: str, delay: float, grows: bool) -> None:
    """x'' + .1 x' + x = -.4 x'(t - tau) is stable up to tau = 1.50423738588 s."""
    root = newton_root(delay)
    assert (root.real > 0) == grows

    def push(s: Any) -> Any:
        return BlockForce("push", s, "-0.4*late.y")

    def late(s: Any) -> Any:
        return Delay("late", rate(s), delay)

    def spring(s: Any) -> Any:
        return jo.Spring("spring", s, stiffness=1.0, damping=0.1)

    def start(s: Any) -> Any:
        return jo.Initial(s, value=1.0)

    model = machine(push, late, spring, start, core=core)
    run = jo.simulate(model, 60.0, solver=jo.RK4(0.05))
    # after the other roots have decayed: x_{n+1} - 2 Re(e^{rh}) x_n + e^{2 Re r h} x_{n-1} = 0
    x, h = run["place"][800::4, 0], 0.2
    left = np.column_stack([x[1:-1], x[:-2]])
    a, b = np.linalg.lstsq(left, x[2:], rcond=None)[0]
    found = np.roots([1.0, -a, -b])
    assert np.log(found[0]).real / h == pytest.approx(root.real, abs=2e-5)


def newton_root(delay: float) -> complex:
    """Root of s^2 + .1 s + 1 + .4 s exp(-s tau) near i."""
    s = 1.1j
    for _ in range(30):
        e = np.exp(-s * delay)
        f = s**2 + 0.1 * s + 1 + 0.4 * s * e
        s -= f / (2 * s + 0.1 + 0.4 * e * (1 - s * delay))
    return complex(s)


def test_the_limit_of_stability_is_the_published_one() -> None:
    low, high = 1.45, 1.56
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if newton_root(middle).real < 0 else (low, middle)
    assert low == pytest.approx(1.50423738588, abs=1e-11)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize(
    "solver", [jo.RK4(4e-3), jo.ROS2(4e-3), jo.GeneralizedAlpha(4e-3), DormandPrince(1e-9)]
)
def test_jumps_are_delayed_as_jumps(core: str, solver: Any) -> None:
    """A sampled force of 1, 2, 3 .. N, 25 ms late: velocities are sums of 10 ms times these."""

    def push(s: Any) -> Any:
        return BlockForce("push", s, "late.y")

    count = Sampled("count", 0.01, {"n": 0.0}, {"n": "n + 1"})
    late = Delay("late", "count.n", 0.025, initial=0.0)

    def speed(s: Any) -> Any:
        return jo.RateSensor("v", s)

    model = machine(count, late, push, speed, StateSensor("y", "late.y"), core=core)
    run = jo.simulate(model, 0.12, solver=solver, output_step=4e-3)
    since = np.asarray(run.time) - 0.025
    whole = np.floor(np.maximum(since, 0.0) / 0.01 + 1e-9)
    wanted = 0.005 * whole * (whole + 1) + (whole + 1) * np.maximum(since - 0.01 * whole, 0.0)
    assert run["v"][:, 0] == pytest.approx(wanted, abs=1e-12)
    assert run["y"][:, 0] == pytest.approx(np.where(since >= 0, whole + 1, 0.0), abs=1e-12)


def test_delays_in_a_chain() -> None:
    """Two delays of a signal are one of the sum, whatever their order among the blocks."""
    second = Delay("second", "first.y", 0.2)
    first = Delay("first", sin(3 * time), 0.3)
    model = machine(second, first, StateSensor("y", "second.y"))
    run = jo.simulate(model, 2.0, solver=jo.RK4(0.01))
    wanted = np.where(run.time >= 0.5, np.sin(3 * (run.time - 0.5)), 0.0)
    assert run["y"][:, 0] == pytest.approx(wanted, abs=2e-8)


def test_a_delay_opens_a_loop() -> None:
    """y = 1 - y(t - 1) / 2 from y = 1: 1/2, 3/4, 5/8 .."""
    late = Delay("late", "1 - 0.5*late.y", 1.0, initial=0.0)
    model = machine(late, StateSensor("y", "late.y"))
    run = jo.simulate(model, 4.5, solver=jo.RK4(0.5), output_step=0.5)
    assert run["y"][:, 0] == pytest.approx([0, 0, 1, 1, 0.5, 0.5, 0.75, 0.75, 0.625, 0.625])


def test_derivative_by_the_delay() -> None:
    """x(2) = 1 - 2 + (2 - tau)^2/2 for x' = -x(t - tau): dx/dtau = -(2 - tau) = -1."""
    run = {}
    for step in (1.0, 1.0 + 1e-6):
        late = Delay("late", "s.x", step)
        states = States("s", {"x": 1.0}, {"x": "-late.y"})
        model = machine(late, states, StateSensor("x", "s.x"))
        run[step] = jo.simulate(model, 2.0, solver=jo.RK4(0.1))["x"][-1, 0]
    assert (run[1.0 + 1e-6] - run[1.0]) / 1e-6 == pytest.approx(-1.0, abs=1e-5)


def test_too_many_jumps() -> None:
    count = Sampled("count", 0.01, {"n": 0.0}, {"n": "n + 1"})
    model = machine(count, Delay("late", "count.n", 1.0, points=20), StateSensor("y", "late.y"))
    with pytest.raises(SimulationError, match="delay 'late': its input jumps too often.*=200"):
        jo.simulate(model, 3.0, solver=jo.RK4(5e-3))


@pytest.mark.parametrize("delay", [0.0, -1.0, math.nan])
def test_delays_are_positive(delay: float) -> None:
    with pytest.raises(InputError, match="time"):
        Delay("late", "s.x", delay)


def test_a_delay_below_a_step_of_bounded_work() -> None:
    solver = jo.RK4(2.0, events="step")
    with pytest.raises(InputError, match="'late': is 1 s, less than the step of 2 s"):
        jo.simulate(decay(), 4.0, solver=solver)
    run = jo.simulate(decay(), 4.0, solver=jo.RK4(2.0))
    assert run["x"][1, 0] == pytest.approx(exact(2.0), abs=1e-14)


@pytest.mark.parametrize(
    "analysis",
    [jo.equilibrium, jo.simulation.linearise, lambda m: jo.modes(m, damped=True)],
)
def test_analyses_without_delays(analysis: Any) -> None:
    with pytest.raises(InputError, match="'late'"):
        analysis(decay())
