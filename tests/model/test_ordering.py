"""Elimination order: a factor of the right pattern, no fill where none is needed."""

from __future__ import annotations

import cProfile
import pstats

import numpy as np
import pytest
from hypothesis import given, strategies as st

import jousto as jo
from jousto.model import elimination_order
from jousto.model.elimination_order import eliminate


def factor_pattern(count, cliques):
    """Pattern of the Cholesky factor of a random matrix with these cliques, and the order."""
    plan = eliminate([1] * count, cliques)
    rng = np.random.default_rng(0)
    S = np.zeros((count, count))
    for clique in cliques:
        x = rng.normal(size=(len(clique), 3))
        S[np.ix_(clique, clique)] += x @ x.T
    S += 10.0 * np.eye(count)
    order = list(plan.order)
    L = np.linalg.cholesky(S[np.ix_(order, order)])
    return plan, S, order, np.abs(L) > 1e-14


@given(st.data())
def test_the_planned_blocks_hold_the_numeric_factor(data):
    count = data.draw(st.integers(1, 9))
    joints = st.lists(st.integers(0, count - 1), min_size=1, max_size=4, unique=True)
    cliques = data.draw(st.lists(joints, max_size=12))
    plan, _, order, nonzero = factor_pattern(count, cliques)
    planned = {(order.index(i), order.index(j)) for i, j in plan.blocks}
    assert sorted(plan.order) == list(range(count))
    assert {(i, j) for i, j in np.argwhere(nonzero).tolist()} <= planned


@given(st.integers(2, 30), st.integers(0, 2**32 - 1))
def test_trees_have_no_fill(bodies, seed):
    """Joint k holds body k on an earlier body or the ground; the joints of a body touch."""
    rng = np.random.default_rng(seed)
    on_body = {k: [k] for k in range(bodies)}
    for k in range(1, bodies):
        on_body[int(rng.integers(0, k))].append(k)
    assert eliminate([3] * bodies, on_body.values()).fill == 0


@pytest.mark.parametrize("count", [3, 4, 10])
def test_a_ring_fills_one_block_for_every_joint_beyond_three(count):
    ring = [(k, (k + 1) % count) for k in range(count)]
    assert eliminate([3] * count, ring).fill == count - 3


def test_update_rows_are_those_of_the_joints():
    plan = eliminate([3, 5, 6], [(0, 1), (0, 2), (1, 2)])
    rows = {plan.blocks[i, j]: [3, 5, 6][i] for i, j in plan.blocks}
    assert any(plan.updates)
    for column in plan.updates:
        for _, left, right, left_rows, right_rows in column:
            assert (left_rows, right_rows) == (rows[left], rows[right])


def test_a_thousand_joints_are_ordered_quickly():
    chain = [(k, k + 1) for k in range(999)]
    assert eliminate([3] * 1000, chain).count == 1999


def test_a_chain_is_eliminated_from_both_ends() -> None:
    """Two sequences of half the length that do not wait for each other."""
    count = 11
    found = eliminate([3] * count, [(k, k + 1) for k in range(count - 1)])
    depth = dict.fromkeys(range(count), 1)
    for joint, column in zip(found.order, found.below, strict=True):
        for _, later in column:
            depth[later] = max(depth[later], depth[joint] + 1)
    assert max(depth.values()) == (count + 1) // 2
    # and in turn, so that both are under way at the same time
    assert found.order[:4] == (0, 10, 1, 9)


def test_a_long_chain_is_eliminated_from_the_ground_to_its_free_end() -> None:
    count = elimination_order.LONG + 2
    bodies = [(k, k + 1) for k in range(count - 1)]
    for free in (count - 1, 0):
        assert eliminate([5] * count, [*bodies, (free,)]).order[-1] == free


# -- what is too dense ----------------------------------------------------------------------


def test_a_flexible_body_with_too_many_joints_is_refused_before_memory_is_full():
    """Its joints act on one another through its modes, too; those of a rigid one need not."""
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 2, jo.Material(E=2.1e11, nu=0.3, rho=7850))
    middle = jo.FlexibleBody("middle", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=1)))
    wheels = [jo.RigidBody(f"w{i}", 1.0, (1, 1, 1)) for i in range(600)]
    joints = [jo.Revolute(f"j{w.name}", middle["start"], w["origin"], (0, 0, 1)) for w in wheels]
    with pytest.raises(jo.InputError, match="body 'middle': has 600 joints.*divide it"):
        jo.compile(jo.Mechanism(middle, *wheels, *joints))


def test_too_many_loops_are_refused():
    """A grid of n x n joints has about n^3 products; here the limit is low instead of n high."""
    n = 12
    grid = [(i * n + j, i * n + j + 1) for i in range(n) for j in range(n - 1)]
    grid += [(i * n + j, i * n + j + n) for i in range(n - 1) for j in range(n)]
    with pytest.raises(elimination_order.TooDense) as found:
        elimination_order.eliminate([3] * n * n, grid, most=200)
    assert found.value.clique == ()
    assert (
        elimination_order.eliminate([3] * 150, [(i, i + 1) for i in range(149)], most=200).fill == 0
    )


def net(side: int) -> tuple[int, list[list[int]]]:
    """Return the joints and cliques of a square net of bodies, each joined to its neighbours."""
    on_body: dict[tuple[int, int], list[int]] = {}
    count = 0
    for i, j in np.ndindex(side, side):
        for other in ((i - 1, j), (i, j - 1)):
            if min(other) >= 0:
                for body in ((i, j), other):
                    on_body.setdefault(body, []).append(count)
                count += 1
    return count, list(on_body.values())


def test_ordering_a_net_takes_no_more_work_than_its_factor(monkeypatch) -> None:
    """Calls are some 2.5 for each product of blocks; exact counts of the fill need 7 and rising.

    The bound in their place leaves some 5 % more blocks; 10 % are allowed.
    """
    count, cliques = net(24)
    assert count > elimination_order.LONG
    profile = cProfile.Profile()
    found = profile.runcall(eliminate, [3] * count, cliques)
    calls = sum(each[1] for each in pstats.Stats(profile).stats.values())
    assert calls < 3 * sum(len(column) for column in found.updates)
    monkeypatch.setattr(elimination_order, "LONG", count)
    assert found.count < 1.1 * eliminate([3] * count, cliques).count
