"""Functional mock-up units, run by FMPy: descriptions, trajectories, states, wrong calls."""

from __future__ import annotations

import io
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import jousto as jo
from export.test_states import chain
from exported import CC, STEP, compiled, engine_rows, swinging_arm
from jousto.export.fmu import write_fmu

fmpy = pytest.importorskip("fmpy")
pytestmark = [
    pytest.mark.skipif(CC is None or sys.platform == "win32", reason="no C compiler"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
]


@pytest.fixture(scope="module")
def arm() -> jo.Model:
    return jo.compile(swinging_arm())


@pytest.fixture(scope="module")
def units(arm: jo.Model, tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    folder = tmp_path_factory.mktemp("units")
    made = {}
    for version in (2, 3):
        out = folder / f"arm{version}.fmu"
        made[version] = write_fmu(arm, out, jo.ROS2(step=STEP), version=version, stop=0.4)
    return made


@pytest.fixture(scope="module", params=(2, 3))
def unit(request: Any, units: dict[int, Path]) -> Path:
    return units[request.param]


@pytest.fixture(scope="module")
def rows(tmp_path_factory: pytest.TempPathFactory) -> np.ndarray:
    return engine_rows(tmp_path_factory.mktemp("rows"), 0.4, 10)


def values(found: Any) -> np.ndarray:
    return np.stack([found[name] for name in found.dtype.names], axis=1)


def test_fmpy_finds_nothing_wrong_in_the_description(unit: Path) -> None:
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(unit)) == []
    about = fmpy.read_model_description(str(unit))
    found = {x.name: x for x in about.modelVariables}
    assert (found["push"].causality, found["push"].start) == ("input", "1.5")
    assert found["spring.stiffness"].unit == "N/m" and found["gravity.z"].start == "-9.81"
    assert [x for x in found if x.startswith("life") and found[x].causality == "output"]
    assert found["tip.x"].displayUnit == "mm"
    assert about.modelExchange is None  # it has an event, stick-slip and damage


def test_co_simulation_has_a_method_of_order_3(arm: jo.Model, tmp_path: Path) -> None:
    out = tmp_path / "arm.fmu"
    write_fmu(arm, out, jo.simulation.ROS3A(step=STEP), version=2, stop=0.2)
    found = fmpy.simulate_fmu(
        str(out), stop_time=0.2, output_interval=0.04, fmi_type="CoSimulation"
    )
    rows = engine_rows(tmp_path, 0.2, 5, solver="ROS3A")
    assert np.array_equal(values(found)[:, 1:], rows[:, 1:])


def test_co_simulation_computes_the_bits_of_the_engine(unit: Path, rows: np.ndarray) -> None:
    found = fmpy.simulate_fmu(
        str(unit), stop_time=0.4, output_interval=0.04, fmi_type="CoSimulation"
    )
    assert np.array_equal(values(found)[:, 1:], rows[:, 1:])
    assert np.abs(found["time"] - rows[:, 0]).max() < 1e-12


@pytest.fixture
def slave(unit: Path, tmp_path: Path) -> Iterator[Any]:
    """Return a function that makes an instance of the unit in its step mode."""
    about = fmpy.read_model_description(str(unit))
    folder = fmpy.extract(str(unit), str(tmp_path / "unit"))
    made = []

    def one(name: str = "one") -> Any:
        given = {"guid": about.guid, "unzipDirectory": folder, "instanceName": name}
        given["modelIdentifier"] = about.coSimulation.modelIdentifier
        two = about.fmiVersion.startswith("2")
        kind = fmpy.fmi2.FMU2Slave if two else fmpy.fmi3.FMU3Slave
        it = kind(**given)
        it.instantiate()
        if two:
            it.setupExperiment(startTime=0.0)
        it.enterInitializationMode()
        it.exitInitializationMode()
        made.append(it)
        it.names = {x.name: x.valueReference for x in about.modelVariables}
        it.get = it.getReal if two else it.getFloat64
        it.set = it.setReal if two else it.setFloat64
        it.take, it.give = (
            (it.getFMUState, it.setFMUState) if two else (it.getFMUState, it.setFMUState)
        )
        return it

    yield one
    for it in made:
        it.freeInstance()


def outputs(it: Any) -> list[float]:
    return list(it.get([it.names[x] for x in ("tip.x", "tip.z", "stress.e1.a.top:s11")]))


def test_instances_are_independent_and_go_back_to_a_state(slave: Any) -> None:
    one, two = slave("one"), slave("two")
    for k in range(20):
        one.doStep(k * STEP, STEP)
        two.doStep(k * STEP, STEP)
    assert outputs(one) == outputs(two)
    kept = one.take()
    one.set([one.names["push"]], [8.0])
    one.set([one.names["spring.stiffness"]], [900.0])
    one.doStep(20 * STEP, 100 * STEP)
    two.doStep(20 * STEP, 100 * STEP)
    assert outputs(one) != outputs(two)
    one.give(kept)
    assert one.get([one.names["push"], one.names["spring.stiffness"]]) == [1.5, 300.0]
    one.doStep(20 * STEP, 100 * STEP)
    assert outputs(one) == outputs(two)
    one.freeFMUState(kept)


def test_states_are_bytes_that_another_instance_reads(slave: Any) -> None:
    one, two = slave("one"), slave("two")
    one.doStep(0.0, 50 * STEP)
    state = one.take()
    data = bytes(one.serializeFMUState(state))
    one.freeFMUState(state)
    other = two.deSerializeFMUState(data) if hasattr(two, "deSerializeFMUState") else None
    other = two.deserializeFMUState(data) if other is None else other
    two.give(other)
    two.freeFMUState(other)
    one.doStep(50 * STEP, 50 * STEP)
    two.doStep(50 * STEP, 50 * STEP)
    assert outputs(one) == outputs(two)


def test_steps_and_values_that_cannot_be_are_refused(slave: Any) -> None:
    it = slave()
    for start, length in ((0.0, 0.7 * STEP), (0.5, STEP), (0.0, -STEP), (0.0, np.nan)):
        with pytest.raises(Exception, match="[Ss]tatus|returned|failed|error"):
            it.doStep(start, length)
    for name, value in (("push", np.nan), ("tip.x", 1.0)):
        with pytest.raises(Exception, match="[Ss]tatus|returned|failed|error"):
            it.set([it.names[name]], [value])
    it.doStep(0.0, STEP)  # it is as it was
    assert it.get([0]) == [STEP]


def test_reset_starts_anew(slave: Any) -> None:
    one, two = slave("one"), slave("two")
    one.set([one.names["push"]], [3.0])
    one.doStep(0.0, 50 * STEP)
    one.reset()
    if hasattr(one, "setupExperiment"):
        one.setupExperiment(startTime=0.0)
    one.enterInitializationMode()
    one.exitInitializationMode()
    one.doStep(0.0, 20 * STEP)
    two.doStep(0.0, 20 * STEP)
    assert outputs(one) == outputs(two)


@pytest.mark.parametrize("version", [2, 3])
def test_model_exchange_of_a_pendulum_comes_to_the_run_of_the_engine(
    version: int, tmp_path: Path
) -> None:
    """CVode's error falls with its tolerance; its own limit here is Baumgarte's drift."""
    rod = jo.RigidBody("rod", 2.0, (0.01, 0.2, 0.2), center=(0.5, 0, 0), markers={"tip": (1, 0, 0)})
    pin = jo.Revolute("pin", jo.ground["origin"], rod["origin"], axis=(0, 1, 0))
    tip = jo.PositionSensor("tip", rod["tip"])
    model = jo.compile(jo.Mechanism(rod, pin, tip, jo.Gravity((0, 0, -9.81))))
    unit = write_fmu(model, tmp_path / "rod.fmu", version=version)
    exact = jo.simulate(model, 0.5, solver=jo.RK4(step=1e-4), output_step=0.05)["tip"]
    errors = []
    for tolerance in (1e-4, 1e-8):
        found = fmpy.simulate_fmu(
            str(unit),
            stop_time=0.5,
            output_interval=0.05,
            fmi_type="ModelExchange",
            relative_tolerance=tolerance,
        )
        errors.append(np.abs(values(found)[:, 1:] - exact).max())
    assert errors[1] < 2e-6 and errors[1] < 0.05 * errors[0]


@pytest.mark.parametrize("offers_exchange", [False, True])
def test_a_unit_of_sources_builds_elsewhere(
    arm: jo.Model, offers_exchange: bool, tmp_path: Path
) -> None:
    """The sources as the build description lists them, with a driver that calls at random."""
    model = chain() if offers_exchange else arm
    unit = write_fmu(model, tmp_path / "arm.fmu", jo.ROS2(step=STEP), on=())
    with zipfile.ZipFile(unit) as archive:
        names = archive.namelist()
        assert not [x for x in names if x.startswith("binaries/")]
        recipe = archive.read("sources/buildDescription.xml").decode()
        archive.extractall(tmp_path)
    sources = tmp_path / "sources"
    files = sorted(path.name for path in sources.glob("*.c"))
    assert all(f'name="{name}"' in recipe for name in files)
    token = fmpy.read_model_description(str(unit)).instantiationToken
    shutil.copy(Path(__file__).with_name("fuzz.c"), sources)
    sanitize = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-O0")
    program = compiled(sources, *files, "fuzz.c", flags=("-DJO_NO_ALLOCATION", *sanitize))
    done = subprocess.run([program, token, "600"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    assert "600 sequences" in done.stdout
    assert (", 0 of model exchange" not in done.stdout) == offers_exchange


def test_what_cannot_be_written_is_told_at_once(arm: jo.Model, tmp_path: Path) -> None:
    with pytest.raises(jo.InputError) as error:
        write_fmu(arm, tmp_path / "arm.fmu", version=4, stop=-1.0)
    assert "version is 4" in str(error.value) and "stop is -1" in str(error.value)
    with pytest.raises(jo.InputError, match="no 'x86_64-linus'; did you mean 'x86_64-linux'"):
        write_fmu(arm, tmp_path / "arm.fmu", on=("x86_64-linus",))


@pytest.mark.parametrize("version", [2, 3])
def test_a_unit_has_a_picture_and_a_page_that_shows_it(
    version: int, arm: jo.Model, tmp_path: Path
) -> None:
    """FMI 2.0 has model.png at the top, FMI 3.0 an icon; sources alone are enough here."""
    out = jo.write(arm, tmp_path / "arm.fmu", version=version, on=())
    place = "model.png" if version == 2 else "terminalsAndIcons/icon.png"
    with zipfile.ZipFile(out) as archive:
        picture = archive.read(place)
        assert archive.read("documentation/model.png") == picture
        page = archive.read("documentation/index.html").decode()
    with Image.open(io.BytesIO(picture)) as image:
        assert len(image.convert("RGB").getcolors(1 << 24)) > 20, "something is drawn"
    assert '<img src="model.png"' in page and "spring.stiffness" in page
    # of those who write the unit without a picture the page has none
    plain = write_fmu(arm, tmp_path / "plain.fmu", version=version, on=())
    with zipfile.ZipFile(plain) as archive:
        assert "<img" not in archive.read("documentation/index.html").decode()
