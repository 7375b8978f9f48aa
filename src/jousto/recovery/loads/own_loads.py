"""Loads of a body from its own motion and deformation: inertia, gravity, elastic forces."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array
from jousto.model.model import BodyModel

INERTIA, SPIN, CORIOLIS = "inertia", "centrifugal and gyroscopic", "coriolis"
GRAVITY, ELASTIC, DAMPING = "gravity", "elastic", "damping"
OWN = (GRAVITY, INERTIA, SPIN, CORIOLIS, ELASTIC, DAMPING)
"""Kinds of loads of a body that come from no other item of the mechanism."""


def own_loads(body: BodyModel, felt: Array, q: Array, v: Array, a: Array) -> dict[str, Array]:
    """Return these loads of a body by kind, from its inertia invariants.

    The equation of motion ``M a = Q`` of a modal body, written as a sum of loads that vanishes
    (d'Alembert; Altarriba 2010, eq. 96-98). With ``S = int u dm``, J the inertia about the origin,
    ``B_j = int u x phi_j dm``, ``D_j = dJ/dp_j / 2`` and the acceleration A of the frame:

    * inertia: ``-(m A + w' x S + I3 p'')``, ``-(S x A + J w' + B p'')``, ``-(I3^T A + B^T w' +
      p'')``
    * centrifugal and gyroscopic: ``-w x (w x S)``, ``-w x J w``, ``w . D_j w``
    * coriolis: ``-2 w x I3 p'``, ``-w x B p' - 2 (sum D_j p'_j) w``, ``-2 w . int phi' x phi_j dm``
    * gravity: ``m g``, ``S x g``, ``I3^T g``
    * elastic: ``-K p``; damping: ``-D p'`` of the modes, or in proportion to the momentum

    Parameters
    ----------
    body : BodyModel
        Its invariants.
    felt : (nt, 3) array
        Gravity, resolved in the body frame, m/s2.
    q, v, a : (nt, 7 + n), (nt, 6 + n), (nt, 6 + n) array
        ``[R e p]``, ``[R' w p']`` and ``[R'' w' p'']`` with R' and R'' resolved in the body frame.

    Returns
    -------
    dict of str to (nt, 6 + n) array
        Force, N, moment about the origin of the body frame, N m, and modal forces, kg^0.5 m/s2,
        body frame; a kind that the body cannot have is missing.
    """
    p, dp, ddp = q[:, 7:], v[:, 6:], a[:, 6:]
    velocity, w, A, dw = v[:, :3], v[:, 3:6], a[:, :3], a[:, 3:6]
    mass = float(np.real(body.mass[0]))
    S0, J0, I3, B0, D0, ED, EB = (
        np.real(getattr(body, name)) for name in ("S0", "J0", "I3", "B0", "D0", "ED", "EB")
    )
    # moments of mass at p
    S = S0 + p @ I3.T
    D = D0 + np.einsum("cjk,tk->tcj", ED, p, optimize=True)
    B = B0 + np.einsum("cjk,tk->tcj", EB, p, optimize=True)
    J = symmetric(J0 + np.einsum("tcj,tj->tc", D0 + D, p))
    # velocities of the deformation: momentum, its moment, half of J'
    Ip, Bp = dp @ I3.T, np.einsum("tcj,tj->tc", B, dp)
    G = np.einsum("cjk,tk->tcj", EB, dp, optimize=True)
    Jd = symmetric(np.einsum("tcj,tj->tc", D, dp))
    wS, Jw = np.cross(w, S), times(J, w)
    found = {
        GRAVITY: stacked(mass * felt, np.cross(S, felt), felt @ I3),
        INERTIA: -stacked(
            mass * A + np.cross(dw, S) + ddp @ I3.T,
            np.cross(S, A) + times(J, dw) + np.einsum("tcj,tj->tc", B, ddp),
            A @ I3 + np.einsum("tcj,tc->tj", B, dw) + ddp,
        ),
        SPIN: stacked(-np.cross(w, wS), -np.cross(w, Jw), np.einsum("tcj,tc->tj", D, products(w))),
    }
    if body.n:
        found[CORIOLIS] = stacked(
            -2.0 * np.cross(w, Ip),
            -np.cross(w, Bp) - 2.0 * times(Jd, w),
            -2.0 * np.einsum("tcj,tc->tj", G, w),
        )
        none = np.zeros((len(q), 3))
        found[ELASTIC] = stacked(none, none, -np.real(body.K) * p)
        found[DAMPING] = stacked(none, none, -np.real(body.D) * dp)
    alpha = float(np.real(body.alpha))
    if alpha:
        momentum, spin = mass * velocity + wS, Jw + np.cross(S, velocity)
        found[DAMPING] = stacked(-alpha * momentum, -alpha * spin, np.zeros((len(q), 0)))
    return found


def stacked(force: Array, moment: Array, modal: Array) -> Array:
    """Return force, moment and modal forces as one array (nt, 6 + n)."""
    return np.concatenate([force, moment, modal], axis=1)


def times(T: Array, x: Array) -> Array:
    """Return the products (nt, 3) of tensors and vectors."""
    return np.asarray(np.einsum("tij,tj->ti", T, x))


def symmetric(x: Array) -> Array:
    """Return tensors (nt, 3, 3) from their components xx yy zz yz xz xy."""
    return np.asarray(x[:, [[0, 5, 4], [5, 1, 3], [4, 3, 2]]])


def products(w: Array) -> Array:
    """Return products (nt, 6) of components of w for xx yy zz yz xz xy in ``w . D w``."""
    x, y, z = w.T
    return np.stack([x * x, y * y, z * z, 2 * y * z, 2 * x * z, 2 * x * y], axis=1)
