"""Stiffness of springs and other forces on a part, which vibrates alone without it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jousto.base.arrays import Array
from jousto.design.optimisation.component import SHARE, Component
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.recovery.shape import rotation_matrices


def stiffness_ratio(model: Model, k: int, q: Array, held: Component, F: Array) -> float:
    """Return the stiffness of forces on a part over that of the part, ``|s^T K_f s| / w2``.

    The largest ratio of the modes s of the held part that have a twentieth of the strain energy
    under the loads. K_f is the derivative of springs, bushings and other forces by the motion of
    the part, the other bodies at rest.

    Parameters
    ----------
    model : Model
        Flexible machine.
    k : int
        Index of the body.
    q : (nq,) array
        Positions at which the forces are linearised.
    held : Component
        Modes of the held part.
    F : (nt, 6 + n) array
        Loads on the part.
    """
    energy = ((F @ held.shapes) ** 2 / held.w2).max(axis=0)
    if not energy.any():
        return 0.0
    bent = energy >= SHARE * energy.sum()
    s = held.shapes[:, bent]
    own = np.abs(np.einsum("ij,ik,kj->j", s, force_stiffness(model, k, q), s))
    return float(np.max(own / held.w2[bent], initial=0.0))


def force_stiffness(model: Model, k: int, q: Array) -> Array:
    """Return K_f (6 + n, 6 + n) for ``[R (body frame), rotation, p]`` of a body at rest."""
    engine = Engine(replace(model, tree=()))
    engine.q[:] = q
    engine.v[:] = 0.0
    body = model.bodies[k]
    at = slice(body.iv, body.iv + 6 + body.n)
    K = np.array(np.real(engine.newton_matrix(0.0, 0.0, 1.0)[at, at]))
    A = rotation_matrices(np.real(engine.q[body.iq + 3 : body.iq + 7])[None])[0]
    K[:3] = A.T @ K[:3]
    K[:, :3] = K[:, :3] @ A
    # without the stiffness of the part itself
    modes = range(6, 6 + body.n)
    K[modes, modes] -= np.real(body.K)
    return K
