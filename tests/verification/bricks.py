"""Isoparametric solids from first principles: K and M of a mesh with any quadrature rule.

A third statement of the elements, slow and short: shape functions are the monomials of the kind
times the inverse of their values at its nodes, so that nothing is taken from a table.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import scipy.sparse as sp

from verification.boxes import EDGES, QUADRATIC

Rule = tuple[np.ndarray, np.ndarray]

CORNERS = {
    "tetra": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "wedge": ((0, 0, -1), (1, 0, -1), (0, 1, -1), (0, 0, 1), (1, 0, 1), (0, 1, 1)),
    "hexahedron": (
        (-1, -1, -1),
        (1, -1, -1),
        (1, 1, -1),
        (-1, 1, -1),
        (-1, -1, 1),
        (1, -1, 1),
        (1, 1, 1),
        (-1, 1, 1),
    ),
}


def _superlinear(power: tuple[int, ...]) -> int:
    """Degree of a monomial, counting only variables of a power above one."""
    return sum(p for p in power if p > 1)


POWERS = {
    "tetra": [p for p in product(range(2), repeat=3) if sum(p) <= 1],
    "tetra10": [p for p in product(range(3), repeat=3) if sum(p) <= 2],
    "wedge": [p for p in product(range(2), repeat=3) if p[0] + p[1] <= 1],
    "wedge15": [
        p
        for p in product(range(3), repeat=3)
        if p[0] + p[1] <= 2 and (p[2] < 2 or p[0] + p[1] <= 1)
    ],
    "hexahedron": list(product(range(2), repeat=3)),
    "hexahedron20": [p for p in product(range(3), repeat=3) if _superlinear(p) <= 2],
}


def reference_nodes(kind: str) -> np.ndarray:
    """Return the nodes (k, 3) of the reference element."""
    corner = QUADRATIC.get(kind, kind)
    x = np.array(CORNERS[corner], dtype=float)
    if kind not in QUADRATIC:
        return x
    return np.vstack([x, x[np.array(EDGES[corner])].mean(axis=1)])


@cache
def _coefficients(kind: str) -> np.ndarray:
    powers = np.array(POWERS[kind])
    x = reference_nodes(kind)
    assert len(powers) == len(x)
    return np.linalg.inv(np.prod(x[:, None] ** powers, axis=2))


def shape(kind: str, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the shape functions (q, k) and their derivatives (q, k, 3) at reference points."""
    powers, C = np.array(POWERS[kind]), _coefficients(kind)
    N = np.prod(points[:, None] ** powers, axis=2) @ C
    dN = []
    for axis in range(3):
        lower = powers.copy()
        lower[:, axis] = np.maximum(lower[:, axis] - 1, 0)
        dN.append((powers[:, axis] * np.prod(points[:, None] ** lower, axis=2)) @ C)
    return N, np.stack(dN, axis=2)


def rule(kind: str, n: int) -> Rule:
    """Return points and weights of n Gauss points a direction, exact to degree 2 n - 1 and more."""
    x, w = np.polynomial.legendre.leggauss(n)
    if kind.startswith("hexahedron"):
        points = np.array(list(product(x, x, x)))
        return points, np.prod(np.array(list(product(w, w, w))), axis=1)
    # collapsed: (a, b, c) in [0, 1]^3 to the simplex, two more points for the Jacobian
    s, v = np.polynomial.legendre.leggauss(n + 1)
    s, v = (s + 1.0) / 2.0, v / 2.0
    rows = []
    if kind.startswith("wedge"):
        for (a, wa), (b, wb), (z, wz) in product(zip(s, v), zip(s, v), zip(x, w)):  # noqa: B905
            rows.append((a, b * (1 - a), z, wa * wb * wz * (1 - a)))
    else:
        for (a, wa), (b, wb), (c, wc) in product(*[list(zip(s, v, strict=True))] * 3):
            jacobian = (1 - a) ** 2 * (1 - b)
            rows.append((a, b * (1 - a), c * (1 - a) * (1 - b), wa * wb * wc * jacobian))
    table = np.array(rows)
    return table[:, :3], table[:, 3]


def triangle_rule(points: int, along: int) -> Rule:
    """Return a rule of a wedge: 1 or 3 points in the triangle, Gauss points along its axis."""
    if points == 1:
        r, v = np.array([[1.0, 1.0]]) / 3.0, np.array([0.5])
    else:
        r, v = np.array([[1.0, 1.0], [4.0, 1.0], [1.0, 4.0]]) / 6.0, np.full(3, 1 / 6)
    z, w = np.polynomial.legendre.leggauss(along)
    rows = [(*a, c, va * wc) for (a, va), (c, wc) in product(zip(r, v), zip(z, w))]  # noqa: B905
    table = np.array(rows)
    return table[:, :3], table[:, 3]


