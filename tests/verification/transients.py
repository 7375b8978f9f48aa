"""Brute force: every degree of freedom of a clamped mesh in inertial coordinates, step by step.

Nothing of flexible multibody theory is used: no modes, no floating frame, no inertia forces of a
moving frame. The unknowns are world positions r of the nodes,

    M r'' + A K (A^T r - x) = F,    r = A x and r'' = A'' x at the clamp,

with the prescribed rotation A(t) of the clamp about the world's origin and the nodes x at rest.
The consistent mass matrix of solids is ``m kron I3``, so it stands before and after a turn alike.
Newmark's average acceleration, whose matrix ``4/h2 M + K`` is one and the same at every step when
the unknowns of a step are turned into the clamp's frame; error of order h2, so two steps give an
extrapolated solution and what is left of the error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

Array = np.ndarray
Angle = Callable[[float], tuple[float, float, float]]


@dataclass(frozen=True)
class Mesh:
    """Matrices (3 nn, 3 nn), nodes (nn, 3) and the nodes held by the clamp."""

    M: Any
    K: Any
    nodes: Array
    clamp: Array


def still(_: float) -> tuple[float, float, float]:
    """Return angle, rate and acceleration of a clamp at rest."""
    return 0.0, 0.0, 0.0


def newmark(
    mesh: Mesh,
    load: Callable[[float], Array],
    h: float,
    times: Array,
    *,
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0),
    angle: Angle = still,
) -> Array:
    """Return the displacements (nt, 3 nn) in the clamp's frame at times that are multiples of h.

    Parameters
    ----------
    mesh : Mesh
        What is clamped; at rest at time 0.
    load : callable
        Nodal forces (3 nn,) in world axes at a time; zero at time 0.
    h : float
        Step, s.
    times : (nt,) array
        When, s.
    axis, angle
        The clamp turns about this axis through the origin by ``angle(t) = (angle, rate, rate')``.
    """
    x = mesh.nodes
    held = np.isin(np.arange(len(x)), mesh.clamp)
    free = np.repeat(~held, 3)
    M, K = (sp.csc_array(B)[free][:, free] for B in (mesh.M, mesh.K))
    M_c = sp.csr_array(mesh.M)[free][:, ~free]
    solve = splu(sp.csc_matrix(4.0 / h**2 * M + K)).solve
    n = np.array(axis) / np.linalg.norm(axis)
    wanted = np.rint(times / h).astype(int)
    assert np.allclose(wanted * h, times, rtol=0.0, atol=1e-6 * h)

    out = np.zeros((len(times), x.size))
    x_f, x_c = x[~held], x[held]
    r, v, a = x_f.copy(), np.zeros_like(x_f), np.zeros_like(x_f)
    for k in range(1, wanted[-1] + 1):
        t = k * h
        turn, rate, change = angle(t)
        A = Rotation.from_rotvec(turn * n).as_matrix()
        # acceleration of the clamp in its own axes
        a_c = change * np.cross(n, x_c) + rate**2 * np.cross(n, np.cross(n, x_c))
        guess = r + h * v + 0.25 * h**2 * a
        right = (load(t).reshape(-1, 3)[~held] @ A).ravel() - M_c @ a_c.ravel()
        right += M @ ((4.0 / h**2) * (guess @ A - x_f)).ravel()
        u = solve(right).reshape(-1, 3)
        new = (x_f + u) @ A.T
        a_new = (4.0 / h**2) * (new - guess)
        v = v + 0.5 * h * (a + a_new)
        r, a = new, a_new
        for i in np.flatnonzero(wanted == k):
            out[i, free] = u.ravel()
    return out


def extrapolated(run: Callable[[float], Array], h: float) -> tuple[Array, Array]:
    """Return ``(4 run(h/2) - run(h)) / 3`` and ``run(h/2)``, whose error is the larger one."""
    coarse, fine = run(h), run(h / 2.0)
    return (4.0 * fine - coarse) / 3.0, fine
