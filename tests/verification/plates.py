"""Exact waves of plates and other closed forms that the verification of solids needs."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq
from scipy.special import jvp, yvp

import jousto as jo


def lamb(k: float, h: float, material: jo.Material) -> float:
    """Return the lowest flexural frequency in rad/s of a plate with the wave number k.

    A plate of thickness h whose edges let the normal and hold the tangential displacement (all
    over the thickness) vibrates as a sum of plane waves with ``k^2 = (m pi/a)^2 + (n pi/b)^2``:
    the antisymmetric Rayleigh-Lamb equation ``tan(q h/2) / tan(p h/2) = -(q^2 - k^2)^2 / (4 k^2 p
    q)``, ``p^2 = (w/cL)^2 - k^2``, ``q^2 = (w/cT)^2 - k^2`` (K. F. Graff, Wave Motion in Elastic
    Solids, 1975, chapter 8), is exact in three dimensions. Below ``w = cT k`` both roots are
    imaginary and the tangents become hyperbolic.
    """
    E, nu, rho = material.E, material.nu, material.rho
    G = E / (2.0 * (1.0 + nu))
    cT = np.sqrt(G / rho)
    cL = np.sqrt(2.0 * G * (1.0 - nu) / (1.0 - 2.0 * nu) / rho)

    def gap(w: float) -> float:
        p, q = np.sqrt(k**2 - (w / cL) ** 2), np.sqrt(k**2 - (w / cT) ** 2)
        left = (q**2 + k**2) ** 2 * np.tanh(p * h / 2.0)
        return float(left - 4.0 * k**2 * p * q * np.tanh(q * h / 2.0))

    guess = mindlin(k, h, material)
    return float(brentq(gap, 0.7 * guess, min(1.3 * guess, cT * k * (1 - 1e-12)), xtol=1e-12))


def kirchhoff(k: float, h: float, material: jo.Material) -> float:
    """Return ``k^2 sqrt(D / (rho h))`` in rad/s, ``D = E h^3 / (12 (1 - nu^2))``."""
    E, nu, rho = material.E, material.nu, material.rho
    return float(k**2 * np.sqrt(E * h**2 / (12.0 * (1.0 - nu**2) * rho)))


def mindlin(k: float, h: float, material: jo.Material) -> float:
    """Return the flexural frequency in rad/s of Mindlin's plate, shear factor pi^2/12.

    ``(1 - S w^2 / k^2) (w0^2 ... )`` written as the lower root of a quadratic in w^2
    (R. D. Mindlin, J. Appl. Mech. 18, 1951).
    """
    E, nu, rho = material.E, material.nu, material.rho
    G, D = E / (2.0 * (1.0 + nu)), E * h**3 / (12.0 * (1.0 - nu**2))
    kGh = np.pi**2 / 12.0 * G * h
    # (D k^2 + kGh - rho h^3/12 w^2) (kGh k^2 - rho h w^2) = (kGh k)^2
    i, m = rho * h**3 / 12.0, rho * h
    a, b, c = i * m, -(m * (D * k**2 + kGh) + i * kGh * k**2), D * kGh * k**4
    return float(np.sqrt((-b - np.sqrt(b**2 - 4.0 * a * c)) / (2.0 * a)))


def thick_ring(
    n: int, radii: tuple[float, float], material: jo.Material, count: int = 2
) -> np.ndarray:
    """Return the lowest in-plane frequencies in Hz of a free thick ring held flat (plane strain).

    n waves around. With ``phi = (A J_n + B Y_n)(w r/cL) cos n t`` and ``psi = (C J_n + D Y_n)(w
    r/cT) sin n t``, ``u_r = phi' + n psi / r``, ``u_t = -n phi / r - psi'``, both surfaces free of
    stress (D. C. Gazis, J. Acoust. Soc. Am. 30, 1958): exact in three dimensions for a ring between
    smooth rigid planes.
    """
    E, nu, rho = material.E, material.nu, material.rho
    G = E / (2.0 * (1.0 + nu))
    lam = 2.0 * G * nu / (1.0 - 2.0 * nu)
    cL, cT = np.sqrt((lam + 2.0 * G) / rho), np.sqrt(G / rho)

    def determinant(w: float) -> float:
        rows = []
        a, b = w / cL, w / cT
        for r in radii:
            normal, shear = [], []
            for f in (jvp, yvp):
                # of phi alone
                p, p1, p2 = f(n, a * r, 0), a * f(n, a * r, 1), a**2 * f(n, a * r, 2)
                normal.append(-lam * a**2 * p + 2.0 * G * p2)
                shear.append(G * 2.0 * n * (p / r**2 - p1 / r))
            for f in (jvp, yvp):
                # of psi alone
                s, s1, s2 = f(n, b * r, 0), b * f(n, b * r, 1), b**2 * f(n, b * r, 2)
                normal.append(2.0 * G * n * (s1 / r - s / r**2))
                shear.append(G * (-s2 + s1 / r - n**2 * s / r**2))
            rows += [normal, shear]
        return float(np.linalg.det(np.array(rows) / G))

    # scan from far below the thin ring's frequency
    start = 0.3 * 2.0 * np.pi * thin_ring(n, radii, material)
    w = start
    found: list[float] = []
    while len(found) < count:
        step = 1.02 * w
        if determinant(w) * determinant(step) < 0.0:
            found.append(brentq(determinant, w, step, rtol=1e-13))
        w = step
    return np.array(found) / (2.0 * np.pi)


def flat(material: jo.Material) -> jo.Material:
    """Return the material whose plane strain is the plane stress of the given one."""
    E, nu = material.E, material.nu
    return jo.Material(E * (1.0 + 2.0 * nu) / (1.0 + nu) ** 2, nu / (1.0 + nu), material.rho)


def thin_ring(n: int, radii: tuple[float, float], material: jo.Material) -> float:
    """Return the in-plane bending frequency in Hz of a thin ring, unrestrained across.

    ``w^2 = E I / (rho A R^4) n^2 (n^2 - 1)^2 / (n^2 + 1)`` (A. E. H. Love, Mathematical Theory of
    Elasticity, 1927, art. 293).
    """
    E, rho = material.E, material.rho
    h, R = radii[1] - radii[0], 0.5 * (radii[0] + radii[1])
    square = E * h**2 / (12.0 * rho * R**4) * n**2 * (n**2 - 1) ** 2 / (n**2 + 1)
    return float(np.sqrt(square) / (2.0 * np.pi))


def spinning_ring(
    r: np.ndarray, radii: tuple[float, float], speed: float, material: jo.Material
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return radial displacement, radial and hoop stress of a spinning ring held flat.

    ``s_r = (3 + m)/8 rho w^2 (b^2 + a^2 - a^2 b^2 / r^2 - r^2)``, ``s_t = (3 + m)/8 rho w^2 (b^2 +
    a^2 + a^2 b^2 / r^2 - (1 + 3 m)/(3 + m) r^2)`` with ``m = nu / (1 - nu)`` for plane strain
    (Timoshenko and Goodier, Theory of Elasticity, 1970, art. 32).
    """
    E, nu, rho = material.E, material.nu, material.rho
    a, b = radii
    m, E1 = nu / (1.0 - nu), E / (1.0 - nu**2)
    c = (3.0 + m) / 8.0 * rho * speed**2
    radial = c * (b**2 + a**2 - (a * b / r) ** 2 - r**2)
    hoop = c * (b**2 + a**2 + (a * b / r) ** 2 - (1.0 + 3.0 * m) / (3.0 + m) * r**2)
    return r * (hoop - m * radial) / E1, radial, hoop
