"""Solid elements: patch tests, mass properties, materials, what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from jousto.base.errors import InputError, JoustoWarning
from jousto.materials.library import material, names
from jousto.materials.material import Material
from jousto.materials.orthotropic import Orthotropic, elasticity, strain_rotation
from jousto.mesh.cells import Cells
from jousto.mesh.mesh import Mesh
from jousto.mesh.reference import places, rule, shape_functions, table
from jousto.parts.mass import PointMass
from jousto.parts.part import Part
from jousto.reduction.reducer import invariants
from parts.grids import ALL, SPRUCE, grid

Array = NDArray[np.float64]
STEEL = Material(E=210e9, nu=0.3, rho=7850.0, name="steel")
SIZE = np.array([0.9, 0.3, 0.2])
WOOD = Orthotropic(**SPRUCE, axes=np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]))


def block(kind: str, distort: float = 0.2) -> Part:
    return Part.solid(grid(kind, (3, 2, 2), SIZE, distort=distort), STEEL)


def surface(part: Part, size: Array = SIZE) -> NDArray[np.bool_]:
    """Nodes on the outside of a box."""
    x = part.nodes
    return np.asarray(np.any((x < 1e-9) | (x > size - 1e-9), axis=1))


def voigt(e: Array) -> Array:
    return np.array([e[0, 0], e[1, 1], e[2, 2], 2 * e[0, 1], 2 * e[1, 2], 2 * e[0, 2]])


@pytest.mark.parametrize("kind", ALL)
def test_shape_functions(kind: str) -> None:
    """One at their node and zero at the others; derivatives are those of the functions."""
    N, _ = shape_functions(kind, places(kind))
    np.testing.assert_allclose(N, np.eye(len(N)), atol=1e-13)
    x, h = table(kind, "stiffness").points, 1e-6
    _, dN = shape_functions(kind, x)
    for d in range(3):
        step = h * np.eye(3)[d]
        ahead, behind = (shape_functions(kind, x + s)[0] for s in (step, -step))
        np.testing.assert_allclose(dN[:, d], (ahead - behind) / (2 * h), atol=1e-8)


@pytest.mark.parametrize(
    ("kind", "volume"), [("tetra", 1 / 6), ("hexahedron", 1.0), ("wedge", 0.5)]
)
def test_quadrature(kind: str, volume: float) -> None:
    """Integrals of x^a y^b z^c over the reference elements, in closed form."""
    from math import factorial as f

    for degree in (1, 3, 5):
        x, w = rule(kind, degree, degree)
        assert w.sum() == pytest.approx(volume, rel=1e-13)
        for a in range(degree + 1):
            for b in range(degree + 1 - a):
                for c in range(degree + 1 - a - b):
                    exact = {
                        "tetra": f(a) * f(b) * f(c) / f(a + b + c + 3),
                        "hexahedron": 1.0 / ((a + 1) * (b + 1) * (c + 1)),
                        "wedge": f(a) * f(b) / f(a + b + 2) / (c + 1),
                    }[kind]
                    found = w @ (x[:, 0] ** a * x[:, 1] ** b * x[:, 2] ** c)
                    assert found == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("kind", ALL)
@pytest.mark.parametrize("law", [STEEL, WOOD], ids=["isotropic", "orthotropic"])
def test_patch(kind: str, law: Material | Orthotropic) -> None:
    """A linear field on the boundary gives the same field inside, and its energy."""
    part = Part.solid(grid(kind, (3, 2, 2), SIZE, distort=0.25), law)
    g = 1e-3 * np.random.default_rng(0).standard_normal((3, 3))
    exact = part.nodes @ g.T
    free = np.flatnonzero(np.repeat(~surface(part), 3))
    K = part.K.toarray()
    u = exact.ravel().copy()
    u[free] = 0.0
    u[free] = np.linalg.solve(K[np.ix_(free, free)], -(K @ u)[free])
    np.testing.assert_allclose(u.reshape(-1, 3), exact, atol=1e-12 * np.abs(exact).max())
    e = voigt(0.5 * (g + g.T))
    energy = 0.5 * SIZE.prod() * e @ elasticity(law) @ e
    assert 0.5 * u @ K @ u == pytest.approx(energy, rel=1e-12)


@pytest.mark.parametrize("kind", ["tetra10", "hexahedron"])
def test_against_the_assembly_of_scikit_fem(kind: str) -> None:
    """Another program's elements, mapping and assembly: the same eigenvalues of K and M."""
    import skfem
    from skfem.helpers import dot
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    mesh = grid(kind, (2, 2, 1), SIZE, distort=0.2)
    part = Part.solid(mesh, STEEL)
    corners = mesh.cells[0].nodes[:, : len(places(kind.rstrip("0123456789")))]
    used, t = np.unique(corners, return_inverse=True)
    t = t.reshape(corners.shape)
    if kind == "tetra10":
        theirs = skfem.MeshTet(np.array(mesh.nodes[used].T), np.array(t.T))
        element = skfem.ElementTetP2()
    else:
        # their hexahedron counts its corners from (1, 1, 1)
        at = np.asarray(skfem.ElementHex1().doflocs)
        order = [int(np.abs(places(kind) - x).max(axis=1).argmin()) for x in at]
        theirs = skfem.MeshHex(np.array(mesh.nodes[used].T), np.array(t[:, order].T))
        element = skfem.ElementHex1()
    degree = {"tetra10": (2, 4), "hexahedron": (3, 5)}[kind]
    vector = skfem.ElementVector(element)
    form = linear_elasticity(*lame_parameters(STEEL.E, STEEL.nu))
    K = form.assemble(skfem.Basis(theirs, vector, intorder=degree[0])).toarray()
    mass = skfem.BilinearForm(lambda u, v, w: STEEL.rho * dot(u, v))
    M = mass.assemble(skfem.Basis(theirs, vector, intorder=degree[1])).toarray()
    for ours, wanted in ((part.K, K), (part.M, M)):
        values, exact = np.linalg.eigvalsh(ours.toarray()), np.linalg.eigvalsh(wanted)
        np.testing.assert_allclose(values, exact, atol=1e-12 * exact[-1])


