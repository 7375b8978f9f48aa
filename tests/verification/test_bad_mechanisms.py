"""Bad mechanisms: each ends in a sentence that names the culprit, what was found and the remedy.

Every case says where it must be noticed (as a whole mechanism, at compilation, during the run) and
the words that an engineer needs to act on. Friction without a load path is in
tests/model/test_friction.py.
"""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

import jousto as jo

X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
GRAVITY = jo.Gravity((0.0, -9.81, 0.0))
O = jo.ground["origin"]
RUN = jo.RK4(step=1e-2)
SOLVERS = [
    RUN,
    jo.ROS2(step=1e-2),
    jo.GeneralizedAlpha(step=1e-2),
    jo.simulation.Newmark(step=1e-2),
    jo.simulation.DormandPrince(),
]


def bar(name, **where):
    return jo.RigidBody(name, 1.0, (0.1, 0.1, 0.1), markers={"end": (1, 0, 0)}, **where)


def hinged(*more):
    """A bar on a hinge, its drives and forces made by functions of both."""
    arm = bar("arm")
    hinge = jo.Revolute("hinge", O, arm["origin"], Z)
    return jo.Mechanism(arm, hinge, *[make(arm, hinge) for make in more], name="machine")


def turn(signal, name="motor"):
    return lambda arm, hinge: jo.Drive(name, hinge.angle, signal)


def lift(signal):
    return lambda arm, hinge: jo.Drive("lift", jo.Displacement(O, arm["end"], "y"), signal)


def geared(one, other):
    """Two shafts in gear, both driven."""
    a, b = bar("a"), bar("b")
    pivots = [jo.Revolute(f"pivot {x.name}", O, x["origin"], Z) for x in (a, b)]
    gear = jo.Gear("gear", pivots[0].angle, pivots[1].angle, ratio=2.0)
    drives = [
        jo.Drive(f"motor {k}", p.angle, s)
        for k, p, s in zip("ab", pivots, (one, other), strict=True)
    ]
    return jo.Mechanism(a, b, *pivots, gear, *drives, name="machine")


def said(problem):
    """Sentences of an InputError, one each."""
    return [str(p) for p in problem.value.problems]


# -- over-driven -----------------------------------------------------------------------------------


def test_one_coordinate_driven_twice():
    with pytest.raises(jo.InputError) as problem:
        hinged(turn(jo.Ramp(0, 1, 0, 1)), turn(jo.Ramp(0, 1, 0, 2), "second"))
    assert said(problem) == [
        "drive 'second': drives hinge.angle, which drive 'motor' drives already; leave one out"
    ]


def test_drives_that_repeat_one_another_run_and_are_named():
    curve = jo.SCurve([0.0, 1.0], [0.0, 1.0])
    with pytest.warns(
        jo.JoustoWarning,
        match=r"a motion is driven twice \('motor a', 'motor b'\): "
        "the run stops if they disagree.*leave out the drive 'motor b'",
    ):
        model = jo.compile(geared(curve, 2.0 * curve))
    run = jo.simulate(model, 1.0, solver=RUN)
    assert run.residuals.position.max() < 1e-12


def test_a_drive_of_what_cannot_move():
    arm = bar("arm")
    hinge, post = (
        jo.Revolute("hinge", O, arm["origin"], Z),
        jo.Rod("post", jo.ground.at((1, 1, 0)), arm["end"]),
    )
    motor = jo.Drive("motor", hinge.angle, jo.SCurve([0.0, 1.0], [0.0, 1.0]))
    with pytest.warns(jo.JoustoWarning) as caught:
        model = jo.compile(jo.Mechanism(arm, hinge, post, motor))
    text = str(caught[-1].message)
    assert (
        "the drive 'motor' prescribes a motion that joints already prevent or prescribe: the run"
        in text
    )
    assert "leave out the drive 'motor'" in text
    with pytest.raises(
        jo.simulation.RunFailed, match="joint 'post' is open .* contradicts 'hinge', 'motor'"
    ):
        jo.simulate(model, 1.0, solver=RUN)


# -- conflicting drives ----------------------------------------------------------------------------


