"""Draw the bump of the page on plastic hinges for three laws.

.venv/bin/python docs/pictures/plastic_hinges.py FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import jousto as jo
from jousto.output.style import COLORS, STYLE

INERTIA = 200.0 / 3.0  # kg m2
LAWS = {
    "kinematic": {"kinematic": 2e4},
    "isotropic": {"isotropic": 2e4},
    "Armstrong-Frederick": {"kinematic": 6e4, "recovery": 30.0},
}


def bump(**law: float) -> jo.Solution:
    """Run the boom of the page."""
    body = jo.RigidBody("boom", 30.0, (INERTIA,) * 3, angular_velocity=(0, 0, 1.8))
    root = jo.Revolute("root", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    hinge = jo.mechanism.PlasticSpring("hinge", root.angle, 2e5, 3000.0, **law)
    sensors = jo.CoordinateSensor("angle", root.angle), jo.ForceSensor("moment", hinge)
    return jo.simulate(
        jo.compile(jo.Mechanism(body, root, hinge, *sensors)), 0.3, solver=jo.RK4(2e-4)
    )


def main(folder: Path) -> None:
    """Angle over time beside moment over angle."""
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9.0, 3.0), layout="constrained")
        for color, (label, law) in zip(COLORS, LAWS.items(), strict=False):
            run = bump(**law)
            left.plot(run.time, run["angle"], color=color, label=label)
            right.plot(run["angle"], -run["moment"] / 1e3, color=color)
        left.set(xlabel="time (s)", ylabel="angle of the boom (rad)")
        right.set(xlabel="angle of the boom (rad)", ylabel="moment of the hinge (kN m)")
        left.set_ylim(top=0.052)
        left.legend(loc="upper center", ncols=3)
        figure.savefig(folder / "plastic_hinges.png")
        plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
