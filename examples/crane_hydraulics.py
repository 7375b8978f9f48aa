"""The folding crane with its hydraulics: pump, two valves, two cylinders, counterbalance valves.

Oil is stiff: the pressures here change at more than 1e4 1/s, and ROS2 still takes steps of 1 ms,
since all derivatives are in its matrix. A quick lever jerks the boom, and the stress at its root
shows how much softer a slow one is. The machine is exported as C, which runs the same steps.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.hydraulics import (
    CounterbalanceValve,
    DirectionalValve,
    HydraulicCylinder,
    HydraulicNetwork,
    Node,
    Oil,
    Orifice,
    Pump,
    ReliefValve,
    Tank,
)
from jousto.mechanism import StateSensor
from jousto.output.style import COLORS, STYLE

LITRE = 1e-3 / 60  # m3/s of 1 l/min
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
LOAD = 800.0  # kg
LEVERS = {"quick lever": 0.02, "slow lever": 0.4}  # s from closed to open
STOP = 1.5  # s
FOLD = jo.Table([0.0, 2.2, 2.4, 3.2, 3.4], [0.0, 0.0, -0.3, -0.3, 0.0])  # lever of the jib
HEAD, FOOT = jo.ground.at((0, 0, 1.8)), jo.ground.at((0.57, 0, 0.54))  # of the column
T_END = 4.0


def beams() -> tuple[jo.FlexibleBody, jo.FlexibleBody]:
    """Boom and jib: box sections, Craig-Bampton with the nodes of the cylinders."""
    outer = jo.Box(width=0.16, height=0.22, web=6e-3, flange=6e-3)
    inner = jo.Box(width=0.12, height=0.18, web=5e-3, flange=5e-3)
    boom = jo.Part.beam(4.0, outer, 8, STEEL, name="boom")
    jib = jo.Part.beam(3.0, inner, 6, STEEL, name="jib")
    # the crane moves in the plane x z: modes across it are left out
    boom_modes = jo.reduce(boom, jo.CraigBampton(("start", "node4", "end"), modes=3))
    jib_modes = jo.reduce(jib, jo.CraigBampton(("start", "node2", "end"), modes=3))
    boom_modes, jib_modes = (x.keep(x.in_plane("xz")) for x in (boom_modes, jib_modes))
    damping = jo.Rayleigh(alpha=0.0, beta=2e-3)
    rising = ((0.8, 0, -0.6), (0, 1, 0), (0.6, 0, 0.8))  # 3 m on 4 m
    return (
        jo.FlexibleBody(
            "boom", boom_modes, position=(0, 0, 1.8), orientation=rising, damping=damping
        ),
        jo.FlexibleBody("jib", jib_modes, position=(3.2, 0, 4.2), damping=damping),
    )


def hydraulics(
    boom: jo.FlexibleBody, jib: jo.FlexibleBody, ramp: float, modulus: float
) -> HydraulicNetwork:
    """Pump with cut-off, two 4/3 valves, two cylinders that counterbalance valves hold."""
    times = [0.0, 0.3, 0.3 + ramp, STOP - ramp, STOP]
    lever = jo.Table(times, [0.0, 0.0, 0.6, 0.6, 0.0])
    edge = {"flow": 40 * LITRE, "drop": 3.5e6}
    valve = {"frequency": 30.0, "damping": 0.9, "overlap": 0.02}
    hold = {
        "setting": 21e6,
        "full": 4e6,
        "ratio": 4.0,
        "flow": 60 * LITRE,
        "drop": 3e6,
        "check_full": 2e6,
    }
    size = {"bore": 0.08, "rod": 0.045, "damping": 5e3}
    return HydraulicNetwork(
        "oil",
        [
            Tank("tank"),
            Node("P", 1e-3, start=1e6),
            Pump("pump", "tank", "P", 45e-6 / (2 * np.pi), speed=50 * np.pi, leak=2e-12,
                 cutoff=18e6, lag=0.02),
            ReliefValve("relief", "P", "tank", setting=21e6, **edge),
            Orifice("bleed", "P", "tank", flow=2 * LITRE, drop=18e6),
            # the lift: rod out raises the boom
            DirectionalValve("lift_valve", "P", "tank", "lift_line", "lift_rod", command=lever,
                             **valve, **edge),
            Node("lift_line", 3e-4, start=1e5),
            CounterbalanceValve("lift_hold", "lift_piston", "lift_line", "lift_rod", **hold),
            Node("lift_piston", 1e-4, start=12e6),
            Node("lift_rod", 4e-4, start=1e5),
            HydraulicCylinder("lift", FOOT, boom["node4"], "lift_piston", "lift_rod",
                              stroke=0.9, closed=1.75, **size),
            # the jib: rod out unfolds it
            DirectionalValve("fold_valve", "P", "tank", "fold_line", "fold_rod", command=FOLD,
                             **valve, **edge),
            Node("fold_line", 3e-4, start=1e5),
            CounterbalanceValve("fold_hold", "fold_piston", "fold_line", "fold_rod", **hold),
            Node("fold_piston", 1e-4, start=12e6),
            Node("fold_rod", 4e-4, start=1e5),
            HydraulicCylinder("fold", boom["node4"], jib["node2"], "fold_piston", "fold_rod",
                              stroke=1.0, closed=2.5, **size),
        ],
        oil=Oil(modulus=modulus),
    )  # fmt: skip


def crane(ramp: float = 0.02, modulus: float = 1.5e9) -> jo.Mechanism:
    """Boom, jib and load on a column; driven by oil."""
    boom, jib = beams()
    load = jo.RigidBody(
        "load", LOAD, (130, 130, 130), position=(6.2, 0, 2.2), markers={"rope": (0, 0, 2)}
    )
    joints = (
        jo.Revolute("hinge", HEAD, boom["start"], axis=(0, 1, 0)),
        jo.Revolute("knuckle", boom["end"], jib["start"], axis=(0, 1, 0)),
        jo.Universal("hook", jib["end"], load["rope"], axis_a=(1, 0, 0), axis_b=(0, 1, 0)),
    )
    oil = hydraulics(boom, jib, ramp, modulus)
    watched = ("P", "lift_piston", "lift_rod", "fold_piston", "lift_force", "lift_x", "fold_x")
    sensors = (
        *(StateSensor(name, oil[name]) for name in watched),
        jo.PositionSensor("tip", jib["end"]),
        jo.StressSensor("root", boom, sites=["e1.a.top"]),
    )
    items = (boom, jib, load, *joints, jo.Gravity((0, 0, -9.81)), oil, *sensors)
    return jo.Mechanism(*items, name="crane", start="rest")


def moved(model: jo.Model, step: float, rest: object) -> jo.Solution:
    """Run from rest; the command lifts the load and folds the jib."""
    return jo.simulate(model, T_END, state=rest, solver=jo.ROS2(step), output_step=5e-3)


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    runs = {}
    for name, ramp in LEVERS.items():
        model = jo.compile(crane(ramp))
        rest = jo.equilibrium(model)
        runs[name] = moved(model, 1e-3, rest)
        fine = moved(model, 5e-4, rest)
        error = np.abs(runs[name]["lift_x"] - fine["lift_x"]).max()
        print(f"{name}: error of the piston at 1 ms {1e6 * error:.1f} um")
        assert error < 2e-4
        # at rest the pressure of the piston side carries the machine
        areas = np.pi / 4 * np.array([0.08**2, 0.08**2 - 0.045**2])
        force = runs[name]["lift_piston"][0, 0] * areas[0] - runs[name]["lift_rod"][0, 0] * areas[1]
        assert abs(force - runs[name]["lift_force"][0, 0]) < 1e-6 * abs(force)
    start = time.process_time()
    moved(model, 1e-3, rest)
    print(f"{T_END / (time.process_time() - start):.0f} times faster than real time")
    swing = {name: float(np.ptp(run["root"][run.time > STOP])) for name, run in runs.items()}
    print(", ".join(f"{name} {1e-6 * x:.1f} MPa" for name, x in swing.items()))
    assert swing["quick lever"] > 1.1 * swing["slow lever"]
    with tempfile.TemporaryDirectory() as made:
        jo.write(model, Path(made) / "crane.c", solver=jo.ROS2(step=1e-3))
        assert "network" in (Path(made) / "crane.c").read_text(encoding="utf-8")
    with plt.style.context(STYLE):
        figure, rows = plt.subplots(3, 1, figsize=(7.2, 6.4), sharex=True, layout="constrained")
        for (name, run), color in zip(runs.items(), COLORS, strict=False):
            rows[0].plot(run.time, run["tip"][:, 2], color=color, label=name)
            rows[1].plot(run.time, 1e-6 * run["lift_piston"][:, 0], color=color)
            rows[2].plot(run.time, 1e-6 * run["root"][:, 0], color=color)
        rows[0].set(ylabel="height of the tip in m")
        rows[1].set(ylabel="lift pressure in MPa")
        rows[2].set(ylabel="stress at the root in MPa", xlabel="time in s")
        rows[0].legend()
        figure.savefig(folder / "crane_hydraulics.png")
    plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path.cwd())
