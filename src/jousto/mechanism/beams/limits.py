"""Limits of beam elements: highest frequency, and tension of stable shear."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy

from jousto.base.arrays import Array


def highest_frequencies(elements: Mapping[str, Array]) -> Array:
    """Return the highest angular frequency (n,) of free elements with their own mass, rad/s.

    No motion of the beam is faster than its fastest free element (Irons and Treharne, 1971), and a
    chain of equal elements comes close to this bound. An explicit method needs a step below about 2
    / frequency.

    Parameters
    ----------
    elements : dict of arrays
        Length, section stiffness C, inertia share, mass and J of the elements as in
        `BeamBody.elements`.
    """
    n = len(elements["length"])
    parts = [np.reshape(elements[key], (n, -1)) for key in ("length", "share", "mass", "J", "C")]
    kinds, which = np.unique(np.concatenate(parts, axis=1), axis=0, return_inverse=True)
    return np.array([_highest(row) for row in kinds])[which.ravel()]


def _highest(row: Array) -> float:
    (length, share, mass), J, C = row[:3], row[3:9], row[9:].reshape(6, 6)
    K, M = element_matrices(length, C, float(share), float(mass), J)
    values = scipy.linalg.eigh(K, M, eigvals_only=True)
    return float(np.sqrt(max(values[-1], 0.0)))


def element_matrices(
    length: float, C: Array, share: float, mass: float, J: Array
) -> tuple[Array, Array]:
    """Return stiffness and mass (12, 12) of a free element on ``[u_a, theta_a, u_b, theta_b]``.

    Parameters
    ----------
    length : float
        m.
    C : (6, 6) array
        Stiffness of the section.
    share : float Share of consistent inertia.
    mass : float
        Mass of the element, kg.
    J : (6,) array
        Rotary inertia xx, yy, zz, yz, xz, xy of the element, kg m2.
    """
    xx, yy, zz, yz, xz, xy = J
    # strains of the end motions: Gamma = du/L - theta x e1, kappa = dtheta/L
    B = np.zeros((6, 12))
    E = np.eye(3)
    turn = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    B[:3, :3], B[:3, 6:9] = -E / length, E / length
    B[:3, 3:6], B[:3, 9:] = turn / 2, turn / 2
    B[3:, 3:6], B[3:, 9:] = -E / length, E / length
    ends = np.array([[0.5, 0.0], [0.0, 0.5]]) + share / 6 * np.array([[-1.0, 1.0], [1.0, -1.0]])
    unit = scipy.linalg.block_diag(mass * E, np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    return length * B.T @ C @ B, np.asarray(np.kron(ends, unit), dtype=np.float64)
