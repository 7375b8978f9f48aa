"""Natural frequencies of solids against exact solutions of three-dimensional elasticity.

Where a plate or beam theory is usual the test also says how far it is from the exact number.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification.boxes import block, ring, rod
from verification.plates import flat, kirchhoff, lamb, mindlin, thick_ring, thin_ring
from verification.solids import dofs, like, solid, supported

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)


def plate(kind, counts, size=(0.5, 0.4, 0.04)):
    """Frequencies of a plate whose edges hold the tangential displacements, and the exact ones."""
    a, b, h = size
    grid = block(kind, size, counts)
    part = solid(grid, STEEL)
    across = np.concatenate([grid.plane(0, 0.0), grid.plane(0, a)])
    along = np.concatenate([grid.plane(1, 0.0), grid.plane(1, b)])
    f, _ = supported(part, np.concatenate([dofs(across, "yz"), dofs(along, "xz")]), 5)
    numbers = [(m, n) for m in range(4) for n in range(4) if m + n]
    k = {(m, n): np.hypot(m * np.pi / a, n * np.pi / b) for m, n in numbers}
    G = STEEL.E / (2.0 * (1.0 + STEEL.nu))
    exact = [lamb(k[p], h, STEEL) for p in numbers if p[0] and p[1]]
    # shear in the plane keeps the thickness: w = cT k
    exact += [np.sqrt(G / STEEL.rho) * k[p] for p in numbers]
    return f, np.sort(exact)[:5] / (2.0 * np.pi)


def bending_error(kind, counts, size):
    """Relative error of the frequency of the longest bending wave of that plate."""
    a, b, h = size
    grid = block(kind, size, counts)
    part = solid(grid, STEEL)
    across = np.concatenate([grid.plane(0, 0.0), grid.plane(0, a)])
    along = np.concatenate([grid.plane(1, 0.0), grid.plane(1, b)])
    f, X = supported(part, np.concatenate([dofs(across, "yz"), dofs(along, "xz")]), 6)
    x, y, z = grid.nodes.T
    wave = np.sin(np.pi * x / a) * np.sin(np.pi * y / b)
    shape = np.stack([0.0 * z, 0.0 * z, wave], axis=1).ravel()
    exact = lamb(np.hypot(np.pi / a, np.pi / b), h, STEEL) / (2.0 * np.pi)
    return f[like(X, part.M, shape).argmax()] / exact - 1.0


def test_plate_waves_against_a_printed_frequency():
    # square, h/a = 0.1, nu = 0.3: w h sqrt(rho/G) = 0.0932 (S. Srinivas, C. V. Joga Rao, A. K.
    # Rao, J. Sound Vib. 12, 1970), 0.0930 by Mindlin, 0.0955 by Kirchhoff with rotary inertia
    a, h = 1.0, 0.1
    k = np.sqrt(2.0) * np.pi / a
    unit = h * np.sqrt(STEEL.rho * 2.0 * (1.0 + STEEL.nu) / STEEL.E)
    assert abs(lamb(k, h, STEEL) * unit - 0.0932) < 6e-5
    assert abs(mindlin(k, h, STEEL) * unit - 0.0930) < 6e-5
    # one long wave: the three theories meet
    slow = [f(1.0, 0.02, STEEL) for f in (lamb, mindlin, kirchhoff)]
    np.testing.assert_allclose(slow, slow[0], rtol=2e-4)


@pytest.mark.parametrize(
    ("kind", "counts", "limits"),
    [
        ("hexahedron20", (8, 8, 2), (1e-3, 3.5e-3)),
        ("wedge15", (8, 8, 2), (3.5e-3, 1.4e-2)),
        ("tetra10", (8, 6, 2), (1e-2, 3.5e-2)),
    ],
)
def test_a_plate_of_solids_against_exact_plate_waves(kind, counts, limits):
    f, exact = plate(kind, counts)
    error = f / exact - 1.0
    assert np.all(error > 0.0)  # Rayleigh
    assert error[0] < limits[0]
    assert error.max() < limits[1], error


def test_a_plate_of_solids_converges_with_fourth_order():
    size = (0.3, 0.3, 0.15)
    errors = [bending_error("hexahedron20", (n, n, n), size) for n in (2, 4)]
    assert errors[1] < 1e-3
    assert np.log2(errors[0] / errors[1]) > 3.5, errors


def test_a_thick_ring_held_flat_against_bessel_functions():
    radii = (0.08, 0.12)
    grid = ring("hexahedron20", radii, 0.02, (2, 48, 1))
    planes = np.concatenate([grid.plane(2, 0.0), grid.plane(2, 0.02)])
    f, _ = supported(solid(grid, STEEL), dofs(planes, "z"), 8, shift=-1e7)
    assert f[:3].max() < 1.0  # three rigid motions in the plane
    exact = [thick_ring(n, radii, STEEL)[0] for n in (2, 3)]
    # every wave stands in two positions
    np.testing.assert_allclose(f[3:7], np.repeat(exact, 2), rtol=2.5e-3)
    # Love's thin ring is far from so thick a one
    assert thin_ring(2, radii, STEEL) > 1.02 * exact[0]


def test_a_free_ring_against_bessel_functions_and_love():
    radii = (0.095, 0.105)
    grid = ring("hexahedron20", radii, 0.01, (1, 48, 1))
    f = jo.reduce(solid(grid, STEEL), jo.FreeFree(modes=8)).frequencies
    for n in (2, 3):
        # narrow: plane stress. A square section bends with twist across the plane a little slower
        exact = thick_ring(n, radii, flat(STEEL))[0]
        error = f / exact - 1.0
        assert np.sum((error > 0.0) & (error < 4e-3)) == 2, (exact, f)
        assert 0.0 < thin_ring(n, radii, STEEL) / exact - 1.0 < 0.014


@pytest.mark.parametrize(
    ("kind", "counts", "limit"),
    [("hexahedron20", (2, 6), 3e-4), ("wedge15", (4, 8), 2e-3), ("tetra10", (4, 8), 4e-3)],
)
def test_a_round_bar_twists_like_a_string(kind, counts, limit):
    # f = sqrt(G / rho) / (2 L): exact in three dimensions, sections turn without warping
    radius, length = 0.05, 0.4
    grid = rod(kind, radius, length, counts)
    part = solid(grid, STEEL)
    f, X = supported(part, [], 14, shift=-1e7)
    x, y, z = grid.nodes.T
    turn = np.cos(np.pi * x / length)
    share = like(X, part.M, np.stack([0.0 * x, -z * turn, y * turn], axis=1).ravel())
    assert share.max() > 0.999
    exact = np.sqrt(STEEL.E / (2.0 * (1.0 + STEEL.nu)) / STEEL.rho) / (2.0 * length)
    assert abs(f[share.argmax()] / exact - 1.0) < limit


def test_a_clamped_bar_without_lateral_contraction_stretches_like_a_string():
    # nu = 0: u = sin((2 k - 1) pi x / 2 L) is exact in three dimensions
    cork = jo.Material(E=2.1e11, nu=0.0, rho=7850.0)
    length = 1.0
    errors = []
    for n in (4, 8):
        grid = block("hexahedron20", (length, 0.1, 0.1), (n, 1, 1))
        part = solid(grid, cork)
        held = np.concatenate([dofs(grid.plane(0, 0.0)), dofs(np.arange(len(grid.nodes)), "yz")])
        f, _ = supported(part, np.unique(held), 3)
        exact = np.array([1.0, 3.0, 5.0]) / (4.0 * length) * np.sqrt(cork.E / cork.rho)
        errors.append(f / exact - 1.0)
    assert np.all(errors[1] < [1.1e-6, 1e-4, 1e-3])
    assert np.all(np.log2(errors[0] / errors[1]) > 3.6)
