"""Elastic joints: closed forms, two integrations of other programs, both cores, all methods."""

from __future__ import annotations

import warnings
from typing import Any, Literal

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import jousto as jo
from jousto.mechanism import ElasticJoint, GearSpring, HarmonicDrive
from jousto.model.model import Model

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely")

G = 9.81
Z = (0, 0, 1)
Coupled = Literal["exact", "reduced"]
FINE = jo.simulation.DormandPrince(output=0.05, tolerance=1e-12)
UNSTABLE = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
CORES = pytest.mark.parametrize("core", ["joint", "maximal"])


def link(angle: float = 0.0, **more: Any) -> tuple[jo.RigidBody, jo.Revolute, ElasticJoint]:
    """Return a link of 0.8 kg m2 about its joint, the joint, and its motor of 0.35 kg m2."""
    turned = jo.Rotate(Z, radians=angle)
    body = jo.RigidBody("link", 4.0, (0.01, 0.16, 0.16), center=(0.4, 0, 0), orientation=turned)
    joint = jo.Revolute("shoulder", jo.ground["origin"], body["origin"], axis=Z)
    elastic = {"stiffness": 900.0} | more
    return body, joint, ElasticJoint("shoulder", joint.angle, 100, 3.5e-5, **elastic)


def arm(coupling: Coupled = "exact", brake: bool = False, moved: bool = False) -> jo.Mechanism:
    """Return a planar arm of two links, the second one at a right angle, with two motors."""
    upper = jo.RigidBody("upper", 6.0, (0.01, 0.15, 0.15), center=(0.25, 0, 0))
    square = jo.Rotate(Z, degrees=90)
    lower = jo.RigidBody(
        *("lower", 3.0, (0.01, 0.06, 0.06)),
        center=(0.2, 0, 0),
        position=(0.5, 0, 0),
        orientation=square,
    )
    shoulder = jo.Revolute("shoulder", jo.ground["origin"], upper["origin"], axis=Z)
    elbow = jo.Revolute("elbow", upper.at((0.5, 0, 0)), lower["origin"], axis=Z)
    how: Any = {"coupling": coupling, "brake": brake}
    one = ElasticJoint("shoulder", shoulder.angle, 100, 1e-4, 2e4, **how)
    two = ElasticJoint("elbow", elbow.angle, 100, 5e-5, 8e3, rotor_mass=0.5, **how)
    items = [upper, lower, shoulder, elbow, one, two, jo.CoordinateSensor("q", shoulder.angle)]
    for motor, size in ((one.motor, 40.0), (two.motor, -15.0)) if moved else ():
        signal = jo.Harmonic(frequency=5.0 / np.pi, amplitude=size / 100)
        items.append(jo.JointForce(f"torque of {motor.name.split()[0]}", motor, signal))
    return jo.Mechanism(*items)


def speeds(mechanism: jo.Mechanism, state: Any = None) -> NDArray[np.float64]:
    """Return the natural frequencies, rad/s."""
    return 2 * np.pi * jo.modes(jo.compile(mechanism), state).frequencies


def end(model: Model, t: float, sensor: str = "q", solver: Any = FINE) -> float:
    return float(jo.simulate(model, t, solver=solver)[sensor][-1, 0])


# -- numbers of two masses and of a planar arm ------------------------------------------------


def test_frequencies_of_two_inertias() -> None:
    """Free ``sqrt(K (1/I + 1/B))``, with the motor held ``sqrt(K / I)``."""
    free = speeds(jo.Mechanism(*link()))
    np.testing.assert_allclose(free[1], np.sqrt(900 * (1 / 0.8 + 1 / 0.35)), rtol=1e-12)
    np.testing.assert_allclose(free[1], 60.79826125, rtol=1e-9)
    held = speeds(jo.Mechanism(*link(brake=True)))
    np.testing.assert_allclose(held, [33.54101966], rtol=1e-9)


def sagging(q: float) -> float:
    """Torque on the link at angle q, with the motor held at 30 degrees, N m."""
    return 900 * (np.pi / 6 - q) - 4 * G * 0.4 * np.cos(q)


SAGGED = brentq(sagging, 0.4, 0.6, xtol=1e-15)


