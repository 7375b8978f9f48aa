"""Bricks of eight nodes whose strain differs from the strain of their displacements.

``bbar``: the change of volume is its mean over the element (T. J. R. Hughes, *The Finite Element
Method* (1987), section 4.5.2). ``incompatible``: the displacement in each direction has three
additional functions ``1 - xi_d^2``; the nine unknowns are eliminated in the element (R. L. Taylor,
P. J. Beresford and E. L. Wilson, *Int. J. Num. Meth. Eng.* 10 (1976) 1211-1219; their derivatives
are those of the centre times ``det J_0 / det J``, so that they do no work on a constant stress).
``reduced``: the stiffness is that of the mean strain plus a small stiffness against the four
hourglass shapes (D. P. Flanagan and T. Belytschko, *Int. J. Num. Meth. Eng.* 17 (1981) 679-706).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.base.voigt import PAIRS
from jousto.mesh.reference import gradients, places, table

SPECIAL = ("bbar", "incompatible", "reduced")
"""Formulations of the kind ``hexahedron`` that this file contains."""

HOURGLASS = 0.0005
"""Hourglass stiffness / ``E V sum (dN/dx)^2``, as in CalculiX."""


@dataclass(frozen=True, eq=False)
class Kinematics:
    """Kinematics of bricks: gradient and strain from displacements at integration points.

    Attributes
    ----------
    gradient : (ne, nq, 3, 3, 24) ndarray
        ``du_i/dx_m`` in 1/m from the displacements of the nodes.
    strain : (ne, nq, 6, 24) ndarray
        ``[e11 e22 e33 g12 g23 g13]``; not always the symmetric part of the gradient.
    volume : (ne, nq) ndarray
        Volume of the points, m^3.
    mean : bool
        Whether the change of volume is its mean over the element.
    """

    gradient: Array
    strain: Array
    volume: Array
    mean: bool = False


def is_special(kind: str, formulation: str) -> bool:
    """Return whether the stiffness of elements is computed in this file, not with `table` only."""
    return kind == "hexahedron" and formulation in SPECIAL


def kinematics(formulation: str, x: Array, C: Array) -> Kinematics:
    """Return gradient, strain and volume at the points of bricks.

    Parameters
    ----------
    formulation : str
        One of `SPECIAL`.
    x : (ne, 8, 3) ndarray
        Positions of the nodes in m.
    C : (6, 6) ndarray
        Elasticity in Pa, with which the incompatible modes are eliminated.
    """
    t = table("hexahedron", "stiffness")
    G, detJ = gradients(t.dN, x)
    volume = t.weights * detJ
    if formulation == "reduced":
        mean = np.einsum("eq,eqmk->emk", volume, G) / volume.sum(axis=1)[:, None, None]
        L = _of_nodes(mean[:, None])
        return Kinematics(L, _strain(L), volume.sum(axis=1)[:, None])
    L = _of_nodes(G)
    if formulation == "bbar":
        return Kinematics(L, mean_volume_change(_strain(L), volume), volume, mean=True)
    inner = _of_nodes(_incompatible(x, detJ))
    B, Bi = _strain(L), _strain(inner)
    CB = volume[:, :, None, None] * (C @ Bi)
    Kii = np.einsum("eqca,eqcb->eab", CB, Bi, optimize=True)
    Kiu = np.einsum("eqca,eqcb->eab", CB, B, optimize=True)
    inside = -np.linalg.solve(Kii, Kiu)[
        :, None
    ]  # the nine eliminated unknowns from the 24 displacements of the nodes
    return Kinematics(L + inner @ inside[:, :, None], B + Bi @ inside, volume)


def mean_volume_change(e: Array, volume: Array) -> Array:
    """Return strains (ne, nq, 6, n) whose trace is replaced by its mean over the element."""
    trace = e[:, :, :3].sum(axis=2, keepdims=True)
    mean = np.einsum("eq,eqcn->ecn", volume, trace) / volume.sum(axis=1)[:, None, None]
    out = e.copy()
    out[:, :, :3] += (mean[:, None] - trace) / 3.0
    return out


def brick_stiffness(formulation: str, x: Array, C: Array) -> Array:
    """Return stiffness matrices as blocks of node pairs, (ne, 8, 8, 3, 3) in N/m."""
    k = kinematics(formulation, x, C)
    ne = len(x)
    B = k.strain.reshape(ne, -1, 24)
    CB = (k.volume[:, :, None, None] * (C @ k.strain)).reshape(ne, -1, 24)
    K = np.matmul(B.swapaxes(1, 2), CB).reshape(ne, 8, 3, 8, 3).transpose(0, 1, 3, 2, 4)
    if formulation == "reduced":
        K = K + _hourglass(x, k, C)[..., None, None] * np.eye(3)
    return np.asarray(0.5 * (K + K.transpose(0, 2, 1, 4, 3)))


def _of_nodes(G: Array) -> Array:
    """Return ``du_i/dx_m`` (ne, nq, 3, 3, 3 k) for derivatives of functions (ne, nq, 3, k)."""
    ne, nq, _, k = G.shape
    L = np.zeros((ne, nq, 3, 3, k, 3))
    for i in range(3):
        L[:, :, i, :, :, i] = G
    return L.reshape(ne, nq, 3, 3, 3 * k)


def _strain(L: Array) -> Array:
    """Return strains (ne, nq, 6, n) of gradients (ne, nq, 3, 3, n)."""
    rows = [L[:, :, i, i] if i == j else L[:, :, i, j] + L[:, :, j, i] for i, j in PAIRS]
    return np.stack(rows, axis=2)


def _incompatible(x: Array, detJ: Array) -> Array:
    """Return derivatives (ne, nq, 3, 3) along x of ``1 - xi_d^2``, d = 1, 2, 3 being the last axis.

    ``dxi_d/dx`` is evaluated at the centre; the factor ``det J_0 / det J`` makes the mean of the
    derivatives over the element zero.
    """
    t, centre = table("hexahedron", "stiffness"), table("hexahedron", "stress", "reduced")
    dN = centre.dN[0]  # (3, 8)
    J = dN @ x  # (ne, d, 3): dx/dr_d
    inverse = np.linalg.inv(J)  # (ne, 3, d): dr_d/dx
    ratio = np.linalg.det(J)[:, None] / detJ
    # 1 - xi^2 = 4 r (1 - r) on the unit cube
    slope = 4.0 * (1.0 - 2.0 * t.points)  # (nq, d)
    return np.asarray(ratio[:, :, None, None] * slope[:, None, :] * inverse[:, None])


def _hourglass(x: Array, k: Kinematics, C: Array) -> Array:
    """Return the hourglass stiffness (ne, 8, 8) in N/m of one direction.

    ``c sum_s gamma_s gamma_s^T``, with ``gamma_s = h_s - G^T x^T h_s`` orthogonal to all linear
    fields. For anisotropic elasticity E follows from the Voigt averages of K and G.
    """
    r, s, t = (2.0 * places("hexahedron") - 1.0).T
    h = np.stack([s * t, t * r, r * s, r * s * t], axis=1)  # (8, 4)
    G = k.gradient[:, 0, 0].reshape(-1, 3, 8, 3)[..., 0]  # mean derivatives (ne, 3, 8)
    gamma = h - np.swapaxes(G, 1, 2) @ (np.swapaxes(x, 1, 2) @ h)
    bulk = C[:3, :3].sum() / 9.0
    shear = (np.trace(C[:3, :3]) + 2.0 * np.trace(C[3:, 3:]) - 3.0 * bulk) / 10.0
    E = 9.0 * bulk * shear / (3.0 * bulk + shear)
    c = HOURGLASS * E * k.volume[:, 0] * (G**2).sum(axis=(1, 2))
    return np.asarray(c[:, None, None] * gamma @ np.swapaxes(gamma, 1, 2))
