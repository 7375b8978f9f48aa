"""The mechanism: bodies, joints, forces and sensors, checked all at once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.errors import Problems, suggest, warn
from jousto.mechanism.body import Body, FlexibleBody, Ground, MovingBody, RigidBody
from jousto.mechanism.fields import check_name, set_fields
from jousto.mechanism.force import LOADS, Gravity, Load, Torque
from jousto.mechanism.joint import JOINTS, Joint, Spherical
from jousto.mechanism.marker import Marker
from jousto.mechanism.orientation import Array, readonly, rotation_matrix
from jousto.mechanism.sensor import (
    SENSORS,
    AngularVelocitySensor,
    ModalSensor,
    OrientationSensor,
    ReactionSensor,
    Sensor,
    StressSensor,
)

# largest gap at a joint, relative to the size of the mechanism, that projection may close
GAP_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Mechanism:
    """Bodies, joints, forces and sensors that belong together.

    Parameters
    ----------
    *items : RigidBody, FlexibleBody, joint, Gravity, Force, Torque or sensor
        In any order; bodies, joints, forces and sensors keep the order in which they are given.
    name : str
        Name for plots and messages.

    Attributes
    ----------
    bodies, joints, forces, sensors : tuple
        The items by kind, in the given order; forces holds forces and torques.
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
        If a body is not connected to anything or nothing will move.

    Examples
    --------
    >>> from jousto.mechanism import Gravity, Revolute, RigidBody, ground
    >>> rod = RigidBody("rod", 1.0, (0.01, 0.1, 0.1), center=(0.5, 0, 0))
    >>> pivot = Revolute("pivot", ground["origin"], rod["origin"])
    >>> Mechanism(rod, pivot, Gravity((0, -9.81, 0)), name="pendulum")
    <Mechanism 'pendulum': 1 body, 1 joint, 0 forces, 0 sensors>
    """

    name: str
    items: tuple[Any, ...]
    bodies: tuple[MovingBody, ...]
    joints: tuple[Joint, ...]
    forces: tuple[Load, ...]
    sensors: tuple[Sensor, ...]
    gravity: Array

    def __init__(self, *items: Any, name: str = "mechanism") -> None:
        fields = {
            "bodies": tuple(x for x in items if isinstance(x, RigidBody | FlexibleBody)),
            "joints": tuple(x for x in items if isinstance(x, JOINTS)),
            "forces": tuple(x for x in items if isinstance(x, LOADS)),
            "sensors": tuple(x for x in items if isinstance(x, SENSORS)),
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

        return (
            f"<Mechanism {self.name!r}: {count('body', 'bodies', self.bodies)}, "
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
        points = [body_points(body) for body in self.bodies]
        points += [marker.r[None] for joint in self.joints for marker in (joint.a, joint.b)]
        cloud = np.vstack(points) if points else np.zeros((1, 3))
        size = float(np.linalg.norm(cloud.max(axis=0) - cloud.min(axis=0)))
        return size if size > 0 else 1.0

    def check(self) -> None:
        """Raise InputError with all problems and warn about what is probably not meant."""
        problems = Problems()
        check_name(problems, "mechanism", self.name)
        check_items(problems, self.items)
        check_names(problems, self)
        check_members(problems, self)
        check_joints(problems, self)
        check_rotations(problems, self)
        problems.raise_if_any()
        warn_unconnected(self)
        warn_mobility(self)
        warn_ground_loads(self)
        warn_at_rest(self)


# -- checks ---------------------------------------------------------------------------------


def body_points(body: MovingBody) -> Array:
    """Return the world positions (k, 3) of a body's nodes or named points, undeformed."""
    if isinstance(body, FlexibleBody):
        points = np.asarray(body.reduced.nodes, dtype=np.float64)
    else:
        points = np.stack([np.zeros(3), body.center, *body.markers.values()])
    return np.asarray(body.position + points @ rotation_matrix(body.orientation).T)


