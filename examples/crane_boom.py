"""A crane's boom is made light: least mass while a trolley drives out and the crane slews.

The boom of 12 m is a box girder in three pieces with walls of 6 mm; the heights of the pieces are
sought. It slews a quarter turn in 4 s while the wheels of a trolley drive out to its tip. Stress
and the tip's deflection are limited at all instants. Equivalent static loads of order 0 and 1 are
compared: constant loads end at a design that is not the lightest, loads that follow the design to
first order at one where the conditions of an optimum hold. Direct optimisation of the runs, which
starts there, stays there.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path

import jousto as jo
from jousto.design import DisplacementLimit, MachineProblem, Optimum, StressLimit, optimise

STEEL = jo.Material(210e9, 0.3, 7850, name="steel")
PIECE, WALL, TURN = 4.0, 6e-3, 1.5708  # m, m, rad
WHEELS = 5e3  # N
STRESS, DEFLECTION = 120e6, 0.1  # Pa, m
PIECES, BOUNDS = ("root", "middle", "tip"), (0.15, 0.8)  # m
STAYS = 1e-3
"""How far direct optimisation may move from an optimum, as a share of the bounds."""


def parts(heights: Mapping[str, float], wall: float = WALL) -> dict[str, jo.Part]:
    """The boom: box girders, 0.6 times as wide as high."""
    pieces = [
        jo.Member(
            (PIECE * i, 0, 0),
            (PIECE * (i + 1), 0, 0),
            jo.Box(0.6 * height, height, web=wall),
            STEEL,
            elements=2,
            name=name,
        )
        for i, (name, height) in enumerate(heights.items())
    ]
    return {"boom": jo.Part.from_members(pieces, name="boom")}


def crane(
    heights: Mapping[str, float], parts: Mapping[str, jo.Part], wheels: float = WHEELS
) -> jo.Mechanism:
    """The boom on its slewing drive, the trolley on its way out."""
    reduced = jo.reduce(parts["boom"], jo.CraigBampton(["root.start"], modes=6))
    boom = jo.FlexibleBody("boom", reduced, damping=0.01)
    slew = jo.Revolute("slew", jo.ground["origin"], boom["root.start"], axis=(0, 0, 1))
    trolley = jo.mechanism.MovingLoad(
        "trolley",
        boom,
        ("root.start", "tip.end"),
        (0, 0, -wheels),
        jo.SCurve((0.5, 4.5), (2.0, 3 * PIECE)),
    )
    return jo.Mechanism(
        boom,
        slew,
        jo.Drive("drive", slew.angle, jo.SCurve((0.0, 4.0), (0.0, TURN))),
        trolley,
        jo.Gravity((0, 0, -9.81)),
        name="crane boom",
    )


def problem(start: Mapping[str, float]) -> MachineProblem:
    """The search for the lightest boom, from the heights of its pieces at the start."""
    limits = [
        StressLimit("boom", STRESS),
        DisplacementLimit("boom", DEFLECTION, "tip.end", relative_to="root.start"),
    ]
    return MachineProblem(
        [jo.Parameter(name, start[name], bounds=BOUNDS, unit="m") for name in PIECES],
        parts,
        crane,
        limits,
        6.0,
        solver=jo.ROS2(step=4e-3),
        output_step=0.04,
    )


def away(one: Optimum, other: Optimum) -> float:
    """How far two designs are apart at most, as a share of the bounds."""
    return max(abs(one.values[name] - other.values[name]) for name in PIECES) / (
        BOUNDS[1] - BOUNDS[0]
    )


def main(out: Path) -> int:
    """Optimise; return 0 if order 1 is lighter than order 0 and direct optimisation stays there."""
    out.mkdir(parents=True, exist_ok=True)
    start = dict.fromkeys(PIECES, 0.4)
    # constant loads do not settle here: they go round between four designs
    classical = optimise(problem(start), order=0, cycles=8)
    first = optimise(problem(start), order=1, cycles=30)
    direct = optimise(problem(first.values), "direct")
    for found in (classical, first, direct):
        print(found)
        print()
    jo.plot(first, path=out / "crane_boom.png")
    saved = 1.0 - first.cost / classical.cost
    print(f"order 1 is lighter by {100 * saved:.2f} %")
    print(f"direct optimisation moves by {100 * away(first, direct):.4f} % of the bounds")
    good = first.converged and first.kkt < 1e-4 and first.ratio < 1.001 and saved > 0.001
    good = good and direct.converged and away(first, direct) < STAYS
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
