"""Surfaces of bodies: used vertices, and feature edges."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.arrays import Array, Index

CREASE = np.cos(np.deg2rad(35.0))  # faces that meet at a larger angle form an edge


def compact(triangles: Any) -> tuple[Index, Index]:
    """Return the nodes that triangles use, and the triangles renumbered to them."""
    used, corners = np.unique(np.asarray(triangles), return_inverse=True)
    return used.astype(np.intp), corners.reshape(-1, np.shape(triangles)[1]).astype(np.intp)


def feature_edges(positions: Array, triangles: Index) -> Index:
    """Return the edges (k, 2) at a boundary or a sharp angle of a surface.

    Coincident vertices count as one, so that triangles with separate vertices have edges at real
    corners only.
    """
    if not len(triangles):
        return np.zeros((0, 2), dtype=np.intp)
    size = float(np.ptp(positions, axis=0).max())
    key = np.round(positions / max(1e-9 * size, 1e-300)).astype(np.int64)
    _, first, same = np.unique(key, axis=0, return_index=True, return_inverse=True)
    corners = first[same.ravel()][triangles]
    x = positions[corners]
    normals = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    edges = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    faces = np.repeat(np.arange(len(corners)), 3)
    code = edges[:, 0] * len(positions) + edges[:, 1]
    order = np.argsort(code, kind="stable")
    starts = np.flatnonzero(np.r_[True, np.diff(code[order]) != 0])
    counts = np.diff(np.r_[starts, len(order)])
    one, other = faces[order[starts]], faces[order[np.minimum(starts + 1, len(order) - 1)]]
    sharp = np.einsum("ij,ij->i", normals[one], normals[other]) < CREASE
    found = edges[order[starts]][(counts != 2) | sharp]
    return np.asarray(found[found[:, 0] != found[:, 1]], dtype=np.intp)
