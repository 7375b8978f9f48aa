"""Geometric stiffening: second-order displacement field of a modal body.

``u = u0 + Phi p + 1/2 chi(p, p)``: the ends of a bent beam move towards each other, and an axial
force does work on this displacement. Through chi, centrifugal forces and joint forces stiffen (or
soften) the body.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.parts.frames.second_order import double_turn
from jousto.reduction.modes.partition import whole_part_basis
from jousto.reduction.modes.rigid import mass_orthonormal_rigid_modes

if TYPE_CHECKING:
    from jousto.parts.interface import Tie
    from jousto.parts.part import Part


LARGEST_FIELD = 1 << 30
"""Largest array of the field, bytes; three such arrays exist at a time."""


@dataclass(frozen=True, eq=False)
class Stiffening:
    """Second-order displacements chi of a body with n modes, ``chi_jk = chi_kj``.

    The rigid motion in chi is arbitrary and chosen such that chi has no momentum,
    ``int chi dm = int u0 x chi dm = 0``.

    Parameters
    ----------
    second_moment : (n, n, 3, 3) array
        ``N[j, k] = int u0 chi_jk^T dm``, symmetric; no unit.
    translations : (nn, 3, n, n) array
        chi of the nodes, part frame, kg^-1 m^-1.
    rotations : (nn, 3, n, n) array
        Second-order rotation vectors of the nodes, kg^-1 m^-2.

    Raises
    ------
    InputError
        If shapes are inconsistent or values are not finite.
    """

    second_moment: Array
    translations: Array
    rotations: Array

    def __post_init__(self) -> None:
        problems = Problems()
        n = int(np.shape(self.second_moment)[0]) if np.ndim(self.second_moment) == 4 else 0
        nn = int(np.shape(self.translations)[0]) if np.ndim(self.translations) == 4 else 0
        for name, shape in (
            ("second_moment", (n, n, 3, 3)),
            ("translations", (nn, 3, n, n)),
            ("rotations", (nn, 3, n, n)),
        ):
            array = problems.array("Stiffening", name, getattr(self, name), shape)
            object.__setattr__(self, name, array)
        problems.raise_if_any()

    @property
    def n(self) -> int:
        """Number of modes."""
        return len(self.second_moment)

    def keep(self, indices: NDArray[np.intp]) -> Stiffening:
        """Return the field of selected modes, in the given order."""
        j, k = np.ix_(indices, indices)
        return Stiffening(
            self.second_moment[j, k],
            self.translations[:, :, j, k],
            self.rotations[:, :, j, k],
        )


def stiffening(part: Part, X: Array) -> Stiffening:
    """Return the second-order displacement field of mode shapes (ndof, n) of beams or solids.

    The energy of an element is that of ``B d + s(d, d)/2``, see `parts.second_order` and
    `parts.solids.second_order`. Displacements ``d = X p + chi(p, p)/2`` whose second-order part has
    no energy solve

        ``K chi_jk = -sum_e B^T k s(x_j, x_k)``. They are dual to the geometric stiffness: ``f .
        chi(p, p) = -p^T Kg(f) p`` for every load f, with Kg of
    the stress state ``K d = f``. The rigid part of chi is chosen such that ``int chi dm`` and ``int
    u0 x chi dm`` vanish.

    Raises
    ------
    InputError
        If the part consists neither of beams nor of solids, or the field needs too much memory.
    """
    where = f"part '{part.name}'"
    second = part.second_order
    if second is None:
        message = (
            "has no geometric stiffening, because it was built from matrices; only parts of "
            "beams (Part.beam, Part.frame, Part.from_members) or solids (Part.solid) have "
            "stress data; reduce with stiffening=False, or cut the part into several bodies"
        )
        raise InputError(Problem(where, message))
    ndof, n = X.shape
    size = 8.0 * ndof * n * n
    if size > LARGEST_FIELD:
        message = (
            f"stiffening of {n} modes at {len(part.nodes)} nodes needs {3.0 * size / 2**30:.1f} "
            f"GiB; ask for fewer modes (up to {int(np.sqrt(LARGEST_FIELD / (8.0 * ndof)))}) or "
            "reduce with stiffening=False"
        )
        raise InputError(Problem(where, message))
    K = sp.csr_array(part.K)
    basis = whole_part_basis(part, K)
    assert basis.solve is not None
    turned = [_turned(part, tie, X) for tie in part.ties]
    chi = np.empty((ndof, n, n))
    for j in range(n):
        # second-order motion of rigidly tied nodes beyond the first-order motion of the tie
        beyond = np.zeros((ndof, n - j))
        for tie, c in zip(part.ties, turned, strict=True):
            if tie.kind == "rigid":
                beyond[tie.dofs] += c[:, j, j:]
        forces = second.forces(X[:, j:], 0)
        if np.any(beyond):
            forces = forces + K @ beyond
        chi[:, j:, j] = beyond + basis.lift(basis.solve(-basis.lower(forces)))
        chi[:, j, j:] = chi[:, j:, j]

    # int g . chi dm of the twelve affine fields g = a + H x
    loads = second.field_loads
    work = np.einsum("df,djk->fjk", loads, chi, optimize=True) + second.work(X)

    # remove the rigid motions, twice for accuracy
    M = sp.csr_array(part.M)
    rigid = mass_orthonormal_rigid_modes(M, part.nodes, part.dofs_per_node, where).R
    fields = _affine(rigid, part)
    gram = fields.T @ (loads.T @ rigid)
    for _ in range(2):
        c = np.linalg.solve(gram, np.einsum("fr,fjk->rjk", fields, work).reshape(6, -1))
        chi -= (rigid @ c).reshape(chi.shape)
        work -= ((loads.T @ rigid) @ c).reshape(work.shape)
    N = work[3:].reshape(3, 3, n, n)
    nodal = chi.reshape(-1, part.dofs_per_node, n, n)
    translations = nodal[:, :3]
    rotations = nodal[:, 3:] if part.dofs_per_node == 6 else np.zeros((len(nodal), 3, n, n))
    if part.ties:
        # reference nodes follow the tied nodes minus the effect of a finite rotation
        q = np.stack(
            [
                np.einsum("ad,djk->ajk", tie.averaging, chi[tie.dofs] - c)
                for tie, c in zip(part.ties, turned, strict=True)
            ]
        )
        translations = np.concatenate([translations, q[:, :3]])
        rotations = np.concatenate([rotations, q[:, 3:]])
    moment = 0.5 * (N + N.swapaxes(0, 1)).transpose(2, 3, 0, 1)
    return Stiffening(moment, translations, rotations)


def _turned(part: Part, tie: Tie, X: Array) -> Array:
    """Return ``theta x (theta x s)`` (k d, n, n) of tied nodes at s from the reference point.

    This is the second-order displacement of the tied nodes in a finite rotation of the reference
    node.
    """
    theta = tie.averaging[3:] @ X[tie.dofs]
    n, d = X.shape[1], part.dofs_per_node
    c = np.zeros((len(tie.nodes), d, n, n))
    c[:, :3] = double_turn(theta, part.nodes[tie.nodes] - tie.at)
    return c.reshape(-1, n, n)


def _affine(rigid: Array, part: Part) -> Array:
    """Return the coefficients (12, 6) of rigid motions ``a + b x r`` as affine fields."""
    a, b = np.split(np.linalg.lstsq(part.rigid_modes(), rigid, rcond=None)[0], 2)
    out = np.zeros((12, 6))
    out[:3] = a
    for c in range(3):
        # b x x = H x with H[d, c] = (b x e_c)_d
        out[3 + 3 * c : 6 + 3 * c] = np.cross(b.T, np.eye(3)[c]).T
    return out
