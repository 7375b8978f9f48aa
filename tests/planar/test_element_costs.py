"""Error and iterations of the elements: an independent program, our measurements, and the page."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
import planar_elements as measured

sys.path.pop(0)

# errors of the tip under 10 EI/L^2 by a program that shares nothing with this one, with its linear
# systems in ten load steps, for 2, 4, 8, 16 elements; then half the roll-up for 4, 8, 16 elements
INDEPENDENT = {
    "corotational": ((3.9e-2, 8.2e-3, 1.9e-3, 4.5e-4), 60, (1.7e-2, 4.1e-3, 1.0e-3), 80),
    "exact": ((2.0e-2, 6.5e-3, 1.8e-3, 4.5e-4), 66, (1.7e-2, 4.1e-3, 1.0e-3), 100),
    "ANCF GI, Lobatto 3 / Gauss 3": (
        (4.3e-3, 5.6e-4, 3.6e-5, 2.2e-6),
        60,
        (2.0e-3, 1.2e-4, 7.5e-6),
        80,
    ),
    "ANCF GI, Gauss 4 / 3": ((5.4e-2, 1.1e-2, 1.6e-3, 6.1e-5), 60, (2.0e-3, 1.3e-4, 8.1e-6), 80),
    "ANCF GI, Gauss 5 / 3": ((7.4e-2, 1.2e-2, 1.6e-3, 6.1e-5), 60, (4.6e-3, 1.4e-4, 8.2e-6), 80),
    "ANCF BS, Gauss 5 / 3": ((7.4e-2, 1.2e-2, 1.5e-3, 1.9e-6), 77, (4.6e-3, 6.7e-5, 1.7e-4), 120),
}
MESHES = (2, 4, 8, 16)
USUAL = ("corotational", "ANCF GI, Lobatto 3 / Gauss 3")
"""Default elements, which each run of the tests measures; the rest are long."""


def usual_first(names: Iterable[str]) -> list[Any]:
    """Return names as parameters, long ones marked."""
    return [n if n in USUAL else pytest.param(n, marks=pytest.mark.slow) for n in names]


@pytest.mark.parametrize("name", usual_first(INDEPENDENT))
def test_errors_and_iterations_are_those_of_an_independent_program(name: str) -> None:
    element, _ = measured.ELEMENTS[name]
    tips, solves, rolls, roll_solves = INDEPENDENT[name]
    exact = measured.tip_reference(element)
    for n, error in zip(MESHES, tips, strict=True):
        path = measured.under_tip_load(element, n)
        found = float(np.hypot(*(path.displacements[-1, -1, :2] - exact)))
        # printed with two digits; the error of BS with 16 elements is a difference of two errors
        assert found == pytest.approx(error, rel=0.06)
        assert path.solves.sum() == pytest.approx(solves, rel=0.2)
    for n, error in zip(MESHES[1:], rolls, strict=True):
        path = measured.rolled_up(element, n)
        found = float(np.hypot(*(path.displacements[-1, -1, :2] - (-1.0, 2.0 / np.pi))))
        assert found == pytest.approx(error, rel=0.06)
        assert path.solves.sum() < 1.5 * roll_solves


@pytest.mark.parametrize("name", usual_first(measured.ELEMENTS))
def test_the_table_of_the_page_is_measured(name: str) -> None:
    """The first two meshes of each row, as the page prints them."""
    page = measured.PAGE.read_text(encoding="utf-8")
    row = re.search(rf"^\| {re.escape(name)} \| ([^|]*) \| ([^|]*) \|", page, re.M)
    assert row is not None
    element, _ = measured.ELEMENTS[name]
    exact = measured.tip_reference(element)
    cells = [float(x) for x in row[1].partition("(")[0].split(", ")]
    for n, error in zip(MESHES[:2], cells, strict=False):
        path = measured.under_tip_load(element, n)
        found = float(np.hypot(*(path.displacements[-1, -1, :2] - exact)))
        assert found == pytest.approx(error, rel=0.06)
