"""The estimated error of a mesh against the true one, where the exact stress is known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.materials.orthotropic import elasticity
from jousto.mesh.reference import gradients, table
from parts.grids import grid
from verification import statics as st
from verification.statics import Array, Solved


def cartesian(radial: Array, hoop: Array, shear: Array, angle: Array) -> Array:
    """Stress (nn, 6) of plane strain from its polar components."""
    c, s, zero = np.cos(angle), np.sin(angle), np.zeros_like(angle)
    s11 = radial * c**2 + hoop * s**2 - 2.0 * shear * s * c
    s22 = radial * s**2 + hoop * c**2 + 2.0 * shear * s * c
    s12 = (radial - hoop) * s * c + shear * (c**2 - s**2)
    return np.stack([s11, s22, st.STEEL.nu * (radial + hoop), s12, zero, zero], axis=1)


def lame(x: Array) -> Array:
    radial, hoop, _ = st.lame(np.hypot(x[:, 0], x[:, 1]))
    return cartesian(radial, hoop, np.zeros_like(radial), np.arctan2(x[:, 1], x[:, 0]))


def kirsch(x: Array) -> Array:
    """Timoshenko and Goodier, *Theory of Elasticity*, art. 35."""
    q, angle = st.HOLE**2 / (x[:, 0] ** 2 + x[:, 1] ** 2), np.arctan2(x[:, 1], x[:, 0])
    twice = 2.0 * angle
    radial = (1.0 - q) + (1.0 - 4.0 * q + 3.0 * q**2) * np.cos(twice)
    hoop = (1.0 + q) - (1.0 + 3.0 * q**2) * np.cos(twice)
    shear = -(1.0 + 2.0 * q - 3.0 * q**2) * np.sin(twice)
    half = 0.5 * st.PULL
    return cartesian(half * radial, half * hoop, half * shear, angle)


def true_error(solved: Solved, exact: Callable[[Array], Array]) -> float:
    """``sqrt(int (s - s_h) C^-1 (s - s_h) dV)`` with the exact stress s, by a fine rule."""
    model, total = solved.part.solids, 0.0
    assert model is not None
    C = elasticity(model.materials[0])
    for group in model.groups:
        t = table(group.kind, "mass")
        G, detJ = gradients(t.dN, model.nodes[group.nodes])
        D = np.einsum("eqjk,eki->eqij", G, solved.d[group.nodes])
        D = 0.5 * (D + np.swapaxes(D, 2, 3))
        pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))
        e = np.stack([(1 + (i != j)) * D[..., i, j] for i, j in pairs], axis=-1)
        x = np.einsum("qk,ekc->eqc", t.N, model.nodes[group.nodes]).reshape(-1, 3)
        away = exact(x).reshape(e.shape) - e @ C.T
        weak = np.linalg.solve(C, away.reshape(-1, 6).T).T.reshape(away.shape)
        total += float(np.einsum("eq,eqi,eqi->", t.weights * detJ, away, weak))
    return float(np.sqrt(total))


PROBLEMS = {"hole": (st.wide_plate, kirsch), "cylinder": (st.cylinder, lame)}


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize(
    ("kind", "order", "low", "high"),
    [
        # effectivity: estimated over true error; near 1 for wedges and linear elements, somewhat
        # careful for 20-node hexahedra, somewhat too good for tetrahedra
        ("hexahedron20", 2.0, 0.9, 1.9),
        ("wedge15", 2.0, 0.9, 1.2),
        ("tetra10", 2.0, 0.65, 0.85),
        ("hexahedron", 1.0, 0.85, 1.05),
        ("wedge", 1.0, 0.8, 1.05),
        ("tetra", 1.0, 0.8, 1.05),
    ],
)
def test_estimated_error_of_known_stress(
    kind: str, order: float, low: float, high: float, problem: str
) -> None:
    """Effectivity, and both errors fall as the order of the element says."""
    make, exact = PROBLEMS[problem]
    estimated, true = [], []
    for layers in (4, 8):
        solved = make(kind, layers)
        found = jo.parts.mesh_error(solved.part, solved.d.reshape(-1))
        estimated.append(float(np.sqrt(found.squares.sum())))
        true.append(true_error(solved, exact))
        assert low <= estimated[-1] / true[-1] <= high
        energy = solved.d.reshape(-1) @ (solved.part.K @ solved.d.reshape(-1))
        # K takes the same rule: the energies agree to rounding
        assert found.energy[0] == pytest.approx(energy, rel=1e-10)
    for error in (estimated, true):
        assert np.log2(error[0] / error[1]) == pytest.approx(order, abs=0.35)


@pytest.mark.parametrize("kind", ["hexahedron20", "tetra10", "tetra"])
def test_no_error_in_a_patch_test(kind: str) -> None:
    """A linear field is exact on every mesh, of two materials, too; the error scales with it."""
    mesh = grid(kind, (3, 2, 2), distort=0.2)
    part = jo.Part.solid(mesh, st.STEEL)
    d = (part.nodes @ np.array([[1.0, 0.2, 0.0], [0.1, -0.5, 0.3], [0.0, 0.4, 0.2]])).ravel()
    assert jo.parts.mesh_error(part, d).eta[0] < 1e-12
    bent = (part.nodes[:, [0]] ** 3 * [0.0, 0.0, 1e-3]).ravel()
    found = jo.parts.mesh_error(part, np.column_stack([bent, 2.0 * bent]))
    assert found.eta[0] == pytest.approx(found.eta[1]) and found.eta[0] > 1e-3
    np.testing.assert_allclose(found.squares[:, 1], 4.0 * found.squares[:, 0])
    assert "of the energy norm at worst, most in element" in repr(found)


def test_the_error_is_found_where_it_is() -> None:
    """At the hole, next to one of the places of the peak."""
    solved = st.wide_plate("hexahedron20", 4)
    found = jo.parts.mesh_error(solved.part, solved.d.reshape(-1))
    centre = found.centers[found.worst()]
    assert np.hypot(centre[0], centre[1]) < 1.6 * st.HOLE
    assert found.squares[found.worst(), 0] < 0.5 * found.squares.sum()


def test_refusals() -> None:
    beam = jo.Part.beam(1.0, jo.Circle(0.01), 2, st.STEEL)
    with pytest.raises(InputError, match="for parts of solids only"):
        jo.parts.mesh_error(beam, np.zeros(beam.K.shape[0]))
    part = jo.Part.solid(grid("tetra", (1, 1, 1)), st.STEEL)
    with pytest.raises(InputError, match=r"must be \(24, n\)"):
        jo.parts.mesh_error(part, np.zeros(7))
