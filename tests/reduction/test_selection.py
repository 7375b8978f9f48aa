"""Reduced parts: choice of modes, nodes, and their checks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from jousto.base.errors import InputError
from jousto.reduction.methods import CraigBampton
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.reducer import reduce
from reduction.bodies import (
    bent,
)


def test_keep() -> None:
    r = reduce(bent(), CraigBampton(("start", "end"), modes=3))
    kept = r.keep([4, 1])
    assert isinstance(kept, ReducedPart)
    assert np.array_equal(kept.frequencies, r.frequencies[[4, 1]])
    assert np.array_equal(kept.modes, r.modes[:, :, [4, 1]])
    assert np.array_equal(kept.invariants.E[0, 1], r.invariants.E[4, 1])
    assert np.array_equal(kept.invariants.I4, r.invariants.I4[:, [4, 1]])
    assert kept.invariants.mass == r.invariants.mass
    mask = r.frequencies < r.frequencies[3]
    assert r.keep(mask).n == 3
    for bad, message in (
        ([], "one mode"),
        ([9], r"modes 0\.\.8, not \[9\]"),
        ([-1], "not"),
        ([1, 1], "more than once"),
        ([0.5], "whole numbers"),
    ):
        with pytest.raises(InputError, match=message):
            r.keep(bad)  # type: ignore[arg-type]


def test_node() -> None:
    r = reduce(bent(), CraigBampton(("start",), modes=1))
    assert (r.node("start"), r.node("node3"), r.node("end")) == (0, 2, len(r.nodes) - 1)
    with pytest.raises(InputError, match="no node 'ende'; did you mean 'end'"):
        r.node("ende")
    with pytest.raises(InputError, match="has 2 nodes"):
        r.node("both")


def test_arrays_cannot_be_changed() -> None:
    r = reduce(bent(), CraigBampton(("start",), modes=2))
    for array in (r.modes, r.rotations, r.frequencies, r.invariants.E, r.nodes, r.elements):
        assert array is not None
        with pytest.raises(ValueError, match="read-only"):
            array.flat[0] = 1


def test_reduced_part_checks_its_arrays() -> None:
    r = reduce(bent(), CraigBampton(("start",), modes=2))
    with pytest.raises(InputError) as error:
        replace(
            r, modes=r.modes[:, :, :1], frequencies=[1.0, np.nan], interfaces=("strt",),
            elements=[[0, 99]],
        )  # fmt: skip
    text = str(error.value)
    for part in ("frequencies[1] is nan", "elements refer to nodes outside", "interface 'strt'"):
        assert part in text
