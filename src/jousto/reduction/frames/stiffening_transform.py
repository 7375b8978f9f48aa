"""Second-order displacements of a body relative to another frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.reduction.fields.invariants import EPS, Invariants
from jousto.reduction.fields.stiffening import Stiffening
from jousto.reduction.reduced import ReducedPart


@dataclass(frozen=True, eq=False)
class Turn:
    """Motion of a frame in the modes of a body, and the orthonormalised new modes.

    Parameters
    ----------
    t, theta : (3, n) array
        Translation at the origin and rotation in each mode, part frame.
    V : (n, n) array
        New modes as combinations of the modes without the motion of the frame.
    """

    t: Array
    theta: Array
    V: Array


def turned_stiffening(reduced: ReducedPart, turn: Turn) -> Stiffening:
    """Return the second-order field of a body relative to a frame that moves in its modes.

    Relative to a frame displaced by ``t p`` and rotated by ``exp(theta p~)``, a particle at ``u0 +
    Phi p + chi(p, p)/2`` is at ``u0 + (Phi - t - theta x u0) p + chi'(p, p)/2`` with

        ``chi'_jk = chi_jk - theta_j x (phi_k - t_k) - theta_k x (phi_j - t_j)
        + (theta_j x (theta_k x u0) + theta_k x (theta_j x u0))/2``,

    and its rotation has ``psi'_jk = psi_jk - (theta_j x Psi_k + theta_k x Psi_j)/2``. The
    second-order motion of the frame is arbitrary and chosen such that chi' has no momentum, as
    required by `Stiffening`.
    """
    held = reduced.stiffening
    assert held is not None
    I, t, theta = reduced.invariants, turn.t, turn.theta
    # int chi' dm and int u0 chi'^T dm before the rigid motion is removed; _jk, symmetric
    cross = np.einsum("abc,bj->jac", EPS, theta)
    twice = np.einsum("jab,kbc->jkac", cross, cross)
    linear = _both(-np.einsum("jab,bk->jka", cross, I.I3 - I.mass * t))
    linear += _both(0.5 * twice @ I.first_moment)
    bare = I.N0 - np.einsum("a,bk->kab", I.first_moment, t)
    N = _both(-np.einsum("kab,jcb->jkac", bare, cross))
    N += _both(0.5 * np.einsum("ab,jkcb->jkac", I.second_moment, twice))
    N += held.second_moment
    b, c = _balanced(I, linear, np.einsum("abc,jkbc->jka", EPS, N))
    turned = np.einsum("abc,jkb->jkac", EPS, b)
    N -= np.einsum("a,jkb->jkab", I.first_moment, c)
    N -= np.einsum("ab,jkcb->jkac", I.second_moment, turned)

    x, V = reduced.nodes, turn.V
    moved = np.einsum("jab,xbk->jkxa", cross, reduced.modes - t)
    chi = held.translations.transpose(2, 3, 0, 1) - _both(moved) - c[:, :, None, :]
    chi += _both(0.5 * np.einsum("jkab,xb->jkxa", twice, x))
    chi -= np.einsum("jkab,xb->jkxa", turned, x)
    psi = held.rotations.transpose(2, 3, 0, 1).copy()
    if reduced.rotations is not None:
        which = slice(None) if reduced.rotation_nodes is None else reduced.rotation_nodes
        own = np.einsum("jab,xbk->jkxa", cross, reduced.rotations)
        psi[:, :, which] -= 0.5 * _both(own) + b[:, :, None, :]
    moment = np.einsum("jkab,jl,km->lmab", 0.5 * (N + N.swapaxes(2, 3)), V, V, optimize=True)
    return Stiffening(
        0.5 * (moment + moment.swapaxes(0, 1)),
        np.einsum("jkxa,jl,km->xalm", chi, V, V, optimize=True),
        np.einsum("jkxa,jl,km->xalm", psi, V, V, optimize=True),
    )


def _both(a: Array) -> Array:
    """Return ``a_jk + a_kj`` of an array (n, n, ...)."""
    return np.asarray(a + a.swapaxes(0, 1))


def _balanced(I: Invariants, linear: Array, angular: Array) -> tuple[Array, Array]:
    """Return the rotation and translation (n, n, 3) that cancel given momenta."""
    h = np.concatenate([linear, angular], axis=2)
    c = I.rigid_motion(h.reshape(-1, 6).T).T.reshape(h.shape)
    return c[..., 3:], c[..., :3]
