"""Second-order displacements of solids, from which geometric stiffness follows.

Displacements d of the nodes are expanded to second order, ``d + 1/2 chi(d, d)``. The elastic energy
is a function of Green's strain ``E = (grad u + grad u^T + grad u^T grad u)/2``, whose part of
second order, with ``eta(x, y) = (grad x^T grad y + grad y^T grad x)/2``, is ``(eps(chi) + eta(d,
d))/2``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Ints, Sparse, as_csr, node_dofs, scatter, times
from jousto.base.object_repr import described
from jousto.base.voigt import PAIRS
from jousto.materials.orthotropic import elasticity
from jousto.mesh.reference import gradients, table
from jousto.parts.frames.second_order import (
    FIELDS,
    affine_fields,
    double_turn,
    moments,
    point_field_loads,
    point_work,
)
from jousto.parts.mass import MassPoints
from jousto.parts.solids.bricks import (
    Kinematics,
    is_special,
    kinematics,
    mean_volume_change,
)
from jousto.parts.solids.model import VOIGT, SolidGroup, SolidModel, expanded

BLOCK_BYTES = 32 << 20


@described
@dataclass(frozen=True, eq=False)
class SolidSecondOrder:
    """Quadratic forms of the nodal displacements of solids; its builder checks the data.

    Attributes
    ----------
    model : SolidModel
    M : (ndof, ndof) sparse array
        Mass of the part.
    attached : MassPoints, optional
        Rigid masses on nodes that are part of M.
    """

    model: SolidModel
    M: Sparse
    attached: MassPoints | None

    def geometric_stiffness(self, d: Array) -> Sparse:
        """Return Kg (ndof, ndof) for the stress s of nodal displacements d (ndof,).

        ``x^T Kg x = int s : (grad x^T grad x) dV``: the block of a node pair is the same for every
        direction of x, except in bricks of special formulation.
        """
        nn = len(self.model.nodes)
        shape = (nn, nn)
        total: Sparse | None = None
        bricks: Sparse = sp.csr_array((3 * nn, 3 * nn))
        for nodes, felt, C in self._bricks(1):
            e = felt.strain @ d.reshape(nn, 3)[nodes].reshape(-1, 1, 24, 1)
            S = (C @ e)[:, :, VOIGT, 0] * felt.volume[:, :, None, None]
            L = felt.gradient
            k = np.einsum("eqima,eqmn,eqinb->eab", L, S, L, optimize=True)
            dofs = node_dofs(nodes, 3)
            bricks = bricks + scatter(0.5 * (k + k.swapaxes(1, 2)), dofs, dofs, (3 * nn, 3 * nn))
        for group, nodes, G, volume in self._blocks(1):
            s = self._stress(group, self._gradient(G, d.reshape(nn, 3)[nodes][..., None]))
            S = s[:, :, VOIGT, 0] * volume[:, :, None, None]
            k = np.einsum("eqma,eqmn,eqnb->eab", G, S, G, optimize=True)
            block = scatter(0.5 * (k + k.swapaxes(1, 2)), nodes, nodes, shape)
            total = block if total is None else total + block
        return as_csr(bricks if total is None else bricks + expanded(total))

    def forces(self, X: Array, j: int) -> Array:
        """Return ``int B^T C eta(x_j, x_k) dV`` (ndof, n) for the columns k of X (ndof, n).

        These nodal forces balance the second-order part of the strain of the elements: ``K chi_jk =
        -forces``.
        """
        nn, n = len(self.model.nodes), X.shape[1]
        U = X.reshape(nn, 3, n)
        out = np.zeros((nn, 3 * n))
        for nodes, felt, C in self._bricks(n):
            ne = len(nodes)
            D = felt.gradient.reshape(ne, -1, 24) @ U[nodes].reshape(ne, 24, n)
            eta = _products(D.reshape(*felt.gradient.shape[:4], n), j)
            if felt.mean:
                eta = mean_volume_change(eta, felt.volume)
            s = (C @ eta) * felt.volume[:, :, None, None]
            f = felt.strain.reshape(ne, -1, 24).swapaxes(1, 2) @ s.reshape(ne, -1, n)
            np.add.at(out, nodes.ravel(), f.reshape(-1, 3 * n))
        for group, nodes, G, volume in self._blocks(n):
            D = self._gradient(G, U[nodes])  # (e, q, i, m, n): du_i/dx_m
            eta = _products(D, j)
            C = elasticity(self.model.materials[group.material])
            s = np.einsum("ij,eqjn->eqin", C, eta) * volume[:, :, None, None]
            # (e, k, 3 q) @ (e, 3 q, 3 n)
            S = s[:, :, VOIGT]  # (e, q, m, i, n)
            ne, nq, _, k = G.shape
            f = np.matmul(G.reshape(ne, 3 * nq, k).swapaxes(1, 2), S.reshape(ne, 3 * nq, 3 * n))
            np.add.at(out, nodes.ravel(), f.reshape(-1, 3 * n))
        return out.reshape(3 * nn, n)

    def work(self, X: Array) -> Array:
        """Return ``int g . chi dm`` (12, n, n) for the fields g, with chi zero at the nodes.

        The integral is zero for solids, but not for masses on rigid arms and masses with inertia
        that rotate with several nodes. Their mean motion is that of the nodes minus ``theta x
        (theta x r)``, the second-order displacement of the nodes in a finite rotation, which does
        not move the mass.
        """
        n = X.shape[1]
        p = self.attached
        if p is None:
            return np.zeros((FIELDS, n, n))
        W = point_work(p, X)
        for i in range(len(p)):
            N, N_rot = (m[3 * i : 3 * i + 3] for m in (p.N, p.N_rot))
            if not N_rot.nnz:
                continue
            nodes = np.unique(N_rot.indices // 3).astype(np.int64)
            columns = node_dofs(nodes[None], 3)[0]
            r = self.model.nodes[nodes] - self.model.nodes[nodes].mean(axis=0)
            c = double_turn(times(N_rot, X), r).reshape(-1, n, n)
            t, turn = (np.einsum("ad,djk->ajk", m[:, columns].toarray(), c) for m in (N, N_rot))
            g = p.mass[i] * affine_fields(p.position[i : i + 1])[0]
            W -= np.einsum("af,ajk->fjk", g, t)
            W -= np.einsum("af,ajk->fjk", moments(p.second_moment[i : i + 1])[0], turn)
        return W

    @cached_property
    def field_loads(self) -> Array:
        """Nodal loads (ndof, 12) with ``int g . u dm = loads^T d`` for the twelve fields g."""
        g = affine_fields(self.model.nodes)
        nodal = g.reshape(-1, FIELDS)
        if self.attached is None:
            return times(self.M, nodal)
        elements = times(self.M, nodal) - times(self.attached.matrix(), nodal)
        return elements + point_field_loads(self.attached)

    def _blocks(self, n: int) -> Iterator[tuple[SolidGroup, Ints, Array, Array]]:
        """Yield blocks of elements: group, nodes, gradients (e, q, 3, k) and volumes (e, q)."""
        for group in self.model.groups:
            if is_special(group.kind, group.formulation):
                continue
            t = table(group.kind, "stiffness", group.formulation)
            nq, k = len(t.weights), group.nodes.shape[1]
            step = max(1, BLOCK_BYTES // (8 * (nq * (3 * k + 30 * n) + 6 * k * n)))
            for i in range(0, len(group), step):
                nodes = group.nodes[i : i + step]
                G, detJ = gradients(t.dN, self.model.nodes[nodes])
                yield group, nodes, G, detJ * t.weights

    def _bricks(self, n: int) -> Iterator[tuple[Ints, Kinematics, Array]]:
        """Yield blocks of bricks of special formulation: nodes, kinematics and elasticity."""
        step = max(1, BLOCK_BYTES // (8 * 8 * (5 * 216 + 30 * n)))
        for group in self.model.groups:
            if not is_special(group.kind, group.formulation):
                continue
            C = elasticity(self.model.materials[group.material])
            for i in range(0, len(group), step):
                nodes = group.nodes[i : i + step]
                yield nodes, kinematics(group.formulation, self.model.nodes[nodes], C), C

    def _gradient(self, G: Array, U: Array) -> Array:
        """Return gradients du_i/dx_m (e, q, i, m, n) of nodal displacements (e, k, 3, n)."""
        ne, nq, _, k = G.shape
        n = U.shape[-1]
        D = np.matmul(G.reshape(ne, 3 * nq, k), U.reshape(ne, k, 3 * n))
        return np.asarray(D).reshape(ne, nq, 3, 3, n).swapaxes(2, 3)

    def _stress(self, group: SolidGroup, D: Array) -> Array:
        """Return the stress (e, q, 6, n) of displacement gradients (e, q, i, m, n)."""
        e = np.stack(
            [D[:, :, a, b] if a == b else D[:, :, a, b] + D[:, :, b, a] for a, b in PAIRS], axis=2
        )
        C = elasticity(self.model.materials[group.material])
        return np.asarray(np.einsum("ij,eqjn->eqin", C, e))


def _products(D: Array, j: int) -> Array:
    """Return ``eta(x_j, x_k)`` (e, q, 6, n) of gradients (e, q, i, m, n) of the columns."""
    own = D[..., j]
    eta = np.empty((*D.shape[:2], 6, D.shape[-1]))
    for c, (a, b) in enumerate(PAIRS):
        first = np.einsum("eqi,eqin->eqn", own[:, :, :, a], D[:, :, :, b])
        if a == b:
            eta[:, :, c] = first
        else:  # engineering shear: twice the component
            eta[:, :, c] = first + np.einsum("eqi,eqin->eqn", own[..., b], D[:, :, :, a])
    return eta
