"""A crane watched by eight strain gauges: stress where no gauge sits, with its band, and the load.

The folding crane of ``crane.yaml`` is simulated once as the truth: finer mesh, more modes, less
damping, and a payload in gusts of wind that the twin does not know. The twin gets the strains of
eight gauges on the boom with 2 um/m of noise, and the positions of the three drives with 0.2 mrad
and 0.2 mm of noise. It finds its own noise from the record, and says what the stress is at eight
other places, within which band, and what damage follows.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.measurement.twin import Band, damage_band, smooth, stress_band, tune
from jousto.output.style import COLORS, STYLE

MODEL = Path(__file__).with_name("crane.yaml")
FINER = {
    "elements: 8": "elements: 16",
    "elements: 6": "elements: 12",
    "[start, node4, end], modes: 3": "[start, node7, end], modes: 10",
    "boom.node4": "boom.node7",
    "beta: 2 ms": "beta: 1.3 ms",
    "mass: 800 kg": "mass: 690 kg",
}
GAUGES = "2.top 2.left 3.bottom 3.right 5.top_left 5.bottom_right 7.top 7.left".split()
HOT = "4.top 4.bottom 4.left 4.top_right 6.bottom 3.top_left 6.top_left 8.bottom".split()
E, NOISE, T_END = 2.1e11, 2e-6, 8.0  # Pa, m/m, s


def rows(part: jo.ReducedPart, places: list, finer: int = 1) -> np.ndarray:
    """Stress along the boom per mode at the start of elements, on a mesh finer times as fine."""
    labels = list(part.stress.labels)
    sites = [place.split(".") for place in places]
    index = [labels.index(f"e{finer * (int(k) - 1) + 1}.a.{point}") for k, point in sites]
    return part.stress.modes[index, 0]


def truth(out: Path, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times, strains of the gauges and stress of the hot spots of the finer crane."""
    text = MODEL.read_text(encoding="utf-8")
    for old, new in FINER.items():
        text = text.replace(old, new)
    path = out / "finer.yaml"
    path.write_text(text, encoding="utf-8")
    crane = jo.read_model(path).mechanism
    path.unlink()
    load = next(body for body in crane.bodies if body.name == "load")
    knots = np.arange(0.0, T_END + 0.75, 0.75)
    wind = [jo.Table(knots, 400.0 * rng.standard_normal(len(knots)), "cubic") for _ in "xy"]
    gusts = [jo.Force(f"gust {i}", load["center"], np.eye(3)[i], signal=wind[i]) for i in (0, 1)]
    model = jo.compile(jo.Mechanism(*crane.items, *gusts, name="truth"))
    start = jo.equilibrium(model)
    run = jo.simulate(model, T_END, state=start, solver=jo.ROS2(2e-3), output_step=0.01)
    boom = next(body for body in run.bodies if body.name == "boom")
    p = run.q[:, boom.q_offset + 7 : boom.q_offset + 7 + boom.n]
    part = next(b.reduced for b in crane.bodies if isinstance(b, jo.FlexibleBody))
    return run.time, p @ rows(part, GAUGES, 2).T / E, p @ rows(part, HOT, 2).T


def watch(t: np.ndarray, rng: np.random.Generator) -> jo.twin.Observer:
    """Return the observer of the boom: the crane without payload, its measured drives, loads."""
    whole = jo.read_model(MODEL).mechanism
    left_out = [x for x in whole.items if getattr(x, "name", "") in ("load", "hook")]
    left_out += whole.sensors
    known = [x for x in whole.items if all(x is not y for y in left_out)]
    crane = jo.Mechanism(*known, name="crane")
    drives = {x.name: x.signal for x in crane.couplings if isinstance(x, jo.Drive)}
    few = t[::5]
    measured = {k: s(few) + 2e-4 * rng.standard_normal(len(few)) for k, s in drives.items()}
    motion = jo.twin.Reference.from_angles(crane, "boom", few, measured, noise=2e-4)
    part = next(b.reduced for b in crane.bodies if isinstance(b, jo.FlexibleBody))
    loads = [
        jo.twin.UnknownLoad("start", "fx fy fz mz", rate=2e4, size=3e4, smooth=True),
        jo.twin.UnknownLoad("node4", "fx fz", rate=3e4, size=5e4, smooth=True),
        jo.twin.UnknownLoad("end", "fx fy fz mx my mz", rate=2e4, size=2e4, smooth=True),
    ]
    balance, B = jo.twin.Balance(60.0, 40.0), rows(part, GAUGES) / E
    given = {"damping": jo.Rayleigh(0.0, 2e-3), "noise": NOISE, "balance": balance}
    return jo.twin.Observer(part, B, loads=loads, step=0.01, reference=motion, **given)


