"""Generalised alpha and Newmark: convergence of Newton, order, damping, constraints, stiffness."""

from __future__ import annotations

import warnings
from functools import cache

import numpy as np
import pytest

import jousto as jo
from jousto.simulation.solvers.implicit import spectral_radius
from verification import iftomm
from verification.mechanisms import STEEL, G, chain, march, orders
from verification.test_iftomm import corner_at, end_of, upright_at

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")

SOFT = jo.Material(E=1.1e9, nu=0.3, rho=7850.0)


def native(engine, solver):
    return engine.native_solver(solver.method, solver.step, solver.projection, **solver.options)


@cache
def soft_rod():
    """A beam with modes of 23 to 106 Hz, which steps of 1 ms resolve."""
    part = jo.Part.beam(1.0, jo.Rectangle(0.1, 0.06), 4, SOFT, theory=jo.parts.EulerBernoulli())
    return jo.reduce(part, jo.FreeFree(modes=4))


@cache
def pendulum():
    body = jo.RigidBody(
        "bar", 2.0, (0.15, 0.2, 0.3), center=(0.5, 0, 0), angular_velocity=(0.5, 1.0, -2.0)
    )
    return jo.compile(
        jo.Mechanism(
            body, jo.Spherical("pivot", jo.ground["origin"], body["origin"]), jo.Gravity(G)
        )
    )


@cache
def double_pendulum():
    """Two flexible beams on a spherical and an oblique revolute joint."""
    w = np.array([0.5, 1.0, -3.0])
    a = jo.FlexibleBody("upper", soft_rod(), angular_velocity=w)
    b = jo.FlexibleBody(
        "lower", soft_rod(), position=(1, 0, 0), velocity=np.cross(w, [1, 0, 0]), angular_velocity=w
    )
    return jo.compile(
        jo.Mechanism(
            a,
            b,
            jo.Spherical("pivot", jo.ground["origin"], a["start"]),
            jo.Revolute("hinge", a["end"], b["start"], axis=(1.0, 0.3, 1.0)),
            jo.Gravity(G),
        )
    )


@cache
def slider_crank():
    """A driven crank, a flexible rod and a slider on a spring with a damper."""
    crank = jo.RigidBody("crank", 1.0, (0.01, 0.02, 0.02), center=(0.1, 0, 0))
    rod = jo.FlexibleBody("rod", soft_rod(), position=(0.2, 0, 0))
    slider = jo.RigidBody("slider", 3.0, (0.02, 0.02, 0.02), position=(1.2, 0, 0))
    bearing = jo.Revolute("bearing", jo.ground["origin"], crank["origin"])
    guide = jo.Prismatic("guide", jo.ground["origin"], slider["origin"], axis=(1, 0, 0))
    motion = jo.Harmonic(frequency=1.0, amplitude=1.0, offset=0.4)
    return jo.compile(
        jo.Mechanism(
            crank,
            rod,
            slider,
            bearing,
            jo.Universal("pin", crank.at((0.2, 0, 0)), rod["start"], (0, 0, 1), (0, 1, 0)),
            jo.Spherical("wrist", rod["end"], slider["origin"]),
            guide,
            jo.Drive("motor", bearing.angle, motion),
            jo.Spring("spring", guide.displacement, stiffness=400.0, damping=20.0),
            jo.Gravity(G),
        )
    )


MODELS = {"pendulum": pendulum, "double pendulum": double_pendulum, "slider-crank": slider_crank}


@pytest.mark.parametrize("name", MODELS)
def test_newton_converges_quadratically(name):
    """``e_(k+1) <= C e_k^2`` with one C, down to round-off."""
    model = MODELS[name]()
    states = []
    for iterations in (1, 2, 3, 4, 8):
        engine = jo.model.Engine(model)
        step = 0.2 if name == "pendulum" else 0.02  # hard ones
        solver = jo.GeneralizedAlpha(
            step=step, tangent="exact", tolerance=None, max_iterations=iterations
        )
        engine.v += 0.5 * np.cos(np.arange(model.nv))
        engine.assemble()
        engine.step(native(engine, solver))
        assert engine.counts.iterations == engine.counts.factorisations == iterations
        states.append(np.concatenate([engine.a, engine.lam]))
    size = float(np.abs(states[-1]).max())
    errors = [float(np.abs(s - states[-1]).max()) / size for s in states[:-1]]
    print(name, errors)
    pairs = list(zip(errors[:-1], errors[1:], strict=True))
    ratios = [after / before**2 for before, after in pairs if after > 1e-13]
    assert errors[0] > 1e-4
    assert errors[1] > 1e-13  # something is left after one iteration
    assert errors[3] < 1e-13  # and nothing after four
    assert max(ratios) < 10.0


