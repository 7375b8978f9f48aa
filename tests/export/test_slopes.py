"""Directional derivatives of exported units, against differences and the engine's complex build."""

from __future__ import annotations

import sys
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from exported import CC, STEP
from jousto.export import toolchain
from jousto.export.fmu import write_fmu
from jousto.model.native.native import Engine
from jousto.simulation.results.row_layout import columns

fmpy = pytest.importorskip("fmpy")
pytestmark = [
    pytest.mark.skipif(CC is None or sys.platform == "win32", reason="no C compiler"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.slow,  # the sources are compiled twice
]

QUICK = ("-std=c99", "-O1")


def arm() -> jo.Mechanism:
    """A flexible arm on a spring with a ball, friction that does not stick, and two inputs."""
    steel = jo.Material(E=210e9, nu=0.3, rho=7850)
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.025), 4, steel)
    bar = jo.FlexibleBody("arm", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2)))
    ball = jo.RigidBody.sphere("ball", 0.05, mass=2.0, position=(1.0, 0, 0))
    pin = jo.Revolute("pin", jo.ground["origin"], bar["start"], axis=(0, 1, 0))
    hold = jo.Fixed("hold", bar["end"], ball["center"])
    drive = jo.Servo("drive", pin.angle, jo.Input("angle", 0.1), kp=400.0, kd=10.0)
    push = jo.Force("push", ball["center"], (0, 0, 1), signal=jo.Input("load", 3.0))
    rub = jo.Friction("rub", pin, 0.2, radius=0.02, law=jo.mechanism.Regularised(0.01))
    return jo.Mechanism(
        *(bar, ball, pin, hold, drive, push, rub, jo.Gravity((0, 0, -9.81))),
        jo.AccelerationSensor("tip", ball["center"]),
        jo.ReactionSensor("pin", pin),
        jo.StressSensor("stress", bar, "e1.a.top"),
    )


@pytest.fixture(scope="module")
def model() -> jo.Model:
    return jo.compile(arm())


