"""Plastic springs and sensors of their states in model files: units, and what is wrong."""

from __future__ import annotations

import pytest

import jousto as jo
from jousto.schema.read import parse_model
from schema.models import same

MODEL = """\
bodies: [{name: boom, mass: 30 kg, inertia: [66, 66, 66], angular_velocity: [0, 0, 1.8]}]
joints: [{type: revolute, name: root, a: ground.origin, b: boom.origin}]
forces:
  - {type: plastic-spring, name: hinge, coordinate: root.angle, stiffness: 200 kN m/rad,
     strength: 3 kN m, kinematic: 6e4, recovery: 30, saturation: 0.5 kN m, rate: 20}
  - {type: spring, name: stay, coordinate: root.angle, stiffness: 5}
sensors:
  - {type: force-state, name: p, force: hinge}
  - {type: force-state, name: X, force: hinge, state: back}
"""


def test_it_equals_the_python_constructors() -> None:
    mechanism = parse_model(MODEL).mechanism
    (root,) = mechanism.joints
    hinge = jo.mechanism.PlasticSpring(
        *("hinge", root.angle, 2e5, 3000.0),
        kinematic=6e4,
        recovery=30.0,
        saturation=500.0,
        rate=20.0,
    )
    same(mechanism.forces[:1], (hinge,))
    state = jo.mechanism.ForceStateSensor
    same(mechanism.sensors, (state("p", hinge), state("X", hinge, "back")))
    assert [sensor.unit for sensor in mechanism.sensors] == ["rad", "N m"]
    run = jo.simulate(jo.compile(mechanism), 0.05)
    assert run["p"].max() > 0.015


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("strength: 3 kN m,", "", "forces.0: .strength. is missing"),
        ("200 kN m/rad", ".inf", "forces.0.stiffness: is inf, must be finite"),
        (", rate: 20", "", "saturation goes with rate; give it, too"),
        ("force: hinge}", "force: stay}", "spring 'stay' has no states; take a PlasticSpring"),
        ("state: back", "state: bak", "'hinge' has no state 'bak'; did you mean 'back'?"),
        ("kinematic:", "kinematik:", "kinematik.*did you mean 'kinematic'"),
    ],
)
def test_what_is_wrong_is_named(old: str, new: str, message: str) -> None:
    with pytest.raises(jo.InputError, match=message):
        parse_model(MODEL.replace(old, new))
