"""Creep coefficients against Kalker's tables and his asymptotes for slender ellipses."""

from __future__ import annotations

import numpy as np
import pytest

from jousto.mechanism.contacts.creep import creep_coefficients

# J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact, 1990, table E.3 (as the program
# CONTACT of Vollebregt and Kalker has it): C11, C22, C23, each for nu = 0, 1/4, 1/2
TABLE = {
    0.1: (2.51, 3.31, 4.85, 2.51, 2.52, 2.53, 0.334, 0.473, 0.731),
    0.2: (2.59, 3.37, 4.81, 2.59, 2.63, 2.66, 0.483, 0.603, 0.809),
    0.5: (2.88, 3.62, 4.83, 2.88, 3.01, 3.14, 0.827, 0.929, 1.07),
    0.8: (3.19, 3.91, 5.05, 3.19, 3.41, 3.65, 1.13, 1.25, 1.40),
    1.0: (3.40, 4.12, 5.20, 3.40, 3.67, 3.98, 1.33, 1.47, 1.63),
    1 / 0.8: (3.65, 4.36, 5.42, 3.65, 3.99, 4.39, 1.58, 1.75, 1.94),
    1 / 0.5: (4.37, 5.10, 6.11, 4.37, 4.90, 5.56, 2.35, 2.62, 2.96),
    1 / 0.2: (6.96, 7.78, 8.82, 6.96, 8.14, 9.79, 5.72, 6.63, 7.89),
    1 / 0.1: (10.7, 11.7, 12.9, 10.7, 12.8, 16.0, 12.2, 14.6, 18.0),
}
# C33 of the same theory for nu = 0, 1/4, 1/2: Kalker, Delft 1967, table 2
SPIN = {
    0.1: (6.42, 8.28, 11.7),
    0.5: (1.74, 1.93, 2.22),
    1.0: (1.21, 1.19, 1.16),
    1 / 0.5: (0.958, 0.819, 0.650),
    1 / 0.1: (0.795, 0.526, 0.228),
}


@pytest.mark.parametrize("ratio", TABLE)
def test_coefficients_of_the_table(ratio):
    """Three printed digits; the series that he summed are off by up to 1 % for slender ellipses."""
    near = 0.009 if 0.4 < ratio < 2.5 else 0.012
    for k, nu in enumerate((0.0, 0.25, 0.5)):
        found = creep_coefficients(ratio, nu)
        np.testing.assert_allclose(found[:3], TABLE[ratio][k::3], rtol=near)
        if ratio in SPIN:
            assert found.C33 == pytest.approx(SPIN[ratio][k], rel=near)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
def test_slender_ellipses(nu):
    """Kalker 1990, appendix E: a/b to infinity (order 1 / log^2) and to 0 (plane strain)."""
    g = 1 / 30
    L = np.log(16 / g**2)
    bend = (1 - nu) * L + 2 * nu
    long = creep_coefficients(1 / g, nu)
    C11 = 2 * np.pi / (L - 2 * nu) / g * (1 + (3 - np.log(4)) / (L - 2 * nu))
    C22 = 2 * np.pi / g * (1 + (1 - nu) * (3 - np.log(4)) / bend) / bend
    C23 = 2 * np.pi / 3 / g**1.5 / ((1 - nu) * L - 2 + 4 * nu)
    np.testing.assert_allclose(long[:2], (C11, C22), rtol=0.033)
    assert long.C23 == pytest.approx(C23, rel=1e-3)
    wide = creep_coefficients(g, nu)
    C23 = np.pi * np.sqrt(g) / 3 / (1 - nu) * (1 + nu * (np.log(16 / g) - 5))
    np.testing.assert_allclose(wide[:2], (np.pi**2 / 4 / (1 - nu), np.pi**2 / 4), rtol=5e-3)
    assert wide.C23 == pytest.approx(C23, rel=0.01)


def test_without_lateral_contraction_both_directions_are_equal():
    """For nu = 0 the half space is as stiff along as across: C11 = C22 for any ellipse."""
    for ratio in (0.05, 0.3, 2.0, 25.0):
        found = creep_coefficients(ratio, 0.0)
        assert found.C11 == pytest.approx(found.C22, rel=1e-9)
