"""The mechanism: bodies, joints, forces and sensors, checked all at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.errors import Problems
from jousto.base.names import check_name
from jousto.base.numbers import set_fields
from jousto.base.rotations import Array, readonly, rotation_matrix
from jousto.mechanism import checks
from jousto.mechanism.beams.body import BeamBody, BeamNode
from jousto.mechanism.bodies.body import Body, FlexibleBody, MovingBody, RigidBody
from jousto.mechanism.checks import where as where
from jousto.mechanism.forces.friction import Friction
from jousto.mechanism.forces.loads import LOADS, Gravity, Load
from jousto.mechanism.forces.springs import ELEMENTS, Element
from jousto.mechanism.initial import Initial
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coupling import Coupler
from jousto.mechanism.sensors.kinds import SENSORS, Sensor
from jousto.mechanism.signals.event import Event


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Mechanism:
    """Bodies, joints, forces and sensors that belong together.

    Parameters
    ----------
    *items : RigidBody, FlexibleBody, BeamBody, joint, Gravity, force, Initial, Event or sensor
        In any order; bodies, joints, forces and sensors keep the order in which they are given.
    name : str
        Name for plots and messages.

    Attributes
    ----------
    bodies, joints, couplings, forces, frictions, events, sensors : tuple
        The items by kind, in the given order; couplings holds gears, racks, couplings and
        drives, forces all force elements. In bodies stand the nodes of beams in the beam's place.
    beams : tuple of BeamBody
        The beams, in the given order.
    initials : tuple of Initial
        Values and rates of coordinates at the start.
    gravity : (3,) array
        Acceleration of free fall, world frame, m/s2; zero without a `Gravity`.
    size : float
        Diagonal of the box around all bodies and joints at the initial pose, m.

    Raises
    ------
    InputError
        With all problems: unknown bodies, names used twice, gaps at joints and so on.

    Warns
    -----
    JoustoWarning
        If a body is not connected to anything, or a force acts on the ground.

    Examples
    --------
    >>> from jousto import Gravity, Revolute, RigidBody, ground
    >>> rod = RigidBody("rod", 1.0, (0.01, 0.1, 0.1), center=(0.5, 0, 0))
    >>> pivot = Revolute("pivot", ground["origin"], rod["origin"])
    >>> Mechanism(rod, pivot, Gravity((0, -9.81, 0)), name="pendulum")
    <Mechanism 'pendulum': 1 body, 1 joint, 0 forces, 0 sensors>
    """

    name: str
    items: tuple[Any, ...]
    bodies: tuple[MovingBody, ...]
    beams: tuple[BeamBody, ...]
    joints: tuple[Joint, ...]
    couplings: tuple[Coupler, ...]
    forces: tuple[Load | Element, ...]
    frictions: tuple[Friction, ...]
    events: tuple[Event, ...]
    sensors: tuple[Sensor, ...]
    initials: tuple[Initial, ...]
    gravity: Array

    def __init__(self, *items: Any, name: str = "mechanism") -> None:
        fields = {
            "bodies": tuple(flattened(items)),
            "beams": tuple(x for x in items if isinstance(x, BeamBody)),
            "joints": tuple(x for x in items if isinstance(x, Joint)),
            "couplings": tuple(x for x in items if isinstance(x, Coupler)),
            "forces": tuple(x for x in items if isinstance(x, (*LOADS, *ELEMENTS))),
            "frictions": tuple(x for x in items if isinstance(x, Friction)),
            "events": tuple(x for x in items if isinstance(x, Event)),
            "sensors": tuple(x for x in items if isinstance(x, SENSORS)),
            "initials": tuple(x for x in items if isinstance(x, Initial)),
        }
        gravity = [x.acceleration for x in items if isinstance(x, Gravity)]
        set_fields(
            self,
            name=name,
            items=items,
            gravity=gravity[0] if gravity else readonly(np.zeros(3)),
            **fields,
        )
        self.check()

    def __repr__(self) -> str:
        def count(kind: str, plural: str, items: Sequence[Any]) -> str:
            return f"{len(items)} {kind if len(items) == 1 else plural}"

        whole = [x for x in self.items if isinstance(x, RigidBody | FlexibleBody | BeamBody)]
        return (
            f"<Mechanism {self.name!r}: {count('body', 'bodies', whole)}, "
            f"{count('joint', 'joints', self.joints)}, {count('force', 'forces', self.forces)}, "
            f"{count('sensor', 'sensors', self.sensors)}>"
        )

    def pose(self, body: Body) -> tuple[Array, Array, Array]:
        """Return the initial pose of a body frame in the world.

        Returns
        -------
        R : (3,) array
            World position of the frame's origin, m.
        A : (3, 3) array
            Rotation matrix, local to world.
        e : (4,) array
            Euler parameters, scalar first.
        """
        return body.position, readonly(rotation_matrix(body.orientation)), body.orientation

    @property
    def size(self) -> float:
        """Diagonal of the box around all bodies and joints at the initial pose, m."""
        points = [body_points(x) for x in self.bodies if not isinstance(x, BeamNode)]
        points += [beam_points(beam) for beam in self.beams]
        points += [marker.r[None] for joint in self.joints for marker in (joint.a, joint.b)]
        cloud = np.vstack(points) if points else np.zeros((1, 3))
        size = float(np.linalg.norm(cloud.max(axis=0) - cloud.min(axis=0)))
        return size if size > 0 else 1.0

    @property
    def mobility(self) -> int:
        """Rigid degrees of freedom less the rows of joints, couplings and drives.

        A beam counts as one body, although every node of it moves freely.
        """
        rows = sum(joint.rows for joint in self.joints) + len(self.couplings)
        nodes = sum(len(beam.bodies) for beam in self.beams)
        return 6 * (len(self.bodies) - nodes + len(self.beams)) - rows

    def check(self) -> None:
        """Raise InputError with all problems and warn about what is probably not meant."""
        problems = Problems()
        check_name(problems, "mechanism", self.name)
        checks.check_items(problems, self.items)
        checks.check_names(problems, self)
        checks.check_members(problems, self)
        checks.check_events(problems, self)
        checks.check_joints(problems, self)
        checks.check_rotations(problems, self)
        checks.check_drives(problems, self)
        checks.check_initials(problems, self)
        checks.check_distances(problems, self)
        checks.check_frictions(problems, self)
        problems.raise_if_any()
        checks.warn_unconnected(self)
        checks.warn_interfaces(self)
        checks.warn_jumps(self)
        checks.warn_ground_loads(self)


def flattened(items: Sequence[Any]) -> Iterator[MovingBody]:
    """Yield the bodies, the nodes of a beam in its place."""
    for item in items:
        if isinstance(item, BeamBody):
            yield from item.bodies
        elif isinstance(item, RigidBody | FlexibleBody):
            yield item


def beam_points(beam: BeamBody) -> Array:
    """Return the world positions (n + 1, 3) of a beam's nodes."""
    return np.asarray(beam.position + beam.nodes @ rotation_matrix(beam.orientation).T)


def body_points(body: MovingBody) -> Array:
    """Return the world positions (k, 3) of a body's nodes or named points, undeformed."""
    if isinstance(body, FlexibleBody):
        points = np.asarray(body.reduced.nodes, dtype=np.float64)
    else:
        points = np.stack([np.zeros(3), body.center, *body.markers.values()])
    return np.asarray(body.position + points @ rotation_matrix(body.orientation).T)