def test_statics_with_the_brake() -> None:
    items = (*link(np.pi / 6, brake=True), jo.Gravity((0, -G, 0)))
    model = jo.compile(jo.Mechanism(*items, jo.CoordinateSensor("q", items[1].angle)))
    state = jo.equilibrium(model)
    angle = 2 * np.arctan2(state.q[6], state.q[3])
    np.testing.assert_allclose(angle, 0.5083642049, rtol=1e-9)
    np.testing.assert_allclose(speeds(jo.Mechanism(*items), state), [33.39835303], rtol=1e-9)


@CORES
def test_a_link_goes_round(core: str) -> None:
    """Motor torque on the side of the joint: the weight's, and 30 sin 6t."""
    *items, motor = link(SAGGED, damping=1.5, windup=np.pi / 6 - SAGGED)
    weight = jo.Constant(4 * G * 0.4 * np.cos(SAGGED) / 100)
    torque = weight + jo.Harmonic(frequency=3 / np.pi, amplitude=0.3)
    items += [motor, jo.JointForce("torque", motor.motor, torque), jo.Gravity((0, -G, 0))]
    machine = jo.Mechanism(*items, jo.CoordinateSensor("q", items[1].angle))
    found = SAGGED + end(jo.compile(machine, core=core), 1.0)
    np.testing.assert_allclose(found, 8.705858464, rtol=1e-9)


@pytest.mark.parametrize("ratio", [100.0, -40.0])
def test_statics_of_a_motor_that_turns_several_times(ratio: float) -> None:
    """A soft servo holds the motor: 50 and 900 N m/rad in series under the weight of the link."""
    body, joint, _ = link()
    motor = ElasticJoint("shoulder", joint.angle, ratio, 3.5e-5, 900.0)
    servo = jo.Servo("servo", motor.motor, 0.0, kp=50.0 / ratio**2)
    read = jo.CoordinateSensor("q", joint.angle), jo.CoordinateSensor("phi", motor.motor)
    items = (body, joint, motor, servo, *read, jo.Gravity((0, -G, 0)))
    model = jo.compile(jo.Mechanism(*items))
    run = jo.simulate(model, 0.01, state=jo.equilibrium(model))
    series = 50.0 * 900.0 / 950.0
    q = brentq(lambda x: series * x + 4 * G * 0.4 * np.cos(x), -1.0, 0.0, xtol=1e-15)
    np.testing.assert_allclose(run["q"][:, 0], q, rtol=1e-9)
    np.testing.assert_allclose(run["phi"][:, 0] / ratio, q * series / 50.0, rtol=1e-9)
    assert abs(run["phi"][0, 0]) > 2 * np.pi


@pytest.mark.parametrize("coupling, third", [("exact", 178.7170757), ("reduced", 178.6123391)])
def test_frequencies_of_an_arm(coupling: Coupled, third: float) -> None:
    held = speeds(arm(coupling, brake=True))
    np.testing.assert_allclose(held, [110.1738355, 228.7038613], rtol=1e-9)
    np.testing.assert_allclose(speeds(arm(coupling))[2], third, rtol=1e-9)


@CORES
@pytest.mark.parametrize("coupling, q", [("exact", 1.033002961), ("reduced", 1.028797100)])
def test_an_arm_moves(coupling: Coupled, q: float, core: str) -> None:
    found = end(jo.compile(arm(coupling, moved=True), core=core), 0.5)
    np.testing.assert_allclose(found, q, rtol=1e-9)


# -- what runs -----------------------------------------------------------------------------


@pytest.mark.parametrize("coupling", ["exact", "reduced"])
def test_it_stays_a_tree_without_rows(coupling: Coupled) -> None:
    model = jo.compile(arm(coupling))
    assert jo.doctor(model).core == "joint coordinates (4 of a tree)"


@UNSTABLE
def test_stiff_gears_do_not_limit_the_step_of_ros2() -> None:
    """A gear 1e4 times as stiff: 18 turns of its vibration in a step of 1 ms."""
    body, joint, motor = link(stiffness=9e6, damping=0.0)
    torque = jo.JointForce("torque", motor.motor, jo.Harmonic(frequency=1.0, amplitude=0.5))
    items = (body, joint, motor, torque, jo.CoordinateSensor("q", joint.angle))
    stiff = jo.compile(jo.Mechanism(*items), core="joint")
    w, tau = 2 * np.pi, 0.5 * 100
    rigid = tau / (0.8 + 0.35) / w * (0.5 - np.sin(w * 0.5) / w)  # one rigid inertia, from rest
    errors = [end(stiff, 0.5, solver=jo.ROS2(h)) - rigid for h in (2e-3, 1e-3)]
    assert abs(errors[1]) < 1e-5 * abs(rigid)
    assert abs(errors[0]) < 5e-5 * abs(rigid)
    grown = end(jo.compile(jo.Mechanism(*items), core="maximal"), 0.5, solver=jo.ROS2(1e-3))
    assert abs(grown - rigid) > abs(rigid)


