"""A driven planar four-bar against the closed form of its kinematics and of its drive torque.

Freudenstein, "Approximate synthesis of four-bar linkages", Transactions of the ASME 77 (1955)
853-861: with bars a (crank), b (coupler), c (rocker) and d (ground),
``K1 cos(psi) - K2 cos(phi) + K3 = cos(phi - psi)``, K1 = d/a, K2 = d/c,
K3 = (a^2 - b^2 + c^2 + d^2)/(2 a c). The velocity and acceleration loops are linear in the rates of
coupler and rocker; the torque follows from d'Alembert's principle: the power of the drive is that
of the inertia forces less that of gravity.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification.mechanisms import march

CRANK, COUPLER, ROCKER, GROUND = 0.25, 0.8, 0.7, 0.9  # m
MASS = np.array([2.0, 3.5, 2.8])  # kg
INERTIA = np.array([0.02, 0.15, 0.12])  # kg m2, about the centre, across the plane
CENTRE = np.array([[0.1, 0.02], [0.35, -0.05], [0.4, 0.03]])  # m, from the first joint of the bar
G = np.array([0.0, -9.81])
START, RATE, BEND = np.radians(70.0), 9.0, 14.0  # of the crank: rad, rad/s, rad/s2
TIMES = np.linspace(0.0, 0.9, 19)  # two and a half turns

# -- closed form -----------------------------------------------------------------------------------


def ray(angle, length=1.0):
    return length * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def across(x):
    """z cross x."""
    return np.stack([-x[..., 1], x[..., 0]], axis=-1)


def angles(phi):
    """Angles (3,) of crank, coupler and rocker, the coupler above the line between the feet."""
    K1, K2 = GROUND / CRANK, GROUND / ROCKER
    K3 = (CRANK**2 - COUPLER**2 + ROCKER**2 + GROUND**2) / (2 * CRANK * ROCKER)
    # in t = tan(psi/2): A t^2 + B t + C = 0
    A = np.cos(phi) - K1 - K2 * np.cos(phi) + K3
    B = -2 * np.sin(phi)
    C = K1 - (K2 + 1) * np.cos(phi) + K3
    psi = 2 * np.arctan2(-B - np.sqrt(B**2 - 4 * A * C), 2 * A)
    if np.sin(psi) < 0:
        psi = 2 * np.arctan2(-B + np.sqrt(B**2 - 4 * A * C), 2 * A)
    bar = np.array([GROUND, 0.0]) + ray(psi, ROCKER) - ray(phi, CRANK)
    return np.array([phi, np.arctan2(bar[1], bar[0]), psi])


def motion(phi, rate, bend):
    """Angles, rates and accelerations (3,) each from those of the crank.

    ``b w3 z x e3 - c w4 z x e4 = -a w2 z x e2`` and its derivative.
    """
    angle = angles(phi)
    e = ray(angle, np.array([CRANK, COUPLER, ROCKER])[:, None])
    n = across(e)
    loop = np.stack([n[1], -n[2]], axis=-1)
    w = np.array([rate, *np.linalg.solve(loop, -rate * n[0])])
    right = -bend * n[0] + w[0] ** 2 * e[0] + w[1] ** 2 * e[1] - w[2] ** 2 * e[2]
    return angle, w, np.array([bend, *np.linalg.solve(loop, right)])


def torque(phi, rate, bend):
    """Torque of the drive on the crank: ``T w2 = sum m (a - g).v + J w' w``."""
    angle, w, alpha = motion(phi, rate, bend)
    first = np.array([[0.0, 0.0], ray(phi, CRANK), [GROUND, 0.0]])
    pin = across(first[1] - first[0])
    v0 = np.array([[0.0, 0.0], w[0] * pin, [0.0, 0.0]])
    a0 = np.array([[0.0, 0.0], bend * pin - w[0] ** 2 * (first[1] - first[0]), [0.0, 0.0]])
    power = 0.0
    for k in range(3):
        x, y = CENTRE[k]
        arm = x * ray(angle[k]) + y * across(ray(angle[k]))
        v = v0[k] + w[k] * across(arm)
        a = a0[k] + alpha[k] * across(arm) - w[k] ** 2 * arm
        power += MASS[k] * (a - G) @ v + INERTIA[k] * alpha[k] * w[k]
    return power / w[0]


# -- the same in space -----------------------------------------------------------------------------