@pytest.mark.parametrize("projection", [True, False], ids=["index 2", "index 3"])
@pytest.mark.parametrize("name", MODELS)
def test_order_of_positions_velocities_and_multipliers(name, projection):
    model = MODELS[name]()
    steps = (5e-4, 2.5e-4, 1.25e-4)
    exact = march(model, jo.RK4(step=1e-4), 0.1)
    runs = [march(model, jo.GeneralizedAlpha(step=h, projection=projection), 0.1) for h in steps]
    for part in ("q", "v", "lam"):
        wanted = getattr(exact, part)[-1]
        errors = [float(np.abs(getattr(run, part)[-1] - wanted).max()) for run in runs]
        np.testing.assert_allclose(orders(errors), 2.0, atol=0.15, err_msg=part)
    balance = [abs(float(run.balance[-1])) for run in runs]
    np.testing.assert_allclose(orders(balance), 2.0, atol=0.25)


@pytest.mark.parametrize("tangent", ["exact", "modified"])
def test_both_tangents_and_newmark_go_to_the_same_motion(tangent):
    model = slider_crank()
    exact = march(model, jo.RK4(step=1e-4), 0.1)
    for solver in (
        jo.GeneralizedAlpha(step=1e-4, rho=0.3, tangent=tangent),
        jo.GeneralizedAlpha(step=1e-4, rho=1.0, tangent=tangent),
        jo.simulation.Newmark(step=1e-4, tangent=tangent),
    ):
        run = march(model, solver, 0.1)
        np.testing.assert_allclose(run.q[-1], exact.q[-1], atol=1e-4)
        np.testing.assert_allclose(run.v[-1], exact.v[-1], atol=2e-2)


def oscillator(frequency):
    """A rigid body on a linear spring along x."""
    body = jo.RigidBody("mass", 2.0, (0.1, 0.1, 0.1), position=(0.5, 0, 0))
    guide = jo.Prismatic("guide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    stiffness = 2.0 * (2.0 * np.pi * frequency) ** 2
    spring = jo.Spring("spring", guide.displacement, stiffness=stiffness, free=0.4)
    return jo.compile(jo.Mechanism(body, guide, spring))


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8, 1.0])
def test_fast_oscillations_are_damped_by_rho(rho):
    """rho is the spectral radius where the step is infinitely long for the oscillation."""
    solver = jo.GeneralizedAlpha(step=1e-3, rho=rho)
    far = spectral_radius(solver, np.array([1e7j]))
    # a double or triple eigenvalue -rho: round-off splits it by its root
    np.testing.assert_allclose(far, rho, atol=1e-4 if rho else 2e-2)
    if rho == 0.0:
        return
    run = march(oscillator(1e6), solver, 0.03, 0.001)  # 6283 rad in a step
    x = run.q[:, 0] - 0.4  # from the unloaded spring

    def left(root):
        """Return what a triple root -root leaves of the recurrence of x."""
        terms = x[3:] + 3 * root * x[2:-1] + 3 * root**2 * x[1:-2] + root**3 * x[:-3]
        return np.abs(terms).max() / np.abs(x).max()

    assert left(rho) < 1e-6
    assert left(0.9 * rho) > 1e-4


@pytest.mark.parametrize(
    ("solver", "wanted"),
    [(jo.simulation.Newmark(step=1e-2), 1e-9), (jo.GeneralizedAlpha(step=1e-2, rho=1.0), 1e-2)],
    ids=["Newmark", "alpha"],
)
def test_energy_of_a_linear_oscillator(solver, wanted):
    """The trapezoidal rule keeps it exactly, whatever the step; rho = 1 keeps it bounded."""
    run = march(oscillator(7.0), solver, 20.0, 0.01)
    total = run.energy[:, 0] + run.energy[:, 3]
    assert total[0] > 10.0
    assert np.abs(total / total[0] - 1.0).max() < wanted


