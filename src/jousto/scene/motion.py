"""Rows of a scene from results, read in slices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.scene.beam_tubes import Resultants
from jousto.scene.scene import Motion
from jousto.simulation.results.solution import Solution


@dataclass(frozen=True, eq=False)
class Rows:
    """Map from states to rows of a scene: q, then the resultants of beams."""

    width: int
    beams: Sequence[Resultants]

    @property
    def velocities(self) -> bool:
        """Whether the rows depend on velocities."""
        return any(beam.damped for beam in self.beams)

    def from_states(self, q: Array, v: Array | None) -> Array:
        """Return the rows (k, nr) of states q (k, nq) and v (k, nv)."""
        return np.concatenate([q, *(beam.values(q, v) for beam in self.beams)], axis=1)


def run_motion(run: Solution, rows: Rows) -> Motion:
    """Return the motion of a run; its rows are read from the results on demand."""

    def read(which: slice) -> Array:
        v = run.states(which)[1] if rows.velocities else None
        return rows.from_states(run.states(which, velocities=False)[0], v)

    return Motion(run.time, read)
