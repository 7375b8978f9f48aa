"""Damage and safety against closed forms, textbooks and statistics of random loads."""

import math
import warnings

import numpy as np
import pytest

from jousto import SN, InputError, JoustoWarning, sn_curve
from jousto.fatigue import (
    FKM,
    SWT,
    Gerber,
    Goodman,
    Morrow,
    Soderberg,
    assess,
    damage,
    fat_class,
    life,
    rainflow,
    stress_safety,
)
from jousto.fatigue.miner.damage import equivalents
from jousto.fatigue.miner.spectrum import Spectrum

CURVE = SN(S_D=100e6, N_D=1e6, k=5)


def waves(amplitudes, mean=0.0):
    """Return a history with one cycle of each amplitude; counted with residue="repeat"."""
    x = np.zeros(2 * len(amplitudes))
    x[0::2], x[1::2] = amplitudes, -np.asarray(amplitudes)
    return x + mean


def test_constant_amplitude():
    n = 500
    cycles = rainflow(np.append(waves(np.full(n, 150e6)), 150e6), residue="half")
    assert cycles.total == n
    D = damage(cycles, CURVE)
    assert pytest.approx(n / 1e6 * 1.5**5) == D
    assert life(cycles, CURVE, duration=20.0) == pytest.approx(20.0 / D)
    assert stress_safety(cycles, CURVE) == pytest.approx(D**-0.2)
    assert stress_safety(cycles, CURVE, allowable=0.3) == pytest.approx((0.3 / D) ** 0.2)


def test_constant_amplitude_at_an_endurance_limit():
    limit = SN(S_D=100e6, N_D=1e6, k=5, rule="original")
    few = rainflow([60e6, -60e6, 60e6], residue="repeat")
    assert damage(few, limit) == 0.0
    # one cycle: the line, not the limit, sets the factor
    assert stress_safety(few, limit) == pytest.approx((1e6) ** 0.2 * 100 / 60)
    many = few.times(1e9)
    assert stress_safety(many, limit) == pytest.approx(100 / 60)
    assert damage(many, limit) == 0.0


def test_gassner_line():
    """Block loading of a Gaussian spectrum in eight steps: life falls as the Woehler line does.

    Elementary Miner: N = N_D (S_D/S_max)^k sum(n) / sum(n (S/S_max)^k).
    """
    x = np.array([1.0, 0.95, 0.85, 0.725, 0.575, 0.425, 0.275, 0.125])  # Gassner's steps
    n = np.array([2, 16, 280, 2720, 20000, 92000, 280000, 604982])
    history = rainflow(waves(x), residue="repeat")
    counts = np.array([n[np.argmin(np.abs(x - a))] for a in history.amplitude])
    for S_max in (150e6, 250e6, 400e6):
        from dataclasses import replace

        block = replace(
            history, range=history.range * S_max, mean=history.mean * S_max, count=counts
        )
        gassner = 1e6 * (100e6 / S_max) ** 5 * n.sum() / np.sum(n * x**5)
        assert n.sum() / damage(block, CURVE) == pytest.approx(gassner, rel=1e-12)


def test_two_blocks_by_the_three_rules():
    cycles = rainflow(waves([200e6] * 10 + [50e6] * 1000), residue="repeat")
    assert cycles.total == 1010
    # between the blocks the amplitudes 200 and 50 share no cycle: 10/31250 and 1000/N
    high, low = 10 / 31250, 1000 / 1e6
    for rule, more in (("original", 0.0), ("elementary", low / 2**5), ("haibach", low / 2**9)):
        D = damage(cycles, SN(S_D=100e6, N_D=1e6, k=5, rule=rule))
        assert pytest.approx(high + more) == D, rule


def test_eurocode_block():
    """EN 1993-1-9, category 80: 1e5 cycles of 150 MPa range, 1e6 of 50, 1e7 of 30 MPa."""
    curve = fat_class(80, "en")
    # 2e6 (80/150)^3; 5e6 (58.96/50)^5 below the knee; 30 is below the cut-off 32.4 MPa
    knee = 80.0 * (2 / 5) ** (1 / 3)
    by_hand = 1e5 / (2e6 * (80 / 150) ** 3) + 1e6 / (5e6 * (knee / 50) ** 5)
    got = sum(curve.damage(0.5e6 * r, n) for r, n in ((150, 1e5), (50, 1e6), (30, 1e7)))
    assert got == pytest.approx(by_hand, rel=1e-12)
    assert curve.damage(15e6, 1e7) == 0.0