def kind_of(item: Any) -> str:
    """Return the kind of an item for messages."""
    if isinstance(item, RigidBody | FlexibleBody):
        return "body"
    if isinstance(item, JOINTS):
        return "joint"
    if isinstance(item, LOADS):
        return "torque" if isinstance(item, Torque) else "force"
    return "sensor"


def where(item: Any) -> str:
    """Return the place of an item for messages, ``joint 'pivot'``."""
    return f"{kind_of(item)} {item.name!r}"


def check_items(problems: Problems, items: tuple[Any, ...]) -> None:
    """Note items that are no part of a mechanism, given twice, or too many."""
    seen: set[int] = set()
    for i, item in enumerate(items):
        place = f"item {i + 1}"
        if isinstance(item, (RigidBody, FlexibleBody, *JOINTS, *LOADS, *SENSORS, Gravity)):
            if id(item) in seen:
                name = "gravity" if isinstance(item, Gravity) else where(item)
                problems.add(name, "given twice, leave one out")
            seen.add(id(item))
        elif isinstance(item, Ground):
            problems.add(place, "the ground is always there, leave it out")
        elif isinstance(item, list | tuple):
            problems.add(place, f"is a {type(item).__name__}; write Mechanism(*items)")
        elif isinstance(item, Marker):
            problems.add(place, f"is the marker {item.label}; give its body instead")
        elif hasattr(item, "invariants"):
            problems.add(place, "is a ReducedPart; make a body of it, FlexibleBody(name, reduced)")
        else:
            problems.add(
                place, f"is a {type(item).__name__}; must be a body, joint, force or sensor"
            )
    different = {id(x) for x in items if isinstance(x, Gravity)}
    if len(different) > 1:
        problems.add("gravity", f"{len(different)} Gravity items, only one makes sense")
    if not any(isinstance(x, RigidBody | FlexibleBody) for x in items):
        problems.add("mechanism", "has no bodies")


def check_names(problems: Problems, mechanism: Mechanism) -> None:
    """Note names that several items of a kind share."""
    for items in (mechanism.bodies, mechanism.joints, mechanism.forces, mechanism.sensors):
        first: dict[str, Any] = {}
        reported: set[str] = set()
        for item in items:
            other = first.setdefault(item.name, item)
            if other is not item and item.name not in reported:
                reported.add(item.name)
                count = len({id(x) for x in items if x.name == item.name})
                kind = "forces" if isinstance(item, LOADS) else f"{kind_of(item)}s"
                kind = "bodies" if kind == "bodys" else kind
                problems.add(where(item), f"{count} {kind} have this name, names must differ")


def markers_of(item: Any) -> Iterator[tuple[str, Marker]]:
    """Yield the markers an item uses with the name of the argument."""
    if isinstance(item, JOINTS):
        yield "a", item.a
        yield "b", item.b
    elif hasattr(item, "marker"):
        yield "marker", item.marker


def check_members(problems: Problems, mechanism: Mechanism) -> None:
    """Note items that refer to bodies or joints that are not in the mechanism."""
    bodies = {body.name: body for body in mechanism.bodies}
    ids = {id(body) for body in mechanism.bodies}

    def missing(item: Any, argument: str, body: Any) -> None:
        if isinstance(body, Ground) or id(body) in ids:
            return
        if body.name in bodies:
            text = "is another body of that name than the one in the mechanism"
        else:
            text = f"is not in the mechanism{suggest(body.name, bodies)}"
        problems.add(where(item), f"{argument}: body {body.name!r} {text}")

    for item in (*mechanism.joints, *mechanism.forces, *mechanism.sensors):
        for argument, marker in markers_of(item):
            missing(item, argument, marker.body)
        if isinstance(item, ModalSensor | StressSensor):
            missing(item, "body", item.body)
        if isinstance(item, ReactionSensor) and all(item.joint is not j for j in mechanism.joints):
            names = [joint.name for joint in mechanism.joints]
            if item.joint.name in names:
                text = "is another joint of that name than the one in the mechanism"
            else:
                text = f"is not in the mechanism{suggest(item.joint.name, names)}"
            problems.add(where(item), f"joint {item.joint.name!r} {text}")


