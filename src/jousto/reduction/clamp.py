"""clamp: the same flexible body seen from a frame that sits on one of its nodes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.linalg as la

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.reduction.fields.invariants import EPS, Invariants
from jousto.reduction.reduced import ReducedPart


@explained
def clamp(reduced: ReducedPart, node: str) -> ReducedPart:
    """Return the part held at a node: modes that vanish there, frequencies of the clamped part.

    From every mode the rigid motion is taken that the node makes in it,
    ``phi'_j = phi_j - t_j - theta_j x (u0 - s)`` with translation t and rotation theta of the node
    at s, and the modes are made orthonormal again with the mass they then move,
    ``K V = M' V diag(omega^2)``. The body and what it can do are the same; only the frame now
    follows the node (tangent frame) instead of the mean motion. The stress of a deformation is
    the same in both.

    Parameters
    ----------
    reduced : ReducedPart
        From `reduce`, with the node among its interfaces if its clamped modes shall be right.
    node : str
        Name of a node that turns: an interface, a set of one node or ``"node7"``.

    Returns
    -------
    ReducedPart
        With as many modes, in the order of the clamped frequencies; without stiffening.

    Raises
    ------
    InputError
        If there is no such node, or it does not turn.

    Examples
    --------
    A steel cantilever of 20 x 10 mm; slender beam theory gives 8.3552 Hz:

    >>> import jousto as jo
    >>> steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    >>> part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 20, steel)
    >>> rod = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=6))
    >>> jo.reduction.clamp(rod, "start").frequencies[0].round(2)
    np.float64(8.35)
    """
    k = reduced.node(node)
    turn = reduced.rotation(k)
    if turn is None:
        raise InputError(
            Problem(
                f"reduced part '{reduced.name}'",
                f"node '{node}' has no rotation, so it cannot hold the part; name an interface",
            )
        )
    s, t = reduced.nodes[k], reduced.modes[k]
    # theta_j x as matrices (n, 3, 3); the rigid motion at the frame's origin, d = theta x s - t
    cross = np.einsum("abc,bj->jac", EPS, turn)
    d = (np.einsum("jab,b->ja", cross, s) - t.T).T
    I = reduced.invariants
    held = _shifted(I, d, cross)
    # motions that move no mass have the modal mass 1 all the same
    mass = held.I6 + np.eye(reduced.n) - I.I6
    stiffness, V = la.eigh(np.diag(reduced.stiffness), 0.5 * (mass + mass.T))
    modes = reduced.modes + d - np.einsum("jab,kb->kaj", cross, reduced.nodes)
    rotations = reduced.rotations
    return replace(
        reduced,
        modes=modes @ V,
        rotations=None if rotations is None else (rotations - turn) @ V,
        frequencies=np.sqrt(stiffness) / (2.0 * np.pi),
        invariants=_combined(held, V),
        stress=None if reduced.stress is None else reduced.stress.combined(V),
        stiffening=None,
        provenance={**reduced.provenance, "clamped": node},
    )


def _shifted(I: Invariants, d: Array, cross: Array) -> Invariants:
    """Return the invariants of the modes ``phi_j + d_j - theta_j x u0``."""
    first, second = I.first_moment, I.second_moment
    N_cross = np.einsum("jba,kcb->jkac", I.N0, cross)  # N0_j^T theta_k~^T
    E = (
        I.E
        + np.einsum("aj,bk->jkab", I.I3, d)
        - N_cross
        + np.einsum("aj,bk->jkab", d, I.I3)
        + I.mass * np.einsum("aj,bk->jkab", d, d)
        - np.einsum("aj,c,kbc->jkab", d, first, cross)
        - np.einsum("jac,kcb->jkab", cross, I.N0)
        - np.einsum("jac,c,bk->jkab", cross, first, d)
        + np.einsum("jac,cd,kbd->jkab", cross, second, cross)
    )
    return Invariants(
        mass=I.mass,
        first_moment=first,
        second_moment=second,
        I3=I.I3 + I.mass * d - np.einsum("jab,b->aj", cross, first),
        N0=I.N0 + np.einsum("a,bj->jab", first, d) - np.einsum("ac,jbc->jab", second, cross),
        E=0.5 * (E + E.transpose(1, 0, 3, 2)),
    )


def _combined(I: Invariants, V: Array) -> Invariants:
    """Return the invariants of the modes ``sum_j phi_j V_jk``."""
    E = np.einsum("jkab,jl,km->lmab", I.E, V, V, optimize=True)
    return Invariants(
        mass=I.mass,
        first_moment=I.first_moment,
        second_moment=I.second_moment,
        I3=I.I3 @ V,
        N0=np.einsum("jab,jl->lab", I.N0, V),
        E=0.5 * (E + E.transpose(1, 0, 3, 2)),
    )
