"""Machines for studies, at the top level so that other processes find them."""

from __future__ import annotations

import os
import time
from pathlib import Path

import jousto as jo

CANTILEVER = """
parameters:
  height: {value: 20 mm, bounds: [10 mm, 40 mm]}
  other: {value: 10 mm, bounds: [5 mm, 20 mm]}
  k: {value: 1 kN/m, bounds: [100 N/m, 10 kN/m]}
  load: {value: 10 N, distribution: normal(sd=1 N)}
parts:
  beam:
    {type: beam, length: 1 m, elements: 8, material: S355,
     section: {type: rectangle, width: 10 mm, height: "${height}"},
     reduce: {type: craig-bampton, interfaces: [start, end], modes: 2}}
  rod:
    {type: beam, length: 1 m, elements: 4, material: S355,
     section: {type: rectangle, width: 10 mm, height: "${other}"},
     reduce: {type: craig-bampton, interfaces: [start, end], modes: 2}}
bodies:
  - {name: arm, part: beam}
  - {name: side, part: rod, position: [0, 1, 0]}
joints:
  - {type: fixed, name: clamp, a: ground.origin, b: arm.start}
  - {type: fixed, name: hold, a: {body: ground, at: [0, 1, 0]}, b: side.start}
forces:
  - type: spring
    name: link
    coordinate: {type: distance, a: arm.end, b: side.end}
    stiffness: ${k}
  - {type: force, name: pull, marker: side.end, vector: [0, 0, "${load}"]}
sensors:
  - {type: position, name: tip, marker: side.end}
  - {type: reaction, name: root, joint: clamp}
simulation: {t_end: 10 ms, solver: {type: ROS2, step: 1 ms}}
"""


def bob(length: float) -> jo.Mechanism:
    """A point mass on a massless rod that starts at 1e-3 rad."""
    mass = jo.RigidBody(
        "bob",
        1.0,
        (1e-9, 1e-9, 1e-9),
        center=(0, -length, 0),
        orientation=jo.Rotate((0, 0, 1), radians=1e-3),
    )
    pivot = jo.Revolute("pivot", jo.ground["origin"], mass["origin"])
    place = jo.PositionSensor("bob", mass.at((0, -length, 0)))
    return jo.Mechanism(mass, pivot, jo.Gravity((0, -9.81, 0)), place)


def pushed(mass: float) -> jo.Mechanism:
    """A mass that an external force pushes along a slide."""
    block = jo.RigidBody("block", mass, (1, 1, 1))
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    push = jo.JointForce("push", slide.displacement, jo.Input("force"))
    return jo.Mechanism(block, slide, push, jo.CoordinateSensor("way", slide.displacement))


def way(run: jo.Solution) -> float:
    """Return how far it came."""
    return float(run["way"][-1, 0])


def deadly(run: jo.Solution) -> float:
    """Return how far it came; the first time it comes far, the process dies."""
    mark = Path(os.environ["JOUSTO_TEST_MARK"])
    if way(run) > 1.9 and not mark.exists():
        mark.touch()
        os._exit(9)
    return way(run)


def fatal(run: jo.Solution) -> float:
    """Return how far it came; the process dies whenever it comes far."""
    if way(run) > 1.9:
        os._exit(9)
    return way(run)


def slow(run: jo.Solution) -> float:
    """Return how far it came after a while, and leave a mark."""
    time.sleep(0.05)
    with Path(os.environ["JOUSTO_TEST_MARK"]).open("a") as file:
        file.write("x")
    return way(run)


FORCES = (jo.Parameter("mass", 2.0, unit="kg"), jo.Parameter("force", 4.0, unit="N"))
RUN = {"t_end": 1.0, "solver": jo.RK4(0.1)}
