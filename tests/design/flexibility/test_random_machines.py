"""Estimates of random machines against the losses of their runs, reading by reading."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from design.flexibility.random_machines import random_readings
from jousto.design.flexibility.body_advice import ReadingAdvice


def advised(seeds: Iterable[int]) -> dict[str, ReadingAdvice]:
    """Return the readings of random machines by ``machine: rigid body: reading``."""
    return {name: one for seed in seeds for name, one in random_readings(seed).items()}


def too_low(readings: dict[str, ReadingAdvice]) -> dict[str, float]:
    """Return estimate / measured loss of the readings whose estimate is too low."""
    ratios = {
        name: one.estimate / one.measured.difference
        for name, one in readings.items()
        if one.measured is not None
    }
    assert len(ratios) == len(readings)
    return {name: ratio for name, ratio in ratios.items() if not ratio >= 0.8}


def finite(readings: dict[str, ReadingAdvice]) -> float:
    """Return the share of the readings with a finite estimate."""
    return float(np.mean([np.isfinite(one.estimate) for one in readings.values()]))


@pytest.mark.parametrize(
    "seeds",
    [
        range(3),
        pytest.param(range(3, 12), marks=pytest.mark.slow),
        pytest.param(range(12, 30), marks=pytest.mark.slow),
    ],
)
def test_estimates_of_random_machines_are_upper_figures(seeds: range) -> None:
    readings = advised(seeds)
    assert len(readings) > 20 * len(seeds)
    assert too_low(readings) == {}
    # an upper figure of everything would be no estimate
    assert finite(readings) >= 0.4
