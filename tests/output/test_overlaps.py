"""No text of a picture covers another text, a scale or a curve."""

from __future__ import annotations

import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

import jousto as jo
from jousto.output.figures.load_path import plot_load_path
from jousto.output.scenes.backdrop import new_picture
from jousto.output.scenes.stage import Stage
from jousto.output.scenes.view import choose_view
from jousto.output.style import styled


def boxes(figure, artists):
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw(renderer)
    return [artist.get_window_extent(renderer) for artist in artists]


@pytest.mark.parametrize("plane", ["xy", None])
def test_the_speed_of_a_film_stands_beside_the_colours_of_stress(plane):
    corners = np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
    stage = Stage(
        np.zeros(1), (), np.zeros((1, 0)), 1.0, (), np.zeros(1), choose_view(plane, corners, None),
        np.array([[-1.0, -1.0], [1.0, 1.0]]), corners, -1.0, 0.5, (), limit=3e8,
    )  # fmt: skip
    with styled():
        figure, _ = new_picture(stage, "a long name of a machine", "50 × slow motion")
        (note,) = (t for t in figure.texts if "slow" in t.get_text())
        bar = figure.axes[-1]
        labels = [t for t in (*bar.get_yticklabels(), bar.yaxis.get_offset_text()) if t.get_text()]
        text, *scale = boxes(figure, [note, bar, *labels])
    assert len(scale) > 4
    assert not any(text.overlaps(part) for part in scale)


@pytest.mark.parametrize("distance", [0.0, 1e-3, 0.05, 0.2])
def test_critical_points_of_a_path_do_not_cover_each_other(distance):
    load, x = np.array([0.0, 1.0, 0.9, 0.0]), np.array([0.0, 0.5, 0.6, 1.0])
    critical = [
        SimpleNamespace(kind="limit", load=1.0, after=0),
        SimpleNamespace(kind="bifurcation", load=1.0 - distance, after=0),
    ]
    path = jo.simulation.LoadPath(
        "load", load, (), {"tip": x}, load, np.zeros(4, dtype=int), load, tuple(critical), True
    )
    with styled():
        figure = plot_load_path(path, "tip")
        (ax,) = figure.axes
        legend = ax.get_legend()
        found = boxes(figure, [*ax.texts, *legend.get_texts()])
        (frame,) = boxes(figure, [ax.patch])
    said = sorted(text.get_text() for text in legend.get_texts())
    assert said == ["1 limit 1", f"2 bifurcation {1.0 - distance:.5g}"]
    assert not any(a.overlaps(b) for a, b in itertools.combinations(found, 2))
    assert not any(frame.overlaps(box) for box in found[-2:])
