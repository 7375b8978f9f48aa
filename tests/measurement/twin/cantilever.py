"""The cantilever of the strain reconstruction: 1 m, 20 x 10 mm, steel, six gauges on top."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

import jousto as jo

L, B, H, E, RHO = 1.0, 0.02, 0.01, 2.1e11, 7850.0
GAUGES = (0.05, 0.2, 0.35, 0.5, 0.65, 0.8)  # m
STEEL = jo.Material(E=E, nu=0.3, rho=RHO)


def part(elements: int = 20) -> jo.Part:
    return jo.Part.beam(
        L,
        jo.Rectangle(B, H),
        elements,
        STEEL,
        theory=jo.parts.EulerBernoulli(),
        rotary_inertia=False,
        name="cantilever",
    )


@dataclass(frozen=True)
class Clamped:
    """Bending in the plane of the height: free degrees of freedom of the part's own matrices."""

    M: np.ndarray
    K: np.ndarray
    omega: np.ndarray
    modes: np.ndarray
    strain: np.ndarray  # (ng, ndof)
    clamp: np.ndarray  # (ndof,) strain of the root


def clamped(elements: int = 20) -> Clamped:
    p = part(elements)
    free = np.array([6 * k + c for k in range(1, elements + 1) for c in (2, 4)])
    M, K = (np.asarray(X.toarray())[np.ix_(free, free)] for X in (p.M, p.K))
    w2, modes = la.eigh(K, M)
    # curvature of the cubic element at its own coordinate, from w and w' = -theta_y at both ends
    h = L / elements

    def row(x: float) -> np.ndarray:
        e = min(int(x / h + 1e-9), elements - 1)
        s = x / h - e
        w = np.array([12 * s - 6, -(6 * s - 4) * h, 6 - 12 * s, -(6 * s - 2) * h]) / h**2
        full = np.zeros(2 * (elements + 1))
        full[2 * e : 2 * e + 4] = -0.5 * H * w
        return full[2:]

    strain = np.array([row(x) for x in GAUGES])
    return Clamped(M, K, np.sqrt(w2), modes, strain, row(0.0))
