"""Comparison: a run with a simpler body, the full run, and the estimate that links both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.design.flexibility.expected import Expected
from jousto.design.flexibility.variant_runs import VariantRun


@dataclass(frozen=True, eq=False)
class Comparison:
    """Runs to be compared.

    Attributes
    ----------
    full : VariantRun or None
        None if only the rigid machine was simulated.
    simple : VariantRun
        Run with the simpler body.
    expected : Expected or None
        Estimate of the full machine from this run.
    rules : mapping of str to function
        Rules of the damage of a stress history by body; that of "" is for all others.
    wanted : frozenset of str
        Names of readings or sensors; all if it is empty.
    """

    full: VariantRun | None
    simple: VariantRun
    expected: Expected | None
    rules: Mapping[str, Any]
    wanted: frozenset[str]

    def is_wanted(self, *names: str) -> bool:
        """Return whether a reading with one of these names is to be compared."""
        return not self.wanted or not self.wanted.isdisjoint(names)


def reading_scale(y: Array, floor: float = 0.0) -> float:
    """Return the range of a reading; without a range its largest value."""
    span = float(np.ptp(y))
    return span if span > floor else float(np.abs(y).max())


def common(t: Array, y: Array, other: Array, values: Array) -> tuple[Array, Array, Array]:
    """Return instants of both runs, and both readings there.

    The instants are those of the reading with fewer ones, up to the end of the other one.
    """
    few = len(other) < len(t)
    times = other if few else t
    times = times[times <= min(t[-1], other[-1]) * (1.0 + 1e-12)]
    if few:
        return times, np.interp(times, t, y), values[: len(times)]
    return times, y[: len(times)], np.interp(times, other, values)
