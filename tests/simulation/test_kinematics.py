"""Fully driven mechanisms against the closed form of the slider-crank (any text on machines)."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo

R, L = 0.2, 0.7  # m, crank and rod
CRANK, ROD, SLIDER = 1.5, 2.0, 0.8  # kg
I_CRANK, I_ROD = 0.03, 0.09  # kg m2, crank about its pin, rod about its centre
TIMES = np.linspace(0.0, 1.5, 31)


def slider_crank(signal, driven=True):
    """Crank about z in the origin, slider along x; at angle 0 all lie on x. No repeated rows."""
    crank = jo.RigidBody("crank", CRANK, (0.01, 0.02, I_CRANK), markers={"end": (R, 0, 0)})
    rod = jo.RigidBody(
        "rod",
        ROD,
        (0.01, I_ROD, I_ROD),
        position=(R + L / 2, 0, 0),
        markers={"start": (-L / 2, 0, 0), "end": (L / 2, 0, 0)},
    )
    slider = jo.RigidBody("slider", SLIDER, (0.01, 0.01, 0.01), position=(R + L, 0, 0))
    shaft = jo.Revolute("shaft", jo.ground["origin"], crank["origin"], axis=(0, 0, 1))
    wrist = jo.Spherical("wrist", rod["end"], slider["origin"])
    parts = [
        crank,
        rod,
        slider,
        shaft,
        jo.Universal("knee", crank["end"], rod["start"], (0, 0, 1), (0, 1, 0)),
        wrist,
        jo.Prismatic("guide", jo.ground.at((R + L, 0, 0)), slider["origin"], axis=(1, 0, 0)),
        jo.ReactionSensor("push", wrist),
    ]
    if driven:
        parts.append(jo.Drive("motor", shaft.angle, signal))
    return jo.compile(jo.Mechanism(*parts, name="slider-crank"))


def closed_form(angle):
    """Slider x, rod angle, rod centre as functions of the crank angle, also complex."""
    tilt = -np.arcsin(R / L * np.sin(angle))
    x = R * np.cos(angle) + L * np.cos(tilt)
    center = R * np.cos(angle) + L / 2 * np.cos(tilt), R * np.sin(angle) + L / 2 * np.sin(tilt)
    return x, tilt, *center


def inertia(angle):
    """Return M with kinetic energy M w^2 / 2; slopes by hand, so that it may be complex."""
    s, c = np.sin(angle), np.cos(angle)
    root = np.sqrt(1 - (R / L * s) ** 2)
    tilt = -R / L * c / root  # d tilt / d angle
    sine = -R / L * s  # of the tilt
    x = -R * s - L * sine * tilt
    cx, cy = -R * s - L / 2 * sine * tilt, R * c + L / 2 * root * tilt
    return I_CRANK + SLIDER * x**2 + ROD * (cx**2 + cy**2) + I_ROD * tilt**2


def slope(function, angle):
    return np.imag(function(angle + 1e-30j)) / 1e-30


@pytest.fixture(scope="module")
def signal():
    return jo.SCurve([0.0, 0.6, 1.5], [0.0, 2.0, 15.0])  # more than two turns


@pytest.fixture(scope="module")
def found(signal):
    return jo.simulation.kinematics(slider_crank(signal), TIMES)


def test_positions_and_velocities(found, signal):
    angle, rate = signal(TIMES), signal.rate(TIMES)
    x, tilt, cx, cy = closed_form(angle)
    q, v = found.q, found.v
    np.testing.assert_allclose(found.time, TIMES, rtol=0, atol=0)
    np.testing.assert_allclose(q[:, 14], x, atol=1e-10)
    np.testing.assert_allclose(q[:, 7:9], np.stack([cx, cy], axis=1), atol=1e-10)
    np.testing.assert_allclose(2 * np.arctan2(q[:, 13], q[:, 10]) % np.pi, tilt % np.pi, atol=1e-9)
    np.testing.assert_allclose(v[:, 5], rate, atol=1e-8)
    np.testing.assert_allclose(
        v[:, 11], rate * slope(lambda a: closed_form(a)[1], angle), atol=1e-8
    )
    np.testing.assert_allclose(
        v[:, 12], rate * slope(lambda a: closed_form(a)[0], angle), atol=1e-8
    )
    assert found.complete
    assert found.residuals.position.max() < 1e-10
    assert np.isnan(found.energy.work).all()


def test_the_pin_accelerates_the_slider(found, signal):
    """Without friction and gravity its force along x is m x'', x'' = x_aa w^2 + x_a alpha."""
    angle, w, alpha = signal(TIMES), signal.rate(TIMES), signal.acceleration(TIMES)
    root = np.sqrt(L**2 - (R * np.sin(angle)) ** 2)
    s, c = np.sin(angle), np.cos(angle)
    first = -R * s - R**2 * s * c / root
    second = -R * c - R**2 * (c**2 - s**2) / root - R**4 * (s * c) ** 2 / root**3
    force = SLIDER * (second * w**2 + first * alpha)
    np.testing.assert_allclose(found["push"][:, 0], force, atol=1e-8 * np.abs(force).max())


def test_the_motor_gives_the_closed_form_torque(signal):
    """T = M alpha + M' w^2 / 2 (Lagrange, one coordinate)."""
    model = slider_crank(signal)
    angle, w, alpha = signal(TIMES), signal.rate(TIMES), signal.acceleration(TIMES)
    torque = inertia(angle) * alpha + 0.5 * slope(inertia, angle) * w**2
    (row,) = (joint.row for joint in model.joints if joint.name == "motor")
    found = -jo.simulation.inverse_dynamics(model, TIMES).multipliers[:, row]
    np.testing.assert_allclose(found, torque, atol=1e-8 * np.abs(torque).max())


