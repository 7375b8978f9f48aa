"""jousto gauges: lists, what they show, measured beside virtual."""

from __future__ import annotations

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

import jousto as jo
from jousto.cli.group import app

MODEL = """\
name: bar
parts:
  rod:
    type: beam
    length: 500 mm
    section: {type: rectangle, width: 20 mm, height: 40 mm}
    material: S355
    elements: 4
    reduce: {type: craig-bampton, interfaces: [start, end], modes: 2}
bodies:
  - {name: arm, part: rod, damping: 0.02}
joints:
  - {type: fixed, name: clamp, a: ground.origin, b: arm.start}
forces:
  - {type: force, name: push, marker: arm.end, vector: [0, 0, -200],
     signal: {type: harmonic, frequency: 1.7, phase: 0.4}}
sensors:
  - {type: gauge, name: top, body: arm, at: [10 cm, 0, 20 mm], length: 3 mm}
  - {type: gauge, name: low, body: arm, at: [10 cm, 0, -20 mm]}
  - {type: rosette, name: ros, body: arm, at: e2.a.left}
  - {type: bridge, name: half, arms: [top, low], gauge_factor: 2.05}
simulation: {t_end: 2 s, solver: {type: ROS2, step: 1e-3}, output_step: 5 ms}
"""


def jousto(*args):
    return CliRunner().invoke(app, [str(a) for a in args])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("gauges")
    (path / "bar.yaml").write_text(MODEL)
    ran = jousto("run", path / "bar.yaml", "-o", path / "bar.h5")
    assert ran.exit_code == 0, ran.output
    return path


def test_gauges_of_a_model(folder):
    said = jousto("gauges", folder / "bar.yaml")
    assert said.exit_code == 0, said.output
    lines = said.stdout.splitlines()
    assert lines[1].split() == [
        "top",
        "gauge",
        "arm",
        "100,",
        "0,",
        "20",
        "1,",
        "0,",
        "0",
        "3",
        "x",
        "0",
    ]
    assert "ros   rosette 45   arm" in said.stdout
    assert "half  half bridge  arm" in said.stdout
    assert lines[-1].startswith("arm: 5 grids, ")
    refused = jousto("gauges", folder / "bar.yaml", "-o", folder / "x.png")
    assert refused.exit_code == 2
    assert "need results; run it first, jousto run" in refused.stderr


def test_what_gauges_show(folder):
    said = jousto("gauges", folder / "bar.h5", "--csv", folder / "v.csv", "-o", folder / "v.png")
    assert said.exit_code == 0, said.output
    lines = said.stdout.splitlines()
    assert [line.split()[0] for line in lines[1:7]] == [
        "top",
        "low",
        "ros.a",
        "ros.b",
        "ros.c",
        "half",
    ]
    assert "mV/V" in lines[6]
    record = jo.gauges.read_record(folder / "v.csv")
    np.testing.assert_array_equal(record["top"], jo.load(folder / "bar.h5")["top"][:, 0])
    assert (folder / "v.png").stat().st_size > 10_000


def test_measured_beside_virtual(folder):
    """A logger that started 0.4321 s later, 4 % more gain, its own rate: both are found."""
    run = jo.load(folder / "bar.h5")
    spline = jo.gauges.record_of(run).resample(times=np.arange(0.5, 1.9, 1 / 97.0), antialias=False)
    time = spline.time - 0.4321
    text = "Zeit;TOP;bridge\ns;µm/m;mV/V\n" + "\n".join(
        ";".join(f"{x:.9g}".replace(".", ",") for x in row)
        for row in zip(time, 1.04e6 * spline["top"], 1e3 * spline["half"], strict=True)
    )
    (folder / "measured.csv").write_text(text, encoding="utf-8")
    said = jousto(
        "gauges", folder / "bar.h5", "--measured", folder / "measured.csv", "--pair", "TOP=top",
        "--pair", "bridge=half", "--max-shift", 0.5, "--csv", folder / "both.csv",
        "-o", folder / "both.png",
    )  # fmt: skip
    assert said.exit_code == 0, said.output
    rows = [line.split() for line in said.stdout.splitlines()]
    assert rows[1][:3] == ["TOP", "top", "um/m"]
    assert float(rows[1][6]) == pytest.approx(1.04, abs=2e-3)
    assert float(rows[2][6]) == pytest.approx(1.0, abs=2e-3)
    assert float(rows[3][2]) == pytest.approx(0.4321, abs=2e-4)
    both = jo.gauges.read_record(folder / "both.csv")
    assert list(both.channels)[:2] == ["TOP measured", "TOP virtual"]
    assert (folder / "both.png").stat().st_size > 10_000


def test_mistakes(folder, tmp_path):
    (tmp_path / "m.csv").write_text("time,g1 [um/m]\n0,1\n1,2\n2,4\n")
    none = jousto("gauges", folder / "bar.h5", "--measured", tmp_path / "m.csv")
    assert none.exit_code == 2
    assert "none of its channels (g1) has the name of a sensor of the run (top, low," in none.stderr
    wrong = jousto(
        "gauges", folder / "bar.h5", "--measured", tmp_path / "m.csv", "--pair", "g1=tip"
    )
    assert wrong.exit_code == 2
    assert "no sensor 'tip'; did you mean 'top'" in wrong.stderr
    assert (
        jousto(
            "gauges", folder / "bar.h5", "--measured", tmp_path / "m.csv", "--unit", "g1"
        ).exit_code
        == 2
    )
    (tmp_path / "empty.csv").write_text("")
    empty = jousto("gauges", folder / "bar.h5", "--measured", tmp_path / "empty.csv")
    assert empty.exit_code == 2
    assert "is empty" in empty.stderr
    bare = MODEL[: MODEL.index("sensors:")] + MODEL[MODEL.index("simulation:") :]
    (tmp_path / "bare.yaml").write_text(bare)
    assert "has no gauges" in jousto("gauges", tmp_path / "bare.yaml").stderr
    with h5py.File(tmp_path / "x.h5", "w"):
        pass
    assert jousto("gauges", tmp_path / "x.h5").exit_code == 2
