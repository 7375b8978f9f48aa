"""Several starts, active instants, and limits that no design keeps."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.design import DisplacementLimit, StressLimit, StructureProblem, optimise


def valley(start):
    """A bar whose cost has two minima: near h = 2 (cost 1) and h = 8 (cost 0.5)."""
    return StructureProblem(
        [jo.Parameter("h", start, bounds=(0.5, 10.0))],
        lambda v: (None, [[v["h"]]]),
        lambda t: np.full((1, len(t)), 1.0),
        [0.0, 1.0],
        lambda v: min(1.0 + (v["h"] - 2.0) ** 2, 0.5 + (v["h"] - 8.0) ** 2),
        [DisplacementLimit("structure", 1.5, "1")],
    )


@pytest.mark.parametrize("method", ["esl", "direct"])
def test_several_starts_find_the_better_optimum(method):
    one = optimise(valley(1.0), method)
    assert one.cost == pytest.approx(1.0, abs=1e-6) and one.converged
    found = optimise(valley(1.0), method, starts=6, seed=2)
    assert found.cost == pytest.approx(0.5, abs=1e-6) and found.converged
    assert found.values["h"] == pytest.approx(8.0, abs=1e-3)
    assert "best of 6 starts" in found.message and "costs from 0.5 to 1" in found.message
    assert len(found.others) == 5
    again = optimise(valley(1.0), method, starts=6, seed=2)
    assert again.values == found.values
    with pytest.raises(jo.InputError, match="starts is 0"):
        optimise(valley(1.0), starts=0)


def bar(limits, force=10e3, stress=lambda v: {"bar": [210e9]}, bounds=(1e-5, 1e-2)):
    """A bar of 1 m in steel: stress F / A, displacement F L / E A."""
    return StructureProblem(
        [jo.Parameter("A", min(1e-3, bounds[1]), bounds=bounds, unit="m^2")],
        lambda v: (None, [[210e9 * v["A"]]]),
        lambda t: np.full((1, len(t)), force),
        [0.0, 1.0],
        lambda v: 7850.0 * v["A"],
        limits,
        stress=stress,
    )


def test_the_number_of_active_instants_stands_beside_the_residual():
    found = optimise(bar([StressLimit("structure", 100e6, criterion="s11")]))
    assert found.instants in (1, 2)  # of the two instants, which are alike
    assert f"with {found.instants} active instant" in repr(found)
    assert "and 1 parameter" in str(found)


@pytest.mark.parametrize("options", [{"order": 1}, {"order": 0}, {"method": "direct"}], ids=str)
def test_limits_that_no_design_keeps_are_named(options):
    # 10 kN on at most 50 mm^2: 200 MPa, where 100 are allowed
    low = [StressLimit("structure", 100e6, criterion="s11")]
    found = optimise(bar(low + [DisplacementLimit("structure", 1e-2, "1")], bounds=(1e-5, 5e-5)),
                     **options)  # fmt: skip
    assert not found.converged
    said = "no design within the bounds meets the limits: the nearest exceeds them by 1 of their"
    assert said in found.message
    assert found.message.endswith("conflict: s11 of structure, A at its upper bound")


def test_two_limits_that_conflict_are_both_named():
    """A stress that grows with A where the displacement falls: ratios A / 1e-4 and 2e-4 / A."""
    limits = [
        StressLimit("structure", 1e6, criterion="s11"),
        DisplacementLimit("structure", 1e4 / 210e9 / 2e-4, "1"),
    ]
    problem = bar(limits, stress=lambda v: {"bar": [1e6 * 210e9 * v["A"] ** 2 / 1e4 / 1e-4]})
    found = optimise(problem)
    # equal at A = sqrt(2) 1e-4, where both are exceeded by sqrt(2) - 1
    assert "the nearest exceeds them by 0.414 of their size" in found.message
    assert "s11 of structure" in found.message and "displacement of structure.1" in found.message
    assert not found.converged and "bound" not in found.message.partition("conflict:")[2]
