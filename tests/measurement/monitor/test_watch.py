"""Watching a cantilever: its stress, damage and alarms, and what happens when things go wrong."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

import jousto as jo
from jousto.measurement.monitor import record_writer as records
from jousto.measurement.monitor.alarms import AlarmLimits, Alarms
from jousto.measurement.monitor.health import STATES
from jousto.measurement.monitor.record_reader import MonitorRecord
from jousto.measurement.monitor.watch import _layout, watch
from measurement.monitor.watched import (
    NAMES,
    NOISE,
    SPOTS,
    cantilever,
    curve,
    lines,
    monitor,
    motion,
    truth,
    written,
)

DATASETS = {
    "samples": ("time", "strain", "states", "stress", "low", "high"),
    "summary": ("time", "samples", "blind", "peak", "damage", "damage_low", "damage_high"),
}


def same(a, b):
    """Check that two records hold the same bits."""
    for table, names in DATASETS.items():
        for name in names:
            np.testing.assert_array_equal(a._read(table, name), b._read(table, name), err_msg=name)
    skip = ("start", "resumed", "end")
    found = [[e for e in x.events if e.kind not in skip] for x in (a, b)]
    assert found[0] == found[1]


def spoilt(rows, part, column, cell):
    """Put a cell in the place of a channel's values."""
    for k in range(part.start, part.stop):
        cells = rows[k + 1].split(",")
        cells[column + 1] = cell
        rows[k + 1] = ",".join(cells)


def test_stress_lies_in_its_band_and_damage_is_that_of_the_whole_history(tmp_path):
    t, p, e = motion()
    found = watch(monitor(sn=curve()), written(tmp_path / "d.csv", lines(t, e)), tmp_path / "r.h5")
    assert found.complete
    assert found.channels == NAMES
    np.testing.assert_allclose(found.time, t)
    assert not found.states.any()
    s = truth(p)
    inside = (found.low <= s) & (s <= found.high)
    # 2000 independent samples: 95 % within 1.5 %
    np.testing.assert_allclose(inside.mean(axis=0), 0.95, atol=0.015)
    # 1.96 standard deviations of S (B^T B)^-1 S^T noise^2
    half = 0.5 * (found.high - found.low)
    reduced, B = cantilever()
    S = reduced.stress.modes[[reduced.stress.labels.index(x) for x in SPOTS], 0]
    deviation = NOISE * np.sqrt(np.diag(S @ np.linalg.inv(B.T @ B) @ S.T))
    np.testing.assert_allclose(np.median(half, axis=0), 1.95996 * deviation, rtol=2e-2)
    meter = jo.model.DamageMeter(curve(), residue="half", n=2)
    meter.push(found.stress)
    np.testing.assert_array_equal(found.summary("damage")[-1], meter.damage())
    low, D, high = (found.summary(x)[-1] for x in ("damage_low", "damage", "damage_high"))
    assert np.all(low < D)
    assert np.all(D < high)
    # goes on at the mean rate: (1 - D) T / D
    np.testing.assert_allclose(found.summary("remaining")[-1], (1 - D) * t[-1] / D, rtol=1e-12)
    assert found.summary("samples").sum() == len(t)
    true = jo.model.DamageMeter(curve(), residue="half", n=2)
    true.push(truth(p))
    assert np.all(low < true.damage())
    assert np.all(true.damage() < high)
    assert "e1.a.top" in str(found)
    found.to_csv(tmp_path / "r.csv")
    assert len((tmp_path / "r.csv").read_text().splitlines()) == len(t) + 1


