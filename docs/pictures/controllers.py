"""Draw the step response of a servo for three settings.

.venv/bin/python docs/pictures/controllers.py FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import jousto as jo
from jousto.output.style import COLORS, STYLE

MASS, OMEGA, GOAL = 2.0, 8.0, 0.25  # kg, rad/s, m


def follow(zeta: float, limit: float | None) -> jo.Solution:
    """Run the cart of the page on controllers."""
    cart = jo.RigidBody("cart", MASS, (0.1, 0.1, 0.1))
    rail = jo.Prismatic("rail", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    kp, kd = MASS * OMEGA**2, 2 * zeta * MASS * OMEGA
    hold = jo.Servo("hold", rail.displacement, GOAL, kp, kd, limit)
    sensors = jo.CoordinateSensor("place", rail.displacement), jo.ForceSensor("force", hold)
    model = jo.compile(jo.Mechanism(cart, rail, hold, *sensors))
    return jo.simulate(model, 1.5, solver=jo.RK4(1e-3))


def main(folder: Path) -> None:
    """Position and force beside each other."""
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.0), layout="constrained")
        for color, (zeta, limit) in zip(
            COLORS, ((0.5, None), (1.0, None), (1.0, 10.0)), strict=False
        ):
            run = follow(zeta, limit)
            label = f"damping ratio {zeta:g}" + (f", limit {limit:g} N" if limit else "")
            left.plot(run.time, run["place"], color=color, label=label)
            right.plot(run.time, run["force"], color=color)
        left.axhline(GOAL, color="0.6", linewidth=0.8)
        left.set(xlabel="time (s)", ylabel="position (m)")
        right.set(xlabel="time (s)", ylabel="force of the servo (N)")
        left.legend()
        figure.savefig(folder / "controllers.png")
        plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
