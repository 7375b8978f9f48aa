"""Ropes over sheaves and sliders in an exported program: the same motion as in the engine."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from exported import CC, PLAIN, compiled, expected, table
from jousto.export.fmu import write_fmu
from jousto.export.project import write_program
from jousto.mechanism import Capstan, ForceStateSensor, Reeving, RopeSpan, Slider, StateSensor

pytestmark = [
    pytest.mark.skipif(
        CC is None or sys.platform == "win32", reason="no C compiler to compile the programs with"
    ),
    pytest.mark.filterwarnings("ignore::jousto.JoustoWarning"),
]


def hoist(rho: float = 0.0) -> list[Any]:
    """A block on two parts of rope with losses, a winch and a drum, and a spring along a span."""
    R = 0.2
    block = jo.RigidBody("block", 50.0, (1, 1, 1), position=(R, -6, 0), velocity=(0.3, 0, 0.1))
    wheel = jo.RigidBody("wheel", 20.0, (0.4, 0.4, 0.4))
    axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"])
    brake = jo.Spring("brake", axle.angle, stiffness=2e3, damping=40.0)
    rope = Reeving(
        "rope", (jo.ground["origin"], block["origin"], jo.ground.at((2 * R, 0, 0))), (0, R, 0),
        stiffness=5e5, damping=5e3, winch=jo.SCurve((0.0, 0.2), (0.0, -0.8)),
        efficiencies=(1, 0.95, 1), drum=axle.angle, drum_radius=0.3, mass_per_length=rho,
    )  # fmt: skip
    guy = jo.Spring("guy", RopeSpan(jo.ground.at((2, 0, 1)), block["origin"], 0.1, -R), 200.0, 5.0)
    sensors = [StateSensor(n, rope[n]) for n in ("tension", "tension_end", "strain", "paid_out")]
    p = jo.PositionSensor("p", block["origin"]), jo.CoordinateSensor("turn", axle.angle)
    hand = jo.RigidBody("hand", 9.0, (1, 1, 1), position=(5, -1, 0))
    rail = jo.Prismatic("rail", jo.ground.at((5, -1, 0)), hand["origin"], axis=(0, 1, 0))
    spring = jo.Spring.between("held", hand["origin"], jo.ground.at((5, -2, 0)), 500.0)
    path = jo.ground.at((4, -2, 0)), jo.ground.at((4.5, 0, 0)), hand["origin"]
    line = Capstan("line", path, (0, -0.1, 0), stiffness=1e4, damping=20.0, mu=0.1)
    sensors += [StateSensor(n, line[n]) for n in ("slip", "heat")]
    return [
        block,
        wheel,
        axle,
        brake,
        rope,
        guy,
        hand,
        rail,
        spring,
        line,
        *sensors,
        *p,
        jo.Gravity((0, -9.81, 0)),
    ]


def carriage(flexible: bool) -> list[Any]:
    """A driven trolley with play and friction on a rail of the ground, or on a beam that bends."""
    trolley = jo.RigidBody("trolley", 5.0, (1, 1, 1), position=(0.5, 0, 0), velocity=(0.4, 0, 0))
    level = jo.ConstantOrientation("level", jo.ground["origin"], trolley["origin"])
    rail: Any = tuple(jo.ground.at((x, 0.02 * x * (2 - x), 0)) for x in (0.0, 1.0, 2.0))
    items: list[Any] = []
    if flexible:
        steel = jo.Material(E=210e9, nu=0.3, rho=7850)
        part = jo.Part.beam(2.0, jo.Rectangle(0.03, 0.02), 4, steel)
        reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=2))
        jib = jo.FlexibleBody("jib", reduced.keep(reduced.in_plane("xy")))
        items = [jib, jo.Fixed("root", jo.ground["origin"], jib["start"])]
        rail = jib["start"], jib["end"]
    runner = Slider(
        "runner", rail, trolley["origin"], 2e5, 500.0, mu=0.1, play=1e-4, resistance=0.5, pull=2.0,
        reference=jo.SCurve((0.0, 0.2), (0.5, 0.7)), hold=2e3, brake=2e2,
    )  # fmt: skip
    sensors = [ForceStateSensor(name, runner, name) for name in ("way", "speed")]
    place = jo.PositionSensor("place", trolley["origin"]), jo.ForceSensor("pad", runner)
    return [*items, trolley, level, runner, *sensors, *place]


@pytest.mark.parametrize(
    ("solver", "core", "flexible"),
    [
        (jo.RK4(1e-4), "joint", False),
        pytest.param(jo.ROS2(5e-4), "maximal", True, marks=pytest.mark.slow),
        pytest.param(jo.GeneralizedAlpha(5e-4), "maximal", True, marks=pytest.mark.slow),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_program_hoists_and_slides(
    tmp_path: Path, solver: Any, core: str, flexible: bool
) -> None:
    machine = jo.Mechanism(*hoist(0.0 if flexible else 1.0), *carriage(flexible), core=core)
    model = jo.compile(machine)
    write_program(model, tmp_path / "machine.c", solver)
    found = table(compiled(tmp_path, "machine.c", flags=(*PLAIN, "-DMAIN")), "0.3", "10")
    want = expected(model, jo.simulate(model, 0.3, solver=solver, output_step=0.03))
    scale = np.abs(want).max(axis=0)
    assert (np.abs(found - want).max(axis=0) <= 1e-8 * scale + 1e-12 * scale.max()).all()
    last = jo.simulate(model, 0.3, solver=solver)
    assert last["paid_out"][-1, 0] < -0.1
    assert np.ptp(last["tension"]) > 10.0
    assert np.ptp(last["slip"]) > 1e-6
    assert np.ptp(last["way"]) > 0.1


def without_memory(items: list[Any]) -> list[Any]:
    """Return the items without the rope that slips, which keeps this between steps."""
    return [one for one in items if getattr(one, "name", "") not in ("line", "slip", "heat")]


@pytest.mark.slow
@pytest.mark.parametrize("sliding", [False, True])
def test_a_unit_hoists(tmp_path: Path, sliding: bool) -> None:
    """The same machine as a functional mock-up unit, in its own steps and in those of FMPy.

    A slider and a rope that slips change their states at the ends of steps, so that their unit has
    its own steps only.
    """
    fmpy = pytest.importorskip("fmpy")
    items = [*hoist(), *carriage(True)] if sliding else without_memory(hoist())
    model = jo.compile(jo.Mechanism(*items))
    solver = jo.ROS2(5e-4)
    out = write_fmu(model, tmp_path / "machine.fmu", solver, version=2, stop=0.3)
    assert (fmpy.read_model_description(str(out)).modelExchange is None) == sliding
    want = expected(model, jo.simulate(model, 0.3, solver=solver, output_step=0.03))
    scale = np.abs(want).max(axis=0)
    for kind in ("CoSimulation",) if sliding else ("CoSimulation", "ModelExchange"):
        found = fmpy.simulate_fmu(
            str(out), stop_time=0.3, output_interval=0.03, fmi_type=kind, relative_tolerance=1e-8
        )
        rows = np.stack([found[name] for name in found.dtype.names], axis=1)
        error = np.abs(rows - want).max(axis=0)
        share = 1e-8 if kind == "CoSimulation" else 1e-3
        assert (error <= share * scale + 1e-12 * scale.max()).all(), kind
