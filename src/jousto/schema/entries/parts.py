"""Parts in the model file: beams, frames, matrices, their materials, sections and reduction."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Discriminator, Field, Tag

from jousto.materials.material import Material
from jousto.schema.entries.base import (
    Count,
    Direction,
    Entry,
    Flag,
    InertiaTensor,
    Position,
    Text,
    Vector,
)
from jousto.schema.entries.choices import by_form
from jousto.schema.entries.declared import (
    FORMS,
    ROW,
    EntryBy,
    EntryOf,
    entry_of,
    keys_of,
    one_of,
    special,
)

MaterialEntry: Any = entry_of(Material, implied=True)
MaterialForm: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")] | Annotated[MaterialEntry, Tag("mapping")], by_form()
]
SectionEntry: Any = one_of("sections", "jousto.sections")
TheoryEntry: Any = one_of("theories", "jousto.parts.frames")
PointMassEntry: Any = Annotated[Any, EntryOf("jousto.parts.mass", "PointMass")]
MemberEntry: Any = Annotated[Any, EntryOf("jousto.parts.frames.members", "Member")]


class LoadPatternEntry(Entry):
    """Uniform force on nodes as a residual load of the reduction: exact static response."""

    force: Direction = Field(description="Direction, part frame")
    nodes: Text = Field(description="A set of nodes")


class PressurePatternEntry(Entry):
    """Pressure on a solid's surface as a residual load of the reduction: exact static response."""

    pressure: Text = Field(description="A surface, or a set with all nodes of its faces")


def _residual_form(value: Any) -> str:
    if isinstance(value, PressurePatternEntry) or (isinstance(value, dict) and "pressure" in value):
        return "pressure load"
    return "scalar" if isinstance(value, str) else "force load"


Residual: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")]
    | Annotated[LoadPatternEntry, Tag("force load")]
    | Annotated[PressurePatternEntry, Tag("pressure load")],
    Discriminator(_residual_form),
]


FORMS.update(
    {
        "inertia": lambda field: InertiaTensor,
        "material": lambda field: MaterialForm,
        "residuals": lambda field: tuple[Residual, ...],
    }
)
SHAPES: Any = one_of("shape functions", "jousto.reduction.shapes")
FORMS["shape functions"] = lambda field: Annotated[
    Annotated[SHAPES, Tag("mapping")] | Annotated[ROW[SHAPES, ...], Tag("list")], by_form()
]
METHODS = ("reductions", "jousto.reduction.methods")
MethodEntry: Any = one_of(*METHODS)


class ModeChoice(Entry):
    """Selection of computed modes; at most one of the two keys."""

    in_plane: Literal["xy", "yz", "xz"] | None = Field(
        None, description="Keep the modes that move in this plane only"
    )
    keep: tuple[Count, ...] | None = Field(None, description="Keep these modes, counted from 0")


class FePart(ModeChoice):
    """Keys of all parts with a mesh."""

    reduce: MethodEntry
    residual_stress: Flag | None = Field(
        None, description="Keep the stress that the modes leave out, for jousto stress --residual"
    )


# -- parts ----------------------------------------------------------------------------------


class FramePart(FePart):
    """Keys of all beam parts beside the fields of their class."""

    stiffening: Flag | None = Field(
        None, description="Forces along the beams stiffen or soften them"
    )


Sections: TypeAlias = Annotated[
    Annotated[SectionEntry, Tag("mapping")] | Annotated[tuple[SectionEntry, ...], Tag("list")],
    by_form(),
]
Materials: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")]
    | Annotated[MaterialEntry, Tag("mapping")]
    | Annotated[tuple[MaterialForm, ...], Tag("list")],
    by_form(),
]
Nodes: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")] | Annotated[tuple[Position, ...], Tag("list")], by_form()
]
FORMS.update(
    {
        "point masses": lambda field: tuple[PointMassEntry, ...],
        "members": lambda field: tuple[MemberEntry, ...],
        "pairs": lambda field: tuple[Annotated[tuple[Count, Count], Vector(2)], ...],
        "sections": lambda field: Sections,
        "materials": lambda field: Materials,
        "node sets": lambda field: dict[Text, tuple[Count, ...]],
    }
)


def superelement() -> Any:
    """Return the entry of `reduce_superelement`."""
    from jousto.reduction.superelement import Condensed

    return special(Condensed, "superelement", **keys_of(Condensed))


MatricesMethod: Any = one_of(*METHODS, others={"superelement": EntryBy(superelement)})
SetInterfaceEntry: Any = Annotated[
    Any,
    EntryOf(
        "jousto.parts.interface",
        "Interface",
        prefix="Set",
        nodes=(Text, Field(description="A node set")),
    ),
]


FORMS.update(
    {
        "positions": lambda field: Nodes,
        "cells": lambda field: tuple[tuple[Count, ...], ...],
        "set interfaces": lambda field: tuple[SetInterfaceEntry, ...],
    }
)


class MatricesChoices(ModeChoice):
    """Keys of matrix parts beside the fields of their class."""

    reduce: MatricesMethod


def matrices() -> Any:
    """Return the entry of `Part.from_file` and `Part.from_matrices`; the keys select which."""
    from jousto.parts.matrices.form import MatrixFiles, PlainMatrices

    keys = keys_of(PlainMatrices, without=("M", "K", "nodes")) | keys_of(MatrixFiles)
    return special(MatrixFiles, "matrices", base=MatricesChoices, **keys)


class ReducedEntry(ModeChoice):
    """`ReducedPart.load`: a reduced part in an HDF5 file."""

    type: Literal["reduced"] = "reduced"
    file: Text