def test_constraints_after_ten_thousand_steps():
    model = double_pendulum()
    run = march(model, jo.GeneralizedAlpha(step=1e-3, rho=0.9), 10.0, 0.01)
    assert run.residuals[:, 0].max() < 1e-10
    assert run.residuals[:, 1].max() < 1e-9


def test_numerical_damping_only_takes_energy():
    run = march(jo.compile(chain("revolute", material=STEEL)), jo.GeneralizedAlpha(2e-3), 0.4, 2e-3)
    balance = run.balance / run.energy[0, 0]
    assert balance.max() < 1e-3
    assert balance.min() > -0.2


def bushed(stiffness, damping=0.0):
    """A pendulum on a bushing instead of a joint."""
    body = jo.RigidBody("bar", 2.0, (0.05, 0.2, 0.2), center=(0.5, 0, 0))
    bush = jo.Bushing(
        "bush",
        jo.ground["origin"],
        body["origin"],
        stiffness=(stiffness, stiffness, stiffness, 0.0, 0.0, 0.0),
        damping=(damping, damping, damping, 0.0, 0.0, 0.0),
    )
    return jo.compile(jo.Mechanism(body, bush, jo.Gravity(G)))


def test_a_very_stiff_bushing_is_a_spherical_joint():
    """1e10 N/m: a period of 60 us, steps of 1 ms, which explicit methods do not survive."""
    body = jo.RigidBody("bar", 2.0, (0.05, 0.2, 0.2), center=(0.5, 0, 0))
    joint = jo.Spherical("pivot", jo.ground["origin"], body["origin"])
    rigid = jo.compile(jo.Mechanism(body, joint, jo.Gravity(G)))
    wanted = march(rigid, jo.RK4(step=1e-3), 0.5)
    found = march(bushed(1e10), jo.GeneralizedAlpha(step=1e-3), 0.5)
    np.testing.assert_allclose(found.q[-1], wanted.q[-1], atol=2e-5)
    np.testing.assert_allclose(found.v[-1], wanted.v[-1], atol=2e-4)
    with pytest.raises(AssertionError, match="the engine stopped"):
        march(bushed(1e10), jo.ROS2(step=1e-3), 0.5)


def test_loops_through_singular_positions_and_with_repeated_rows():
    """Published loops: IFToMM A02 passes its singular position, A04 has a row too many."""
    ladder, bricard = jo.compile(iftomm.four_bars(2)), jo.compile(iftomm.bricard())
    assert bricard.redundant
    turned, corner = upright_at(1.0), corner_at(np.array([0.0, 1.0]))[-1]
    for projection in (True, False):
        far: dict[str, list[float]] = {"ladder": [], "bricard": []}
        for steps in (250, 500):
            solver = jo.GeneralizedAlpha(step=1.0 / steps, projection=projection)
            run = march(ladder, solver, 1.0)
            far["ladder"].append(float(np.abs(end_of(run) - turned).max()))
            run = march(bricard, solver, 1.0)
            far["bricard"].append(float(np.abs(run.sensors["P3"][-1] - corner).max()))
            assert run.residuals[-1, 0] < 1e-12 * bricard.size
        for name, errors in far.items():
            assert orders(errors)[0] == pytest.approx(2.0, abs=0.2), (name, errors)


def test_a_stiff_governor_at_a_hundred_times_the_explicit_step():
    """IFToMM A05: the dampers of its rods are as fast as 2e4 1/s."""
    model = jo.compile(iftomm.governor())
    exact = march(model, jo.RK4(step=5e-5), 0.2)
    errors = []
    for step in (1e-2, 5e-3, 2.5e-3):
        run = march(model, jo.GeneralizedAlpha(step=step), 0.2)
        errors.append(float(np.abs(run.sensors["s"][-1] - exact.sensors["s"][-1]).max()))
    assert errors[-1] < 2e-5
    np.testing.assert_allclose(orders(errors), 2.0, atol=0.5)


