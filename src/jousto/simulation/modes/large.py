"""Modes of large mechanisms by sparse matrices, at rest and in motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from numpy.typing import NDArray

from jousto.base.arrays import Array, skew
from jousto.base.rotations import rotation_matrix
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.simulation.modes.spectrum import lowest_modes, newton_sparse, saddle
from jousto.simulation.state import State, put

MANY = 600  # number of velocities and rows above which matrices are sparse
# rounding error of omega^2 over the largest stiffness over mass, after iterative refinement
ROUND_OFF = 10 * float(np.finfo(float).eps)
USUAL = 20  # default number of modes of large mechanisms
NOISE = 1e-13  # omega^2 over the largest stiffness over mass, below which it is round-off


def large_modes(
    model: Model, state: State, damped: bool, count: int
) -> tuple[NDArray[np.complex128], NDArray[Any], float]:
    """Return eigenvalues (k,) in 1/s, increments (nv, k), and the rounding error of omega^2.

    The modes are sorted, the lowest first; their increments are in body frames.

    With increments x in body frames: ``dq = T x``, ``dv = T (x' + W x)``; ``da`` of translations
    is ``T (x'' + 2 W x' + (W' + W W) x)``, of rotations ``T (x'' + W x' + W' x)``, with the spin W
    of the body. The matrices of

        ``M x'' + G x' + K x + C^T y = 0,  C x = 0``

    then follow from derivatives of the engine's residual and are constant in steady rotation.
    """
    engine = Engine(model)
    put(engine, state, "modes")
    if not damped:
        engine.v[:] = 0.0
    engine.accelerations()
    nv = model.nv
    A = newton_sparse(engine, 0.0, 0.0, 1.0).tocsr()
    D = newton_sparse(engine, 0.0, 1.0, 0.0).tocsr()[:nv, :nv]
    M = newton_sparse(engine, 1.0, 0.0, 0.0).tocsr()[:nv, :nv]
    frames: list[Any] = []
    for b in model.bodies:
        frames += [rotation_matrix(engine.q[b.iq + 3 : b.iq + 7]), np.eye(3), np.eye(b.n)]
    T = sp.block_diag(frames, format="csr")
    rates, twice, pulls = _spins(model, engine)
    K = T.T @ (A[:nv, :nv] @ T + D @ T @ rates + M @ T @ pulls)
    G = T.T @ (M @ T @ twice + D @ T)
    M = T.T @ M @ T
    C = A[:nv, nv:].T @ T
    round_off = ROUND_OFF * _ratio(K, M)
    if not damped:
        found = lowest_modes(K.tocsc(), M.tocsc(), C.tocsc(), count)
        roots = np.sqrt(-found.squares.astype(np.complex128))
        return np.where(roots.imag < 0.0, -roots, roots), found.shapes, round_off
    return *_quadratic(K, G, M, C, count), round_off


def _ratio(K: Any, M: Any) -> float:
    """Return the largest ratio of stiffness and mass, (rad/s)^2."""
    return float(np.max(np.abs(K.diagonal()) / np.maximum(M.diagonal(), 1e-300)))


def _spins(model: Model, engine: Engine) -> tuple[Any, Any, Any]:
    """Return the sparse matrices d(dv)/dx, d(da)/dx' and d(da)/dx (nv, nv), in body frames."""
    rates: list[Any] = []
    twice: list[Any] = []
    pulls: list[Any] = []
    for b in model.bodies:
        w, turned = skew(engine.v[b.iv + 3 : b.iv + 6]), skew(engine.a[b.iv + 3 : b.iv + 6])
        none = np.zeros((b.n, b.n))
        rates += [w, w, none]
        twice += [2.0 * w, w, none]
        pulls += [turned + w @ w, turned, none]
    first, second, third = (sp.block_diag(x, format="csr") for x in (rates, twice, pulls))
    return first, second, third


def _quadratic(
    K: Any, G: Any, M: Any, C: Any, count: int
) -> tuple[NDArray[np.complex128], NDArray[Any]]:
    """Return the eigenvalues l nearest to 0 and the x of ``(l^2 M + l G + K) x = 0``, ``C x = 0``.

    The method is shift-invert Arnoldi.
    """
    n = K.shape[0]
    ratio = _ratio(K, M)
    still = np.sort(np.abs(lowest_modes(K.tocsc(), M.tocsc(), C.tocsc(), 8).squares))
    firm = still[still > NOISE * ratio]
    # a free rigid motion has the eigenvalue 0: shift away from it
    free_one = len(firm) < len(still)
    shift = 0.3 * float(np.sqrt(firm[0] if len(firm) else 1e3 * NOISE * ratio)) * free_one
    solve = saddle(K + shift * G + shift**2 * M, C)

    def inverse(z: Array) -> Array:
        f, g = z[:n], z[n:]
        x = solve(-(M @ (g + shift * f) + G @ f))
        return np.concatenate([x, f + shift * x])

    operator: Any = spl.LinearOperator((2 * n, 2 * n), matvec=inverse, dtype=np.float64)
    free = solve(M @ np.random.default_rng(7).standard_normal(n))
    start = np.concatenate([free, free])
    wanted = min(2 * count + 4, 2 * (n - C.shape[0]) - 2)
    values, vectors = spl.eigs(operator, k=wanted, which="LM", v0=inverse(start))
    found = shift + 1.0 / values
    keep = np.flatnonzero(found.imag >= 0.0)
    keep = keep[np.argsort(np.abs(found[keep]), kind="stable")][:count]
    return np.asarray(found[keep]), vectors[:n, keep]
