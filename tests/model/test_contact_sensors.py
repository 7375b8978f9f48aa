"""Sensors of contacts: sums over tips, pairs of a set, pressure by Hertz; doctor."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.fatigue import hertz_line, hertz_point
from jousto.mechanism import (
    Capsule,
    CollisionShape,
    Contact,
    ContactForceSensor,
    ContactPressureSensor,
    Contacts,
    ConvexHull,
    Cuboid,
    HalfSpace,
    Hertz,
    PowerLaw,
    Sphere,
    Surface,
    Torus,
)
from jousto.simulation.results import contact_findings

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

G = 9.81
STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)
SOLVERS = [jo.RK4(1e-3), jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)]


def names(solver: Any) -> str:
    return type(solver).__name__


@pytest.mark.parametrize("solver", SOLVERS, ids=names)
@pytest.mark.parametrize("shape", [Cuboid((0.2, 0.3, 0.1)), Capsule(0.05, 0.3)], ids=["box", "rod"])
def test_force_over_several_tips(solver, shape):
    """The weight that is 20 mm off the middle: force, and moment about the marker of the shape."""
    turn = np.eye(3) if isinstance(shape, Cuboid) else [(0, 0, -1), (0, 1, 0), (1, 0, 0)]
    body = jo.RigidBody("body", 2.0, (0.02,) * 3, position=(0, 0, 0.05))
    place = body.at((0, 0, 0), axes=turn)
    law = PowerLaw(1e6, 1.0, restitution=0.2)
    touch = Contact("floor", jo.ground["origin"], HalfSpace(), place, shape, law)
    off = 0.02
    weight = jo.Force("weight", body.at((off, 0, 0)), (0, 0, -2.0 * G))
    # in the plane only, so that a capsule does not roll
    guide = jo.Planar("plane", jo.ground["origin"], body["origin"], normal=(0, 1, 0))
    sensor = jo.ForceSensor("f", touch)
    applied = jo.mechanism.BodyLoadSensor("all", body, "applied")
    model = jo.compile(jo.Mechanism(body, touch, weight, guide, sensor, applied))
    run = jo.simulate(model, 0.02, state=jo.equilibrium(model), solver=solver)
    assert sum(force.element == "contact" for force in model.forces) == len(shape.tips)
    np.testing.assert_allclose(run["f"][-1, :3], [0, 0, 2 * G], atol=1e-5)
    np.testing.assert_allclose(run["f"][-1, 3:], [0, -2 * G * off, 0], atol=1e-6)
    # with the weight they are all applied loads of the body
    np.testing.assert_allclose(run["all"][-1], 0.0, atol=2e-5)


def stack(**more: Any) -> tuple[list[Any], Contacts]:
    """Two balls that rest on each other, and one beside them, at their depths under the weight."""
    first, second, third = ((N / 1e6) ** (2 / 3) for N in (3 * G, 2 * G, 4 * G))
    places = [(0, 0, 0.1 - first), (0, 0, 0.3 - first - second), (1, 0, 0.1 - third)]
    balls = [
        jo.RigidBody.sphere(f"b{i}", radius=0.1, mass=m, position=at)
        for i, (m, at) in enumerate(zip((1, 2, 4), places, strict=True))
    ]
    shapes = [
        CollisionShape(one.name, one["origin"], Sphere(0.1), group=f"g{one.name}", **more)
        for one in balls
    ]
    shapes.append(CollisionShape("floor", jo.ground["origin"], HalfSpace(), **more))
    law = None if more else PowerLaw(1e6, restitution=0.1)
    return balls, Contacts("set", shapes, law=law, overlap="start")


@pytest.mark.parametrize("solver", SOLVERS, ids=names)
def test_forces_of_pairs_of_a_set(solver):
    """Each pair by itself, both directions, groups and shapes; moments about the marker of b."""
    balls, contacts = stack()
    sensors = [
        ContactForceSensor(f"{a} on {b}", contacts, a, b)
        for a, b in (("floor", "b0"), ("b0", "floor"), ("b0", "gb1"), ("floor", "b1"),
                     ("all", "gb2"))
    ]  # fmt: skip
    slide = [
        jo.Prismatic(f"s{x.name}", jo.ground.at(x.position), x["origin"], axis=(0, 0, 1))
        for x in balls
    ]
    model = jo.compile(jo.Mechanism(*balls, *slide, contacts, *sensors, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 0.05, solver=solver)
    last = {name: run[name][-1] for name in run}
    np.testing.assert_allclose(last["floor on b0"][:3], [0, 0, 3 * G], rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(last["b0 on floor"], -last["floor on b0"], atol=1e-12)
    np.testing.assert_allclose(last["b0 on gb1"][:3], [0, 0, 2 * G], rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(last["floor on b1"], 0.0)
    np.testing.assert_allclose(last["all on gb2"][:3], [0, 0, 4 * G], rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(last["floor on b0"][3:], 0.0, atol=1e-9)


def test_the_moment_of_a_group_is_about_its_first_shape():
    """The ball at x = 1 m seen from that at x = 0: moment r x F."""
    balls, contacts = stack()
    group = [CollisionShape(x.name, x.marker, x.shape, group="balls") for x in contacts.shapes[:3]]
    contacts = Contacts(
        "set", [*group, contacts.shapes[3]], law=PowerLaw(1e6, restitution=0.1), overlap="start"
    )
    sensor = ContactForceSensor("f", contacts, "floor", "balls")
    slide = [
        jo.Prismatic(f"s{x.name}", jo.ground.at(x.position), x["origin"], axis=(0, 0, 1))
        for x in balls
    ]
    model = jo.compile(jo.Mechanism(*balls, *slide, contacts, sensor, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 0.02, solver=jo.ROS2(1e-3))
    np.testing.assert_allclose(run["f"][-1, :3], [0, 0, 7 * G], rtol=1e-4, atol=1e-9)
    np.testing.assert_allclose(run["f"][-1, 3:], [0, -4 * G, 0], rtol=1e-4, atol=1e-7)


def test_force_of_a_pair_of_polytopes():
    """A hull with its weight off the middle, in both orders: force, moment about its marker."""
    corners = np.array(np.meshgrid(*[(-0.1, 0.1)] * 3)).reshape(3, -1).T
    body = jo.RigidBody("b", 2.0, (0.01,) * 3, center=(0.03, 0.05, 0), position=(5, 6, 0.1))
    law = PowerLaw(1e6, 1.0, restitution=0.2)
    floor = CollisionShape("floor", jo.ground["origin"], HalfSpace())
    hull = CollisionShape("hull", body["origin"], ConvexHull(corners))
    for shapes in ([floor, hull], [hull, floor]):
        touch = Contacts("set", shapes, law=law)
        sensor = ContactForceSensor("f", touch, "floor", "hull")
        model = jo.compile(jo.Mechanism(body, touch, sensor, jo.Gravity((0, 0, -G))))
        run = jo.simulate(model, 2e-3, state=jo.equilibrium(model), solver=jo.ROS2(1e-3))
        wanted = [0, 0, 2 * G, 0.05 * 2 * G, -0.03 * 2 * G, 0]
        np.testing.assert_allclose(run["f"][-1], wanted, atol=1e-4)


def test_names_of_a_pair_are_checked():
    _, contacts = stack()
    with pytest.raises(jo.InputError, match="no shape or group 'flor' in 'set'; did you mean"):
        ContactForceSensor("f", contacts, "flor", "b0")
    with pytest.raises(jo.InputError, match="'b0' is on both sides"):
        ContactForceSensor("f", contacts, "b0", "b0")
    with pytest.raises(jo.InputError, match="'b0' is on both sides"):
        ContactForceSensor("f", contacts, "b0", "gb0")
    with pytest.raises(jo.InputError, match="take a ContactForceSensor of two of its shapes"):
        jo.ForceSensor("f", contacts)


def pressed(shape_a: Any, shape_b: Any, law: Any, force: float, **more: Any) -> tuple[Any, Any]:
    """Values of a pressure sensor where a body is pressed on the floor, and the run."""
    body = jo.RigidBody("body", 1.0, (0.01,) * 3, position=(0, 0, more.pop("height")))
    place = body.at((0, 0, 0), axes=more.pop("axes", np.eye(3)))
    touch = Contact("touch", jo.ground["origin"], shape_a, place, shape_b, law)
    sensor = ContactPressureSensor("p", touch, **more)
    guide = jo.Prismatic("guide", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    push = jo.Force("push", body["origin"], (0, 0, -force))
    model = jo.compile(jo.Mechanism(body, guide, touch, push, sensor))
    run = jo.simulate(model, 0.001, state=jo.equilibrium(model), solver=jo.ROS2(1e-4))
    return run["p"][-1], run


def test_pressure_of_a_ball_on_a_plane():
    """Johnson 1985, eq. 3.39 and 4.24: p0 = (6 F E*^2/(pi^3 R^2))^(1/3), a = (3 F R/4 E*)^(1/3)."""
    law, R, F = Hertz.between(STEEL), 0.01, 100.0
    found, run = pressed(HalfSpace(), Sphere(R), law, F, height=R)
    p0 = (6 * F * law.modulus**2 / (pi**3 * R**2)) ** (1 / 3)
    a = (3 * F * R / (4 * law.modulus)) ** (1 / 3)
    np.testing.assert_allclose(found, [p0, a, a], rtol=1e-6)
    (point,) = run.contacts.at(-1)
    assert point.pressure == pytest.approx(p0, rel=1e-6)


def test_pressure_of_a_wheel_with_a_rounded_rim():
    """Radii 0.46 m along and 0.3 m across: the ellipse of `hertz_point`."""
    law = PowerLaw(1e10, 1.5, restitution=0.5)
    modulus = STEEL.E / (2 * (1 - STEEL.nu**2))
    F = 80e3
    turn = [(1, 0, 0), (0, 0, -1), (0, 1, 0)]
    found, _ = pressed(
        HalfSpace(), Torus(0.16, 0.3), law, F, height=0.46, axes=turn, modulus=modulus
    )
    want = hertz_point(F, radii=(0.46, 0.3), material=STEEL)
    np.testing.assert_allclose(found, [want.p0, want.a, want.b], rtol=1e-6)


def test_pressure_of_a_line():
    law, F = PowerLaw(1e9, 1.0, restitution=0.5), 10e3
    modulus = STEEL.E / (2 * (1 - STEEL.nu**2))
    found, _ = pressed(
        HalfSpace(), Sphere(0.1), law, F, height=0.1, modulus=modulus, radii=(0.1, 1.0), length=0.03
    )
    want = hertz_line(F, length=0.03, radius=0.1, material=STEEL)
    np.testing.assert_allclose(found, [want.p0, want.a], rtol=1e-6)


def test_pressure_of_a_set_by_its_surfaces():
    steel = Surface("steel", 210e9, 0.3, restitution=0.5)
    balls, contacts = stack(surface=steel)
    model = jo.compile(jo.Mechanism(*balls, contacts, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 0.001, solver=jo.RK4(1e-5))
    point = next(one for one in run.contacts.at(0.0) if {one.a, one.b} == {"b0", "b1"})
    modulus = 210e9 / (2 * (1 - 0.3**2))
    p0 = (6 * point.force * modulus**2 * (2 / 0.1) ** 2) ** (1 / 3) / pi
    assert point.force > 0.0
    assert point.pressure == pytest.approx(p0, rel=1e-9)


def test_pressure_without_radii_or_modulus_is_refused():
    body = jo.RigidBody("body", 1.0, (0.01,) * 3)
    floor = jo.ground["origin"], HalfSpace()
    plain = Contact("t", *floor, body["origin"], Sphere(0.1), PowerLaw(1e6))
    with pytest.raises(jo.InputError, match=r"PowerLaw has no E\*; give modulus="):
        ContactPressureSensor("p", plain)
    corner = Contact("t", *floor, body["origin"], Sphere(0.0), PowerLaw(1e6))
    with pytest.raises(jo.InputError, match="sphere have no radii of a point; give radii="):
        ContactPressureSensor("p", corner, modulus=1e11)
    box = Contact("t", *floor, body["origin"], Cuboid((1, 1, 1)), PowerLaw(1e6))
    with pytest.raises(jo.InputError, match="several tips with a pressure each"):
        ContactPressureSensor("p", box, modulus=1e11, radii=(0.1, 0.1))
    with pytest.raises(jo.InputError, match="must be positive"):
        ContactPressureSensor("p", plain, modulus=1e11, radii=(0.1, -0.1))


# -- doctor ------------------------------------------------------------------------------------


def drop(law: Any, height: float = 0.5, radius: float = 0.05) -> jo.Mechanism:
    ball = jo.RigidBody.sphere("ball", radius=radius, mass=0.1, position=(0, 0, height))
    touch = Contact("t", jo.ground["origin"], HalfSpace(), ball["origin"], Sphere(radius), law)
    return jo.Mechanism(ball, touch, jo.Gravity((0, 0, -G)))


def test_doctor_finds_nothing_in_a_good_run():
    run = jo.simulate(jo.compile(drop(PowerLaw(1e8, restitution=0.6))), 0.5, solver=jo.RK4(1e-3))
    assert len(run.contacts) > 0
    assert jo.doctor(run).warnings == ()


def test_doctor_names_a_contact_that_is_too_soft():
    run = jo.simulate(jo.compile(drop(PowerLaw(1e4, restitution=0.6))), 0.6, solver=jo.RK4(1e-3))
    text = " ".join(jo.doctor(run).warnings)
    assert "'t' (ground - ball) was" in text and "take a stiffer law" in text


def test_doctor_names_contacts_with_few_steps(monkeypatch):
    """Of the 35 steps of this contact: no method takes fewer than 20."""
    run = jo.simulate(jo.compile(drop(PowerLaw(1e8, restitution=0.6))), 0.5, solver=jo.RK4(1e-3))
    monkeypatch.setattr(contact_findings, "FEW", 100)
    text = " ".join(jo.doctor(run).warnings)
    assert "1 of 1 contacts had fewer than 100 steps, the fewest" in text and "a step of" in text


def test_doctor_names_a_restitution_that_is_not_reached():
    """A free rebound with half of the speed, where 0.9 is asked for."""
    run = jo.simulate(jo.compile(drop(PowerLaw(1e8, restitution=0.5))), 0.5, solver=jo.RK4(1e-3))
    (event,), (pair,) = run.contacts, run.contacts._pairs
    found = contact_findings.contact_findings((event,), (pair,), run)
    assert found == ()
    (text,) = contact_findings.contact_findings((event,), (replace(pair, restitution=0.9),), run)
    assert "'t' (ground - ball) rebounded with 0.499 of its speed" in text
    assert "a restitution of 0.9 is asked for" in text and "another force" in text


def test_doctor_names_overlaps_at_the_start():
    diagnosis = jo.doctor(drop(PowerLaw(1e6), height=0.049))
    assert diagnosis.overlaps == (
        "'t' (ground - ball) by 0.001 m (2 % of the smaller shape), where the law holds 0.0126 J: "
        "up to 0.503 m/s, 0.0129 m high",
    )
    assert "overlap at the start" in str(diagnosis)
    assert jo.doctor(drop(PowerLaw(1e6), height=0.051)).overlaps == ()
