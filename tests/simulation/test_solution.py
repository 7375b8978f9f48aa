"""Solution: where results live, how they travel, and what they say of themselves."""

from __future__ import annotations

import csv
import pickle
import sys
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import jousto as jo
from jousto.simulation.results import memory
from jousto.simulation.results.diagnostics import Energy
from jousto.simulation.results.stored import FileRecords
from session import objects

EARTH = jo.Gravity((0, -9.81, 0))


def swing(length: float) -> jo.Solution:
    """Run a pendulum; module level, so that a pool finds it."""
    ball = jo.RigidBody(
        "ball", 1.0, (0.01,) * 3, position=(length, 0, 0), markers={"eye": (-length, 0, 0)}
    )
    pivot = jo.Revolute("pivot", jo.ground["origin"], ball["eye"], (0, 0, 1))
    angle = jo.CoordinateSensor("angle", jo.Angle(jo.ground["origin"], ball["eye"]))
    model = jo.compile(
        jo.Mechanism(
            ball,
            pivot,
            EARTH,
            jo.ReactionSensor("hinge", pivot),
            angle,
            jo.mechanism.Event("low", angle, threshold=-0.2),
            name="swing",
        )
    )
    return jo.simulate(model, 0.5, output_step=0.1)


def contents(run: jo.Solution) -> dict[str, np.ndarray]:
    """Return every array that a run gives."""
    found = {"time": run.time, "q": run.q, "v": run.v, "lam": run.multipliers}
    found |= {f"sensor {name}": run[name] for name in run}
    found |= {f"energy {k}": v for k, v in vars(run.energy).items()}
    found |= {f"residual {k}": v for k, v in vars(run.residuals).items()}
    found |= {f"work {k}": v for k, v in vars(run.work).items()}
    for body in run.bodies:
        found |= {
            f"{body.name} {name}": getattr(body, name) for name in ("nodes", "elements", "modes")
        }
        found[f"{body.name} coordinates"] = run.coordinates(body.name, slice(1, None, 2))
        stress = run.stress_modes(body.name)
        if stress is not None:
            found[f"{body.name} stress"] = stress.modes
    state = run.state()
    found |= {f"state {k}": v for k, v in vars(state).items() if isinstance(v, np.ndarray)}
    return found


def assert_same(one: jo.Solution, other: jo.Solution) -> None:
    ours, theirs = contents(one), contents(other)
    assert ours.keys() == theirs.keys()
    for name, value in ours.items():
        assert_array_equal(value, theirs[name], err_msg=name)
    assert one.events == other.events
    assert one.sensors == other.sensors
    assert one.stressed == other.stressed
    assert one.model_text == other.model_text
    assert [one.about(n) for n in one] == [other.about(n) for n in other]
    assert one.attributes.keys() == other.attributes.keys()
    assert str(one.attributes["run"]) == str(other.attributes["run"])


# -- memory and files ------------------------------------------------------------------------------


def test_results_in_memory_are_those_of_a_file(pendulum, tmp_path):
    options = {"output_step": 0.01, "model_text": "name: x\n"}
    kept = jo.simulate(pendulum, 0.05, **options)
    assert_same(kept, jo.load(kept.save(tmp_path / "saved.h5")))
    written = jo.simulate(pendulum, 0.05, path=tmp_path / "run.h5", **options)
    assert contents(kept).keys() == contents(written).keys()
    assert_array_equal(kept.q, written.q)
    run = swing(1.0)
    assert [e.name for e in run.events] == ["low"]
    assert_same(run, jo.load(run.save(tmp_path / "swing.h5")))
    again = written.save(tmp_path / "copy.h5")
    assert_same(written, jo.load(again))
    with pytest.raises(jo.InputError, match="does not exist; create it first"):
        kept.save(tmp_path / "none" / "x.h5")


