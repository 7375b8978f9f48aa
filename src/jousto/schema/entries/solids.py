"""Entries of solid parts: meshes, node picks, interfaces; the union of all kinds of parts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, TypeAlias

from pydantic import Discriminator, Field, Tag, model_validator

from jousto.schema.entries.base import (
    Count,
    Entry,
    Flag,
    Length,
    Position,
    Text,
    fail,
)
from jousto.schema.entries.choices import by_form
from jousto.schema.entries.declared import FORMS, EntryBy, EntryOf, keys_of, one_of, special
from jousto.schema.entries.parts import (
    FePart,
    FramePart,
    ReducedEntry,
    matrices,
)

# -- materials ------------------------------------------------------------------------------


InlineMaterial: Any = one_of(
    "materials",
    "jousto.materials",
    implied=lambda data: "orthotropic" if "E1" in data else "isotropic",
)
SolidMaterial: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")] | Annotated[InlineMaterial, Tag("mapping")], by_form()
]

# -- meshes ---------------------------------------------------------------------------------


class MeshFileEntry(Entry):
    """`read_mesh`: a mesh in a file, .msh .inp .bdf .nas .med .vtk .vtu or .cdb."""

    file: Text
    unit: Text | None = Field(None, description="Unit of length in the file such as mm; m if none")


class CadEntry(Entry):
    """`mesh_cad`: a CAD file, .step .stp or .brep, meshed with tetrahedra."""

    cad: Text = Field(description="The file")
    size: Length = Field(description="Length of the elements' edges")
    order: Count | None = Field(None, description="2 (tetra10, if none) or 1 (tetra4)")
    curved: Flag | None = Field(None, description="Whether edges follow curved surfaces")
    per_circle: Count | None = Field(None, description="Elements along a full turn, 12 if none")
    unit: Text | None = Field(None, description="Unit of length instead of that of the file")
    refine: dict[Text, Length] | None = Field(
        None, description="Smaller elements at faces (face12) or groups"
    )


def _mesh_form(value: Any) -> str:
    if isinstance(value, dict):
        return "CAD file" if "cad" in value else "mesh file"
    if isinstance(value, CadEntry):
        return "CAD file"
    return "mesh file" if isinstance(value, MeshFileEntry) else "scalar"


MeshForm: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")]
    | Annotated[MeshFileEntry, Tag("mesh file")]
    | Annotated[CadEntry, Tag("CAD file")],
    Discriminator(_mesh_form),
]

# -- picks of nodes -------------------------------------------------------------------------


PICKS = "jousto.mesh.picks"


class HolePick(Entry):
    """Wall of the cylindrical hole whose centre is nearest to a point."""

    near: Position
    diameter: Length | None = Field(None, description="Of this diameter, within 2 %")


class PickEntry(Entry):
    """Surface nodes selected by position; exactly one of the keys."""

    box: Annotated[Any, EntryOf(PICKS, "InBox")] | None = None
    cylinder: Annotated[Any, EntryOf(PICKS, "InCylinder")] | None = None
    sphere: Annotated[Any, EntryOf(PICKS, "InSphere")] | None = None
    plane: Annotated[Any, EntryOf(PICKS, "OnPlane")] | None = None
    nearest: Annotated[Any, EntryOf(PICKS, "Nearest")] | None = None
    hole: HolePick | None = None
    inside: Flag | None = Field(None, description="Nodes inside of the part, too")

    @model_validator(mode="after")
    def _one_form(self) -> PickEntry:
        forms = [key for key in PickEntry.model_fields if key != "inside"]
        given = [key for key in forms if getattr(self, key) is not None]
        if len(given) != 1:
            found = " and ".join(given) or "none"
            raise fail(f"give one of {', '.join(forms)}; found {found}")
        return self


Pick: TypeAlias = Annotated[
    Annotated[Text, Tag("scalar")]
    | Annotated[tuple[Text, ...], Tag("list")]
    | Annotated[PickEntry, Tag("mapping")],
    by_form(),
]

# -- the part -------------------------------------------------------------------------------


FORMS["pick"] = lambda field: Pick
InterfaceEntry: Any = Annotated[Any, EntryOf("jousto.parts.interface", "Interface")]
WeldToeEntry: Any = Annotated[Any, EntryOf("jousto.fatigue.welds.toes", "WeldToe")]


class SolidChoices(FePart):
    """Keys of solids beside the fields of their class."""

    mesh: MeshForm = Field(
        description="A mesh file, {file: ..., unit: mm} or {cad: ..., size: ...}"
    )
    material: SolidMaterial | None = Field(None, description="Name in the library, or its values")
    materials: dict[Text, SolidMaterial] | None = Field(
        None, description="One for each element set, instead of one for all"
    )
    sets: dict[Text, Pick] | None = Field(None, description="Named nodes of the surface")
    stiffening: Flag | None = Field(None, description="Forces along the body stiffen or soften it")
    stress: Pick | None = Field(
        None,
        description="Where stress is kept: surface (if none), skin (free surfaces), all, none, or"
        " sets",
    )
    welds: tuple[WeldToeEntry, ...] | None = Field(
        None, description="Toes of welds: stress sites besides the others"
    )
    solver: Text | None = Field(None, description="Library for the factorisation; the best if none")
    cache: Flag | None = Field(None, description="Whether the reduction is kept for the next time")

    @model_validator(mode="after")
    def _one_material(self) -> SolidChoices:
        if (self.material is None) == (self.materials is None):
            raise fail("give either material: for the whole part or materials: by element set")
        return self


def solid() -> Any:
    """Return the entry of `Part.solid`: solid elements of a mesh or a CAD file."""
    from jousto.parts.solids.form import MeshSolid

    keys = keys_of(MeshSolid, without=("mesh", "materials"))
    return special(MeshSolid, "solid", base=SolidChoices, **keys)


FORMS["interfaces"] = lambda field: tuple[InterfaceEntry, ...]
OTHERS: Mapping[str, Any] = {
    "solid": EntryBy(solid),
    "matrices": EntryBy(matrices),
    "reduced": ReducedEntry,
}
PartEntry: Any = one_of(
    *("parts", "jousto.parts.part", lambda data: "reduced" if "file" in data else None),
    others=OTHERS,
    unsaid=("reduced",),
    base=FramePart,
)