@pytest.mark.parametrize("kind", ALL)
def test_free(kind: str) -> None:
    """Symmetric, and six motions without forces: no mechanism, no support."""
    K = block(kind).K.toarray()
    np.testing.assert_array_equal(K, K.T)
    values = np.linalg.eigvalsh(K)
    assert np.all(np.abs(values[:6]) < 1e-12 * values[-1])
    assert values[6] > 1e-5 * values[-1]


@pytest.mark.parametrize("kind", ALL)
@pytest.mark.parametrize("lumped", [False, True])
def test_mass_of_a_box(kind: str, lumped: bool) -> None:
    """Mass, centre and inertia of a box; lumped mass keeps the mass alone exactly."""
    part = Part.solid(grid(kind, (3, 2, 2), SIZE, distort=0.2), STEEL, lumped=lumped)
    mass = STEEL.rho * SIZE.prod()
    assert part.mass == pytest.approx(mass, rel=1e-13)
    assert np.all(np.linalg.eigvalsh(part.M.toarray()) > 0.0)
    if not lumped:
        a, b, c = SIZE**2
        exact = mass / 12.0 * np.diag([b + c, a + c, a + b])
        np.testing.assert_allclose(part.center, SIZE / 2, rtol=1e-13)
        np.testing.assert_allclose(part.inertia, exact, atol=1e-13 * mass)


