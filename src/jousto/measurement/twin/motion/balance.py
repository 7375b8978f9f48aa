"""Balance of loads and motion of a part: Newton's and Euler's equations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, warn
from jousto.measurement.twin.motion.reference import Reference
from jousto.reduction.fields.invariants import EPS, Invariants
from jousto.reduction.reduced import ReducedPart

WARNED, REFUSED = 0.01, 0.1
"""Relative rms of the missing load: stress is doubtful above the first value, and wrong above the
second."""

ROUNDING = 1e-9
"""Share of the largest component below which a component is zero."""

Load = tuple[int, Array, Array]
"""Node index, and force (nt, 3) and moment (nt, 3) on it, body frame."""


def inertia_wrench(
    invariants: Invariants, reference: Reference, p: Array, dp: Array, ddp: Array
) -> tuple[Array, Array, Array]:
    """Return force and moment about the mass centre that a motion requires, and the centre.

    With ``u = u0 + Phi p``, ``F = int u'' dm`` and ``M = int u x u'' dm``, where ``u'' = a + w' x u
    + w x (w x u) + 2 w x Phi p' + Phi p''`` and a is the acceleration of the frame minus gravity; M
    is then taken about the mass centre.

    Parameters
    ----------
    invariants : Invariants
        Inertia invariants of the part.
    reference : Reference
        Motion of its frame at nt instants.
    p, dp, ddp : (nt, n) array
        Modal coordinates, velocities and accelerations.

    Returns
    -------
    force, moment, centre : (nt, 3) array
        Body frame, N, N m and m.
    """
    I, a, w, dw = invariants, reference.acceleration, reference.w, reference.dw
    S = I.first_moment + p @ I.I3.T  # int u dm
    # int u phi_j^T dm, contracted with p, p' and p''
    N, V, W = (np.einsum("tj,jab->tab", x, I.N0) for x in (p, dp, ddp))
    Epp, Epv, Epa = (np.einsum("tk,tj,kjab->tab", p, x, I.E, optimize=True) for x in (p, dp, ddp))
    U = I.second_moment + N + np.swapaxes(N, 1, 2) + Epp
    V, W = V + Epv, W + Epa
    force = I.mass * a + np.cross(dw, S) + np.cross(w, np.cross(w, S))
    force += 2.0 * np.cross(w, dp @ I.I3.T) + ddp @ I.I3.T

    def turned(x: Array) -> Array:
        return np.asarray(np.einsum("taa,tb->tb", U, x) - np.einsum("tab,tb->ta", U, x))

    moment = np.cross(S, a) + turned(dw) + np.cross(w, turned(w))
    moment += 2.0 * (np.einsum("taa,tb->tb", V, w) - np.einsum("tab,ta->tb", V, w))
    moment += np.einsum("abc,tbc->ta", EPS, W)
    centre = S / I.mass
    return force, moment - np.cross(centre, force), centre


def check_balance(
    reduced: ReducedPart,
    reference: Reference,
    loads: Sequence[Load],
    A: Array,
    motion: tuple[Array, Array, Array],
) -> None:
    """Return the comparison of loads with the forces that the motion of a part requires.

    Parameters
    ----------
    reduced : ReducedPart
        The part.
    reference : Reference
        Motion of its frame.
    loads : sequence of Load
        All loads on the part except its weight.
    A : (nt, 3, 3) array
        Rotation of the frame.
    motion : tuple of three (nt, n) array
        Modal coordinates, velocities and accelerations.

    Raises
    ------
    InputError
        If more than a tenth of the loads is missing.

    Warns
    -----
    JoustoWarning
        If more than a hundredth is missing.
    """
    force, moment, centre = inertia_wrench(reduced.invariants, reference, *motion)
    size, turning = np.linalg.norm(force, axis=1), np.linalg.norm(moment, axis=1)
    for node, f, m in loads:
        r = reduced.nodes[node] + motion[0] @ reduced.modes[node].T - centre
        force = force - f
        moment = moment - m - np.cross(r, f)
        size = size + np.linalg.norm(f, axis=1)
        turning = turning + np.linalg.norm(m, axis=1)
    # lever arm of moments beside forces: distance of the farthest node
    arm = float(np.linalg.norm(reduced.nodes - centre[0], axis=1).max())
    shares = [
        _rms(np.linalg.norm(x, axis=1)) / (_rms(scale) or 1.0)
        for x, scale in ((force, size), (moment, arm * size + turning))
    ]
    if max(shares) <= WARNED:
        return
    worst = (force, moment)[int(np.argmax(shares))]
    k = int(np.argmax(np.linalg.norm(worst, axis=1)))
    names = ("force", "N", force, shares[0]), ("moment", "N m", moment, shares[1])
    missing = " and ".join(
        f"a {name} of ({_numbers(A[k] @ x[k])}) {unit}"
        for name, unit, x, share in names
        if share > WARNED
    )
    message = (
        f"the loads do not balance: at {reference.time[k]:g} s the motion of the part needs "
        f"{missing} more (world axes, about the mass centre), {max(shares):.0%} of all loads; give "
        "all that acts on it but its weight, also motors, drives, springs and friction, with the "
        "sign of what acts on this body; or its mass is not that of the body, or the output step "
        "is too long for accelerations"
    )
    if max(shares) > REFUSED:
        raise InputError(Problem("drive_part", message))
    warn("drive_part", message)


def _numbers(x: Array) -> str:
    """Return components, with zero in place of rounding errors."""
    return ", ".join(f"{v:.4g}" if abs(v) > ROUNDING * np.abs(x).max() else "0" for v in x)


def _rms(x: Array) -> float:
    return float(np.sqrt(np.mean(x * x)))