def four_bar(*, repeated=False):
    """Three rigid bars, the crank driven by ``RATE t + BEND t^2 / 2``."""
    z = (0.0, 0.0, 1.0)
    angle, w, _ = motion(START, RATE, BEND)
    first = np.array([[0.0, 0.0], ray(START, CRANK), [GROUND, 0.0]])
    lengths = (CRANK, COUPLER, ROCKER)
    v0 = np.array([[0.0, 0.0], RATE * across(first[1]), [0.0, 0.0]])
    bars = [
        jo.RigidBody(
            name,
            MASS[k],
            (0.7 * INERTIA[k], 0.6 * INERTIA[k], INERTIA[k]),
            center=(*CENTRE[k], 0.0),
            markers={"start": (0, 0, 0), "end": (lengths[k], 0, 0)},
            position=(*first[k], 0.0),
            orientation=jo.Rotate(z, degrees=np.degrees(angle[k])),
            velocity=(*v0[k], 0.0),
            angular_velocity=(0.0, 0.0, w[k]),
        )
        for k, name in enumerate(("crank", "coupler", "rocker"))
    ]
    crank, coupler, rocker = bars
    inner = (jo.Revolute, jo.Revolute) if repeated else (jo.Spherical, jo.Universal)
    pivot = jo.Revolute("pivot", jo.ground["origin"], crank["start"], z)
    pin = inner[0]("pin", crank["end"], coupler["start"], *([z] if repeated else []))
    axes = [z] if repeated else [z, (1.0, 0.0, 0.0)]
    knee = inner[1]("knee", coupler["end"], rocker["end"], *axes)
    foot = jo.Revolute("foot", jo.ground.at((GROUND, 0, 0)), rocker["start"], z)
    t = jo.Ramp(0.0, 10.0, 0.0, 10.0)
    drive = jo.Drive("drive", pivot.angle, RATE * t + 0.5 * BEND * (t * t))
    sensors = [jo.CoordinateSensor("crank", pivot.angle), jo.CoordinateSensor("rocker", foot.angle)]
    return jo.Mechanism(*bars, pivot, pin, knee, foot, drive, *sensors, jo.Gravity((*G, 0.0)))


@pytest.fixture(scope="module", params=[False, True], ids=["18 rows", "21 rows"])
def model(request):
    if not request.param:
        return jo.compile(four_bar())
    with pytest.warns(jo.JoustoWarning, match="3 of the constraint rows.*the motion is right"):
        return jo.compile(four_bar(repeated=True))


def closed_form(times):
    """Angles, rates, accelerations (nt, 3) and torque (nt,)."""
    states = [(START + RATE * t + 0.5 * BEND * t**2, RATE + BEND * t) for t in times]
    angle, w, alpha = np.swapaxes([motion(phi, rate, BEND) for phi, rate in states], 0, 1)
    return np.unwrap(angle, axis=0), w, alpha, np.array([torque(*s, BEND) for s in states])


def drive_torque(model, multipliers):
    row = next(joint.row for joint in model.joints if joint.name == "drive")
    return -multipliers[:, row]


def test_the_closed_form_is_consistent():
    # rates and accelerations against differences of the angles, torque against the energy
    h = 1e-4
    phi = START + 0.3
    angle = [motion(phi + k * RATE * h + 0.5 * BEND * h**2 * k**2, 0, 0)[0] for k in (-1, 0, 1)]
    _, w, alpha = motion(phi, RATE, BEND)
    np.testing.assert_allclose((angle[2] - angle[0]) / (2 * h), w, rtol=1e-6)
    np.testing.assert_allclose((angle[2] - 2 * angle[1] + angle[0]) / h**2, alpha, rtol=1e-4)


def test_kinematics_is_freudenstein_s(model):
    angle, w, alpha, _ = closed_form(TIMES)
    run = jo.simulation.kinematics(model, TIMES)
    assert angle[-1, 0] - angle[0, 0] > 4 * np.pi
    np.testing.assert_allclose(run["crank"][:, 0], angle[:, 0] - angle[0, 0], atol=1e-12)
    np.testing.assert_allclose(run["rocker"][:, 0], angle[:, 2] - angle[0, 2], atol=1e-12)
    engine = jo.model.Engine(model)
    for k, t in enumerate(TIMES):
        engine.time[0], engine.q[:], engine.v[:] = t, run.q[k], run.v[k]
        a = engine.accelerations()[0]
        np.testing.assert_allclose(engine.v[5::6], w[k], rtol=1e-11)
        np.testing.assert_allclose(a[5::6], alpha[k], rtol=0, atol=1e-9 * np.abs(alpha).max())


def test_the_drive_does_the_work_of_inertia_and_gravity(model):
    expected = closed_form(TIMES)[3]
    run = jo.simulation.inverse_dynamics(model, TIMES)
    found = drive_torque(model, run.multipliers)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * np.abs(expected).max())


def test_integration_follows_the_same_motion(model):
    run = march(model, jo.RK4(step=1e-3), 0.9, 0.05)
    angle, w, _, expected = closed_form(run.time)
    np.testing.assert_allclose(run.sensors["rocker"][:, 0], angle[:, 2] - angle[0, 2], atol=1e-9)
    np.testing.assert_allclose(run.v[:, 5::6], w, rtol=0, atol=1e-8 * np.abs(w).max())
    found = drive_torque(model, run.lam)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-7 * np.abs(expected).max())
    # the work of the drive is in the balance
    assert np.abs(run.balance).max() < 1e-7 * np.ptp(run.energy[:, 6])
