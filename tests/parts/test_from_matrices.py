"""Parts from the matrices of other programs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.testing import assert_allclose, assert_array_equal

from jousto.base.errors import InputError, JoustoWarning
from jousto.materials.material import Material
from jousto.parts.interface import Interface
from jousto.parts.mass import PointMass
from jousto.parts.part import Part
from jousto.sections.section import Circle

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
ROD = Circle(0.05)
BEAM = Part.beam(1.0, ROD, 3, STEEL)
M, K, NODES = BEAM.M, BEAM.K, BEAM.nodes
LUMPED = Part.frame(
    [(0, 0, 0), (1, 0, 0), (1, 2, 0.5)],
    [(0, 1), (1, 2)],
    sections=ROD,
    materials=STEEL,
    lumped=True,
    point_masses=[PointMass(1, 3.0, inertia=(1.0, 2.0, 2.5), offset=(0.1, 0.2, 0.3))],
)


def test_consistent_mass_has_no_points() -> None:
    part = Part.from_matrices(BEAM.M, BEAM.K.tocsc(), BEAM.nodes, node_sets={"tip": 3}, name="b")
    assert part.mass_points is None and part.stress is None
    assert part.dofs_per_node == 6 and part.node("tip") == part.node("node4") == 3
    assert part.mass == pytest.approx(BEAM.mass, rel=1e-13)
    assert_allclose(part.center, BEAM.center, rtol=1e-12, atol=1e-14)
    assert_allclose(part.inertia, BEAM.inertia, rtol=1e-10, atol=1e-13)


def test_lumped_mass_gives_its_points_back() -> None:
    part = Part.from_matrices(LUMPED.M.toarray(), LUMPED.K.toarray(), LUMPED.nodes)
    given, found = LUMPED.mass_points, part.mass_points
    assert given is not None and found is not None
    for name in ("mass", "position", "second_moment"):
        assert_allclose(getattr(found, name), getattr(given, name), rtol=1e-10, atol=1e-12)
    for name in ("N", "N_rot"):
        assert_allclose(
            getattr(found, name).toarray(), getattr(given, name).toarray(), rtol=1e-12, atol=1e-14
        )
    assert_allclose(found.matrix().toarray(), part.M.toarray(), rtol=1e-10, atol=1e-12)


def test_three_degrees_of_freedom() -> None:
    # four masses on a tetrahedron of springs
    nodes = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], dtype=float)
    K = np.zeros((12, 12))
    for i in range(4):
        for j in range(i):
            e = nodes[i] - nodes[j]
            g = np.zeros(12)
            g[3 * i : 3 * i + 3], g[3 * j : 3 * j + 3] = e, -e
            K += 1e6 * np.outer(g, g)
    m = np.array([1.0, 2.0, 3.0, 4.0])
    part = Part.from_matrices(np.diag(np.repeat(m, 3)), K, nodes, elements=[(0, 1, 2, 3)])
    assert part.dofs_per_node == 3
    points = part.mass_points
    assert points is not None
    assert_allclose(points.mass, m)
    assert points.N_rot.nnz == 0 and points.N_rot.shape == (12, 12)
    assert_allclose(part.center, [0.2, 0.3, 0.4], rtol=1e-13)
    x = nodes - part.center
    J = sum(mi * (xi @ xi * np.eye(3) - np.outer(xi, xi)) for mi, xi in zip(m, x, strict=True))
    assert_allclose(part.inertia, J, rtol=1e-12, atol=1e-14)


def test_anisotropic_nodal_mass_has_no_points() -> None:
    M = LUMPED.M.toarray()
    M[0, 0] *= 2.0
    assert Part.from_matrices(M, LUMPED.K, LUMPED.nodes).mass_points is None
    M = LUMPED.M.toarray()
    M[9, 6] = M[6, 9] = 0.1  # couples translation and rotation, not by an offset
    assert Part.from_matrices(M, LUMPED.K, LUMPED.nodes).mass_points is None


def test_a_rigid_interface_joins_pieces() -> None:
    """Two beams side by side; an average lets each of them go where it wants."""
    both = [np.kron(np.eye(2), X.toarray()) for X in (M, K)]
    nodes = np.vstack([NODES, NODES + [0, 0, 1]])
    ends = (len(NODES) - 1, 2 * len(NODES) - 1)
    part = Part.from_matrices(*both, nodes, interfaces=(Interface("bridge", ends),))
    assert part.ties[0].nodes.tolist() == list(ends)
    mean = Interface("bridge", (0, *ends), kind="average")
    with pytest.raises(InputError, match="has 2 pieces"):
        Part.from_matrices(*both, nodes, interfaces=(mean,))
    with pytest.raises(InputError, match="has 2 pieces"):
        Part.from_matrices(*both, nodes, interfaces=(Interface("foot", ends[:1]),))


def test_input_is_not_changed() -> None:
    # with a stored zero, which the part drops from its own copy
    coo = K.tocoo()
    place = (np.append(coo.row, 0), np.append(coo.col, 23))
    given = sp.csr_matrix((np.append(coo.data, 0.0), place), shape=K.shape)
    before = given.copy()
    part = Part.from_matrices(M, given, NODES)
    assert given.nnz == before.nnz == part.K.nnz + 1
    assert_array_equal(given.data, before.data)


def grounded(dof: int, stiffness: float) -> np.ndarray:
    K = BEAM.K.toarray()
    K[dof, dof] += stiffness
    return K


@pytest.mark.parametrize(
    ("K", "message"),
    [
        (grounded(1, 1e9), r"translation along y \(.* Hz\), rotation about z"),
        (grounded(3, 1e6), r"a rigid rotation about x \(.* Hz\) stores"),
    ],
)
def test_supports_are_noticed(K: np.ndarray, message: str) -> None:
    with pytest.warns(JoustoWarning, match=message):
        Part.from_matrices(BEAM.M, K, BEAM.nodes)


def test_nodes_in_other_units_are_noticed() -> None:
    with pytest.warns(JoustoWarning, match="node positions are in m"):
        Part.from_matrices(BEAM.M, BEAM.K, 1e3 * BEAM.nodes)


def with_entry(matrix: sp.csr_array, i: int, j: int, value: float) -> np.ndarray:
    out = matrix.toarray()
    out[i, j] = value
    return np.asarray(out)


def loose() -> tuple[np.ndarray, np.ndarray]:
    M, K = np.zeros((30, 30)), np.zeros((30, 30))
    M[:24, :24], K[:24, :24] = BEAM.M.toarray(), BEAM.K.toarray()
    return M, K


FIVE = np.vstack([BEAM.nodes, [(2.0, 0.0, 0.0)]])

BAD: tuple[tuple[Callable[[], object], tuple[str, ...]], ...] = (
    (
        lambda: Part.from_matrices(M, with_entry(K, 2, 3, np.nan), NODES),
        ("stiffness matrix K[2, 3] is nan",),
    ),
    (
        lambda: Part.from_matrices(M.toarray()[:5], K, NODES),
        ("M has shape (5, 24), must be square",),
    ),
    (lambda: Part.from_matrices(np.ones(4), K, NODES), ("M has shape (4,), must be square",)),
    (lambda: Part.from_matrices([["mass"]], K, NODES), ("mass matrix M is not a matrix",)),
    (
        lambda: Part.from_matrices(M, 1j * K.toarray(), NODES),
        ("K is not a matrix of real numbers",),
    ),
    (
        lambda: Part.from_matrices(M, with_entry(K, 1, 7, 5.0), NODES),
        ("K is not symmetric", "is 5 but"),
    ),
    (
        lambda: Part.from_matrices(sp.triu(M), np.triu(K.toarray()), NODES),
        ("M is not symmetric", "K is not symmetric", "only one triangle is filled"),
    ),
    (lambda: Part.from_matrices(M, K, NODES[:3]), ("24 rows in M do not fit 3 nodes",)),
    (
        lambda: Part.from_matrices(M, K, NODES, dofs_per_node=3),
        ("24 rows in M do not fit 4 nodes with dofs_per_node = 3",),
    ),
    (lambda: Part.from_matrices(M, np.eye(12), NODES), ("M is (24, 24) and K is (12, 12)",)),
    (lambda: Part.from_matrices(M, K, np.full((4, 3), np.inf)), ("nodes[0, 0] is inf",)),
    (
        lambda: Part.from_matrices(-M, K, NODES),
        ("M is not positive semidefinite: the block of node1", "M contains no mass"),
    ),
    (
        lambda: Part.from_matrices(M, BEAM.K - 2.0 * sp.csr_array(np.diag(K.diagonal())), NODES),
        ("K is not positive semidefinite",),
    ),
    (lambda: Part.from_matrices(*loose(), FIVE), ("node5: neither mass nor stiffness",)),
    (
        lambda: Part.from_matrices(
            np.kron(np.eye(2), M.toarray()),
            np.kron(np.eye(2), K.toarray()),
            np.vstack([NODES, NODES + [0, 0, 1]]),
        ),
        ("has 2 pieces", "1 m apart"),
    ),
    (
        lambda: Part.from_matrices(M, K, NODES, node_sets={"tip": 8}),
        ("node set 'tip' contains node 8",),
    ),
    (
        lambda: Part.from_matrices(M, K, NODES, elements=[(0, 1, 2, 9)]),
        ("elements[0, 3] is node 9",),
    ),
    (
        lambda: Part(name="x", nodes=NODES, elements=BEAM.elements, dofs_per_node=5, M=M, K=K),
        ("dofs_per_node is 5", "M has shape (24, 24), must be (20, 20)"),
    ),
)


@pytest.mark.parametrize(("make", "messages"), BAD)
def test_bad_matrices(make: Callable[[], object], messages: tuple[str, ...]) -> None:
    with pytest.raises(InputError) as caught:
        make()
    for message in messages:
        assert message in str(caught.value)


def test_indefinite_between_nodes_is_found() -> None:
    # every nodal block is fine, the whole is not
    M = BEAM.M.toarray()
    M[0, 6] = M[6, 0] = 10.0 * M[0, 0]
    with pytest.raises(InputError, match="its lowest eigenvalue"):
        Part.from_matrices(M, BEAM.K, BEAM.nodes)


def test_swapped_matrices_are_told_to_be() -> None:
    part = Part.beam(1.0, Circle(0.01), 4, Material(E=210e9, nu=0.3, rho=7850))
    with pytest.raises(InputError, match="K and M seem to be swapped"):
        Part.from_matrices(part.K, part.M, part.nodes)
    Part.from_matrices(part.M, part.K, part.nodes)
