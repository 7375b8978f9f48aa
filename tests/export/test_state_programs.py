"""States in an exported program: the same motion as in the engine."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from exported import CC, expected, rows_of
from jousto.mechanism import (
    BlockForce,
    Delay,
    LookupMap,
    PIDController,
    Play,
    Relay,
    Sampled,
    States,
    StateSensor,
    rate,
    value,
)

pytestmark = pytest.mark.skipif(
    CC is None or sys.platform == "win32", reason="no C compiler to compile the programs with"
)


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("method", ["RK4", "ROS2", "GeneralizedAlpha"])
def test_a_program_has_states(tmp_path: Path, core: str, method: str) -> None:
    """A motor with a stiff winding and a harmonic voltage."""
    wheel = jo.RigidBody("wheel", 1.0, (1e-4, 1e-4, 1e-4))
    axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"], axis=(0, 0, 1))
    winding = States(
        "winding",
        {"i": 0.5},
        {"i": "(u*smooth_step(time/0.01) - i - 0.05*w)/0.5e-3"},
        inputs={"u": jo.Harmonic(frequency=20.0, amplitude=12.0), "w": rate(axle.angle)},
        forces={axle.angle: "0.05*i - 1e-5*absolute(w)*w"},
    )
    sensors = StateSensor("i", winding["i"], unit="A"), jo.RateSensor("w", axle.angle)
    model = jo.compile(jo.Mechanism(wheel, axle, winding, *sensors, core=core))
    solver = getattr(jo, method)(step=2e-4)
    found = rows_of(model, solver, tmp_path, "0.05", "10")
    want = expected(model, jo.simulate(model, 0.05, solver=solver, output_step=5e-3))
    assert np.abs(found - want).max() < 1e-9 * np.abs(want).max()
    assert np.abs(np.diff(want, axis=0)).max() > 0.01


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("method", ["RK4", "ROS2", "GeneralizedAlpha"])
def test_a_program_has_a_hydraulic_network(tmp_path: Path, core: str, method: str) -> None:
    """A cylinder, a valve with a spool, a pump with a lag, and an accumulator, all in C."""
    h, litre = jo.hydraulics, 1e-3 / 60
    load = jo.RigidBody("load", 300.0, (1, 1, 1), position=(0.7, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], load["origin"], axis=(1, 0, 0))
    network = h.HydraulicNetwork(
        "oil",
        [
            h.Tank("tank"),
            h.Node("P", 5e-4, start=5e6),
            h.Pump("pump", "tank", "P", 4e-6, speed=150.0, cutoff=12e6, lag=0.02),
            h.Accumulator("gas", "P", 1e-4, 4e6),
            h.DirectionalValve(
                *("valve", "P", "tank", "A", "B"),
                flow=40 * litre,
                command=jo.Harmonic(frequency=5.0, amplitude=0.5),
                frequency=60.0,
                rate_limit=20.0,
            ),
            h.Node("A", 1e-4, start=1e6),
            h.Node("B", 1e-4, start=1e6),
            h.HydraulicCylinder(
                *("c", jo.ground["origin"], load["origin"], "A", "B"),
                bore=0.05,
                rod=0.03,
                stroke=0.4,
                closed=0.5,
                damping=2e3,
                seal=100.0,
                rod_cushion=h.Cushion(length=0.05, flow=60 * litre),
            ),
        ],
        oil=h.Oil(air=0.005),
    )
    names = "A", "c_rod", "valve_spool", "c_force", "heat_power"
    sensors = [StateSensor(name, network[name]) for name in names]
    model = jo.compile(jo.Mechanism(load, rail, network, *sensors, core=core))
    solver = getattr(jo, method)(step=2e-5 if method == "RK4" else 2e-4)
    found = rows_of(model, solver, tmp_path, "0.05", "10")
    want = expected(model, jo.simulate(model, 0.05, solver=solver, output_step=5e-3))
    scale = np.abs(want).max(axis=0)
    assert (np.abs(found - want).max(axis=0) <= 1e-8 * scale).all()
    assert np.abs(np.diff(want, axis=0)).max() > 0.01


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("method", ["RK4", "ROS2", "GeneralizedAlpha"])
def test_a_program_has_samples_play_relays_and_tables(
    tmp_path: Path, core: str, method: str
) -> None:
    """A cart with sampled control, twice late, play, a relay on its rate, a map as a spring."""
    cart = jo.RigidBody("cart", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    s = rail.displacement
    updates = {"u": "-80*x - 6*v", "n": "n + 1"}
    inputs = {"x": value(s), "v": rate(s)}
    times: Any = {"phase": 0.01, "latency": 7.3e-3, "jitter": 4e-3, "seed": 3}
    control = Sampled("control", 0.03, {"u": 0.0, "n": 0.0}, updates, inputs=inputs, **times)
    play, relay = Play("play", s, 0.01), Relay("relay", rate(s), -0.2, 0.1, on=2.0)
    knots = [-0.3, -0.1, 0.0, 0.2, 0.3]
    table = LookupMap("table", play["y"], rate(s), knots, [-1, 0, 2], np.outer(knots, [1, 2, 3]))
    late = Delay("late", control["u"] + rate(s), 0.0175)
    push = BlockForce("push", s, late["y"] + relay["y"] - 5.0 * table["z"])
    sensors = (
        jo.CoordinateSensor("x", s),
        *(
            StateSensor(name, name)
            for name in ("control.n", "play.y", "relay.y", "table.z", "late.y")
        ),
    )
    start = jo.Initial(s, value=0.2)
    blocks = control, play, relay, table, late, push
    model = jo.compile(jo.Mechanism(cart, rail, start, *blocks, *sensors, core=core))
    solver = getattr(jo, method)(step=1e-3)
    found = rows_of(model, solver, tmp_path, "1.0", "20")
    run = jo.simulate(model, 1.0, solver=solver, output_step=0.05)
    want = expected(model, run)
    assert np.abs(found - want).max() < 1e-9 * np.abs(want).max()
    assert {0.0, 2.0} == set(run["relay.y"][:, 0].tolist())
    # the sample of 1 s is late
    assert run["control.n"][-1, 0] == 33.0


@pytest.mark.parametrize(("core", "method"), [("joint", "ROS2"), ("maximal", "GeneralizedAlpha")])
def test_a_program_has_an_electric_drive(tmp_path: Path, core: str, method: str) -> None:
    """Motor with current control and weakening, gear with backlash and losses, brake."""
    rotor, drum = (jo.RigidBody(n, 1.0, (J,) * 3) for n, J in (("rotor", 1e-3), ("drum", 1.0)))
    origin = jo.ground["origin"]
    shaft, axle = (
        jo.Revolute(f"{x.name} axle", origin, x["origin"], axis=(0, 0, 1)) for x in (rotor, drum)
    )
    control = PIDController("pid", 300.0, rate(shaft.angle), kp=1.0, ki=5.0, limit=20.0)
    motor = jo.electric.SynchronousMotor(
        *("m", shaft.angle, 0.5, 2e-3, 3e-3, 0.08, 4),
        current=control["u"],
        bandwidth=1e3,
        dc_voltage=100.0,
        largest_current=20.0,
        weakening=True,
        strategy="least-current",
    )
    gear = jo.electric.Gearbox(
        *("g", shaft.angle, axle.angle, 20.0, 1e4, 50.0), backlash=0.004, efficiency=0.8
    )
    release = jo.Table([0.0, 0.09, 0.1], [1.0, 1.0, 0.0])
    brake = jo.electric.Brake("b", shaft.angle, 15.0, 1e4, release=release, damping=1.0)
    load = jo.electric.ThermalLoad("t", motor["amplitude"], 10.0, 0.1, trips=True)
    seen = ("iq", "id", "torque"), ("torque", "windup"), ("torque",), ("load", "tripped")
    sensors = [
        StateSensor(f"{block.name} {name}", block[name])
        for block, names in zip((motor, gear, brake, load), seen, strict=True)
        for name in names
    ]
    joints = rotor, drum, shaft, axle
    blocks = control, motor, gear, brake, load
    weight = jo.JointForce("weight", axle.angle, -50.0)
    model = jo.compile(jo.Mechanism(*joints, *blocks, weight, *sensors, core=core))
    solver = getattr(jo, method)(step=2e-4)
    found = rows_of(model, solver, tmp_path, "0.14", "10")
    run = jo.simulate(model, 0.14, solver=solver, output_step=0.014)
    want = expected(model, run)
    scale = np.abs(want).max(axis=0)
    assert (np.abs(found - want).max(axis=0) <= 1e-8 * scale).all()
    assert run["t tripped"][-1, 0] == 1.0
    assert run["m id"].min() < -1.0
    assert run["b torque"].min() < -10.0


@pytest.mark.slow
def test_the_program_of_the_hydraulic_crane(tmp_path: Path) -> None:
    """Two flexible beams, 12 states of oil: the same motion at 1 ms as in the engine."""
    example = Path(__file__).parents[2] / "examples" / "crane_hydraulics.py"
    model = jo.compile(runpy.run_path(str(example))["crane"]())
    solver = jo.ROS2(step=1e-3)
    found = rows_of(model, solver, tmp_path, "1.0", "10")
    want = expected(model, jo.simulate(model, 1.0, solver=solver, output_step=0.1))
    assert np.abs(found - want).max() < 1e-10 * np.abs(want).max()
    assert np.ptp(want, axis=0).max() > 1e6  # Pa
