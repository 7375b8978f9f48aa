"""Pictures of studies: what is drawn, and what cannot be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo


def table(points: np.ndarray, failed: int = 0) -> jo.design.StudyTable:
    x = np.asarray(points, dtype=float)
    y = np.column_stack([x.sum(axis=1), x[:, 0] ** 2])
    reasons = [""] * len(x)
    for k in range(failed):
        y[k], reasons[k] = np.nan, "broken"
    names = ("wall", "load")[: x.shape[1]]
    units = {"wall": "m", "load": "N", "stress": "Pa", "mass": "kg"}
    return jo.design.StudyTable(names, ("stress", "mass"), x, y, tuple(reasons), units)


def grid(n: int, m: int) -> np.ndarray:
    return np.array([[a, b] for a in np.linspace(1, 2, n) for b in np.linspace(0, 5, m)])


def test_lines_of_one_parameter() -> None:
    axes = jo.plot(table(np.linspace(2, 1, 5)[:, None])).axes
    assert [ax.get_ylabel() for ax in axes] == ["stress (Pa)", "mass (kg)"]
    assert axes[-1].get_xlabel() == "wall (m)"
    x = axes[0].lines[0].get_xdata()
    assert list(x) == sorted(x) and len(x) == 5


def test_lines_for_each_value_of_the_second_parameter() -> None:
    axes = jo.plot(table(grid(9, 3)), "wall", "load", "stress").axes
    assert len(axes) == 1 and len(axes[0].lines) == 3
    assert [t.get_text() for t in axes[0].get_legend().get_texts()] == ["0", "2.5", "5"]


def test_scatter_has_all_pairs_and_tells_what_failed() -> None:
    rng = np.random.default_rng(1)
    figure = jo.plot(table(rng.random((40, 2)), failed=3))
    assert len(figure.axes) == 16
    assert "3 failed" in [t.get_text() for t in figure.texts]
    assert len(figure.axes[1].lines[0].get_xdata()) == 37


def test_surface_and_parallel_coordinates(tmp_path: Path) -> None:
    data = table(grid(6, 6))
    figure = jo.plot(data, "wall", "load", "stress", kind="surface", path=tmp_path / "s.png")
    assert figure.axes[0].get_xlabel() == "wall (m)" and (tmp_path / "s.png").exists()
    figure = jo.plot(data, kind="parallel")
    assert len(figure.axes[0].collections[0].get_paths()) == 36
    labels = [t.get_text() for t in figure.axes[0].get_xticklabels()]
    assert labels == ["wall (m)", "load (N)", "stress (Pa)", "mass (kg)"]


def test_what_cannot_be_drawn_is_said() -> None:
    data = table(grid(3, 3))
    for given, options, message in (
        (("wal", "stress"), {}, "no column 'wal'; did you mean 'wall'?"),
        ((), {"kind": "line"}, "kind is 'line'; did you mean 'lines'?"),
        (("wall", "stress"), {"kind": "surface"}, "over two parameters"),
        (("wall",), {}, "needs an outcome and a parameter"),
    ):
        with pytest.raises(jo.InputError, match=message.replace("?", r"\?")):
            jo.plot(data, *given, **options)
    with pytest.raises(jo.InputError, match="all points of the study failed"):
        jo.plot(table(grid(2, 2), failed=4))
    line = np.column_stack([np.linspace(1, 2, 5), np.linspace(3, 4, 5)])
    with pytest.raises(jo.InputError, match="not on a line"):
        jo.plot(table(line), kind="surface")
