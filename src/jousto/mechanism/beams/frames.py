"""Geometry of a beam: section frames along a line of nodes, and strains of elements.

Section frames have the columns [x along the beam, y, z]. All vectors are resolved in the frame of
the points.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jousto.base.arrays import Array, skew
from jousto.base.rotations import exp_rotation


def tangents(points: Array, corners: Sequence[int] = ()) -> Array:
    """Return unit tangents at both ends of every element, (n, 2, 3).

    The circle through three nodes defines the tangent at the middle node (exact on arcs). At the
    ends of the line and at corners the tangent is the mirror image of that at the other end of the
    element.
    """
    chords = np.diff(points, axis=0)
    length = np.linalg.norm(chords, axis=1)
    u = chords / length[:, None]
    n = len(u)
    at = np.zeros((n, 2, 3))
    inner = length[1:, None] * u[:-1] + length[:-1, None] * u[1:]
    long = np.linalg.norm(inner, axis=1, keepdims=True)
    inner = inner / np.where(long > 0, long, 1.0)
    at[1:, 0], at[:-1, 1] = inner, inner
    cut = sorted({0, n, *corners})
    for first, last in zip(cut[:-1], cut[1:], strict=True):
        if last == first + 1:  # a single element between two corners is straight
            at[first] = u[first]
            continue
        at[first, 0] = 2 * (u[first] @ at[first, 1]) * u[first] - at[first, 1]
        at[last - 1, 1] = 2 * (u[last - 1] @ at[last - 1, 0]) * u[last - 1] - at[last - 1, 0]
    return at


def smallest_turn(a: Array, b: Array) -> Array:
    """Return the smallest rotation (3, 3) from the unit vector a to the unit vector b."""
    v, c = np.cross(a, b), float(a @ b)
    V = skew(v)
    return np.eye(3) + V + V @ V / (1.0 + c)


def section_frames(along: Array, up: Array, twist: Array) -> Array:
    """Return the section frames (n, 2, 3, 3) at both ends of every element.

    Parameters
    ----------
    along : (n, 2, 3) array
        Unit tangents.
    up : (3,) or (n + 1, 3) array
        Direction near the z axis of the first section; the others follow by the smallest rotations
        of the tangent. With one row per node: the direction near the z axis of each section.
    twist : (n + 1,) array
        Additional rotation about the tangent at every node, rad.
    """
    n = len(along)
    frames = np.zeros((n, 2, 3, 3))
    Q = frame_of(along[0, 0], up if up.ndim == 1 else up[0])
    for i in range(n):
        for end in (0, 1):
            t = along[i, end]
            if up.ndim == 2:
                Q = frame_of(t, up[i + end])
            elif not np.array_equal(Q[:, 0], t):
                Q = smallest_turn(Q[:, 0], t) @ Q
                Q[:, 0] = t
                # remove the round-off of the transport
                Q[:, 2] -= t * (t @ Q[:, 2])
                Q[:, 2] /= np.linalg.norm(Q[:, 2])
                Q[:, 1] = np.cross(Q[:, 2], t)
            frames[i, end] = Q
    if np.any(twist):
        c, s = np.cos(twist), np.sin(twist)
        turn = np.zeros((n + 1, 3, 3))
        turn[:, 0, 0], turn[:, 1, 1], turn[:, 2, 2] = 1.0, c, c
        turn[:, 1, 2], turn[:, 2, 1] = -s, s
        frames[:, 0] = frames[:, 0] @ turn[:-1]
        frames[:, 1] = frames[:, 1] @ turn[1:]
    return frames


def frame_of(x: Array, up: Array) -> Array:
    """Return the frame (3, 3) with x along a unit vector and z near `up`; NaN if parallel."""
    y = np.cross(up, x)
    sine = float(np.linalg.norm(y)) / max(float(np.linalg.norm(up)), 1e-300)
    if sine < 1e-6:
        return np.full((3, 3), np.nan)
    y = y / np.linalg.norm(y)
    return np.stack([x, y, np.cross(x, y)], axis=1)


def rotation_vectors(A: Array) -> Array:
    """Return the rotation vectors (n, 3) of rotation matrices (n, 3, 3), |phi| <= pi."""
    # half the axial vector is sin(phi) n; the trace is 1 + 2 cos(phi)
    axial = 0.5 * np.stack(
        [A[:, 2, 1] - A[:, 1, 2], A[:, 0, 2] - A[:, 2, 0], A[:, 1, 0] - A[:, 0, 1]], axis=1
    )
    sine = np.linalg.norm(axial, axis=1)
    cosine = 0.5 * (np.trace(A, axis1=1, axis2=2) - 1.0)
    angle = np.arctan2(sine, cosine)
    small = sine < 1e-8
    factor = np.where(small, 1.0, angle / np.where(small, 1.0, sine))
    out = np.asarray(factor[:, None] * axial)
    for i in np.flatnonzero((sine < 1e-3) & (cosine < 0)):  # near half a turn
        S = 0.5 * (A[i] + A[i].T) + np.eye(3)
        column = S[:, int(np.argmax(np.diag(S)))]
        axis = column / np.linalg.norm(column)
        out[i] = angle[i] * axis * (1.0 if axis @ axial[i] >= 0 else -1.0)
    return out


def strains(r: Array, Q: Array, length: Array, *, helical: bool = False) -> Array:
    """Return ``[Q_m^T (r_b - r_a)/L - e1, phi/L]`` (n, 6) of elements.

    Parameters
    ----------
    r : (n, 2, 3) array
        Ends of the elements' axes, m.
    Q : (n, 2, 3, 3) array
        Frames of the ends.
    length : (n,) array
        Unstressed lengths, m.
    helical : bool
        Whether the axis is a helix between the ends, longer than its chord: the part of Gamma + e1
        perpendicular to the rotation vector is multiplied by ``h / sin h``, ``h = |phi|/2``.

    Returns
    -------
    (n, 6) array
        Gamma, m/m, and kappa, rad/m, in the frame half way between the ends.
    """
    phi = rotation_vectors(np.swapaxes(Q[:, 0], 1, 2) @ Q[:, 1])
    half = np.stack([exp_rotation(0.5 * x) for x in phi])
    middle = Q[:, 0] @ half
    gamma = np.einsum("nji,nj->ni", middle, (r[:, 1] - r[:, 0]) / length[:, None])
    if helical:
        h = 0.5 * np.linalg.norm(phi, axis=1, keepdims=True)
        axis = phi / np.where(h > 0.0, 2.0 * h, 1.0)
        along = axis * np.sum(axis * gamma, axis=1, keepdims=True)
        gamma = along + (gamma - along) / np.sinc(h / np.pi)
    gamma[:, 0] -= 1.0
    return np.concatenate([gamma, phi / length[:, None]], axis=1)


def arc_lengths(r: Array, Q: Array) -> Array:
    """Return the lengths (n,) of arcs through the elements' ends: chord x (h / sin h).

    h is half of the bending angle between the frames of the two ends.
    """
    phi = rotation_vectors(np.swapaxes(Q[:, 0], 1, 2) @ Q[:, 1])
    half = 0.5 * np.linalg.norm(phi[:, 1:], axis=1)
    chord = np.linalg.norm(r[:, 1] - r[:, 0], axis=1)
    return np.asarray(chord / np.sinc(half / np.pi))