def test_narrow_band_gaussian():
    """Peaks of a narrow-band Gaussian stress are Rayleigh: D = n/N_D (sqrt2 s/S_D)^k G(1+k/2).

    J. W. Miles, On structural fatigue under random loading, J. Aeronaut. Sci. 21 (1954) 753.
    """
    rng = np.random.default_rng(11)
    n, samples, sigma = 32768, 16, 40e6  # periods, samples of each
    lines = np.arange(int(0.96 * n), int(1.04 * n) + 1)
    spectrum = np.zeros(n * samples // 2 + 1, dtype=complex)
    z = rng.normal(size=(2, len(lines)))
    spectrum[lines] = z[0] + 1j * z[1]
    x = np.fft.irfft(spectrum, n=n * samples)
    x *= sigma / np.sqrt(np.mean(x**2))
    cycles = rainflow(x, residue="repeat")
    # 2600 independent values: the scatter of the sum is 3 % with k = 3, 6 % with k = 5
    for k, width in ((3.0, 0.06), (5.0, 0.15)):
        closed = n / 1e6 * (math.sqrt(2) * sigma / 100e6) ** k * math.gamma(1 + k / 2)
        D = damage(cycles, SN(S_D=100e6, N_D=1e6, k=k))
        assert pytest.approx(closed, rel=width) == D


def test_rayleigh_quantiles():
    """The same closed form with the peaks at the quantiles of Rayleigh: no chance in it."""
    sigma, n, k = 40e6, 20_000, 5.0
    peaks = sigma * np.sqrt(-2.0 * np.log1p(-(np.arange(n) + 0.5) / n))
    x = waves(peaks)
    D = damage(rainflow(x, residue="repeat"), CURVE)
    closed = n / 1e6 * (math.sqrt(2) * sigma / 100e6) ** k * math.gamma(1 + k / 2)
    assert pytest.approx(closed, rel=2e-3) == D


def test_mean_stress_enters_the_damage():
    cycles = rainflow(np.append(waves([100e6] * 4, mean=120e6), 220e6), residue="half")
    for rule, S in (
        (Goodman(600e6), 125e6),
        (Gerber(600e6), 100e6 / 0.96),
        (Morrow(1200e6), 100e6 / 0.9),
        (SWT(), math.sqrt(220e6 * 100e6)),
    ):
        assert damage(cycles, CURVE, rule) == pytest.approx(4 * (S / 100e6) ** 5 / 1e6), rule


def test_dowling_equivalent_amplitude():
    # Dowling, Mechanical Behavior of Materials (4th ed.), p. 460: AISI 4340, amplitude 379 MPa
    # on a mean of 621 MPa: 586.0 MPa by Morrow with sigma_f' = 1758 MPa
    curve = sn_curve("AISI 4340 aircraft")
    cycles = rainflow([242e6, 1000e6, 242e6], residue="repeat")
    assert equivalents(cycles, Morrow(1758e6)) / 1e6 == pytest.approx([586.0], abs=0.05)
    N = 0.5 * (586.0 / 1758.0) ** (1 / -0.0977)
    assert 1.0 / damage(cycles, curve, Morrow(1758e6)) == pytest.approx(N, rel=1e-3)


def test_curve_of_another_ratio_is_turned_to_full_reversal():
    rule = Goodman(500e6)
    pulsating = SN(S_D=75e6, N_D=1e6, k=5, R=0.0)  # amplitude 75 on a mean of 75 MPa
    cycles = rainflow([0.0, 150e6, 0.0], residue="repeat")
    assert damage(cycles, pulsating, rule) == pytest.approx(1e-6)
    assert damage(cycles, pulsating) == pytest.approx(1e-6)


def test_mean_above_the_strength_is_no_fatigue():
    cycles = rainflow([550e6, 560e6, 550e6], residue="repeat")
    with pytest.warns(JoustoWarning, match="above the tensile strength 500 MPa"):
        assert damage(cycles, CURVE, Goodman(500e6)) == math.inf
    with pytest.warns(JoustoWarning, match="above the tensile strength 500 MPa"):
        damage(cycles, SN(S_D=100e6, N_D=1e6, k=5, S_u=500e6))
    # a correction has a strength, too
    for mean, said in (
        (Goodman(S_u=500e6), "above the tensile strength 500 MPa"),
        (Gerber(S_u=500e6), "above the tensile strength 500 MPa"),
        (Soderberg(S_y=400e6), "above the yield stress 400 MPa"),
    ):
        with pytest.warns(JoustoWarning, match=said):
            assess(cycles, SN(S_D=100e6, N_D=1e6, k=5), mean=mean)


def test_spectrum_is_the_direct_sum():
    rng = np.random.default_rng(1)
    S, n = rng.exponential(60e6, 400), rng.integers(1, 5, 400).astype(float)
    curves = [SN(100e6, 1e6, 5, rule) for rule in ("original", "elementary", "haibach")] + [
        fat_class(160, "en"),
        SN(100e6, 1e6, 5, "haibach", k2=22.0),
    ]
    for curve in curves:
        spectrum = Spectrum(S, n, curve)
        for f in (0.1, 0.7, 1.0, 3.0, 1e3):
            assert spectrum.damage(f) == pytest.approx(curve.damage(f * S, n), rel=1e-9)
        f = spectrum.factor(1e-3)
        assert spectrum.damage(f * (1 - 1e-9)) <= 1e-3 < spectrum.damage(f * (1 + 1e-9))


def test_amplitudes_at_the_knee_and_at_the_limit_count():
    """As in the curve itself: the knee belongs to the line above, the limit to the one below."""
    for curve in (SN(1.0e8, 1e6, 5, "original"), SN(1.0e8, 1e6, 5, "haibach", N_cut=512e6)):
        limit = curve.S_limit  # 50 MPa of the second: (1/2)^9 = 1/512
        S = np.array([1.0e8, limit])
        assert Spectrum(S, np.ones(2), curve).damage() == pytest.approx(curve.damage(S), rel=1e-12)
        assert curve.damage(limit) > 0.0


def test_safety_of_goodman_scales_mean_and_amplitude():
    cycles = rainflow([0.0, 80e6, 0.0], residue="repeat").times(1e4)
    rule = Goodman(500e6)
    f = stress_safety(cycles, CURVE, rule)
    S = float(rule.equivalent(40e6 * f, 40e6 * f))
    assert 1e4 * (S / 100e6) ** 5 / 1e6 == pytest.approx(1.0)
    assert stress_safety(cycles, CURVE, FKM(0.2)) == pytest.approx(100**0.2 / (0.4 * 1.2), rel=1e-9)


CURVES = [
    {"rule": "elementary", "T_S": 1.25},
    {"rule": "original", "T_S": 1.25},
    {"rule": "haibach", "T_S": 1.25},
    {"rule": "haibach", "T_S": 1.15, "T_N": 4.0},
    {"rule": "haibach", "T_N": 4.0, "N_cut": 1e8},
]


def reaching(peak):
    """A history with cycles of several sizes."""
    return [0.0, peak, -20e6, 0.8 * peak, 10e6, peak, 0.0]


@pytest.mark.parametrize("mean", [None, SWT(), Goodman(700e6)])
@pytest.mark.parametrize(
    ("kind", "peak", "P"),
    [
        *((kind, 260e6, P) for kind in CURVES for P in (0.1, 0.9, 0.99, 0.9999)),
        *((kind, 160e6, P) for kind in CURVES for P in (0.9, 0.99, 0.9999)),
        *((kind, 160e6, 0.1) for kind in CURVES if kind["rule"] != "original"),
    ],
)
def test_life_at_a_survival_probability_has_that_probability(kind, mean, peak, P):
    """Whether the cycles are above the knee of the mean curve, below it or at both sides."""
    curve = SN(S_D=100e6, N_D=1e6, k=5, R=-1.0 if mean is None else -0.5, **kind)
    at = assess(reaching(peak), curve, residue="repeat", mean=mean, survival=P)
    wanted = at.life * 0.999999
    again = assess(reaching(peak), curve, residue="repeat", mean=mean, required=wanted)
    # the shorter life is survived by 0.4e-6 more at the most: density of the normal distribution
    # over k times the standard deviation of log S
    assert P * (1.0 - 1e-9) <= again.probability < P + 1e-6


def test_below_the_limit_specimens_last_for_ever():
    """Phi(lg(S_D / S_a) / s), s = lg(T_S) / 2.563, of those whose limit is above S_a = 90 MPa."""
    curve = SN(S_D=100e6, N_D=1e6, k=5, rule="original", T_S=1.25)
    at = assess(reaching(160e6), curve, residue="repeat", survival=0.1)
    assert math.isinf(at.life)
    forever = assess(reaching(160e6), curve, residue="repeat", required=1e300)
    s = math.log10(1.25) / (2.0 * 1.2815515655)
    z = math.log10(100.0 / 90.0) / s
    expected = 0.5 * (1.0 + math.erf(z / math.sqrt(2.0)))
    assert forever.probability == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("rule", "amplitude", "required"),
    [("original", 99e6, 1e7), ("haibach", 60e6, 3e7), ("elementary", 60e6, 1e7)],
)
def test_survival_is_that_of_specimens_of_scattering_strength(rule, amplitude, required):
    """Cycles below the knee of the mean are above that of weak specimens: Monte Carlo."""
    curve = SN(S_D=100e6, N_D=1e6, k=5, rule=rule, T_S=1.25)
    found = assess([0, 2 * amplitude, 0], curve, residue="repeat", required=required)
    strength = 100e6 * 1.25 ** (np.random.default_rng(7).normal(size=100_000) / 2.5631)
    ratio = amplitude / strength
    below = {"original": 0.0 * ratio, "haibach": ratio**9, "elementary": ratio**5}[rule]
    sums = np.where(ratio >= 1.0, ratio**5, below) * required / 1e6
    assert found.probability == pytest.approx(np.mean(sums <= 1.0), abs=0.005)


