"""Ropes with mass and on sheaves that turn: closed forms, energy, tangents, bad input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import Reeving, StateSensor
from jousto.schema.read import parse_model
from model.test_newton import assert_exact
from model.test_ropes import down, mass

G, R = 9.81, 0.2


def watch(rope: Reeving) -> list[StateSensor]:
    names = (*rope.outputs, *rope.starts)
    return [StateSensor(name, rope[name]) for name in names]


def atwood(
    rho: float, J: float, EA: float = 1e9, core: str = "auto", damping: float = 1e-2
) -> tuple[jo.Model, float]:
    """Masses of 10 and 9 kg on a rope of 10 m over a wheel; the height of the wheel over them."""
    high = 0.5 * (10.0 - np.pi * R)
    loads = [mass(name, m, x, -high) for name, m, x in (("a", 10.0, -R), ("b", 9.0, R))]
    wheel = jo.RigidBody("wheel", 3.0, (J, J, J))
    axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"])
    path = loads[0]["origin"], wheel["origin"], loads[1]["origin"]
    tension = 9.5 * G + rho * high * G / 2
    rope = Reeving(
        *("rope", path, (0, -R, 0)), stiffness=EA, damping=damping * EA, hinges=axle.angle,
        mass_per_length=rho, length=10.0 / (1 + tension / EA),
    )  # fmt: skip
    place = jo.PositionSensor("a", loads[0]["origin"])
    sensors = place, jo.CoordinateSensor("turn", axle.angle)
    return down(*loads, wheel, axle, rope, *sensors, *watch(rope), core=core), high


@pytest.mark.parametrize("core", ["maximal", "joint"])
def test_a_rope_with_mass_falls_over_a_wheel(core):
    """``(m1 + m2 + rho l + J/R^2) x'' = (m1 - m2) g + 2 rho g x``: 0.1320912015 m in 1 s."""
    model, high = atwood(2.0, 0.05, core=core)
    run = jo.simulate(model, 1.0, solver=jo.GeneralizedAlpha(1e-3))
    fall = -high - run["a"][-1, 1]
    assert fall == pytest.approx(0.1320912015, rel=1e-6)
    rate = np.sqrt(4.0 * G / (19.0 + 20.0 + 0.05 / R**2))
    assert 0.25 * (np.cosh(rate) - 1.0) == pytest.approx(0.1320912015, rel=1e-9)


def test_a_wheel_has_inertia():
    """``(m1 + m2 + J/R^2) x'' = (m1 - m2) g``, and both tensions follow from it."""
    model, high = atwood(0.0, 0.5)
    run = jo.simulate(model, 0.5, solver=jo.GeneralizedAlpha(2e-3))
    a = G / (19.0 + 0.5 / R**2)
    assert -high - run["a"][-1, 1] == pytest.approx(0.5 * a * 0.5**2, rel=1e-6)
    assert run["tension"][-1, 0] == pytest.approx(10.0 * (G - a), rel=1e-6)
    assert run["tension_end"][-1, 0] == pytest.approx(9.0 * (G + a), rel=1e-6)


@pytest.mark.parametrize("rho", [0.0, 2.0])
def test_the_energy_of_the_rope_is_kept(rho):
    """Energy of bodies and rope less the work of its weight: constant while the rope vibrates.

    The weight m g of each side works at the speed c of the rope there; rope that passes the wheel
    changes from one speed to the other.
    """
    model, high = atwood(rho, 0.05, EA=1e5, damping=0.0)
    run = jo.simulate(model, 0.5, solver=jo.RK4(1e-4))
    assert np.ptp(run["stored"]) > 1e-3
    e = run.energy
    total = e.kinetic + e.potential + run["stored"][:, 0] + run["kinetic"][:, 0]
    if rho:
        half = 5.0 / (1 + (9.5 * G + rho * high * G / 2) / 1e5)
        passed = -R * run["turn"][:, 0]
        m = np.stack([half - passed, half + passed]) * rho
        c = np.stack([run["speed1"][:, 0], run["speed2"][:, 0]])
        energy = 0.5 * (m * c**2).sum(axis=0)
        np.testing.assert_allclose(run["kinetic"][:, 0], energy, rtol=1e-9)
        power = G * (m[1] * c[1] - m[0] * c[0])
        power += 0.5 * np.gradient(m[0], run.time) * (c[0] ** 2 - c[1] ** 2)
        steps = 0.5 * (power[1:] + power[:-1]) * np.diff(run.time)
        total[1:] -= np.cumsum(steps)
    assert np.ptp(total) < 1e-5 * np.ptp(e.potential)


def hoist(a: float, EA: float = 1e8, g: float = G) -> jo.Model:
    """A block of 50 kg on two parts of 6 m of rope of 3 kg/m, hoisted with a/2."""
    block = jo.RigidBody("block", 50.0, (5, 5, 5), position=(R, -6, 0))
    tension = 25.0 * G + 9.0 * G
    path = jo.ground["origin"], block["origin"], jo.ground.at((2 * R, 0, 0))
    rope = Reeving(
        *("rope", path, (0, R, 0)), stiffness=EA, damping=1e-2 * EA, mass_per_length=3.0,
        length=(12.0 + np.pi * R) / (1 + tension / EA), winch=jo.Table([0, 10], [0, -10 * a]),
    )  # fmt: skip
    place = jo.PositionSensor("p", block["origin"]), jo.VelocitySensor("v", block["origin"])
    items = block, rope, *place, *watch(rope), jo.Gravity((0, -g, 0))
    return jo.compile(jo.Mechanism(*items))


def test_tensions_of_a_rope_that_is_hoisted():
    """The fixed part hangs, the other one accelerates; on the rim the rope turns its momentum.

    At the block ``2 T - 2 rho v^2 = m (g + v')`` with the speed v of the block and of the rope on
    its rim, at the drum ``T + rho l (g + 2 v')``, at the fixed end ``T + rho l g``.
    """
    a, rho = 1.0, 3.0
    model = hoist(a)
    run = jo.simulate(model, 1.0, solver=jo.GeneralizedAlpha(2e-3))
    v, l = run["v"][-1, 1], -run["p"][-1, 1] + 0.5 * np.pi * R
    assert v == pytest.approx(0.5 * a, rel=1e-5)
    T = 25.0 * (G + 0.5 * a) + rho * v**2
    assert rho * v**2 > 0.7
    assert run["tension"][-1, 0] == pytest.approx(T + rho * l * (G + a), abs=1e-3)
    assert run["tension_end"][-1, 0] == pytest.approx(T + rho * l * G, abs=1e-3)


@pytest.mark.parametrize("factor", [1.0, 0.5])
def test_a_rope_with_mass_at_rest(factor):
    """The tension grows by the weight of the rope below, with any gravity."""
    model = hoist(0.0, EA=1e6, g=factor * G)
    rest = jo.equilibrium(model)
    run = jo.simulate(model, 1e-3, state=rest, solver=jo.GeneralizedAlpha(1e-3))
    l = -run["p"][0, 1] + 0.5 * np.pi * R
    # the stretched rope has 4e-4 less mass over its length
    wanted = factor * G * (25.0 + 3.0 * l)
    assert run["tension"][0, 0] == pytest.approx(wanted, rel=3e-4)
    assert run["tension_end"][0, 0] == pytest.approx(wanted, rel=3e-4)


def test_the_weight_follows_the_gravity_of_a_variant():
    """Another gravity of a compiled machine reaches the rope as well."""
    engine = jo.model.Engine(hoist(0.0))
    rates = []
    for factor in (1.0, 0.5):
        engine.gravity[:] = (0, -factor * G, 0)
        engine.accelerations()
        rates.append(np.array(engine.state_rates))
    # fall and rise of both parts by gravity: half of it
    np.testing.assert_allclose((rates[0] - rates[1])[[2, 4]], (0.5 * G, -0.5 * G), rtol=1e-9)


def test_tangents_of_a_rope_with_mass():
    rng = np.random.default_rng(5)
    model, _ = atwood(2.0, 0.05, EA=1e4, core="maximal")
    engine = jo.model.Engine(model)
    engine.v[:] = 0.1 * rng.normal(size=engine.model.nv)
    engine.accelerations()
    assert_exact(engine, 1e-11)


def test_the_rope_starts_with_the_bodies():
    """A block that falls with 1 m/s, its rope with it: no jump of the tension."""
    block = jo.RigidBody("block", 50.0, (5, 5, 5), position=(R, -6, 0), velocity=(0, -1.0, 0))
    path = jo.ground["origin"], block["origin"], jo.ground.at((2 * R, 0, 0))
    rope = Reeving(
        *("rope", path, (0, R, 0)), stiffness=1e6, mass_per_length=3.0, winch=2.0,
        length=(12.0 + np.pi * R) / (1 + 333.0 / 1e6),
    )  # fmt: skip
    # the drum pays out 2 m/s on its side, the fixed part is at rest
    assert rope.starts["speed1"] == pytest.approx(2.0, abs=1e-12)
    assert rope.starts["speed2"] == pytest.approx(0.0, abs=1e-12)


def test_what_is_refused_and_why():
    load, top = mass("load", 1.0, 0.2, -3), jo.ground["origin"]
    wheel = jo.RigidBody("wheel", 1.0, (1, 1, 1))
    axle = jo.Revolute("axle", top, wheel["origin"])
    other = jo.Revolute("other", jo.ground.at((5, 0, 0)), load.at((0, 1, 0)))
    path = jo.ground.at((-R, -3, 0)), wheel["origin"], load["origin"]

    def refused(text: str, **more: Any) -> None:
        with pytest.raises(InputError, match=text):
            Reeving("rope", path, (0, -R, 0), **({"stiffness": 1e6} | more))

    refused(r"hinges\[0\].*turns no sheave of the path", hinges=other.angle)
    refused(r"efficiencies\[1\] at wheel.origin is 0.9, must be 1: the sheave turns; declare",
            hinges=axle.angle, efficiencies=(1, 0.9, 1))  # fmt: skip
    refused("mass_per_length is -1 kg/m, must not be negative", mass_per_length=-1)
    refused("mass_per_length is nan", mass_per_length=np.nan)
    refused("hinges", hinges=3.0)


FILE = """
bodies:
  - {name: a, mass: 10 kg, inertia: [1, 1, 1], position: [-0.2, -5, 0]}
  - {name: wheel, mass: 3 kg, inertia: [0.05, 0.05, 0.05]}
joints:
  - {type: revolute, name: axle, a: ground.origin, b: wheel.origin}
gravity: [0, -9.81, 0]
states:
  - type: reeving
    name: rope
    path: [a.origin, wheel.origin, {body: ground, at: [200 mm, -5 m, 0 m]}]
    radii: [0 m, -200 mm, 0 m]
    stiffness: 1 MN
    damping: 5 kN s/m
    hinges: [axle.angle]
    mass_per_length: 2 kg/m
sensors:
  - {type: state, name: pull, of: rope.tension_end, unit: N}
"""


def test_a_model_file_is_the_same_machine():
    a, wheel = mass("a", 10.0, -0.2, -5), jo.RigidBody("wheel", 3.0, (0.05, 0.05, 0.05))
    axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"])
    rope = Reeving(
        "rope", (a["origin"], wheel["origin"], jo.ground.at((0.2, -5, 0))), (0, -0.2, 0),
        stiffness=1e6, damping=5e3, hinges=axle.angle, mass_per_length=2.0,
    )  # fmt: skip
    model = down(a, wheel, axle, rope, StateSensor("pull", rope["tension_end"], unit="N"))
    read = jo.compile(parse_model(FILE).mechanism)
    runs = [jo.simulate(one, 0.2, solver=jo.GeneralizedAlpha(1e-3)) for one in (model, read)]
    np.testing.assert_allclose(runs[0]["pull"], runs[1]["pull"], rtol=1e-9)
