"""The states of channels, one kind of failure after the other."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.recovery.monitor import STATES, ChannelRules, Health
from jousto.recovery.monitor.stream import EMPTY, NOT_A_NUMBER

RULES = ChannelRules(range=1e-3, stuck=20, spike=40.0, back=5)
N = 400


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
