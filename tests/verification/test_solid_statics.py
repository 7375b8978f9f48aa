"""Displacements and surface stresses of solids against closed forms, and how they converge.

Geometry and exact values: `statics`. The documented meshes have four layers of quadratic hexahedra
from the arc outwards (eight elements around a quarter of it); peaks are taken from the skin, see
`Part.surface_stress`, and from the nodes, `Part.stress`.
"""

from __future__ import annotations

import numpy as np
import pytest

from jousto.reduction.methods import FreeFree
from jousto.reduction.reducer import reduce
from jousto.sections.section import Rectangle
from verification import statics as st
from verification.solids import dofs, supported

ELEMENTS = ("tetra10", "hexahedron20", "wedge15")


@pytest.mark.parametrize(
    ("kind", "displacement", "inside", "outside"),
    [
        ("hexahedron20", 1e-4, 0.025, 1e-4),
        ("tetra10", 1e-3, 0.016, 1e-3),
        ("wedge15", 1e-3, 0.015, 1e-3),
    ],
)
def test_thick_cylinder(kind: str, displacement: float, inside: float, outside: float) -> None:
    """Lame: the bore's displacement, hoop stress under pressure inside, of the free outside."""
    found = st.cylinder(kind, 4)
    x = found.part.nodes
    bore = st.near(np.hypot(x[:, 0], x[:, 1]), st.BORE)
    _, at_bore, u = st.lame(np.array([st.BORE]))
    assert np.hypot(found.d[bore, 0], found.d[bore, 1]) == pytest.approx(u[0], rel=displacement)
    angle = np.arctan2(x[bore, 1], x[bore, 0])
    assert st.hoop(angle, found.s[bore]) == pytest.approx(at_bore[0], rel=inside)
    angle, skin = st.on_arc(found, st.OUTSIDE)
    _, at_outside, _ = st.lame(np.array([st.OUTSIDE]))
    assert st.hoop(angle, skin) == pytest.approx(at_outside[0], rel=outside)


@pytest.mark.parametrize(
    ("kind", "limit"), [("hexahedron20", 0.004), ("wedge15", 0.009), ("tetra10", 0.016)]
)
def test_hole_in_a_wide_plate(kind: str, limit: float) -> None:
    """Kirsch: the hoop stress ``S (1 - 2 cos 2 theta)`` all around the hole, over its peak 3 S."""
    angle, s = st.on_arc(st.wide_plate(kind, 4), st.HOLE)
    exact = 1.0 - 2.0 * np.cos(2.0 * angle)
    assert exact.max() == pytest.approx(3.0)
    np.testing.assert_allclose(st.hoop(angle, s) / st.PULL, exact, atol=3.0 * limit)


@pytest.mark.parametrize("notch", [False, True], ids=["hole", "notches"])
@pytest.mark.parametrize("ratio", [0.2, 0.5])
@pytest.mark.parametrize(("kind", "layers"), [("hexahedron20", 4), ("tetra10", 8), ("wedge15", 4)])
def test_peaks_of_finite_plates(kind: str, layers: int, ratio: float, notch: bool) -> None:
    """Peterson: holes and half-round notches in strips, peak within two per cent."""
    width = 0.1
    solved = st.strip(kind, layers, width=width, radius=0.5 * ratio * width, notch=notch)
    _, s = st.on_arc(solved, 0.5 * ratio * width, (0.0, 0.5 * width if notch else 0.0))
    factor = st.semicircular_notches(ratio) / (1.0 - ratio) if notch else st.howland(ratio)
    assert s[:, 0].max() == pytest.approx(st.PULL * factor, rel=0.02)


@pytest.mark.parametrize("kind", ELEMENTS)
def test_order_at_the_surface(kind: str) -> None:
    """Stress at nodes converges with the second order up to a free surface; that of the skin of
    hexahedra, which meet at the middles of one another's sides, with the fourth."""
    at_nodes, skin = [], []
    for layers in (4, 8):
        solved = st.wide_plate(kind, layers)
        angle, s = st.on_arc(solved, st.HOLE)
        skin.append(np.abs(st.hoop(angle, s) / st.PULL - 1.0 + 2.0 * np.cos(2.0 * angle)).max())
        x = solved.part.nodes
        hole = st.near(np.hypot(x[:, 0], x[:, 1]), st.HOLE)
        angle = np.arctan2(x[hole, 1], x[hole, 0])
        value = st.hoop(angle, solved.s[hole]) / st.PULL
        at_nodes.append(np.abs(value - 1.0 + 2.0 * np.cos(2.0 * angle)).max())
    assert np.log2(at_nodes[0] / at_nodes[1]) > 1.6
    assert np.log2(skin[0] / skin[1]) > (3.5 if kind == "hexahedron20" else 1.9)


