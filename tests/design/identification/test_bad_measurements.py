"""Measurements that are wrong: one sentence each, all at once."""

import warnings

import numpy as np
import pytest

import jousto as jo
from design.identification.machines import oscillator, record, released
from jousto.design import Experiment, Values, identify

T, X = released(samples=101)


def machine(k):
    return oscillator(k, mass=2.0, start=0.1)


def stiffness(**more):
    return jo.Parameter("k", 40.0, unit="N/m", **more)


def given(**more):
    return Experiment(record(T, X, 1e-4), **{"noise": {"x": 1e-4}} | more)


def sentences(*args, **more):
    with pytest.raises(jo.InputError) as caught:
        identify(*args, **more)
    return str(caught.value)


def test_all_problems_of_an_experiment_come_at_once():
    with pytest.raises(jo.InputError) as caught:
        Experiment(
            record(T + (-0.5), X),
            inputs={"push": "forze"},
            noise={"y": 1.0},
            gain={"x": "one"},
            window=(2.0, 1.0),
        )
    text = str(caught.value)
    assert "the model at 0 s; move it by record.shifted" in text
    assert "input 'push': no channel 'forze'" in text
    assert "noise: no channel 'y'" in text
    assert "gain of x" in text
    assert "the first instant must be below the second" in text


@pytest.mark.parametrize(
    ("noise", "sentence"),
    [
        ("2", "noise of 'x' is '2', must be a positive number, an array (nt,), a channel"),
        (-1.0, "must be a positive number"),
        (0.0, "must be a positive number"),
        (np.nan, "must be a positive number"),
        ([1.0, 2.0], "must be a positive number"),
        (True, "must be a positive number"),
        ("0 %", "noise of 'x' is 0 at 101 samples; add an absolute part"),
    ],
)
def test_noise_that_is_none(noise, sentence):
    assert sentence in sentences(machine, stiffness(), given(noise={"x": noise}))


def test_channels_and_sensors_that_do_not_meet():
    text = sentences(machine, stiffness(), given(outputs={"xx": "x", "x": "y"}))
    assert "no sensor 'xx'" in text and "no channel 'y'" in text
    other = Experiment(record(T, X).renamed({"x": "laser"}))
    assert "nothing to compare: channels laser; sensors x" in sentences(machine, stiffness(), other)


def test_a_channel_without_unit_or_in_another():
    bare = jo.gauges.Record(T, {"x": X}, {}, "bare")
    text = sentences(machine, stiffness(), Experiment(bare))
    assert "channel 'x' has no unit; sensor 'x' is in m: read_record(..., units={'x': ...})" in text
    text = sentences(machine, stiffness(), Experiment(record(T, X, unit="m/s2")))
    assert "channel 'x' has the unit m/s2; sensor 'x' is in m" in text


def test_a_channel_that_drives_and_is_compared():
    text = sentences(machine, stiffness(), given(inputs={"force": "x"}, outputs={"x": "x"}))
    assert "channel 'x' drives the model and is compared, too" in text


def test_a_dead_channel():
    text = sentences(machine, stiffness(), Experiment(record(T, 0 * X + 1.0)))
    assert "channel 'x' is constant (1): dead or not connected; leave it out of outputs" in text


def test_too_few_values():
    short = Experiment(record(T[:5], X[:5]), window=(0.0, 0.05))
    assert "channel 'x' has 3 values to compare, must have 4" in sentences(
        machine, stiffness(), short
    )
    one = Values({"frequency(1)": (1.0, 0.1)})
    two = [stiffness(), jo.Parameter("mass", 1.0, unit="kg")]
    text = sentences(lambda k, mass: oscillator(k, mass=mass), two, one)
    assert "2 unknown numbers, but 1 value" in text


def test_parameters_that_nothing_uses_or_have_one_name():
    text = sentences(machine, [stiffness(), jo.Parameter("stiffness", 1.0)], given())
    assert "parameter 'stiffness': is unused" in text
    bias = {"x": jo.Parameter("k", 0.0, unit="m")}
    text = sentences(machine, stiffness(), given(bias=bias))
    assert "parameter 'k': is the name of two unknowns" in text


