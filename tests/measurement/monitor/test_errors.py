"""Bands of a monitor and an observer that hold errors which no record shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import jousto as jo
from jousto.measurement.monitor.health import ChannelRules
from jousto.measurement.monitor.monitor import Monitor
from jousto.measurement.twin.bands.bands import stress_band
from jousto.measurement.twin.bands.life import damage_band
from jousto.measurement.twin.signals import gauge_errors
from jousto.measurement.twin.smoother import smooth
from measurement.monitor.test_observed import NOISE, SPOTS, STEP, held, rows, swung
from measurement.monitor.watched import NAMES, cantilever

DRAWS = 400
# a share of 0.95 in 400 draws, three standard errors either way
LOW, HIGH = 0.95 - 3 * np.sqrt(0.95 * 0.05 / DRAWS), 0.95 + 3 * np.sqrt(0.95 * 0.05 / DRAWS)
X = (0.05, 0.15, 0.35, 0.55, 0.75)
STILL = ChannelRules(stuck=0, spike=0.0)
"""Samples are independent here, not a motion."""


def glued(part, shift=(0.0, 0.0, 0.0, 0.0, 0.0)):
    """The gauges on a cantilever of 1 m, on top and below in turn, or beside their places."""
    return [
        jo.gauges.Gauge(f"g{i + 1}", part, (x + dx, 0.0, 0.005 * (-1) ** i))
        for i, (x, dx) in enumerate(zip(X, shift, strict=True))
    ]


def larger(nt):
    """Time, part and modes of a motion of some 60 MPa, at which errors in proportion count.

    The part is that of the twin: what fewer modes miss is the discrepancy, another error.
    """
    t, part, p = swung(nt, modes=1)
    return t, part, 10.0 * p


def recorded(nt, seed=0):
    """Time, strains of the gauges with noise and stress of a motion."""
    t, part, p = larger(nt)
    e = p @ jo.gauges.gauge_rows(glued(part)).T
    noise = NOISE * np.random.default_rng(seed).standard_normal(e.shape)
    return t, e + noise, p @ rows(part, SPOTS).T


@pytest.mark.parametrize("criterion", ["s11", "von-mises", "signed-von-mises", "principal-1"])
def test_a_monitor_has_the_bands_of_the_whole_record(criterion):
    """Noise, discrepancy, errors of gauges and in proportion; gauges that are silent; near zero."""
    reduced, B = cantilever()
    spots = ("e1.a.top", "e2.a.bottom", "e9.b.top")
    rng = np.random.default_rng(3)
    p = 0.02 * rng.normal(size=(300, 2)) * (1.0, 0.1) * rng.uniform(0.0, 1.0, size=(300, 1)) ** 4
    e = p @ B.T + 1e-6 * rng.normal(size=(300, len(B)))
    e[100:200, 2] = np.nan
    errors = np.array([0.01 * B, 0.002 * np.roll(B, 1, axis=0)])
    given = {"noise": 1e-6, "names": NAMES, "discrepancy": 2e-6}
    for own, scale in ((None, 0.0), (errors, 0.0), (None, 0.05), (errors, 0.03)):
        twin = jo.twin.Reconstruction(B, errors=own, **given)
        watched = Monitor(twin, reduced, spots, criterion=criterion, scale=scale, rules=STILL)
        t = 0.01 * np.arange(300.0)
        parts = [watched.push(t[i : i + 7], e[i : i + 7]) for i in range(0, 300, 7)]
        found = [np.vstack([getattr(x, name) for x in parts]) for name in ("stress", "low", "high")]
        whole = stress_band(twin.estimate(e), reduced, criterion, sites=spots, scale=scale)
        back = np.ones(300, dtype=bool)
        back[200:210] = False  # a channel that comes back is believed after ten samples
        for name, x in zip(("value", "low", "high"), found, strict=True):
            np.testing.assert_allclose(
                x[back], getattr(whole, name)[back], rtol=1e-9, atol=1e-3, err_msg=name
            )


def machines(seed, said, modulus):
    """Strains and stress of one instant each of machines drawn at random, and their twin."""
    rng = np.random.default_rng(seed)
    part = held(1)
    fit = glued(part)
    B = jo.gauges.gauge_rows(fit)
    S = rows(part, SPOTS)
    p = 0.02 * rng.normal(size=(DRAWS, part.n)) * (1.0, 0.1, 0.02, 0.002)[: part.n]
    e = np.empty((DRAWS, len(B)))
    for k, one in enumerate(p):
        shift = said["position"] * rng.normal(size=len(B))
        own = 1.0 + said["factor"] * rng.normal(size=len(B))
        e[k] = own * (jo.gauges.gauge_rows(glued(part, shift)) @ one) + NOISE * rng.normal(
            size=len(B)
        )
    truth = (1.0 + modulus * rng.normal(size=(DRAWS, 1))) * (p @ S.T)
    return part, fit, B, e, truth


@pytest.mark.parametrize("criterion", ["s11", "signed-von-mises"])
def test_a_monitor_holds_machines_drawn_at_random(criterion):
    said = {"factor": 0.01, "position": 2e-3}
    part, fit, B, e, truth = machines(5, said, 0.03)
    names = tuple(gauge.name for gauge in fit)
    given = {"criterion": criterion, "rules": STILL}
    t = np.arange(float(DRAWS))

    def inside(errors, scale):
        twin = jo.twin.Reconstruction(B, noise=NOISE, names=names, errors=errors)
        found = Monitor(twin, part, SPOTS, scale=scale, **given).push(t, e)
        return ((found.low <= truth) & (truth <= found.high)).mean(axis=0)

    found = inside(gauge_errors(fit, **said), 0.03)
    assert np.all((found > LOW) & (found < HIGH)), found
    assert np.all(inside(None, 0.0) < 0.6)


def wrong(said, seed=7, machines=80, nt=30):
    """Time, records of machines with gauges that differ in the same motion, and its stress."""
    rng = np.random.default_rng(seed)
    t, part, p = larger(nt)
    records = []
    for _ in range(machines):
        shift = said["position"] * rng.normal(size=len(X))
        own = 1.0 + said["factor"] * rng.normal(size=len(X))
        e = own * (p @ jo.gauges.gauge_rows(glued(part, shift)).T)
        records.append(e + NOISE * rng.standard_normal(e.shape))
    return t, records, p @ rows(part, SPOTS).T


def make(part, fit, **options):
    force = jo.twin.UnknownLoad("end", ("fz",), rate=300.0, size=30.0, smooth=True)
    return jo.twin.Observer(part, fit, loads=[force], step=STEP, noise=NOISE, **options)


def test_an_observer_holds_machines_with_gauges_that_differ():
    said = {"factor": 0.02, "position": 3e-3}
    part = held(1)
    fit = glued(part)
    t, records, truth = wrong(said)
    errors = gauge_errors(fit, **said)
    twin = make(part, fit, errors=errors)
    inside, bare, late = [], [], []
    for e in records:
        found = twin.run(t, e)
        for known, shares in ((found, inside), (replace(found, moved=None), bare)):
            band = stress_band(known, part, "s11", sites=SPOTS)
            # one instant of each machine: the others are not independent of it
            shares.append(((band.low <= truth) & (truth <= band.high))[-1])
    for e in records[:5]:
        late.append(stress_band(smooth(twin.run(t, e)), part, "s11", sites=SPOTS).inside(truth))
    n = len(records)
    low, high = (0.95 + sign * 3 * np.sqrt(0.95 * 0.05 / n) for sign in (-1, 1))
    share = np.mean(inside, axis=0)
    assert np.all((share > low) & (share < high)), share
    assert np.all(np.mean(bare, axis=0) < 0.6), np.mean(bare, axis=0)
    assert np.all(np.mean(late, axis=0) > 0.8)
    np.testing.assert_allclose(found.p, make(part, fit).run(t, records[-1]).p)


def test_what_an_error_does_is_what_the_estimate_moves_by():
    """A filter is linear: the same record with one gauge 1 % larger, filtered and smoothed."""
    t, part, p = larger(80)
    e = p @ jo.gauges.gauge_rows(glued(part)).T
    part = held(1)
    fit = glued(part)
    e[40:60, 1] = np.nan
    errors = gauge_errors(fit, factor=1.0 - 1e-9)
    twin = make(part, fit, errors=errors)
    plain = twin.run(t, e)
    for gauge in (0, 3):
        more = e.copy()
        more[:, gauge] *= 1.01
        other = twin.run(t, more)
        for a, b in ((plain, other), (smooth(plain), smooth(other))):
            moved = 0.01 * a.deviations(slice(None))[:, :, gauge]
            # strain measured, not estimated, times 1 %: they differ by what the modes leave out
            scale = np.abs(moved).max(axis=0)
            assert np.all(np.abs(b.p - a.p - moved) < 0.05 * scale + 1e-12)


def test_an_observer_with_errors_is_kept_and_watched():
    part = held(1)
    fit = glued(part)
    t, e, _ = recorded(60)
    errors = gauge_errors(fit, factor=0.01)
    first, again = make(part, fit, errors=errors), make(part, fit, errors=errors)
    for k in range(30):
        first.step(t[k], e[k])
    again.load(first.save())
    for k in range(30, 60):
        a, b = first.step(t[k], e[k]), again.step(t[k], e[k])
    np.testing.assert_array_equal(a.drift, b.drift)
    with pytest.raises(jo.InputError, match="'drift'"):
        make(part, fit, errors=errors).load(make_memory(part, fit, t, e))
    # a monitor gives the same band as the whole record
    watched = Monitor(
        make(part, fit, errors=errors), part, SPOTS, criterion="s11", rules=STILL, scale=0.02
    )
    found = [watched.push(t[i : i + 9], e[i : i + 9]) for i in range(0, 60, 9)]
    whole = stress_band(
        make(part, fit, errors=errors).run(t, e), part, "s11", sites=SPOTS, scale=0.02
    )
    np.testing.assert_allclose(np.vstack([x.high for x in found]), whole.high, rtol=1e-9)


def make_memory(part, fit, t, e):
    twin = make(part, fit)
    twin.step(t[0], e[0])
    return twin.save()


def test_the_band_of_damage_is_that_of_machines_with_gauges_that_differ():
    part = held(1)
    fit = glued(part)
    t, e, _ = recorded(70)
    sn = jo.SN(S_D=50e6, N_D=1e6, k=5, rule="elementary")
    given = {"residue": "half", "sites": SPOTS[:1], "criterion": "s11", "scale": 0.0}
    twin = make(part, fit, errors=gauge_errors(fit, factor=0.03))
    band = damage_band(twin.run(t, e), part, sn, draws=200, **given)
    found = []
    rng, S = np.random.default_rng(2), rows(part, SPOTS[:1])
    for _ in range(40):
        meter = jo.model.DamageMeter(sn, residue="half")
        meter.push(twin.run(t, (1.0 + 0.03 * rng.standard_normal(len(X))) * e).p @ S.T)
        found.append(np.log(meter.damage()[0]))
    # k = 5 times the deviation of the stress; that of 40 is known to 11 %
    width = np.log(band.high / band.low)[0]
    assert width == pytest.approx(2 * 1.96 * np.std(found), rel=0.35)


def test_impossible_errors_are_told():
    part = held(1)
    fit = glued(part)
    with pytest.raises(jo.InputError, match="errors"):
        make(part, fit, errors=np.zeros((1, 2, 3)))
    with pytest.raises(jo.InputError, match="share such as 0.03"):
        Monitor(make(part, fit), part, SPOTS, criterion="s11", scale=-1.0)


def test_samples_one_by_one_are_those_of_a_block_and_bad_ones_are_refused():
    """What is left out for speed must not let anything bad through."""
    reduced, B = cantilever()
    twin = jo.twin.Reconstruction(B, noise=NOISE, names=NAMES)
    sn = jo.SN(S_D=50e6, N_D=1e6, k=5, T_S=1.3)
    given = {"sn": sn, "limits": jo.monitor.AlarmLimits(stress=40e6, channels=5), "every": 0.1}
    t = 0.01 * np.arange(300.0)
    e = 5e-4 * np.sin(7.0 * t)[:, None] * B[:, 0] / np.abs(B[:, 0]).max()
    e = e + 1e-7 * np.random.default_rng(1).normal(size=e.shape)
    e[50:60, 1], e[70:80, :4], e[90, 2], e[95, 3] = np.nan, np.nan, np.inf, 0.5
    t[200:] += 3.0
    one, block = (Monitor(twin, reduced, ("e1.a.top", "e4.b.top"), **given) for _ in range(2))
    parts = [one.push(t[k], e[k]) if k % 2 else one.push(t[k : k + 1], e[k]) for k in range(300)]
    whole = block.push(t, e)
    assert whole.alarms and whole.changes and np.isnan(whole.stress).any()
    for name in ("states", "stress", "low", "high"):
        found = np.vstack([getattr(part, name) for part in parts])
        np.testing.assert_allclose(found, getattr(whole, name), rtol=1e-9, err_msg=name)
    for name in ("changes", "alarms"):
        found = [x for part in parts for x in getattr(part, name)]
        assert [str(x)[:40] for x in found] == [str(x)[:40] for x in getattr(whole, name)]
    assert one.life.watched == pytest.approx(block.life.watched, rel=1e-12)
    ends = [x for part in parts for x in part.summaries]
    assert [(x.samples, x.blind) for x in ends] == [(x.samples, x.blind) for x in whole.summaries]
    for a, b in zip(ends, whole.summaries, strict=True):
        np.testing.assert_allclose(a.peak, b.peak, rtol=1e-9)
    before = one.save()
    for time, row, sentence in (
        (t[-1], e[0], "time must increase"),
        (np.nan, e[0], "time must increase"),
        (np.inf, e[0], "time must increase"),
        ([9.0, 9.0], e[:2], "time must increase"),
        (9.0, e[0, :4], "4 channels, must be 5"),
    ):
        with pytest.raises(jo.InputError, match=sentence):
            one.push(time, row)
    for name, x in one.save().items():
        np.testing.assert_array_equal(x, before[name], err_msg=name)
