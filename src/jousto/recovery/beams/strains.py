"""Strains and stress resultants of beam elements from the states of their nodes.

Two-node elements with one strain at the midpoint: Reissner's strains (Simo, *Comput. Methods
Appl. Mech. Eng.* 49 (1985) 55-70) with the interpolated relative rotation of Crisfield and
Jelenic, *Proc. R. Soc. A* 455 (1999) 1125-1147. All functions take arrays (..., ne, ...).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from jousto.base.arrays import Array
from jousto.model.beam_record import BeamShape
from jousto.model.native.header import named

SMALL = 1e-3  # angle below which coefficients are series, rad; the next term is below 1e-15


@dataclass(frozen=True, eq=False)
class Elements:
    """Constants of the elements of a beam, read from the engine's data.

    Attributes
    ----------
    L : (ne,) array
        Lengths, m.
    ua, ub : (ne, 3) array
        Vector from the node to the end of the element, frame of the node, m.
    Ba, Bb : (ne, 3, 3) array
        Axes of the section at the ends, as columns, frame of the node.
    C : (ne, 6, 6) array
        Section stiffness on ``[Gamma kappa]``: N, N m and N m^2.
    e0 : (ne, 6) array
        Strain of the unstressed shape.
    beta : (ne,) array
        Factor of stiffness-proportional damping, s.
    helical : (ne, 1) array
        1 for elements with a helical axis, 0 for elements with a straight axis.
    polar : (ne,) array
        Ip/A about the shear centre, m2, for the extension of fibres by twist.
    """

    L: Array
    ua: Array
    Ba: Array
    ub: Array
    Bb: Array
    C: Array
    e0: Array
    beta: Array
    helical: Array
    polar: Array


def elements(beam: BeamShape) -> Elements:
    """Return the constants of the elements of a beam."""
    x, n = named("jo_beam_data", beam.data), beam.n
    return Elements(
        L=x.length,
        ua=x.u_a,
        Ba=x.B_a.reshape(n, 3, 3),
        ub=x.u_b,
        Bb=x.B_b.reshape(n, 3, 3),
        C=x.C.reshape(n, 6, 6),
        e0=x.e0,
        beta=x.beta,
        helical=x.helical[:, None],
        polar=x.polar,
    )


@dataclass(frozen=True, eq=False)
class Poses:
    """Positions and section axes at the ends of elements, world frame.

    Attributes
    ----------
    ra, rb : (..., ne, 3) array
        Positions of the ends, m.
    Qa, Qb : (..., ne, 3, 3) array
        Columns are the axes of the section, x along the beam.
    """

    ra: Array
    Qa: Array
    rb: Array
    Qb: Array


def poses(beam: Elements, R: Array, A: Array) -> Poses:
    """Return the poses of element ends for nodes at R (..., n + 1, 3) with axes A (..., 3, 3)."""
    Aa, Ab = A[..., :-1, :, :], A[..., 1:, :, :]
    return Poses(
        ra=R[..., :-1, :] + _apply(Aa, beam.ua),
        Qa=Aa @ beam.Ba,
        rb=R[..., 1:, :] + _apply(Ab, beam.ub),
        Qb=Ab @ beam.Bb,
    )


@dataclass(frozen=True, eq=False)
class Strains:
    """Strains of elements, with the quantities for the resultants at their ends.

    Attributes
    ----------
    e : (..., ne, 6) array
        ``[Gamma kappa] - e0`` in the axes of the section at the midpoint, m/m and 1/m.
    phi : (..., ne, 3) array
        Rotation vector from end a to end b, rad.
    r : (..., ne, 3) array
        Vector from end a to end b, in the axes of the section at the midpoint, m.
    helix : Helix
        Matrix D from the chord to the arc.
    lean : (..., ne, 1) array
        ``Ip/A kappa_x``, m, for the extension of fibres by twist.
    """

    e: Array
    phi: Array
    r: Array
    helix: Helix
    lean: Array


@dataclass(frozen=True, eq=False)
class Helix:
    """Matrix from chord to arc of helical elements, ``D = c 1 + (1 - c) n n^T``, ``n = phi/|phi|``.

    ``c = (|phi| / 2) / sin(|phi| / 2)`` (exponential map of SE(3) at the midpoint); c = 1 for
    straight elements.

    Attributes
    ----------
    n : (..., ne, 3) array
    c : (..., ne, 1) array
    slope : (..., ne, 1) array
        ``dc / d|phi|``, 1/rad.
    rest : (..., ne, 1) array
        ``(1 - c) / |phi|``, 1/rad.
    """

    n: Array
    c: Array
    slope: Array
    rest: Array

    def arc(self, x: Array) -> Array:
        """Return ``D x``."""
        along = (self.n * x).sum(axis=-1, keepdims=True) * self.n
        return np.asarray(along + self.c * (x - along))

    def turned(self, x: Array, w: Array) -> Array:
        """Return ``d(D x)/dphi w``."""
        nx, nw = (self.n * x).sum(-1, keepdims=True), (self.n * w).sum(-1, keepdims=True)
        x_, w_ = x - nx * self.n, w - nw * self.n
        across = (x_ * w_).sum(-1, keepdims=True)
        return np.asarray(self.slope * nw * x_ + self.rest * (nx * w_ + across * self.n))

    def pulled(self, x: Array, y: Array) -> Array:
        """Return ``(d(D x)/dphi)^T y``."""
        nx, ny = (self.n * x).sum(-1, keepdims=True), (self.n * y).sum(-1, keepdims=True)
        x_, y_ = x - nx * self.n, y - ny * self.n
        across = (x_ * y_).sum(-1, keepdims=True)
        return np.asarray(self.slope * across * self.n + self.rest * (nx * y_ + ny * x_))


def helix(beam: Elements, phi: Array) -> Helix:
    """Return the matrices from chords to arcs for rotation vectors phi (..., ne, 3)."""
    angle = np.linalg.norm(phi, axis=-1, keepdims=True)
    n = phi / np.where(angle > 0.0, angle, 1.0)
    small = angle < 0.02
    h = 0.5 * np.where(small, 1.0, angle)
    sin, cos = np.sin(h), np.cos(h)
    c = np.where(small, 1.0 + angle**2 / 24.0 + 7.0 * angle**4 / 5760.0, h / sin)
    slope = np.where(small, angle / 12.0 + 7.0 * angle**3 / 1440.0, 0.5 * (sin - h * cos) / sin**2)
    rest = np.where(small, -angle / 24.0 - 7.0 * angle**3 / 5760.0, (1.0 - c) / (2.0 * h))
    on = beam.helical
    return Helix(n, 1.0 + on * (c - 1.0), on * slope, on * rest)


def strains(beam: Elements, at: Poses) -> Strains:
    """Return strains ``Gamma = Qm^T (rb - ra) / L - e1``, ``kappa = phi / L``, minus e0.

    ``phi = log(Qa^T Qb)``, and ``Qm = Qa exp(phi / 2)`` are the axes at the midpoint. In a helical
    element the chord ``rb - ra`` is replaced by its arc. The extension of fibres by twist adds
    ``Ip/A kappa_x^2 / 2`` to Gamma_x.
    """
    phi = logarithm(np.swapaxes(at.Qa, -1, -2) @ at.Qb)
    # Qm^T = exp(-phi / 2) Qa^T
    r = rotate_vectors(-0.5 * phi, _apply(np.swapaxes(at.Qa, -1, -2), at.rb - at.ra))
    L = beam.L[:, None]
    bow = helix(beam, phi)
    gamma = bow.arc(r) / L - np.array([1.0, 0.0, 0.0])
    e = np.concatenate([gamma, phi / L], axis=-1) - beam.e0
    kappa, rest = phi[..., 0] / beam.L, beam.e0[:, 3]
    e[..., 0] += 0.5 * beam.polar * (kappa - rest) * (kappa + rest)
    return Strains(e, phi, r, bow, (beam.polar * kappa)[..., None])


def rates(beam: Elements, found: Strains, Qa: Array, slip: Array, spin: Array) -> Array:
    """Return the rates (..., ne, 6) of the strains, 1/s.

    ``Gamma' = Qm^T (rb' - ra' + r x wm) / L`` and ``kappa' = T^-1 Qa^T (wb - wa) / L``.

    Parameters
    ----------
    beam, found
        As above.
    Qa : (..., ne, 3, 3) array
        Axes at end a.
    slip : (..., ne, 3) array
        ``rb' - ra' + r x wa``: velocity of end b relative to end a, world frame, m/s.
    spin : (..., ne, 3) array
        ``wb - wa``, world frame, rad/s.
    """
    phi, half = found.phi, -0.5 * found.phi
    back = np.swapaxes(Qa, -1, -2)
    w = _apply(back, spin)
    # k = phi' = T^-1 w; the midpoint rotates faster than end a by P w
    k = w - 0.5 * np.cross(phi, w) + _inverse(phi) * np.cross(phi, np.cross(phi, w))
    wm = rotate_vectors(half, w)
    more = 0.5 * wm - _lag(phi) * np.cross(phi, wm)
    v = rotate_vectors(half, _apply(back, slip)) + np.cross(found.r, more)
    v = found.helix.arc(v) + found.helix.turned(found.r, k)
    v[..., :1] += found.lean * k[..., :1]
    return np.asarray(np.concatenate([v, k], axis=-1) / beam.L[:, None])


def resultants(beam: Elements, e: Array, rate: Array | None = None) -> Array:
    """Return resultants ``C e + beta C e'`` (..., ne, 6) at the midpoints, N and N m."""
    total = e if rate is None else e + beam.beta[:, None] * rate
    return np.asarray(np.einsum("nij,...nj->...ni", beam.C, total))


