"""S-N curves against their definition, tables of textbooks and another program."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from jousto import SN, InputError, JoustoWarning
from jousto.fatigue import fat_class, thickness_factor
from jousto.materials.strength.sn_library import estimate_sn, sn_curve, sn_curves


def steel(**others):
    return SN(**{"S_D": 100e6, "N_D": 1e6, "k": 5.0} | others)


def test_basquin_line_and_the_three_rules():
    S = np.array([200e6, 100e6, 50e6, 0.0])
    assert steel(rule="elementary").cycles(S)[:3] == pytest.approx([31250, 1e6, 32e6])
    assert steel(rule="haibach").cycles(S)[2] == pytest.approx(1e6 * 2**9)
    assert np.isinf(steel(rule="original").cycles(S)[2:]).all()
    assert np.isinf(steel().cycles(0.0))
    assert steel(rule="original").damage([100e6, 99.999e6], [3, 1e9]) == pytest.approx(3e-6)


def test_amplitude_is_the_inverse():
    for curve in (steel(), steel(rule="haibach"), steel(rule="haibach", k2=22.0)):
        N = np.array([1e3, 1e6, 1e7, 3e8])
        assert curve.cycles(curve.amplitude(N)) == pytest.approx(N)
    assert steel(rule="original").amplitude(1e9) == 100e6
    cut = steel(rule="haibach", N_cut=1e8)
    assert cut.amplitude(1e12) == pytest.approx(cut.S_limit)
    assert np.isinf(cut.cycles(0.9999 * cut.S_limit))
    assert np.isfinite(cut.cycles(1.0001 * cut.S_limit))


@pytest.mark.parametrize("rule", ["original", "elementary", "haibach"])
def test_numbers_say_the_same_as_the_curve(rule):
    curve = steel(rule=rule)
    S_D, N_D, k, k2, limit = curve.numbers
    for S in (250e6, 100e6, 80e6, 20e6):
        m = k if S >= S_D else k2
        plain = 0.0 if S < limit else (S / S_D) ** m / N_D
        assert curve.damage(S) == pytest.approx(plain, rel=1e-14)


def test_dowling_table_9_1_is_consistent_with_its_second_form():
    # there: sigma_a = sf' (2 N)^b = A N^b, MPa
    A = {"SAE 1015 normalized": 927, "Man-Ten hot rolled": 1006, "RQC-100": 897}
    A |= {"SAE 4142 450 HB": 1837, "AISI 4340 aircraft": 1643, "2024-T4": 839}
    A |= {"Ti-6Al-4V aged": 1889}
    assert set(A) == set(sn_curves())
    for name, value in A.items():
        # half of the last printed digit, and what the printed digits of b make of 2^b
        assert sn_curve(name).amplitude(1.0) / 1e6 == pytest.approx(value, abs=0.6), name


def test_eurocode_limits():
    # EN 1993-1-9:2005, 7.1 (2) and (3): 0.737, 0.549 from knee to cut-off; shear 0.457
    weld = fat_class(90, "en")
    assert 2 * weld.S_D / 90e6 == pytest.approx(0.737, abs=5e-4)
    assert weld.S_limit / weld.S_D == pytest.approx(0.549, abs=5e-4)
    assert weld.cycles(45e6) == pytest.approx(2e6)
    shear = fat_class(80, "en", shear=True)
    assert 2 * shear.S_limit / 80e6 == pytest.approx(0.457, abs=5e-4)
    assert shear.cycles(40e6) == pytest.approx(2e6)
    assert np.isinf(fat_class(90, "en", constant=True).cycles(0.999 * weld.S_D))


def test_iiw_knee_points():
    # IIW-2259-15, table 3.1: FAT 71 has its knee at 41.5 MPa and 1e7 cycles, FAT 100 at 58.5,
    # shear FAT 100 at 46.0 (45.7 exactly) and 1e8
    assert 2 * fat_class(71).S_D / 1e6 == pytest.approx(41.5, abs=0.05)
    assert 2 * fat_class(100).S_D / 1e6 == pytest.approx(58.5, abs=0.05)
    assert 2 * fat_class(100, shear=True).S_D / 1e6 == pytest.approx(45.7, abs=0.05)
    assert fat_class(71).slope2 == 5.0
    assert fat_class(71, constant=True).slope2 == 22.0


def test_thickness():
    assert thickness_factor(0.1, "butt") == pytest.approx(0.25**0.2)
    assert thickness_factor(0.036, 0.25, reference=0.03) == pytest.approx((30 / 36) ** 0.25)
    assert fat_class(71, factor=0.8).S_D == pytest.approx(0.8 * fat_class(71).S_D)


def test_survival_against_pylife():
    woehler = pytest.importorskip("pylife.materiallaws").WoehlerCurve
    pd = pytest.importorskip("pandas")
    for T_S, T_N in ((1.25, None), (1.25, 5.0), (None, 4.0)):
        own = steel(T_S=T_S, T_N=T_N, rule="original")
        given = {"SD": 100.0, "ND": 1e6, "k_1": 5.0, "failure_probability": 0.5}
        given |= {k: v for k, v in (("TS", T_S), ("TN", T_N)) if v is not None}
        for P in (0.1, 0.9, 0.975, 0.999):
            theirs = woehler(pd.Series(given)).transform_to_failure_probability(1.0 - P).to_pandas()
            mine = own.at_survival(P)
            assert mine.S_D / 1e6 == pytest.approx(theirs.SD, rel=1e-12)
            assert mine.N_D == pytest.approx(theirs.ND, rel=1e-12)


def test_scatter_bands():
    curve = steel(T_S=1.25)
    assert curve.at_survival(0.1).S_D / curve.at_survival(0.9).S_D == pytest.approx(1.25)
    both = steel(T_N=3.0)
    ratio = both.at_survival(0.1).cycles(150e6) / both.at_survival(0.9).cycles(150e6)
    assert ratio == pytest.approx(3.0)
    assert curve.at_survival(0.99).at_survival(0.5).S_D == pytest.approx(100e6)


def test_estimates():
    # FKM: 0.45 of the tensile strength of steel, 0.34 of nodular iron, 0.30 of aluminium
    assert estimate_sn(1000e6).S_D == pytest.approx(450e6)
    assert sn_curve("en-gjs-400-15").S_D == pytest.approx(136e6)
    assert estimate_sn(310e6, "aluminium", rule="haibach").slope2 == 15.0


def test_units_in_both_directions():
    with pytest.warns(JoustoWarning, match="was it given in MPa"):
        steel(S_D=100.0)
    with pytest.warns(JoustoWarning, match="multiplied by 1e6"):
        steel(S_D=100e12)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        steel(S_u=500e6)


def test_all_mistakes_at_once():
    with pytest.raises(InputError) as caught:
        SN(S_D=-1.0, N_D=0.5, k=0.2, rule="miner", T_S=0.8, survival=97.5, S_u=float("nan"))
    text = str(caught.value)
    for word in ("S_D is -1", "N_D is 0.5", "k is 0.2", "rule is 'miner'", "T_S", "97.5", "S_u"):
        assert word in text
    assert len(caught.value.problems) == 7
    with pytest.raises(InputError, match="must be above it"):
        steel(S_u=90e6)
    with pytest.raises(InputError, match='is allowed with rule="haibach" only'):
        steel(k2=9.0, rule="original")
    with pytest.raises(InputError, match="has no scatter"):
        steel().at_survival(0.9)
    with pytest.raises(InputError, match="positive numbers in Pa"):
        steel().cycles([1e6, np.nan])
    with pytest.raises(InputError, match="a class from 5 to 250"):
        fat_class(71e6)
    with pytest.raises(InputError, match="did you mean 'RQC-100'"):
        sn_curve("RQC-10")


def test_turned_curve_keeps_the_pivot():
    curve = replace(steel(), rule="haibach")
    turned = curve.with_factors(0.7, 0.9, pivot=1e3)
    assert turned.amplitude(1e3) == pytest.approx(curve.amplitude(1e3))
    assert turned.S_D == pytest.approx(63e6)
    assert turned.slope2 == pytest.approx(2 * turned.k - 1)
    with pytest.raises(InputError, match="does not fall"):
        curve.with_factors(50.0, pivot=1e3)


def test_a_weld_class_that_no_standard_has_is_told() -> None:
    # IIW-2259-15, figure 3.1: 63, 71 and 80 follow one another; 17 is 71 mistyped
    with pytest.warns(
        JoustoWarning, match=r"no FAT class 17 of direct .* nearest: 16 and 18; .*17 M"
    ):
        curve = sn_curve("fat17")
    assert curve.name == "FAT 17 iiw"
    with pytest.warns(JoustoWarning, match="no FAT class 71 of shear .* nearest: 36 and 80;"):
        sn_curve("fat71-shear-en")
    with pytest.warns(JoustoWarning, match="nearest: 160;"):
        sn_curve("fat170")
    for name in ("fat36", "fat71", "FAT 160 en", "fat80-shear"):  # warnings are errors in tests
        sn_curve(name)
    assert fat_class(75).name == "FAT 75 iiw"  # meant so