def test_events_are_found_between_steps():
    """A falling body reaches 0.5 m when the closed form says, and the run goes on from there."""
    body = jo.RigidBody("ball", 1.0, (1e-3,) * 3, position=(0, 2.0, 0))
    place = jo.PositionSensor("place", body["origin"])
    floor = jo.mechanism.Event("floor", place, 0.5, "falling", component="y")
    model = jo.compile(jo.Mechanism(body, place, floor, jo.Gravity(G)))
    engine = jo.model.Engine(model)
    solver = native(engine, jo.GeneralizedAlpha(step=0.1))
    engine.run(solver, 8, 8, np.zeros((2, engine.row_size)))
    ((time, *_),) = engine.happenings()
    assert time == pytest.approx(np.sqrt(3.0 / 9.81), abs=1e-11)
    assert engine.q[1] == pytest.approx(2.0 - 0.5 * 9.81 * 0.8**2, abs=1e-11)


def test_derivatives_of_a_run_by_complex_steps():
    """An imaginary step in gravity passes Newton's iteration: against differences of order 4."""
    model, up = slider_crank(), np.array([0.3, 1.0, 0.2])

    def end(change, tolerance=1e-13):
        engine = jo.model.Engine(
            model,
            complex_scalars=isinstance(change, complex),
            override={("model", 0, "gravity"): model.gravity + change * up},
        )
        # kept factors close the joints with those of an older state, a little elsewhere
        method = jo.GeneralizedAlpha(step=2e-3, tolerance=tolerance, tangent="exact")
        solver = native(engine, method)
        engine.run(solver, 25, 25, np.zeros((2, engine.row_size), engine.dtype))
        return np.concatenate([engine.q, engine.v])

    d = 0.02
    exact = end(1e-30j, 1e-2).imag / 1e-30
    near, far = end(d) - end(-d), end(2 * d) - end(-2 * d)
    difference = (8 * near - far) / (12 * d)
    assert np.abs(exact).max() > 1e-3
    np.testing.assert_allclose(exact, difference, rtol=0, atol=1e-8 * np.abs(exact).max())


@pytest.mark.parametrize("name", MODELS)
def test_multipliers_are_right_from_the_start(name):
    """After three steps, at the order of the method; index 3 would begin with an error of order 1.

    Arnold, Bruels and Cardona, Numer. Math. 129 (2015).
    """
    model, errors = MODELS[name](), []
    for step in (1e-3, 2.5e-4):
        run = march(model, jo.GeneralizedAlpha(step=step), 3 * step)
        exact = march(model, jo.RK4(step=step / 8), 3 * step)
        errors.append(float(np.abs(run.lam[-1] - exact.lam[-1]).max()))
    assert 0.5 * orders(errors)[0] > 1.8  # the steps are in the ratio 4


def test_free_fall_and_rest_have_no_scale_of_their_own():
    """No acceleration but gravity, or none at all: the iteration still ends."""
    for gravity in (G, 0.0 * G):
        body = jo.RigidBody("body", 2.0, (0.1, 0.2, 0.25))
        model = jo.compile(jo.Mechanism(body, jo.Gravity(gravity)))
        run = march(model, jo.GeneralizedAlpha(step=1e-2), 1.0)
        np.testing.assert_allclose(run.q[-1, :3], 0.5 * gravity, atol=1e-12)


def test_friction_that_explicit_methods_cannot_bear_raises_no_warning():
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        run = jo.simulate(
            hinged(jo.mechanism.Regularised(1e-4)), 0.1, solver=jo.GeneralizedAlpha(step=1e-3)
        )
    assert not said
    assert run.energy.friction[-1] > 0.0


