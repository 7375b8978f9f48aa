"""Laws of contact over the depth: cylinders by Johnson, tables; friction without a bristle."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import (
    CollisionShape,
    Contact,
    Contacts,
    Cuboid,
    HalfSpace,
    HertzLine,
    Impact,
    Impedance,
    JohnsonLine,
    PowerLaw,
    Regularised,
    Sphere,
    SpringDamper,
    StickSlip,
    TableLaw,
)

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

G = 9.81
STEEL = jo.Material(207e9, 0.3, 7850.0)


def force_at(law: Any, depth: float) -> float:
    """Force of a law at a depth, at rest, N."""
    body = jo.RigidBody("b", 1.0, (1,) * 3, position=(0, 0, -depth))
    contact = Contact("c", jo.ground["origin"], HalfSpace(), body["origin"], Sphere(0.0), law)
    engine = jo.model.Engine(jo.compile(jo.Mechanism(body, contact)))
    return float(engine.accelerations()[0][2])


def energy_at(law: Any, depth: float) -> float:
    """Elastic energy of a law at a depth, J."""
    body = jo.RigidBody("b", 1.0, (1,) * 3, position=(0, 0, -depth))
    contact = Contact("c", jo.ground["origin"], HalfSpace(), body["origin"], Sphere(0.0), law)
    engine = jo.model.Engine(jo.compile(jo.Mechanism(body, contact)))
    engine.accelerations()
    return float(engine.energy()[3])


def test_pin_in_its_hole_by_johnson():
    """10.5 and 10 mm, 20 mm long: 814.618 N at 1 um; the equation ends at 0.5413 dR."""
    law = JohnsonLine.between(STEEL, length=0.02, radii=5e-4)
    assert force_at(law, 1e-6) == pytest.approx(814.6181682512, rel=1e-11)
    modulus = 207e9 / (2 * (1 - 0.09))
    q, b = np.pi * modulus * 0.02, 4 * np.pi * modulus * 0.02 * 5e-4
    depth = 1e4 / q * (np.log(b / 1e4) - 1)
    assert force_at(law, depth) == pytest.approx(1e4, rel=1e-11)
    slope = (force_at(law, depth + 1e-10) - force_at(law, depth - 1e-10)) / 2e-10
    assert slope == pytest.approx(1357338474.839, rel=1e-6)


def test_johnson_continues_along_its_tangent():
    law = JohnsonLine(1e11, 0.01, 1e-3)
    end = 4e-3 * 1.25 * np.exp(-2.25)
    F = [force_at(law, end * x) for x in (1 - 1e-6, 1 + 1e-6, 1.5, 2.0)]
    assert F[1] / F[0] == pytest.approx(1.0, abs=1e-5)
    assert (F[3] - F[2]) / (0.5 * end) == pytest.approx(np.pi * 1e9 / 0.25, rel=1e-11)


def test_line_by_its_length():
    law = HertzLine.between(STEEL, length=0.02)
    assert force_at(law, 1e-6) == pytest.approx(np.pi / 4 * 207e9 / 1.82 * 0.02 * 1e-6, rel=1e-12)


D = np.array([0, 0.4e-3, 1e-3, 1.5e-3])
F = np.array([0.0, 100.0, 700.0, 2000.0])


def test_a_table_is_the_cubic_of_fritsch_and_carlson():
    from scipy.interpolate import PchipInterpolator

    law, exact = TableLaw(D, F), PchipInterpolator(D, F)
    for depth in np.linspace(1e-6, 1.5e-3, 23):
        assert force_at(law, depth) == pytest.approx(float(exact(depth)), rel=1e-12)
    rows = law.rows
    assert rows[:, 3] == pytest.approx([float(exact.integrate(0, d)) for d in D], rel=1e-12)
    beyond = force_at(law, 2.5e-3)
    assert beyond == pytest.approx(2000 + 1e-3 * rows[-1, 2], rel=1e-12)


@pytest.mark.parametrize(
    "numbers",
    [(0.9, 0.95, 1e-3, 0.5, 2.0), (1e-4, 0.9999, 0.01, 0.2, 1.5), (0.5, 0.5, 1e-3, 0.5, 2.0)],
)
def test_impedance_of_robot_files(numbers):
    """a by the formula of MuJoCo's documentation, F = K d a^2 / (1 - a); its energy by SciPy."""
    from scipy.integrate import quad

    low, high, width, middle, power = numbers
    law = Impedance(1e4, *numbers, restitution=1.0)

    def force(d: float) -> float:
        x = min(d / width, 1.0)
        late = 1 - (1 - x) ** power / (1 - middle) ** (power - 1)
        a = low + (high - low) * (x**power / middle ** (power - 1) if x <= middle else late)
        return 1e4 * d * a * a / (1 - a)

    depths = width * np.array([0.05, middle, 0.7, 0.999, 2.0])
    for depth in depths:
        assert force_at(law, depth) == pytest.approx(force(depth), rel=1e-11)
        exact = quad(force, 0, depth, points=[min(depth, x * width) for x in (middle, 1)])[0]
        assert energy_at(law, depth) == pytest.approx(exact, rel=1e-6)


