"""Solid elements of a part as arrays, and their matrices."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Ints, Sparse
from jousto.base.object_repr import described
from jousto.materials.material import Material
from jousto.materials.orthotropic import Orthotropic, elasticity
from jousto.mesh.reference import gradients, jacobians, table
from jousto.parts.solids.bricks import brick_stiffness, is_special

BLOCK_BYTES = 48 << 20
"""Memory of one block of elements during assembly, bytes."""

VOIGT = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2]])
"""Index of ``s_ij`` in ``[s11 s22 s33 s12 s23 s13]``."""


@described
@dataclass(frozen=True, eq=False)
class SolidGroup:
    """Elements of one kind and one material; its builder checks the data.

    Attributes
    ----------
    kind : str
        One of `elements.KINDS`.
    nodes : (ne, k) ndarray
        Node indices, VTK's order.
    ids : (ne,) ndarray
        Numbers of the elements in their file.
    material : int
        Index into the materials of the model.
    formulation : str
        Formulation of the stiffness, see :class:`Cells`.
    """

    kind: str
    nodes: Ints
    ids: Ints
    material: int
    formulation: str = "full"

    def __len__(self) -> int:
        return len(self.nodes)


@described
@dataclass(frozen=True, eq=False)
class SolidModel:
    """Solid elements of a part; its builder checks the data.

    Attributes
    ----------
    nodes : (nn, 3) ndarray
        Positions in m, part frame.
    node_ids : (nn,) ndarray
        Numbers of the nodes in their file.
    groups : tuple of SolidGroup
    materials : tuple of Material or Orthotropic
    names : tuple of str
        Names of the materials, for the labels of stress sites where two materials meet.
    density_factor : float
        Factor of all densities (mass scaling by a weighed mass).
    faces : tuple of (nf, k) ndarray
        Outer faces by kind, normals outwards.
    face_materials : tuple of (nf,) ndarray
        Index of the material behind each face.
    """

    nodes: Array
    node_ids: Ints
    groups: tuple[SolidGroup, ...]
    materials: tuple[Material | Orthotropic, ...]
    names: tuple[str, ...]
    density_factor: float = 1.0
    faces: tuple[Ints, ...] = ()
    face_materials: tuple[Ints, ...] = ()

    @property
    def count(self) -> int:
        """Number of elements."""
        return sum(len(group) for group in self.groups)

    def density(self, group: SolidGroup) -> float:
        """Density of a group in kg/m^3."""
        return self.density_factor * self.materials[group.material].rho

    def stiffness(self) -> Sparse:
        """Return the stiffness matrix (3 nn, 3 nn) in N/m, ``sum_e int B^T C B dV``."""
        pattern = self._pattern
        data = np.zeros((pattern.nnz, 9))
        flat = data.reshape(-1)
        for group, rows, place in self._blocks("stiffness"):
            C = elasticity(self.materials[group.material])
            x = self.nodes[group.nodes[rows]]
            k = element_stiffness(group.kind, x, C, group.formulation)
            index = 9 * place.reshape(-1, 1) + np.arange(9)
            np.add.at(flat, index.reshape(-1), k.reshape(-1))
        nn = len(self.nodes)
        blocks = data.reshape(-1, 3, 3)
        K = sp.bsr_array((blocks, pattern.indices, pattern.indptr), shape=(3 * nn, 3 * nn))
        return K.tocsr()

    def scalar_mass(self) -> Sparse:
        """Return the mass matrix (nn, nn) in kg of one direction, ``sum_e int rho N^T N dV``."""
        pattern = self._pattern
        data = np.zeros(pattern.nnz)
        for group, rows, place in self._blocks("mass"):
            m = element_mass(group.kind, self.nodes[group.nodes[rows]], self.density(group))
            np.add.at(data, place.reshape(-1), m.reshape(-1))
        return sp.csr_array((data, pattern.indices, pattern.indptr), shape=pattern.shape)

    def lumped_mass(self) -> Array:
        """Return lumped masses (nn,) in kg, in proportion to the diagonal of the element matrix.

        The masses are positive for every element: Hinton, Rock and Zienkiewicz, *Earthquake
        Engineering and Structural Dynamics* 4 (1976) 245-249.
        """
        masses = np.zeros(len(self.nodes))
        for group, rows, _ in self._blocks("mass"):
            m = element_mass(group.kind, self.nodes[group.nodes[rows]], self.density(group))
            diagonal = np.einsum("eaa->ea", m)
            share = diagonal / diagonal.sum(axis=1, keepdims=True)
            np.add.at(masses, group.nodes[rows], share * m.sum(axis=(1, 2))[:, None])
        return masses

    def volume(self) -> float:
        """Volume in m^3."""
        total = 0.0
        for group, rows, _ in self._blocks("mass"):
            points = table(group.kind, "mass")
            detJ = jacobians(points.dN, self.nodes[group.nodes[rows]])
            total += float((detJ @ points.weights).sum())
        return total

    @cached_property
    def _pattern(self) -> sp.csr_array:
        """Sparsity pattern of nodes that share an element; the data are unused."""
        return self._places[0]

    @cached_property
    def _places(self) -> tuple[sp.csr_array, Ints]:
        """Pattern, and the position in the pattern of each pair of nodes of each element."""
        nn = len(self.nodes)
        rows = [np.repeat(g.nodes, g.nodes.shape[1], axis=1).ravel() for g in self.groups]
        columns = [np.tile(g.nodes, (1, g.nodes.shape[1])).ravel() for g in self.groups]
        row = np.concatenate(rows).astype(np.int32)
        column = np.concatenate(columns).astype(np.int32)
        count = np.arange(len(row), dtype=np.int32)
        # sort the pairs by row and column: a counting sort, then short sorts
        order = sp.coo_matrix((count, (row, column)), shape=(nn, nn))
        order.has_canonical_format = True  # keep duplicate entries separate
        pairs = order.tocsr()
        pairs.has_sorted_indices = False
        pairs.sort_indices()
        starts = np.zeros(len(row) + 1, dtype=bool)
        starts[pairs.indptr] = True
        first = starts[:-1].copy()
        first[1:] |= pairs.indices[1:] != pairs.indices[:-1]
        number = np.cumsum(first) - 1
        place = np.empty(len(row), dtype=np.int64)
        place[pairs.data] = number
        indptr = np.concatenate([[0], np.cumsum(first)])[pairs.indptr]
        indices = pairs.indices[first]
        shape = (nn, nn)
        return sp.csr_array((np.empty(len(indices)), indices, indptr), shape=shape), place

    def _blocks(self, purpose: str) -> Iterator[tuple[SolidGroup, slice, Ints]]:
        """Yield blocks of elements: group, element rows, positions of node pairs in the pattern."""
        at = 0
        for group in self.groups:
            ne, k = group.nodes.shape
            nq = len(table(group.kind, purpose).weights)
            # bricks of special formulation have dense operators at each point
            dense = 240 * nq * k if is_special(group.kind, group.formulation) else 12 * nq * k
            step = max(1, BLOCK_BYTES // (8 * (36 * k * k + dense)))
            place = self._places[1][at : at + ne * k * k].reshape(ne, k, k)
            at += ne * k * k
            for start in range(0, ne, step):
                rows = slice(start, min(start + step, ne))
                yield group, rows, place[rows]


def element_stiffness(kind: str, x: Array, C: Array, formulation: str = "full") -> Array:
    """Return element stiffness matrices as blocks of node pairs, (ne, k, k, 3, 3) in N/m.

    ``K_ai,bj = C_imjn int (dN_a/dx_m) (dN_b/dx_n) dV``; for bricks of special formulation see
    `bricks`.

    Parameters
    ----------
    kind : str
    x : (ne, k, 3) ndarray
        Positions of the nodes in m.
    C : (6, 6) ndarray
        Elasticity in Pa, Voigt order ``[11 22 33 12 23 13]``.
    formulation : str
        See `SolidGroup`.
    """
    if is_special(kind, formulation):
        return brick_stiffness(formulation, x, C)
    t = table(kind, "stiffness", formulation)
    ne, k = x.shape[:2]
    G, detJ = gradients(t.dN, x)
    A = (np.sqrt(t.weights * detJ)[:, :, None, None] * G).reshape(ne, -1, 3 * k)
    H = np.matmul(A.transpose(0, 2, 1), A).reshape(ne, 3, k, 3, k)
    H = np.ascontiguousarray(H.transpose(0, 2, 4, 1, 3)).reshape(-1, 9)
    C4 = C[VOIGT[:, :, None, None], VOIGT]  # i m j n
    K = (H @ C4.transpose(1, 3, 0, 2).reshape(9, 9)).reshape(ne, k, k, 3, 3)
    return np.asarray(0.5 * (K + K.transpose(0, 2, 1, 4, 3)))


def element_mass(kind: str, x: Array, rho: float) -> Array:
    """Return consistent element mass matrices of one direction, (ne, k, k) in kg."""
    t = table(kind, "mass")
    k = x.shape[1]
    NN = (t.N[:, :, None] * t.N[:, None, :]).reshape(-1, k * k)
    detJ = jacobians(t.dN, x)
    return np.asarray((rho * t.weights * detJ) @ NN).reshape(-1, k, k)


def expanded(scalar: Sparse) -> Sparse:
    """Return the mass matrix of three directions from the matrix of one direction."""
    csr = sp.csr_array(scalar)
    count = np.repeat(np.diff(csr.indptr), 3)
    indptr = np.concatenate([[0], np.cumsum(count)])
    # row 3 a + i contains row a in the columns 3 b + i
    row = np.repeat(np.arange(csr.shape[0]), np.diff(csr.indptr))
    place = np.arange(csr.nnz) - csr.indptr[row]
    width = np.diff(csr.indptr)[row]
    at = 3 * csr.indptr[row] + place
    indices = np.empty(3 * csr.nnz, dtype=np.int32)
    data = np.empty(3 * csr.nnz)
    for i in range(3):
        indices[at + i * width] = 3 * csr.indices + i
        data[at + i * width] = csr.data
    shape = (3 * csr.shape[0], 3 * csr.shape[0])
    return sp.csr_array((data, indices, indptr.astype(np.int32)), shape=shape)
