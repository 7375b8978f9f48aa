"""Draw the motion of exact beams beside published and exact references, from the tests.

.venv/bin/python docs/pictures/beam_dynamics.py FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

ROOT = Path(__file__).parent.parent.parent
sys.path[:0] = [str(ROOT / "tests")]

import jousto as jo
from jousto.output.style import COLORS, STYLE
from verification import (
    test_beam_dynamics_buckling as buckling,
    test_beam_dynamics_elbow as elbow,
    test_beam_dynamics_flight as flight,
    test_beam_dynamics_shaft as shaft,
)
from verification.beams_dynamic import whirls
from verification.test_beam_dynamics_frequencies import STIFF, L

DOTS = {"linestyle": "none", "marker": "o", "markersize": 4, "markerfacecolor": "white"}


def draw_elbow(ax) -> None:  # type: ignore[no-untyped-def]
    run = elbow.pushed(10, 16.0, 0.02, mass=0.5)
    for name, points, color in (("elbow", elbow.ELBOW, COLORS[0]), ("tip", elbow.TIP, COLORS[1])):
        ax.plot(run.time, run[name][:, 2], color=color, label=name)
        ax.plot(*points.T, color=color, **DOTS)
    ax.plot(*elbow.KRYSL.T, color=COLORS[1], **{**DOTS, "marker": "s"})
    ax.set(xlabel="time", ylabel="out of the plane")
    ax.set_title("right-angle cantilever (Simo, Vu-Quoc)", loc="left", fontsize=9.5)
    ax.legend(frameon=False, fontsize=8)


def draw_buckling(ax) -> None:  # type: ignore[no-untyped-def]
    for n, color in ((10, COLORS[1]), (20, COLORS[0])):
        run = buckling.run_of(n, 0.25, 5e-4)
        ax.plot(run.time, 1e3 * run["middle"][:, 1], color=color, label=f"{n} elements")
    t, y = buckling.EXUDYN[:, :2].T
    ax.plot(t, 1e3 * y, color=COLORS[-1], label="EXUDYN, 20", **DOTS)
    ax.set(xlabel="time, s", ylabel="middle of the blade aside, mm")
    ax.set_title("lateral buckling (IFToMM)", loc="left", fontsize=9.5)
    ax.legend(frameon=False, fontsize=8)


def draw_shaft(ax) -> None:  # type: ignore[no-untyped-def]
    run, z = shaft.run_up(16, 2.5, 1e-3, mass=0.5, bending=True)
    exact = shaft.deflection(run.time)
    ax.plot(run.time, 1e3 * np.abs(z), color=COLORS[0], label="16 elements")
    ax.plot(run.time, 1e3 * np.abs(exact), "--", color=COLORS[1], label="Laval's rotor")
    ax.set(xlabel="time, s", ylabel="deflection of the disc, mm")
    ax.set_title("through the critical speed (IFToMM)", loc="left", fontsize=9.5)
    ax.legend(frameon=False, fontsize=8)


def draw_orders(ax) -> None:  # type: ignore[no-untyped-def]
    numbers = np.array([4, 6, 8, 12, 16, 24, 32])
    exact = whirls(STIFF, L, 1)[2]
    for label, options, color in (
        ("lumped", {"share": 0.0}, COLORS[0]),
        ("consistent", {"share": 1.0}, COLORS[1]),
        ("lumped, bending", {"share": 0.0, "bending": True}, COLORS[2]),
    ):
        e = [abs(whirls(STIFF, L, 1, elements=n, **options)[2] / exact - 1) for n in numbers]
        ax.loglog(numbers, e, "o-", markersize=4, color=color, label=label)
    steps = np.array([0.02, 0.01, 0.005, 0.0025])
    misses = []
    for h in steps:
        model = jo.compile(flight.flying(6, loads=False, mass=0.5, **flight.SPIN))
        run = jo.simulate(model, 1.0, solver=jo.GeneralizedAlpha(step=h, rho=0.8))
        H = flight.momenta(model, run, 6, 0.5)[:, 3:]
        misses.append(np.abs(H - H[0]).max() / np.abs(H[0]).max())
    ax.loglog(0.1 / steps, misses, "s--", markersize=4, color=COLORS[-1], label="spin in flight")
    ax.minorticks_off()
    ax.set_xticks([4, 8, 16, 32], ["4", "8", "16", "32"])
    ax.set(xlabel="elements; 0.1 s / step of the flight", ylabel="relative error")
    ax.set_title("first frequency; angular momentum", loc="left", fontsize=9.5)
    ax.legend(frameon=False, fontsize=7.5)


def main(folder: Path) -> None:
    """Four problems beside one another."""
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(2, 2, figsize=(9.5, 6.4), layout="constrained")
        for ax, draw in zip(
            axes.flat, (draw_elbow, draw_buckling, draw_shaft, draw_orders), strict=True
        ):
            draw(ax)
        figure.savefig(folder / "beam_dynamics.png", dpi=110)
        plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
