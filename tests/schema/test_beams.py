"""Geometrically exact beams in the model file."""

import numpy as np
import pytest

import jousto as jo
from jousto.schema.read import parse_model
from schema.models import same

MODEL = """
bodies:
  - name: rope
    type: beam
    points: [[0, 0, 0], [50 cm, 0, 0]]
    elements: 4
    section: {type: circle, diameter: 8 mm}
    material: {E: 70 GPa, nu: 0.33, rho: 2.7 g/cm3}
    mass: consistent
    bending: true
    damping: {mass: 0.1, stiffness: 1 ms}
    up: [0, 1, 0]
    twist: 90 deg
    offset: [0, 5 mm]
    markers: {grip: 2}
    position: [0, 0, 1]
    angular_velocity: [0, 0, 60 rpm]
  - name: blade
    points: [[0.5, 0, 1], [0.6, 0, 1], [0.7, 0.02, 1], [0.8, 0.02, 1]]
    corners: [1]
    mass: corrected
    straight: true
    twist: [0, 0.1, 0.2, 0.3]
    section:
      - type: stiffness
        stiffness: [1e6, 4e5, 4e5, 20, 30, 40]
        mass: 0.8
        inertia: [2e-4, 1e-4, 1e-4]
      - type: offset
        section: {type: rectangle, width: 20 mm, height: 10 mm}
        material: {E: 70 GPa, nu: 0.33, rho: 2700}
        centroid: [1 mm, 0]
        shear_center: [2 mm, 0]
      - type: stiffness
        stiffness:
          - [1e6, 0, 0, 0, 0, 0]
          - [0, 4e5, 0, 0, 0, 0]
          - [0, 0, 4e5, 0, 0, 0]
          - [0, 0, 0, 20, 5, 0]
          - [0, 0, 0, 5, 30, 0]
          - [0, 0, 0, 0, 0, 40]
        mass: 0.8 kg/m
        inertia: [0.2 kg mm, 1e-4, 1e-4]
        center: [1 mm, 2 mm]
joints:
  - {type: fixed, name: root, a: ground.at0, b: rope.start}
  - {type: fixed, name: weld, a: rope.end, b: blade.node1, as_placed: false}
forces:
  - {type: line, name: wind, beam: rope, force: [0, 3 N/m, 0]}
  - {type: line, name: push, beam: blade, follow: true, signal: {type: step, time: 1},
     force: [[0, 0, 1], [0, 0, 2], [0, 0, 3], [0, 0, 4]], torque: [0.1 N m/m, 0, 0]}
sensors:
  - {type: section, name: root, beam: rope, at: start}
  - {type: section, name: mid, beam: rope, at: 20 cm, quantity: strains}
  - {type: section, name: third, beam: blade, element: e3}
gravity: [0, 0, -9.81]
""".replace("ground.at0", "{body: ground, at: [0, 0, 1]}").replace(
    "rope.end, b: blade.node1, as_placed: false", "rope.end, b: blade.node1"
)


def test_beams_equal_the_python_constructors():
    mechanism = parse_model(MODEL).mechanism
    rope, blade = mechanism.beams
    alu = jo.Material(70e9, 0.33, 2700.0)
    same(
        rope.elements,
        jo.BeamBody(
            "rope",
            [(0, 0, 0), (0.5, 0, 0)],
            jo.Circle(0.008),
            alu,
            elements=4,
            mass="consistent",
            bending=True,
            damping=jo.mechanism.BeamDamping(mass=0.1, stiffness=1e-3),
            up=(0, 1, 0),
            twist=np.pi / 2,
            offset=(0, 0.005),
        ).elements,
    )
    assert rope["grip"].body is rope.bodies[2]
    assert rope.bodies[-1].velocity == pytest.approx([0, np.pi, 0])
    coupled = np.diag([1e6, 4e5, 4e5, 20, 30, 40])
    coupled[3, 4] = coupled[4, 3] = 5
    sections = (
        jo.mechanism.BeamSection((1e6, 4e5, 4e5, 20, 30, 40), 0.8, (2e-4, 1e-4, 1e-4)),
        jo.mechanism.BeamSection.of(
            jo.Rectangle(0.02, 0.01), alu, centroid=(0.001, 0), shear_center=(0.002, 0)
        ),
        jo.mechanism.BeamSection(coupled, 0.8, (2e-4, 1e-4, 1e-4), center=(0.001, 0.002)),
    )
    expected = jo.BeamBody(
        "blade",
        [(0.5, 0, 1), (0.6, 0, 1), (0.7, 0.02, 1), (0.8, 0.02, 1)],
        sections,
        corners=[1],
        mass="corrected",
        straight=True,
        twist=[0, 0.1, 0.2, 0.3],
    )
    same(blade.elements, expected.elements)
    assert np.any(blade.unstressed)  # the twist is no bend: straight
    wind, push = mechanism.forces
    assert wind.force[:, 1] == pytest.approx(np.full(5, 3.0)) and not wind.follow
    assert push.force[:, 2] == pytest.approx([1, 2, 3, 4]) and push.follow
    assert push.torque[:, 0] == pytest.approx(np.full(4, 0.1))
    root, mid, third = mechanism.sensors
    assert (root.element, mid.element, third.element) == (0, 1, 2)
    assert mid.quantity == "strains" and root.components[0] == "N"


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("elements: 4", "elements: 0", "elements is 0"),
        ("at: start", "at: 3 m", "goes from 0 to 0.50"),
        ("beam: rope, force", "beam: rop, force", "did you mean 'rope'"),
        ("rope.end, b", "rope.node9, b", "its nodes are 'node1' to 'node5'"),
        ("diameter: 8 mm", "diameter: -8 mm", "must be a positive number"),
        ("[0, 3 N/m, 0]", "[0, 3 kg, 0]", "expects a stiffness or a force per length"),
        ("mass: consistent", "mass: heavy", "lumped"),
    ],
)
def test_errors_name_the_line(before, after, message):
    assert before in MODEL
    with pytest.raises(jo.InputError, match=message) as error:
        parse_model(MODEL.replace(before, after), name="m.yaml")
    line = MODEL[: MODEL.index(before)].count("\n") + 1
    assert any(p.where.startswith(f"m.yaml:{line}") for p in error.value.problems)
