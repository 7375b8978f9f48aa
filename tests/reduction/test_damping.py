"""Modal damping from ratios and from Rayleigh coefficients."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from jousto.base.errors import InputError, JoustoWarning
from jousto.reduction.damping import Rayleigh, modal_damping

F = np.array([1.0, 4.0, 25.0])
OMEGA = 2.0 * np.pi * F


def test_ratios() -> None:
    assert modal_damping(0.0, F) == pytest.approx(np.zeros(3))
    assert modal_damping(0.02, F) == pytest.approx(0.04 * OMEGA)
    assert modal_damping([0.0, 0.01, 0.5], F) == pytest.approx(2 * OMEGA * [0.0, 0.01, 0.5])
    assert modal_damping(np.array([0.1, 0.1, 0.1]), F).shape == (3,)


def test_rayleigh_is_alpha_m_plus_beta_k() -> None:
    assert modal_damping(Rayleigh(0.3, 1e-4), F) == pytest.approx(0.3 + 1e-4 * OMEGA**2)


@given(
    st.floats(0.1, 10.0), st.floats(1.5, 50.0), st.floats(1e-3, 0.2)
)  # fmt: skip
def test_rayleigh_from_equal_ratios_meets_both_and_is_lower_between(
    f: float, factor: float, zeta: float
) -> None:
    damping = Rayleigh.from_ratios((f, zeta), (f * factor, zeta))
    between = f * np.sqrt(factor)
    frequencies = np.array([f, between, f * factor])
    ratio = modal_damping(damping, frequencies) / (4.0 * np.pi * frequencies)
    assert ratio[[0, 2]] == pytest.approx(zeta, rel=1e-9)
    assert ratio[1] < zeta


def test_read_only() -> None:
    with pytest.raises(ValueError, match="read-only"):
        modal_damping(0.1, F)[0] = 1.0


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        (-0.1, "-0.1 must be 0 or positive"),
        (float("nan"), "nan must be"),
        ([0.1, 0.1], "2 ratios for 3 modes"),
        ([0.1, -1.0, 0.0], "-1 must be"),
        ([[0.1]], "give one ratio"),
        ("high", "neither a ratio"),
    ],
)
def test_bad_ratios(spec: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        modal_damping(spec, F)  # type: ignore[arg-type]


def test_bad_coefficients() -> None:
    with pytest.raises(InputError) as error:
        Rayleigh(-1.0, float("inf"))
    assert "alpha is -1" in str(error.value) and "beta is inf" in str(error.value)
    with pytest.raises(InputError, match="positive and different"):
        Rayleigh.from_ratios((1.0, 0.1), (1.0, 0.2))
    with pytest.raises(InputError, match="alpha is -"):
        Rayleigh.from_ratios((1.0, 0.01), (2.0, 0.5))


def test_per_cent() -> None:
    with pytest.warns(JoustoWarning, match="is it in per cent"):
        modal_damping(2.0, F)
