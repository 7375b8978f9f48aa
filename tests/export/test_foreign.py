"""Units of other programs in a mechanism: a cylinder written in C here, and machines of our own."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from cli.test_meshes import call as command
from exported import CC
from jousto.export.fmu import write_fmu
from jousto.simulation.cosimulation.fmu_process import FmuProcess

fmpy = pytest.importorskip("fmpy")
pytestmark = [
    pytest.mark.filterwarnings("ignore:fmu .* the exchange has an energy error"),
    pytest.mark.skipif(CC is None or sys.platform == "win32", reason="no C compiler"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
]

# held values make a swing grow by exp(omega^2 H t / 2): here by 1.08 at 1 ms in 0.2 s
MASS, AREA, BULK, VOLUME, SPEED = 2000.0, 1e-3, 1.5e9, 1e-3, 0.2
STIFF = BULK * AREA**2 / VOLUME  # N/m of the oil spring
OMEGA = np.sqrt(STIFF / MASS)

VARIABLES = """
<ScalarVariable name="speed" valueReference="0" causality="input" variability="continuous">
  <Real start="0" unit="mm/s"/></ScalarVariable>
<ScalarVariable name="pressure" valueReference="1" causality="output" variability="continuous"
  initial="exact"><Real start="0" unit="bar"/></ScalarVariable>
<ScalarVariable name="force" valueReference="2" causality="output" variability="continuous">
  <Real unit="N"/></ScalarVariable>
<ScalarVariable name="area" valueReference="3" causality="parameter" variability="tunable">
  <Real start="0.001" unit="m2"/></ScalarVariable>
<ScalarVariable name="bulk" valueReference="4" causality="parameter" variability="fixed">
  <Real start="1.5e9" unit="odd"/></ScalarVariable>
<ScalarVariable name="volume" valueReference="5" causality="parameter" variability="fixed">
  <Real start="0.001"/></ScalarVariable>
"""
DESCRIPTION = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="cylinder" guid="oil">
<CoSimulation modelIdentifier="cylinder" canHandleVariableCommunicationStepSize="true"
  canGetAndSetFMUstate="true"/>
<UnitDefinitions>
  <Unit name="bar"><BaseUnit kg="1" m="-1" s="-2" factor="1e5"/></Unit>
  <Unit name="mm/s"><BaseUnit m="1" s="-1" factor="{{factor}}"/></Unit>
  <Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit>
  <Unit name="odd"/>
</UnitDefinitions>
<ModelVariables>{VARIABLES}</ModelVariables>
<ModelStructure><Outputs><Unknown index="2"/><Unknown index="3"/></Outputs></ModelStructure>
</fmiModelDescription>"""


def pack(folder: Path, name: str, *flags: str, factor: float = 1.0, **more: bytes) -> Path:
    """Compile the cylinder; with `factor` its speed is in other units."""
    binary = folder / f"{name}.so"
    source = Path(__file__).parent / "cylinder.c"
    line = [str(CC), "-O1", "-shared", "-fPIC", *flags, str(source), "-o", str(binary)]
    done = subprocess.run(line, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    out = folder / f"{name}.fmu"
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION.replace("{factor}", repr(factor)))
        place = f"binaries/{fmpy.platform}/cylinder{fmpy.sharedLibraryExtension}"
        archive.write(binary, place)
        for key, content in more.items():
            archive.writestr(key, content)
    return out