def test_failing_channels_are_left_out_and_the_rest_goes_on(tmp_path):
    t, p, e = motion()
    rows = lines(t, e)
    failures = (
        (0, slice(400, 600), "", "dropout"),
        (1, slice(500, 700), "nan", "nan"),
        (4, slice(1500, 1700), "99999", "saturated"),
    )
    for column, part, cell, _ in failures:
        spoilt(rows, part, column, cell)
    found = watch(monitor(), written(tmp_path / "d.csv", rows), tmp_path / "r.h5")
    for column, part, _, name in failures:
        assert {STATES[k] for k in found.states[part, column]} == {name}
    s = truth(p)
    assert np.isfinite(found.stress).all()
    inside = (found.low <= s) & (s <= found.high)
    np.testing.assert_allclose(inside.mean(axis=0), 0.95, atol=0.015)
    # with fewer channels the band is wider
    half = found.high - found.low
    assert np.all(half[520:580].mean(axis=0) > 1.05 * half[800:1400].mean(axis=0))
    changed = [event.text for event in found.events if event.kind == "channel"]
    assert changed[0] == "g1: dropout, was ok"
    assert "g5: saturated, was ok" in changed
    assert "g1: ok" in changed


def test_too_few_channels_are_blind_and_raise_an_alarm(tmp_path):
    t, _, e = motion(600)
    e[200:300, 1:] = np.nan  # one gauge cannot tell two modes
    data = written(tmp_path / "d.csv", lines(t, e))
    limits = AlarmLimits(channels=3, hold=1.0)
    found = watch(monitor(sn=curve(), limits=limits), data, tmp_path / "r.h5")
    # and for ten samples after it until the channels are believed
    assert np.isnan(found.stress[200:310]).all()
    assert np.isfinite(found.stress[310:]).all()
    assert found.summary("blind").sum() == 110
    alarms = [(round(x.time, 2), x.text[:5]) for x in found.events if x.kind == "alarm"]
    assert alarms == [(2.0, "ALARM"), (4.09, "over:")]
    # blind time is no watched time
    assert found.summary("watched")[-1] == pytest.approx(5.99 - 1.1, abs=0.02)


def test_alarms_have_hysteresis(tmp_path):
    t, p, _ = motion(3000)
    scale = np.where((t > 5) & (t < 10), 1.0, 0.5)[:, None]  # 70 MPa for five seconds, else 35
    e = (p * scale) @ cantilever()[1].T
    data = written(tmp_path / "d.csv", lines(t, e))
    limits = AlarmLimits(stress=60e6, release=0.9, hold=3.0)
    found = watch(monitor(limits=limits), data, tmp_path / "r.h5")
    alarms = [x for x in found.events if x.kind == "alarm" and SPOTS[0] in x.text]
    # some ten peaks above the limit, one alarm
    assert [x.text.split(":")[0] for x in alarms] == ["ALARM", "over"]
    assert 5.0 < alarms[0].time < 6.1
    assert 12.0 < alarms[1].time < 13.1


def test_damage_and_life_raise_alarms_once(tmp_path):
    t, _, e = motion()
    data = written(tmp_path / "d.csv", lines(t, e))
    limits = AlarmLimits(damage=1e-5, life=1e9)
    found = watch(monitor(sn=curve(), limits=limits), data, tmp_path / "r.h5")
    D, when = found.summary("damage"), found.summary("time")
    told = {x.text.split(" at ")[1].split(",")[0]: x for x in found.events if "damage" in x.text}
    over = {spot: np.flatnonzero(D[:, k] >= 1e-5) for k, spot in enumerate(SPOTS)}
    assert told
    assert {spot: alarm.time for spot, alarm in told.items()} == {
        spot: when[rows[0]] for spot, rows in over.items() if len(rows)
    }
    lives = [x.text for x in found.events if "remaining life" in x.text]
    assert len(lives) == 2
    assert all(x.endswith("limit 31.7 years") for x in lives)  # 1e9 s


def test_an_alarm_of_the_life_ends_a_tenth_above_its_limit() -> None:
    alarms = Alarms(AlarmLimits(life=100.0), ("spot",))
    lives = [150.0, 100.0, 90.0, 109.0, 101.0, 111.0, 105.0, 99.0]
    told = [alarms.summary(t, np.zeros(1), np.array([x])) for t, x in enumerate(lives)]
    assert [(x.time, x.on, x.value) for one in told for x in one] == [
        (1, True, 100.0),
        (5, False, 111.0),
        (7, True, 99.0),
    ]


