"""Hot spots: the search finds what brute force finds, and its bounds are never below the truth."""

from __future__ import annotations

import importlib
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import jousto.recovery.hotspots.bounds as bounds
from jousto.base.errors import InputError, JoustoError
from jousto.recovery.fields.build import field_from
from jousto.recovery.fields.criteria import Plane, evaluate
from jousto.recovery.fields.field import StressField
from jousto.recovery.hotspots.hot_spots import hot_spots
from jousto.recovery.hotspots.measures import EXTREMES, measure
from jousto.recovery.hotspots.search import search
from jousto.recovery.hotspots.windows import cut_windows, spectral
from jousto.reduction.fields.stress import StressModes

CRITERIA: tuple[Any, ...] = (
    "von-mises",
    "signed-von-mises",
    "principal-1",
    "principal-2",
    "principal-3",
    "signed-principal",
    "max-shear",
    "s11",
    "s23",
    Plane((1.0, 2.0, -1.0)),
)
CASES = [
    (criterion, extreme)
    for criterion in CRITERIA
    for extreme in EXTREMES
    if not (criterion in ("von-mises", "max-shear") and extreme == "smallest")
]


def random_field(seed: int, ns: int, nt: int, n: int) -> StressField:
    """A path of sines, jumps and lone peaks; stress modes of one, two and many components."""
    rng = np.random.default_rng(seed)
    S = rng.normal(size=(ns, 6, n)) * rng.choice([1e3, 1e6, 1e8], size=(ns, 1, 1))
    S[rng.random(ns) < 0.3, 1:] = 0.0
    S[rng.random(ns) < 0.1] = 0.0
    if ns > 3:
        S[1], S[2] = S[0], -S[0]  # ties
    t = np.linspace(0.0, 1.0, nt)
    p = np.sin(np.outer(t, rng.uniform(1, 60, n)) + rng.uniform(0, 6, n)) / (1 + np.arange(n))
    p += rng.normal(size=(nt, n)) * rng.choice([0.0, 1e-6, 0.3])
    p[rng.integers(nt)] += rng.normal(size=n) * rng.choice([0.0, 5.0])
    if n > 2:
        p[:, 2] = 2.0 * p[:, 0]  # a path of lower rank
        p[:, 1] *= rng.choice([0.0, 1e-9, 1.0])
    p *= 1e-3
    labels = tuple(f"n{k + 1}" for k in range(ns))
    axes = np.tile(np.eye(3), (ns, 1, 1))
    return field_from(StressModes(labels, rng.random((ns, 3)), axes, S), p, t)


def brute_force(field: StressField, sought: Any, count: int, apart: float) -> tuple[Any, Any]:
    """Return the ranked values of the hot spots and all largest values, worked out in full."""
    s = np.einsum("scj,tj->tsc", field.S, field.p)
    best = sought.rank(sought.value(s)).max(axis=0)
    left, values = best.copy(), []
    while len(values) < count and np.isfinite(left).any():
        k = int(np.argmax(left))
        values.append(left[k])
        away = np.linalg.norm(field.positions - field.positions[k], axis=1)
        left[away <= apart] = -np.inf
        left[k] = -np.inf
    return np.array(values), best


def rounding(field: StressField) -> Any:
    """What two orders of the same sum may differ by at each place (ns,), Pa."""
    largest = np.abs(field.S).sum(axis=1) @ np.abs(field.p).max(axis=0)
    return np.asarray(1e-14 * largest)


