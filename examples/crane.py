"""A folding crane lifts its load: forces of its cylinder at rest, and how it rings after the stop.

The model is ``crane.yaml``: column, boom, jib, a cylinder of barrel and piston, and a load that
hangs from the tip. All three drives move at once and stop smoothly after 6 s. At rest the cylinder
must push as the principle of virtual work says: ``F dL = sum m g dz``, with heights from the
triangle of boom, column and cylinder. After the stop the tip must ring with the natural
frequencies that `modes` finds about the rest position.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

MODEL = Path(__file__).with_name("crane.yaml")
G, STOP = 9.81, 6.0  # m/s2, s
FOOT, EYE = np.array([0.57, 0.54]), 1.5  # m: foot of the cylinder; its eye on the boom
BOOM, JIB, HEAD = 4.0, 3.0, 1.8  # m
MASS = {"boom": 7850 * BOOM * (0.16 * 0.22 - 0.148 * 0.208), "barrel": 60.0, "piston": 40.0}
MASS |= {"jib": 7850 * JIB * (0.12 * 0.18 - 0.11 * 0.17), "load": 800.0}  # kg


def energy(length: float, fold: float) -> float:
    """Potential energy, J, of the rigid crane with a cylinder of this length, m."""
    arm = FOOT - (0.0, HEAD)
    d = np.hypot(*arm)
    inner = np.arccos((d**2 + EYE**2 - length**2) / (2 * d * EYE))
    boom = np.arctan2(arm[1], arm[0]) + inner
    # the jib is level when the boom rises 3 on 4
    jib = boom - np.arctan2(3, 4) - fold
    eye = HEAD + EYE * np.sin(boom)
    tip = HEAD + BOOM * np.sin(boom) + JIB * np.sin(jib)
    up = (eye - FOOT[1]) / length
    heights = {
        "boom": HEAD + BOOM / 2 * np.sin(boom),
        "jib": tip - JIB / 2 * np.sin(jib),
        "barrel": FOOT[1] + 0.6 * up,
        "piston": eye - 0.6 * up,
        "load": tip - 2.0,
    }
    return G * sum(MASS[name] * z for name, z in heights.items())


def push(length: float, fold: float, step: float = 1e-5) -> float:
    """Force of the cylinder at rest by virtual work, N."""
    return (energy(length + step, fold) - energy(length - step, fold)) / (2 * step)


def ringing(t: np.ndarray, x: np.ndarray, low: float, high: float) -> float:
    """Frequency, Hz, between low and high that is strongest in the acceleration of a signal."""
    a = np.hanning(len(t)) * np.gradient(np.gradient(x, t), t)
    grid = np.arange(low, high, 1e-3)
    size = [abs(np.sum(a * np.exp(-2j * np.pi * f * t))) for f in grid]
    return float(grid[int(np.argmax(size))])


def draw(
    t: np.ndarray, panels: list[tuple[str, str, list[tuple[np.ndarray, str]]]], path: Path
) -> None:
    """One panel beside the other; the first line of each solid, the others dashed."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(1, len(panels), figsize=(12, 3.6), layout="constrained")
        for ax, (title, unit, lines) in zip(axes, panels, strict=True):
            for i, (values, label) in enumerate(lines):
                dashed = {"linestyle": (0, (5, 2)), "zorder": 3} if i else {}
                ax.plot(t, values, color=COLORS[i], label=label, **dashed)
            ax.set_title(title, **bold)
            ax.set(xlabel="time (s)", ylabel=unit)
            ax.legend()
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Run the file, compare and draw; return 0 if forces and frequencies are right."""
    out.mkdir(parents=True, exist_ok=True)
    file = jo.read_model(MODEL)
    model = jo.compile(file.mechanism)
    run = jo.simulate(model, file.simulation.t_end, **file.simulation.given(model))
    t = run.time
    row = next(joint.row for joint in model.joints if joint.name == "luffing")
    force = np.ravel(run["cylinder"])

    end = jo.simulation.State(run.q[-1], 0 * run.v[-1], run.multipliers[-1], t[-1])
    rest = jo.equilibrium(model, end)
    length = jo.SCurve((4.5, 6.0), (2.25, 2.45))(t)
    fold = jo.SCurve((1.0, 4.0), (0.0, np.radians(20)))(t)
    statics = np.array([push(L, a) for L, a in zip(length, fold, strict=True)])
    before, after = force[0], -rest.lam[row]
    worst = max(abs(before / statics[0] - 1), abs(after / statics[-1] - 1))
    factor = (force / statics).max()

    found = jo.modes(model, rest).frequencies
    late = t > STOP
    side = run["tip"] @ (-np.sin(np.pi / 6), np.cos(np.pi / 6), 0.0)
    rings = {
        "to the side": ringing(t[late], side[late], 2.5, 6.0),
        "up and down": ringing(t[late], run["tip"][late, 2], 1.0, 2.5),
    }
    print(f"cylinder at the start {before / 1e3:.3f} kN, virtual work {statics[0] / 1e3:.3f} kN")
    print(f"cylinder at the end   {after / 1e3:.3f} kN, virtual work {statics[-1] / 1e3:.3f} kN")
    print(f"dynamic factor        {factor:.3f}")
    print("modes at the end     ", ", ".join(f"{f:.3f}" for f in found[:5]), "Hz")
    off = []
    for name, f in rings.items():
        nearest = found[np.argmin(np.abs(found - f))]
        off.append(abs(f / nearest - 1))
        print(f"the tip rings {name} with {f:.3f} Hz, mode {nearest:.3f} Hz")
    panels = [
        ("Force of the cylinder", "kN", [(force / 1e3, "jousto"), (statics / 1e3, "at rest")]),
        (
            "Height of tip and load",
            "m",
            [(run["tip"][:, 2], "tip"), (run["load"][:, 2] + 2, "load + 2 m")],
        ),
        (
            "Stress of the boom at the eye",
            "MPa",
            [(run["boom"][:, 0] / 1e6, "top"), (run["boom"][:, 6] / 1e6, "bottom")],
        ),
    ]
    draw(t, panels, out / "crane.png")
    jo.still(run, out / "crane_still.png", times=(0.0, 4.0, 6.0), trail="tip")

    good = worst < 0.01 and max(off) < 0.02 and 1.0 < factor < 2.0
    print("the crane lifts as it must" if good else "THE CRANE IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
