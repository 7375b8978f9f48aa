"""Pictures of local loops and of random stress."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo

S = 1e6 * np.array([1200.0, -300, 600, -1000, 1200])


def test_loops_pass_through_their_turning_points(tmp_path: Path) -> None:
    m = jo.fatigue.strain_life("sae-1045")
    figure = jo.plot(m, S, path=tmp_path / "loops.png")
    line, points = figure.axes[0].lines[:2]
    path = jo.fatigue.local_path(S, m)
    assert points.get_ydata() == pytest.approx(path.stress / 1e6)
    # the curve comes by every point, and is closed: 1200 MPa again where it was before
    drawn = np.column_stack(line.get_data())
    for point in np.column_stack(points.get_data()):
        assert np.abs(drawn - point).sum(axis=1).min() < 1e-6
    assert (tmp_path / "loops.png").stat().st_size > 5000
    with pytest.raises(jo.InputError):
        jo.plot(m, S, path=tmp_path / "loops.txt")


def test_spectra(tmp_path: Path) -> None:
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 4, jo.Material(E=210e9, nu=0.3, rho=7850.0))
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=4))
    response = jo.fatigue.random_response(
        reduced, [2.0, 80.0], [3.0, 3.0], base="start", direction=(0, 1, 0)
    )
    figure = jo.plot(response, "e1.a.top_left", path=tmp_path / "psd.png")
    (line,) = figure.axes[0].lines
    # the highest point is a natural frequency
    f = line.get_xdata()[int(np.argmax(line.get_ydata()))]
    assert np.abs(response.natural / f - 1).min() < 5e-3
