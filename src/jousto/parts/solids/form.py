"""A mesh with its materials as input of a part."""

from __future__ import annotations

from typing import Any

from jousto.base.errors import Problems
from jousto.base.fields import AnyField, Choice, Flag, OptionalText, field
from jousto.base.numbers import OptionalPositive, set_fields
from jousto.mesh.mesh import Mesh
from jousto.parts.form import PartForm
from jousto.parts.solids.build import solid_fields


class MeshSolid(PartForm):
    """Part of solid elements from a mesh.

    Nodes keep the order of the mesh; nodes that no solid element uses are left out with a warning.
    ``K = int B^T C B dV`` and ``M = int rho N^T N dV`` are integrated exactly for straight
    elements, and M also for curved ones, unless the element types of the file have another
    formulation, such as ``C3D8I`` of Abaqus. Use quadratic elements (``tetra10``, ``hexahedron20``,
    ``wedge15``): linear ones are far too stiff in bending.

    Raises
    ------
    InputError
        With all problems: no solid elements, unknown sets, elements without a material or of
        negative volume, point masses that cannot be attached, errors that :meth:`Mesh.check` finds.

    Warns
    -----
    JoustoWarning
        If nodes belong to no solid element, the weighed mass is far from the model's, or the mesh
        is doubtful: its size suggests another unit, it has disconnected pieces, or nodes coincide.
    """

    mesh: AnyField = field(
        "Mesh with ``tetra tetra10 hexahedron hexahedron20 wedge wedge15`` elements", noun="Mesh"
    )
    materials: AnyField = field(
        "Material of all elements, or one per element set (or per material name of the file)",
        noun="Material, Orthotropic or {str: Material or Orthotropic}",
    )
    formulation: Choice = field(
        "Formulation of all elements that support it; ``own`` for that of the mesh; see "
        ":class:`Cells`",
        words=("own", "full", "reduced", "incompatible", "bbar"),
        default="own",
        kw_only=True,
    )
    lumped: Flag = field(
        "Whether the mass is lumped at the nodes (in proportion to the diagonal of the "
        "consistent element matrix), instead of consistent",
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
        "Mass of the real part with its point masses: densities are scaled to this mass",
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
        "Name of the part; None for the name of the mesh", file=False, default=None, kw_only=True
    )

    def heading(self, problems: Problems) -> str:
        """Return the prefix of messages, with the name of the mesh for a part without a name."""
        if vars(self)["name"] is None:
            set_fields(self, name=str(getattr(self.mesh, "name", "solid")))
        return f"part '{self.name}'"

    def _formulated(self) -> Any:
        """Return the mesh with the requested formulation."""
        given: Any = self.mesh
        if self.formulation == "own" or not isinstance(given, Mesh):
            return given
        return given.formulated(self.formulation)

    def assembled(self) -> dict[str, Any]:
        """Return the fields of the part that is built from the mesh."""
        fields = solid_fields(
            self._formulated(),
            self.materials,
            f"part '{self.name}'",
            lumped=self.lumped,
            point_masses=self.point_masses,
            weighed_mass=self.weighed_mass,
        )
        return {"name": self.name, "interfaces": self.interfaces, **fields}
