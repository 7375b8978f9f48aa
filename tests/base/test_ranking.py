"""Tables of places: the largest value first, and a rule for what round-off would decide."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.base.ranking import largest, ranking
from jousto.recovery.fields.build import field_from
from jousto.reduction.fields.stress import StressModes

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


@pytest.mark.parametrize("criterion", ["von-mises", "s11"])
def test_hot_spots_of_symmetric_places(criterion: str, rng: np.random.Generator) -> None:
    """Eight places alike but for round-off, one of them smaller: told in the order of labels."""
    labels = [f"e{k}.a.top" for k in (11, 2, 1, 9, 10, 3, 8, 5)]
    p = rng.standard_normal((60, 3))
    one = rng.standard_normal((1, 6, 3))
    for _ in range(4):
        S = 1e6 * one * (1.0 + 2e-15 * rng.standard_normal((8, 6, 3)))
        S[2] *= 0.5
        modes = StressModes(tuple(labels), np.zeros((8, 3)), np.tile(np.eye(3), (8, 1, 1)), S)
        found = jo.hot_spots(field_from(modes, p, np.arange(60.0)), count=4, criterion=criterion)
        assert [spot.site for spot in found] == [f"e{k}.a.top" for k in (2, 3, 5, 8)]
        assert found.certified


def test_planes_that_are_equally_bad(rng: np.random.Generator) -> None:
    """Tension and torsion in phase: two planes, as one sees with the principal axis as mirror."""
    t = np.linspace(0.0, 2.0 * np.pi, 361)
    k = 0.3
    # both lie half of atan(1/k) beside the principal axis
    principal, aside = 0.5 * np.arctan2(2 * 5e7, 1e8), 0.5 * np.arctan2(1.0, k)
    angles = [principal - aside, principal + aside]
    nearest = max(angles, key=lambda a: abs(np.cos(a)))
    for _ in range(6):
        s = np.zeros((361, 6))
        s[:, 0], s[:, 3] = 1e8 * np.sin(t), 5e7 * np.sin(t)
        # the last bits decide which of them a search finds larger
        s *= 1.0 + 1e-15 * rng.standard_normal((361, 6))
        n = jo.fatigue.critical_plane(s, jo.fatigue.Findley(k)).normal
        assert abs(n @ [np.cos(nearest), np.sin(nearest), 0]) == pytest.approx(1, abs=1e-6)


def test_tables_of_damage_follow_the_rule() -> None:
    # three places alike but for round-off, which the first two have on the wrong side
    t = np.linspace(0.0, 20.0 * np.pi, 801)
    s = np.zeros((4, 801, 6))
    s[:, :, 0] = 2e8 * np.sin(t) * np.array([1.0 + 4e-15, 1.0 + 2e-15, 1.0, 1.2])[:, None]
    found = jo.fatigue.plane_damage(
        s, jo.fatigue.NormalStress(), jo.SN(S_D=1e8, N_D=1e6, k=5), residue="repeat"
    )
    assert [line.split()[0] for line in found.table().splitlines()[3:]] == ["3", "0", "1", "2"]
    reverse = jo.fatigue.plane_damage(
        s[::-1], jo.fatigue.NormalStress(), jo.SN(S_D=1e8, N_D=1e6, k=5), residue="repeat"
    )
    assert [line.split()[0] for line in reverse.table().splitlines()[3:]] == ["0", "1", "2", "3"]


def test_the_first_of_equal_values_is_the_largest() -> None:
    values = [1.0, 3.0, 3.0 + 1e-14, 2.0, np.nan]
    assert largest(values) == 1
    assert largest(values, ("a", "p10", "p9", "b", "c")) == 2
    assert largest([-3.0 - 1e-14, -3.0, -4.0]) == 0
    assert largest([0.0, np.inf, np.inf]) == 1
    assert ranking(values).tolist() == [1, 2, 3, 0, 4]


@pytest.mark.parametrize("nudge", [-1e-14, 0.0, 1e-14])
def test_the_nearest_of_nodes_equally_far_are_the_first(nudge: float) -> None:
    corners = np.array([[1.0, 0, 0], [0, 1.0 + nudge, 0], [0.2, 0, 0], [0, 0, 1.0 - nudge]])
    assert jo.mesh.Nearest((0, 0, 0), count=2).of(corners).tolist() == [0, 2]
    assert jo.mesh.Nearest((0, 0, 0), count=9).of(corners).tolist() == [0, 1, 2, 3]


@pytest.mark.parametrize("nudge", [-1e-14, 0.0, 1e-14])
def test_gauges_that_help_as_much_are_chosen_by_their_names(nudge: float) -> None:
    """Two modes, each seen by two gauges alike but for round-off."""
    rows = np.array([[1.0, 0.0], [1.0 + nudge, 0.0], [0.0, 1.0], [0.0, 1.0 - nudge]])
    found = jo.twin.place_gauges(rows, 2, names=("g10", "g9", "g2", "g1"), noise=1e-6)
    assert sorted(found.names) == ["g1", "g9"]


@pytest.mark.parametrize("nudge", [-1e-14, 0.0, 1e-14])
def test_bodies_that_move_as_much_are_told_by_their_names(nudge: float) -> None:
    from jousto.cli.terminal import most_at

    shape = {
        "leg2": np.array([0.0, 1.0 + nudge]),
        "leg1": np.array([-1.0, 0.0]),
        "top": np.zeros(2),
    }
    assert most_at(shape) == "leg1"
