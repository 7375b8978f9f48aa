"""Saved states of functional mock-up units: their kind and size; what a unit refuses to be."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import jousto as jo
from exported import CC
from jousto.export.fmu import why_not_exchanged, write_fmu

fmpy = pytest.importorskip("fmpy")
pytestmark = [
    pytest.mark.skipif(CC is None or sys.platform == "win32", reason="no C compiler"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
]

STEP = 1e-3
ERROR = 3  # fmi2Error, fmi3Error


def chain(*more: Any) -> jo.Model:
    """Return a double pendulum, whose co-simulation keeps joint coordinates besides q and v."""
    J = (0.01, 0.01, 0.01)
    one = jo.RigidBody("one", 1.0, J, center=(0.5, 0, 0))
    two = jo.RigidBody("two", 1.0, J, center=(0.5, 0, 0), position=(1, 0, 0))
    a = jo.Revolute("a", jo.ground["origin"], one["origin"], axis=(0, 1, 0))
    b = jo.Revolute("b", one.at((1, 0, 0)), two["origin"], axis=(0, 1, 0))
    angle = jo.CoordinateSensor("angle", a.angle)
    items = (one, two, a, b, angle, jo.Gravity((0, 0, -9.81)))
    return jo.compile(jo.Mechanism(*items, *(make(angle) for make in more)), core="joint")


@pytest.fixture(scope="module", params=(2, 3))
def instance(
    request: Any, tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str], Any]:  # fmt: skip
    """Return a function that makes an instance for model exchange or co-simulation."""
    return maker(chain(), request.param, tmp_path_factory.mktemp("chain"))


def maker(model: jo.Model, version: int, folder: Path) -> Callable[..., Any]:
    file = write_fmu(model, folder / "chain.fmu", jo.ROS2(step=STEP), version=version)
    about = fmpy.read_model_description(str(file))
    place = fmpy.extract(str(file), str(folder / "unit"))
    module = fmpy.fmi2 if version == 2 else fmpy.fmi3

    def make(kind: str, log: Any = None) -> Any:
        found = getattr(module, f"FMU{version}{kind}")(
            guid=about.guid, unzipDirectory=place, modelIdentifier="chain", instanceName=kind
        )
        if version == 2:
            calls = fmpy.fmi2.fmi2CallbackFunctions()
            calls.logger = fmpy.fmi2.fmi2CallbackLoggerTYPE(lambda *given: log and log(given[-1]))
            calls.allocateMemory = fmpy.fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
            calls.freeMemory = fmpy.fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
            found.instantiate(callbacks=calls)
            found.setupExperiment(startTime=0.0)
        else:
            found.instantiate(logMessage=lambda *given: log and log(given[-1]))
        found.enterInitializationMode()
        found.exitInitializationMode()
        set_state = f"fmi{version}SetFMU{'s' if version == 2 else 'S'}tate"
        found.status_of = lambda state: getattr(found.dll, set_state)(found.component, state)
        found.value = lambda: (found.getReal if version == 2 else found.getFloat64)([1])[0]
        return found

    return make


def test_a_state_belongs_to_instances_of_its_kind(instance: Callable[..., Any]) -> None:
    """The other kind has more or fewer numbers: its end would be read from foreign memory."""
    said: list[bytes] = []
    step, exchange = instance("Slave", said.append), instance("Model", said.append)
    step.doStep(0.0, 100 * STEP)
    states = {step: step.getFMUState(), exchange: exchange.getFMUState()}
    for one, other in ((step, exchange), (exchange, step)):
        before = one.value()
        assert one.status_of(states[other]) == ERROR
        assert one.value() == before
        sentence = said[-1].decode()
        assert "the state is one of" in sentence and "bytes, states of this instance" in sentence
        assert one.status_of(states[one]) == 0
    for one, state in states.items():
        one.freeFMUState(state)


def test_bytes_of_another_kind_or_length_are_refused(instance: Callable[..., Any]) -> None:
    step, exchange = instance("Slave"), instance("Model")
    mine, theirs = step.getFMUState(), exchange.getFMUState()
    serialize = "serializeFMUState"
    bytes_of = {
        one: bytes(getattr(one, serialize)(s)) for one, s in ((step, mine), (exchange, theirs))
    }
    sizes = {one: len(x) for one, x in bytes_of.items()}
    assert sizes[step] > sizes[exchange], "joint coordinates are what the other kind lacks"
    read = getattr(step, "deSerializeFMUState", None) or step.deserializeFMUState
    for data in (bytes_of[exchange], bytes_of[step][:-8], bytes_of[step] + bytes(8), b"", b"\1"):
        with pytest.raises(Exception, match="failed with status 3"):
            read(data)
    step.freeFMUState(read(bytes_of[step]))
    step.freeFMUState(mine)
    exchange.freeFMUState(theirs)


def test_memory_of_the_smaller_kind_is_not_written_over(instance: Callable[..., Any]) -> None:
    """A state that is taken into one that exists grows it: the importer may reuse its memory."""
    step, exchange = instance("Slave"), instance("Model")
    state = exchange.getFMUState()
    handle = ctypes.c_void_p(state.value if hasattr(state, "value") else state)
    two = hasattr(step.dll, "fmi2GetFMUstate")
    take = step.dll.fmi2GetFMUstate if two else step.dll.fmi3GetFMUState
    step.doStep(0.0, 10 * STEP)
    assert take(step.component, ctypes.byref(handle)) == 0
    found = step.value()
    step.doStep(10 * STEP, 10 * STEP)
    assert step.value() != found
    assert step.status_of(handle) == 0 and step.value() == found
    step.freeFMUState(handle)


@pytest.mark.parametrize("version", (2, 3))
def test_a_unit_without_model_exchange_refuses_it(version: int, tmp_path: Path) -> None:
    model = chain(lambda angle: jo.mechanism.Event("low", angle, threshold=-1.0))
    make = maker(model, version, tmp_path)
    said: list[bytes] = []
    with pytest.raises(Exception, match="[Ii]nstantiate"):
        make("Model", said.append)
    assert "co-simulation only: events" in said[-1].decode()
    assert make("Slave").value() == 0.0


@pytest.mark.slow  # compiles a unit of its own
def test_states_of_blocks_are_continuous_states_of_model_exchange(tmp_path: Path) -> None:
    """A DC motor that the importer integrates: current and speed of the precise run."""
    rotor = jo.RigidBody("rotor", 1.0, (1e-4, 1e-4, 1e-4))
    axle = jo.Revolute("axle", jo.ground["origin"], rotor["origin"], axis=(0, 0, 1))
    motor = jo.electric.DCMotor("motor", axle.angle, 12.0, 1.0, 0.5e-3, 0.05)
    current = jo.mechanism.StateSensor("i", motor["current"], unit="A")
    speed = jo.RateSensor("w", axle.angle)
    model = jo.compile(jo.Mechanism(rotor, axle, motor, current, speed))
    write_fmu(model, tmp_path / "motor.fmu", solver=jo.ROS2(1e-4))
    description = fmpy.read_model_description(tmp_path / "motor.fmu")
    states = {x.derivative.name for x in description.modelVariables if x.derivative}
    assert any(name.endswith("motor.current") for name in states)
    options = {"stop_time": 0.05, "output_interval": 0.01, "relative_tolerance": 1e-8}
    found = fmpy.simulate_fmu(tmp_path / "motor.fmu", fmi_type="ModelExchange", **options)
    precise = jo.simulation.DormandPrince(1e-10)
    run = jo.simulate(model, 0.05, solver=precise, output_step=0.01)
    assert abs(found["i"] - run["i"][:, 0]).max() < 1e-5
    assert abs(found["w"] - run["w"][:, 0]).max() < 1e-4
    brake = jo.electric.Brake("brake", axle.angle, 1.0, 1e4)
    held = jo.compile(jo.Mechanism(rotor, axle, motor, brake))
    assert "change at the ends of its own steps" in why_not_exchanged(held)
