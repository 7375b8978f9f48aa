"""Electric drives: closed forms, and numbers by DOP853 and Radau with located kinks."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

import jousto as jo
from jousto.base.errors import InputError
from jousto.electric import Brake, DCMotor, Gearbox, SynchronousMotor, ThermalLoad
from jousto.mechanism import (
    BlockForce,
    PIDController,
    States,
    StateSensor,
    rate,
    value,
)

CORES = ("joint", "maximal")
PRECISE = jo.simulation.DormandPrince(1e-11)
WORKS = ("supplied", "mechanical", "heat", "stored")


def hinge(name: str, inertia: float) -> Any:
    body = jo.RigidBody(name, 1.0, (inertia,) * 3)
    axis = (0, 0, 1)
    return body, jo.Revolute(f"{name} axle", jo.ground["origin"], body["origin"], axis=axis)


def works(block: Any) -> list[StateSensor]:
    return [StateSensor(name, block[f"{name}_work"], unit="J") for name in WORKS]


def closed(run: Any) -> float:
    """Energy that is missing in the book over that supplied."""
    supplied, *others = (run[name][-1, 0] for name in WORKS)
    return float(abs(supplied - sum(others)) / abs(supplied))


# -- DC motor ------------------------------------------------------------------------------------


def dc(core: str = "joint", inductance: float = 0.5e-3, ratio: float = 1.0) -> Any:
    """R 1, k 0.05, J 1e-4, b 1e-5 at 12 V; seen through a gear of a ratio, the same rotor."""
    body, joint = hinge("rotor", 1e-4 * ratio**2)
    motor = DCMotor("m", joint.angle, 12.0, 1.0, inductance, 0.05, ratio=ratio, book=True)
    damper = jo.Spring("air", joint.angle, damping=1e-5 * ratio**2)
    more = StateSensor("w", motor["speed"]), StateSensor("i", motor["current"], unit="A")
    return jo.Mechanism(body, joint, motor, damper, *more, *works(motor), core=core)


@pytest.mark.parametrize("core", CORES)
def test_poles_and_step_of_a_dc_motor(core: str) -> None:
    """Poles -1974.678135 and -25.42186450 1/s; the step is an exponential of a matrix."""
    model = jo.compile(dc(core))
    poles = np.linalg.eigvals(jo.simulation.linearise(model).A).real
    near = np.sort(poles[np.abs(poles) > 1.0])
    assert near == pytest.approx([-1974.678135, -25.42186450], rel=1e-9)
    run = jo.simulate(model, 0.1, solver=PRECISE, output_step=0.05)
    A = np.array([[-1 / 0.5e-3, -0.05 / 0.5e-3, 12 / 0.5e-3], [500.0, -0.1, 0.0], [0, 0, 0]])
    for k, t in enumerate(run.time):
        i, w, _ = expm(A * t) @ [0, 0, 1]
        assert run["i"][k, 0] == pytest.approx(i, abs=1e-9)
        assert run["w"][k, 0] == pytest.approx(w, abs=1e-7)
    assert closed(run) < 1e-12


def test_a_dc_motor_without_inductance_is_a_lag() -> None:
    run = jo.simulate(jo.compile(dc(inductance=0.0)), 0.1, solver=jo.RK4(1e-4))
    fall = (0.05**2 + 1e-5) / 1e-4
    wanted = 12 * 0.05 / 1e-4 / fall * (1 - math.exp(-fall * 0.1))
    assert run["w"][-1, 0] == pytest.approx(wanted, rel=1e-10)
    assert closed(run) < 1e-12


@pytest.mark.parametrize("solver", [jo.ROS2(1e-4), jo.GeneralizedAlpha(1e-4)])
def test_a_rigid_gear_of_a_motor_reflects_the_load(solver: Any) -> None:
    one, other = (
        jo.simulate(jo.compile(dc(ratio=ratio)), 0.05, solver=solver) for ratio in (1.0, -7.0)
    )
    assert np.abs(one["i"] - other["i"]).max() < 1e-9
    assert np.abs(one["w"] - other["w"]).max() < 1e-7
    assert one["i"].max() > 5.0


def test_equilibrium_of_a_dc_motor_holds_a_pendulum() -> None:
    """The angle at which the weight takes the torque k u/R."""
    arm = jo.RigidBody("arm", 1.0, (0.1, 0.1, 0.1), center=(0, -0.1, 0))
    joint = jo.Revolute("joint", jo.ground["origin"], arm["origin"], axis=(0, 0, 1))
    motor = DCMotor("m", joint.angle, 12.0, 1.0, 1e-3, 0.05)
    sensors = jo.CoordinateSensor("q", joint.angle), StateSensor("i", motor["current"])
    model = jo.compile(jo.Mechanism(arm, joint, motor, jo.Gravity((0, -9.81, 0)), *sensors))
    rest = jo.simulate(model, 1e-4, state=jo.equilibrium(model), solver=jo.RK4(1e-4))
    assert math.sin(rest["q"][0, 0]) == pytest.approx(0.6 / 0.981, rel=1e-8)
    assert rest["i"][0, 0] == pytest.approx(12.0, rel=1e-8)


# -- synchronous motor ---------------------------------------------------------------------------

KT = 1.5 * 4 * 0.08
PLATE = (0.5, 2e-3, 3e-3, 0.08, 4)  # R, Ld, Lq, flux, pole pairs
BAND = 2 * math.pi * 200


def servo(core: str = "joint", **options: Any) -> Any:
    """J 2e-3, b 1e-4, 1 N m of load; speed PI of 50 J/kt, Ti 0.08 s, 20 A; step to 200 rad/s."""
    body, joint = hinge("rotor", 2e-3)
    kp = 50 * 2e-3 / KT
    gains = {"kp": kp, "ki": kp / 0.08, "limit": 20.0, "tracking": 0.9 * 0.08}
    control = PIDController("pid", 200.0, rate(joint.angle), **gains)
    motor = SynchronousMotor(
        *("m", joint.angle, *PLATE),
        **{"current": control["u"], "current_d": 0.0, "bandwidth": BAND, "book": True} | options,
    )
    air = jo.Spring("air", joint.angle, damping=1e-4)
    load = jo.JointForce("load", joint.angle, -1.0)
    sensors = (
        jo.RateSensor("w", joint.angle),
        *(StateSensor(name, motor[name]) for name in ("iq", "id", "vd", "vq", "wanted_d")),
        StateSensor("unlimited", control["unlimited"]),
    )
    parts = body, joint, control, motor, air, load
    return jo.Mechanism(*parts, *sensors, *works(motor), core=core)


def test_speed_control_of_a_synchronous_motor() -> None:
    """82.1409616691, 189.128074062 rad/s, 1.71914386265 A; leaves its limit at .0320315495885 s."""
    run = jo.simulate(jo.compile(servo()), 0.2, solver=PRECISE, output_step=1e-3)
    assert run["w"][20, 0] == pytest.approx(82.1409616691, abs=1e-9)
    assert run["w"][50, 0] == pytest.approx(189.128074062, abs=1e-8)
    assert run["iq"][-1, 0] == pytest.approx(1.71914386265, abs=1e-10)
    after = run["unlimited"][33:37, 0] - 20.0  # a polynomial behind the kink
    before = run["unlimited"][28:33, 0] - 20.0
    c = np.polyfit(run.time[28:33], before, 4)
    ends = [x.real for x in np.roots(c) if abs(x.imag) < 1e-9 and 0.03 < x.real < 0.034]
    assert after.max() < 0.0 < before.min()
    assert ends == pytest.approx([0.0320315495885], abs=1e-7)
    assert closed(run) < 1e-12


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("solver", [jo.RK4, jo.ROS2, jo.GeneralizedAlpha])
def test_methods_have_their_order(core: str, solver: Any) -> None:
    """Until the limit is left the equations are smooth: errors fall by 16 or 4 with half a step."""
    rough, fine = (
        abs(
            jo.simulate(jo.compile(servo(core)), 0.016, solver=solver(h), output_step=0.016)["iq"][
                1, 0
            ]
            - 20.0 * (1.0 - math.exp(-BAND * 0.016))
        )
        for h in (2e-4, 1e-4)
    )
    order = 4 if solver is jo.RK4 else 2
    assert math.log2(rough / fine) == pytest.approx(order, abs=0.25) or rough < 1e-7


def test_a_current_follows_by_a_lag_and_ideal_currents_do_so_too() -> None:
    first, second = (
        jo.simulate(jo.compile(servo(**more)), 0.02, solver=jo.RK4(2e-5), output_step=1e-3)
        for more in ({}, {"ideal": True})
    )
    lag = 20.0 * (1.0 - np.exp(-BAND * first.time))
    for run in (first, second):
        assert np.abs(run["iq"][:, 0] - lag).max() < 1e-6
        assert np.abs(run["id"]).max() < 1e-9
    assert np.abs(first["vq"][1:] - second["vq"][1:]).max() < 1e-4


def test_voltages_stay_within_their_circle() -> None:
    """At 60 V of the phases the motor does not reach 200 rad/s without weakening."""
    model = jo.compile(servo(dc_voltage=60 * math.sqrt(3.0)))
    run = jo.simulate(model, 0.2, solver=jo.ROS2(1e-4))
    size = np.hypot(run["vd"], run["vq"])
    assert size.max() == pytest.approx(60.0, rel=1e-9)
    assert run["w"].max() < 190.0
    assert closed(run) < 1e-9
    more = {"current_d": None, "largest_current": 20.0, "weakening": True}
    weak = jo.compile(servo(dc_voltage=60 * math.sqrt(3.0), **more))
    run = jo.simulate(weak, 0.4, solver=jo.ROS2(2e-4))
    assert run["w"][-1, 0] == pytest.approx(200.0, abs=0.2)
    assert run["id"][-1, 0] < -3.0
    assert np.hypot(run["vd"], run["vq"])[-1, 0] < 60.0


WEAK = {"dc_voltage": 60 * math.sqrt(3.0), "largest_current": 20.0, "weakening": True}
LEAST = {"strategy": "least-current", "largest_current": 20.0}


@pytest.mark.parametrize(
    ("speed", "current", "options", "d", "q"),
    [
        (149.9, 30.0, WEAK, 0.0, 20.0),  # base speed 150 rad/s
        (250.0, 30.0, WEAK, -16.0, 12.0),
        (-250.0, -30.0, WEAK, -16.0, -12.0),
        (374.9, 30.0, WEAK, -19.998, 0.256),  # top speed 375 rad/s
        (376.0, 30.0, WEAK, -20.0, 0.0),
        # less torque needs less of the field: psi + Ld id = sqrt(.06^2 - (Lq)^2)
        (250.0, 1.0, WEAK, (math.sqrt(0.06**2 - 0.003**2) - 0.08) / 2e-3, 1.0),
        # (psi - sqrt(psi^2 + 8 (Lq - Ld)^2 I^2)) / (4 (Lq - Ld))
        (1.0, 30.0, LEAST, -4.49489742783, math.sqrt(400 - 4.49489742783**2)),
    ],
)
def test_wanted_currents(speed: float, current: float, options: Any, d: float, q: float) -> None:
    """Circle of the current and ellipse of the voltage, 60 V without resistance."""
    body, joint = hinge("rotor", 1e6)
    motor = SynchronousMotor(
        *("m", joint.angle, *PLATE),
        current=current, bandwidth=BAND, ideal=True, reserve=0.0, **options,
    )  # fmt: skip
    names = ("wanted_d", "wanted_q", "torque")
    sensors = [StateSensor(name, motor[name]) for name in names]
    start = jo.Initial(joint.angle, rate=speed)
    model = jo.compile(jo.Mechanism(body, joint, motor, start, *sensors))
    run = jo.simulate(model, 0.03, solver=jo.RK4(1e-4))
    near = 1e-3 if abs(d + 19.998) < 1e-9 else 1e-6
    assert run["wanted_d"][-1, 0] == pytest.approx(d, abs=near)
    assert run["wanted_q"][-1, 0] == pytest.approx(q, abs=near)
    torque = 1.5 * 4 * (0.08 * q + (2e-3 - 3e-3) * d * q)
    assert run["torque"][-1, 0] == pytest.approx(torque, abs=6 * 0.1 * near)
    if options is LEAST:
        assert run["torque"][-1, 0] == pytest.approx(9.87999825458, abs=1e-6)


def test_voltages_of_the_user_drive_the_windings() -> None:
    """A held rotor: both currents rise like in a coil, v/R (1 - exp(-R t/L))."""
    body, joint = hinge("rotor", 1e9)
    options: dict[str, Any] = {"voltage_d": 1.0, "voltage_q": 2.0, "book": True}
    motor = SynchronousMotor("m", joint.angle, *PLATE, **options)
    sensors = [StateSensor(name, motor[name]) for name in ("id", "iq")]
    model = jo.compile(jo.Mechanism(body, joint, motor, *sensors, *works(motor)))
    run = jo.simulate(model, 0.01, solver=jo.RK4(1e-5))
    assert run["id"][-1, 0] == pytest.approx(2.0 * (1 - math.exp(-0.01 * 0.5 / 2e-3)), rel=1e-6)
    assert run["iq"][-1, 0] == pytest.approx(4.0 * (1 - math.exp(-0.01 * 0.5 / 3e-3)), rel=1e-6)
    assert closed(run) < 1e-12


# -- gear ----------------------------------------------------------------------------------------


def winch(torque: float, core: str = "joint", **options: Any) -> Any:
    """Rotor 1e-3 kg m2, N 20, efficiency .8 and .7, drum of .1 m with 100 kg on its rope."""
    rotor, motor = hinge("rotor", 1e-3)
    drum, axle = hinge("drum", 100 * 0.1**2)
    losses = {"efficiency": 0.8, "back_efficiency": 0.7, "book": True} | options
    gear = Gearbox("gear", motor.angle, axle.angle, 20.0, 2e6, 2e3, **losses)
    drive = jo.JointForce("drive", motor.angle, torque)
    load = jo.JointForce("load", axle.angle, -98.1)
    sensors = jo.RateSensor("w", axle.angle), StateSensor("heat rate", gear["heat_power"])
    parts = rotor, drum, motor, axle, gear, drive, load
    return jo.Mechanism(*parts, *sensors, *works(gear), core=core)


SOLVERS = [
    jo.RK4(4e-5),
    jo.ROS2(1e-3),
    jo.GeneralizedAlpha(1e-3),
    jo.simulation.DormandPrince(1e-8),
]


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("solver", SOLVERS, ids=lambda s: type(s).__name__)
def test_a_gear_with_losses_lifts(core: str, solver: Any) -> None:
    """(N eta T - m g r) / (m r^2 + eta J N^2) r = 2.26515151515 m/s2 at 8 N m."""
    run = jo.simulate(jo.compile(winch(8.0, core)), 0.2, solver=solver, output_step=0.1)
    assert run["w"][2, 0] - run["w"][1, 0] == pytest.approx(2.26515151515, abs=1e-8)
    assert closed(run) < 1e-3  # the book of powers is exact, its integrals have the method's error
    assert (run["heat rate"] >= 0.0).all()


@pytest.mark.filterwarnings("ignore:.*energy balance")
@pytest.mark.parametrize(
    ("torque", "moves"), [(6.14, 1), (6.12, 0), (5.0, 0), (3.44, 0), (3.42, -1), (0.0, -1)]
)
def test_a_gear_with_losses_holds_between_two_torques(torque: float, moves: int) -> None:
    """It lifts above m g r/(N eta) = 6.13125, and holds above m g r eta_b/N = 3.4335 N m."""
    run = jo.simulate(jo.compile(winch(torque)), 0.5, solver=jo.ROS2(1e-3), output_step=0.1)
    share = 16.0 if moves > 0 else 20.0 / 0.7
    wanted = moves and (torque * share - 98.1) / (1.0 + 0.4 * share / 20.0)
    gained = run["w"][-1, 0] - run["w"][-2, 0]
    assert gained == pytest.approx(0.1 * wanted, abs=1e-6)
    if not moves:
        assert abs(run["w"][-1, 0]) < 1e-9


@pytest.mark.filterwarnings("ignore:.*energy balance")
def test_a_self_locking_gear_holds_without_torque() -> None:
    locked = winch(0.0, back_efficiency=-0.1)
    run = jo.simulate(jo.compile(locked), 0.5, solver=jo.ROS2(1e-3), output_step=0.1)
    assert abs(run["w"][-1, 0]) < 1e-9
    back = winch(-1.0, back_efficiency=-0.1)  # -m g r .1/N = -.4905 N m lowers it
    run = jo.simulate(jo.compile(back), 0.5, solver=jo.ROS2(1e-3), output_step=0.1)
    assert run["w"][-1, 0] < -1.0


def hunting(core: str = "joint") -> Any:
    """J .01 and .05 (.02 N m s), backlash .02; u = -6 q2 + 30 z - .5 q1', z' = -q2."""
    rotor, motor = hinge("rotor", 0.01)
    load, axle = hinge("load", 0.05)
    gear = Gearbox("gear", motor.angle, axle.angle, 1.0, 500.0, 5.0, backlash=0.02)
    control = States(
        "control",
        {"z": 0.0},
        {"z": "-q"},
        inputs={"q": value(axle.angle), "w": rate(motor.angle)},
        outputs={"u": "-6*q + 30*z - 0.5*w"},
    )
    parts = (
        *(rotor, load, motor, axle, gear, control),
        BlockForce("drive", motor.angle, control["u"]),
        jo.Spring("air", axle.angle, damping=0.02),
        jo.Initial(motor.angle, value=0.05),
        jo.Initial(axle.angle, value=0.04),
        jo.CoordinateSensor("q2", axle.angle),
        jo.RateSensor("w1", motor.angle),
        StateSensor("windup", gear["windup"]),
        StateSensor("side", gear["side"]),
    )
    return jo.Mechanism(*parts, core=core)


def touches(run: Any) -> Any:
    """Times, q2 and q1' of touches ahead: polynomials through the six samples before them."""
    side = run["side"][:, 0]
    found = []
    for k in np.flatnonzero((side[1:] > 0.5) & (side[:-1] < 0.5)) - 5:
        t = run.time[k] + 1e-3 * np.arange(6)
        rows = slice(k, k + 6)
        c = np.polynomial.Polynomial.fit(t, run["windup"][rows, 0] - 0.01, 5)
        at = min((z.real for z in c.roots() if abs(z.imag) < 1e-6), key=lambda z: abs(z - t[-1]))
        read = (np.polynomial.Polynomial.fit(t, run[x][rows, 0], 5)(at) for x in ("q2", "w1"))
        found.append((at, *read))
    return np.array(found)


