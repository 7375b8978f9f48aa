"""Reference elements of solids and their faces: shape functions, derivatives, quadrature.

The shape functions and the quadrature of triangles, tetrahedra and lines are those of scikit-fem,
in the node order of VTK and evaluated once per kind, so that the assembly needs only a few array
products.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from jousto.base.arrays import Array

KINDS = {"tetra": 4, "tetra10": 10, "hexahedron": 8, "hexahedron20": 20, "wedge": 6, "wedge15": 15}
"""Kinds of solid elements with their number of nodes."""

FORMULATIONS = {
    "tetra": ("full",),
    "tetra10": ("full",),
    "hexahedron": ("full", "bbar", "incompatible", "reduced"),
    "hexahedron20": ("full", "reduced"),
    "wedge": ("full", "reduced"),
    "wedge15": ("full", "reduced"),
}
"""Formulations of the stiffness of each kind; see `jousto.parts.solids.bricks` for those of
the brick of eight nodes."""

CORNERS = {
    "tetra": "tetra",
    "tetra10": "tetra",
    "hexahedron": "hexahedron",
    "hexahedron20": "hexahedron",
    "wedge": "wedge",
    "wedge15": "wedge",
    "triangle": "triangle",
    "triangle6": "triangle",
    "quad": "quad",
    "quad8": "quad",
}
"""The linear element with the same corners."""

_PLACES = {
    "tetra": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
    "hexahedron": [
        [0, 0, 0],
        [1, 0, 0],
        [1, 1, 0],
        [0, 1, 0],
        [0, 0, 1],
        [1, 0, 1],
        [1, 1, 1],
        [0, 1, 1],
    ],
    "wedge": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]],
    "triangle": [[0, 0], [1, 0], [0, 1]],
    "quad": [[0, 0], [1, 0], [1, 1], [0, 1]],
}

EDGES = {
    "tetra10": [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]],
    "hexahedron20": [
        [0, 1],
        [1, 2],
        [2, 3],
        [3, 0],
        [4, 5],
        [5, 6],
        [6, 7],
        [7, 4],
        [0, 4],
        [1, 5],
        [2, 6],
        [3, 7],
    ],
    "wedge15": [[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]],
    "triangle6": [[0, 1], [1, 2], [2, 0]],
    "quad8": [[0, 1], [1, 2], [2, 3], [3, 0]],
}
"""Corners on both sides of each mid-side node, in the order of the mid-side nodes."""

# degrees of exactness in the plane and along the axis of (stiffness, mass, stress); stiffness:
# exact for straight elements, mass: exact for curved ones, too
_DEGREES = {
    "tetra": ((1, 1), (3, 3), (1, 1)),
    "tetra10": ((2, 2), (7, 7), (2, 2)),
    "hexahedron": ((3, 3), (5, 5), (3, 3)),
    "hexahedron20": ((5, 5), (9, 9), (3, 3)),
    "wedge": ((2, 3), (4, 5), (2, 3)),
    "wedge15": ((4, 5), (8, 9), (2, 3)),
}
# degrees of the reduced rules of Abaqus and CalculiX: C3D8R 1, C3D20R 2 x 2 x 2, C3D6 1 x 2,
# C3D15 3 x 3; for stiffness and stress only, the mass remains exact
_REDUCED = {
    "hexahedron": ((1, 1), (1, 1)),
    "hexahedron20": ((3, 3), (3, 3)),
    "wedge": ((1, 3), (1, 3)),
    "wedge15": ((2, 5), (2, 3)),
}
PURPOSES = ("stiffness", "mass", "stress")
FACES = {3: ("triangle", 4), 4: ("quad", 5), 6: ("triangle6", 4), 8: ("quad8", 5)}
"""Kinds of faces by their number of nodes, and the degree of their rule."""


@dataclass(frozen=True, eq=False)
class Table:
    """Element at the points of a quadrature rule.

    Attributes
    ----------
    points : (nq, 3) ndarray
        Reference coordinates; two for faces.
    weights : (nq,) ndarray
        Weights, whose sum is the volume of the reference element.
    N : (nq, k) ndarray
        Shape functions.
    dN : (nq, 3, k) ndarray
        Their derivatives along the reference coordinates.
    """

    points: Array
    weights: Array
    N: Array
    dN: Array


@cache
def places(kind: str) -> Array:
    """Return the reference coordinates of the nodes, (k, 3) of solids or (k, 2) of faces."""
    corners = np.array(_PLACES[CORNERS[kind]], dtype=np.float64)
    if kind not in EDGES:
        return corners
    return np.concatenate([corners, corners[EDGES[kind]].mean(axis=1)])


@cache
def face_table(k: int, *, at_nodes: bool = False) -> Table:
    """Return the table of a face of k nodes, at its quadrature points or at its nodes."""
    kind, degree = FACES[k]
    points, weights = rule(kind, degree, 0)
    if at_nodes:
        points, weights = places(kind), np.zeros(k)
    N, dN = shape_functions(kind, points)
    return Table(points, weights, N, dN)


@cache
def table(kind: str, purpose: str, formulation: str = "full") -> Table:
    """Return the element at its quadrature points for "stiffness", "mass" or "stress".

    Stress is sampled where it is most accurate (the points of the reduced rule of quadratic
    elements), at one point per corner of the element, except for the linear tetrahedron, whose
    stress is constant. Elements of reduced integration have fewer points.
    """
    degrees = _DEGREES[kind][PURPOSES.index(purpose)]
    if formulation == "reduced" and purpose != "mass":
        degrees = _REDUCED[kind][purpose == "stress"]
    points, weights = rule(kind, *degrees)
    N, dN = shape_functions(kind, points)
    return Table(points, weights, N, dN)


def rule(kind: str, plane: int, axis: int) -> tuple[Array, Array]:
    """Return points (nq, 3) and weights (nq,) exact for polynomials of given degrees."""
    from skfem.quadrature import get_quadrature  # slow to import, needed for solids only
    from skfem.refdom import RefLine, RefTet, RefTri

    corners = CORNERS[kind]
    if corners == "tetra":
        # from degree 5 on, tetrahedra of scikit-fem 12 are exact to one degree less than specified
        X, w = get_quadrature(RefTet, plane if plane < 5 else plane + 1)
        return np.ascontiguousarray(X.T), w
    if corners in ("wedge", "triangle"):
        # scikit-fem's smallest rule has three points
        one = (np.full((2, 1), 1.0 / 3.0), np.array([0.5]))
        X, w = get_quadrature(RefTri, plane) if plane > 1 else one
    elif plane == 1:  # scikit-fem's smallest rule has two points
        X, w = np.full((2, 1), 0.5), np.ones(1)
    else:
        x, wx = get_quadrature(RefLine, plane)
        X = np.stack([np.tile(x[0], x.size), np.repeat(x[0], x.size)])
        w = np.outer(wx, wx).ravel()
    if corners in ("triangle", "quad"):
        return np.ascontiguousarray(X.T), w
    # product of a rule in the plane and one along the axis
    z, wz = get_quadrature(RefLine, axis) if axis > 1 else (np.full((1, 1), 0.5), np.ones(1))
    points = np.column_stack([np.tile(X.T, (z.size, 1)), np.repeat(z[0], w.size)])
    return points, np.outer(wz, w).ravel()


def shape_functions(kind: str, points: Array) -> tuple[Array, Array]:
    """Return shape functions (nq, k) and their derivatives (nq, 3, k) at points (nq, 3)."""
    if kind == "wedge15":
        return _wedge15(points)
    from skfem import element

    name = {
        "tetra": "ElementTetP1",
        "tetra10": "ElementTetP2",
        "hexahedron": "ElementHex1",
        "hexahedron20": "ElementHexS2",
        "wedge": "ElementWedge1",
        "triangle": "ElementTriP1",
        "triangle6": "ElementTriP2",
        "quad": "ElementQuad1",
        "quad8": "ElementQuadS2",
    }[kind]
    reference = getattr(element, name)()
    theirs, ours = np.asarray(reference.doflocs), places(kind)
    order = np.abs(ours[:, None] - theirs[None]).max(axis=2).argmin(axis=1)
    X = np.ascontiguousarray(points.T)
    both = [reference.lbasis(X, int(i)) for i in order]
    N = np.stack([np.broadcast_to(f, len(points)) for f, _ in both], axis=1)
    dN = np.stack([np.broadcast_to(df, X.shape).T for _, df in both], axis=2)
    return N, dN


def _wedge15(points: Array) -> tuple[Array, Array]:
    """Return the 15-node wedge, which scikit-fem does not have.

    Its functions are quadratic in the triangle times linear along the axis, and linear in the
    triangle times quadratic along the axis, each one at its node and zero at the others. On the
    faces they equal those of `tetra10` and `hexahedron20`.
    """
    powers = [(i, j, m) for m in (0, 1) for i in range(3) for j in range(3 - i)]
    powers += [(0, 0, 2), (1, 0, 2), (0, 1, 2)]
    p = np.array(powers)

    def monomials(x: Array, along: int | None = None) -> Array:
        e = p.copy()
        factor = np.ones(len(p))
        if along is not None:
            factor = e[:, along].astype(np.float64)
            e[:, along] = np.maximum(e[:, along] - 1, 0)
        return np.asarray(factor * np.prod(x[:, None, :] ** e, axis=2))

    coefficients = np.linalg.inv(monomials(places("wedge15")))
    dN = np.stack([monomials(points, along) @ coefficients for along in range(3)], axis=1)
    return monomials(points) @ coefficients, dN


def gradients(dN: Array, x: Array) -> tuple[Array, Array]:
    """Return spatial derivatives of the shape functions and the Jacobian determinant.

    Parameters
    ----------
    dN : (nq, 3, k) ndarray
        Derivatives along the reference coordinates.
    x : (ne, k, 3) ndarray
        Positions of the nodes in m.

    Returns
    -------
    G : (ne, nq, 3, k) ndarray
        Derivatives along x, y and z in 1/m.
    detJ : (ne, nq) ndarray
        Ratio of volumes in m^3.
    """
    nq, _, k = dN.shape
    J = np.matmul(x.transpose(0, 2, 1), dN.reshape(nq * 3, k).T).reshape(-1, 3, nq, 3)
    # rows of the inverse from cross products: dxi_0/dx = (dx/dxi_1 x dx/dxi_2) / detJ
    a, b, c = (J[..., d] for d in range(3))
    inverse = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=-1)
    detJ = np.sum(a * inverse[..., 0], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse /= detJ[:, None, :, None]
    # (ne, nq, 3, 3) @ (nq, 3, k)
    return np.matmul(inverse.transpose(0, 2, 1, 3), dN), detJ


def jacobians(dN: Array, x: Array) -> Array:
    """Return the Jacobian determinants (ne, nq) only, see `gradients`."""
    nq, _, k = dN.shape
    J = np.matmul(x.transpose(0, 2, 1), dN.reshape(nq * 3, k).T).reshape(-1, 3, nq, 3)
    a, b, c = (J[..., d] for d in range(3))
    return np.asarray(np.sum(a * _cross(b, c), axis=1))


def _cross(a: Array, b: Array) -> Array:
    """Return the cross product along axis 1."""
    return np.stack(
        [
            a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1],
            a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
            a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0],
        ],
        axis=1,
    )