@pytest.mark.parametrize(
    ("kind", "counts", "tip", "stress"),
    [
        # beam theory itself is 1e-5 off at half length: half way from the ends
        ("hexahedron20", (10, 1, 2), 5e-4, 2e-5),
        ("wedge15", (10, 1, 2), 5e-4, 3e-3),
        ("tetra10", (20, 1, 2), 5e-4, 0.012),
    ],
)
def test_cantilever(kind: str, counts: tuple[int, int, int], tip: float, stress: float) -> None:
    """Timoshenko: ``F L^3/(3 E I) + F L/(k G A)`` with k = 5/6, ``F (L/2) h/(2 I)`` at half length.

    Without lateral contraction beam theory holds but near the ends.
    """
    found = st.cantilever(kind, counts)
    I, A, E = st.BREADTH * st.HEIGHT**3 / 12.0, st.BREADTH * st.HEIGHT, 210e9
    exact = st.TIP * st.LENGTH**3 / (3 * E * I) + st.TIP * st.LENGTH / (5 / 6 * 0.5 * E * A)
    x = found.part.nodes
    end = st.near(x[:, 0], st.LENGTH)
    assert -found.d[end, 2].mean() == pytest.approx(exact, rel=tip)
    top = st.near(x[:, 0], 0.5 * st.LENGTH) & st.near(x[:, 2], st.HEIGHT)
    bending = st.TIP * 0.5 * st.LENGTH * 0.5 * st.HEIGHT / I
    assert found.s[top, 0] == pytest.approx(bending, rel=stress)


def test_linear_elements_are_too_stiff() -> None:
    """What the documentation warns of: one layer of linear elements bends by a third too little."""
    coarse = st.cantilever("hexahedron", (10, 1, 2))
    fine = st.cantilever("hexahedron20", (10, 1, 2))
    ratio = coarse.d[:, 2].min() / fine.d[:, 2].min()
    assert ratio == pytest.approx(2.0 / 3.0, abs=0.03)


BENDING = {
    # roots of cos k cosh k = 1 and cos k cosh k = -1
    "free": (4.730040744862704, 7.853204624095838),
    "clamped": (1.875104068711961, 4.694091132974175),
}


@pytest.mark.parametrize("support", BENDING)
@pytest.mark.parametrize(
    ("kind", "counts"), [("hexahedron20", (24, 1, 1)), ("tetra10", (30, 1, 1))]
)
def test_slender_bar_in_bending(support: str, kind: str, counts: tuple[int, int, int]) -> None:
    """Euler-Bernoulli frequencies ``k^2/(2 pi L^2) sqrt(E I/(rho A))`` of both directions."""
    length, b, h = 1.0, 0.006, 0.004
    mesh = st.grid(kind, counts, (length, b, h))
    part = st.Part.solid(
        mesh.with_set("root", np.flatnonzero(mesh.nodes[:, 0] < 1e-9)),
        st.Material(E=210e9, nu=0.0, rho=7850.0),
    )
    wave = np.sqrt(210e9 / (12.0 * 7850.0)) / (2.0 * np.pi * length**2)
    exact = sorted(k**2 * wave * t for k in BENDING[support] for t in (b, h))
    if support == "free":
        found = reduce(part, FreeFree(modes=4)).frequencies
    else:
        found = supported(part, dofs(part.node_sets["root"]), 4)[0]
    np.testing.assert_allclose(found, exact, rtol=3e-3)


@pytest.mark.parametrize("support", ["free", "clamped"])
def test_ten_frequencies_of_a_bar(support: str) -> None:
    """Bending in two planes, torsion and stretching against beams of Timoshenko's theory.

    Held against contraction at a clamp, a bar is 0.3 per cent stiffer there.
    """
    steel = st.Material(E=210e9, nu=0.3, rho=7850.0)
    beam = st.Part.beam(1.0, Rectangle(0.03, 0.02), 120, steel)
    mesh = st.grid("hexahedron20", (36, 4, 3), (1.0, 0.03, 0.02))
    bar = st.Part.solid(mesh.with_set("root", np.flatnonzero(mesh.nodes[:, 0] < 1e-9)), steel)
    if support == "free":
        found, exact = (reduce(part, FreeFree(modes=10)).frequencies for part in (bar, beam))
    else:
        found = supported(bar, dofs(bar.node_sets["root"]), 10)[0]
        exact = supported(beam, np.arange(6), 10)[0]
    np.testing.assert_allclose(found, exact, rtol=5e-3)