def test_beams_and_inputs_come_back_from_memory_and_from_a_file(tmp_path):
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
    ends = [(0, 0, 0), (1, 0, 0)]
    beam = jo.BeamBody("beam", ends, jo.Rectangle(0.02, 0.02), steel, elements=2)
    joint = jo.Fixed("wall", jo.ground["origin"], beam["start"])
    push = jo.Force("push", beam["end"], (0, 1, 0), signal=jo.Input("u", 1.0))
    model = jo.compile(jo.Mechanism(beam, joint, push))
    run = jo.simulate(model, 0.01)
    stored = jo.load(run.save(tmp_path / "run.h5"))
    for one, other in zip(run.beam_states("beam"), stored.beam_states("beam"), strict=True):
        assert_array_equal(one, other)
    assert run.beams[0].name == stored.beams[0].name == "beam"
    assert run.stressed == stored.stressed == ("beam",)
    assert run.state().inputs == stored.state().inputs == {"u": 1.0}


def test_nothing_is_written_until_somebody_asks(pendulum, tmp_path, monkeypatch):
    monkeypatch.setattr(memory.tempfile, "mkdtemp", lambda **_: pytest.fail("wrote a file"))
    run = jo.simulate(pendulum, 0.01)
    assert run["tip"].shape == (11, 3)
    with pytest.raises(jo.InputError, match="results of 'pendulum': no sensor 'tipp'"):
        run["tipp"]


def test_what_is_read_is_a_copy(pendulum):
    run = jo.simulate(pendulum, 0.01)
    run["tip"][:] = 7.0
    run.q[:] = 7.0
    assert not (run["tip"] == 7.0).any()
    assert not (run.q == 7.0).any()


def test_large_results_go_to_a_temporary_file(pendulum, monkeypatch):
    small = jo.simulate(pendulum, 0.05, output_step=0.01)
    monkeypatch.setattr(memory, "IN_MEMORY", 0)
    run = jo.simulate(pendulum, 0.05, output_step=0.01)
    assert isinstance(run._records, FileRecords)
    assert_array_equal(run.q, small.q)
    folder = run.path.parent
    other = pickle.loads(pickle.dumps(run))
    del run
    assert not folder.exists()
    assert_array_equal(other.q, small.q)  # the data went along
    folder = other.path.parent
    del other
    assert not folder.exists()


# -- other processes -------------------------------------------------------------------------------


def test_results_come_back_from_a_pool():
    with ProcessPoolExecutor(2) as pool:
        runs = list(pool.map(swing, (0.5, 1.0)))
    assert_same_but_run(runs[0], swing(0.5))
    assert runs[1]["hinge"].shape == (6, 6)


def assert_same_but_run(one: jo.Solution, other: jo.Solution) -> None:
    ours, theirs = contents(one), contents(other)
    for name, value in ours.items():
        assert_array_equal(value, theirs[name], err_msg=name)


def test_functions_of_the_user_do_not_travel(pendulum):
    """Results of a model with a lambda, which cannot be pickled, can."""
    ball = jo.RigidBody("ball", 1.0, (0.01,) * 3)
    pull = jo.UserForce("pull", ball["origin"], lambda t, x: np.zeros(6))
    pivot = jo.Spherical("pivot", jo.ground["origin"], ball["origin"])
    run = jo.simulate(jo.compile(jo.Mechanism(ball, pivot, pull)), 0.01)
    assert_same(run, pickle.loads(pickle.dumps(run)))


