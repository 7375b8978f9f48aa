"""What the elements of a beam can bear: their highest frequency and the tension of stable shear."""

from __future__ import annotations

import numpy as np
import scipy.linalg as sl

from jousto.mechanism.orientation import Array


def highest_frequencies(data: Array) -> Array:
    """Return the highest angular frequency (n,) of free elements with their own mass, rad/s.

    No motion of the beam is faster than its fastest element (Irons and Treharne, 1971), and a
    chain of equal elements comes close to it. An explicit method needs steps of about 2 over it.

    Parameters
    ----------
    data : (n, 80) array
        Elements as in ``jo_beam`` of jousto.h.
    """
    kinds, which = np.unique(
        np.concatenate([data[:, :1], data[:, 25:61], data[:, 69:77]], axis=1),
        axis=0,
        return_inverse=True,
    )
    return np.array([_highest(row) for row in kinds])[which.ravel()]


def _highest(row: Array) -> float:
    L, C, share, mass = row[0], row[1:37].reshape(6, 6), row[37], row[38]
    xx, yy, zz, yz, xz, xy = row[39:45]
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    # strains of end displacements and rotations: Gamma = du/L - theta x e1, kappa = dtheta/L
    B = np.zeros((6, 12))
    E = np.eye(3)
    turn = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    B[:3, :3], B[:3, 6:9] = -E / L, E / L
    B[:3, 3:6], B[:3, 9:] = turn / 2, turn / 2
    B[3:, 3:6], B[3:, 9:] = -E / L, E / L
    ends = np.array([[0.5, 0.0], [0.0, 0.5]]) + share / 6 * np.array([[-1.0, 1.0], [1.0, -1.0]])
    unit = sl.block_diag(mass * E, J)
    values = sl.eigh(L * B.T @ C @ B, np.kron(ends, unit), eigvals_only=True)
    return float(np.sqrt(max(values[-1], 0.0)))
