"""Warnings of beams before, during and after a run."""

import warnings

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism.beams.limits import highest_frequencies

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
DOWN = jo.Gravity((0, 0, -9.81))


def hanging(stiffness, mass=1.0, **options):
    """A rope of 1 m that hangs from the ground, inertia of a thick section."""
    section = jo.mechanism.BeamSection(stiffness, mass, (2e-3, 1e-3, 1e-3))
    options = {"elements": 4} | options
    beam = jo.BeamBody("rope", [(0, 0, 0), (0, 0, -1)], section, **options)
    return beam, jo.Fixed("root", jo.ground["origin"], beam["start"].turned(beam.frames[0].T))


def test_the_fastest_element_is_that_of_the_stretching_bar():
    """A free bar of two lumped halves: w = 2 c/L; with the consistent mass sqrt(3) as fast."""
    for mass, factor in (("lumped", 2.0), ("consistent", 2.0 * np.sqrt(3.0))):
        section = jo.mechanism.BeamSection((1e6, 1e2, 1e2, 1e-3, 1e-3, 1e-3), 2.0, (2.0, 1.0, 1.0))
        beam = jo.BeamBody("b", [(0, 0, 0), (3, 0, 0)], section, elements=6, mass=mass)
        found = highest_frequencies(beam.elements)
        assert found == pytest.approx(np.full(6, factor * np.sqrt(1e6 / 2.0) / 0.5))


@pytest.mark.parametrize("scale", [0.97, 1.05])
def test_the_limit_of_rk4_is_where_the_run_breaks(scale):
    beam = jo.BeamBody("bar", [(0, 0, 0), (1, 0, 0)], jo.Circle(0.05), STEEL, elements=6)
    root = jo.Fixed("root", jo.ground["origin"], beam["start"])
    kick = jo.Force("kick", beam["end"], (1e3, 1e3, 0))
    model = jo.compile(jo.Mechanism(beam, root, kick))
    step = scale * np.sqrt(8.0) / (2 * np.pi * beam.highest_frequency)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            largest = np.abs(jo.simulate(model, 600 * step, solver=jo.RK4(step=step)).q).max()
        except jo.SimulationError:
            largest = np.inf
    # the beam is 1 m long and hardly moves, or everything grows without limit
    assert (largest > 2.0, largest < 1.1) == (scale > 1.0, scale < 1.0)
    assert any("stiffest body 'bar'" in str(w.message) for w in caught) == (scale > 1.0)


def test_weight_beyond_the_tension_that_shear_bears():
    """EA 1e3 N, GA 5 N: unstable beyond GA/(1 - GA/EA) = 5.025 N."""
    beam, root = hanging((1e3, 5.0, 5.0, 1, 1, 1))
    with pytest.warns(
        jo.JoustoWarning, match=r"weight causes a tension of up to 9.81 N, but beyond 5.03 N"
    ):
        jo.compile(jo.Mechanism(beam, root, DOWN))


def test_tension_in_the_run_beyond_what_shear_bears():
    beam, root = hanging((1e3, 50.0, 50.0, 1, 1, 1))
    pull = jo.Force("pull", beam["end"], (0, 0, -80.0), signal=jo.Ramp(0.0, 0.5))
    model = jo.compile(jo.Mechanism(beam, root, pull, DOWN))
    with pytest.warns(jo.JoustoWarning, match="beam 'rope': the tension in its element 0") as seen:
        jo.simulate(model, 0.5, solver=jo.GeneralizedAlpha(step=5e-3))
    assert sum("beam 'rope'" in str(w.message) for w in seen) == 1


def test_bending_by_more_than_a_radian_in_an_element():
    beam, root = hanging(
        (1e6, 1e6, 1e6, 10, 10, 10), elements=2, damping=jo.mechanism.BeamDamping(2.0, 0.05)
    )
    moment = jo.Torque("bend", beam["end"], (0, 30.0, 0), signal=jo.Ramp(0.0, 0.5))
    model = jo.compile(jo.Mechanism(beam, root, moment))
    with pytest.warns(jo.JoustoWarning, match=r"beam 'rope': its element \d bent or twisted by"):
        jo.simulate(model, 1.0, solver=jo.GeneralizedAlpha(step=5e-3))


def test_an_element_that_is_curved_by_more_than_a_radian():
    t = np.linspace(0, np.pi, 4)
    points = np.stack([np.sin(t), 1 - np.cos(t), 0 * t], axis=1)
    with pytest.warns(jo.JoustoWarning, match="bend by up to 1.05 rad each"):
        jo.BeamBody("hook", points, jo.Circle(0.01), STEEL)


def test_a_step_too_large_for_newton_names_the_beam_and_the_remedy():
    beam, root = hanging((1e6, 1e6, 1e6, 10, 10, 10))
    blow = jo.Torque("blow", beam["end"], (0, 4e3, 0))
    model = jo.compile(jo.Mechanism(beam, root, blow, DOWN))
    solver = jo.GeneralizedAlpha(step=0.05, max_iterations=8)
    with pytest.raises(jo.SimulationError, match="beam 'rope'") as error:
        jo.simulate(model, 1.0, solver=solver)
    assert "smaller step" in str(error.value)
