"""Which shape functions? Clamped, pinned and free ones on three beams.

A steel strip of 1 m is swung by a shaft that turns by 0.04 rad, pushed between two pins, and
pushed while it flies freely. The body has n eigenfunctions of a beam in closed form, clamped-free,
pinned-pinned or free-free, and is compared with one that has all modes of the mesh. Schwertassek,
Wallrapp and Shabana (1999) found that not the frame but the ends of the functions decide: with
those that the joints leave a few functions are enough, with others the error falls slowly, and the
stress where they cannot bend is wrong.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE
from jousto.reduction import BeamFunctions, ChordFrame, NodeFrame, ShapeFunctions, in_frame

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
PART = jo.Part.beam(
    1.0, jo.Rectangle(0.01, 0.02), 24, STEEL, name="strip", theory=jo.parts.EulerBernoulli()
)
NUMBERS = (1, 2, 3, 4, 6, 8, 10)
ENDS = ("clamped-free", "pinned-pinned", "free-free")
ORIGIN, Z = jo.ground["origin"], (0.0, 0.0, 1.0)
TIME, PULSE = 0.12, 0.03  # s
GRID = np.linspace(0.0, PULSE, 61)
SWING = jo.Table(GRID, 0.02 * (1.0 - np.cos(np.pi * GRID / PULSE)), "cubic")  # rad
PUSH = jo.Table(GRID, np.sin(np.pi * GRID / PULSE) ** 2, "cubic")
CASES = {
    "swung by a shaft": "e1.a.right",
    "between two pins": "e12.b.right",
    "flying freely": "e12.b.right",
}


def machine(case: str, reduced: jo.ReducedPart) -> jo.Mechanism:
    """The strip in one of the three cases, with its deflection (m) and stress (Pa)."""
    rod = jo.FlexibleBody("strip", reduced)
    stress = jo.StressSensor("stress", rod, (CASES[case],))
    start, end = rod["start"], rod["end"]
    if case == "swung by a shaft":
        hub = jo.RigidBody("hub", 1.0, (0.1, 0.1, 0.1))
        shaft = jo.Revolute("shaft", ORIGIN, hub["origin"], Z)
        turn = jo.Drive("turn", shaft.angle, SWING)
        seen = jo.PositionSensor("bend", end, relative_to=hub["origin"])
        root = jo.Fixed("root", hub["origin"], start)
        return jo.Mechanism(hub, rod, shaft, turn, root, seen, stress)
    push = jo.Force("push", rod["node9"], (0.0, 100.0, 0.0), signal=PUSH)
    if case == "flying freely":
        # the force alone connects it to the world
        return jo.Mechanism(rod, push, jo.PositionSensor("bend", end), stress)
    pin = jo.Revolute("pin", ORIGIN, start, Z)
    roller = jo.PointOnLine("roller", jo.ground.at((1.0, 0.0, 0.0)), end, (1.0, 0.0, 0.0))
    return jo.Mechanism(rod, push, pin, roller, jo.PositionSensor("bend", rod["node13"]), stress)


def motion(case: str, reduced: jo.ReducedPart) -> tuple[np.ndarray, np.ndarray]:
    """Position y of the end or middle (m) and stress along the fibre (Pa) over time."""
    with warnings.catch_warnings():
        # jousto says which functions leave out most of a load: that is what is measured here
        warnings.simplefilter("ignore", jo.JoustoWarning)
        run = jo.simulate(jo.compile(machine(case, reduced)), TIME, output_step=5e-4)
    return run["bend"][:, 1], run["stress"][:, 0]


def errors(case: str, ends: str, full: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Largest errors of deflection and stress over their largest values, (2, numbers)."""
    found = []
    for n in NUMBERS:
        reduced = jo.reduce(PART, ShapeFunctions(BeamFunctions(ends, n, across="y")))
        pairs = zip(motion(case, reduced), full, strict=True)
        found.append([np.abs(x - y).max() / np.abs(y).max() for x, y in pairs])
    return np.array(found).T


def frames(case: str) -> float:
    """Largest difference of the motion from three frames over the largest, by good functions."""
    ends = ENDS[list(CASES).index(case)]
    six = jo.reduce(PART, ShapeFunctions(BeamFunctions(ends, 6, across="y")))
    mean, _ = motion(case, six)
    seen = [in_frame(six, frame) for frame in (NodeFrame("start"), ChordFrame("start", "end"))]
    return float(max(np.abs(motion(case, r)[0] - mean).max() for r in seen) / np.abs(mean).max())


def draw(table: dict[str, dict[str, np.ndarray]], path: Path) -> None:
    """Error over number of functions, a picture for each case."""
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(1, 3, figsize=(10.5, 3.6), layout="constrained", sharey=True)
        for ax, (case, lines) in zip(axes, table.items(), strict=True):
            for color, (ends, (bend, stress)) in zip(COLORS, lines.items(), strict=False):
                ax.loglog(NUMBERS, bend, "o-", color=color, markersize=3, label=ends)
                ax.loglog(NUMBERS, stress, "--", color=color, linewidth=1)
            ax.set_title(case, loc="left", fontweight="bold", fontsize=10.5, pad=8)
            ax.set(xlabel="number of functions", xticks=NUMBERS, xticklabels=map(str, NUMBERS))
            ax.minorticks_off()
        axes[0].set_ylabel("error of deflection (dashed: stress)")
        axes[0].legend(title="functions", loc="lower left")
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Run all cases, print and draw the errors; return 0 if they say what is known."""
    out.mkdir(parents=True, exist_ok=True)
    whole = jo.reduce(PART, jo.CraigBampton(("start", "node9", "end"), modes=40))
    whole = whole.keep(whole.in_plane("xy"))
    table: dict[str, dict[str, np.ndarray]] = {}
    moved = 0.0
    for case in CASES:
        full = motion(case, whole)
        print(f"{case}: bends by {1e3 * np.abs(full[0]).max():.2f} mm", end=", ")
        print(f"{1e-6 * np.abs(full[1]).max():.1f} MPa")
        table[case] = {ends: errors(case, ends, full) for ends in ENDS}
        for ends, (bend, _) in table[case].items():
            print(f"  {ends:14}", "  ".join(f"{x:7.1e}" for x in bend))
        moved = max(moved, frames(case))
    print(f"three frames, the same functions: {moved:.1e} apart")
    draw(table, out / "shape_functions.png")

    shaft, pins, free = ({k: v[0] for k, v in table[case].items()} for case in CASES)
    good = shaft["clamped-free"][3] < 1e-3 < 0.1 < shaft["free-free"][-1]
    good = good and pins["pinned-pinned"][0] < 0.01 < 0.1 < pins["clamped-free"][1]
    good = good and free["free-free"][1] < 0.05 < 0.1 < free["clamped-free"][1]
    # products of deformations: slopes are below a hundredth
    good = good and moved < 0.01
    print("the ends of the functions decide" if good else "THE FUNCTIONS ARE WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
