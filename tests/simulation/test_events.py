"""Runs with events, inputs and states to go on from."""

from __future__ import annotations

import importlib

import h5py
import numpy as np
import pytest

import jousto as jo
from jousto.simulation.running.simulate import describe
from verification.test_friction import block_on_a_belt

pytestmark = pytest.mark.filterwarnings("ignore:.*nothing will move")

G = 9.81
SOLVERS = [
    jo.RK4(0.01), jo.ROS2(0.01), jo.simulation.SSPRK3(0.01), jo.simulation.ROS3A(0.01)
]  # fmt: skip


def slewing(stop=True, *, law=None):
    """A drum with an unbalance, turned by a motor until a limit switch; angle over many turns."""
    drum = jo.RigidBody("drum", 2.0, (0.1, 0.1, 0.1), center=(0.02, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], drum["origin"], axis=(0, 0, 1))
    limit = jo.mechanism.Event("limit", hinge.angle, 20.0, "rising", stop)
    half = jo.mechanism.Event("half turn", hinge.angle, np.pi, "rising")
    torque = (
        jo.mechanism.Switched(half, 2.0, 1.0) if stop else jo.mechanism.Switched(limit, 2.0, -3.0)
    )
    items = [] if law is None else [jo.Friction("rub", hinge, 0.05, 0.1, radius=0.05, law=law)]
    return jo.compile(
        jo.Mechanism(
            *(drum, hinge, limit, half, jo.Gravity((0, -G, 0)), *items),
            jo.JointForce("motor", hinge.angle, torque),
            jo.JointForce("brake", hinge.angle, jo.Input("brake", -0.1)),
            jo.CoordinateSensor("angle", hinge.angle),
            name="drum",
        )
    )


def test_a_run_that_an_event_stops_ends_normally(tmp_path):
    path = tmp_path / "run.h5"
    run = jo.simulate(slewing(), 20.0, output_step=0.1, solver=jo.RK4(0.01), path=path)
    assert run.complete
    end = run.time[-1]
    assert run.attributes["ended"] == f"stopped by event 'limit' at {end:.9g} s"
    assert describe(run)["ended"].startswith("stopped by event 'limit'")
    assert run["angle"][-1, 0] == pytest.approx(20.0, abs=1e-10)
    np.testing.assert_allclose(run.time[:-1], 0.1 * np.arange(run.nt - 1), atol=1e-12)
    assert 0 < end - run.time[-2] <= 0.1
    with h5py.File(path) as file:  # no room left over
        assert file["time"].shape == file["sensors/angle"].shape[:1] == (run.nt,)
        assert file["events/names"][()].tolist() == [b"limit", b"half turn"]
    assert [(e.name, e.change, e.count) for e in jo.load(path).events] == [
        ("half turn", "rising", 1),
        ("limit", "rising", 1),
    ]
    assert run.events[-1].time == end
    assert str(run.events[0]).endswith(" s: half turn rising, 1st time")


def test_a_run_without_events_has_an_empty_table(pendulum):
    run = jo.simulate(pendulum, 0.01)
    assert run.events == ()
    assert run.attributes["ended"] == "completed"


def test_the_table_tells_stick_and_slip(tmp_path):
    run = jo.simulate(block_on_a_belt(jo.mechanism.StickSlip()), 1.7, solver=jo.RK4(0.005))
    words = [(e.name, e.change, e.count) for e in run.events]
    assert words == [
        ("rub", "slips backward", 1),
        ("rub", "sticks", 2),
        ("rub", "slips backward", 3),
        ("rub", "sticks", 4),
    ]


def test_a_long_table_is_cut_with_a_warning(monkeypatch):
    for name in ("results.memory", "results.writer", "running.simulate"):
        monkeypatch.setattr(importlib.import_module(f"jousto.simulation.{name}"), "EVENTS", 5)
    body = jo.RigidBody("body", 1.0, (1, 1, 1), velocity=(1, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], (1, 0, 0))
    wave = jo.SignalSensor("wave", jo.Harmonic(frequency=20.0))
    model = jo.compile(jo.Mechanism(body, rail, wave, jo.mechanism.Event("zero", wave)))
    with pytest.warns(jo.JoustoWarning, match="only the first 5 events"):
        run = jo.simulate(model, 1.0)
    assert [e.count for e in run.events] == [1, 2, 3, 4, 5]


# -- going on -----------------------------------------------------------------------------------


