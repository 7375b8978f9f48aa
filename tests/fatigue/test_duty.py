"""Duty cycles against the rainflow count of the whole history."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from jousto import SN, InputError
from jousto.fatigue import DutyCycle, DutyEvent, damage, rainflow


def spectrum(cycles):
    out = Counter()
    for r, m, c in zip(cycles.range, cycles.mean, cycles.count, strict=True):
        out[float(r), float(m)] += float(c)
    return dict(out)


events = st.lists(
    st.tuples(st.lists(st.integers(-6, 6), min_size=2, max_size=10), st.integers(1, 6)),
    min_size=1,
    max_size=4,
)


@settings(max_examples=150, deadline=None)
@given(events, st.sampled_from(["half", "repeat", "ignore"]))
def test_sequence_is_the_count_of_the_whole_history(events, rule):
    duty = DutyCycle(events, transitions="sequence")
    whole = [x for history, n in events for x in history * n]
    assert spectrum(duty.cycles(residue=rule)) == spectrum(rainflow(whole, residue=rule))


def test_a_million_repeats_cost_no_more():
    duty = DutyCycle(
        [([0, 50e6, 10e6, 80e6, 0], 1_000_000), ([0, -90e6, 0], 3)], transitions="sequence"
    )
    counted = duty.cycles(residue="repeat").sums()
    assert counted == {40e6: 1e6, 80e6: 999_999.0, 90e6: 2.0, 170e6: 1.0}


def test_separate_adds_what_each_event_does():
    a, b = [0, 80e6, 0], [0, -60e6, 20e6, -60e6, 0]
    duty = DutyCycle([(a, 1000, "lift"), (b, 2.5, "stop")], transitions="separate")
    curve = SN(S_D=100e6, N_D=1e6, k=5)
    for rule in ("half", "repeat"):
        alone = 1000 * damage(rainflow(a, residue=rule), curve)
        alone += 2.5 * damage(rainflow(b, residue=rule), curve)
        assert damage(duty.cycles(residue=rule), curve) == pytest.approx(alone)


def test_worst_pairs_peaks_and_valleys():
    # by hand: peaks 80 (1000), 40 (200), 0 (20); valleys -60 (10), -20 (100), 0 (2000)
    duty = DutyCycle(
        [([0, 80, 0], 1000), ([0, -60, 0], 10), ([40, -20, 40], 100)], transitions="worst"
    )
    assert duty.cycles(residue="repeat").sums() == {40: 200.0, 80: 890.0, 100: 100.0, 140: 10.0}


@settings(max_examples=40, deadline=None)
@given(events)
def test_worst_is_no_better_than_any_order(events):
    curve = SN(S_D=1e6, N_D=1e6, k=5)
    scaled = [(1e6 * np.array(h, dtype=float), n) for h, n in events]
    worst = damage(DutyCycle(scaled, transitions="worst").cycles(residue="repeat"), curve)
    for order in (scaled, scaled[::-1]):
        some = DutyCycle(order, transitions="sequence").cycles(residue="repeat")
        assert damage(some, curve) <= worst * (1 + 1e-12)


def test_duration():
    duty = DutyCycle(
        [DutyEvent([0, 1, 0], 10, "a", duration=60.0), DutyEvent([0, 2, 0], 2, "b", duration=5.0)],
        transitions="separate",
    )
    assert duty.duration == 610.0
    assert "a: 10 times 60 s" in str(duty)


def test_mistakes():
    with pytest.raises(InputError, match='transitions is missing: give "separate"'):
        DutyCycle([([0, 1, 0], 1), ([0, 2, 0], 1)])
    with pytest.raises(InputError, match="has no events"):
        DutyCycle([])
    with pytest.raises(InputError, match="repeats is -3"):
        DutyCycle([([0, 1, 0], -3)])
    with pytest.raises(InputError, match="needs whole numbers"):
        DutyCycle([([0, 1, 0], 2.5), ([0, 2, 0], 1)], transitions="sequence")
    with pytest.raises(InputError, match="did you mean 'worst'"):
        DutyCycle([([0, 1, 0], 2), ([0, 2, 0], 1)], transitions="worse")
    worst = DutyCycle([([0, 1, 0], 2), ([0, 2, 0], 1)], transitions="worst")
    with pytest.raises(InputError, match='needs residue="repeat"'):
        worst.cycles(residue="half")
    with pytest.raises(InputError, match="residue is missing"):
        worst.cycles()
