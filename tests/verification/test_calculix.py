"""Parts of solids against CalculiX: matrices, frequencies, static displacements and stresses.

Both programs get the same nodes. CalculiX integrates the mass of tetrahedra and wedges with few
points (`bricks.calculix`); frequencies are compared with that rule, and how far it is from the
exact integral of jousto is a result of its own.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh, null_space
from scipy.spatial.transform import Rotation

import jousto as jo
from parts.grids import SPRUCE
from verification import bricks, calculix
from verification.boxes import KINDS, block
from verification.solids import at_rest, dofs, solid, supported
from verification.test_calculix_rules import bent

ARM = Path(__file__).parents[2] / "examples" / "data" / "link_arm.step"
STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
SIZE = (0.8, 0.1, 0.06)
COUNTS = {
    "tetra": (16, 2, 2),
    "tetra10": (10, 2, 1),
    "wedge": (16, 2, 2),
    "wedge15": (10, 2, 1),
    "hexahedron": (16, 2, 2),
    "hexahedron20": (10, 2, 2),
}
SAME_MASS = ("hexahedron", "hexahedron20")
SAME_STIFFNESS = ("tetra", "tetra10", "hexahedron", "hexahedron20")
DIGITS = 5e-7
"""ccx prints seven digits."""
PULL = (1e5, 2e3, -1e3)  # N


def beam(kind):
    return block(kind, SIZE, COUNTS[kind])


def as_calculix(grid, part):
    """The same part with the mass (and for wedges the stiffness) integrated as ccx does."""
    kind = grid.cells[0].kind
    K = part.K if kind in SAME_STIFFNESS else bricks.stiffness(grid, STEEL, bricks.calculix)
    M = part.M if kind in SAME_MASS else bricks.mass(grid, STEEL, bricks.calculix)
    return jo.Part.from_matrices(M, K, part.nodes)


def curved(kind):
    return block(kind, (1.0, 0.1, 0.06), (4, 1, 1), bend=bent)


@pytest.mark.parametrize("kind", KINDS)
def test_mass_is_that_of_first_principles(kind):
    # without ccx, too
    M = bricks.mass(curved(kind), STEEL, lambda k: bricks.rule(k, 6))
    assert abs(solid(curved(kind), STEEL).M - M).max() < 1e-13 * abs(M).max()


@pytest.mark.parametrize("kind", SAME_STIFFNESS)
def test_stiffness_is_that_of_first_principles(kind):
    K = bricks.stiffness(curved(kind), STEEL, bricks.calculix)
    assert abs(solid(curved(kind), STEEL).K - K).max() < 1e-13 * abs(K).max()


@pytest.mark.parametrize("kind", sorted(set(KINDS) - set(SAME_STIFFNESS)))
def test_stiffness_of_straight_wedges_is_that_of_first_principles(kind):
    # curved ones have rational integrands, which no rule of points integrates exactly
    grid = block(kind, (1.0, 0.1, 0.06), (4, 1, 1))
    part, K = solid(grid, STEEL), bricks.stiffness(grid, STEEL)
    assert abs(part.K - K).max() < 1e-13 * abs(K).max()


@calculix.needed
@pytest.mark.parametrize("kind", SAME_STIFFNESS)
def test_stiffness_is_that_of_calculix(kind):
    K, _ = calculix.matrices(calculix.Deck(curved(kind), STEEL))
    assert abs(solid(curved(kind), STEEL).K - K).max() < 5e-12 * abs(K).max()


@calculix.needed
def test_mass_of_bricks_is_that_of_calculix():
    kind = SAME_MASS[-1]
    _, M = calculix.matrices(calculix.Deck(curved(kind), STEEL))
    # 27 points there, 64 here: of curved elements the integrand is of a higher order
    assert abs(solid(curved(kind), STEEL).M - M).max() < 2e-4 * abs(M).max()


@pytest.mark.parametrize("kind", SAME_STIFFNESS)
def test_probes_of_stiffness_are_those_of_calculix(kind):
    theirs, _ = calculix.matrix_probes(calculix.Deck(curved(kind), STEEL))
    calculix.assert_probed(solid(curved(kind), STEEL).K, theirs, 5e-12)


def spruce():
    """Nine constants about axes that are none of the part's."""
    axes = Rotation.from_rotvec([0.3, -0.5, 0.8]).as_matrix()
    return jo.materials.Orthotropic(**SPRUCE, axes=axes)


