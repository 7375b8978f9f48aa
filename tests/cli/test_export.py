"""`jousto export` and `jousto peaks`: parts and results for other programs and for people."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from cli.test_meshes import call
from output.blocks import bar, swinging_bar
from output.runs import swing
from schema.plates import plate


def test_results_become_a_table(tmp_path: Path) -> None:
    run = swing()
    code, text = call("export", run.path, "tip", "tip.speed", "-o", tmp_path / "a.csv")
    assert (code, text) == (0, f"written to {tmp_path / 'a.csv'}\n")
    with (tmp_path / "a.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0][:4] == ["time (s)", "tip.x (m)", "tip.y (m)", "tip.z (m)"]
    assert rows[0][4] == "tip.speed.x (m/s)"
    table = np.array(rows[1:], dtype=float)
    assert np.array_equal(table[:, 0], run.time)
    assert np.array_equal(table[:, 1:4], run["tip"])
    assert np.array_equal(table[:, 4:], run["tip.speed"])
    jo.write(run, tmp_path / "b.csv")
    head = (tmp_path / "b.csv").read_text(encoding="utf-8").splitlines()[0]
    assert "stress.e1.a.top:s11 (Pa)" in head


@pytest.mark.parametrize("suffix", ["vtu", "fem", "sid"])
def test_parts_go_to_other_programs(suffix: str, tmp_path: Path) -> None:
    bar().save(tmp_path / "bar.h5")
    code, text = call("export", tmp_path / "bar.h5", "-o", tmp_path / f"bar.{suffix}")
    assert code == 0, text
    assert (tmp_path / f"bar.{suffix}").stat().st_size > 1000


def test_refuses_clearly(tmp_path: Path) -> None:
    run = swing()
    code, text = call("export", run.path, "-o", tmp_path / "a.sid")
    assert (code, "to export results" in text) == (2, True)
    code, text = call("export", run.path, "tipp", "-o", tmp_path / "a.csv")
    assert (code, "no sensor 'tipp'; did you mean 'tip'?" in text) == (2, True)
    code, text = call("export", tmp_path / "none.h5", "-o", tmp_path / "a.csv")
    assert (code, "no such file" in text) == (2, True)
    (tmp_path / "a.txt").write_text("hello")
    code, text = call("export", tmp_path / "a.txt", "-o", tmp_path / "a.csv")
    assert (code, "is neither a reduced part, results of jousto nor a model file" in text) == (
        2,
        True,
    )


def test_info_on_a_mesh(tmp_path: Path) -> None:
    code, text = call("info", jo.write(plate(), tmp_path / "plate.vtu"))
    assert code == 0
    assert "400 x 100 x 20 mm" in text


def test_peaks_of_sensors_and_of_the_surface() -> None:
    run = swing()
    code, text = call("peaks", run.path, "tip")
    assert code == 0
    z = run["tip"][:, 2]
    row = next(line for line in text.splitlines() if "tip.z" in line)
    assert row.split() == ["tip.z", f"{z.min():.6g}", f"{run.time[z.argmin()]:.6g}", "s",
                           f"{z.max():.6g}", f"{run.time[z.argmax()]:.6g}", "s", "m"]  # fmt: skip
    code, text = call("peaks", run.path, "pin")  # each component has its own unit
    units = {row[0]: row[7:] for row in map(str.split, text.splitlines()) if row}
    assert (units["pin.Fx"], units["pin.Mx"]) == (["N"], ["N", "m"])
    run = swinging_bar()
    code, text = call("peaks", run.path)
    p = np.abs(run.q[:, 7])
    # the stress modes are x p1 MPa: the largest is at the end of the bar
    row = next(line for line in text.splitlines() if "von Mises" in line).split()
    assert (row[0], float(row[1])) == ("bar", pytest.approx(1e6 * p.max(), rel=1e-4))
    assert float(row[2]) == pytest.approx(run.time[p.argmax()])
    assert "von Mises on the surface at (1000," in text
    assert "error budget of 'bar'" in text.splitlines()[-2]
    assert "jousto hotspots --finer-step" in text.splitlines()[-1]
    # from a later time on, and beams
    code, text = call("peaks", run.path, "--from", "50 ms", "--to", "0.1 s")
    within = (run.time > 0.05) & (run.time < 0.1 + 1e-9)
    row = next(line for line in text.splitlines() if "von Mises" in line).split()
    assert float(row[1]) == pytest.approx(1e6 * p[within].max(), rel=1e-4)
    code, text = call("peaks", swing().path)
    # top and bottom are equal: the first label
    assert jo.hot_spots(swing(), count=1)[0].site == "e3.a.bottom"
    assert "von Mises in e3.a.bottom at (500, 0, -10) mm" in text
    code, text = call("peaks", run.path, "--from", "5 s")
    assert (code, "no instant from 5" in text) == (2, True)
    code, text = call("peaks", swing().path, "tipp")
    assert (code, "did you mean 'tip'?" in text) == (2, True)
