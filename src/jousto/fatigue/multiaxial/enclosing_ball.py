"""Smallest enclosing circles and balls, exact."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from jousto.base.arrays import Array

SLACK = 1e-10  # relative distance outside a circle or ball, below which a point is inside
PAIRS = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
TRIPLES = ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3))


def enclosing_circles(points: Array) -> tuple[Array, Array]:
    """Return centres (m, 2) and radii (m,) of the smallest circles around m sets of points.

    The smallest circle around four points is exact: it passes through two or three of them. The
    point farthest outside is added to these until no point is outside; the iteration ends because
    the radius grows in every step.

    Parameters
    ----------
    points : (m, nt, 2) array
    """
    m, nt, _ = points.shape
    if nt == 0:
        return np.zeros((m, 2)), np.zeros(m)
    size = np.abs(points).max(axis=(1, 2))
    size = np.where(size > 0.0, size, 1.0)
    P = points / size[:, None, None]
    rows = np.arange(m)
    far = np.argmax(np.sum((P - P[:, :1]) ** 2, axis=2), axis=1)
    support = np.stack([P[:, 0], P[rows, far], P[rows, far]], axis=1)
    centre = 0.5 * (support[:, 0] + support[:, 1])
    radius = 0.5 * np.linalg.norm(support[:, 0] - support[:, 1], axis=1)
    live = rows
    for _ in range(10 * nt + 10):
        gap = np.sum((P[live] - centre[live, None]) ** 2, axis=2)
        out = np.argmax(gap, axis=1)
        beyond = np.sqrt(gap[np.arange(len(live)), out]) > radius[live] + SLACK
        live, out = live[beyond], out[beyond]
        if not len(live):
            break
        four = np.concatenate([support[live], P[live, out][:, None]], axis=1)
        support[live], centre[live], radius[live] = _of_four(four)
    return centre * size[:, None], radius * size


def _of_four(four: Array) -> tuple[Array, Array, Array]:
    """Return support (m, 3, 2), centre and radius of the smallest circles around four points."""
    m = len(four)
    centres, radii, supports = [], [], []
    for i, j in PAIRS:
        a, b = four[:, i], four[:, j]
        centres.append(0.5 * (a + b))
        radii.append(0.5 * np.linalg.norm(a - b, axis=1))
        supports.append(np.stack([a, b, b], axis=1))
    for triple in TRIPLES:
        a, b, c = (four[:, k] for k in triple)
        ab, ac = b - a, c - a
        det = 2.0 * (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0])
        flat = np.abs(det) < 1e-14
        det = np.where(flat, 1.0, det)
        lb, lc = np.sum(ab * ab, axis=1), np.sum(ac * ac, axis=1)
        x = (ac[:, 1] * lb - ab[:, 1] * lc) / det
        y = (ab[:, 0] * lc - ac[:, 0] * lb) / det
        offset = np.stack([x, y], axis=1)
        centres.append(a + offset)
        radii.append(np.where(flat, np.inf, np.linalg.norm(offset, axis=1)))
        supports.append(np.stack([a, b, c], axis=1))
    C, R = np.stack(centres, axis=1), np.stack(radii, axis=1)
    reach = np.linalg.norm(four[:, None] - C[:, :, None], axis=3).max(axis=2)
    R = np.where(reach <= R + 0.1 * SLACK, R, np.inf)
    # if round-off leaves no circle around all four points: centre with the smallest maximum
    # distance
    lost = np.isinf(R).all(axis=1)
    R[lost] = reach[lost]
    best = np.argmin(R, axis=1)
    rows = np.arange(m)
    return np.stack(supports, axis=1)[rows, best], C[rows, best], R[rows, best]


def enclosing_ball(points: Array) -> tuple[Array, float]:
    """Return centre (d,) and radius of the smallest ball around points (nt, d), exact.

    At most d + 1 points determine the ball. In each step the farthest point outside is added to
    them, and the smallest ball through a subset that encloses all of them is the next one.
    """
    size = float(np.abs(points).max()) if points.size else 0.0
    if size == 0.0:
        return np.zeros(points.shape[1]), 0.0
    P = points / size
    support = P[:1]
    centre, radius = support[0], 0.0
    for _ in range(10 * len(P) + 10):
        gap = np.linalg.norm(P - centre, axis=1)
        out = int(np.argmax(gap))
        if gap[out] <= radius + SLACK:
            break
        support, centre, radius = _of_few(np.concatenate([support, P[out : out + 1]]))
    return centre * size, radius * size


def _of_few(points: Array) -> tuple[Array, Array, float]:
    """Return support, centre and radius of the smallest ball around a few points."""
    best = (points, points[0], np.inf)
    for k in range(2, len(points) + 1):
        for chosen in combinations(range(len(points)), k):
            S = points[list(chosen)]
            A = S[1:] - S[0]
            G = 2.0 * A @ A.T
            if np.linalg.matrix_rank(G, tol=1e-13) < k - 1:
                continue
            weights = np.linalg.solve(G, np.sum(A * A, axis=1))
            # a centre outside the simplex belongs to a smaller subset
            if weights.min() < -1e-9 or weights.sum() > 1.0 + 1e-9:
                continue
            centre = S[0] + weights @ A
            radius = float(np.linalg.norm(weights @ A))
            reach = np.linalg.norm(points - centre, axis=1).max()
            if radius < best[2] and reach <= radius + 0.5 * SLACK:
                best = (S, centre, radius)
        if np.isfinite(best[2]):
            break
    return best
