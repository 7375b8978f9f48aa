"""Members: the items of a mechanism sorted by kind."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from jousto.base.arrays import Array, read_only
from jousto.base.complexstep import floats
from jousto.base.numbers import set_fields
from jousto.base.rotations import rotation_matrix
from jousto.mechanism.assembly import Assembly, unpacked
from jousto.mechanism.beams.body import BeamBody
from jousto.mechanism.beams.discretisation import BeamNode
from jousto.mechanism.bodies.body import FlexibleBody, MovingBody, RigidBody
from jousto.mechanism.bodies.marker import world_positions
from jousto.mechanism.event import Event
from jousto.mechanism.forces.base import ForceElement
from jousto.mechanism.forces.friction import Friction
from jousto.mechanism.forces.loads import Gravity
from jousto.mechanism.foreign.fmu import Fmu
from jousto.mechanism.initial import Initial
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coupling import Coupler
from jousto.mechanism.sensors.base import Sensor
from jousto.mechanism.states.block import Block

CORES = ("auto", "joint", "maximal")
"""Names of the solver cores, see `compile`."""
STARTS = ("initial", "rest", "vibration-free")
"""Initial states of runs: declared pose, static equilibrium, or deformed without vibration."""


POINT = 1e-6
"""Extent of a mechanism that counts as rounding / largest radius of gyration of its bodies."""


def word_problem(name: str, word: Any, words: tuple[str, ...]) -> str | None:
    """Return the problem with an option, or None if the option is one of the allowed words."""
    if word in words:
        return None
    known = ", ".join(repr(one) for one in words[:-1])
    return f"{name} is {word!r}, must be {known} or {words[-1]!r}"


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Members:
    """Items of a `Mechanism`, sorted by kind, before they are checked.

    Attributes as in `Mechanism`.
    """

    name: str
    core: str
    start: str
    items: tuple[Any, ...]
    bodies: tuple[MovingBody, ...]
    beams: tuple[BeamBody, ...]
    joints: tuple[Joint, ...]
    couplings: tuple[Coupler, ...]
    forces: tuple[ForceElement, ...]
    frictions: tuple[Friction, ...]
    events: tuple[Event, ...]
    sensors: tuple[Sensor, ...]
    initials: tuple[Initial, ...]
    fmus: tuple[Fmu, ...]
    blocks: tuple[Block, ...]
    assemblies: tuple[Assembly, ...]
    gravity: Array

    def __init__(
        self, *items: Any, name: str = "mechanism", core: str = "auto", start: str = "initial"
    ) -> None:
        assemblies = tuple(x for x in items if isinstance(x, Assembly))
        items = tuple(unpacked(items)) if assemblies else items
        fmus = tuple(x for x in items if isinstance(x, Fmu))
        fields: dict[str, Any] = {
            "assemblies": assemblies,
            "bodies": tuple(flattened(items)),
            "beams": tuple(x for x in items if isinstance(x, BeamBody)),
            "joints": tuple(x for x in items if isinstance(x, Joint)),
            # the rows that act at times only follow the permanent ones
            "couplings": tuple(
                sorted((x for x in items if isinstance(x, Coupler)), key=lambda x: x.optional)
            ),
            "forces": tuple(x for x in items if isinstance(x, ForceElement)),
            "frictions": tuple(x for x in items if isinstance(x, Friction)),
            "events": tuple(x for x in items if isinstance(x, Event)),
            "sensors": (
                *(x for x in items if isinstance(x, Sensor)),
                *(sensor for fmu in fmus for sensor in fmu.sensors),
            ),
            "fmus": fmus,
            "blocks": tuple(x for x in items if isinstance(x, Block)),
            "initials": tuple(x for x in items if isinstance(x, Initial)),
        }
        gravity = [x.acceleration for x in items if isinstance(x, Gravity)]
        set_fields(
            self,
            name=name,
            core=core,
            start=start,
            items=items,
            gravity=gravity[0] if gravity else read_only(np.zeros(3)),
            **fields,
        )

    @cached_property
    def size(self) -> float:
        """Diagonal of the box around all bodies and joints at the initial pose, m.

        If all points coincide up to rounding, the largest radius of gyration of a body.
        """
        size, arm = self.extent, self.arm
        return size if size > POINT * arm else arm or 1.0

    @cached_property
    def arm(self) -> float:
        """Largest radius of gyration of a rigid body about its centre of mass, m."""
        return widest(self._rigid)

    @property
    def _rigid(self) -> list[RigidBody]:
        """Rigid bodies without the nodes of beams."""
        return [x for x in self.bodies if isinstance(x, RigidBody) and not isinstance(x, BeamNode)]

    @cached_property
    def extent(self) -> float:
        """Diagonal of the box around all bodies and joints at the initial pose, m."""
        rigid = self._rigid
        points = [named_points(rigid)] if rigid else []
        points += [node_points(x) for x in self.bodies if isinstance(x, FlexibleBody)]
        points += [beam_points(beam) for beam in self.beams]
        if self.joints:
            points += [self.joint_ends.reshape(-1, 3)]
        cloud = np.vstack(points) if points else np.zeros((1, 3))
        return float(np.linalg.norm(cloud.max(axis=0) - cloud.min(axis=0)))

    @cached_property
    def joint_ends(self) -> Array:
        """World positions (k, 2, 3) of the markers a and b of the joints at the initial pose, m."""
        ends = [marker for joint in self.joints for marker in (joint.a, joint.b)]
        return world_positions(ends).reshape(-1, 2, 3)


def flattened(items: Sequence[Any]) -> Iterator[MovingBody]:
    """Yield the bodies, each beam replaced by its nodes."""
    for item in items:
        if isinstance(item, BeamBody):
            yield from item.bodies
        elif isinstance(item, RigidBody | FlexibleBody):
            yield item


def beam_points(beam: BeamBody) -> Array:
    """Return the world positions (n + 1, 3) of a beam's nodes."""
    return np.asarray(beam.position + beam.nodes @ rotation_matrix(beam.orientation).T)


def node_points(body: FlexibleBody) -> Array:
    """Return the world positions (k, 3) of a body's nodes, undeformed."""
    points = floats(body.reduced.nodes)
    return np.asarray(body.position + points @ rotation_matrix(body.orientation).T)


def widest(bodies: Sequence[RigidBody]) -> float:
    """Return the largest radius of gyration of a body about its centre of mass, m."""
    if not bodies:
        return 0.0
    moments = np.real(np.trace(floats([body.inertia for body in bodies]), axis1=1, axis2=2))
    return float(np.sqrt(0.5 * moments / np.real(floats([body.mass for body in bodies]))).max())


def named_points(bodies: Sequence[RigidBody]) -> Array:
    """Return the world positions (k, 3) of the origins, centres and named points of bodies."""
    R = floats([body.position for body in bodies])
    A = rotation_matrix([body.orientation for body in bodies])
    points = [(body.center, *body.markers.values()) for body in bodies]
    owner = np.repeat(np.arange(len(bodies)), [len(some) for some in points])
    u = floats([point for some in points for point in some])
    return np.vstack([R, R[owner] + (A[owner] @ u[..., None])[..., 0]])