def draw(t: np.ndarray, live: Band, true: np.ndarray, damage: list, path: Path) -> None:
    """Draw truth and band at the eye of the cylinder, the error in its band, and the damage."""
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
        value, low, high = (1e-6 * x[:, 0] for x in (live.value, live.low, live.high))
        axes[0].plot(t, 1e-6 * true[:, 0], color=COLORS[0], label="truth")
        axes[0].plot(t, value, color=COLORS[1], linestyle=(0, (5, 2)), label="twin")
        axes[0].set(ylabel="MPa")
        axes[1].fill_between(
            t, low - value, high - value, color=COLORS[1], alpha=0.25, label="95 %"
        )
        axes[1].plot(t, 1e-6 * true[:, 0] - value, color=COLORS[0], lw=0.8, label="truth - twin")
        axes[1].set(ylabel="MPa")
        band, exact = damage
        at = np.arange(len(HOT))
        ends = [100 * (x / exact - 1) for x in (band.low, band.high)]
        axes[2].vlines(at, *ends, color=COLORS[1], lw=6, alpha=0.5, label="95 %")
        axes[2].axhline(0.0, color=COLORS[0], label="truth")
        axes[2].set(xticks=at, xlim=(-0.7, 7.7), ylabel="% of the true damage")
        axes[2].set_xticklabels(HOT, rotation=60, fontsize=7)
        names = ("Stress at the eye, no gauge there", "Error and band", "Damage at eight places")
        for ax, name in zip(axes, names, strict=True):
            ax.set_title(name, loc="left", fontweight="bold", fontsize=10.5, pad=8)
            ax.legend()
        for ax in axes[:2]:
            ax.set(xlabel="time (s)")
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Simulate, watch and compare; return 0 if the bands hold what they say."""
    out.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(5)
    t, e, true = truth(out, rng)
    e += NOISE * rng.standard_normal(e.shape)
    observer = watch(t, rng)
    observer = tune(observer, t[::2], e[::2])
    observed = observer.run(t, e)
    part = observer.reduced
    sites = ["e" + x.replace(".", ".a.") for x in HOT]
    live = stress_band(observed, part, "s11", sites=sites)
    late = stress_band(smooth(observed), part, "s11", sites=sites)
    sn = jo.SN(S_D=60e6, N_D=2e6, k=5, rule="elementary")
    settings = {"residue": "half", "sites": sites, "criterion": "s11", "draws": 30}
    band = damage_band(observed, part, sn, **settings)
    meter = jo.model.DamageMeter(sn, residue="half", n=len(HOT))
    meter.push(true)
    exact = meter.damage()
    print(live)
    print(band)
    inside, after = live.inside(true), late.inside(true)
    held = (band.low <= exact) & (exact <= band.high)
    print(f"in its band: live {100 * inside.mean():.1f} %, smoothed {100 * after.mean():.1f} %")
    print(f"life in its band at {held.sum()} of {len(HOT)} places")
    draw(t, live, true, [band, exact], out / "crane_twin.png")
    good = 0.92 < inside.mean() < 0.98 and 0.92 < after.mean() < 0.99 and held.sum() >= 7
    print("the twin knows what it does not know" if good else "THE TWIN IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
