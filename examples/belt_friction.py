"""Stick and slip of a block on a moving belt, against the closed form.

The model is ``belt_friction.yaml``. A spring k holds a block m on a belt of speed v. It sticks
until the spring pulls with mu_static m g and slips under mu_kinetic m g until its speed is v again.
With D = (mu_static - mu_kinetic) m g / k and w = sqrt(k / m) it sticks for 2 D / v and slips for
2 / w (pi - atan(D w / v)), between x = mu_kinetic m g / k +- sqrt(D**2 + (v / w)**2).
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

MODEL = Path(__file__).with_name("belt_friction.yaml")
M, K, V, STATIC, KINETIC, G = 1.0, 100.0, 0.1, 0.4, 0.2, 9.81  # SI, as in the file
D, W = (STATIC - KINETIC) * M * G / K, np.sqrt(K / M)
STICK, SLIP = 2 * D / V, 2 / W * (np.pi - np.arctan(D * W / V))
MIDDLE, REACH = KINETIC * M * G / K, np.hypot(D, V / W)


def exact(t: np.ndarray) -> np.ndarray:
    """Position of the block, from rest on the belt at x = 0, m."""
    late = np.mod(t, STICK + SLIP)
    slipped = late - STICK
    slipping = MIDDLE + D * np.cos(W * slipped) + V / W * np.sin(W * slipped)
    return np.where(late < STICK, MIDDLE - D + V * late, slipping)


def smooth(velocity: float, end: float) -> jo.Solution:
    """Run the same machine with the regularised law."""
    mechanism = jo.read_model(MODEL).mechanism
    rub = mechanism.frictions[0]
    law = jo.mechanism.Regularised(velocity)
    other = jo.Friction(rub.name, rub.joint, KINETIC, STATIC, law=law)
    items = [other if item is rub else item for item in mechanism.items]
    model = jo.compile(jo.Mechanism(*items))
    return jo.simulate(model, end, solver=jo.RK4(2e-4), output_step=1e-3)


def draw(run: jo.Solution, soft: jo.Solution, path: Path) -> None:
    """Position in time and speed over position."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.6), layout="constrained")
        left.plot(run.time, 1e3 * run["block"][:, 0], color=COLORS[0], label="stick-slip")
        left.plot(
            *(run.time, 1e3 * exact(run.time)),
            color=COLORS[1],
            linestyle=(0, (5, 2)),
            label="closed form",
        )
        left.set_title("Position of the block", **bold)
        left.set(xlabel="time (s)", ylabel="x (mm)", ylim=(-6, 56))
        left.legend(loc="upper right", ncols=2)
        for one, color, label in ((run, 0, "stick-slip"), (soft, 2, "regularised, 5 mm/s")):
            x, speed = 1e3 * one["block"][:, 0], 1e3 * one["speed"][:, 0]
            right.plot(x, speed, color=COLORS[color], label=label)
        right.axhline(1e3 * V, color="0.6", linewidth=0.8, zorder=0)
        right.set_title("Speed over position", **bold)
        right.set(xlabel="x (mm)", ylabel="mm/s")
        right.legend(loc="center")
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Run both laws, compare and draw; return 0 if the motion is that of the closed form."""
    out.mkdir(parents=True, exist_ok=True)
    file = jo.read_model(MODEL)
    run = jo.simulate(jo.compile(file.mechanism), file.simulation.t_end, **file.simulation.given())
    soft = smooth(5e-3, file.simulation.t_end)
    x = run["block"][:, 0]
    miss = np.abs(x - exact(run.time)).max()
    rubbed = run.energy.friction
    falls_nowhere = bool((np.diff(rubbed) >= 0).all())
    print(f"sticks for {STICK:.5f} s, slips for {SLIP:.8f} s")
    print(f"range of the block   {1e3 * x.min():.4f} to {1e3 * x.max():.4f} mm")
    print(f"closed form          {1e3 * (MIDDLE - REACH):.4f} to {1e3 * (MIDDLE + REACH):.4f} mm")
    print(f"off the closed form  {1e9 * miss:.4f} nm")
    print(f"lost to friction     {rubbed[-1]:.6f} J, falls nowhere: {falls_nowhere}")
    print(f"largest energy error {np.abs(run.energy.error).max():.1e} J")
    draw(run, soft, out / "belt_friction.png")

    good = miss < 1e-9 and falls_nowhere
    print("the block sticks and slips as it must" if good else "THE BLOCK IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