LAWS = [
    TableLaw(D, F, restitution=0.6),
    TableLaw(D, F, restitution=1.0),
    JohnsonLine(1e8, 0.01, 5e-3, restitution=0.6),
    JohnsonLine(1e10, 0.01, 1e-3, restitution=0.3),
    HertzLine(1e9, 0.01, restitution=0.8),
    Impedance(2e5, 0.1, 0.95, 5e-3, 0.3, 3.0, restitution=0.5),
]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: f"{type(law).__name__} {law.restitution}")
@pytest.mark.parametrize("speed", [0.02, 2.0])
def test_restitution_is_what_was_asked_for(law, speed):
    """Whatever the curve, with a step longer than the touch."""
    body = jo.RigidBody("b", 0.3, (1e-3,) * 3, position=(0, 0, 1e-4), velocity=(0, 0, -speed))
    contact = Contact("c", jo.ground["origin"], HalfSpace(), body["origin"], Sphere(0.0), law)
    v = jo.VelocitySensor("v", body["origin"])
    run = jo.simulate(jo.compile(jo.Mechanism(body, contact, v)), 0.1, solver=jo.RK4(2e-3))
    assert run["v"][-1, 2] / speed == pytest.approx(law.restitution, rel=1e-4)
    assert np.abs(run.energy.error).max() < 5e-4 * 0.15 * speed**2


@pytest.mark.parametrize(
    "law",
    [LAWS[0], JohnsonLine(1e6, 0.05, 0.3), HertzLine(1e6, 0.05), Impedance(1e5, 0.2, 0.9, 3e-3)],
    ids=["table", "line", "hertz", "impedance"],
)
@pytest.mark.parametrize(
    "more", [{}, {"mu_kinetic": 0.3, "mu_static": 0.4, "friction": Regularised(2.0)}]
)
def test_tangent_is_the_derivative(law, more):
    """Newton's matrix against complex steps; slips below, above and beyond twice the velocity."""
    rng = np.random.default_rng(5)
    for speed in (0.5, 1.0, 3.0):
        v, w = speed * rng.normal(size=3), rng.normal(size=3)
        body = jo.RigidBody(
            "b", 1.0, (0.05, 0.06, 0.07), position=(0, 0, 0.099), velocity=v, angular_velocity=w
        )
        contact = Contact(
            "c", jo.ground["origin"], HalfSpace(), body["origin"], Sphere(0.1), law, **more
        )
        engine = jo.model.Engine(jo.compile(jo.Mechanism(body, contact)))
        assert engine.states[0]
        engine.accelerations()
        exact = engine.tangent()
        for M, weights in ((exact.K, (0.0, 0.0, 1.0)), (exact.D, (0.0, 1.0, 0.0))):
            N = engine.newton_matrix(*weights)[: len(M), : len(M)]
            assert np.abs(M - N).max() <= 1e-12 * np.abs(M).max()


