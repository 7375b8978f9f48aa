"""Stress of solids at their nodes: exact fields, materials that meet, the choice of sites."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from jousto.errors import InputError
from jousto.parts import Material, Part, SolidStress
from jousto.parts.orthotropic import elasticity
from parts.grids import ALL, grid

Array = NDArray[np.float64]
STEEL = Material(E=210e9, nu=0.3, rho=7850.0, name="steel")
SIZE = np.array([0.9, 0.3, 0.2])


def solid_stress(part: Part) -> SolidStress:
    assert isinstance(part.stress, SolidStress)
    return part.stress


@pytest.mark.parametrize("kind", ALL)
def test_linear_field(kind: str) -> None:
    """Constant strain, also in distorted elements; a rotation strains nothing."""
    part = Part.solid(grid(kind, (3, 2, 2), SIZE, distort=0.25), STEEL)
    g = 1e-3 * np.random.default_rng(0).standard_normal((3, 3))
    d = (part.nodes @ g.T).ravel()
    e = np.array(
        [g[0, 0], g[1, 1], g[2, 2], g[0, 1] + g[1, 0], g[1, 2] + g[2, 1], g[0, 2] + g[2, 0]]
    )
    s = elasticity(STEEL) @ e
    assert part.strain is not None
    np.testing.assert_allclose(
        part.strain.evaluate(d), np.tile(e, (len(part.nodes), 1)), atol=1e-15
    )
    found = solid_stress(part).evaluate(np.column_stack([d, 2.0 * d]))
    np.testing.assert_allclose(found[:, :, 0], np.tile(s, (len(part.nodes), 1)), rtol=1e-11)
    np.testing.assert_allclose(found[:, :, 1], 2.0 * found[:, :, 0])
    turn = part.rigid_modes()[:, 3:]
    assert np.abs(solid_stress(part).evaluate(turn)).max() < 1e-12 * STEEL.E


@pytest.mark.parametrize("kind", ["tetra10", "hexahedron20", "wedge15"])
def test_bending(kind: str) -> None:
    """Pure bending, ``s11 = -E y/r``: exact up to the surface, where centres would be far off."""
    part = Part.solid(grid(kind, (3, 1, 2), SIZE), STEEL)
    x, y, z = part.nodes.T
    nu, c = STEEL.nu, 1e-3
    d = np.stack([-c * x * y, 0.5 * c * (x**2 + nu * (y**2 - z**2)), c * nu * y * z], axis=1)
    s = solid_stress(part).evaluate(d.ravel())
    exact = np.zeros_like(s)
    exact[:, 0] = -STEEL.E * c * y
    np.testing.assert_allclose(s, exact, atol=1e-10 * STEEL.E * c)


def test_where_materials_meet() -> None:
    """Both sides are told apart: equal strains along the face, the stress of each modulus."""
    soft, hard = (Material(E=E, nu=0.0, rho=1e3, name="m") for E in (70e9, 210e9))
    mesh = grid(
        "hexahedron20",
        (2, 2, 1),
        materials=lambda x: np.where(x[:, 0] < 0.5, "left", "right"),
    )
    part = Part.solid(mesh, {"left": soft, "right": hard})
    d = np.zeros((len(part.nodes), 3))
    d[:, 1] = 1e-3 * part.nodes[:, 1]
    stress = solid_stress(part)
    s = stress.evaluate(d.ravel())
    exact = np.where(stress.material == 0, 70e6, 210e6)
    np.testing.assert_allclose(s[:, 1], exact)
    shared = np.flatnonzero(np.abs(part.nodes[:, 0] - 0.5) < 1e-9)
    assert len(stress) == len(part.nodes) + len(shared)
    label = f"n{mesh.node_ids[shared[0]]}"
    pair = stress.select([f"{label}.right", f"{label}.left"])
    np.testing.assert_allclose(pair.evaluate(d.ravel())[:, 1], [210e6, 70e6])
    assert pair.elasticity is not None
    np.testing.assert_array_equal(pair.elasticity[:, 0], [210e9, 70e9])
    with pytest.raises(InputError, match="no site 'n999'"):
        stress.select(["n999"])


def test_choice_of_nodes() -> None:
    """A few sites give the numbers that they have among all; labels are the mesh's numbers."""
    mesh = grid("tetra10", (3, 2, 2), SIZE, distort=0.2)
    mesh.node_ids = mesh.node_ids * 10
    part = Part.solid(mesh, STEEL)
    stress = solid_stress(part)
    d = np.random.default_rng(0).standard_normal((3 * len(part.nodes), 4))
    s = stress.evaluate(d)
    some = stress.at([7, 3])
    assert some.sites == ("n40", "n80")
    np.testing.assert_allclose(some.evaluate(d), s[[3, 7]], rtol=1e-12)
    np.testing.assert_array_equal(some.positions, part.nodes[[3, 7]])
    turned = stress.select(["n80", "n40"])
    np.testing.assert_allclose(turned.evaluate(d[:, 0]), s[[7, 3], :, 0], rtol=1e-12)


def test_blocks_of_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    """Small blocks of columns and elements give the same numbers."""
    part = Part.solid(grid("wedge15", (3, 2, 2), SIZE), STEEL)
    d = np.random.default_rng(0).standard_normal((3 * len(part.nodes), 5))
    s = solid_stress(part).evaluate(d)
    monkeypatch.setattr("jousto.parts.solids.stress.BLOCK_BYTES", 1)
    np.testing.assert_allclose(solid_stress(part).evaluate(d), s, rtol=1e-12)


def test_rows_of_a_few_sites(rng: np.random.Generator) -> None:
    """The explicit operator of some sites is the one that goes element by element."""
    part = Part.solid(grid("tetra10", (3, 2, 2), SIZE, distort=0.25), STEEL)
    stress = solid_stress(part)
    sites = [stress.sites[i] for i in (17, 3, 40)]
    d = rng.standard_normal((part.K.shape[0], 2))
    found = (stress.rows(sites) @ d).reshape(3, 6, 2)
    np.testing.assert_allclose(found, stress.evaluate(d)[[17, 3, 40]], rtol=1e-12)
    assert stress.rows(sites).nnz < 0.8 * 18 * part.K.shape[0]
