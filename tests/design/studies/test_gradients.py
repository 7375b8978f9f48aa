"""Gradients of outcomes: closed forms, and central differences of the same machine."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.base.complexstep import STEP, stepping
from jousto.design.studies.case import Machine, Settings
from jousto.design.studies.gradient_result import WAYS

P = jo.Parameter
G = 9.81
ROUND_OFF = 1e-10  # of derivatives of closed forms: some hundred operations in double precision


def slopes(study, x=None, share=1e-3):
    """Central differences of fourth order (no, np): errors of share^4 and of 1e-13 / share."""
    x = np.asarray(study.nominal if x is None else x)
    columns = []
    for j in range(len(x)):
        h = np.zeros(len(x))
        h[j] = share * (abs(x[j]) or 1.0)
        near, far = study([x + h, x - h]), study([x + 2 * h, x - 2 * h])
        columns.append((8 * (near[0] - near[1]) - (far[0] - far[1])) / (12 * h[j]))
    return np.transpose(columns)


def agree(found, wanted, tolerance=1e-6):
    """Every derivative is that of differences, relative to the largest of its row."""
    assert found.exact, str(found)
    # differences lose what round-off of the outcome leaves of a slope that is nearly zero
    noise = 1e-9 * np.abs(found.values)[:, None] / np.maximum(np.abs(found.x), 1e-300)
    error = np.abs(found.jacobian - wanted)
    assert np.all(error <= tolerance * np.abs(wanted) + noise), f"{error}\n{wanted}"


def pendulum(mass, length, inertia, g):
    bob = jo.RigidBody("bob", mass, (inertia, inertia, inertia), center=(0, -length, 0))
    pivot = jo.Revolute("pivot", jo.ground["origin"], bob["origin"])
    return jo.Mechanism(bob, pivot, jo.Gravity((0, -g, 0)))


def test_frequency_of_a_pendulum():
    # f = sqrt(m g l / (J + m l^2)) / 2 pi
    at = {"mass": 2.0, "length": 0.7, "inertia": 0.3, "g": G}
    study = jo.study(pendulum, [P(k, v) for k, v in at.items()], "frequency(1)")
    found = jo.design.gradient(study)
    m, length, J, g = at.values()
    I = J + m * length**2
    f = math.sqrt(m * g * length / I) / (2 * math.pi)
    half = [1 / m - length**2 / I, 1 / length - 2 * m * length / I, -1 / I, 1 / g]
    assert found.exact
    np.testing.assert_allclose(found.values, [f], rtol=ROUND_OFF)
    np.testing.assert_allclose(found.jacobian[0], 0.5 * f * np.array(half), rtol=ROUND_OFF)


def masses(m1, m2, k1, k2):
    """Two masses on springs in a row, sliding without friction."""
    items = []
    before = jo.ground["origin"]
    for name, m, k in (("1", m1, k1), ("2", m2, k2)):
        body = jo.RigidBody(f"mass {name}", m, (1.0, 1.0, 1.0))
        slide = jo.Prismatic(f"slide {name}", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
        along = jo.Displacement(before, body["origin"], "x")
        spring = jo.Spring(f"spring {name}", along, k)
        items += [body, slide, spring, jo.CoordinateSensor(f"x{name}", slide.displacement)]
        before = body["origin"]
    return jo.Mechanism(*items, jo.Gravity((G, 0, 0)))


def test_frequencies_and_rest_of_two_masses_on_springs():
    at = {"m1": 2.0, "m2": 3.0, "k1": 700.0, "k2": 400.0}
    study = jo.study(
        masses,
        [P(k, v) for k, v in at.items()],
        ["frequency(1)", "frequency(2)", "frequency(1, rest)", "first(x1)", "first(x2)", "mass"],
        t_end=1e-3,
        state=jo.equilibrium,
    )
    found = jo.design.gradient(study)
    m1, m2, k1, k2 = at.values()
    # d omega^2 = x^T (dK - omega^2 dM) x with x^T M x = 1
    K = np.array([[k1 + k2, -k2], [-k2, k2]])
    root = np.diag([m1**-0.5, m2**-0.5])
    squares, z = np.linalg.eigh(root @ K @ root)
    for i, (square, x) in enumerate(zip(squares, (root @ z).T, strict=True)):
        f = math.sqrt(square) / (2 * math.pi)
        by = [-square * x[0] ** 2, -square * x[1] ** 2, x[0] ** 2, (x[1] - x[0]) ** 2]
        wanted = np.array(by) / (8 * math.pi**2 * f)
        np.testing.assert_allclose(found.jacobian[i], wanted, rtol=ROUND_OFF)
    np.testing.assert_allclose(found.jacobian[2], found.jacobian[0], rtol=1e-9)
    # x1 = (m1 + m2) g / k1, x2 = x1 + m2 g / k2
    x1 = np.array([G / k1, G / k1, -(m1 + m2) * G / k1**2, 0.0])
    np.testing.assert_allclose(found["first(x1)"], x1, rtol=ROUND_OFF, atol=1e-15)
    x2 = x1 + [0.0, G / k2, 0.0, -m2 * G / k2**2]
    np.testing.assert_allclose(found["first(x2)"], x2, rtol=ROUND_OFF, atol=1e-15)
    np.testing.assert_allclose(found["mass"], [1, 1, 0, 0], rtol=ROUND_OFF, atol=1e-15)


def test_equal_frequencies_have_the_slopes_of_the_branches():
    # two pendulums of one length: shortening one raises its frequency alone
    def pair(a, b):
        items = []
        for name, length in (("a", a), ("b", b)):
            bob = jo.RigidBody(name, 1.0, (1e-3, 1e-3, 1e-3), center=(0, -length, 0))
            items += [bob, jo.Revolute(f"pivot {name}", jo.ground["origin"], bob["origin"])]
        return jo.Mechanism(*items, jo.Gravity((0, -G, 0)))

    outcomes = ["frequency(1)", "frequency(2)"]
    # differences across the crossing would say something else: no check by them
    found = jo.design.gradient(jo.study(pair, [P("a", 0.5), P("b", 0.5)], outcomes), check=False)
    I = 1e-3 + 0.25
    f = math.sqrt(G * 0.5 / I) / (2 * math.pi)
    slope = 0.5 * f * (2.0 - 1.0 / I)
    assert slope < 0
    np.testing.assert_allclose(found.jacobian, [[slope, slope], [0, 0]], rtol=1e-9, atol=1e-9)


def four_bar(crank, coupler, rocker, mass, stiffness, damping, angle, anchor, width):
    """A four-bar with a driven crank, a spring, an offset of its base and a box as coupler."""
    base = 0.5
    # the angle of the rocker from the law of cosines: a start that moves with the lengths
    d2 = (base - crank) ** 2
    beta = np.arccos((d2 + rocker**2 - coupler**2) / (2 * np.sqrt(d2) * rocker))
    B = np.array([base - rocker * np.cos(beta), rocker * np.sin(beta), 0])
    A = np.array([crank, 0, 0])
    n = (B - A) / coupler
    tilt = [[n[0], -n[1], 0], [n[1], n[0], 0], [0, 0, 1]]
    m = np.array([0, 0, 0.01])
    one = jo.RigidBody("crank", 0.4, (1e-4, 2e-3, 2e-3), center=(crank / 2, 0, 0))
    two = jo.RigidBody.box(
        "coupler", (coupler, width, 0.01), mass=mass, position=0.5 * (A + B), orientation=tilt
    )
    three = jo.RigidBody("rocker", 0.5, (1e-2, 1e-2, 1e-2), position=(base, 0, 0))
    crank_pin = jo.Revolute("crank pin", jo.ground["origin"], one["origin"])
    pins = [
        jo.Spherical("A", one.at((crank, 0, 0)), two.at((-coupler / 2, 0, 0))),
        jo.Spherical("B", three.at(B - [base, 0, 0]), two.at((coupler / 2, 0, 0))),
        jo.Revolute("D", jo.ground.at((base, 0, 0)), three["origin"]),
    ]
    turn = jo.Drive("turn", crank_pin.angle, jo.SCurve((0.0, 0.3), (0.0, angle)))
    spring = jo.Spring.between(
        "spring", jo.ground.at((0.2, anchor, 0)), two["center"], stiffness, damping=damping
    )
    spin = jo.Bushing(
        "spin", jo.ground.at(0.5 * (A + B)), two.at((0, 0, 0)), (0, 0, 0, 2.0, 2.0, 0), damping=0.0
    )
    sensors = [
        jo.PositionSensor("mid", two.at(m)),
        jo.ReactionSensor("force", pins[2]),
        jo.VelocitySensor("rate", three.at((0.1, 0, 0))),
    ]
    return jo.Mechanism(
        one, two, three, crank_pin, *pins, turn, spring, spin, jo.Gravity((0, -G, 0)), *sensors
    )


FOUR_BAR = {
    "crank": 0.12,
    "coupler": 0.5,
    "rocker": 0.35,
    "mass": 0.8,
    "stiffness": 300.0,
    "damping": 4.0,
    "angle": 2.0,
    "anchor": 0.6,
    "width": 0.03,
}


@pytest.mark.parametrize(
    "solver", [jo.RK4(2e-3), jo.ROS2(2e-3), jo.GeneralizedAlpha(2e-3, tangent="exact")]
)
def test_run_of_a_four_bar(solver):
    study = jo.study(
        four_bar,
        [P(k, v) for k, v in FOUR_BAR.items()],
        ["max(mid.y)", "rms(mid.x)", "peak(rate.x)", "reaction(D)", "last(mid.x)"],
        t_end=0.3,
        solver=solver,
    )
    agree(jo.design.gradient(study), slopes(study, share=1e-4))


def thrown(speed, angle, drag):
    ball = jo.RigidBody("ball", 1.0, (1e-3, 1e-3, 1e-3), velocity=(speed, 0, 0))
    wind = jo.Force(
        "wind", ball["origin"], (1, 0, 0), signal=jo.Harmonic(frequency=1.0, phase=angle)
    )
    air = jo.Spring.between("air", jo.ground.at((0, 1, 0)), ball["origin"], 0.0, damping=drag)
    return jo.Mechanism(ball, wind, air, jo.PositionSensor("at", ball["origin"]))


@pytest.mark.parametrize("lost", [math.sin, float, lambda x: math.sqrt(float(x))])
def test_functions_that_need_real_numbers_make_models_on_both_sides(lost):
    def made(speed, drag):
        return thrown(lost(speed), 0.0, drag)

    given = [P("speed", 0.7), P("drag", 0.1)]
    study = jo.study(made, given, ["last(at.x)", "mass"], t_end=0.2, solver=jo.RK4(1e-2))
    found = jo.design.gradient(study)
    line = made.__code__.co_firstlineno + 1
    why = "complex run: line " + ("" if lost.__name__ == "<lambda>" else f"{line} ")
    assert found.how[0][0].startswith(why) and found.how[0][1] == "complex step"
    assert "test_gradients.py needs real numbers" in found.how[0][0]
    # four models beside that of the point, of which and of the check there are two others; and two
    # each for zeros of the mass and for the small share of the drag
    assert found.exact and found.runs == {"real": 9, "complex": 2, "models": 11}
    # truncation of 4e-12 times the powers of the parameter; round-off of the runs over the step
    noise = 4 * np.finfo(float).eps * abs(found.values[0]) / (1e-3 * study.nominal)
    error = np.abs(found.jacobian - slopes(study))[0]
    assert np.all(error <= 1e-9 * np.abs(found.jacobian[0]) + noise), error


@pytest.mark.parametrize("lost", [abs, lambda x: x.real])
def test_functions_that_lose_derivatives_are_found_out(lost):
    def made(speed):
        return thrown(lost(speed), 0.0, 0.1)

    study = jo.study(made, P("speed", 0.7), "last(at.x)", t_end=0.2, solver=jo.RK4(1e-2))
    found = jo.design.gradient(study)
    assert not found.exact
    assert found.how == (("differences: complex steps and differences disagree",),)
    np.testing.assert_allclose(found.jacobian, slopes(study), rtol=1e-6)


def share(lost):
    """An outcome of 5 to which one parameter adds little, by a function that loses derivatives."""

    def outcome(case):
        return 5.0 + case.values["force"] + 1e-4 * lost(case.values["mass"])

    return jo.design.Function("y", outcome, of="case")


LOSE = {
    "norm": (lambda m: np.linalg.norm([m, 1.0]), lambda m: m / math.hypot(m, 1.0)),
    "abs": (abs, lambda m: 1.0),
    "real": (lambda m: m.real, lambda m: 1.0),
    "less": (lambda m: 1e-2 * abs(m) ** 2, lambda m: 2e-2 * m),
    "part": (lambda m: 1e-3 * m + abs(m), lambda m: 1.001),
    "kink": (lambda m: abs(m.real - 2.0), None),
}


@pytest.mark.parametrize("name", LOSE)
def test_a_derivative_that_is_lost_is_found_out_however_small_it_is_beside_others(name):
    function, slope = LOSE[name]
    found = jo.design.gradient(study_of_push(pushed, share(function)))
    assert found.how[0][1] == "complex step" and found["y", "force"] == 1.0
    assert found.how[0][0].startswith("differences: complex steps lose this derivative")
    # rounding of 5 by a step of 1.2e-5
    if slope is not None:
        assert found["y", "mass"] == pytest.approx(1e-4 * slope(2.0), abs=1e-9)
    else:
        assert "it bends here, slopes -0.0001 and 0.0001" in found.how[0][0]


@pytest.mark.parametrize(
    "flat",
    [
        lambda m: 3.0,
        lambda m: (m - 2.0) ** 2,
        lambda m: (m - 2.0) ** 3,
        lambda m: np.maximum(m, 2.001),
        lambda m: (m + 1e6) - m,
    ],
)
def test_derivatives_that_are_zero_stay_zero(flat):
    found = jo.design.gradient(study_of_push(pushed, share(flat)))
    assert found.exact and abs(found["y", "mass"]) < STEP, str(found)


@pytest.mark.parametrize("jumps", [lambda m: int(m.real), lambda m: np.real(m) > 1.5])
def test_whole_numbers_that_a_parameter_changes_have_no_derivative(jumps):
    def outcome(case):
        return jumps(case.values["mass"])

    found = jo.design.gradient(study_of_push(pushed, jo.design.Function("y", outcome, of="case")))
    assert found.how[0][0].startswith("none: the outcome is a whole number, which jumps to ")
    assert np.isnan(found["y", "mass"]) and found["y", "force"] == 0.0
    counted = jo.design.gradient(study_of_push(pushed, {"rows": lambda run: len(run.time)}))
    assert not np.any(counted["rows"])


def test_stairs_have_no_derivative_between_two_steps():
    found = jo.design.gradient(
        study_of_push(pushed, share(lambda m: math.floor(1000.0 * m.real + 0.5) / 1000.0))
    )
    assert found.how[0][0].startswith("none: it is constant here and jumps to ")
    assert np.isnan(found["y", "mass"]) and found["y", "force"] == 1.0


@pytest.mark.parametrize("part", ["bodies", "kind"])
def test_machines_that_change_their_form_are_differentiated_by_differences(part):
    def made(mass, force):
        items = list(pushed(float(mass), force).items)
        if part == "bodies" and float(mass) > 2.001:  # inside of the four models, not at the point
            items.append(jo.RigidBody("more", 1.0, (1.0, 1.0, 1.0)))
        if part == "kind" and float(mass) > 2.001:
            items.append(jo.CoordinateSensor("y", items[1].displacement))
        return jo.Mechanism(*items)

    found = jo.design.gradient(study_of_push(made))
    assert found.how[0][0].startswith("differences: line ")
    np.testing.assert_allclose(found["last(x)"], [-0.375, 0.25], rtol=1e-6)


def test_what_looks_into_a_mechanism_of_real_numbers_has_differences():
    def weight(mechanism):
        return 9.81 * mechanism.bodies[0].mass

    outcomes = [jo.design.Function("weight", weight, of="mechanism"), "last(x)"]
    study = study_of_push(lambda mass, force: pushed(float(mass), force), outcomes)
    found = jo.design.gradient(study)
    assert found.how[0][0] == "differences: what looks into the mechanism needs its numbers"
    assert found.how[1][0].startswith("complex run: ")
    np.testing.assert_allclose(found["weight"], [9.81, 0.0], rtol=1e-6)


def pushed(mass, force):
    """A block on a slide: x = F t^2 / 2 m, exact in RK4."""
    body = jo.RigidBody("block", mass, (1.0, 1.0, 1.0))
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    push = jo.JointForce("push", slide.displacement, force)
    return jo.Mechanism(body, slide, push, jo.CoordinateSensor("x", slide.displacement))


def study_of_push(function, outcomes="last(x)", bounds=None):
    given = [P("mass", 2.0, bounds=bounds), P("force", 3.0)]
    return jo.study(function, given, outcomes, t_end=1.0, solver=jo.RK4(0.1))


@pytest.mark.parametrize("bend", [lambda f: np.maximum(f, 3.0), lambda f: 3.0 + abs(f - 3.0)])
def test_at_a_kink_the_slopes_of_both_sides_are_said(bend):
    study = study_of_push(lambda mass, force: pushed(mass, bend(force)))
    found = jo.design.gradient(study)
    low, high = [(bend(3.0 + d) - bend(3.0)) / d / 4.0 + 0.0 for d in (-1.0, 1.0)]
    assert found.how[0][1].startswith("differences: complex steps and differences disagree")
    said = found.how[0][1].replace("-0 ", "0 ")
    assert f"it bends here, slopes {low:g} and {high:g}" in said
    np.testing.assert_allclose(found.jacobian, [[-0.375, 0.5 * (low + high)]], atol=1e-6)
    # 0.1 percent beside it nothing is left of it
    beside = jo.design.gradient(study, [2.0, 3.003])
    assert bend(4.0) > bend(3.0) and beside["last(x)", "force"] == pytest.approx(0.25)


def test_a_kink_close_by_does_not_spoil_the_check():
    # 3e-6 away: inside of the first step of the check, outside of the second
    near = 3.0 * (1 + 3e-6)
    study = study_of_push(lambda mass, force: pushed(mass, 10 * np.maximum(force, near) + force))
    found = jo.design.gradient(study)
    assert found.exact and found.runs == {"real": 5, "complex": 2, "models": 6}
    assert found["last(x)", "force"] == pytest.approx(0.25, rel=ROUND_OFF)


def test_whole_numbers_have_no_derivative():
    found = jo.design.gradient(study_of_push(lambda mass, force: pushed(mass, int(force))))
    assert found.how[0][0] == "complex step" and found.how[0][1].startswith("none: line ")
    assert found.how[0][1].endswith("it jumps here") and np.isnan(found.jacobian[0, 1])
    np.testing.assert_allclose(found.jacobian[0, 0], -0.375, rtol=ROUND_OFF)


def test_noisy_outcomes_are_differentiated_with_wide_steps():
    def noisy(mass, force):
        return pushed(mass, float(force) * (1 + 1e-6 * math.sin(1e9 * float(force))))

    found = jo.design.gradient(study_of_push(noisy))
    assert "it is noisy, steps of 0.003" in found.how[0][1]
    # noise of 1e-6 by a step of 1e-3
    np.testing.assert_allclose(found["last(x)", "force"], 0.25, rtol=2e-3)


def test_beyond_a_border_differences_are_taken_on_one_side():
    def light(mass, force):
        if float(mass) > 2.0:
            raise ValueError("too heavy")
        return pushed(mass, force)

    found = jo.design.gradient(study_of_push(light))
    assert "on one side, above it fails: " in found.how[0][0] and "too heavy" in found.how[0][0]
    # of second order, round-off of 1e-10 / 6e-6 allowed
    np.testing.assert_allclose(found["last(x)"], [-0.375, 0.25], rtol=1e-6)


def test_outcomes_that_are_not_finite_have_no_derivative():
    def life(run):
        return np.inf if run["x"].max() < 10.0 else 1.0

    found = jo.design.gradient(study_of_push(pushed, {"life": life, "x": "last(x)"}))
    assert found.how[0] == 2 * ("none: the outcome is inf",) and np.all(np.isnan(found["life"]))
    assert found.how[1] == 2 * ("complex step",)


def test_parameters_without_effect_have_zero_slopes():
    found = jo.design.gradient(study_of_push(lambda mass, force: pushed(mass, 3.0)))
    assert found.exact and found["last(x)", "force"] == 0.0


@pytest.mark.parametrize(
    ("x", "said"),
    [
        ([2.0, np.nan], "must be finite"),
        ([[2.0, 3.0], [2.0, 3.0]], r"has shape \(2, 2\)"),
        (5, r"has shape \(\)"),
        ({"mass": [1.0]}, "mass, force is not an array"),
        ([5.0, 3.0], "mass is 5, outside of 1 to 4"),
    ],
)
def test_points_that_make_no_sense(x, said):
    study = study_of_push(pushed, bounds=(1.0, 4.0))
    with pytest.raises(jo.InputError, match=said):
        jo.design.gradient(study, x)
    with pytest.raises(jo.InputError, match="outcomes is empty"):
        jo.design.gradient(study, outcomes=())


def test_what_takes_decisions_is_differentiated_by_differences():
    def study(of=thrown, **run):
        given = [P("speed", 0.7), P("angle", 0.3), P("drag", 0.1)]
        return jo.study(of, given, "last(at.x)", t_end=0.2, **run)

    adaptive = study(solver=jo.simulation.DormandPrince())
    found = jo.design.gradient(adaptive, check=False)
    assert found.how[0][0] == "differences: DormandPrince chooses its steps"
    np.testing.assert_allclose(found.jacobian, slopes(adaptive), rtol=1e-5)

    def watched(speed, angle, drag):
        made = thrown(speed, angle, drag)
        far = jo.mechanism.Event("far", made.sensors[0], 0.05, component="x")
        push = jo.Force(
            "push", made.bodies[0]["origin"], (1, 0, 0), signal=jo.mechanism.Switched(far, 0.0, 1.0)
        )
        return jo.Mechanism(*made.items, far, push)

    events = study(watched, solver=jo.RK4(1e-2))
    found = jo.design.gradient(events)
    assert found.how[0] == 3 * ("differences: events",)
    np.testing.assert_allclose(found.jacobian, slopes(events), rtol=1e-5)


def test_result_has_names_and_says_how():
    study = jo.study(
        thrown,
        [P("speed", 0.7), P("angle", 0.3), P("drag", 0.1)],
        {"x": "last(at.x)", "m": "mass"},
        t_end=0.2,
        solver=jo.RK4(1e-2),
    )
    found = jo.design.gradient(study, outcomes="x")
    assert found.outcomes == ("x",) and found["x"].shape == (3,)
    assert found["x", "speed"] == found.jacobian[0, 0]
    assert "3 of 3 derivatives by complex steps" in str(found)
    # two of the check, and two for one of them whose share is small
    assert found.runs == {"real": 5, "complex": 3, "models": 7}
    with pytest.raises(KeyError, match="no outcome 'y'"):
        found["y"]
    with pytest.raises(jo.InputError, match="no outcome 'z'"):
        jo.design.gradient(study, outcomes="z")


def test_page_has_the_words():
    page = (Path(__file__).parents[3] / "docs/gradients.md").read_text()
    for word, meaning in WAYS.items():
        assert f"| `{word}` | {meaning} |" in page


def test_functions_of_runs_that_need_real_numbers_are_followed_along_the_motion():
    def largest(run):
        return float(max(map(float, np.ravel(run["x"]))))

    found = jo.design.gradient(study_of_push(pushed, largest))
    assert found.how == (2 * ("complex motion",),) and WAYS["complex motion"] in str(found)
    np.testing.assert_allclose(found.jacobian, [[-0.375, 0.25]], rtol=ROUND_OFF)


def test_inputs_have_gradients():
    def made():
        body = jo.RigidBody("block", 2.0, (1.0, 1.0, 1.0))
        slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
        push = jo.JointForce("push", slide.displacement, jo.Input("force"))
        return jo.Mechanism(body, slide, push, jo.CoordinateSensor("x", slide.displacement))

    study = jo.study(made(), P("force", 3.0), "last(x)", t_end=1.0, solver=jo.RK4(1e-2))
    found = jo.design.gradient(study)  # x = F t^2 / 2 m, exact in RK4
    np.testing.assert_allclose(found.jacobian, [[0.25]], rtol=ROUND_OFF)
    assert found.exact


def test_limit_states_take_gradients():
    # x = F t^2 / 2 m <= 1.5 m at 1 s: 3 m - F >= 0, a plane
    def made(mass):
        body = jo.RigidBody("block", mass, (1.0, 1.0, 1.0))
        slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
        push = jo.JointForce("push", slide.displacement, jo.Input("force"))
        return jo.Mechanism(body, slide, push, jo.CoordinateSensor("x", slide.displacement))

    mass = P("mass", 2.0, bounds=(1.9, 2.1), distribution="normal(sd=0.2)")
    force = P("force", 4.0, distribution="normal(sd=0.4)")
    study = jo.study(made, [mass, force], "last(x)", t_end=1.0, solver=jo.RK4(0.1))
    limit = jo.design.limit_state(study, "last(x) <= 1.5", gradient=True)
    found = jo.design.form(limit)
    np.testing.assert_allclose(found.beta, 2.0 / np.hypot(3 * 0.2, 0.4), rtol=1e-6)


def test_complex_numbers_are_taken_nowhere_else():
    with pytest.raises(jo.InputError, match="mass"):
        jo.RigidBody("ball", 1.0 + 1e-30j, (1e-3, 1e-3, 1e-3))
    with pytest.raises(jo.InputError, match="center"):
        jo.RigidBody("ball", 1.0, (1e-3, 1e-3, 1e-3), center=(1.0 + 0j, 0, 0))
    with stepping():
        ball = jo.RigidBody("ball", np.complex128(1.0 + 1j * STEP), (1e-3, 1e-3, 1e-3))
    assert ball.mass.imag == STEP
    # what is made inside does not stay as a default of what is made outside
    assert jo.RigidBody("ball", 1.0, (1e-3, 1e-3, 1e-3)).center.dtype == np.float64


def hanging(mass, stiffness):
    body = jo.RigidBody("weight", mass, (1.0, 1.0, 1.0))
    guide = jo.Prismatic("guide", jo.ground["origin"], body["origin"], axis=(0, 1, 0))
    spring = jo.Spring("hanger", guide.displacement, stiffness)
    place = jo.CoordinateSensor("place", guide.displacement)
    return jo.Mechanism(body, guide, spring, place, jo.Gravity((0, -G, 0)), start="rest")


def test_the_start_at_rest_that_a_mechanism_asks_for_moves_with_the_parameters():
    study = jo.study(hanging, [P("mass", 2.0), P("stiffness", 500.0)], "min(place)", t_end=0.1)
    found = jo.design.gradient(study)
    sag = -2.0 * G / 500.0
    assert found.exact  # of the values alone, complex steps and differences disagreed
    np.testing.assert_allclose(found.values, [sag], rtol=1e-9)
    np.testing.assert_allclose(found.jacobian[0], [sag / 2.0, -sag / 500.0], rtol=1e-6)


def test_runs_of_a_study_iterate_to_a_fixed_tolerance() -> None:
    """Differences between runs see the end of Newton's iteration, which auto leaves open."""
    body = jo.RigidBody("bar", 2.0, (0.1, 0.2, 0.2), center=(0.5, 0, 0))
    pin = jo.Revolute("pin", jo.ground["origin"], body["origin"], axis=(0, 1, 0))
    model = jo.compile(jo.Mechanism(body, pin, jo.Gravity((0, 0, -9.81))))
    for given, wanted in (("auto", 1e-10), (1e-8, 1e-8), (None, None)):
        solver = jo.GeneralizedAlpha(1e-3, tolerance=given)
        machine = Machine(model, Settings(0.1, {"solver": solver}), (), {})
        assert machine.repeated.how["solver"].tolerance == wanted