@pytest.mark.parametrize("law", [SpringDamper(1e5, 10.0), Impact(1e6, 1.5, 10.0, 1e-3)])
def test_tangent_of_slow_slips_of_laws_without_restitution(law):
    """Slips of 5 um/s turn as the friction law has them: their scale is not a speed of 1 m/s."""
    body = jo.RigidBody("b", 1.0, (1,) * 3, position=(0, 0, -1e-3), velocity=(5e-6, 2e-6, 0))
    contact = Contact(
        *("c", jo.ground["origin"], HalfSpace(), body["origin"], Sphere(0.0), law), mu_kinetic=0.3
    )
    engine = jo.model.Engine(jo.compile(jo.Mechanism(body, contact)))
    assert engine.states[0] == 2  # slips
    engine.accelerations()
    exact = engine.tangent().D
    N = engine.newton_matrix(0.0, 1.0, 0.0)[: len(exact), : len(exact)]
    assert np.abs(exact).max() > 1e6  # mu N / |slip|
    assert np.abs(exact - N).max() <= 1e-12 * np.abs(exact).max()


@pytest.mark.parametrize("law", [SpringDamper(1e5, 10.0), Impact(1e8)])
def test_speed_of_a_slow_approach(law):
    """A drop from 10 mm: sqrt(2 g h), also below 1 m/s and without a restitution."""
    body = jo.RigidBody("b", 1.0, (1e-3,) * 3, position=(0, 0, 0.06))
    contact = Contact("c", jo.ground["origin"], HalfSpace(), body["origin"], Sphere(0.05), law)
    model = jo.compile(jo.Mechanism(body, contact, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 0.047, solver=jo.RK4(1e-4))
    assert run.contacts[0].approach == pytest.approx(np.sqrt(2 * G * 0.01), rel=1e-9)


def incline(angle: float, speed: float, solver: Any, t: float, core: str, velocity: float) -> Any:
    """A block of 1 kg on a ramp, mu 0.4 and 0.3, Regularised(velocity); x up the ramp."""
    turn, K = np.radians(angle), 1e7
    sunk = G * np.cos(turn) / (4 * K)
    body = jo.RigidBody(
        "b", 1.0, (0.01, 0.012, 0.015), position=(0, 0, 0.05 - sunk), velocity=(speed, 0, 0)
    )
    contact = Contact(
        "c", jo.ground["origin"], HalfSpace(), body["origin"], Cuboid((0.4, 0.4, 0.1)),
        PowerLaw(K, 1.0),
        mu_kinetic=0.3, mu_static=0.4, friction=Regularised(velocity),
    )  # fmt: skip
    gravity = jo.Gravity((-G * np.sin(turn), 0, -G * np.cos(turn)))
    sensors = (jo.PositionSensor("x", body["origin"]), jo.VelocitySensor("v", body["origin"]))
    model = jo.compile(jo.Mechanism(body, contact, gravity, *sensors), core=core)
    return jo.simulate(model, t, solver=solver)


CASES = [
    (jo.ROS2(1e-3), "joint"),
    (jo.ROS2(1e-3), "maximal"),
    (jo.GeneralizedAlpha(2e-4), "maximal"),
]


@pytest.mark.parametrize(("solver", "core"), CASES)
def test_a_block_with_smooth_friction_creeps(solver, core):
    """tan 15 deg = 0.4 w (15 - 10 w^2 + 3 w^4) / 8: w = 0.397, where a bristle stays."""
    run = incline(15.0, 0.0, solver, 2.0, core, 1e-3)
    roots = np.roots([3, 0, -10, 0, 15, -8 * np.tan(np.radians(15)) / 0.4])
    (w,) = [r.real for r in roots if abs(r.imag) < 1e-12 and 0 < r.real < 1]
    assert w == pytest.approx(0.397, abs=5e-4)
    assert -run["v"][-1, 0] == pytest.approx(1e-3 * w, rel=1e-6)
    assert np.abs(run.energy.error).max() < 1e-6


@pytest.mark.parametrize(("solver", "core"), CASES)
def test_a_block_with_smooth_friction_slides_back(solver, core):
    """Up 25 degrees at 3 m/s: it stops, and is back after 1.3855 s, sooner by its turn at v / g."""
    run = incline(25.0, 3.0, solver, 1.6, core, 1e-4)
    a = np.radians(25.0)
    up = 9 / (2 * G * (np.sin(a) + 0.3 * np.cos(a)))
    x, t = run["x"][:, 0], run.time
    assert x.max() == pytest.approx(up, rel=1e-4)
    i = np.argmax((x < 0) & (t > 0.5))
    back = t[i - 1] + (t[i] - t[i - 1]) * x[i - 1] / (x[i - 1] - x[i])
    assert back == pytest.approx(1.385514397, abs=2e-4)


@pytest.mark.parametrize("heading", [0.0, 20.0, 45.0])
def test_smooth_friction_is_a_circle(heading):
    """2 m/s, mu 0.4: it keeps its line and stops after v^2 / 2 mu g in every direction."""
    e = np.array([np.cos(np.radians(heading)), np.sin(np.radians(heading)), 0.0])
    body = jo.RigidBody("p", 1.0, (0.01,) * 3, position=(0, 0, -G / 4e7), velocity=2 * e)
    contact = Contact(
        "c", jo.ground["origin"], HalfSpace(), body["origin"], Sphere(0.0), PowerLaw(4e7, 1.0),
        mu_kinetic=0.4, friction=Regularised(1e-3),
    )  # fmt: skip
    x = jo.PositionSensor("x", body["origin"])
    model = jo.compile(jo.Mechanism(body, contact, jo.Gravity((0, 0, -G)), x))
    end = jo.simulate(model, 1.0, solver=jo.ROS2(1e-3))["x"][-1]
    assert abs(end[1] * e[0] - end[0] * e[1]) < 1e-12
    assert end @ e == pytest.approx(4 / (2 * 0.4 * G), rel=2e-4)


@pytest.mark.parametrize(
    ("depths", "forces", "message"),
    [
        ([0, 1, 2], [0, 1], "3 depths and 2 forces"),
        ([0], [0], "1 depths and 1 forces"),
        ([0.1, 1], [0, 1], "depths start at 0.1"),
        ([0, 1], [5, 6], "forces start at 5"),
        ([0, 2, 1], [0, 1, 2], "depths must rise: 2 is followed by 1"),
        ([0, 1, 2], [0, 1, 1], "forces must rise: 1 is followed by 1"),
        ([0, np.nan], [0, 1], "depths"),
    ],
)
def test_tables_that_are_refused(depths, forces, message):
    with pytest.raises(jo.InputError, match=message):
        TableLaw(depths, forces)


def test_what_is_refused():
    body = jo.RigidBody("b", 1.0, (1,) * 3, position=(0, 0, 1))
    ground = jo.ground["origin"]
    ball = (ground, HalfSpace(), body["origin"], Sphere(0.1))
    with pytest.raises(jo.InputError, match="mu_kinetic is 0; give mu_kinetic"):
        Contact("c", *ball, PowerLaw(1e6), friction=StickSlip())  # type: ignore[arg-type]
    with pytest.raises(jo.InputError, match="with a restitution, not TableLaw"):
        Contact("c", *ball, TableLaw(D, F), resolve="impulse")
    boxes = (ground, Cuboid((1, 1, 1)), body["origin"], Cuboid((1, 1, 1)))
    with pytest.raises(jo.InputError, match="among corners, which a TableLaw does not"):
        Contact("c", *boxes, TableLaw(D, F))
    shapes = [
        CollisionShape("a", ground, HalfSpace()),
        CollisionShape("b", body["origin"], Sphere(1)),
    ]
    with pytest.raises(jo.InputError, match="a set of contacts has no TableLaw"):
        Contacts("c", shapes, law=TableLaw(D, F))
    with pytest.raises(jo.InputError, match="an impulse has no moment that resists rolling"):
        Contacts("c", shapes, law=PowerLaw(1e6), rolling=0.1, resolve="impulse")