def test_a_pickle_names_the_file_of_the_user(pendulum, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = jo.simulate(pendulum, 0.05, path="run.h5")
    packed = pickle.dumps(run)
    assert len(packed) < 1000
    monkeypatch.chdir("/")  # another process may work elsewhere
    assert_same(run := jo.load(tmp_path / "run.h5"), pickle.loads(packed))


# -- a mapping -------------------------------------------------------------------------------------


def test_a_run_is_a_mapping_of_its_sensors():
    run = swing(1.0)
    assert isinstance(run, Mapping)
    assert list(run) == ["hinge", "angle"] == list(run.keys())
    assert len(run) == 2 == len(dict(run))
    assert run.nt == 6 == len(run.time)
    assert "hinge" in run and "hinge.Fx" in run
    assert "hunge" not in run and "hinge.Fq" not in run and 7 not in run
    assert_array_equal(dict(run)["angle"], run["angle"])
    assert [name for name, _ in run.items()] == ["hinge", "angle"]
    for (_, one), other in zip(run.items(), run.values(), strict=True):
        assert_array_equal(one, other)
    assert_array_equal(run.get("hinge"), run["hinge"])
    assert run.get("hunge") is None and run.get("hunge", 3) == 3
    assert {run: 1}[run] == 1 and run == run and run != swing(1.0)


def test_a_run_without_sensors_is_still_one():
    ball = jo.RigidBody("ball", 1.0, (0.01,) * 3)
    joint = jo.Spherical("pivot", jo.ground["origin"], ball["origin"])
    run = jo.simulate(jo.compile(jo.Mechanism(ball, joint, EARTH)), 0.01)
    assert len(run) == 0 and bool(run) and run.nt == 11


def test_components_are_asked_for_by_name(tmp_path):
    run = swing(1.0)
    for found in (run, jo.load(run.save(tmp_path / "run.h5"))):
        assert_array_equal(found["hinge.My"], found["hinge"][:, 4])
        about = found.about("hinge.My")
        assert (about["unit"], about["components"]) == ("N m", ("My",))
        assert found.about("hinge.Fx")["unit"] == "N"
    frame = run.to_csv(tmp_path / "a.csv", "hinge.My", "angle").read_text().splitlines()
    assert frame[0] == "time (s),hinge.My (N m),angle (rad)"


def test_a_stress_component_is_that_of_every_site():
    run = objects()["run"]  # its sensor has two sites
    labels = run.about("stress")["components"]
    wanted = [labels.index(f"e1.a.{side}:s11") for side in ("top", "bottom")]
    assert_array_equal(run["stress.s11"], run["stress"][:, wanted])
    assert_array_equal(run["stress.e1.a.top:s11"], run["stress"][:, wanted[0]])
    assert run["stress.e1.a.top"].shape == (run.nt, 6)
    assert run.about("stress.s11")["components"] == ("e1.a.top:s11", "e1.a.bottom:s11")


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("hing", "no sensor 'hing'; did you mean 'hinge'?"),
        ("hinge.Fq", "sensor 'hinge' has no component 'Fq'; known: Fx"),
        ("Fx", "no sensor 'Fx'; known: hinge, angle"),
        (3, "no sensor 3; known: hinge, angle"),
    ],
)
def test_unknown_names_are_key_errors_that_help(name, says):
    run = swing(1.0)
    with pytest.raises(KeyError) as error:
        run[name]
    assert isinstance(error.value, jo.InputError)
    assert says in str(error.value) and not str(error.value).startswith('"')
    assert str(pickle.loads(pickle.dumps(error.value))) == str(error.value)


def test_print_is_short(pendulum):
    run = jo.simulate(pendulum, 0.01)
    assert (
        repr(run)
        == "<Solution 'pendulum': 11 instants to 0.01 s, 2 sensors, ROS2(step=0.001, ...)>"
    )
    body = jo.RigidBody("b", 1.0, (1, 1, 1))
    joint = jo.Spherical("j", jo.ground["origin"], body["origin"])
    long = jo.simulate(jo.compile(jo.Mechanism(body, joint, EARTH, name="x" * 1000)), 0.01)
    assert len(repr(long)) < 300


# -- tables ----------------------------------------------------------------------------------------


