"""Centrifugal stress of solids: closed forms, CalculiX, and a disc that spins in the engine."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import jousto as jo
from verification import bricks, calculix
from verification.boxes import ring
from verification.plates import flat, spinning_ring
from verification.solids import at_rest, dofs, solid

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
RADII = (0.05, 0.15)
SPEED = 1000.0  # rad/s: 154 MPa at the bore
WIDTH = 0.02


def polar(grid, stress):
    """Radius, radial and hoop stress (nn,) of stresses (nn, 6)."""
    r = np.hypot(grid.nodes[:, 0], grid.nodes[:, 1])
    x, y = grid.nodes[:, 0] / r, grid.nodes[:, 1] / r
    xx, yy, xy = stress[:, 0], stress[:, 1], stress[:, 3]
    radial = xx * x**2 + yy * y**2 + 2.0 * xy * x * y
    return r, radial, xx + yy - radial


def pull(grid, part):
    """Centrifugal load (ndof,) at 1 rad/s about z."""
    return part.M @ (grid.nodes * [1.0, 1.0, 0.0]).ravel()


def symmetric(grid):
    """Degrees of freedom that symmetry holds."""
    across, along = (np.flatnonzero(np.abs(grid.nodes[:, a]) < 1e-9) for a in (0, 1))
    return np.concatenate([dofs(across, "x"), dofs(along, "y")])


def spun(kind, counts):
    """A ring between smooth planes: grid, displacements and stress."""
    grid = ring(kind, RADII, WIDTH, counts)
    part = solid(grid, STEEL)
    planes = np.concatenate([grid.plane(2, 0.0), grid.plane(2, WIDTH)])
    held = np.unique(np.concatenate([dofs(planes, "z"), symmetric(grid)]))
    d = at_rest(part, held, SPEED**2 * pull(grid, part))
    return grid, d.reshape(-1, 3), part.stress.evaluate(d)


def errors(kind, counts):
    """Largest errors of radial displacement and hoop stress, relative to their largest values."""
    grid, u, s = spun(kind, counts)
    r, _, hoop = polar(grid, s)
    exact_u, _, exact_hoop = spinning_ring(r, RADII, SPEED, STEEL)
    out = np.einsum("na,na->n", u[:, :2], grid.nodes[:, :2]) / r
    return [np.abs(a - b).max() / b.max() for a, b in ((out, exact_u), (hoop, exact_hoop))]


@pytest.mark.parametrize(
    ("kind", "counts", "limits"),
    [("hexahedron20", (8, 32, 1), (1e-4, 1.4e-2)), ("tetra10", (6, 40, 1), (1.6e-3, 1.6e-2))],
)
def test_a_spinning_ring_against_timoshenko_and_goodier(kind, counts, limits):
    u, hoop = errors(kind, counts)
    assert u < limits[0]
    assert hoop < limits[1]


def test_stress_of_a_spinning_ring_converges():
    coarse, fine = (errors("hexahedron20", (n, 8 * n, 1)) for n in (2, 4))
    assert np.log2(coarse[0] / fine[0]) > 3.0, (coarse, fine)
    assert np.log2(coarse[1] / fine[1]) > 1.2, (coarse, fine)


def test_a_spinning_ring_against_calculix():
    grid = ring("tetra10", RADII, WIDTH, (2, 16, 1))
    part = solid(grid, STEEL)
    clamp = grid.plane(2, 0.0)
    theirs = calculix.static(calculix.Deck(grid, STEEL, clamp), spin=(SPEED, (0, 0, 0), (0, 0, 1)))
    # the load of ccx has four points in a tetrahedron, as its mass
    position = (grid.nodes * [1.0, 1.0, 0.0]).ravel()
    load = SPEED**2 * bricks.mass(grid, STEEL, bricks.calculix) @ position
    d = at_rest(part, dofs(clamp), load)
    np.testing.assert_allclose(d.reshape(-1, 3), theirs.u, rtol=0, atol=5e-7 * np.abs(d).max())
    s = replace(part.stress, faces=False).evaluate(d)
    np.testing.assert_allclose(s, theirs.stress, rtol=0, atol=2e-5 * np.abs(s).max())


@pytest.mark.filterwarnings("ignore:.*has no joint to another body")
@pytest.mark.filterwarnings("ignore:.*same frequency")
def test_a_disc_that_spins_in_the_engine():
    # free in space, damped until it rests in its rotating frame; the residual vector of the
    # centrifugal load holds its shape
    grid = ring("hexahedron20", RADII, 0.01, (4, 24, 1))
    part = solid(grid, STEEL)
    load = pull(grid, part)
    reduced = jo.reduce(part, jo.FreeFree(modes=4, residuals=(load,)))
    disc = jo.FlexibleBody("disc", reduced, angular_velocity=(0.0, 0.0, 500.0), damping=1.0)
    run = jo.simulate(
        jo.compile(jo.Mechanism(disc)), 2e-3, solver=jo.RK4(step=4e-6), output_step=1e-3
    )
    q, v = run.q[-1], run.v[-1]
    # it widens, its angular momentum stays, its speed falls a little
    assert 5e-5 < 1.0 - v[5] / 500.0 < 5e-4
    ours = reduced.stress.modes @ q[7:]

    # the full model at that speed, the centrifugal load following the widened disc
    flat_ = np.concatenate([symmetric(grid), dofs(grid.plane(2, 0.0)[:1], "z")])
    d = at_rest(part, flat_, v[5] ** 2 * load)
    full = part.stress.evaluate(d)
    np.testing.assert_allclose(ours, full, rtol=0, atol=1e-3 * np.abs(full).max())
    r, _, hoop = polar(grid, ours)
    exact = spinning_ring(r, RADII, v[5], flat(STEEL))[2]
    assert np.abs(hoop - exact).max() < 0.04 * exact.max()
