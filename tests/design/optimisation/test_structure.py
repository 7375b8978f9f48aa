"""Equivalent static loads against a small problem whose optimum is known.

Two masses in a chain, ``k_i = 10 b_i``, pushed by half a sine of 2 s; least ``b1 + b2`` with the
last mass within 0.25 m. By a transient of its own (below) and by SLSQP from eight starts the
optimum is 2.57964 at (1.24086, 1.33879); classical equivalent loads end at 2.64849.
"""

import numpy as np
import pytest
import scipy.linalg as sl
from scipy.integrate import solve_ivp

import jousto as jo
from jousto.design import DisplacementLimit, FrequencyLimit, StructureProblem, optimise
from jousto.design.optimisation import loads as esl

TIME = np.linspace(0.0, 8.0, 2001)


def matrices(v):
    k1, k2 = 10.0 * v["b1"], 10.0 * v["b2"]
    masses = np.diag([1.0 + 0.15 * (v["b1"] + v["b2"]), 1.0 + 0.15 * v["b2"]])
    return masses, np.array([[k1 + k2, -k2], [-k2, k2]])


def push(t):
    return np.stack([np.zeros_like(t), np.where(t < 2.0, np.sin(np.pi * t / 2.0), 0.0)])


def chain(start=(2.0, 2.0), limits=None, **options):
    parameters = [
        jo.Parameter(name, value, bounds=(0.2, 20.0))
        for name, value in zip(("b1", "b2"), start, strict=True)
    ]
    limits = [DisplacementLimit("structure", 0.25, "2")] if limits is None else limits
    return StructureProblem(
        parameters, matrices, push, TIME, lambda v: v["b1"] + v["b2"], limits, **options
    )


def test_the_motion_is_that_of_the_differential_equation():
    problem = chain(damping=0.05)
    x = np.array([1.3, 0.7])
    motion = problem.motions(x)[0]
    z = motion.shapes @ motion.coordinates

    M, K = matrices(problem.values(x))
    w2, Phi = sl.eigh(K, M)
    D = M @ Phi @ np.diag(2 * 0.05 * np.sqrt(w2)) @ Phi.T @ M

    def slope(t, y):
        return np.concatenate(
            [y[2:], np.linalg.solve(M, push(np.array([t]))[:, 0] - K @ y[:2] - D @ y[2:])]
        )

    y, parts = np.zeros(4), []
    for first, last in ((0.0, 2.0), (2.0, 8.0)):  # the force has a corner at 2 s
        inside = TIME[(TIME >= first) & (TIME <= last)]
        run = solve_ivp(slope, (first, last), y, "DOP853", inside, rtol=1e-12, atol=1e-13)
        y = run.y[:, -1]
        parts.append(run.y[:2, : -1 if last == 2.0 else None])
    assert z == pytest.approx(np.hstack(parts), abs=1e-10)


def test_equivalent_loads_deform_the_structure_as_its_motion_does():
    problem = chain()
    x = np.array([0.9, 1.7])
    (motion,), (body,) = problem.motions(x), problem.bodies(x)
    (load,) = esl.classical(x, (body,), (motion,))
    z = motion.shapes @ motion.coordinates
    K = matrices(problem.values(x))[1]
    f = load.columns @ load.coordinates(x, np.arange(len(TIME)))
    assert f == pytest.approx(K @ z, abs=1e-12 * np.abs(f).max())
    assert body.solve(f) == pytest.approx(z, abs=1e-10 * np.abs(z).max())


def test_loads_of_first_order_have_the_slopes_of_the_motion():
    problem = chain()
    x = np.array([1.2, 1.4])
    (load,) = esl.first_order(problem, x, 1e-5)
    every = np.arange(len(TIME))
    near = x + np.array([1e-3, -2e-3])

    def f(design):
        (motion,), (body,) = problem.motions(design), problem.bodies(design)
        return body.K @ motion.shapes @ motion.coordinates

    exact, linear = f(near), load.columns @ load.coordinates(near, every)
    constant = load.columns @ load.coordinates(x, every)
    # what is left falls with the square of the step
    further = x + np.array([1e-4, -2e-4])
    small = np.abs(f(further) - load.columns @ load.coordinates(further, every)).max()
    assert np.abs(exact - constant).max() > 20 * np.abs(exact - linear).max()
    assert np.abs(exact - linear).max() / small == pytest.approx(100, rel=0.05)


@pytest.mark.parametrize("start", [(2.0, 2.0), (1.0, 1.0)])
def test_first_order_meets_the_optimum(start):
    found = optimise(chain(start), order=1, tolerance=1e-7)
    assert found.converged
    assert found.cost == pytest.approx(2.579634, rel=1e-5)
    assert list(found.values.values()) == pytest.approx([1.240856, 1.338778], rel=2e-5)
    assert found.ratio == pytest.approx(1.0, abs=1e-5)
    assert found.kkt < 1e-4
    assert {str(place).partition(" at ")[0] for place, _ in found.active} == {
        "displacement of structure.2, 2"
    }


def test_the_classical_method_ends_elsewhere():
    found = optimise(chain(), order=0, tolerance=1e-7)
    assert found.converged
    assert found.cost == pytest.approx(2.648471, rel=2e-5)
    assert list(found.values.values()) == pytest.approx([1.473894, 1.174577], rel=5e-5)
    assert found.kkt > 0.1  # no optimum of the moving structure


def test_the_direct_method_meets_the_optimum():
    found = optimise(chain((1.0, 1.0)), "direct", tolerance=1e-7)
    assert found.cost == pytest.approx(2.579634, rel=1e-5)
    assert found.kkt < 1e-6