def test_drives_that_conflict_from_the_start():
    ramp = jo.Ramp(0.0, 1.0, 0.0, 1.0)
    with pytest.raises(jo.InputError) as problem:
        jo.compile(geared(ramp, ramp))
    found = said(problem)
    assert [line.split(":")[0] for line in found] == [
        "coupling 'gear'",
        "drive 'motor a'",
        "drive 'motor b'",
    ]
    assert "drive 'motor a': contradicts 'gear', 'motor b'" in found[1]
    assert all("leave a free motion for every drive" in line for line in found)


@pytest.mark.filterwarnings("ignore:.*driven twice:jousto.JoustoWarning")
@pytest.mark.parametrize("solver", SOLVERS, ids=lambda solver: type(solver).__name__)
def test_drives_that_conflict_later_stop_the_run(solver):
    # position and rate agree at first
    curve = jo.SCurve([0.0, 1.0], [0.0, 1.0])
    model = jo.compile(geared(curve, curve))
    with pytest.raises(
        jo.SimulationError,
        match="cannot follow .* 'gear', 'motor a', 'motor b' contradict one another from there on; "
        "give each motion one drive only",
    ):
        jo.simulation.kinematics(model, [0.0, 0.5, 1.0])
    with pytest.raises(jo.simulation.RunFailed) as problem:
        jo.simulate(model, 1.0, solver=solver)
    text = str(problem.value)
    assert "coupling 'gear' is open by" in text or "drive 'motor" in text
    assert "it contradicts 'motor a', 'motor b'; drive each motion once" in text
    assert 0.0 < problem.value.time < 0.2
    assert problem.value.solution.nt > 1


def test_a_drive_that_jumps():
    with pytest.warns(
        jo.JoustoWarning,
        match=r"drive 'motor': its signal jumps at t = 0.5 s, .* use "
        "SCurve or Ramp",
    ):
        hinged(turn(jo.Step(0.5, 0.0, 1.0)))


def test_a_drive_beyond_what_the_lengths_allow():
    model = jo.compile(hinged(lift(jo.Ramp(0.0, 1.0, 0.0, 1.5))))
    with pytest.raises(
        jo.SimulationError,
        match="cannot follow its drives past .* keep the drives within the limits of the lengths",
    ):
        jo.simulation.kinematics(model, [0.0, 0.5, 1.0])
    with pytest.raises(
        jo.simulation.RunFailed, match=r"lengths do not allow the motion of the drives \('lift'\)"
    ):
        jo.simulate(model, 1.0, solver=RUN)


# -- loops -----------------------------------------------------------------------------------------


def loop(reach, kind, tilt=0.0, **options):
    a = bar("a", orientation=jo.Rotate(Z, degrees=tilt))
    b = bar("b", position=a["end"].r, orientation=jo.Rotate(Z, degrees=-tilt))
    ends = ((O, a["origin"]), (a["end"], b["origin"]), (b["end"], jo.ground.at((reach, 0, 0))))
    joints = [kind(name, *pair, **options) for name, pair in zip("ABC", ends, strict=True)]
    return jo.Mechanism(a, b, *joints, GRAVITY, name="machine")


def test_an_open_loop_is_an_error_with_its_gap():
    with pytest.raises(jo.InputError) as problem:
        loop(2.5, jo.Revolute, axis=Z)
    assert said(problem) == [
        "joint 'C': initial gap of 500 mm: b.end is at (2, 0, 0), ground.at(2.5, 0, 0) at "
        "(2.5, 0, 0) m; move a body until the points meet"
    ]


@pytest.mark.parametrize("kind", [jo.Revolute, jo.Spherical, jo.Universal])
def test_a_loop_that_cannot_close(kind):
    mechanism = loop(2.5, kind, as_placed=False)
    with pytest.raises(jo.InputError) as problem:
        jo.compile(mechanism)
    found = said(problem)
    assert found
    for line in found:
        assert "cannot be closed, " in line
        assert "change a length" in line
        assert "start nearer to the closed position" in line


def test_a_rough_loop_that_can_close_is_closed():
    with pytest.warns(jo.JoustoWarning, match="3 of the constraint rows of 'A', 'B', 'C'"):
        model = jo.compile(loop(1.7, jo.Revolute, tilt=20.0, as_placed=False))
    assert np.abs(jo.model.Engine(model).constraints()[0]).max() < 1e-12


# -- nothing can move ------------------------------------------------------------------------------


