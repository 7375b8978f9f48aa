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
from jousto import hydraulics as h
from jousto.mechanism import StateSensor
from jousto.output.style import COLORS, STYLE

LITRE = 1e-3 / 60  # m3/s of 1 l/min
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
LOAD = 800.0  # kg
LEVERS = {"quick lever": 0.02, "slow lever": 0.4}  # s from closed to open
STOP = 1.5  # s
FOLD = jo.Table([0.0, 2.2, 2.4, 3.2, 3.4], [0.0, 0.0, -0.3, -0.3, 0.0])  # lever of the jib
BORE, ROD = 0.08, 0.045  # m
HEAD, FOOT = jo.ground.at((0, 0, 1.8)), jo.ground.at((0.57, 0, 0.54))  # of the column
T_END = 4.0


def beams() -> tuple[jo.FlexibleBody, jo.FlexibleBody]:
    outer = jo.Box(width=0.16, height=0.22, web=6e-3, flange=6e-3)
    inner = jo.Box(width=0.12, height=0.18, web=5e-3, flange=5e-3)
    boom = jo.Part.beam(4.0, outer, 8, STEEL, name="boom")
    jib = jo.Part.beam(3.0, inner, 6, STEEL, name="jib")
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


def axis(
    name: str, lever: jo.Table, ends: list[jo.mechanism.Marker], way: list[float]
) -> list[object]:
    """A 4/3 valve, a cylinder, and the counterbalance valve that holds its piston side."""
    line, piston, rod = (f"{name}_{x}" for x in ("line", "piston", "rod"))
    valve = h.DirectionalValve(
        *(f"{name}_valve", "P", "tank", line, rod),
        command=lever, frequency=30.0, overlap=0.02, flow=40 * LITRE,
    )  # fmt: skip
    hold = h.CounterbalanceValve(
        *(f"{name}_hold", piston, line, rod),
        setting=21e6, full=10e6, ratio=2.0, check_full=4e6, flow=60 * LITRE, drop=3e6,
    )  # fmt: skip
    cylinder = h.HydraulicCylinder(
        *(name, ends[0], ends[1], piston, rod),
        bore=BORE, rod=ROD, closed=way[0], stroke=way[1], damping=5e3,
    )  # fmt: skip
    nodes = h.Node(line, 3e-4), h.Node(piston, 1e-4, start=12e6), h.Node(rod, 4e-4)
    return [valve, hold, cylinder, *nodes]


def hydraulics(
    boom: jo.FlexibleBody, jib: jo.FlexibleBody, ramp: float, modulus: float
) -> h.HydraulicNetwork:
    """Pump with cut-off and two axes: the lift raises the boom, the other unfolds the jib."""
    lever = jo.Table([0, 0.3, 0.3 + ramp, STOP - ramp, STOP], [0, 0, 0.6, 0.6, 0])
    pump = h.Pump("pump", "tank", "P", 45e-6 / (2 * np.pi), speed=50 * np.pi, cutoff=18e6, lag=0.02)
    elements = [
        *(h.Tank("tank"), h.Node("P", 1e-3, start=1e6), pump),
        h.ReliefValve("relief", "P", "tank", setting=21e6, flow=40 * LITRE),
        h.Orifice("bleed", "P", "tank", flow=2 * LITRE, drop=18e6),
        *axis("lift", lever, [FOOT, boom["node4"]], [1.75, 0.9]),
        *axis("fold", FOLD, [boom["node4"], jib["node2"]], [2.5, 1.0]),
    ]
    return h.HydraulicNetwork("oil", elements, oil=h.Oil(modulus=modulus))


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


def moved(model: jo.Model, step: float, rest: jo.simulation.State) -> jo.Solution:
    return jo.simulate(model, T_END, state=rest, solver=jo.ROS2(step), output_step=5e-3)


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    runs, model = {}, jo.compile(crane())
    rest = jo.equilibrium(model)
    for name, ramp in LEVERS.items():
        model = jo.compile(crane(ramp))
        runs[name] = moved(model, 1e-3, rest)
        fine = moved(model, 5e-4, rest)
        error = np.abs(runs[name]["lift_x"] - fine["lift_x"]).max()
        print(f"{name}: error of the piston at 1 ms {1e6 * error:.1f} um")
        assert error < 1e-5
        areas = np.pi / 4 * np.array([BORE**2, BORE**2 - ROD**2])
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
    with plt.style.context(STYLE):
        figure, rows = plt.subplots(3, 1, figsize=(7.2, 6.4), sharex=True, layout="constrained")
        for (name, run), color in zip(runs.items(), COLORS, strict=False):
            rows[0].plot(run.time, run["tip"][:, 2], color=color, label=name)
            rows[1].plot(run.time, 1e-6 * run["lift_piston"][:, 0], color=color)
            rows[2].plot(run.time, 1e-6 * run["root"][:, 0], color=color)
        for i, label in enumerate(("tip in m", "lift in MPa", "root in MPa")):
            rows[i].set(ylabel=label)
        rows[0].legend()
        figure.savefig(folder / "crane_hydraulics.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path.cwd())