def wheel_drive(K: float, sliding: bool, ratio: float = -80.0) -> jo.Model:
    """Return a cart or wheel whose joint is declared from it to the ground: the motor is on it.

    Another link on it shakes the motor; ``theta' = -q'`` where the gear is rigid.
    """
    body = jo.RigidBody("body", 4.0, (0.1, 0.2, 0.3), center=(0.1, 0.02, 0.03))
    other = jo.RigidBody("other", 1.0, (0.01, 0.02, 0.03), center=(0.2, 0.1, 0.0))
    kind: Any = jo.Prismatic if sliding else jo.Revolute
    joint = kind("joint", body["origin"], jo.ground["origin"], axis=(1, 0.2, 0.3))
    swing = jo.Revolute("swing", body["origin"], other["origin"], axis=(0, 1, 0))
    motor = ElasticJoint("joint", joint.coordinates[0], ratio, 2e-4, K, damping=K / 3e4)
    torque = jo.JointForce("torque", motor.motor, jo.Harmonic(frequency=1.0, amplitude=0.5))
    read = jo.CoordinateSensor("q", motor.coordinate)
    items = (body, other, joint, swing, motor, torque, read, jo.Gravity((0, 0, -G)))
    return jo.compile(jo.Mechanism(*items), core="joint")


@pytest.mark.parametrize("sliding", [False, True])
def test_a_motor_on_the_moving_body_is_in_the_matrix_of_ros2(sliding: bool) -> None:
    """Second order, and a gear 1e4 times as stiff does not limit the step."""
    soft, stiff = wheel_drive(3e4, sliding), wheel_drive(3e8, sliding)
    assert soft.tree[0].reversed
    exact = end(soft, 0.2)
    errors = [abs(end(soft, 0.2, solver=jo.ROS2(h)) - exact) for h in (4e-4, 2e-4)]
    assert 3.5 < errors[0] / errors[1] < 4.5
    rigid = end(wheel_drive(3e5, sliding), 0.2, solver=jo.ROS2(1e-5))
    np.testing.assert_allclose(end(stiff, 0.2, solver=jo.ROS2(1e-3)), rigid, rtol=2e-3)


@pytest.mark.parametrize("coupling", ["exact", "reduced"])
@pytest.mark.parametrize("method", [jo.ROS2, jo.GeneralizedAlpha])
def test_methods_are_of_second_order(method: Any, coupling: Coupled) -> None:
    model = jo.compile(arm(coupling, moved=True))
    exact = end(model, 0.5)
    errors = [abs(end(model, 0.5, solver=method(h)) - exact) for h in (2e-4, 1e-4)]
    assert 3.5 < errors[0] / errors[1] < 4.5


@pytest.mark.parametrize("coupling", ["exact", "reduced"])
def test_on_a_flexible_boom_both_cores_agree(coupling: Coupled) -> None:
    """A rigid tree with elastic joints on a flexible boom; ROS2 has the gears in its matrix."""
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    strip = jo.Part.beam(2.0, jo.Rectangle(0.02, 0.04), 4, steel)
    boom = jo.FlexibleBody("boom", jo.reduce(strip, jo.CraigBampton(("start", "end"), modes=2)))
    items: list[Any] = [boom, jo.Fixed("foot", jo.ground["origin"], boom["start"])]
    before: Any = boom["end"]
    for k in range(4):
        body = jo.RigidBody(
            f"link {k}", 2.0, (0.01, 0.1, 0.1), center=(0.4, 0, 0), position=(2 + k, 0, 0)
        )
        pin = jo.Revolute(f"pin {k}", before, body["origin"], axis=(0, 1, k % 2))
        gear: dict[str, Any] = {"damping": 2.0, "coupling": coupling}
        items += [body, pin, ElasticJoint(f"pin {k}", pin.angle, -60, 2e-5, 2e3, **gear)]
        before = body.at((1, 0, 0))
    machine = jo.Mechanism(*items, jo.PositionSensor("q", before), jo.Gravity((0, 0, -G)))
    joint, maximal = (jo.compile(machine, core=core) for core in ("joint", "maximal"))
    assert "joint coordinates for" in jo.doctor(joint).core
    exact = jo.simulate(maximal, 0.05, solver=jo.RK4(2e-5))["q"][-1]
    for solver, error in ((jo.RK4(2e-5), 1e-9), (jo.ROS2(1e-4), 2e-6)):
        found = jo.simulate(joint, 0.05, solver=solver)["q"][-1]
        np.testing.assert_allclose(found, exact, atol=error)


