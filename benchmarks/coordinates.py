"""One step of three machines in positions of the bodies, joint coordinates and natural coordinates.

    .venv/bin/python benchmarks/coordinates.py

Unknowns, rows, and processor time of a step, least of several runs in loops of the engine. The
moving frame is Python: its time contains sensors and energies at the stored instants, here one in
ten steps. The table is printed as it stands in docs/coordinates.md.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

import jousto as jo
from jousto.schema.read import read_model
from trees import arm, chain, mechanism, ours

CRANE = Path(__file__).parents[1] / "examples" / "crane.yaml"
STEP, STEPS, REPEATS = 1e-3, 100, 5  # s, steps of the moving frame


def natural(machine: jo.Mechanism) -> float:
    """Milliseconds of a step of the moving frame."""
    best = {STEPS: np.inf, 2 * STEPS: np.inf}
    for _ in range(REPEATS):
        for steps in best:
            begin = time.process_time()
            jo.natural.moving_frame(machine, steps * STEP, step=STEP, output_step=10 * STEP)
            best[steps] = min(best[steps], time.process_time() - begin)
    return 1e3 * (best[2 * STEPS] - best[STEPS]) / STEPS


def row(name: str, machine: jo.Mechanism, method: str) -> str:
    model = jo.compile(machine, core="maximal")
    cells = [name, f"{model.nv}; {model.nrow}", f"{ours(model, method, REPEATS):.3g} us"]
    try:
        tree = jo.compile(machine, core="joint")
        cells += [f"{tree.nu}; 0", f"{ours(tree, method, REPEATS):.3g} us"]
    except jo.InputError:
        cells += ["refused", ""]
    n = sum(12 + body.n for body in model.bodies)
    rows = 6 * len(model.bodies) + model.nrow
    cells += [f"{n}; {rows}", f"{natural(machine):.2g} ms"]
    return "| " + " | ".join(cells) + " |"


if __name__ == "__main__":
    heads = "bodies", "a step", "joints", "a step", "natural", "a step"
    print("| machine | " + " | ".join(heads) + " |")
    print("|---" * 7 + "|")
    print(row("rigid six-axis arm, RK4", mechanism(arm()), "rk4"), flush=True)
    if "short" not in sys.argv:
        print(
            row("rigid chain of 30 hinges, RK4", mechanism(chain("hinge", 30)), "rk4"), flush=True
        )
        print(row("flexible crane, ROS2", read_model(CRANE).mechanism, "ros2"), flush=True)