@pytest.fixture(scope="module")
def oil(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return pack(tmp_path_factory.mktemp("oil"), "oil")


def cart(file: Path, **how: Any) -> jo.Mechanism:
    """Return a mass on a rail that runs into the oil at t = 0."""
    body = jo.RigidBody("cart", MASS, (1, 1, 1), velocity=(SPEED, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    push = jo.JointForce("push", rail.displacement, jo.Input("push"))
    place = jo.CoordinateSensor("place", rail.displacement)
    speed = jo.RateSensor("speed", rail.displacement)
    given: dict[str, Any] = {
        "inputs": {"speed": speed},
        "outputs": {"force": jo.Input("push"), "pressure": None},
        "power": {"force": "speed"},
        "step": 1e-3,
    }
    fmu = jo.Fmu(file, **{**given, **how})
    return jo.Mechanism(body, rail, push, place, speed, fmu)


def run(file: Path, t_end: float = 0.2, own: float = 2.5e-4, **how: Any) -> jo.Solution:
    return jo.simulate(jo.compile(cart(file, **how)), t_end, solver=jo.RK4(step=own))


def exact(t: np.ndarray) -> np.ndarray:
    return SPEED / OMEGA * np.sin(OMEGA * t)


def error(found: jo.Solution) -> float:
    """Return the largest error over the amplitude."""
    off = found["place"][:, 0] - exact(found.time)
    return float(np.abs(off).max()) * OMEGA / SPEED


def orders(values: list[float]) -> np.ndarray:
    return np.log2(np.array(values[:-1]) / np.array(values[1:]))


@pytest.mark.filterwarnings("ignore:fmu 'oil'. the exchange has an energy error")
def test_a_mass_on_oil_swings_with_its_frequency_of_order_one_and_two(oil: Path) -> None:
    """sqrt(k/m) with k = B A^2/V; held values are of order 1, straight lines of order 2."""
    steps = (2e-3, 1e-3, 5e-4)
    held = [error(run(oil, step=step, own=1.25e-4)) for step in steps]
    lines = [error(run(oil, step=step, own=1.25e-4, between="linear")) for step in steps]
    assert np.abs(orders(held)[-1] - 1.0) < 0.15, held
    assert np.abs(orders(lines)[-1] - 2.0) < 0.3, lines
    assert lines[-1] < 2e-2 * held[0]


@pytest.mark.filterwarnings("ignore:fmu 'oil'. the exchange has an energy error")
def test_the_energy_of_the_exchange_explains_what_the_swing_gains(oil: Path) -> None:
    """What the oil stores is p^2 V / 2 B exactly: energy in the system is off by energy_error."""
    for between in ("hold", "linear"):
        found = run(oil, between=between)
        kinetic = found.energy.kinetic
        stored = found["oil.pressure"][:, 0] ** 2 * VOLUME / (2 * BULK)
        gained = kinetic + stored - (kinetic[0] + stored[0])
        at = np.arange(0, len(found.time), 4)  # exchanges
        missed = found["oil.energy_error"][:, 0]
        scale = 0.5 * MASS * SPEED**2
        # the unit integrates its work exactly, that of the machine is known to its own step^2
        assert np.abs(gained - missed)[at].max() < 1e-3 * max(np.abs(missed).max(), 1e-3 * scale)
    assert np.abs(found["oil.energy_error"]).max() < 5e-3 * scale


def test_the_energy_error_has_the_order_of_the_exchange(oil: Path) -> None:
    with pytest.warns(
        jo.JoustoWarning, match="the exchange has an energy error of up to .* a smaller step"
    ):
        found = [run(oil, step=s, own=1.25e-4) for s in (2e-3, 1e-3, 5e-4)]
    held = [float(np.abs(x["oil.energy_error"]).max()) for x in found]
    assert np.abs(orders(held)[-1] - 1.0) < 0.25, held


@pytest.mark.filterwarnings("ignore:fmu 'oil'. the exchange has an energy error")
@pytest.mark.parametrize(
    "between,order", [pytest.param("hold", 1, marks=pytest.mark.slow), ("linear", 2)]
)
def test_halved_steps_estimate_the_error_of_a_step(oil: Path, between: str, order: int) -> None:
    """The estimate is of order p + 1, and that of a step from known values is near its error."""
    largest, ratios = [], []
    for step in (2e-3, 1e-3):
        found = run(oil, step=step, own=1.25e-4, between=between, estimate=True)
        plain = run(oil, step=step / 2, own=1.25e-4, between=between)
        assert np.array_equal(found["place"], plain["place"]), "the halves are kept"
        largest.append(float(found["oil.force.error"].max()))
        # one step from rest: F = -k x
        ends = np.flatnonzero(np.abs(found.time / step - np.round(found.time / step)) < 1e-9)
        force = found["oil.force"][ends, 0] + STIFF * found["place"][ends, 0]
        ratios.append(found["oil.force.error"][ends[-1], 0] / max(np.abs(np.diff(force)).max(), 1))
    assert abs(np.log2(largest[0] / largest[1]) - (order + 1)) < 0.4, largest


def test_units_of_the_description_are_converted(tmp_path: Path, oil: Path) -> None:
    """A unit that takes its speed in mm/s as the cylinder takes it in m/s is 1000 times stiffer."""
    odd = pack(tmp_path, "oil", factor=1e-3)
    soft = run(odd, parameters={"volume": VOLUME * 1e3})
    plain = run(oil)
    assert np.allclose(soft["place"], plain["place"], rtol=1e-9, atol=1e-12)
    known = plain["oil.force"][:, 0]
    assert np.allclose(plain["oil.pressure"][:, 0] * AREA, known, rtol=1e-12, atol=1e-9)


def test_parameters_and_start_values(oil: Path) -> None:
    """Half the volume is twice the stiffness; a start pressure pushes from the first instant."""
    found = run(oil, t_end=0.1, parameters={"volume": VOLUME / 2, "pressure": 4e5})
    assert found["oil.pressure"][0, 0] == 4e5
    assert np.isclose(found["oil.force"][0, 0], AREA * 4e5, rtol=1e-12)
    w, f = np.sqrt(2) * OMEGA, AREA * 4e5 / MASS
    t = found.time
    wanted = SPEED / w * np.sin(w * t) + f / w**2 * (1 - np.cos(w * t))
    assert np.abs(found["place"][:, 0] - wanted).max() < 0.1 * SPEED / w


def test_a_tunable_parameter_follows_a_sensor(oil: Path) -> None:
    body = cart(oil).bodies[0]
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    speed = jo.RateSensor("speed", rail.displacement)
    bore = jo.SignalSensor("bore", jo.Step(0.05, AREA, 0.0))
    push = jo.JointForce("push", rail.displacement, jo.Input("push"))
    fmu = jo.Fmu(oil, inputs={"speed": speed, "area": bore}, outputs={"force": jo.Input("push")})
    found = jo.simulate(
        jo.compile(jo.Mechanism(body, rail, speed, bore, push, fmu)), 0.1, solver=jo.RK4(step=5e-4)
    )
    force = found["oil.force"][:, 0]
    assert np.abs(force[(found.time > 0.01) & (found.time < 0.05)]).min() > 0
    assert not force[found.time > 0.0525].any()


@pytest.mark.parametrize(
    "flag,said",
    [
        ("-DCRASH", r"fmu 'bad' at 0\.005 s: its binary crashed \(SIGSEGV\)"),
        ("-DREFUSE", r"fmu 'bad' at 0\.005 s: fmi2DoStep failed .*the oil .* 42 bar, 100%"),
        ("-DNOT_A_NUMBER", r"fmu 'bad' at 0\.005 s: its output 'force' is -?nan"),
    ],
)
def test_a_unit_that_fails_is_one_sentence_and_the_results_stay(
    tmp_path: Path, flag: str, said: str
) -> None:
    bad = pack(tmp_path, "bad", flag)
    model = jo.compile(cart(bad))
    with pytest.raises(jo.simulation.RunFailed, match=said) as failed:
        jo.simulate(model, 0.2, solver=jo.RK4(step=2.5e-4), path=tmp_path / "run.h5")
    kept = jo.simulation.results.solution.load(tmp_path / "run.h5")
    assert failed.value.solution is not None and kept.nt == 21
    assert np.isclose(kept.time[-1], 0.005)


@pytest.mark.usefixtures("broken_pipe")
def test_a_unit_whose_process_is_gone_is_one_sentence(
    oil: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    step = FmuProcess.step

    def killed(self: FmuProcess, time: float, length: float, values: Any) -> Any:
        if time > 0.004:
            self._process.kill()
            self._process.wait()
        return step(self, time, length, values)

    monkeypatch.setattr(FmuProcess, "step", killed)
    with pytest.raises(
        jo.simulation.RunFailed, match=r"fmu 'oil' at 0\.005 s: its process was killed"
    ):
        jo.simulate(jo.compile(cart(oil)), 0.1, solver=jo.RK4(step=2.5e-4))


def test_a_unit_that_hangs_is_one_sentence(tmp_path: Path) -> None:
    bad = pack(tmp_path, "bad", "-DHANG")
    said = r"fmu 'bad' at 0\.005 s: it did not answer \(step\) within its patience of 1\.5 s"
    model = jo.compile(cart(bad, patience=1.5))
    with pytest.raises(jo.simulation.RunFailed, match=said):
        jo.simulate(model, 0.2, solver=jo.RK4(step=2.5e-4))


def test_the_file_of_results_has_the_outputs(tmp_path: Path, oil: Path) -> None:
    model = jo.compile(cart(oil))
    in_memory = jo.simulate(model, 0.02, solver=jo.RK4(step=5e-4), output_step=2e-3)
    jo.simulate(model, 0.02, solver=jo.RK4(step=5e-4), output_step=2e-3, path=tmp_path / "run.h5")
    kept = jo.simulation.results.solution.load(tmp_path / "run.h5")
    assert len(in_memory.time) == 11
    for name in ("oil.force", "oil.pressure", "oil.delivered", "oil.received", "place"):
        assert np.array_equal(kept[name], in_memory[name])


# -- one machine cut in two -------------------------------------------------------------------

M1, M2, K = 2.0, 3.0, 800.0


def half(folder: Path, name: str) -> Path:
    """Write one cart of two, the second with the spring between them."""
    first = name == "a"
    body = jo.RigidBody("cart", M1 if first else M2, (1, 1, 1), velocity=(0.5 * first, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    place = jo.CoordinateSensor("place", rail.displacement)
    speed = jo.RateSensor("speed", rail.displacement)
    if first:
        push = jo.JointForce("push", rail.displacement, jo.Input("force"))
        out = [push, place, speed]
    else:
        hold = jo.Servo("hold", rail.displacement, jo.Input("other"), kp=K)
        out = [hold, place, speed]
    model = jo.compile(jo.Mechanism(body, rail, *out, name=name))
    return write_fmu(model, folder / f"{name}.fmu", jo.RK4(step=1e-4), version=3 if first else 2)


@pytest.fixture(scope="module")
def halves(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("halves")
    return half(folder, "a"), half(folder, "b")


def whole(t: np.ndarray) -> np.ndarray:
    """Return the places (2, n) of two carts with a spring between, the first thrown."""
    w = np.sqrt(K * (M1 + M2) / (M1 * M2))
    mean, apart = M1 * 0.5 / (M1 + M2) * t, 0.5 / w * np.sin(w * t)
    return np.array([mean + M2 / (M1 + M2) * apart, mean - M1 / (M1 + M2) * apart])


def together(halves: tuple[Path, Path], step: float, between: str) -> tuple[float, float]:
    """Return the largest errors of place (over the amplitude) and energy (over that thrown in)."""
    a, b = halves
    bench = jo.RigidBody("bench", 1.0, (1, 1, 1))
    foot = jo.Prismatic("foot", jo.ground["origin"], bench["origin"], axis=(1, 0, 0))
    at_a = jo.SignalSensor("at a", jo.Input("x1"))
    at_b = jo.SignalSensor("at b", jo.Input("x2"))
    spring = jo.SignalSensor("spring", K * jo.Input("x2") - K * jo.Input("x1"))
    how: dict[str, Any] = {"step": step, "between": between}
    first = jo.Fmu(
        a, inputs={"force": spring}, outputs={"place": jo.Input("x1"), "speed": None}, **how
    )
    second = jo.Fmu(
        b, inputs={"other": at_a}, outputs={"place": jo.Input("x2"), "speed": None}, **how
    )
    model = jo.compile(jo.Mechanism(bench, foot, at_a, at_b, spring, first, second))
    run = jo.simulate(model, 0.4, solver=jo.RK4(step=step), state=None)
    x1, x2 = run["a.place"][:, 0], run["b.place"][:, 0]
    v1, v2 = run["a.speed"][:, 0], run["b.speed"][:, 0]
    off = np.abs(np.array([x1, x2]) - whole(run.time)).max()
    energy = 0.5 * M1 * v1**2 + 0.5 * M2 * v2**2 + 0.5 * K * (x1 - x2) ** 2
    w = np.sqrt(K * (M1 + M2) / (M1 * M2))
    return float(off) * w / 0.5, float(np.abs(energy / energy[0] - 1).max())


@pytest.mark.filterwarnings("ignore:simulate .* nothing will move")
@pytest.mark.parametrize(
    "between,order", [pytest.param("hold", 1, marks=pytest.mark.slow), ("linear", 2)]
)
def test_a_machine_cut_at_a_joint_comes_to_the_whole(
    halves: tuple[Path, Path], between: str, order: int
) -> None:
    found = [together(halves, step, between) for step in (4e-3, 2e-3, 1e-3)]
    place, energy = ([row[k] for row in found] for k in (0, 1))
    assert abs(orders(place)[-1] - order) < 0.25, place
    assert abs(orders(energy)[-1] - order) < 0.5 or order == 2 and orders(energy)[-1] > 1.7, energy


# -- in model files ---------------------------------------------------------------------------

FILE = """
bodies: [{name: cart, mass: 2 t, inertia: [1, 1, 1], velocity: [0.2, 0, 0]}]
joints: [{type: prismatic, name: rail, a: ground.origin, b: cart.origin, axis: [1, 0, 0]}]
forces:
  - type: joint-force
    name: push
    coordinate: rail.displacement
    signal: {type: input, name: push}
sensors:
  - {type: coordinate, name: place, coordinate: rail.displacement}
  - {type: rate, name: speed, coordinate: rail.displacement}
  - {type: velocity, name: motion, marker: cart.origin}
fmus:
  - name: oil
    file: oil.fmu
    inputs: {speed: speed, area: 1000 mm2}
    outputs: {force: push, pressure: null}
    parameters: {volume: 1e-3, pressure: 4 bar}
    power: {force: speed}
    step: 1 ms
    between: linear
"""


def test_a_model_file_says_the_same_as_python(oil: Path) -> None:
    (oil.parent / "cart.yaml").write_text(FILE)
    file = jo.read_model(oil.parent / "cart.yaml", trust=True)
    fmu = file.mechanism.fmus[0]
    assert fmu.parameters == {"volume": 1e-3, "pressure": 4e5} and fmu.patience == 60.0
    model = jo.compile(file.mechanism)
    found = jo.simulate(model, 0.05, solver=jo.RK4(step=2.5e-4))
    how = {
        "inputs": {"speed": cart(oil).sensors[1], "area": AREA},
        "parameters": {"volume": VOLUME, "pressure": 4e5},
        "between": "linear",
    }
    body = cart(oil)
    how["inputs"]["speed"] = next(s for s in body.sensors if s.name == "speed")
    items = [x for x in body.items if not isinstance(x, jo.Fmu)]
    given = {"outputs": {"force": jo.Input("push"), "pressure": None}, "power": {"force": "speed"}}
    same = jo.Mechanism(*items, jo.Fmu(oil, **how, **given))
    wanted = jo.simulate(jo.compile(same), 0.05, solver=jo.RK4(step=2.5e-4))
    assert np.array_equal(found["place"], wanted["place"])
    assert np.array_equal(found["oil.pressure"], wanted["oil.pressure"])


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b" " * (1 << 30), "is larger than 64 MB"),
        (b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>', "a document type"),
    ],
    ids=["blanks", "entities"],
)
def test_a_description_that_would_fill_the_memory_is_refused(
    content: bytes, said: str, tmp_path: Path
) -> None:
    """1 GiB of blanks are 1 MB in an archive."""
    with zipfile.ZipFile(tmp_path / "large.fmu", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", content, compresslevel=1)
    with pytest.raises(jo.InputError, match=said):
        jo.Fmu(tmp_path / "large.fmu")


STEPS = (
    ("run", "--quiet"), ("live",), ("view", "--modes", "-o", "modes.html"),
    ("study", "--vary", "speed=0.1,0.3", "--outcome", "max(place)"),
    ("export", "-o", "machine.fmu"), ("export", "-o", "machine.html"), ("realtime",),
    ("modes",), ("equilibrium",), ("linearise",), ("verify",), ("view", "-o", "pose.html"),
    ("check",), ("info",),
)  # fmt: skip


def test_no_command_loads_a_unit_of_a_file_that_nobody_trusts(tmp_path: Path) -> None:
    """Loading alone would run the constructor of its library, which leaves a mark."""
    mark = tmp_path / "mark"
    pack(tmp_path, "oil", f'-DMARK="{mark}"')
    file = tmp_path / "cart.yaml"
    run = "simulation: {t_end: 0.01, solver: {type: RK4, step: 1 ms}}"
    machine = FILE.replace("0.2, 0, 0", "${speed}, 0, 0")
    file.write_text(f"{run}\n{machine}parameters: {{speed: 0.2}}\n")
    for name, *words in STEPS:
        more = [str(tmp_path / x) if x.endswith((".fmu", ".html")) else x for x in words]
        code, said = command(name, file, *more)
        assert not mark.exists(), name
        loads_nothing = name in ("check", "info") or "pose.html" in words
        assert (code == 0) == loads_nothing and "internal error" not in said, (name, code, said)
    code, said = command("run", file, "--quiet")
    assert "cart.yaml:16" in said and "native code" in said and "--trust" in said
    assert not file.with_suffix(".h5").exists()
    code, said = command("check", file)
    assert code == 0 and "runs only if trusted" in said
    code, said = command("run", file, "--quiet", "--trust")
    assert code == 0 and mark.exists(), said


def test_a_unit_of_a_file_runs_in_python_only_with_trust(oil: Path) -> None:
    (oil.parent / "cart.yaml").write_text(FILE)
    with pytest.raises(jo.InputError, match=r"native code.*read_model\(path, trust=True\)"):
        jo.simulate(jo.compile(jo.read_model(oil.parent / "cart.yaml").mechanism), 0.01)


def test_a_live_machine_refuses_a_unit_that_it_would_not_step(oil: Path) -> None:
    with pytest.raises(jo.InputError, match="fmu 'oil' does not step in a live machine"):
        jo.live(cart(oil), open=False)


def test_check_lists_a_unit_and_compares_its_step(oil: Path) -> None:
    for step, code, said in (("1 ms", 0, "fmu oil"), ("1.5 ms", 2, "multiple of the step of the")):
        run = f"simulation: {{t_end: 0.03, solver: {{type: RK4, step: 1 ms}}}}\n{FILE}"
        (oil.parent / "cart.yaml").write_text(
            run.replace("step: 1 ms\n    b", f"step: {step}\n    b")
        )
        found, text = command("check", oil.parent / "cart.yaml")
        assert found == code and said in text, text


@pytest.mark.parametrize("speed,component", [("motion.x", 0), ("motion.0", 0), ("motion.z", 2)])
def test_a_component_of_a_sensor_follows_a_dot(oil: Path, speed: str, component: int) -> None:
    text = FILE.replace("speed: speed, area: 1000 mm2", f"speed: {speed}")
    (oil.parent / "part.yaml").write_text(text)
    fmu = jo.read_model(oil.parent / "part.yaml").mechanism.fmus[0]
    sensor, place = fmu.inputs["speed"]
    assert (sensor.name, place) == ("motion", component)


def test_a_unit_measures_another_in_any_order_of_the_file(oil: Path) -> None:
    first = "  - {name: second, file: oil.fmu, inputs: {speed: oil.pressure}}\n"
    text = FILE.replace("fmus:\n", "fmus:\n" + first)
    (oil.parent / "two.yaml").write_text(text)
    with pytest.warns(jo.JoustoWarning, match="input 'speed' is in mm/s"):
        mechanism = jo.read_model(oil.parent / "two.yaml").mechanism
    second, one = mechanism.fmus
    assert second.inputs["speed"][0] is one["pressure"]


@pytest.mark.parametrize(
    "old,new,said",
    [
        ("speed: speed,", "speed: spede,", "no sensor 'spede'; did you mean 'speed'?"),
        ("area: 1000 mm2", "area: 1000 mm", "expects an area (m2), got 1000 mm (a length)"),
        ("speed: speed,", "sped: speed,", "has no input 'sped'; did you mean 'speed'?"),
        ("speed: speed,", "speed: motion.q,", "no component 'q'"),
        ("pressure: 4 bar", "pressure: 4 N", "expects a pressure (Pa), got 4 N (a force)"),
        ("file: oil.fmu", "file: none.fmu", "none.fmu"),
        ("force: push", "force: puhs", "sets input 'puhs', which nothing in the mechanism uses"),
        ("step: 1 ms", "stop: 1 ms", "unknown key 'stop'"),
        ("speed: speed,", "speed: oil.force,", "wait for each other"),
    ],
)
def test_what_a_model_file_says_wrong_has_its_line(
    oil: Path, old: str, new: str, said: str
) -> None:
    (oil.parent / "bad.yaml").write_text(FILE.replace(old, new, 1))
    with pytest.raises(jo.InputError) as found:
        jo.read_model(oil.parent / "bad.yaml")
    assert said in str(found.value), found.value
    assert "bad.yaml:" in str(found.value)


# -- what is refused --------------------------------------------------------------------------


def test_wrong_names_are_all_named(oil: Path) -> None:
    with pytest.raises(jo.InputError) as found:
        jo.Fmu(
            oil,
            inputs={"spede": 1.0, "pressure": 2.0},
            outputs={"forze": jo.Input("p"), "speed": None},
            parameters={"colour": 1.0, "volume": "big"},
            power={"force": "speed"},
        )
    text = str(found.value)
    for said in (
        "no input 'spede'; did you mean 'speed'?",
        "'pressure' has causality output, must be input",
        "no output 'forze'; did you mean 'force'?",
        "no parameter or start value 'colour'",
        "parameter 'volume' is 'big', must be a number",
        "power: 'force' is not among its outputs here",
    ):
        assert said in text, text


def test_units_that_do_not_fit_and_are_not_known_are_said(oil: Path) -> None:
    rail = cart(oil).joints[0]
    place = jo.CoordinateSensor("place", rail.displacement)
    with pytest.warns(jo.JoustoWarning, match="input 'speed' is in mm/s, sensor 'place' measures"):
        jo.Fmu(oil, inputs={"speed": place})
    with pytest.warns(jo.JoustoWarning, match="'bulk' is in 'odd', which is not known"):
        jo.Fmu(oil, parameters={"bulk": 1e9})


def test_a_hostile_or_foreign_archive_is_refused(tmp_path: Path, oil: Path) -> None:
    bad = pack(tmp_path, "bad", **{"../../evil.txt": b"boom"})
    with pytest.raises(jo.InputError, match="would be written outside of its folder"):
        jo.Fmu(bad)
    with pytest.raises(jo.InputError, match=r"no such file '.*baad\.fmu'; did you mean 'bad\.fmu'"):
        jo.Fmu(tmp_path / "baad.fmu")
    (tmp_path / "no.fmu").write_bytes(b"no zip")
    with pytest.raises(jo.InputError, match="is not a zip archive of a functional mock-up unit"):
        jo.Fmu(tmp_path / "no.fmu")
    with zipfile.ZipFile(oil) as old, zipfile.ZipFile(tmp_path / "win.fmu", "w") as new:
        new.writestr("modelDescription.xml", old.read("modelDescription.xml"))
        new.writestr("binaries/win64/cylinder.dll", b"x")
    with pytest.raises(jo.InputError, match=r"no binary for \w+, it has win64; ask the author"):
        jo.Fmu(tmp_path / "win.fmu")
    with zipfile.ZipFile(tmp_path / "xml.fmu", "w") as new:
        new.writestr("modelDescription.xml", "<not")
    with pytest.raises(jo.InputError, match="its modelDescription.xml cannot be read"):
        jo.Fmu(tmp_path / "xml.fmu")
    shutil.copy(oil, tmp_path / "gone.fmu")
    with pytest.raises(jo.InputError, match=r"none\.fmu"):
        jo.Fmu(tmp_path / "none.fmu")


def test_runs_that_cannot_be_are_refused_by_name(oil: Path) -> None:
    model = jo.compile(cart(oil))
    with pytest.raises(jo.InputError, match="fmu 'oil': step is 0.001 s, must be a multiple"):
        jo.simulate(model, 0.3, solver=jo.RK4(step=3e-4))
    with pytest.raises(jo.InputError, match="fmu 'oil': DormandPrince chooses its steps itself"):
        jo.simulate(model, 0.1, solver=jo.simulation.DormandPrince())
    begun = jo.simulate(model, 0.01, solver=jo.RK4(step=1e-3))
    with pytest.raises(jo.InputError, match="fmu 'oil'.* a run with it cannot be continued"):
        jo.simulate(model, 0.02, solver=jo.RK4(step=1e-3), state=begun.state())
    with pytest.raises(jo.InputError, match="'push' is set by fmu 'oil'; remove it"):
        jo.simulate(model, 0.02, solver=jo.RK4(step=1e-3), inputs={"push": 1.0})
    for call in (
        lambda: jo.verify(cart(oil), 0.01),
        lambda: jo.simulation.Simulator(model),
        lambda: jo.equilibrium(model),
        lambda: jo.modes(model),
        lambda: jo.write(model, "out.c"),
    ):
        with pytest.raises(jo.InputError, match="fmu 'oil'"):
            call()


def test_a_mechanism_that_lacks_what_crosses(oil: Path) -> None:
    whole = cart(oil)
    items = [x for x in whole.items if getattr(x, "name", "") not in ("speed", "push")]
    with pytest.raises(jo.InputError) as found:
        jo.Mechanism(*items)
    assert "sensor 'speed' is not in the mechanism" in str(found.value)
    assert "sets input 'push', which nothing in the mechanism uses" in str(found.value)
