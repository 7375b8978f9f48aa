"""Solids under load against CalculiX: pressure, spin, buckling, frequencies of a loaded bar."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.sparse.linalg import eigsh

import jousto as jo
from verification import calculix
from verification.boxes import block
from verification.solids import at_rest, dofs, solid, supported

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
LENGTH, WIDTH, HEIGHT = 1.0, 0.02, 0.03
COUNTS = {"hexahedron20": (10, 1, 1), "tetra10": (12, 1, 1)}
EULER = np.pi**2 * STEEL.E * HEIGHT * WIDTH**3 / 12.0 / (4.0 * LENGTH**2)  # N


def column(kind):
    """A slender column clamped at its foot, with a force of Euler along it at its head."""
    grid = block(kind, (LENGTH, WIDTH, HEIGHT), COUNTS[kind])
    part, clamp, tip = solid(grid, STEEL), grid.plane(0, 0.0), grid.plane(0, LENGTH)
    load = np.zeros((len(grid.nodes), 3))
    load[tip, 0] = EULER / len(tip)
    return grid, part, clamp, load


def nodal(load):
    return [(int(n), load[n]) for n in np.flatnonzero(np.any(load, axis=1))]


@pytest.mark.parametrize("kind", COUNTS)
def test_buckling(kind):
    grid, part, clamp, load = column(kind)
    theirs = calculix.buckling(calculix.Deck(grid, STEEL, clamp), nodal(-load), 4)
    Kg = part.geometric_stiffness(at_rest(part, dofs(clamp), -load.ravel()))
    free = np.setdiff1d(np.arange(load.size), dofs(clamp))
    K, G = (sp.csc_array(A)[free][:, free] for A in (part.K, Kg))
    start = np.random.default_rng(0).standard_normal(len(free))
    ours, _ = eigsh(K, 4, -G, sigma=1.0, mode="buckling", v0=start)
    np.testing.assert_allclose(np.sort(ours), theirs, rtol=2e-6)
    # Euler; the clamped foot cannot contract
    assert 0.0 < theirs[0] - 1.0 < 0.02


@pytest.mark.parametrize("kind", COUNTS)
@pytest.mark.parametrize("factor", [1.0, -0.5])
def test_frequencies_of_a_loaded_column(kind, factor):
    # CalculiX loads it with large displacements, of which these are the first order: strain 1e-4
    grid, part, clamp, load = column(kind)
    theirs = calculix.loaded_frequencies(calculix.Deck(grid, STEEL, clamp), nodal(factor * load), 6)
    d = at_rest(part, dofs(clamp), factor * load.ravel())
    stiffened = replace(part, K=part.K + part.geometric_stiffness(d))
    ours, _ = supported(stiffened, dofs(clamp), 6)
    bare, _ = supported(part, dofs(clamp), 6)
    assert abs(ours[0] / bare[0] - 1.0) > 0.2
    np.testing.assert_allclose(ours, theirs, rtol=1e-4)


def bent(x):
    """Curved in the plane of the pressure."""
    return np.stack([x[:, 0], x[:, 1] + 0.1 * x[:, 0] ** 2, x[:, 2] + 0.2 * x[:, 0] ** 2], axis=1)


@pytest.mark.parametrize("kind", ["tetra", "tetra10", "hexahedron", "hexahedron20"])
def test_pressure_on_a_curved_surface(kind):
    size, counts = (0.5, 0.1, 0.06), (6, 2, 2)
    plain, grid = block(kind, size, counts), block(kind, size, counts, bend=bent)
    clamp, top = plain.plane(0, 0.0), plain.plane(2, size[2])
    theirs = calculix.static(calculix.Deck(grid, STEEL, clamp), pressure=(top, 1e6))
    part = solid(grid, STEEL)
    d = at_rest(part, dofs(clamp), part.load(jo.parts.Pressure(top, 1e6)))
    atol = 1e-6 * np.abs(d).max()
    np.testing.assert_allclose(d.reshape(-1, 3), theirs.u, rtol=0, atol=atol)


def test_centrifugal_load():
    grid = block("hexahedron20", (0.5, 0.1, 0.06), (4, 2, 1))
    clamp = grid.plane(0, 0.0)
    deck = calculix.Deck(grid, STEEL, clamp)
    theirs = calculix.static(deck, spin=(200.0, (0.1, 0.0, 0.0), (0.0, 0.6, 0.8)))
    part = solid(grid, STEEL)
    load = part.load(jo.parts.Spin((0.0, 120.0, 160.0), (0.1, 0.0, 0.0)))
    d = at_rest(part, dofs(clamp), load)
    atol = 1e-6 * np.abs(d).max()
    np.testing.assert_allclose(d.reshape(-1, 3), theirs.u, rtol=0, atol=atol)
