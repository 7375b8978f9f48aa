"""Contact in machines beside closed forms: ball on a beam, bar on a wall, cam and follower."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import Contact, HalfSpace, Hertz, PowerLaw, Sphere, SpringDamper
from jousto.reduction import BeamFunctions, ChordFrame, ShapeFunctions

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*moves freely", "ignore:.*static work", "ignore:.*(diamond|metal)"
)
G = 9.81


# -- ball on a beam -------------------------------------------------------------------------------


def pinned_beam(material: jo.Material, side: float, elements: int) -> jo.FlexibleBody:
    """10 symmetric modes of Euler and Bernoulli's beam of 200 mm with a square section.

    The section of the part is flat, with the same stiffness and mass: without rotary inertia.
    """
    h = 1e-6
    E, rho = material.E * side**4 / h**3, material.rho * side**2 / h
    flat = jo.Material(E=E, nu=material.nu, rho=rho)
    part = jo.Part.beam(
        *(0.2, jo.Rectangle(1.0, h), elements, flat), theory=jo.parts.EulerBernoulli()
    )
    pinned = BeamFunctions("pinned-pinned", 19, axis="x", across="z")
    reduced = jo.reduce(part, ShapeFunctions(pinned, frame=ChordFrame("start", "end")))
    return jo.FlexibleBody("beam", reduced.keep(range(0, 19, 2)))


def test_a_ball_strikes_a_beam_twice() -> None:
    """Timoshenko's impact: the beam swings back and strikes the ball again.

    Modes ``M q'' + M w^2 q = -F s`` and Hertz's law ``F = K d^1.5``, integrated to 1e-11.
    """
    R, elements = 0.015, 80
    steel = jo.Material(E=210e9, nu=0.3, rho=7850.0)
    beam = pinned_beam(steel, 0.01, elements)
    ball = jo.RigidBody.sphere(
        *("ball",), radius=R, mass=7850.0 * 4 / 3 * np.pi * R**3,
        position=(0.1, 0, R), velocity=(0, 0, -0.1),
    )  # fmt: skip
    touch = Contact(
        *("touch", beam[f"node{elements // 2 + 1}"], HalfSpace(), ball["origin"], Sphere(R)),
        Hertz.between(steel, restitution=1.0),
    )
    hinge = jo.Revolute("hinge", jo.ground["origin"], beam["start"], (0, 1, 0))
    roller = jo.PointOnPlane("roller", jo.ground.at((0.2, 0, 0)), beam["end"], (0, 0, 1))
    model = jo.compile(jo.Mechanism(beam, hinge, roller, ball, touch))
    solver = jo.simulation.DormandPrince(1e-10)
    first, second = jo.simulate(model, 8e-4, solver=solver).contacts
    assert first.part == pytest.approx(1.930918161e-4, rel=2e-7)
    assert second.touch == pytest.approx(6.143063910e-4, rel=2e-6)
    assert second.force == pytest.approx(137.1848889, rel=2e-6)


# -- bar on a wall --------------------------------------------------------------------------------


def bar_on_wall(elements: int) -> tuple[float, float]:
    """Mean force over the middle of the impact, N, and its duration, s.

    The stiffness of the wall is that of an element: it vanishes with a finer mesh.
    """
    side, rho = 0.01, 7850.0
    steel = jo.Material(E=210e9, nu=0.3, rho=rho)
    bar = jo.BeamBody(
        *("bar", [(0, 0, 0), (0, 0, 1)], jo.Rectangle(side, side), steel),
        elements=elements,
        velocity=(0, 0, -1),
    )
    wall = SpringDamper(210e9 * side**2 * elements)
    touch = Contact("touch", jo.ground["origin"], HalfSpace(), bar["start"], Sphere(0.0), wall)
    model = jo.compile(jo.Mechanism(bar, touch, jo.ForceSensor("F", touch)))
    solver = jo.GeneralizedAlpha(6e-5 / elements, 0.5)
    run = jo.simulate(model, 4.5e-4, solver=solver, output_step=1e-6)
    (event,) = run.contacts
    middle = (run.time > 0.05 * event.part) & (run.time < 0.9 * event.part)
    return float(run["F"][middle, 2].mean()), event.part - event.touch


def test_a_bar_strikes_a_wall() -> None:
    """1 m, 1 cm2, steel, 1 m/s: ``A v sqrt(E rho)`` for the time ``2 L sqrt(rho / E)``."""
    (_, coarse), (force, fine) = bar_on_wall(30), bar_on_wall(120)
    assert force == pytest.approx(4060.172410, rel=1e-3)
    late = fine / 3.866830867e-4 - 1.0
    assert 0.0 < late < 0.015  # the corner of the wave is as wide as an element
    assert late < 0.5 * (coarse / 3.866830867e-4 - 1.0)


# -- cam and follower -----------------------------------------------------------------------------


def lifts(speed: float, K: float, solver: Any, degrees: float) -> float:
    """Angle at which the flat follower of a cam ``r + e sin`` lifts, degrees; nan: it stays.

    A disc of radius r, turned about an axis at e from its centre, has this profile.
    """
    r, e, m = 0.03, 0.01, 0.2
    cam = jo.RigidBody("cam", 1.0, (1e-3,) * 3)
    hinge = jo.Revolute("hinge", jo.ground["origin"], cam["origin"], (0, 1, 0))
    # depth of the force at the start and its rate, so that the contact does not vibrate
    sunk, sinks = (m * G + 20.0) / K, (5000.0 - m * speed**2) * e * speed / K
    follower = jo.RigidBody(
        "follower", m, (1e-3,) * 3, position=(0, 0, r - sunk), velocity=(0, 0, e * speed - sinks)
    )
    guide = jo.Prismatic("guide", jo.ground.at((0, 0, r)), follower["origin"], (0, 0, 1))
    face = follower.at((0, 0, 0), axes=np.diag([1.0, -1.0, -1.0]))
    law = PowerLaw(K, 1.0, restitution=1.0)
    touch = Contact("touch", cam.at((e, 0, 0)), Sphere(r), face, HalfSpace(), law)
    turn = jo.Drive("turn", hinge.angle, jo.ConstantSpeed(-speed))
    mechanism = jo.Mechanism(
        *(cam, hinge, turn, follower, guide, touch),
        jo.Spring("spring", guide.displacement, 5000.0, free=0.0),
        jo.Force("preload", follower["origin"], (0, 0, -20.0)),
        jo.Gravity((0, 0, -G)),
    )
    run = jo.simulate(jo.compile(mechanism), np.radians(degrees) / speed, solver=solver)
    return float(np.degrees(run.contacts[0].part * speed))


def test_a_follower_lifts_at_its_angle() -> None:
    """300 rad/s: ``sin a = (m g + 20) / (e (m w^2 - k))``."""
    found = lifts(300.0, 1e10, jo.GeneralizedAlpha(5e-7, 0.8), 10.5)
    assert found == pytest.approx(9.726104711, rel=2e-5)


@pytest.mark.parametrize(("speed", "stays"), [(189.68, True), (189.70, False)])
def test_a_follower_jumps_above_a_speed(speed: float, stays: bool) -> None:
    """``w^2 = (m g + 20 + k e) / (m e)``: 189.6865836 rad/s."""
    assert np.isnan(lifts(speed, 1e10, jo.GeneralizedAlpha(2e-5, 0.5), 95.0)) == stays
