"""Stress at the hot spot of each body, and the damage of its history."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.fatigue.cycles.rainflow import rainflow
from jousto.fatigue.miner.damage import damage
from jousto.recovery.fields.build import field_from
from jousto.recovery.fields.criteria import evaluate
from jousto.recovery.hotspots.hot_spots import hot_spots
from jousto.reduction.fields.stress import StressModes

CRITERION = "signed-von-mises"
"""Stress of a reading; its sign distinguishes tension from compression."""


@dataclass(frozen=True, eq=False)
class HotSpotReading:
    """Stress at the site of a body with the largest von Mises stress of a run.

    Attributes
    ----------
    body, site : str
    modes : StressModes
        Stress of each mode of the body at this site alone.
    rule : object or None
        Rule of the damage of a history; None if no life was asked for.
    """

    body: str
    site: str
    modes: StressModes
    rule: Any

    @property
    def name(self) -> str:
        """Name of the reading, ``stress BODY SITE``."""
        return f"stress {self.body} {self.site}"

    def history(self, p: Array) -> Array:
        """Return the stress (nt,), Pa, of modal coordinates (nt, n)."""
        return stress_of_modes(self.modes, p)

    def damage(self, history: Array) -> float:
        """Return the damage of a history of the stress (nt,), Pa; NaN without a rule."""
        return float("nan") if self.rule is None else float(self.rule(history))


def stress_of_modes(modes: StressModes, p: Array) -> Array:
    """Return the stress (nt,), Pa, at the first site of modes for coordinates (nt, n)."""
    return np.asarray(evaluate(np.einsum("cj,tj->tc", modes.modes[0], p), CRITERION))


def hot_spot_reading(
    body: str, modes: StressModes, p: Array, time: Array, rules: Mapping[str, Any]
) -> HotSpotReading:
    """Return the hot spot of a body.

    Parameters
    ----------
    body : str
    modes : StressModes
        Stress of each mode at all sites.
    p : (nt, n) array
        Modal coordinates of the run.
    time : (nt,) array
        Instants, s.
    rules : mapping of str to function
        Rules of the damage of a history by body; that of "" is for all others.
    """
    field = field_from(modes, p, time, name=body)
    spot = hot_spots(field, count=1).spots[0]
    place = field.indices(spot.site)
    return HotSpotReading(body, spot.site, modes.select(place), rules.get(body, rules.get("")))


@dataclass(frozen=True)
class SlopeRule:
    """Damage of a history by the slope m of the S-N curve alone, ``sum n s^m``, without unit."""

    m: float

    def __call__(self, history: Array) -> float:
        """Return the sum, with the amplitudes of the cycles in MPa."""
        cycles = rainflow(history, residue="half")
        return float(np.sum(cycles.count * (1e-6 * cycles.amplitude) ** self.m))


@dataclass(frozen=True, eq=False)
class CheckRule:
    """Damage of a history by the fatigue check of a model file."""

    check: Any

    def __call__(self, history: Array) -> float:
        """Return Miner's sum."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            cycles = rainflow(history, residue=self.check.residue or "half")
            return damage(cycles, self.check.sn, self.check.mean)


def damage_ratio(simple: float, full: float) -> float:
    """Return the damage of the simpler run / that of the full one; 1 if both are zero."""
    if full == simple:
        return 1.0
    if np.isnan(full) or np.isnan(simple):
        return float("nan")
    return simple / full if full else float("inf")