def test_friction_that_sticks_on_the_motor_beside_ros2() -> None:
    """The motor sticks, and its link swings on the gear."""
    body, joint, motor = link(0.1, windup=0.2)
    hold = jo.Friction(
        *("hold", motor.bearing, 0.5),
        radius=1.0,
        preload=9.0,
        law=jo.mechanism.StickSlip(),
    )
    read = jo.CoordinateSensor("q", joint.angle), jo.CoordinateSensor("phi", motor.motor)
    model = jo.compile(jo.Mechanism(body, joint, motor, hold, *read))
    run = jo.simulate(model, 0.3, solver=jo.ROS2(1e-4))
    w = np.sqrt(900 / 0.8)
    np.testing.assert_array_equal(run["phi"], 0.0)
    np.testing.assert_allclose(run["q"][:, 0], 0.2 * (1 - np.cos(w * run.time)), atol=2e-5)


def test_friction_of_the_motor_slips_in_both_cores() -> None:
    runs, law = [], jo.mechanism.Regularised(velocity=0.5)
    for core in ("joint", "maximal"):
        body, joint, motor = link(0.1, windup=0.2)
        rub = jo.Friction("rub", motor.bearing, 0.2, radius=0.5, preload=2.0, law=law)
        read = jo.CoordinateSensor("q", joint.angle)
        model = jo.compile(jo.Mechanism(body, joint, motor, rub, read), core=core)
        runs.append(jo.simulate(model, 0.3, solver=jo.ROS2(2e-5))["q"])
    assert np.ptp(runs[0]) > 0.05
    np.testing.assert_allclose(runs[0], runs[1], atol=1e-6)


def test_dry_and_viscous_friction_of_the_motor_stop_it() -> None:
    """A motor alone: ``J w' = -f - c w`` until it stands."""
    body, joint, motor = link(friction=0.02, viscous=1e-4)
    spin = jo.Initial(motor.motor, rate=30.0)
    free = jo.Mechanism(body, motor.rotor, motor.bearing, joint, motor.items[3], spin)
    rate = jo.RateSensor("w", motor.motor)
    model = jo.compile(jo.Mechanism(*free.items, rate))
    run = jo.simulate(model, 0.06, solver=jo.RK4(1e-5))
    a = 1e-4 / 3.5e-5
    wanted = (30.0 + 200.0) * np.exp(-a * run.time) - 200.0
    moving = wanted > 1.5  # full friction above 0.01 rad/s of the joint, 1 rad/s of the motor
    np.testing.assert_allclose(run["w"][moving, 0], wanted[moving], rtol=1e-8)
    assert abs(run["w"][-1, 0]) < 1.5


def test_the_doctor_says_the_explicit_step() -> None:
    """Two inertias, an arm, and a law whose last piece is the stiffest."""
    step = jo.doctor(jo.Mechanism(*link())).explicit_step
    np.testing.assert_allclose(step, 2.8 / 60.79826125, rtol=1e-9)
    np.testing.assert_allclose(jo.doctor(arm()).explicit_step, 2.8 / speeds(arm())[3], rtol=1e-9)
    soft = jo.doctor(jo.Mechanism(*link(stiffness=None, law=DRIVE)))
    pair = np.sqrt(1.7e4 * (1 / 0.8 + 1 / 0.35))
    np.testing.assert_allclose(soft.explicit_step, 2.8 / pair, rtol=1e-9)
    assert f"explicit: RK4 needs a step below {2.8e3 / pair:.3g} ms" in str(soft)
    bare = jo.Mechanism(*link()[:2])
    assert jo.doctor(bare).explicit_step is None


# -- laws ------------------------------------------------------------------------------------


