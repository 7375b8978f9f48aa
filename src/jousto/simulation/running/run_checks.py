"""RunWatch: checks of a run: energy balance, gaps of joints, spin and bending of bodies, motors."""

from __future__ import annotations

import functools

import numpy as np
from numpy.typing import NDArray

from jousto.base.errors import warn
from jousto.mechanism.sensors.scalar import ENERGIES
from jousto.model.model import Model
from jousto.model.native.header import places
from jousto.model.rank.redundancy import disagreement
from jousto.simulation.check_bending import bends
from jousto.simulation.check_motors import MotorTurns
from jousto.simulation.check_spin import spins
from jousto.simulation.results.diagnostics import FAIR, STEADY

SIGNS = np.array(
    [-1.0 if name == "work" else 1.0 for name in ENERGIES]
)  # signs of the terms of the energy balance
UNSEEN = np.full(len(ENERGIES), np.inf)  # smallest energies before the first row, J
GAP_LIMIT = 1e-9  # gap of a joint over the size of the mechanism, above which it is warned of
STILL = 1e-9  # displacement in a run over the size of the mechanism, below which a body is at rest
OPEN_LIMIT = 1e-4  # gap over the size of the mechanism, above which redundant joints end the run


RESTING = 0.1
"""Largest kinetic energy over the exchanged energy of a machine that only settles."""
SETTLED = 1e-6
"""Way over the size of a mechanism by which its weight settles unseen."""
SETTLED_SPRINGS = 1e-3
"""Share of the energy in springs that settles unseen."""


@functools.cache
def _diagnostics() -> tuple[slice, int]:
    """Return the places of the energies, one after the other, and of the gaps."""
    at = places("jo_diagnostics")
    first = at[ENERGIES[0]].start
    assert [at[name].start - first for name in ENERGIES] == list(range(len(ENERGIES)))
    return slice(first, first + len(ENERGIES)), at["position_residual"].start


class Contradiction(Exception):
    """Error raised if redundant joints, couplings or drives contradict one another."""


