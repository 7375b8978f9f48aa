"""same_motion: converts the state of a body to another reference condition."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array, skew
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.rotations import euler_parameters, exp_rotation, rotation_matrix
from jousto.reduction.modes.rigid import length_scale
from jousto.reduction.reduced import ReducedPart

SPANNED = 1e-6
"""Largest part of a mode outside of the modes of the other frame / size of the mode."""


@explained
def same_motion(
    old: ReducedPart, new: ReducedPart, q: ArrayLike, v: ArrayLike
) -> tuple[Array, Array]:
    """Return the coordinates and velocities of a body relative to another of its frames.

    With ``phi_j = sum_k phi'_k T_kj + t_j + theta_j x u0``: ``R' = R + A t p``,
    ``A' = A exp(theta p~)``, ``p' = T p`` and their time derivatives. All nodes then have the same
    motion to first order in the deformation; the error is of the order of the products ``theta p x
    Phi' p'``, (deflection / length)^2.

    Parameters
    ----------
    old, new : ReducedPart
        The same modes relative to two frames, such as a part and the result of `in_frame`.
    q : (7 + n,) array_like
        ``[R, e, p]`` of the old body: m, Euler parameters, kg^0.5 m.
    v : (6 + n,) array_like
        ``[R', w, p']``: m/s in the world, rad/s in the body frame, kg^0.5 m/s.

    Returns
    -------
    tuple of arrays
        q and v of the new body.

    Raises
    ------
    InputError
        If shapes are wrong, or the modes are not those of the other part.

    Examples
    --------
    >>> import jousto as jo
    >>> from jousto.reduction import NodeFrame, in_frame
    >>> steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    >>> part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 8, steel)
    >>> rod = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2))
    >>> held = in_frame(rod, NodeFrame("start"))
    >>> q = np.r_[0, 0, 0, 1, 0, 0, 0, 1e-3 * np.ones(rod.n)]
    >>> moved, _ = same_motion(rod, held, q, np.zeros(6 + rod.n))
    >>> start = rod.nodes[rod.node("start")] + rod.modes[rod.node("start")] @ q[7:]
    >>> np.allclose(moved[:3], start, atol=1e-6)
    True
    """
    where = f"reduced part '{new.name}'"
    problems = Problems()
    state = problems.array(where, "q", q, (7 + old.n,))
    rate = problems.array(where, "v", v, (6 + old.n,))
    problems.raise_if_any()
    assert state is not None and rate is not None
    t, theta, T = relative_motion(old, new, where)
    A, p, dp = rotation_matrix(state[3:7]), state[7:], rate[6:]
    turn, spin = theta @ p, theta @ dp
    B = exp_rotation(turn)
    w = B.T @ rate[3:6] + _turning(turn) @ spin
    R = state[:3] + A @ (t @ p)
    dR = rate[:3] + A @ (np.cross(rate[3:6], t @ p) + t @ dp)
    moved = np.concatenate([R, euler_parameters(A @ B), T @ p])
    return moved, np.concatenate([dR, w, T @ dp])


def relative_motion(old: ReducedPart, new: ReducedPart, where: str) -> tuple[Array, Array, Array]:
    """Return t, theta (3, n) and T (n', n), which express the old modes by the new ones."""
    same = old.nodes.shape == new.nodes.shape and np.allclose(old.nodes, new.nodes)
    if not same:
        raise InputError(Problem(where, f"has other nodes than reduced part '{old.name}'"))
    length = length_scale(new.nodes)
    middle = new.nodes.mean(axis=0)
    arms = np.stack([np.cross(e, new.nodes - middle) for e in np.eye(3)], axis=2) / length
    shifts = np.broadcast_to(np.eye(3), arms.shape)
    rows = [np.concatenate([new.modes, shifts, arms], axis=2)]
    wanted = [old.modes]
    if new.rotations is not None and old.rotations is not None:
        still = np.zeros((len(new.rotations), 3, 3))
        rows.append(np.concatenate([length * new.rotations, still, still + np.eye(3)], axis=2))
        wanted.append(length * old.rotations)
    basis = np.concatenate(rows).reshape(-1, new.n + 6)
    modes = np.concatenate(wanted).reshape(-1, old.n)
    size = np.linalg.norm(basis, axis=0)
    c = np.linalg.lstsq(basis / size, modes, rcond=1e-14)[0] / size[:, None]
    if np.linalg.norm(basis @ c - modes) > SPANNED * np.linalg.norm(modes):
        message = (
            f"does not contain the modes of reduced part '{old.name}': both must be the same "
            f"reduction relative to two frames"
        )
        raise InputError(Problem(where, message))
    theta = c[new.n + 3 :] / length
    t = c[new.n : new.n + 3] - np.cross(theta, middle, axisa=0, axisc=0)
    return t, theta, c[: new.n]


def _turning(turn: Array) -> Array:
    """Return the matrix from the rate of a rotation vector to angular velocity, rotated frame."""
    a, W = float(np.linalg.norm(turn)), skew(turn)
    b = 0.5 * np.sinc(a / (2.0 * np.pi)) ** 2
    c = 1.0 / 6.0 - a**2 / 120.0 if a < 1e-2 else (a - np.sin(a)) / a**3
    return np.asarray(np.eye(3) - b * W + c * (W @ W))
