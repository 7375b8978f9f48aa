"""Models and the comparison that the tests of model files share."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

PENDULUM = """\
name: flexible pendulum
parts:
  rod:
    type: beam
    length: 2 m
    section: {type: rectangle, width: 100 mm, height: 0.1}
    material: {E: 210 GPa, nu: 0.3, rho: 7.85 g/cm3}
    elements: 4
    lumped: true
    theory: {type: euler-bernoulli}
    reduce: {type: craig-bampton, interfaces: [start], modes: 4}
bodies:
  - {name: arm, part: rod, damping: 0.0, position: [0, 0, 0]}
joints:
  - {type: spherical, name: pivot, a: ground.origin, b: arm.start}
gravity: [0, -9.81, 0]
sensors:
  - {type: position, name: middle, marker: arm.node3}
simulation: {t_end: 10 s, solver: {type: RK4, step: 1e-3}, output_step: 0.01}
"""


EVERYTHING = """\
$schema: ../docs/model.schema.json
name: everything
parts:
  boom:
    type: members
    members:
      - name: leg
        start: [0, 0, 0]
        end: [1, 0, 0]
        section: {type: tube, outer_diameter: 60 mm, wall: 3 mm}
        material: &steel {E: 210 GPa, nu: 0.3, rho: 7850, name: steel}
        elements: 3
        orientation: [0, 1, 0]
        end_offset: [-10 mm, 0, 0]
      - start: [1, 0, 0]
        end: [1, 1, 0]
        section: {type: i-beam, height: 0.1, width: 0.05, web: 5 mm, flange: 6 mm, fillet: 2 mm}
        material: *steel
    points: {tip: [1, 1, 0]}
    theory: {type: timoshenko, ky: 0.8, kz: 0.9}
    rotary_inertia: yes
    point_masses:
      - {node: tip, mass: 2 kg, inertia: [0.1, 0.1, 0.1], offset: [0, 0, 10 cm]}
    reduce: {type: craig-bampton, interfaces: [leg.start, tip], frequency_limit: 500 Hz}
  plane:
    type: frame
    nodes: [[0, 0, 0], [1, 0, 0], [2, 0, 0]]
    elements: [[0, 1], [1, 2]]
    sections:
      - {type: circle, diameter: 30 mm}
      - {type: box, width: 40 mm, height: 30 mm, web: 2 mm, flange: 3 mm}
    materials: *steel
    orientations: [[0, 0, 1], [0, 1, 0]]
    offsets: [[[0, 0, 0], [0, 0, 0.01]], [[0, 0, 0.01], [0, 0, 0]]]
    lumped: no
    node_sets: {hub: [0]}
    reduce: {type: free-free, modes: 8}
    keep: [0, 2, 3]
  flat:
    type: beam
    length: 1 m
    section:
      type: general
      A: 2 cm2
      Iy: 1 cm4
      Iz: 2 cm4
      J: 1.5 cm4
      ky: 0.8
      kz: 0.8
      points: [{name: top, y: 0, z: 1 cm, shear: [[1, 2, 3], [4, 5, 6]]}, {name: side, y: 1, z: 0}]
    elements: 3
    material: *steel
    stiffening: yes
    residual_stress: yes
    orientation: [0, 1, 0]
    reduce: {type: craig-bampton, interfaces: [start], modes: 6}
    in_plane: xy
bodies:
  - name: crank
    mass: 500 g
    inertia: [1e-3, 2e-3, 2e-3]
    center: [0.1, 0, 0]
    markers: {pin: [200 mm, 0, 0], eye: [0, 0, 0]}
    position: [0, 0, 0]
    orientation: {axis: [0, 0, 1], angle_deg: 30}
    angular_velocity: [0, 0, 60 rpm]
    outline: [[0, 0, 0], [0.2, 0, 0]]
  - name: block
    type: rigid
    mass: 1
    inertia: [[2, -0.1, 0], [-0.1, 2, 0], [0, 0, 2]]
    position: [5, 0, 0]
    orientation: [0, 1, 0, 0]
    velocity: [1 m/s, 0, 0]
  - name: arm
    part: boom
    position: [10, 0, 0]
    orientation: [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    damping: {type: rayleigh, alpha: 0.5 1/s, beta: 1 ms}
    drop_invariants: [I5, I9]
  - name: wing
    type: flexible
    part: plane
    position: [20, 0, 0]
    damping: [1 %, 0.02, 0.03]
    modal_coordinates: [1e-3, 0, 0]
    modal_velocities: [0, 1e-3, 0]
  - {name: tail, part: flat, damping: 0.01, position: [30, 0, 0]}
joints:
  - {type: revolute, name: hinge, a: ground.origin, b: crank.eye, axis: [0, 0, 1]}
  - {type: revolute, name: bare, b: block.origin,
     a: {body: ground, at: [5 m, 0, 0], axes: {axis: [1, 0, 0], angle_deg: 90 deg}}}
  - {type: fixed, name: clamp, a: {body: ground, at: [10, 0, 0]}, b: arm.leg.start}
  - {type: spherical, name: ball, a: {body: ground, at: [30, 0, 0]}, b: {body: tail, point: start}}
forces:
  - {type: force, name: push, marker: crank.pin, vector: [0, 1 kN, 0], follow: true,
     signal: {type: harmonic, frequency: 2 Hz, amplitude: 3, phase: 90 deg, offset: 1}}
  - {type: torque, name: twist, marker: arm.tip, vector: [0, 0, 5 N m],
     signal: {type: table, times: [0, 500 ms, 1], values: [0, 1, 0]}}
  - {type: force, name: pull, marker: {body: arm, point: tip}, vector: [0, 0, 1],
     signal: {type: step, time: 1, before: 2, after: 3}}
gravity: [0, 0, -1 g0]
sensors:
  - {type: position, name: s1, marker: crank.pin}
  - {type: velocity, name: s2, marker: crank.pin}
  - {type: orientation, name: s3, marker: crank.pin}
  - {type: angular-velocity, name: s4, marker: crank.pin}
  - {type: modal, name: s5, body: wing}
  - {type: reaction, name: s6, joint: hinge}
  - {type: stress, name: s7, body: arm, sites: [e1.a.top, e2.b.left]}
  - {type: stress, name: s8, body: tail}
simulation: {t_end: 1, solver: {type: ROS2, step: 2 ms, projection: no,
             baumgarte: {alpha: 50 1/s, beta: 50 1/s}}}
"""


def same(a, b, path="") -> None:
    """Assert that two objects have the same fields, exactly."""
    assert type(a) is type(b), path
    if isinstance(a, np.ndarray):
        np.testing.assert_array_equal(a, b, err_msg=path)
    elif dataclasses.is_dataclass(a):
        for field in dataclasses.fields(a):
            if field.name not in ("items", "provenance", "source"):
                same(getattr(a, field.name), getattr(b, field.name), f"{path}.{field.name}")
    elif isinstance(a, Mapping):
        assert list(a) == list(b), path
        for key in a:
            same(a[key], b[key], f"{path}[{key}]")
    elif isinstance(a, tuple | list):
        assert len(a) == len(b), path
        for i, (x, y) in enumerate(zip(a, b, strict=True)):
            same(x, y, f"{path}[{i}]")
    else:
        assert a == b, path
