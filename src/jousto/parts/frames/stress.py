"""Stress at section points of beams as a linear operator of the nodal displacements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from jousto.base.arrays import Array, Ints, Sparse, as_csr, node_dofs, read_only, scatter, times
from jousto.base.errors import InputError, Problem, suggest
from jousto.base.object_repr import described
from jousto.parts.frames.element import BeamElements, end_displacements, stiffness
from jousto.sections.section import Section

# section forces are the end forces of the element, with the opposite sign at end a
_ENDS = np.array([[-1.0], [1.0]])


@described
@dataclass(frozen=True, eq=False)
class StressOperator:
    """Linear operator from nodal displacements to stress at named sites.

    At a section point (y, z) the section forces ``[N Vy Vz T My Mz]`` of the element's end give
    ``s11 = N/A + My z/Iy - Mz y/Iz`` and the shear stresses of :class:`SectionPoint`. The section
    forces are those of static equilibrium, ``k d``, exact for members loaded at their ends.

    Parameters
    ----------
    sites : tuple of str
        Names such as ``"e3.a.top"``: third element, end a, section point "top".
    positions : (ns, 3) ndarray
        Undeformed positions in m, part frame.
    axes : (ns, 3, 3) ndarray
        Columns are the local x, y, z axes in which the stress is resolved, part frame.
    matrix : (6 ns, ndof) sparse array
        Row 6 i + c gives component c of ``[s11 s22 s33 s12 s23 s13]`` at site i in Pa.
    elasticity : (ns, 2) ndarray, optional
        Young's modulus in Pa and Poisson's ratio at each site, for strains.
    compliance : (ns, 6, 6) ndarray, optional
        Compliance (strain from stress) in 1/Pa at each site, for anisotropic materials.
    """

    sites: tuple[str, ...]
    positions: Array
    axes: Array
    matrix: Sparse
    elasticity: Array | None = None
    compliance: Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "positions", read_only(self.positions))
        object.__setattr__(self, "axes", read_only(self.axes))
        if self.elasticity is not None:
            object.__setattr__(self, "elasticity", read_only(self.elasticity))

    def evaluate(self, d: Array) -> Array:
        """Return the stress (ns, 6, ncol) in Pa from displacements (ndof, ncol) or (ndof,).

        Components ``[s11 s22 s33 s12 s23 s13]`` in the axes of each site; a single column of
        displacements gives (ns, 6).
        """
        s = times(self.matrix, np.asarray(d))
        return s.reshape(len(self.sites), 6, *s.shape[1:])

    @cached_property
    def _index(self) -> dict[str, int]:
        return {site: i for i, site in enumerate(self.sites)}

    def index(self, site: str) -> int:
        """Return the index of a site.

        Raises
        ------
        InputError
            If there is no such site; the message suggests the most similar name.
        """
        if site not in self._index:
            raise InputError(Problem("stress", f"no site '{site}'{suggest(site, self.sites)}"))
        return self._index[site]

    def rows(self, sites: Sequence[str]) -> Sparse:
        """Return the operator (6 m, ndof) from nodal displacements to the stress at sites.

        Raises
        ------
        InputError
            If a site does not exist.
        """
        i = np.array([self.index(site) for site in sites], dtype=np.int64)
        return as_csr(self.matrix[node_dofs(i[:, None], 6).ravel()])

    def select(self, sites: Sequence[str]) -> StressOperator:
        """Return the operator of some sites, in the given order.

        Raises
        ------
        InputError
            If a site does not exist.
        """
        i = np.array([self.index(site) for site in sites], dtype=np.int64)
        rows = node_dofs(i[:, None], 6).ravel()
        known = None if self.elasticity is None else self.elasticity[i]
        soft = None if self.compliance is None else self.compliance[i]
        return StressOperator(
            tuple(sites), self.positions[i], self.axes[i], self.matrix[rows], known, soft
        )


def section_forces(beams: BeamElements) -> Array:
    """Return the operators (ne, 2, 6, 12) from nodal displacements to section forces.

    ``[N Vy Vz T My Mz]`` in N and N m at end a and end b, local axes, as they act on the face whose
    outward normal is the local x axis.
    """
    f = stiffness(beams) @ end_displacements(beams)
    signed: Array = f.reshape(-1, 2, 6, 12) * _ENDS[None, :, :, None]
    return signed


def beam_stress(
    beams: BeamElements, sections: Sequence[Section], elements: Ints, ndof: int
) -> StressOperator | None:
    """Return the stress operator of beams, or None if no section has points.

    Parameters
    ----------
    beams : BeamElements
    sections : sequence of Section
        One section for each element.
    elements : (ne, 2) ndarray
        Node indices.
    ndof : int
        Degrees of freedom of the part.
    """
    groups: dict[int, list[int]] = {}
    for number, section in enumerate(sections):
        groups.setdefault(id(section), []).append(number)
    points = {key: sections[members[0]].points for key, members in groups.items()}

    # order of the sites: elements, ends, points
    count = np.array([2 * len(points[id(section)]) for section in sections], dtype=np.int64)
    first = np.concatenate([[0], np.cumsum(count)])
    ns = int(first[-1])
    if ns == 0:
        return None
    sites = tuple(
        f"e{number + 1}.{end}.{point.name}"
        for number, section in enumerate(sections)
        for end in "ab"
        for point in points[id(section)]
    )

    forces = section_forces(beams)
    dofs = node_dofs(elements, 6)
    kind = beams.kind
    positions = np.empty((ns, 3), kind)
    axes = np.empty((ns, 3, 3), kind)
    constants = np.empty((ns, 2), kind)
    blocks, rows, columns = [], [], []
    for key, members in groups.items():
        m = len(points[key])
        if m == 0:
            continue
        e = np.array(members, dtype=np.int64)
        place = first[e][:, None, None] + m * np.arange(2)[:, None] + np.arange(m)
        yz = np.array([[0.0, p.y, p.z] for p in points[key]])
        ends = beams.origin[e][:, None, :] + (
            np.array([0.0, 1.0])[:, None] * (beams.length[e, None] * beams.axes[e, :, 0])[:, None]
        )
        positions[place] = ends[:, :, None] + np.einsum("eij,pj->epi", beams.axes[e], yz)[:, None]
        axes[place] = beams.axes[e][:, None, None]
        E, G = beams.EA[e] / sections[members[0]].A, beams.GJ[e] / sections[members[0]].J
        constants[place] = np.stack([E, E / (2.0 * G) - 1.0], axis=1)[:, None, None]

        S = _recovery(sections[members[0]])
        blocks.append(np.einsum("pij,eajd->eapid", S, forces[e]).reshape(-1, 3, 12))
        rows.append((6 * place[..., None] + np.array([0, 3, 5])).reshape(-1, 3))
        columns.append(np.repeat(dofs[e], 2 * m, axis=0))
    matrix = scatter(
        np.concatenate(blocks), np.concatenate(rows), np.concatenate(columns), (6 * ns, ndof)
    )
    return StressOperator(sites, positions, axes, matrix, constants)


def _recovery(section: Section) -> Array:
    """Return the matrices (points, 3, 6) from section forces [N Vy Vz T My Mz] to [s11 s12 s13]."""
    S = np.zeros((len(section.points), 3, 6), np.result_type(section.A, section.Iy, section.Iz))
    for S_p, p in zip(S, section.points, strict=True):
        S_p[0, [0, 4, 5]] = 1.0 / section.A, p.z / section.Iy, -p.y / section.Iz
        S_p[1:, 1:4] = p.shear
    return S