def test_instants_may_be_turns_apart_and_start_anywhere(signal):
    found = jo.simulation.kinematics(slider_crank(signal), [0.9, 1.5])
    np.testing.assert_allclose(found.q[:, 14], closed_form(signal([0.9, 1.5]))[0], atol=1e-10)


def test_free_motions_are_counted(signal):
    with pytest.raises(
        jo.InputError, match="has 1 motion without a drive at the initial pose.*add a"
    ):
        jo.simulation.kinematics(slider_crank(signal, driven=False), TIMES)
    with pytest.raises(jo.InputError, match="has no drive"):
        jo.simulation.inverse_dynamics(slider_crank(signal, driven=False), TIMES)


E, RHO, LENGTH, WIDTH, HEIGHT = 2.1e11, 7850.0, 2.0, 0.05, 0.02  # steel strip, bends about z


@pytest.fixture(scope="module")
def strip():
    part = jo.Part.beam(
        length=LENGTH,
        section=jo.Rectangle(HEIGHT, WIDTH),
        elements=8,
        material=jo.Material(E=E, nu=0.3, rho=RHO),
        theory=jo.parts.EulerBernoulli(),
    )
    return jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=8))


def arm(strip, signal, *items, damping=0.0):
    body = jo.FlexibleBody("arm", strip, damping=damping)
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["start"], axis=(0, 0, 1))
    motor = jo.Drive("motor", hinge.angle, signal)
    sensors = jo.PositionSensor("tip", body["end"]), jo.ReactionSensor("torque", motor)
    return jo.compile(jo.Mechanism(body, hinge, motor, *sensors, *items))


def test_a_spinning_rod_is_stretched_as_by_its_own_weight(strip):
    """E u'' = -rho Omega^2 (x + u): u(L) = tan(k L) / k - L, k^2 = rho Omega^2 / E; no torque."""
    speed = 20.0
    k = speed * np.sqrt(RHO / E)
    found = jo.simulation.inverse_dynamics(arm(strip, jo.Ramp(0, 9, 0, 9 * speed)), [0.5, 1.0])
    stretch = np.linalg.norm(found["tip"], axis=1) - LENGTH
    np.testing.assert_allclose(stretch, np.tan(k * LENGTH) / k - LENGTH, rtol=1e-5)  # 14 modes
    np.testing.assert_allclose(found["torque"], 0.0, atol=1e-8)