@pytest.mark.parametrize(
    ("text", "options", "sentence"),
    [
        ("", {}, "is empty"),
        ("time,g1,g2\n0,1,2\n", {}, "no column 'g3' for 'g3'"),
        ("time,g1,g2,g3,g4,g5 [furlong]\n0,0,0,0,0,0\n", {}, "not a unit of strain"),
        ("time,g1,g2,g3,g4,g5\n0,300,20,30,40,50\n", {}, "not strains in m/m"),
        ("time,g1,g1,g2,g3,g4,g5\n", {}, "more than once"),
        ("time,g1,g2,g3,g4,g5\n0,0,0,0,0,0\n", {"columns": {"gg": "g1"}}, "no channel 'gg'"),
    ],
)
def test_wrong_data_are_told(tmp_path, text, options, sentence):
    data = tmp_path / "d.csv"
    data.write_text(text)
    with pytest.raises(jo.InputError, match=sentence):
        watch(monitor(), data, tmp_path / "r.h5", **options)


def test_wrong_set_ups_are_told():
    with pytest.raises(jo.InputError, match="needs an S-N curve"):
        monitor(limits=AlarmLimits(life=10.0))
    with pytest.raises(jo.InputError, match="was it meant in MPa"):
        AlarmLimits(stress=200.0)
    with pytest.raises(jo.InputError, match="signed-von-mises"):
        monitor(criterion="signed-von-mise")
    with pytest.raises(jo.InputError, match="must increase"):
        monitor().push([0.0, 0.0], np.zeros((2, 5)))


def test_units_and_columns(tmp_path):
    t, _, e = motion(300)
    head = "t;CH1;CH2;CH3;CH4;CH5;CH6"
    rows = [
        f"{time:g};" + ";".join(f"{1e3 * x:.8f}" for x in row) + ";7"
        for time, row in zip(t, e, strict=True)
    ]
    data = written(tmp_path / "d.csv", [head, *rows])
    columns = {name: f"CH{i + 1}" for i, name in enumerate(NAMES)}
    with pytest.warns(jo.JoustoWarning, match="no gauge uses: CH6"):
        found = watch(monitor(), data, tmp_path / "r.h5", columns=columns, unit="mm/m")
    np.testing.assert_allclose(found.strain, e, atol=1e-11)


class Pieces(io.BytesIO):
    """A pipe that gives the header alone, then all that follows."""

    def read1(self, size=-1):
        return self.readline() if self.tell() == 0 else super().read1(size)

    def seekable(self):
        return False


def test_units_that_come_later_than_their_names_hold(tmp_path):
    t, _, e = motion(600)
    text = lines(t, e)
    text[0] = "time," + ",".join(NAMES)
    text.insert(1, "s" + 5 * ",um/m")
    data = "\n".join(text).encode()
    found = watch(monitor(), Pieces(data), tmp_path / "r.h5")
    np.testing.assert_allclose(found.strain, e, atol=1e-10)
    assert not [event for event in found.events if event.kind == "garbage"]
    with pytest.raises(jo.InputError, match="in 'furlong', which is not a unit of strain"):
        watch(monitor(), Pieces(data.replace(b"um/m", b"furlong")), tmp_path / "f.h5")


class Stopped(io.BytesIO):
    """A pipe in which something happens after some reads."""

    def __init__(self, data, reads, error):
        super().__init__(data)
        self.left, self.error = reads, error

    def read1(self, size=-1):
        self.left -= 1
        if self.left < 0:
            raise self.error
        return super().read1(4096)

    def seekable(self):
        return False


