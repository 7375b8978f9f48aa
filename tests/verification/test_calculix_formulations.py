"""Formulations of solids against CalculiX and against a published table.

R. H. MacNeal and R. L. Harder, A proposed standard set of problems to test finite element accuracy,
*Finite Elements in Analysis and Design* 1 (1985) 3-20.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import scipy.sparse.linalg as spla

import jousto as jo
from jousto.mesh.mesh import Mesh
from parts.grids import grid
from verification import calculix
from verification.calculix import Deck, frequencies, needed
from verification.solids import dofs

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
TYPES = [
    ("hexahedron", "full", "C3D8"),
    ("hexahedron", "incompatible", "C3D8I"),
    ("hexahedron", "reduced", "C3D8R"),
    ("hexahedron20", "full", "C3D20"),
    ("hexahedron20", "reduced", "C3D20R"),
    ("wedge", "reduced", "C3D6"),
    ("wedge15", "reduced", "C3D15"),
    ("tetra", "full", "C3D4"),
    ("tetra10", "full", "C3D10"),
]
# ccx forms these otherwise where elements are no parallelepipeds: the derivatives of its
# incompatible modes have another mean than zero, and its hourglass shapes are orthogonal to one
# direction alone
BOXES_ONLY = ("C3D8I", "C3D8R")


def solved(part: jo.Part, held, forces) -> np.ndarray:
    """Displacements (nn, 3) under nodal forces."""
    f = np.zeros((len(part.nodes), 3))
    for node, force in forces:
        f[node] += force
    free = np.setdiff1d(np.arange(f.size), dofs(held))
    u = np.zeros(f.size)
    u[free] = spla.spsolve(part.K[free][:, free].tocsc(), f.ravel()[free])
    return u.reshape(-1, 3)


def of_ccx(mesh: Mesh, held, forces, etype: str) -> np.ndarray:
    deck = Deck(mesh, STEEL, held, {mesh.cells[0].kind: etype})
    steps = ["*STEP", "*STATIC", *calculix._cload(forces), "*NODE PRINT, NSET=NALL", "U"]
    text = calculix.run([*deck.head(), *steps, "*END STEP"], ("dat",))["dat"]
    u = np.zeros((len(mesh.nodes), 3))
    for line in text.splitlines():
        if re.match(r"\s+\d+\s+[-0-9.]+E", line):
            node, *values = line.split()
            u[int(node) - 1] = [float(x) for x in values[:3]]
    return u


@needed
@pytest.mark.parametrize("distort", [0.0, 0.2])
@pytest.mark.parametrize(("kind", "how", "etype"), TYPES)
def test_displacements(kind: str, how: str, etype: str, distort: float) -> None:
    if distort and etype in BOXES_ONLY:
        distort = 0.0
    mesh = grid(kind, (10, 2, 2), (0.1, 0.02, 0.01), distort=distort)
    if etype in BOXES_ONLY:  # oblique
        shear = np.array([[1.0, 0.2, -0.1], [0.1, 1.0, 0.3], [-0.2, 0.1, 1.0]])
        mesh = Mesh("oblique", mesh.nodes @ shear, mesh.cells)
    x = grid(kind, (10, 2, 2), (0.1, 0.02, 0.01)).nodes[:, 0]
    held, tip = np.flatnonzero(x < 1e-9), np.flatnonzero(x > 0.1 - 1e-9)
    forces = [(n, (10.0 + i, 3.0 - i, 7.0)) for i, n in enumerate(tip)]
    ours = solved(jo.Part.solid(mesh.formulated(how), STEEL), held, forces)
    ccx = of_ccx(mesh, held, forces, etype)
    # ccx prints seven digits; its penalty of E 1e-9 for none
    np.testing.assert_allclose(ours, ccx, atol=1e-6 * np.abs(ccx).max())


@pytest.mark.filterwarnings("ignore:.*BOUNDARY .* ignored:jousto.JoustoWarning")
@needed
@pytest.mark.parametrize(
    ("etype", "least"),
    [
        # ccx's mass of both is that of 2 x 2 x 2 and 3 x 3 x 3 points, exact for cuboids
        ("C3D8", 1e-6),
        ("C3D20", 1e-6),
        ("C3D20R", 1e-6),
        # ccx solves for the nine inner unknowns with the modes and does not condense them
        ("C3D8I", 2e-3),
        # its mass has the mean velocity of an element alone
        ("C3D8R", 5e-3),
    ],
)
def test_frequencies_of_a_cantilever_read_from_a_deck(
    tmp_path: Path, etype: str, least: float
) -> None:
    # 300 x 20 x 10 mm, 30 x 2 x 2 elements; beam theory: 92.8 Hz
    kind = "hexahedron20" if "20" in etype else "hexahedron"
    mesh = grid(kind, (30, 2, 2), (0.3, 0.02, 0.01))
    held = np.flatnonzero(mesh.nodes[:, 0] < 1e-9)
    deck = Deck(mesh, STEEL, held, {kind: etype})
    (tmp_path / "bar.inp").write_text("\n".join(deck.head()) + "\n")
    part = jo.Part.solid(jo.read_mesh(tmp_path / "bar.inp"), STEEL)
    free = np.setdiff1d(np.arange(3 * len(mesh.nodes)), dofs(held))
    K, M = part.K[free][:, free].tocsc(), part.M[free][:, free].tocsc()
    ours = np.sqrt(np.sort(spla.eigsh(K, 4, M, sigma=0.0)[0])) / (2 * np.pi)
    np.testing.assert_allclose(ours, frequencies(deck, 4, kept=False), rtol=least)
    if etype != "C3D8":
        # mean strain in two layers: sqrt(1 - 1/4) of it, the hourglass stiffness adds 2 %
        beam = 92.8 * (np.sqrt(0.75) if etype == "C3D8R" else 1.0)
        assert ours[0] == pytest.approx(beam, rel=0.025 if etype == "C3D8R" else 0.006)


# shape of the mesh: in-plane and out-of-plane tip displacement over that of beam theory
TABLE = {
    "full": {"rectangle": (0.970, 0.961), "trapezoid": (0.886, 0.920), "oblique": (0.967, 0.941)},
    "reduced": {
        "rectangle": (0.984, 0.972),
        "trapezoid": (0.964, 0.964),
        "oblique": (0.994, 0.961),
    },
}


@pytest.mark.parametrize("shape", ["rectangle", "trapezoid", "oblique"])
@pytest.mark.parametrize("how", ["full", "reduced"])
def test_straight_cantilever_of_macneal_and_harder(how: str, shape: str) -> None:
    # 6 x 0.2 x 0.1, nu 0.3, six bricks of 20 nodes; 0.1081 and 0.4321 by beam theory for E 1e7
    def bend(x: np.ndarray) -> np.ndarray:
        lean = {"rectangle": 0.0, "trapezoid": np.cos(np.pi * x[:, 0]), "oblique": 1.0}[shape]
        inner = (x[:, 0] > 0.6) & (x[:, 0] < 5.4)
        # planes between elements are turned by 45 degrees; mid nodes stay in the middle
        moved = x.copy()
        moved[:, 0] += np.where(inner, lean, 0.0) * (x[:, 2] - 0.1)
        return moved

    plain = grid("hexahedron", (6, 1, 1), (6.0, 0.1, 0.2))
    mesh = quadratic(Mesh("bar", bend(plain.nodes), plain.cells))
    x = mesh.nodes
    held, tip = np.flatnonzero(x[:, 0] < 1e-9), np.flatnonzero(x[:, 0] > 6 - 1e-9)
    # unit shear over the end: corners -1/12, mid nodes 1/3
    corner = (np.abs(x[tip, 1] - 0.05) > 0.04) & (np.abs(x[tip, 2] - 0.1) > 0.09)
    share = np.where(corner, -1.0 / 12.0, 1.0 / 3.0)
    part = jo.Part.solid(mesh.formulated(how), jo.Material(E=1e10, nu=0.3, rho=1000.0))
    found = []
    for direction, beam in ((2, 0.1081e-3), (1, 0.4321e-3)):
        unit = np.eye(3)[direction]
        u = solved(part, held, [(n, unit * w) for n, w in zip(tip, share, strict=True)])
        found.append(u[tip, direction].mean() / beam)
    # the table has three digits
    np.testing.assert_allclose(found, TABLE[how][shape], atol=6e-4)


def quadratic(mesh: Mesh) -> Mesh:
    """The mesh of bricks with nodes at the middle of its edges."""
    from jousto.mesh.cells import Cells, edges

    cells = np.asarray(mesh.cells[0].nodes)
    pairs = np.sort(cells[:, edges("hexahedron")], axis=2)
    unique, middle = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
    both = np.concatenate([cells, middle.reshape(len(cells), -1) + len(mesh.nodes)], axis=1)
    nodes = np.concatenate([mesh.nodes, mesh.nodes[unique].mean(axis=1)])
    return Mesh(mesh.name, nodes, Cells("hexahedron20", both))
