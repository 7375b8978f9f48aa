"""How probably does a crane's boom last 20 years? Reliability of its welds, and a wall by SORA.

The boom of ``crane_boom.py`` at its least mass slews and drives its trolley out 60 times a day, on
300 days a year. Payload, wall and the S-N curve of its welds scatter. FORM finds the most probable
failure, importance sampling and Monte Carlo check it, SORA finds the wall with a reliability index
of 3. Each step prints its runs and its time.

``--samples 1000`` samples more, ``--dask`` simulates points side by side on a Dask cluster.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from crane_boom import crane, parts
from robot_arm_life import analyse, command

import jousto as jo
from jousto import design

HEIGHTS = {"root": 0.539, "middle": 0.378, "tip": 0.212}  # m, of least mass
MOVE, MOVES = 6.0, 20 * 300 * 60  # s
WELD = jo.SN(S_D=50e6, N_D=2e6, k=3, rule="elementary")  # amplitude, half of the welds survive
COUNT = {"criterion": "s11", "residue": "repeat"}
WALL = jo.Parameter("wall", 6e-3, (4e-3, 15e-3), unit="m", distribution="normal(sd=0.25 mm)")
WHEELS = jo.Parameter("wheels", 5e3, unit="N", distribution="gumbel(cov=0.15)")
SCATTER = jo.Parameter("scatter", 1.0, distribution="lognormal(cov=0.6)")


def boom(wall: float, wheels: float) -> jo.Mechanism:
    """The crane with another wall and payload."""
    return crane(HEIGHTS, parts(HEIGHTS, wall), wheels)


def main(out: Path, samples: int, workers: Any) -> int:
    """Analyse, redesign and draw; return 0 if the samples agree with FORM."""
    life = design.Damage("life", "boom", life=True, sn=WELD, options=COUNT)
    study = jo.study(
        boom,
        [WALL, WHEELS],
        [life, "mass(boom)"],
        t_end=MOVE,
        solver=jo.ROS2(step=8e-3),
        output_step=0.04,
        state=jo.simulation.vibration_free_state,
    )
    text = f"life >= {MOVES * MOVE:.0f} s / scatter"
    limit = design.limit_state(study, text, parameters=[SCATTER], workers=workers)
    found, better, good = analyse(study, limit, samples)
    walls = (WALL.value, better.design["wall"])
    before, after = study([[wall, WHEELS.value] for wall in walls])[:, 1]
    print(f"boom of {before:.0f} kg, then {after:.0f} kg with a wall of {1e3 * walls[1]:.2f} mm")
    jo.plot(found, path=out / "crane_life.png")
    jo.plot(better, path=out / "crane_life_redesign.png")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(command(main, samples=60))
