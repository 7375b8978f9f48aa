"""Stress between stored instants: bounded by the stored velocities, against finely sampled runs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import jousto as jo
from jousto.recovery.fields.build import field_from
from jousto.recovery.hotspots.interval_bounds import PARTS, cubics
from jousto.reduction.fields.stress import StressModes

Array = NDArray[np.float64]
TAU = 2.0 * np.pi


def waves(time: Array, rate: bool = False) -> Array:
    """Two vibrations of 3 and 5 Hz whose sum peaks between most instants."""
    turn = TAU * np.array([3.0, 5.0])
    angle = time[:, None] * turn + [0.3, 1.1]
    return turn * np.cos(angle) if rate else np.sin(angle)


def two_places() -> StressModes:
    S = np.zeros((2, 6, 2))
    S[0, 0] = 50e6, 40e6
    S[1, 3] = 20e6, -30e6
    return StressModes(("a", "b"), np.eye(3)[:2], np.tile(np.eye(3), (2, 1, 1)), S)


@pytest.mark.parametrize("criterion", ["von-mises", "max-shear", "principal-3", "s11"])
@pytest.mark.parametrize("step", [1 / 40, 1 / 80])
def test_a_peak_between_the_instants_is_bounded(criterion: str, step: float) -> None:
    """8 and 16 instants in the shorter period: missed, and bounded closely."""
    time = np.arange(0.0, 1.0, step)
    fine = np.linspace(time[0], time[-1], 20001)
    stored = field_from(two_places(), waves(time), time, v=waves(time, rate=True))
    true = jo.hot_spots(field_from(two_places(), waves(fine), fine), count=2, criterion=criterion)
    found = jo.hot_spots(stored, count=2, criterion=criterion)
    assert abs(found[0].value) < 0.999 * abs(true[0].value)  # the peak is missed
    top = max(abs(spot.value) for spot in true)
    assert top <= found.bound_between
    # and not by more than a few thousandths
    assert found.bound_between <= 1.005 * top
    assert len(found) == 2
    for spot in found:
        same = next(other for other in true if other.site == spot.site)
        assert criterion != "principal-3" or spot.between < 0.0
        assert abs(spot.between) >= abs(same.value)
    assert "between the stored instants no site exceeds" in str(found)


def test_a_cubic_is_what_it_is() -> None:
    """Motion of third degree: the samples lie on it, and the fourth derivative is nothing."""
    time = np.array([0.0, 0.1, 0.25, 0.3])
    a = np.array([0.2, -1.0, 3.0, 5.0])
    p = np.polynomial.polynomial.polyval(time, a)[:, None]
    v = np.polynomial.polynomial.polyval(time, a[1:] * [1, 2, 3])[:, None]
    found = cubics(p, v, time)
    dense = np.concatenate(
        [np.linspace(s, e, PARTS, endpoint=False) for s, e in zip(time[:-1], time[1:], strict=True)]
        + [time[-1:]]
    )
    np.testing.assert_allclose(
        found.path[:, 0], np.polynomial.polynomial.polyval(dense, a), rtol=1e-13
    )
    # between samples: an eighth of h^2 times the largest second derivative, 2 * 3 + 6 * 5 t
    largest = max(
        ((e - s) / PARTS) ** 2 / 8.0 * (6.0 + 30.0 * e)
        for s, e in zip(time[:-1], time[1:], strict=True)
    )
    assert found.stray[0] == pytest.approx(largest, rel=1e-9)


def test_what_is_not_known_is_said() -> None:
    """Without velocities nothing; too few instants for the vibration: store more."""
    time = np.arange(0.0, 1.0, 1 / 40)
    found = jo.hot_spots(field_from(two_places(), waves(time), time), count=1)
    assert np.isnan(found.bound_between) and np.isnan(found[0].between)
    assert "it is not known (no velocities are stored)" in str(found)
    time = np.arange(0.0, 3.0, 1 / 8)
    stored = field_from(two_places(), waves(time), time, v=waves(time, rate=True))
    assert "store more (output_step)" in str(jo.hot_spots(stored, count=1))
    # a sign that jumps has no bound of this kind
    signed = jo.hot_spots(stored, count=1, criterion="signed-von-mises", extreme="largest")
    assert np.isnan(signed.bound_between)


def test_a_run_stored_coarsely(tmp_path: Path) -> None:
    """A link hit at its end: the peak of a run stored finely lies between coarse instants."""
    part = jo.Part.beam(0.8, jo.Rectangle(0.02, 0.05), 6, jo.material("S355"))
    link = jo.FlexibleBody("link", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2)))
    blow = jo.SCurve([0.0, 0.004, 0.008], [0.0, 1.0, 0.0])
    model = jo.compile(
        jo.Mechanism(
            link,
            jo.Fixed("root", jo.ground["origin"], link["start"]),
            jo.Force("blow", link["end"], (0.0, 300.0, 500.0), signal=blow),
        )
    )
    runs = [
        jo.simulate(model, 0.063, solver=jo.ROS2(1e-5), output_step=step, path=tmp_path / f"{k}.h5")
        for k, step in enumerate((1e-5, 3.5e-3))
    ]
    true, found = (jo.hot_spots(run, count=1) for run in runs)
    assert found[0].value < 0.995 * true[0].value
    assert found[0].value < true[0].value <= found.bound_between <= 1.1 * true[0].value
    assert true[0].value <= found[0].between
    assert true.bound_between == pytest.approx(true[0].value, rel=1e-3)
