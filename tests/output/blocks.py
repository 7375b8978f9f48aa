"""A solid block as the matrices of hexahedra, with its outer triangles: something to draw."""

from __future__ import annotations

import functools
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

import jousto as jo
from jousto.reduction.fields.stress import StressModes

CORNERS = np.array([[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1],
                    [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]])  # fmt: skip
FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))


def grid(counts: tuple[int, int, int], sizes: tuple[float, float, float]) -> tuple:
    """Return nodes (nn, 3), hexahedra (ne, 8) and outer triangles (nt, 3) of a block."""
    steps = [np.linspace(0.0, size, n + 1) for n, size in zip(counts, sizes, strict=True)]
    nodes = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    index = np.arange(len(nodes)).reshape([n + 1 for n in counts])
    cut = {-1: slice(None, -1), 1: slice(1, None)}
    hexes = np.stack([index[cut[a], cut[b], cut[c]].ravel() for a, b, c in CORNERS], axis=1)
    quads = np.concatenate([hexes[:, face] for face in FACES])
    _, first, times = np.unique(
        np.sort(quads, axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = quads[first[times == 1]]
    return nodes, hexes, np.concatenate([outer[:, [0, 1, 2]], outer[:, [0, 2, 3]]])


def matrices(nodes: np.ndarray, hexes: np.ndarray, E: float, rho: float) -> tuple:
    """Return K and M of equal hexahedra with nu = 0.3, eight Gauss points each."""
    nu = 0.3
    lame, G = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    D = np.diag([2 * G] * 3 + [G] * 3)
    D[:3, :3] += lame
    k, m = np.zeros((24, 24)), np.zeros((24, 24))
    for point in CORNERS / np.sqrt(3.0):
        ones = 1 + CORNERS * point
        N = ones.prod(axis=1) / 8
        dN = np.stack([CORNERS[:, i] * np.delete(ones, i, 1).prod(axis=1) / 8 for i in range(3)], 1)
        J = dN.T @ nodes[hexes[0]]
        g = dN @ np.linalg.inv(J).T
        B = np.zeros((6, 24))
        for i in range(3):
            B[i, i::3] = g[:, i]
        for row, (i, j) in enumerate(((0, 1), (1, 2), (0, 2)), start=3):
            B[row, i::3], B[row, j::3] = g[:, j], g[:, i]
        k += np.linalg.det(J) * B.T @ D @ B
        m += np.linalg.det(J) * rho * np.kron(np.outer(N, N), np.eye(3))
    dofs = (3 * hexes[:, :, None] + np.arange(3)).reshape(len(hexes), -1)
    place = (np.repeat(dofs, 24, axis=1).ravel(), np.tile(dofs, (1, 24)).ravel())
    size = (3 * len(nodes),) * 2
    return tuple(
        sp.coo_array((np.tile(x.ravel(), len(hexes)), place), shape=size).tocsr() for x in (k, m)
    )


@functools.cache
def bar() -> jo.ReducedPart:
    """A bar of 1 m along x whose stress modes are those of stretching only: s11 = x p1 MPa."""
    nodes, hexes, triangles = grid((8, 2, 2), (1.0, 0.1, 0.12))
    K, M = matrices(nodes, hexes, 2e9, 1200.0)
    part = jo.Part.from_matrices(M, K, nodes, elements=triangles, node_sets={"corner": [0]})
    reduced = jo.reduce(part, jo.FreeFree(modes=4))
    skin = np.unique(triangles)
    modes = np.zeros((len(skin), 6, reduced.n))
    modes[:, 0, 0] = 1e6 * nodes[skin, 0]
    axes = np.tile(np.eye(3), (len(skin), 1, 1))
    labels = tuple(f"n{k + 1}" for k in skin)
    return replace(reduced, stress=StressModes(labels, nodes[skin], axes, modes))


@functools.cache
def swinging_bar() -> jo.Solution:
    """The bar swings about a corner."""
    body = jo.FlexibleBody("bar", bar(), damping=0.02)
    model = jo.compile(
        jo.Mechanism(
            body,
            jo.Spherical("pivot", jo.ground["origin"], body["corner"]),
            jo.Gravity((0, 0, -9.81)),
            name="bar",
        )
    )
    return jo.simulate(model, 0.2, solver=jo.ROS2(5e-4), output_step=0.02)
