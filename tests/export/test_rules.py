"""What importers may do with an instance, as the Reference FMUs of the standard are tested:
reset at any time, states kept and given back in the middle, instances side by side, early ends."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from exported import CC, STEP
from jousto.export.fmu import write_fmu

fmpy = pytest.importorskip("fmpy")
pytestmark = [
    pytest.mark.skipif(CC is None or sys.platform == "win32", reason="no C compiler"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
]

FAILED = "[Ss]tatus|returned|failed|error"


def pendulum() -> jo.Mechanism:
    """A pendulum that is pushed, with friction that sticks, and an event that stops it."""
    rod = jo.RigidBody("rod", 2.0, (0.01, 0.2, 0.2), center=(0.5, 0, 0), markers={"tip": (1, 0, 0)})
    pin = jo.Revolute("pin", jo.ground["origin"], rod["origin"], axis=(0, 1, 0))
    push = jo.JointForce("push", pin.angle, jo.Input("push", 2.0))
    rub = jo.Friction("rub", pin, 0.1, 0.12, radius=0.02, law=jo.mechanism.StickSlip())
    tip = jo.PositionSensor("tip", rod["tip"])
    stop = jo.mechanism.Event("deep", tip, component="z", threshold=-0.5, stop=True)
    return jo.Mechanism(rod, pin, push, rub, tip, stop, jo.Gravity((0, 0, -9.81)))


@pytest.fixture(scope="module")
def model() -> jo.Model:
    return jo.compile(pendulum())


@pytest.fixture(scope="module", params=(2, 3))
def unit(request: Any, model: jo.Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("rules") / "pendulum.fmu"
    return write_fmu(model, out, jo.RK4(step=STEP), version=request.param)


class Instance:
    """An instance of the unit with the names of one version for those of both."""

    def __init__(self, about: Any, folder: str, name: str, **how: Any) -> None:
        self.two = about.fmiVersion.startswith("2")
        kind = fmpy.fmi2.FMU2Slave if self.two else fmpy.fmi3.FMU3Slave
        self.it = kind(
            guid=about.guid,
            unzipDirectory=folder,
            instanceName=name,
            modelIdentifier=about.coSimulation.modelIdentifier,
        )
        self.it.instantiate(**how)
        self.refs = {x.name: x.valueReference for x in about.modelVariables}
        self.read = self.it.getReal if self.two else self.it.getFloat64
        self.write = self.it.setReal if self.two else self.it.setFloat64
        self.time = 0.0

    def begin(self) -> Instance:
        if self.two:
            self.it.setupExperiment(startTime=0.0)
        self.it.enterInitializationMode()
        self.it.exitInitializationMode()
        self.time = 0.0
        return self

    def reset(self) -> Instance:
        self.it.reset()
        return self

    def get(self, *names: str) -> list[float]:
        return list(self.read([self.refs[name] for name in names]))

    def set(self, name: str, value: float) -> None:
        self.write([self.refs[name]], [value])

    def go(self, steps: int) -> list[float]:
        for _ in range(steps):
            self.it.doStep(self.time, STEP)
            self.time += STEP
        return self.get("tip.x", "tip.z", "push", "gravity.z")


@pytest.fixture
def make(unit: Path, tmp_path: Path) -> Iterator[Callable[..., Instance]]:
    about = fmpy.read_model_description(str(unit))
    folder = fmpy.extract(str(unit), str(tmp_path / "unit"))
    made: list[Instance] = []

    def one(name: str = "one", **how: Any) -> Instance:
        made.append(Instance(about, folder, name, **how))
        return made[-1]

    yield one
    for instance in made:
        instance.it.freeInstance()


def upset(one: Instance) -> None:
    """Leave nothing as it was: an input, parameters, the motion."""
    one.set("push", 9.0)
    one.set("gravity.z", -1.0)
    one.set("rub.mu_kinetic", 0.5)


def test_reset_is_allowed_at_any_time(make: Callable[..., Instance]) -> None:
    """Instantiated, initialising, stepping, ended, and after a step that failed."""
    fresh = make("fresh").begin().go(100)
    one = make()
    one.reset().reset()
    upset(one)
    assert one.reset().begin().go(100) == fresh, "instantiated"
    upset(one.reset())
    if one.two:
        one.it.setupExperiment(startTime=0.0)
    one.it.enterInitializationMode()
    upset(one)
    assert one.reset().begin().go(100) == fresh, "initialising"
    upset(one)
    one.go(50)
    assert one.reset().begin().go(100) == fresh, "stepping"
    one.it.terminate()
    assert one.reset().begin().go(100) == fresh, "ended"
    with pytest.raises(Exception, match=FAILED):
        one.it.doStep(one.time, -STEP)
    assert one.reset().begin().go(100) == fresh, "after a step that was refused"
    one.set("gravity.z", -1e300)
    with pytest.raises(Exception, match=FAILED):
        for _ in range(5):
            one.go(1)
    assert one.reset().begin().go(100) == fresh, "after the motion diverged"


def test_states_go_back_in_the_middle_and_as_often_as_one_likes(
    make: Callable[..., Instance],
) -> None:
    one = make().begin()
    one.go(60)
    kept, at = one.it.getFMUState(), one.time
    ahead = one.go(60)
    for end in (lambda: None, lambda: one.it.terminate(), lambda: one.reset()):
        end()
        one.it.setFMUState(kept)
        one.time = at
        upset(one)
        assert one.go(60) != ahead
        one.it.setFMUState(kept)
        one.time = at
        assert one.get("push", "gravity.z") == [2.0, -9.81]
        assert one.go(60) == ahead
    # an earlier and a later state, in any order
    later, then = one.it.getFMUState(), one.time
    beyond = one.go(20)
    one.it.setFMUState(kept)
    one.time = at
    one.go(7)
    one.it.setFMUState(later)
    one.time = then
    assert one.go(20) == beyond
    for state in (kept, later):
        one.it.freeFMUState(state)


def test_instances_side_by_side_know_nothing_of_each_other(make: Callable[..., Instance]) -> None:
    """In turns, with other inputs and parameters, one of them reset on the way."""
    alone = []
    for push in (2.0, 5.0):
        one = make(f"alone {push}").begin()
        one.set("push", push)
        alone.append([one.go(10) for _ in range(12)])
    one, two = make("one").begin(), make("two").begin()
    one.set("push", 2.0)
    two.set("push", 5.0)
    found: list[list[list[float]]] = [[], []]
    for k in range(12):
        found[0].append(one.go(10))
        found[1].append(two.go(10))
        if k == 5:
            two.reset().begin()
            two.set("push", 5.0)
            found[1] = [two.go(10) for _ in range(6)]
    assert found == alone


def until_the_end(one: Instance) -> tuple[Any, float]:
    """Ask for a step over the event; return what the step returned and when the machine stands."""
    one.go(100)
    if one.two:
        with pytest.raises(Exception, match=FAILED):
            one.it.doStep(one.time, 1.0)
        status = ctypes.c_int()
        one.it.fmi2GetBooleanStatus(one.it.component, 3, ctypes.byref(status))
        reached = ctypes.c_double()
        one.it.fmi2GetRealStatus(one.it.component, 2, ctypes.byref(reached))
        return bool(status.value), reached.value
    event, terminate, early, reached = one.it.doStep(one.time, 1.0)
    return (event, terminate, early), reached


def test_an_event_that_stops_ends_a_step_early(
    make: Callable[..., Instance], model: jo.Model
) -> None:
    """The instant is that of the engine's own run, to a step; the importer is told to end."""
    run = jo.simulate(model, 2.0, solver=jo.RK4(step=STEP))
    end = float(run.time[-1])
    assert end < 1.5 and run["tip"][-1, 2] <= -0.5 + 1e-9
    one = make().begin()
    said, reached = until_the_end(one)
    assert abs(reached - end) < 1e-9
    assert one.get("time")[0] == reached and abs(one.get("tip.z")[0] + 0.5) < 1e-6
    if one.two:
        assert said is True  # terminated
    else:
        # early return was not allowed: the step is not called one, the end is
        assert said == (False, True, False)
        allowed = make("allowed", earlyReturnAllowed=True).begin()
        said, reached = until_the_end(allowed)
        assert said == (False, True, True) and abs(reached - end) < 1e-9
    one.it.terminate()
    assert np.isfinite(one.get("tip.x")[0]), "values can still be read"
