"""A solid body that spins freely: momenta and energy from the finite element matrices.

The velocity field ``R' + w x u + Phi p'`` is linear in the nodal positions, so that the consistent
mass matrix of an isoparametric solid gives its momenta exactly; the sums here use it and the nodes
alone, not the invariants of the reduced part.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification import bricks
from verification.boxes import block
from verification.mechanisms import march, orders
from verification.particles import rotation
from verification.solids import solid

pytestmark = pytest.mark.filterwarnings("ignore:.*has no joint to another body")

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
N = 8


def bent(x):
    """A tapered, twisted bar: three different moments of inertia, no plane of symmetry."""
    t = x[:, 0] / 0.4
    y, z = x[:, 1] * (1.0 - 0.4 * t), x[:, 2] * (1.0 + 0.5 * t)
    c, s = np.cos(0.6 * t), np.sin(0.6 * t)
    return np.stack([x[:, 0], c * y - s * z + 0.05 * t**2, s * y + c * z], axis=1)


@pytest.mark.parametrize("kind", ["hexahedron20", "tetra10"])
def test_a_free_solid_keeps_its_momenta_and_energy(kind):
    grid = block(kind, (0.4, 0.04, 0.02), (6, 1, 1), bend=bent)
    part = solid(grid, STEEL)
    reduced = jo.reduce(part, jo.FreeFree(modes=N))
    body = jo.FlexibleBody(
        "free",
        reduced,
        position=(0.3, -0.2, 0.5),
        orientation=jo.Rotate((1, 2, 3), degrees=50.0),
        velocity=(0.5, -1.0, 2.0),
        angular_velocity=(60.0, -80.0, 200.0),
        modal_velocities=2.0 * np.cos(np.arange(N)),
    )
    model = jo.compile(jo.Mechanism(body))
    K = bricks.stiffness(grid, STEEL, bricks.calculix)
    M = bricks.mass(grid, STEEL)
    m = M[::3, ::3]  # scalar mass
    Phi = reduced.modes

    def sums(q, v):
        A = rotation(q[3:7])
        d, rate = Phi @ q[7:], Phi @ v[6:]
        u = grid.nodes + d
        r = q[:3] + u @ A.T
        speed = v[:3] + (np.cross(v[3:6], u) + rate) @ A.T
        turn = np.einsum("ai,aj->ij", r, m @ speed)
        L = np.array([turn[1, 2] - turn[2, 1], turn[2, 0] - turn[0, 2], turn[0, 1] - turn[1, 0]])
        kinetic = 0.5 * np.sum(speed * (m @ speed))
        return np.concatenate([(m @ speed).sum(0), L, [kinetic, 0.5 * d.ravel() @ (K @ d.ravel())]])

    errors = []
    for steps in (800, 1600):
        run = march(model, jo.RK4(step=4e-3 / steps), 4e-3, 4e-4)
        table = np.array([sums(q, v) for q, v in zip(run.q, run.v, strict=True)])
        energy = table[:, 6] + table[:, 7]
        # the bar bends: strain energy goes and comes
        assert np.ptp(table[:, 7]) > 1e-3 * energy[0]
        change = np.abs(table[:, :6] - table[0, :6])
        errors.append(
            [
                change[:, :3].max() / np.abs(table[0, :3]).max(),
                change[:, 3:].max() / np.abs(table[0, 3:6]).max(),
                np.abs(energy / energy[0] - 1.0).max(),
            ]
        )
    names = ("momentum", "angular momentum", "energy")
    for name, limit, pair in zip(
        names, (1e-12, 1e-9, 1e-7), zip(*errors, strict=True), strict=True
    ):
        assert pair[-1] < limit, (name, pair)
        # constant to the method's order, or already at round-off
        assert pair[-1] < 1e-12 or orders(pair)[-1] > 3.7, (name, pair)
