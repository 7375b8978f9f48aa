"""Geometrically exact beams beside EXUDYN's: microseconds per step and the error they buy.

python benchmarks/beams.py        10, 100 and 1000 elements, about three minutes
python benchmarks/beams.py quick  10 and 100 elements
python benchmarks/beams.py short  10 elements, and no meshes compared: that everything runs

A strip of plastic hangs on a spherical joint, starts level and at rest and falls under gravity
that leans out of the plane; it swings and bends. The error is the largest component of the tip's
distance, at ten instants, from the same code at a fine step, so of the step alone;
*apart* is the distance of the two fine solutions on the same mesh. Both codes are of second order
in the step, so that the work at equal error is the time of a step times the root of its error.
"""

from __future__ import annotations

import os
import sys
import time
import warnings
from dataclasses import dataclass
from typing import Any

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from numpy.typing import NDArray

import exudyn_beams as peer
import jousto as jo
from jousto.model.native.header import places
from strips import LEANING, LENGTH, NU, RHO, UPRIGHT, WIDTH, E, mechanism

H = 1e-3  # s
INSTANTS = 10
ENDS = {10: 0.5, 100: 0.3, 1000: 0.05}  # s, what EXUDYN can do in the time


@dataclass(frozen=True)
class Cost:
    """A run of jousto."""

    microseconds: float
    newton: float
    tip: NDArray[np.float64]


def strip(gravity: tuple[float, float, float]) -> peer.Strip:
    """The same for EXUDYN."""
    section: Any = jo.Rectangle(WIDTH, WIDTH)
    G = E / (2 + 2 * NU)
    shear = (5 / 6) * G * section.A
    return peer.Strip(
        LENGTH,
        RHO * section.A,
        (RHO * (section.Iy + section.Iz), RHO * section.Iy, RHO * section.Iz),
        (E * section.A, shear, shear, G * section.J, E * section.Iy, E * section.Iz),
        gravity,
    )


def run(model: jo.Model, solver: Any, end: float, tries: int = 3) -> Cost:
    """The engine alone, the least of several runs."""
    best, steps = np.inf, round(end / solver.step)
    for _ in range(tries):
        engine = jo.model.Engine(model)
        native = engine.native_solver(
            solver.method, solver.step, solver.projection, **solver.options
        )
        rows = np.zeros((INSTANTS, engine.row_size))
        begin = time.process_time()
        status, _ = engine.run(native, steps, steps // INSTANTS, rows)
        best = min(best, time.process_time() - begin)
        assert status == "ok", f"{solver} stopped with status {status}"
    iterations = int(engine.counts.iterations) / steps
    at = 1 + model.nq + model.nv + model.nrow + len(places("jo_diagnostics"))
    return Cost(1e6 * best / steps, iterations, rows[:, at : at + 3])


def distance(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Largest component, mm."""
    return 1e3 * float(np.abs(a - b).max())


METHODS = {
    "ROS2": lambda h: jo.ROS2(step=h),
    "alpha": lambda h: jo.GeneralizedAlpha(step=h, tangent="exact"),
    "alpha, kept": lambda h: jo.GeneralizedAlpha(step=h, tangent="modified"),
}


def table(elements: int) -> None:
    """Print one mesh."""
    end = ENDS[elements]
    print(f"\n{elements} elements, {end} s at {1e3 * H:g} ms")
    print(f"{'':34s}{'us/step':>10s}{'us/node':>9s}{'Newton':>8s}{'error mm':>10s}{'order':>7s}")
    model = jo.compile(mechanism(elements, LEANING))
    fine = run(model, METHODS["alpha"](H / 16), end, 1).tip
    ours: list[tuple[str, float, float]] = []
    for name, solver in METHODS.items():
        if name == "alpha, kept" and elements > 100:
            continue
        cost = run(model, solver(H), end)
        error = distance(cost.tip, fine)
        half = distance(run(model, solver(H / 2), end, 1).tip, fine)
        ours.append((name, cost.microseconds, error))
        line(f"jousto {name}", cost, elements, error, half)
    falls = strip(LEANING)
    steps = {10: 16, 100: 8, 1000: 4}[elements]
    other = peer.run(peer.spatial, falls, elements, H / steps, end, True, tolerance=peer.TIGHT).tip
    theirs: list[tuple[float, float]] = []
    for modified in (False, True):
        if not modified and elements > 100:
            continue  # minutes
        cost = peer.run(
            peer.spatial, falls, elements, H, end, modified, 2 if elements < 1000 else 1
        )
        error = distance(cost.tip, other) / (1 - 1 / steps**2)
        theirs.append((cost.microseconds, error))
        kind = "modified Newton" if modified else "full Newton"
        line(f"EXUDYN spatial, {kind}", cost, elements, error, np.nan)
    fastest, its_error = min(theirs)
    print(
        f"fine solutions apart {distance(fine, other):.4f} mm; EXUDYN's faster one against jousto:"
    )
    for name, microseconds, error in ours:
        equal = fastest * np.sqrt(its_error) / (microseconds * np.sqrt(error))
        print(
            f"  {name:12s} a step {fastest / microseconds:6.1f}, at equal error {equal:6.1f} times"
        )
    flat = min(
        (peer.run(peer.planar, strip(UPRIGHT), elements, H, end, m, 2) for m in (False, True)),
        key=lambda cost: cost.microseconds,
    )
    print(f"EXUDYN's planar beam (3 of the 6 coordinates): {flat.microseconds:.1f} us/step")


def line(name: str, cost: Any, elements: int, error: float, half: float) -> None:
    """Print one row."""
    order = np.log2(error / half) if half > 0 else np.nan
    per_node = cost.microseconds / (elements + 1)
    print(
        f"{name:34s}{cost.microseconds:10.1f}{per_node:9.2f}{cost.newton:8.2f}"
        f"{error:10.4f}{order:7.2f}"
    )


def meshes() -> None:
    """Error of the mesh against 160 elements: plain, with bending and corrected mass, EXUDYN."""
    end = 0.3
    fine = run(jo.compile(mechanism(160, LEANING, True)), METHODS["alpha"](H / 8), end, 1).tip
    print(f"\nerror of the mesh at {end} s, mm")
    print(f"{'elements':>10s}{'jousto':>10s}{'order 3':>10s}{'EXUDYN':>10s}")
    for elements in (5, 10, 20, 40):
        errors = [
            distance(
                run(
                    jo.compile(mechanism(elements, LEANING, b)), METHODS["alpha"](H / 8), end, 1
                ).tip,
                fine,
            )
            for b in (False, True)
        ]
        other = peer.run(
            peer.spatial, strip(LEANING), elements, H / 8, end, True, tolerance=peer.TIGHT
        ).tip
        print(f"{elements:10d}{errors[0]:10.4f}{errors[1]:10.4f}{distance(other, fine):10.4f}")


def main() -> None:
    """Print the tables."""
    warnings.simplefilter("ignore")
    short, quick = (word in sys.argv[1:] for word in ("short", "quick"))
    for elements in (10,) if short else (10, 100) if quick else (10, 100, 1000):
        table(elements)
    if not short:
        meshes()


if __name__ == "__main__":
    main()