def end_resultants(found: Strains, s: Array) -> Array:
    """Return the resultants (..., ne, 2, 6) at both ends, in the axes of the section there.

    The forces of the element on its nodes are the gradient of its energy. The moments satisfy the
    equilibrium of the element, ``M_b - M_a = -(rb - ra) x n``, with equal forces n at both ends.

    Parameters
    ----------
    found : Strains
    s : (..., ne, 6) array
        Resultants at the midpoint.
    """
    phi, n, m = found.phi, s[..., :3], np.array(s[..., 3:])
    m[..., :1] += found.lean * n[..., :1]
    m = m + found.helix.pulled(found.r, n)
    n = found.helix.arc(n)
    angle = np.linalg.norm(phi, axis=-1, keepdims=True)
    # the component of M along phi is unchanged; the perpendicular component is multiplied by
    # (phi/2) / sin(phi/2)
    half = 0.5 * angle
    grow = np.where(
        angle > SMALL, half / np.sin(np.where(angle > SMALL, half, 1.0)), 1.0 + half**2 / 6.0
    )
    safe = np.where(angle > 0.0, angle, 1.0)
    u = phi / safe
    along = (u * m).sum(axis=-1, keepdims=True) * u
    middle = along + grow * (m - along)
    lever = np.cross(n, found.r)
    twist = _lag(phi) * np.cross(phi, lever)
    at_a = middle - 0.5 * lever + twist
    at_b = middle + 0.5 * lever + twist
    turn = 0.5 * phi
    a = np.concatenate([rotate_vectors(turn, n), rotate_vectors(turn, at_a)], axis=-1)
    b = np.concatenate([rotate_vectors(-turn, n), rotate_vectors(-turn, at_b)], axis=-1)
    return np.stack([a, b], axis=-2)


