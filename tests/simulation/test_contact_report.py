"""Contacts of a run: events from touch to part, and the points of an instant."""

from __future__ import annotations

from math import gamma, pi, sqrt
from typing import Any

import h5py
import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import (
    CollisionShape,
    Contact,
    Contacts,
    Cuboid,
    HalfSpace,
    PowerLaw,
    Sphere,
    SpringDamper,
)
from jousto.simulation.results import contact_table

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

R, M, V, K = 0.05, 0.4, 2.0, 1e8
G = 9.81
METHODS = {
    "RK4": (jo.RK4(1e-3), 2e-4),
    "ROS2": (jo.ROS2(1e-3), 2e-3),
    "GeneralizedAlpha": (jo.GeneralizedAlpha(1e-3), 2e-3),
    "DormandPrince": (jo.simulation.DormandPrince(tolerance=1e-9), 2e-5),
}


def shot(restitution: float = 1.0, law: Any = None) -> jo.Mechanism:
    """Two equal balls that fly at each other without gravity, and touch after 0.01 s."""
    balls = [
        jo.RigidBody.sphere(name, radius=R, mass=M, position=(at, 0, 0), velocity=(speed, 0, 0))
        for name, at, speed in (("a", 0, 0), ("b", 2 * R + 0.01 * V, -V))
    ]
    law = law or PowerLaw(K, restitution=restitution)
    touch = Contact("hit", balls[0]["origin"], Sphere(R), balls[1]["origin"], Sphere(R), law)
    return jo.Mechanism(*balls, touch)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("e", [1.0, 0.6])
def test_event_of_a_central_hit(method, e):
    """Touch, speeds, impulse and loss by the laws of momentum; depth and duration by Hertz."""
    solver, small = METHODS[method]
    run = jo.simulate(jo.compile(shot(e)), 0.02, solver=solver)
    (event,) = run.contacts
    mass = M / 2
    assert (event.contact, event.a, event.b, event.tip) == ("hit", "a", "b", 0)
    assert event.touch == pytest.approx(0.01, abs=1e-10)
    assert event.approach == pytest.approx(V, rel=1e-9)
    assert event.rebound == pytest.approx(e * V, rel=2e-3)
    assert event.impulse == pytest.approx(mass * V * (1 + e), rel=5 * small)
    assert event.lost_restitution == pytest.approx(
        0.5 * mass * V**2 * (1 - e**2), abs=5 * small * 0.5 * mass * V**2
    )
    assert event.lost_friction == event.friction_impulse == 0.0
    assert event.steps >= 20
    if e == 1.0:
        depth = (5 * mass * V**2 / (4 * K)) ** 0.4
        assert event.depth == pytest.approx(depth, rel=small)
        assert event.force == pytest.approx(K * depth**1.5, rel=max(small, 1e-3))
        assert event.part - event.touch == pytest.approx(2.943275184 * depth / V, rel=5 * small)


def test_impulse_of_a_spring_by_its_half_wave():
    """N = k d for half a period: impulse 2 m v, force v sqrt(k m), duration pi sqrt(m/k)."""
    k, mass = 1e6, M / 2
    run = jo.simulate(jo.compile(shot(law=SpringDamper(k))), 0.02, solver=jo.RK4(1e-3))
    (event,) = run.contacts
    assert event.force == pytest.approx(V * sqrt(k * mass), rel=1e-4)
    assert event.depth == pytest.approx(V * sqrt(mass / k), rel=1e-5)
    assert event.part - event.touch == pytest.approx(pi * sqrt(mass / k), rel=1e-4)
    assert event.impulse == pytest.approx(2 * mass * V, rel=3e-4)