@pytest.mark.parametrize("law", [None, jo.mechanism.StickSlip()], ids=["free", "stick-slip"])
@pytest.mark.parametrize("solver", SOLVERS, ids=lambda s: type(s).__name__)
def test_a_run_goes_on_as_if_it_had_not_been_interrupted(solver, law):
    model = slewing(stop=False, law=law)
    options = {"solver": solver, "output_step": 0.05}
    whole = jo.simulate(model, 16.0, **options)
    assert whole["angle"].max() > 6 * np.pi  # turns are remembered
    assert [e.name for e in whole.events].count("limit") >= 1
    for instant in (2.0, 9.3):
        first = jo.simulate(model, instant, **options)
        rest = jo.simulate(model, 16.0, state=first.state(), **options)
        k = first.nt - 1
        for name in ("time", "q", "v", "multipliers"):
            np.testing.assert_array_equal(getattr(rest, name), getattr(whole, name)[k:])
        np.testing.assert_array_equal(rest["angle"], whole["angle"][k:])
        np.testing.assert_array_equal(rest.energy.friction, whole.energy.friction[k:])
        assert first.events + rest.events == whole.events
        # any instant of a run will do
        middle = jo.simulate(model, 16.0, state=whole.state(instant), **options)
        np.testing.assert_array_equal(middle.q, whole.q[k:])
        assert np.abs(rest.energy.error).max() < 2 * np.abs(whole.energy.error).max() + 1e-12


@pytest.mark.parametrize(
    ("solver", "tolerance"),
    [(jo.GeneralizedAlpha(0.005), 2e-4), (jo.simulation.DormandPrince(1e-9), 1e-6)],
    ids=lambda x: type(x).__name__,
)
def test_methods_with_a_memory_start_anew_within_their_accuracy(solver, tolerance):
    model = slewing(stop=False)
    whole = jo.simulate(model, 4.0, solver=solver, output_step=0.05)
    first = jo.simulate(model, 2.5, solver=solver, output_step=0.05)
    rest = jo.simulate(model, 4.0, solver=solver, output_step=0.05, state=first.state())
    np.testing.assert_allclose(rest["angle"], whole["angle"][50:], atol=tolerance)
    assert first.events + rest.events == whole.events
    assert whole.events


def test_states_that_do_not_fit_are_refused(pendulum):
    model = slewing()
    run = jo.simulate(model, 0.1, solver=jo.RK4(0.01))
    with pytest.raises(jo.InputError, match=r"no instant is stored at 0.055 s, the nearest is 0.0"):
        run.state(0.055)
    with pytest.raises(jo.InputError, match=r"t_end = 0.1 s is not after the state's time, 0.1 s"):
        jo.simulate(model, 0.1, state=run.state())
    with pytest.raises(jo.InputError) as error:
        jo.simulate(pendulum, 1.0, state=run.state())
    assert "take one of this model" in str(error.value)
    bad = run.state()
    bad.v[0] = np.nan
    with pytest.raises(jo.InputError, match="velocities of the state are not finite"):
        jo.simulate(model, 1.0, state=bad)


# -- inputs -------------------------------------------------------------------------------------


