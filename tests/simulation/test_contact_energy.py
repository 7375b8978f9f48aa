"""Energy of contacts: what they store and lose closes the balance, and nothing is created."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import Capsule, Contact, HalfSpace, PowerLaw, Sphere

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

METHODS = {
    "RK4": lambda step: jo.RK4(step),
    "ROS2": lambda step: jo.ROS2(step),
    "GeneralizedAlpha": lambda step: jo.GeneralizedAlpha(step),
    "DormandPrince": lambda step: jo.simulation.DormandPrince(
        tolerance=1e-6 if step > 5e-4 else 1e-8
    ),
}
LEFT = {"RK4": 1e-4, "ROS2": 4e-3, "GeneralizedAlpha": 4e-3, "DormandPrince": 3e-6}
"""Error of the balance over the energy of the ball at 20 steps a touch."""
RISE = {"RK4": 1.2e-5, "ROS2": 2e-3, "GeneralizedAlpha": 2e-3, "DormandPrince": 2e-6}
"""Rise of the energy over that at the start. The speed after an elastic touch in 20 steps is wrong
by up to 6e-4 (ROS2), 3e-4 (GeneralizedAlpha) and 6e-6 (RK4): twice as much of the energy, more
after several touches. DormandPrince, with tolerances of 1e-6 and 1e-8, shows that the law itself
creates none."""
HALF = 0.5  # m, half the side of the box


def thrown(restitution: float, mu: float) -> tuple[jo.Mechanism, Contact]:
    ball = jo.RigidBody.sphere(
        "ball", radius=0.05, mass=0.1, position=(0, 0, 0.3), velocity=(1.5, 0, 0)
    )
    law = PowerLaw(1e6, restitution=restitution)
    floor = jo.ground["origin"], HalfSpace()
    touch = Contact("floor", *floor, ball["origin"], Sphere(0.05), law, mu_kinetic=mu)
    return jo.Mechanism(ball, touch, jo.Gravity((0, 0, -9.81))), touch


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("e", "mu"), [(1.0, 0.3), (0.6, 0.0), (0.6, 0.05), (0.6, 0.8)])
def test_the_balance_closes(method, e, mu):
    """A ball that slips (mu .05, .3) or catches hold (.8), and loses by restitution or not."""
    machine, _ = thrown(e, mu)
    run = jo.simulate(jo.compile(machine), 0.5, solver=METHODS[method](1e-3), output_step=1e-3)
    energy = run.energy
    start = energy.total[0]
    assert np.abs(energy.error).max() < LEFT[method] * start
    # the parts that belong to the contact are all that is stored and lost
    np.testing.assert_allclose(energy.contacts, energy.springs, atol=1e-15)
    lost = energy.restitution + energy.rubbed
    left = energy.kinetic + energy.potential + energy.contacts + lost - start
    # losses are quadratures over the steps, in rows within an adaptive step a straight line
    assert np.abs(left).max() < (2e-3 + LEFT[method]) * start
    assert np.abs(left[-1]) < (1e-3 + LEFT[method]) * start
    assert energy.restitution[-1] == pytest.approx(energy.dissipated[-1], abs=1e-3 * start)
    assert energy.rubbed[-1] == pytest.approx(energy.friction[-1], abs=1e-3 * start)
    assert (energy.restitution[-1] < 1e-9) == (e == 1.0)
    assert (energy.rubbed[-1] < 1e-9) == (mu == 0.0)
    if method == "RK4":
        assert (np.diff(lost) > -1e-6 * start).all()


def test_a_contact_that_is_switched_off_loses_what_it_stores():
    """The floor disappears while the ball rests on it at its deepest point."""
    machine, touch = thrown(1.0, 0.0)
    height = jo.PositionSensor("height", machine.bodies[0]["origin"])
    gone = jo.mechanism.Event(
        "gone", height, 0.0488, component="z", direction="falling", releases=[touch]
    )
    machine = jo.Mechanism(*machine.bodies, touch, jo.Gravity((0, 0, -9.81)), height, gone)
    run = jo.simulate(jo.compile(machine), 0.4, solver=jo.RK4(1e-3))
    energy = run.energy
    (event,) = run.contacts
    stored = 1e6 * 0.0012**2.5 / 2.5
    assert event.part == pytest.approx(run.events[0].time, abs=1e-9)
    assert event.lost_restitution == pytest.approx(stored, rel=1e-4)
    assert energy.restitution[-1] == pytest.approx(stored, rel=1e-4)
    assert energy.contacts[-1] == 0.0
    assert np.abs(energy.error).max() < LEFT["RK4"] * energy.total[0]


def frame(z: Any) -> Any:
    z = np.asarray(z, dtype=float)
    x = np.roll(z, 1)
    return np.stack([x, np.cross(z, x), z], axis=1)


def box_of_bodies(seed: int) -> jo.Mechanism:
    """Four balls or capsules in a closed box with random laws, speeds and friction."""
    random = np.random.default_rng(seed)
    exponent = float(random.choice([1.0, 1.5]))
    stiffness = 10.0 ** random.uniform(5, 6.5) if exponent > 1.0 else 10.0 ** random.uniform(4, 5.2)
    law = PowerLaw(stiffness, exponent, restitution=float(random.choice([0.3, 0.6, 0.9, 1.0])))
    mu = float(random.choice([0.0, 0.1, 0.3, 0.8]))
    shape: Any = Capsule(0.05, 0.1) if seed % 2 else Sphere(0.08)
    bodies = [
        jo.RigidBody(
            f"b{i}", 0.5, (2e-3, 2.5e-3, 3e-3) if seed % 2 else (1.28e-3,) * 3,
            position=(0.5 * (i % 2) - 0.25, 0.5 * (i // 2) - 0.25, random.uniform(-0.2, 0.2)),
            velocity=random.normal(size=3) * 1.5, angular_velocity=random.normal(size=3) * 5,
        )
        for i in range(4)
    ]  # fmt: skip
    walls = [(name, sign) for name in "xyz" for sign in (-1.0, 1.0)]
    touch = []
    more: dict[str, Any] = {"mu_kinetic": mu, "mu_static": 1.2 * mu}
    for name, sign in walls:
        normal = -sign * np.eye(3)["xyz".index(name)]
        wall = jo.ground.at(-HALF * normal, axes=frame(normal))
        touch += [
            Contact(f"{name}{sign:g} {b.name}", wall, HalfSpace(), b["origin"], shape, law, **more)
            for b in bodies
        ]
    touch += [
        Contact(f"{a.name} {b.name}", a["origin"], shape, b["origin"], shape, law, **more)
        for i, a in enumerate(bodies)
        for b in bodies[:i]
    ]
    return jo.Mechanism(*bodies, *touch, jo.Gravity((0, 0, -9.81 * (seed // 2 % 2))))


def check_energy(seed: int, method: str, step: float) -> None:
    model = jo.compile(box_of_bodies(seed))
    run = jo.simulate(model, 0.3, solver=METHODS[method](step), output_step=1e-3)
    total = run.energy.total
    assert len(run.contacts) > 0
    rise = (total - np.minimum.accumulate(total)).max() / total[0]
    assert rise < RISE[method] + 1e-9, f"box {seed}: the energy rises by {rise:.2g}"


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("seed", range(6))
def test_energy_of_a_closed_system_never_rises(method, seed):
    check_energy(seed, method, 1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("step", [2e-3, 1e-3, 2e-4])
@pytest.mark.parametrize("seed", range(200))
def test_energy_of_200_boxes_never_rises(method, step, seed):
    check_energy(seed, method, step)