def test_any_exponent_has_its_depth():
    """1/2 m v^2 = K d^(n+1)/(n+1), and the duration by the beta function."""
    n, mass = 2.0, M / 2
    law = PowerLaw(1e10, n, restitution=1.0)
    run = jo.simulate(jo.compile(shot(law=law)), 0.02, solver=jo.RK4(1e-3))
    (event,) = run.contacts
    depth = ((n + 1) * 0.5 * mass * V**2 / 1e10) ** (1 / (n + 1))
    assert event.depth == pytest.approx(depth, rel=2e-4)
    duration = 2 * depth / V * sqrt(pi) * gamma(1 + 1 / (n + 1)) / gamma(0.5 + 1 / (n + 1))
    assert event.part - event.touch == pytest.approx(duration, rel=1e-3)


def block(push: float) -> jo.Mechanism:
    """A block of 2 kg on points at its corners, pushed along x; the floor's frame is turned."""
    body = jo.RigidBody("block", 2.0, (0.01,) * 3)
    floor = jo.ground.at((0, 0, 0), axes=[(0.6, -0.8, 0), (0.8, 0.6, 0), (0, 0, 1)])
    law = PowerLaw(1e6, 1.0, restitution=0.3)
    feet = [
        Contact(f"foot{i}", floor, HalfSpace(), body.at((x, y, 0)), Sphere(0.0), law,
                mu_kinetic=0.3, mu_static=0.4)
        for i, (x, y) in enumerate([(-1, -1), (-1, 1), (1, -1), (1, 1)])
    ]  # fmt: skip
    force = jo.Force("push", body["origin"], (push, 0, 0))
    return jo.Mechanism(body, *feet, force, jo.Gravity((0, 0, -G)))


def test_a_contact_without_friction_neither_sticks_nor_slips():
    ball = jo.RigidBody.sphere("ball", radius=0.05, mass=1.0, position=(0, 0, 0.05 - 1e-4))
    law = PowerLaw(1e5, 1.0)
    touch = Contact("touch", jo.ground["origin"], HalfSpace(), ball["origin"], Sphere(0.05), law)
    run = jo.simulate(jo.compile(jo.Mechanism(ball, touch)), 1e-4, solver=jo.RK4(1e-4))
    assert [one.phase for one in run.contacts.at(-1)] == ["no friction"]


@pytest.mark.parametrize("solver", [jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)], ids=["ROS2", "GA"])
def test_points_of_an_instant(solver):
    """A block that is pushed below its friction sticks, above it slips: sums of forces."""
    for push, phase in ((3.0, "sticks"), (20.0, "slips")):
        model = jo.compile(block(push))
        run = jo.simulate(model, 0.3, solver=solver, state=jo.equilibrium(jo.compile(block(0.0))))
        points = run.contacts.at(-1)
        assert [one.contact for one in points] == [f"foot{i}" for i in range(4)]
        assert {one.phase for one in points} == {phase}
        assert sum(one.force for one in points) == pytest.approx(2 * G, rel=1e-5)
        friction = sum(one.friction for one in points)
        want = -push if phase == "sticks" else -0.3 * 2 * G
        np.testing.assert_allclose(friction, [want, 0, 0], atol=2e-3)
        for one in points:
            assert one.gap < 0.0
            np.testing.assert_allclose(one.normal, [0, 0, 1], atol=1e-12)
            assert abs(one.point[2]) < 1e-4
            assert one.features == ""
            assert one.age > 0.0
        assert sum(one.stored for one in points) == pytest.approx(run.energy.contacts[-1])
        events = run.contacts
        assert len(events) == 4
        assert all(np.isnan(one.part) for one in events)
        assert sum(one.impulse for one in events) == pytest.approx(2 * G * 0.3, rel=1e-3)


def test_points_are_those_of_the_force_sensor_at_every_instant():
    """Recomputed from the stored states, the force is that of the run to round-off."""
    machine = shot(0.7)
    sensor = jo.ForceSensor("N", machine.forces[0])
    model = jo.compile(jo.Mechanism(*machine.bodies, *machine.forces, sensor))
    run = jo.simulate(model, 0.0115, solver=jo.RK4(1e-5))
    found = [run.contacts.at(t) for t in run.time]
    forces = np.array([sum(one.force for one in points) for points in found])
    np.testing.assert_allclose(forces, np.abs(run["N"][:, 0]), atol=1e-9 * forces.max())
    assert forces.max() > 1e3
    assert {len(points) for points in found} == {0, 1}
    assert all(len(run.contacts.at(t, near=True)) == 1 for t in run.time[:3])


