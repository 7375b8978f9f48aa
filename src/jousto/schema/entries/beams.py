"""Geometrically exact beams in the model file, their sections and loads."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Discriminator, Field, Tag

from jousto.mechanism.beams.body import BeamDamping
from jousto.schema.entries.base import (
    Angle,
    AngularVelocity3,
    Area,
    Count,
    Direction,
    Entry,
    Flag,
    Length,
    Number,
    Orientation,
    Position,
    Pressure,
    Text,
    Unit,
    Vector,
    Velocity3,
)
from jousto.schema.entries.choices import by_form
from jousto.schema.entries.declared import entry_of, one_of
from jousto.schema.entries.parts import MaterialForm, SectionEntry
from jousto.sections.points import StressPoint

MassPerLength: TypeAlias = Annotated[float, Unit("kg/m")]
InertiaPerLength: TypeAlias = Annotated[float, Unit("kg m")]
Place2: TypeAlias = Annotated[tuple[Length, Length], Vector(2)]


def _rows(value: Any) -> str:
    """Return whether a list holds lists (one row each) or numbers."""
    if not isinstance(value, list | tuple):
        return "one"
    return "rows" if value and isinstance(value[0], list | tuple) else "one"


def _nodes(value: Any) -> str:
    return "list" if isinstance(value, list | tuple) else "one"


Six: TypeAlias = Annotated[tuple[Number, Number, Number, Number, Number, Number], Vector(6)]
Matrix6: TypeAlias = Annotated[tuple[Six, Six, Six, Six, Six, Six], Vector(6)]
InertiaRow: TypeAlias = Annotated[
    tuple[InertiaPerLength, InertiaPerLength, InertiaPerLength], Vector(3)
]


StressPointEntry: Any = entry_of(StressPoint)


class BeamSectionEntry(Entry):
    """`BeamSection`: given by its stiffness and inertia."""

    type: Literal["stiffness"]
    stiffness: Annotated[
        Annotated[Six, Tag("one")] | Annotated[Matrix6, Tag("rows")], Discriminator(_rows)
    ] = Field(description="EA GAy GAz GJ EIy EIz, or the 6 x 6 matrix; N, N m, N m2")
    mass: MassPerLength
    inertia: Annotated[
        Annotated[InertiaRow, Tag("one")]
        | Annotated[Annotated[tuple[InertiaRow, InertiaRow, InertiaRow], Vector(3)], Tag("rows")],
        Discriminator(_rows),
    ] = Field(description="Per length, about the mass centre: three moments or a 3 x 3 tensor")
    center: Place2 | None = Field(None, description="Mass centre (y, z)")
    points: tuple[StressPointEntry, ...] | None = Field(None, description="Where stress is known")
    outline: tuple[Place2, ...] | None = Field(None, description="Outer edge (y, z), for pictures")
    elasticity: Annotated[tuple[Pressure, Number], Vector(2)] | None = Field(
        None, description="Young's modulus and Poisson's ratio, for gauges"
    )
    polar: Area | None = Field(
        None, description="(Iy + Iz)/A about the shear centre, by which tension resists twist"
    )


class OffsetSectionEntry(Entry):
    """`BeamSection.of`: a section whose centroid and shear centre are off the axis."""

    type: Literal["offset"]
    section: SectionEntry
    material: MaterialForm
    centroid: Place2 | None = Field(None, description="Centroid (y, z) from the axis")
    shear_center: Place2 | None = Field(None, description="Shear centre (y, z), the centroid's")
    fibres: Flag | None = Field(None, description="Whether twist stretches the fibres (true)")


OWN: Mapping[str, type[Entry]] = {"stiffness": BeamSectionEntry, "offset": OffsetSectionEntry}
AnySection: Any = one_of("sections", "jousto.sections", others=OWN)


BeamDampingEntry: Any = entry_of(BeamDamping)


def _mass(value: Any) -> str:
    return "word" if isinstance(value, str) else "number"


class BeamBodyEntry(Entry):
    """`BeamBody`: a geometrically exact beam."""

    type: Literal["beam"] = "beam"
    name: Text
    points: tuple[Position, ...] = Field(
        description="Two ends of a straight beam, or all nodes of a curved one, body frame"
    )
    section: Annotated[
        Annotated[AnySection, Tag("mapping")] | Annotated[tuple[AnySection, ...], Tag("list")],
        by_form(),
    ] = Field(description="One for all elements or one each")
    material: MaterialForm | None = Field(None, description="Not of stiffness and offset sections")
    elements: Count | None = Field(None, description="Number, between two points")
    up: (
        Annotated[
            Annotated[Direction, Tag("one")] | Annotated[tuple[Direction, ...], Tag("rows")],
            Discriminator(_rows),
        ]
        | None
    ) = Field(None, description="Near the z axis of the first section, or of that at each node")
    twist: (
        Annotated[
            Annotated[Angle, Tag("one")] | Annotated[tuple[Angle, ...], Tag("list")],
            Discriminator(_nodes),
        ]
        | None
    ) = Field(None, description="Turn of the sections at the end, or at each node")
    corners: tuple[Count, ...] | None = Field(None, description="Nodes (from 0) with a corner")
    mass: (
        Annotated[
            Annotated[Literal["lumped", "corrected", "consistent"], Tag("word")]
            | Annotated[Number, Tag("number")],
            Discriminator(_mass),
        ]
        | None
    ) = Field(
        None,
        description="Inertia: lumped (0), consistent (1), between, or corrected; if not given, "
        "corrected with bending, else lumped",
    )
    bending: Flag | None = Field(None, description="Residual bending flexibility")
    damping: BeamDampingEntry | None = None
    offset: (
        Annotated[
            Annotated[Place2, Tag("one")] | Annotated[tuple[Place2, ...], Tag("rows")],
            Discriminator(_rows),
        ]
        | None
    ) = Field(None, description="Section axis (y, z) from the nodes, or that of each node")
    straight: Flag | None = Field(None, description="Whether the unstressed beam is straight")
    reference: tuple[Position, ...] | None = Field(None, description="Nodes of the unstressed beam")
    markers: dict[Text, Count] | None = Field(None, description="Names of nodes (from 0)")
    position: Position | None = None
    orientation: Orientation | None = None
    velocity: Velocity3 | None = Field(None, description="Of the body frame's origin")
    angular_velocity: AngularVelocity3 | None = None
