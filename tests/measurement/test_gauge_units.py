"""Values of gauges that were given in another unit are told."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.measurement.gauges.compare import GaugeComparison, GaugePair


@pytest.mark.parametrize(
    ("scale", "correlation", "message"),
    [
        (98.0, 0.999, "given in percent; divide it by 100"),
        (1.1e6, 0.98, "given in um/m; divide it by 1e6"),
        (-9.9e-3, -0.99, "taken as percent; multiply it by 100"),
        (1e-6, 0.99, "taken as um/m; multiply it by 1e6"),
        (1.02, 0.999, ""),
        (98.0, 0.2, ""),
    ],
)
def test_a_scale_that_is_a_unit_is_told(scale: float, correlation: float, message: str) -> None:
    x = np.linspace(-1e-4, 1e-4, 5)
    pair = GaugePair("G1", "g1", "m/m", scale * x, x, correlation, scale, 1e-6)
    text = str(GaugeComparison(np.arange(5.0), (pair,)))
    assert message in text
    assert ("probably" in text) == bool(message)


def test_millivolts_taken_as_volts_are_told() -> None:
    with pytest.raises(jo.InputError, match="if the output is in mV/V"):
        jo.gauges.quarter_bridge_strain(0.998)
    assert jo.gauges.quarter_bridge_strain(0.998e-3) == pytest.approx(0.002, rel=1e-3)