def test_a_frequency_bounds_the_design():
    limits = [DisplacementLimit("structure", 10.0, "2"), FrequencyLimit(0.4)]
    found = optimise(chain(limits=limits), tolerance=1e-7)
    M, K = matrices(found.values)
    assert np.sqrt(sl.eigh(K, M)[0][0]) / (2 * np.pi) == pytest.approx(0.4, rel=1e-6)
    # Lagrange: at the least sum of stiffness both slopes of the frequency are equal
    b = np.array(list(found.values.values()))

    def frequency(c):
        return sl.eigh(*matrices(dict(zip(("b1", "b2"), c, strict=True)))[::-1])[0][0]

    h = 1e-5
    slopes = [(frequency(b + h * e) - frequency(b - h * e)) / (2 * h) for e in np.eye(2)]
    assert slopes[0] == pytest.approx(slopes[1], rel=1e-2)


def test_everything_wrong_is_reported_at_once():
    with pytest.raises(jo.InputError) as caught:
        StructureProblem(
            [jo.Parameter("b1", 1.0), jo.Parameter("b1", 15.0, bounds=(10.0, 20.0))],
            matrices,
            push,
            TIME,
            lambda v: 1.0,
            [],
        )
    text = str(caught.value)
    assert "'b1' is given twice" in text
    assert "needs two finite bounds" in text
    assert "no limits" in text


def test_limits_name_bodies_that_exist():
    with pytest.raises(jo.InputError, match="no flexible body 'boom'"):
        optimise(chain(limits=[DisplacementLimit("boom", 0.1, "2")]))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"order": 2}, "order is 2"),
        ({"method": "sqp"}, "method is 'sqp'"),
        ({"tolerance": -1.0}, "tolerance"),
        ({"screen": 2.0}, "screen"),
        ({"trust": 0.0}, "trust"),
        ({"cycles": 0}, "cycles"),
    ],
)
def test_impossible_options(options, message):
    with pytest.raises(jo.InputError, match=message):
        optimise(chain(), **options)


def test_no_design_keeps_the_limits():
    # within the bounds the structure is too soft: the report says that a limit is exceeded
    found = optimise(chain(limits=[DisplacementLimit("structure", 1e-3, "2")]), cycles=6)
    assert found.ratio > 1.0
    assert "a limit is exceeded" in found.message


@pytest.mark.parametrize("turns", [0.5, 10.0, 40.0, 3000.0])  # of a mode between two instants
def test_a_constant_force_is_exact_however_coarse_the_instants(turns):
    time = np.linspace(0.0, 2.0, 5)
    w = turns / time[1]
    one = StructureProblem(
        [jo.Parameter("k", w**2, bounds=(0.5 * w**2, 2 * w**2))],
        lambda v: (np.eye(1), np.array([[v["k"]]])),
        lambda t: np.ones((1, len(t))),
        time,
        lambda v: v["k"],
        [DisplacementLimit("structure", 1.0, "1")],
    )
    (motion,) = one.motions(one.start)
    # in units of the static deflection; the phase w t loses digits as it grows
    assert (motion.shapes @ motion.coordinates)[0] * w**2 == pytest.approx(
        1 - np.cos(w * time), abs=1e-13 * (10 + turns)
    )


def test_a_motion_that_is_no_number_is_no_optimum():
    def broken(v):
        return np.eye(2), np.diag([v["b1"], np.nan if v["b2"] < 1.9 else v["b2"]])

    def lost(x):
        motion = StructureProblem.run(problem, x)[0]
        motion.coordinates[:, 1000:] = np.nan
        return (motion,)

    problem = chain()
    problem.run = lost
    for method in ("esl", "direct"):
        with pytest.raises(jo.InputError, match="displacement of structure.2: has values"):
            optimise(problem, method)
    with pytest.raises(jo.InputError, match="force must return finite numbers"):
        StructureProblem(
            [jo.Parameter("b1", 1.0, bounds=(0.2, 20.0))],
            broken,
            lambda t: np.stack([t, np.where(t > 1.0, np.nan, 1.0)]),
            TIME,
            lambda v: 1.0,
            [DisplacementLimit("structure", 0.25, "2")],
        )


def test_functions_are_asked_within_the_bounds_only():
    asked = []

    def rooted(v):
        asked.append(v["k"])
        return np.eye(1), np.array([[5.0 + np.sqrt(v["k"])]])  # no number below 0

    def spring():
        return StructureProblem(
            [jo.Parameter("k", 1.0, bounds=(0.0, 2.0))],
            rooted,
            lambda t: np.ones((1, len(t))),
            np.linspace(0.0, 5.0, 101),
            lambda v: v["k"],
            [DisplacementLimit("structure", 1.0, "1")],
        )

    for options in ({"order": 0}, {"order": 1}, {"method": "direct"}):
        found = optimise(spring(), **options)
        assert found.values["k"] == pytest.approx(0.0, abs=1e-6)  # the limit is never reached
    assert min(asked) >= 0.0
    assert max(asked) <= 2.0


def test_instants_that_change_with_the_design():
    problem = chain()
    runs = []

    def shorter(x):
        (motion,) = StructureProblem.run(problem, x)
        runs.append(x)
        motion = type(motion)(
            0, "", motion.time[: -len(runs)], motion.shapes, motion.coordinates[:, : -len(runs)]
        )
        return (motion,)

    problem.run = shorter
    for method in ("esl", "direct"):
        with pytest.raises(jo.InputError, match="the number of instants changes"):
            optimise(problem, method)