def check_joints(problems: Problems, mechanism: Mechanism) -> None:
    """Note joints that connect nothing and joints that are open at the initial pose."""
    tolerance = GAP_TOLERANCE * mechanism.size
    for joint in mechanism.joints:
        a, b = joint.a, joint.b
        if isinstance(a.body, Ground) and isinstance(b.body, Ground):
            problems.add(where(joint), f"both markers are on the ground, {a.label} and {b.label}")
        elif a.body is b.body:
            if np.array_equal(a.position_local, b.position_local) and a.node == b.node:
                problems.add(where(joint), f"connects {a.label} with itself")
            else:
                problems.add(
                    where(joint),
                    f"both markers are on body {a.body.name!r}, {a.label} and {b.label}; "
                    "a joint connects two bodies",
                )
        else:
            gap = float(np.linalg.norm(b.r - a.r))
            if gap > tolerance:
                problems.add(
                    where(joint),
                    f"initial gap of {1e3 * gap:.6g} mm: {a.label} is at {world_point(a)}, "
                    f"{b.label} at {world_point(b)} m; move a body until they meet",
                )


def world_point(marker: Marker) -> str:
    """Return the initial world position of a marker for messages, ``(1, 0, 0)``."""
    return "(" + ", ".join(f"{x:.9g}" for x in marker.r + 0.0) + ")"


def check_rotations(problems: Problems, mechanism: Mechanism) -> None:
    """Note items that need the rotation of a node whose part has translations only."""
    for item in (*mechanism.joints, *mechanism.forces, *mechanism.sensors):
        needs = (
            (isinstance(item, JOINTS) and not isinstance(item, Spherical))
            or isinstance(item, Torque | OrientationSensor | AngularVelocitySensor)
            or (isinstance(item, LOADS) and item.follow)
        )
        for argument, marker in markers_of(item):
            flexible = isinstance(marker.body, FlexibleBody)
            if needs and flexible and marker.body.reduced.rotations is None:  # type: ignore[union-attr]
                problems.add(
                    where(item),
                    f"{argument}: {marker.label} has no rotation mode shapes "
                    "(three degrees of freedom per node), only translations can be used",
                )


def warn_unconnected(mechanism: Mechanism) -> None:
    """Warn about bodies without a joint."""
    joined = {id(m.body) for joint in mechanism.joints for m in (joint.a, joint.b)}
    for body in mechanism.bodies:
        if id(body) not in joined:
            warn(where(body), "is not connected to anything, it moves freely")


def warn_mobility(mechanism: Mechanism) -> None:
    """Warn if there are as many constraint rows as coordinates."""
    coordinates = sum(6 + len(body.modal_coordinates) for body in mechanism.bodies)
    rows = sum(joint.rows for joint in mechanism.joints)
    if rows >= coordinates:
        warn(
            f"mechanism {mechanism.name!r}",
            f"{rows} constraint rows for {coordinates} coordinates: it cannot move, or joints "
            "repeat each other's rows",
        )


def warn_ground_loads(mechanism: Mechanism) -> None:
    """Warn about forces and torques on the ground."""
    for load in mechanism.forces:
        if isinstance(load.marker.body, Ground):
            warn(where(load), "acts on the ground, it has no effect")


def warn_at_rest(mechanism: Mechanism) -> None:
    """Warn if nothing can start to move."""
    moving = any(
        np.any(body.velocity)
        or np.any(body.angular_velocity)
        or np.any(body.modal_velocities)
        or np.any(body.modal_coordinates)
        for body in mechanism.bodies
    )
    loads = any(not isinstance(load.marker.body, Ground) for load in mechanism.forces)
    if not (moving or loads or np.any(mechanism.gravity)):
        warn(
            f"mechanism {mechanism.name!r}",
            "no gravity, no force and no initial velocity: nothing will move",
        )
