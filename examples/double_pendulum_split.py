"""One beam or two welded halves: the motion must not depend on how a beam is cut into bodies.

A steel beam falls about a hinge: as one flexible body, and as two or four bodies joined by fixed
joints. With more modes the descriptions approach one another. What is left is no error of the joint
but of the theory: within a body bending is linear, in the moving frame of that body. It falls with
the square of the number of pieces, for each piece bends less.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

LENGTH, ELEMENTS = 2.0, 16
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850, name="steel")
FEW, MANY = 2, 12  # fixed-interface modes of each body, in both planes


def pendulum(pieces: int, modes: int) -> jo.Mechanism:
    """A horizontal beam of so many bodies, hinged at its start."""
    length = LENGTH / pieces
    part = jo.Part.beam(length, jo.Rectangle(0.04, 0.06), ELEMENTS // pieces, STEEL)
    piece = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=modes))
    piece = piece.keep(piece.in_plane("xy"))
    bodies = [
        jo.FlexibleBody(f"piece{k + 1}", piece, position=(k * length, 0, 0)) for k in range(pieces)
    ]
    welds = [
        jo.Fixed(f"weld{k + 1}", a["end"], b["start"])
        for k, (a, b) in enumerate(zip(bodies, bodies[1:], strict=False))
    ]
    return jo.Mechanism(
        *bodies,
        *welds,
        jo.Revolute("hinge", jo.ground["origin"], bodies[0]["start"], axis=(0, 0, 1)),
        jo.Gravity((0.0, -9.81, 0.0)),
        jo.PositionSensor("tip", bodies[-1]["end"]),
        name=f"pendulum of {pieces}",
    )


def simulate(pieces: int, modes: int) -> jo.Solution:
    """Let it fall for 1.5 s."""
    model = jo.compile(pendulum(pieces, modes))
    return jo.simulate(model, 1.5, solver=jo.ROS2(2e-4), output_step=2e-3)


def apart(a: jo.Solution, b: jo.Solution) -> np.ndarray:
    """Distance of the two tips, (nt,) m."""
    return np.asarray(np.linalg.norm(a["tip"] - b["tip"], axis=1))


def main(out: Path) -> int:
    """Compare one, two and four bodies; return 0 if they agree better and better."""
    out.mkdir(parents=True, exist_ok=True)
    runs = {
        (pieces, modes): simulate(pieces, modes)
        for pieces, modes in ((1, FEW), (2, FEW), (1, MANY), (2, MANY), (4, MANY))
    }
    curves = {
        f"one and two bodies, {FEW} modes each": apart(runs[1, FEW], runs[2, FEW]),
        f"one and two bodies, {MANY} modes each": apart(runs[1, MANY], runs[2, MANY]),
        f"two and four bodies, {MANY} modes each": apart(runs[2, MANY], runs[4, MANY]),
    }
    print("largest distance of the tips in 1.5 s, on a path of 4 m")
    for name, distance in curves.items():
        print(f"  {name:38}{1e6 * distance.max():8.1f} µm")

    with plt.style.context(STYLE):
        figure, ax = plt.subplots(figsize=(8, 3.8), layout="constrained")
        for color, (name, distance) in zip(COLORS, curves.items(), strict=False):
            largest = 1e6 * np.maximum.accumulate(distance)[1:]
            ax.semilogy(runs[1, FEW].time[1:], largest, color=color, label=name)
        ax.set_title("Largest distance of the tips so far", loc="left", fontweight="bold")
        ax.set(xlabel="time (s)", ylabel="µm", ylim=(1e-2, None))
        ax.legend(loc="lower right")
        figure.savefig(out / "split.png")
        plt.close(figure)
    both = {"one body": runs[1, MANY], "two bodies": runs[2, MANY]}
    jo.plot(both, "tip", path=out / "split_tip.png")
    jo.animate(runs[4, MANY], out / "split_still.png", stills=9, trail="tip")

    few, many, finer = (float(distance.max()) for distance in curves.values())
    good = many < few / 5 and finer < many / 3 and many < 4e-5
    print("cut or not, the motion is the same" if good else "THE MOTIONS DIFFER")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
