"""Damaged and hostile records of a monitoring run: a sentence, never an internal error."""

from __future__ import annotations

import shutil

import h5py
import numpy as np
import pytest

import jousto as jo
from cli.test_meshes import call
from jousto.measurement.monitor.record_reader import MonitorRecord
from jousto.measurement.monitor.watch import watch
from measurement.monitor.watched import curve, lines, monitor, motion, written


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    folder = tmp_path_factory.mktemp("record")
    t, _, e = motion(300)
    data = written(folder / "d.csv", lines(t, e))
    watch(monitor(sn=curve()), data, folder / "r.h5")
    return folder / "r.h5"


def outcome(path) -> str:
    """Read all; return the sentence that refuses the file, empty if there is none."""
    try:
        found = MonitorRecord(path)
        for name in ("time", "strain", "states", "stress", "low", "high", "events", "model_text"):
            getattr(found, name)
        assert len(found) == len(found.time)
        assert found.stress.shape == (len(found), len(found.spots))
        if found.counted:
            found.summary("damage")
    except jo.InputError as error:
        said = str(error)
    else:
        return ""
    assert str(path) in said
    return said


def test_edited_records_are_refused_or_read(original, tmp_path):
    rng = np.random.default_rng(7)
    items: list[str] = []
    with h5py.File(original) as file:
        file.visit(items.append)
        attrs = list(file.attrs)
    path = tmp_path / "r.h5"
    makers = (
        lambda file, place: None,
        lambda file, place: file.create_group(place),
        lambda file, place: file.create_dataset(place, data="text"),
        lambda file, place: file.create_dataset(place, data=2.5),
        lambda file, place: file.create_dataset(place, (10**7, 10**6), "f8", chunks=(10, 10)),
        lambda file, place: file.__setitem__(place, h5py.SoftLink("/samples/time")),
        lambda file, place: file.__setitem__(place, h5py.ExternalLink("x.h5", "/samples")),
    )
    refused = count = 0
    for place in items:
        for k in rng.choice(len(makers), 3, replace=False):
            shutil.copy(original, path)
            with h5py.File(path, "r+") as file:
                del file[place]
                makers[k](file, place)
            refused += bool(outcome(path))
            count += 1
    for name in attrs:
        shutil.copy(original, path)
        with h5py.File(path, "r+") as file:
            file.attrs[name] = np.arange(3.0)
        refused += bool(outcome(path))
        count += 1
    assert count > 90
    assert refused > 0.6 * count


def test_damaged_records_are_refused_or_read(original, tmp_path):
    """Bits that tip and files cut short; data of a record have no checksums."""
    whole = original.read_bytes()
    rng = np.random.default_rng(8)
    path = tmp_path / "r.h5"
    used = np.flatnonzero(np.frombuffer(whole, np.uint8))
    said = []
    for at in rng.choice(used, 60):
        damaged = bytearray(whole)
        damaged[at] ^= 1 << rng.integers(8)
        path.write_bytes(damaged)
        said.append(outcome(path))
    # most bits are data, which have no checksums
    assert 0 < sum(map(bool, said)) < len(said)
    for size in rng.integers(0, len(whole) // 2, 15):
        path.write_bytes(whole[:size])
        assert outcome(path)


def test_the_command_says_a_sentence(original, tmp_path):
    path = tmp_path / "r.h5"
    shutil.copy(original, path)
    with h5py.File(path, "r+") as file:
        del file["samples/stress"]
    code, text = call("info", path)
    assert (code, "samples/stress is missing" in text) == (2, True)
