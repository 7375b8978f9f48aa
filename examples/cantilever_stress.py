"""A cantilever under a slow tip force: stress in the sections against ``F (L - x) / W``.

The beam is held by a fixed joint to the ground. Its constraint modes contain the static shape under
a tip force exactly, so that after the transient the stress is that of the beam theory.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

LENGTH, WIDTH, HEIGHT = 1.2, 0.04, 0.06  # m
FORCE = 1500.0  # N, downwards
W = WIDTH * HEIGHT**2 / 6  # m3, section modulus
ELEMENTS = 6
S = np.linspace(0.0, 1.0, 121)
RAMP = jo.Table(0.6 * S, S**3 * (10 - 15 * S + 6 * S**2))  # smooth: a kink would make it ring


def cantilever() -> jo.Mechanism:
    """A steel beam along x with its height along z; the force grows for 0.6 s, then stays."""
    part = jo.Part.beam(
        length=LENGTH,
        section=jo.Rectangle(WIDTH, HEIGHT),
        elements=ELEMENTS,
        material=jo.Material(E=210e9, nu=0.3, rho=7850, name="steel"),
    )
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=4))
    beam = jo.FlexibleBody("beam", reduced, damping=0.05)
    mechanism = jo.Mechanism(
        beam,
        jo.Fixed("wall", jo.ground["origin"], beam["start"]),
        jo.Force("load", beam["end"], (0.0, 0.0, -FORCE), signal=RAMP),
        jo.StressSensor("root", beam, "e1.a.top"),
        jo.PositionSensor("tip", beam["end"]),
        name="cantilever",
    )
    return mechanism


def draw(run: jo.Solution, along: np.ndarray, path: Path) -> None:
    """Stress at the root against time, and along the beam at the end."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    theory = {"color": COLORS[1], "linestyle": (0, (5, 2)), "zorder": 3}
    x = np.linspace(0.0, LENGTH, ELEMENTS + 1)
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.6), layout="constrained")
        left.plot(run.time, 1e-6 * run["root"][:, 0], color=COLORS[0], label="jousto")
        left.plot(run.time, 1e-6 * RAMP(run.time) * FORCE * LENGTH / W, **theory, label="F L / W")
        left.set_title("Stress at the root, upper side", **bold)
        left.set(xlabel="time (s)", ylabel="MPa")
        left.legend()
        right.plot(x, 1e-6 * along, "o", color=COLORS[0], markerfacecolor="white", label="jousto")
        right.plot(x, 1e-6 * FORCE * (LENGTH - x) / W, **theory, label="F (L - x) / W")
        right.set_title("Stress along the upper side at the end", **bold)
        right.set(xlabel="x (m)", ylabel="MPa")
        right.margins(x=0.03)
        right.legend()
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Load, compare and draw; return 0 if the stress is right."""
    out.mkdir(parents=True, exist_ok=True)
    model = jo.compile(cantilever())
    run = jo.simulate(model, 0.8, solver=jo.ROS2(5e-4), output_step=2e-3)

    sites = [f"e{k + 1}.a.top" for k in range(ELEMENTS)] + [f"e{ELEMENTS}.b.top"]
    field = jo.stress_field(run, "beam")
    along = field.at(run.time[-1], sites)[:, 0]
    exact = FORCE * LENGTH / W
    error = run["root"][-1, 0] / exact - 1.0
    most = jo.hot_spots(field, count=1)[0]
    print(f"stress at the root        {1e-6 * run['root'][-1, 0]:.4f} MPa")
    print(f"closed form F L / W       {1e-6 * exact:.4f} MPa, relative difference {error:.1e}")
    print(f"largest von Mises stress  {1e-6 * most.value:.4f} MPa at {most.site}, {most.time:g} s")
    draw(run, along, out / "cantilever_stress.png")

    linear = np.abs(along - exact * np.linspace(1.0, 0.0, ELEMENTS + 1)).max() / exact
    good = abs(error) < 1e-4 and linear < 1e-4 and most.site.startswith("e1.a.")
    print("the stress is that of the closed form" if good else "THE STRESS IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
