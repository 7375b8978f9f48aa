"""A hydraulic hose on a robot: an exact beam between modal arms, and what it does to the machine.

Upper arm and forearm are modal bodies, the hose over the elbow is a geometrically exact beam of
12 elements, straight when it is free and clamped to both arms. While the column turns by 90 degrees
and the elbow bends by 45, the hose bends further and swings sideways. The work of the motors must
become the energy of the machine, 24 elements must move like 12, and the tightest bend must stay
above the smallest radius that the hose allows.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

import jousto as jo
from jousto.output.style import COLORS, STYLE

CHORD, LENGTH = 0.75, 1.0  # m, between the fittings and of the hose
SMALLEST = 0.13  # m, radius to which it may be bent
ALUMINIUM = jo.Material(E=70e9, nu=0.33, rho=2700.0)
# a hose of 10 mm full of oil: E I = 4 N m2, 0.6 kg/m
HOSE = jo.mechanism.BeamSection(
    stiffness=np.diag([6e4, 2e4, 2e4, 3.0, 4.0, 4.0]),
    mass=0.6,
    inertia=(6e-5, 3e-5, 3e-5),
    outline=0.011 * np.array([[np.cos(a), np.sin(a)] for a in np.linspace(0, 2 * np.pi, 13)]),
)


def arc(elements: int) -> np.ndarray:
    """Nodes of a circular arc over the chord: the shape of a straight rod with its ends bent."""
    half = brentq(lambda x: np.sin(x) / x - CHORD / LENGTH, 0.1, 3.0)
    radius = LENGTH / (2 * half)
    a = np.linspace(-half, half, elements + 1)
    return np.stack(
        [0.5 * CHORD + radius * np.sin(a), 0 * a, radius * (np.cos(a) - np.cos(half))], axis=1
    )


def foot(pipe: jo.BeamBody, end: int) -> jo.mechanism.Marker:
    """Where a fitting stands on an arm, 60 mm below the end of the hose, rigidly joined to it."""
    return pipe.node(end, at=pipe.frames[end].T @ np.array([0.0, 0.0, -0.06]))


def machine(elements: int, *, hose: bool = True) -> jo.Mechanism:
    """Column, upper arm, forearm with a payload, and the hose over the elbow."""
    arms = []
    for name, start, length in (("arm", 0.0, 0.8), ("forearm", 0.8, 0.7)):
        box = jo.Box(0.1, 0.1, web=0.005, flange=0.005)
        part = jo.Part.beam(length=length, section=box, elements=8, material=ALUMINIUM)
        reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "node5", "end"), modes=4))
        arms.append(
            jo.FlexibleBody(name, reduced, position=(start, 0, 0.5), damping=jo.Rayleigh(0.0, 3e-4))
        )
    arm, forearm = arms
    column = jo.RigidBody("column", 120.0, (4, 4, 3), markers={"shoulder": (0, 0, 0.5)})
    load = jo.RigidBody("load", 8.0, (0.03, 0.03, 0.03), position=(1.5, 0, 0.5))
    pipe = jo.BeamBody(
        "hose",
        arc(elements),
        HOSE,
        straight=True,
        bending=True,
        mass="corrected",
        damping=jo.mechanism.BeamDamping(stiffness=2e-3),
        position=(0.4, 0, 0.56),
    )
    items: list = [column, arm, forearm, load, jo.Gravity((0, 0, -9.81))]
    axes = [
        jo.Revolute("axis 1", jo.ground["origin"], column["origin"], axis=(0, 0, 1)),
        jo.Revolute("axis 2", column["shoulder"], arm["start"], axis=(0, 1, 0)),
        jo.Revolute("axis 3", arm["end"], forearm["start"], axis=(0, 1, 0)),
    ]
    for axis, angle in zip(axes, (np.pi / 2, -np.pi / 9, np.pi / 4), strict=True):
        move = jo.SCurve((0.2, 1.0), (0.0, angle))
        motor = jo.Drive(axis.name.replace("axis", "motor"), axis.angle, move)
        items += [axis, motor, jo.ReactionSensor(motor.name, motor)]
    items.append(jo.Fixed("gripper", forearm["end"], load["origin"]))
    items.append(jo.PositionSensor("load", load["origin"]))
    if hose:
        items += [
            pipe,
            jo.Fixed("fitting 1", arm["node5"], foot(pipe, 0)),
            jo.Fixed("fitting 2", forearm["node5"], foot(pipe, -1)),
            jo.PositionSensor("top", pipe.node(elements // 2)),
        ]
    return jo.Mechanism(*items, name="robot with hose")


def swing(mechanism: jo.Mechanism) -> jo.Solution:
    """From rest through the motion and half a second after it."""
    model = jo.compile(mechanism)
    return jo.simulate(
        model, 1.5, solver=jo.GeneralizedAlpha(step=1e-3), state=jo.equilibrium(model)
    )


def draw(run: jo.Solution, bare: jo.Solution, radius: np.ndarray, path: Path) -> None:
    """Radius of the tightest bend, the top of the hose, torque with and without it."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5}
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
        axes[0].plot(run.time, 1e3 * radius, color=COLORS[0])
        axes[0].axhline(1e3 * SMALLEST, color=COLORS[1], linestyle=(0, (5, 2)))
        axes[0].set_title("Tightest bend of the hose, and its limit", **bold)
        axes[0].set_ylim(0, None)
        for i, axis in enumerate("xyz"):
            axes[1].plot(run.time, run["top"][:, i], color=COLORS[i], label=axis)
        axes[1].set_title("Middle of the hose", **bold)
        axes[2].plot(run.time, np.ravel(run["motor 3"]), color=COLORS[0], label="with hose")
        axes[2].plot(bare.time, np.ravel(bare["motor 3"]), color=COLORS[1], label="without")
        axes[2].set_title("Torque of the elbow", **bold)
        for ax, unit in zip(axes, ("mm", "m", "N m"), strict=True):
            ax.set(xlabel="time (s)", ylabel=unit)
            if ax is not axes[0]:
                ax.legend()
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Run with 12 and 24 elements and without the hose; return 0 if all agree."""
    out.mkdir(parents=True, exist_ok=True)
    run, fine, bare = swing(machine(12)), swing(machine(24)), swing(machine(20, hose=False))
    forces = jo.recovery.section_forces(run, "hose")
    radius = 1 / np.linalg.norm(forces.strains[..., 4:6], axis=2).max(axis=1)
    apart = np.abs(run["top"] - fine["top"]).max()
    path = np.ptp(run["top"], axis=0).max()
    missing = np.abs(run.energy.error).max() / np.abs(run.energy.work).max()
    torque, ideal = np.ravel(run["motor 3"]), np.ravel(bare["motor 3"])
    more = np.abs(torque).max() / np.abs(ideal).max() - 1

    print(f"tightest bend {1e3 * radius.min():.0f} mm at {run.time[radius.argmin()]:.2f} s")
    print(f"12 and 24 elements put its middle {1e6 * apart:.0f} um apart, of {path:.2f} m")
    print(f"the energy balance misses {100 * missing:.3f} % of the work of the motors")
    print(f"largest torque of the elbow {100 * more:+.1f} % by the hose")
    draw(run, bare, radius, out / "robot_hose.png")
    jo.still(run, out / "robot_hose_still.png", times=(0.0, 0.6, 1.0), trail="top")
    good = radius.min() > SMALLEST and apart < 1e-3 * path and missing < 0.01
    print("the hose may be used" if good else "THE HOSE MUST NOT BE USED")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
