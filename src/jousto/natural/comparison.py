"""Readings of two runs, and how far they differ."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.base.object_repr import described
from jousto.simulation.results.diagnostics import FAIR

SAME = 1e-6
"""Share of its size by which a reading may differ at one state: both find it from one position and
velocity, the second formulation by iteration."""
CLOSE = 1e-3
"""Share of its size by which the runs may differ in any case."""
FALLING = 1.5
"""Order with which differences of runs fall at the least, if they are larger."""
FAR = FAIR
"""Share of its size beyond which runs do not come together, however fast the difference falls: an
order is one of the method only where differences are small."""

FRAME = "another frame"
STRETCHED = (
    ": modes are linear, so the body bends too far for them or loads stiffen it, which "
    "stiffening=True of its part takes in"
)


@described
@dataclass(frozen=True, eq=False)
class Compared:
    """A reading of both formulations.

    Attributes
    ----------
    name : str
        Name of the sensor, or of what was measured besides.
    size : float
        Largest value of the engine, or what it is compared with where it is next to nothing.
    unit : str
        Its unit, or units.
    at_instants : float
        Largest difference at the same state, as a share of the size; nan if it has none there.
    coarse, fine : float
        Largest difference of the runs, as a share of the size, at the step and at half of it.
    unique : bool
        Whether it is unique, as reactions of redundant joints and what follows from friction there
        are not; others are not compared.
    worst : float
        Time of the largest difference at the same state, s.
    direct : bool
        Whether it follows from positions and velocities at one place, as forces do. Otherwise
        accelerations, in which every fault shows, or sums over the machine are part of it.
    settles : bool
        Whether runs of two methods have to come together in it.
    own : float
        Difference of the runs of one method at both steps, as a share of the size: of the method
        that misses itself less.
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
        """Order with which the difference of the runs vanishes; nan where there is none."""
        if self.fine <= 0.0 or self.coarse <= 0.0:
            return np.nan
        return float(np.log2(self.coarse / self.fine))

    @property
    def same(self) -> bool:
        """Whether both read the same at the same states."""
        return not self.unique or not self.at_instants > SAME

    @property
    def meets(self) -> bool:
        """Whether the runs come together: next to each other, or near and with the order."""
        if not self.unique or not self.fine > CLOSE:
            return True
        return self.fine <= FAR and self.order >= FALLING

    @property
    def unresolved(self) -> bool:
        """Whether each method misses itself by as much as the other: the step resolves too little.

        A run with half the step misses the truth by 1/3 of the difference of its own runs at order
        2, by as much at order 1; so two of them are apart by at most twice that.
        """
        return not self.meets and self.fine <= 2.0 * self.own


@described
@dataclass(frozen=True, eq=False)
class Way:
    """Runs of the engine by another method, in another frame, basis or mechanism.

    Attributes
    ----------
    name : str
        What is other.
    rows : tuple of Compared
        How far the readings differ.
    failed : str
        Why there are none.
    """

    name: str
    rows: tuple[Compared, ...]
    failed: str = ""

    @property
    def worst(self) -> Compared | None:
        """The settled reading that differs most."""
        found = [row for row in self.rows if row.unique and row.settles]
        return max(found, key=lambda row: row.fine, default=None)

    @property
    def apart(self) -> tuple[Compared, ...]:
        """Readings that do not come together with the step, the largest difference first."""
        found = [row for row in self.rows if row.settles and not row.meets]
        return tuple(sorted(found, key=lambda row: -row.fine))

    @property
    def far(self) -> bool:
        """Whether it has to be named: readings differ by per cents, or it is not compared."""
        return bool(self.failed) or (self.worst is not None and self.worst.fine > FAR)

    @property
    def hint(self) -> str:
        """What makes frames differ, and the remedy."""
        return STRETCHED if self.name == FRAME and not self.failed else ""

    @property
    def said(self) -> str:
        """What it found, in a few words."""
        row = self.worst
        if self.failed or row is None:
            return f"not compared: {self.failed or 'no reading in common'}"
        falls = f", order {row.order:.1f}" if np.isfinite(row.order) else ""
        return f"differs by {row.fine:.1e} of the size at most, in '{row.name}'{falls}"


def sizes(values: Array, units: list[str], typical: dict[str, float]) -> Array:
    """Return what differences of components (k,) are compared with, from values (nt, k).

    The largest component of the same unit, at least a thousandth of what is typical of the unit.
    """
    largest = np.abs(values).max(axis=0, initial=0.0)
    out = np.zeros(len(units))
    for k, unit in enumerate(units):
        same = [largest[j] for j, other in enumerate(units) if other == unit]
        out[k] = max(max(same), 1e-3 * typical.get(unit, 0.0), 1e-300)
    return out