@pytest.mark.parametrize("core", CORES)
def test_a_gear_with_backlash_ends_in_a_limit_cycle(core: str) -> None:
    """Cycle of .675277793768 s; at each touch q2 -.0283676055562 and q1' .12952774902 rad/s."""
    model = jo.compile(hunting(core))
    run = jo.simulate(model, 20.0, solver=jo.RK4(5e-4), output_step=1e-3)
    found = touches(run)
    assert found[-1, 0] - found[-2, 0] == pytest.approx(0.675277793768, abs=1e-8)
    assert found[-1, 1] == pytest.approx(-0.0283676055562, abs=1e-9)
    assert found[-1, 2] == pytest.approx(0.12952774902, abs=1e-7)


@pytest.mark.parametrize("solver", [jo.ROS2, jo.GeneralizedAlpha], ids=lambda s: s.__name__)
def test_touches_of_teeth_are_located_by_all_methods(solver: Any) -> None:
    """Errors fall by four with half a step: no step passes over a touch or a parting."""
    exact = jo.simulate(jo.compile(hunting()), 1.0, solver=jo.RK4(1e-4), output_step=0.5)
    errors = []
    for h in (4e-4, 2e-4):
        run = jo.simulate(jo.compile(hunting()), 1.0, solver=solver(h), output_step=0.5)
        errors.append(np.abs(run["q2"] - exact["q2"]).max())
    assert errors[0] / errors[1] > 3.0
    assert errors[1] < 1e-5


