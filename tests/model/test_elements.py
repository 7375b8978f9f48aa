"""Force elements and sensors as declared, in the engine: closed forms, equivalents, energy."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism.forces.springs import Bushing, JointForce, ModalLoad, Servo, Spring, UserForce
from jousto.mechanism.joints import coupling as c
from jousto.mechanism.joints.coordinate import Angle, Displacement
from jousto.mechanism.joints.hinges import Revolute
from jousto.mechanism.joints.slides import Prismatic
from jousto.mechanism.sensors.scalar import (
    CoordinateSensor,
    EnergySensor,
    RateSensor,
    SignalSensor,
)
from jousto.mechanism.signals.base import Constant, Input
from jousto.mechanism.signals.harmonic import Harmonic
from jousto.mechanism.signals.piecewise import Ramp, Table
from verification.mechanisms import rod

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*nothing will move")

INERTIA = 0.4


def body(name, position=(0, 0, 0), **more):
    """Return a rigid body whose centre of mass is its origin."""
    return jo.RigidBody(name, 2.0, (0.3, 0.35, INERTIA), position=position, **more)


def slider():
    """Return a mass of 2 kg on a slide along x."""
    block = body("block")
    return block, Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))


def wheel():
    """Return an inertia of 0.4 kg m2 about z on a hinge."""
    disc = body("disc")
    return disc, Revolute("hinge", jo.ground["origin"], disc["origin"])


def start(*items):
    """Return the engine and its first accelerations."""
    engine = jo.model.Engine(jo.compile(jo.Mechanism(*items)))
    return engine, engine.accelerations()[0].copy()


def test_a_spring_and_damper_oscillates_as_the_closed_form():
    """s = free + e^(-d t) (x0 cos w t + d x0 / w sin w t), d = c / 2m, w^2 = k/m - d^2."""
    block, slide = slider()
    k, damping, free, preload = 50.0, 0.8, -0.1, 2.0
    items = (
        Spring("spring", slide.displacement, k, damping, free=free, preload=preload),
        CoordinateSensor("s", slide.displacement),
        RateSensor("rate", slide.displacement),
    )
    run = jo.simulate(
        jo.compile(jo.Mechanism(block, slide, *items)), t_end=4.0, solver=jo.RK4(step=2e-3)
    )
    rest, decay = free + preload / k, damping / 4.0
    w = np.sqrt(k / 2.0 - decay**2)
    t = run.time
    fade = -rest * np.exp(-decay * t)
    s = rest + fade * (np.cos(w * t) + decay / w * np.sin(w * t))
    rate = -fade * (decay**2 / w + w) * np.sin(w * t)
    np.testing.assert_allclose(np.ravel(run["s"]), s, atol=1e-9)
    np.testing.assert_allclose(np.ravel(run["rate"]), rate, atol=1e-8)


def test_tables_take_the_coordinate_and_its_rate():
    straight = Table((-1.0, 1.0), (30.0, -30.0))
    block = body("block", velocity=(0.5, 0, 0))
    slide = Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    spring = Spring("spring", slide.displacement, table=straight, damper_table=straight)
    engine, _ = start(block, slide, spring)
    engine.q[0] += 0.2
    a, _ = engine.accelerations()
    assert a[0] == pytest.approx(-30.0 * (0.2 + 0.5) / 2.0, rel=1e-12)


def test_a_torsional_spring_turns_back_over_many_turns():
    disc = body("disc", angular_velocity=(0, 0, 10.0))
    hinge = Revolute("hinge", jo.ground["origin"], disc["origin"])
    spring = Spring("spring", hinge.angle, 0.1)
    model = jo.compile(jo.Mechanism(disc, hinge, spring, CoordinateSensor("turn", hinge.angle)))
    run = jo.simulate(model, t_end=6.0, solver=jo.RK4(step=1e-2))
    w = np.sqrt(0.1 / INERTIA)
    np.testing.assert_allclose(np.ravel(run["turn"]), 10.0 / w * np.sin(w * run.time), atol=1e-7)
    assert run["turn"].max() > 6 * np.pi


def test_a_bushing_is_three_springs_along_axes_and_one_about_them():
    """For a turn about one axis the rotation vector is the angle."""
    K = (900.0, 700.0, 500.0, 0.0, 0.0, 40.0)

    def pair():
        one = body("one", velocity=(0.1, 0.2, 0.3), angular_velocity=(0, 0, 0.7))
        two = body("two", (0.6, 0.3, 0.2), orientation=jo.Rotate((0, 0, 1), degrees=20.0))
        return one, two, one.at((0.2, 0.1, 0.0)), two.at((-0.3, 0.0, 0.1))

    one, two, a, b = pair()
    D = 0.02 * np.array(K)
    _, whole = start(one, two, Bushing("bushing", a, b, K, D))
    one, two, a, b = pair()
    springs = [
        Spring(f"spring {axis}", Displacement(a, b, axis), k, 0.02 * k, free=0.0)
        for axis, k in zip("xyz", K[:3], strict=True)
    ]
    turn = Spring("turn", Angle(a, b), K[5], 0.02 * K[5], free=0.0)
    _, apart = start(one, two, *springs, turn)
    assert np.abs(whole).max() > 10.0
    np.testing.assert_allclose(whole, apart, atol=1e-11 * np.abs(whole).max())


def test_the_preload_of_a_bushing_acts_on_b_in_the_axes_of_a():
    one = body("one", orientation=jo.Rotate((0, 0, 1), degrees=90.0))
    two = body("two")
    preload = (4.0, 0.0, 0.0, 0.0, 0.0, 2.0)
    _, a = start(one, two, Bushing("b", one["origin"], two["origin"], 0.0, preload=preload))
    np.testing.assert_allclose(a[6:9], (0.0, 2.0, 0.0), atol=1e-14)
    assert a[11] == pytest.approx(2.0 / INERTIA, rel=1e-12)
    np.testing.assert_allclose(a[:3], (0.0, -2.0, 0.0), atol=1e-14)


@pytest.mark.parametrize(("reference", "torque"), [(0.1, 3.0 + 2.0), (0.5, 8.0), (-0.5, -8.0)])
def test_a_servo_pushes_with_its_gains_up_to_its_limit(reference, torque):
    """kp (ref - s) + kd (ref' - s') = 30 ref + 2, at most 8 N m."""
    disc, hinge = wheel()
    wanted = Ramp(-1.0, 1.0, reference - 4.0, reference + 4.0)  # 4 rad/s
    servo = Servo("servo", hinge.angle, wanted, kp=30.0, kd=0.5, limit=8.0)
    _, a = start(disc, hinge, servo)
    assert a[5] == pytest.approx(torque / INERTIA, rel=1e-12)


def test_a_servo_without_limit_holds_a_constant():
    disc, hinge = wheel()
    servo = Servo("servo", hinge.angle, 1.0, kp=40.0, kd=8.0)
    model = jo.compile(jo.Mechanism(disc, hinge, servo, CoordinateSensor("turn", hinge.angle)))
    run = jo.simulate(model, t_end=3.0, solver=jo.RK4(step=2e-3))
    w = 10.0  # kp = I w^2, kd = 2 I w: critical
    exact = 1.0 - (1.0 + w * run.time) * np.exp(-w * run.time)
    np.testing.assert_allclose(np.ravel(run["turn"]), exact, atol=1e-7)


def test_a_joint_force_is_an_actuator_with_an_input():
    disc, hinge = wheel()
    torque = Input("u", 1.5)
    force = JointForce("motor", hinge.angle, torque + 0.5)
    engine, a = start(disc, hinge, force, SignalSensor("u", torque))
    assert a[5] == pytest.approx(2.0 / INERTIA, rel=1e-12)
    engine.input[0] = -0.5
    assert engine.accelerations()[0][5] == pytest.approx(0.0, abs=1e-14)
    assert engine.sensors()[0] == -0.5


@pytest.mark.filterwarnings("ignore:.*static work")
def test_a_modal_load_is_the_nodal_forces_that_follow():
    """Undeformed, the projected pattern and forces at the nodes give the same accelerations."""
    rng = np.random.default_rng(3)
    arm = jo.FlexibleBody("arm", rod())
    pattern = rng.normal(size=np.shape(arm.reduced.nodes)) * 50.0
    half = Constant(0.5)
    _, modal = start(arm, ModalLoad("pressure", arm, pattern, half))
    arm = jo.FlexibleBody("arm", rod())
    forces = [
        jo.Force(f"f{k}", arm[f"node{k + 1}"], pattern[k], follow=True, signal=half)
        for k in range(len(pattern))
    ]
    _, nodal = start(arm, *forces)
    assert np.abs(modal).max() > 1.0
    np.testing.assert_allclose(modal, nodal, rtol=1e-9, atol=1e-9 * np.abs(nodal).max())


def test_a_user_force_acts_at_its_marker_in_the_reference():
    one = body("one", orientation=jo.Rotate((0, 0, 1), degrees=90.0))
    two = body("two", (0.5, 0, 0))
    wind = UserForce("wind", two["origin"], lambda t, x: [4.0, 0, 0, 0, 0, 0], one["origin"])
    _, a = start(one, two, wind)
    np.testing.assert_allclose(a[6:9], (0.0, 2.0, 0.0), atol=1e-14)
    assert a[11] == pytest.approx(0.0, abs=1e-14)
    _, alone = start(two, UserForce("wind", two["origin"], lambda t, x: [4.0, 0, 0, 0, 0, 0]))
    np.testing.assert_allclose(alone[:3], (2.0, 0.0, 0.0), atol=1e-14)


def test_energy_sensors_close_the_balance():
    block, slide = slider()
    disc = body("disc", (0.4, 0.4, 0))
    hinge = Revolute("hinge", block.at((0.3, 0.4, 0)), disc.at((-0.1, 0, 0.0)))
    names = ("kinetic", "strain", "potential", "springs", "dissipated", "friction", "work")
    elements = (
        Spring("spring", slide.displacement, 80.0, 3.0, free=0.1),
        Bushing("bushing", jo.ground["origin"], disc["origin"], 20.0, 0.5),
        Servo("servo", hinge.angle, Harmonic(frequency=1.0, amplitude=0.4), 5.0, 0.3, limit=1.0),
        JointForce("push", slide.displacement, Ramp(0.0, 0.5, 0.0, 6.0)),
        UserForce("drag", disc["origin"], lambda t, x: [*(-0.4 * x[12:15]), 0, 0, 0]),
        jo.Gravity((0, -9.81, 0)),
    )
    sensors = [EnergySensor(name, name) for name in names]
    model = jo.compile(jo.Mechanism(block, slide, disc, hinge, *elements, *sensors))
    run = jo.simulate(model, t_end=1.0, solver=jo.RK4(step=2e-3))
    T, U, P, S, lost, friction, work = (np.ravel(run[name]) for name in names)
    balance = T + U + P + S + lost + friction - work
    assert min(np.ptp(T), np.ptp(S), lost[-1], abs(work[-1])) > 0.05
    assert np.ptp(balance) < 1e-5
    np.testing.assert_allclose(S, run.energy.springs)
    np.testing.assert_allclose(work, run.energy.work)


def test_couplings_and_springs_share_one_coordinate():
    """A spring along the coordinate of a drive works on the drive: -lam = I a + k s."""
    disc, hinge = wheel()
    drive = c.Drive("drive", hinge.angle, Constant(0.0))
    spring = Spring("spring", hinge.angle, 40.0, free=0.25)
    engine, a = start(disc, hinge, drive, spring)
    assert a[5] == pytest.approx(0.0, abs=1e-13)
    assert abs(engine.lam[-1]) == pytest.approx(10.0, rel=1e-12)
