"""Machines at rest on contacts: forces, modes and linear motion against closed forms."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import Contact, Cuboid, HalfSpace, PowerLaw, Sphere, StickSlip
from jousto.simulation.state import put

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely")

G = 9.81


def forces(model: Any, state: Any, contacts: Any) -> dict[str, Any]:
    """Force of each contact at a state, N."""
    engine = jo.model.Engine(model)
    put(engine, state, "test")
    engine.accelerations()
    values = np.array(engine.sensors()).reshape(len(contacts), -1)
    return {contact.name: values[i, :3] for i, contact in enumerate(contacts)}


def stack(mu: float, gap: float) -> Any:
    """Five boxes of 2 kg, 1e6 N/m at each corner, each gap above where it rests."""
    law, size = PowerLaw(1e6, 1.0, restitution=1.0), 0.1
    inertia = (2 / 12 * (0.2**2 + size**2), 2 / 12 * (0.2**2 + size**2), 2 / 6 * 0.2**2)
    below, items = jo.ground["origin"], []
    for i in range(5):
        box = jo.RigidBody(f"b{i}", 2.0, inertia, position=(0, 0, size * (i + 0.5) + gap * (i + 1)))
        items += [box, Contact(f"c{i}", below, HalfSpace(), box["origin"], Cuboid((0.2, 0.2, size)),
                               law, mu_kinetic=mu)]  # fmt: skip
        below = box.at((0, 0, size / 2))
    return jo.compile(jo.Mechanism(*items, jo.Gravity((0, 0, -G))))


@pytest.mark.parametrize("mu", [0.0, 0.5])
def test_stack_of_five_boxes(mu):
    """Lowest corner 24.525 N; the lowest frequency up and down is that of a chain of springs."""
    model = stack(mu, 1e-4)
    state = jo.equilibrium(model)
    assert 0.05 - state.q[2] == pytest.approx(2.4525e-5, rel=1e-8)
    found = 2 * np.pi * jo.modes(model, state).frequencies
    chain = 2 * np.sqrt(4e6 / 2) * np.sin(np.pi / 22)
    assert chain == pytest.approx(402.527148826, rel=1e-11)
    assert np.abs(found - chain).min() < 1e-8 * chain
    linear = np.abs(jo.simulation.linearise(model, state).eigenvalues.imag)
    assert np.abs(linear - chain).min() < 1e-8 * chain
    if not mu:
        assert found[found > 1.0].min() == pytest.approx(chain, rel=1e-8)
    else:
        assert found.min() > 1.0  # bristles hold every direction


@pytest.mark.parametrize("method", ["modes", "damped", "linearise"])
def test_bristles_are_stiffness(method):
    """A ball held on a plane: a spring along z, and shear k at the height of the contact point."""
    m, R, K, k = 2.0, 0.1, 1e7, 0.5 * 1e7
    J = 0.4 * m * R * R
    ball = jo.RigidBody("b", m, (J,) * 3, position=(0, 0, R))
    contact = Contact("c", jo.ground["origin"], HalfSpace(), ball["origin"], Sphere(R),
                      PowerLaw(K, 1.0, restitution=1.0), mu_kinetic=0.5, shear=0.5)  # fmt: skip
    model = jo.compile(jo.Mechanism(ball, contact, jo.Gravity((0, 0, -G))))
    state = jo.equilibrium(model)
    depth = m * G / K
    if method == "linearise":
        found = np.abs(jo.simulation.linearise(model, state).eigenvalues.imag)
    else:
        found = 2 * np.pi * jo.modes(model, state, damped=method == "damped").frequencies
    arm = R - depth / 2
    for wanted in (np.sqrt(K / m), np.sqrt(k * (1 / m + arm**2 / J))):
        assert np.abs(found - wanted).min() < 1e-5 * wanted


@pytest.mark.parametrize(
    ("at", "wanted"),
    [
        ((0.1, 0.05), (34.16666666667, 25 + 5 / 6, 24 + 1 / 6, 15 + 5 / 6)),
        ((0.3, 0.15), (55, 25, 20, 0)),
    ],
)
def test_table_on_four_legs(at, wanted):
    """1 x 0.6 m, 100 N away from the middle: forces by stiffness; a leg lifts."""
    table = jo.RigidBody("t", 10.0, (1, 1, 1))
    law = PowerLaw(1e9, 1.0, restitution=1.0)
    contacts = [
        Contact(
            f"{i}{j}",
            jo.ground["origin"],
            HalfSpace(),
            table.at((0.5 * i, 0.3 * j, 0)),
            Sphere(0.0),
            law,
        )  # fmt: skip
        for i, j in product((1, -1), repeat=2)
    ]
    load = jo.Force("load", table.at((*at, 0)), (0, 0, -100.0))
    sensors = [jo.ForceSensor(f"N{c.name}", c) for c in contacts]
    model = jo.compile(jo.Mechanism(table, *contacts, load, *sensors))
    found = forces(model, jo.equilibrium(model), contacts)
    for contact, N in zip(contacts, wanted, strict=True):
        assert found[contact.name][2] == pytest.approx(N, abs=2e-6)


def test_joints_that_stick_are_refused():
    arm = jo.RigidBody("arm", 1.0, (0.1,) * 3, position=(0, 0, 1))
    joint = jo.Revolute("pin", jo.ground.at((0, 0, 1)), arm["origin"], axis=(0, 1, 0))
    friction = jo.Friction("rub", joint, mu_kinetic=0.1, radius=0.01, law=StickSlip())
    contact = Contact("c", jo.ground["origin"], HalfSpace(), arm.at((1, 0, 0)), Sphere(0.1),
                      PowerLaw(1e6))  # fmt: skip
    model = jo.compile(jo.Mechanism(arm, joint, friction, contact, jo.Gravity((0, 0, -G))))
    with pytest.raises(jo.InputError, match="rub.*sticks beside contacts.*Regularised"):
        jo.equilibrium(model)


def test_a_search_that_ends_without_rest_says_how_far_it_moves():
    """Nothing holds the ball: it rolls down the slope, by a finite share of its size a step."""
    ball = jo.RigidBody.sphere("ball", radius=0.1, mass=1.0, position=(0, 0, 0.1))
    law, floor = PowerLaw(1e6), jo.ground["origin"]
    touch = Contact("touch", floor, HalfSpace(), ball["origin"], Sphere(0.1), law, mu_kinetic=0.5)
    model = jo.compile(jo.Mechanism(ball, touch, jo.Gravity((1.0, 0, -9.7))))
    with pytest.raises(
        jo.SimulationError,
        match=r"still moves by \d\.\de[-+]\d\d rad or of its size in a step of \d",
    ):
        jo.equilibrium(model)
