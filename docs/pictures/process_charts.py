"""Draw the flow charts of equivalent static loads, reliable design and stress of a moving part.

.venv/bin/python docs/pictures/process_charts.py FOLDER

After annexes 1 and 2 and table 1 of E. Altarriba, *Rasitusten alykas seuranta* (Lappeenranta 2010),
from its equations 1 to 24 and 101 to 103, in our own words.
"""

from __future__ import annotations

import sys
from pathlib import Path

from chart import Box, Chart

from jousto.output.style import COLORS

BLUE, ORANGE, GREEN, VIOLET = COLORS[:4]


def equivalent_loads(path: Path) -> None:
    """Draw the loop over the rigid machine and, in it, that over the vibrating component."""
    chart = Chart(8.8, 6.6)
    chart.frame(Box(2.4, 3.8, 3.9, 4.1), "Outer loop p'", "machine, all rigid", BLUE)
    chart.frame(Box(6.65, 3.2, 3.8, 5.3), "Inner loop p", "component, elastic", ORANGE)
    # steps
    start = chart.end(Box(2.4, 6.25, 2.6, 0.45), "First design b, p' = 0")
    run = chart.box(Box(2.4, 5.0, 3.0, 0.62), "Run the machine", "with the masses of b", BLUE)
    loads = chart.box(
        Box(2.4, 4.0, 3.0, 0.62), "Loads on the component", "F$_C$(t) of its joints", BLUE
    )
    same = chart.question(Box(2.4, 2.7, 3.4, 1.3), "changes of F$_C$(t)\n≤ ε$_1$ of its size?")
    found = chart.end(
        Box(2.4, 1.15, 3.0, 0.62), "Design found", "a flexible run shows its true peak", GREEN
    )
    shake = chart.box(Box(6.6, 5.0, 3.0, 0.62), "Vibration", "M z'' + D z' + K z = F(t)", ORANGE)
    still = chart.box(
        Box(6.6, 4.0, 3.0, 0.62),
        "Equivalent static loads",
        "f$_h$ = K z(t$_h$) at each instant",
        ORANGE,
    )
    best = chart.box(
        Box(6.6, 3.0, 3.0, 0.62),
        "Optimum of statics",
        "least cost within limits under all f$_h$",
        ORANGE,
    )
    done = chart.question(Box(6.6, 1.6, 2.8, 1.2), "|b$_{p+1}$ - b$_p$| ≤ ε$_2$?")
    # ways
    chart.down(start, run, loads, same)
    chart.down(shake, still, best, done)
    chart.arrow([same.bottom, found.top], "yes", (0.22, -0.2))
    chart.arrow([same.right, (4.52, same.y), (4.52, shake.y), shake.left], "no", (0.22, 0.13))
    chart.arrow([done.right, (8.33, done.y), (8.33, shake.y), shake.right], "no", (0.16, 0.13))
    back = [done.bottom, (done.x, 0.3), (0.22, 0.3), (0.22, run.y), run.left]
    chart.arrow(back, "yes, p' + 1", (-0.5, -0.25))
    chart.save(path)