def hinged(law):
    """A bar that falls from the horizontal on a hinge that rubs."""
    body = jo.RigidBody("bar", 2.0, (0.05, 0.2, 0.2), center=(0.5, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    rub = jo.Friction("rub", hinge, 0.3, 0.4, radius=0.1, law=law)
    return jo.compile(
        jo.Mechanism(body, hinge, rub, jo.Gravity(G), jo.CoordinateSensor("angle", hinge.angle))
    )


def test_friction_that_is_steep_at_rest():
    """Exact derivatives of the friction, the multipliers included: few iterations at any step."""
    wanted = march(hinged(jo.mechanism.Regularised(1e-3)), jo.RK4(step=2e-4), 3.0)
    for step, miss in ((2e-2, 6e-3), (5e-3, 6e-4)):
        solver = jo.GeneralizedAlpha(step=step, max_iterations=7)
        run = march(hinged(jo.mechanism.Regularised(1e-3)), solver, 3.0, 0.1)
        np.testing.assert_allclose(run.sensors["angle"][-1], wanted.sensors["angle"][-1], atol=miss)
        assert run.energy[-1, 5] == pytest.approx(wanted.energy[-1, 5], rel=2e-3)
        assert (np.diff(run.energy[:, 5]) > -1e-12).all()  # friction never adds energy
        assert np.abs(run.balance).max() < 0.02 * run.energy[-1, 5]


def counted(tangent):
    """Iterations and factorisations of 100 steps, having seen that each step counts."""
    model = double_pendulum()
    engine = jo.model.Engine(model)
    solver = jo.GeneralizedAlpha(step=1e-3, tangent=tangent)
    rows = np.zeros((100, engine.row_size))
    assert engine.run(native(engine, solver), 100, 1, rows) == ("ok", 100)
    iterations = rows[:, 1 + model.nq + model.nv + model.nrow + 10]
    assert iterations[-1] == engine.counts.iterations
    assert (np.diff(iterations) >= 1).all()
    return engine.counts.iterations, engine.counts.factorisations


def test_the_exact_tangent_factorises_in_every_iteration():
    iterations, factorisations = counted("exact")
    assert factorisations == iterations <= 300


def test_the_modified_tangent_keeps_its_factors():
    # the bodies turn by 0.3 to 0.4 rad, joints are closed with factors of at most 0.01 rad ago
    assert counted("modified")[1] < 40


def test_results_do_not_depend_on_how_the_run_is_cut():
    model = slider_crank()
    states = []
    for pieces in ((40,), (1, 7, 32)):
        engine = jo.model.Engine(model)
        solver = native(engine, jo.GeneralizedAlpha(step=1e-3))
        for count in pieces:
            engine.run(solver, count, count, np.zeros((1 + count, engine.row_size)))
        states.append(np.concatenate([engine.q, engine.v]))
    np.testing.assert_allclose(states[0], states[1], rtol=0, atol=1e-13)


def test_a_step_that_does_not_converge_says_what_to_do():
    model = bushed(1e10)
    solver = jo.GeneralizedAlpha(step=1.0, max_iterations=1)  # it turns by more than a radian
    with pytest.raises(
        jo.simulation.RunFailed, match="at this body; take a smaller step.*try 0.5 s"
    ):
        jo.simulate(model, 1.0, solver=solver)
    engine = jo.model.Engine(model)
    before = np.concatenate([engine.q, engine.v])
    with pytest.raises(jo.SimulationError, match="body 'bar': Newton's iteration did not converge"):
        engine.step(native(engine, solver))
    np.testing.assert_array_equal(np.concatenate([engine.q, engine.v]), before)
    assert engine.time[0] == 0.0


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: jo.GeneralizedAlpha(step=-1.0), "step is -1.0, must be a positive number"),
        (lambda: jo.GeneralizedAlpha(rho=1.2), "rho is 1.2, must be between 0"),
        (
            lambda: jo.GeneralizedAlpha(tolerance=0.5),
            "tolerance is 0.5, must be 'auto', between 1e-14",
        ),
        (lambda: jo.GeneralizedAlpha(max_iterations=0), "max_iterations is 0, must be a whole"),
        (
            lambda: jo.simulation.Newmark(tangent="old"),
            "tangent is 'old', must be 'exact' or 'modified'",
        ),
        (lambda: jo.simulation.Newmark(beta=0.0), "beta is 0.0, must be between 0 and 1 and not 0"),
        (lambda: jo.simulation.Newmark(gamma=0.3), "gamma is 0.3, must be between 0.5 and 1"),
        (lambda: jo.simulation.Newmark(projection=1), "projection is 1, must be True or False"),
    ],
)
def test_bad_options(make, sentence):
    with pytest.raises(jo.InputError, match=sentence):
        make()