@pytest.mark.parametrize(("criterion", "extreme"), CASES)
def test_finds_what_brute_force_finds(criterion: Any, extreme: str) -> None:
    for seed in range(2):
        field = random_field(seed, 40, 330, 5)
        sought = measure(criterion, extreme)
        for count, apart in ((4, 0.0), (6, 0.25), (200, 0.1)):
            expected, best = brute_force(field, sought, count, apart)
            found = search(field.S, field.p, field.positions, sought, count=count, separation=apart)
            slack = rounding(field).max()
            assert np.abs(found.ranked - expected).max() <= slack
            away = np.abs(best[found.places] - found.ranked)
            assert np.all(away <= rounding(field)[found.places])
            # nothing that is neither a spot nor near one exceeds what the certificate says
            near = np.zeros(field.ns, dtype=bool)
            for k in found.places:
                away = np.linalg.norm(field.positions - field.positions[k], axis=1)
                near |= (away <= apart) & (apart > 0.0)
                near[k] = True
            # exactly: the bound has a margin for every order of the sums
            proof = found.certificate
            assert best[~near].max(initial=-np.inf) <= proof.bound
            assert proof.bound <= found.ranked.min() + proof.margin + slack


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    ns=st.integers(1, 40),
    nt=st.sampled_from([1, 2, 15, 16, 17, 127, 128, 129, 130, 257, 400]),
    n=st.integers(1, 9),
    case=st.sampled_from(CASES),
    apart=st.sampled_from([0.0, 0.3, 3.0]),
    count=st.integers(1, 8),
)
def test_any_case(
    seed: int, ns: int, nt: int, n: int, case: tuple[Any, str], apart: float, count: int
) -> None:
    field = random_field(seed, ns, nt, n)
    sought = measure(*case)
    expected, best = brute_force(field, sought, count, apart)
    found = search(field.S, field.p, field.positions, sought, count=count, separation=apart)
    assert len(found.ranked) == len(expected)
    slack = rounding(field).max()
    assert np.abs(found.ranked - expected).max() <= slack
    at = field.p[found.instants]
    s = np.einsum("kcj,kj->kc", field.S[found.places], at)
    assert np.allclose(sought.rank(sought.value(s)), found.ranked, rtol=0, atol=slack)


@pytest.mark.parametrize(("criterion", "extreme"), CASES)
def test_bounds_are_never_below_the_truth(criterion: Any, extreme: str) -> None:
    for seed in range(3):
        field = random_field(100 + seed, 30, 300, 4)
        sought = measure(criterion, extreme)
        work = bounds.prepare(field.S, field.p, sought)
        _, best = brute_force(field, sought, 1, 0.0)
        assert np.all(work.whole() >= best)
        every = np.arange(field.ns)
        # nothing is refined: all that is known of the places are the bounds of the coarse windows
        found, _, upper = work.refine(every, np.full(field.ns, np.inf))
        assert np.all(np.isneginf(found))
        assert np.all(upper >= best)
        # half of them refined; what is known exactly differs by the order of its sum
        found, _, upper = work.refine(every, np.full(field.ns, np.median(best)))
        assert np.all(upper >= np.where(found == upper, best - rounding(field), best))
        assert np.all(found <= best + rounding(field))


STRAINS = [case for case in CASES if case[0] not in ("s11", "s23")]
STRAINS += [(name, extreme) for name in ("e11", "g23", "e12") for extreme in EXTREMES]


@pytest.mark.parametrize(("criterion", "extreme"), STRAINS)
def test_finds_what_brute_force_finds_of_strain(criterion: Any, extreme: str) -> None:
    """The normal strain of a plane takes half of every engineering shear: one bound, one value."""
    for seed in range(3):
        stress = random_field(seed, 40, 330, 4)
        modes = replace(stress.modes, elasticity=np.tile([210e9, 0.3], (40, 1)))
        field = field_from(modes, stress.p, stress.time, strain=True)
        values = measure(criterion, extreme, strain=True).rank(field.values(criterion))
        expected = np.sort(values.max(axis=0))[::-1][:5]
        found = hot_spots(field, count=5, criterion=criterion, extreme=extreme)
        slack = rounding(field).max()
        ranked = measure(criterion, extreme, strain=True).rank(np.array([x.value for x in found]))
        assert np.abs(ranked - expected).max() <= slack
        assert found.certified


def test_the_bound_is_above_values_in_any_order_of_their_sums() -> None:
    """What `values` finds at all other places, by other sums than the search, stays below."""
    for seed in range(40):
        rng = np.random.default_rng(seed)
        S, p = 1e6 * rng.normal(size=(40, 6, 8)), rng.normal(size=(300, 8))
        modes = StressModes(
            tuple(map(str, range(40))), np.eye(40, 3), np.tile(np.eye(3), (40, 1, 1)), S
        )
        field = field_from(modes, p, np.arange(300.0))
        found = hot_spots(field, count=39)
        left = next(k for k in field.labels if k not in {spot.site for spot in found})
        for values in (
            field.values("von-mises", left),
            evaluate(np.einsum("cj,tj->tc", S[int(left)], p)),
        ):
            assert values.max() <= found.bound <= values.max() * (1 + 1e-9)
        assert found.certified


