"""A six-axis robot of flexible links swings a pane of glass: torques, deviation, residual ringing.

The model is ``robot.yaml``: all six axes turn at once along S-curves of 0.8 s. The torques of the
run must follow those of inverse dynamics of the rigid robot, and equal them at rest. The corner of
the glass leaves the path of the rigid robot by some millimetres: by the bending that
`inverse_dynamics` of the flexible robot gives, without vibration, and by the ringing about it,
which after the stop must have a natural frequency of the robot in its last pose.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

MODEL = Path(__file__).with_name("robot.yaml")
STOP = 1.0  # s


def torques(run: jo.Solution) -> np.ndarray:
    """Torques of the six motors (instants, 6), N m."""
    return np.stack([np.ravel(run[f"motor {axis}"]) for axis in range(1, 7)], axis=1)


def ringing(t: np.ndarray, x: np.ndarray) -> float:
    """Strongest frequency of a decaying signal, Hz."""
    x = np.hanning(len(t)) * (x - x.mean())
    grid = np.arange(5.0, 40.0, 0.01)
    size = [abs(np.sum(x * np.exp(-2j * np.pi * f * t))) for f in grid]
    return float(grid[int(np.argmax(size))])


def draw(t: np.ndarray, panels: list, path: Path) -> None:
    """One panel beside the other; of each the first line solid, the others dashed."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(1, len(panels), figsize=(12, 3.6), layout="constrained")
        for ax, (title, unit, lines) in zip(axes, panels, strict=True):
            for i, (values, label) in enumerate(lines):
                dashed = {"linestyle": (0, (5, 2)), "zorder": 3} if i else {}
                ax.plot(t, values, color=COLORS[i], label=label, **dashed)
            ax.set_title(title, **bold)
            ax.set(xlabel="time (s)", ylabel=unit)
            ax.legend()
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Run the file, compare and draw; return 0 if torques and ringing are right."""
    out.mkdir(parents=True, exist_ok=True)
    file = jo.read_model(MODEL)
    model = jo.compile(file.mechanism)
    run = jo.simulate(model, file.simulation.t_end, **file.simulation.given(model))
    t = run.time
    stiff = jo.compile(jo.read_model(MODEL, rigid=True).mechanism)
    rigid = jo.simulation.inverse_dynamics(stiff, t)
    # every fourth instant of the motion will do, and the last one
    few = np.append(np.flatnonzero(t < STOP + 0.01)[::4], len(t) - 1)
    bent = jo.simulation.inverse_dynamics(model, t[few])

    drive, ideal = torques(run), torques(rigid)
    largest = np.abs(ideal).max(axis=0)
    rms = np.sqrt(((drive - ideal) ** 2).mean(axis=0)) / largest
    # axes 1 and 6 are vertical at the start and carry nothing at rest
    rest = np.abs(drive[-100:].mean(axis=0) - ideal[-1])[1:5] / largest[1:5]

    away, quiet = (
        1e3 * np.linalg.norm(a["corner"] - b, axis=1)
        for a, b in ((run, rigid["corner"]), (bent, rigid["corner"][few]))
    )
    late = t > STOP + 0.05
    heard = ringing(t[late], drive[late, 5])
    end = jo.simulation.State(run.q[-1], 0 * run.v[-1], run.multipliers[-1], t[-1])
    found = jo.modes(model, jo.equilibrium(model, end)).frequencies
    nearest = found[np.argmin(np.abs(found - heard))]

    print("largest torques, rigid     ", " ".join(f"{x:7.1f}" for x in largest), "N m")
    print("flexible, root mean square ", " ".join(f"{100 * x:6.1f}%" for x in rms))
    print(f"at rest within {100 * rest.max():.2f} % of the largest")
    print(f"corner of the glass away from the rigid robot by up to {away.max():.2f} mm")
    print(f"of this by bending alone   {quiet.max():.2f} mm")
    print(f"it rings with {heard:.2f} Hz, mode {nearest:.2f} Hz")
    panels = [
        ("Torque of axis 2", "N m", [(drive[:, 1], "flexible"), (ideal[:, 1], "rigid")]),
        ("Torque of axis 6", "N m", [(drive[:, 5], "flexible"), (ideal[:, 5], "rigid")]),
        (
            "Corner of the glass, off the rigid robot",
            "mm",
            [(away, "with vibration"), (np.interp(t, t[few], quiet), "bending alone")],
        ),
    ]
    draw(t, panels, out / "robot.png")
    jo.still(run, out / "robot_still.png", times=(0.0, 0.6, 1.2), trail="corner")

    good = rms[:5].max() < 0.05 and rest.max() < 0.01 and abs(heard / nearest - 1) < 0.02
    print("the robot moves as it must" if good else "THE ROBOT IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