class RunWatch:
    """Largest error of the energy balance and largest gap of the joints of a run so far."""

    def __init__(
        self, model: Model, *, projected: bool, motors: tuple[MotorTurns, ...] = ()
    ) -> None:
        self._model = model
        self._projected = projected
        first, (terms, gaps) = 1 + model.nq + model.nv + model.nrow, _diagnostics()
        self._terms = slice(first + terms.start, first + terms.stop)
        self._gaps = first + gaps
        self._low, self._high = UNSEEN, -UNSEEN
        self._start: float | None = None
        self._since = self._until = 0.0
        self._missed = 0.0
        self._gap = 0.0
        self._open: NDArray[np.float64] | None = None  # row (row_size,) with the largest gap
        self._spins = spins(model)
        self._turning = [0.0] * len(self._spins)
        self._bends = bends(model)
        self._bent = [0.0] * len(self._bends)
        self._motors = motors
        self._fast = [0.0] * len(motors)

    def see(self, rows: NDArray[np.float64]) -> None:
        """Update the largest errors with rows (k, row_size) of the engine."""
        if not len(rows):
            return
        terms = rows[:, self._terms]
        balance = terms @ SIGNS
        low, high = np.minimum.reduce(terms), np.maximum.reduce(terms)
        if self._start is None:
            self._start, self._since = float(balance[0]), float(rows[0, 0])
            self._low, self._high = low, high
        else:
            self._low, self._high = np.fmin(self._low, low), np.fmax(self._high, high)
        self._until = float(rows[-1, 0])
        if len(rows) > 1 or balance[0] != self._start:
            self._missed = max(self._missed, float(np.abs(balance - self._start).max()))
        for k, spin in enumerate(self._spins):
            self._turning[k] = max(self._turning[k], spin.squared(rows))
        for k, bend in enumerate(self._bends):
            self._bent[k] = max(self._bent[k], bend.furthest(rows))
        for k, motor in enumerate(self._motors):
            self._fast[k] = max(self._fast[k], motor.fastest(rows))
        gaps = rows[:, self._gaps]
        if (widest := float(np.maximum.reduce(gaps))) > self._gap:
            self._gap, self._open = widest, rows[int(np.argmax(gaps))].copy()
        if self._projected and self._model.redundant:
            limit = OPEN_LIMIT * self._model.size
            if self._gap > limit:
                raise Contradiction(self._gaping(rows[int(np.argmax(gaps > limit))]))

    def _small(self, level: float, potential: float) -> float:
        """Return the energy, J, that is negligible compared with energies of this size."""
        size = self._model.size
        mass = sum(float(b.mass[0]) for b in self._model.bodies)
        weight = mass * float(np.abs(self._model.gravity).max())
        lasted = self._until - self._since
        still = mass * (STILL * size / lasted) ** 2 if lasted > 0.0 else 0.0
        return max(1e-6 * level, 1e-12 * potential, 1e-12 * weight * size, still)

    def _settling(self, kinetic: float, exchanged: float, springs: float) -> float:
        """Return the energy, J, that is negligible while contacts settle under their loads, else 0.

        Nothing moves then: bristles and depths find their loads, within a millionth of the size of
        the mechanism, or of a thousandth of what springs store.
        """
        if not self._model.touches or kinetic > RESTING * exchanged:
            return 0.0
        mass = sum(float(b.mass[0]) for b in self._model.bodies)
        weight = mass * float(np.abs(self._model.gravity).max())
        return max(SETTLED * weight * self._model.size, SETTLED_SPRINGS * springs)

    def _gaping(self, row: NDArray[np.float64]) -> str:
        """Return a sentence with the joint of the largest gap at an instant, and with the cause."""
        return disagreement(self._model, row[1 : 1 + self._model.nq], float(row[0]))

    @property
    def rubbed(self) -> bool:
        """Whether friction dissipated energy, or nothing moved."""
        low, high = self._extremes()
        return high["friction"] > low["friction"] or not high["kinetic"] > 0.0

    def _extremes(self) -> tuple[dict[str, float], dict[str, float]]:
        """Return the smallest and the largest value of each energy in the run, J."""
        low = dict(zip(ENERGIES, self._low.tolist(), strict=True))
        return low, dict(zip(ENERGIES, self._high.tolist(), strict=True))

    def judge(self) -> None:
        """Warn if the error of the balance is noticeable beside the exchanged or kinetic energy."""
        where = f"simulate {self._model.name!r}"
        for spin, squared in zip(self._spins, self._turning, strict=True):
            if sentence := spin.sentence(squared):
                warn(where, sentence)
        for bend, turn in zip(self._bends, self._bent, strict=True):
            if sentence := bend.sentence(turn):
                warn(where, sentence)
        for motor, speed in zip(self._motors, self._fast, strict=True):
            if sentence := motor.sentence(speed):
                warn(where, sentence)
        # one of the exchanged energies, a lower bound of their sum
        if self._missed > FAIR * float(
            (self._high - self._low)[: len(places("jo_energies"))].max()
        ):
            self._judge_balance(where)
        if self._projected and self._open is not None and self._gap > GAP_LIMIT * self._model.size:
            warn(
                where,
                f"joints opened by up to {self._gap:.3g} m in spite of the projection, "
                f"at {self._open[0]:.4g} s {self._gaping(self._open)}; take a smaller step",
            )

    def _judge_balance(self, where: str) -> None:
        """Warn of the error of the energy balance if it is noticeable."""
        low, high = self._extremes()
        exchanged = sum(high[name] - low[name] for name in places("jo_energies"))
        # no check of a machine that moves by round-off only
        level = {name: max(abs(high[name]), abs(low[name])) for name in ENERGIES}
        potential, kinetic = level.pop("potential"), level["kinetic"]
        scale = max(exchanged, STEADY * kinetic)
        small = self._small(max(level.values()), potential)
        small = max(small, self._settling(kinetic, exchanged, level["springs"]))
        if self._missed > FAIR * scale and self._missed > small:
            warn(
                where,
                f"the error of the energy balance is {self._missed:.3g} J of {exchanged:.3g} J "
                f"exchanged ({100 * self._missed / max(exchanged, 1e-300):.2g} %); a smaller "
                "step is more accurate",
            )