def tetrahedron_rule(points: int) -> Rule:
    """Return the rule of a tetrahedron with 1 point (degree one) or 4 points (degree two)."""
    if points == 1:
        return np.full((1, 3), 0.25), np.array([1 / 6])
    a, b = (5.0 - np.sqrt(5.0)) / 20.0, (5.0 + 3.0 * np.sqrt(5.0)) / 20.0
    return np.full((4, 3), a) + (b - a) * np.vstack([np.zeros(3), np.eye(3)]), np.full(4, 1 / 24)


def calculix(kind: str) -> Rule:
    """Return the rule by which CalculiX integrates K and M of its C3D4 .. C3D20."""
    return {
        "tetra": lambda: tetrahedron_rule(1),
        "tetra10": lambda: tetrahedron_rule(4),
        "wedge": lambda: triangle_rule(1, 2),
        "wedge15": lambda: triangle_rule(3, 3),
        "hexahedron": lambda: rule("hexahedron", 2),
        "hexahedron20": lambda: rule("hexahedron20", 3),
    }[kind]()


def elasticity(material: Any) -> np.ndarray:
    """Return H (6, 6) of ``[xx yy zz xy yz zx]`` with engineering shears."""
    E, nu = material.E, material.nu
    lam, G = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    H = np.zeros((6, 6))
    H[:3, :3] = lam
    H[np.arange(6), np.arange(6)] = [lam + 2 * G] * 3 + [G] * 3
    return H


def _gradients(kind: str, xyz: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return dN/dx (e, q, k, 3) and the Jacobian's determinant (e, q)."""
    _, dN = shape(kind, points)
    J = np.einsum("eka,qkr->eqar", xyz, dN)
    return np.einsum("qkr,eqra->eqka", dN, np.linalg.inv(J)), np.linalg.det(J)


def strain(g: np.ndarray) -> np.ndarray:
    """Return B (..., 6, 3 k) of gradients (..., k, 3)."""
    B = np.zeros((*g.shape[:-2], 6, g.shape[-2], 3))
    for row, (a, b) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))):
        if a == b:
            B[..., row, :, a] = g[..., a]
        else:
            B[..., row, :, b], B[..., row, :, a] = g[..., a], g[..., b]
    return B.reshape(*g.shape[:-2], 6, -1)


def stiffness(mesh: Any, material: Any, quadrature: Callable[[str], Rule] | None = None) -> Any:
    """Return K (3 nn, 3 nn), node after node."""
    H = elasticity(material)

    def element(kind: str, xyz: np.ndarray) -> np.ndarray:
        points, weights = quadrature(kind) if quadrature else rule(kind, 3)
        g, det = _gradients(kind, xyz, points)
        B = strain(g)
        return np.einsum("eqip,ij,eqjr,eq->epr", B, H, B, weights * det, optimize=True)

    return _assemble(mesh, element)


def mass(mesh: Any, material: Any, quadrature: Callable[[str], Rule] | None = None) -> Any:
    """Return the consistent M (3 nn, 3 nn), node after node."""

    def element(kind: str, xyz: np.ndarray) -> np.ndarray:
        points, weights = quadrature(kind) if quadrature else rule(kind, 4)
        N, _ = shape(kind, points)
        _, det = _gradients(kind, xyz, points)
        m = material.rho * np.einsum("qk,ql,eq->ekl", N, N, weights * det)
        return np.einsum("ekl,ab->ekalb", m, np.eye(3)).reshape(len(xyz), 3 * N.shape[1], -1)

    return _assemble(mesh, element)


def _assemble(mesh: Any, element: Callable[[str, np.ndarray], np.ndarray]) -> Any:
    size = 3 * len(mesh.nodes)
    total = sp.csr_array((size, size))
    for cells in mesh.cells:
        nodes = np.asarray(cells.nodes)
        blocks = element(cells.kind, np.asarray(mesh.nodes)[nodes])
        dofs = (3 * nodes[:, :, None] + np.arange(3)).reshape(len(nodes), -1)
        rows = np.repeat(dofs, dofs.shape[1], axis=1).ravel()
        columns = np.tile(dofs, (1, dofs.shape[1])).ravel()
        total = total + sp.csr_array((blocks.ravel(), (rows, columns)), shape=(size, size))
    return total
