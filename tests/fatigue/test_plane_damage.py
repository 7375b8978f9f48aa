"""Damage on planes by the engine against a plain count of every line of every plane."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jousto as jo
from fatigue.counting import pairs
from jousto.fatigue.cycles.rainflow import turning_points
from jousto.fatigue.multiaxial.planes import normals, on_planes

STEEL = jo.SN(S_D=100e6, N_D=1e6, k=5.0)
KNEE = jo.SN(S_D=100e6, N_D=1e6, k=5.0, rule="haibach")
FINDLEY = jo.fatigue.Findley(0.3)
SHEAR = jo.fatigue.FatemiSocie(S_y=400e6, E=210e9)


def histories(ns: int, nt: int, seed: int) -> np.ndarray:
    """Stress (ns, nt, 6) whose components go their own ways, with plateaus, up to 250 MPa."""
    rng = np.random.default_rng(seed)
    s = np.cumsum(rng.normal(size=(ns, nt, 4)), axis=1) + 3.0 * rng.normal(size=(ns, nt, 4))
    s[:, nt // 3 : nt // 3 + 4] = s[:, nt // 3, None]
    s = np.einsum("ntk,nkc->ntc", s, rng.normal(size=(ns, 4, 6)))
    return 250e6 * s / np.abs(s).max(axis=(1, 2))[:, None, None]


def line_damage(x, sn, residue, cycle):
    """One line: four-point count of ASTM E1049; `cycle` takes from, to and the largest sn."""
    if residue == "repeat":
        turn = int(np.argmax(np.abs(x)))
        x, sn = (np.concatenate([a[turn:], a[: turn + 1]]) for a in (x, sn))
    index = turning_points(x)[1]
    i, j, count = pairs(x[index], residue)
    total = 0.0
    for a, b, times in zip(index[i], index[j], count, strict=True):
        total += times * cycle(x[a], x[b], sn[a : b + 1].max())
    return total


def brute(s, criterion, curve, residue, step, mean=None):
    """Damage (planes, lines) of every line of every plane."""
    n = normals(math.radians(step))
    angles = np.radians(np.arange(0.0, 180.0, step))
    sn, t = on_planes(s, n)

    def cycle(a, b, top):
        size = 0.5 * abs(a - b)
        if isinstance(criterion, jo.fatigue.NormalStress):
            size = size if mean is None else float(mean.equivalent(size, 0.5 * (a + b)))
            return float(curve.damage(size))
        value = criterion.value(size, top)
        if isinstance(criterion, jo.fatigue.FatemiSocie):
            return 1.0 / float(criterion.cycles(value, curve))
        return float(curve.damage(float(criterion.equivalent(value))))

    out = []
    for normal, shear in zip(sn, t, strict=True):
        lines = shear @ np.stack([np.cos(angles), np.sin(angles)])
        lines = normal[:, None] if isinstance(criterion, jo.fatigue.NormalStress) else lines
        out.append([line_damage(x, normal, residue, cycle) for x in lines.T])
    return n, np.array(out)


@pytest.mark.parametrize("residue", ["half", "repeat", "ignore"])
@pytest.mark.parametrize(
    ("criterion", "curve", "mean"),
    [
        (FINDLEY, STEEL, None),
        (FINDLEY, KNEE, None),
        (jo.fatigue.NormalStress(), STEEL, None),
        (jo.fatigue.NormalStress(), STEEL, jo.fatigue.Goodman(S_u=900e6)),
        (SHEAR, jo.fatigue.strain_life("sae-1045"), None),
    ],
)
def test_no_line_of_any_plane_is_worse(residue, criterion, curve, mean):
    step = 30.0
    s = histories(3, 60, seed=3)
    found = jo.fatigue.plane_damage(s, criterion, curve, residue=residue, mean=mean, step=step)
    # the table of the strain-life curve leaves 1e-7 of the life, counting itself round-off
    near = 1e-6 if criterion is SHEAR else 1e-9
    for one, damage, normal in zip(s, found.damage, found.normal, strict=True):
        n, D = brute(one, criterion, curve, residue, step, mean)
        assert damage == pytest.approx(D.max(), rel=near)
        place = np.flatnonzero((n == normal).all(axis=1))
        assert D[place[0]].max() == pytest.approx(D.max(), rel=near)


def test_many_places_are_those_one_by_one():
    s = histories(150, 40, seed=5)
    together = jo.fatigue.plane_damage(s, FINDLEY, STEEL, residue="half", step=45.0)
    alone = [
        jo.fatigue.plane_damage(x, FINDLEY, STEEL, residue="half", step=45.0).damage[0] for x in s
    ]
    np.testing.assert_array_equal(together.damage, alone)


def test_histories_without_cycles_do_no_damage():
    still = np.zeros((2, 5, 6))
    still[1] = [100e6, 20e6, 0.0, 30e6, 0.0, 0.0]
    for criterion, curve in (
        (FINDLEY, STEEL),
        (jo.fatigue.NormalStress(), STEEL),
        (SHEAR, jo.fatigue.strain_life("sae-1045")),
    ):
        for residue in ("half", "repeat", "ignore"):
            found = jo.fatigue.plane_damage(still, criterion, curve, residue=residue)
            assert found.damage.tolist() == [0.0, 0.0]
            single = jo.fatigue.plane_damage(still[1, :1], criterion, curve, residue=residue)
            assert single.damage.tolist() == [0.0]


def at_angle(degrees):
    return [math.cos(math.radians(degrees)), math.sin(math.radians(degrees)), 0.0]


@pytest.mark.parametrize("residue", ["half", "repeat", "ignore"])
@pytest.mark.parametrize("nudge", [(1.0, 1.0 + 4e-14), (1.0 + 4e-14, 1.0), (1.0, 1.0)])
def test_of_planes_equally_bad_the_one_nearest_to_the_first_axis_is_taken(nudge, residue):
    """Equal tension along x and y: the normal stress is the same on all planes along z."""
    s = np.zeros((1, 60, 6))
    swing = 80e6 * np.sin(np.arange(60.0)) + 20e6
    s[0, :, 0], s[0, :, 1] = nudge[0] * swing, nudge[1] * swing
    found = jo.fatigue.plane_damage(s, jo.fatigue.NormalStress(), STEEL, residue=residue)
    assert found.normal[0] == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    # alternating shear: planes at 40 and 50 degrees (45 is none of them) to each side of x
    s = np.zeros((1, 60, 6))
    s[0, :, 3] = 80e6 * (-1.0) ** np.arange(60)
    s[0, :, 0] = 1e-13 * s[0, :, 3] * (nudge[0] - nudge[1]) / 4e-14
    found = jo.fatigue.plane_damage(s, jo.fatigue.NormalStress(), STEEL, residue=residue)
    assert found.normal[0] == pytest.approx(at_angle(40.0), abs=1e-12)
    # at 8.3 degrees = atan(k) / 2 to each side of x and of y, next to it 10
    shear = jo.fatigue.plane_damage(s, FINDLEY, STEEL, residue=residue)
    assert shear.normal[0] == pytest.approx(at_angle(10.0), abs=1e-12)


@pytest.mark.parametrize("nudge", [-1.0, 0.0, 1.0])
@pytest.mark.parametrize("criterion", [jo.fatigue.NormalStress(), FINDLEY, SHEAR], ids=repr)
def test_critical_planes_of_bars_are_chosen_by_the_rule(criterion, nudge):
    """Tension along z: all planes at one angle to the bar are equally bad."""
    s = np.zeros((73, 6))
    s[:, 2] = 100e6 * np.sin(np.linspace(0.0, 2.0 * np.pi, 73))
    s[:, 0], s[:, 1] = 1e-14 * nudge * s[:, 2], -1e-14 * nudge * s[:, 2]
    found = jo.fatigue.critical_plane(s, criterion)
    plain = jo.fatigue.critical_plane(s * [0, 0, 1, 0, 0, 0], criterion)
    assert found.normal == pytest.approx(plain.normal, abs=1e-3)
    # next to the plane of x and z: the net of 9 degrees decides, which is then refined
    assert abs(found.normal[1]) < np.radians(9.0)
    assert found.normal[0] >= -1e-3
