"""LCD glass transfer robot: parts, motion, stress, friction, hot spots and life of one transfer.

A robot of the kind that H. Seo et al. design for loads of motion (J. Mech. Sci. Technol. 22 (2008)
722): a carriage lifts and turns, two arms of box section fold so that a fork of four composite
tines moves along a straight line, with a pane of glass on rubber pads. Belts from the base turn
forearm and fork, so that friction in elbow and wrist loads the arms. Dimensions are ours.

Checked: the stress at the root of the arm, at rest and stretched out, is that of statics by hand;
the damage that the engine counts while it steps is that of the stored history.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

ALU = jo.Material(E=70e9, nu=0.33, rho=2700, name="aluminium")
CARBON = jo.Material(E=110e9, nu=0.3, rho=1600, name="carbon fibre")
ARM = jo.Box(0.16, 0.09, web=0.006)
LINK, FOLDED, OUT = 1.0, np.radians(75.0), np.radians(20.0)  # m, angle of the upper arm
GLASS = 2.5  # kg, 1100 x 1300 x 0.7 mm
SITE, WELD = "e1.a.top", jo.fatigue.fat_class(28)  # fillet weld at the root, aluminium
T_END, STEP, Z = 3.4, 1e-3, (0, 0, 1)
PADS = {"p1": (0.4, -0.45, 0), "p2": (0.4, 0.45, 0), "p3": (1.2, -0.45, 0), "p4": (1.2, 0.45, 0)}
OUTLINE = [[0, -0.65, 0], [1.1, -0.65, 0], [1.1, 0.65, 0], [0, 0.65, 0], [0, -0.65, 0]]


def parts() -> dict[str, jo.Part]:
    """Two equal arms, with gear and bearings at the end, and the fork."""
    link = jo.Part.beam(LINK, ARM, 6, ALU, point_masses=jo.parts.PointMass("end", 5.0))
    palm, tine = jo.Box(0.08, 0.05, web=0.004), jo.Box(0.05, 0.025, web=0.002)
    fork = [jo.Member((0, 0, 0), (0.2, 0, 0), palm, ALU, name="wrist")]
    for a, b in zip((-0.45, -0.15, 0.0, 0.15), (-0.15, 0.0, 0.15, 0.45), strict=True):
        fork.append(jo.Member((0.2, a, 0), (0.2, b, 0), palm, ALU))
    for y in (-0.45, -0.15, 0.15, 0.45):
        for a, b in ((0.2, 0.4), (0.4, 1.2), (1.2, 1.4)):
            fork.append(jo.Member((a, y, 0), (b, y, 0), tine, CARBON, elements=2))
    return {"link": link, "fork": jo.Part.from_members(fork, points=PADS, name="fork")}


def robot(made: dict[str, jo.Part]) -> jo.Mechanism:
    """Folded before one cassette: it turns, stretches out and lowers the glass into another."""
    link = jo.reduce(made["link"], jo.CraigBampton(("start", "end"), modes=4))
    fork = jo.reduce(made["fork"], jo.CraigBampton(("wrist.start", *PADS), modes=6))
    soft = jo.Rayleigh(0.0, 2e-4)
    reach = 2 * LINK * np.cos(FOLDED)
    bent = np.degrees(FOLDED)
    elbow = (LINK * np.cos(FOLDED), LINK * np.sin(FOLDED), 0)
    lift = jo.RigidBody("carriage", 120.0, (6, 6, 5))
    base = jo.RigidBody("base", 60.0, (2, 2, 2))
    upper = jo.FlexibleBody("upper arm", link, damping=soft, orientation=jo.Rotate(Z, degrees=bent))
    back = jo.Rotate(Z, degrees=-bent)
    fore = jo.FlexibleBody("forearm", link, damping=soft, position=elbow, orientation=back)
    hand = jo.FlexibleBody("fork", fork, damping=soft, position=(reach, 0, 0))
    inertia = GLASS / 12 * np.array([1.3**2, 1.1**2, 1.1**2 + 1.3**2])
    glass = jo.RigidBody(
        "glass", GLASS, inertia, center=(0.55, 0, 0), position=(reach + 0.25, 0, 0),
        outline=OUTLINE, markers={p: (x - 0.25, y, 0) for p, (x, y, _) in PADS.items()},
    )  # fmt: skip
    rail = jo.Prismatic("rail", jo.ground["origin"], lift["origin"], Z)
    turn = jo.Revolute("turn", lift["origin"], base["origin"], Z)
    shoulder = jo.Revolute("shoulder", base["origin"], upper["start"], Z)
    elbows = jo.Revolute("elbow", upper["end"], fore["start"], Z)
    wrist = jo.Revolute("wrist", fore["end"], hand["wrist.start"], Z)
    fold = jo.SCurve((1.2, 2.2), (0.0, OUT - FOLDED))
    unfold = jo.SCurve((1.2, 2.2), (-FOLDED, -OUT))
    rubs = {"law": jo.mechanism.StickSlip(), "radius": 0.06, "bearing_length": 0.08, "preload": 3e3}
    rubber = np.array((3e4, 3e4, 3e4, 0, 0, 0))  # N/m
    stress = jo.StressSensor("root", upper, SITE)
    return jo.Mechanism(
        *(lift, base, upper, fore, hand, glass, rail, turn, shoulder, elbows, wrist),
        jo.Drive("lift", rail.displacement, jo.SCurve((2.4, 2.8), (0.0, -0.04))),
        jo.Drive("turning", turn.angle, jo.SCurve((0.2, 1.2), (0.0, np.pi / 2))),
        jo.Drive("arm", shoulder.angle, fold),
        jo.Drive("elbow belt", jo.Angle(base["origin"], fore["start"]), unfold),
        jo.Drive("wrist belt", jo.Angle(base["origin"], hand["wrist.start"]), jo.Constant(0.0)),
        jo.Friction("elbow bearing", elbows, 0.02, 0.03, **rubs),
        jo.Friction("wrist bearing", wrist, 0.02, 0.03, **rubs),
        *(jo.Bushing(p, hand[p], glass[p], rubber, 2e-3 * rubber) for p in PADS),
        *(jo.Gravity((0, 0, -9.81)), stress, jo.PositionSensor("glass", glass["center"])),
        jo.mechanism.DamageSensor("life", stress, WELD, residue="repeat", components=f"{SITE}:s11"),
        name="LCD robot",
    )  # fmt: skip


def root_stress(made: dict[str, jo.Part]) -> float:
    """Stress at the root of the upper arm by statics, stretched out and at rest, Pa."""
    link, fork = made["link"], made["fork"]
    elbow, reach = LINK * np.cos(OUT), 2 * LINK * np.cos(OUT)
    # weights, their distance from the shoulder along the stretched robot and beside it
    loads = [
        (link.mass, link.center[0] * np.cos(OUT), link.center[0] * np.sin(OUT)),
        (link.mass, elbow + link.center[0] * np.cos(OUT), (LINK - link.center[0]) * np.sin(OUT)),
        (fork.mass, reach + fork.center[0], 0.0),
        (GLASS, reach + 0.25 + 0.55, 0.0),
    ]
    along = np.array([np.cos(OUT), np.sin(OUT)])
    moment = sum(9.81 * m * float(along @ (x, y)) for m, x, y in loads)
    return moment * 0.5 * ARM.height / ARM.Iy


def main(out: Path) -> int:
    """Run with and without friction, recover stress, count; return 0 if all of it is right."""
    out.mkdir(parents=True, exist_ok=True)
    made = parts()
    machine = robot(made)
    models = [jo.compile(m) for m in (machine, jo.recovery.without_friction(machine))]
    runs = [
        jo.simulate(m, T_END, solver=jo.ROS2(STEP), output_step=STEP, state=jo.equilibrium(m))
        for m in models
    ]
    run = runs[0]
    still, hand_made = run["root"][-100:, 0].mean(), root_stress(made)
    rubbed = jo.recovery.friction_stress(run, runs[1], "upper arm", start=1.0)
    spots = jo.hot_spots(run, count=3, separation=0.2)
    cycles = jo.fatigue.rainflow(run["root"][:, 0], residue="repeat")
    offline, counted = jo.fatigue.damage(cycles, WELD), run["life"][-1, 0]
    print(f"root of the arm at rest {still / 1e6:.3f} MPa, by hand {hand_made / 1e6:.3f} MPa")
    print(spots)
    worst = rubbed.table(1)[0]
    print(f"friction adds up to {worst['due'] / 1e6:.3f} MPa, at {worst['site']}")
    print(f"{len(rubbed.transitions)} transitions between stick and slip")
    print(f"damage of a transfer {counted:.3e} in the engine, {offline:.3e} of the history")
    print(f"life {1 / counted:.3g} transfers")
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.6), layout="constrained")
        left.plot(run.time, 1e-6 * run["root"][:, 0], color=COLORS[0])
        left.axhline(1e-6 * hand_made, color=COLORS[1], linestyle=(0, (5, 2)), label="statics")
        left.set(xlabel="time (s)", ylabel="stress at the root of the arm (MPa)")
        left.legend()
        right.plot(run.time, run["life"][:, 0], color=COLORS[2])
        right.set(xlabel="time (s)", ylabel="damage, transfer repeated (1)")
        figure.savefig(out / "lcd_robot.png")
        plt.close(figure)
    jo.plot(rubbed, path=out / "lcd_robot_friction.png")
    jo.still(run, out / "lcd_robot_still.png", times=(0.0, 1.3, T_END), trail="glass")

    good = abs(still / hand_made - 1) < 0.01 and abs(counted / offline - 1) < 1e-9
    print("the robot lives as counted" if good else "THE ROBOT IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
