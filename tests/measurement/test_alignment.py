"""Alignment of measured records with runs: shifts between samples are found."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import jousto as jo


def signal(t, rng_seed=4):
    """Return a band-limited signal that does not repeat itself, 0 to 12 Hz."""
    rng = np.random.default_rng(rng_seed)
    f, a, p = rng.uniform(0.2, 12.0, 40), rng.standard_normal(40), rng.uniform(0, 6.28, 40)
    return 1e-4 * np.sum(a[:, None] * np.sin(2 * np.pi * f[:, None] * t + p[:, None]), axis=0)


@pytest.mark.parametrize("true", [0.73213, -1.41877, 0.0])
@pytest.mark.parametrize("rates", [(100.0, 100.0), (200.0, 73.0), (60.0, 500.0)])
def test_shift_between_samples(true, rates):
    """Other rates and starts, noise of 2 %, gain 1.1: the shift to a hundredth of a sample."""
    ra, rb = rates
    tb = np.arange(0, 12, 1 / rb)
    other = jo.gauges.Record(tb, {"model": signal(tb)}, {"model": "m/m"}, name="run")
    ta = np.arange(2.0, 9.0, 1 / ra)
    rng = np.random.default_rng(1)
    x = 1.1 * signal(ta) + 2e-2 * 4e-4 * rng.standard_normal(len(ta))
    measured = jo.gauges.Record(ta - true, {"g1": x}, {"g1": "m/m"}, name="test")
    fit = jo.gauges.align(measured, other, "g1", "model")
    assert fit.shift == pytest.approx(true, abs=0.02 / min(rates))
    assert fit.correlation > 0.995
    assert fit.scale == pytest.approx(1.1, rel=0.01)
    assert fit.uncertainty < 1e-3
    np.testing.assert_allclose(fit.record.time, measured.time + fit.shift)
    assert f"shift {fit.shift:+.6g} s" in str(fit)


def test_missing_values_do_not_disturb():
    t = np.arange(0, 8, 0.01)
    x = signal(t)
    holes = x.copy()
    holes[100:120] = np.nan
    fit = jo.gauges.align(
        jo.gauges.Record(t - 0.333, {"g": holes}), jo.gauges.Record(t, {"g": x}), "g"
    )
    assert fit.shift == pytest.approx(0.333, abs=1e-4)


def test_events():
    """A light barrier: three steps in the model, two of them in the record."""
    t = np.arange(0, 10, 0.01)
    steps = sum(1.0 * (np.abs(t - c) < 0.5) for c in (2.0, 4.7, 8.3))
    other = jo.gauges.Record(t, {"gate": steps})
    later = (t > 3.5) & (t < 9.5)
    measured = jo.gauges.Record(t[later] - 3.5 + 100.0, {"gate": steps[later]})
    fit = jo.gauges.align(measured, other, "gate", level=0.5)
    assert fit.shift == pytest.approx(-96.5, abs=1e-9)
    assert fit.uncertainty < 1e-9
    np.testing.assert_allclose(other.crossings("gate", 0.5), [1.505, 4.205, 7.805], atol=0.006)
    assert len(other.crossings("gate", 0.5, 0)) == 6
    with pytest.raises(jo.InputError, match="never rises through 5; it goes from 0 to 1"):
        jo.gauges.align(measured, other, "gate", level=5.0)


def test_what_is_told():
    t = np.arange(0, 8, 0.01)
    x = signal(t)
    record = jo.gauges.Record(t, {"g": x, "flat": 0 * x, "wave": np.sin(2 * np.pi * 2 * t)})
    other = jo.gauges.Record(
        t, {"g": -x, "wave": np.sin(2 * np.pi * 2 * t), "noise": signal(t, 99)}
    )
    with pytest.warns(jo.JoustoWarning, match="fit best with opposite sign"):
        jo.gauges.align(record, other, "g")
    with pytest.warns(jo.JoustoWarning, match="fits as well as .* the signal repeats itself"):
        jo.gauges.align(record, other, "wave")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert abs(jo.gauges.align(record, other, "wave", max_shift=0.2).shift) < 1e-6
    with pytest.warns(jo.JoustoWarning, match="hardly agree at any shift"):
        jo.gauges.align(record, other, "g", "noise", max_shift=0.3)
    with pytest.raises(jo.InputError) as error:
        jo.gauges.align(record, other, "flat", "nothing", max_shift=-1.0)
    assert len(error.value.problems) == 3
