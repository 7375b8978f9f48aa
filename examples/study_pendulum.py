"""A study with a closed form: the period of a pendulum over its length and amplitude.

A pendulum that is let go from a large angle swings slower than a small one: its period is
``T = 2 pi sqrt(l / g) / agm(1, cos(a / 2))`` with the arithmetic-geometric mean (Gauss). The study
runs 9 lengths and 5 amplitudes, of which the last is no pendulum any more but stands on its head:
it never falls, and its outcome fails, which the table keeps. A second study lets both scatter.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import jousto as jo

G = 9.81  # m/s2


def pendulum(length: float, amplitude: float) -> jo.Mechanism:
    """Return a small mass on a massless rod, held at an angle from straight down, rad."""
    turned = jo.Rotate((0, 0, 1), radians=amplitude)
    bob = jo.RigidBody("bob", 1.0, (1e-9, 1e-9, 1e-9), center=(0, -length, 0), orientation=turned)
    pivot = jo.Revolute("pivot", jo.ground["origin"], bob["origin"])
    place = jo.PositionSensor("bob", bob.at((0, -length, 0)))
    return jo.Mechanism(bob, pivot, jo.Gravity((0, -G, 0)), place)


def period(run: jo.Solution) -> float:
    """Return four times the time to the lowest point, s."""
    x = run["bob.x"]
    below = np.flatnonzero(x <= 0.0)
    if not len(below):
        raise ValueError("it does not come down")
    k = below[0]
    t = run.time[k - 1 : k + 1]
    return float(4.0 * np.interp(0.0, [-x[k - 1], -x[k]], t))


def closed_form(length: np.ndarray, amplitude: np.ndarray) -> np.ndarray:
    """Return the period by the arithmetic-geometric mean."""
    a, b = np.ones_like(length), np.cos(amplitude / 2)
    for _ in range(8):
        a, b = (a + b) / 2, np.sqrt(a * b)
    return np.asarray(2 * np.pi * np.sqrt(length / G) / a)


def main(out: Path) -> int:
    """Run the studies, compare, draw."""
    out.mkdir(exist_ok=True)
    parameters = [
        jo.Parameter("length", 1.0, bounds=(0.25, 4.0), unit="m"),
        jo.Parameter("amplitude", 0.1, bounds=(0.1, np.pi), unit="rad"),
    ]
    study = jo.study(
        pendulum,
        parameters,
        jo.design.Function("period", period, measured_in="s"),
        t_end=3.0,
        solver=jo.RK4(2e-3),
    )
    angles = [*np.radians([10.0, 60.0, 120.0, 160.0]), np.pi]
    points = jo.design.grid(study.parameters, {"length": 9, "amplitude": angles})
    table = study.run(points, workers=2)
    print(table)

    good = table.good
    expected = closed_form(table["length"], table["amplitude"])
    error = np.abs(table["period"][good] / expected[good] - 1).max()
    print(f"largest error of the period {error:.1e}")

    rng = jo.design.sobol(study.parameters, 64)
    spread = study.run(rng, path=out / "spread.csv")
    jo.plot(table, path=out / "study_lines.png")
    jo.plot(spread, kind="surface", path=out / "study_surface.png")
    jo.plot(spread, kind="parallel", path=out / "study_parallel.png")
    (out / "spread.csv").unlink()
    (out / "spread.csv.jsonl").unlink()

    # linear interpolation between rows 2 ms apart, over quarters of 0.25 s and more
    right = error < 1e-4 and (~good).sum() == 9
    print("the pendulum swings as Gauss says" if right else "THE STUDY IS WRONG")
    return 0 if right else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
