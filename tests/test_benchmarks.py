"""Figures of the benchmarks on the pages are those of one stored run, and so are the pictures."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).parent.parent
BENCHMARKS = ROOT / "benchmarks"
NAMES = ("page", "precision_fronts", "precision_figures")


@pytest.fixture
def programs(monkeypatch: pytest.MonkeyPatch) -> dict[str, ModuleType]:
    """Modules of benchmarks/, which are gone after the test."""
    monkeypatch.syspath_prepend(BENCHMARKS)
    for path in BENCHMARKS.glob("*.py"):
        monkeypatch.delitem(sys.modules, path.stem, raising=False)
    made = {name: __import__(name) for name in NAMES}
    for name in [*made, "instructions"]:
        monkeypatch.setitem(sys.modules, name, sys.modules[name])
    return made


def test_pages_have_the_figures_of_the_stored_run(programs: dict[str, ModuleType]) -> None:
    page = programs["page"]
    results, pages = page.stored(), page.pages()
    names = {path.name for path in pages}
    assert {"README.md", "benchmarks.md", "work-precision.md", "benchmarks-trees.md"} <= names
    for path in pages:
        text = path.read_text(encoding="utf-8")
        assert page.filled(text, results) == text, f"{path.name}: run benchmarks/page.py"


def test_another_run_would_change_them(programs: dict[str, ModuleType]) -> None:
    page = programs["page"]
    results = json.loads(json.dumps(page.stored()))
    for found in results["precision"].values():
        for point in found["points"]:
            if point["program"] == "EXUDYN":
                point["seconds"] *= 1.5
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert page.filled(text, results) != text


def test_pictures_show_the_stored_run(programs: dict[str, ModuleType]) -> None:
    figures = programs["precision_figures"]
    wanted = figures.digest(programs["page"].stored()).encode()
    for name in figures.FIGURES:
        assert wanted in (figures.PICTURES / name).read_bytes(), f"run precision_figures.py: {name}"


def point(program: str, error: float | None, seconds: float, **setting: Any) -> dict[str, Any]:
    made = {"program": program, "method": "m", "error": error, "seconds": seconds}
    return made | {"setting": setting}


def test_times_at_equal_error_are_interpolated_in_logarithms(
    programs: dict[str, ModuleType],
) -> None:
    fronts = programs["precision_fronts"]
    points = [point("a", 10.0**-k, 2.0**k) for k in (2, 4, 6)]
    points += [point("a", 1e-3, 1e3), point("a", None, 1e-9)]  # beaten; without an error
    curve = fronts.front(points, "a")
    np.testing.assert_allclose(curve, [[1e-2, 4], [1e-4, 16], [1e-6, 64]])
    assert fronts.time_at(curve, 1e-3) == pytest.approx(8)
    assert fronts.time_at(curve, 1e-5) == pytest.approx(32)
    assert np.isnan([fronts.time_at(curve, error) for error in (1e-1, 1e-7)]).all()


def test_the_loosest_tolerance_that_keeps_the_error_is_compared(
    programs: dict[str, ModuleType],
) -> None:
    points = [
        point("b", 3e-5, 1.0, step=1e-3, tolerance=1e-4),  # cheap, but its error is another
        point("b", 1.05e-5, 2.0, step=1e-3, tolerance=1e-6),
        point("b", 1e-5, 4.0, step=1e-3, tolerance=1e-8),
        point("b", 1e-9, 0.5, step=1e-4, tolerance=1e-8),
    ]
    taken = programs["precision_fronts"].at_step(points, "b", "m", 1e-3)
    assert taken["seconds"] == 2.0
