"""Data of criteria for the engine, with the smallest number of rows per mode."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array
from jousto.base.voigt import PAIRS
from jousto.model.native.recover import Recovery, tiles
from jousto.recovery.fields.criteria import Criterion, weights

HALF_SHEARS = np.array([1.0, 1.0, 1.0, 0.5, 0.5, 0.5])

MISES = np.array(
    [
        [np.sqrt(0.75), -np.sqrt(0.75), 0, 0, 0, 0],
        [-0.5, -0.5, 1.0, 0, 0, 0],
        [0, 0, 0, np.sqrt(3.0), 0, 0],
        [0, 0, 0, 0, np.sqrt(3.0), 0],
        [0, 0, 0, 0, 0, np.sqrt(3.0)],
    ]
)
"""``s^T V s = |MISES s|^2``: the von Mises stress is the norm of a vector (5,)."""

NAMES = {
    "signed-von-mises": "SIGNED_MISES",
    "principal-1": "PRINCIPAL_1",
    "principal-2": "PRINCIPAL_2",
    "principal-3": "PRINCIPAL_3",
    "signed-principal": "SIGNED_PRINCIPAL",
    "max-shear": "SHEAR",
}


def kernel(S: Array, criterion: Criterion, strain: bool = False, world: bool = False) -> Recovery:
    """Return the data of a criterion for the engine.

    Parameters
    ----------
    S : (ns, 6, k) array
        Stress or strain of each mode.
    criterion : str or Plane
        A valid criterion.
    strain : bool
        Whether S is strain with engineering shears.
    world : bool
        Whether components are in world axes while S is in the body frame; `world_weights` then
        returns their weights.
    """
    ns = len(S)
    w = weights(criterion, strain)
    if w is not None and not world:
        return Recovery(tiles(np.einsum("c,scj->sj", w, S)[:, None, :]), ns, "WEIGHTED")
    T = S * HALF_SHEARS[:, None] if strain else S
    if w is not None:
        return Recovery(tiles(T), ns, "WEIGHTED")
    if criterion == "von-mises":
        rows = np.matmul(MISES, T)
        # only rows that are not zero, since parts of beams have one direct and two shear stresses
        kept = np.any(rows, axis=(0, 2))
        kept[:1] |= not np.any(kept)
        return Recovery(tiles(rows[:, kept]), ns, "NORM", 2.0 / 3.0 if strain else 1.0)
    scale = 1.0
    if criterion == "signed-von-mises" and strain:
        scale = 2.0 / 3.0
    if criterion == "max-shear" and not strain:
        scale = 0.5
    return Recovery(tiles(T), ns, NAMES[str(criterion)], scale)


def world_weights(w: Array, A: Array, strain: bool = False) -> Array:
    """Return the weights (nt, 6) of body components for ``w . s`` of world components s.

    Parameters
    ----------
    w : (6,) array
        Weights of the components in world axes.
    A : (nt, 3, 3) array
        Rotation matrices from body to world.
    strain : bool
        Whether w is for engineering shears; the result is for tensor shears.
    """
    W = np.zeros((3, 3))
    for c, (i, j) in enumerate(PAIRS):
        W[i, j] = W[j, i] = w[c] if i == j or strain else 0.5 * w[c]
    body = np.einsum("tai,ab,tbj->tij", A, W, A, optimize=True)
    return np.stack([body[:, i, j] * (1.0 if i == j else 2.0) for i, j in PAIRS], axis=1)
