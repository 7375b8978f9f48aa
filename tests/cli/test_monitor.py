"""jousto monitor: from files and pipes, killed and resumed, with bad input."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import jousto as jo
from hearing import hear
from jousto.cli.group import app
from jousto.measurement.monitor.record_reader import MonitorRecord
from measurement.monitor.watched import NAMES, lines, motion, written

MODEL = """\
parts:
  rod:
    type: beam
    length: 1 m
    section: {type: rectangle, width: 20 mm, height: 10 mm}
    elements: 10
    material: {E: 210 GPa, nu: 0.3, rho: 7850}
    reduce: {type: craig-bampton, interfaces: [start], modes: 6}
    in_plane: xz
bodies: [{name: rod, part: rod}]
joints: [{type: fixed, name: root, a: ground.origin, b: rod.start}]
gravity: [0, 0, -9.81]
sensors:
  - {type: gauge, name: g1, body: rod, at: e1.a.top}
  - {type: gauge, name: g2, body: rod, at: e3.a.top}
  - {type: gauge, name: g3, body: rod, at: e5.a.top}
  - {type: gauge, name: g4, body: rod, at: e7.a.top}
  - {type: gauge, name: g5, body: rod, at: e9.a.top}
simulation: {t_end: 100 ms, solver: {type: ROS2, step: 50 us}, output_step: 1 ms}
monitor:
  spots: [e1.a.top, e2.a.bottom]
  sn: {S_D: 50 MPa, N_D: 1e6, k: 5, T_S: 1.3}
  limits: {stress: 60 MPa, channels: 4}
