"""The model file: bodies, forces, sensors and the simulation."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, Tag

from jousto.mechanism.forces.friction import Friction
from jousto.mechanism.initial import Initial
from jousto.mechanism.signals.event import Event
from jousto.reduction.damping import Rayleigh
from jousto.schema.entries import connections as connections
from jousto.schema.entries.base import (
    Acceleration3,
    AngularVelocity3,
    Density,
    Direction,
    Duration,
    Entry,
    InertiaTensor,
    Length,
    Mass,
    Number,
    Orientation,
    Position,
    Text,
    Velocity3,
)
from jousto.schema.entries.beams import BeamBodyEntry
from jousto.schema.entries.choices import Later, by_form, tagged
from jousto.schema.entries.declared import alone, entry_of, one_of
from jousto.schema.entries.fatigue import FatigueEntry
from jousto.schema.entries.monitor import MonitorEntry
from jousto.schema.entries.sensors import SensorEntry
from jousto.schema.entries.solids import PartEntry

# -- bodies ---------------------------------------------------------------------------------


class Posed(Entry):
    """Initial pose and velocity of a body frame, resolved in the world."""

    name: Text
    position: Position | None = None
    orientation: Orientation | None = None
    velocity: Velocity3 | None = Field(None, description="Of the body frame's origin")
    angular_velocity: AngularVelocity3 | None = None


class RigidBodyEntry(Posed):
    """`RigidBody`."""

    type: Literal["rigid"] = "rigid"
    mass: Mass
    inertia: InertiaTensor = Field(
        description="About the centre of mass in body axes: three moments or a 3 x 3 tensor"
    )
    center: Position | None = Field(None, description="Centre of mass in the body frame")
    markers: dict[Text, Position] | None = Field(None, description="Named points, body frame")
    outline: tuple[Position, ...] | None = Field(None, description="Polyline to draw the body")


class ShapedEntry(Posed):
    """A rigid body that is given by its shape."""

    mass: Mass | None = None
    density: Density | None = Field(None, description="Instead of the mass")
    at: Position | None = Field(None, description="Of the shape's middle in the body frame")
    markers: dict[Text, Position] | None = Field(None, description="Named points, body frame")


class BoxBodyEntry(ShapedEntry):
    """`RigidBody.box`."""

    type: Literal["box"]
    size: Position = Field(description="Lengths along x, y, z")


class CylinderBodyEntry(ShapedEntry):
    """`RigidBody.cylinder`."""

    type: Literal["cylinder"]
    radius: Length
    length: Length
    axis: Direction | None = Field(None, description="In the body frame; z if not given")


class SphereBodyEntry(ShapedEntry):
    """`RigidBody.sphere`."""

    type: Literal["sphere"]
    radius: Length


class MeshBodyEntry(ShapedEntry):
    """`RigidBody.from_mesh`."""

    type: Literal["surface"]
    file: Text = Field(description="Closed surface of triangles such as STL")
    unit: Literal["m", "mm", "cm", "in", "ft"] | None = Field(None, description="Of the file")


RayleighEntry: Any = entry_of(Rayleigh)
DampingEntry: TypeAlias = Annotated[
    Annotated[Number, Tag("scalar")]
    | Annotated[tuple[Number, ...], Tag("list")]
    | Annotated[RayleighEntry, Tag("mapping")],
    by_form(),
]


class FlexibleBodyEntry(Posed):
    """`FlexibleBody`: a part in a floating frame."""

    type: Literal["flexible"] = "flexible"
    part: Text = Field(description="Name of an entry of parts")
    damping: DampingEntry | None = Field(
        None, description="Damping ratio of all modes, one for each mode, or Rayleigh damping"
    )
    modal_coordinates: tuple[Number, ...] | None = Field(None, description="kg^0.5 m")
    modal_velocities: tuple[Number, ...] | None = Field(None, description="kg^0.5 m/s")
    drop_invariants: tuple[Literal["I5", "I9"], ...] | None = None


def _kind_of_body(data: dict[str, Any]) -> str | None:
    if "part" in data:
        return "flexible"
    if "section" in data or "points" in data:
        return "beam"
    return "rigid" if "mass" in data or "inertia" in data else None


BodyEntry: TypeAlias = Annotated[
    Annotated[RigidBodyEntry, Tag("rigid")]
    | Annotated[BoxBodyEntry, Tag("box")]
    | Annotated[CylinderBodyEntry, Tag("cylinder")]
    | Annotated[SphereBodyEntry, Tag("sphere")]
    | Annotated[MeshBodyEntry, Tag("surface")]
    | Annotated[FlexibleBodyEntry, Tag("flexible")]
    | Annotated[BeamBodyEntry, Tag("beam")],
    tagged(_kind_of_body),
]

# -- simulation and the whole file ----------------------------------------------------------


SolverEntry: Any = one_of("solvers", "jousto.simulation.solvers.explicit")


class SimulationEntry(Entry):
    """Arguments of `simulate`."""

    t_end: Duration
    solver: SolverEntry | None = None
    output_step: Duration | None = Field(None, description="Distance of the recorded times")
    start: Literal["initial", "rest", "settled"] | None = Field(
        None,
        description="From the initial pose, from the position of rest at time 0, or with elastic "
        "bodies bent as the motion bends them",
    )


JOINTS = "jousto.mechanism.joints"
JointEntry: Any = one_of("joints", JOINTS)
CouplerEntry: Any = one_of("couplings", JOINTS)
FrictionEntry: Any = alone(Friction)
InitialEntry: Any = alone(Initial)
EventEntry: Any = alone(Event)
ForceEntry: Any = one_of("forces", "jousto.mechanism.forces")


class ModelEntry(Entry):
    """A jousto model."""

    schema_: Text | None = Field(None, alias="$schema", description="For editors, not used")
    name: Text | None = None
    parts: dict[Text, PartEntry] | None = None
    bodies: tuple[BodyEntry, ...]
    joints: tuple[JointEntry, ...] | None = None
    couplings: tuple[CouplerEntry, ...] | None = None
    forces: tuple[ForceEntry, ...] | None = None
    frictions: tuple[FrictionEntry, ...] | None = None
    initial: tuple[InitialEntry, ...] | None = None
    gravity: Acceleration3 | None = None
    sensors: tuple[SensorEntry, ...] | None = None
    events: tuple[EventEntry, ...] | None = None
    simulation: Annotated[SimulationEntry, Later()] | None = None
    fatigue: Annotated[FatigueEntry, Later()] | None = None
    monitor: Annotated[MonitorEntry, Later()] | None = None
