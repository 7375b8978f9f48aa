"""Work-precision diagrams: processor time and error of every program that moves eight machines.

.venv/bin/python benchmarks/precision.py [short] [WORDS]

WORDS choose the machines whose names contain one of them; `short` takes one setting of each method.
Each program is measured against its own motion at a fine step, extrapolated where its error is of
second order; how far these motions of the programs are apart is given too. All runs of a machine
take turns; the least processor time of each counts. Prints the points and, of each program at the
same error, the time of the fastest method, interpolated between its points in logarithms.
"""

from __future__ import annotations

import argparse
import json
import os
import time
import warnings
from pathlib import Path
from typing import Any

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np
from numpy.typing import NDArray

import jousto as jo
import pinocchio_native
from precision_cases import CONTESTS, Contest, Curve, shorten
from precision_fronts import Point, fastest, front, levels, programs, time_at

Array = NDArray[np.float64]
ROUNDS, AGAIN = 5, 6.0  # rounds at most; s of processor time for repetitions of a machine
LONG = 1.5  # s: a run that takes longer is not repeated
ORDER = {"generalised alpha": 2, "GeneralizedAlpha": 2}  # extrapolated where two runs are given


def reference(curve: Curve, run: Any) -> Array | None:
    """Motion that a program converges to, from its finest runs; None if they fail."""
    found: list[Array] = []
    for setting in curve.fine:
        try:
            found.append(run(setting)[1])
        except ArithmeticError:
            continue
    if len(found) == 2:  # steps of ratio two, the finer one first
        share = 2.0 ** ORDER[curve.method]
        return np.asarray((share * found[0] - found[1]) / (share - 1.0))
    return found[0] if found else None


def measured(contest: Contest) -> tuple[list[Point], dict[str, Array], list[str]]:
    """Points without errors, with their motions; the reference of each program; who is left out."""
    points: list[Point] = []
    references: dict[str, Array] = {}
    left_out: list[str] = []
    for curve in contest.curves:
        try:
            run = curve.make()
        except (ImportError, ValueError) as error:
            left_out.append(f"{curve.program}, {curve.method}: {error}")
            continue
        truth = reference(curve, run)
        if truth is not None:
            references[curve.program] = truth
        for setting in curve.settings:
            point = {"program": curve.program, "method": curve.method, "setting": setting}
            try:
                spent, tip = run(setting)
            except (ArithmeticError, ImportError) as error:
                left_out.append(f"{curve.program}, {curve.method}, {label(setting)}: {error}")
                continue
            points.append(point | {"seconds": spent, "tip": tip, "run": run})
    repeat(points)
    return points, references, left_out


def repeat(points: list[Point]) -> None:
    """Take the least time of several rounds in which all runs take turns."""
    spent = 0.0
    for _ in range(ROUNDS - 1):
        for point in points:
            if point["seconds"] < LONG and spent < AGAIN:
                again = point["run"](point["setting"])[0]
                point["seconds"] = min(point["seconds"], again)
                spent += again


def contested(contest: Contest) -> dict[str, Any]:
    """What the results file stores of one machine."""
    points, references, left_out = measured(contest)
    for point in points:
        tip, truth = point.pop("tip"), references.get(point["program"])
        del point["run"]
        point["seconds"] /= contest.end  # of processor time for a second of motion
        point["error"] = None if truth is None else float(np.linalg.norm(tip - truth, axis=1).max())
    apart = {
        name: float(np.linalg.norm(truth - references["jousto"], axis=1).max())
        for name, truth in references.items()
        if name != "jousto" and "jousto" in references
    }
    return {"end": contest.end, "points": points, "apart": apart, "left out": left_out}


def label(setting: dict[str, Any]) -> str:
    """Return a setting in words."""
    return ", ".join(
        f"{k} {v:g}" if isinstance(v, float) else f"{k} {v}" for k, v in setting.items()
    )


def report(name: str, result: dict[str, Any]) -> None:
    """Print one machine."""
    points = result["points"]
    print(f"\n{name}, {result['end']:g} s")
    for p in points:
        setting = label(p["setting"])
        error = "" if p["error"] is None else f"{p['error']:8.1e} m"
        print(f"  {p['program']:12s}{p['method']:18s}{setting:44s}{p['seconds']:10.5f} s/s {error}")
    for program, gap in result["apart"].items():
        print(f"  motions of jousto and {program}: {gap:.1e} m apart")
    for sentence in result["left out"]:
        print(f"  left out: {sentence}")
    for error in levels(points):
        own = time_at(front(points, "jousto"), error)
        cells = [f"{fastest(points, 'jousto', error)} {own:.5f} s/s"]
        for program in programs(points)[1:]:
            other = time_at(front(points, program), error)
            if np.isfinite(other):
                cells.append(f"{program} {other / own:.1f} times")
        print(f"  at {error:.0e} m: {', '.join(cells)}")


def measure(words: list[str], short: bool = False) -> dict[str, Any]:
    """Measure and print the machines chosen; return what the results file stores of them."""
    found = {}
    for name, make in CONTESTS.items():
        if words and not any(word in name for word in words):
            continue
        begin = time.process_time()
        contest = make()
        if short:
            shorten(contest)
        found[name] = contested(contest)
        report(name, found[name])
        print(f"  measured in {time.process_time() - begin:.0f} s", flush=True)
    return found


def main() -> None:
    """Measure, print and store."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("words", nargs="*", help="only machines whose names contain one of them")
    parser.add_argument("--json", type=Path, help="file for the points")
    given = parser.parse_args()
    warnings.simplefilter("ignore", jo.JoustoWarning)
    short = "short" in given.words
    pinocchio_native.may_compile = not short
    found = measure([word for word in given.words if word != "short"], short)
    if given.json:
        given.json.write_text(json.dumps(found) + "\n")


if __name__ == "__main__":
    main()
