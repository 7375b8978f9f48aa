"""Verification: what two formulations of a mechanism say of each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array, some
from jousto.base.described import described
from jousto.base.errors import count
from jousto.simulation.results.diagnostics import FAIR

SAME = 1e-6
"""Share of its size by which a reading may differ at one state: both find it from one position and
velocity, the second formulation by iteration."""
CLOSE = 1e-3
"""Share of its size by which the runs may differ in any case."""
IDLE = "give it loads, drives or velocities, or what they do is not compared"
FALLING = 1.5
"""Order with which differences of runs fall at the least, if they are larger."""


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
        """Whether the runs come together."""
        return not self.unique or not self.fine > CLOSE or self.order >= FALLING

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
    def said(self) -> str:
        """What it found, in a few words."""
        row = self.worst
        if self.failed or row is None:
            return f"not compared: {self.failed or 'no reading in common'}"
        falls = f", order {row.order:.1f}" if np.isfinite(row.order) else ""
        return f"differs by {row.fine:.1e} of the size at most, in '{row.name}'{falls}"


@described
@dataclass(frozen=True, eq=False)
class Verification:
    """What two formulations say of each other, or two methods where one formulation is not known.

    Attributes
    ----------
    name : str
        Name of the mechanism.
    rows : tuple of Compared
        Every sensor, and what was measured besides.
    instants : int
        Number of states at which both were compared.
    step : float
        The longer step of the runs, s.
    open_joints : tuple of str
        Joints that the states of the engine leave open by the equations of the other formulation.
    energy : tuple of float
        Relative errors of the energy balance: of the engine at the step and at half of it, and of
        the moving frame.
    residual : float
        Largest position constraint that the moving frame misses, m or 1.
    iterations : float
        Iterations of a step of the moving frame.
    left_out : tuple of str
        Sensors that only the engine reads.
    ways : tuple of Way
        Other runs of the engine: by another method first.
    unknown : tuple of str
        What the moving frame does not know of the mechanism. If there is anything, `rows` are the
        differences of two methods of the engine.
    still : bool
        Whether nothing moved in the run, so that terms of the motion are not compared.
    shared : tuple of str
        Friction that follows from reactions which are not unique, and the motion with it: then
        positions, velocities and what depends on them alone are compared, at the same states.
    """

    name: str
    rows: tuple[Compared, ...]
    instants: int
    step: float
    open_joints: tuple[str, ...]
    energy: tuple[float, float, float, float]
    residual: float
    iterations: float
    left_out: tuple[str, ...] = ()
    ways: tuple[Way, ...] = ()
    unknown: tuple[str, ...] = ()
    still: bool = False
    shared: tuple[str, ...] = ()

    @property
    def different(self) -> tuple[Compared, ...]:
        """What both read differently at the same state, direct readings and large ones first."""
        found = [row for row in self.rows if not row.same]
        return tuple(sorted(found, key=lambda row: (not row.direct, -row.at_instants)))

    @property
    def apart(self) -> tuple[Compared, ...]:
        """What the runs do not agree in at these steps, the largest difference first."""
        found = [row for row in self.rows if not row.meets]
        return tuple(sorted(found, key=lambda row: -row.fine))

    @property
    def agrees(self) -> bool:
        """Whether both have the same equations of motion, constraints and readings.

        Where the moving frame does not know the mechanism: whether the runs of two methods come
        together and the energy balance closes.
        """
        if self.unknown:
            return self.settled
        return not self.different and not self.open_joints

    @property
    def settled(self) -> bool:
        """Whether two methods of the engine come together and keep the balance of energy."""
        first = self.ways[0]
        return not (first.failed or first.apart or self.shared) and self.energy[1] <= FAIR

    @property
    def undecided(self) -> bool:
        """Whether the runs of two methods, which alone can judge, say neither yes nor no."""
        apart = self.ways[0].apart
        return bool(self.unknown) and (
            bool(self.shared) or (bool(apart) and all(row.unresolved for row in apart))
        )

    @property
    def verdict(self) -> str:
        """The result in one sentence, and whether anything moved."""
        return self._result + ("; but nothing moved in the run: " + IDLE if self.still else "")

    @property
    def _result(self) -> str:
        """The result in one sentence."""
        if self.unknown:
            return self._of_methods()
        if self.open_joints:
            names = some([f"'{name}'" for name in self.open_joints])
            return f"the formulations DISAGREE: states of the engine leave {names} open"
        if wrong := self.different:
            first = wrong[0]
            others = some([f"'{row.name}'" for row in wrong[1:]], 4)
            more = f", and so do {others}" if others else ""
            return (
                f"the formulations DISAGREE: '{first.name}' differs by {first.at_instants:.2g} of "
                f"its size at the same state, {first.worst:g} s{more}"
            )
        checked = [row for row in self.rows if row.unique and np.isfinite(row.at_instants)]
        largest = max((row.at_instants for row in checked), default=0.0)
        equal = (
            f"the formulations agree: {count(len(checked), 'reading')} at "
            f"{count(self.instants, 'state')} are the same to {largest:.0e} of their size"
        )
        if self.shared:
            return f"{equal}; {self._share}"
        if apart := self.apart:
            names = some([f"'{row.name}'" for row in apart], 4)
            return (
                f"{equal}; the runs do not come together in {names} with a step of "
                f"{self.step / 2:g} s: take a shorter one, which resolves the vibration"
            )
        far = max((row.fine for row in self.rows if row.unique), default=0.0)
        return f"{equal}, and runs with a step of {self.step / 2:g} s differ by {far:.0e} at most"

    @property
    def _share(self) -> str:
        """What is not compared where friction is not unique, and the remedy."""
        names = some([f"'{name}'" for name in self.shared], 4)
        return (
            f"but the friction {names} follows from reactions that are not unique, so "
            "accelerations, reactions and runs are not compared: free a motion of the loop or let "
            "a body be flexible"
        )

    def _of_methods(self) -> str:
        """The result where the moving frame does not know the mechanism."""
        first = self.ways[0]
        alone = f"the moving frame does not know {count(len(self.unknown), 'thing')} of the machine"
        if first.failed:
            return f"{alone}, and the other method does not come to its end: {first.failed}"
        if self.shared:
            return f"{alone}, {self._share}"
        names = some([f"'{row.name}'" for row in first.apart], 4)
        if self.undecided:
            return (
                f"{alone}, and nothing is decided: each method misses itself as much as the other "
                f"in {names}, whose vibration a step of {self.step / 2:g} s does not resolve; take "
                "a shorter one"
            )
        if first.apart:
            return (
                f"{alone}, and two methods of the engine DISAGREE with a step of "
                f"{self.step / 2:g} s in {names}: take a shorter one"
            )
        if self.energy[1] > FAIR:
            return f"{alone}, and the energy balance of the engine misses {self.energy[1]:.1e}"
        worst = first.worst
        far = 0.0 if worst is None else worst.fine
        return (
            f"{alone}; two methods of the engine agree: runs with a step of {self.step / 2:g} s "
            f"differ by {far:.0e} of the size at most, and the energy balance closes to "
            f"{self.energy[1]:.0e}"
        )

    def __repr__(self) -> str:
        word = "agree" if self.agrees else "are undecided" if self.undecided else "DISAGREE"
        return f"<Verification {self.name!r}: the formulations {word}>"

    @property
    def table(self) -> tuple[tuple[str, ...], ...]:
        """A row of text for every reading: name, size, differences, order."""
        return tuple(
            (
                row.name,
                f"{row.size:.3g} {row.unit}",
                share(row.at_instants) if row.unique else "not unique",
                share(row.coarse) if row.unique else "",
                share(row.fine) if row.unique else "",
                f"{row.order:.1f}" if row.unique and row.fine > 1e-9 else "",
            )
            for row in self.rows
        )

    @property
    def facts(self) -> tuple[tuple[str, str], ...]:
        """What else was found, as names and sentences."""
        engine, half, frame, fine = self.energy
        found = [("energy, engine", f"misses {engine:.1e}, at half the step {half:.1e}")]
        found += [(way.name, way.said) for way in self.ways]
        if self.unknown:
            return (*found, *(("not known", what) for what in self.unknown))
        found += [
            ("energy, moving frame", f"misses {frame:.1e}, at half the step {fine:.1e}"),
            ("constraints", f"missed by {self.residual:.1e} at most"),
            ("iterations", f"{self.iterations:.1f} a step"),
        ]
        if self.left_out:
            found.append(("not compared", ", ".join(self.left_out)))
        return tuple(found)

    def __str__(self) -> str:
        """Return the table, the facts and the verdict as text."""
        lines = [COLUMNS, *self.table]
        widths = [max(len(line[k]) for line in lines) for k in range(len(COLUMNS))]
        text = [
            "  ".join(
                cell.ljust(width) if k < 1 else cell.rjust(width)
                for k, (cell, width) in enumerate(zip(line, widths, strict=True))
            ).rstrip()
            for line in lines
        ]
        wide = max(len(name) for name, _ in self.facts)
        text += [f"{name.ljust(wide)}  {value}" for name, value in self.facts]
        return "\n".join([*text, self.verdict])


COLUMNS = ("reading", "size", "same state", "run", "half step", "order")


def share(value: float) -> str:
    """Return a share of a size as text."""
    return "" if np.isnan(value) else f"{value:.1e}"


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