def test_ctrl_c_ends_it_clean_and_it_goes_on(tmp_path):
    t, _, e = motion()
    data = "\n".join(lines(t, e)).encode()
    target = tmp_path / "r.h5"
    found = watch(monitor(sn=curve()), Stopped(data, 8, KeyboardInterrupt()), target)
    assert not found.complete
    assert found.ended == "stopped by Ctrl-C"
    assert 0 < len(found) < len(t)
    # the pipe begins again: what was seen is skipped
    again = Stopped(data, 1000, KeyboardInterrupt())
    found = watch(monitor(sn=curve()), again, target, resume=True)
    assert found.complete
    np.testing.assert_allclose(found.time, t)
    whole = watch(monitor(sn=curve()), io.BytesIO(data), tmp_path / "w.h5")
    np.testing.assert_allclose(found.stress, whole.stress, rtol=1e-12, atol=1e-3)
    np.testing.assert_allclose(found.summary("damage"), whole.summary("damage"), rtol=1e-9)


def test_a_source_that_breaks_leaves_the_record(tmp_path):
    t, _, e = motion()
    data = "\n".join(lines(t, e)).encode()
    with pytest.raises(OSError, match="device gone"):
        watch(monitor(), Stopped(data, 8, OSError(5, "device gone")), tmp_path / "r.h5")
    found = MonitorRecord(tmp_path / "r.h5")
    assert len(found) > 100
    assert "device gone" in found.ended


SCRIPT = """
import sys, time
from measurement.monitor.watched import monitor, curve
from jousto.measurement.monitor.watch import watch
def slowly(progress):
    print(len(progress.update.time), flush=True)
    time.sleep(0.05)
watch(monitor(sn=curve()), sys.argv[1], sys.argv[2], show=slowly)
"""


