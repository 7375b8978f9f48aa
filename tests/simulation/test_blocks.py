"""Blocks of control: closed forms, exponentials of matrices, independent integrations."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy import signal
from scipy.linalg import expm

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import (
    Adder,
    Block,
    BlockForce,
    DeadBand,
    Integrator,
    Lag,
    Lead,
    LinearSystem,
    Multiplier,
    PIDController,
    RateLimit,
    Saturation,
    States,
    StateSensor,
    Switch,
    TransferFunction,
    rate,
    sin,
    time,
)
from jousto.mechanism.states.state_space import of_transfer_function

CORES = ("joint", "maximal")


def machine(*blocks: Any, core: str = "joint", watch: Any = None, friction: float = 0.5) -> Any:
    """Cart of 1 kg with a viscous damper, blocks, and sensors of their outputs by `block.name`."""
    cart = jo.RigidBody("cart", 1.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    made = [one(rail.displacement) if callable(one) else one for one in blocks]
    sensors = [
        StateSensor(f"{block.name}.{name}", block[name])
        for block in made
        if isinstance(block, Block)
        for name in block.outputs
    ]
    damper = jo.Spring("oil", rail.displacement, damping=friction)
    place = jo.CoordinateSensor("x", rail.displacement)
    return jo.Mechanism(cart, rail, damper, place, *made, *sensors, core=core)


def run(mechanism: Any, end: float, solver: Any, **more: Any) -> Any:
    return jo.simulate(jo.compile(mechanism), end, solver=solver, **more)


def controlled(core: str, **options: Any) -> Any:
    """y'' + 0.5 y' = u with a PID of 8, Ti 2, Td 0.5 on y only, and the limit 1.5; r = 1."""
    cart = jo.RigidBody("cart", 1.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    s = rail.displacement
    gains = {"kp": 8.0, "ki": 8.0 / 2.0, "kd": 8.0 * 0.5, "limit": 1.5}
    pid = PIDController("pid", 1.0, s, **gains, **options)
    push, damper = BlockForce("push", s, pid["u"]), jo.Spring("oil", s, damping=0.5)
    return jo.Mechanism(
        cart,
        rail,
        damper,
        pid,
        push,
        jo.CoordinateSensor("y", s),
        StateSensor("u", "pid.u"),
        core=core,
    )


def peak(values: Any) -> float:
    """Largest value of the polynomial of degree 4 through the five samples about it."""
    k = int(np.argmax(values))
    c = np.polyfit(np.arange(-2, 3), values[k - 2 : k + 3], 4)
    found = [z.real for z in np.roots(np.polyder(c)) if abs(z.imag) < 1e-9 and abs(z) < 1]
    return float(np.polyval(c, found[0]))


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize(
    ("options", "wanted"), [({}, 1.185558148), ({"anti_windup": "none"}, 1.360858220)]
)
def test_peak_of_a_limited_pid(core: str, options: Any, wanted: float) -> None:
    """Peaks by DOP853 and Radau of the four equations with located kinks."""
    found = run(controlled(core, **options), 8.0, jo.RK4(2.5e-4))["y"][:, 0]
    assert peak(found) == pytest.approx(wanted, abs=1e-9)


def test_clamping_and_tracking_of_a_pid() -> None:
    """Clamping holds the integral part; tracking of the saturated output is the default."""
    clamped = peak(run(controlled("joint", anti_windup="clamping"), 8.0, jo.RK4(1e-3))["y"][:, 0])
    assert 1.0 < clamped < 1.185
    same = controlled("joint", actual=Saturation("s", "pid.unlimited", -1.5, 1.5).value)
    assert peak(run(same, 8.0, jo.RK4(2.5e-4))["y"][:, 0]) == pytest.approx(1.185558148, abs=1e-9)


def test_pid_as_a_block_is_the_pid_as_a_force() -> None:
    gains = {"kp": 8.0, "ki": 4.0, "kd": 4.0, "limit": 1.5}
    block = run(controlled("joint"), 3.0, jo.RK4(1e-3))["y"]
    cart = jo.RigidBody("cart", 1.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    s = rail.displacement
    force = jo.mechanism.PID("pid", s, 1.0, **gains)
    damper = jo.Spring("oil", s, damping=0.5)
    other = run(
        jo.Mechanism(cart, rail, damper, force, jo.CoordinateSensor("y", s)), 3.0, jo.RK4(1e-3)
    )
    assert np.abs(block - other["y"]).max() < 1e-12


NUM, DEN = [2.0, 3.0, 500.0], [1.0, 4.0, 130.0, 400.0]


def exact(A: Any, B: Any, C: Any, D: Any, t: float, w: float = 7.0) -> Any:
    """Outputs at t for the inputs cos(w t), sin(w t) .. from zero states, by an exponential."""
    n, m = B.shape
    turn = np.array([[0.0, -w], [w, 0.0]])
    all_ = np.zeros((n + 2, n + 2))
    all_[:n, :n], all_[:n, n : n + m], all_[n:, n:] = A, B, turn
    x = expm(all_ * t) @ np.concatenate([np.zeros(n), [1.0, 0.0]])
    return C @ x[:n] + D @ x[n : n + m]


WAVE = (
    jo.Harmonic(frequency=7 / (2 * math.pi), phase=math.pi / 2),
    jo.Harmonic(frequency=7 / (2 * math.pi)),
)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize(("method", "order"), [("RK4", 4), ("ROS2", 2), ("GeneralizedAlpha", 2)])
def test_order_of_a_transfer_function(core: str, method: str, order: int) -> None:
    block = TransferFunction("tf", WAVE[0], NUM, DEN)
    wanted = exact(*signal.tf2ss(NUM, DEN), t=1.0)[0]
    model, errors = jo.compile(machine(block, core=core)), []
    for step in (1e-2, 5e-3):
        found = jo.simulate(model, 1.0, solver=getattr(jo, method)(step))["tf.y"]
        errors.append(abs(found[-1, 0] - wanted))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.25)
    assert errors[1] < 1e-2 * abs(wanted)


def test_a_linear_system_with_several_inputs_and_outputs() -> None:
    rng = np.random.default_rng(3)
    A = rng.normal(size=(3, 3)) - 3 * np.eye(3)
    B, C, D = rng.normal(size=(3, 2)), rng.normal(size=(2, 3)), rng.normal(size=(2, 2))
    block = LinearSystem("system", WAVE, A, B, C, D)
    found = run(machine(block), 1.0, jo.RK4(1e-3))
    y = [found["system.y1"][-1, 0], found["system.y2"][-1, 0]]
    assert y == pytest.approx(exact(A, B, C, D, 1.0), abs=1e-10)


def test_poles_of_blocks_in_linearise() -> None:
    """Poles of the system with those of the cart: 0 and -0.5."""
    block = TransferFunction("tf", 0.0, NUM, DEN)
    found = np.sort_complex(
        np.linalg.eigvals(jo.simulation.linearise(jo.compile(machine(block))).A)
    )
    wanted = np.sort_complex(np.concatenate([np.roots(DEN), [0.0, -0.5]]))
    assert np.abs(found - wanted).max() < 1e-9


SYSTEMS = [
    signal.StateSpace(*signal.tf2ss(NUM, DEN)),
    signal.TransferFunction(NUM, DEN),
    signal.TransferFunction(NUM, DEN).to_zpk(),
    # attributes of python-control: StateSpace and TransferFunction
    SimpleNamespace(**dict(zip("ABCD", signal.tf2ss(NUM, DEN), strict=True)), dt=0),
    SimpleNamespace(num=[[np.array(NUM)]], den=[[np.array(DEN)]], dt=None),
]


@pytest.mark.parametrize("system", SYSTEMS)
def test_systems_of_other_libraries(system: Any) -> None:
    block = States.from_system("other", system, WAVE[0])
    wanted = exact(*signal.tf2ss(NUM, DEN), t=1.0)[0]
    found = run(machine(block), 1.0, jo.RK4(1e-3))["other.y"][-1, 0]
    assert found == pytest.approx(wanted, rel=1e-8)


def test_states_of_a_given_system_keep_their_order() -> None:
    A, B, C, D = signal.tf2ss(NUM, DEN)
    block = States.from_system("own", SYSTEMS[0], 1.0, initial=[1.0, 2.0, 3.0])
    sensors = [StateSensor(name, block[name]) for name in ("x1", "x2", "x3")]
    found = run(machine(block, *sensors), 1e-9, jo.RK4(1e-9))
    assert [found[name][0, 0] for name in ("x1", "x2", "x3")] == [1.0, 2.0, 3.0]


def test_balanced_states_of_a_transfer_function() -> None:
    """Coefficients over 12 decades; scaling by powers of 2 is exact: poles and zeros stay."""
    den = np.poly([-1e-2, -1e1, -1e4])
    A, B, C, D = of_transfer_function(np.array([1e3, 1e9]), den)
    assert np.sort(np.linalg.eigvals(A)) == pytest.approx([-1e4, -1e1, -1e-2], rel=1e-10)
    assert np.abs(A).max() / np.abs(A[A != 0]).min() < 1e9
    s = 3.0j
    value = (C @ np.linalg.solve(s * np.eye(3) - A, B) + D)[0, 0]
    assert value == pytest.approx(np.polyval([1e3, 1e9], s) / np.polyval(den, s), rel=1e-12)


@pytest.mark.parametrize(("method", "error"), [("RK4", 1e-9), ("ROS2", 2e-5)])
def test_lag_lead_and_integrator(method: str, error: float) -> None:
    blocks = [
        Lag("lag", 3.0, 0.1, 2.0, initial=1.0),
        Lead("lead", 1.0, 0.3, 0.1),
        Integrator("area", time, 4.0, initial=1.0),
    ]
    found = run(
        machine(*blocks, StateSensor("lag.y", blocks[0]["y"])), 0.25, getattr(jo, method)(1e-3)
    )
    decay = math.exp(-2.5)
    assert found["lag.y"][-1, 0] == pytest.approx(6 - 5 * decay, abs=error)
    assert found["lead.y"][-1, 0] == pytest.approx(1 + 2 * decay, abs=error)
    assert found["area.y"][-1, 0] == pytest.approx(1 + 2 * 0.25**2, abs=error)


def test_an_integrator_stops_at_its_limits_and_leaves_them_at_once() -> None:
    block = Integrator("area", 10 * sin(2 * math.pi * time), lower=-0.5, upper=1.0)
    found = run(machine(block), 1.0, jo.RK4(1e-3), output_step=1e-3)
    y, t = found["area.y"][:, 0], found.time
    assert y.max() == 1.0
    assert y.min() == -0.5
    # after half a period the input turns, and the integral leaves the limit
    falling = 1.0 - 10 / (2 * math.pi) * (1 + np.cos(2 * math.pi * t))
    at = (t > 0.5) & (falling > -0.49)
    assert np.abs(y - falling)[at].max() < 0.012  # one step beyond the limit: 10 * 1e-3


def test_maps_without_states() -> None:
    u = 4 * time - 2
    values = {
        "sum": (Adder("sum", [u, 1.0, time], [2, -1, 3]), lambda t: 2 * (4 * t - 2) - 1 + 3 * t),
        "plain": (Adder("plain", [u, time]), lambda t: 5 * t - 2),
        "product": (Multiplier("product", [u, time, 2.0]), lambda t: (4 * t - 2) * t * 2),
        "limit": (Saturation("limit", u, -1.0, 0.5), lambda t: np.clip(4 * t - 2, -1, 0.5)),
        "above": (Saturation("above", u, upper=0.5), lambda t: np.minimum(4 * t - 2, 0.5)),
        "band": (
            DeadBand("band", u, -1.0, 0.5),
            lambda t: 4 * t - 2 - np.clip(4 * t - 2, -1, 0.5),
        ),
        "switch": (Switch("switch", u, time, -1.0), lambda t: np.where(4 * t > 2, t, -1.0)),
    }
    found = run(machine(*(block for block, _ in values.values())), 1.0, jo.RK4(0.03125))
    for name, (_, wanted) in values.items():
        assert found[f"{name}.y"][:, 0] == pytest.approx(wanted(found.time), abs=1e-14)


def test_rate_limit_rises_and_falls_with_its_rates() -> None:
    """After a jump by 1 the rate is 2, then a lag of 1 ms remains; downwards the rate is 4."""
    block = RateLimit("limit", jo.Step(time=0.0, before=1.0, after=1.0), 2.0, 4.0)
    found = run(machine(block, StateSensor("y", block["y"])), 0.6, jo.RK4(5e-4))
    y, t = found["y"][:, 0], found.time
    assert y[t < 0.49] == pytest.approx(2 * t[t < 0.49], abs=1e-12)
    left = 2e-3 * math.exp(-(0.6 - 0.499) / 1e-3)
    assert y[-1] == pytest.approx(1.0 - left, abs=1e-9)
    down = RateLimit("limit", -1.0, 2.0, 4.0)
    fallen = run(machine(down, StateSensor("y", down["y"])), 0.2, jo.RK4(5e-4))
    assert fallen["y"][-1, 0] == pytest.approx(-0.8, abs=1e-12)


@pytest.mark.parametrize("core", CORES)
def test_equilibrium_with_a_pid_block(core: str) -> None:
    """The integral part carries the weight, and nothing moves."""
    body = jo.RigidBody("cart", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    s = rail.displacement
    pid = PIDController("pid", 0.25, s, kp=200.0, ki=50.0, kd=20.0, limit=100.0)
    push = BlockForce("push", s, pid["u"])
    sensors = StateSensor("I", pid["integral"]), jo.CoordinateSensor("x", s)
    gravity = jo.Gravity((0, 0, -9.81))
    model = jo.compile(jo.Mechanism(body, rail, pid, push, gravity, *sensors, core=core))
    rest = jo.simulate(model, 1e-3, state=jo.equilibrium(model), solver=jo.RK4(1e-3))
    assert rest["I"][0, 0] == pytest.approx(2 * 9.81, rel=1e-8)
    assert rest["x"][-1, 0] == pytest.approx(0.25, rel=1e-8)


@pytest.mark.parametrize("core", CORES)
def test_gradient_with_respect_to_a_coefficient(core: str) -> None:
    """Complex step through the conversion of a transfer function against central differences."""

    def build(zeta: Any) -> Any:
        block = TransferFunction("tf", 1.0, [100.0], [1.0, 20.0 * zeta, 100.0])
        return machine(block, core=core)

    study = jo.study(
        build, jo.Parameter("zeta", 0.3), ["last(tf.y)"], t_end=0.2, solver=jo.RK4(1e-3)
    )
    found = jo.design.gradient(study, [0.3], check=False)
    assert found.how == (("complex step",),)
    ends = [float(study([0.3 + sign * 1e-5])[0]) for sign in (1, -1)]
    assert found.jacobian[0, 0] == pytest.approx((ends[0] - ends[1]) / 2e-5, rel=1e-7)


WRONG = [
    (lambda: TransferFunction("t", 0.0, [1, 0, 0], [1, 1]), "degree 2 over .* degree 1.*filter it"),
    (lambda: TransferFunction("t", 0.0, [1], [0, 0]), "denominator of zeros"),
    (
        lambda: LinearSystem("l", 0.0, np.eye(2), np.ones((1, 1)), np.ones((1, 2))),
        r"B has shape \(1, 1\), must be \(2, 1\) for 2 states, 1 inputs and 1 outputs",
    ),
    (lambda: Saturation("s", 0.0, 1.0, -1.0), "lower is 1, must be below upper, -1"),
    (lambda: Saturation("s", 0.0), "has no limit"),
    (lambda: DeadBand("s", 0.0, 1.0, -1.0), "lower is 1"),
    (lambda: Adder("s", [1.0, 2.0], [1.0]), "2 inputs and 1 gains"),
    (lambda: Adder("s", []), "inputs is empty"),
    (lambda: Lag("s", 0.0, -1.0), "time"),
    (lambda: Lag("s", Lag("t", 0.0, 1.0), 1.0), r"take its output, block\['y'\]"),
    (lambda: Lag("s", "open('x')", 1.0), "input: .* not allowed"),
    (lambda: Integrator("s", 0.0, initial=2.0, upper=1.0), "initial is 2, beyond the limit of 1"),
    (lambda: PIDController("p", 0.0, 0.0), "kp, ki and kd are all 0"),
    (lambda: PIDController("p", 0.0, 0.0, kp=1.0, limit=0.0), "limit is 0, must be positive"),
    (lambda: PIDController("p", 0.0, 0.0, kp=1.0, limit=1.0, lower=2.0), "lower is 2"),
    (lambda: PIDController("p", 0.0, 0.0, ki=1.0, limit=1.0), "tracking is missing"),
    (lambda: PIDController("p", 0.0, 0.0, kd=1.0), "filter is missing"),
    (
        lambda: PIDController("p", 0.0, 0.0, kp=1.0, ki=1.0, actual=0.0, anti_windup="none"),
        "actual is given",
    ),
    (lambda: States.from_system("s", object(), 0.0), "neither A, B, C, D nor num, den"),
    (lambda: States.from_system("s", SYSTEMS[0]), "has 1 inputs, 0 are given"),
    (lambda: States.from_system("s", SYSTEMS[0], 0.0, initial=[1.0]), "3 states, 1 initial"),
    (
        lambda: States.from_system("s", SimpleNamespace(num=[1], den=[1, 1], dt=True), 0.0),
        "unknown period",
    ),
    (
        lambda: States.from_system(
            "s", SimpleNamespace(num=[[[1], [1]]], den=[[[1], [1]]], dt=0), 0.0
        ),
        "several inputs or outputs",
    ),
]


@pytest.mark.parametrize(("build", "message"), WRONG)
def test_what_is_wrong_is_named(build: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        build()


def test_an_algebraic_loop_of_blocks_is_named() -> None:
    blocks = [
        Adder("error", [1.0, "motor.y"], [1, -1]),
        Saturation("limited", "error.y", -1.0, 1.0),
        Adder("motor", ["limited.y", 1.0]),
    ]
    with pytest.raises(
        InputError, match=r"algebraic loop: .*error\.y.*a lag, an integrator or a delay"
    ):
        jo.compile(machine(*blocks))
    opened = [*blocks[:2], Lag("motor", "limited.y", 0.1)]
    assert run(machine(*opened), 0.1, jo.RK4(1e-3))["error.y"][-1, 0] < 1.0


def test_a_block_measures_the_machine() -> None:
    """A rate of a coordinate as an input: the lag of the speed of a cart that rolls out."""

    def lag(s: Any) -> Block:
        return Lag("lag", rate(s), 0.1)

    def filtered(s: Any) -> Any:
        return StateSensor("filtered", "lag.y")

    def start(s: Any) -> Any:
        return jo.Initial(s, rate=1.0)

    found = run(machine(lag, filtered, start), 1.0, jo.RK4(1e-3))
    wanted = (math.exp(-0.5) - math.exp(-10.0)) / (1 - 0.5 * 0.1)
    assert found["filtered"][-1, 0] == pytest.approx(wanted, abs=1e-9)