# -- brake and thermal load ----------------------------------------------------------------------


def braked(core: str = "joint", load: Any = 3.0, speed: float = 150.0, **options: Any) -> Any:
    body, joint = hinge("drum", 0.05)
    brake = Brake("brake", joint.angle, 12.0, 1e6, **{"damping": 30.0} | options)
    parts = (
        *(body, joint, brake, jo.JointForce("load", joint.angle, load)),
        jo.Initial(joint.angle, rate=speed),
        jo.CoordinateSensor("q", joint.angle),
        jo.RateSensor("w", joint.angle),
        StateSensor("torque", brake["torque"]),
        StateSensor("heat", brake["heat_power"]),
    )
    return jo.Mechanism(*parts, core=core)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("solver", SOLVERS, ids=lambda s: type(s).__name__)
def test_a_brake_stops_and_holds(core: str, solver: Any) -> None:
    """12 N m against 3, .05 kg m2, 150 rad/s: .833333333333 s, 62.5 rad; then it does not creep."""
    model = jo.compile(braked(core))
    run = jo.simulate(model, 2.0, solver=solver, output_step=1 / 12)
    before, at, late = run["w"][9, 0], run["q"][10, 0], run["q"][-1, 0]
    assert before == pytest.approx(180.0 / 12, abs=1e-6)
    assert at == pytest.approx(62.5, abs=1e-8)
    assert late == pytest.approx(62.5 - 9e-6, abs=5e-7)  # 12 - 3 N m less on the stiffness
    assert abs(run["q"][-1, 0] - run["q"][-3, 0]) < 5e-7
    assert run["torque"][-1, 0] == pytest.approx(-3.0, abs=0.05)