@pytest.fixture(scope="module", params=(2, 3))
def unit(request: Any, model: jo.Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("slopes") / "arm.fmu"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(toolchain, "FLAGS", QUICK)
        solver = jo.ROS2(step=STEP)
        return write_fmu(model, out, solver, version=request.param, derivatives=True)


class Instance:
    """A unit after its initialisation, for one or the other use."""

    def __init__(self, path: Path, exchange: bool) -> None:
        about = fmpy.read_model_description(str(path))
        two = about.fmiVersion.startswith("2")
        use = about.modelExchange if exchange else about.coSimulation
        # the reader knows the word of FMI 2.0 alone
        with zipfile.ZipFile(path) as archive:
            text = archive.read("modelDescription.xml").decode()
        word = f"providesDirectionalDerivative{'' if two else 's'}"
        self.provides = text.count(f'{word}="true"') == 2
        room = fmpy.fmi2 if two else fmpy.fmi3
        kind = getattr(room, f"FMU{2 if two else 3}{'Model' if exchange else 'Slave'}")
        self.it = it = kind(
            guid=about.guid,
            unzipDirectory=fmpy.extract(str(path)),
            instanceName="one",
            modelIdentifier=use.modelIdentifier,
        )
        it.instantiate()
        if two:
            it.setupExperiment(startTime=0.0)
        it.enterInitializationMode()
        it.exitInitializationMode()
        self.two = two
        self.refs = {x.name: x.valueReference for x in about.modelVariables}
        self.outputs = [x.valueReference for x in about.modelVariables if x.causality == "output"]
        self.rates = [x.valueReference for x in about.modelVariables if x.derivative is not None]
        self.states = [x.derivative.valueReference for x in about.modelVariables if x.derivative]
        self.get = it.getReal if two else it.getFloat64
        self.set = it.setReal if two else it.setFloat64

    def slope(self, unknown: list[int], known: list[int], seed: list[float]) -> np.ndarray:
        return np.array(self.it.getDirectionalDerivative(unknown, known, seed))


@pytest.fixture
def slave(unit: Path) -> Iterator[Instance]:
    made = Instance(unit, exchange=False)
    yield made
    made.it.freeInstance()


@pytest.fixture
def exchanged(unit: Path) -> Iterator[Instance]:
    made = Instance(unit, exchange=True)
    yield made
    made.it.freeInstance()


def near(found: np.ndarray, wanted: np.ndarray, tolerance: float) -> bool:
    return bool(np.abs(found - wanted).max() <= tolerance * np.abs(wanted).max())


@pytest.mark.parametrize(
    "known,step", [("load", 1e-2), ("angle", 1e-5), ("gravity.z", 1e-3), ("drive.stiffness", 1e-2)]
)
def test_outputs_change_with_inputs_and_parameters_as_differences_say(
    slave: Instance, known: str, step: float
) -> None:
    """In the middle of a run; differences of order 2 of numbers with 16 digits keep 8 and more."""
    assert slave.provides
    for k in range(40):
        slave.it.doStep(k * STEP, STEP)
    ref = slave.refs[known]
    [at] = slave.get([ref])
    sides = []
    for sign in (1.0, -1.0):
        slave.set([ref], [at + sign * step])
        sides.append(np.array(slave.get(slave.outputs)))
    slave.set([ref], [at])
    kept = slave.get(slave.outputs)
    found = slave.slope(slave.outputs, [ref], [1.0])
    assert near(found, (sides[0] - sides[1]) / (2 * step), 1e-6)
    assert np.abs(found).max() > 0
    assert slave.get(slave.outputs) == kept, "nothing of the machine changes"
    # seeds are a direction: linear in each of them
    both = slave.slope(slave.outputs, [ref, slave.refs["load"]], [2.0, -3.0])
    other = slave.slope(slave.outputs, [slave.refs["load"]], [1.0])
    assert near(both, 2.0 * found - 3.0 * other, 1e-12)


def test_they_are_those_of_the_complex_engine(slave: Instance, model: jo.Model) -> None:
    twin = Engine(model, complex_scalars=True)
    first = columns(model)[0]
    assert first is not None
    place = next(c for c in columns(model) if c.place == f"sensors/{model.sensors[0].name}").first
    for name in ("load", "angle"):
        k = list(model.inputs).index(name)
        value = twin.input[k]
        twin.input[k] = value + 1e-30j
        wanted = np.array(twin.row()).imag[place : place + model.nout] / 1e-30
        twin.input[k] = value
        found = slave.slope(slave.outputs, [slave.refs[name]], [1.0])
        assert near(found, wanted, 1e-9)


def test_the_jacobian_of_model_exchange_is_that_of_differences(exchanged: Instance) -> None:
    """Columns of d x'/d x at a disturbed state, Euler parameters off their unit included."""
    it, n = exchanged.it, len(exchanged.states)
    assert exchanged.provides and n
    if exchanged.two:
        it.enterContinuousTimeMode() if hasattr(it, "enterContinuousTimeMode") else None
    else:
        it.updateDiscreteStates()
        it.enterContinuousTimeMode()
    rng = np.random.default_rng(7)
    x = np.array(exchanged.get(exchanged.states)) + 1e-4 * rng.standard_normal(n)

    def rates(at: np.ndarray) -> np.ndarray:
        import ctypes

        kind = ctypes.c_double * n
        states = kind(*at)
        it.setContinuousStates(states, n)
        return np.array(exchanged.get(exchanged.rates))

    largest = 0.0
    for column in rng.choice(n, 6, replace=False):
        step = np.zeros(n)
        step[column] = 1e-6
        wanted = (rates(x + step) - rates(x - step)) / 2e-6
        rates(x)
        found = exchanged.slope(exchanged.rates, [exchanged.states[column]], [1.0])
        scale = np.abs(wanted).max()
        largest = max(largest, scale)
        assert np.abs(found - wanted).max() <= 1e-5 * max(scale, 1.0)
    assert largest > 1.0


def test_what_has_no_derivative_is_refused(slave: Instance) -> None:
    for unknown, known in (("load", "angle"), ("tip.x", "tip.z")):
        with pytest.raises(Exception, match="[Ss]tatus|failed|error"):
            slave.slope([slave.refs[unknown]], [slave.refs[known]], [1.0])
    slave.it.doStep(0.0, STEP)  # it goes on


def test_without_them_a_unit_says_so(model: jo.Model, tmp_path: Path) -> None:
    unit = write_fmu(model, tmp_path / "arm.fmu", jo.ROS2(step=STEP), version=3)
    made = Instance(unit, exchange=False)
    assert not made.provides
    with pytest.raises(Exception, match="[Ss]tatus|failed|error"):
        made.slope(made.outputs, [made.refs["load"]], [1.0])
    made.it.freeInstance()