@pytest.mark.filterwarnings("ignore:.*pairs of coincident nodes")
def test_mass_of_a_tube() -> None:
    """A curved mesh: the volume between the parabolas that stand for the arcs, in closed form.

    On an edge of angle ``2 a`` the parabola through ends and middle of the arc encloses
    ``r^2 (sin a cos a + 4/3 sin a (1 - cos a))``: the triangle and two thirds of the rectangle.
    """
    n, r, R, L = 8, 0.4, 0.5, 0.3

    def bend(x: Array) -> Array:
        angle = -2.0 * np.pi * x[:, 0]
        out = np.column_stack([x[:, 1] * np.cos(angle), x[:, 1] * np.sin(angle), x[:, 2]])
        return out

    mesh = grid("hexahedron20", (n, 1, 1), (1.0, R - r, L), bend=lambda x: bend(x + [0, r, 0]))
    part = Part.solid(mesh, STEEL)
    a = np.pi / n
    area = n * (R**2 - r**2) * (np.sin(a) * np.cos(a) + 4.0 / 3.0 * np.sin(a) * (1.0 - np.cos(a)))
    assert part.mass == pytest.approx(STEEL.rho * area * L, rel=1e-12)
    assert part.mass == pytest.approx(STEEL.rho * np.pi * (R**2 - r**2) * L, rel=1e-3)


def test_two_materials() -> None:
    """A bar of two halves pulled along: the mass of both, the stretch of springs in a row."""
    soft = Material(E=70e9, nu=0.0, rho=2700.0, name="soft")
    hard = Material(E=210e9, nu=0.0, rho=7850.0, name="hard")
    mesh = grid(
        "hexahedron20",
        (4, 1, 1),
        (1.0, 0.1, 0.1),
        materials=lambda x: np.where(x[:, 0] < 0.5, "left", "right"),
    )
    part = Part.solid(mesh, {"left": soft, "right": hard})
    assert part.mass == pytest.approx(0.005 * (2700.0 + 7850.0))
    ends = [np.flatnonzero(np.abs(part.nodes[:, 0] - x) < 1e-9) for x in (0.0, 1.0)]
    u = np.zeros(part.K.shape[0])
    u[3 * ends[1]] = 1e-3
    held = np.concatenate([3 * ends[0], 3 * ends[0] + 1, 3 * ends[0] + 2, 3 * ends[1]])
    free = np.setdiff1d(np.arange(len(u)), held)
    K = part.K.toarray()
    u[free] = np.linalg.solve(K[np.ix_(free, free)], -(K @ u)[free])
    force = (K @ u)[3 * ends[1]].sum()
    assert force == pytest.approx(1e-3 * 0.01 / (0.5 / 70e9 + 0.5 / 210e9), rel=1e-9)


def test_orthotropic_strains() -> None:
    """Pulls along the material axes give the strains that define the moduli."""
    S = np.linalg.inv(elasticity(WOOD))
    to_material = strain_rotation(np.asarray(WOOD.axes))
    S = to_material @ S @ to_material.T
    np.testing.assert_allclose(1.0 / np.diag(S)[:3], [11e9, 0.9e9, 0.5e9])
    np.testing.assert_allclose(1.0 / np.diag(S)[3:], [0.75e9, 0.04e9, 0.72e9])
    np.testing.assert_allclose(-S[[1, 2], 0] * 11e9, [0.37, 0.42])
    assert -S[2, 1] * 0.9e9 == pytest.approx(0.47)


def test_orthotropic_with_isotropic_values() -> None:
    G = STEEL.G
    same = Orthotropic(
        E1=210e9, E2=210e9, E3=210e9, nu12=0.3, nu13=0.3, nu23=0.3, G12=G, G13=G, G23=G,
        rho=7850.0, axes=np.asarray(WOOD.axes),
    )  # fmt: skip
    np.testing.assert_allclose(elasticity(same), elasticity(STEEL), atol=1e-3)