def test_a_table_names_the_unit_of_each_component(tmp_path):
    run = swing(1.0)
    assert run.to_csv(tmp_path / "run.csv") == tmp_path / "run.csv"
    with (tmp_path / "run.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    assert rows[0] == [
        "time (s)",
        *(f"hinge.F{axis} (N)" for axis in "xyz"),
        *(f"hinge.M{axis} (N m)" for axis in "xyz"),
        "angle (rad)",
    ]
    table = np.array(rows[1:], dtype=float)
    assert_array_equal(table[:, 1:7], run["hinge"])
    with pytest.raises(jo.InputError, match="no sensor 'hing'; did you mean 'hinge'"):
        run.to_csv(tmp_path / "x.csv", "hing")
    few = [
        run.to_csv(tmp_path / "few.csv", *given[0], **given[1]).read_text()
        for given in (
            (("angle", "hinge.Fx"), {}),
            ((["angle", "hinge.Fx"],), {}),
            ((), {"sensors": ["angle", "hinge.Fx"]}),
        )
    ]
    assert few[0] == few[1] == few[2]
    assert few[0].startswith("time (s),angle (rad),hinge.Fx (N)\n")
    with pytest.raises(jo.InputError, match="sensors is 3, must be a name or a list of names"):
        run.to_csv(tmp_path / "x.csv", sensors=3)
    with pytest.raises(jo.InputError, match="does not exist; create it first"):
        run.to_csv(tmp_path / "none" / "x.csv")


def test_pandas():
    pytest.importorskip("pandas")
    run = swing(1.0)
    frame = run.to_pandas()
    assert_array_equal(frame.index, run.time)
    assert_array_equal(frame["hinge.My"], run["hinge"][:, 4])
    assert frame.attrs["units"]["hinge.My"] == "N m"
    assert list(run.to_pandas("angle").columns) == ["angle"]
    for given in (("hinge.My", "angle"), (["hinge.My", "angle"],)):
        assert list(run.to_pandas(*given).columns) == ["hinge.My", "angle"]
    assert list(run.to_pandas(sensors=["angle"]).columns) == ["angle"]


def test_xarray():
    pytest.importorskip("xarray")
    run = swing(1.0)
    data = run.to_xarray()
    assert_array_equal(data["hinge"].sel(hinge_component="My"), run["hinge"][:, 4])
    assert data["hinge"].sel(hinge_component="My")["hinge_unit"].item() == "N m"
    assert data["angle"].attrs["units"] == "rad"
    assert data["angle"].dims == ("time",)


@pytest.mark.parametrize("package", ["pandas", "xarray"])
def test_the_extra_is_named_where_it_is_missing(package, monkeypatch):
    run = swing(1.0)
    monkeypatch.setitem(sys.modules, package, None)  # importing it fails
    with pytest.raises(jo.InputError, match=f"pip install {package} .*the extra frames"):
        getattr(run, f"to_{package}")()


# -- energy ----------------------------------------------------------------------------------------


def exchange(missing: float) -> Energy:
    """Return a fall in which 2 J become kinetic, and this much more."""
    none = np.zeros(3)
    kinetic = np.array([0.0, 1.0, 2.0 + missing])
    return Energy(kinetic, none, np.array([5.0, 4.0, 3.0]), none, none, none, none)


@pytest.mark.parametrize(
    ("missing", "words"),
    [
        (0.0, "energy balance closes to round-off: good"),
        (-4e-7, "energy balance closes to 2e-07 of the largest energy exchanged: good"),
        (0.02, "closes to 0.01 of the largest energy exchanged: fair, a smaller step"),
        (-0.4, "closes only to 0.2 of the largest energy exchanged: poor, take a smaller step"),
    ],
)
def test_the_energy_balance_has_a_verdict(missing, words):
    energy = exchange(missing)
    assert words in energy.verdict
    # potential falls by 2 J; what kinetic energy has too much counts among what was exchanged
    assert energy.exchanged == pytest.approx(2.0 + max(missing, 0.0))


def steady(missing: float) -> Energy:
    """Return a rotation with 1000 J that loses or gains this much."""
    none = np.zeros(3)
    return Energy(1000.0 + missing * np.array([0.0, 0.5, 1.0]), *(none,) * 6)


