"""A cast link arm from its CAD file lifts 2.5 t: mesh, modes, certificate, motion, stress.

The mesh ``data/link_arm.vtu`` was made from ``data/link_arm.step`` by

    jousto mesh link_arm.step --size "75 mm" --per-circle 8 -o link_arm.vtu

The arm turns about its large bore by 60 degrees in 1 s and carries the load in its small bore.
Before it starts, the stress half-way must be ``M y / I`` of the I-section; while it turns, the
drive's torque must be that of a rigid arm and load, but for the vibration of the elastic one.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

MESH = Path(__file__).parent / "data" / "link_arm.vtu"
LENGTH, LOAD, G = 1.2, 2500.0, 9.81  # m, kg, m/s2
DEPTH, WIDTH, FLANGE, WEB, FILLET = 0.18, 0.11, 0.02, 0.018, 0.012  # m, of the I-section
SWING = jo.SCurve((0.1, 1.1), (0.0, np.deg2rad(60.0)))


def reduced_arm() -> tuple[jo.Part, jo.ReducedPart]:
    """The arm with its two bores as interfaces, and its modes."""
    mesh = jo.read_mesh(MESH)
    bores = sorted(mesh.holes(), key=lambda hole: hole.point[0])
    part = jo.Part.solid(
        mesh,
        jo.material("S355"),
        interfaces=(
            jo.Interface("eye", bores[0].nodes, kind="average"),
            jo.Interface("pin", bores[-1].nodes, kind="average"),
        ),
    )
    return part, jo.reduce(part, jo.CraigBampton(modes=12))


def lift(arm: jo.ReducedPart, site: str) -> jo.Solution:
    """Turn the arm about its large bore, from the position of rest, the load in the small bore."""
    body = jo.FlexibleBody("arm", arm, damping=0.02)
    load = jo.RigidBody("load", LOAD, (50.0, 50.0, 50.0), position=(LENGTH, 0, 0))
    pivot = jo.Revolute("pivot", jo.ground["origin"], body["eye"], axis=(0, 0, 1))
    motor = jo.Drive("motor", pivot.angle, SWING)
    model = jo.compile(
        jo.Mechanism(
            body,
            load,
            pivot,
            motor,
            jo.Revolute("pin", body["pin"], load["origin"], axis=(0, 0, 1)),
            jo.Gravity((0.0, -G, 0.0)),
            jo.ReactionSensor("torque", motor),
            jo.StressSensor("flange", body, site),
            name="link arm",
        )
    )
    rest = jo.equilibrium(model)
    return jo.simulate(model, 1.6, solver=jo.ROS2(2e-4), state=rest, output_step=2e-3)


def rigid_torque(t: np.ndarray, arm: jo.ReducedPart) -> np.ndarray:
    """Torque of the drive if nothing bent: ``J phi'' + (m c + M l) g cos(phi)``."""
    mass = arm.invariants
    J = np.trace(mass.second_moment[:2, :2]) + LOAD * LENGTH**2
    moment = mass.first_moment[0] + LOAD * LENGTH
    return J * SWING.acceleration(t) + moment * G * np.cos(SWING(t))


def beam_stress(part: jo.Part) -> float:
    """Bending stress of the flange half-way at rest, from load and own weight beyond: M y / I."""
    x = 0.5 * LENGTH
    inner = DEPTH - 2.0 * FLANGE
    inertia = (WIDTH * DEPTH**3 - (WIDTH - WEB) * inner**3) / 12.0
    inertia += (4.0 - np.pi) * FILLET**2 * (0.5 * inner - 0.223 * FILLET) ** 2
    weight = np.asarray(part.M.sum(axis=1)).reshape(-1, 3)[:, 0] * G
    own = weight * np.clip(part.nodes[:, 0] - x, 0.0, None)
    return (LOAD * G * (LENGTH - x) + own.sum()) * 0.5 * DEPTH / inertia


def draw(run: jo.Solution, theory: np.ndarray, path: Path) -> None:
    """Torque of the drive and stress of the flange over time."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.6), layout="constrained")
        left.plot(run.time, run["torque"][:, 0] / 1e3, color=COLORS[0], label="elastic arm")
        left.plot(run.time, theory / 1e3, "--", color=COLORS[1], zorder=3, label="rigid arm")
        left.set_title("Torque of the drive", **bold)
        left.set(xlabel="time (s)", ylabel="kN m")
        left.legend()
        right.plot(run.time, run["flange"][:, 0] / 1e6, color=COLORS[0])
        right.set_title("Stress of the upper flange half-way", **bold)
        right.set(xlabel="time (s)", ylabel="MPa along the arm")
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Mesh to stress, with closed forms beside it; return 0 if they agree."""
    out.mkdir(parents=True, exist_ok=True)
    part, arm = reduced_arm()
    print(str(jo.certificate.certify(part, arm)).partition("\nsix rigid")[0])
    jo.draw(part, out / "link_arm_mesh.png")
    jo.draw(arm, out / "link_arm_mode.png", mode=1)
    run = lift(arm, arm.stress.nearest((0.5 * LENGTH, 0.5 * DEPTH, 0.0)))  # upper flange, half-way
    theory = rigid_torque(run.time, arm)
    torque, stress = run["torque"][:, 0], run["flange"][:, 0]
    worst = jo.hot_spots(run, count=1)[0]
    expected = beam_stress(part)
    difference = np.abs(torque - theory).max() / theory.max()
    standing = run.time > 1.225  # four periods of the vibration
    held = torque[standing].mean() / theory[-1] - 1.0
    print(f"stress half-way at rest  {stress[0] / 1e6:.2f} MPa, M y / I {expected / 1e6:.2f} MPa")
    print(f"largest torque           {torque.max() / 1e3:.2f} kN m, rigid {theory.max() / 1e3:.2f}")
    print(f"differs by at most       {100 * difference:.1f} %, {100 * held:.2f} % at the end")
    print(f"largest stress           {worst.value / 1e6:.1f} MPa at {worst.site}, {worst.time:g} s")
    draw(run, theory, out / "link_arm.png")
    jo.still(run, out / "link_arm_still.png", times=[0.0, 0.6, 1.6], stress=True)

    good = abs(stress[0] / expected - 1.0) < 0.01 and difference < 0.15 and abs(held) < 0.01
    print("the arm bends as it must" if good else "THE ARM IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
