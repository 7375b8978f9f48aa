"""Entries of sensors."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, Discriminator, Field, Tag

from jousto.schema.entries.base import (
    Count,
    Direction,
    Entry,
    Length,
    Marker,
    Number,
    Position,
    Pressure,
    Text,
)
from jousto.schema.entries.beams import SectionSensorEntry
from jousto.schema.entries.choices import by_form, tagged
from jousto.schema.entries.connections import CoordinateEntry
from jousto.schema.entries.curves import MeanEntry, SNOrName
from jousto.schema.entries.signals import SignalOrNumber

SITES = "Such as e3.a.top, or a position: the site nearest to it; all if not given"


class MotionSensorEntry(Entry):
    """`PositionSensor`, `VelocitySensor`, `AccelerationSensor` and those of orientation."""

    type: Literal[
        "position",
        "velocity",
        "acceleration",
        "orientation",
        "angular-velocity",
        "angular-acceleration",
    ]
    name: Text
    marker: Marker
    relative_to: Marker | None = Field(
        None, description="The observer, who moves and turns with this marker"
    )
    resolved_in: Marker | None = Field(
        None, description="Axes of the components; those of the observer, or the world's"
    )


class ModalSensorEntry(Entry):
    """`ModalSensor`: modal coordinates and velocities of a flexible body."""

    type: Literal["modal"]
    name: Text
    body: Text


def _axes(value: Any) -> str:
    if isinstance(value, dict | BaseModel):
        return "mapping"
    return "marker" if isinstance(value, str) and "." in value else "word"


Axes: TypeAlias = Annotated[
    Annotated[Literal["world", "joint"], Tag("word")]
    | Annotated[Marker, Tag("marker")]
    | Annotated[Marker, Tag("mapping")],
    Discriminator(_axes),
]


class ReactionSensorEntry(Entry):
    """`ReactionSensor`: force and moment of a joint, or what a coupling or drive exerts."""

    type: Literal["reaction"]
    name: Text
    joint: Text = Field(description="Name of a joint, coupling or drive")
    resolved_in: Axes | None = Field(
        None, description="world (if not given), joint, or a marker; of joints only"
    )


class ForceSensorEntry(Entry):
    """`ForceSensor`: what a force element exerts."""

    type: Literal["force"]
    name: Text
    force: Text = Field(description="Name of an entry of forces")
    resolved_in: Marker | None = Field(None, description="Axes of the components, or the world's")


Place: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")] | Annotated[Position, Tag("list")], by_form()
]


class StressSensorEntry(Entry):
    """`StressSensor`: six stress components at section points of a flexible body."""

    type: Literal["stress"]
    name: Text
    body: Text
    sites: tuple[Place, ...] | None = Field(None, description=SITES)


class VonMisesSensorEntry(Entry):
    """`VonMisesSensor`: equivalent stress."""

    type: Literal["von-mises"]
    name: Text
    body: Text
    sites: tuple[Place, ...] | None = Field(None, description=SITES)


class PrincipalStressSensorEntry(Entry):
    """`PrincipalStressSensor`: the three principal stresses, the largest first."""

    type: Literal["principal-stress"]
    name: Text
    body: Text
    sites: tuple[Place, ...] | None = Field(None, description=SITES)


def _expansion(value: Any) -> str:
    """Return whether an expansion is a number, maybe in quotes, or the name of a material."""
    try:
        float(value)
    except (TypeError, ValueError):
        return "text" if isinstance(value, str) else "number"
    return "number"


class TemperatureEntry(Entry):
    """`Temperature`: what a gauge shows when it gets warm."""

    signal: SignalOrNumber = Field(description="Temperature over time, K or deg C")
    part: Annotated[
        Annotated[Number, Tag("number")] | Annotated[Text, Tag("text")],
        Discriminator(_expansion),
    ] = Field(description="Thermal expansion of the part, 1/K, or the name of a material")
    gauge: Annotated[Number | None, Field(description="That of the grid, 1/K")] = None
    reference: Annotated[Number | None, Field(description="When it was balanced, 20")] = None
    resistance: Annotated[
        Number | None, Field(description="Temperature coefficient of the resistance, 1/K")
    ] = None
    gauge_factor: Annotated[Number | None, Field(description="For the resistance, 2")] = None


class GaugeEntry(Entry):
    """`Gauge`: a virtual strain gauge."""

    type: Literal["gauge"]
    name: Text
    body: Text
    at: Place = Field(description="A position in the part frame, or a stress site as e3.a.top")
    direction: Direction | None = Field(
        None, description="Along the gauge, part frame; along the beam if not given"
    )
    length: Annotated[Length | None, Field(description="Of the grid; a point if not given")] = None
    width: Annotated[Length | None, Field(description="Of the grid")] = None
    transverse: Annotated[Number | None, Field(description="Transverse sensitivity")] = None
    reach: Annotated[
        Length | None, Field(description="How far the position may lie off the surface")
    ] = None
    E: Annotated[Pressure | None, Field(description="Young's modulus, if not the part's")] = None
    nu: Annotated[Number | None, Field(description="Poisson's ratio, if not the part's")] = None
    temperature: TemperatureEntry | None = None


class RosetteEntry(Entry):
    """`Rosette`: two or three virtual strain gauges at one place."""

    type: Literal["rosette"]
    name: Text
    body: Text
    at: Place = Field(description="A position in the part frame, or a stress site as e3.a.top")
    direction: Direction | None = Field(
        None, description="Along grid a, part frame; along the beam if not given"
    )
    kind: Annotated[Text | None, Field(description="'45' (if not given), '60' or '90'")] = None
    normal: Direction | None = Field(None, description="Outward normal, on beams")
    length: Annotated[Length | None, Field(description="Of the grids")] = None
    width: Annotated[Length | None, Field(description="Of the grids")] = None
    transverse: Annotated[Number | None, Field(description="Transverse sensitivity")] = None
    reach: Annotated[
        Length | None, Field(description="How far the position may lie off the surface")
    ] = None
    E: Annotated[Pressure | None, Field(description="Young's modulus, if not the part's")] = None
    nu: Annotated[Number | None, Field(description="Poisson's ratio, if not the part's")] = None
    temperature: TemperatureEntry | None = None


class BridgeEntry(Entry):
    """`Bridge`: a Wheatstone bridge of gauges, V/V."""

    type: Literal["bridge"]
    name: Text
    arms: tuple[Text | None, ...] = Field(
        description="Names of gauges in the arms 1 to 4 (+ - + -); null is a fixed resistor"
    )
    gauge_factor: Annotated[Number | None, Field(description="2 if not given")] = None
    resistance: Annotated[Number | None, Field(description="Of each arm, ohm")] = None


class CoordinateSensorEntry(Entry):
    """`CoordinateSensor`: value of a coordinate."""

    type: Literal["coordinate"]
    name: Text
    coordinate: CoordinateEntry


class RateSensorEntry(Entry):
    """`RateSensor`: rate of a coordinate."""

    type: Literal["rate"]
    name: Text
    coordinate: CoordinateEntry


class EnergySensorEntry(Entry):
    """`EnergySensor`: one term of the energy balance."""

    type: Literal["energy"]
    name: Text
    energy: Text = Field(
        description="kinetic, strain, potential, springs, dissipated, friction or work"
    )


class SignalSensorEntry(Entry):
    """`SignalSensor`: value of a signal."""

    type: Literal["signal"]
    name: Text
    signal: SignalOrNumber


Components: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")] | Annotated[tuple[Text, ...], Tag("list")], by_form()
]


class DamageSensorEntry(Entry):
    """`DamageSensor`: fatigue damage of what another sensor measures."""

    type: Literal["damage"]
    name: Text
    sensor: Text = Field(description="Name of a sensor of stress")
    sn: SNOrName = Field(description="S-N curve: such as fat71, a name of the library, or values")
    residue: Literal["half", "repeat", "ignore"] = Field(
        description="How what the rainflow count leaves over counts"
    )
    mean: MeanEntry | None = Field(None, description="Mean stress correction; none if not given")
    components: Components | None = Field(
        None, description="Of the sensor; all of them if not given"
    )
    factor: Annotated[
        Number | None, Field(description="Stress in Pa for a value of 1; needed but for Pa")
    ] = None
    depth: Annotated[Count | None, Field(description="Turning points remembered, 32")] = None
    resolution: Annotated[
        Pressure | None, Field(description="Samples are rounded to multiples of it; 0")
    ] = None


SensorEntry: TypeAlias = Annotated[
    Annotated[MotionSensorEntry, Tag("position")]
    | Annotated[MotionSensorEntry, Tag("velocity")]
    | Annotated[MotionSensorEntry, Tag("acceleration")]
    | Annotated[MotionSensorEntry, Tag("orientation")]
    | Annotated[MotionSensorEntry, Tag("angular-velocity")]
    | Annotated[MotionSensorEntry, Tag("angular-acceleration")]
    | Annotated[ModalSensorEntry, Tag("modal")]
    | Annotated[ReactionSensorEntry, Tag("reaction")]
    | Annotated[ForceSensorEntry, Tag("force")]
    | Annotated[StressSensorEntry, Tag("stress")]
    | Annotated[VonMisesSensorEntry, Tag("von-mises")]
    | Annotated[PrincipalStressSensorEntry, Tag("principal-stress")]
    | Annotated[GaugeEntry, Tag("gauge")]
    | Annotated[RosetteEntry, Tag("rosette")]
    | Annotated[BridgeEntry, Tag("bridge")]
    | Annotated[SectionSensorEntry, Tag("section")]
    | Annotated[CoordinateSensorEntry, Tag("coordinate")]
    | Annotated[RateSensorEntry, Tag("rate")]
    | Annotated[EnergySensorEntry, Tag("energy")]
    | Annotated[SignalSensorEntry, Tag("signal")]
    | Annotated[DamageSensorEntry, Tag("damage")],
    tagged(),
]