@pytest.mark.parametrize("blocks", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_a_killed_watch_is_readable_and_goes_on_exactly(tmp_path, blocks):
    t, _, e = motion(2500)
    rows = lines(t, e)
    spoilt(rows, slice(700, 900), 2, "")
    rows[2000:2000] = ["garbage", "1,2", rows[200]]
    data = written(tmp_path / "d.csv", rows)
    whole = watch(monitor(sn=curve()), data, tmp_path / "w.h5")
    target = tmp_path / "r.h5"
    process = subprocess.Popen(
        [sys.executable, "-c", SCRIPT, str(data), str(target)],
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    for _ in range(blocks):
        process.stdout.readline()
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    process.stdout.close()
    killed = MonitorRecord(target)
    assert not killed.complete
    assert killed.ended == "running or killed"
    assert 512 * blocks <= len(killed) < 2500
    np.testing.assert_array_equal(killed.stress, whole.stress[: len(killed)])
    same(watch(monitor(sn=curve()), data, target, resume=True), whole)


class EnoughError(Exception):
    pass


def test_a_record_that_is_torn_while_it_is_written_goes_on(tmp_path):
    """Whatever was written of the next block, the last checkpoint holds."""
    t, _, e = motion(2000)
    data = written(tmp_path / "d.csv", lines(t, e))
    whole = watch(monitor(sn=curve()), data, tmp_path / "w.h5")
    target = tmp_path / "r.h5"
    put = records.Record._put
    # stop after one of the writes of a block, half written, also in a checkpoint
    # or before the first
    for stop in (2, 5, 11, 41, 53, 68):
        count = [0]

        def torn(self, place, piece, at=0, stop=stop, count=count):
            count[0] += 1
            if count[0] == stop:
                put(self, place, piece[: len(piece) // 2], at)
            if count[0] >= stop:
                raise EnoughError
            put(self, place, piece, at)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(records.Record, "_put", torn)
            patch.setattr(records.Record, "close", lambda self, *a, **k: self._file.close())
            with pytest.raises(EnoughError):
                watch(monitor(sn=curve()), data, target)
        assert len(MonitorRecord(target).stress) % 512 == 0
        same(watch(monitor(sn=curve()), data, target, resume=True), whole)


@pytest.mark.parametrize("resumed_from", ["nothing", "a part of a block"])
def test_a_watch_killed_before_its_first_block_goes_on(tmp_path, resumed_from):
    t, _, e = motion(2000)
    data = written(tmp_path / "d.csv", lines(t, e))
    whole = watch(monitor(sn=curve()), data, tmp_path / "w.h5")
    target = tmp_path / "r.h5"
    layout = _layout(monitor(sn=curve()), "")
    record = records.Record.create(target, layout)
    if resumed_from != "nothing":
        record.append(
            "samples", {c.name: np.ones((3, max(c.width, 1))) for c in layout.tables[0].columns}
        )
    record._file.close()  # as by a kill
    same(watch(monitor(sn=curve()), data, target, resume=True), whole)
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["d.csv", "r.h5", "w.h5"]


FULL = """
import resource, signal, sys
sys.path.insert(0, sys.argv[1])
from measurement.monitor.watched import curve, monitor
from jousto.measurement.monitor import record_writer as records
from jousto.measurement.monitor.watch import watch
import jousto as jo
create = records.Record.create.__func__
def limited(cls, path, layout):
    made = create(cls, path, layout)
    size = path.stat().st_size + 1000
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    return made
records.Record.create = classmethod(limited)
try:
    watch(monitor(sn=curve()), sys.argv[2], sys.argv[3])
except jo.SimulationError as error:
    print(error)
    print(error.time)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="limits the size of files")
def test_a_full_disk_is_named_with_its_file_and_the_watch_goes_on(tmp_path):
    t, _, e = motion(6000)  # more rows than a new record has room for
    data = written(tmp_path / "d.csv", lines(t, e))
    target = tmp_path / "r.h5"
    done = subprocess.run(
        [sys.executable, "-c", FULL, str(Path(__file__).parents[2]), str(data), str(target)],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert done.returncode == 0, done.stderr
    assert f"{target}: cannot be written: File too large" in done.stdout
    assert "go on with resume; what was recorded is kept" in done.stdout
    assert 0 < len(MonitorRecord(target)) < 6000
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["d.csv", "r.h5"]
    whole = watch(monitor(sn=curve()), data, tmp_path / "w.h5")
    same(watch(monitor(sn=curve()), data, target, resume=True), whole)


def test_a_record_grows(tmp_path, monkeypatch):
    t, _, e = motion(2000)
    data = written(tmp_path / "d.csv", lines(t, e))
    b = watch(monitor(sn=curve(), every=0.05), data, tmp_path / "b.h5")
    monkeypatch.setattr(records.Table.__init__, "__defaults__", (64,))
    monkeypatch.setattr(records, "ROOM", 64)
    same(watch(monitor(sn=curve(), every=0.05), data, tmp_path / "a.h5"), b)
    assert not list(tmp_path.glob("*.new"))


def test_resume_refuses_what_does_not_fit(tmp_path):
    t, _, e = motion(600)
    data, target = written(tmp_path / "d.csv", lines(t, e)), tmp_path / "r.h5"
    with pytest.warns(jo.JoustoWarning, match="a new one begins"):
        new = watch(monitor(), data, target, resume=True)
    assert len(new) == 600
    assert new.events[0].kind == "start"
    reduced, B = cantilever()
    twin = jo.twin.Reconstruction(B, noise=NOISE, names=NAMES)
    with pytest.raises(jo.InputError, match="its spots are e1.a.top"):
        watch(jo.monitor.Monitor(twin, reduced, ["e3.a.top"]), data, target, resume=True)
    with h5py.File(tmp_path / "x.h5", "w"):
        pass
    with pytest.raises(jo.InputError, match="some other HDF5 file"):
        MonitorRecord(tmp_path / "x.h5")
    short = written(tmp_path / "short.csv", lines(t[:5], e[:5]))
    with pytest.raises(jo.InputError, match="it is another file"):
        watch(monitor(), short, target, resume=True)


def test_the_record_is_readable_while_it_is_written(tmp_path):
    t, _, e = motion(2000)
    data = written(tmp_path / "d.csv", lines(t, e))
    seen = []

    def look(progress):
        record = MonitorRecord(tmp_path / "r.h5")
        seen.append(len(record))
        assert np.isfinite(record.stress).all()

    watch(monitor(), data, tmp_path / "r.h5", show=look)
    assert seen[:4] == [512, 1024, 1536, 2000]


def test_a_plot_of_the_record(tmp_path):
    t, _, e = motion(600)
    e[100:200, 0] = np.nan
    data = written(tmp_path / "d.csv", lines(t, e))
    found = watch(monitor(sn=curve()), data, tmp_path / "r.h5")
    picture = jo.plot(found, path=tmp_path / "r.png")
    # the names of the places stand above the curves, not over their peaks
    top = picture.axes[0]
    assert top.get_legend().get_window_extent().y0 >= top.patch.get_window_extent().y1 - 1.0
    assert [ax.get_ylabel() for ax in picture.axes][:2] == ["stress (MPa)", "damage"]
    assert (tmp_path / "r.png").stat().st_size > 5000


def test_its_memory_does_not_grow():
    t, _, e = motion(400)
    one = monitor(sn=curve())
    one.push(t, e)
    size = sum(x.nbytes for x in one.save().values())
    one.push(t + 10.0, e)
    assert sum(x.nbytes for x in one.save().values()) == size


@pytest.mark.parametrize("reads", [3, 8, 1000])
def test_a_pipe_that_begins_again_is_skipped_with_its_garbage(tmp_path, reads):
    """Also where a piece holds nothing new, and after a record that is complete."""
    t, _, e = motion(900)
    text = lines(t, e)
    text[300:300] = 3 * ["garbage"]
    text[700:700] = 2 * ["1,2"]
    data = "\n".join(text).encode()
    whole = watch(monitor(sn=curve()), io.BytesIO(data), tmp_path / "w.h5")
    target = tmp_path / "r.h5"
    watch(monitor(sn=curve()), Stopped(data, reads, KeyboardInterrupt()), target)
    again = Stopped(data, 1000, KeyboardInterrupt())
    found = watch(monitor(sn=curve()), again, target, resume=True)
    assert found.complete
    np.testing.assert_array_equal(found.time, whole.time)
    np.testing.assert_allclose(found.stress, whole.stress, rtol=1e-12, atol=1e-3)
    np.testing.assert_allclose(found.summary("damage"), whole.summary("damage"), rtol=1e-9)
    assert found.summary("garbage")[-1] == whole.summary("garbage")[-1] == 5
    told = [[x.text for x in r.events if x.kind == "garbage"] for r in (found, whole)]
    assert told[0] == told[1]


def test_a_piece_of_garbage_alone_is_borne(tmp_path):
    t, _, e = motion(100)
    text = "\n".join(lines(t, e)) + "\n"
    data = (text + 2000 * "garbage\n").encode()
    found = watch(monitor(), Stopped(data, 1000, KeyboardInterrupt()), tmp_path / "r.h5")
    assert found.complete
    assert len(found) == 100
    assert sum(x.kind == "garbage" for x in found.events) == 1000


def test_only_a_cross_begins_a_comment(tmp_path):
    t, _, e = motion(100)
    text = lines(t, e)
    text[50:50] = ["# a remark", "% 12 percent"]
    found = watch(monitor(), written(tmp_path / "d.csv", text), tmp_path / "r.h5")
    assert [x.text[:8] for x in found.events if x.kind == "garbage"] == ["line 52:"]


def test_no_samples_tell_nothing():
    one = monitor(sn=curve())
    update = one.push([], np.zeros((0, 5)))
    assert update.stress.shape == (0, len(SPOTS))
    assert update.states.shape == (0, 5)
