"""Arguments of a wrong kind: sentences with name, value and remedy, never raw errors."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest

import jousto as jo
import misuse
from jousto.base.arguments import HOW, explained, misfits
from session import STEEL, objects, public

FAST = ("text", "number", "none", "object")


@pytest.fixture(scope="module")
def calls(tmp_path_factory: pytest.TempPathFactory) -> dict[str, misuse.Call]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return misuse.calls(tmp_path_factory.mktemp("misuse"))


@pytest.mark.filterwarnings("ignore")
def test_the_calls_work_before_they_are_spoilt(
    calls: dict[str, misuse.Call], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, (what, given) in calls.items():
        if name not in misuse.NO_FILE:
            what(**given)
    plt.close("all")


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    "kind",
    [pytest.param(k, marks=() if k in FAST else pytest.mark.slow) for k in misuse.WRONG],
)
def test_spoilt_arguments_are_told_in_sentences(
    kind: str, calls: dict[str, misuse.Call], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each argument of each public function; some take the value, none fails in the depths."""
    monkeypatch.chdir(tmp_path)
    raw = []
    for name, (what, given) in calls.items():
        for argument in misuse.arguments(what):
            if misuse.WRONG[kind] is misuse.value_of(what, given, argument):
                continue  # nothing is spoilt
            try:
                what(**{**given, argument: misuse.WRONG[kind]})
            except jo.JoustoError:
                pass
            except Exception as error:
                raw.append(f"{name}, {argument}: {type(error).__name__}: {error}")
        plt.close("all")
    assert not raw, "\n".join(raw)


def test_calls_cover_the_public_functions(calls: dict[str, misuse.Call]) -> None:
    functions = {
        place.rpartition(".")[2]
        for place, x in public().items()
        if callable(x) and not isinstance(x, type)
    }
    assert functions - {"ground", "time"} - set(calls) <= misuse.NOT_CALLED | misuse.SPECIAL


def sentence(what: Any, *given: Any, **named: Any) -> str:
    with pytest.raises(jo.InputError) as error:
        what(*given, **named)
    return str(error.value)


def test_what_newcomers_wrote() -> None:
    made = objects()
    arm, ball = made["mechanism"].bodies
    model, mesh, field = made["model"], made["mesh"], made["field"]
    hinge = made["mechanism"].joints[0]
    assert sentence(jo.StressSensor, "s", arm, (0.1, 0, 0.02)) == (
        "sensor 's': sites is (0.1, 0, 0.02), must be labels such as 'e1.a.top'; the site "
        "nearest to a point is arm.reduced.stress.nearest((x, y, z))"
    )
    for wrong in ("S355", STEEL):
        said = sentence(jo.damage_field, field, wrong, residue="half")
        assert said.startswith("damage_field: sn is ") and "jo.fatigue.estimate_sn('S355')" in said
    said = sentence(jo.damage_field, made["run"], made["curve"], residue="half")
    assert said.endswith("must be a StressField or a DutyCycle: jo.stress_field(run, body)")
    named = "get it from the library by jo.material('S355')"
    assert named in sentence(jo.Part.solid, mesh, "S355")
    assert named in sentence(jo.Part.beam, 1.0, jo.Circle(0.01), 2, "S355")
    assert named in sentence(jo.Member, (0, 0, 0), (1, 0, 0), jo.Circle(0.01), "S355")
    ends = [(0, 0, 0), (1, 0, 0)]
    assert named in sentence(jo.BeamBody, "b", ends, jo.Circle(0.01), "S355", elements=2)
    assert sentence(jo.simulate, model, "1 s") == "simulate: t_end is '1 s', must be a number"
    assert "must be a Model: jo.compile(mechanism)" in sentence(jo.equilibrium, made["run"])
    assert "jo.simulate(model, t_end) or jo.load(path)" in sentence(jo.animate, "x.h5", "x.gif")
    assert "bodies is <FlexibleBody 'arm': 10 modes>" in sentence(
        jo.hot_spots, made["run"], bodies=arm
    )
    assert "must be a number or a signal" in sentence(jo.Drive, "d", hinge.angle, "1 rad/s")


def test_a_number_is_a_constant_signal() -> None:
    ball = jo.RigidBody("ball", 1.0, (1.0, 1.0, 1.0))
    for kind in (jo.Force, jo.Torque):
        force = kind("f", ball["origin"], (1.0, 0.0, 0.0), signal=5.0)
        assert repr(force.signal) == repr(jo.Constant(5.0))
    slide = jo.Prismatic("guide", jo.ground["origin"], ball["origin"], axis=(1, 0, 0))
    push = jo.Force("push", ball["origin"], (1.0, 0.0, 0.0), signal=5.0)
    position = jo.PositionSensor("x", ball["origin"])
    model = jo.compile(jo.Mechanism(ball, slide, push, position))
    run = jo.simulate(model, 1.0, solver=jo.RK4(1e-2))
    # x = F t^2 / (2 m), which RK4 integrates exactly; 1e-12 of 2.5 m is its rounding in 100 steps
    assert run["x.x"][-1] == pytest.approx(2.5, abs=2.5e-12)


def test_a_hole_of_a_mesh_is_an_interface() -> None:
    mesh, hole = objects()["mesh"], objects()["hole"]
    one, other = (
        jo.Part.solid(mesh, STEEL, interfaces=[jo.Interface("bore", nodes)]).ties[0]
        for nodes in (hole, hole.nodes)
    )
    np.testing.assert_array_equal(one.nodes, other.nodes)
    np.testing.assert_array_equal(one.at, other.at)


def test_bodies_are_no_sequences() -> None:
    arm, ball = objects()["mechanism"].bodies
    for body in (arm, ball, objects()["arch"], jo.ground):
        with pytest.raises(TypeError, match="not iterable"):
            iter(body)


# -- the rule itself -------------------------------------------------------------------------------


@explained
def example(x: float, names: list[str] | None = None, *, run: jo.Solution | None = None) -> float:
    return x + len([name.upper() for name in names or ()]) + len(run or ())


def test_only_failed_calls_are_looked_at() -> None:
    assert example(True) == 1  # not a number, but it works
    assert sentence(example, "a") == "example: x is 'a', must be a number"
    assert sentence(example, 1.0, names=[1]) == "example: names is [1], must be texts or None"
    assert "run is 3, must be a Solution" in sentence(example, 1.0, run=3)
    with pytest.raises(TypeError, match="unexpected keyword argument 'y'"):
        example(1.0, y=2.0)  # type: ignore[call-arg]


def test_an_error_that_is_not_the_callers_stays_what_it_is() -> None:
    @explained
    def broken(x: float) -> float:
        raise TypeError(f"inside {x}")

    with pytest.raises(TypeError, match="inside 1.0"):
        broken(1.0)


def test_sources_of_objects_exist() -> None:
    for text in HOW.values():
        for name in text.replace("jo.", " jo.").split():
            if name.startswith("jo."):
                thing: Any = jo
                for word in re.findall(r"\w+", name[3:].split("(")[0]):
                    thing = getattr(thing, word)


def test_nothing_is_blamed_in_calls_that_work(calls: dict[str, misuse.Call]) -> None:
    for name, (what, given) in calls.items():
        if not isinstance(what, type) and name not in misuse.NO_FILE:
            function = getattr(what, "__func__", what)
            me = (what.__self__,) if hasattr(what, "__self__") else ()
            assert misfits(function, name, me, given) == []
