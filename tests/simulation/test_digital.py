"""Digital control: sampled PID controllers, transfer functions in z, latency and jitter."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy import signal, stats

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import (
    BlockForce,
    Sampled,
    SampledPID,
    SampledTransferFunction,
    StateSensor,
    cos,
    rate,
    sin,
    time,
)
from jousto.simulation import DormandPrince

T = 0.01
CORES = ("joint", "maximal")
METHODS = [jo.RK4(2e-3), jo.ROS2(2e-3), jo.GeneralizedAlpha(2e-3), DormandPrince(1e-11)]


def machine(*items: Any, core: str = "joint") -> Any:
    cart = jo.RigidBody("cart", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    made = [one(rail.displacement) if callable(one) else one for one in items]
    sensors = (
        jo.CoordinateSensor("x", rail.displacement),
        jo.RateSensor("v", rail.displacement),
    )
    return jo.compile(jo.Mechanism(cart, rail, *made, *sensors, core=core))


def ticks(block: Any, output: str = "u", end: float = 0.4) -> Any:
    """Values of an output after each sample."""
    model = machine(block, StateSensor("value", block[output]))
    return jo.simulate(model, end, solver=jo.RK4(T))["value"][:, 0]


@pytest.mark.parametrize(
    ("method", "rule"), [("backward", "backward_diff"), ("tustin", "bilinear")]
)
def test_pid_is_the_discretised_one(method: str, rule: str) -> None:
    """Tick for tick: I and D of SciPy's discretisations, filtered by SciPy."""
    kp, ki, kd, tf = 3.0, 8.0, 0.2, 0.03
    block = SampledPID(
        *("pid", cos(5 * time), sin(20 * time), T),
        kp=kp, ki=ki, kd=kd, filter=tf, weight=0.7, method=method,
    )  # fmt: skip
    t = T * np.arange(41)
    r, y = np.cos(5 * t), np.sin(20 * t)

    def filtered(num: Any, den: Any, x: Any) -> Any:
        b, a, _ = signal.cont2discrete((num, den), T, rule)
        return signal.lfilter(np.ravel(b), a, x)

    wanted = kp * (0.7 * r - y) + filtered([ki], [1, 0], r - y) - filtered([kd, 0], [tf, 1], y)
    assert ticks(block) == pytest.approx(wanted, abs=1e-13)
    assert np.ptp(wanted) > 5.0


@pytest.mark.parametrize("anti_windup", ["back-calculation", "clamping", "none"])
def test_anti_windup_tick_for_tick(anti_windup: Any) -> None:
    """The recursion of the book, in a loop."""
    kp, ki, limit, tracking = 2.0, 30.0, 1.5, 0.05
    block = SampledPID(
        *("pid", 1.0, sin(12 * time), T),
        kp=kp, ki=ki, limit=limit, lower=-1.0, anti_windup=anti_windup,
        tracking=tracking if anti_windup == "back-calculation" else None,
    )  # fmt: skip
    integral, wanted, limited = 0.0, [], 0
    for t in T * np.arange(41):
        e = 1.0 - np.sin(12 * t)
        grown = integral + ki * T * e
        v = kp * e + grown
        u = min(max(v, -1.0), limit)
        limited += u != v
        if anti_windup == "clamping" and (v - u) * e > 0:
            grown = integral
        if anti_windup == "back-calculation":
            grown += T / tracking * (u - v)
        integral = grown
        wanted.append(u)
    assert ticks(block) == pytest.approx(wanted, abs=1e-13)
    assert 5 < limited < 41 or anti_windup == "none"


def test_transfer_function_in_z_is_that_of_scipy() -> None:
    num, den = signal.butter(3, 0.2)
    block = SampledTransferFunction("filter", sin(20 * time), num, den, T)
    wanted = signal.lfilter(num, den, np.sin(20 * T * np.arange(41)))
    assert ticks(block, "y") == pytest.approx(wanted, abs=1e-13)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("solver", METHODS, ids=lambda solver: type(solver).__name__)
