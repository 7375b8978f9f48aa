"""Strain reconstruction: the cantilever's published numbers, laws of least squares, bad input."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import jousto as jo
from measurement.twin.cantilever import STEEL, Clamped, E, H, L, clamped


@pytest.fixture(scope="module")
def beam() -> Clamped:
    return clamped()


def tip_response(beam: Clamped, frequency: float) -> np.ndarray:
    """Displacements under a unit force at the tip that oscillates, undamped."""
    F = np.zeros(len(beam.K))
    F[-2] = 1.0
    return np.linalg.solve(beam.K - (2 * np.pi * frequency) ** 2 * beam.M, F)


def test_frequencies_of_the_cantilever(beam: Clamped) -> None:
    # Euler-Bernoulli beam of 20 elements; the first is 1.8751^2 sqrt(EI / (m L^3)) / (2 pi)
    found = beam.omega[:4] / (2 * np.pi)
    np.testing.assert_allclose(found, [8.35517, 52.3610, 146.615, 287.319], rtol=5e-6)


@pytest.mark.parametrize(("modes", "expected"), [(3, 1.01459), (5, 1.00399)])
def test_normal_modes_alone_miss_the_root(beam: Clamped, modes: int, expected: float) -> None:
    """Truncation: 3 modes give 1.5 % too much at the clamp, 5 modes 0.4 %."""
    twin = jo.twin.Reconstruction(beam.strain @ beam.modes[:, :modes])
    u = 1e-3 * tip_response(beam, 3.0)
    p = twin.estimate(beam.strain @ u).p[0]
    # 1e-4: which side of a node the gauge lies on decides the fifth digit
    assert beam.clamp @ beam.modes[:, :modes] @ p / (beam.clamp @ u) == pytest.approx(
        expected, abs=1e-4
    )


def test_static_shape_completes_the_basis(beam: Clamped) -> None:
    shapes = np.column_stack([tip_response(beam, 0.0), beam.modes[:, :3]])
    shapes /= np.sqrt(np.einsum("ij,ij->j", shapes, beam.M @ shapes))
    twin = jo.twin.Reconstruction(beam.strain @ shapes)
    errors = {}
    for frequency in (0.0, 3.0, 6.0, 9.0):
        u = 1e-3 * tip_response(beam, frequency)
        ratio = beam.clamp @ shapes @ twin.estimate(beam.strain @ u).p[0] / (beam.clamp @ u)
        errors[frequency] = ratio - 1.0
    assert np.abs(list(errors.values())).max() < 2e-6
    assert errors[3.0] == pytest.approx(7e-7, abs=1e-7)


@pytest.mark.filterwarnings("ignore:.*contradict one another")
def test_estimate_is_that_of_bayes(rng: np.random.Generator) -> None:
    """Gain and covariance against the normal equations of the text books."""
    B = rng.normal(size=(5, 3))
    root = rng.normal(size=(5, 5))
    R, G = 1e-12 * (root @ root.T + np.eye(5)), np.diag([1e-10, 4e-10, 1e-12])
    twin = jo.twin.Reconstruction(B, noise=R, prior=G)
    e = 1e-4 * rng.normal(size=(4, 5))
    e[1, 2] = e[2, :] = np.nan
    found = twin.estimate(e)
    for k in range(4):
        seen = np.isfinite(e[k])
        Ri = np.linalg.inv(R[np.ix_(seen, seen)]) if seen.any() else np.zeros((0, 0))
        P = np.linalg.inv(B[seen].T @ Ri @ B[seen] + np.linalg.inv(G))
        np.testing.assert_allclose(found.covariance[k], P, rtol=1e-6, atol=1e-18)
        np.testing.assert_allclose(found.p[k], P @ B[seen].T @ Ri @ e[k, seen], rtol=1e-6)
    np.testing.assert_allclose(found.p[2], 0.0)
    np.testing.assert_allclose(found.band[2], np.sqrt(np.diag(G)))


@pytest.mark.filterwarnings("ignore:.*contradict one another")
def test_left_out_residual_is_that_without_the_gauge(rng: np.random.Generator) -> None:
    B, R = rng.normal(size=(6, 3)), np.diag(1e-12 * rng.uniform(1.0, 3.0, 6))
    e = 1e-4 * rng.normal(size=6)
    whole = jo.twin.Reconstruction(B, noise=R, prior=1e-3).estimate(e)
    for g in range(6):
        rest = np.arange(6) != g
        twin = jo.twin.Reconstruction(B[rest], noise=R[np.ix_(rest, rest)], prior=1e-3)
        without = twin.estimate(e[rest])
        np.testing.assert_allclose(whole.leave_one_out[0, g], e[g] - B[g] @ without.p[0], rtol=1e-6)
        expected = np.sqrt(R[g, g] + B[g] @ without.covariance[0] @ B[g])
        np.testing.assert_allclose(whole.expected[0, g], expected, rtol=1e-6)


def test_bands_hold_the_truth_as_often_as_they_say(rng: np.random.Generator) -> None:
    B = rng.normal(size=(7, 4))
    p = 1e-4 * rng.normal(size=(5000, 4))
    e = p @ B.T + 1e-6 * rng.normal(size=(5000, 7))
    e[rng.random(e.shape) < 0.05] = np.nan
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # rows with fewer than four gauges
        found = jo.twin.Reconstruction(B, noise=1e-6).estimate(e)
    good = np.isfinite(found.p[:, 0])
    z = (found.p - p)[good] / found.band[good]
    # 95 % of 5000 rows: 2.5 standard deviations of the share are 0.8 %
    np.testing.assert_allclose((np.abs(z) < 1.96).mean(axis=0), 0.95, atol=0.012)
    np.testing.assert_allclose(found.score, 1.0, atol=0.05)


def test_calibration_finds_the_noise(rng: np.random.Generator) -> None:
    B = rng.normal(size=(8, 3))
    e = 1e-4 * rng.normal(size=(2000, 3)) @ B.T + 5e-6 * rng.normal(size=(2000, 8))
    for prior in (None, 1e-4):
        twin = jo.twin.Reconstruction(B, noise=1e-6, prior=prior).calibrated(e)
        np.testing.assert_allclose(np.sqrt(np.diag(twin.noise)), 5e-6, rtol=0.05)


def test_a_dead_gauge_is_estimated_without(rng: np.random.Generator) -> None:
    B = rng.normal(size=(6, 3))
    p = 1e-4 * rng.normal(size=(50, 3))
    e = p @ B.T
    e[20:, 4] = np.nan
    found = jo.twin.Reconstruction(B).estimate(e, 0.1 * np.arange(50))
    np.testing.assert_allclose(found.p, p, atol=1e-15)
    assert (found.band[20:] > found.band[:1]).all()
    assert np.isnan(found.residual[20:, 4]).all()


def test_fewer_gauges_than_modes() -> None:
    B = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    with pytest.raises(jo.InputError, match=r"2 gauges distinguish 2 of 3 modes.*give prior="):
        jo.twin.Reconstruction(B)
    with pytest.warns(jo.JoustoWarning, match="the prior alone determines the other 1 combination"):
        twin = jo.twin.Reconstruction(B, prior=1e-4)
    # what is not seen keeps the prior's spread: (1, 0, -1)
    direction = np.array([1.0, 0.0, -1.0]) / np.sqrt(2.0)
    P = twin.estimate([1e-4, 1e-4]).covariance[0]
    np.testing.assert_allclose(direction @ P @ direction, 1e-8, rtol=1e-6)


def test_collinear_gauges_are_named() -> None:
    B = np.array([[1.0, 2.0], [2.0, 4.0], [-1.0, -2.0]])
    with pytest.raises(jo.InputError, match=r"3 gauges distinguish 1 of 2 modes; 'b' and 'a', "):
        jo.twin.Reconstruction(B, names=("a", "b", "c"))


def test_condition_number_is_told() -> None:
    with pytest.warns(jo.JoustoWarning, match="condition number 2e\\+05"):
        jo.twin.Reconstruction([[1.0, 0.0], [1.0, 1e-5]])


@pytest.mark.parametrize(
    ("e", "time", "message"),
    [
        ([[0.05, 0.01]], None, "looks like percent: divide by 100"),
        ([[350.0, 20.0]], None, "looks like um/m: divide by 1e6"),
        ([[1e-4, 1e-4, 1e-4]], None, r"shape \(1, 3\), must be \(instants, 2\)"),
        (np.zeros((2, 5)), None, "looks transposed"),
        ([[1e-4, np.inf]], None, "channel 'right' is infinite at row 0"),
        (np.zeros((3, 2)), [0.0, 2.0, 1.0], "time runs backwards or stands still: 2 s is followed"),
        (np.zeros((3, 2)), [0.0, 1.0], "2 times for 3 rows"),
        ([["a", "b"]], None, "not an array of numbers"),
    ],
)
def test_bad_records(e: object, time: object, message: str) -> None:
    twin = jo.twin.Reconstruction([[1.0], [2.0]], names=("left", "right"))
    with pytest.raises(jo.InputError, match=message):
        twin.estimate(e, time)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("noise", "message"),
    [
        (0.0, "noise is 0 m/m, must be positive"),
        ([1e-6, -1e-6], "noise is -1e-06 m/m, must be positive"),
        (1.0, "noise is 1 m/m; standard deviations are in m/m"),
        ([1e-6] * 3, "noise has 3 values, must be 1 or 2"),
        ([[1e-12, 2e-12], [2e-12, 1e-12]], "not a covariance matrix: its smallest eigenvalue"),
        ([[1e-12, 1e-12], [0.0, 1e-12]], "not symmetric"),
        ("much", "must be standard deviations"),
    ],
)
def test_bad_noise(noise: object, message: str) -> None:
    with pytest.raises(jo.InputError, match=message):
        jo.twin.Reconstruction([[1.0], [2.0]], noise=noise)


def test_row_that_too_few_gauges_see_is_nan() -> None:
    twin = jo.twin.Reconstruction(np.eye(2))
    with pytest.warns(jo.JoustoWarning, match="at 1 instant of 2 too few gauges"):
        found = twin.estimate([[1e-4, 1e-4], [1e-4, np.nan]])
    assert np.isfinite(found.p[0]).all() and np.isnan(found.p[1]).all()


def test_strains_in_percent_contradict_one_another() -> None:
    """Small strains in percent pass as large ones; what does not fit is a hundredfold, too."""
    rng = np.random.default_rng(3)
    B = rng.standard_normal((6, 2))
    e = 1e-5 * rng.standard_normal((50, 2)) @ B.T + 1e-6 * rng.standard_normal((50, 6))
    twin = jo.twin.Reconstruction(B)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        twin.estimate(e)
    with pytest.warns(jo.JoustoWarning, match="contradict one another"):
        twin.estimate(100.0 * e)


@pytest.mark.parametrize(
    ("strain", "message"), [(0.012, "percent"), (0.9, "percent"), (10.57, "um/m: divide by 1e6")]
)
def test_every_door_names_the_same_unit(strain: float, message: str) -> None:
    from jousto.measurement.gauges.record import too_large

    twin = jo.twin.Reconstruction([[1.0], [1.0]])
    with pytest.raises(jo.InputError, match=message):
        twin.estimate([[strain, strain]])
    assert ("um/m'" if strain > 1 else "'%'") in too_large("g", np.array([strain]))


def test_damage_of_single_instants_is_refused_in_words() -> None:
    found = jo.twin.Reconstruction([[1.0], [1.0]]).estimate([[1e-4, 1e-4]])
    with pytest.raises(jo.InputError, match=r"must be from Observer\.run"):
        jo.twin.damage_band(found, None, None, residue="half")  # type: ignore[arg-type]


def test_what_is_advised_where_gauges_are_too_few_still_tells_the_load() -> None:
    """A static load at the tip: the shapes that it needs are those of the interfaces."""
    rod = jo.Part.beam(L, jo.Rectangle(0.02, H), 12, STEEL)
    sites = [f"e{k}.a.{side}" for k in (2, 5, 8, 11) for side in ("top", "bottom")]

    def reduced(modes: int) -> jo.reduction.ReducedPart:
        whole = jo.reduce(rod, jo.CraigBampton(["start", "end"], modes=modes))
        held = jo.reduction.clamp(whole, "start")
        return held.keep(held.in_plane("xz"))

    def rows(body: jo.reduction.ReducedPart) -> np.ndarray:
        places = [body.stress.labels.index(site) for site in sites]
        return body.stress.modes[places, 0] / E

    def load(body: jo.reduction.ReducedPart) -> float:
        p = jo.twin.Reconstruction(rows(body)).estimate(rows(fine) @ bent).p[0]
        shapes = body.modes[body.node("end")]  # (3, n)
        return float(np.linalg.lstsq(shapes.T, body.stiffness * p, rcond=None)[0][2])

    fine = reduced(14)
    bent = fine.modes[fine.node("end")].T @ [0.0, 0.0, -100.0] / fine.stiffness
    with pytest.raises(jo.InputError, match=r"weigh the modes by their stiffness \(jo.t") as found:
        load(fine)
    # the mode of the largest displacement per strain is no mode that may be left out
    assert "hardly seen" not in str(found.value)
    # solved with condition numbers of 1e4
    assert load(reduced(2)) == pytest.approx(-100.0, rel=1e-6)
    cut = fine.keep(range(reduced(2).n))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert abs(load(cut) + 100.0) > 5.0
