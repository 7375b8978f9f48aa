"""Rods, wedges and drawers that jam by friction end in stick, at the angles of closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import Contact, ForceStateSensor, HalfSpace, PowerLaw, Sphere

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

G = 9.81
STICKS = 1
METHODS = (
    jo.RK4(1e-3),
    jo.simulation.DormandPrince(1e-8, output=1e-3),
    jo.ROS2(1e-3),
    jo.GeneralizedAlpha(1e-3),
)


# -- Painleve's rod -------------------------------------------------------------------------------


def rod(mu: float, law: Any, deep: float = 1e-9) -> Any:
    """A rod of 1 kg and 1 m whose tip slides at 1 m/s, ahead of its centre of mass."""
    half, inertia, lean = 0.5, 1 / 12, np.arctan(2.0)
    tilt = jo.Rotate((0, 1, 0), degrees=-float(np.degrees(lean)))
    at = (half * np.cos(lean), 0, half * np.sin(lean) - deep)
    body = jo.RigidBody(
        *("rod", 1.0, (1e-3, inertia, inertia)), position=at, orientation=tilt, velocity=(-1, 0, 0)
    )
    tip = body.at((-half, 0, 0))
    touch = Contact("tip", jo.ground["origin"], HalfSpace(), tip, Sphere(0.0), law, mu_kinetic=mu)
    sensors = (
        jo.PositionSensor("x", tip),
        jo.VelocitySensor("v", tip),
        jo.ForceSensor("N", touch),
        ForceStateSensor("phase", touch, "phase"),
    )
    return jo.compile(jo.Mechanism(body, touch, jo.Gravity((0, 0, -G)), *sensors))


def test_painleves_rod_ends_in_stick():
    """mu = 2 at tan(lean) = 2, above the bound of 4/3: no force solves the rigid equations.

    Rigid, the tip's acceleration along the normal is N (1 + 3 cos(a) (cos(a) - mu sin(a))) / m - g,
    and its factor is negative. With a law the force grows until the tip has stopped, long before
    it would under friction from the weight, in 51 ms.
    """
    lean = np.arctan(2.0)
    assert 1 + 3 * np.cos(lean) * (np.cos(lean) - 2.0 * np.sin(lean)) < -0.5
    model, stops = rod(2.0, PowerLaw(1e6)), []
    for solver in METHODS:
        run = jo.simulate(model, 0.02, solver=solver)
        first = int(np.argmax(run["v"][:, 0] > -0.02))
        assert 0.002 < run.time[first] < 0.02
        assert run["N"][:, 2].max() > 8 * G
        assert (run["phase"][:, 0] == STICKS).any()
        assert run.attributes["contacts"] == "missed: 0 (proven)"
        stops.append(run["x"][:, 0].min())
    assert np.ptp(stops) < 0.02 * np.abs(stops).max()


@pytest.mark.parametrize("solver", METHODS[:2], ids=lambda s: type(s).__name__)
def test_explicit_methods_follow_a_jam(solver):
    """Friction drives the tip in at 200 times the speed of its touch, which is its loss no more.

    With the damper of the touch, 1 mm/s, a jam took 35,600 steps of some 0.1 microseconds.
    """
    run = jo.simulate(rod(2.0, PowerLaw(1e6)), 0.02, solver=solver)
    steps = int(run.attributes["contact steps"].split(" at once")[0])
    assert 1000 < steps < 4000


def test_a_part_at_rest_that_is_struck_keeps_its_law():
    """A ball that sticks to the floor is struck from above at 1 m/s: it touched at 1 mm/s."""
    law = PowerLaw(1e8, restitution=0.5)
    low, high = (
        jo.RigidBody.sphere(
            name, radius=0.05, mass=0.5, position=(0, 0, z - 1e-9), velocity=(0, 0, v)
        )
        for name, z, v in (("low", 0.05, 0.0), ("high", 0.151, -1.0))
    )
    floor, ball = jo.ground["origin"], Sphere(0.05)
    stands = Contact("stands", floor, HalfSpace(), low["origin"], ball, law, mu_kinetic=0.3)
    strikes = Contact("strikes", low["origin"], ball, high["origin"], ball, law, mu_kinetic=0.3)
    sensors = [
        ForceStateSensor("approach", stands, "approach"),
        jo.ForceSensor("N", stands),
    ]
    model = jo.compile(jo.Mechanism(low, high, stands, strikes, *sensors))
    run = jo.simulate(model, 1.5e-3, solver=jo.RK4(1e-5))
    assert run["N"][:, 2].max() > 1e3
    np.testing.assert_allclose(run["approach"], 1e-3)


@pytest.mark.parametrize("solver", METHODS[2:], ids=lambda s: type(s).__name__)
def test_a_jammed_rod_stays(solver):
    """Its tip has stopped and carries the rod, which falls over it; mu of 1.6 and 5, stiff."""
    for mu in (1.6, 5.0):
        run = jo.simulate(rod(mu, PowerLaw(1e8, restitution=0.1)), 0.2, solver=solver)
        late = run.time > 0.1
        assert (run["phase"][late, 0] == STICKS).all()
        assert np.ptp(run["x"][late, 0]) < 1e-4


@pytest.mark.parametrize("solver", [*METHODS[:3], jo.RK4(1e-4)], ids=lambda s: type(s).__name__)
def test_a_touch_at_a_depth_of_rounding(solver):
    """Friction acts against the slip from the second step on: the bristle is at most mu N / k.

    A tip that is 6e-17 m deep at the start had a bristle of 6 cm, in the direction of the slip.
    """
    run = jo.simulate(rod(0.5, PowerLaw(1e6, restitution=1.0), deep=0.0), 0.005, solver=solver)
    assert (run["N"][2:, 0] > 0.4 * run["N"][2:, 2]).all()
    assert run["N"][-1, 0] == pytest.approx(0.5 * run["N"][-1, 2], rel=1e-6)


# -- wedges and drawers ---------------------------------------------------------------------------


def wedge(angles: tuple[float, float], mu: tuple[float, float], depth: float) -> list[Any]:
    """A wedge of no weight between two walls at angles to z, which it overlaps by a depth.

    It moves along x and z; dampers make the motion monotone, of a time constant of some 10 ms.
    """
    guide, body = (jo.RigidBody(name, 0.1, (0.1,) * 3) for name in ("guide", "wedge"))
    x = jo.Prismatic("x", jo.ground["origin"], guide["origin"], axis=(1, 0, 0))
    z = jo.Prismatic("z", guide["origin"], body["origin"], axis=(0, 0, 1))
    law = PowerLaw(1e6, 1.0, restitution=1.0)
    items: list[Any] = [guide, body, x, z]
    items += [jo.Spring(f"drag {j.name}", j.displacement, 0.0, damping=2e4) for j in (x, z)]
    for name, side, angle, friction in zip("lr", (-1, 1), angles, mu, strict=True):
        n = np.array((-side * np.cos(angle), 0, np.sin(angle)))  # out of the wall
        turn = np.column_stack((np.cross((0, 1, 0), n), (0, 1, 0), n))
        wall = jo.ground.at(tuple(depth * n), axes=turn)
        touch = Contact(
            name, wall, HalfSpace(), body["origin"], Sphere(0.0), law, mu_kinetic=friction
        )
        items += [touch, ForceStateSensor(f"phase {name}", touch, "phase")]
        items.append(jo.ForceSensor(f"F {name}", touch))
    return items


@pytest.mark.parametrize(("beyond", "sticks"), [(-1e-6, True), (1e-6, False)])
@pytest.mark.parametrize("solver", METHODS[2:], ids=lambda s: type(s).__name__)
def test_a_wedge_sticks_below_its_angle(solver, beyond, sticks):
    """mu = 0.2: half an angle of 11.30993247402 degrees, to 1e-6 degrees."""
    half = np.radians(11.30993247402 + beyond)
    model = jo.compile(jo.Mechanism(*wedge((half, half), (0.2, 0.2), 1e-3)))
    run = jo.simulate(model, 1.0, solver=solver)
    assert (run["phase l"][-1, 0] == STICKS) == sticks
    assert (run["phase r"][-1, 0] == STICKS) == sticks


@pytest.mark.parametrize(("beyond", "sticks"), [(-1e-6, True), (1e-6, False)])
def test_a_wedge_between_unlike_walls(beyond, sticks):
    """mu = 0.2 and 0.15: 19.84069808397 degrees in all, however they are shared."""
    a = np.radians(9.0)
    b = np.radians(19.84069808397 + beyond) - a
    model = jo.compile(jo.Mechanism(*wedge((a, b), (0.2, 0.15), 1e-3)))
    run = jo.simulate(model, 2.0, solver=jo.ROS2(1e-3))
    assert (run["phase l"][-1, 0] == STICKS) == sticks


def test_force_of_a_driven_wedge():
    """100 N, half an angle of 15 degrees, mu 0.2: N = 50 / (sin a + mu cos a) = 110.6184386 N."""
    half = np.radians(15.0)
    parts = wedge((half, half), (0.2, 0.2), 0.0)
    push = jo.Force("push", parts[1]["origin"], (0, 0, -100.0))
    run = jo.simulate(jo.compile(jo.Mechanism(*parts, push)), 4.0, solver=jo.ROS2(1e-3))
    for name, side in (("l", -1), ("r", 1)):
        normal = run[f"F {name}"][-1, :3] @ (-side * np.cos(half), 0, np.sin(half))
        assert normal == pytest.approx(110.6184386206, rel=1e-8)


@pytest.mark.parametrize(("off", "jams"), [(0.995, False), (1.005, True)])
@pytest.mark.parametrize("solver", METHODS[2:], ids=lambda s: type(s).__name__)
def test_a_drawer_jams(solver, off, jams):
    """400 mm long in its guide, mu 0.2: pushed beside its axis by more than L / 2 mu = 1 m."""
    length, mu, law = 0.4, 0.2, PowerLaw(1e8, 1.0, restitution=0.1, slowest=0.1)
    body = jo.RigidBody("drawer", 1.0, (0.1,) * 3)
    plane = jo.Planar("plane", jo.ground["origin"], body["origin"], normal=(0, 0, 1))
    items: list[Any] = [body, plane]
    for name, at, side in (("front", length / 2, -1), ("back", -length / 2, 1)):
        axes = np.column_stack(((side, 0, 0), (0, 0, -1), (0, side, 0)))
        wall, tip = jo.ground.at((0, 0, 0), axes=axes), body.at((at, 0, 0))
        items.append(Contact(name, wall, HalfSpace(), tip, Sphere(0.0), law, mu_kinetic=mu))
    push = jo.Force("push", body.at((0, -off, 0)), (100.0, 0, 0))
    x, v = jo.PositionSensor("x", body["origin"]), jo.VelocitySensor("v", body["origin"])
    run = jo.simulate(jo.compile(jo.Mechanism(*items, push, x, v)), 1.0, solver=solver)
    if jams:
        assert np.abs(run["v"][-1]).max() < 1e-6
        assert abs(run["x"][-1, 0]) < 1e-3
    else:
        wanted = 100.0 - 2 * mu * 100.0 * off / length
        assert run["v"][-1, 0] == pytest.approx(wanted, rel=0.1)
