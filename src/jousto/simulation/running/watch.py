"""RunWatch: what a run missed in its energy balance, its joints and its spins."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jousto.base.errors import warn
from jousto.mechanism.sensors.readings import ENERGIES
from jousto.model.model import Model
from jousto.model.native.header import named, places
from jousto.model.rank.redundancy import disagreement
from jousto.simulation.running.diagnostics import FAIR, STEADY, Energy
from jousto.simulation.running.spin import Spin

GAP_LIMIT = 1e-9  # of the size of the mechanism, with projection
OPEN_LIMIT = 1e-4  # the same: where repeated rows contradict one another the run ends


class Contradiction(Exception):
    """Joints, couplings or drives that repeat one another disagree."""


class RunWatch:
    """What the energy balance missed and how far the joints opened so far, in fixed memory."""

    def __init__(self, model: Model, *, projected: bool) -> None:
        self._model = model
        self._projected = projected
        self._first = 1 + model.nq + model.nv + model.nrow
        self._low = dict.fromkeys(ENERGIES, np.inf)
        self._high = dict.fromkeys(ENERGIES, -np.inf)
        self._start: float | None = None
        self._missed = 0.0
        self._gap = 0.0
        self._open: NDArray[np.float64] | None = None  # the row with the largest gap
        self._spins = [
            Spin(model, k) for k, b in enumerate(model.bodies) if b.n and not b.stiffening
        ]

    def see(self, rows: NDArray[np.float64]) -> None:
        """Look at rows of the engine."""
        if not len(rows):
            return
        found = named("jo_diagnostics", rows[:, self._first :])
        energy = Energy(**{name: getattr(found, name) for name in ENERGIES})
        balance = energy.total + energy.dissipated + energy.friction - energy.work
        for name, term in vars(energy).items():
            self._low[name] = min(self._low[name], float(term.min()))
            self._high[name] = max(self._high[name], float(term.max()))
        if self._start is None:
            self._start = float(balance[0])
        self._missed = max(self._missed, float(np.abs(balance - self._start).max()))
        for spin in self._spins:
            spin.see(rows)
        gaps = found.position_residual
        if gaps.max() > self._gap:
            self._gap, self._open = float(gaps.max()), rows[int(np.argmax(gaps))].copy()
        if self._projected and self._model.redundant:
            limit = OPEN_LIMIT * self._model.size
            if self._gap > limit:
                raise Contradiction(self._gaping(rows[int(np.argmax(gaps > limit))]))

    def _gaping(self, row: NDArray[np.float64]) -> str:
        """Return which joint is open at an instant, and why."""
        return disagreement(self._model, row[1 : 1 + self._model.nq], float(row[0]))

    @property
    def rubbed(self) -> bool:
        """Whether friction took energy, or nothing moved."""
        lost = self._high["friction"] > self._low["friction"]
        return lost or not self._high["kinetic"] > 0.0

    def judge(self) -> None:
        """Warn if the balance misses a noticeable share of the energy exchanged or kinetic."""
        where = f"simulate {self._model.name!r}"
        for sentence in filter(None, (spin.sentence for spin in self._spins)):
            warn(where, sentence)
        exchanged = sum(self._high[name] - self._low[name] for name in places("jo_energies"))
        # shares of what moves only by round-off mean nothing
        level = {name: max(abs(self._high[name]), abs(self._low[name])) for name in ENERGIES}
        potential, kinetic = level.pop("potential"), level["kinetic"]
        mass = sum(float(b.mass[0]) for b in self._model.bodies)
        weight = mass * np.abs(self._model.gravity).max()
        small = max(
            1e-6 * max(level.values()),
            1e-12 * potential,
            1e-12 * float(weight) * self._model.size,
            1e-18 * mass,  # a speed of 1 nm/s
        )
        scale = max(exchanged, STEADY * kinetic)
        if self._missed > FAIR * scale and self._missed > small:
            warn(
                where,
                f"the energy balance misses {self._missed:.3g} J of {exchanged:.3g} J exchanged "
                f"({100 * self._missed / max(exchanged, 1e-300):.2g} %); a smaller step is more "
                "accurate",
            )
        if self._projected and self._open is not None and self._gap > GAP_LIMIT * self._model.size:
            warn(
                where,
                f"joints opened by up to {self._gap:.3g} (m, or rad) in spite of the projection, "
                f"at {self._open[0]:.4g} s {self._gaping(self._open)}; take a smaller step",
            )
