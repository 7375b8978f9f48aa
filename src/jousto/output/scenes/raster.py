"""Rasterised triangles with a depth buffer: the nearest triangle at each sample."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from jousto.base.arrays import Array, Index

FINE = 2  # samples per pixel and direction, for smooth edges
MOST = 1 << 19  # samples per block
# depth levels; at the same level the later triangle wins, so that coplanar faces of two
# bodies do not mix
LEVELS = 1e7


def rasterize(corners: Array, shades: Array, width: int, height: int) -> Array:
    """Return a picture of triangles with the nearest one at each pixel.

    Parameters
    ----------
    corners : (k, 3, 3) array
        Right and up in pixels from the lower left corner of the picture, and nearness in any unit.
    shades : (k, 3, 4) array
        Colours of the corners, 0 to 1; between them they are interpolated.
    width, height : int
        Pixels.

    Returns
    -------
    (height, width, 4) array
        Red, green, blue and coverage, 0 to 1, the lowest row first. Edges are smooth: a pixel has
        the mean of its samples.
    """
    fine = np.where(np.isfinite(corners).all(axis=(1, 2), keepdims=True), corners, 0.0)
    fine = fine * np.array([FINE, FINE, 1.0])
    shares = _shares(fine)
    owner = _nearest(fine, shares, FINE * width, FINE * height)
    blocks = owner.reshape(height, FINE, width, FINE).transpose(0, 2, 1, 3)
    samples = blocks.reshape(height * width, FINE**2)
    picture = np.zeros((height * width, 4))
    # inside a triangle the pixel colour is the mean of its samples
    same = (samples == samples[:, :1]).all(axis=1)
    whole = np.flatnonzero(same & (samples[:, 0] >= 0))
    row, column = np.divmod(whole, width)
    middle = np.stack([column + 0.5, row + 0.5]) * float(FINE)
    picture[whole] = _colors(samples[whole, 0], middle, shares, shades)
    edge, number = np.nonzero(~same[:, None] & (samples >= 0))
    row, column = np.divmod(edge, width)
    at = np.stack([FINE * column + number % FINE, FINE * row + number // FINE])
    places = at.astype(np.float64) + 0.5
    found = _colors(samples[edge, number], places, shares, shades)
    found[:, :3] *= found[:, 3:]
    for k in range(4):
        picture[~same, k] = np.bincount(edge, found[:, k], len(picture))[~same] / FINE**2
    covered = ~same & (picture[:, 3] > 0.0)
    picture[covered, :3] /= picture[covered, 3:]
    return np.asarray(picture.reshape(height, width, 4))


def _shares(corners: Array) -> Array:
    """Return the barycentric coordinates as forms (k, 3, 3): s_i = f_i0 x + f_i1 y + f_i2."""
    a, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    # triangles seen edge-on have no finite forms
    area = np.where(area == 0.0, np.nan, area)
    second = np.stack([v[:, 1], -v[:, 0], v[:, 0] * a[:, 1] - v[:, 1] * a[:, 0]], axis=1)
    third = np.stack([-u[:, 1], u[:, 0], u[:, 1] * a[:, 0] - u[:, 0] * a[:, 1]], axis=1)
    others = np.stack([second, third], axis=1) / area[:, None, None]
    first = np.array([0.0, 0.0, 1.0]) - others.sum(axis=1)
    return np.concatenate([first[:, None], others], axis=1)


def _colors(triangle: Index, places: Array, shares: Array, shades: Array) -> Array:
    """Return the colours (n, 4) of triangles at places (2, n)."""
    forms = np.einsum("kij,kic->kjc", shares, shades)
    x, y = places[0][:, None], places[1][:, None]
    found = forms[triangle, 0] * x + forms[triangle, 1] * y + forms[triangle, 2]
    return np.asarray(np.clip(found, 0.0, 1.0))


def _nearest(corners: Array, shares: Array, width: int, height: int) -> Index:
    """Return the nearest triangle at each sample (height x width,), -1 without any."""
    owner = np.full(width * height, -1, dtype=np.intp)
    depth = np.full(width * height, -np.inf)
    if not len(corners):
        return owner
    forms = np.einsum("kij,ki->kj", shares, corners[:, :, 2])
    level = LEVELS / (np.ptp(corners[:, :, 2]) or 1.0)
    for triangle, row, low, count in _spans(corners, shares, width, height):
        samples = np.repeat(np.arange(len(count)), count)
        column = np.arange(len(samples)) + np.repeat(low - (np.cumsum(count) - count), count)
        at_row = forms[triangle, 1] * (row + 0.5) + forms[triangle, 2]
        near = np.rint(level * (at_row[samples] + forms[triangle, 0][samples] * (column + 0.5)))
        place = (row * width)[samples] + column
        np.maximum.at(depth, place, near)
        seen = np.flatnonzero(near == depth[place])
        owner[place[seen]] = triangle[samples[seen]]
    return owner


def _spans(
    corners: Array, shares: Array, width: int, height: int
) -> Iterator[tuple[Index, Index, Index, Index]]:
    """Yield triangles, rows, first columns and numbers of samples inside each triangle."""
    low = np.clip(np.ceil(corners[:, :, 1].min(axis=1) - 0.5), 0, height).astype(np.intp)
    high = np.clip(np.floor(corners[:, :, 1].max(axis=1) + 0.5), 0, height).astype(np.intp)
    rows = np.maximum(high - low, 0)
    triangle = np.repeat(np.arange(len(corners)), rows)
    row = np.arange(len(triangle)) - np.repeat(np.cumsum(rows) - rows - low, rows)
    # all three barycentric coordinates must be >= 0
    slope = shares[triangle, :, 0]
    rest = shares[triangle, :, 1] * (row + 0.5)[:, None] + shares[triangle, :, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        at = -rest / slope
    left = np.where(slope > 0.0, at, 0.0).max(axis=1)
    right = np.where(slope < 0.0, at, float(width)).min(axis=1)
    outside = ((slope == 0.0) & (rest < 0.0)).any(axis=1) | ~np.isfinite(slope).all(axis=1)
    first = np.ceil(np.clip(left, 0, width) - 0.5 - 1e-9)
    last = np.floor(np.clip(right, 0, width) - 0.5 + 1e-9)
    count = np.where(outside, 0, np.clip(last, None, width - 1) - np.maximum(first, 0) + 1)
    count = np.maximum(np.nan_to_num(count), 0).astype(np.intp)
    kept = np.flatnonzero(count)
    triangle, row, count = triangle[kept], row[kept], count[kept]
    begin = np.maximum(first[kept], 0).astype(np.intp)
    ends = np.cumsum(count)
    place = 0
    while place < len(count):
        done = ends[place - 1] if place else 0
        after = max(place + 1, int(np.searchsorted(ends, done + MOST, side="right")))
        some = slice(place, after)
        yield triangle[some], row[some], begin[some], count[some]
        place = after
