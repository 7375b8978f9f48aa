"""Contacts in the second formulation: forces and accelerations of the engine at the same states."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.rotations import rotation_matrix
from jousto.mechanism import (
    Bore,
    Capsule,
    Contact,
    ConvexHull,
    Cuboid,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    HollowSphere,
    Impact,
    JohnsonLine,
    PowerLaw,
    Regularised,
    Sphere,
    SpringDamper,
    Torus,
)
from jousto.natural.equations.supported import check_known
from jousto.natural.sensors_at_state import at_states
from jousto.simulation.state import State, put

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")

# shape that is touched, shape that touches, position of the latter in the frame of the former
PAIRS = [
    (HalfSpace(), Sphere(0.1), (0.3, -0.2, 0.097)),
    (HalfSpace(), Cuboid((0.3, 0.4, 0.2)), (0.1, 0.2, 0.1)),
    (HalfSpace(), Capsule(0.05, 0.3), (0.1, 0.2, 0.08)),
    (Sphere(0.2), Sphere(0.1), (0.1, 0.15, 0.23)),
    (HollowSphere(0.3), Sphere(0.1), (0.05, -0.12, 0.16)),
    (Capsule(0.1, 0.4), Sphere(0.1), (0.15, 0.11, 0.05)),
    (Capsule(0.1, 0.4), Sphere(0.1), (0.05, 0.1, 0.35)),
    (Cuboid((0.4, 0.6, 0.8)), Sphere(0.1), (0.27, 0.1, -0.2)),
    (Cuboid((0.4, 0.6, 0.8)), Sphere(0.1), (0.24, 0.36, 0.44)),
    (Cylinder(0.2, 0.5), Sphere(0.1), (0.2, 0.15, 0.1)),
    (Cylinder(0.2, 0.5), Sphere(0.1), (0.18, 0.15, 0.3)),
    (Bore(0.3), Sphere(0.1), (0.15, -0.15, 0.4)),
    (Torus(0.3, 0.1), Sphere(0.1), (0.3, 0.1, 0.15)),
]
LAWS = (SpringDamper(2e4, 30.0), Impact(1e7, 2.2, 50.0, 0.02), PowerLaw(1e6, restitution=1.0))


def machine(on: Any, of: Any, at: Any, law: Any, flexible: bool = False) -> jo.Mechanism:
    """Two bodies in motion that overlap, the first one bent if it is flexible."""
    rng = np.random.default_rng(5)
    first: Any = jo.RigidBody(
        *("first", 2.0, (0.1, 0.2, 0.25)), position=(0.1, -0.2, 0.3),
        orientation=jo.Rotate((1, 2, -1), degrees=40.0),
        velocity=rng.normal(size=3), angular_velocity=rng.normal(size=3),
    )  # fmt: skip
    place = first["origin"]
    if flexible:
        steel = jo.Material(E=2e9, nu=0.3, rho=1000.0)
        part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.03), 6, steel)
        reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=3))
        first = jo.FlexibleBody(
            *("first", reduced), velocity=rng.normal(size=3), angular_velocity=rng.normal(size=3)
        )
        place = first["end"]
    A = rotation_matrix(first.orientation)
    where = first.position + A @ (place.position_local + np.asarray(at))
    turned = first.orientation + (0.0, 0.02, -0.01, 0.03)
    second = jo.RigidBody(
        *("second", 0.7, (0.02, 0.03, 0.04)), position=where,
        orientation=turned / np.linalg.norm(turned),
        velocity=rng.normal(size=3), angular_velocity=rng.normal(size=3),
    )  # fmt: skip
    touch = Contact(
        *("touch", place, on, second.at((0.0, 0.0, 0.0)), of, law),
        mu_kinetic=0.2,
        mu_static=0.3,
        friction=Regularised(0.7),
    )
    sensors = [jo.ForceSensor("force", touch)]
    for marker in (place, second["origin"]):
        sensors.append(jo.AccelerationSensor(f"a {marker.body.name}", marker))
    return jo.Mechanism(first, second, touch, *sensors)


def same(mechanism: jo.Mechanism) -> None:
    """Assert that both formulations have the same sensor values at the start."""
    model = jo.compile(mechanism)
    engine, state = jo.model.Engine(model), State(model.q0, model.v0, np.zeros(model.nrow))
    put(engine, state, "test")
    engine.start_states()
    engine.accelerations()
    values = np.array(engine.sensors())
    found = at_states(mechanism, [state], mechanism.sensors).readings
    for sensor in model.sensors:
        wanted = values[sensor.offset : sensor.offset + sensor.count]
        assert np.abs(wanted).max() > 0.1
        np.testing.assert_allclose(found[sensor.name][0], wanted, atol=1e-11 * np.abs(wanted).max())


@pytest.mark.parametrize(("on", "of", "at"), PAIRS, ids=repr)
def test_forces_of_every_pair(on: Any, of: Any, at: Any) -> None:
    """Normal force with its damper, and smooth friction, on bodies in general motion."""
    same(machine(on, of, at, SpringDamper(2e4, 30.0)))


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
@pytest.mark.parametrize("flexible", [False, True])
def test_laws_and_flexible_bodies(law: Any, flexible: bool) -> None:
    same(machine(HalfSpace(), Sphere(0.1), (0.05, -0.02, 0.092), law, flexible))


def test_runs_of_both_agree() -> None:
    """A ball that lands and slips, with touches at other instants of the steps."""
    ball = jo.RigidBody.sphere(
        "ball", radius=0.05, mass=0.5, position=(0, 0, 0.053), velocity=(0.3, 0, -0.5)
    )
    touch = Contact(
        *("touch", jo.ground["origin"], HalfSpace(), ball["origin"], Sphere(0.05)),
        SpringDamper(2e3, 2.0),
        mu_kinetic=0.3,
        friction=Regularised(0.1),
    )
    mechanism = jo.Mechanism(ball, touch, jo.Gravity((0, 0, -9.81)), jo.ForceSensor("F", touch))
    found = jo.verify(mechanism, 0.03, step=5e-4)
    assert not found.unknown
    assert found.agrees
    assert {row.name for row in found.rows} >= {"F", "energy of springs"}


LEFT_OUT = {
    "restitution=1": {"law": PowerLaw(1e6)},
    "friction=Regularised": {"mu_kinetic": 0.3},
    "resistance to rolling": {"rolling": 1e-3},
    "impulses": {"resolve": "impulse", "law": PowerLaw(1e6, restitution=1.0)},
    "powers of the depth": {"law": JohnsonLine(1e9, 0.1, 0.01, restitution=1.0)},
    "wander": {"shape_b": Ellipsoid((0.1, 0.2, 0.3))},
    "bristles": {"shape_b": ConvexHull([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])},
}


@pytest.mark.parametrize("words", LEFT_OUT)
def test_what_is_left_out_is_said_by_name(words: str) -> None:
    body = jo.RigidBody("body", 1.0, (0.1,) * 3, position=(0, 0, 1))
    given: dict[str, Any] = {"shape_b": Sphere(0.1), "law": SpringDamper(1e4)} | LEFT_OUT[words]
    touch = Contact("touch", jo.ground["origin"], HalfSpace(), body["origin"], **given)
    with pytest.raises(jo.InputError, match=f"touch.*{words}"):
        check_known(jo.Mechanism(body, touch))
