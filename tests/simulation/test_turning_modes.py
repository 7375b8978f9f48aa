"""Modes about a motion: whirl and the particle in a turning frame, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo

pytestmark = pytest.mark.filterwarnings("ignore:.*nothing will move")


def disc(spin: float) -> jo.Model:
    """A disc on a light shaft that gives in rotation: k about x and y, polar inertia about z."""
    body = jo.RigidBody("disc", mass=3.0, inertia=(0.4, 0.4, 0.7), angular_velocity=(0, 0, spin))
    frame = jo.ground["origin"]
    return jo.compile(
        jo.Mechanism(
            body,
            jo.Spherical("bearing", frame, body["origin"]),
            jo.Bushing("shaft", frame, body["origin"], (0, 0, 0, 90.0, 90.0, 0)),
        )
    )


@pytest.mark.parametrize("spin", [5.0, 40.0])
def test_a_spinning_disc_whirls_forwards_and_backwards(spin: float) -> None:
    # in axes that stand still, J w^2 -+ Jp spin w - k = 0 (Genta, Dynamics of Rotating Systems,
    # 2005, section 2.4); the body frame turns, so that its modes are these less and plus the spin
    model = disc(spin)
    J, Jp, k = 0.4, 0.7, 90.0
    half = Jp * spin / (2.0 * J)
    root = np.sqrt(half**2 + k / J)
    forward, backward = half + root, root - half
    expected = np.sort(np.abs([forward - spin, backward + spin]))
    values = jo.modes(model, damped=True).eigenvalues
    found = np.sort(np.abs(values.imag[np.abs(values.imag) > 1e-3]))
    np.testing.assert_allclose(found, expected, rtol=1e-8)
    np.testing.assert_allclose(values.real, 0.0, atol=1e-6)


def test_modes_at_rest_of_a_spinning_disc_say_what_they_leave_out() -> None:
    with pytest.warns(jo.JoustoWarning, match=r"'disc' rotates at 40 rad/s.*damped=True") as said:
        found = jo.modes(disc(40.0))
    assert len(said) == 1
    # those of the disc that stands still: k = J w^2, twice
    np.testing.assert_allclose(found.frequencies[-2:], np.sqrt(90.0 / 0.4) / (2 * np.pi), rtol=1e-9)
    jo.modes(disc(0.0))  # without a word


def test_a_particle_on_springs_in_a_turning_frame_splits_its_frequency() -> None:
    # x'' - 2 W y' + (w0^2 - W^2) x = 0 and likewise y: w = w0 +- W (Foucault)
    W, k, m = 3.0, 200.0, 2.0
    table = jo.RigidBody("table", mass=50.0, inertia=(9, 9, 9), angular_velocity=(0, 0, W))
    bob = jo.RigidBody("bob", mass=m, inertia=(1e-3, 1e-3, 1e-3), angular_velocity=(0, 0, W))
    model = jo.compile(
        jo.Mechanism(
            table,
            bob,
            jo.Revolute("axle", jo.ground["origin"], table["origin"], axis=(0, 0, 1)),
            jo.Drive(
                "motor",
                jo.Angle(jo.ground["origin"], table["origin"]),
                jo.Ramp(-1.0, 9.0, -W, 9.0 * W),
            ),
            jo.Planar("floor", table["origin"], bob["origin"], normal=(0, 0, 1)),
            jo.Bushing("springs", table["origin"], bob["origin"], (k, k, 0, 0, 0, 1e3)),
        )
    )
    values = jo.modes(model, damped=True).eigenvalues
    w0 = np.sqrt(k / m)
    found = np.sort(values.imag)[:2]
    np.testing.assert_allclose(found, [w0 - W, w0 + W], rtol=1e-8)