def test_survival_of_nothing_and_of_a_break():
    scatter = SN(S_D=100e6, N_D=1e6, k=5, T_S=1.25)
    assert assess([1e6, 1e6], scatter, residue="half").probability == 1.0
    broken = [300e6, 500e6, 300e6]
    with pytest.warns(JoustoWarning, match="500 MPa, is above the tensile strength 350 MPa"):
        found = assess(broken, scatter, residue="half", mean=Goodman(350e6))
    assert found.probability == 0.0


def test_assessment_at_a_survival_probability():
    mean = SN(S_D=100e6, N_D=1e6, k=5, T_S=1.25)
    history = [0.0, 240e6, 0.0]
    half = assess(history, mean, residue="repeat", required=1e5)
    safe = assess(history, mean, residue="repeat", required=1e5, survival=0.9)
    # log-normal: 90 % is one half of the scatter band below the mean
    assert half.safety / safe.safety == pytest.approx(math.sqrt(1.25))
    assert half.life / safe.life == pytest.approx(1.25**2.5)
    assert half.probability == pytest.approx(safe.probability)
    # at the life of the curve for 90 % nine of ten live
    again = assess(history, mean, residue="repeat", required=safe.life)
    assert again.probability == pytest.approx(0.9)
    assert "survival" in str(safe) and "residue: repeat" in str(safe)
    assert math.isnan(assess(history, CURVE, residue="repeat").probability)


