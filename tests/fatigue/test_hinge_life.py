"""Plastic hinges: verdict over cycles, strain life against closed forms, wrong histories."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.optimize

import jousto as jo
from jousto.fatigue import StrainLife, hinge_cycles, hinge_life

STEEL = StrainLife(E=206e9, sf=930e6, b=-0.095, ef=0.26, c=-0.47)
H, LENGTH, W = 0.2, 0.1, 2e-4  # depth, plastic length, m; section modulus, m3


def test_reversals_at_an_amplitude_of_one_per_cent() -> None:
    """p h / (2 l_p) = .01 under hardly any moment, by Manson-Coffin: 1748.505715 reversals."""
    M, p = 1e-6 * np.array([1.0, -1.0, 1.0]), 0.01 * 2 * LENGTH / H * np.array([1.0, -1.0, 1.0])
    for form in ("coffin-manson", "morrow"):
        found = hinge_life(
            M, p, STEEL, length=LENGTH, depth=H, modulus=W, residue="repeat", form=form
        )
        assert 2.0 * found.life == pytest.approx(1748.505715, rel=1e-9)
        assert found.strain == pytest.approx([0.01], rel=1e-9)


@pytest.mark.parametrize("form", ["morrow", "swt"])
@pytest.mark.parametrize("depth", [H, None])
def test_elastic_part_and_mean_stress(depth: float | None, form: str) -> None:
    M, p = np.array([30e3, -10e3, 30e3]), np.array([0.012, 0.002, 0.012])
    lever = 1.0 if depth is None else depth / 2
    found = hinge_life(
        M, p, STEEL, length=LENGTH, depth=depth, modulus=W, residue="repeat", form=form
    )
    amplitude = 20e3 / W / STEEL.E + 0.005 * lever / LENGTH
    assert found.strain == pytest.approx([amplitude], rel=1e-12)
    assert found.mean == pytest.approx([10e3 / W], rel=1e-12)
    x, e = 2.0 * found.cycles[0], amplitude
    sf, b, ef, c, E = STEEL.sf, STEEL.b, STEEL.ef, STEEL.c, STEEL.E
    if form == "morrow":
        assert (sf - 10e3 / W) / E * x**b + ef * x**c == pytest.approx(e, rel=1e-9)
    else:
        top = 10e3 / W + float(STEEL.stress(e))
        wanted = sf**2 / E * x ** (2 * b) + sf * ef * x ** (b + c)
        assert top * e == pytest.approx(wanted, rel=1e-9)


def test_life_falls_with_the_plastic_length() -> None:
    M, p = np.array([30e3, -30e3, 30e3]), np.array([0.02, -0.02, 0.02])
    lives = [
        hinge_life(M, p, STEEL, length=x, depth=H, modulus=W, residue="repeat").life
        for x in (0.1, 0.2)
    ]
    assert lives[1] > 2.5 * lives[0]


def cycles_of(loads: list[float], **law: float) -> jo.fatigue.HingeCycles:
    """Return the cycles of a hinge of 3000 N m under a slow moment with these turning points."""
    body = jo.RigidBody("boom", 0.1, (0.01,) * 3)
    root = jo.Revolute("root", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    hinge = jo.mechanism.PlasticSpring("hinge", root.angle, 2e5, 3000.0, **law)
    hold = jo.Spring("hold", root.angle, damping=200.0)
    times = np.arange(2 * len(loads))  # it rests at every turning point, as the damper lags
    load = jo.JointForce("load", root.angle, jo.Table(times, np.repeat(loads, 2)))
    p = jo.mechanism.ForceStateSensor("p", hinge)
    items = (body, root, hinge, hold, load, jo.ForceSensor("M", hinge), p)
    run = jo.simulate(jo.compile(jo.Mechanism(*items)), float(times[-1]), solver=jo.ROS2(1e-3))
    return hinge_cycles(-run["M"], run["p"])


@pytest.mark.parametrize(
    "loads, law, verdict",
    [
        ([0, 2900, -2900] * 3, {"kinematic": 2e4}, "elastic"),
        # range below 2 M_y, kinematic: shakedown
        ([0, *[5000, -900] * 4], {"kinematic": 2e4}, "shakedown"),
        ([0, *[5000, -1100] * 4], {"kinematic": 2e4}, "alternating"),
        ([0, *[4000, -4000] * 4], {"isotropic": 2e4}, "shakedown"),
        ([0, *[4000, -3500] * 6], {"kinematic": 6e4, "recovery": 30.0}, "ratchet"),
    ],
)
def test_verdict(loads: list[float], law: dict[str, float], verdict: str) -> None:
    found = cycles_of([float(x) for x in loads], **law)
    assert found.verdict == verdict
    assert len(found.range) >= 2
    assert verdict in str(found)
    assert (found.work >= -1e-9).all()
    if verdict == "ratchet":
        wanted = np.log((2000.0**2 - 500.0**2) / (2000.0**2 - 1000.0**2)) / 30.0
        assert found.drift[-1] == pytest.approx(wanted, rel=1e-4)
    if verdict == "alternating":
        assert found.range[-1] == pytest.approx(100.0 / 2e4, rel=1e-4)


def test_yielding_in_the_last_half_cycle_counts() -> None:
    M, p = [0.0, *[1000.0, -1000.0] * 3, 5000.0], [0.0] * 7 + [0.1]
    found = hinge_cycles(M, p)
    assert found.verdict == "undecided"
    assert found.drift[-1] == pytest.approx(0.1)
    assert found.work.sum() == pytest.approx(0.1 * 2000.0)  # nothing is left out
    # what yields while the moment stays after the last turn counts, too
    assert hinge_cycles([*M, 5000.0], [*p, 0.3]).drift[-1] == pytest.approx(0.3)


def test_one_cycle_with_drift_is_no_ratchet() -> None:
    M, p = [0.0, *[1000.0, -1000.0] * 3, 5000.0, -1000.0], [0.0] * 7 + [0.1, 0.1]
    assert hinge_cycles(M, p).verdict == "undecided"
    # shakedown after it, and a ratchet once other cycles add as much
    assert hinge_cycles([*M, 1000.0, -1000.0], [*p, 0.1, 0.1]).verdict == "shakedown"
    more = [*M, 5000.0, -1000.0, 5000.0, -1000.0]
    assert hinge_cycles(more, [*p, 0.2, 0.2, 0.3, 0.3]).verdict == "ratchet"
    # to and fro by turns adds nothing
    assert hinge_cycles(more, [*p, 0.0, 0.0, 0.1, 0.1]).verdict == "undecided"


@pytest.mark.parametrize("count", [6, 12, 40])
def test_a_drift_that_dies_away_settles(count: int) -> None:
    """Armstrong and Frederick with isotropic hardening: X and the yield force step by step.

    Between two turns M the flow dl solves ``s X + M_y + Hi l = s M`` with
    ``s X = C/G - (C/G - s X0) exp(-G dl)``.
    """
    C, G, Hi, strength, X, p, path = 6e4, 30.0, 5e3, 3000.0, 0.0, 0.0, 0.0
    M, plastic = [0.0], [0.0]
    for load in [4000.0, -3500.0] * count:
        s = np.sign(load)

        def over(
            dl: float, s: float = s, load: float = load, X: float = X, l: float = path
        ) -> float:
            back = C / G - (C / G - s * X) * np.exp(-G * dl)
            return float(back + strength + Hi * (l + dl) - s * load)

        dl = scipy.optimize.brentq(over, 0.0, 1.0, xtol=1e-18) if over(0.0) < 0.0 else 0.0
        X = s * (C / G - (C / G - s * X) * np.exp(-G * dl))
        p, path = p + s * dl, path + dl
        M.append(load)
        plastic.append(p)
    found = hinge_cycles(M, plastic)
    assert abs(found.drift[-1]) < 0.75 * abs(found.drift[-2])
    assert found.verdict == "settling"
    assert f"drift of the last cycle {found.drift[-1]:.4g}" in str(found)


def test_a_plateau_of_the_moment_belongs_to_the_cycle_that_ends_there() -> None:
    """Without hardening it flows at a constant moment."""
    up, down = [3000.0] * 3, [-3000.0] * 3
    M = [0.0, *up, *down, *up, *down]
    p = np.array([0, 0, 0.05, 0.1, 0.1, 0, -0.1, -0.1, 0, 0.1, 0.1, 0, -0.1])
    found = hinge_cycles(M, p)
    assert found.verdict == "alternating"
    assert found.range == pytest.approx([0.2, 0.2])
    assert found.work[-1] == pytest.approx(3000.0 * 0.4)


def test_back_force_may_move_the_hinge_against_the_moment() -> None:
    """X = 6000 above M_y = 3000: from 9000 down to 3000 it is elastic, at 1000 it flows back."""
    found = hinge_cycles([9000.0, 3000.0, 1000.0, 9000.0], [0.3, 0.3, 0.2, 0.3])
    assert found.work[-1] == pytest.approx(-0.1 * 2000.0 + 0.1 * 5000.0)
    with pytest.warns(jo.JoustoWarning, match="no complete cycle"):
        assert hinge_cycles([9000, 3000, 1000], [0.3, 0.3, 0.2]).verdict == "undecided"


def test_small_turns_are_no_cycles() -> None:
    M = np.array([0, 100, 98, 4000, 3990, 4000, -4000, -3999, -4000, 4000.0])
    p = np.array([0, 0, 0, 0.05, 0.05, 0.05, -0.05, -0.05, -0.05, 0.05])
    assert len(hinge_cycles(M, p).range) == 1
    assert len(hinge_cycles(M, p, ignore=0.0).range) > 1


def test_wrong_histories() -> None:
    M, p = [0.0, 4000.0, -4000.0], [0.0, 0.05, -0.05]
    with pytest.raises(jo.InputError, match="against the moment; a ForceSensor has the force on"):
        hinge_cycles([0.0, -4000.0, 4000.0], p)
    with pytest.raises(jo.InputError, match="3 values of moment, 2 of plastic"):
        hinge_cycles(M, p[:2])
    with pytest.raises(jo.InputError, match="against the moment"):  # without hardening
        hinge_cycles([0.0, -3000.0, -3000.0], [0.0, 0.0, 0.1])
    for wrong in ([0.0, 1j, 0.0], None, "M"):
        with pytest.raises(jo.InputError, match="moment"):
            hinge_cycles(wrong, p)  # type: ignore[arg-type]
    with pytest.raises(jo.InputError, match="empty"):
        hinge_cycles([], [])
    with pytest.raises(jo.InputError) as error:
        hinge_life(M, p, STEEL, length=0.0, modulus=-1.0, depth=0.0, residue="hafl", form="x")
    assert len(error.value.problems) == 5
    with pytest.warns(jo.JoustoWarning, match="a repetition of the history would start from there"):
        hinge_life(M, p, STEEL, length=1.0, modulus=1.0, depth=0.1, residue="repeat")