def reliable_design(path: Path) -> None:
    """Draw the loop over designs and, in it, the search for the most probable point of failure."""
    chart = Chart(8.8, 7.3)
    chart.frame(Box(1.7, 4.2, 2.8, 3.7), "Designs", "cost W(b)", BLUE)
    chart.frame(Box(5.95, 3.2, 5.2, 5.7), "Each limit state G", "fails where G ≤ 0", ORANGE)
    start = chart.end(
        Box(1.7, 6.75, 2.8, 0.68), "First design b, scatter of X", "index β$_t$ of each limit state"
    )
    trial = chart.box(Box(1.7, 5.4, 2.3, 0.62), "Design b", "means of its scatter", BLUE)
    kept = chart.question(Box(1.7, 3.6, 2.5, 1.4), "all limits kept,\ncost least?")
    found = chart.end(
        Box(1.7, 1.6, 2.7, 0.62), "Reliable design", "samples check its tangents", GREEN
    )
    normal = chart.box(
        Box(5.95, 5.4, 4.4, 0.62),
        "Standard normal variables",
        "u = T(X): less probable with larger |u|",
        ORANGE,
    )
    index = chart.box(Box(4.45, 4.36, 1.9, 0.82), "RIA", "nearest point\nof G = 0: β = |u|", ORANGE)
    least = chart.box(
        Box(6.95, 4.36, 2.6, 0.82), "PMA", "least G on |u| = β$_t$\nalong n = -∇G / |∇G|", ORANGE
    )
    turn = chart.question(Box(6.95, 3.3, 2.6, 0.9), "G convex, ζ > 0?")
    mean = chart.box(Box(6.15, 2.35, 1.3, 0.62), "AMV", "u = β$_t$ n", VIOLET)
    three = chart.box(Box(7.75, 2.35, 1.3, 0.62), "CMV", "mean of 3 n", VIOLET)
    still = chart.question(Box(6.95, 1.4, 2.6, 0.8), "|u / β$_t$ - n| small?")
    verdict = chart.box(
        Box(5.0, 0.62, 2.9, 0.42), "kept if β ≥ β$_t$, or least G ≥ 0", color=ORANGE
    )
    # ways
    chart.down(start, trial)
    chart.arrow([trial.right, normal.left])
    chart.down(least, turn)
    for box in (index, least):
        chart.arrow([(box.x, normal.bottom[1]), box.top])
    chart.arrow([turn.bottom, (turn.x, 2.78), (mean.x, 2.78), mean.top], "yes", (-0.45, 0.02))
    chart.arrow([turn.bottom, (turn.x, 2.78), (three.x, 2.78), three.top], "no", (0.45, 0.02))
    for box in (mean, three):
        chart.arrow([box.bottom, (box.x, 1.92), (still.x, 1.92), still.top])
    chart.arrow([still.right, (8.48, still.y), (8.48, turn.y), turn.right], "no", (0.12, 0.12))
    chart.arrow([still.bottom, (still.x, verdict.y), verdict.right], "yes", (0.22, -0.12))
    chart.arrow([index.bottom, (index.x, verdict.top[1])])
    chart.arrow([verdict.left, (3.22, verdict.y), (3.22, kept.y), kept.right])
    chart.arrow([kept.left, (0.14, kept.y), (0.14, trial.y), trial.left], "no", (0.03, 0.14))
    chart.arrow([kept.bottom, found.top], "yes", (0.22, -0.2))
    chart.save(path)


def stress_of_motion(path: Path) -> None:
    """Draw the way from a part and a machine to displacement, stress and life of the part."""
    chart = Chart(8.8, 4.9)
    for x, name, note, color in (
        (1.5, "Part", "once", BLUE),
        (4.4, "Machine", "each run", ORANGE),
        (7.3, "Place p", "each run", GREEN),
    ):
        chart.frame(Box(x, 2.65, 2.7, 4.2), name, note, color)
    # steps
    mesh = chart.box(
        Box(1.5, 3.95, 2.3, 0.82), "Mesh", "interfaces at its joints\nmatrices K and M", BLUE
    )
    modes = chart.box(
        Box(1.5, 2.7, 2.3, 0.82), "Modes Φ", "static and normal ones,\northonormal", BLUE
    )
    fields = chart.box(
        Box(1.5, 1.45, 2.3, 0.82), "Stress modes Σ", "of Φ at every place,\nby Hooke's law", BLUE
    )
    bodies = chart.box(
        Box(4.4, 3.95, 2.3, 0.82), "Mechanism", "bodies, joints, drives,\nloads, friction", ORANGE
    )
    motion = chart.box(
        Box(4.4, 2.7, 2.3, 0.82),
        "Equations of motion",
        "unknown: R, A of the\nframe, modal q",
        ORANGE,
    )
    run = chart.box(
        Box(4.4, 1.45, 2.3, 0.82), "Motion", "R(t), A(t), q(t)\nat every instant", ORANGE
    )
    place = chart.box(
        Box(7.3, 3.95, 2.3, 0.82), "Displacement", "r = R + A (u$_0$ + u$_f$)\nu$_f$ = Φ q", GREEN
    )
    stress = chart.box(Box(7.3, 2.7, 2.3, 0.82), "Stress", "σ = Σ q\nranked hot spots", GREEN)
    life = chart.box(Box(7.3, 1.45, 2.3, 0.82), "Life", "rainflow cycles,\ndamage D", GREEN)
    # ways
    chart.down(mesh, modes, fields)
    chart.down(bodies, motion, run)
    chart.down(place, stress, life)
    chart.arrow(
        [(modes.right[0], 2.8), (2.95, 2.8), (2.95, bodies.y), bodies.left], "Φ", (0.16, 0.13)
    )
    chart.arrow([run.right, (5.88, run.y), (5.88, place.y), place.left], "q(t)", (0.16, 0.14))
    chart.arrow(
        [fields.bottom, (fields.x, 0.25), (8.6, 0.25), (8.6, stress.y), stress.right],
        "Σ",
        (0.16, -0.3),
    )
    chart.save(path)


def main(folder: Path) -> None:
    """Draw all charts."""
    equivalent_loads(folder / "esl_process.png")
    reliable_design(folder / "rbdo_process.png")
    stress_of_motion(folder / "stress_process.png")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
