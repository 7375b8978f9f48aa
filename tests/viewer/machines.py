"""Small runs that the viewer is tested with."""

from __future__ import annotations

import functools

import numpy as np

import jousto as jo
from jousto.viewer.queries import Answers
from jousto.viewer.viewable import scenes_of
from verification.boxes import block
from verification.solids import mesh

SOFT = jo.Material(E=6e9, nu=0.4, rho=1150.0)  # so that the deformation is seen
LENGTH, HIGH = 0.8, 0.008


@functools.cache
def bar() -> jo.ReducedPart:
    """A soft thin bar along x with an interface at each end."""
    made = mesh(block("hexahedron20", (LENGTH, 0.04, HIGH), (12, 2, 2)))
    x = made.nodes[:, 0]
    ends = {"root": np.flatnonzero(x < 1e-9), "tip": np.flatnonzero(x > LENGTH - 1e-9)}
    part = jo.Part.solid(made, SOFT, name="bar").with_interfaces(
        *(jo.Interface(name, nodes.tolist()) for name, nodes in ends.items())
    )
    return jo.reduce(part, jo.CraigBampton(("root", "tip"), modes=4))


@functools.cache
def mechanism() -> jo.Mechanism:
    """The bar swings on a spring at its root, with a ball at its tip."""
    arm = jo.FlexibleBody("bar", bar(), damping=0.02)
    ball = jo.RigidBody.sphere("ball", 0.03, mass=0.3, position=(LENGTH, 0.02, HIGH / 2))
    hinge = jo.Revolute("hinge", jo.ground.at((0, 0.02, HIGH / 2)), arm["root"], axis=(0, 1, 0))
    return jo.Mechanism(
        *(arm, ball, hinge, jo.Fixed("weld", arm["tip"], ball["origin"])),
        jo.Gravity((0, 0, -9.81)),
        jo.Spring("spring", hinge.angle, 60.0),
        jo.PositionSensor("ball", ball["origin"]),
        jo.ReactionSensor("pin", hinge),
        name="swing",
    )


@functools.cache
def swing() -> jo.Solution:
    """Return its run of 0.5 s, in memory."""
    return jo.simulate(jo.compile(mechanism()), 0.5, output_step=2e-3)


@functools.cache
def answers() -> Answers:
    """What answers for the run."""
    return Answers(scenes_of([swing()]))


def number_of(name: str, found: Answers | None = None) -> int:
    """Return the number of a body of a scene."""
    scene = (found or answers()).scenes[0]
    return [body.name for body in scene.bodies].index(name)