def test_a_held_arm_sags_and_its_motor_carries_it(strip):
    """w L^4 / (8 E I) by the linear theory, torque of the weight at half the length."""
    found = jo.simulation.inverse_dynamics(
        arm(strip, jo.Constant(0.0), jo.Gravity((0, -9.81, 0))), [1.0]
    )
    weight, inertia = 9.81 * RHO * WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12
    # the arm turns with its root, so that the lever shortens by the square of the sag: 1e-4
    np.testing.assert_allclose(
        found["tip"][0, 1], -weight * LENGTH**4 / (8 * E * inertia), rtol=2e-4
    )
    np.testing.assert_allclose(found["torque"], weight * LENGTH**2 / 2, rtol=1e-4)


def test_joints_that_bend_a_body_bend_it(strip):
    """Clamped at both ends: w L^4 / (384 E I) in the middle, with modes that joints constrain."""
    body = jo.FlexibleBody("arm", strip)
    model = jo.compile(
        jo.Mechanism(
            body,
            jo.Fixed("left", jo.ground["origin"], body["start"]),
            jo.Fixed("right", jo.ground.at((LENGTH, 0, 0)), body["end"]),
            jo.Gravity((0, -9.81, 0)),
            jo.PositionSensor("middle", body["node5"]),
        )
    )
    found = jo.simulation.kinematics(model, [1.0])
    weight, inertia = 9.81 * RHO * WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12
    # consistent loads of two elements per eighth, eight modes: 2e-4
    np.testing.assert_allclose(
        found["middle"][0, 1], -weight * LENGTH**4 / (384 * E * inertia), rtol=5e-4
    )


def test_slow_motion_needs_the_torque_of_the_simulation(strip):
    """A turn by 1 rad in 4 s, lowest mode 4 Hz; the simulation starts at rest and is damped."""
    model = arm(strip, jo.SCurve([0.0, 4.0], [0.0, 1.0]), jo.Gravity((0, -9.81, 0)), damping=0.02)
    rest = jo.equilibrium(model)
    run = jo.simulate(model, 4.0, solver=jo.ROS2(step=5e-4), output_step=0.1, state=rest)
    found = jo.simulation.inverse_dynamics(model, run.time)
    np.testing.assert_allclose(found["torque"], run["torque"], atol=0.006 * found["torque"].max())
    np.testing.assert_allclose(found["tip"], run["tip"], atol=2e-4)
    assert np.abs(found["torque"] - found["torque"][0]).max() > 1.0  # the motion matters


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
def test_a_motion_faster_than_the_modes_is_refused(strip):
    model = arm(strip, jo.Harmonic(frequency=20.0, amplitude=0.5), jo.Gravity((0, -9.81, 0)))
    with pytest.raises(jo.SimulationError, match="too soft for a quasi-static shape"):
        jo.simulation.kinematics(model, np.linspace(0, 0.1, 3))


def test_times_must_increase(signal):
    with pytest.raises(jo.InputError, match=r"must increase, but 1 s is followed by 0\.5 s"):
        jo.simulation.kinematics(slider_crank(signal), [0.0, 1.0, 0.5])


def test_a_drive_out_of_reach_is_named_with_its_time(tmp_path):
    """Two rods of 1 m whose ends are drawn apart at 1 m/s from a distance of 1 m: taut at 1 s."""
    one = jo.RigidBody("one", 1.0, (0.1, 0.1, 0.1), markers={"end": (0.5, np.sqrt(0.75), 0)})
    two = jo.RigidBody("two", 1.0, (0.1, 0.1, 0.1), position=(1.0, 0, 0))
    model = jo.compile(
        jo.Mechanism(
            one,
            two,
            jo.Revolute("pin", jo.ground["origin"], one["origin"], axis=(0, 0, 1)),
            slide := jo.Prismatic("slide", jo.ground.at((1, 0, 0)), two["origin"], axis=(1, 0, 0)),
            jo.Rod("rod", one["end"], two["origin"]),
            jo.Drive("pull", slide.displacement, jo.Ramp(0, 2, 0, 2)),
        )
    )
    target = tmp_path / "taut.h5"
    with pytest.raises(jo.SimulationError, match="cannot follow its drives past (1|0.99999)"):
        jo.simulation.kinematics(model, np.linspace(0, 2, 11), path=target)
    kept = jo.load(target)
    assert not kept.complete
    assert kept.nt in (5, 6)
