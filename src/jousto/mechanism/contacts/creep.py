"""Creep of two elastic bodies that roll on each other: coefficients of Kalker's linear theory."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from jousto.base.arrays import Array

DEGREE = 8
"""Degree of the polynomials of the tractions; 12 changes C by less than 1e-3."""
SLENDER = 60.0
"""Largest ratio of the half axes that the degree resolves."""
DIRECTIONS = 48
"""Directions of integration over half a turn for a circle, times the root of the ratio."""


class CreepCoefficients(NamedTuple):
    """Kalker's coefficients, 1: ``Fx = -G a b C11 nu_x``.

    ``Fy = -G a b (C22 nu_y + sqrt(a b) C23 phi)``, ``M = G a b (sqrt(a b) C23 nu_y - a b C33
    phi)``.
    """

    C11: float
    C22: float
    C23: float
    C33: float


@lru_cache(maxsize=256)
def creep_coefficients(ratio: float, nu: float) -> CreepCoefficients:
    """Return the creep coefficients of an elliptic contact of two bodies of one material.

    Parameters
    ----------
    ratio : float
        Half axis along the rolling direction over the one across, from 1/60 to 60.
    nu : float
        Poisson's ratio, from 0 to 0.5.

    Notes
    -----
    J. J. Kalker, On the rolling contact of two elastic bodies in the presence of dry friction,
    1967: nothing slips. With the half space's displacement u (Boussinesq, Cerruti) under the
    traction p, ``du/dx = (nu_x - phi y, nu_y + phi x)``, which leaves u free by functions of y:
    they make p vanish at the leading edge. Under ``p = polynomial / sqrt(1 - x^2/a^2 - y^2/b^2)``
    u is a polynomial of the same degree (Galin); a ray through the ellipse integrates it exactly
    by Gauss-Chebyshev.
    """
    a, b = np.sqrt(ratio), 1.0 / np.sqrt(ratio)  # a b = 1
    n = (DEGREE + 1) * (DEGREE + 2) // 2

    # compliance: coefficients of u from those of p, by points in the ellipse
    x, y = _points()
    fit = np.linalg.pinv(_basis(x, y))
    xx, xy, yy = (fit @ u for u in _displacements(x, y, a, b, nu))
    compliance = np.block([[xx, xy], [xy, yy]])

    # u of the three creepages, and u that depends on y alone, of each component
    none = np.zeros(n)
    along, spin_x, spin_y = (fit @ f for f in (a * x, -x * y, 0.5 * (a * x) ** 2))
    given = [np.r_[along, none], np.r_[none, along], np.r_[spin_x, spin_y]]
    alone = [k for k, (i, _) in enumerate(_degrees()) if i == 0]
    free = np.eye(2 * n)[[*alone, *(n + k for k in alone)]]
    tractions = np.linalg.solve(compliance, np.vstack([given, free]).T)

    # no traction at the leading edge x > 0, least squares over the angle of the ellipse
    angle = (np.arange(4 * DEGREE) + 0.5) * np.pi / (4 * DEGREE)
    edge = _basis(np.sin(angle), np.cos(angle)) * np.sin(angle)[:, None]
    ahead = np.vstack([edge @ tractions[:n], edge @ tractions[n:]])
    size = np.linalg.norm(ahead[:, 3:], axis=0)
    shares = np.linalg.lstsq(ahead[:, 3:] / size, -ahead[:, :3], rcond=1e-12)[0]
    p = tractions[:, :3] + tractions[:, 3:] / size @ shares

    one, lever_x, lever_y = _moments(a, b)
    Fx, Fy = one @ p[:n], one @ p[n:]
    M = lever_x @ p[n:] - lever_y @ p[:n]
    found = Fx[0], Fy[1], 0.5 * (Fy[2] - M[1]), M[2]
    return CreepCoefficients(*(abs(float(c)) for c in found))


def _degrees() -> list[tuple[int, int]]:
    return [(i, j) for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)]


def _basis(x: Any, y: Any) -> Array:
    """Return products of Chebyshev polynomials (..., n) at x/a, y/b."""
    i, j = np.transpose(_degrees())
    return np.asarray(chebvander(x, DEGREE)[..., i] * chebvander(y, DEGREE)[..., j])


def _points() -> tuple[Array, Array]:
    """Return points x/a, y/b within the ellipse that determine the polynomials."""
    rings, around = DEGREE // 2 + 2, 2 * DEGREE + 2
    r, angle = np.meshgrid(
        np.sqrt((np.arange(rings) + 0.5) / rings), 2 * np.pi * np.arange(around) / around
    )
    return (r * np.cos(angle)).ravel(), (r * np.sin(angle)).ravel()


def _displacements(x: Array, y: Array, a: float, b: float, nu: float) -> list[Array]:
    """Return u_xx, u_xy = u_yx, u_yy (points, n) under the tractions of the basis; G = 1."""
    # directions in the ellipse made a circle, a ray each: u = int K dtheta int p ds
    count = int(DIRECTIONS * np.sqrt(max(a, b) / min(a, b)) ** 1.5)
    phi = (np.arange(count) + 0.5) * np.pi / count
    way = np.cos(phi), np.sin(phi)
    stretch = np.sqrt((a * way[0]) ** 2 + (b * way[1]) ** 2)
    cos, sin = a * way[0] / stretch, b * way[1] / stretch
    kernels = (1 - nu) + nu * cos**2, nu * sin * cos, (1 - nu) + nu * sin**2
    weights = np.stack(kernels) * a * b / stretch / count

    # along a ray p is a polynomial over the root of a parabola: Gauss-Chebyshev is exact
    order = DEGREE // 2 + 1
    nodes = np.cos((np.arange(order) + 0.5) * np.pi / order)
    middle = -(np.outer(x, way[0]) + np.outer(y, way[1]))
    half = np.sqrt(middle**2 + (1.0 - x**2 - y**2)[:, None])
    sums = np.zeros((3, len(x), len(_degrees())))
    for node in nodes:
        s = middle + node * half
        basis = _basis(x[:, None] + s * way[0], y[:, None] + s * way[1])
        sums += np.einsum("kt,mtn->kmn", weights, basis) * (np.pi / order)
    return list(sums)


def _moments(a: float, b: float) -> tuple[Array, Array, Array]:
    """Return integrals (n,) of 1, x, y times the tractions of the basis over the ellipse."""
    z, weight = np.polynomial.legendre.leggauss(DEGREE + 3)
    z, weight = 0.5 * (z + 1.0), 0.5 * weight  # z: root of 1 - r^2
    angle = 2 * np.pi * np.arange(2 * DEGREE + 4) / (2 * DEGREE + 4)
    r = np.sqrt(1.0 - z**2)[:, None]
    x, y = r * np.cos(angle), r * np.sin(angle)
    area = np.broadcast_to(weight[:, None] * 2 * np.pi / len(angle), x.shape)
    basis = _basis(x, y)
    one, by_x, by_y = (np.einsum("ra,ran->n", area * f, basis) for f in (1.0, a * x, b * y))
    return one, by_x, by_y