@pytest.mark.filterwarnings("ignore:.*energy balance")
@pytest.mark.parametrize(("load", "holds"), [(14.9, True), (15.1, False), (-14.9, True)])
def test_a_sticking_brake_holds_its_static_torque(load: float, holds: bool) -> None:
    """Static 15 N m, 12 N m when slipping; the load grows slowly."""
    made = braked(load=jo.Ramp(0.0, 0.5) * load, speed=0.0, static=15.0, damping=100.0)
    run = jo.simulate(jo.compile(made), 1.0, solver=jo.ROS2(1e-3), output_step=0.1)
    if holds:
        assert abs(run["q"][-1, 0]) == pytest.approx(abs(load) / 1e6, rel=1e-6)
    else:
        assert run["w"][-1, 0] - run["w"][-2, 0] == pytest.approx(0.1 * 3.1 / 0.05, rel=1e-6)
        assert run["torque"][-1, 0] == pytest.approx(-12.0, rel=1e-12)
        slips = 0.5 * 15.0 / 15.1  # s; until 0.5 s the load grows
        gained = (0.5 * (15.0 + 15.1) - 12.0) * (0.5 - slips) + 3.1 * 0.5
        assert run["w"][-1, 0] == pytest.approx(gained / 0.05, abs=2e-3)


