"""Tables of places: the largest value first, and a rule for what round-off would decide."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.recovery.ranking import ranking

LABELS = ("e10.a.left", "e2.b.top", "e2.a.top", "e1.b.left")


def test_distinct_values_fall() -> None:
    assert ranking([1.0, 4.0, -2.0, 1.1], LABELS).tolist() == [1, 3, 0, 2]
    assert ranking([], ()).tolist() == []


@pytest.mark.parametrize("size", [1e-30, 1.0, 3e8])
def test_round_off_does_not_order_equal_places(size: float, rng: np.random.Generator) -> None:
    # element 2 before element 10, as they are numbered
    for _ in range(20):
        values = size * (1.0 + 1e-14 * rng.standard_normal(4))
        assert ranking(values, LABELS).tolist() == [3, 2, 1, 0]
    # a difference that is more than round-off counts
    assert ranking(size * np.array([1.0, 1.0, 1.0, 1.0 - 1e-8]), LABELS).tolist() == [2, 1, 0, 3]


def test_what_is_equal_to_round_off_is_ranked_by_the_second_value() -> None:
    values, then = [0.0, 0.0, 0.0, 1.0], [-2.0, -1.0, -1.0 - 1e-14, -9.0]
    assert ranking(values, LABELS, then=then).tolist() == [3, 2, 1, 0]


def test_what_is_no_number_is_last() -> None:
    assert ranking([np.nan, np.inf, 2.0, np.inf], LABELS).tolist() == [3, 1, 2, 0]
    assert ranking([-np.inf, 2.0, -np.inf, np.inf], LABELS).tolist() == [3, 1, 2, 0]


def test_tables_of_damage_follow_the_rule() -> None:
    # three places alike but for round-off, which the first two have on the wrong side
    t = np.linspace(0.0, 20.0 * np.pi, 801)
    s = np.zeros((4, 801, 6))
    s[:, :, 0] = 2e8 * np.sin(t) * np.array([1.0 + 4e-15, 1.0 + 2e-15, 1.0, 1.2])[:, None]
    found = jo.plane_damage(s, jo.NormalStress(), jo.SN(S_D=1e8, N_D=1e6, k=5), residue="repeat")
    assert [line.split()[0] for line in found.table().splitlines()[2:]] == ["3", "0", "1", "2"]
    reverse = jo.plane_damage(
        s[::-1], jo.NormalStress(), jo.SN(S_D=1e8, N_D=1e6, k=5), residue="repeat"
    )
    assert [line.split()[0] for line in reverse.table().splitlines()[2:]] == ["0", "1", "2", "3"]