def test_orthotropic_refusals() -> None:
    good = dict.fromkeys(("E1", "E2", "E3", "G12", "G13", "G23"), 1e9)
    good |= dict.fromkeys(("nu12", "nu13", "nu23"), 0.3) | {"E1": 11e9}
    with pytest.raises(InputError, match="not positive definite"):
        Orthotropic(**{**good, "nu12": 3.4}, rho=400.0)
    with pytest.raises(InputError, match="E2 is -1") as caught:
        Orthotropic(**{**good, "E2": -1.0}, rho=400.0, axes=2.0 * np.eye(3))
    assert "unit vectors" in str(caught.value)
    with pytest.raises(InputError, match="right-handed"):
        Orthotropic(**good, rho=400.0, axes=np.diag([1.0, 1.0, -1.0]))


def test_point_masses() -> None:
    """On one node, and with inertia and offset on a face: the box's values and Steiner's."""
    mesh = grid("hexahedron20", (2, 1, 1), SIZE)
    mesh = mesh.with_set("end", np.flatnonzero(mesh.nodes[:, 0] > SIZE[0] - 1e-9))
    J = np.diag([0.5, 0.6, 0.7])
    part = Part.solid(
        mesh,
        STEEL,
        point_masses=(PointMass(0, 3.0), PointMass("end", 20.0, inertia=J, offset=(0.1, 0, 0.2))),
    )
    bare = Part.solid(mesh, STEEL)
    m = np.array([bare.mass, 3.0, 20.0])
    x = np.stack([bare.center, [0, 0, 0], np.array([1.0, 0.15, 0.3])])
    centre = m @ x / m.sum()
    r = x - centre
    exact = bare.inertia + J + (m @ (r**2).sum(axis=1)) * np.eye(3) - r.T @ (m[:, None] * r)
    assert part.mass == pytest.approx(m.sum(), rel=1e-12)
    np.testing.assert_allclose(part.center, centre, rtol=1e-12)
    np.testing.assert_allclose(part.inertia, exact, atol=1e-10)
    with pytest.raises(InputError, match="three nodes"):
        Part.solid(mesh, STEEL, point_masses=[PointMass(0, 1.0, inertia=(1, 1, 1))])


def test_invariants_with_point_masses() -> None:
    """Mass integrals of two rigid motions as modes: those of the body with its attached mass."""
    mesh = grid("hexahedron20", (2, 1, 1), SIZE)
    mesh = mesh.with_set("end", np.flatnonzero(mesh.nodes[:, 0] > SIZE[0] - 1e-9))
    mass = PointMass("end", 20.0, inertia=(0.5, 0.6, 0.7), offset=(0.1, 0.0, 0.2))
    part = Part.solid(mesh, STEEL, point_masses=[mass])
    found = invariants(part, part.rigid_modes())
    c, m = part.center, part.mass
    J = part.inertia + m * (c @ c * np.eye(3) - np.outer(c, c))
    np.testing.assert_allclose(found.I7, J, rtol=1e-11, atol=1e-10)
    # two turns: int (e_a x u0) . (e_b x u0) dm
    np.testing.assert_allclose(found.I6[3:, 3:], J, rtol=1e-11, atol=1e-10)
    np.testing.assert_allclose(found.I4[:, 3:], J, rtol=1e-11, atol=1e-10)
    np.testing.assert_allclose(found.I2, m * c, rtol=1e-12)


def test_weighed_mass() -> None:
    """Densities meet the scale's reading; a reading far off is doubted."""
    mesh = grid("tetra10", (2, 1, 1), SIZE)
    mass = STEEL.rho * SIZE.prod()
    part = Part.solid(mesh, STEEL, weighed_mass=1.03 * mass + 2.0, point_masses=[PointMass(1, 2.0)])
    assert part.mass == pytest.approx(1.03 * mass + 2.0, rel=1e-12)
    assert part.solids is not None
    assert part.solids.density_factor == pytest.approx(1.03)
    with pytest.warns(JoustoWarning, match="check units"):
        Part.solid(mesh, STEEL, weighed_mass=2.0 * mass)
    with pytest.raises(InputError, match="point masses alone are 500 kg"):
        Part.solid(mesh, STEEL, weighed_mass=450.0, point_masses=[PointMass(0, 500.0)])


