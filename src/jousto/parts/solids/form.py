"""A mesh with its materials, which a part is made of."""

from __future__ import annotations

from typing import Any

from jousto.base.errors import Problems
from jousto.base.fields import AnyField, Choice, Flag, OptionalText, field
from jousto.base.numbers import OptionalPositive, set_fields
from jousto.mesh.mesh import Mesh
from jousto.parts.form import PartForm
from jousto.parts.solids.build import solid_fields


class MeshSolid(PartForm):
    """A part of solid elements from a mesh.

    Nodes keep the order of the mesh; nodes that no solid element uses are left out with a
    warning. ``K = int B^T C B dV`` and ``M = int rho N^T N dV`` are integrated exactly for
    straight elements, the mass for curved ones, too, unless the types of the elements in their
    file say otherwise, such as Abaqus's ``C3D8I``. Take quadratic elements (``tetra10``,
    ``hexahedron20``, ``wedge15``): linear ones are far too stiff in bending.

    Raises
    ------
    InputError
        With everything that is wrong: no solid elements, unknown sets, elements without a
        material or turned inside out, point masses that cannot be held, errors that
        :meth:`Mesh.check` finds.

    Warns
    -----
    JoustoWarning
        If nodes belong to no solid element, the weighed mass is far from the model's, or the
        mesh is doubtful: its size suggests another unit, it falls into pieces, nodes coincide.
    """

    mesh: AnyField = field(
        "With ``tetra tetra10 hexahedron hexahedron20 wedge wedge15`` elements", noun="Mesh"
    )
    materials: AnyField = field(
        "One for all elements, or one for each element set (or each material named in the file)",
        noun="Material, Orthotropic or {str: Material or Orthotropic}",
    )
    formulation: Choice = field(
        "Of all elements that have it, in place of the one in the mesh (``own``); see "
        ":class:`Cells`",
        words=("own", "full", "reduced", "incompatible", "bbar"),
        default="own",
        kw_only=True,
    )
    lumped: Flag = field(
        "Mass on the nodes instead of the consistent mass: shares of each element's mass like the "
        "diagonal of its consistent matrix",
        default=False,
        kw_only=True,
    )
    point_masses: AnyField = field(
        "Rigid masses on a node, or on the mean of a node set; inertia and offset need a set",
        form="point masses",
        noun="PointMass or sequence of PointMass",
        default=(),
        kw_only=True,
    )
    weighed_mass: OptionalPositive = field(
        "Mass of the real part with its point masses: densities are scaled to meet it",
        unit="kg",
        default=None,
        kw_only=True,
    )
    interfaces: AnyField = field(
        "Surfaces tied to one node of six motions each",
        form="interfaces",
        noun="sequence of Interface",
        default=(),
        kw_only=True,
    )
    name: OptionalText = field(
        "That of the mesh if not given", file=False, default=None, kw_only=True
    )

    def heading(self, problems: Problems) -> str:
        """Return the beginning of messages, with the name of the mesh where none is given."""
        if vars(self)["name"] is None:
            set_fields(self, name=str(getattr(self.mesh, "name", "solid")))
        return f"part '{self.name}'"

    def _formulated(self) -> Any:
        """Return the mesh with the formulation that is wanted."""
        given: Any = self.mesh
        if self.formulation == "own" or not isinstance(given, Mesh):
            return given
        return given.formulated(self.formulation)

    def assembled(self) -> dict[str, Any]:
        """Return the fields of the part."""
        fields = solid_fields(
            self._formulated(),
            self.materials,
            f"part '{self.name}'",
            lumped=self.lumped,
            point_masses=self.point_masses,
            weighed_mass=self.weighed_mass,
        )
        return {"name": self.name, "interfaces": self.interfaces, **fields}
