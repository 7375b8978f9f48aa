"""States in an exported program: the same motion as in the engine."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import CC, PLAIN, compiled, expected, table
from jousto.export.project import write_program
from jousto.mechanism import States, StateSensor, rate

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
    write_program(model, tmp_path / "motor.c", solver)
    found = table(compiled(tmp_path, "motor.c", flags=(*PLAIN, "-DMAIN")), "0.05", "10")
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
    write_program(model, tmp_path / "oil.c", solver)
    found = table(compiled(tmp_path, "oil.c", flags=(*PLAIN, "-DMAIN")), "0.05", "10")
    want = expected(model, jo.simulate(model, 0.05, solver=solver, output_step=5e-3))
    scale = np.abs(want).max(axis=0)
    assert (np.abs(found - want).max(axis=0) <= 1e-8 * scale).all()
    assert np.abs(np.diff(want, axis=0)).max() > 0.01
