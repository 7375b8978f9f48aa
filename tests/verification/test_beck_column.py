"""Beck's column, pressed by a force that follows its end: flutter, no buckling."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import jousto as jo
from jousto.simulation.modes import large

E, RHO, B, H = 210e9, 7850.0, 0.02, 0.002
EI = E * B * H**3 / 12
UNIT = np.sqrt(EI / (RHO * B * H)) / (2 * np.pi)  # Hz, length 1 m


@pytest.fixture(scope="module")
def column() -> jo.Model:
    steel = jo.Material(E=E, nu=0.3, rho=RHO)
    beam = jo.BeamBody(
        "beam", [(0, 0, 0), (1, 0, 0)], jo.Rectangle(B, H), steel, elements=12, up=(0, 0, 1),
        bending=True, mass="corrected",
    )  # fmt: skip
    base = jo.Fixed("base", jo.ground["origin"], beam["start"])
    push = jo.Force("push", beam["end"], (-1, 0, 0), follow=True, signal=jo.Input("load"))
    return jo.compile(jo.Mechanism(beam, base, push))


def closed(p: float) -> list[float]:
    """First two frequencies, Hz, at p = P L^2 / EI (Beck 1952; Bolotin 1963, 2.2)."""

    def zero(w: float) -> float:
        root = np.sqrt(p * p / 4 + w * w)
        a, b = np.sqrt(p / 2 + root), np.sqrt(root - p / 2)
        turn = p * w * np.sin(a) * np.sinh(b) + 2 * w * w * np.cos(a) * np.cosh(b)
        return float(p * p + 2 * w * w + turn)

    grid = np.linspace(0.5, 30.0, 600)
    found = [
        brentq(zero, x, y)
        for x, y in zip(grid[:-1], grid[1:], strict=True)
        if zero(x) * zero(y) < 0
    ]
    return [w * UNIT for w in found[:2]]


@pytest.mark.parametrize("many", [600, 1])
def test_frequencies_under_a_load_that_follows(column, monkeypatch, many):
    monkeypatch.setattr(large, "MANY", many)
    for p in (5.0, 15.0):
        state = jo.simulation.load_path(column, "load", to=p * EI, steps=3).states[-1]
        found = jo.modes(column, state, count=6)
        low = [min(found.frequencies, key=lambda f, c=c: abs(f - c)) for c in closed(p)]
        assert low == pytest.approx(closed(p), rel=5e-3)
        assert np.abs(found.damping).max() < 1e-6


def test_it_flutters_beyond_20_05(column):
    """P = 20.05 EI / L^2 (Beck 1952): one of a pair grows, the other decays."""
    for p, flutters in ((19.8, False), (20.3, True)):
        state = jo.simulation.load_path(column, "load", to=p * EI, steps=3).states[-1]
        damping = jo.modes(column, state).damping
        assert (damping.min() < -1e-3) == flutters
        assert (damping.max() > 1e-3) == flutters
