"""Points of a study whose machines run in the lanes of one vector: as each alone, to round-off."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import jousto as jo
from jousto.design.studies import case
from jousto.mechanism.numbers import with_numbers
from jousto.model.native import ensemble
from jousto.model.variants import Variants
from jousto.simulation.running import batched_runs

pytestmark = [
    pytest.mark.skipif(ensemble.machines() == 1, reason="no build of lanes for this processor"),
    pytest.mark.filterwarnings("ignore::jousto.JoustoWarning"),
]


@pytest.fixture(autouse=True)
def in_positions(monkeypatch):
    """Trees in joint coordinates step alone; these machines are to share lanes."""
    monkeypatch.setattr(case, "Variants", functools.partial(Variants, core="maximal"))


LENGTH = jo.Parameter("length", 1.0, unit="m")
OUTCOMES = ["min(bob.y)", "max(bob.x)"]


def pendulum(length):
    """A bob on a hinge; a longer one than 2 m falls so fast that its run diverges."""
    speed = 1e14 if length > 2.0 else 1.0
    bob = jo.RigidBody("bob", 1.0, (1e-3, 1e-3, 1e-3), center=(length, 0, 0))
    pivot = jo.Revolute("pivot", jo.ground["origin"], bob["origin"])
    turned = jo.Spring("spring", pivot.angle, stiffness=speed)
    place = jo.PositionSensor("bob", bob.at((length, 0, 0)))
    return jo.Mechanism(bob, pivot, turned, jo.Gravity((0, -9.81, 0)), place)


@pytest.fixture
def groups(monkeypatch):
    """How many engines each ensemble got."""
    seen = []
    original = batched_runs.Ensemble

    def counted(engines):
        seen.append(len({id(engine) for engine in engines}))
        return original(engines)

    monkeypatch.setattr(batched_runs, "Ensemble", counted)
    return seen


def a_study():
    return jo.study(pendulum, LENGTH, OUTCOMES, t_end=0.1, solver=jo.RK4(step=1e-3))


@pytest.mark.parametrize("workers", [1, 2])
def test_a_study_gives_what_each_point_gives_alone(groups, workers):
    width = ensemble.machines()
    points = np.linspace(0.5, 1.5, 2 * width + width // 2 + 1)[:, None]  # lanes are left over
    found = a_study().run(points, workers=workers)
    assert sorted(groups) == [width // 2 + 1, width, width]
    alone = np.array([a_study()(x) for x in points[::5]])
    # 100 steps of a pendulum: round-off hardly grows
    np.testing.assert_allclose(found.y[::5], alone, rtol=0, atol=1e-12)
    assert np.ptp(found.y[:, 1]) > 0.5


def test_few_points_run_alone(groups):
    a_study().run(np.linspace(0.5, 1.5, ensemble.machines() // 2)[:, None], workers=1)
    assert groups == []


def test_a_point_that_fails_is_the_only_one(groups):
    points = np.linspace(0.5, 1.5, ensemble.machines())[:, None]
    points[2] = 2.5
    found = a_study().run(points, workers=1)
    assert groups == [len(points)]
    assert [bool(reason) for reason in found.reasons] == [k == 2 for k in range(len(points))]
    assert "diverged" in found.reasons[2]
    np.testing.assert_allclose(found.y[3], a_study()(points[3]), rtol=0, atol=1e-12)


def test_variants_share_lanes(groups):
    """Numbers written into copies of one memory."""
    mass = jo.Parameter("bob.mass", 1.0, unit="kg")
    points = np.linspace(0.5, 1.5, 2 * ensemble.machines())[:, None]
    how = {"t_end": 1.0, "solver": jo.RK4(1e-3)}
    study = jo.study(pendulum(1.0), mass, OUTCOMES, **how)
    found = study(points)
    assert groups == 2 * [ensemble.machines()] and study.counts["compilations"] == 1
    for x, y in zip(points[:, 0], found, strict=True):
        machine = with_numbers(pendulum(1.0), {"bob.mass": x})
        run = jo.simulate(jo.compile(machine, core="maximal"), **how)
        alone = run["bob"][:, 1].min(), run["bob"][:, 0].max()
        np.testing.assert_allclose(y, alone, rtol=1e-12, atol=1e-14)
    assert len(set(found[:, 0])) == len(points)