def test_constant_history_lives_for_ever():
    found = assess([80e6, 80e6, 80e6], CURVE, residue="half")
    assert (found.damage, found.life, found.safety) == (0.0, math.inf, math.inf)
    assert "for ever" in str(found)


def test_units_are_told_in_both_directions():
    stress_in_MPa = rainflow([0.0, 150.0, -150.0, 0.0], residue="half")
    with pytest.warns(JoustoWarning, match="are the stresses in MPa"):
        damage(stress_in_MPa, CURVE)
    stress = rainflow([0.0, 150e6, -150e6, 0.0], residue="half")
    with pytest.warns(JoustoWarning, match="was it given in MPa"):
        curve = SN(S_D=100.0, N_D=1e6, k=5)
    with pytest.warns(JoustoWarning, match="was the curve given in MPa"):
        damage(stress, curve)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        damage(stress, CURVE)
        damage(rainflow([0.0, 1e-4, 0.0], residue="half"), CURVE)


def test_mistakes():
    with pytest.raises(InputError, match="must be Cycles"):
        damage([1e6, 2e6], CURVE)
    with pytest.raises(InputError, match="residue is missing"):
        assess([0, 1e6, 0], CURVE)
    with pytest.raises(InputError) as caught:
        assess([0, 1e6, 0], CURVE, residue="half", duration=-1.0, allowable=0.0, required=-5.0)
    assert len(caught.value.problems) == 3
    with pytest.raises(InputError, match="has no scatter"):
        assess([0, 1e6, 0], CURVE, residue="half", survival=0.99)


def test_a_constant_stress_above_the_strength_does_not_live_for_ever():
    cycles = rainflow([600e6, 600e6], residue="half")
    said = "above the tensile strength 500 MPa"
    with pytest.warns(JoustoWarning, match=said):
        assert damage(cycles, CURVE, Goodman(500e6)) == math.inf
    with pytest.warns(JoustoWarning, match=said):
        assert life(cycles, CURVE, Goodman(500e6)) == 0.0
    assert damage(rainflow([400e6, 400e6], residue="half"), CURVE, Goodman(500e6)) == 0.0
    scatter = SN(S_D=100e6, N_D=1e6, k=5, T_S=1.25)
    with pytest.warns(JoustoWarning, match=said):
        found = assess(cycles, scatter, mean=Goodman(500e6))
    assert (found.life, found.probability) == (0.0, 0.0)
    assert found.safety == pytest.approx(500 / 600)
    with pytest.warns(JoustoWarning, match=said):
        assert damage(cycles, SN(S_D=100e6, N_D=1e6, k=5, S_u=500e6)) == 0.0


@pytest.mark.parametrize("duration", [-5.0, 0.0, math.nan])
def test_life_refuses_a_duration_that_is_none(duration):
    with pytest.raises(InputError, match="duration"):
        life(rainflow([0, 1e8, 0], residue="half"), CURVE, duration=duration)
