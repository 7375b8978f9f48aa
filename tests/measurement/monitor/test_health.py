"""The states of channels, one kind of failure after the other."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.measurement.monitor.health import STATES, ChannelRules, Health
from jousto.measurement.monitor.stream import EMPTY, INFINITE, NOT_A_NUMBER
from jousto.model.native.health import FOLLOW, PERSIST, WARM

RULES = ChannelRules(range=1e-3, stuck=20, spike=40.0, back=5)
N = 400
OK, DROPOUT, NAN, SATURATED, STUCK, SPIKE, BACK = range(len(STATES))


def signal(n=N, nc=3):
    t = 0.01 * np.arange(n)
    rng = np.random.default_rng(3)
    e = 1e-4 * np.sin(5.0 * t[:, None] + np.arange(nc)) + 1e-6 * rng.normal(size=(n, nc))
    return t, e


def states(e, cells=None, rules=RULES, pieces=1):
    t = 0.01 * np.arange(len(e))
    health = Health([f"g{c + 1}" for c in range(e.shape[1])], rules)
    found, changes = [], []
    for part in np.array_split(np.arange(len(e)), pieces):
        c = None if cells is None else cells[part]
        one, changed = health.check(t[part], e[part], c)
        found.append(one)
        changes += changed
    return np.concatenate(found), changes


def names(column):
    return [STATES[k] for k in column]


def test_good_channels_are_ok():
    _, e = signal()
    found, changes = states(e)
    assert not found.any()
    assert changes == []


@pytest.mark.parametrize(("cell", "state"), [(EMPTY, "dropout"), (NOT_A_NUMBER, "nan")])
def test_missing_values(cell, state):
    _, e = signal()
    cells = np.zeros(e.shape, dtype=np.uint8)
    e[100:150, 1], cells[100:150, 1] = np.nan, cell
    found, changes = states(e, cells)
    assert set(names(found[100:150, 1])) == {state}
    assert names(found[150:156, 1]) == 5 * ["back"] + ["ok"]
    assert not found[:, [0, 2]].any()
    assert [(c.channel, c.before, c.after) for c in changes] == [
        ("g2", "ok", state),
        ("g2", state, "back"),
        ("g2", "back", "ok"),
    ]


def test_saturation():
    _, e = signal()
    e[200:210, 0] = 1e-3
    e[300, 0] = -np.inf
    found, _ = states(e)
    assert set(names(found[200:210, 0])) == {"saturated"}
    assert names(found[300:301, 0]) == ["saturated"]


def test_a_channel_that_freezes_is_stuck_but_not_a_machine_at_rest():
    _, e = signal()
    e[100:200, 2] = e[100, 2]
    found, _ = states(e)
    assert names(found[118:121, 2]) == ["ok", "ok", "stuck"]
    assert set(names(found[121:200, 2])) == {"stuck"}
    _, e = signal()
    e[100:200] = e[100]
    assert not states(e)[0][:200].any()


def test_a_wild_value_is_a_spike_and_a_step_is_none():
    _, e = signal()
    e[200, 1] += 9e-4
    e[300:, 0] += 5e-4  # a load that stays
    found, _ = states(e)
    assert names(found[199:203, 1]) == ["ok", "spike", "ok", "ok"]
    assert names(found[299:304, 0]) == ["ok", "spike", "spike", "ok", "ok"]
    assert not found[304:].any()


@pytest.mark.parametrize("pieces", [7, 400])
def test_blocks_make_no_difference(pieces):
    _, e = signal()
    e[50:90, 0], e[120, 1], e[200:300, 2] = np.nan, 5e-4, e[200, 2]
    whole, changes = states(e)
    parts, changed = states(e, pieces=pieces)
    np.testing.assert_array_equal(whole, parts)
    assert changes == changed


def test_memory_goes_on():
    _, e = signal()
    e[50:90, 0], e[150:300, 2] = np.nan, e[150, 2]
    whole, _ = states(e)
    t = 0.01 * np.arange(N)
    first, second = Health(("a", "b", "c"), RULES), Health(("a", "b", "c"), RULES)
    first.check(t[:160], e[:160])
    second.load(first.save())
    np.testing.assert_array_equal(second.check(t[160:], e[160:])[0], whole[160:])


def test_bad_rules_are_told():
    with pytest.raises(jo.InputError) as error:
        ChannelRules(range=0.0, stuck=-1, spike=np.nan, back=1.5)
    assert len(error.value.problems) == 4


def test_a_range_that_no_gauge_has_is_told():
    """Beyond it the twins refuse values as no strains, which would end a watch."""
    with pytest.raises(jo.InputError, match="must be at most 0.01"):
        ChannelRules(range=0.05)


class Plain:
    """The rules of a channel in plain NumPy, all channels of a sample at once."""

    def __init__(self, n, rules):
        self.rules, self.state = rules, np.zeros(n, dtype=np.uint8)
        self._last, self._good = np.full(n, np.nan), np.full(n, np.nan)
        for name in ("_usual", "_seen", "_same", "_moves", "_level", "_well"):
            setattr(self, name, np.zeros(n))

    def sample(self, x, cells):
        rules = self.rules
        there = np.isfinite(x)
        state = np.zeros(len(x), dtype=np.uint8)
        state[~there] = NAN
        state[cells == EMPTY] = DROPOUT
        wide = (cells == INFINITE) | (there & (np.abs(x) >= rules.range))
        state[wide] = SATURATED

        # stuck: the same to the last digit while the others move on
        same = there & (x == self._last)
        moved = there & ~same & np.isfinite(self._last)
        others = moved.sum() > 0
        self._same = np.where(same, self._same + 1.0, 0.0)
        self._moves = np.where(same, self._moves + (1.0 if others else 0.0), 0.0)
        if rules.stuck:
            state[(state == OK) & (self._moves >= rules.stuck)] = STUCK

        # spike: a jump far beyond the usual steps, until a few samples stay there
        step = np.abs(x - self._good)
        if rules.spike:
            known = (self._seen >= WARM) & np.isfinite(step)
            limit = rules.spike * np.maximum(self._usual, 1e-12)
            jump = known & (state == OK) & (step > limit)
            near = np.isfinite(self._last) & (np.abs(x - self._last) <= limit)
            self._level = np.where(jump, np.where(near, self._level + 1.0, 1.0), 0.0)
            state[jump & (self._level < PERSIST)] = SPIKE
        good = state == OK
        usual = good & np.isfinite(step)
        rate = np.maximum(FOLLOW, 1.0 / (1.0 + self._seen))
        # a believed jump must not make the next one look usual
        capped = np.where(self._seen >= WARM, np.minimum(step, 4.0 * self._usual + 1e-12), step)
        self._usual = np.where(usual, self._usual + rate * (capped - self._usual), self._usual)
        self._seen = np.where(usual, self._seen + 1.0, self._seen)
        self._good = np.where(good, x, self._good)
        self._last = np.where(there, x, np.nan)

        # what failed must be well for some samples before it is believed again
        self._well = np.where(good, self._well + 1.0, 0.0)
        failed = self.state != OK
        brief = self.state == SPIKE  # one wild value says nothing of the next
        state[good & failed & ~brief & (self._well <= rules.back)] = BACK
        return state


def test_the_engine_follows_the_rules_as_they_stand():
    rng = np.random.default_rng(8)
    for rules in (
        RULES,
        ChannelRules(range=1e-3, stuck=0, spike=0.0, back=0),
        ChannelRules(range=5e-4, stuck=3, spike=8.0, back=2),
    ):
        _, e = signal(1500, 4)
        e += np.cumsum(rng.normal(size=e.shape), axis=0) * 2e-6
        cells = np.zeros(e.shape, dtype=np.uint8)
        for k in rng.integers(100, 1450, 60):  # faults of every kind and length
            c, long, kind = rng.integers(4), int(rng.integers(1, 40)), rng.integers(6)
            rows = slice(k, k + long)
            if kind == 0:
                e[rows, c] = np.nan
                cells[rows, c] = rng.choice([EMPTY, NOT_A_NUMBER])
            elif kind == 1:
                e[k, c], cells[k, c] = np.inf, INFINITE
            elif kind == 2:
                e[rows, c] = e[k, c]
            elif kind == 3:
                e[k, c] += rng.normal() * 3e-3
            elif kind == 4:
                e[k:, c] += rng.normal() * 3e-4
            else:
                e[rows, c] += 2e-3
        plain, health = Plain(4, rules), Health(["a", "b", "c", "d"], rules)
        found, changes = health.check(0.01 * np.arange(len(e)), e, cells)
        told = 0
        for k, (x, cell) in enumerate(zip(e, cells, strict=True)):
            before = plain.state
            plain.state = plain.sample(x, cell)
            assert plain.state.tolist() == found[k].tolist(), k
            told += int(np.count_nonzero(plain.state != before))
        assert told == len(changes) > 50
        again = Health(["a", "b", "c", "d"], rules)
        again.load(health.save())
        np.testing.assert_array_equal(again.save(), health.save())
