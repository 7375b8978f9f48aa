"""Springs that are too soft beside a part, because rounding errors of its stiffness hide them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.linalg as la

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.reduction.supports.mechanism import name_of_motion, reduced_rows
from jousto.reduction.supports.restraints import RigidSupport
from jousto.reduction.supports.support import Support
from jousto.reduction.supports.system import System

# stiffness of supports relative to the sum of K_ii in a rigid motion, below which supports are
# refused: five times `LOOSE` of the factorisation; rounding errors of K of 1e-16 are then 0.1 % of
# that stiffness
LEAST = 1e-13
SHOWN = 3  # springs that a message names
SHARE = 0.01  # share of a spring in the stiffness of a motion, above which it is named


def check_softness(
    system: System, supports: Sequence[Support], support: RigidSupport, R: Array
) -> None:
    """Raise InputError for rigid motions whose supports are softer than rounding errors of K.

    With ``S`` the stiffness of the supports and ``Q = R^T diag(K_ii) R``, both (6, 6) in the rigid
    motions R, rounding errors of ``K R = 0`` are ``eps a^T Q a`` in the motion a. Motions with
    ``a^T S a < 1e-13 a^T Q a`` are refused.
    """
    Q = R.T @ (system.K.diagonal()[:, None] * R)
    if not Q.any():
        return
    # if no node has stiffness in a motion, its stiffness is that of rounding errors
    Q += 1e-15 * np.trace(Q) * np.eye(6)
    C = la.cholesky(Q, lower=True)
    # S = F^T F in b = C^T a, for which Q is the identity; stiffness is at most Q, since larger
    # values would round off the others
    W = la.solve_triangular(C, support.rows.T, lower=True).T
    least = np.minimum(support.stiffness, 1.0 / np.maximum((W**2).sum(axis=1), 1.0 / Q.max()))
    F = np.sqrt(least)[:, None] * W
    _, s, V = la.svd(np.linalg.qr(F, mode="r"))
    soft = V[s**2 < LEAST]
    if not len(soft):
        return
    # as few rotations as possible in each motion, as in messages on mechanisms
    rows = reduced_rows(np.roll(la.solve_triangular(C.T, soft.T).T, 3, axis=1))
    springs = support.owners >= 0
    found, shares = [], np.zeros(len(supports))
    for row in rows:
        b = C.T @ np.roll(row, 3)
        forces = (F @ b) ** 2
        # clamps are rigid, even if they are close together
        if forces[springs].sum() < SHARE * forces.sum():
            continue
        np.maximum.at(shares, support.owners[springs], forces[springs] / forces.sum())
        name = name_of_motion(row, system.center, system.length)
        turning = not name.startswith("translation")
        size = np.linalg.norm(row[:3]) / system.length if turning else np.linalg.norm(row[3:])
        unit = "N m/rad" if turning else "N/m"
        held, needed = forces.sum() / size**2, LEAST * (b @ b) / size**2
        found.append(f"the {name} with {held:.3g} {unit}, must be at least {needed:.3g} {unit}")
    if not found:
        return
    names = [
        f"{type(one).__name__} on {one.label}"
        for one, share in zip(supports, shares, strict=True)
        if share > SHARE
    ]
    several, more = len(names) > 1, len(names) - SHOWN
    if more > 0:
        names[SHOWN:] = [f"{more} more"]
    message = (
        f"{' and '.join(names)} {'are' if several else 'is'} too soft beside the part, whose "
        f"stiffness has rounding errors of this size: {'they hold' if several else 'it holds'} "
        f"{'; '.join(found)}; use stiffer springs, or hold further directions or nodes"
    )
    raise InputError(Problem(system.where, message))
