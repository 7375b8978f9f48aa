"""Entries of joints, their coordinates, couplings and drives."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, Discriminator, Field, Tag
from pydantic_core import core_schema

from jousto.base.units import describe
from jousto.schema.entries.base import (
    Amount,
    Entry,
    Flag,
    Force3,
    ForceN,
    Length,
    Marker,
    Number,
    Text,
    Vector,
    Velocity,
    fail,
)
from jousto.schema.entries.choices import by_form, tagged
from jousto.schema.entries.declared import FORMS, one_of
from jousto.schema.entries.signals import CurveEntry, SignalEntry, SignalOrNumber

# -- coordinates ----------------------------------------------------------------------------


class _CoordinateText:
    """Annotation of ``joint.coordinate``."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Check that there is a dot with something on both sides."""

        def check(value: Any) -> str:
            joint, dot, name = value.rpartition(".") if isinstance(value, str) else ("", "", "")
            if not (dot and joint.strip() and name.strip()):
                raise fail(
                    "expects a coordinate such as hinge.angle, slide.displacement or "
                    f"{{type: distance, a: arm.tip, b: ground.origin}}, got {describe(value)}"
                )
            return str(value)

        return core_schema.no_info_plain_validator_function(check)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe as a string with a dot."""
        return {"type": "string", "pattern": r"^.+\.[^.]+$", "description": "joint.coordinate"}


CoordinateForm: Any = one_of("coordinates", "jousto.mechanism.joints")
CoordinateEntry: TypeAlias = Annotated[
    Annotated[str, _CoordinateText(), Tag("scalar")] | Annotated[CoordinateForm, Tag("mapping")],
    Discriminator(lambda v: "mapping" if isinstance(v, dict | BaseModel) else "scalar"),
]

FORMS["coordinate"] = lambda field: CoordinateEntry
FORMS["coordinates"] = lambda field: tuple[CoordinateEntry, ...]

# -- force elements -------------------------------------------------------------------------

Six: TypeAlias = Annotated[
    tuple[Amount, Amount, Amount, Amount, Amount, Amount],
    Vector(6),
]
SixOrMatrix: TypeAlias = Annotated[
    Annotated[Six, Tag("scalar")]
    | Annotated[Annotated[tuple[Six, Six, Six, Six, Six, Six], Vector(6)], Tag("list")],
    Discriminator(lambda v: "list" if v and isinstance(v[0], list | tuple) else "scalar"),
]
Pattern: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")]
    | Annotated[tuple[Force3, ...], Tag("list")]
    | Annotated[dict[Text, Force3], Tag("mapping")],
    by_form(),
]


class SpringEntry(Entry):
    """`Spring`: a spring and damper along a coordinate."""

    type: Literal["spring"]
    name: Text
    coordinate: CoordinateEntry
    stiffness: Amount | None = Field(None, description="N/m, or N m/rad along an angle")
    damping: Amount | None = Field(None, description="N s/m, or N m s/rad along an angle")
    free: Amount | None = Field(None, description="Without force; the initial pose if not given")
    preload: Amount | None = Field(None, description="Force or torque along the coordinate")
    table: CurveEntry | None = Field(None, description="Force over the coordinate")
    damper_table: CurveEntry | None = Field(None, description="Force over the coordinate's rate")


class BushingEntry(Entry):
    """`Bushing`: a linear support of b on a, translation then rotation, in the axes of a."""

    type: Literal["bushing"]
    name: Text
    a: Marker
    b: Marker
    stiffness: SixOrMatrix = Field(description="The diagonal, or six rows of a matrix")
    damping: SixOrMatrix | None = Field(None, description="As stiffness; zero if not given")
    preload: Six | None = None


class JointForceEntry(Entry):
    """`JointForce`: a force or torque along a coordinate."""

    type: Literal["joint-force"]
    name: Text
    coordinate: CoordinateEntry
    signal: SignalOrNumber


class MovingLoadEntry(Entry):
    """`MovingLoad`: a force that travels along a flexible body."""

    type: Literal["moving-load"]
    name: Text
    body: Text
    path: tuple[Text, ...] = Field(description="Corners of the path: names of nodes")
    vector: Force3
    position: SignalOrNumber = Field(description="Path length from the first corner")
    follow: Flag | None = Field(None, description="Whether it turns with the body")
    signal: SignalEntry | None = Field(None, description="Factor as a function of time")


class ServoEntry(Entry):
    """`Servo`: a controlled force or torque along a coordinate."""

    type: Literal["servo"]
    name: Text
    coordinate: CoordinateEntry
    reference: SignalOrNumber = Field(description="Wanted value of the coordinate")
    kp: Amount = Field(description="N/m, or N m/rad along an angle")
    kd: Amount | None = Field(None, description="N s/m, or N m s/rad along an angle")
    limit: Amount | None = Field(None, description="Largest force or torque")


class ModalLoadEntry(Entry):
    """`ModalLoad`: nodal forces that follow a flexible body, such as a pressure."""

    type: Literal["modal-load"]
    name: Text
    body: Text
    pattern: Pattern = Field(
        description="Forces in the body frame: for named nodes, a list with one for every node, or "
        "a file (.csv, .txt, .npy) with them in N"
    )
    signal: SignalEntry | None = Field(None, description="Factor as a function of time")


class _Function:
    """Annotation of ``module:function`` or ``file.py:function``."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Check that there is a colon with something on both sides."""

        def check(value: Any) -> str:
            place, colon, name = value.rpartition(":") if isinstance(value, str) else ("", "", "")
            if not (colon and place.strip() and name.isidentifier()):
                raise fail(
                    "expects module:function or file.py:function such as wind.py:drag, "
                    f"got {describe(value)}"
                )
            return str(value)

        return core_schema.no_info_plain_validator_function(check)

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        """Describe as a string with a colon."""
        return {"type": "string", "pattern": r"^.+:[^:]+$", "description": "module:function"}


class UserForceEntry(Entry):
    """`UserForce`: force and torque by a function; it runs only if the file is trusted."""

    type: Literal["user-force"]
    name: Text
    marker: Marker
    function: Annotated[str, _Function()] = Field(
        description="module:function, or file.py:function relative to the model file"
    )
    reference: Marker | None = Field(None, description="Frame of motion and force; the world")


# -- friction -------------------------------------------------------------------------------


class RegularisedEntry(Entry):
    """`Regularised`: a smooth law; what sticks creeps."""

    type: Literal["regularised"]
    velocity: Velocity | None = Field(
        None, description="Slip speed at which friction is full, 1 mm/s if not given"
    )


class StickSlipEntry(Entry):
    """`StickSlip`: joints stick by a constraint, then slip."""

    type: Literal["stick-slip"]


LawEntry: TypeAlias = Annotated[
    Annotated[RegularisedEntry, Tag("regularised")] | Annotated[StickSlipEntry, Tag("stick-slip")],
    tagged(),
]


class FrictionEntry(Entry):
    """`Friction` of a revolute, prismatic or cylindrical joint."""

    name: Text
    joint: Text = Field(description="Name of an entry of joints")
    mu_kinetic: Number
    mu_static: Number | None = Field(None, description="mu_kinetic if not given")
    radius: Length | None = Field(None, description="Of the pin, where the joint turns")
    bearing_length: Length | None = Field(
        None, description="Over which bending moments press; they do not if not given"
    )
    collar_radius: Length | None = Field(
        None, description="Of the thrust collar, or arm of a guide that carries moments"
    )
    preload: ForceN | None = Field(None, description="Normal force that is always there")
    law: LawEntry | None = Field(None, description="At low speed; regularised if not given")