DRIVE = HarmonicDrive(stiffness=(1e4, 1.4e4, 1.7e4), torques=(14, 48))


@UNSTABLE
@pytest.mark.parametrize(
    "losses",
    [
        {},
        {"damping": 1.5},
        {"damping": 50.0},  # decays without vibration
        {"damping": 1.5e3},
        {"viscous": 0.2},
        {"friction": 0.2},  # of full size above a small speed only
        {"damping": 10.0, "viscous": 1e-3, "law": DRIVE, "stiffness": None},
    ],
)
def test_the_explicit_step_is_that_of_rk4(losses: dict[str, Any]) -> None:
    body, joint, motor = link(windup=1e-3, **losses)
    model = jo.compile(jo.Mechanism(body, joint, motor, jo.CoordinateSensor("q", joint.angle)))
    step = jo.doctor(model).explicit_step
    assert step is not None
    assert abs(end(model, 200 * step, solver=jo.RK4(0.98 * step))) < 2e-3
    if losses.get("friction") or "law" in losses:  # softer at large speeds, at small wind-up
        return
    with pytest.raises(jo.simulation.RunFailed, match="diverged"):
        end(model, 1500 * step, solver=jo.RK4(1.05 * step))


def test_the_explicit_step_sees_a_servo_of_the_motor() -> None:
    """Position control at the motor: ``B theta'' = -kp N^2 theta``, stiffer than the gear."""
    body, joint, motor = link()
    servo = jo.Servo("servo", motor.motor, 0.0, kp=30.0, kd=0.05)
    step = jo.doctor(jo.Mechanism(body, joint, motor, servo)).explicit_step
    K, D = np.array([[900.0, -900.0], [-900.0, 900 + 30e4]]), np.diag([0.0, 0.05e4])
    H = np.diag([1 / 0.8, 1 / 0.35])
    rates = np.linalg.eigvals(np.block([[np.zeros((2, 2)), np.eye(2)], [-H @ K, -H @ D]]))
    x = step * rates
    growth = np.abs(1 + x + x**2 / 2 + x**3 / 6 + x**4 / 24)
    assert 0.95 < growth.max() < 1.0


def test_windup_of_a_harmonic_drive() -> None:
    np.testing.assert_allclose(DRIVE.windup(80.0), 5.710924370e-3, rtol=1e-9)
    np.testing.assert_allclose(DRIVE.windup(-7.0), -7e-4, rtol=1e-14)


def test_torque_of_a_harmonic_drive() -> None:
    """The motor is held, the link swings through all pieces of the law; SciPy integrates it."""

    def torque(e: float) -> float:
        size = abs(e)
        corners = np.array([0.0, 14 / 1e4, 14 / 1e4 + 34 / 1.4e4])
        pieces = np.diff([*corners, np.inf])
        parts = np.clip(size - corners, 0.0, pieces) @ np.array([1e4, 1.4e4, 1.7e4])
        return float(np.sign(e) * parts)

    body, joint, motor = link(stiffness=None, law=DRIVE, windup=7e-3, brake=True)
    read = jo.CoordinateSensor("q", joint.angle), jo.ForceSensor("s", motor.gear)
    energy = jo.mechanism.EnergySensor("energy", "springs")
    model = jo.compile(jo.Mechanism(body, joint, motor, *read, energy))
    run = jo.simulate(model, 0.1, solver=FINE)
    wanted = solve_ivp(
        lambda t, y: [y[1], torque(7e-3 - y[0]) / 0.8],
        *((0, 0.1), (0.0, 0.0)),
        rtol=1e-12,
        atol=1e-14,
        max_step=1e-3,
        t_eval=run.time,
    )
    np.testing.assert_allclose(run["q"][:, 0], wanted.y[0], atol=1e-9)
    s = np.array([torque(7e-3 - q) for q in run["q"][:, 0]])
    np.testing.assert_allclose(run["s"], np.stack([s, -s / 100], axis=1), rtol=1e-8, atol=1e-8)
    assert abs(run["s"][0, 0]) > 48.0  # beyond the last corner


