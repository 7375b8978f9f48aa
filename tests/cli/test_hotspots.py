"""`jousto hotspots`: the worst places of a run, with proof, as table, files and picture."""

from __future__ import annotations

import csv
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest

import jousto as jo
from cli.test_meshes import call
from output.blocks import swinging_bar
from output.runs import swing


def test_ranks_the_places_of_a_run(tmp_path: Path) -> None:
    run = swing()
    code, text = call("hotspots", run.path, "-n", "2", "--separation", "50 mm")
    assert code == 0, text
    values = jo.stress_field(run, "arm").values("von-mises")
    at, place = np.unravel_index(int(np.argmax(values)), values.shape)
    row = text.splitlines()[1].split()
    assert row[0] == "1"
    assert float(row[2]) == pytest.approx(values.max() / 1e6, rel=1e-5)
    # what it may reach between the instants, which are close enough here
    assert row[3] == "-"  # a beam has no mesh of solids
    assert values.max() / 1e6 <= float(row[4]) * (1 + 1e-3) < 1.1 * values.max() / 1e6
    assert float(row[5]) == pytest.approx(run.time[at], rel=1e-5)
    assert float(row[6]) == pytest.approx(1e3 * jo.stress_field(run, "arm").positions[place, 0])
    assert "certified: no other site exceeds" in text
    assert "between the stored instants no site exceeds" in text
    assert "error budget of 'arm'" in text and "not known: modes, step, mesh" in text
    # the same run again is no finer: nothing changes
    code, text = call("hotspots", run.path, "-n", "1", "--finer-step", run.path)
    assert code == 0 and "step 0 %" in text and "not known: modes, mesh" in text
    # a window of time
    code, text = call("hotspots", run.path, "arm", "--to", "100 ms", "-n", "1")
    early = values[run.time <= 0.1 + 1e-9]
    assert float(text.splitlines()[1].split()[2]) == pytest.approx(early.max() / 1e6, rel=1e-5)
    assert "from 0 to 0.1 s" in text


def test_files_hold_the_same_numbers(tmp_path: Path) -> None:
    run = swinging_bar()
    files = [tmp_path / name for name in ("t.csv", "h.h5", "p.png", "v.vtu")]
    code, text = call(
        "hotspots", run.path, "-n", "3", "--criterion", "s11", "--csv", files[0],
        "--histories", files[1], "-o", files[2], "--vtu", files[3],
    )  # fmt: skip
    assert code == 0, text
    found = jo.hot_spots(run, count=3, criterion="s11")
    # the stress modes are x p1 MPa: the largest is at the end of the bar
    p = run.q[:, 7]
    assert found[0].value == pytest.approx(1e6 * p[np.abs(p).argmax()], rel=1e-9)
    with files[0].open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0][4] == "s11 (Pa)"
    assert float(rows[1][4]) == found[0].value
    with h5py.File(files[1]) as file:
        assert file.attrs["certified"] == 1
        assert np.allclose(file["1/criterion"], 1e6 * p, rtol=1e-12)
        assert file["1/criterion"].attrs["unit"] == "Pa"
    assert files[2].stat().st_size > 5000
    mesh = meshio.read(files[3])
    assert np.nanmax(mesh.point_data["s11 (Pa)"]) == pytest.approx(np.abs(1e6 * p).max())
    assert sorted(mesh.point_data["hot spot"])[-3:] == [1, 2, 3]
    jo.plot(found, run, view="xz", path=tmp_path / "q.svg")
    found.write_histories(tmp_path / "h.csv")
    table = np.loadtxt(tmp_path / "h.csv", delimiter=",", skiprows=1)
    assert np.allclose(table[:, 0], run.time)
    assert np.allclose(table[:, 1], 1e6 * p)


def test_refuses_clearly(tmp_path: Path) -> None:
    run = swing()
    code, text = call("hotspots", run.path, "armm")
    assert (code, "no body 'armm'; did you mean 'arm'?" in text) == (2, True)
    code, text = call("hotspots", run.path, "hand")
    assert (code, "no stress modes" in text) == (2, True)
    code, text = call("hotspots", run.path, "--criterion", "von-misses")
    assert (code, "did you mean 'von-mises'?" in text) == (2, True)
    code, text = call("hotspots", run.path, "--criterion", "normal:1,b,0")
    assert (code, "three numbers" in text) == (2, True)
    code, text = call("hotspots", run.path, "--separation", "3 kg")
    assert code == 2
    code, text = call("hotspots", run.path, "--from", "3 s")
    assert (code, "no instant from 3" in text) == (2, True)
    code, text = call("hotspots", run.path, "--csv", tmp_path / "a.txt")
    assert (code, "'.txt' is not a format to write here; known: .csv" in text) == (2, True)
    assert "certified" not in text  # told before the search