@pytest.mark.parametrize(
    ("missing", "words"),
    [
        (-4e-7, "energy balance closes to 4e-10 of the largest kinetic energy: good"),
        (0.02, "closes to 2e-05 of the largest kinetic energy: fair, a smaller step"),
        (-0.4, "closes only to 0.0004 of the largest kinetic energy: poor, take a smaller step"),
        (3.0, "closes only to 1 of the largest energy exchanged: poor, take a smaller step"),
    ],
)
def test_a_steady_rotation_is_judged_by_the_energy_it_has(missing, words):
    assert words in steady(missing).verdict


@pytest.mark.parametrize("solver", [jo.RK4(step=1e-4), jo.simulation.DormandPrince(tolerance=1e-6)])
def test_a_machine_that_turns_steadily_is_good(solver):
    """Two bodies on an inclined shaft keep 33 kJ to 1e-12 (RK4) and 5e-7, and exchange nothing."""
    w = 100.0 * np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    hub = jo.RigidBody("hub", 50.0, (1.0, 1.3, 2.0), angular_velocity=w)
    arm = jo.RigidBody(
        "arm",
        5.0,
        (0.1, 0.13, 0.2),
        position=(1, 0, 0),
        velocity=np.cross(w, (1, 0, 0)),
        angular_velocity=w,
    )
    shaft = jo.Revolute("shaft", jo.ground["origin"], hub["origin"], axis=w)
    weld = jo.Fixed("weld", hub.at((1, 0, 0)), arm["origin"])
    model = jo.compile(jo.Mechanism(hub, arm, shaft, weld), core="maximal")
    run = jo.simulate(model, 0.5, solver=solver)
    assert np.ptp(run.energy.kinetic) < 1e-6 * run.energy.kinetic[0]
    assert run.energy.verdict.endswith("of the largest kinetic energy: good")


def test_verdicts_on_rest_on_nothing_and_on_kinematics():
    none = np.zeros(2)
    assert Energy(none, none, none, none, none, none, none).verdict.endswith("round-off: good")
    empty = np.zeros(0)
    assert Energy(*(empty,) * 7).verdict.endswith("good")
    unknown = Energy(none, none, none, none, none, none, np.full(2, np.nan))
    assert "not known" in unknown.verdict


def test_a_coarse_step_is_told_from_a_fine_one(pendulum):
    """RK4 damps vibration with the fifth power of the step."""
    run = swing(1.0)
    assert run.energy.verdict.endswith("good")
    assert run.energy.relative_error < 1e-3


# -- engines of one model --------------------------------------------------------------------------


def test_engines_share_constants_but_not_gravity_or_state(pendulum):
    one, other = jo.model.Engine(pendulum), jo.model.Engine(pendulum)
    before, _ = other.accelerations()
    before = before.copy()
    one.gravity[:] = 0.0
    one.q[:3] += 1.0
    after, _ = other.accelerations()
    assert_array_equal(before, after)
    del one
    assert_array_equal(jo.model.Engine(pendulum).accelerations()[0], before)
    perturbed = jo.model.Engine(pendulum, override={("body", 0, "K"): 2.0 * pendulum.bodies[0].K})
    perturbed.q[7:9] = other.q[7:9] = 1e-3
    assert not np.array_equal(perturbed.accelerations()[0], other.accelerations()[0])


def test_the_constants_of_a_model_go_with_it():
    from jousto.model.native import layout

    body = jo.RigidBody("b", 1.0, (1, 1, 1))
    joint = jo.Spherical("j", jo.ground["origin"], body["origin"])
    model = jo.compile(jo.Mechanism(body, joint, EARTH))
    engine = jo.model.Engine(model)
    assert model in layout._LAID
    count = len(layout._LAID)
    del model, engine
    assert len(layout._LAID) == count - 1
