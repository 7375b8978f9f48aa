"""The memory of a reduction is told before it starts, and too much is refused."""

from __future__ import annotations

import logging
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

from jousto.errors import InputError, JoustoWarning
from jousto.reduction import CraigBampton, FreeFree, backends, memory, memory_estimate, reduce
from jousto.reduction.memory import GiB, MiB
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

    part = Arm()
    estimate = memory_estimate(part, CraigBampton(("a", "b"), modes=20), solver="superlu")
    like_pardiso = estimate.total - estimate.factor * (1.0 - 120.0 / 300.0)
    assert like_pardiso == pytest.approx(3334 * MiB, rel=0.25)


def test_the_estimate_is_said(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, logger="jousto"):
        reduce(block((4, 1, 1)), METHOD)
    assert "part 'block': 60 unknowns: up to about" in caplog.text
    assert "factorisation by superlu" in caplog.text


def test_too_large_for_the_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    part = block((4, 1, 1))
    need = memory_estimate(part, FreeFree(modes=3))
    monkeypatch.setattr(memory, "machine_memory", lambda: 0.999 * need.least)
    with pytest.raises(InputError, match="part 'block': .* 60 unknowns needs at least .* coarser"):
        reduce(part, FreeFree(modes=3))
    between = 0.5 * (need.least + need.total)
    monkeypatch.setattr(memory, "machine_memory", lambda: between)
    with pytest.warns(JoustoWarning, match="needs up to about .* this machine has"):
        assert reduce(part, FreeFree(modes=3)).n == 3


def test_pardiso_counts_before_it_factorises(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pypardiso")
    from jousto.reduction import run

    monkeypatch.setattr(run, "machine_memory", lambda: 100.0)
    with pytest.raises(InputError, match="pardiso could not factorise.*it needs .* GiB"):
        reduce(block((6, 2, 2)), METHOD, solver="pardiso")


def test_the_machine_has_memory() -> None:
    assert 0.1 * GiB < memory.machine_memory() < 1e6 * GiB
    text = str(replace(memory_estimate(block((2, 1, 1)), METHOD), machine=8.0 * GiB))
    assert "of 8.0 GiB" in text
