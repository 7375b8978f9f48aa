"""A plate with a hole as a mesh of hexahedra20, without a mesher."""

from __future__ import annotations

import functools

import numpy as np

import jousto as jo

LENGTH, WIDTH, THICK = 0.4, 0.1, 0.02  # m
HOLE, MIDDLE = 0.025, np.array([0.3, 0.05])  # radius and place, m
EDGES = (
    (0, 1),
    (1, 2),
    (2, 3),
    (3, 0),
    (4, 5),
    (5, 6),
    (6, 7),
    (7, 4),
    (0, 4),
    (1, 5),
    (2, 6),
    (3, 7),
)


def _square(angles: np.ndarray) -> np.ndarray:
    """Return where rays from the middle of a square of half side 0.05 meet its edge."""
    ray = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return 0.05 * ray / np.abs(ray).max(axis=-1, keepdims=True)


@functools.cache
def plate() -> jo.Mesh:
    """Return the plate: sets left and right, element set all; the hole's wall is curved."""
    corners: list[np.ndarray] = []
    hexes: list[list[int]] = []

    def number(point: np.ndarray) -> int:
        for k, other in enumerate(corners):
            if np.allclose(point, other, atol=1e-9):
                return k
        corners.append(point)
        return len(corners) - 1

    def add(quad: list[np.ndarray]) -> None:
        low = [number(np.append(p, 0.0)) for p in quad]
        hexes.append(low + [number(np.append(p, THICK)) for p in quad])

    # a ring of 16 around the hole in two layers, then a grid of 4 x 4 squares to the left
    angles = np.deg2rad(np.arange(-45.0, 315.0 + 1.0, 22.5))
    tangents = 0.05 * np.tan(np.deg2rad(np.array([-45.0, -22.5, 0.0, 22.5])))
    outer = []
    for side in range(4):
        c, s = np.cos(side * np.pi / 2), np.sin(side * np.pi / 2)
        outer += [np.array([c * 0.05 - s * t, s * 0.05 + c * t]) for t in tangents]
    outer.append(outer[0])
    for k in range(16):
        inner = [HOLE * np.array([np.cos(a), np.sin(a)]) for a in angles[[k, k + 1]]]
        mid = [0.5 * (i + o) for i, o in zip(inner, outer[k : k + 2], strict=True)]
        add([MIDDLE + p for p in (inner[0], mid[0], mid[1], inner[1])])
        add([MIDDLE + p for p in (mid[0], outer[k], outer[k + 1], mid[1])])
    rows = np.sort(0.05 + np.array([-0.05, tangents[1], 0.0, tangents[3], 0.05]))
    for x0, x1 in zip(*(np.linspace(0.0, 0.25, 6)[i:] for i in (0, 1)), strict=False):
        for y0, y1 in zip(rows[:-1], rows[1:], strict=True):
            add([np.array(p) for p in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))])
    for y0, y1 in zip(rows[:-1], rows[1:], strict=True):
        add([np.array(p) for p in ((0.35, y0), (0.4, y0), (0.4, y1), (0.35, y1))])
    # middles of the edges, on the wall of the hole where both ends are
    nodes = [*corners]
    places: dict[tuple[int, int], int] = {}
    cells = []
    for hexa in hexes:
        row = list(hexa)
        for a, b in EDGES:
            key = (min(hexa[a], hexa[b]), max(hexa[a], hexa[b]))
            if key not in places:
                point = 0.5 * (nodes[key[0]] + nodes[key[1]])
                arm = [nodes[k][:2] - MIDDLE for k in key]
                if all(abs(np.linalg.norm(r) - HOLE) < 1e-9 for r in arm):
                    middle = arm[0] + arm[1]
                    point[:2] = MIDDLE + HOLE * middle / np.linalg.norm(middle)
                places[key] = len(nodes)
                nodes.append(point)
            row.append(places[key])
        cells.append(row)
    x = np.array(nodes)
    return jo.Mesh(
        "plate",
        x,
        jo.mesh.Cells("hexahedron20", cells),
        node_sets={
            "left": np.flatnonzero(x[:, 0] < 1e-9),
            "right": np.flatnonzero(x[:, 0] > LENGTH - 1e-9),
        },
        element_sets={"all": np.arange(len(cells))},
    )
