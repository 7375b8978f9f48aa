"""The model file: bodies, forces, sensors and the simulation."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, Tag

from jousto.schema.entries.base import (
    Acceleration3,
    Amount,
    AngularVelocity3,
    Component,
    Density,
    Direction,
    Duration,
    Entry,
    Flag,
    Force3,
    InertiaTensor,
    Length,
    Marker,
    Mass,
    Number,
    Orientation,
    Position,
    Rate,
    Text,
    Time,
    Torque3,
    Velocity3,
)
from jousto.schema.entries.beams import BeamBodyEntry, LineLoadEntry
from jousto.schema.entries.choices import Later, by_form, tagged
from jousto.schema.entries.connections import (
    BushingEntry,
    CoordinateEntry,
    CoordinateForm,
    FrictionEntry,
    JointForceEntry,
    ModalLoadEntry,
    MovingLoadEntry,
    ServoEntry,
    SpringEntry,
    UserForceEntry,
)
from jousto.schema.entries.declared import one_of
from jousto.schema.entries.fatigue import FatigueEntry
from jousto.schema.entries.monitor import MonitorEntry
from jousto.schema.entries.sensors import SensorEntry
from jousto.schema.entries.signals import SignalEntry
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


class RayleighEntry(Entry):
    """`Rayleigh`: damping proportional to mass and stiffness."""

    type: Literal["rayleigh"]
    alpha: Rate
    beta: Time


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

# -- forces ---------------------------------------------------------------------------------


class ForceEntry(Entry):
    """`Force` at a marker."""

    type: Literal["force"]
    name: Text
    marker: Marker
    vector: Force3
    follow: Flag | None = Field(None, description="Whether it turns with the marker")
    signal: SignalEntry | None = Field(None, description="Factor as a function of time")


class TorqueEntry(Entry):
    """`Torque` at a marker."""

    type: Literal["torque"]
    name: Text
    marker: Marker
    vector: Torque3
    follow: Flag | None = Field(None, description="Whether it turns with the marker")
    signal: SignalEntry | None = Field(None, description="Factor as a function of time")


LoadEntry: TypeAlias = Annotated[
    Annotated[ForceEntry, Tag("force")]
    | Annotated[TorqueEntry, Tag("torque")]
    | Annotated[SpringEntry, Tag("spring")]
    | Annotated[BushingEntry, Tag("bushing")]
    | Annotated[JointForceEntry, Tag("joint-force")]
    | Annotated[MovingLoadEntry, Tag("moving-load")]
    | Annotated[ServoEntry, Tag("servo")]
    | Annotated[ModalLoadEntry, Tag("modal-load")]
    | Annotated[UserForceEntry, Tag("user-force")]
    | Annotated[LineLoadEntry, Tag("line")],
    tagged(),
]

# -- events ---------------------------------------------------------------------------------


class EventEntry(Entry):
    """`Event`: what is watched passes a threshold."""

    name: Text
    watch: Annotated[
        Annotated[Text, Tag("scalar")] | Annotated[CoordinateForm, Tag("mapping")], by_form()
    ] = Field(description="Name of a sensor, or a coordinate such as hinge.angle")
    threshold: Amount | None = Field(None, description="In the unit of what is watched; 0 if none")
    direction: Literal["both", "rising", "falling"] | None = Field(None, description="Both if none")
    stop: Flag | None = Field(None, description="Whether the run ends there")
    component: Component | None = Field(None, description="Of a sensor with several")


# -- start ----------------------------------------------------------------------------------


class InitialEntry(Entry):
    """`Initial`: value and rate of a coordinate at time 0."""

    coordinate: CoordinateEntry = Field(description="Such as crank.angle")
    value: Amount | None = Field(None, description="That of the given pose if not given")
    rate: Amount | None = Field(None, description="Such as 5.24 rad/s, 50 rpm or 0.2 m/s")

    @property
    def name(self) -> str:
        """What the coordinate is called."""
        return str(self.coordinate)


# -- simulation and the whole file ----------------------------------------------------------


SolverEntry: Any = one_of("solvers", "jousto.simulation.solvers")


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


class ModelEntry(Entry):
    """A jousto model."""

    schema_: Text | None = Field(None, alias="$schema", description="For editors, not used")
    name: Text | None = None
    parts: dict[Text, PartEntry] | None = None
    bodies: tuple[BodyEntry, ...]
    joints: tuple[JointEntry, ...] | None = None
    couplings: tuple[CouplerEntry, ...] | None = None
    forces: tuple[LoadEntry, ...] | None = None
    frictions: tuple[Annotated[FrictionEntry, Later()], ...] | None = None
    initial: tuple[Annotated[InitialEntry, Later()], ...] | None = None
    gravity: Acceleration3 | None = None
    sensors: tuple[SensorEntry, ...] | None = None
    events: tuple[Annotated[EventEntry, Later()], ...] | None = None
    simulation: Annotated[SimulationEntry, Later()] | None = None
    fatigue: Annotated[FatigueEntry, Later()] | None = None
    monitor: Annotated[MonitorEntry, Later()] | None = None
