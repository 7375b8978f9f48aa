"""Discretisation error of solids, estimated from stress jumps between elements."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array, Ints
from jousto.base.errors import InputError, Problem
from jousto.base.renames import missing_attribute
from jousto.materials.orthotropic import elasticity
from jousto.mesh.reference import table
from jousto.parts.solids.model import SolidGroup, SolidModel
from jousto.parts.solids.stress import SolidStress, block_strains, continuation, point_strains

if TYPE_CHECKING:
    from jousto.parts.part import Part

BLOCK_BYTES = 32 << 20
"""Memory of the stress at the points of a block of elements, bytes."""


@dataclass(frozen=True, eq=False)
class MeshError:
    """Estimated error of a mesh in the energy norm, for each of n displacement fields.

    Attributes
    ----------
    ids : (ne,) ndarray of int
        Numbers of the elements in their file.
    centers : (ne, 3) ndarray
        Mean positions of the nodes of each element in m, part frame.
    squares : (ne, n) ndarray
        Square of the error in each element, ``int (s* - s) C^-1 (s* - s) dV``, J.
    energy : (n,) ndarray
        ``int s C^-1 s dV``, twice the strain energy, J.
    """

    ids: Ints
    centers: Array
    squares: Array
    energy: Array

    if not TYPE_CHECKING:  # types of attributes remain known

        def __getattr__(self, name: str) -> NoReturn:
            missing_attribute(self, name)

    @property
    def eta(self) -> Array:
        """Relative error in the energy norm, ``|e| / sqrt(|u|^2 + |e|^2)``, (n,)."""
        e2 = self.squares.sum(axis=0)
        total = self.energy + e2
        share = np.divide(e2, total, out=np.zeros_like(e2), where=total > 0.0)
        return np.asarray(np.sqrt(share))

    def worst(self, field: int = 0) -> int:
        """Return the index of the element with the largest share of the error of a field."""
        return int(np.argmax(self.squares[:, field]))

    def __repr__(self) -> str:
        eta = self.eta
        k = int(np.argmax(eta))
        return (
            f"<MeshError: {100.0 * eta[k]:.2g} % of the energy norm at worst, most in element "
            f"{self.ids[self.worst(k)]}>"
        )


@explained
def mesh_error(part: Part, d: Array) -> MeshError:
    """Return the estimated discretisation error of displacements of a part of solids.

    The stress ``s*``, which is interpolated by the shape functions from the stress at the nodes
    (see `SolidStress`), approximates the exact stress: ``|e|^2 = int (s* - s) C^-1 (s* - s) dV``
    (O. C. Zienkiewicz and J. Z. Zhu, *Int. J. Num. Meth. Eng.* 24 (1987) 337-357).

    Parameters
    ----------
    part : Part
        Part of solids.
    d : (ndof, n) or (ndof,) array_like
        Nodal displacements in m, such as modes or static solutions.

    Raises
    ------
    InputError
        If the part does not consist of solids, or d has another length.

    Examples
    --------
    ``jo.parts.mesh_error(part, reduced.modes.reshape(-1, reduced.n)).eta``
    """
    model, X = _checked(part, d)
    stress = SolidStress.everywhere(model)
    s, site = stress.evaluate(X), stress.numbers
    squares, energy = [], np.zeros(X.shape[1])
    for group in model.groups:
        own, work = _group_error(model, group, site[group.material], s, X)
        squares.append(own)
        energy += work
    return MeshError(
        np.concatenate([group.ids for group in model.groups]),
        np.concatenate([model.nodes[group.nodes].mean(axis=1) for group in model.groups]),
        np.concatenate(squares),
        energy,
    )


def _checked(part: Part, d: Array) -> tuple[SolidModel, Array]:
    """Return the solid elements of a part, and displacements (ndof, n)."""
    where = f"part '{part.name}'"
    model = part.solids
    if model is None:
        raise InputError(
            Problem(where, "has no mesh error; it is defined for parts of solids only")
        )
    x = np.asarray(d, dtype=np.float64)
    if x.ndim not in (1, 2) or len(x) != 3 * len(model.nodes):
        message = f"displacements have shape {x.shape}, must be ({3 * len(model.nodes)}, n)"
        raise InputError(Problem(where, message))
    return model, x.reshape(len(x), -1)


def _group_error(
    model: SolidModel, group: SolidGroup, site: Ints, s: Array, X: Array
) -> tuple[Array, Array]:
    """Return the squared error (ne, n) of the elements of a group and their energy (n,)."""
    t = table(group.kind, "stiffness", group.formulation)
    nq, n, k = len(t.weights), X.shape[1], group.nodes.shape[1]
    C = elasticity(model.materials[group.material])
    soft = np.linalg.inv(C)
    U = X.reshape(len(model.nodes), 3 * n)
    squares, energy = np.empty((len(group), n)), np.zeros(n)
    step = max(1, BLOCK_BYTES // (8 * n * (24 * nq + 6 * k)))
    for start in range(0, len(group), step):
        nodes = group.nodes[start : start + step]
        m = len(nodes)
        flat = np.empty((m * nq, 6, n))
        w = block_strains(model, group, nodes, U[nodes], "stiffness", flat)
        e = flat.reshape(m, nq, 6, n)
        own = np.einsum("ij,mqjn->mqin", C, e)
        # s* from the nodes
        given = np.matmul(t.N, s[site[nodes]].reshape(m, k, 6 * n)).reshape(m, nq, 6, n)
        away = given - own
        squares[start : start + m] = np.einsum(
            "mq,mqin,ij,mqjn->mn", w, away, soft, away, optimize=True
        )
        energy += np.einsum("mq,mqin,mqin->n", w, own, e, optimize=True)
    return squares, energy


@explained
def place_errors(part: Part, d: Array) -> Array:
    """Return the estimated error of the stress at every node of a part of solids, (ns, n) in Pa.

    The error is the root mean square, over the elements around a node, of the von Mises stress of
    ``s_e - s*``, where s_e is the stress extrapolated from one element and s* the stress at the
    node, see `SolidStress`. The sites are those of ``part.stress``.

    Parameters
    ----------
    part : Part
        Part of solids.
    d : (ndof, n) or (ndof,) array_like
        Nodal displacements in m.

    Raises
    ------
    InputError
        See `mesh_error`.
    """
    model, X = _checked(part, d)
    stress = SolidStress.everywhere(model)
    s = stress.evaluate(X)
    site = stress.numbers
    squares, count = np.zeros((len(stress), X.shape[1])), np.zeros(len(stress))
    V = np.diag([1.5, 1.5, 1.5, 3.0, 3.0, 3.0])
    V[:3, :3] -= 0.5
    for group in model.groups:
        nq, n = len(table(group.kind, "stress", group.formulation).weights), X.shape[1]
        C = elasticity(model.materials[group.material])
        step = max(1, BLOCK_BYTES // (8 * 6 * n * (nq + 3 * group.nodes.shape[1])))
        for start in range(0, len(group), step):
            chosen = np.arange(start, min(start + step, len(group)))
            strains = np.empty((len(chosen) * nq, 6, n))
            point_strains(model, group, chosen, X, strains)
            strains = np.matmul(
                continuation(group.kind, group.formulation), strains.reshape(len(chosen), nq, 6 * n)
            ).reshape(len(chosen), -1, 6, n)
            at = site[group.material][group.nodes[chosen]]
            away = np.einsum("ij,mkjn->mkin", C, strains) - s[at]
            own = np.einsum("mkin,ij,mkjn->mkn", away, V, away, optimize=True)
            np.add.at(squares, at, np.maximum(own, 0.0))
            np.add.at(count, at, 1.0)
    return np.asarray(np.sqrt(squares / count[:, None]))
