"""Spin-up of a slender beam, with and without geometric stiffening.

The model is ``spin_up.yaml``: a beam of 10 m is brought to 6 rad/s in 15 s. It lags behind while it
is accelerated and is pulled straight by its own spin. Kane, Ryan and Banerjee (1987) showed that
linear modes miss this: the faster they spin, the softer they are, until the beam folds up. The
lowest point is compared with a chain of rigid links and springs, extrapolated to the beam
(``tests/verification/spin_up.py``).
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

MODEL = Path(__file__).with_name("spin_up.yaml")
LENGTH = 10.0  # m, as in the file
LOWEST = -0.57376  # m, the chain of links


def spin(speed: float, *, stiffening: bool) -> tuple[np.ndarray, np.ndarray, list[str]]:
    """Time, deflection of the tip across the turning axis of the hub, and what jousto warned of."""
    text = MODEL.read_text(encoding="utf-8")
    # another speed: all three terms of the turn
    for number in ("0.2", "2.2797266319525994", "90"):
        text = text.replace(f" {number} rad", f" {float(number) * speed / 6.0!r} rad")
    text = text.replace("stiffening: true", f"stiffening: {str(stiffening).lower()}")
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", jo.JoustoWarning)
        path = Path(folder) / MODEL.name
        path.write_text(text, encoding="utf-8")
        file = jo.read_model(path)
        given = file.simulation.given()
        run = jo.simulate(jo.compile(file.mechanism), file.simulation.t_end, **given)
        (drive,) = file.mechanism.couplings
        assert isinstance(drive, jo.Drive)
        angle = drive.signal(run.time)
        x, y = run["tip"][:, :2].T
        said = [str(w.message) for w in caught]
        return run.time, np.cos(angle) * y - np.sin(angle) * x, said


def draw(curves: dict[str, tuple[np.ndarray, np.ndarray]], fast: dict, path: Path) -> None:
    """Deflection over time at 6 and at 12 rad/s."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(9.5, 3.6), layout="constrained")
        for ax, lines, speed in zip(axes, (curves, fast), (6, 12), strict=True):
            for color, (label, (time, bend)) in zip(COLORS, lines.items(), strict=False):
                ax.plot(time, bend, color=color, label=label)
            ax.set_title(f"Deflection of the tip, up to {speed} rad/s", **bold)
            ax.set(xlabel="time (s)", ylabel="m")
            ax.legend()
        axes[0].axhline(LOWEST, color="0.5", linewidth=0.8, linestyle=(0, (5, 3)))
        axes[1].set_ylim(-3.0, 3.0)
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Run four times, compare and draw; return 0 if the stiffened beam is right."""
    out.mkdir(parents=True, exist_ok=True)
    time, stiff, quiet = spin(6.0, stiffening=True)
    _, linear, said = spin(6.0, stiffening=False)
    _, fast_stiff, _ = spin(12.0, stiffening=True)
    _, fast_linear, _ = spin(12.0, stiffening=False)
    names = ("with stiffening", "linear modes")
    draw(
        dict(zip(names, ((time, stiff), (time, linear)), strict=True)),
        dict(zip(names, ((time, fast_stiff), (time, fast_linear)), strict=True)),
        out / "spin_up.png",
    )
    print(f"lowest point, 6 rad/s   {stiff.min():.4f} m, chain of links {LOWEST:.4f} m")
    print(f"with linear modes       {linear.min():.4f} m")
    print(f"farthest, 12 rad/s      {np.abs(fast_stiff).max():.3f} m")
    print(f"with linear modes       {np.abs(fast_linear).max():.1f} m, it folds up")
    print("\n".join(said))

    good = abs(stiff.min() - LOWEST) < 5e-4 and not quiet and len(said) == 1
    good = good and np.abs(fast_stiff).max() < 1.0 < LENGTH < np.abs(fast_linear).max()
    print("the beam is stretched as it must" if good else "THE BEAM IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
