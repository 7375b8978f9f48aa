"""Parts of an acceleration, Rantalainen 2007, eq. 3.23, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.base.rotations import rotation_matrix
from verification.mechanisms import rod

pytestmark = pytest.mark.filterwarnings("ignore:.*(moves freely|nothing will move|static work)")

Z = (0.0, 0.0, 1.0)
PARTS = ("frame", "normal", "tangential", "coriolis", "relative")
Parts = jo.mechanism.AccelerationPartsSensor


def by_name(row):
    """Return the five vectors of a row by name."""
    return dict(zip(PARTS, np.reshape(row, (5, 3)), strict=True))


def test_a_bead_that_is_driven_along_a_driven_tube():
    """In the tube's axes: (s'' - s W^2) e_r + (s W' + 2 s' W) e_t."""
    tube = jo.RigidBody("tube", 1.0, (0.1, 0.1, 0.1))
    bead = jo.RigidBody("bead", 0.5, (1e-6, 1e-6, 1e-6), position=(0.4, 0, 0))
    shaft = jo.Revolute("shaft", jo.ground["origin"], tube["origin"], Z)
    bore = jo.Prismatic("bore", tube["origin"], bead["origin"], (1, 0, 0))
    turn = jo.Drive("turn", shaft.angle, jo.Harmonic(frequency=0.5, amplitude=0.9))
    way = jo.Harmonic(frequency=0.8, amplitude=0.1, offset=0.4)
    slide = jo.Drive("slide", bore.displacement, way)
    parts = Parts("parts", bead["origin"], relative_to=tube["origin"])
    whole = jo.AccelerationSensor("whole", bead["origin"], resolved_in=tube["origin"])
    model = jo.compile(jo.Mechanism(tube, bead, shaft, bore, turn, slide, parts, whole))
    run = jo.simulation.kinematics(model, np.linspace(0.1, 1.7, 9))
    assert run.about("parts")["components"][9:12] == ("coriolis:x", "coriolis:y", "coriolis:z")
    p, q = np.pi, 1.6 * np.pi  # rad/s of the turn and of the way
    t = run.time
    W, W1 = 0.9 * p * np.cos(p * t), -0.9 * p**2 * np.sin(p * t)
    s, s1 = 0.4 + 0.1 * np.sin(q * t), 0.1 * q * np.cos(q * t)
    s2 = -0.1 * q**2 * np.sin(q * t)
    found = run["parts"].reshape(-1, 5, 3)
    expected = np.zeros_like(found)
    expected[:, 1, 0] = -s * W**2
    expected[:, 2, 1] = s * W1
    expected[:, 3, 1] = 2 * W * s1
    expected[:, 4, 0] = s2
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * scale)  # of the assembly
    np.testing.assert_allclose(found.sum(axis=1), run["whole"], rtol=0, atol=1e-12 * scale)


@pytest.mark.parametrize("degrees", [0.0, 25.0, -70.0])
def test_a_pendulum_has_a_normal_and_a_tangential_part(degrees):
    """(J + m c^2) th'' = -m g c sin th; at the distance L: L w^2 inwards and L th'' across."""
    mass, c, J, g, spin, L = 2.0, 0.9, 0.3, 9.81, 1.7, 1.5
    th = np.deg2rad(degrees)
    bar = jo.RigidBody(
        "bar", mass, (0.2, 0.2, J), center=(c, 0, 0), markers={"tip": (L, 0, 0)},
        orientation=jo.Rotate(Z, degrees=degrees - 90.0), angular_velocity=(0, 0, spin),
    )  # fmt: skip
    hinge = jo.Revolute("hinge", jo.ground["origin"], bar["origin"], Z)
    parts = Parts("parts", bar["tip"], resolved_in=bar["tip"])
    engine = jo.model.Engine(jo.compile(jo.Mechanism(bar, hinge, jo.Gravity((0, -g, 0)), parts)))
    engine.accelerations()
    found = by_name(engine.sensors())
    second = -mass * g * c * np.sin(th) / (J + mass * c**2)
    np.testing.assert_allclose(found["normal"], (-L * spin**2, 0, 0), atol=1e-12)
    np.testing.assert_allclose(found["tangential"], (0, L * second, 0), atol=1e-12)
    for part in ("frame", "coriolis", "relative"):
        np.testing.assert_allclose(found[part], 0, atol=1e-12)


def test_the_relative_part_of_a_flexible_body_is_the_elastic_one():
    """A Phi p'', 2 w x A Phi p', and w' x A (u0 + Phi p), all with the state of the engine."""
    rng = np.random.default_rng(5)
    reduced = rod()
    n = reduced.n
    arm = jo.FlexibleBody(
        "arm", reduced, orientation=jo.Rotate((1, 2, 3), degrees=40.0),
        angular_velocity=(0.5, -1.0, 2.0), modal_coordinates=0.1 * rng.normal(size=n) / n,
        modal_velocities=rng.normal(size=n),
    )  # fmt: skip
    end = arm["end"]
    push = jo.Force("push", arm["start"], (3.0, -2.0, 5.0))
    sensors = (
        Parts("own", end),
        Parts("seen", end, relative_to=arm["node3"], resolved_in=jo.ground["origin"]),
        jo.AccelerationSensor("whole", end),
    )
    model = jo.compile(jo.Mechanism(arm, push, jo.Gravity((0, 0, -9.81)), *sensors))
    engine = jo.model.Engine(model)
    a, _ = engine.accelerations()
    values = engine.sensors()
    row = {s.name: values[s.offset : s.offset + s.count] for s in model.sensors}
    found = by_name(row["own"])
    A = rotation_matrix(engine.q[3:7])
    u = A @ (end.position_local + end.Phi @ engine.q[7:])
    w, w1 = A @ engine.v[3:6], A @ a[3:6]
    expected = {
        "frame": a[:3],
        "normal": np.cross(w, np.cross(w, u)),
        "tangential": np.cross(w1, u),
        "coriolis": 2 * np.cross(w, A @ end.Phi @ engine.v[6:]),
        "relative": A @ end.Phi @ a[6:],
    }
    scale = max(np.abs(x).max() for x in expected.values())
    for part in PARTS:
        assert np.abs(expected[part]).max() > 1e-6 * scale
        np.testing.assert_allclose(found[part], expected[part], rtol=0, atol=1e-12 * scale)
    # from any moving frame the sum is the acceleration in the world
    for key in ("own", "seen"):
        total = row[key].reshape(5, 3).sum(axis=0)
        np.testing.assert_allclose(total, row["whole"], rtol=0, atol=1e-12 * scale)


def test_a_marker_seen_from_itself_and_one_on_the_ground():
    ball = jo.RigidBody("ball", 2.0, (0.3, 0.35, 0.4), angular_velocity=(1, 2, 3))
    tip = ball.at((0.2, 0.1, 0.0))
    sensors = (Parts("itself", tip, relative_to=tip), Parts("ground", jo.ground.at((1, 2, 3))))
    sensors += (jo.AccelerationSensor("whole", tip, resolved_in=tip),)
    engine = jo.model.Engine(jo.compile(jo.Mechanism(ball, *sensors)))
    engine.accelerations()
    values = engine.sensors()
    np.testing.assert_allclose(values[:3], values[30:33], rtol=1e-14)
    np.testing.assert_allclose(values[3:30], 0.0, atol=1e-14)