"""
ENV = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}


def call(*words, input=None):
    result = CliRunner().invoke(app, [str(word) for word in words], input=input)
    return result.exit_code, result.stdout, result.stderr


@pytest.fixture
def case(tmp_path):
    model = tmp_path / "rod.yaml"
    model.write_text(MODEL)
    t, _, e = motion(1200)
    return model, written(tmp_path / "d.csv", [*lines(t, e), "garbage"])


def test_a_file_is_watched_plotted_and_described(case, tmp_path):
    model, data = case
    code, out, err = call("monitor", model, "--gauges", data, "--csv", tmp_path / "s.csv")
    assert code == 0, err
    assert "ALARM: stress" in out
    assert "alarm: ALARM" not in out
    assert "garbage: line 1202" in out
    record = MonitorRecord(tmp_path / "rod.monitor.h5")
    assert record.complete
    assert record.channels == NAMES
    assert record.model_text == MODEL
    assert len((tmp_path / "s.csv").read_text().splitlines()) == 1201
    code, out, _ = call("info", record.path)
    assert code == 0
    assert "1200 samples, 5 channels" in out
    code, _, err = call("plot", record.path, "-o", tmp_path / "p.png")
    assert code == 0, err
    assert (tmp_path / "p.png").stat().st_size > 5000


@pytest.mark.slow
def test_a_pipe_and_ctrl_c(case, tmp_path):
    model, data = case
    process = subprocess.Popen(
        [sys.executable, "-m", "jousto", "monitor", str(model), "--gauges", "-"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=ENV,
        preexec_fn=hear,
    )
    process.stdin.write(data.read_bytes()[:20_000])
    process.stdin.flush()
    assert b"start: watching standard input" in process.stdout.readline()
    process.stdout.readline()
    process.send_signal(signal.SIGINT)
    out = process.communicate(timeout=300)[0]
    assert process.returncode == 0
    assert b"stopped by Ctrl-C" in out
    found = MonitorRecord(tmp_path / "rod.monitor.h5")
    assert not found.complete
    before = len(found)
    assert before > 100
    # the same data once more through the pipe: what was seen is skipped
    code, _, err = call("monitor", model, "--gauges", "-", "--resume", "-q", input=data.read_text())
    assert code == 0, err
    found = MonitorRecord(tmp_path / "rod.monitor.h5")
    np.testing.assert_allclose(found.time, motion(1200)[0])


@pytest.mark.slow
def test_a_killed_command_goes_on(case, tmp_path):
    model, data = case
    target = tmp_path / "k.h5"
    call("monitor", model, "--gauges", data, "-o", tmp_path / "w.h5", "-q")
    process = subprocess.Popen(
        [sys.executable, "-m", "jousto", "monitor", str(model), "--gauges", "-", "-o", str(target)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=ENV,
    )
    process.stdin.write(data.read_bytes()[:30_000])
    process.stdin.flush()
    process.stdout.readline()
    process.stdout.readline()
    process.kill()
    process.communicate()
    assert len(MonitorRecord(target)) > 100
    code, _, err = call("monitor", model, "--gauges", data, "-o", target, "--resume", "-q")
    assert code == 0, err
    whole, found = MonitorRecord(tmp_path / "w.h5"), MonitorRecord(target)
    assert found.complete
    np.testing.assert_allclose(found.stress, whole.stress, rtol=1e-12, atol=1e-3)


def test_bad_input_has_code_2(case, tmp_path):
    model, data = case
    empty = tmp_path / "empty.csv"
    empty.write_text("")
    code, _, err = call("monitor", model, "--gauges", empty)
    assert code == 2
    assert "is empty; nothing was measured" in err
    model.write_text(MODEL.replace("e1.a.top, e2", "e1.a.topp, e2"))
    code, _, err = call("monitor", model, "--gauges", data)
    assert code == 2
    assert "did you mean 'e1.a.top'" in err
    model.write_text(MODEL[: MODEL.index("monitor:")])
    code, _, err = call("monitor", model, "--gauges", data)
    assert code == 2
    assert "has no block monitor" in err


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("[e1.a.top, e2.a.bottom]", "3", "hot spots are found in a reference run"),
        ("stress: 60 MPa", "stress: 60", "was it meant in MPa"),
        ("limits:", "gauges: [g9]\n  limits:", "no gauge 'g9'"),
        ("k: 5", "k: 0.5", "k"),
        ("limits:", "noise: 1 mm\n  limits:", "expects a number"),
    ],
)
def test_bad_blocks_are_told_with_their_line(tmp_path, old, new, sentence):
    path = tmp_path / "rod.yaml"
    path.write_text(MODEL.replace(old, new))
    with pytest.raises(jo.InputError, match=sentence) as error:
        jo.read_model(path)
    assert "rod.yaml:" in str(error.value)


def test_errors_of_the_gauges_are_in_the_bands(tmp_path):
    """The keys of `errors` are `scale` of the monitor and those of gauge_errors of the twin."""
    plain, wide = tmp_path / "rod.yaml", tmp_path / "wide.yaml"
    plain.write_text(MODEL)
    said = "monitor:\n  errors: {scale: 3 %, factor: 0.01, position: 2 mm}\n"
    wide.write_text(MODEL.replace("monitor:\n", said))
    settings = jo.read_model(wide).monitor
    assert (settings.scale, settings.factor, settings.position) == (0.03, 0.01, 2e-3)
    t, _, e = motion(50)
    a, b = (jo.read_model(path).monitor.monitor().push(t, e) for path in (plain, wide))
    np.testing.assert_allclose(a.stress, b.stress)
    half = 0.5 * (b.high - b.low)
    # at least what the errors in proportion alone make of it
    assert np.all(half >= 1.95 * 0.03 * np.abs(b.stress))
    assert np.all(b.high - b.low > a.high - a.low)
    wide.write_text(MODEL.replace("monitor:\n", said.replace("3 %", "2")))
    with pytest.raises(jo.InputError, match="scale is 2"):
        jo.read_model(wide)


def test_hot_spots_of_a_reference_run(tmp_path):
    path = Path(tmp_path / "rod.yaml")
    text = MODEL.replace("[e1.a.top, e2.a.bottom]", "2\n  separation: 50 mm\n  reference: run")
    path.write_text(text)
    file = jo.read_model(path)
    run = jo.simulate(jo.compile(file.mechanism), 0.02, **file.simulation.given())
    monitor = file.monitor.monitor(run)
    worst = jo.hot_spots(
        jo.stress_field(run, "rod"), count=2, criterion="signed-von-mises", separation=0.05
    )
    assert monitor.spots == tuple(spot.site for spot in worst)
