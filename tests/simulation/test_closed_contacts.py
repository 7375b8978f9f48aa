"""Contacts at rest that are far stiffer than the step: the steps that a run then takes."""

from __future__ import annotations

import re
import warnings

import pytest

import jousto as jo
from jousto.mechanism import CollisionShape, Contact, Contacts, HalfSpace, Hertz, PowerLaw, Sphere
from jousto.simulation.running.closed_contacts import closed_contact_warning

G, R = 9.81, 0.05


def resting(law: object, *, in_set: bool, sunk: float) -> jo.Model:
    ball = jo.RigidBody.sphere("ball", radius=R, mass=0.5, position=(0, 0, R - sunk))
    if in_set:
        shapes = [
            CollisionShape("floor", jo.ground["origin"], HalfSpace()),
            CollisionShape("ball", ball["origin"], Sphere(R)),
        ]
        touch = Contacts("feet", shapes, law=law, overlap="start")
    else:
        touch = Contact("feet", jo.ground["origin"], HalfSpace(), ball["origin"], Sphere(R), law)
    return jo.compile(jo.Mechanism(ball, touch, jo.Gravity((0, 0, -G))))


@pytest.mark.filterwarnings("ignore:.*energy balance")
@pytest.mark.parametrize("in_set", [False, True])
@pytest.mark.parametrize(
    "law",
    [
        PowerLaw(1e13, 1.0, restitution=1.0, slowest=1e-9),
        PowerLaw(1e18, 1.5, restitution=1.0, slowest=1e-9),
    ],
)
def test_predicted_steps_are_those_of_the_run(law, in_set):
    """At the depth of the effective mass, 2/7 m; the sentence names step, number and remedy."""
    sunk = (2 / 7 * 0.5 * G / law.stiffness) ** (1 / law.exponent)
    model = resting(law, in_set=in_set, sunk=sunk)
    with pytest.warns(jo.JoustoWarning, match="contact 'feet' is so stiff that RK4 takes") as said:
        run = jo.simulate(model, 2e-3, solver=jo.RK4(2e-3))
    (text,) = [str(one.message) for one in said if "so stiff" in str(one.message)]
    number = float(re.search(r"closed, (\S+) of them", text).group(1))
    assert run.work.steps[-1] == pytest.approx(number, rel=0.5)
    assert "take ROS2 or GeneralizedAlpha" in text


def test_soft_contacts_and_implicit_methods_are_not_named():
    stiff = resting(PowerLaw(1e13, 1.0), in_set=False, sunk=1e-9)
    for solver in (jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3), jo.RK4(1e-7)):
        assert closed_contact_warning(stiff, solver, solver.step) == ""
    steel = jo.Material(210e9, 0.3, 7850.0)
    soft = resting(Hertz.between(steel, restitution=0.5), in_set=False, sunk=1e-9)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert closed_contact_warning(soft, jo.RK4(1e-3), 1e-3) == ""
