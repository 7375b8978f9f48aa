"""Machines of any size: a threshold with a unit in it shows as an answer that depends on the size.

All lengths are scaled; loads follow, so that deflections over the length stay (slender beams,
``F L^3 / 3 EI``; ``f = 1.8751^2 / (2 pi L^2) sqrt(EI / rho A)``).
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
SIZES = [1e-6, 1e-4, 1.0, 50.0]  # m
SLENDER = 100.0


def cantilever(length: float, alpha: float) -> jo.Model:
    """A beam whose end a load of alpha EI / L^2 bends."""
    side = length / SLENDER
    section = jo.Rectangle(side, side)
    part = jo.Part.beam(length, section, 8, STEEL, theory=jo.parts.EulerBernoulli())
    bar = jo.FlexibleBody("bar", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4)))
    load = alpha * STEEL.E * side**4 / 12.0 / length**2
    return jo.compile(
        jo.Mechanism(
            bar,
            jo.Fixed("weld", jo.ground["origin"], bar["start"]),
            jo.Force("pull", bar["end"], (0, 0, load), signal=jo.Input("f", initial=1.0)),
            jo.PositionSensor("end", bar["end"]),
        )
    )


@pytest.mark.parametrize("alpha", [1e-3, 1e-6])
@pytest.mark.parametrize("length", SIZES)
def test_a_beam_of_any_size_bends_alike(length: float, alpha: float) -> None:
    model = cantilever(length, alpha)
    path = jo.simulation.load_path(model, "f", start=0.0, to=1.0, steps=2)
    run = jo.simulate(model, 1e-9 * length, state=jo.equilibrium(model), output_step=1e-9 * length)
    for bent in (path["end"][-1, 2], run["end"][0, 2]):
        # second order shortens it by the square of alpha
        assert 3.0 * bent / alpha / length == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("length", SIZES)
def test_a_beam_of_any_size_sounds_alike(length: float) -> None:
    found = jo.modes(cantilever(length, 0.0)).frequencies[0]
    side = length / SLENDER
    rate = np.sqrt(STEEL.E * side**2 / 12.0 / STEEL.rho)
    assert found == pytest.approx(1.8751041**2 / (2.0 * np.pi * length**2) * rate, rel=2e-4)


@pytest.mark.parametrize("length", SIZES)
def test_a_beam_of_any_size_buckles_alike(length: float) -> None:
    side = length / SLENDER
    section = jo.Rectangle(side, side)
    part = jo.Part.beam(length, section, 8, STEEL, theory=jo.parts.EulerBernoulli())
    bar = jo.FlexibleBody("bar", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4)))
    foot = jo.Fixed("foot", jo.ground["origin"], bar["start"])
    push = jo.Force("press", bar["end"], (-1, 0, 0), signal=jo.Input("load"))
    model = jo.compile(jo.Mechanism(bar, foot, push))
    wanted = 0.25 * np.pi**2 * STEEL.E * side**4 / 12.0 / length**2
    assert jo.simulation.buckling(model, "load", 1).loads[0] == pytest.approx(wanted, rel=1e-3)


@pytest.mark.parametrize("length", SIZES)
def test_a_crank_of_any_size_moves_alike(length: float) -> None:
    """Slider-crank, crank r and rod 3 r: the slider is at ``r cos a + sqrt(9 - sin^2 a) r``."""
    mass = 1000.0 * length**3
    inertia = (mass * length**2,) * 3
    crank = jo.RigidBody("crank", mass, inertia, markers={"pin": (length, 0, 0)})
    rod = jo.RigidBody(
        "rod", mass, inertia, position=(length, 0, 0), markers={"end": (3 * length, 0, 0)}
    )
    slider = jo.RigidBody("slider", mass, inertia, position=(4 * length, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], crank["origin"], axis=(0, 0, 1))
    model = jo.compile(
        jo.Mechanism(
            *(crank, rod, slider, hinge),
            jo.Cylindrical("pin", crank["pin"], rod["origin"], axis=(0, 0, 1)),
            jo.Spherical("wrist", rod["end"], slider["origin"]),
            jo.Prismatic("guide", jo.ground["origin"], slider["origin"], axis=(1, 0, 0)),
            jo.Drive("motor", hinge.angle, jo.ConstantSpeed(1.0)),
            jo.PositionSensor("slide", slider["origin"]),
        )
    )
    run = jo.simulation.kinematics(model, np.linspace(0.0, 2.0, 9))
    a = run.time
    wanted = np.cos(a) + np.sqrt(9.0 - np.sin(a) ** 2)
    assert run["slide"][:, 0] / length == pytest.approx(wanted, abs=1e-9)


@pytest.mark.parametrize("length", SIZES)
@pytest.mark.parametrize("off", [0.0, 0.1 + 0.2 - 0.3, 1e-9])
def test_a_rotor_that_stands_at_one_point_but_for_rounding(off: float, length: float) -> None:
    # the gap of 5.55e-17 m was all of the mechanism's size, beside which it was refused
    inertia = 2.0 * length**2 * np.array([0.05, 0.05, 0.1])
    rotor = jo.RigidBody(
        "rotor", 2.0, inertia, position=(off * length, 0, 0), angular_velocity=(0, 0, 5.0)
    )
    hinge = jo.Revolute("hinge", jo.ground["origin"], rotor["origin"], axis=(0, 0, 1))
    mechanism = jo.Mechanism(rotor, hinge, jo.CoordinateSensor("turned", hinge.angle))
    # the mean square of the distance from the centre is half the sum of the moments
    assert mechanism.size == pytest.approx(np.sqrt(0.1) * length, rel=1e-12)
    for solver in (jo.ROS2(), jo.GeneralizedAlpha(step=1e-3), jo.simulation.DormandPrince()):
        run = jo.simulate(jo.compile(mechanism), 0.5, solver=solver)
        # free of torque: 5 rad/s all the time
        assert run["turned"][-1].item() == pytest.approx(2.5, rel=1e-9)
