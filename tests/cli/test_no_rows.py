"""Results without an instant: a run that was killed before its first rows, or has just begun."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from cli.test_meshes import call
from jousto.simulation.results import writer as results

COMMANDS = [
    ("plot",), ("plot", "-o", "a.png"), ("animate", "-o", "a.gif"), ("view", "-o", "a.html"),
    ("hotspots",), ("peaks",), ("stress",), ("stress", "arm", "--at", "1 s"), ("forces",),
    ("fatigue", "--sn", "S355", "--residue", "half"), ("export", "-o", "a.csv"),
    ("multiaxial",), ("strain-life", "--material", "man-ten", "--residue", "repeat"),
    ("gauges", "-o", "a.csv"), ("friction", "run.h5"),
]  # fmt: skip


def model() -> jo.Model:
    steel = jo.Material(E=210e9, nu=0.3, rho=7850)
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.025), 4, steel)
    arm = jo.FlexibleBody("arm", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2)))
    pin = jo.Revolute("pin", jo.ground["origin"], arm["start"], axis=(0, 1, 0))
    tip = jo.PositionSensor("tip", arm["end"])
    return jo.compile(jo.Mechanism(arm, pin, tip, jo.Gravity((0, 0, -9.81))))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a run, and with one that was killed before it wrote a row."""
    place = tmp_path_factory.mktemp("rows")
    machine = model()
    jo.simulate(machine, 0.01, path=place / "run.h5")
    about = {"solver": "ROS2", "chosen": "", "step": 1e-3, "t_end": 0.01}
    about |= {"gravity": machine.gravity, "evaluations_per_step": 2}
    killed = results.ResultsWriter(place / "none.h5", machine, 11, about, "")
    killed._take_place(killed._beside)  # as versions did that wrote at once
    killed._file.close()
    return place


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: words[0])
def test_a_command_says_that_there_is_no_instant(
    folder: Path, words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    name, *more = words
    code, said = call(name, "none.h5", *more)
    assert code == 2, said
    assert "none.h5: contains no instant" in " ".join(said.split())


def test_info_tells_of_it_and_python_refuses_it(folder: Path) -> None:
    code, said = call("info", folder / "none.h5")
    assert code == 0 and "running or killed" in said
    with pytest.raises(jo.InputError, match="contains no instant"):
        jo.load(folder / "none.h5")


# -- what a new run does to the results that stand at its path -------------------------------


def begin_and_fail(machine: jo.Model, path: Path, when: Callable[[], None]) -> None:
    """Begin a run that ends before its first row."""

    def push(t: float) -> float:
        when()
        raise ArithmeticError("no value")

    with pytest.raises(jo.JoustoError):
        jo.simulate(machine, 0.01, path=path, inputs={"push": push})


def driven() -> jo.Model:
    body = jo.RigidBody("cart", 1.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    push = jo.JointForce("push", rail.displacement, jo.Input("push", 1.0))
    place = jo.CoordinateSensor("place", rail.displacement)
    return jo.compile(jo.Mechanism(body, rail, push, place))


def test_old_results_stay_until_the_first_rows_are_written(tmp_path: Path) -> None:
    machine, path = driven(), tmp_path / "run.h5"
    jo.simulate(machine, 0.02, path=path)
    before = path.read_bytes()
    seen = []
    begin_and_fail(machine, path, lambda: seen.append(jo.load(path).nt))
    assert seen == [21]
    assert path.read_bytes() == before
    assert [file.name for file in tmp_path.iterdir()] == ["run.h5"]
    run = jo.simulate(machine, 0.01, path=path)
    assert run.nt == jo.load(path).nt == 11
    assert [file.name for file in tmp_path.iterdir()] == ["run.h5"]


def test_a_run_is_readable_at_its_path_from_its_first_rows_on(tmp_path: Path) -> None:
    """And whoever has the old results open is told that they were replaced."""
    machine, path = driven(), tmp_path / "run.h5"
    old = jo.simulate(machine, 0.02, path=path)
    seen: list[int] = []

    def push(t: float) -> float:
        if t >= 0.005:
            seen.append(jo.load(path).nt)
        return 1.0

    run = jo.simulate(machine, 0.01, path=path, inputs={"push": push})
    assert run.nt == 11 and seen and all(0 < n <= 11 for n in seen)
    with pytest.raises(jo.InputError, match="overwritten by another run"):
        old["place"]
    assert np.isclose(run["place"][-1, 0], 0.5 * 0.01**2)


def test_a_link_keeps_pointing_at_the_file_that_is_replaced(tmp_path: Path) -> None:
    machine = driven()
    real, link = tmp_path / "real.h5", tmp_path / "link.h5"
    jo.simulate(machine, 0.02, path=real)
    link.symlink_to(real)
    jo.simulate(machine, 0.01, path=link)
    assert link.is_symlink() and jo.load(real).nt == 11
