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
    Frequency,
    InertiaTensor,
    Position,
    Text,
    Vector,
)
from jousto.schema.entries.choices import by_form
from jousto.schema.entries.declared import FORMS, EntryOf, entry_of, one_of

MaterialEntry: Any = entry_of(Material, implied=True)
MaterialForm: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")] | Annotated[MaterialEntry, Tag("mapping")], by_form()
]
SectionEntry: Any = one_of("sections", "jousto.sections")
TheoryEntry: Any = one_of("theories", "jousto.parts.frames")
PointMassEntry: Any = Annotated[Any, EntryOf("jousto.parts.mass", "PointMass")]
MemberEntry: Any = Annotated[Any, EntryOf("jousto.parts.frames.members", "Member")]


class LoadPatternEntry(Entry):
    """A force spread evenly over nodes, of any size: its static response is then exact."""

    force: Direction = Field(description="Direction, part frame")
    nodes: Text = Field(description="A set of nodes")


class PressurePatternEntry(Entry):
    """A pressure on a surface of a solid, of any size: its static response is then exact."""

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
METHODS = ("reductions", "jousto.reduction.methods")
MethodEntry: Any = one_of(*METHODS)


class ModeChoice(Entry):
    """Which of the computed modes to keep; at most one of the two."""

    in_plane: Literal["xy", "yz", "xz"] | None = Field(
        None, description="Keep the modes that move in this plane only"
    )
    keep: tuple[Count, ...] | None = Field(None, description="Keep these modes, counted from 0")


class FePart(ModeChoice):
    """What all parts with a mesh have."""

    reduce: MethodEntry
    residual_stress: Flag | None = Field(
        None, description="Keep the stress that the modes leave out, for jousto stress --residual"
    )


# -- parts ----------------------------------------------------------------------------------


class FramePart(FePart):
    """What all parts made of beams have besides the fields of their class."""

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


class SuperelementEntry(Entry):
    """`reduce_superelement`: what the other program kept, orthonormal."""

    type: Literal["superelement"]
    modes: Count | None = Field(None, description="Keep the lowest; all if not given")
    frequency_limit: Frequency | None = Field(None, description="Highest frequency kept")


MatricesMethod: Any = one_of(*METHODS, others={"superelement": SuperelementEntry})
SetInterfaceEntry: Any = Annotated[
    Any,
    EntryOf(
        "jousto.parts.interface",
        "Interface",
        prefix="Set",
        nodes=(Text, Field(description="A node set")),
    ),
]


class MatricesEntry(ModeChoice):
    """`Part.from_file`: mass and stiffness from another program."""

    type: Literal["matrices"]
    reduce: MatricesMethod
    K: Text = Field(
        description="File of the stiffness matrix, or of both: .sti, .full, .op4, .pch, .mtx, .npz,"
        " .npy, .rsa"
    )
    M: Text | None = Field(
        None, description="File of the mass matrix, where it is another one that is not beside K"
    )
    nodes: Nodes | None = Field(
        None,
        description="Positions: a mesh, a table of x y z or number x y z (.npy, .csv, .txt), or a"
        " list; found beside the matrices of CalculiX, Ansys and Nastran",
    )
    dofs: Text | None = Field(
        None, description="File with the node and the direction (1..6, 0 modal) of each row"
    )
    format: Literal["calculix", "ansys", "op4", "dmig", "abaqus", "plain"] | None = Field(
        None, description="From the ending and the content if not given"
    )
    units: Text | None = Field(
        None, description="Units of the files, such as SI, mm-t-s, in-lbf-s; SI if not given"
    )
    dofs_per_node: Count | None = Field(None, description="3 or 6, from the sizes if not given")
    node_sets: dict[Text, tuple[Count, ...]] | None = Field(
        None,
        description="Numbers of nodes as in the other program; counted from 0 for plain matrices"
        " without dofs",
    )
    interfaces: tuple[SetInterfaceEntry, ...] | None = Field(
        None, description="Surfaces that follow a node with six directions"
    )
    elements: tuple[tuple[Count, ...], ...] | None = Field(None, description="For drawing only")


class ReducedEntry(ModeChoice):
    """`ReducedPart.load`: a part reduced before, in an HDF5 file."""

    type: Literal["reduced"] = "reduced"
    file: Text
