"""How probably does a robot's arm last ten years? Reliability, and a wall that is thick enough.

The arm lifts a payload every 2.4 s. Payload, wall and the S-N curve of its welds scatter. FORM
finds the most probable failure, importance sampling and Monte Carlo check it, SORA finds the wall
with a reliability index of 3. All of them ask one study, which simulates a point once; the scatter
of the S-N curve is a factor of the life that is asked for and costs no runs.

``--samples 1000`` samples more, ``--dask`` simulates points side by side on a Dask cluster.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto import design
from jousto.output.style import COLORS, STYLE

ALUMINIUM = jo.Material(70e9, 0.33, 2700, name="aluminium")
LENGTH, DIAMETER, PERIOD = 0.8, 0.14, 2.4  # m, m, s
WELD = jo.SN(S_D=12.5e6, N_D=2e6, k=3, rule="elementary")  # amplitude, half of the welds survive
COUNT = {"criterion": "s11", "residue": "repeat"}
WALL = jo.Parameter("wall", 4e-3, (3e-3, 12e-3), unit="m", distribution="normal(sd=0.15 mm)")
PAYLOAD = jo.Parameter("payload", 15.0, unit="kg", distribution="lognormal(cov=0.15)")
SCATTER = jo.Parameter("scatter", 1.0, distribution="lognormal(cov=0.5)")
YEARS, TARGET = 10, 3.0


def robot(wall: float, payload: float) -> jo.Mechanism:
    """Upper arm on its shoulder, forearm and payload: up, and down again."""
    part = jo.Part.beam(LENGTH, jo.Tube(DIAMETER, wall), 4, ALUMINIUM, name="arm")
    reduced = jo.reduce(part, jo.CraigBampton(["start", "end"], modes=5))
    damping = jo.Rayleigh.from_ratios((8.0, 0.05), (80.0, 0.05))
    arm = jo.FlexibleBody("arm", reduced.keep(reduced.in_plane("xz")), damping=damping)
    inertia = (0.01, 0.3, 0.3)
    fore = jo.RigidBody("forearm", 5.0, inertia, position=(LENGTH, 0, 0), center=(0.4, 0, 0))
    load = jo.RigidBody.sphere("payload", 0.1, mass=payload, position=(2 * LENGTH, 0, 0))
    shoulder = jo.Revolute("shoulder", jo.ground["origin"], arm["start"], axis=(0, 1, 0))
    elbow = jo.Revolute("elbow", arm["end"], fore["origin"], axis=(0, 1, 0))
    grip = jo.Fixed("grip", fore.at((LENGTH, 0, 0)), load["origin"])
    times = (0.0, 1.1, 1.2, 2.3)
    motors = (
        jo.Drive("motor 1", shoulder.angle, jo.SCurve(times, (0.3, -0.7, -0.7, 0.3))),
        jo.Drive("motor 2", elbow.angle, jo.SCurve(times, (0.0, 1.2, 1.2, 0.0))),
    )
    return jo.Mechanism(arm, fore, load, shoulder, elbow, grip, *motors, jo.Gravity((0, 0, -9.81)))


def analyse(study: design.Study, limit: design.LimitState, samples: int) -> tuple[Any, Any, bool]:
    """FORM, two samplings and the wall by SORA; whether they agree."""
    start = perf_counter()

    def show(result: Any) -> Any:
        print(result, f"\n    {study.counts['runs']} runs, {perf_counter() - start:.0f} s so far")
        return result

    found = show(design.form(limit))
    close = show(design.importance_sampling(found, samples=samples, confidence=0.99, seed=1))
    plain = show(design.monte_carlo(limit, samples=samples, confidence=0.99, seed=1))
    between = study.parameters[0].bounds
    assert between is not None
    cost, bounds = (lambda d: 1e3 * d["wall"]), {"wall": between}
    better = show(design.rbdo(cost, [limit], bounds=bounds, beta=TARGET, tolerance=1e-3))
    print("importance:", ", ".join(f"{k} {100 * v:.0f} %" for k, v in found.importance.items()))
    # tangents leave some of the index; the intervals of both samplings must have common values
    good = abs(close.beta - found.beta) < 0.2
    good = good and max(close.low, plain.low) < min(close.high, plain.high)
    return found, better, good and abs(better.betas[limit.name] - TARGET) < 0.01


def draw(study: design.Study, found: design.FormResult, path: Path) -> None:
    """Life over wall and payload, with the design point on the limit surface."""
    walls, payloads = np.linspace(3.4e-3, 4.6e-3, 4), np.linspace(8, 30, 5)
    table = study.run({"wall": walls, "payload": payloads})
    years = table["life"].reshape(len(walls), len(payloads)).T / (365.25 * 86400)
    scatter = found.x["scatter"]
    with plt.style.context(STYLE):
        figure, ax = plt.subplots(figsize=(6, 4), layout="constrained")
        surface, levels = (1e3 * walls, payloads, np.log(years)), np.log([15, 30, 60, 120])
        lines = ax.contour(*surface, levels, colors=COLORS[7])
        ax.clabel(lines, fmt=lambda level: f"{np.exp(level):.0f} years")
        ax.contour(*surface, [np.log(YEARS / scatter)], colors=COLORS[1])
        ax.plot(1e3 * WALL.value, PAYLOAD.value, "o", color=COLORS[0], label="as built")
        label = f"most probable failure: {scatter:.2f} times the life"
        ax.plot(1e3 * found.x["wall"], found.x["payload"], "s", color=COLORS[1], label=label)
        ax.set_title("Median life", loc="left", fontweight="bold")
        ax.set(xlabel="wall (mm)", ylabel="payload (kg)")
        ax.legend(loc="upper right")
        figure.savefig(path)
        plt.close(figure)


def main(out: Path, samples: int, workers: Any) -> int:
    """Analyse, redesign and draw; return 0 if the samples agree with FORM."""
    life = design.Damage("life", "arm", life=True, sn=WELD, options=COUNT)
    study = jo.study(
        robot,
        [WALL, PAYLOAD],
        [life, "mass(arm)"],
        t_end=PERIOD,
        solver=jo.ROS2(step=4e-3),
        output_step=0.016,
        state=jo.simulation.vibration_free_state,
    )
    text = f"life >= {YEARS} years / scatter"
    limit = design.limit_state(study, text, parameters=[SCATTER], workers=workers)
    found, better, good = analyse(study, limit, samples)
    walls = (WALL.value, better.design["wall"])
    before, after = study([[wall, PAYLOAD.value] for wall in walls])[:, 1]
    print(f"arm of {before:.2f} kg, then {after:.2f} kg with a wall of {1e3 * walls[1]:.2f} mm")
    jo.plot(found, path=out / "robot_arm_importance.png")
    jo.plot(better, path=out / "robot_arm_redesign.png")
    draw(study, found, out / "robot_arm_life.png")
    return 0 if good else 1


def command(main: Callable[[Path, int, Any], int], samples: int) -> int:
    """Call main with the arguments of the command line."""
    parser = argparse.ArgumentParser()
    parser.add_argument("out", type=Path, nargs="?", default=Path("out"))
    parser.add_argument("--samples", type=int, default=samples)
    parser.add_argument("--dask", action="store_true")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    if not given.dask:
        return main(given.out, given.samples, 1)
    from distributed import Client

    with Client(threads_per_worker=1) as client:
        return main(given.out, given.samples, client)


if __name__ == "__main__":
    sys.exit(command(main, samples=60))
