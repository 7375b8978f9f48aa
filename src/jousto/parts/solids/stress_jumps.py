"""Stress jumps between elements as quadratic forms in the amplitudes of many shapes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jousto.base.arrays import Array
from jousto.materials.orthotropic import elasticity
from jousto.mesh.reference import table
from jousto.parts.solids.stress import SolidStress, continuation, point_strains

ROWS = 6
"""Number of eigenvectors stored per site; the remaining ones contribute little."""
BLOCK_BYTES = 64 << 20
"""Memory of the element stresses at the sites of a block, bytes."""

# the von Mises stress of a tensor is the length of these five numbers
MISES = np.array(
    [
        [np.sqrt(0.75), -np.sqrt(0.75), 0, 0, 0, 0],
        [-0.5, -0.5, 1.0, 0, 0, 0],
        [0, 0, 0, np.sqrt(3.0), 0, 0],
        [0, 0, 0, 0, np.sqrt(3.0), 0],
        [0, 0, 0, 0, 0, np.sqrt(3.0)],
    ]
)


def place_scatter(stress: SolidStress, X: Array, s: Array, size: Array) -> Array:
    """Return E (ns, r, n) with which ``|E p|`` is the estimated stress error of ``X p``.

    The error is that of `place_errors`, the root mean square of the von Mises stress of ``s_e -
    s*`` over the elements around a site, ``p^T Q p`` with ``Q = sum A_e^T A_e / count``; E contains
    the r largest eigenvalues of Q, for shapes scaled by `size`.

    Parameters
    ----------
    stress : SolidStress
    X : (ndof, n) ndarray
        Displacements of the shapes, m.
    s : (ns, 6, n) ndarray
        Stress of the shapes, ``stress.evaluate(X)``.
    size : (n,) ndarray
        Typical relative amplitudes of the shapes.
    """
    ns, n = len(stress), X.shape[1]
    found = np.zeros((ns, min(ROWS, n), n))
    order = np.argsort(stress.node, kind="stable")
    # memory of eight elements around a site: their points, the stress at their nodes, and Q
    step = max(32, BLOCK_BYTES // (8 * n * (8 * 6 * 60 + n)))
    for start in range(0, ns, step):
        chosen = order[start : start + step]
        few = replace(stress, node=stress.node[chosen], material=stress.material[chosen])
        Q = _squares(few, X, s[chosen])
        Q *= np.multiply.outer(size, size)
        values, vectors = np.linalg.eigh(Q)
        rows = np.sqrt(np.maximum(values, 0.0))[:, :, None] * np.swapaxes(vectors, 1, 2) / size
        found[chosen] = rows[:, ::-1][:, : found.shape[1]]
    # single precision is sufficient for an estimate, and makes files smaller
    return np.asarray(found.astype(np.float32).astype(np.float64))


def _squares(few: SolidStress, X: Array, s: Array) -> Array:
    """Return Q (ns, n, n) of some sites."""
    n, model, site = X.shape[1], few.model, few.numbers
    Q, count = np.zeros((len(few), n, n)), np.zeros(len(few))
    for group, touching in zip(model.groups, few._averages[1], strict=True):
        nq = len(table(group.kind, "stress", group.formulation).weights)
        C = elasticity(model.materials[group.material])
        step = max(1, BLOCK_BYTES // (8 * 6 * n * (nq + 3 * group.nodes.shape[1])))
        for start in range(0, len(touching), step):
            chosen = touching[start : start + step]
            strains = np.empty((len(chosen) * nq, 6, n))
            point_strains(model, group, chosen, X, strains)
            own = np.matmul(
                continuation(group.kind, group.formulation), strains.reshape(len(chosen), nq, 6 * n)
            )
            at = site[group.material][group.nodes[chosen]].ravel()
            known = at >= 0
            at = at[known]
            away = C @ own.reshape(-1, 6, n)[known] - s[at]
            _add(Q, at, MISES @ away)
            count += np.bincount(at, minlength=len(few))
    return Q / np.maximum(count, 1.0)[:, None, None]


def _add(Q: Array, at: Array, A: Array) -> None:
    """Add the product ``A_k^T A_k`` of each block A (m, 5, n) to the site of the block."""
    order = np.argsort(at, kind="stable")
    places, first, times = np.unique(at[order], return_index=True, return_counts=True)
    for k in np.unique(times):
        mine = np.flatnonzero(times == k)
        rows = A[order[first[mine][:, None] + np.arange(k)]].reshape(len(mine), -1, A.shape[2])
        Q[places[mine]] += np.swapaxes(rows, 1, 2) @ rows
