"""Matrices summed from blocks over bodies against the same sums of full matrices."""

from __future__ import annotations

import numpy as np
import pytest

from jousto.natural.equations.block_matrix import Layout, Slopes, Term

NB, W, NS = 5, 15, 12
MODES = np.array([3, 0, 2, 0, 1])


def full(ends: np.ndarray, blocks: np.ndarray) -> np.ndarray:
    """Derivatives (k, NB W) of functions from those with respect to the bodies of each."""
    out = np.zeros((len(ends), NB + 1, W))
    for row, (bodies, each) in enumerate(zip(ends, blocks, strict=True)):
        for body, block in zip(bodies, each, strict=True):
            out[row, body] += block
    return out[:, :NB].reshape(len(ends), -1)


@pytest.mark.parametrize("large", [False, True])
def test_solvers_against_full_matrices(large: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Functions with both ends on one body or on the ground, rows of several and of none twice.

    1e-9: the matrices have condition numbers below 1e4.
    """
    if large:
        monkeypatch.setattr("jousto.natural.equations.block_matrix.LARGE", 1)
    rng = np.random.default_rng(3)
    ends = rng.integers(0, NB + 1, (NS, 2))
    ends[0], ends[1] = (2, 2), (NB, 1)
    used = np.arange(W) < 12 + MODES[:, None]
    blocks = rng.standard_normal((NS, 2, W)) * np.concatenate([used, np.zeros((1, W))])[ends]
    F = np.where(rng.random((40, NS)) < 0.15, rng.standard_normal((40, NS)), 0.0)
    F[np.arange(NS), np.arange(NS)] = 1.0
    layout = Layout(F, ends, MODES, W)
    slopes = Slopes(layout.functions, blocks)
    Cq = layout.rows(slopes)
    B = full(ends, blocks)
    v, f, lam = rng.standard_normal(NB * W), rng.standard_normal(NS), rng.standard_normal(40)
    np.testing.assert_allclose(slopes.times(v), B @ v, atol=1e-12)
    np.testing.assert_allclose(slopes.pulled(f), f @ B, atol=1e-12)
    np.testing.assert_allclose(Cq.times(v), F @ B @ v, atol=1e-12)
    np.testing.assert_allclose(Cq.pulled(lam), lam @ F @ B, atol=1e-12)

    half = rng.standard_normal((NB, W, W)) * used[:, :, None]
    M = half @ np.swapaxes(half, 1, 2) + 5.0 * np.eye(W)
    weight = rng.random(40)
    H = rng.standard_normal((3, 3))
    own = (rng.integers(0, NB + 1, (3, 2)), rng.standard_normal((3, 2, W)))
    own[1][...] *= np.concatenate([used, np.zeros((1, W))])[own[0]]
    terms = [slopes.term(np.array([4, 7]), np.eye(2)), Term(*own, 0.1 * H)]
    dense = sum(
        [
            (F @ B).T @ (weight[:, None] * (F @ B)),
            B[[4, 7]].T @ B[[4, 7]],
            full(*own).T @ (0.1 * H) @ full(*own),
        ]
    )
    for body in range(NB):
        here = slice(W * body, W * (body + 1))
        dense[here, here] += M[body]
    r = rng.standard_normal(NB * W) * used.ravel()
    x = layout.solver(M, Cq, weight, terms)(r)
    assert np.all(x[~used.ravel()] == 0.0)
    np.testing.assert_allclose(dense @ x, r, atol=1e-9)
