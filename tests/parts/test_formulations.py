"""Formulations of solids: patch tests, zero energy, bending, stress and second-order forms."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from numpy.typing import NDArray

import jousto as jo
from jousto.base.errors import InputError, JoustoWarning
from jousto.materials.orthotropic import elasticity
from jousto.mesh.cells import Cells
from jousto.mesh.mesh import Mesh
from jousto.mesh.reference import FORMULATIONS, places
from jousto.parts.mesh_error import mesh_error
from jousto.parts.solids import bricks
from jousto.parts.solids.model import element_stiffness
from parts.grids import SPRUCE, grid

Array = NDArray[np.float64]
STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
WOOD = jo.materials.Orthotropic(**SPRUCE)
EVERY = [(kind, how) for kind, names in FORMULATIONS.items() for how in names]
BRICKS = FORMULATIONS["hexahedron"]


def of(mesh: Mesh, how: str, material=STEEL) -> jo.Part:
    return jo.Part.solid(mesh.formulated(how), material)


def linear(x: Array) -> Array:
    """Displacements of a constant gradient."""
    return x @ np.array([[1e-3, 4e-4, -2e-4], [3e-4, -2e-3, 5e-4], [7e-4, -1e-4, 8e-4]]).T


@pytest.mark.parametrize("material", [STEEL, WOOD], ids=["steel", "spruce"])
@pytest.mark.parametrize(("kind", "how"), EVERY)
def test_patch_of_distorted_elements(kind: str, how: str, material) -> None:
    part = of(grid(kind, (3, 3, 3), (0.3, 0.2, 0.1), distort=0.25), how, material)
    u = linear(part.nodes)
    f = (part.K @ u.ravel()).reshape(-1, 3)
    inner = np.all((part.nodes > 1e-9) & (part.nodes < np.ptp(part.nodes, axis=0) - 1e-9), axis=1)
    # no forces inside, to rounding of those on the faces
    assert np.abs(f[inner]).max() < 1e-11 * np.abs(f).max()
    gradient = linear(np.eye(3)).T
    e = [gradient[i, i] for i in range(3)]
    e += [gradient[i, j] + gradient[j, i] for i, j in ((0, 1), (1, 2), (0, 2))]
    s = elasticity(material) @ np.array(e)
    np.testing.assert_allclose(
        part.stress.evaluate(u.ravel()), np.tile(s, (len(part.nodes), 1)), atol=1e-9 * abs(s).max()
    )
    # and the exact energy
    volume = 0.3 * 0.2 * 0.1
    assert 0.5 * u.ravel() @ f.ravel() == pytest.approx(0.5 * volume * s @ e, rel=1e-11)


@pytest.mark.parametrize("how", BRICKS)
def test_only_rigid_motions_of_a_brick_have_no_energy(how: str) -> None:
    x = places("hexahedron") * (0.3, 0.2, 0.1)
    x = x + np.random.default_rng(2).uniform(-0.02, 0.02, x.shape)
    K = element_stiffness("hexahedron", x[None], elasticity(STEEL), how)[0]
    values = np.linalg.eigvalsh(K.transpose(0, 2, 1, 3).reshape(24, 24))
    # the hourglass stiffness is 1e-4 of the others
    assert np.sum(values < 1e-6 * values[-1]) == 6
    assert values[0] > -1e-12 * values[-1]


# changes of volume of trilinear displacements: 1, x, y, z, xy, yz, zx
@pytest.mark.parametrize(("how", "number"), [("full", 7), ("bbar", 1), ("reduced", 1)])
def test_how_many_motions_feel_the_bulk_modulus(how: str, number: int) -> None:
    C = np.eye(6)
    C[:3, :3] = 2.0 * np.eye(3) + 1e9  # lambda is 1e9 mu
    K = element_stiffness("hexahedron", places("hexahedron")[None], C, how)[0]
    values = np.linalg.eigvalsh(K.transpose(0, 2, 1, 3).reshape(24, 24))
    assert np.sum(values > 1e5) == number


def cantilever(counts: tuple[int, int, int], how: str, nu: float = 0.3) -> tuple[jo.Part, Array]:
    """A bar of 300 x 20 x 10 mm and its displacements under a moment about y at its end."""
    part = of(grid("hexahedron", counts, (0.3, 0.02, 0.01)), how, replace(STEEL, nu=nu))
    x = part.nodes
    # a linear traction over the end, consistent with bilinear faces: F = int N^T s dA
    f = np.zeros((len(x), 3))
    y, z = (np.unique(np.round(x[:, i], 12)) for i in (1, 2))
    share_y = np.convolve(np.diff(y), [0.5, 0.5])
    h = np.diff(z)
    of_z = np.zeros(len(z))
    for k in range(len(h)):  # int N_a z dz over a layer, z from the middle
        a, b = z[k] - 0.005, z[k + 1] - 0.005
        of_z[k] += h[k] * (2 * a + b) / 6
        of_z[k + 1] += h[k] * (a + 2 * b) / 6
    end = np.flatnonzero(x[:, 0] > 0.3 - 1e-9)
    j, k = np.searchsorted(y, x[end, 1] - 1e-9), np.searchsorted(z, x[end, 2] - 1e-9)
    f[end, 0] = share_y[j] * of_z[k] / (0.02 * 0.01**3 / 12)  # stress z / I of 1 N m
    # the clamped end may contract: only x is held there, and the middle against the rest
    held = [3 * i for i in np.flatnonzero(x[:, 0] < 1e-9)]
    corner = int(np.argmin(x.sum(axis=1)))
    beside = int(np.flatnonzero((x[:, 0] < 1e-9) & (x[:, 1] > 0.02 - 1e-9) & (x[:, 2] < 1e-9))[0])
    held += [3 * corner + 1, 3 * corner + 2, 3 * beside + 2]
    free = np.setdiff1d(np.arange(f.size), held)
    u = np.zeros(f.size)
    u[free] = spla.spsolve(part.K[free][:, free].tocsc(), f.ravel()[free])
    return part, u


@pytest.mark.parametrize("nu", [0.0, 0.3])
def test_incompatible_bricks_bend_exactly(nu: float) -> None:
    # pure bending: s11 = M z / I and the deflection M L^2 / (2 E I), with one layer of bricks
    part, u = cantilever((6, 1, 1), "incompatible", nu)
    I = 0.02 * 0.01**3 / 12
    s = part.stress.evaluate(u)
    exact = np.zeros_like(s)
    exact[:, 0] = (part.stress.positions[:, 2] - 0.005) / I
    np.testing.assert_allclose(s, exact, atol=1e-8 * 0.005 / I)
    end = part.nodes[:, 0] > 0.3 - 1e-9
    bottom = part.nodes[:, 2] < 1e-9
    w = u.reshape(-1, 3)[end & bottom, 2]
    np.testing.assert_allclose(w, -(0.3**2) / (2 * STEEL.E * I), rtol=1e-9)


@pytest.mark.parametrize("layers", [2, 4])
def test_mean_strain_bends_as_layers_of_constant_stress(
    layers: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    # n layers of constant stress have 1 - 1/n^2 of the second moment
    exact = -(0.3**2) / (2 * STEEL.E * 0.02 * 0.01**3 / 12 * (1 - 1 / layers**2))

    def end() -> Array:
        part, u = cantilever((30, 1, layers), "reduced", nu=0.0)
        return u.reshape(-1, 3)[(part.nodes[:, 0] > 0.3 - 1e-9) & (part.nodes[:, 2] < 1e-9), 2]

    stiff = end()
    monkeypatch.setattr(bricks, "HOURGLASS", 1e-5 * bricks.HOURGLASS)
    np.testing.assert_allclose(end(), exact, rtol=1e-4)
    # the hourglass stiffness holds some of it, a few percent where bricks are flat
    assert np.all(np.abs(stiff) > 0.97 * abs(exact)) and np.all(np.abs(stiff) < abs(exact))


@pytest.mark.parametrize(("kind", "how"), EVERY)
def test_forces_and_geometric_stiffness_are_one_form(kind: str, how: str) -> None:
    # d . int B^T C eta(x_j, x_k) = int s(d) : eta(x_j, x_k) = x_j . Kg(d) x_k
    part = of(grid(kind, (2, 2, 2), (0.3, 0.2, 0.1), distort=0.2), how)
    rng = np.random.default_rng(4)
    d, X = rng.normal(size=3 * len(part.nodes)), rng.normal(size=(3 * len(part.nodes), 4))
    second = part.second_order
    Kg = second.geometric_stiffness(d)
    for j in range(2):
        left, right = d @ second.forces(X, j), X[:, j] @ (Kg @ X)
        np.testing.assert_allclose(left, right, rtol=1e-9, atol=1e-9 * np.abs(right).max())


@pytest.mark.parametrize("how", BRICKS)
def test_second_order_forces_hold_a_rotation(how: str) -> None:
    # a rotation u = W x has second-order displacements W^2 x, which cancel its strain
    part = of(grid("hexahedron", (2, 2, 2), (0.3, 0.2, 0.1), distort=0.2), how)
    w = np.array([0.3, -0.5, 0.8])
    W = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    X = (part.nodes @ W.T).reshape(-1, 1)
    chi = (part.nodes @ (W @ W).T).ravel()
    f = part.second_order.forces(X, 0)[:, 0]
    np.testing.assert_allclose(part.K @ chi, -f, atol=1e-9 * np.abs(f).max())


@pytest.mark.parametrize("how", ["incompatible", "reduced"])
def test_column_buckles_at_eulers_load(how: str) -> None:
    # clamped and free, 200 x 10 x 10 mm: pi^2 E I / (4 L^2); 4 layers of mean strain lose 1/16 of I
    part = of(grid("hexahedron", (40, 4, 4), (0.2, 0.01, 0.01)), how, replace(STEEL, nu=0.0))
    x = part.nodes
    free = np.setdiff1d(
        np.arange(3 * len(x)), 3 * np.flatnonzero(x[:, 0] < 1e-9)[:, None] + [0, 1, 2]
    )
    # unit compression: u = -x / (E A)
    d = np.zeros((len(x), 3))
    d[:, 0] = -x[:, 0] / (STEEL.E * 1e-4)
    Kg = part.second_order.geometric_stiffness(d.ravel())[free][:, free]
    values = spla.eigsh(-Kg, 1, part.K[free][:, free], sigma=None, which="LA")[0]
    euler = np.pi**2 * STEEL.E * 1e-8 / 12 / (4 * 0.2**2)
    expected = euler if how == "incompatible" else euler * (1 - 1 / 16)
    # shear softens by 3 parts in 1000, the hourglass stiffness stiffens by as much
    assert 1.0 / values[-1] == pytest.approx(expected, rel=0.01)


def test_energy_of_the_error_estimate_is_that_of_the_elements() -> None:
    part, u = cantilever((6, 1, 1), "incompatible")
    found = mesh_error(part, u)
    assert found.energy[0] == pytest.approx(float(u @ part.K @ u), rel=1e-10)
    # the stress is exact, so that there is no error
    assert found.eta[0] < 1e-6


def test_formulation_of_a_part_and_of_its_copies(tmp_path: Path) -> None:
    mesh = grid("hexahedron", (6, 1, 1), (0.3, 0.02, 0.01))
    option = jo.Part.solid(mesh, STEEL, formulation="incompatible")
    assert (abs(option.K - of(mesh, "incompatible").K)).max() == 0.0
    assert option.mesh.solids[0].formulation == "incompatible"
    for copy in (option.mesh.solid(), option.mesh.merged(), option.mesh.scaled(2.0)):
        assert copy.solids[0].formulation == "incompatible"
    # a deck keeps it
    for how, name in (("incompatible", "C3D8I"), ("reduced", "C3D8R"), ("bbar", "C3D8H")):
        jo.write(mesh.formulated(how), tmp_path / "bar.inp")
        assert f"TYPE={name}" in (tmp_path / "bar.inp").read_text()
        assert jo.read_mesh(tmp_path / "bar.inp").solids[0].formulation == how
    with pytest.warns(JoustoWarning, match="no element for hexahedron 'bbar'; give formulation="):
        jo.write(mesh.formulated("bbar"), tmp_path / "bar.vtu")
    with pytest.warns(JoustoWarning, match="no element for wedge 'full'"):
        jo.write(grid("wedge", (1, 1, 1)), tmp_path / "wedge.inp")


def test_reductions_and_their_files_differ_by_formulation(tmp_path: Path) -> None:
    mesh = grid("hexahedron", (6, 1, 1), (0.3, 0.02, 0.01))
    found = {}
    for how in BRICKS:
        part = jo.Part.solid(mesh, STEEL, formulation=how)
        reduced = jo.reduce(part, jo.FreeFree(3), cache=tmp_path / "cache")
        again = jo.reduce(part, jo.FreeFree(3), cache=tmp_path / "cache")
        np.testing.assert_array_equal(again.frequencies, reduced.frequencies)
        reduced.save(tmp_path / f"{how}.h5")
        loaded = jo.ReducedPart.load(tmp_path / f"{how}.h5")
        np.testing.assert_array_equal(loaded.frequencies, reduced.frequencies)
        found[how] = reduced.frequencies
    values = np.array(list(found.values()))
    assert np.all(np.abs(np.diff(values[:, 0])) > 0.01 * values[:-1, 0])


def test_wrong_formulations_are_refused() -> None:
    mesh = grid("tetra10", (1, 1, 1))
    with pytest.raises(InputError, match=r"'bbar' \(only hexahedron have it\); it has tetra10"):
        jo.Part.solid(mesh, STEEL, formulation="bbar")
    with pytest.raises(InputError, match="formulation is 'exact', must be 'own', 'full'"):
        jo.Part.solid(mesh, STEEL, formulation="exact")
    with pytest.raises(InputError, match="'sharp' .known: full, bbar, incompatible, reduced"):
        mesh.formulated("sharp")
    with pytest.raises(InputError, match="has no formulation 'bbar'; it has full"):
        Cells("tetra", [(0, 1, 2, 3)], formulation="bbar")


@pytest.mark.parametrize(
    ("how", "status", "sentence"),
    [
        ("full", "warn", "too stiff in bending"),
        ("bbar", "warn", "too stiff in bending"),
        ("incompatible", "ok", "accurate in bending"),
        ("reduced", "warn", "too soft in bending"),
    ],
)
def test_certificate_names_the_formulation(how: str, status: str, sentence: str) -> None:
    mesh = grid("hexahedron", (6, 1, 1), (0.3, 0.02, 0.01))
    part = jo.Part.solid(mesh, STEEL, formulation=how)
    found = jo.certificate.certify(part, jo.reduce(part, jo.FreeFree(3)))
    (check,) = [check for check in found.checks if check.topic == "elements"]
    assert (check.status, sentence in check.sentence) == (status, True)
    assert check.value == ("6 hexahedron" if how == "full" else f"6 hexahedron ({how})")
