"""Stress of solids at their nodes: exact fields, materials that meet, the choice of sites."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from jousto.base.errors import InputError
from jousto.materials.material import Material
from jousto.materials.orthotropic import Orthotropic, elasticity
from jousto.mesh.picks import InBox
from jousto.parts.interface import Interface
from jousto.parts.part import Part
from jousto.parts.solids.stress import SolidStress
from jousto.reduction.methods import FreeFree
from jousto.reduction.reducer import reduce
from jousto.sections.section import Circle
from parts.grids import ALL, grid
from parts.test_solids import WOOD

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
    mesh = replace(mesh, node_ids=mesh.node_ids * 10)
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


def test_rows_of_many_sites_take_blocks_of_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows of all sites are sparse, and no more than a block of them is ever dense."""
    part = Part.solid(grid("tetra", (6, 6, 6), SIZE), STEEL)
    stress = solid_stress(part)
    whole = stress.rows(stress.sites)
    full = 8 * (len(stress) * 6) * part.K.shape[0]
    monkeypatch.setattr("jousto.parts.solids.stress.ROWS_BYTES", full // 20)
    monkeypatch.setattr("jousto.parts.solids.stress.BLOCK_BYTES", full // 20)
    tracemalloc.start()
    rows = stress.rows(stress.sites)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 0.5 * full
    assert abs(rows - whole).max() <= 1e-15 * abs(whole).max()
    d = np.random.default_rng(0).standard_normal(part.K.shape[0])
    np.testing.assert_allclose(
        (rows @ d).reshape(-1, 6), stress.evaluate(d), atol=1e-9 * np.abs(stress.evaluate(d)).max()
    )


@pytest.mark.parametrize("kind", ALL)
@pytest.mark.parametrize("law", [STEEL, WOOD], ids=["isotropic", "orthotropic"])
def test_free_surface_of_a_linear_field(kind: str, law: Material | Orthotropic) -> None:
    """The strain along a face is kept, the stress across it taken away: s n = 0 and no other."""
    part = Part.solid(grid(kind, (3, 2, 2), SIZE, distort=0.25), law)
    g = 1e-3 * np.random.default_rng(0).standard_normal((3, 3))
    top = np.flatnonzero(part.nodes[:, 2] > SIZE[2] - 1e-9)
    s = part.surface_stress(top).evaluate((part.nodes @ g.T).ravel())
    assert len(s) == len(top)
    scale = np.abs(s).max()
    np.testing.assert_allclose(s[:, [2, 4, 5]], 0.0, atol=1e-10 * scale)
    e = np.linalg.solve(elasticity(law), s[0])
    np.testing.assert_allclose(e[[0, 1, 3]], [g[0, 0], g[1, 1], g[0, 1] + g[1, 0]], rtol=1e-9)
    np.testing.assert_allclose(s, np.tile(s[0], (len(s), 1)), atol=1e-9 * scale)


def test_free_surface_of_a_bar() -> None:
    """A pulled bar: the same stress from inside and from the skin, edges and corners included."""
    part = Part.solid(grid("tetra10", (3, 2, 2), SIZE), STEEL)
    nu = STEEL.nu
    d = 1e-3 * part.nodes * [1.0, -nu, -nu]
    inside = np.all((part.nodes > 1e-9) & (part.nodes < SIZE - 1e-9), axis=1)
    sides = np.flatnonzero(~inside & (part.nodes[:, 0] > -1.0))
    skin = part.surface_stress(InBox((-1, -1, -1), (1, 1, SIZE[2])))
    assert len(skin.sites) == len(sides)
    on_top = part.surface_stress(np.flatnonzero(part.nodes[:, 1] > SIZE[1] - 1e-9))
    exact = np.tile([1e-3 * STEEL.E, 0, 0, 0, 0, 0], (len(on_top.sites), 1))
    np.testing.assert_allclose(on_top.evaluate(d.ravel()), exact, atol=1e-10 * STEEL.E)
    normals = part.surface_normals
    assert np.all(normals[inside] == 0.0)
    np.testing.assert_allclose(np.linalg.norm(normals[sides], axis=1), 1.0)


def test_normals_of_a_ball() -> None:
    """Normals of a shell's surfaces are those of the spheres, to the accuracy of parabolas."""

    def shell(x: Array) -> Array:
        r, a, b = 0.1 + 0.1 * x[:, 2], x[:, 0] - 0.5, x[:, 1] - 0.5
        return np.column_stack(
            [r * np.sin(a) * np.cos(b), r * np.sin(b), r * np.cos(a) * np.cos(b)]
        )

    part = Part.solid(grid("hexahedron20", (4, 4, 2), bend=shell), STEEL)
    r = np.linalg.norm(part.nodes, axis=1)
    radial = part.nodes / r[:, None]
    # not at the rim, where normals of two surfaces meet
    inner = np.abs(part.nodes[:, :2]).max(axis=1) < 0.3 * r
    for radius, sign in ((0.1, -1.0), (0.2, 1.0)):
        on = inner & (np.abs(r - radius) < 1e-9)
        error = np.linalg.norm(part.surface_normals[on] - sign * radial[on], axis=1)
        assert error.max() < 1e-4
    assert np.all(part.surface_normals[inner & (np.abs(r - 0.15) < 0.01)] == 0.0)


def test_interfaces_are_not_free() -> None:
    """Faces of an interface carry loads: the skin's stress leaves them out unless asked."""
    mesh = grid("hexahedron20", (3, 1, 1), SIZE)
    mesh = mesh.with_set("end", np.flatnonzero(mesh.nodes[:, 0] > SIZE[0] - 1e-9))
    part = Part.solid(mesh, STEEL, interfaces=[Interface("pin", "end")])
    free, everything = part.surface_stress(), part.surface_stress(np.arange(len(part.nodes)))
    d = np.zeros((len(part.nodes), 3))
    d[:, 0] = 1e-3 * part.nodes[:, 0]
    # at the edge of the interface the side faces alone count
    edge = np.flatnonzero((part.nodes[:, 0] > SIZE[0] - 1e-9) & (part.nodes[:, 2] < 1e-9))
    site = f"n{mesh.node_ids[edge[0]]}"
    E, nu = STEEL.E, STEEL.nu
    s = free.select([site]).evaluate(d.ravel())[0]
    # no strain across: the plane state of the side faces is exact for linear displacements
    assert s[0] == pytest.approx(1e-3 * E / (1 - nu**2), rel=1e-9)
    assert everything.select([site]).evaluate(d.ravel())[0, 0] < s[0]


def test_reduction_with_a_chosen_stress() -> None:
    """A part takes the stress operator it is given, and reductions with it."""
    part = Part.solid(grid("hexahedron20", (4, 1, 1), SIZE), STEEL)
    skin = part.with_stress(part.surface_stress([*range(len(part.nodes))]))
    r = reduce(skin, FreeFree(modes=2))
    assert r.stress is not None
    assert r.stress.labels == skin.stress.sites  # type: ignore[union-attr]
    assert reduce(part.with_stress(None), FreeFree(modes=2)).stress is None
    with pytest.raises(InputError, match="no outer face has all its nodes in the pick"):
        part.surface_stress([0, 1])
    with pytest.raises(InputError, match="has no surface"):
        Part.beam(1.0, Circle(0.01), 2, STEEL).surface_stress()