def test_a_brake_closes_with_its_lag() -> None:
    """c = 1 - exp(-t/.05): the speed by its integral."""
    made = braked(load=0.0, speed=100.0, release=0.0, lag=0.05, closed=0.0)
    run = jo.simulate(jo.compile(made), 0.2, solver=jo.RK4(1e-3), output_step=0.1)
    work = 12.0 / 0.05 * (0.2 - 0.05 * (1 - math.exp(-0.2 / 0.05)))
    assert run["w"][-1, 0] == pytest.approx(100.0 - work, abs=1e-6)
    released = braked(load=1.0, speed=0.0, release=1.0, lag=0.05, closed=0.0)
    run = jo.simulate(jo.compile(released), 0.2, solver=jo.RK4(1e-3), output_step=0.1)
    assert run["w"][-1, 0] == pytest.approx(0.2 / 0.05, abs=1e-9)
    assert (run["heat"] >= 0.0).all()


def test_a_thermal_load_trips() -> None:
    """60 s, twice the rated current, from cold: 60 ln(4/3) = 17.2609243471 s."""
    body, joint = hinge("rotor", 1.0)
    load = ThermalLoad("load", 8.0, 4.0, 60.0, largest=12.0, reduced_from=0.5, trips=True)
    names = ("load", "tripped", "limit")
    sensors = [StateSensor(name, load[name]) for name in names]
    trip = jo.mechanism.Event("trip", sensors[0], 1.0)
    watch = States("watch", {"time": 0.0}, {"time": load["tripped"]})
    since = StateSensor("since", watch["time"], unit="s")
    parts = body, joint, load, watch, *sensors, since
    alone = jo.simulate(jo.compile(jo.Mechanism(*parts)), 20.0, solver=jo.RK4(0.1))
    assert alone["since"][-1, 0] == pytest.approx(20.0 - 17.2609243471, abs=1e-8)
    run = jo.simulate(
        jo.compile(jo.Mechanism(*parts, trip)), 20.0, solver=jo.RK4(0.1), output_step=0.1
    )
    (event,) = (one for one in run.events if one.name == "trip")
    assert event.time == pytest.approx(17.2609243471, abs=1e-8)
    assert run["tripped"][172, 0] == 0.0
    assert run["tripped"][173, 0] == 1.0
    th = 4.0 * (1.0 - math.exp(-12.0 / 60.0))
    limit = math.sqrt(16.0 + (144.0 - 16.0) * (1.0 - th) / 0.5)
    assert run["limit"][0, 0] == pytest.approx(12.0)
    assert run["limit"][120, 0] == pytest.approx(limit, rel=1e-6)
    assert run["limit"][-1, 0] == pytest.approx(4.0)


def test_equilibrium_with_a_brake_is_refused_with_a_remedy() -> None:
    with pytest.raises(InputError, match="brake"):
        jo.equilibrium(jo.compile(braked(speed=0.0)))
