"""Verification: result of the comparison of two formulations of a mechanism."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import some
from jousto.base.errors import count
from jousto.base.object_repr import described
from jousto.natural.comparison import Compared, Way
from jousto.simulation.results.diagnostics import FAIR

IDLE = "give it loads, drives or velocities, or what they do is not compared"


@described
@dataclass(frozen=True, eq=False)
class Verification:
    """Comparison of two formulations, or of two methods of the engine if only one is available.

    Attributes
    ----------
    name : str
        Name of the mechanism.
    rows : tuple of Compared
        Compared readings: all sensors, and the added ones.
    instants : int
        Number of states compared.
    step : float
        Longer step of the runs, s.
    open_joints : tuple of str
        Joints that are open in the states of the engine by the equations of the moving frame.
    energy : tuple of float
        Relative errors of the energy balance: of the engine at the step and at half of it, and of
        the moving frame.
    residual : float
        Largest position residual of the moving frame, m or 1.
    iterations : float
        Mean number of iterations of a step of the moving frame.
    left_out : tuple of str
        Sensors that the moving frame does not support.
    ways : tuple of Way
        Variants of the engine's run, another method first.
    unknown : tuple of str
        Items of the mechanism that the moving frame does not support. If there are any, `rows` are
        the differences of two methods of the engine.
    still : bool
        Whether nothing moved in the run, so that terms of the motion are not verified.
    shared : tuple of str
        Frictions whose normal force is not unique. If there are any, only positions, velocities and
        quantities that depend on them alone are compared, at the same states.
    stopped : tuple of str
        Runs that did not reach their end, with the reason; runs are then not compared.
    ended : bool
        Whether the run of the engine with the compared states reached its end.
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
    stopped: tuple[str, ...] = ()
    ended: bool = True

    @property
    def different(self) -> tuple[Compared, ...]:
        """Readings that differ at the same state, direct readings and large differences first."""
        found = [row for row in self.rows if not row.same]
        return tuple(sorted(found, key=lambda row: (not row.direct, -row.at_instants)))

    @property
    def apart(self) -> tuple[Compared, ...]:
        """Readings whose runs do not converge to each other, the largest difference first."""
        found = [row for row in self.rows if not row.meets]
        return tuple(sorted(found, key=lambda row: -row.fine))

    @property
    def agrees(self) -> bool:
        """Whether equations of motion, constraints and readings of both are equal.

        If the moving frame does not support the mechanism: whether the runs of two methods converge
        to each other and the energy balance closes.
        """
        if self.unknown:
            return self.settled
        return self.ended and not self.different and not self.open_joints

    @property
    def settled(self) -> bool:
        """Whether two methods of the engine agree and the energy balance closes."""
        if not self.ways:
            return False
        first = self.ways[0]
        return not (first.failed or first.apart or self.shared) and self.energy[1] <= FAIR

    @property
    def undecided(self) -> bool:
        """Whether the comparison is inconclusive.

        The comparison is inconclusive if the engine stopped before a difference occurred, or if the
        runs of two methods are the only criterion and do not resolve the vibration or did not reach
        their end.
        """
        if not self.unknown:
            return not (self.ended or self.different or self.open_joints)
        if not self.ways or self.ways[0].failed or self.shared:
            return True
        apart = self.ways[0].apart
        return bool(apart) and all(row.unresolved for row in apart)

    @property
    def word(self) -> str:
        """The result in a word: agree, undecided or disagree."""
        return "agree" if self.agrees else "undecided" if self.undecided else "disagree"

    @property
    def verdict(self) -> str:
        """Result in one sentence, with the variants that differ, and a note if nothing moved."""
        others = "".join(f"; {way.name} {way.said}{way.hint}" for way in self._elsewhere)
        idle = "; but nothing moved in the run: " + IDLE if self.still else ""
        return f"{self._result}{others}{idle}"

    @property
    def _elsewhere(self) -> tuple[Way, ...]:
        """Variants with large differences or an early end that the result does not name."""
        ways = self.ways[1:] if self.unknown else self.ways
        return tuple(way for way in ways if way.far)

    @property
    def _result(self) -> str:
        """The result in one sentence."""
        if self.unknown:
            return self._of_methods()
        stopped = self.stopped[-1] if self.stopped else ""
        besides = f"; besides, {stopped}" if stopped else ""
        if self.open_joints:
            names = some([f"'{name}'" for name in self.open_joints])
            return f"the formulations DISAGREE: states of the engine leave {names} open{besides}"
        if wrong := self.different:
            first = wrong[0]
            others = some([f"'{row.name}'" for row in wrong[1:]], 4)
            more = f", and so do {others}" if others else ""
            return (
                f"the formulations DISAGREE: '{first.name}' differs by {first.at_instants:.2g} of "
                f"its size at the same state, {first.worst:g} s{more}{besides}"
            )
        checked = [row for row in self.rows if row.unique and np.isfinite(row.at_instants)]
        largest = max((row.at_instants for row in checked), default=0.0)
        equal = (
            f"{count(len(checked), 'reading')} at {count(self.instants, 'state')} are equal to "
            f"{largest:.0e} of their size"
        )
        if not self.ended and not self.rows:
            return f"nothing is decided: {stopped}"
        if not self.ended:
            return f"nothing is decided: {stopped}; in the first half of that run {equal}"
        equal = f"the formulations agree: {equal}"
        if self.shared:
            return f"{equal}; {self._share}"
        if stopped:
            return f"{equal}, but runs are not compared: {stopped}"
        if apart := self.apart:
            names = some([f"'{row.name}'" for row in apart], 4)
            return (
                f"{equal}; the runs do not converge to each other in {names} with a step of "
                f"{self.step / 2:g} s; take a shorter one, which resolves the vibration"
            )
        far = max((row.fine for row in self.rows if row.unique), default=0.0)
        return f"{equal}, and runs with a step of {self.step / 2:g} s differ by {far:.0e} at most"

    @property
    def _share(self) -> str:
        """Text on readings not compared because friction is not unique, with the remedy."""
        names = some([f"'{name}'" for name in self.shared], 4)
        return (
            f"but the friction {names} depends on reactions that are not unique, so "
            "accelerations, reactions and runs are not compared; release a motion of the loop or "
            "make a body flexible"
        )

    def _of_methods(self) -> str:
        """Result for a mechanism that the moving frame does not support."""
        alone = f"the moving frame does not know {count(len(self.unknown), 'thing')} of the machine"
        if not self.ways:
            return f"{alone}, and nothing is decided: {self.stopped[-1]}"
        first = self.ways[0]
        if first.failed:
            return (
                f"{alone}, and nothing is decided: the other method does not reach its end: "
                f"{first.failed}"
            )
        if self.shared:
            return f"{alone}, {self._share}"
        names = some([f"'{row.name}'" for row in first.apart], 4)
        if self.undecided:
            return (
                f"{alone}, and nothing is decided: the methods differ no more than each does with "
                f"half the step, in {names}, whose vibration a step of {self.step / 2:g} s does "
                "not resolve; take a shorter one"
            )
        if first.apart:
            return (
                f"{alone}, and two methods of the engine DISAGREE with a step of "
                f"{self.step / 2:g} s in {names}; take a shorter one"
            )
        if self.energy[1] > FAIR:
            return f"{alone}, and the energy error of the engine is {self.energy[1]:.1e}"
        worst = first.worst
        far = 0.0 if worst is None else worst.fine
        return (
            f"{alone}; two methods of the engine agree: runs with a step of {self.step / 2:g} s "
            f"differ by {far:.0e} of the size at most, and the energy balance closes to "
            f"{self.energy[1]:.0e}"
        )

    def __repr__(self) -> str:
        word = {"undecided": "are undecided", "disagree": "DISAGREE"}.get(self.word, self.word)
        return f"<Verification {self.name!r}: the formulations {word}>"

    @property
    def table(self) -> tuple[tuple[str, ...], ...]:
        """Table of texts with a row for every reading: name, size, differences, order."""
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
        """Further results as pairs of name and sentence."""
        engine, half, frame, fine = self.energy
        found: list[tuple[str, str]] = []
        if np.isfinite(engine):
            found += [("energy, engine", f"error {engine:.1e}, at half the step {half:.1e}")]
        found += [(way.name, way.said) for way in self.ways]
        found += [("stopped", why) for why in self.stopped]
        if self.unknown:
            return (*found, *(("not known", what) for what in self.unknown))
        if not self.stopped:
            found += [
                ("energy, moving frame", f"error {frame:.1e}, at half the step {fine:.1e}"),
                ("constraints", f"largest residual {self.residual:.1e}"),
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
    """Return a relative difference as a text."""
    return "" if np.isnan(value) else f"{value:.1e}"
