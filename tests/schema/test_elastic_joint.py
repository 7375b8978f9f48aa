"""Elastic joints in model files: units, names of their items, and what is wrong."""

from __future__ import annotations

import pytest

import jousto as jo
from jousto.mechanism import ElasticJoint, HarmonicDrive
from jousto.schema.read import parse_model
from schema.models import same

MODEL = """\
bodies:
  - {name: link, mass: 4 kg, inertia: [0.01, 0.16, 0.16], center: [0.4, 0, 0]}
  - {name: tool, mass: 1 kg, inertia: [0.01, 0.01, 0.01], position: [0.8, 0, 0]}
joints:
  - {type: revolute, name: shoulder, a: ground.origin, b: link.origin, axis: [0, 1, 0]}
  - {type: prismatic, name: slide, a: {body: link, at: [0.8, 0, 0]}, b: tool.origin,
     axis: [1, 0, 0]}
elastic_joints:
  - name: shoulder
    coordinate: shoulder.angle
    ratio: 100
    rotor_inertia: 3.5e-5 kg m2
    law: {type: harmonic-drive, stiffness: [10 kN m/rad, 1.4e4, 1.7e4], torques: [14, 48 N m]}
    windup: 0.1 deg
  - {name: slide, coordinate: slide.displacement, ratio: 1200 1/m, rotor_inertia: 2e-5,
     stiffness: 30 kN/mm, coupling: reduced, rotor_mass: 200 g, brake: true}
couplings:
  - {type: drive, name: turn, coordinate: shoulder motor.angle, signal: 0}
forces:
  - {type: gear-spring, name: belt, coordinate: slide.displacement, motor: shoulder motor.angle,
     ratio: 90 1/m, stiffness: 5 N/mm, damping: 2 N s/m}
sensors:
  - {type: force, name: torque, force: shoulder gear}
  - {type: reaction, name: bearing, joint: shoulder motor}
"""


def test_it_equals_the_python_constructors() -> None:
    mechanism = parse_model(MODEL).mechanism
    shoulder, slide = mechanism.joints[:2]
    law = HarmonicDrive(stiffness=(1e4, 1.4e4, 1.7e4), torques=(14, 48))
    one = ElasticJoint(
        *("shoulder", shoulder.angle, 100, 3.5e-5), law=law, windup=0.1 * 3.141592653589793 / 180
    )
    two = ElasticJoint(
        *("slide", slide.displacement, 1200, 2e-5, 3e7),
        coupling="reduced",
        rotor_mass=0.2,
        brake=True,
    )
    same(mechanism.assemblies, (one, two))
    same(mechanism.joints[2:], (one.bearing, two.bearing, two.items[-1]))
    belt = jo.mechanism.GearSpring(*("belt", slide.displacement, one.motor, 90.0, 5e3), damping=2.0)
    same(mechanism.forces, (one.gear, two.gear, belt))
    same(mechanism.sensors[0], jo.ForceSensor("torque", one.gear))
    run = jo.simulate(jo.compile(mechanism), 0.01)
    assert run["torque"].shape[1] == 2


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("ratio: 100\n", "ratio: 0\n", r"elastic_joints.0.ratio: ratio is 0, must not be zero"),
        ("ratio: 1200 1/m", "ratio: 1200 m", "elastic_joints.1.ratio: expects a number in 1/m"),
        ("force: shoulder gear", "force: shoulder geer", "no force 'shoulder geer'; did you mean"),
        ("joint: shoulder motor", "joint: shoulder moto", "did you mean 'shoulder motor'"),
        ("coordinate: shoulder.angle", "coordinate: shouldr.angle", "no joint 'shouldr'"),
        ("rotor_mass", "rotor_mas", "unknown key 'rotor_mas'; did you mean 'rotor_mass'"),
        ("torques: [14, 48 N m]", "torques: [14]", "3 values of stiffness but 1 torques"),
        ("3.5e-5 kg m2", "0", "rotor_inertia is 0 kg m2, must be positive"),
        ("name: slide, coordinate", "name: shoulder, coordinate", "begin with 'shoulder '"),
    ],
)
def test_what_is_wrong_is_named(old: str, new: str, message: str) -> None:
    with pytest.raises(jo.InputError, match=message):
        parse_model(MODEL.replace(old, new))


def test_a_name_with_an_error_is_reported_once() -> None:
    with pytest.raises(jo.InputError) as error:
        parse_model(MODEL.replace("coordinate: shoulder.angle", "coordinate: shouldr.angle"))
    assert "depends on itself" not in str(error.value)
    assert "shoulder motor" not in str(error.value)
