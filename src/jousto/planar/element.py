"""Planar two-node Reissner beam elements, all elements of a frame at a time.

E. Reissner, *ZAMP* 23 (1972) 795-804; J. C. Simo, L. Vu-Quoc, *J. Appl. Mech.* 53 (1986) 849-863;
in the form of Makinen, Marjamaki and Pajunen, equations 14 to 19: linear shape functions, one point
of integration for the elastic forces, exact integration of the mass.

The variables at the midpoint of an element are ``z = [x', y', theta, kappa]``, linear in the
displacements: ``z = T u + z0``. With c, s the cosine and sine of theta

    eps = x' c + y' s - 1,   gam = y' c - x' s,   kap = theta'                          (17)
    d eps/dz = [c, s, gam, 0],   d gam/dz = [-s, c, -(1 + eps), 0],   d kap/dz = [0, 0, 0, 1]

and B of eq. 15 is these rows times T. Kelvin-Voigt damping adds ``beta D e'`` to the resultants.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class Middle(NamedTuple):
    """State at the midpoints of the elements.

    Attributes
    ----------
    strains, resultants : (ne, 3) array
        eps, gam, kap (1/m) and N, Q (N), M (N m); resultants with their damping part.
    rows : (ne, 2, 4) array
        Derivatives of eps and gam by z.
    rates : (ne, 2) array
        Rates of eps and gam, 1/s; zero without damping.
    turning : (ne,) array
        Rate of theta, rad/s; zero without damping.
    """

    strains: Array
    resultants: Array
    rows: Array
    rates: Array
    turning: Array


def middle(z: Array, D: Array, beta: float = 0.0, rate: Array | None = None) -> Middle:
    """Return strains and resultants, eqs. 16 and 17.

    Parameters
    ----------
    z : (ne, 4) array
        x', y', theta (rad), kappa (1/m) at the midpoints.
    D : (ne, 3) array
        EA, GA (N) and EI (N m^2).
    beta : float
        Stiffness-proportional damping, s.
    rate : (ne, 4) array, optional
        Time derivative of z, for the damping.
    """
    x, y, th = z[:, 0], z[:, 1], z[:, 2]
    c, s = np.cos(th), np.sin(th)
    rows = np.zeros((len(z), 2, 4), dtype=z.dtype)
    strains = np.empty((len(z), 3), dtype=z.dtype)
    stretch, gam = x * c + y * s, y * c - x * s
    strains[:, 0], strains[:, 1], strains[:, 2] = stretch - 1.0, gam, z[:, 3]
    rows[:, 0, 0] = rows[:, 1, 1] = c
    rows[:, 0, 1] = s
    rows[:, 1, 0] = -s
    rows[:, 0, 2] = gam
    rows[:, 1, 2] = -stretch
    if beta == 0.0 or rate is None:
        none = np.zeros((len(z), 2))
        return Middle(strains, D * strains, rows, none, none[:, 0])
    speed = np.empty((len(z), 3), dtype=np.result_type(z, rate))
    speed[:, :2] = np.einsum("eij,ej->ei", rows, rate)
    speed[:, 2] = rate[:, 3]
    return Middle(strains, D * (strains + beta * speed), rows, speed[:, :2], rate[:, 2])


def gradient(m: Middle) -> Array:
    """Return the forces on z per length (ne, 4), rows times resultants, eq. 14."""
    N, Q = m.resultants[:, 0], m.resultants[:, 1]
    w = m.rows[:, 0] * N[:, None] + m.rows[:, 1] * Q[:, None]
    w[:, 3] = m.resultants[:, 2]
    return np.asarray(w)


def hessian(m: Middle, D: Array, beta: float = 0.0) -> Array:
    """Return the derivative of `gradient` by z (ne, 4, 4), eq. 18 per length."""
    e, g = m.rows[:, 0], m.rows[:, 1]
    EA, GA = D[:, 0, None, None], D[:, 1, None, None]
    if beta == 0.0:
        # material part
        H = EA * e[:, :, None] * e[:, None, :] + GA * g[:, :, None] * g[:, None, :]
    else:
        # damping part: the strain rates depend on z too
        de, dg = e + beta * _rate_rows(m, 0), g + beta * _rate_rows(m, 1)
        H = EA * e[:, :, None] * de[:, None, :] + GA * g[:, :, None] * dg[:, None, :]
    # geometric part: the rows change with theta
    N, Q = m.resultants[:, 0], m.resultants[:, 1]
    turn = N[:, None] * g - Q[:, None] * e
    H[:, :2, 2] += turn[:, :2]
    H[:, 2, :3] += turn[:, :3]
    H[:, 3, 3] = D[:, 2]
    return np.asarray(H)


def _rate_rows(m: Middle, k: int) -> Array:
    """Return the derivative by z of the rate of eps (k = 0) or gam (k = 1)."""
    w = m.turning[:, None]
    out = w * m.rows[:, 1] if k == 0 else -w * m.rows[:, 0]
    out[:, 2] = m.rates[:, 1] if k == 0 else -m.rates[:, 0]
    return np.asarray(out)


def viscous(m: Middle, D: Array, beta: float) -> Array:
    """Return the derivative of `gradient` by the rate of z, (ne, 4, 4)."""
    e, g = m.rows[:, 0], m.rows[:, 1]
    EA, GA = D[:, 0, None, None], D[:, 1, None, None]
    C = beta * (EA * e[:, :, None] * e[:, None, :] + GA * g[:, :, None] * g[:, None, :])
    C[:, 3, 3] = beta * D[:, 2]
    return np.asarray(C)


def shape_matrix(length: Array, dofs: Array, size: int) -> Array:
    """Return T (4 ne, size) from the displacements of all slaves to z of all elements.

    Parameters
    ----------
    length : (ne,) array
        Lengths of the elements, m.
    dofs : (ne, 6) array of int
        Indices of x, y, rotation of both ends among the slaves.
    size : int
        Number of slave displacements.
    """
    ne = len(length)
    T = np.zeros((ne, 4, size))
    e, L = np.arange(ne), np.asarray(length)
    for row, (a, b) in {0: (0, 3), 1: (1, 4), 3: (2, 5)}.items():
        T[e, row, dofs[:, a]] = -1.0 / L
        T[e, row, dofs[:, b]] += 1.0 / L
    T[e, 2, dofs[:, 2]] = 0.5
    T[e, 2, dofs[:, 5]] += 0.5
    return T.reshape(4 * ne, size)


def mass_matrix(mass: Array, rotary: Array, dofs: Array, size: int) -> Array:
    """Return the mass matrix of all elements, eq. 19, (size, size).

    Parameters
    ----------
    mass : (ne,) array
        Masses of the elements, kg.
    rotary : (ne,) array
        Rotary inertia ``m i^2`` of the elements, kg m^2.
    dofs, size :
        As in `shape_matrix`.
    """
    M = np.zeros((size, size))
    for m, J, d in zip(mass, rotary, dofs, strict=True):
        for c, value in enumerate((m, m, J)):
            a, b = d[c], d[c + 3]
            M[a, a] += value / 3.0
            M[b, b] += value / 3.0
            M[a, b] += value / 6.0
            M[b, a] += value / 6.0
    return M