@calculix.needed
@pytest.mark.parametrize("kind", SAME_STIFFNESS)
def test_wood_at_an_angle(kind):
    K, _ = calculix.matrices(calculix.Deck(curved(kind), spruce()))
    assert abs(solid(curved(kind), spruce()).K - K).max() < 5e-12 * abs(K).max()


@pytest.mark.parametrize("kind", SAME_STIFFNESS)
def test_probes_of_wood_at_an_angle(kind):
    theirs, _ = calculix.matrix_probes(calculix.Deck(curved(kind), spruce()))
    calculix.assert_probed(solid(curved(kind), spruce()).K, theirs, 5e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_ten_free_frequencies(kind):
    grid = beam(kind)
    theirs = calculix.frequencies(calculix.Deck(grid, STEEL))
    part = as_calculix(grid, solid(grid, STEEL))
    ours = jo.reduce(part, jo.FreeFree(modes=10)).frequencies
    np.testing.assert_allclose(ours, theirs, rtol=DIGITS)


def test_a_held_reduced_part_has_the_clamped_frequencies():
    grid = beam("hexahedron20")
    part, clamp = solid(grid, STEEL), grid.plane(0, 0.0)
    full, _ = supported(part, dofs(clamp), 6)
    np.testing.assert_allclose(held(part, clamp, 6), full, rtol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_ten_clamped_frequencies(kind):
    grid = beam(kind)
    clamp = grid.plane(0, 0.0)
    theirs = calculix.frequencies(calculix.Deck(grid, STEEL, clamp))
    part = as_calculix(grid, solid(grid, STEEL))
    ours, _ = supported(part, dofs(clamp), 10)
    np.testing.assert_allclose(ours, theirs, rtol=DIGITS)


@pytest.mark.parametrize(
    ("kind", "first", "tenth"),
    [("tetra10", 5e-5, 3e-3), ("wedge15", 6e-4, 6e-3), ("hexahedron20", DIGITS, DIGITS)],
)
def test_what_the_exact_integrals_change(kind, first, tenth):
    grid = beam(kind)
    theirs = calculix.frequencies(calculix.Deck(grid, STEEL))
    ours = jo.reduce(solid(grid, STEEL), jo.FreeFree(modes=10)).frequencies
    change = np.abs(ours / theirs - 1.0)
    assert change[0] < first
    assert change.max() < tenth


def held(part, nodes, number):
    """Frequencies in Hz of the reduced part whose only interface is held."""
    tied = part.with_interfaces(jo.Interface("bore", nodes, at=(0.0, 0.0, 0.0)))
    reduced = jo.reduce(tied, jo.CraigBampton(modes=number))
    node, R = reduced.node("bore"), part.rigid_modes()
    # motion of the interface, about the origin, in rigid motions and modes
    q = np.hstack([np.eye(6), np.vstack([reduced.modes[node], reduced.rotation(node)])])
    Z = null_space(q)
    K = np.concatenate([np.zeros(6), reduced.stiffness])[:, None] * Z
    # modes have no momentum beside rigid motions
    M = np.vstack([R.T @ (part.M @ R) @ Z[:6], Z[6:]])
    return np.sqrt(eigh(Z.T @ K, Z.T @ M, eigvals_only=True)) / (2.0 * np.pi)


@calculix.needed
@pytest.mark.slow
def test_ten_frequencies_of_the_link_arm():
    """Free, and clamped at its larger bore."""
    pytest.importorskip("gmsh")
    with pytest.warns(jo.JoustoWarning, match="would be folded"):  # four elements round a bore
        mesh = jo.mesh_cad(ARM, size=0.1, per_circle=4)
    theirs = calculix.frequencies(calculix.Deck(mesh, STEEL), kept=False)
    part = jo.Part.solid(mesh, STEEL)
    M = bricks.mass(mesh, STEEL, bricks.calculix)
    same = jo.reduce(jo.Part.from_matrices(M, part.K, part.nodes), jo.FreeFree(modes=10))
    np.testing.assert_allclose(same.frequencies, theirs, rtol=DIGITS)
    own = jo.reduce(part, jo.FreeFree(modes=10))
    np.testing.assert_allclose(own.frequencies, theirs, rtol=1e-4)
    bore = mesh.holes()[0].nodes
    theirs = calculix.frequencies(calculix.Deck(mesh, STEEL, bore), kept=False)
    np.testing.assert_allclose(held(part, bore, 10), theirs, rtol=1e-4)


def test_the_mass_rule_of_four_points_matters_less_on_finer_meshes():
    changes = []
    for n in (1, 2):
        grid = block("tetra10", (0.4, 0.1, 0.06), (4 * n, n, n))
        part = solid(grid, STEEL)
        exact = jo.reduce(part, jo.FreeFree(modes=3)).frequencies
        other = jo.reduce(as_calculix(grid, part), jo.FreeFree(modes=3)).frequencies
        changes.append(np.abs(other / exact - 1.0))
    assert np.all(changes[1] < changes[0] / 8.0), changes


def tip_load(grid, force):
    tip = grid.plane(0, SIZE[0])
    return [(int(n), np.asarray(force) / len(tip)) for n in tip]


def pulled(kind):
    """The beam pulled, and bent about both axes, at its tip; clamped."""
    grid = beam(kind)
    clamp, forces = grid.plane(0, 0.0), tip_load(grid, PULL)
    theirs = calculix.static(calculix.Deck(grid, STEEL, clamp), forces=forces)
    part = solid(grid, STEEL)
    load = np.zeros((len(grid.nodes), 3))
    for node, force in forces:
        load[node] += force
    d = at_rest(part, dofs(clamp), load.ravel())
    # all components continued from inside, as there
    return grid, theirs, d.reshape(-1, 3), replace(part.stress, faces=False).evaluate(d)


@pytest.mark.parametrize("kind", SAME_STIFFNESS)
def test_displacements_under_a_tip_load(kind):
    _, theirs, u, _ = pulled(kind)
    np.testing.assert_allclose(u, theirs.u, rtol=0, atol=DIGITS * np.abs(u).max())


@pytest.mark.parametrize("kind", ["tetra", "tetra10", "hexahedron"])
def test_nodal_stresses_under_a_tip_load(kind):
    # the same points, continued to the nodes and averaged in the same way; six digits printed
    _, theirs, _, s = pulled(kind)
    np.testing.assert_allclose(s, theirs.stress, rtol=0, atol=4e-5 * np.abs(s).max())


@pytest.mark.parametrize(("kind", "limit"), [("tetra10", 6e-3), ("hexahedron20", 6e-3)])
def test_nodal_stresses_against_beam_theory(kind, limit):
    # CalculiX continues the stress of C3D20 from 27 points, jousto from the eight best ones
    grid, theirs, _, s = pulled(kind)
    x, y, z = grid.nodes.T
    (L, b, h), (N, Fy, Fz) = SIZE, PULL
    bending = Fy * (y - b / 2) * 12.0 / (h * b**3) + Fz * (z - h / 2) * 12.0 / (b * h**3)
    exact = N / (b * h) - (L - x) * bending
    away = np.abs(x - L / 2.0) < 0.3 * L
    ours, other = (np.abs(a[:, 0] - exact)[away].max() / exact.max() for a in (s, theirs.stress))
    assert ours < limit
    assert ours < 1.01 * other
