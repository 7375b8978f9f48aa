"""Factors on the endurance limit against the examples of the books they come from."""

import math

import pytest

from jousto import InputError
from jousto.fatigue import (
    finish_factor,
    load_factor,
    reliability_factor,
    roughness_factor,
    size_factor,
)


def test_shigley_examples():
    # Shigley's Mechanical Engineering Design, 9th ed., examples 6-3 and 6-4
    assert finish_factor("machined", 520e6, edition=9) == pytest.approx(0.860, abs=5e-4)
    # page 288: the same steel forged
    assert finish_factor("forged", 520e6, edition=9) == pytest.approx(0.540, abs=5e-4)
    # 6-4 takes (d / 7.62 mm)^-0.107 = 0.858; the rounded 1.24 d^-0.107 gives 0.2 % less
    assert size_factor(0.032) == pytest.approx(0.858, rel=3e-3)
    assert size_factor(0.37 * 0.032) == pytest.approx(0.954, rel=3e-3)
    assert [load_factor(x) for x in ("bending", "axial", "torsion")] == [1.0, 0.85, 0.59]


def test_finishes_of_the_11th_edition():
    # EES, Surface_Factor by table 6-2 of the 11th edition: forged, 1000 MPa, k_a = 0.2921
    assert finish_factor("forged", 1000e6) == pytest.approx(0.2921, abs=5e-5)
    assert finish_factor("forged", 1000e6, edition=11) == finish_factor("forged", 1000e6)
    # at most 1 where the power law is above it
    assert finish_factor("forged", 150e6) == 1.0


# both columns of table 6-2 are printed: a for S_u in kpsi and the exponent
KPSI = {
    9: {"ground": 1.34, "machined": 2.70, "hot-rolled": 14.4, "forged": 39.9},
    11: {"ground": 1.21, "machined": 2.00, "hot-rolled": 11.0, "forged": 12.7},
}


@pytest.mark.parametrize("edition", [9, 11])
def test_both_columns_of_the_table_are_one_law(edition):
    for finish, a in KPSI[edition].items():
        low, high = (finish_factor(finish, S, edition=edition) for S in (1e9, 2e9))
        b = math.log2(high / low)
        # three printed digits
        assert low == pytest.approx(a * (1e9 / 6.894757e6) ** b, rel=4e-3)


def test_unknown_edition_is_told():
    with pytest.raises(InputError, match="edition is 7.*9, 11") as told:
        finish_factor("polsihed", 520e6, edition=7)
    assert len(told.value.problems) == 2


def test_shigley_reliability_table():
    # there, table 6-5
    for P, k in ((0.5, 1.0), (0.9, 0.897), (0.95, 0.868), (0.99, 0.814), (0.999, 0.753)):
        assert reliability_factor(P) == pytest.approx(k, abs=1e-3)


def test_fkm_roughness():
    # K_R = 1 - a lg(Rz) lg(2 R_m / R_min): 1 - 0.22 lg(100) lg(2*800/400)
    assert roughness_factor(100e-6, 800e6) == pytest.approx(1 - 0.22 * 2 * 0.6020599913)
    assert roughness_factor(1e-6, 800e6) == 1.0
    assert roughness_factor(200e-6, 250e6, "grey-iron") == pytest.approx(
        1 - 0.06 * 2.301029996 * 0.6989700043
    )


def test_wrong_units_are_told():
    with pytest.raises(InputError, match="20e-6 is 20 um"):
        roughness_factor(20.0, 500e6)
    with pytest.raises(InputError, match="500e6 is 500 MPa"):
        finish_factor("machined", 500.0)
    with pytest.raises(InputError, match="0.032 is 32 mm"):
        size_factor(32.0)
    with pytest.raises(InputError, match="0.99, not 99"):
        reliability_factor(99.0)
