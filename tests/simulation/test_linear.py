"""Linearisation, modes and equilibrium against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo

G = 9.81
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)


def rod(name, angle, start=(0.0, 0.0, 0.0), length=1.2, mass=3.0):
    """A slender rod that points down at angle 0; its frame is in its centre, x along it."""
    inertia = np.diag([1e-3, mass * length**2 / 12, mass * length**2 / 12])
    turn = jo.Rotate((0, 0, 1), degrees=angle - 90.0)
    along = np.array([np.sin(np.radians(angle)), -np.cos(np.radians(angle)), 0.0])
    return jo.RigidBody(
        name,
        mass=mass,
        inertia=inertia,
        position=np.asarray(start) + 0.5 * length * along,
        orientation=turn,
        markers={"start": (-length / 2, 0, 0), "end": (length / 2, 0, 0)},
    )


def pendulum(angle):
    arm = rod("arm", angle)
    return jo.compile(
        jo.Mechanism(
            arm,
            jo.Revolute("pin", jo.ground["origin"], arm["start"], axis=(0, 0, 1)),
            jo.Gravity((0, -G, 0)),
            jo.PositionSensor("tip", arm["end"]),
        )
    )


def test_hanging_rod_swings_with_its_closed_form():
    found = jo.modes(pendulum(0.0))
    np.testing.assert_allclose(found.frequencies, np.sqrt(1.5 * G / 1.2) / (2 * np.pi), rtol=1e-12)
    # its tip moves across, nothing moves more
    assert np.abs(found.shapes["arm"]).max() == pytest.approx(1.0)


def test_upright_rod_falls_with_its_closed_form():
    values = jo.simulation.linearise(pendulum(180.0)).eigenvalues
    rate = np.sqrt(1.5 * G / 1.2)
    np.testing.assert_allclose(np.sort(values.real), [-rate, rate], rtol=1e-10)


def test_output_matrix_is_the_slope_of_the_sensor():
    linear = jo.simulation.linearise(pendulum(0.0), outputs=["tip"])
    assert linear.output_names == ("tip.x", "tip.y", "tip.z")
    # the tip moves 1.2 m per rad, and with it the centre 0.6 m: N = (0.6, 1) / |..|
    np.testing.assert_allclose(np.abs(linear.C[:, 0]), [1.2 / np.hypot(0.6, 1.0), 0, 0], atol=1e-12)
    with pytest.raises(jo.InputError, match="no sensor 'tap'"):
        jo.simulation.linearise(pendulum(0.0), outputs=["tap"])


def test_double_pendulum_has_its_closed_form_frequencies():
    upper, lower = rod("upper", 0.0), rod("lower", 0.0, start=(0, -1.2, 0))
    model = jo.compile(
        jo.Mechanism(
            upper,
            lower,
            jo.Revolute("pin", jo.ground["origin"], upper["start"], axis=(0, 0, 1)),
            jo.Revolute("knee", upper["end"], lower["start"], axis=(0, 0, 1)),
            jo.Gravity((0, -G, 0)),
        )
    )
    # M = m L^2 [[4/3, 1/2], [1/2, 1/3]], K = m g L diag(3/2, 1/2)
    M = 1.2 * np.array([[4 / 3, 1 / 2], [1 / 2, 1 / 3]])
    squares = np.linalg.eigvals(np.linalg.solve(M, G * np.diag([1.5, 0.5])))
    expected = np.sort(np.sqrt(squares)) / (2 * np.pi)
    np.testing.assert_allclose(jo.modes(model).frequencies, expected, rtol=1e-10)
    damped = jo.modes(model, damped=True)
    np.testing.assert_allclose(damped.frequencies, expected, rtol=1e-8)
    np.testing.assert_allclose(damped.damping, 0.0, atol=1e-8)


@pytest.mark.parametrize("angle", [5.0, 90.0, 170.0])
def test_a_pendulum_rests_hanging(angle):
    model = pendulum(angle)
    state = jo.equilibrium(model)
    np.testing.assert_allclose(state.q[:3], [0.0, -0.6, 0.0], atol=1e-8)
    frequency = jo.modes(model, state).frequencies
    np.testing.assert_allclose(frequency, np.sqrt(1.5 * G / 1.2) / (2 * np.pi), rtol=1e-9)


def test_a_hinged_blade_on_a_turning_hub_flaps_with_its_closed_form():
    # centrifugal stiffening (Johnson, Helicopter Theory, 1980): Omega sqrt(1 + 3 e / (2 L))
    length, offset, spin = 1.2, 0.4, 7.0
    hub = jo.RigidBody(
        "hub", 10.0, (1e9, 1e9, 1e9), angular_velocity=(0, 0, spin), markers={"arm": (offset, 0, 0)}
    )
    blade = jo.RigidBody(
        "blade",
        3.0,
        (1e-9, 3.0 * length**2 / 12, 3.0 * length**2 / 12),
        position=(offset + length / 2, 0, 0),
        velocity=(0, spin * (offset + length / 2), 0),
        angular_velocity=(0, 0, spin),
        markers={"root": (-length / 2, 0, 0)},
    )
    model = jo.compile(
        jo.Mechanism(
            hub,
            blade,
            jo.Revolute("shaft", jo.ground["origin"], hub["origin"], axis=(0, 0, 1)),
            jo.Revolute("flap", hub["arm"], blade["root"], axis=(0, 1, 0)),
        )
    )
    found = jo.modes(model, damped=True)
    expected = spin * np.sqrt(1 + 1.5 * offset / length)
    assert found.frequencies.max() == pytest.approx(expected / (2 * np.pi), rel=1e-7)
    assert np.abs(found.eigenvalues.real).max() < 1e-6


def test_a_conical_pendulum_nods_with_its_closed_form():
    # theta'' = Omega^2 sin cos - g/l sin at constant momentum: Omega sqrt(1 + 3 cos^2 theta) for a
    # thin rod too, with l = 2 L / 3 and Omega^2 = g / (l cos theta)
    length, mass, theta = 1.2, 3.0, np.radians(40.0)
    spin = np.sqrt(G / (2 * length / 3 * np.cos(theta)))
    along = np.array([np.sin(theta), -np.cos(theta), 0.0])
    arm = jo.RigidBody(
        "arm",
        mass,
        (1e-6, mass * length**2 / 12, mass * length**2 / 12),
        position=0.5 * length * along,
        orientation=jo.Rotate((0, 0, 1), degrees=40.0 - 90.0),
        velocity=(0, 0, -0.5 * length * np.sin(theta) * spin),
        angular_velocity=(0, spin, 0),
        markers={"start": (-length / 2, 0, 0)},
    )
    model = jo.compile(
        jo.Mechanism(
            arm,
            jo.Spherical("pivot", jo.ground["origin"], arm["start"]),
            jo.Gravity((0, -G, 0)),
        )
    )
    values = jo.modes(model, damped=True).eigenvalues
    expected = 1j * spin * np.sqrt(1 + 3 * np.cos(theta) ** 2)
    assert np.abs(values - expected).min() < 1e-4 * spin


def test_a_falling_body_has_no_equilibrium():
    with pytest.warns(jo.JoustoWarning, match="moves freely"):
        model = jo.compile(jo.Mechanism(rod("stone", 0.0), jo.Gravity((0, -G, 0))))
    with pytest.raises(jo.SimulationError, match="a force acts on body 'stone'"):
        jo.equilibrium(model)


def test_clamped_beam_sags_and_vibrates_as_theory_says():
    length, side = 2.0, 0.04
    part = jo.Part.beam(length, jo.Rectangle(side, side), 8, STEEL)
    beam = jo.FlexibleBody(
        "beam", jo.reduce(part, jo.CraigBampton(interfaces=("start",), modes=12))
    )
    model = jo.compile(
        jo.Mechanism(
            beam,
            jo.Fixed("wall", jo.ground["origin"], beam["start"]),
            jo.Gravity((0, -G, 0)),
            jo.PositionSensor("tip", beam["end"]),
        )
    )
    state = jo.equilibrium(model)
    engine = jo.model.Engine(model)
    engine.q[:] = state.q
    engine.v[:] = 0.0
    engine.accelerations()
    bending = STEEL.E * side**4 / 12
    line = STEEL.rho * side**2
    # w L^4 / (8 E I); the shear part and the missing higher modes are some 1e-3 of it
    assert engine.sensors()[1] == pytest.approx(-line * G * length**4 / (8 * bending), rel=2e-3)
    # Blevins (1979), table 8-1; shear lowers it by about (h / L)^2
    first = (1.87510407 / length) ** 2 * np.sqrt(bending / line) / (2 * np.pi)
    np.testing.assert_allclose(jo.modes(model, state).frequencies[:2], first, rtol=2e-3)


def test_a_run_from_the_rest_position_stays_there():
    model = pendulum(30.0)
    state = jo.equilibrium(model)
    run = jo.simulate(model, 0.2, solver=jo.RK4(1e-2), state=state)
    np.testing.assert_allclose(run["tip"], [[0.0, -1.2, 0.0]] * len(run.time), atol=1e-7)
    with pytest.raises(jo.InputError, match="state has 3 positions"):
        jo.simulate(model, 0.2, state=jo.simulation.State(np.zeros(3), np.zeros(6), np.zeros(5)))