def test_faces_of_boxes_name_their_features():
    low = jo.RigidBody("low", 1.0, (0.01,) * 3, position=(0, 0, 0.05))
    top = jo.RigidBody("top", 1.0, (0.01,) * 3, position=(0, 0, 0.15))
    law = PowerLaw(1e6, 1.0, restitution=0.3)
    box = Cuboid((0.2, 0.2, 0.1))
    touch = [
        Contact("floor", jo.ground["origin"], HalfSpace(), low["origin"], box, law),
        Contact("stack", low["origin"], box, top["origin"], box, law),
    ]
    model = jo.compile(jo.Mechanism(low, top, *touch, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 0.01, state=jo.equilibrium(model), solver=jo.ROS2(1e-3))
    points = [one for one in run.contacts.at(-1) if one.contact == "stack"]
    assert len(points) == 4
    assert sorted(one.tip for one in points) == [0, 1, 2, 3]
    assert all("face" in one.features and "vertex" in one.features for one in points)
    assert sum(one.force for one in points) == pytest.approx(G, rel=1e-6)
    # eight corners of the lower box touch the floor, one contact of the engine each
    tips = [one.tip for one in run.contacts.at(-1) if one.contact == "floor"]
    assert len(tips) == len(set(tips)) == 4


def heap(many: bool) -> jo.Mechanism:
    balls = [
        jo.RigidBody.sphere(f"b{i}", radius=R, mass=1.0, position=(0.4 * i, 0, 0.06 + 0.1 * i))
        for i in range(3)
    ]
    law = PowerLaw(1e7, restitution=0.7)
    floor = jo.ground["origin"]
    touch: list[Any]
    if many:
        shapes = [CollisionShape(f"s{one.name}", one["origin"], Sphere(R)) for one in balls]
        shapes.append(CollisionShape("floor", floor, HalfSpace()))
        touch = [Contacts("all", shapes, law=law, mu_kinetic=0.3)]
    else:
        touch = [
            Contact(f"c{i}", floor, HalfSpace(), one["origin"], Sphere(R), law, mu_kinetic=0.3)
            for i, one in enumerate(balls)
        ]
    return jo.Mechanism(*balls, *touch, jo.Gravity((0, 0, -G)))


def test_a_set_reports_its_shapes_with_the_events_of_single_contacts():
    one, other = (
        jo.simulate(jo.compile(heap(many)), 0.5, solver=jo.RK4(1e-3)).contacts
        for many in (True, False)
    )
    assert len(one) == len(other) > 4
    for a, b in zip(sorted(one, key=lambda x: x.touch), sorted(other, key=lambda x: x.touch),
                    strict=True):  # fmt: skip
        assert a.contact == "all"
        assert {a.a, a.b} == {"floor", f"sb{b.contact[1:]}"}
        assert b.a == "ground"
        for name in ("touch", "approach", "force", "depth", "impulse", "lost_restitution"):
            assert getattr(a, name) == pytest.approx(getattr(b, name), rel=1e-8)


def test_files_hold_what_memory_holds(tmp_path):
    model = jo.compile(heap(True))
    run = jo.simulate(model, 0.5, solver=jo.RK4(1e-3))
    path = run.save(tmp_path / "saved.h5")
    direct = jo.simulate(model, 0.5, solver=jo.RK4(1e-3), path=tmp_path / "direct.h5")
    for other in (jo.load(path), direct, jo.load(tmp_path / "direct.h5")):
        assert list(map(str, other.contacts)) == list(map(str, run.contacts))
        np.testing.assert_array_equal(other.energy.rubbed, run.energy.rubbed)
    loaded = jo.load(path)
    with pytest.raises(jo.InputError, match=r"give it: run.contacts.at\(time, model="):
        loaded.contacts.at(0.1)
    near = loaded.contacts.at(0.1, near=True, model=model)
    assert [one.gap for one in near] == [one.gap for one in run.contacts.at(0.1, near=True)]
    frame = run.contacts.to_pandas()
    assert list(frame["contact"]) == ["all"] * len(run.contacts)
    assert frame.attrs["units"]["force"] == "N"
    text = run.contacts.to_csv(tmp_path / "c.csv").read_text().splitlines()
    assert text[0].startswith("contact,a,b,tip,touch (s),part (s),approach (m/s)")
    assert len(text) == 1 + len(run.contacts)
    table = run.contacts.at(-1, near=True).to_csv(tmp_path / "p.csv").read_text()
    assert "normal.z" in table.splitlines()[0]


def test_a_run_that_continues_has_the_losses_of_one_in_one_go():
    model = jo.compile(heap(True))
    whole = jo.simulate(model, 0.5, solver=jo.RK4(1e-3))
    first = jo.simulate(model, 0.25, solver=jo.RK4(1e-3))
    rest = jo.simulate(model, 0.5, solver=jo.RK4(1e-3), state=first.state())
    for name in ("contacts", "restitution", "rubbed"):
        # a contact that is cut in two loses the third point of one parabola
        want = getattr(whole.energy, name)[-1]
        assert getattr(rest.energy, name)[-1] == pytest.approx(want, rel=1e-7, abs=1e-12)


def test_what_is_not_kept_is_counted(monkeypatch):
    monkeypatch.setattr(contact_table, "CONTACTS", 3)
    run = jo.simulate(jo.compile(heap(False)), 0.5, solver=jo.RK4(1e-3))
    assert len(run.contacts) == 3
    assert run.contacts.dropped > 1
    assert f"{run.contacts.dropped} more not kept" in repr(run.contacts)


def test_a_machine_without_contacts_stores_nothing(tmp_path):
    wheel = jo.RigidBody("wheel", 3.0, (0.01, 0.01, 0.02), angular_velocity=(0, 0, 9))
    axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"], axis=(0, 0, 1))
    model = jo.compile(jo.Mechanism(wheel, axle))
    run = jo.simulate(model, 0.1, path=tmp_path / "run.h5")
    assert len(run.contacts) == 0
    assert len(run.contacts.at(-1, model=model)) == 0
    assert not run.energy.contacts.any()
    with h5py.File(tmp_path / "run.h5") as file:
        assert "contacts" not in file
        assert "contact_energy" not in file["state"]


def test_a_simulator_records_them(tmp_path):
    model = jo.compile(shot(0.6))
    want = jo.simulate(model, 0.02, solver=jo.RK4(1e-4)).contacts[0]
    with jo.simulation.Simulator(model, jo.RK4(1e-4), path=tmp_path / "s.h5") as sim:
        sim.step(200)
    (event,) = jo.load(tmp_path / "s.h5").contacts
    assert event.impulse == pytest.approx(want.impulse, rel=1e-12)


def test_a_surface_of_triangles_names_the_triangle_that_touches():
    """A ball over the second of two triangles of a square."""
    square = jo.mechanism.TriangleMesh.of(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2), (0, 2, 3)]
    )
    ball = jo.RigidBody.sphere("ball", radius=R, mass=1.0, position=(0.2, 0.7, R - 1e-4))
    law = PowerLaw(1e7, restitution=0.3)
    touch = Contact("t", jo.ground["origin"], square, ball["origin"], Sphere(R), law)
    model = jo.compile(jo.Mechanism(ball, touch, jo.Gravity((0, 0, -G))))
    (point,) = jo.simulate(model, 1e-4, solver=jo.RK4(1e-5)).contacts.at(0.0)
    assert point.features == "triangle 1, vertex 0"
    np.testing.assert_allclose(point.normal, [0, 0, 1], atol=1e-12)
    np.testing.assert_allclose(point.point[:2], [0.2, 0.7], atol=1e-12)
