"""Stress and strain at the nodes of solids, element by element, without an explicit matrix."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Ints, Sparse, as_csr, read_only, times
from jousto.base.errors import InputError, Problem, suggest
from jousto.base.object_repr import described
from jousto.materials.material import Material
from jousto.materials.orthotropic import elasticity
from jousto.mesh.reference import CORNERS, gradients, places, shape_functions, table
from jousto.parts.solids.bricks import is_special, kinematics
from jousto.parts.solids.faces import FaceStress, face_stress
from jousto.parts.solids.model import VOIGT, SolidGroup, SolidModel

BLOCK_BYTES = 96 << 20
"""Memory of the strains of one block of displacement columns, bytes."""


ROWS_BYTES = 32 << 20
"""Memory of the unit displacements of one block and of their stress, bytes."""


@described
@dataclass(frozen=True, eq=False)
class SolidStress:
    """Stress or strain at nodes of solids from nodal displacements.

    In each element strains are computed at the points where they are most accurate (Barlow, *Int.
    J. Num. Meth. Eng.* 10 (1976) 243-251), extrapolated to its nodes by the linear shape functions
    of its corners, and averaged over the elements of one material around a node. On outer faces of
    quadratic elements the in-plane strain is that of the face, and only the traction is
    extrapolated, see `face_stress`. A node where materials meet has one site per material.

    Attributes
    ----------
    model : SolidModel
    node : (ns,) ndarray of int
        Node index of each site.
    material : (ns,) ndarray of int
        Index of the material of each site.
    quantity : str
        ``"stress"`` in Pa: ``[s11 s22 s33 s12 s23 s13]``, or ``"strain"``:
        ``[e11 e22 e33 g12 g23 g13]`` with engineering shear strains g. Part axes.
    faces : bool
        Whether the in-plane strain on outer faces is that of the faces. With False the whole strain
        is extrapolated from inside, as in most finite element programs: ``replace(part.stress,
        faces=False)``.
    """

    model: SolidModel
    node: Ints
    material: Ints
    quantity: str = "stress"
    faces: bool = True

    @classmethod
    def everywhere(cls, model: SolidModel, quantity: str = "stress") -> SolidStress:
        """Return the operator for all nodes."""
        pairs = [
            np.unique(g.nodes).astype(np.int64) * len(model.materials) + g.material
            for g in model.groups
        ]
        both = np.unique(np.concatenate(pairs))
        return cls(model, both // len(model.materials), both % len(model.materials), quantity)

    def __len__(self) -> int:
        return len(self.node)

    @cached_property
    def sites(self) -> tuple[str, ...]:
        """Labels: ``n12`` for node number 12 of the mesh; ``n12.left`` if materials meet there."""
        return labels(self.model, self.node, self.material)

    @cached_property
    def positions(self) -> Array:
        """Undeformed positions in m, part frame, (ns, 3)."""
        return read_only(self.model.nodes[self.node])

    @cached_property
    def axes(self) -> Array:
        """Axes in which the components are resolved, (ns, 3, 3): those of the part."""
        return np.broadcast_to(np.eye(3), (len(self), 3, 3))

    @cached_property
    def elasticity(self) -> Array | None:
        """Young's modulus in Pa and Poisson's ratio, (ns, 2); None if one is orthotropic."""
        constants = []
        for m in self.model.materials:
            if not isinstance(m, Material):
                return None
            constants.append((m.E, m.nu))
        return np.array(constants)[self.material]

    @cached_property
    def compliance(self) -> Array | None:
        """Compliance (strain from stress), (ns, 6, 6) in 1/Pa, if a material is orthotropic.

        Else None.
        """
        return compliances(self.model, self.material)

    def evaluate(self, d: Array) -> Array:
        """Return stress or strain, (ns, 6, ncol), from displacements (ndof, ncol) or (ndof,).

        A single column of displacements gives (ns, 6).
        """
        x = np.asarray(d, dtype=np.float64)
        X = x.reshape(len(x), -1)
        weights, rows = self._averages
        points = weights.shape[1]
        step = max(1, BLOCK_BYTES // (48 * max(points, 1)))
        out = np.empty((len(self), 6, X.shape[1]))
        for i in range(0, X.shape[1], step):
            part = X[:, i : i + step]
            strains = np.empty((points, 6, part.shape[1]))
            at = 0
            for group, chosen in zip(self.model.groups, rows, strict=True):
                nq = len(table(group.kind, "stress", group.formulation).weights)
                size = len(chosen) * nq
                point_strains(self.model, group, chosen, part, strains[at : at + size])
                at += size
            mean = times(weights, strains.reshape(points, -1)).reshape(len(self), 6, -1)
            out[:, :, i : i + step] = mean
        self._apply([elasticity(material) for material in self.model.materials], out)
        if self.faces:
            self._outer.correct(out, X)
        if self.quantity == "strain":
            C = [elasticity(material) for material in self.model.materials]
            self._apply([np.asarray(np.linalg.inv(law)) for law in C], out)
        return out[:, :, 0] if x.ndim == 1 else out

    def _apply(self, laws: Sequence[Array], out: Array) -> None:
        """Multiply (ns, 6, n) by the matrix of the material of each site."""
        for m, law in enumerate(laws):
            mine = slice(None) if len(laws) == 1 else self.material == m
            out[mine] = np.einsum("ij,sjk->sik", law, out[mine])

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
            raise InputError(Problem(self.quantity, f"no site '{site}'{suggest(site, self.sites)}"))
        return self._index[site]

    def select(self, sites: Sequence[str]) -> SolidStress:
        """Return the operator of some sites, in the given order.

        Raises
        ------
        InputError
            If a site does not exist.
        """
        i = np.array([self.index(site) for site in sites], dtype=np.int64)
        return replace(self, node=self.node[i], material=self.material[i])

    def rows(self, sites: Sequence[str]) -> Sparse:
        """Return the operator (6 m, ndof) from nodal displacements to the stress at a few sites.

        Raises
        ------
        InputError
            If a site does not exist.
        """
        few = self.select(sites)
        # the elements around the sites as a separate model
        groups = [
            (group, chosen)
            for group, chosen in zip(self.model.groups, few._averages[1], strict=True)
            if len(chosen)
        ]
        used = np.unique(np.concatenate([group.nodes[chosen].ravel() for group, chosen in groups]))
        # outer faces at the sites belong to these elements
        faces = [
            (face, np.any(few.numbers[m[:, None], face] >= 0, axis=1))
            for face, m in zip(self.model.faces, self.model.face_materials, strict=True)
        ]
        around = replace(
            self.model,
            nodes=self.model.nodes[used],
            node_ids=self.model.node_ids[used],
            groups=tuple(
                replace(
                    group,
                    nodes=np.searchsorted(used, group.nodes[chosen]),
                    ids=group.ids[chosen],
                )
                for group, chosen in groups
            ),
            faces=tuple(np.searchsorted(used, face[mask]) for face, mask in faces),
            face_materials=tuple(
                m[mask] for m, (_, mask) in zip(self.model.face_materials, faces, strict=True)
            ),
        )
        local = replace(few, model=around, node=np.searchsorted(used, few.node))
        n, m = 3 * len(used), 6 * len(few)
        columns = (3 * used[:, None] + np.arange(3)).ravel()
        # block by block of columns: all columns would not fit, and are nearly empty
        step = max(1, ROWS_BYTES // (8 * (n + m)))
        found = []
        for start in range(0, n, step):
            unit = np.zeros((n, min(step, n - start)))
            unit[start + np.arange(unit.shape[1]), np.arange(unit.shape[1])] = 1.0
            found.append(sp.csc_array(local.evaluate(unit).reshape(m, -1)))
        place = (np.ones(n), (np.arange(n), columns))
        spread = sp.csr_array(sp.coo_array(place, shape=(n, 3 * len(self.model.nodes))))
        return as_csr(sp.hstack(found, format="csr") @ spread)

    def at(self, nodes: Sequence[int] | Ints) -> SolidStress:
        """Return the operator for the sites at some nodes (indices of the part), in node order."""
        i = np.flatnonzero(np.isin(self.node, np.asarray(nodes)))
        return replace(self, node=self.node[i], material=self.material[i])

    @cached_property
    def numbers(self) -> Ints:
        """Index of the site of each node in each material (n materials, nn), -1 for none."""
        site = np.full((len(self.model.materials), len(self.model.nodes)), -1, dtype=np.int64)
        site[self.material, self.node] = np.arange(len(self))
        return site

    @cached_property
    def _outer(self) -> FaceStress:
        """Stress of the sites on outer faces."""
        return face_stress(self.model, self.numbers, len(self))

    @cached_property
    def _averages(self) -> tuple[Sparse, tuple[Ints, ...]]:
        """Weights (ns, points) of the strains at the points; and the elements with these points."""
        site = self.numbers
        chosen, rows, columns, values, at = [], [], [], [], 0
        for group in self.model.groups:
            mine = site[group.material][group.nodes]
            touching = np.flatnonzero(np.any(mine >= 0, axis=1))
            chosen.append(touching)
            E = continuation(group.kind, group.formulation)
            k, nq = E.shape
            row = np.broadcast_to(mine[touching][:, :, None], (len(touching), k, nq))
            column = at + np.arange(len(touching) * nq).reshape(-1, 1, nq)
            keep = row >= 0
            rows.append(row[keep])
            columns.append(np.broadcast_to(column, row.shape)[keep])
            values.append(np.broadcast_to(E, row.shape)[keep])
            at += len(touching) * nq
        row, value = np.concatenate(rows), np.concatenate(values)
        # the weights of each element add up to one at its nodes
        total = np.bincount(row, weights=value, minlength=len(self))
        value = value / total[row]
        matrix = sp.coo_array((value, (row, np.concatenate(columns))), shape=(len(self), at))
        return as_csr(matrix.tocsr()), tuple(chosen)


def continuation(kind: str, formulation: str = "full") -> Array:
    """Return the weights (k, nq) that extrapolate values at the stress points to the nodes."""
    points = table(kind, "stress", formulation).points
    corners = CORNERS[kind]
    if len(points) == 1:
        return np.ones((len(places(kind)), 1))
    at_points = shape_functions(corners, points)[0]
    at_nodes = shape_functions(corners, places(kind))[0]
    # fewer points than corners: smallest corner values, constant in the missing directions
    square = len(points) == at_points.shape[1]
    return np.asarray(at_nodes @ (np.linalg.inv if square else np.linalg.pinv)(at_points))


def point_strains(model: SolidModel, group: SolidGroup, chosen: Ints, X: Array, out: Array) -> None:
    """Write the strains (len(chosen) * nq, 6, n) at the points of some elements.

    Parameters
    ----------
    model : SolidModel
    group : SolidGroup
    chosen : (m,) ndarray of int
        Elements of the group.
    X : (ndof, n) ndarray
        Displacements.
    out : (m * nq, 6, n) ndarray
        ``[e11 e22 e33 g12 g23 g13]`` at the points of the first element, of the second and so on.
    """
    nq = len(table(group.kind, "stress", group.formulation).weights)
    n, k = X.shape[1], group.nodes.shape[1]
    step = max(1, (16 << 20) // (8 * (3 * k * n + 9 * nq * n + 240 * nq * k)))
    # a view for any order in memory; the displacements of a block are copied, never all of them
    U = X.reshape(len(model.nodes), 3, n)
    for start in range(0, len(chosen), step):
        nodes = group.nodes[chosen[start : start + step]]
        block = out[start * nq : (start + len(nodes)) * nq]
        own = U[nodes].reshape(*nodes.shape, 3 * n)
        block_strains(model, group, nodes, own, "stress", block)


def block_strains(
    model: SolidModel, group: SolidGroup, nodes: Ints, U: Array, purpose: str, out: Array
) -> Array:
    """Write strains of elements with the same nodes (m, k); return volumes (m, nq) in m^3.

    Parameters
    ----------
    model : SolidModel
    group : SolidGroup
        Kind, formulation and material of the elements.
    nodes : (m, k) ndarray of int
    U : (m, k, 3 n) ndarray
        Displacements of the nodes, direction by direction.
    purpose : {"stress", "stiffness"}
        Purpose of the integration points; see `table`.
    out : (m * nq, 6, n) ndarray
        See `point_strains`.
    """
    m, k = nodes.shape
    x = model.nodes[nodes]
    if is_special(group.kind, group.formulation):
        felt = kinematics(group.formulation, x, elasticity(model.materials[group.material]))
        B = felt.strain.reshape(m, -1, 3 * k)
        out[:] = np.matmul(B, U.reshape(m, 3 * k, -1)).reshape(out.shape)
        return felt.volume
    t = table(group.kind, purpose, group.formulation)
    G, detJ = gradients(t.dN, x)
    nq = len(t.weights)
    strains_of(np.matmul(G.reshape(m, 3 * nq, k), U).reshape(m * nq, 3, 3, -1), out)
    return np.asarray(t.weights * detJ)


def strains_of(D: Array, out: Array) -> None:
    """Write strains (m, 6, n) of displacement gradients (m, 3, 3, n), ``D_ij = du_j / dx_i``."""
    for i in range(3):
        out[:, i] = D[:, i, i]
    for i, j in ((0, 1), (1, 2), (0, 2)):
        np.add(D[:, i, j], D[:, j, i], out=out[:, VOIGT[i, j]])


def labels(model: SolidModel, node: Ints, material: Ints) -> tuple[str, ...]:
    """Return the labels of sites at nodes (ns,) in materials (ns,)."""
    ids = model.node_ids[node]
    if len(model.materials) == 1:
        return tuple(f"n{i}" for i in ids)
    count = np.zeros((len(model.nodes), len(model.materials)), dtype=np.int64)
    for group in model.groups:
        count[np.unique(group.nodes), group.material] = 1
    several = count.sum(axis=1)[node] > 1
    return tuple(
        f"n{i}.{model.names[m]}" if shared else f"n{i}"
        for i, m, shared in zip(ids, material, several, strict=True)
    )


def compliances(model: SolidModel, material: Ints) -> Array | None:
    """Return the compliance (ns, 6, 6) at sites in materials (ns,); None if all are isotropic."""
    if all(isinstance(m, Material) for m in model.materials):
        return None
    return np.array([np.linalg.inv(elasticity(m)) for m in model.materials])[material]
