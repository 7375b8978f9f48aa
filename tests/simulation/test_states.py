"""States x' = f with their forces: closed forms and independent integrations, order, both cores.

The digits of the hydraulic machines are those on which integrations by DOP853 and by Radau of the
equations of each machine, written out in minimal coordinates, agree.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

import jousto as jo
from jousto.base.errors import InputError, SimulationError
from jousto.mechanism import States, StateSensor, rate, sqrt, time, value, where
from jousto.mechanism.joints.coordinate import Distance

CORES = ("joint", "maximal")
PISTON, ROD = math.pi * 0.05**2 / 4, math.pi * (0.05**2 - 0.036**2) / 4  # m2, 50/36 mm
VALVE = 3.5634832255e-7  # m3/s/sqrt(Pa): 40 l/min at 3.5 MPa


def motor(core: str, volts: Any = 12.0) -> jo.Mechanism:
    """DC motor: R 1 ohm, L 0.5 mH, k 0.05, J 1e-4 kg m2, b 1e-5 N m s."""
    wheel = jo.RigidBody("wheel", 1.0, (1e-4, 1e-4, 1e-4))
    axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"], axis=(0, 0, 1))
    winding = States(
        "winding",
        {"i": 0.0},
        {"i": "(u - 1.0*i - 0.05*w)/0.5e-3"},
        inputs={"u": volts, "w": rate(axle.angle)},
        outputs={"torque": "0.05*i"},
        forces={axle.angle: "0.05*i"},
    )
    sensors = (
        jo.RateSensor("w", axle.angle),
        StateSensor("i", winding["i"], unit="A"),
        StateSensor("torque", "winding.torque", unit="N m"),
    )
    return jo.Mechanism(
        wheel, axle, jo.Spring("oil", axle.angle, damping=1e-5), winding, *sensors, core=core
    )


MOTOR = np.array([[-1 / 0.5e-3, -0.05 / 0.5e-3], [0.05 / 1e-4, -1e-5 / 1e-4]])


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize(("method", "order"), [("RK4", 4), ("ROS2", 2), ("GeneralizedAlpha", 2)])
def test_order_of_a_motor(core: str, method: str, order: int) -> None:
    exact = np.linalg.solve(MOTOR, (expm(MOTOR * 0.02) - np.eye(2)) @ [12 / 0.5e-3, 0.0])
    model, errors = jo.compile(motor(core)), []
    for step in (4e-4, 2e-4, 1e-4):
        run = jo.simulate(model, 0.02, solver=getattr(jo, method)(step))
        errors.append([run["i"][-1, 0] - exact[0], run["w"][-1, 0] - exact[1]])
        assert run["torque"][-1, 0] == pytest.approx(0.05 * run["i"][-1, 0], rel=1e-14)
    assert np.log2(errors[1][1] / errors[2][1]) == pytest.approx(order, abs=0.02)
    assert abs(errors[2][0]) < 1e-5


@pytest.mark.parametrize("core", CORES)
def test_poles_of_a_motor(core: str) -> None:
    found = np.sort(np.linalg.eigvals(jo.simulation.linearise(jo.compile(motor(core))).A).real)
    # characteristic polynomial: L J s^2 + (R J + L b) s + R b + k^2
    exact = np.roots([0.5e-3 * 1e-4, 1e-4 + 0.5e-3 * 1e-5, 1e-5 + 0.05**2])
    assert found[:2] == pytest.approx(np.sort(exact), rel=1e-12)
    assert found[:2] == pytest.approx([-1974.678135, -25.42186450], rel=1e-9)


def test_many_and_few_forces_agree() -> None:
    """A stiff force is in Newton's matrix, or corrects accelerations where forces are few: 9 or 1.

    Two bodies with a coordinate that both move in, in a loop of joints; the difference is that of
    the two forms of the second stage, of order 2.
    """
    bodies = [jo.RigidBody(n, 1.0 + i, (1, 1, 2), position=(i, 0, 0)) for i, n in enumerate("ab")]
    turn = jo.Revolute("turn", jo.ground["origin"], bodies[0]["origin"], axis=(0, 0, 1))
    slide = jo.Revolute("elbow", bodies[0].at((0.5, 0, 0)), bodies[1].at((-0.5, 0, 0)),
                        axis=(0, 0, 1))  # fmt: skip
    way = Distance(jo.ground.at((0.2, -1, 0)), bodies[1].at((0.4, 0.1, 0)))
    ends = {}
    for count in (1, 9):
        lags = [
            States(
                f"lag{i}",
                {"F": 0.0},
                {"F": f"({3000 / count}*(1 - s) - F)/1e-5"},
                inputs={"s": value(way)},
                forces={way: "F"},
            )
            for i in range(count)
        ]
        place = jo.CoordinateSensor("s", way)
        model = jo.compile(
            jo.Mechanism(*bodies, turn, slide, *lags, place, jo.Gravity((0, -9.81, 0))),
            core="maximal",
        )
        ends[count] = [
            jo.simulate(model, 0.05, solver=jo.ROS2(h))["s"][-1, 0] for h in (1e-3, 5e-4, 2.5e-4)
        ]
    differences = np.abs(np.subtract(ends[1], ends[9]))
    assert 0.0 < differences[1] < differences[0] / 3.5
    assert differences[2] < differences[1] / 3.5
    assert differences[2] < 1e-6


def test_stiff_states_do_not_limit_the_step_of_implicit_methods() -> None:
    """Lag of 1 us: the time constant is 1e-3 of a step; RK4 diverges with this step."""
    body = jo.RigidBody("cart", 1.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    lag = States(
        "lag",
        {"F": 0.0},
        {"F": "(-100*x - F)/1e-6"},
        inputs={"x": value(rail.displacement)},
        forces={rail.displacement: "F"},
    )
    start = jo.Initial(rail.displacement, value=0.1)
    x = jo.CoordinateSensor("x", rail.displacement)
    model = jo.compile(jo.Mechanism(body, rail, lag, start, x))
    for solver in (jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)):
        run = jo.simulate(model, 0.5, solver=solver)
        assert run["x"][-1, 0] == pytest.approx(0.1 * math.cos(5.0), abs=2e-5)
    with pytest.raises(SimulationError):
        jo.simulate(model, 0.5, solver=jo.RK4(1e-3))


def edge(dp: Any) -> Any:
    """Flow over a smooth edge over its coefficient, transition at 1e4 Pa."""
    return dp / sqrt(sqrt(dp * dp + 1e8))


def cylinder(core: str, apart: bool) -> jo.Mechanism:
    """Cylinder 50/36 mm that drives 200 kg against 10 kN through a valve that opens in 0.05 s."""
    block = jo.RigidBody("block", 200.0, (1, 1, 1), position=(0.6, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    line = Distance(jo.ground["origin"], block["origin"]) if apart else rail.displacement
    offset = 0.5 if apart else rail.displacement.initial - 0.1

    def oil(x: Any, u: Any) -> Any:
        opening = where(0.05 - time, time / 0.05, 1.0)
        q1, q2 = VALVE * opening * edge(16e6 - x["p1"]), -VALVE * opening * edge(x["p2"])
        v1, v2 = 1e-4 + PISTON * u["x"], 1e-4 + ROD * (0.5 - u["x"])
        rates = {
            "p1": 1.2e9 / v1 * (q1 - PISTON * u["v"]),
            "p2": 1.2e9 / v2 * (q2 + ROD * u["v"]),
        }
        return rates, {}, {line: PISTON * x["p1"] - ROD * x["p2"] - 10e3 - 2000.0 * u["v"]}

    start = {"p1": (ROD * 1e6 + 10e3) / PISTON, "p2": 1e6}
    inputs = {"x": value(line) - offset, "v": rate(line)}
    system = States.from_rule("oil", oil, start, inputs, dict.fromkeys(start, 1e6))
    sensors = StateSensor("x", value(line) - offset), StateSensor("p1", system["p1"], unit="Pa")
    return jo.Mechanism(block, rail, system, *sensors, core=core)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("apart", [False, True])
def test_hydraulic_cylinder(core: str, apart: bool) -> None:
    """0.1407638687 m and 6699598.317 Pa after 0.1 s, by two integrations of five equations."""
    model, errors = jo.compile(cylinder(core, apart)), []
    run = jo.simulate(model, 0.1, solver=jo.RK4(5e-5))
    assert run["x"][-1, 0] == pytest.approx(0.1407638687, abs=1e-10)
    assert run["p1"][-1, 0] == pytest.approx(6699598.317, abs=1e-3)
    for method in (jo.ROS2, jo.GeneralizedAlpha):
        errors = [
            jo.simulate(model, 0.1, solver=method(step))["p1"][-1, 0] - 6699598.317
            for step in (1e-4, 5e-5)
        ]
        assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.01)


def four_bar(core: str) -> jo.Mechanism:
    """Four-bar linkage whose crank a cylinder turns; the closed loop is spatially exact."""
    turn = np.radians(120)
    crank_end, pivot = np.array([0.5 * np.cos(turn), 0.5 * np.sin(turn), 0]), np.array([2.5, 0, 0])
    gap = pivot - crank_end
    along = (4 - 1.25**2 + gap @ gap) / (2 * np.linalg.norm(gap))
    e = gap / np.linalg.norm(gap)
    top = crank_end + along * e + math.sqrt(4 - along**2) * np.array([-e[1], e[0], 0])

    def rod(name: str, p: Any, q: Any, mass: float) -> jo.RigidBody:
        length = float(np.linalg.norm(q - p))
        half = math.atan2(q[1] - p[1], q[0] - p[0]) / 2
        inertia = mass * length**2 / 12
        return jo.RigidBody(
            name,
            mass,
            (1e-6 + 0 * inertia, inertia, inertia),
            position=(p + q) / 2,
            orientation=(math.cos(half), 0, 0, math.sin(half)),
            markers={"p": (-length / 2, 0, 0), "q": (length / 2, 0, 0)},
        )

    origin = np.zeros(3)
    crank, coupler, rocker = (
        rod("crank", origin, crank_end, 10.0),
        rod("coupler", crank_end, top, 40.0),
        rod("rocker", pivot, top, 25.0),
    )
    ends = (
        ("A", jo.ground.at(origin), crank["p"]),
        ("B", crank["q"], coupler["p"]),
        ("C", coupler["q"], rocker["q"]),
        ("D", jo.ground.at(pivot), rocker["p"]),
    )
    joints = [jo.Revolute(name, a, b, axis=(0, 0, 1)) for name, a, b in ends]
    line = Distance(jo.ground.at((-0.9, 0, 0)), crank["q"], name="cylinder")

    def oil(x: Any, u: Any) -> Any:
        closing = where(0.5 - time, 0.4 - (time - 0.4) * 4, 0.0)
        opening = where(0.1 - time, 4 * time, where(0.4 - time, 0.4, closing))
        q1, q2 = VALVE * opening * edge(10e6 - x["p1"]), -VALVE * opening * edge(x["p2"])
        v1, v2 = 1e-4 + PISTON * u["x"], 1e-4 + ROD * (0.6 - u["x"])
        rates = {
            "p1": 1.5e9 / v1 * (q1 - PISTON * u["v"]),
            "p2": 1.5e9 / v2 * (q2 + ROD * u["v"]),
            "work": 10e6 * q1,
            "heat": q1 * (10e6 - x["p1"]) - q2 * x["p2"],
        }
        return rates, {}, {line: PISTON * x["p1"] - ROD * x["p2"] - 1000.0 * u["v"]}

    start = {"p1": 1139936.031, "p2": 2e6, "work": 0.0, "heat": 0.0}
    inputs = {"x": value(line) - 0.7, "v": rate(line)}
    sizes = {"p1": 1e6, "p2": 1e6, "work": 1e3, "heat": 1e3}
    system = States.from_rule("oil", oil, start, inputs, sizes)
    sensors: list[Any] = [StateSensor(name, system[name]) for name in start]
    sensors += [
        jo.CoordinateSensor("angle", joints[0].angle),
        jo.RateSensor("speed", joints[0].angle),
    ]
    gravity = jo.Gravity((0, -9.81, 0))
    return jo.Mechanism(crank, coupler, rocker, *joints, gravity, system, *sensors, core=core)


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
@pytest.mark.parametrize("core", ["auto", "maximal"])
def test_four_bar_moved_by_oil(core: str) -> None:
    model = jo.compile(four_bar(core))
    run = jo.simulate(model, 0.6, solver=jo.RK4(1e-4), output_step=0.1)
    turned = 120 + np.degrees(run["angle"][3, 0] - run["angle"][0, 0])
    assert turned == pytest.approx(113.809014175, abs=1e-9)
    assert run["speed"][3, 0] == pytest.approx(-0.435426544855, abs=1e-11)
    assert run["p2"][3, 0] == pytest.approx(2030073.92409, abs=1e-5)
    assert run["p1"][-1, 0] == pytest.approx(1156479.15369, abs=0.1)
    assert run["work"][-1, 0] == pytest.approx(1687.32560716, abs=1e-8)
    assert run["heat"][-1, 0] == pytest.approx(1642.7875148, abs=1e-8)
    for method in (jo.ROS2, jo.GeneralizedAlpha):
        coarse, fine = (
            jo.simulate(model, 0.3, solver=method(step), output_step=0.3) for step in (5e-4, 2.5e-4)
        )
        errors = [
            120 + np.degrees(x["angle"][-1, 0] - x["angle"][0, 0]) - 113.809014175
            for x in (coarse, fine)
        ]
        assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.05)


PISTON_63, ROD_63 = math.pi * 0.063**2 / 4, math.pi * (0.063**2 - 0.036**2) / 4


def lowering(core: str, pilot: float = 0.5) -> jo.Mechanism:
    """A load of 20 kN is lowered through a counterbalance valve; two blocks in a loop of names."""
    body = jo.RigidBody("load", 2000.0, (1, 1, 1), position=(0.3, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    s = rail.displacement
    a1, a2, kv = PISTON_63, ROD_63, 60e-3 / 60 / math.sqrt(3e6)
    oil = States(
        "oil",
        {"p1": (20e3 + a2 * 2e6) / a1, "p2": 2e6},
        {
            "p1": f"1.2e9/(1e-4 + {a1}*x)*(-q1 - {a1}*v)",
            "p2": f"1.2e9/(1e-4 + {a2}*(0.4 - x))*(q + {a2}*v)",
        },
        inputs={
            "x": value(s) - (s.initial - 0.3),
            "v": rate(s),
            "q": jo.Ramp(0, 0.2) * (20e-3 / 60),
            "q1": "valve.q",
        },
        outputs={"z": f"(p1 + {pilot}*p2 - 9e6)/2e6"},
        forces={s: f"{a1}*p1 - {a2}*p2 - 20e3 - 2e4*v"},
        sizes={"p1": 1e6, "p2": 1e6},
    )
    valve = States(
        "valve",
        {},
        {},
        inputs={"p1": "oil.p1", "z": "oil.z"},
        outputs={"q": f"{kv}*smooth_step(z)*p1/sqrt(sqrt(p1**2 + 1e8))"},
    )
    sensors = (
        StateSensor("p1", oil["p1"], unit="Pa"),
        StateSensor("x", value(s) - (s.initial - 0.3), unit="m"),
        jo.RateSensor("v", s),
    )
    return jo.Mechanism(body, rail, valve, oil, *sensors, core=core)


@pytest.mark.parametrize("core", CORES)
def test_counterbalance_valve(core: str) -> None:
    model = jo.compile(lowering(core))
    run = jo.simulate(model, 0.4, solver=jo.RK4(1e-4), output_step=0.1)
    assert run["x"][2, 0] == pytest.approx(0.284399962506, abs=1e-12)
    assert run["p1"][2, 0] == pytest.approx(7636506.01739, abs=1e-3)
    assert -run["v"][-1, 0] == pytest.approx(0.157901760348, abs=1e-10)


def test_equilibrium_finds_states_that_do_not_change() -> None:
    """PI controller written as states: weight held at the reference, integral part = weight."""
    body = jo.RigidBody("cart", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    s = rail.displacement
    control = States(
        "control",
        {"I": 0.0, "filtered": 0.0},
        {"I": "50*(0.25 - x)", "filtered": "(x - filtered)/0.01"},
        inputs={"x": value(s) - s.initial},
        outputs={"u": "200*(0.25 - filtered) + I"},
        forces={s: "200*(0.25 - filtered) + I"},
    )
    model = jo.compile(
        jo.Mechanism(
            body,
            rail,
            control,
            jo.Gravity((0, 0, -9.81)),
            StateSensor("I", control["I"]),
            StateSensor("filtered", control["filtered"]),
            StateSensor("x", value(s) - s.initial),
        )
    )
    rest = jo.simulate(model, 1e-3, state=jo.equilibrium(model), solver=jo.RK4(1e-3))
    assert rest["I"][0, 0] == pytest.approx(2 * 9.81, rel=1e-8)
    assert rest["filtered"][0, 0] == pytest.approx(0.25, rel=1e-8)
    assert rest["x"][-1, 0] == pytest.approx(0.25, rel=1e-8)
    with pytest.raises(InputError, match="damped=True"):
        jo.modes(model)


def test_equilibrium_says_that_a_state_cannot_rest() -> None:
    body = jo.RigidBody("cart", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    grows = States("grows", {"x": 0.0}, {"x": "1 + 0*x"})
    spring = jo.Spring("spring", rail.displacement, 100.0)
    model = jo.compile(jo.Mechanism(body, rail, spring, grows))
    with pytest.raises(SimulationError, match=r"'grows\.x' still changes"):
        jo.equilibrium(model)


@pytest.mark.parametrize("core", CORES)
def test_gradient_with_respect_to_a_number_of_a_block(core: str) -> None:
    """Inductance of the motor: derivative along the run against central differences."""

    def build(inductance: Any) -> jo.Mechanism:
        wheel = jo.RigidBody("wheel", 1.0, (1e-4, 1e-4, 1e-4))
        axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"], axis=(0, 0, 1))

        def rule(x: Any, u: Any) -> Any:
            i = x["i"]
            return {"i": (12.0 - i - 0.05 * u["w"]) / inductance}, {}, {axle.angle: 0.05 * i}

        winding = States.from_rule("winding", rule, {"i": 0.0}, {"w": rate(axle.angle)})
        return jo.Mechanism(wheel, axle, winding, jo.RateSensor("w", axle.angle), core=core)

    parameter = jo.Parameter("inductance", 5e-4)
    study = jo.study(build, parameter, ["last(w.s')"], t_end=5e-3, solver=jo.RK4(1e-4))
    found = jo.design.gradient(study, [5e-4], check=False)
    assert found.how == (("complex step",),)
    step = 1e-7
    ends = [float(study([5e-4 + sign * step])[0]) for sign in (1, -1)]
    assert found.jacobian[0, 0] == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-6)


@pytest.mark.parametrize("core", CORES)
def test_energy_that_a_block_supplies(core: str) -> None:
    """Work of the torque is the kinetic energy and what friction takes, of order 2 in the step."""
    errors = []
    for step in (4e-4, 2e-4):
        model = jo.compile(motor(core, jo.Harmonic(frequency=40.0, amplitude=12.0)))
        run = jo.simulate(model, 0.04, solver=jo.ROS2(step))
        errors.append(float(np.abs(run.energy.error).max()))
    assert errors[1] < 0.3 * errors[0]
    assert errors[1] < 1e-3 * float(np.abs(run.energy.kinetic).max())
