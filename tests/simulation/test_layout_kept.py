"""The layout of a results file is made once for runs of one model and one length."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

import jousto as jo
from jousto.simulation.results import writer as results


@pytest.fixture
def model():
    body = jo.RigidBody("b", 2.0, (0.1, 0.2, 0.2), center=(0.5, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["origin"], (0, 1, 0))
    tip = jo.PositionSensor("tip", body["origin"])
    return jo.compile(jo.Mechanism(body, hinge, tip, jo.Gravity((0, 0, -9.81))))


def content(path):
    """Return all attributes and data of a file but the moments and the identity of the run."""
    found = {}

    def take(name, item):
        found.update({(name, key): np.array(x).tolist() for key, x in item.attrs.items()})
        if isinstance(item, h5py.Dataset):
            found[name] = np.array(item[()]).tolist()

    with h5py.File(path) as file:
        take("/", file)
        file.visititems(take)
    return {k: x for k, x in found.items() if k[-1] not in ("run", "wall_time", "real_time_factor")}


def run(model, path, step=1e-3):
    return jo.simulate(model, 0.02, solver=jo.RK4(step), output_step=2e-3, path=path)


def test_it_is_made_once(model, tmp_path, monkeypatch):
    made = []
    describe = results._describe
    monkeypatch.setattr(results, "_describe", lambda *a: made.append(1) or describe(*a))
    for name in "abc":
        run(model, tmp_path / f"{name}.h5")
    assert len(made) == 1


def test_files_hold_what_they_would_alone(model, tmp_path):
    run(model, tmp_path / "first.h5", step=5e-4)
    run(model, tmp_path / "again.h5")
    results._LAID.clear()
    run(model, tmp_path / "alone.h5")
    again, alone = content(tmp_path / "again.h5"), content(tmp_path / "alone.h5")
    differing = {k for k in again.keys() | alone.keys() if str(again.get(k)) != str(alone.get(k))}
    assert not differing
    with h5py.File(tmp_path / "first.h5") as a, h5py.File(tmp_path / "again.h5") as b:
        assert a.attrs["run"] != b.attrs["run"]


def test_a_killed_run_is_read_as_one(model, tmp_path, monkeypatch):
    whole = run(model, tmp_path / "whole.h5")
    monkeypatch.setattr(results.ResultsWriter, "close", lambda self, *a: self._file.close())
    run(model, tmp_path / "killed.h5")
    with h5py.File(tmp_path / "killed.h5") as file:
        assert file.attrs["complete"] == 0
        assert b"killed" in bytes(file.attrs["ended"])
        assert file["rows"][()] == len(whole.time)
    killed = jo.load(tmp_path / "killed.h5")
    np.testing.assert_array_equal(killed["tip"], whole["tip"])
