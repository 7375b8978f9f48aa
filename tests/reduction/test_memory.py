"""The memory of a reduction is told before it starts, and too much is refused."""

from __future__ import annotations

import logging
import tracemalloc
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from jousto.base.errors import InputError, JoustoWarning
from jousto.parts.interface import Interface
from jousto.reduction.methods import CraigBampton, FreeFree
from jousto.reduction.reducer import reduce
from jousto.reduction.sparse import backends, memory
from jousto.reduction.sparse.memory import GiB, MiB, memory_estimate
from reduction.blocks import block

METHOD = CraigBampton(("left", "right"), modes=4)


def test_the_factor_is_estimated_for_a_bulky_part() -> None:
    """A cube is the bulkiest: PARDISO counts what it needs before it computes."""
    pytest.importorskip("pypardiso")
    part = block((16, 16, 16), (1.0, 1.0, 1.0))
    free = np.arange(60, part.K.shape[0])
    counted = backends.Pardiso(sp.csr_array(part.K[free][:, free])).memory
    estimate = memory_estimate(part, METHOD, solver="pardiso")
    assert 0.4 < estimate.factor / counted < 2.5
    assert estimate.least < estimate.total
    assert estimate.total > estimate.factor + 12 * (part.K.nnz + part.M.nnz)


def test_the_whole_is_what_the_link_arm_took() -> None:
    """281,202 unknowns, 20.8 million entries of K, 20 modes: a peak of 3334 MiB with PARDISO."""
    part: Any = block((2, 1, 1))
    n, entries = 281_202, 20_840_076

    class Matrix:
        def __init__(self, nnz: int) -> None:
            self.shape, self.nnz = (n, n), nnz

    class Arm:
        name, K, M = "arm", Matrix(entries), Matrix(entries // 3)
        ties, stress, node_sets, dofs_per_node = (), None, {"a": (1, 2), "b": (3, 4)}, 3

    part = Arm()
    estimate = memory_estimate(part, CraigBampton(("a", "b"), modes=20), solver="superlu")
    like_pardiso = estimate.total - estimate.factor * (1.0 - 120.0 / 300.0)
    # what is told before must suffice, and not frighten
    assert 3334 * MiB < like_pardiso < 1.25 * 3334 * MiB


def test_the_estimate_is_said(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, logger="jousto"):
        reduce(block((4, 1, 1)), METHOD)
    assert "part 'block': 60 unknowns, 28 modes: up to about" in caplog.text
    assert "factorisation by superlu" in caplog.text


def test_too_large_for_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    part = block((4, 1, 1))
    need = memory_estimate(part, FreeFree(modes=3))
    monkeypatch.setattr(memory, "machine_memory", lambda: 0.999 * need.least)
    with pytest.raises(
        InputError, match="part 'block': .* 60 unknowns to 3 modes needs at least .* coarser"
    ):
        reduce(part, FreeFree(modes=3))
    between = 0.5 * (need.least + need.total)
    monkeypatch.setattr(memory, "machine_memory", lambda: between)
    with pytest.warns(JoustoWarning, match="needs up to about .* this machine has"):
        assert reduce(part, FreeFree(modes=3)).n == 3


def test_pardiso_counts_before_it_factorises(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pypardiso")
    from jousto.reduction import stages

    monkeypatch.setattr(stages, "machine_memory", lambda: 100.0)
    with pytest.raises(InputError, match="pardiso could not factorise.*it needs .* GiB"):
        reduce(block((6, 2, 2)), METHOD, solver="pardiso")


def test_the_machine_has_memory() -> None:
    assert 0.1 * GiB < memory.machine_memory() < 1e6 * GiB
    text = str(replace(memory_estimate(block((2, 1, 1)), METHOD), machine=8.0 * GiB))
    assert "of 8.0 GiB" in text


def test_node_sets_and_residuals_count() -> None:
    """Every node of a set adds its motions, an interface six, a load one, a stress site six."""
    part = block((6, 2, 2))
    assert memory_estimate(part, METHOD).modes == 4 + 2 * 9 * 3
    load = np.ones((part.K.shape[0], 2))
    method = CraigBampton(("left",), modes=4, residuals=(load, "n1"), inertia_relief=True)
    assert memory_estimate(part, method).modes == 4 + 27 + 2 + 6 + 6
    assert memory_estimate(part, FreeFree(modes=3, interfaces=("left",))).modes == 3 + 27
    tied = part.with_interfaces(Interface("a", "left"), Interface("b", "right", kind="average"))
    # none named: all
    assert memory_estimate(tied, CraigBampton(modes=4)).modes == 4 + 12
    assert memory_estimate(tied, FreeFree(modes=4)).modes == 4


def test_a_wide_node_set_is_estimated() -> None:
    """What numpy holds at the most while 98 nodes of 539 are interfaces."""
    part = block((10, 6, 6))
    wide = tuple(int(i) for i in np.flatnonzero(part.nodes[:, 0] < 0.15))
    part = replace(part, node_sets={"wide": wide}, elements=np.zeros((0, 2), dtype=np.int64))
    method = CraigBampton(("wide",), modes=2)
    tracemalloc.start()
    made = reduce(part, method, cache=False)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert made.n == 3 * len(wide) + 2 - 6
    estimate = memory_estimate(part, method)
    dense = estimate.least - memory_estimate(part, FreeFree(modes=2)).least
    assert 0.6 < dense / peak < 1.5
    assert memory_estimate(part, method, stiffening=True).total > 10 * estimate.total


def test_a_wide_node_set_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    part = block((16, 8, 8))
    method = CraigBampton(("left", "right"), modes=2)
    need = memory_estimate(part, method)
    monkeypatch.setattr(memory, "machine_memory", lambda: 0.999 * need.least)
    with pytest.raises(InputError, match=r"to 488 modes needs .* Interface\(name, nodes\) has 6"):
        reduce(part, method)


def test_large_parts_show_their_stages_where_they_are_seen(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from jousto.reduction import reducer

    part = block((4, 1, 1))
    monkeypatch.setattr(reducer, "AUTOMATIC", part.K.shape[0])
    reduce(part, METHOD)
    assert capsys.readouterr().err == ""  # no terminal
    monkeypatch.setattr("sys.stderr.isatty", lambda: True, raising=False)
    reduce(part, METHOD)
    shown = capsys.readouterr().err
    assert "factorisation" in shown and "invariants" in shown
    reduce(part, METHOD, progress=False)
    monkeypatch.setattr(reducer, "AUTOMATIC", part.K.shape[0] + 1)
    reduce(part, METHOD)
    assert capsys.readouterr().err == ""