def cart():
    """A mass of 2 kg pushed by an input."""
    body = jo.RigidBody("cart", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    return jo.compile(
        jo.Mechanism(
            *(body, rail),
            jo.JointForce("push", rail.displacement, jo.Input("u") + 2.0 * jo.Input("w")),
            jo.CoordinateSensor("x", rail.displacement),
            jo.SignalSensor("u", jo.Input("u")),
        )
    )


@pytest.mark.parametrize("solver", SOLVERS, ids=lambda s: type(s).__name__)
def test_a_signal_for_an_input_is_that_signal(solver):
    wave = jo.Harmonic(frequency=0.7) + jo.Ramp(0.2, 0.4) * jo.Constant(3.0)
    run = jo.simulate(cart(), 1.0, solver=solver, inputs={"w": 0.5, "u": wave})
    body = jo.RigidBody("cart", 2.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    push = jo.JointForce("push", rail.displacement, wave + 2.0 * jo.Constant(0.5))
    x = jo.CoordinateSensor("x", rail.displacement)
    same = jo.simulate(jo.compile(jo.Mechanism(body, rail, push, x)), 1.0, solver=solver)
    np.testing.assert_allclose(run["x"], same["x"], atol=1e-15)
    np.testing.assert_allclose(run["u"].ravel(), wave(run.time), atol=1e-14)


def test_functions_and_samples_are_held():
    # steps of 0.1 s: u is held from the start of each, x follows exactly
    def force(t):
        return 4.0 * t

    run = jo.simulate(cart(), 1.0, solver=jo.RK4(0.1), inputs={"u": force})
    x = v = 0.0
    for k in range(10):
        a = force(0.1 * k) / 2.0
        x, v = x + 0.1 * v + 0.005 * a, v + 0.1 * a
    assert run["x"][-1, 0] == pytest.approx(x, rel=1e-12)
    samples = force(0.1 * np.arange(10))
    same = jo.simulate(cart(), 1.0, solver=jo.RK4(0.1), inputs={"u": samples})
    np.testing.assert_allclose(same["x"], run["x"], atol=1e-15)
    free = jo.simulate(
        cart(), 1.0, solver=jo.simulation.DormandPrince(), output_step=0.1, inputs={"u": force}
    )
    np.testing.assert_allclose(free["x"], run["x"], atol=1e-12)
    fine = jo.simulate(
        cart(), 1.0, solver=jo.RK4(0.01), output_step=0.1, inputs={"u": np.append(samples, 9.0)}
    )
    np.testing.assert_allclose(fine["x"], run["x"], atol=1e-14)
    np.testing.assert_allclose(fine["u"].ravel()[1:], samples)  # what was held until then


@pytest.mark.parametrize(
    ("value", "sentence"),
    [
        ({"v": 1.0}, "no input 'v'; known: u, w"),
        ({"u": "1"}, "is '1', must be a Signal, a number, a function of time or an array"),
        ({"u": np.nan}, "value is nan, must be finite"),
        ({"u": np.zeros(7)}, "has 7 samples, the run has 10 intervals between outputs"),
        ({"u": jo.Input("other")}, "its signal depends on an input or an event"),
    ],
)
def test_impossible_inputs(value, sentence):
    with pytest.raises(jo.InputError) as error:
        jo.simulate(cart(), 1.0, output_step=0.1, inputs=value)
    assert sentence in str(error.value)


@pytest.mark.parametrize(
    ("function", "sentence"),
    [
        (lambda t: 1.0 / (t - 0.5), "its function raised ZeroDivisionError"),
        (lambda t: 1.0 if t < 0.5 else float("nan"), "its function returned nan at 0.5 s"),
        (lambda t: 1.0 if t < 0.5 else None, "its function returned None at 0.5 s"),
    ],
)
def test_a_function_that_fails_ends_the_run_and_keeps_the_results(function, sentence):
    with pytest.raises(jo.simulation.RunFailed) as error:
        jo.simulate(cart(), 1.0, solver=jo.RK4(0.125), inputs={"u": function})
    assert sentence in str(error.value)
    assert "input 'u'" in str(error.value)
    assert error.value.solution.time[-1] == 0.5


# -- stepping from outside ----------------------------------------------------------------------


@pytest.mark.parametrize("solver", SOLVERS, ids=lambda s: type(s).__name__)
def test_a_simulator_does_what_simulate_does(solver):
    model = slewing()
    run = jo.simulate(model, 20.0, solver=solver)
    sim = jo.simulation.Simulator(model, solver)
    sim.step(100)
    assert sim.read("angle") == run["angle"][100]
    other = jo.simulation.Simulator(model, solver, state=sim.state())
    for s in (sim, other):
        while not s.stopped:
            s.step(7)
        assert s.stopped == "limit"
        assert s.time == pytest.approx(run.time[-1], abs=1e-12)
        assert s.read("angle")[0] == pytest.approx(20.0, abs=1e-10)
    assert sim.events == run.events


def test_a_controller_in_the_loop():
    sim = jo.simulation.Simulator(cart(), jo.RK4(0.01))
    x = v = 0.0
    for _ in range(300):
        measured = sim.read("x")[0]
        assert measured == pytest.approx(x, abs=1e-13)
        sim.set("u", -3.0 * (measured - 0.1))
        sim.step()
        a = -1.5 * (x - 0.1)
        x, v = x + 0.01 * v + 5e-5 * a, v + 0.01 * a
    assert sim.read("u")[0] == pytest.approx(-3.0 * (measured - 0.1))


def test_a_simulator_names_what_it_does_not_know():
    sim = jo.simulation.Simulator(cart())
    with pytest.raises(jo.InputError, match="no input 'uu'; did you mean 'u'"):
        sim.set("uu", 1.0)
    with pytest.raises(jo.InputError, match="input 'u': is nan, must be finite"):
        sim.set("u", np.nan)
    with pytest.raises(jo.InputError, match="no sensor 'y'"):
        sim.read("y")
    with pytest.raises(jo.InputError, match="solver is 3, must be one of .*RK4"):
        jo.simulation.Simulator(cart(), 3)
    with pytest.raises(jo.InputError, match="DormandPrince chooses its steps itself"):
        jo.simulation.Simulator(cart(), jo.simulation.DormandPrince())