def logarithm(Q: Array) -> Array:
    """Return the rotation vectors (..., 3) of rotation matrices (..., 3, 3), rad."""
    vectors = Rotation.from_matrix(Q.reshape(-1, 3, 3)).as_rotvec()
    return np.asarray(vectors.reshape(Q.shape[:-1]))


def exponential(phi: Array) -> Array:
    """Return the rotation matrices (..., 3, 3) of rotation vectors (..., 3)."""
    matrices = Rotation.from_rotvec(phi.reshape(-1, 3)).as_matrix()
    return np.asarray(matrices.reshape(*phi.shape, 3))


def rotate_vectors(phi: Array, x: Array) -> Array:
    """Return ``exp(phi) x`` of vectors (..., 3) by Rodrigues' formula."""
    angle2 = (phi * phi).sum(axis=-1, keepdims=True)
    angle = np.sqrt(angle2)
    small = angle < SMALL
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 1.0 - angle2 / 6.0, np.sin(safe) / safe)
    b = np.where(small, 0.5 - angle2 / 24.0, (1.0 - np.cos(safe)) / safe**2)
    cross = np.cross(phi, x)
    return np.asarray(x + a * cross + b * np.cross(phi, cross))


def _apply(Q: Array, x: Array) -> Array:
    return np.asarray(np.einsum("...ij,...j->...i", Q, x))


def _lag(phi: Array) -> Array:
    """Return ``tan(|phi| / 4) / (2 |phi|)``."""
    angle = np.linalg.norm(phi, axis=-1, keepdims=True)
    small = angle < SMALL
    safe = np.where(small, 1.0, angle)
    return np.where(small, 0.125 + angle**2 / 384.0, 0.5 * np.tan(0.25 * safe) / safe)


def _inverse(phi: Array) -> Array:
    """Return the last coefficient of ``T^-1 = 1 - [phi] / 2 + c [phi]^2``."""
    angle = np.linalg.norm(phi, axis=-1, keepdims=True)
    small = angle < 0.1  # series, since the closed form is inaccurate for small angles
    safe = np.where(small, 1.0, angle)
    series = 1.0 / 12.0 + angle**2 / 720.0 + angle**4 / 30240.0 + angle**6 / 1209600.0
    return np.asarray(np.where(small, series, (1.0 - 0.5 * safe / np.tan(0.5 * safe)) / safe**2))
