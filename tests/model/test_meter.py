"""The streaming damage meter against the counts of whole histories and published numbers."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, strategies as st

import jousto as jo
from jousto.model.native.damage_meter import count_cycles

ASTM = np.array([-2.0, 1, -3, 5, -1, 3, -4, 4, -2])  # ASTM E1049-85(2017), figure 6
# few values make ties and plateaus, many make long residues; none are closer than the rounding of
# the curve's 100 MPa, below which a meter sees no turn
LOADS = st.one_of(
    st.lists(st.integers(-4, 4).map(float), min_size=1, max_size=120),
    st.lists(st.floats(-1e9, 1e9).map(lambda x: round(x, 3)), min_size=1, max_size=60),
)
# differences of these are exact, so that rules by ranges and by values agree
EXACT = st.one_of(
    st.lists(st.integers(-4, 4).map(float), min_size=1, max_size=120),
    st.lists(st.integers(-(10**9), 10**9).map(lambda i: i / 8), min_size=1, max_size=60),
)


@dataclass(frozen=True)
class Curve:
    """An S-N curve by its numbers alone."""

    numbers: tuple[float, float, float, float, float] = (100e6, 1e6, 5.0, 5.0, 0.0)


def meter(residue="half", **options):
    return jo.model.DamageMeter(Curve(), residue=residue, **options)


def three_point(x):
    """Ranges and counts by the rules of ASTM E1049-85, 5.4.4, as they stand there."""
    turns = []
    for value in x:
        if turns and value == turns[-1]:
            continue
        if len(turns) > 1 and (value > turns[-1]) == (turns[-1] > turns[-2]):
            turns[-1] = value
        else:
            turns.append(value)
    counts, stack = Counter(), []
    for value in turns:
        stack.append(value)
        while len(stack) >= 3:
            x_range, y_range = abs(stack[-1] - stack[-2]), abs(stack[-2] - stack[-3])
            if x_range < y_range:
                break
            if len(stack) == 3:
                counts[y_range] += 0.5
                del stack[0]
            else:
                counts[y_range] += 1.0
                del stack[-3:-1]
    for a, b in zip(stack, stack[1:], strict=False):
        counts[abs(a - b)] += 0.5
    return counts


def basquin(counts, S_D=100e6, N_D=1e6, k=5.0):
    return sum(n * (0.5 * r / S_D) ** k / N_D for r, n in counts.items())


# -- published numbers ------------------------------------------------------------------------


def test_astm_counts_and_damage_of_the_block():
    counts = three_point(ASTM)
    assert counts == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
    m = meter()
    m.push(25e6 * ASTM)
    assert m.damage()[0] == pytest.approx(2.07025146e-6, rel=1e-8)
    assert m.damage()[0] == pytest.approx(basquin(three_point(25e6 * ASTM)), rel=1e-14)
    # one closed cycle, -1 to 3; the rest is left over
    assert m.cycles[0] == 1
    assert m.damage("ignore")[0] == pytest.approx(0.5**5 / 1e6, rel=1e-14)
    assert (m.residue() / 25e6).tolist() == [-2, 1, -3, 5, -4, 4, -2]
    # gone through again and again, the block closes 9, 7, 4 and 3 every time
    repeated = sum((12.5e6 * r / 100e6) ** 5 for r in (9, 7, 4, 3)) / 1e6
    assert m.damage("repeat")[0] == pytest.approx(repeated, rel=1e-14)
    assert m.damage()[0] == pytest.approx(2.07025146e-6, rel=1e-8)  # reading changes nothing


# -- rounding ---------------------------------------------------------------------------------


def test_rounding_turns_no_history():
    """At rest a stress is rounding alone; ranges below 1e-12 of the knee are no cycles."""
    rng = np.random.default_rng(5)
    m = meter()
    m.push(1e-9 * rng.standard_normal((1000, 1)))
    assert m.cycles[0] == 0 and m.damage()[0] == 0.0
    # rounding upon a stress: the damage is that of the stress
    loads = np.tile([0.0, 1e8, 2e8, 1e8], 10)
    m = meter()
    m.push((loads + 1e-8 * rng.standard_normal(40))[:, None])
    exact = meter()
    exact.push(loads[:, None])
    assert m.damage()[0] == pytest.approx(exact.damage()[0], rel=1e-12)
    # a slow drift is none, however small its steps: 1e-5 Pa a sample, 1 Pa and back
    m = meter()
    way = 1e-5 * np.arange(100_001)
    m.push(np.concatenate([way, way[::-1]])[:, None])
    np.testing.assert_allclose(m.residue(), [0.0, 1.0, 0.0], atol=1e-4)


# -- the same as the count of the whole history -----------------------------------------------


@given(LOADS, st.data())
def test_blocks_of_any_size_close_the_cycles_of_the_whole_history(loads, data):
    x = np.array(loads)
    cycles, where, residue, residue_where = count_cycles(x)
    m = meter(depth=256)
    cuts = sorted(data.draw(st.lists(st.integers(0, len(x)), max_size=5)))
    found = np.vstack([m.trace(piece) for piece in np.split(x, cuts)])
    np.testing.assert_array_equal(found, cycles)  # bit by bit, in the same order
    np.testing.assert_array_equal(m.residue(), residue)
    np.testing.assert_array_equal(x[where], cycles)
    np.testing.assert_array_equal(x[residue_where], residue)
    assert np.all(np.diff(residue_where) > 0)


@given(EXACT)
def test_half_cycles_are_those_of_the_standard(loads):
    x = np.array(loads)
    cycles, _, residue, _ = count_cycles(x)
    counts = Counter()
    for a, b in cycles:
        counts[abs(a - b)] += 1.0
    for a, b in zip(residue, residue[1:], strict=False):
        counts[abs(a - b)] += 0.5
    expected = three_point(loads)
    assert counts == expected
    m = meter(depth=256)
    m.push(x)
    assert m.damage()[0] == pytest.approx(basquin(expected), rel=1e-12)


@given(EXACT)
def test_four_points_of_pylife_are_the_same(loads):
    RF = pytest.importorskip("pylife.stress.rainflow")
    x = np.array(loads)
    # pyLife takes the last sample for a turning point, also at the end of a plateau
    x = x[: len(x) - next((i for i, v in enumerate(x[::-1]) if v != x[-1]), len(x)) + 1]
    if len(x) < 2:
        return
    recorder = RF.FullRecorder()
    detector = RF.FourPointDetector(recorder=recorder).process(x)
    cycles, _, residue, _ = count_cycles(x)
    assert sorted(map(tuple, cycles)) == sorted(
        zip(recorder.values_from, recorder.values_to, strict=True)
    )
    np.testing.assert_array_equal(residue, detector.residuals)


@given(LOADS, st.integers(0, 120))
def test_a_meter_goes_on_from_its_memory(loads, at):
    x = np.array(loads)
    whole, first, second = (
        meter("repeat", depth=8),
        meter("repeat", depth=8),
        meter("half", depth=8),
    )
    whole.push(x)
    first.push(x[:at])
    second.load(first.save())
    second.push(x[at:])
    np.testing.assert_array_equal(second.save(), whole.save())


@given(LOADS)
def test_repeating_is_the_history_after_itself(loads):
    x = np.array(loads)
    once, twice = meter("repeat", depth=512), meter("ignore", depth=512)
    once.push(x)
    twice.push(x)
    before = twice.damage()[0]
    twice.push(x)
    expected = twice.damage()[0] - before
    # once more would add the same: the residue of a repeated history is that of the history
    assert once.damage()[0] == pytest.approx(expected, rel=1e-9, abs=1e-12 * expected + 1e-300)


def test_samples_that_are_no_numbers_are_left_out_and_counted(rng):
    x = np.cumsum(rng.normal(size=400)) * 1e7
    spoiled = np.insert(x, [0, 50, 51, 399, 400], [np.nan, np.inf, -np.inf, np.nan, np.nan])
    clean, dirty = meter(), meter()
    clean.push(x)
    dirty.push(spoiled)
    assert dirty.dropped[0] == 5
    assert dirty.samples[0] == 400
    assert dirty.damage()[0] == clean.damage()[0]
    assert "5 samples were not finite" in str(dirty)


def test_many_histories_side_by_side(rng):
    x = np.cumsum(rng.normal(size=(300, 70)), axis=0) * 1e7
    m = meter(n=70)
    m.push(x[:100])
    for row in x[100:110]:
        m.push(row)
    m.push(x[110:])
    for i in range(70):
        one = meter()
        one.push(x[:, i])
        assert one.damage()[0] == m.damage()[i]
        np.testing.assert_array_equal(one.residue(), m.residue(i))
    np.testing.assert_array_equal(m.extremes, np.stack([x.min(axis=0), x.max(axis=0)], axis=1))


# -- curves and mean stress as in Python ------------------------------------------------------

MEANS = (
    *(
        None,
        jo.fatigue.Goodman(400e6),
        jo.fatigue.Goodman(400e6, credit=False),
        jo.fatigue.Morrow(900e6),
    ),
    *(
        jo.fatigue.Soderberg(300e6),
        jo.fatigue.Gerber(400e6),
        jo.fatigue.SWT(),
        jo.fatigue.Walker(0.65),
        jo.fatigue.FKM(0.3),
    ),
    *(
        jo.fatigue.WeldRatio("low"),
        jo.fatigue.WeldRatio("medium"),
        jo.fatigue.WeldRatio("high"),
        jo.fatigue.PartCompression(),
    ),
)
CURVES = (
    *(jo.SN(100e6, 1e6, 5, rule) for rule in ("original", "elementary", "haibach")),
    *(
        jo.fatigue.fat_class(71),
        jo.fatigue.fat_class(71, "en"),
        jo.SN(80e6, 2e6, 4, T_S=1.3).at_survival(0.977),
    ),
)


@pytest.mark.parametrize("mean", MEANS, ids=str)
def test_mean_stress_is_corrected_as_in_python(rng, mean):
    a, b = rng.uniform(-350e6, 350e6, (2, 500))
    a[:8] = [0, 100e6, -100e6, 100e6, 300e6, -300e6, 399e6, 200e6]  # on the borders of regimes
    b[:8] = [100e6, 0, 0, -100e6, 150e6, -100e6, 401e6, 100e6]
    m = jo.model.DamageMeter(CURVES[1], residue="half", mean=mean)
    found = [m._library.jo_cycle_amplitude(m.native, x, y) for x, y in zip(a, b, strict=True)]
    expected = 0.5 * np.abs(a - b)
    if mean is not None:
        expected = mean.equivalent(expected, 0.5 * (a + b))
    np.testing.assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.parametrize("sn", CURVES, ids=str)
def test_damage_is_that_of_the_curve(rng, sn):
    S_D, _, _, _, limit = sn.numbers
    S = np.concatenate([rng.uniform(0.0, 3.0 * S_D, 200), [0.0, S_D, limit, 0.999 * limit]])
    m = jo.model.DamageMeter(sn, residue="half")
    found = [m._library.jo_cycle_damage(m.native, -x, x) for x in S]
    np.testing.assert_allclose(found, [sn.damage(x) for x in S], rtol=1e-12)


@pytest.mark.parametrize("residue", ["half", "ignore", "repeat"])
def test_the_meter_and_the_offline_damage_are_one(rng, residue):
    x = 40e6 + 0.97 * np.cumsum(rng.normal(size=5000)) * 4e6
    sn, mean = jo.SN(100e6, 1e6, 5, "haibach"), jo.fatigue.FKM(0.3)
    m = jo.model.DamageMeter(sn, residue=residue, mean=mean)
    m.push(x)
    offline = jo.fatigue.damage(jo.fatigue.rainflow(x, residue=residue), sn, mean)
    assert m.damage()[0] == pytest.approx(offline, rel=1e-12)
    assert offline > 0.0


# -- a full memory --------------------------------------------------------------------------


@given(LOADS, st.integers(6, 9))
def test_a_full_memory_is_never_below_the_exact_count(loads, depth):
    x = np.array(loads)
    exact, small = meter(depth=512), meter(depth=depth)
    exact.push(x)
    small.push(x)
    for residue in ("half", "ignore", "repeat"):
        assert small.damage(residue)[0] >= exact.damage(residue)[0] * (1 - 1e-12)
    # where the memory was enough the count is exact, else it says so
    same = small.damage()[0] == pytest.approx(exact.damage()[0], rel=1e-12)
    assert same or small.forced[0] > 0
    assert (small.largest_forced[0] > 0.0) == (small.forced[0] > 0)


@pytest.mark.parametrize(("depth", "most"), [(8, 0.12), (16, 0.047), (32, 0.021), (64, 0.01)])
def test_a_decay_is_overstated_as_little_as_the_page_says(depth, most):
    for n in (100, 500, 2000):
        u = np.arange(n) / n
        for envelope in (1.0 - u, 0.01**u, 0.1**u):
            exact, small = meter(depth=2 * n), meter(depth=depth)
            for one in (exact, small):
                one.push(200e6 * envelope * (-1.0) ** np.arange(n))
            for residue in ("half", "repeat"):
                over = small.damage(residue)[0] / exact.damage(residue)[0] - 1.0
                # round-off of two sums of 2000 damages
                assert -1e-12 <= over <= most


def test_growing_vibrations_need_no_memory_and_shrinking_ones_are_told():
    n = 2000
    envelope = np.linspace(0.01, 1.0, n) * 200e6
    x = envelope * (-1.0) ** np.arange(n)
    exact, small = meter(depth=2 * n), meter(depth=16)
    exact.push(x)
    small.push(x)
    assert (small.shed[0], small.forced[0]) == (n - 16, 0)
    assert small.damage()[0] == pytest.approx(exact.damage()[0], rel=1e-12)
    exact.push(x[::-1])
    small.push(x[::-1])
    assert small.forced[0] > 900
    assert 1.0 <= small.damage()[0] / exact.damage()[0] < 1.005
    assert "closed by force" in str(small)


def test_classes_bound_the_memory():
    n, width = 4000, 10e6
    x = np.exp(-np.arange(n) / 1500) * 200e6 * (-1.0) ** np.arange(n)
    depth = int(2 * (x.max() - x.min()) / width) + 4
    m = meter(depth=depth, resolution=width)
    m.push(x)
    m.push(x[::-1])
    assert (m.forced[0], m.shed[0]) == (0, 0)
    exact = meter(depth=3 * n)
    exact.push(width * np.floor(np.concatenate([x, x[::-1]]) / width + 0.5))
    assert m.damage()[0] == pytest.approx(exact.damage()[0], rel=1e-12)


def test_small_cycles_are_not_lost_in_a_large_sum():
    m = meter()
    m.push([0.0, 2e9, -2e9, 2e9, 0.0])  # 3.2 per cycle
    before = m.damage("ignore")[0]
    small = np.tile([0.0, 10e6], 200_000)
    m.push(small)
    each = (5e6 / 100e6) ** 5 / 1e6
    assert m.cycles[0] > 199_990
    gained = m.damage("ignore")[0] - before
    assert gained == pytest.approx((m.cycles[0] - 1) * each, rel=1e-3)


def test_the_memory_of_another_curve_is_refused():
    x = 25e6 * ASTM
    first = jo.model.DamageMeter(jo.SN(100e6, 1e6, 5), residue="half", n=2)
    first.push(np.stack([x, 2 * x], axis=1))
    saved = first.save()
    for name, sn, options in (
        ("S-N curve", jo.SN(10e6, 1e6, 5), {}),
        ("S-N curve", jo.SN(100e6, 1e6, 5, "haibach"), {}),
        ("mean stress correction", jo.SN(100e6, 1e6, 5), {"mean": jo.fatigue.Goodman(400e6)}),
        ("resolution", jo.SN(100e6, 1e6, 5), {"resolution": 1e6}),
    ):
        other = jo.model.DamageMeter(sn, residue="half", n=2, **options)
        with pytest.raises(jo.InputError, match=f"row 0 of memory was counted with another {name}"):
            other.load(saved)
        assert not other.damage().any()  # nothing was taken
    # the same curve and another residue rule go on
    same = jo.model.DamageMeter(jo.SN(100e6, 1e6, 5), residue="ignore", n=2)
    same.load(saved)
    np.testing.assert_array_equal(same.damage("half"), first.damage())


# -- mistakes -------------------------------------------------------------------------------


def test_all_mistakes_at_once():
    with pytest.raises(jo.InputError) as error:
        jo.model.DamageMeter(3.0, residue="halves", mean="goodman", n=0, depth=3, resolution=-1.0)
    text = str(error.value)
    for part in (
        "sn is 3.0, must be an S-N curve",
        "mean is 'goodman', must be a mean stress correction",
        "residue is 'halves', must be one of",
        "did you mean 'half'",
        "depth is 3, must be a whole number of at least 6",
        "resolution is -1 Pa",
        "n is 0, must be a whole number of at least 1",
    ):
        assert part in text
    m = meter(n=3)
    with pytest.raises(jo.InputError, match=r"block is \(5, 2\), must be \(nt, 3\)"):
        m.push(np.zeros((5, 2)))
    with pytest.raises(jo.InputError, match="trace works with a single history"):
        m.trace([1.0, 2.0, 3.0])
    with pytest.raises(jo.InputError, match="residue is 'all'"):
        m.damage("all")
    with pytest.raises(jo.InputError, match="the same n and depth"):
        m.load(np.zeros((2, 4)))
    spoiled = m.save()
    spoiled[1, 0] = 7.5
    with pytest.raises(jo.InputError, match="row 1 of memory is not that of a meter"):
        m.load(spoiled)
    straight = meter(n=1)
    straight.push(np.array([[0.0], [3e8], [1.5e8]]))
    memory = straight.save()
    points = np.flatnonzero(memory[0] == 1.5e8)
    memory[0, points[-1]] = 4e8  # goes on where the one before ends: no turning point
    with pytest.raises(jo.InputError, match="row 0 of memory is not that of a meter"):
        straight.load(memory)
    with pytest.raises(jo.InputError, match="sample 1 is nan"):
        count_cycles([0.0, np.nan])