def test_a_ball_screw_carries_its_motor() -> None:
    """A slide with a motor that turns along it: N in radians per metre."""
    body = jo.RigidBody("table", 20.0, (1, 1, 1))
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    ratio, J, K = 2 * np.pi / 0.005, 2e-5, 3e7
    motor = ElasticJoint("slide", slide.displacement, ratio, J, K)
    pair = np.sqrt(K * (1 / 20.0 + 1 / (ratio**2 * J)))
    np.testing.assert_allclose(speeds(jo.Mechanism(body, slide, motor))[1], pair, rtol=1e-9)


@CORES
@pytest.mark.parametrize("solver", [FINE, jo.GeneralizedAlpha(1e-4), jo.ROS2(1e-4)])
def test_a_rotor_is_a_gyroscope(solver: Any, core: str) -> None:
    """The axis of a fast motor turns: the moment across it is ``J phi' w``."""
    frame = jo.RigidBody("frame", 5.0, (0.1, 0.1, 0.1), angular_velocity=(0, 0, 2.0))
    table = jo.Revolute("table", jo.ground["origin"], frame["origin"], axis=Z)
    arm = jo.RigidBody("arm", 1e-3, (1.0, 1.0, 1.0), angular_velocity=(0, 0, 2.0))
    roll = jo.Revolute("roll", frame["origin"], arm["origin"], axis=(1, 0, 0))
    motor = ElasticJoint("roll", roll.angle, 100, 1e-3, 1e-6)
    items = (frame, table, arm, roll, motor, jo.Initial(motor.motor, rate=300.0))
    across = jo.ReactionSensor("across", motor.bearing, resolved_in=frame["origin"])
    model = jo.compile(jo.Mechanism(*items, across), core=core)
    run = jo.simulate(model, 0.02, solver=solver)
    np.testing.assert_allclose(run["across"][-1, 4], 1e-3 * 300.0 * 2.0, rtol=1e-6)


# -- the start -------------------------------------------------------------------------------


@pytest.mark.parametrize("how", ["initial", "bodies"])
def test_a_gear_starts_without_windup(how: str) -> None:
    body, joint, motor = link()
    start: tuple[Any, ...] = (jo.Initial(joint.angle, value=2.0, rate=0.5),)
    if how == "bodies":
        body = jo.RigidBody("link", 4.0, (0.01, 0.16, 0.16), angular_velocity=(0, 0, 0.5))
        joint = jo.Revolute("shoulder", jo.ground["origin"], body["origin"], axis=Z)
        motor = ElasticJoint("shoulder", joint.angle, 100, 3.5e-5, 900.0)
        start = ()
    read = jo.ForceSensor("s", motor.gear), jo.RateSensor("w", motor.motor)
    model = jo.compile(jo.Mechanism(body, joint, motor, *read, *start))
    run = jo.simulate(model, 0.1)
    np.testing.assert_allclose(run["w"], 50.0, rtol=1e-12)
    np.testing.assert_allclose(run["s"], 0.0, atol=1e-9)


def test_a_motor_keeps_the_rate_given_to_it() -> None:
    body, joint, motor = link()
    rates = jo.Initial(joint.angle, rate=0.5), jo.Initial(motor.motor, rate=-7.0)
    read = jo.RateSensor("w", motor.motor)
    run = jo.simulate(jo.compile(jo.Mechanism(body, joint, motor, *rates, read)), 0.001)
    np.testing.assert_allclose(run["w"][0], -7.0, rtol=1e-12)
    braked = (*link(brake=True),)
    spun = jo.Initial(braked[1].angle, rate=0.5)
    read = jo.RateSensor("q", spun.coordinate)
    run = jo.simulate(jo.compile(jo.Mechanism(*braked, spun, read)), 1e-3)
    np.testing.assert_allclose(run["q"][0], 0.5, rtol=1e-12)


# -- what is wrong ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"ratio": 0.0}, "ratio is 0, must not be zero"),
        ({"rotor_inertia": -1.0}, "rotor_inertia is -1 kg m2, must be positive"),
        ({"stiffness": None}, "give either stiffness or law"),
        ({"law": DRIVE}, "give either stiffness or law"),
        ({"stiffness": None, "law": 3.0}, "law is 3.0, must be a HarmonicDrive or None"),
        ({"coupling": "soft"}, "coupling is 'soft', must be 'exact' or 'reduced'"),
        ({"coordinate": 1.0}, "coordinate is 1.0, must be a coordinate such as hinge.angle"),
    ],
)
def test_what_is_wrong_is_named(changes: Any, message: str) -> None:
    given = {"coordinate": link()[1].angle, "ratio": 100, "rotor_inertia": 3.5e-5}
    with pytest.raises(jo.InputError, match=message):
        ElasticJoint("shoulder", **{**given, "stiffness": 900.0, **changes})


