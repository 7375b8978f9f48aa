"""Contact forces for the arrows of the viewer: runs, files, saved pages, live machines."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.schema.read import parse_model
from jousto.simulation.live.runner import Runner
from jousto.viewer.live.session import LiveDesk
from jousto.viewer.live.sources import OpenedMachine
from jousto.viewer.queries import Answers
from jousto.viewer.standalone import contents
from jousto.viewer.viewable import scenes_of
from viewer.machines import swing

G = 9.81
CRATE, BALL = 5.0, 1.0
HIGH = 0.2
"""Height of the crate, m."""


# depths at rest: 6 kg / 4 corners, and 1 kg, times 9.81 m/s2 / 1e6 N/m
TEXT = """
name: stack
bodies:
  - {type: box, name: crate, size: [0.4, 0.3, 0.2], mass: 5, position: [0, 0, 0.099985285]}
  - {type: sphere, name: ball, radius: 0.05, mass: 1, position: [0, 0, 0.249975475]}
forces:
  - type: contacts
    name: set
    law: {type: power-law, stiffness: 1e6, exponent: 1, restitution: 0.1}
    mu_kinetic: 0.4
    overlap: start
    shapes:
      - {name: floor, marker: ground.origin, shape: {type: half-space}}
      - {name: crate, marker: crate.origin, shape: {type: cuboid, lengths: [0.4, 0.3, 0.2]}}
      - {name: ball, marker: ball.origin, shape: {type: sphere, radius: 0.05}}
gravity: [0, 0, -9.81]
"""


def run_of(path: Path | None = None) -> jo.Solution:
    """A ball at rest on a crate on the floor."""
    model = jo.compile(parse_model(TEXT).mechanism)
    text = "" if path is None else TEXT
    solver = jo.ROS2(1e-3)
    return jo.simulate(model, 0.2, solver=solver, output_step=0.01, path=path, model_text=text)


resting = functools.cache(run_of)


def ask(answers: Answers, first: int, count: int) -> dict[str, Any]:
    return answers.answer({"ask": "touches", "run": 0, "first": first, "count": count})


def at_rest(found: dict[str, Any]) -> None:
    """Check the last instant: weights, places and texts."""
    values = found["values"][-int(found["counts"][-1]) :]
    texts = [found["texts"][int(row[12])] for row in values]
    assert sorted(set(texts)) == ["set: crate - ball, sticks", "set: floor - crate, sticks"]
    for name, weight, high in (("ball", BALL, HIGH), ("floor", CRATE + BALL, 0.0)):
        rows = values[[name in text for text in texts]]
        assert rows[:, 3:6].sum(axis=0) == pytest.approx([0, 0, weight * G], abs=2e-3 * weight * G)
        assert rows[:, 7].sum() == pytest.approx(weight * G, rel=2e-3)
        assert rows[:, 2] == pytest.approx(high, abs=1e-4)
        assert (rows[:, 6] < 0).all()


def test_forces_of_a_run() -> None:
    """Arrows are the forces on the second body, of any frames; the largest one gives the scale."""
    run = resting()
    answers = Answers(scenes_of([run]))
    scene = answers.answer({"ask": "scene", "run": 0})
    assert scene["touches"] == max(event.force for event in run.contacts)
    found = ask(answers, run.nt - 3, 3)
    assert found["counts"].tolist() == [5, 5, 5]
    at_rest(found)
    # instants of a window are counted from its begin
    answers.answer({"ask": "window", "run": 0, "start": 0.1, "end": 0.2})
    assert ask(answers, 0, 1)["first"] == 0
    np.testing.assert_array_equal(ask(answers, 10, 1)["values"], found["values"][-5:])
    with pytest.raises(InputError, match="count is 1000, must be a whole number from 1 to 64"):
        ask(answers, 0, 1000)


def test_a_machine_without_contacts_pays_nothing() -> None:
    answers = Answers(scenes_of([swing()]))
    assert answers.answer({"ask": "scene", "run": 0})["touches"] is None
    assert "touches" not in contents(answers.scenes[0], 10)
    with pytest.raises(InputError, match="this scene has no contacts"):
        ask(answers, 0, 1)


def test_forces_in_a_saved_page() -> None:
    """A saved page contains the points of its instants with 7 digits."""
    found = contents(scenes_of([resting()])[0], 10)
    assert len(found["touches"]["counts"]) == len(found["time"]) == len(found["rows"])
    assert found["touches"]["values"].dtype == np.float32
    at_rest(found["touches"])


def test_forces_of_a_file(tmp_path: Path) -> None:
    """Results of a model file contain its text; those of Python say what to do."""
    path = resting().save(tmp_path / "stack.h5")
    answers = Answers(scenes_of([path]))
    with pytest.raises(InputError, match=r"stack.h5: contains no model.*jo.view\(run\) shows them"):
        ask(answers, 0, 1)
    header = contents(scenes_of([path])[0], 10)["scene"]
    assert header["touches"] is None
    assert "no arrows of contact forces. stack.h5: contains no model" in header["note"]
    run = run_of(tmp_path / "text.h5")
    at_rest(ask(Answers(scenes_of([tmp_path / "text.h5"])), run.nt - 1, 1))


def test_forces_of_a_live_machine(tmp_path: Path) -> None:
    """Each picture contains the forces of its instant; a machine without contacts sends none."""
    model, solver = resting().model, jo.ROS2(1e-3)
    assert model is not None
    made = OpenedMachine(model, solver, state=resting().state())
    runner = Runner(made.machine(None), speed=0, playing=False)
    try:
        desk = LiveDesk(made, runner, step=None, ranges={}, record=tmp_path / "x.h5")
        assert desk.scene.touches == 0.0
        for _ in range(3):
            runner.step()
        at_rest(desk.live(runner.glance)["touches"])
    finally:
        runner.close()
