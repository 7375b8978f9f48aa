"""Joint friction against closed forms: a belt, a pin, a rough floor; energy and order.

The references are in `friction`: a block on a belt in closed form, a point mass on a pin whose
normal force contains the acceleration; `test_friction_reference` checks them.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification.friction import GRAVITY, Belt, PinPendulum
from verification.mechanisms import rod


def block_on_a_belt(law: jo.mechanism.Regularised | jo.mechanism.StickSlip) -> jo.Model:
    """Start at the end of a slip: the stretch is -D about that of sliding."""
    data = Belt()
    place = data.kinetic * data.mass * GRAVITY / data.stiffness - data.stretch
    v = (data.speed, 0.0, 0.0)
    belt = jo.RigidBody("belt", 1.0, (1, 1, 1), velocity=v)
    block = jo.RigidBody("block", data.mass, (1, 1, 1), position=(place, 0, 0), velocity=v)
    origin, x = jo.ground["origin"], (1, 0, 0)
    frame = jo.Prismatic("frame", origin, belt["origin"], axis=x)
    contact = jo.Prismatic("contact", belt["origin"], block["origin"], axis=x)
    way = jo.Displacement(origin, block["origin"], "x")
    return jo.compile(
        jo.Mechanism(
            *(belt, block, frame, contact, jo.Gravity((0, 0, -GRAVITY))),
            jo.Drive("motor", frame.displacement, jo.Ramp(-1, 9, -data.speed, 9 * data.speed)),
            jo.Spring("spring", way, data.stiffness, free=0.0),
            jo.Friction("rub", contact, data.kinetic, data.static, law=law),
            jo.CoordinateSensor("x", way),
            jo.RateSensor("slip", contact.displacement),
        )
    )


def pendulum(law: jo.mechanism.Regularised | jo.mechanism.StickSlip) -> jo.Model:
    """A point mass (with 1e-8 kg m2, without which its turn is not defined) on a pin, at 90 deg."""
    data = PinPendulum()
    bob = jo.RigidBody("bob", data.mass, (1e-8,) * 3, position=(data.length, 0, 0))
    pin = jo.Revolute("pin", jo.ground["origin"], bob.at((-data.length, 0, 0)), axis=(0, 0, 1))
    return jo.compile(
        jo.Mechanism(
            *(bob, pin, jo.Gravity((0, -GRAVITY, 0))),
            jo.Friction("rub", pin, data.friction, radius=data.radius, law=law),
            jo.CoordinateSensor("angle", pin.angle),
            jo.RateSensor("rate", pin.angle),
        )
    )


def test_regularised_friction_converges_to_the_belt():
    """Extremes of the position; the error falls with the root of the law's velocity."""
    low, high = Belt().extremes
    errors = []
    for velocity in (1e-2, 2.5e-3):
        run = jo.simulate(
            block_on_a_belt(jo.mechanism.Regularised(velocity)), 0.9, solver=jo.RK4(2e-4)
        )
        x = run["x"].ravel()
        errors.append(max(abs(x.min() - low), abs(x.max() - high)))
    assert errors[1] < 0.6 * errors[0]
    assert errors[1] < 0.03 * (high - low)


def test_regularised_friction_converges_to_the_pin():
    """First turning points; the error falls with the law's velocity."""
    exact = np.array(PinPendulum().turning_points(np.pi / 2, 2))
    errors = []
    for velocity in (8e-3, 2e-3):
        run = jo.simulate(pendulum(jo.mechanism.Regularised(velocity)), 2.4, solver=jo.RK4(2e-4))
        angle = run["angle"].ravel() + np.pi / 2
        found = np.array([angle.min(), angle[run.time > 1.5].max()])
        errors.append(np.abs(found - exact[:, 1]).max())
    assert errors[1] < 0.3 * errors[0]
    assert errors[1] < 1e-4


