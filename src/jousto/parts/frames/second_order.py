"""Second-order displacements of beams, from which geometric stiffness follows.

Displacements d of the nodes are expanded to second order, ``d + 1/2 chi(d, d)``. The elastic energy
depends on the stretch of an element and on the rotations of its ends relative to its chord; this
file contains the quadratic terms in d of this stretch and of these rotations. Local axes and the
order of degrees of freedom are as in `element`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from jousto.base.arrays import Array, Ints, Sparse, node_dofs, scatter, transposed
from jousto.base.object_repr import described
from jousto.parts.frames.element import (
    BeamElements,
    end_displacements,
    shape_functions,
    slopes,
    stiffness,
)
from jousto.parts.mass import MassPoints

_ABSCISSAE, _WEIGHTS = np.polynomial.legendre.leggauss(4)
GAUSS = tuple(
    (0.5 * (1.0 + float(x)), 0.5 * float(w)) for x, w in zip(_ABSCISSAE, _WEIGHTS, strict=True)
)
"""Gauss points xi along an element and weights, exact for polynomials of degree 7."""

# permutation symbol: (a x b)_i = EPS[i, j, k] a_j b_k
EPS = np.zeros((3, 3, 3))
EPS[0, 1, 2] = EPS[1, 2, 0] = EPS[2, 0, 1] = 1.0
EPS[0, 2, 1] = EPS[2, 1, 0] = EPS[1, 0, 2] = -1.0

FIELDS = 12
"""Affine fields ``a + H x``: three with H = 0, then H = e_d e_c^T in the order c, d."""


@described
@dataclass(frozen=True, eq=False)
class SecondOrder:
    """Quadratic forms of the nodal displacements of a frame; its builder checks the data.

    Attributes
    ----------
    beams : BeamElements
    elements : (ne, 2) ndarray
        Node indices.
    line_mass : (ne,) ndarray
        Distributed mass in kg/m; zero where the mass is lumped.
    line_moment : (ne, 3, 3) ndarray
        Second moment ``int s s^T dm`` of the section per length in kg m, part axes.
    gyration : (ne,) ndarray
        ``(Iy + Iz)/A`` in m^2.
    points : MassPoints
        Masses fixed to nodes.
    ndof : int
        Degrees of freedom of the part.
    """

    beams: BeamElements
    elements: Ints
    line_mass: Array
    line_moment: Array
    gyration: Array
    points: MassPoints
    ndof: int

    @cached_property
    def dofs(self) -> Ints:
        """Degrees of freedom of each element, (ne, 12)."""
        return node_dofs(self.elements, 6)

    @cached_property
    def to_local(self) -> Array:
        """Matrices from nodal to local end displacements, (ne, 12, 12)."""
        return end_displacements(self.beams)

    def geometric_stiffness(self, d: Array) -> Sparse:
        """Return Kg (ndof, ndof) for the stress state of nodal displacements d (ndof,).

        ``x^T Kg x = sum f . s(x, x)`` over the elements: f = k d are the end forces of the element
        and s the second-order part of its deformation, see `deformation_forms`.
        """
        end = np.einsum("eij,ej->ei", self.to_local, d[self.dofs])
        f = np.einsum("eij,ej->ei", stiffness(self.beams), end)
        local = np.einsum("ec,ecab->eab", f, deformation_forms(self.beams, self.gyration))
        blocks = transposed(self.to_local) @ local @ self.to_local
        return scatter(
            0.5 * (blocks + transposed(blocks)), self.dofs, self.dofs, (self.ndof, self.ndof)
        )

    def forces(self, X: Array, j: int) -> Array:
        """Return ``B^T k s(x_j, x_k)`` (ndof, n) for the columns k of X (ndof, n).

        These nodal forces balance the second-order part of the deformation of the elements: ``K
        chi_jk = -forces``.
        """
        s = self._bilinear(self._deformation, X, j)
        f = np.einsum("eic,eij,ejk->eck", self.to_local, stiffness(self.beams), s, optimize=True)
        out = np.zeros((self.ndof, X.shape[1]))
        np.add.at(out, self.dofs.ravel(), f.reshape(-1, X.shape[1]))
        return out

    def work(self, X: Array) -> Array:
        """Return ``int g . chi_jk dm`` (12, n, n) for the fields g, with chi = 0 at the nodes.

        The second-order motions of particles with ``chi = 0`` at the nodes are those of rigid arms,
        of rotating sections, and of the axis between two nodes.
        """
        n = X.shape[1]
        W = np.zeros((FIELDS, n, n))
        ends = self.to_local @ X[self.dofs]
        for f in range(FIELDS):
            W[f] = np.einsum("eaj,eab,ebk->jk", ends, self._field_forms[:, f], ends, optimize=True)
        if len(self.points):
            W += point_work(self.points, X)
        return 0.5 * (W + W.swapaxes(1, 2))

    @cached_property
    def field_loads(self) -> Array:
        """Nodal loads (ndof, 12) with ``int g . u dm = loads^T d`` for the twelve fields g."""
        ends = self._end_loads.copy()
        axes, L = self.beams.axes, self.beams.length
        turn = 0.5 * L[:, None, None] * (transposed(axes) @ moments(self.line_moment))
        ends[:, 3:6] += turn
        ends[:, 9:12] += turn
        nodal = transposed(self.to_local) @ ends
        out = np.zeros((self.ndof, FIELDS))
        np.add.at(out, self.dofs.ravel(), nodal.reshape(-1, FIELDS))
        if len(self.points):
            out += point_field_loads(self.points)
        return out

    # -- parts of the forms -------------------------------------------------------------------

    @cached_property
    def _deformation(self) -> Array:
        return deformation_forms(self.beams, self.gyration)

    @cached_property
    def _end_loads(self) -> Array:
        """Local end loads (ne, 12, 12 fields) of the distributed mass, without section inertia."""
        b = self.beams
        loads = np.zeros((len(b), 12, FIELDS))
        for xi, w in GAUSS:
            g = transposed(b.axes) @ affine_fields(_places(b, xi))
            N = shape_functions(b, xi)[:, :3]
            loads += (w * b.length * self.line_mass)[:, None, None] * (transposed(N) @ g)
        return np.asarray(loads)

    @cached_property
    def _field_forms(self) -> Array:
        """Forms (ne, 12 fields, 12, 12) in local end displacements, for `work`."""
        b, L = self.beams, self.beams.length
        # motion of the ends: rigid arms and the direction of the axis
        forms = np.einsum("ecf,ecab->efab", self._end_loads, motion_forms(b))
        # rotation of sections
        H_G = np.zeros((len(b), FIELDS, 3, 3))
        H_G[:, 3:] = np.einsum("ecb,dg->ecdgb", self.line_moment, np.eye(3)).reshape(-1, 9, 3, 3)
        A = np.einsum("eai,efab,ebj->efij", b.axes, _arm_forms(H_G), b.axes, optimize=True)
        for xi, w in GAUSS:
            R = shape_functions(b, xi)[:, 3:]
            forms += (w * L)[:, None, None, None] * np.einsum(
                "eia,efij,ejb->efab", R, A, R, optimize=True
            )
        # shortening between the nodes: the axial force varies along the element by -q
        q = [
            self.line_mass[:, None] * np.einsum("ea,eaf->ef", b.axes[:, :, 0], affine_fields(x))
            for x in (_places(b, 0.0), _places(b, 1.0))
        ]
        first = shortening_forms(b, self.gyration, lambda xi: 0.5 - xi)
        second = shortening_forms(b, self.gyration, lambda xi: 1.0 / 6.0 - 0.5 * xi**2)
        for force, form in ((q[0], first), (q[1] - q[0], second)):
            forms -= np.einsum("e,ef,eab->efab", L, force, form)
        return np.asarray(forms)

    def _bilinear(self, forms: Array, X: Array, j: int) -> Array:
        """Return ``s(x_j, x_k)`` (ne, 12, n) for symmetric forms (ne, 12, 12, 12)."""
        ends = self.to_local @ X[self.dofs]
        half = np.einsum("ecab,ea->ecb", forms, ends[:, :, j])
        return np.asarray(half @ ends)


def point_field_loads(p: MassPoints) -> Array:
    """Return nodal loads (ndof, 12) with ``int g . u dm = loads^T d`` for masses on nodes."""
    g = p.mass[:, None, None] * affine_fields(p.position)
    loads = np.asarray(p.N.T @ g.reshape(-1, FIELDS))
    return np.asarray(loads + p.N_rot.T @ moments(p.second_moment).reshape(-1, FIELDS))


def point_work(p: MassPoints, X: Array) -> Array:
    """Return ``int g . chi dm`` (12, n, n) of masses on nodes, with chi = 0 at the nodes."""
    n = X.shape[1]
    # int g (arm + s)^T dm
    f = p.mass[:, None, None] * affine_fields(p.position)
    P = np.einsum("kaf,kb->kfab", f, np.asarray(p.arm))
    P[:, 3:] += np.einsum("kcb,dg->kcdgb", p.second_moment, np.eye(3)).reshape(-1, 9, 3, 3)
    turn = np.asarray(p.N_rot @ X).reshape(-1, 3, n)
    A = _arm_forms(P)
    W = np.stack(
        [np.einsum("kaj,kab,kbl->jl", turn, A[:, f], turn, optimize=True) for f in range(FIELDS)]
    )
    return np.asarray(0.5 * (W + W.swapaxes(1, 2)))


def deformation_forms(beams: BeamElements, gyration: Array) -> Array:
    """Return forms (ne, 12, 12, 12) of the second-order part s of element deformation.

    To second order, the element has the linear elastic energy of the displacements ``x + s(x,
    x)/2`` in place of its local end displacements x. With the chord ``D = u_b - u_a``, its rotation
    ``rho = (tau, -Dz/L, Dy/L)``, tau the mean twist, and the end rotations theta:

    * stretch, at end b: ``int v'^2 + w'^2 + (Iy + Iz)/A rx'^2 dx``;
    * end rotations relative to the chord: ``-rho x theta - 2 rho2``, where
      ``rho2 = (0, Dx Dz/L^2 + tau rho_z/2, -Dx Dy/L^2 - tau rho_y/2)`` is the second-order part of
      the chord's rotation vector;
    * ends on rigid arms o: ``theta x (theta x o)``.
    """
    L = beams.length[:, None]
    s = motion_forms(beams)
    s[:, [4, 5, 10, 11]] = 0.0
    e = np.broadcast_to(np.eye(12), (len(beams), 12, 12)).swapaxes(0, 1)
    stretch, y, z = e[6] - e[0], e[7] - e[1], e[8] - e[2]
    tau, rho_y, rho_z = 0.5 * (e[3] + e[9]), -z / L, y / L
    s[:, 6] += shortening_forms(beams, gyration, lambda xi: 1.0)
    for o in (3, 9):
        x, y_turn, z_turn = e[o], e[o + 1], e[o + 2]
        s[:, o] += _product(rho_z, y_turn) - _product(rho_y, z_turn)
        s[:, o + 1] += _product(tau, z_turn - rho_z) - _product(rho_z, x)
        s[:, o + 1] -= 2.0 * _product(stretch / L, z / L)
        s[:, o + 2] += _product(tau, rho_y - y_turn) + _product(rho_y, x)
        s[:, o + 2] += 2.0 * _product(stretch / L, y / L)
    return s


def motion_forms(beams: BeamElements) -> Array:
    """Return forms (ne, 12, 12, 12) of the second-order motion of the ends with fixed nodes.

    Translation: ``theta x (theta x o)`` of the rigid arms o. Rotation: the change of direction of
    the axis, ``theta x (theta x e_x)``, as a slope ``(0, -w', v')``.
    """
    m = np.zeros((len(beams), 12, 12, 12))
    e = np.broadcast_to(np.eye(12), (len(beams), 12, 12)).swapaxes(0, 1)
    for end, o in ((0, 3), (1, 9)):
        arm = np.einsum("eij,ei->ej", beams.axes, beams.offsets[:, end])
        turn = e[o : o + 3]
        along = np.einsum("ai,abi->ab", arm, turn.transpose(1, 2, 0))
        for c in range(3):
            m[:, o - 3 + c] += _product(turn[c], along)
            for d in range(3):
                m[:, o - 3 + c] -= arm[:, c, None, None] * _product(turn[d], turn[d])
        m[:, o + 1] -= _product(turn[0], turn[2])
        m[:, o + 2] += _product(turn[0], turn[1])
    return m


def shortening_forms(
    beams: BeamElements, gyration: Array, weight: Callable[[float], float]
) -> Array:
    """Return ``int weight(xi) (v'^2 + w'^2 + (Iy + Iz)/A rx'^2) dx`` as forms (ne, 12, 12)."""
    out = np.zeros((len(beams), 12, 12))
    factor = np.stack([np.ones(len(beams)), np.ones(len(beams)), gyration], axis=1)
    for xi, w in GAUSS:
        b = slopes(beams, xi)
        scale = w * weight(xi) * beams.length[:, None] * factor
        out += transposed(b) @ (scale[:, :, None] * b)
    return out


def _product(a: Array, b: Array) -> Array:
    """Return the symmetric form (ne, 12, 12) of the product of two linear forms (ne, 12)."""
    outer = a[:, :, None] * b[:, None, :]
    return 0.5 * (outer + transposed(outer))


def _places(beams: BeamElements, xi: float) -> Array:
    """Return the points (ne, 3) on the axes at x = xi L."""
    return np.asarray(beams.origin + xi * beams.length[:, None] * beams.axes[:, :, 0])


def affine_fields(x: Array) -> Array:
    """Return the twelve affine fields (k, 3, 12) at points x (k, 3)."""
    g = np.zeros((len(x), 3, FIELDS))
    g[:, :, :3] = np.eye(3)
    g[:, :, 3:] = np.einsum("kc,ad->kacd", x, np.eye(3)).reshape(len(x), 3, 9)
    return g


def moments(G: Array) -> Array:
    """Return ``int s x g(s) dm`` (k, 3, 12) for affine fields on sections with second moment G."""
    out = np.zeros((len(G), 3, FIELDS))
    out[:, :, 3:] = np.einsum("ead,kac->kecd", EPS, G).reshape(len(G), 3, 9)
    return out


def _arm_forms(P: Array) -> Array:
    """Return ``sym(P) - tr(P) E``, the form in theta of ``int g . (theta x (theta x s)) dm``.

    ``P = int g s^T dm``.
    """
    trace = np.trace(P, axis1=-2, axis2=-1)[..., None, None]
    return np.asarray(0.5 * (P + transposed(P)) - trace * np.eye(3))


def double_turn(theta: Array, s: Array) -> Array:
    """Return the symmetric form of ``theta x (theta x s)``, (k, 3, n, n).

    Parameters
    ----------
    theta : (3, n) ndarray
        Rotation vectors of n motions.
    s : (k, 3) ndarray
        Arms.
    """
    along = s @ theta
    mixed = np.einsum("aj,ik->iajk", theta, along)
    mixed = 0.5 * (mixed + mixed.swapaxes(2, 3))
    return np.asarray(mixed - np.einsum("jk,ia->iajk", theta.T @ theta, s))