def test_a_check_record_seeks_nothing_of_its_own():
    bias = {"x": jo.Parameter("bias", 0.0, unit="m")}
    text = sentences(machine, stiffness(), given(), check=given(bias=bias))
    assert "parameter 'bias': is sought for a channel of a check record" in text
    found = identify(
        machine, stiffness(), given(bias=bias), check=given(bias=bias), solver=jo.RK4(1e-2)
    )
    assert found.checks[0].test.rms == pytest.approx(found.fits[0].test.rms, rel=0.02)


def test_a_machine_that_fails_at_the_start():
    text = sentences(machine, jo.Parameter("k", -1e9, unit="N/m"), given())
    assert "stiffness is -1e+09, must not be negative" in text
    text = sentences(lambda k: 1 / 0, stiffness(), given())
    assert "ZeroDivisionError" in text


def test_a_failing_machine_beside_the_way_is_only_a_shorter_step():
    def fragile(k):
        if k > 60.0:
            raise ValueError("too stiff")
        return machine(k)

    found = identify(fragile, jo.Parameter("k", 59.9, unit="N/m"), given(), solver=jo.RK4(1e-2))
    assert found["k"] == pytest.approx(50.0, rel=1e-3)


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        ({"loss": "square"}, "loss is 'square', must be one of linear, huber, soft_l1, cauchy"),
        ({"starts": 0}, "starts is 0, must be a whole number from 1 on"),
        ({"workers": 1.5}, "workers is 1.5, must be a whole number from 1 on"),
        ({"check": 3}, "check is 3, must be an Experiment"),
    ],
)
def test_arguments_that_are_none(more, sentence):
    assert sentence in sentences(machine, stiffness(), given(), **more)


def test_held_inputs_must_be_inputs():
    text = sentences(machine, stiffness(), given(held=["force"]))
    assert "held: no input 'force'" in text


def test_priors_that_are_not_normal():
    text = sentences(machine, stiffness(distribution="uniform(30 N/m, 50 N/m)"), given())
    assert "the prior here, must be normal or lognormal" in text


def test_bounds_that_end_the_search_are_said():
    with pytest.warns(jo.JoustoWarning) as caught:
        found = identify(machine, stiffness(bounds=(30.0, 45.0)), given(), solver=jo.RK4(1e-2))
    assert found["k"] == pytest.approx(45.0)
    assert any("'k' ends on its upper bound 45" in str(one.message) for one in caught)


def test_a_start_on_a_bound_is_moved_inside():
    with pytest.warns(jo.JoustoWarning, match="starts on its bound 40; the search starts at 40.6"):
        found = identify(machine, stiffness(bounds=(40.0, 100.0)), given(), solver=jo.RK4(1e-2))
    assert found["k"] == pytest.approx(50.0, rel=1e-3)


def test_a_channel_of_the_other_sign():
    near = jo.Parameter("k", 49.0, bounds=(45.0, 55.0), unit="N/m")
    turned = Experiment(record(T, -X, 1e-4), noise={"x": 1e-4})
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        identify(machine, near, turned, solver=jo.RK4(1e-2))
    assert any("wired with the other sign? Compare with '-x'" in str(one.message) for one in caught)
    right = Experiment(record(T, -X, 1e-4), outputs={"x": "-x"}, noise={"x": 1e-4})
    found = identify(machine, stiffness(), right, solver=jo.RK4(1e-2))
    assert found["k"] == pytest.approx(50.0, rel=1e-3)


def test_steps_that_show_in_the_result():
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        identify(machine, stiffness(), given(noise={"x": 1e-7}), solver=jo.RK4(2e-2))
    assert any("give a solver with a shorter step" in str(one.message) for one in caught)


def test_unknown_names_of_the_result():
    found = identify(machine, stiffness(), given(), solver=jo.RK4(1e-2))
    with pytest.raises(jo.InputError, match="no unknown 'K'"):
        found["K"]


@pytest.mark.parametrize("pair", [1.0, (1.0,), (1.0, 0.0), (1.0, "x"), (np.nan, 1.0), "ab"])
def test_values_must_be_pairs(pair):
    with pytest.raises(jo.InputError, match="must be a pair of the value and its standard dev"):
        Values({"mass": pair})
