"""Strains and stresses from rosettes."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo

STEEL = {"E": 210e9, "nu": 0.3}


def test_worked_example():
    """Rectangular rosette: exx = ea, eyy = ec, gxy = 2 eb - ea - ec; values worked by hand."""
    state = jo.gauges.rosette_state([200e-6, 80e-6, -50e-6], **STEEL)
    np.testing.assert_allclose((state.exx, state.eyy, state.gxy), (200e-6, -50e-6, 10e-6))
    found = np.array([state.sxx, state.syy, state.txy, state.s1, state.s2, state.von_mises])
    by_hand = (42.6923, 2.30769, 0.807692, 42.70846, 2.29154, 41.61003)
    np.testing.assert_allclose(found, 1e6 * np.array(by_hand), rtol=3e-6)
    assert np.degrees(state.angle) == pytest.approx(1.14531, abs=5e-6)


@pytest.mark.parametrize("kind", ["45", "60", "delta", "rectangular"])
@pytest.mark.parametrize("K", [0.0, 0.03])
def test_any_plane_state_comes_back(kind, K, rng):
    """Grids of known strains, with transverse sensitivity, over a history of two axes."""
    exx, eyy, gxy = 1e-4 * rng.standard_normal((3, 4, 5))
    angles = np.radians((0, 45, 90) if kind in ("45", "rectangular") else (0, 60, 120))
    along = [
        exx * np.cos(t) ** 2 + eyy * np.sin(t) ** 2 + gxy * np.sin(t) * np.cos(t) for t in angles
    ]
    shown = np.stack([(e + K * (exx + eyy - e)) / (1 - 0.285 * K) for e in along], axis=-1)
    state = jo.gauges.rosette_state(shown, kind=kind, transverse=K, **STEEL)
    np.testing.assert_allclose(state.exx, exx, atol=1e-15)
    np.testing.assert_allclose(state.eyy, eyy, atol=1e-15)
    np.testing.assert_allclose(state.gxy, gxy, atol=1e-15)
    # principal values and directions are those of the tensor
    for i in np.ndindex(exx.shape):
        S = np.array([[state.sxx[i], state.txy[i]], [state.txy[i], state.syy[i]]])
        values, vectors = np.linalg.eigh(S)
        np.testing.assert_allclose((state.s2[i], state.s1[i]), values, rtol=1e-9, atol=1e-3)
        n = (np.cos(state.angle[i]), np.sin(state.angle[i]))
        assert abs(vectors[:, 1] @ n) == pytest.approx(1.0, abs=1e-9)
        assert state.shear[i] == pytest.approx((values[1] - values[0]) / 2, rel=1e-9)


def test_noise_as_a_sample_shows(rng):
    """Standard deviations to the first order are those of a large sample."""
    e, noise = np.array([200e-6, 80e-6, -50e-6]), np.array([1e-6, 2e-6, 0.5e-6])
    state = jo.gauges.rosette_state(e, noise=noise, **STEEL)
    sample = jo.gauges.rosette_state(e + noise * rng.standard_normal((20_000, 3)), **STEEL)
    for key in ("gxy", "e1", "s1", "s2", "angle", "von_mises"):
        assert state.sd[key] == pytest.approx(np.std(getattr(sample, key)), rel=0.03), key
    assert "+-" in str(state)


def test_tee_and_equal_strains():
    tee = jo.gauges.rosette_state([100e-6, -30e-6], kind="tee", **STEEL)
    assert tee.s1 == pytest.approx(210e9 * 91e-6 / 0.91)
    assert tee.s2 == pytest.approx(0.0, abs=1e-9 * tee.s1)
    even = jo.gauges.rosette_state([100e-6, 100e-6, 100e-6], **STEEL)
    assert np.isnan(even.angle)
    assert even.s1 == pytest.approx(210e9 * 100e-6 / 0.7)


def test_pressure_vessel():
    """Thin closed vessel: hoop p r/t, axial half of it; a rosette 20 degrees off the hoop."""
    p, r, t = 2e6, 0.5, 0.01
    hoop, axial = p * r / t, p * r / (2 * t)
    eh, ea = (hoop - 0.3 * axial) / 210e9, (axial - 0.3 * hoop) / 210e9
    angles = np.radians(20.0) + np.radians([0, 60, 120])
    grids = eh * np.cos(angles) ** 2 + ea * np.sin(angles) ** 2
    state = jo.gauges.rosette_state(grids, kind="60", **STEEL)
    assert state.s1 == pytest.approx(hoop)
    assert state.s2 == pytest.approx(axial)
    assert np.degrees(state.angle) == pytest.approx(-20.0)


def test_what_is_wrong():
    with pytest.raises(jo.InputError) as error:
        jo.gauges.rosette_state([200.0, 80.0, -50.0], **STEEL)
    assert "a strain is 200 m/m: it was likely given in um/m: divide by 1e6" in str(error.value)
    with pytest.raises(jo.InputError) as error:
        jo.gauges.rosette_state([1e-6, 1e-6], kind="x", E=0.0, nu=0.7)
    assert len(error.value.problems) == 3
    with pytest.raises(jo.InputError, match=r"e has shape \(2,\), the last must be 3"):
        jo.gauges.rosette_state([1e-6, 1e-6], **STEEL)


@pytest.mark.parametrize(
    ("e", "E", "message"),
    [
        ([0.02, 0.008, -0.005], 210e9, "percent: divide by 100"),
        ([9e-3, 9e-3, 9e-3], 210e9, "beyond most steels"),
        ([2e-4, 8e-5, -5e-5], 210e3, "was it given in MPa"),
    ],
)
def test_other_units_are_warned_of(e: list[float], E: float, message: str) -> None:
    with pytest.warns(jo.JoustoWarning, match=message):
        jo.gauges.rosette_state(e, E=E, nu=0.3)


def test_no_direction_is_printed_where_all_are_equal() -> None:
    same = str(jo.gauges.rosette_state([1e-4, 1e-4, 1e-4], E=210e9, nu=0.3, noise=1e-6))
    assert "undefined" in same
    assert "nan" not in same
    clear = str(jo.gauges.rosette_state([2e-4, 8e-5, -5e-5], E=210e9, nu=0.3, noise=1e-6))
    assert "deg from grid a" in clear
    assert "undefined" not in clear
