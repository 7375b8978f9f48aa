"""A boom of four exact beams spins up about a pivot beside its axis: what inertia tangents save.

The example of Makinen, Marjamaki and Pajunen, *Nopeudesta riippuvien hitausvoimatermien vaikutus
palkkilaskentaan* (Tampere University of Technology), section 5. Without an argument it runs to
0.442 s; with ``--long`` also their second run, to 1.997 s, and the run that shears off.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE
from jousto.planar import (
    Convergence,
    PlanarBeam,
    PlanarDamping,
    PlanarElement,
    PlanarFrame,
    PlanarLoad,
    PlanarNewmark,
    PlanarRun,
    PlanarSection,
    PlanarSupport,
    inertia_share,
    simulate_planar,
)

A, I, E, RHO = 1900e-6, 3.756e-6, 207e9, 7850.0  # m2, m4, Pa, kg/m3
Pair = tuple[PlanarRun, PlanarRun]
ABSOLUTE = Convergence(residual=1e-3)  # the tolerance of the paper, read as N and N m


def boom(GA: float = E * A, element: str | PlanarElement = "exact", n: int = 4) -> PlanarFrame:
    """A boom of 4 m on a pivot 0.5 m beside its axis, and a moment that grows with t^6."""
    section = PlanarSection(EA=E * A, GA=GA, EI=E * I, mass=RHO * A, rotary=RHO * I)
    moment = PlanarLoad(0, moment=2e6, signal=lambda t: t if t <= 1.0 else t**6)
    return PlanarFrame(
        [(0.0, -0.5), *((4.0 * i / n, 0.0) for i in range(1, n + 1))],
        [
            PlanarBeam(0, 1, section, offset_a=(0.0, 0.5)),
            *(PlanarBeam(i, i + 1, section) for i in range(1, n)),
        ],
        supports=[PlanarSupport(0)],
        loads=[moment],
        damping=PlanarDamping(mass=0.1),
        element=element,
    )


def spin(
    step: float, t_end: float, tangents: bool, convergence: Convergence = ABSOLUTE
) -> PlanarRun:
    """Run until the end or until Newton's iteration gives up, as the paper does."""
    method = PlanarNewmark(step, damping=0.001)
    return simulate_planar(
        *(boom(), t_end, method), convergence=convergence, inertia_tangents=tangents, partial=True
    )


def rpm(run: PlanarRun) -> np.ndarray:
    """Speed of the pivot."""
    return run.velocities[:, 0, 2] * 30 / np.pi


def compare(step: float, t_end: float) -> Pair:
    """Run with and without the velocity-dependent tangents and print one line for each."""
    runs = spin(step, t_end, True), spin(step, t_end, False)
    for run, name in zip(runs, ("with", "without"), strict=True):
        counts = f"{run.evaluations.sum():6d} residuals {run.solves.sum():6d} solves"
        print(f"step {step:.0e} s {name:8} {run.steps:6d} steps {counts} {rpm(run)[-1]:8.0f} rpm")
    return runs


def criteria() -> None:
    """How the counts depend on what the paper does not say: its criterion."""
    for text, rule in (
        ("residual 1e-3 N", ABSOLUTE),
        ("residual 1 N", Convergence(residual=1.0)),
        ("relative 1e-6", Convergence(relative=1e-6)),
        ("increment 1e-6", Convergence(increment=1e-6)),
        ("increment 1e-3", Convergence(increment=1e-3)),
    ):
        on, off = (
            spin(1e-3, 0.442, tangents, rule).evaluations.sum() for tangents in (True, False)
        )
        print(f"{text:16} {on:6d} with, {off:6d} without: {on / off:.3f}")


def shears_off() -> None:
    """GA = 5/6 G A: the linear law loses its stability, and the program says so."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            simulate_planar(boom(5 / 6 * E / 2.6 * A), 1.1, PlanarNewmark(1e-4, 0.001))
        except jo.SimulationError as error:
            print(error)
        print(*(item.message for item in caught), sep="\n")


def draw(coarse: Pair, fine: Pair, path: Path) -> None:
    """Speed, work and the share of K_acc."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    with plt.style.context(STYLE):
        figure, (left, middle, right) = plt.subplots(1, 3, figsize=(11, 3.5), layout="constrained")
        left.plot(fine[0].time, rpm(fine[0]), color=COLORS[0], label="step 1e-4 s")
        left.plot(coarse[0].time[:443], rpm(coarse[0])[:443], color=COLORS[1], label="step 1e-3 s")
        left.plot([0.442, 1.997], [3762, 17724], "o", color=COLORS[7], label="paper")
        left.set_title("Speed", **bold)
        left.set(xlabel="time (s)", ylabel="rpm")
        left.legend()
        names = "with K$_{acc}$, C$_{acc}$", "without"
        for run, color, name in zip(fine, COLORS, names, strict=False):
            middle.plot(run.time, np.cumsum(run.evaluations), color=color, label=name)
        middle.set_title("Residuals evaluated", **bold)
        middle.set(xlabel="time (s)")
        middle.legend()
        every = np.arange(0, fine[0].steps, max(1, fine[0].steps // 400))
        right.plot(rpm(fine[0])[every], inertia_share(fine[0], every), color=COLORS[0])
        right.set_title("||K$_{acc}$|| / ||K||", **bold)
        right.set(xlabel="rpm")
        figure.savefig(path)
        plt.close(figure)


def main(out: Path, long: bool) -> int:
    """Run, compare and draw; return 0 if speeds and savings are those of the paper."""
    out.mkdir(parents=True, exist_ok=True)
    coarse, fine = compare(1e-3, 0.442), compare(1e-4, 2.0 if long else 0.442)
    criteria()
    if long:
        shears_off()
    draw(coarse, fine, out / "offset_boom.png")
    good = abs(rpm(coarse[0])[442] / 3762 - 1) < 2e-3
    saved = [1 - a.evaluations.sum() / b.evaluations.sum() for a, b in (coarse, fine)]
    good &= 0.15 < saved[0] < 0.22
    if long:
        good &= abs(rpm(fine[0])[19970] / 17724 - 1) < 1e-3 and 0.33 < saved[1] < 0.38
    print(f"the tangents save {100 * saved[0]:.0f} % and {100 * saved[1]:.0f} % of the residuals")
    return 0 if good else 1


if __name__ == "__main__":
    words = [word for word in sys.argv[1:] if word != "--long"]
    sys.exit(main(Path(words[0] if words else "out"), "--long" in sys.argv))
