"""Warning about flexible bodies that spin too fast for linear modes."""

from __future__ import annotations

import warnings

import numpy as np

import jousto as jo


def spinning(w, *, stiffening=False):
    """A free beam along x at a constant spin; its lowest frequency is 111 Hz."""
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.03), 4, jo.Material(E=210e9, nu=0.3, rho=7850))
    rod = jo.reduce(part, jo.FreeFree(modes=3), stiffening=stiffening)
    x = (-0.5, 0.0, 0.0)
    body = jo.FlexibleBody("rod", rod, angular_velocity=w, velocity=np.cross(w, x), position=x)
    pivot = jo.Spherical("pivot", jo.ground["origin"], body["node3"])
    model = jo.compile(jo.Mechanism(body, pivot))
    return model, float(np.sqrt(model.bodies[0].K.min()))


def sentences(model):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        jo.simulate(model, 2e-3, solver=jo.ROS2(step=1e-5), output_step=1e-4)
    return [str(w.message) for w in caught if "stiffening" in str(w.message)]


def test_a_slow_spin_across_the_beam_is_not_said():
    _, lowest = spinning((0, 0, 0.1))
    assert sentences(spinning((0, 0, 0.15 * lowest))[0]) == []


def test_a_fast_spin_across_the_beam_is_said_once():
    _, lowest = spinning((0, 0, 0.1))
    (found,) = sentences(spinning((0, 0, 0.25 * lowest))[0])
    assert f"'rod' spins with up to {0.25 * lowest:.3g} rad/s, 25 % of its lowest" in found
    assert "reduce its part with stiffening=True" in found


def test_a_shaft_may_turn_about_its_own_axis():
    _, lowest = spinning((0, 0, 0.1))
    assert sentences(spinning((0.5 * lowest, 0, 0))[0]) == []


def test_with_stiffening_nothing_is_said():
    _, lowest = spinning((0, 0, 0.1))
    assert sentences(spinning((0, 0, 0.5 * lowest), stiffening=True)[0]) == []
