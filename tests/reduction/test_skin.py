"""Strain under a grid on the surface of solids: exact fields, curved surfaces, edges."""

from __future__ import annotations

import numpy as np
import pytest

from jousto.materials.material import Material
from jousto.parts.part import Part
from jousto.reduction.fields.solid_surface_strain import (
    LeavesSurface,
    Skin,
    grid_strain,
    point_strain,
    tangent,
)
from parts.grids import ALL, grid

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
SIZE = np.array([0.9, 0.3, 0.2])
QUADRATIC = [kind for kind in ALL if kind in ("tetra10", "hexahedron20", "wedge15")]
AT = np.array([0.41, 0.13, 0.2])
OBLIQUE = np.array([0.8, 0.6, 0.0])


def box(kind, distort=0.0):
    part = Part.solid(grid(kind, (3, 2, 2), SIZE, distort=distort), STEEL)
    return part, Skin(part.nodes, part.faces)


@pytest.mark.parametrize("kind", ALL)
def test_linear_field(kind):
    """Constant strain: at a point, along a line and over a rectangle, on any kind of face."""
    part, skin = box(kind)
    g = 1e-3 * np.random.default_rng(1).standard_normal((3, 3))
    u = part.nodes @ g.T
    expected = OBLIQUE @ g @ OBLIQUE
    foot = skin.foot(AT + (0, 0, 1e-4))
    np.testing.assert_allclose(foot.x, AT, atol=1e-12)
    np.testing.assert_allclose(foot.normal, (0, 0, 1), atol=1e-12)
    assert foot.distance == pytest.approx(1e-4)
    found = [
        point_strain(skin.feet(AT), OBLIQUE)(u),
        grid_strain(skin, foot, OBLIQUE, 0.2, 0.0)(u),
        grid_strain(skin, foot, OBLIQUE, 0.2, 0.1)(u),
    ]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize("kind", QUADRATIC)
def test_bending_field(kind):
    """``u = x^2/2`` along x has the strain x: its mean over a grid is that of the middle, and the
    mean of ``u = x y^2`` over a width b is ``y^2 + b^2/12``."""
    part, skin = box(kind)
    x, y, _ = part.nodes.T
    u = np.zeros_like(part.nodes)
    u[:, 0] = 0.5 * x**2
    foot = skin.foot(AT)
    X = np.array([1.0, 0, 0])
    # lines through several elements, their middles off every node
    assert grid_strain(skin, foot, X, 0.5, 0.0)(u) == pytest.approx(0.41, rel=1e-9)
    assert point_strain(skin.feet(AT), X)(u) == pytest.approx(0.41, rel=1e-9)
    u[:, 0] = x * y
    assert grid_strain(skin, foot, X, 0.3, 0.2)(u) == pytest.approx(0.13, rel=1e-9)


def test_difference_of_the_ends():
    """Whatever the field between: on a plane the elongation over the length."""
    part, skin = box("tetra10")
    u = np.random.default_rng(3).standard_normal(part.nodes.shape)
    foot = skin.foot(AT)
    ends = [skin.foot(AT + s * 0.1 * OBLIQUE) for s in (-1, 1)]
    a, b = (OBLIQUE @ (foot.N @ u[foot.nodes]) for foot in ends)
    assert grid_strain(skin, foot, OBLIQUE, 0.2, 0.0)(u) == pytest.approx((b - a) / 0.2, rel=1e-9)
    # rigid motions do not strain it
    turned = np.cross((1.0, -2.0, 3.0), part.nodes)
    assert abs(grid_strain(skin, foot, OBLIQUE, 0.2, 0.1)(turned)) < 1e-12


def cylinder(radius, height, pieces, order):
    """Return nodes and quadratic faces of a cylinder about z, outward normals."""
    nodes, faces = [], []
    n = 2 * pieces
    for k in range(2 * order + 1):
        for i in range(n):
            a = 2 * np.pi * i / n
            nodes.append((radius * np.cos(a), radius * np.sin(a), height * k / (2 * order)))

    def at(i, k):
        return k * n + i % n

    for k in range(0, 2 * order, 2):
        for i in range(0, n, 2):
            faces.append(
                [at(i, k), at(i + 2, k), at(i + 2, k + 2), at(i, k + 2),
                 at(i + 1, k), at(i + 2, k + 1), at(i + 1, k + 2), at(i, k + 1)]
            )  # fmt: skip
    return np.array(nodes), [np.array(faces)]


def test_hoop_strain_of_a_cylinder():
    """A growing cylinder: hoop strain u/r under a grid that follows the curved surface."""
    nodes, faces = cylinder(0.02, 0.1, 24, 6)
    skin = Skin(nodes, faces)
    grown = nodes * (1e-3, 1e-3, 0.0)
    foot = skin.foot(np.array([0.03 * np.cos(0.3), 0.03 * np.sin(0.3), 0.047]))
    assert foot.distance == pytest.approx(0.01, rel=1e-4)
    hoop = tangent(np.array([0.0, 1.0, 0.0]), foot.normal)
    assert grid_strain(skin, foot, hoop, 0.010, 0.006)(grown) == pytest.approx(1e-3, rel=1e-6)
    assert point_strain([foot], hoop)(grown) == pytest.approx(1e-3, rel=1e-3)
    # a twist gives half the shear strain at 45 degrees, and nothing along and around
    twist = np.cross((0, 0, 1.0), nodes) * (0.05 * nodes[:, 2:])
    z = np.array([0.0, 0.0, 1.0])
    oblique = (hoop + z) / np.sqrt(2.0)
    strain = 0.5 * 0.05 * 0.02
    assert grid_strain(skin, foot, oblique, 0.005, 0.003)(twist) == pytest.approx(strain, rel=2e-3)
    assert abs(grid_strain(skin, foot, hoop, 0.005, 0.003)(twist)) < 1e-3 * strain
    assert abs(grid_strain(skin, foot, z, 0.005, 0.003)(twist)) < 1e-3 * strain


def test_grids_that_leave_the_surface():
    """0.07 m to the edge y = 0.2, beyond which the side face begins."""
    _, skin = box("tetra10")
    foot = skin.foot(np.array([0.41, 0.23, 0.2]))
    y = np.array([0.0, 1.0, 0.0])
    with pytest.raises(LeavesSurface) as error:
        grid_strain(skin, foot, y, 0.3, 0.0)
    assert 0.05 < error.value.reach < 0.1
    grid_strain(skin, foot, y, 0.13, 0.0)
    with pytest.raises(LeavesSurface):
        grid_strain(skin, foot, np.array([1.0, 0, 0]), 0.1, 0.2)