def test_mobility_zero():
    with pytest.warns(
        jo.JoustoWarning,
        match="nothing can move: its 6 constraint rows prevent every motion; free a motion",
    ):
        welded = jo.Mechanism(arm := bar("arm"), jo.Fixed("weld", O, arm["origin"]), GRAVITY)
        jo.compile(welded)
    found = jo.doctor(welded)
    assert found.mobility == 0
    assert found.still == ("arm",)


def test_a_triangle_of_bars_stands_still_and_says_so():
    a = bar("a", orientation=jo.Rotate(Z, degrees=60.0))
    b = bar("b", position=(1, 0, 0), orientation=jo.Rotate(Z, degrees=120.0))
    joints = (
        jo.Revolute("A", O, a["origin"], Z),
        jo.Revolute("B", jo.ground.at((1, 0, 0)), b["origin"], Z),
        jo.Revolute("C", a["end"], b["end"], Z),
    )
    with pytest.warns(
        jo.JoustoWarning,
        match="'A', 'B', 'C' are redundant; nothing can move.*"
        "replace the revolute joint 'A' by a spherical one",
    ):
        model = jo.compile(jo.Mechanism(a, b, *joints, GRAVITY))
    # no warning about an energy balance of round-off
    run = jo.simulate(model, 0.1, solver=RUN)
    assert np.abs(run.v).max() < 1e-12


# -- reactions that are not unique -----------------------------------------------------------------


def test_redundant_reactions_asked_for():
    door = bar("door")
    low = jo.Revolute("low", O, door["origin"], X)
    high = jo.Revolute("high", jo.ground.at((1, 0, 0)), door["end"], X)
    asked = jo.ReactionSensor("hinge force", low)
    with pytest.warns(jo.JoustoWarning) as caught:
        model = jo.compile(jo.Mechanism(door, low, high, asked, GRAVITY))
    (text,) = [str(w.message) for w in caught if "are redundant" in str(w.message)]
    assert "5 of the constraint rows of 'low', 'high' are redundant" in text
    assert "the reactions of these joints are not unique (computed: those of least norm)" in text
    assert "leave out the joint 'high'" in text
    assert "'hinge force' depend on these reactions" in text
    (sensor,) = model.sensors
    assert "not unique" in sensor.description


# -- user functions --------------------------------------------------------------------------------


def late(value):
    """Zero for 0.4 s, then a value or an exception."""

    def wind(t, x):
        if t < 0.4:
            return np.zeros(6)
        if isinstance(value, Exception):
            raise value
        return value

    return wind


COMPILED = ctypes.CFUNCTYPE(
    ctypes.c_int,
    ctypes.c_double,
    ctypes.POINTER(ctypes.c_double),
    ctypes.POINTER(ctypes.c_double),
    ctypes.c_void_p,
)


@COMPILED
def failing(t, x, y, user):
    return int(t > 0.4)


@COMPILED
def undefined(t, x, y, user):
    for i in range(6):
        y[i] = np.nan if t > 0.4 else 0.0
    return 0


CALLBACKS = {
    "raises": (late(KeyError("no wind")), "raised KeyError: 'no wind'"),
    "returns NaN": (
        late([0, 0, 0, 0, np.nan, 0]),
        "returned values that are not finite, torque y is nan; check it at the positions",
    ),
    "returns a force only": (late(np.zeros(3)), r"array of shape \(3,\), must be \(6,\)"),
    "returns nothing": (late(None), "returned"),
    "compiled, error": (failing, "reported an error or returned a value that is not finite"),
    "compiled, NaN": (undefined, "reported an error or returned a value that is not finite"),
}


@pytest.mark.parametrize("case", CALLBACKS)
def test_user_functions_that_fail(case):
    function, expected = CALLBACKS[case]
    model = jo.compile(hinged(lambda arm, _: jo.UserForce("wind", arm["end"], function)))
    with pytest.raises(
        jo.simulation.RunFailed, match=f"force 'wind': its function .*{expected}"
    ) as problem:
        jo.simulate(model, 1.0, solver=RUN)
    # the run up to there is kept
    assert 0.39 < problem.value.time < 0.42
    assert problem.value.solution.nt in (40, 41)


def test_a_user_function_that_fails_at_once():
    with pytest.raises(jo.SimulationError, match="force 'wind': its function raised ZeroDivision"):
        jo.compile(hinged(lambda arm, _: jo.UserForce("wind", arm["end"], lambda t, x: 1 / 0)))