def test_latency_is_exact(core: str, solver: Any) -> None:
    """2 kg with u = -800 x - 60 v, read every 20 ms and applied 7 ms later: powers of a matrix."""
    period, latency = 0.02, 0.007

    def control(s: Any) -> Any:
        inputs = {"x": s, "v": rate(s)}
        updates = {"u": "-800*x - 60*v", "n": "n + 1"}
        values = {"u": 0.0, "n": 0.0}
        return Sampled("c", period, values, updates, inputs=inputs, latency=latency)

    def force(s: Any) -> Any:
        return BlockForce("f", s, "c.u")

    def start(s: Any) -> Any:
        return jo.Initial(s, value=1.0)

    model = machine(control, force, start, StateSensor("n", "c.n"), core=core)
    run = jo.simulate(model, 0.2, solver=solver)

    def coast(h: float) -> Any:
        return np.array([[1, h, h * h / 4], [0, 1, h / 2], [0, 0, 1]])

    apply = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    z, u = np.array([1.0, 0.0, 0.0]), 0.0
    for _ in range(10):
        u = -800 * z[0] - 60 * z[1]
        z = coast(latency) @ apply @ z
        z[2] = u
        z = coast(period - latency) @ z
    assert [run["x"][-1, 0], run["v"][-1, 0]] == pytest.approx(z[:2], abs=1e-11)
    # the 11th sample is read at 0.2 s and not seen yet
    assert run["n"][-1, 0] == 10.0


def splitmix(seed: int, sample: int) -> float:
    """SplitMix64 of Steele, Lea and Flood, to 53 bits."""
    mask = (1 << 64) - 1
    z = (seed * 0xD1B54A32D192ED03 + (sample + 1) * 0x9E3779B97F4A7C15) & mask
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & mask
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & mask
    return float((z ^ (z >> 31)) >> 11) / 2**53


@pytest.mark.parametrize("solver", [jo.RK4(3e-3), DormandPrince(1e-8)])
def test_jitter_of_a_seed(solver: Any) -> None:
    """Samples read the time: it is that of the generator, in every method."""
    seen = {}
    for seed in (0, 7):
        block = Sampled("c", T, {"t": 0.0}, {"t": time}, jitter=4e-3, seed=seed, latency=2e-3)
        model = machine(block, StateSensor("t", "c.t"))
        run = jo.simulate(model, 0.3, solver=solver, output_step=3e-3)
        reads = np.array([T * k + 4e-3 * splitmix(seed, k) for k in range(31)])
        k = np.searchsorted(reads + 2e-3, run.time + 1e-12) - 1
        assert run["t"][:, 0] == pytest.approx(np.where(k < 0, 0.0, reads[k]), abs=1e-12)
        seen[seed] = run["t"]
    assert not np.allclose(seen[0], seen[7])


def test_jitter_is_uniform() -> None:
    for seed in (0, 1, 123456789):
        sample = [splitmix(seed, k) for k in range(2000)]
        assert stats.kstest(sample, "uniform").pvalue > 1e-3
        assert abs(np.corrcoef(sample[1:], sample[:-1])[0, 1]) < 0.06


def test_the_first_samples_see_initial_values() -> None:
    """Whatever the order of the blocks: in turn, as at each later time."""
    first = Sampled("first", T, {"y": 1.0}, {"y": "second.y"})
    second = Sampled("second", T, {"y": 5.0}, {"y": "0.5*first.y"})
    model = machine(
        first, second, StateSensor("first", "first.y"), StateSensor("second", "second.y")
    )
    run = jo.simulate(model, 0.02, solver=jo.RK4(T))
    assert run["first"][:, 0].tolist() == [5.0, 2.5, 1.25]
    assert run["second"][:, 0].tolist() == [2.5, 1.25, 0.625]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: SampledPID("c", 1.0, 0.0, T), "kp, ki and kd are all 0"),
        (lambda: SampledPID("c", 1.0, 0.0, T, kp=-1.0), "kp is -1"),
        (lambda: SampledPID("c", 1.0, 0.0, 0.0, kp=1.0), "period is 0"),
        (lambda: SampledPID("c", 1.0, 0.0, T, kp=1.0, latency=0.008, jitter=0.002), "must be less"),
        (lambda: SampledPID("c", 1.0, 0.0, T, kp=1.0, ki=1.0, tracking=1e-3), "tracking is 0.001"),
        (lambda: SampledTransferFunction("c", 1.0, [1, 0, 0], [1, 0], T), "samples of the future"),
        (lambda: SampledTransferFunction("c", 1.0, [1], [0, 0], T), "denominator of zeros"),
    ],
)
def test_what_does_not_fit_is_reported(make: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


def test_jitter_and_steps_of_bounded_work() -> None:
    block = Sampled("c", T, {"t": 0.0}, {"t": time}, jitter=1e-3)
    with pytest.raises(InputError, match="jitter"):
        jo.simulate(machine(block), 0.1, solver=jo.RK4(1e-3, events="step"))