def test_bounds_that_contradict_values_end_with_an_error() -> None:
    """A bound that stays above a value after all windows were worked out must not loop forever."""
    field = random_field(2, 30, 300, 3)
    sought = measure("s12", "magnitude")
    # values of half the size: no value reaches what the knots of the windows promise
    low = replace(sought, value=lambda s: 0.5 * sought.value(s))
    with pytest.raises(JoustoError, match="contradict each other"):
        search(field.S, field.p, field.positions, low, count=3)


def test_one_instant_of_one_place() -> None:
    """A place that is worse than all others for one instant, by the smallest margin."""
    rng = np.random.default_rng(3)
    ns, nt, n = 400, 3000, 6
    S = np.zeros((ns, 6, n))
    S[:, 0] = rng.uniform(-1.0, 1.0, (ns, n))
    S[:, 0, -1] = 0.0
    t = np.linspace(0, 1, nt)
    p = np.sin(np.outer(t, np.arange(20, 20 + n)))
    p[:, -1] = 0.0
    p[1777, -1] = 1.0  # a mode that moves at one instant only, and stresses one place
    worst = np.abs(S[:, 0] @ p.T).max()
    sign = np.sign(S[123, 0] @ p[1777])
    S[123, 0, -1] = sign * (worst * (1.0 + 1e-12) - abs(S[123, 0, :-1] @ p[1777, :-1]))
    labels = tuple(map(str, range(ns)))
    modes = StressModes(labels, rng.random((ns, 3)), np.tile(np.eye(3), (ns, 1, 1)), S)
    found = hot_spots(field_from(modes, p, t), count=1)
    assert (found[0].site, found[0].time) == ("123", t[1777])
    assert found.pruned + found.visited == ns
    assert found.certified


def test_a_bound_that_is_too_low_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """With bounds of nine tenths the same checks see that places are missed."""
    field = random_field(11, 300, 700, 5)
    sought = measure("von-mises")
    expected, _ = brute_force(field, sought, 20, 0.0)
    whole = bounds.Search.whole
    monkeypatch.setattr(bounds.Search, "whole", lambda self: 0.9 * whole(self))
    # a loose bound first, a tight one second: the second place is the worse one
    S = np.zeros((2, 6, 2))
    S[0, 0], S[1, 0] = (95.0, 95.0), (96.0, 0.0)
    p = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    importlib.import_module("jousto.recovery.hotspots.search")
    monkeypatch.setattr(sys.modules["jousto.recovery.hotspots.search"], "FIRST", 1)
    low = search(S, p, np.eye(2, 3), sought, count=1)
    assert (low.ranked[0], low.certificate.bound) == (95.0, pytest.approx(0.9 * 96.0))
    monkeypatch.setattr(bounds.Search, "whole", whole)
    good = search(S, p, np.eye(2, 3), sought, count=1)
    assert (good.ranked[0], good.certificate.bound) == (96.0, pytest.approx(95.0, rel=1e-10))
    # chords: a window whose strays are left out misses what happens between its knots
    monkeypatch.setattr(bounds.Windows, "strays", lambda *_: 0.0)
    monkeypatch.setattr(bounds.Windows, "strays_of_pairs", lambda *_: 0.0)
    found = search(field.S, field.p, field.positions, sought, count=20)
    assert np.abs(found.ranked - expected).max() > 1e-3 * expected[0]


