"""Rigid and averaging interfaces against those of CalculiX: *RIGID BODY, *DISTRIBUTING."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import jousto as jo
from jousto.mesh.area import area_matrix
from verification import calculix, calculix_kept
from verification.boxes import block
from verification.solids import solid

Array = NDArray[np.float64]
STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
AT = np.array([0.45, 0.02, -0.01])
F, T = np.array([3.0, 5.0, -2.0]), np.array([0.7, -0.3, 0.5])
DIGITS = 5e-7
"""ccx prints seven digits."""


def box(kind: str) -> tuple[Any, jo.Part, Array, Array]:
    """A box of solids and its ends; the left one is a node set."""
    grid = block(kind, (0.4, 0.1, 0.06), (4, 2, 1))
    part = solid(grid, STEEL)
    x = part.nodes
    left, right = (np.flatnonzero(np.abs(x[:, 0] - a) < 1e-9) for a in (0.0, 0.4))
    return grid, replace(part, node_sets={"left": tuple(left)}), left, right


def responses(part: jo.Part, left: Array) -> tuple[Array, Array]:
    """Displacements (nn, 3) and motion (6,) of the reference node, the left nodes held."""
    reduced = jo.reduce(part, jo.CraigBampton(("left", "b"), modes=0))
    b = reduced.node("b")
    R = np.zeros((len(reduced.nodes), 3, 6))
    R[:, :, :3] = np.eye(3)
    for c, e in enumerate(np.eye(3)):
        R[:, :, 3 + c] = np.cross(e, reduced.nodes)
    Y = np.concatenate([R, reduced.modes], axis=2)
    turn = np.concatenate([np.zeros((3, 3)), np.eye(3), np.asarray(reduced.rotation(b))], axis=1)
    q = np.concatenate([Y[b], turn])
    # rigid motion and modes with the left nodes at rest
    C = Y[left].reshape(-1, Y.shape[2])
    scale = np.concatenate([np.ones(6), 1.0 / np.sqrt(reduced.stiffness)])
    _, s, V = np.linalg.svd(C * scale)
    rank = int(np.sum(s > 1e-9 * s[0]))
    Z = scale[:, None] * V[rank:].T
    K = Z[6:].T @ (reduced.stiffness[:, None] * Z[6:])
    p = Z @ np.linalg.solve(K, Z.T @ (q.T @ np.concatenate([F, T])))
    return Y @ p, q @ p


def ccx(grid: Any, left: Array, extra: list[str], loads: list[str]) -> Array:
    """Displacements of all nodes and of the two reference nodes by CalculiX."""
    nn = len(grid.nodes)
    lines = calculix.Deck(grid, STEEL, fixed=left).head()
    at = ", ".join(f"{a:.12e}" for a in AT)
    lines += ["*NODE, NSET=REF", f"{nn + 1}, {at}", f"{nn + 2}, {at}", *extra]
    lines += ["*STEP", "*STATIC", "*CLOAD", *loads]
    lines += ["*NODE PRINT, NSET=NALL", "U", "*NODE PRINT, NSET=REF", "U", "*END STEP"]

    def compute() -> Array:
        return calculix.displacements(calculix.run(lines, ("dat",))["dat"], nn + 2)

    return calculix_kept.answer(lines, compute)


@pytest.mark.parametrize("kind", ["hexahedron", "hexahedron20", "tetra10"])
def test_rigid_interface_is_a_rigid_body_of_calculix(kind: str) -> None:
    grid, part, left, right = box(kind)
    u, q = responses(part.with_interfaces(jo.Interface("b", right, at=AT)), left)
    nn = len(part.nodes)
    rigid = ["*NSET, NSET=RIGHT", *(f"{i + 1}," for i in right)]
    rigid.append(f"*RIGID BODY, NSET=RIGHT, REF NODE={nn + 1}, ROT NODE={nn + 2}")
    loads = [f"{nn + 1}, {i + 1}, {F[i]}" for i in range(3)]
    loads += [f"{nn + 2}, {i + 1}, {T[i]}" for i in range(3)]
    found = ccx(grid, left, rigid, loads)
    np.testing.assert_allclose(found[nn], q[:3], atol=DIGITS * np.abs(q[:3]).max())
    np.testing.assert_allclose(found[nn + 1], q[3:], atol=DIGITS * np.abs(q[3:]).max())
    np.testing.assert_allclose(found[:nn], u[:nn], atol=2 * DIGITS * np.abs(u).max())


def test_average_is_a_distributing_coupling_of_calculix() -> None:
    """CalculiX weighs the nodes of linear faces by their share of the area."""
    grid, part, left, right = box("hexahedron")
    inside = [group[np.all(np.isin(group, right), axis=1)] for group in part.faces]
    share = np.asarray(area_matrix(part.nodes, inside).sum(axis=1))[right]
    own = jo.Interface("b", right, kind="average", at=AT, weights=share)
    u, _ = responses(part.with_interfaces(own), left)
    nn = len(part.nodes)
    surface, number = ["*SURFACE, NAME=END"], 0
    for cells in grid.cells:
        for nodes in np.asarray(cells.nodes):
            number += 1
            for side, face in enumerate(calculix.FACES[8], 1):
                if np.all(np.isin(nodes[list(face)], right)):
                    surface.append(f"{number}, S{side}")
    surface += [f"*COUPLING, REF NODE={nn + 1}, SURFACE=END, CONSTRAINT NAME=C"]
    loads = [f"{nn + 1}, {i + 1}, {x}" for i, x in enumerate([*F, *T])]
    found = ccx(grid, left, [*surface, "*DISTRIBUTING", "1, 6"], loads)
    np.testing.assert_allclose(found[:nn], u[:nn], atol=2 * DIGITS * np.abs(u).max())