@pytest.mark.parametrize("solver", [jo.RK4(1e-3), jo.ROS2(1e-3)], ids=lambda s: type(s).__name__)
def test_a_block_on_a_rough_floor_loses_4_mu_m_g_over_k_per_period(solver):
    """Den Hartog: half periods of pi/w about +-mu m g / k, until the spring cannot move it."""
    m, k, mu, start = 2.0, 200.0, 0.1, 0.1
    block = jo.RigidBody("block", m, (1, 1, 1), position=(start, 0, 0))
    floor = jo.Prismatic("floor", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    model = jo.compile(
        jo.Mechanism(
            *(block, floor, jo.Gravity((0, 0, -GRAVITY))),
            jo.Spring("spring", floor.displacement, k, free=0.0),
            jo.Friction("rub", floor, mu, law=jo.mechanism.StickSlip()),
            jo.CoordinateSensor("x", floor.displacement),
        )
    )
    run = jo.simulate(model, 4.0, solver=solver)
    x, loss = run["x"].ravel(), mu * m * GRAVITY / k
    half = np.pi / np.sqrt(k / m)
    turns = round(0.5 * (start / loss - 1))  # the block stops where k |x| <= mu m g
    ends = start - 2 * loss * np.arange(turns + 1)
    assert abs(ends[-1]) <= loss < abs(ends[-2])
    for i, end in enumerate(ends):
        at = int(round(i * half / solver.step))
        assert abs(x[at]) == pytest.approx(abs(end), abs=2e-5)
    assert x[-1] == pytest.approx((-1) ** turns * ends[-1], abs=2e-5)
    assert np.ptp(x[run.time > (turns + 0.1) * half]) < 1e-14  # and there it stays
    gone = 0.5 * k * (start**2 - x[-1] ** 2)
    assert run.energy.friction[-1] == pytest.approx(gone, rel=5e-5)


def test_the_pin_pendulum_swings_as_the_reference_says_between_its_turns():
    """Fourth order in the step up to the first turning point: N contains the acceleration."""
    data, end = PinPendulum(), 0.8
    from scipy.integrate import solve_ivp

    exact = solve_ivp(
        lambda _, y: [y[1], data.acceleration(y[0], y[1], -1.0)],
        *((0.0, end), [np.pi / 2, -1e-300]),
        method="DOP853",
        rtol=1e-13,
        atol=1e-14,
    ).y[0, -1]
    errors = {}
    for solver in (jo.RK4(0.04), jo.RK4(0.02), jo.ROS2(0.02), jo.ROS2(0.01)):
        run = jo.simulate(pendulum(jo.mechanism.StickSlip()), end, solver=solver)
        errors[solver] = abs(run["angle"].ravel()[-1] + np.pi / 2 - exact)
    rk4, rk4_half, ros2, ros2_half = errors.values()
    assert 12 < rk4 / rk4_half < 20
    assert 3.5 < ros2 / ros2_half < 4.5


def swinging(law: jo.mechanism.Regularised | jo.mechanism.StickSlip) -> jo.Model:
    """Two flexible beams in space: a pin with all ways to press, and a pole on which one slides."""
    lengths = {"radius": 0.05, "bearing_length": 0.3, "collar_radius": 0.08}
    at = np.array([1.0, 0.0, 0.0])
    w = np.array([0.1, 0.3, 1.0]) * (1.0 / 1.1)
    upper = jo.FlexibleBody("upper", rod(), angular_velocity=w)
    pin = jo.Revolute("pin", jo.ground["origin"], upper["start"], axis=w)
    lower = jo.FlexibleBody(
        *("lower", rod()),
        position=at,
        orientation=jo.Rotate((0, 0, 1), degrees=-70.0),
        velocity=np.cross(w, at),
        angular_velocity=w,
    )
    pole = jo.Cylindrical("pole", upper["end"], lower["start"], axis=(0, 0.2, 1.0))
    return jo.compile(
        jo.Mechanism(
            *(upper, lower, pin, pole, jo.Gravity((0, -GRAVITY, 0))),
            jo.Friction("pin friction", pin, 0.2, 0.25, law=law, **lengths),
            jo.Friction(
                *("pole friction", pole, 0.1, 0.2), radius=0.05, bearing_length=0.3, law=law
            ),
            jo.Spring("return", pole.displacement, 500.0, free=0.0),
        )
    )


@pytest.mark.parametrize(
    ("law", "solver", "fall"),
    [
        # with switches between sticking and slipping only small, not of the order of the method
        (jo.mechanism.StickSlip(), jo.RK4, 0.0),
        (jo.mechanism.StickSlip(), jo.ROS2, 0.0),
        (jo.mechanism.Regularised(0.02), jo.RK4, 6.0),
        (jo.mechanism.Regularised(0.02), jo.ROS2, 3.0),
    ],
    ids=lambda x: x.__name__ if isinstance(x, type) else type(x).__name__,
)
def test_friction_never_adds_energy_and_the_balance_closes(law, solver, fall):
    runs = [jo.simulate(swinging(law), 0.4, solver=solver(step)) for step in (2e-4, 1e-4)]
    assert min(np.diff(run.energy.friction).min() for run in runs) >= 0.0
    lost = runs[-1].energy.friction[-1]
    assert lost > 1.0
    missed = [np.abs(run.energy.error).max() for run in runs]
    assert missed[-1] < 2e-4 * lost
    assert missed[0] / missed[1] > fall


def test_a_stuck_hinge_of_a_vibrating_beam_does_not_creep():
    """A horizontal flexible beam let go on a hinge that holds: only its modes move."""
    beam = jo.FlexibleBody("beam", rod())
    hinge = jo.Revolute("hinge", jo.ground["origin"], beam["start"], axis=(0, 0, 1))
    model = jo.compile(
        jo.Mechanism(
            *(beam, hinge, jo.Gravity((0, -GRAVITY, 0))),
            jo.Friction("brake", hinge, 0.5, radius=0.1, preload=2e4, law=jo.mechanism.StickSlip()),
            jo.CoordinateSensor("angle", hinge.angle),
            jo.PositionSensor("tip", beam["end"]),
        )
    )
    run = jo.simulate(model, 2.0, solver=jo.ROS2(2e-4))
    assert np.ptp(run["tip"][:, 1]) > 1e-3
    assert np.abs(run["angle"]).max() < 1e-12
    assert run.energy.friction[-1] < 1e-12


def test_thirty_rubbing_hinges_of_a_flexible_chain_do_not_chatter():
    """Let go from rest: frictions that release and hold one another settle in a few evaluations."""
    items: list[object] = [jo.Gravity((0, -GRAVITY, 0))]
    at = jo.ground["origin"]
    for i in range(30):
        body = jo.FlexibleBody(f"link {i}", rod(), position=(i, 0, 0))
        joint = jo.Revolute(f"hinge {i}", at, body["start"], axis=(0, 0.1 * i, 1))
        rub = jo.Friction(f"rub {i}", joint, 0.1, radius=0.02, law=jo.mechanism.StickSlip())
        items += [body, joint, rub]
        at = body["end"]
    engine = jo.model.Engine(jo.compile(jo.Mechanism(*items)))
    solver = engine.native_solver("rk4", 1e-4, True)
    engine.row()
    for _ in range(30):
        engine.step(solver)
    assert engine.counts.evaluations < 30 * 60
    assert engine.work[1] > 0.0
