"""What an event releases: flights, broken springs and uncoupled motors in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo

G, L, M, J = 9.81, 0.8, 2.0, 0.05
SOLVERS = {
    "RK4": (jo.RK4(step=1e-3), 1e-9),
    "ROS2": (jo.ROS2(step=2e-4), 1e-5),
    "alpha": (jo.GeneralizedAlpha(step=2e-4), 1e-5),
    "DormandPrince": (jo.simulation.DormandPrince(tolerance=1e-10), 1e-7),
}


def pendulum(angle=1.0, **more):
    """Return a bob that starts at rest where its arm is level, and lets go at an angle."""
    bob = jo.RigidBody("bob", M, (J, J, J), position=(L, 0, 0), markers={"eye": (-L, 0, 0)}, **more)
    hinge = jo.Revolute("hinge", jo.ground["origin"], bob["eye"], axis=(0, 1, 0))
    let_go = jo.mechanism.Event("let go", hinge.angle, angle, releases=hinge)
    sensors = (
        jo.PositionSensor("place", bob["origin"]),
        jo.AngularVelocitySensor("spin", bob["origin"]),
        jo.ReactionSensor("pull", hinge),
    )
    return jo.Mechanism(bob, hinge, let_go, jo.Gravity((0, 0, -G)), *sensors)


@pytest.mark.parametrize("name", SOLVERS)
def test_a_released_bob_flies_on_a_parabola(name):
    solver, small = SOLVERS[name]
    run = jo.simulate(jo.compile(pendulum()), 1.0, solver=solver, output_step=0.01)
    (happened,) = run.events
    # energy on the circle, then a parabola and a constant spin
    w = np.sqrt(2 * M * G * L * np.sin(1.0) / (M * L**2 + J))
    start = L * np.array([np.cos(1.0), 0, -np.sin(1.0)])
    speed = w * L * np.array([-np.sin(1.0), 0, -np.cos(1.0)])
    after = run.time > happened.time + 1e-9
    assert 10 < np.sum(after) < 80
    t = (run.time[after] - happened.time)[:, None]
    flight = start + speed * t + 0.5 * np.array([0, 0, -G]) * t**2
    np.testing.assert_allclose(run["place"][after], flight, rtol=0, atol=small)
    np.testing.assert_allclose(run["spin"][after][:, 1], w, rtol=small)
    np.testing.assert_array_equal(run["pull"][after], 0.0)
    # before: Newton's law along the arm
    phi = np.arcsin(-run["place"][~after][:, 2] / L)
    along = M * L * 2 * M * G * L * np.sin(phi) / (M * L**2 + J) + M * G * np.sin(phi)
    across = M * G * np.cos(phi) * (1 - M * L**2 / (M * L**2 + J))
    pull = np.linalg.norm(run["pull"][~after][1:, :3], axis=1)
    np.testing.assert_allclose(pull, np.hypot(along, across)[1:], atol=1e3 * small)
    assert np.abs(run.energy.error).max() < max(10 * small, 1e-8) * M * G * L


def test_a_run_goes_on_from_a_state_in_which_the_joint_is_gone():
    model = jo.compile(pendulum())
    whole = jo.simulate(model, 0.8, solver=jo.RK4(step=1e-3), output_step=0.1)
    first = jo.simulate(model, 0.7, solver=jo.RK4(step=1e-3), output_step=0.1)
    assert first.events
    second = jo.simulate(model, 0.8, solver=jo.RK4(step=1e-3), output_step=0.1, state=first.state())
    np.testing.assert_array_equal(second.q[-1], whole.q[-1])


@pytest.mark.parametrize("name", SOLVERS)
def test_a_spring_that_breaks_loses_what_it_has_stored(name):
    """m x'' = F - k x until k x = B, then m x'' = F; B^2 / 2k is lost."""
    solver, small = SOLVERS[name]
    k, F, B = 500.0, 20.0, 30.0
    block = jo.RigidBody("block", M, (J, J, J))
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    spring = jo.Spring("spring", slide.displacement, k)
    push = jo.JointForce("push", slide.displacement, F)
    force = jo.ForceSensor("force", spring)
    snap = jo.mechanism.Event("snap", force, -B, "falling", releases=(spring,))
    lost = jo.mechanism.EnergySensor("lost", "dissipated")
    model = jo.compile(jo.Mechanism(block, slide, spring, push, force, snap, lost))
    run = jo.simulate(model, 0.3, solver=solver, output_step=0.01)
    w = np.sqrt(k / M)
    t1 = np.arccos(1 - B / F) / w
    assert run.events[0].time == pytest.approx(t1, abs=max(small, 1e-8))
    x1, v1 = B / k, F / k * w * np.sin(w * t1)
    t = run.time
    x = np.where(
        t < t1, F / k * (1 - np.cos(w * t)), x1 + v1 * (t - t1) + F / M * (t - t1) ** 2 / 2
    )
    np.testing.assert_allclose(run.q[:, 0], x, rtol=0, atol=max(10 * small, 1e-8))
    after = t > t1
    np.testing.assert_array_equal(run["force"][after], 0.0)
    np.testing.assert_allclose(run["lost"][after], B**2 / (2 * k), rtol=max(10 * small, 1e-8))
    assert np.abs(run.energy.error).max() < max(10 * small, 1e-8) * B**2 / k


def test_a_motor_that_is_uncoupled_leaves_its_wheel_spinning():
    wheel = jo.RigidBody("wheel", 1.0, (0.2, 0.2, 0.2))
    hinge = jo.Revolute("hinge", jo.ground["origin"], wheel["origin"], axis=(0, 0, 1))
    motor = jo.Drive("motor", hinge.angle, jo.SCurve((0, 1), (0, 10.0)))
    speed = jo.RateSensor("speed", hinge.angle)
    off = jo.mechanism.Event("off", hinge.angle, 5.0, releases=(motor,))
    torque = jo.ReactionSensor("torque", motor)
    model = jo.compile(jo.Mechanism(wheel, hinge, motor, speed, off, torque))
    run = jo.simulate(model, 1.5, solver=jo.RK4(step=1e-3), output_step=0.05)
    (happened,) = run.events
    assert happened.time == pytest.approx(0.5, abs=1e-8)  # half way, where the curve is symmetric
    after = run.time > happened.time + 1e-9
    # the steepest slope of 10 t^3 - 15 t^4 + 6 t^5, times the height
    np.testing.assert_allclose(run["speed"][after], 10.0 * 1.875, rtol=1e-9)
    np.testing.assert_array_equal(run["torque"][after], 0.0)
    assert np.abs(run["torque"][~after]).max() > 1.0
    assert np.abs(run.energy.error).max() < 1e-6 * run.energy.kinetic.max()


def held_beam(exact):
    """Return a clamped beam at rest under its weight, whose clamp a clock releases at 20 ms."""
    rubber = jo.Material(E=2e9, nu=0.3, rho=1100.0)
    if exact:
        beam = jo.BeamBody("beam", [(0, 0, 0), (1, 0, 0)], jo.Circle(0.05), rubber, elements=4)
    else:
        part = jo.Part.beam(1.0, jo.Circle(0.05), 4, rubber)
        beam = jo.FlexibleBody("beam", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2)))
    clamp = jo.Fixed("clamp", jo.ground["origin"], beam["start"])
    clock = jo.SignalSensor("clock", jo.Ramp(0.0, 10.0, before=0.0, after=10.0))
    cut = jo.mechanism.Event("cut", clock, 0.02, releases=(clamp,))
    pull = jo.ReactionSensor("pull", clamp)
    return jo.compile(jo.Mechanism(beam, clamp, clock, cut, pull, jo.Gravity((0, 0, -G))))


@pytest.mark.parametrize("solver", [jo.ROS2(step=1e-4), jo.GeneralizedAlpha(step=1e-4)], ids=str)
@pytest.mark.parametrize("exact", [False, True], ids=["modal", "exact"])
def test_a_beam_that_is_cut_loose_falls_as_a_whole(exact, solver):
    """Its centre of mass falls by g t^2 / 2, whatever the beam does meanwhile."""
    model = held_beam(exact)
    rest = jo.equilibrium(model)
    run = jo.simulate(model, 0.06, solver=solver, output_step=5e-3, state=rest)
    assert run.events[0].time == pytest.approx(0.02, abs=1e-11)
    after = run.time > 0.02 + 1e-9
    weight = sum(float(body.mass[0]) for body in model.bodies) * G
    assert run["pull"][0, 2] == pytest.approx(weight, rel=1e-6)
    np.testing.assert_array_equal(run["pull"][after], 0.0)
    # potential energy is that of the centre of mass
    fallen = -(run.energy.potential - run.energy.potential[0]) / weight
    expected = np.where(after, 0.5 * G * (run.time - 0.02) ** 2, 0.0)
    np.testing.assert_allclose(fallen, expected, rtol=0, atol=2e-6)


def test_what_cannot_be_released_is_named():
    ball = jo.RigidBody("ball", M, (J, J, J))
    slide = jo.Prismatic("slide", jo.ground["origin"], ball["origin"], axis=(1, 0, 0))
    other = jo.Fixed("other", jo.ground["origin"], ball["origin"])
    rub = jo.Friction("rub", slide, 0.1)
    events = (
        jo.mechanism.Event("one", slide.displacement, 1.0, releases=(slide, other)),
        jo.mechanism.Event("two", slide.displacement, 2.0, releases=(slide,)),
    )
    with pytest.raises(jo.InputError) as error:
        jo.Mechanism(ball, slide, rub, *events)
    text = str(error.value)
    assert "event 'one': releases joint 'other', which is not in the mechanism; add it" in text
    assert "releases joint 'slide', which has the friction 'rub'" in text
    assert "event 'two': releases joint 'slide', which event 'one' releases already" in text
    with pytest.raises(jo.InputError, match=r"releases\[0\] is 3, must be a joint"):
        jo.mechanism.Event("three", slide.displacement, 1.0, releases=(3,))


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("solver", [jo.RK4(1e-2), jo.ROS2(1e-2), jo.GeneralizedAlpha(1e-2)])
def test_the_states_of_a_controller_stay_after_its_release(solver, core):
    mass = jo.RigidBody("mass", 1.0, (J, J, J))
    rail = jo.Prismatic("rail", jo.ground["origin"], mass["origin"], axis=(1, 0, 0))
    hold = jo.mechanism.PID("hold", rail.displacement, 1.0, kp=8.0, ki=4.0, kd=4.0)
    cut = jo.mechanism.Event("cut", rail.displacement, 0.3, releases=hold)
    engine = jo.model.Engine(jo.compile(jo.Mechanism(mass, rail, hold, cut), core=core))
    native = engine.native_solver(solver.method, solver.step, True, **solver.options)
    seen = []
    for _ in range(60):
        engine.step(native)
        if engine.happened[0]:
            seen.append(engine.states.copy())
    assert len(seen) > 20 and np.abs(seen).min() > 0.1
    np.testing.assert_array_equal(np.ptp(seen, axis=0), 0.0)


@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_a_plastic_spring_divides_no_step_after_its_release(core):
    """RK4 takes four evaluations in each step then, however the coordinate turns."""
    block = jo.RigidBody("block", 1.0, (J, J, J))
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    spring = jo.mechanism.PlasticSpring("spring", slide.displacement, 100.0, 1.0, kinematic=10.0)
    push = jo.JointForce("push", slide.displacement, jo.Harmonic(frequency=5.0, amplitude=40.0))
    cut = jo.mechanism.Event("cut", slide.displacement, 0.02, releases=spring)
    engine = jo.model.Engine(jo.compile(jo.Mechanism(block, slide, spring, push, cut), core=core))
    native, counts = engine.native_solver("rk4", 1e-3, True), []
    for _ in range(800):
        engine.step(native)
        if engine.happened[0]:
            counts.append(engine.counts.evaluations)
    assert len(counts) > 700
    np.testing.assert_array_equal(np.diff(counts)[1:], 4)