def test_norms_and_windows() -> None:
    rng = np.random.default_rng(0)
    B = rng.normal(size=(50, 5, 7))
    B[:10, 1:] = 0.0
    B[10:20] *= 1e-200
    norm = np.linalg.norm(B, 2, axis=(1, 2))
    bound = spectral(B)
    assert np.all(bound >= norm)
    assert np.all(bound <= 1.12 * norm + 1e-140)
    y = rng.normal(size=(129, 7)).cumsum(axis=0)
    windows = cut_windows(y, 16)
    columns = np.sqrt((B**2).sum(axis=1))
    strays = windows.strays(columns, bound)
    ends = np.linspace(0.0, 1.0, 17)[:16, None]
    for w in range(8):
        a, b = y[16 * w], y[16 * w + 16]
        inside = y[16 * w : 16 * w + 16]
        # the nearest point of the chord, found by trying many
        shares = np.linspace(0, 1, 2001)[:, None, None]
        d = inside - ((1 - shares) * a + shares * b)
        d = d[np.argmin((d**2).sum(axis=2), axis=0), np.arange(16)]
        reached = np.linalg.norm(B @ d.T, axis=1).max(axis=1)
        assert np.all(strays[:, w] >= reached * (1 - 1e-2))
    assert ends.shape == (16, 1)


def test_straight_paths_need_their_ends_only() -> None:
    """A convex criterion of a straight path is largest at an end: spec of the chord bound."""
    rng = np.random.default_rng(5)
    p = np.linspace(0, 1, 1025)[:, None] * rng.normal(size=4)
    S = rng.normal(size=(200, 6, 4))
    found = search(S, p, np.zeros((200, 3)), measure("von-mises"), count=1)
    assert found.instants[0] == 1024
    assert found.certificate.full == 17 * found.certificate.complete  # one window each


def test_refuses_clearly() -> None:
    field = random_field(0, 5, 40, 3)
    with pytest.raises(InputError, match="not a criterion"):
        hot_spots(field, criterion="mises")
    with pytest.raises(InputError, match=r"count is 0.*\n?.*"):
        hot_spots(field, count=0)
    with pytest.raises(InputError, match="separation is -1"):
        hot_spots(field, separation=-1)
    with pytest.raises(InputError, match="given more than once"):
        hot_spots([field, field])
    with pytest.raises(InputError, match="extreme is 'most'"):
        hot_spots(field, extreme="most")
    with pytest.raises(InputError, match="omit extreme"):
        hot_spots(field, extreme="smallest")
    with pytest.raises(InputError, match="must be a run or fields"):
        hot_spots(7)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="no instant from 5"):
        hot_spots(field, start=5.0)
    A = np.tile([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], (40, 1, 1))
    world = field_from(field.modes, field.p, field.time, A=A)
    with pytest.raises(InputError, match="world axes changes with the rotation"):
        hot_spots(world, criterion="s11")
    here, there = hot_spots(field, count=1)[0], hot_spots(world, count=1)[0]
    assert there.value == pytest.approx(here.value, rel=1e-12)
    assert there.tensor[:2] == pytest.approx(here.tensor[1::-1], rel=1e-12)  # turned about z


def test_coordinates_without_numbers_are_refused_with_their_time() -> None:
    field = random_field(0, 5, 40, 3)
    p = np.array(field.p)
    p[[17, 30], 1] = np.nan
    with pytest.raises(InputError, match=r"coordinate 2 is nan at 0.435.* s, instant 17, .* of 2"):
        field_from(field.modes, p, field.time)


def test_bodies_are_ranked_together() -> None:
    """The worst of all bodies; what is left out of one is bounded by the others, too."""
    fields = [replace(random_field(seed, 30, 100, 3), name=f"b{seed}") for seed in (1, 2, 3)]
    found = hot_spots(fields, count=4, separation=0.1)
    apart = [brute_force(field, measure("von-mises"), 4, 0.1)[0] for field in fields]
    expected = np.sort(np.concatenate(apart))[::-1]
    assert np.allclose([spot.value for spot in found], expected[:4], rtol=1e-12)
    assert found.bound >= expected[4]
    assert found.certified
    assert [spot.rank for spot in found] == [1, 2, 3, 4]
    assert "body" in str(found)
    assert np.abs(found.history(0)).max() == pytest.approx(found[0].value, rel=1e-12)


def test_says_when_the_start_is_the_worst() -> None:
    field = random_field(4, 20, 400, 3)
    decay = np.exp(-200.0 * field.time)[:, None]
    started = hot_spots(field_from(field.modes, decay * field.p, field.time), count=3)
    assert started.early == pytest.approx(0.05)
    assert "first 0.05 s" in started.advice()
    growing = hot_spots(field_from(field.modes, field.p / decay, field.time), count=3)
    assert growing.early is None
    assert growing.advice() == ""


