"""The elements from first principles (bricks.py) against those of CalculiX, entry by entry.

What is learnt: which quadrature rule CalculiX uses, so that both programs can be asked the same.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification import bricks, calculix
from verification.boxes import KINDS, block

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)


def bent(x):
    """A block that is bent, tapered and sheared: curved faces, no right angle."""
    t = x[:, 0]
    return np.stack(
        [
            t + 0.02 * np.sin(20.0 * x[:, 1]) + 0.01 * x[:, 2],
            x[:, 1] * (1.0 + 0.3 * t) + 0.1 * t**2,
            x[:, 2] * (1.0 + 0.2 * t) + 0.03 * x[:, 1],
        ],
        axis=1,
    )


@calculix.needed
@pytest.mark.parametrize("kind", KINDS)
def test_stiffness_and_mass_are_those_of_calculix(kind):
    mesh = block(kind, (1.0, 0.1, 0.06), (4, 1, 1), bend=bent)
    theirs = calculix.matrices(calculix.Deck(mesh, STEEL))
    for verb, their in zip((bricks.stiffness, bricks.mass), theirs, strict=True):
        ours = verb(mesh, STEEL, bricks.calculix)
        # ccx prints coordinates with 13, entries with 14 digits
        assert abs(ours - their).max() < 5e-12 * abs(their).max()


@pytest.mark.parametrize("kind", KINDS)
def test_probes_of_stiffness_and_mass_are_those_of_calculix(kind):
    mesh = block(kind, (1.0, 0.1, 0.06), (4, 1, 1), bend=bent)
    theirs = calculix.matrix_probes(calculix.Deck(mesh, STEEL))
    for verb, their in zip((bricks.stiffness, bricks.mass), theirs, strict=True):
        calculix.assert_probed(verb(mesh, STEEL, bricks.calculix), their, 5e-12)


def test_probes_see_an_entry_that_is_wrong():
    K = bricks.stiffness(block("hexahedron", (1.0, 0.1, 0.06), (4, 1, 1), bend=bent), STEEL)
    theirs = calculix.probes(K)
    calculix.assert_probed(K, theirs, 5e-12)
    i, j = (int(x[len(x) // 3]) for x in K.nonzero())
    wrong = K.tolil()
    wrong[i, j] = wrong[j, i] = K[i, j] + 1e-7 * abs(K).max()
    with pytest.raises(AssertionError):
        calculix.assert_probed(wrong.tocsr(), theirs, 5e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_bricks_know_rigid_motion_mass_and_uniform_strain(kind):
    mesh = block(kind, (1.0, 0.1, 0.06), (3, 2, 2), bend=bent, curved=False)
    K, M = bricks.stiffness(mesh, STEEL), bricks.mass(mesh, STEEL)
    x, y, z = mesh.nodes.T
    zero = np.zeros_like(x)
    turn = np.stack([-y, x, zero], axis=1).ravel()
    assert np.abs(K @ turn).max() < 1e-12 * abs(K).max()
    # uniform strain: no force on inner nodes, energy 1/2 e^T H e V
    stretch = np.stack([x + 0.5 * y, 2.0 * y + 0.25 * z, -z + x], axis=1).ravel()
    strain = np.array([1.0, 2.0, -1.0, 0.5, 0.25, 1.0])
    volume = (M @ np.ones(len(stretch))).sum() / 3.0 / STEEL.rho
    energy = strain @ bricks.elasticity(STEEL) @ strain * volume
    np.testing.assert_allclose(stretch @ (K @ stretch), energy, rtol=1e-10)
