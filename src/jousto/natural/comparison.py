"""Differences of the readings of two formulations and of runs, with their criteria."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.base.object_repr import described
from jousto.simulation.results.diagnostics import FAIR

SAME = 1e-6
"""Largest relative difference of equal readings at the same state; the second formulation computes
them by iteration."""
CLOSE = 1e-3
"""Relative difference of runs below which they agree in any case."""
FALLING = 1.5
"""Smallest order of convergence of larger differences of runs that agree."""
FAR = FAIR
"""Relative difference of runs above which they do not agree at any order, since the order of a
method shows only in small differences."""

FRAME = "another frame"
STRETCHED = (
    ": the body bends beyond the range of linear modes, or loads change its stiffness; reduce its "
    "part with stiffening=True"
)


@described
@dataclass(frozen=True, eq=False)
class Compared:
    """Comparison of a reading of both formulations.

    Attributes
    ----------
    name : str
        Name of the sensor or the added reading.
    size : float
        Scale of the differences: largest value of the engine, or a typical value if it is tiny.
    unit : str
        Unit or units.
    at_instants : float
        Largest relative difference at the same state; nan if not compared there.
    coarse, fine : float
        Largest relative difference of the runs, at the step and at half of it.
    unique : bool
        Whether the reading is unique and compared; reactions of redundant joints, and quantities
        that depend on their friction, are not.
    worst : float
        Instant of the largest difference at the same state, s.
    direct : bool
        Whether the reading depends on positions and velocities at one point, as forces do, and not
        on accelerations or on sums over the machine, in which every error shows.
    settles : bool
        Whether runs of two methods must agree in this reading.
    own : float
        Relative difference of the runs of one method at both steps, the smaller of both methods.
    """

    name: str
    size: float
    unit: str
    at_instants: float
    coarse: float
    fine: float
    unique: bool = True
    worst: float = 0.0
    direct: bool = False
    settles: bool = True
    own: float = 0.0

    @property
    def order(self) -> float:
        """Order of convergence of the difference of the runs; nan without a difference."""
        if self.fine <= 0.0 or self.coarse <= 0.0:
            return np.nan
        return float(np.log2(self.coarse / self.fine))

    @property
    def same(self) -> bool:
        """Whether the readings are equal at the same states."""
        return not self.unique or not self.at_instants > SAME

    @property
    def meets(self) -> bool:
        """Whether the runs agree: a very small difference, or a small one with the order."""
        if not self.unique or not self.fine > CLOSE:
            return True
        return self.fine <= FAR and self.order >= FALLING

    @property
    def unresolved(self) -> bool:
        """Whether the difference of two methods is within the error of each, with too long a step.

        The error of a run with half the step is 1/3 of the difference of its runs at both steps for
        order 2, and equal to this difference for order 1; two runs differ by at most twice that.
        """
        return not self.meets and self.fine <= 2.0 * self.own


@described
@dataclass(frozen=True, eq=False)
class Way:
    """Variant of the engine's run: another method, body frame, modal basis or mechanism.

    Attributes
    ----------
    name : str
        Name of the variant.
    rows : tuple of Compared
        Differences of the readings.
    failed : str
        Reason of a failure; empty without one.
    """

    name: str
    rows: tuple[Compared, ...]
    failed: str = ""

    @property
    def worst(self) -> Compared | None:
        """Reading with the largest difference, among those that must agree; None without any."""
        found = [row for row in self.rows if row.unique and row.settles]
        return max(found, key=lambda row: row.fine, default=None)

    @property
    def apart(self) -> tuple[Compared, ...]:
        """Readings whose runs do not agree, the largest difference first."""
        found = [row for row in self.rows if row.settles and not row.meets]
        return tuple(sorted(found, key=lambda row: -row.fine))

    @property
    def far(self) -> bool:
        """Whether the verdict mentions this variant: large differences, or no comparison."""
        return bool(self.failed) or (self.worst is not None and self.worst.fine > FAR)

    @property
    def hint(self) -> str:
        """Cause of differences of body frames, with the remedy."""
        return STRETCHED if self.name == FRAME and not self.failed else ""

    @property
    def said(self) -> str:
        """Result of the comparison with this variant, as a text."""
        row = self.worst
        if self.failed or row is None:
            return f"not compared: {self.failed or 'no reading in common'}"
        falls = f", order {row.order:.1f}" if np.isfinite(row.order) else ""
        return f"differs by {row.fine:.1e} of the size at most, in '{row.name}'{falls}"


def sizes(values: Array, units: list[str], typical: dict[str, float]) -> Array:
    """Return the scales (k,) of differences of components, from values (nt, k).

    A scale is the largest component of the same unit, at least a thousandth of a typical value.
    """
    largest = np.abs(values).max(axis=0, initial=0.0)
    out = np.zeros(len(units))
    for k, unit in enumerate(units):
        same = [largest[j] for j, other in enumerate(units) if other == unit]
        out[k] = max(max(same), 1e-3 * typical.get(unit, 0.0), 1e-300)
    return out
