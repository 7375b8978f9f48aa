"""Machines and results travel to other processes and back."""

from __future__ import annotations

import multiprocessing
import pickle
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import MissingFileError, Problem
from jousto.base.frozen_dict import Frozen
from jousto.simulation.running.simulate import RunInterrupted


def arm(angle: float = 0.0) -> jo.Mechanism:
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
    part = jo.Part.beam(length=1.0, section=jo.Rectangle(0.01, 0.02), elements=4, material=steel)
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=2))
    body = jo.FlexibleBody("arm", reduced)
    return jo.Mechanism(
        body,
        jo.Revolute("pivot", jo.ground["origin"], body["start"], axis=(0, np.sin(angle), 1)),
        jo.Gravity((0, -9.81, 0)),
        jo.PositionSensor("tip", body["end"]),
    )


def simulated(mechanism: jo.Mechanism) -> jo.Solution:
    return jo.simulate(jo.compile(mechanism), 0.05, solver=jo.RK4(1e-4), output_step=0.01)


def test_a_study_in_processes_gives_what_one_process_gives():
    """The same build runs the same instructions there, so equal means equal."""
    machines = [arm(), arm(0.3)]
    # a fresh interpreter, as on Windows and macOS
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(2, mp_context=fresh) as pool:
        runs = list(pool.map(jo.compile, machines))
    for mechanism, model in zip(machines, runs, strict=True):
        here = simulated(mechanism)
        back = jo.simulate(model, 0.05, solver=jo.RK4(1e-4), output_step=0.01)
        np.testing.assert_array_equal(back["tip"], here["tip"])
        again = pickle.loads(pickle.dumps(back))
        np.testing.assert_array_equal(again["tip"], here["tip"])
        assert again.stressed == here.stressed == ("arm",)


def test_a_frozen_mapping_stays_as_it_is():
    found = pickle.loads(pickle.dumps(Frozen({"b": 1, "a": 2})))
    assert dict(found) == {"b": 1, "a": 2}
    assert list(found) == ["b", "a"]
    with pytest.raises(TypeError):
        found["c"] = 3


def test_errors_keep_what_they_know_in_another_process():
    """A pool passes errors by pickling; one bad run must not end the others."""
    run = simulated(arm())
    found = [
        jo.InputError([Problem("a", "one"), Problem("b", "two")]),
        MissingFileError(Problem("x.yaml", "no such file")),
        jo.SimulationError("diverged", time=0.25, body="arm"),
        jo.simulation.RunFailed("diverged", run, time=0.25, body="arm"),
        RunInterrupted("stopped", run),
    ]
    for error in found:
        back = pickle.loads(pickle.dumps(error))
        assert type(back) is type(error)
        assert str(back) == str(error)
        for name in ("problems", "time", "body"):
            assert getattr(back, name, None) == getattr(error, name, None)
        if hasattr(error, "solution"):
            np.testing.assert_array_equal(back.solution["tip"], run["tip"])
