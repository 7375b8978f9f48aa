"""plot_planar draws motions and equilibria of planar frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.output.figures.planar import lines
from jousto.planar.dynamics import simulate_planar
from jousto.planar.frame import PlanarFrame
from jousto.planar.items import PlanarBeam, PlanarLoad, PlanarSupport
from jousto.planar.methods import PlanarNewmark
from jousto.planar.section import PlanarSection
from jousto.planar.statics import load_steps

ROD = PlanarSection(EA=3e4, GA=1e4, EI=50.0, mass=2.0, rotary=0.05)


@pytest.fixture
def frame() -> PlanarFrame:
    return PlanarFrame(
        [(0.0, -0.2), (1.0, 0.0), (2.0, 0.0)],
        [PlanarBeam(0, 1, ROD, offset_a=(0.0, 0.2)), PlanarBeam(1, 2, ROD)],
        supports=[PlanarSupport(0, rotation=True)],
        loads=[PlanarLoad(2, force=(0.0, 20.0))],
    )


def test_a_motion(frame: PlanarFrame, tmp_path: Path) -> None:
    run = simulate_planar(frame, 0.05, PlanarNewmark(1e-3))
    figure = jo.plot(run, path=tmp_path / "run.png")
    assert (tmp_path / "run.png").stat().st_size > 1000
    shapes, energies, work = figure.axes
    assert len(shapes.lines) == 7 * 2
    assert [line.get_label() for line in energies.lines] == ["kinetic", "strain"]
    assert np.array_equal(work.lines[0].get_ydata(), run.evaluations[1:])
    # node, end of its arm, the next node
    first, second = lines(run, 0)
    assert first == pytest.approx(np.array([(0, -0.2), (0, 0), (1, 0), (1, 0)]))
    assert lines(run, 50)[1][-1] == pytest.approx(run.positions[50, 2])


def test_equilibria(frame: PlanarFrame, tmp_path: Path) -> None:
    path = load_steps(frame, np.linspace(0, 1, 4))
    figure = jo.plot(path)
    curve = figure.axes[1]
    assert curve.get_xlabel() == "displacement of node 2 (m)"
    assert np.array_equal(curve.lines[0].get_ydata(), path.factors)
    with pytest.raises(jo.InputError, match="not a format"):
        jo.plot(path, path=tmp_path / "path.txt")
