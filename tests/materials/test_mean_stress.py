"""Mean stress corrections against their formulas, limits of their regimes and other programs."""

import numpy as np
import pytest

from jousto import InputError, JoustoWarning
from jousto.fatigue import (
    FKM,
    SWT,
    Gerber,
    Goodman,
    Morrow,
    PartCompression,
    Soderberg,
    Walker,
    WeldRatio,
)


def ratio(R, S_max=100e6):
    """Return amplitude and mean of a cycle with stress ratio R and maximum S_max."""
    return 0.5 * (1 - R) * S_max, 0.5 * (1 + R) * S_max


def test_formulas():
    a, m = 100e6, 120e6
    assert Goodman(600e6).equivalent(a, m) == pytest.approx(125e6)
    assert Soderberg(400e6).equivalent(a, m) == pytest.approx(100e6 / 0.7)
    assert Morrow(1200e6).equivalent(a, m) == pytest.approx(100e6 / 0.9)
    assert Gerber(600e6).equivalent(a, m) == pytest.approx(100e6 / 0.96)
    assert SWT().equivalent(a, m) == pytest.approx(np.sqrt(220e6 * 100e6))
    assert Walker(0.7).equivalent(a, m) == pytest.approx(220e6**0.3 * 100e6**0.7)


def test_mean_without_effect_at_full_reversal():
    for rule in (Goodman(5e8), Gerber(5e8), Morrow(9e8), SWT(), Walker(0.6), FKM(0.2)):
        assert rule.equivalent([3e7, 2e8], 0.0) == pytest.approx([3e7, 2e8])


def test_compression():
    assert Goodman(500e6).equivalent(100e6, -100e6) == pytest.approx(100e6 / 1.2)
    assert Goodman(500e6, credit=False).equivalent(100e6, -100e6) == pytest.approx(100e6)
    assert Gerber(500e6).equivalent(100e6, -100e6) == pytest.approx(100e6)
    assert SWT().equivalent(100e6, -150e6) == 0.0


def test_mean_at_the_strength_breaks():
    for rule in (Goodman(500e6), Gerber(500e6), Soderberg(500e6), Morrow(500e6)):
        assert np.isinf(rule.equivalent(1e6, [500e6, 700e6])).all()


def test_fkm_regimes_meet():
    rule = FKM(0.3)
    for R in (0.0, 0.5):
        below, above = (rule.equivalent(*ratio(R + e)) for e in (-1e-9, 1e-9))
        assert below == pytest.approx(above, rel=1e-7)
    # amplitude endured at R = 0 over that at R = -1 is 1/(1 + M) by definition of M
    assert rule.equivalent(*ratio(0.0)) / ratio(0.0)[0] == pytest.approx(1.3)
    # pure compression: the value of R = -inf, zero-to-compression
    assert rule.equivalent(50e6, -50e6) == pytest.approx(rule.equivalent(50e6, -500e6))


def test_fkm_against_pylife():
    pytest.importorskip("pylife")
    import pandas as pd
    from pylife.strength import meanstress

    cycles = [ratio(R) for R in (-4.0, -1.0, -0.3, 0.0, 0.2, 0.4, 0.5, 0.7, 0.9)]
    M = 0.24
    # their fkm_goodman has no fourth regime; the diagram of five segments has
    slopes = {"M0": M, "M1": M / 3.0, "M2": 0.0, "M3": 0.0, "M4": 0.0, "R12": 0.5, "R23": 0.8}
    haigh = meanstress.HaighDiagram.five_segment(pd.Series(slopes))
    table = pd.DataFrame({"range": [2 * a for a, _ in cycles], "mean": [m for _, m in cycles]})
    theirs = haigh.transform(table, -1.0)["range"].to_numpy() / 2.0
    own = FKM(M).equivalent(*np.transpose(cycles))
    assert own == pytest.approx(theirs, rel=1e-9)


def test_fkm_sensitivities():
    # FKM guideline (6th ed.), table 4.4.1: M = a R_m / 1000 MPa + b
    assert FKM.of("steel", 700e6).M == pytest.approx(0.145)
    assert FKM.of("nodular-iron", 500e6).M == pytest.approx(0.255)
    assert FKM.of("grey-iron", 250e6).M == pytest.approx(0.5)
    assert FKM.of("aluminium", 310e6).M == pytest.approx(0.27)


def test_weld_bonus():
    # IIW-2259-15, 3.5.2
    for case, known in (
        ("low", {-3.0: 1.6, -1.0: 1.6, 0.0: 1.2, 0.5: 1.0, 0.8: 1.0}),
        ("medium", {-3.0: 1.3, -1.0: 1.3, -0.5: 1.1, -0.25: 1.0, 0.5: 1.0}),
        ("high", {-3.0: 1.0, 0.0: 1.0}),
    ):
        for R, f in known.items():
            a, m = ratio(R)
            assert a / WeldRatio(case).equivalent(a, m) == pytest.approx(f), (case, R)
    assert WeldRatio("low").equivalent(50e6, -100e6) == pytest.approx(50e6 / 1.6)


def test_part_of_the_compression():
    rule = PartCompression()
    assert rule.equivalent(50e6, 80e6) == pytest.approx(50e6)  # all tension
    assert rule.equivalent(50e6, -80e6) == pytest.approx(30e6)  # all compression
    # from -40 to 100 MPa: 100 + 0.6 40 = 124 MPa range
    assert rule.equivalent(70e6, 30e6) == pytest.approx(62e6)


def test_mistakes():
    with pytest.raises(InputError, match="S_u is -1 Pa"):
        Goodman(-1.0)
    with pytest.raises(InputError, match="below 1"):
        FKM(1.5)
    with pytest.raises(InputError, match="did you mean 'steel'"):
        FKM.of("steal", 500e6)
    with pytest.raises(InputError, match="low, medium or high"):
        WeldRatio("none")
    with pytest.warns(JoustoWarning, match="was it given in MPa"):
        Goodman(500.0)
