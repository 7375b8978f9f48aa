"""Bands that hold errors which stay through a record: modulus, gauge factor, place, direction."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import jousto as jo
from jousto.measurement.twin.bands.bands import stress_band
from jousto.measurement.twin.estimates import Posterior
from jousto.measurement.twin.signals import gauge_errors
from jousto.recovery.fields.criteria import evaluate
from jousto.reduction.fields.stress import StressModes
from parts.grids import grid

E, H = 2.1e11, 0.01
PLACES = [
    (x, 0.0, z) for x, z in zip((0.05, 0.2, 0.35, 0.5, 0.65, 0.8), 3 * (H / 2, -H / 2), strict=True)
]
SITES = ("e1.a.bottom", "e8.a.top", "e15.a.bottom")
DRAWS = 400
# a share of 0.95 in 400 draws, three standard errors either way
LOW, HIGH = 0.95 - 3 * np.sqrt(0.95 * 0.05 / DRAWS), 0.95 + 3 * np.sqrt(0.95 * 0.05 / DRAWS)


@cache
def rod() -> jo.ReducedPart:
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, H), 20, jo.Material(E=E, nu=0.3, rho=7850))
    held = jo.reduction.clamp(jo.reduce(part, jo.CraigBampton(("start", "end"), modes=3)), "start")
    return held.keep(held.in_plane("xz"))


def gauges(reduced: jo.ReducedPart, shift=(0.0,) * 6) -> list[jo.gauges.Gauge]:
    return [
        jo.gauges.Gauge(f"g{i}", reduced, (x + dx, y, z))
        for i, ((x, y, z), dx) in enumerate(zip(PLACES, shift, strict=True))
    ]


def coverage(criterion: str, scale: float, said: dict, made: dict, seed: int) -> np.ndarray:
    """Share of independent instants, each of another machine, at which a band holds the truth."""
    rng = np.random.default_rng(seed)
    reduced = rod()
    fit = gauges(reduced)
    B = jo.gauges.gauge_rows(fit)
    errors = gauge_errors(fit, **said) if said else None
    twin = jo.twin.Reconstruction(B, noise=1e-6, errors=errors)
    S = reduced.stress.modes[[reduced.stress.labels.index(x) for x in SITES]]
    size = np.array([1.0, 0.1, 0.02, 0.002, 0.002])
    p = 0.02 * rng.normal(size=(DRAWS, len(size))) * size
    e, truth = np.empty((DRAWS, len(B))), np.empty((DRAWS, len(SITES)))
    for k, one in enumerate(p):
        modulus = 1.0 + made.get("modulus", 0.0) * rng.normal()
        shared = 1.0 + made.get("shared", 0.0) * rng.normal()
        own = 1.0 + made.get("factor", 0.0) * rng.normal(size=len(B))
        shift = made.get("position", 0.0) * rng.normal(size=len(B))
        rows = jo.gauges.gauge_rows(gauges(reduced, shift)) if shift.any() else B
        e[k] = shared * own * (rows @ one) + 1e-6 * rng.normal(size=len(B))
        # the same strain from another modulus is another stress
        truth[k] = modulus * evaluate(S @ one, criterion)
    band = stress_band(twin.estimate(e), reduced, criterion, sites=SITES, scale=scale)
    return band.inside(truth)


@pytest.mark.parametrize("criterion", ["s11", "signed-von-mises"])
def test_bands_hold_the_truth_of_machines_drawn_at_random(criterion):
    made = {"modulus": 0.05, "shared": 0.01}
    scale = float(np.hypot(0.05, 0.01))
    found = coverage(criterion, scale, {}, made, seed=1)
    assert np.all((found > LOW) & (found < HIGH)), found
    # the noise alone holds a small part of it
    assert np.all(coverage(criterion, 0.0, {}, made, seed=1) < 0.5)


def test_bands_hold_gauges_that_differ_and_sit_beside_their_place():
    said = {"factor": 0.01, "position": 2e-3}
    found = coverage("s11", 0.03, said, {**said, "modulus": 0.03}, seed=2)
    assert np.all((found > LOW) & (found < HIGH)), found
    found = coverage("signed-von-mises", 0.0, said, said, seed=3)
    assert np.all((found > LOW) & (found < HIGH)), found
    assert np.all(coverage("s11", 0.0, {}, said, seed=2) < 0.8)


def test_the_band_of_one_gauge_and_one_mode_is_the_sum_of_squares():
    # e = 100 um/m: 1 um/m of noise, 2 % of scale, 3 % of its own factor: sqrt(1 + 4 + 9) % of it
    S = np.zeros((1, 6, 1))
    S[0, 0, 0] = E
    modes = StressModes(("n",), np.zeros((1, 3)), np.eye(3)[None], S)
    twin = jo.twin.Reconstruction([[1.0]], noise=1e-6, errors=0.03 * np.ones((1, 1, 1)))
    band = stress_band(twin.estimate([[100e-6]]), modes, "s11", scale=0.02)
    half = 0.5 * (band.high - band.low)[0, 0]
    assert half == pytest.approx(1.959964 * np.sqrt(14.0) * 1e-6 * E, rel=1e-6)
    # a mises stress of one component is the same, sampled near zero only
    bent = stress_band(twin.estimate([[100e-6]]), modes, "signed-von-mises", scale=0.02)
    assert 0.5 * (bent.high - bent.low)[0, 0] == pytest.approx(half, rel=1e-6)
    # a silent gauge brings no error of its own
    two = jo.twin.Reconstruction([[1.0], [1.0]], noise=1e-6, errors=[[[0.03], [0.0]]])
    one = stress_band(two.estimate([[np.nan, 100e-6]]), modes, "s11")
    assert 0.5 * (one.high - one.low)[0, 0] == pytest.approx(1.959964e-6 * E, rel=1e-6)


def test_slope_of_the_strain_along_a_cantilever():
    # load at the end: strain at the top is -F (L - x) h / (2 E I), its slope F h / (2 E I)
    reduced = rod()
    gauge = jo.gauges.Gauge("g", reduced, (0.5, 0.0, H / 2))
    tip = reduced.modes[reduced.node("end"), 2]
    p = tip / reduced.stiffness  # at rest under 1 N
    slope = H / 2 / (E * 0.02 * H**3 / 12)
    found = gauge_errors([gauge], position=1e-3)
    assert found.shape[:2] == (1, 1)
    assert abs(found[0, 0] @ p) == pytest.approx(1e-3 * slope, rel=1e-6)


def test_turned_gauge_in_shear():
    # gauge at angle theta to the axis: de/dtheta of the strain tensor, by the tensor itself
    size = (0.2, 0.02, 0.01)
    part = jo.Part.solid(grid("hexahedron20", (8, 2, 2), size), jo.Material(E, 0.3, 7850))
    reduced = jo.reduce(part, jo.FreeFree(modes=12))
    gauge = jo.gauges.Gauge("g", reduced, (0.09, 0.008, 0.01), (1.0, 0.3, 0.0))
    found = gauge_errors([gauge], angle=0.02)[0, 0] / 0.02
    t = gauge.axis

    def row(angle):
        c, s = np.cos(angle), np.sin(angle)
        d = np.array([c * t[0] - s * t[1], s * t[0] + c * t[1], 0.0])
        return jo.gauges.Gauge("h", reduced, gauge.position, d).rows[0]

    # e = a + b cos 2 theta + c sin 2 theta: its slope from three directions
    a, b, c = row(0.0), row(np.pi / 4), row(-np.pi / 4)
    np.testing.assert_allclose(np.abs(found), np.abs(b - c), rtol=1e-3, atol=1e-6 * np.abs(a).max())


def test_impossible_errors_are_told():
    reduced = rod()
    fit = gauges(reduced)
    with pytest.raises(jo.InputError) as told:
        gauge_errors(fit, factor=-1.0, position=-1.0, angle=2.0)
    assert len(told.value.problems) == 3
    with pytest.raises(jo.InputError, match="there is no gauge"):
        gauge_errors([])
    with pytest.raises(jo.InputError, match="errors"):
        jo.twin.Reconstruction(jo.gauges.gauge_rows(fit), errors=np.zeros((1, 2, 3)))
    nothing = Posterior(
        np.zeros(0), np.zeros((0, reduced.n)), np.zeros((1, 5, 5)), np.zeros(0, int)
    )
    with pytest.raises(jo.InputError, match="share such as 0.03"):
        stress_band(nothing, reduced, "s11", scale=3.0)
