"""Andrews' squeezer: seven bars, three loops, a spring and a motor, to its published solution.

Data and the angles at 0.03 s: Hairer and Wanner, *Solving Ordinary Differential Equations II*,
section VI.9; Mazzia and Magherini, *Test Set for Initial Value Problem Solvers*. The crank makes
two and a half turns in that time; ten revolute joints repeat nine rows, which changes nothing.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

Z = (0.0, 0.0, 1.0)
END = 0.03  # s
GROUND = {"O": (0, 0), "A": (-0.06934, -0.00227), "B": (-0.03635, 0.03273), "C": (0.014, 0.072)}
# heading at the start rad, mass kg, inertia kg m2, centre, points; all from the pivot, in m
BARS = {
    "K1": (-0.06171389014, 0.04325, 2.194e-6, (92e-5, 0), {"end": (7e-3, 0)}),
    "K2": (-0.06171389014, 0.00365, 4.410e-7, (-115e-4, 0), {"meet": (-28e-3, 0)}),
    "K3": (
        *(0.45527981916, 0.02373, 5.255e-6, (1043e-5, -1874e-5)),
        {"meet": (0, -35e-3), "spring": (2e-2, -18e-3)},
    ),
    "K5": (0.48736497954, 0.07050, 1.169e-5, (2308e-5, 916e-5), {"end": (4e-2, 0)}),
    "K4": (0.71003336993, 0.00706, 5.667e-7, (0, 1421e-5 - 2e-2), {"meet": (0, -2e-2)}),
    "K7": (1.23054744455, 0.05498, 1.912e-5, (1228e-5, -449e-5), {"end": (0, -4e-2)}),
    "K6": (1.00787905438, 0.00706, 5.667e-7, (2e-2 - 1421e-5, 0), {"meet": (2e-2, 0)}),
}
HELD = {"K1": "O", "K2": "K1", "K3": "B", "K5": "A", "K4": "K5", "K7": "A", "K6": "K7"}
START = {"K1": -0.0617138900142764, "K3": 0.455279819163070, "K5": 0.487364979543842}
PUBLISHED = {"K1": 15.81077119629904, "K3": 0.04082224013073101, "K5": 0.5244099658805304}
NAMES = {"K1": "crank", "K3": "bar at the spring", "K5": "lower bar"}


def squeezer() -> jo.Mechanism:
    """The mechanism, with the angles of three of its bars."""
    bodies: dict[str, jo.RigidBody] = {}
    joints = []
    for bar, (heading, mass, inertia, centre, points) in BARS.items():
        turn = jo.Rotate(Z, degrees=np.degrees(heading))
        held = HELD[bar]
        at = bodies[held]["end"] if held in bodies else jo.ground.at((*GROUND[held], 0.0))
        bodies[bar] = jo.RigidBody(
            bar,
            mass,
            (0.5 * inertia, 0.5 * inertia, inertia),
            center=(*centre, 0.0),
            markers={name: (*x, 0.0) for name, x in points.items()},
            position=at.r,
            orientation=turn,
        )
        joints.append(jo.Revolute(f"{bar} pivot", at, bodies[bar]["origin"], Z))
    meet = bodies["K2"]["meet"]
    joints += [jo.Revolute(f"K2-{k}", meet, bodies[k]["meet"], Z) for k in ("K3", "K4", "K6")]
    fixed = jo.ground.at((*GROUND["C"], 0.0))
    spring = jo.Spring.between("spring", fixed, bodies["K3"]["spring"], 4530.0, free=0.07785)
    sensors = [jo.CoordinateSensor(k, joints[list(BARS).index(k)].angle) for k in PUBLISHED]
    motor = jo.JointForce("motor", joints[0].angle, 0.033)
    return jo.Mechanism(*bodies.values(), *joints, spring, motor, *sensors, name="squeezer")


def angles(run: jo.Solution) -> np.ndarray:
    """Angles (nt, 3) of the three bars."""
    return np.stack([START[k] + run[k][:, 0] for k in PUBLISHED], axis=1)


def draw(time: np.ndarray, found: np.ndarray, errors: dict, path: Path) -> None:
    """Angles over time with the published ones, and the error against the number of steps."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.6), layout="constrained")
        for k, (bar, color) in enumerate(zip(PUBLISHED, COLORS, strict=False)):
            shown = (1.0, 10.0, 10.0)[k]
            label = NAMES[bar] + (" (10 times)" if shown > 1 else "")
            left.plot(1e3 * time, shown * found[:, k], color=color, label=label)
            left.plot(1e3 * END, shown * PUBLISHED[bar], "o", color=color, clip_on=False)
        left.set_title("Angles and published values", **bold)
        left.set(xlabel="time (ms)", ylabel="rad")
        left.legend()
        for (name, (steps, error)), color in zip(errors.items(), COLORS, strict=False):
            right.loglog(steps, error, "o-", color=color, label=name)
        right.set_title("Error of the crank's angle", **bold)
        right.set(xlabel="steps", ylabel="rad", xlim=(250, 8000))
        right.minorticks_off()
        right.set_xticks([300, 1000, 3000], ["300", "1000", "3000"])
        right.legend()
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Run with three methods, compare and draw; return 0 if the published angles are met."""
    out.mkdir(parents=True, exist_ok=True)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", jo.JoustoWarning)
        model = jo.compile(squeezer())
    print(str(said[-1].message)[:96] + "...")
    best = jo.simulate(model, END, solver=jo.RK4(step=2e-6), output_step=1e-4)
    wanted = np.array(list(PUBLISHED.values()))
    miss = np.abs(angles(best)[-1] - wanted)
    errors = {}
    for method, counts in (
        (jo.RK4, (300, 600, 1200)),
        (jo.ROS2, (1500, 3000, 6000)),
        (jo.GeneralizedAlpha, (750, 1500, 3000)),
    ):
        runs = [
            jo.simulate(model, END, solver=method(step=END / n), output_step=END) for n in counts
        ]
        errors[method.__name__] = counts, [abs(angles(r)[-1, 0] - wanted[0]) for r in runs]
    for bar, value, off in zip(PUBLISHED, angles(best)[-1], miss, strict=True):
        print(f"{NAMES[bar]:18} {value:.9f} rad, off by {off:.1e}")
    draw(best.time, angles(best), errors, out / "squeezer.png")
    good = miss.max() < 1e-8 and len(said) == 1
    print("the published angles are met" if good else "THE SQUEEZER IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