def test_invariants_of_strain() -> None:
    """The equivalent strain of uniaxial stress is 2/3 (1 + nu) of the strain along it."""
    S = np.zeros((3, 6, 1))
    S[:, 0, 0] = 210e6, 105e6, 21e6
    axes = np.tile(np.eye(3), (3, 1, 1))
    elasticity = np.tile([210e9, 0.3], (3, 1))
    modes = StressModes(("a", "b", "c"), np.eye(3), axes, S, elasticity)
    field = field_from(modes, [[0.5], [1.0], [-1.5]], [0.0, 1.0, 2.0], strain=True)
    found = hot_spots(field, count=2)
    assert [spot.site for spot in found] == ["a", "b"]
    assert found[0].value == pytest.approx(1.5e-3 * 2 / 3 * 1.3, rel=1e-12)
    found = hot_spots(field, count=1, criterion="max-shear")
    assert found[0].value == pytest.approx(1.5e-3 * 1.3, rel=1e-12)
    assert "um/m" in str(found)
    assert evaluate(found[0].tensor, "principal-1", True) == pytest.approx(0.3 * 1.5e-3)


def test_points_of_one_section_are_one_spot() -> None:
    """Without a separation beams list sections, not the neighbours of the worst point."""
    labels = tuple(f"e{e}.a.{k}" for e in (1, 2, 3) for k in ("top", "side", "bottom"))
    high = np.tile([[0.0, 0.0, 0.1], [0.0, 0.1, 0.0], [0.0, 0.0, -0.1]], (3, 1))
    x = np.repeat(np.arange(3.0), 3)[:, None] * [1.0, 0.0, 0.0] + high
    S = np.zeros((9, 6, 1))
    S[:, 0, 0] = [9e6, 8e6, -7e6, 3e6, 2e6, 1e6, 6e6, 5e6, 4e6]
    axes = np.tile(np.eye(3), (9, 1, 1))
    nodes = np.repeat([0, 1, 2], 3)
    modes = StressModes(labels, x, axes, S, nodes=nodes)
    field = field_from(modes, [[0.0], [1.0]], [0.0, 1.0])
    found = hot_spots(field, count=3)
    assert [spot.site for spot in found] == ["e1.a.top", "e3.a.top", "e2.a.top"]
    # twice the largest distance from the centre of a section's three points
    assert found.separation == pytest.approx(2.0 * np.hypot(0.1, 0.1 / 3.0), rel=1e-5)
    every = hot_spots(field, count=3, separation=0.0)
    assert [spot.site for spot in every] == ["e1.a.top", "e1.a.side", "e1.a.bottom"]
    # of solids each node is a place of its own
    solid = field_from(replace(modes, nodes=np.arange(9)), [[0.0], [1.0]], [0.0, 1.0])
    assert [spot.site for spot in hot_spots(solid, count=2)] == ["e1.a.top", "e1.a.side"]


@pytest.mark.parametrize("criterion", ["principal-1", "principal-3"])
@pytest.mark.parametrize("instants", [40, 300])
def test_the_first_principal_stress_of_compression_is_found_to_be_zero(
    criterion: str, instants: int
) -> None:
    """And the third one of tension: 0 beside stresses of some 5, so 5e-15 is its rounding."""
    rng = np.random.default_rng(0)
    d = rng.standard_normal((60, 3))
    x, y, z = (d / np.linalg.norm(d, axis=1)[:, None]).T
    uniaxial = np.stack([x * x, y * y, z * z, x * y, y * z, x * z], axis=1)
    modes = uniaxial[:, :, None] * rng.uniform(1.0, 2.0, (60, 1, 2))
    p = np.abs(rng.standard_normal((instants, 2))) * (-1.0 if criterion == "principal-1" else 1.0)
    found = search(modes, p, np.zeros((60, 3)), measure(criterion), count=4)
    assert len(found.places) == 4
    np.testing.assert_allclose(found.ranked, 0.0, atol=1e-14)