def test_refusals() -> None:
    mesh = grid("tetra", (2, 1, 1), materials=lambda x: np.where(x[:, 0] < 0.5, "left", "right"))
    with pytest.raises(
        InputError, match="no element set 'lef' for a material; did you mean 'left'"
    ):
        Part.solid(mesh, {"lef": STEEL})
    with pytest.raises(InputError, match=r"6 elements have no material \(element 7, 8"):
        Part.solid(mesh, {"left": STEEL})
    both = replace(mesh, element_sets={**mesh.element_sets, "all": np.arange(12)})
    with pytest.raises(InputError, match="6 elements have two materials"):
        Part.solid(both, {"left": STEEL, "all": STEEL})
    with pytest.raises(InputError, match="lock above"):
        Part.solid(mesh, Material(E=1e9, nu=0.5, rho=1000.0))
    nodes = mesh.cells[0].nodes.copy()
    nodes[3] = nodes[3][[1, 0, 2, 3]]
    with pytest.raises(InputError, match="1 element of negative or zero volume: element 4"):
        Part.solid(replace(mesh, cells=(Cells("tetra", nodes),)), STEEL)
    shell = Mesh("shell", mesh.nodes, Cells("triangle", nodes[:, :3]))
    with pytest.raises(InputError, match="no solid elements .* it has triangle only"):
        Part.solid(shell, STEEL)
    mixed = replace(mesh, cells=(*mesh.cells, Cells("pyramid", [[0, 1, 2, 3, 4]])))
    with pytest.raises(InputError, match="pyramid elements, which have no stiffness"):
        Part.solid(mixed, STEEL)


def test_what_is_no_mesh() -> None:
    with pytest.raises(InputError, match="mesh is 'arm.msh', must be a Mesh"):
        Part.solid("arm.msh", STEEL)  # type: ignore[arg-type]


def test_materials_by_the_names_in_the_file() -> None:
    """Blocks of cells name their material; so may the caller."""
    mesh = grid("hexahedron", (2, 1, 1))
    nodes = mesh.cells[0].nodes
    cells = (
        Cells("hexahedron", nodes[:1], material="A"),
        Cells("hexahedron", nodes[1:], material="B"),
    )
    light = Material(E=70e9, nu=0.3, rho=2700.0)
    part = Part.solid(replace(mesh, cells=cells), {"B": light, "A": STEEL})
    assert part.mass == pytest.approx(0.5 * (7850.0 + 2700.0))


def test_unused_nodes_are_left_out() -> None:
    mesh = grid("hexahedron", (1, 1, 1))
    nodes = np.concatenate([[[5.0, 5.0, 5.0]], mesh.nodes])
    cells = Cells("hexahedron", mesh.cells[0].nodes + 1)
    ids = np.concatenate([[99], mesh.node_ids])
    loose = Mesh("box", nodes, cells, node_ids=ids, node_sets={"corner": [0, 1]})
    with pytest.warns(JoustoWarning, match=r"1 node of .* left out \(node 99\)"):
        part = Part.solid(loose, STEEL)
    assert len(part.nodes) == 8
    assert part.node_sets["corner"] == (0,)
    assert part.surface_stress().sites[0] == "n1"


@pytest.mark.parametrize("name", names())
def test_library(name: str) -> None:
    """Every material is plausible, says its source and is found under its name."""
    m = material(name)
    assert m.source
    assert m.name == name
    # speed of sound sqrt(E/rho): near 5 km/s in metals but cast iron, 1 to 3 km/s in polymers
    assert (3500.0 if m.rho > 1500.0 else 1000.0) < np.sqrt(m.E / m.rho) < 5300.0
    assert material(name.lower().replace("-", " ")).name == name


def test_library_refusal() -> None:
    with pytest.raises(InputError, match=r"no 'S356'; did you mean 'S35"):
        material("S356")