def test_lengths_have_no_harmonic_drive_and_no_distance_a_motor() -> None:
    body = jo.RigidBody("table", 20.0, (1, 1, 1))
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    with pytest.raises(jo.InputError, match="law is for angles, but slide.displacement is"):
        ElasticJoint("slide", slide.displacement, 100, 1e-5, law=DRIVE)
    away = jo.Distance(jo.ground.at((1, 0, 0)), body["origin"])
    with pytest.raises(jo.InputError, match="is a distance, must be an angle or a displacement"):
        ElasticJoint("slide", away, 100, 1e-5, 1.0)
    angle = link()[1].angle
    with pytest.raises(jo.InputError, match="couples shoulder.angle with itself"):
        GearSpring("gear", angle, angle, 1.0, 1.0)
    with pytest.raises(jo.InputError, match="a length; must be an angle"):
        GearSpring("gear", angle, slide.displacement, 1.0, 1.0)


def test_laws_are_compared_and_hashed() -> None:
    other = HarmonicDrive(stiffness=(1e4, 1.4e4, 1.7e4), torques=(14, 48))
    assert DRIVE in (other, DRIVE)
    assert {DRIVE: 1}[DRIVE] == 1


def test_wrong_laws_are_named() -> None:
    with pytest.raises(jo.InputError, match="2 values of stiffness but 2 torques"):
        HarmonicDrive(stiffness=(1e4, 1e4), torques=(14, 48))
    with pytest.raises(jo.InputError, match="must be positive and ascending"):
        HarmonicDrive(stiffness=(1e4, 1e4, 1e4), torques=(48, 14))
    with pytest.raises(jo.InputError, match="must be positive"):
        HarmonicDrive(stiffness=(1e4, -1e4), torques=(48,))


def test_the_derivative_by_the_ratio_contains_that_of_the_friction() -> None:
    """Speed of full friction: 0.01 rad/s of the joint, ``ratio`` times as much at the motor."""

    def machine(ratio: float) -> jo.Mechanism:
        body, joint, _ = link()
        motor = ElasticJoint("shoulder", joint.angle, ratio, 3.5e-3, 900.0, friction=0.02)
        torque = jo.JointForce("torque", motor.motor, jo.Harmonic(frequency=3.0, amplitude=0.1))
        return jo.Mechanism(body, joint, motor, torque, jo.CoordinateSensor("q", joint.angle))

    def q(ratio: float) -> float:
        return end(jo.compile(machine(ratio)), 0.1, solver=jo.RK4(1e-3))

    ratio = [jo.Parameter("ratio", -60.0)]
    study = jo.study(machine, ratio, {"q": "last(q)"}, t_end=0.1, solver=jo.RK4(1e-3))
    found = jo.design.gradient(study)
    assert "1 of 1 derivatives by complex steps" in str(found)
    slope = (q(-60.01) - q(-59.99)) / -0.02
    np.testing.assert_allclose(found["q", "ratio"], slope, rtol=1e-6)


@pytest.mark.filterwarnings("ignore:.*energy balance")
@pytest.mark.parametrize(
    "core, solver, warned",
    [
        ("maximal", jo.RK4(1e-3), True),
        ("joint", jo.GeneralizedAlpha(1e-3), True),
        ("joint", jo.RK4(1e-3), False),
        ("maximal", jo.RK4(2e-4), False),
    ],
)
def test_motors_whose_turns_are_not_counted_are_named(core: str, solver: Any, warned: bool) -> None:
    """A gear of 1e4: at 0.5 rad/s of the joint the motor turns by 5 rad in a step of 1 ms."""
    body, joint, _ = link()
    motor = ElasticJoint("shoulder", joint.angle, 1e4, 3.5e-9, 900.0)
    rate = jo.Initial(joint.angle, rate=0.5)
    model = jo.compile(jo.Mechanism(body, joint, motor, rate), core=core)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        jo.simulate(model, 0.02, solver=solver)
    named = [str(x.message) for x in caught if "'shoulder gear' turns by up" in str(x.message)]
    assert len(named) == warned
    assert all("rad in a step" in x and "take steps below 0.000" in x for x in named)
