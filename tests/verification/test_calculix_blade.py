"""A blade of solids that spins in the engine against CalculiX's frequencies of a spun blade.

Everything takes part: mesh, rigid interface, reduction with geometric stiffening, the engine's
linearisation about steady rotation. CalculiX loads the mesh by centrifugal forces with large
displacements and perturbs that state, with stress stiffening and the turning of the load.
"""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification import calculix
from verification.boxes import block
from verification.hubs import on_a_hub
from verification.solids import solid

STEEL = jo.Material(E=2e11, nu=0.3, rho=7850.0)
LENGTH, WIDTH, HEIGHT = 1.0, 0.04, 0.012
# sqrt(E I / (rho A L^4)) of flap, rad/s
UNIT = float(np.sqrt(STEEL.E / (12.0 * STEEL.rho)) * HEIGHT / LENGTH**2)
GRID = block(
    "hexahedron20",
    (LENGTH, WIDTH, HEIGHT),
    (10, 1, 1),
    bend=lambda x: x - np.array([0.0, WIDTH / 2.0, HEIGHT / 2.0]),
)
ROOT = GRID.plane(0, 0.0)


def frequencies(speed):
    """Frequencies in Hz of the blade on a heavy hub that turns about z."""
    part = solid(GRID, STEEL).with_interfaces(jo.Interface("root", ROOT, at=(0.0, 0.0, 0.0)))
    rod = jo.reduce(part, jo.CraigBampton(modes=10), stiffening=True)
    rates = on_a_hub(rod, "root", speed)
    return rates[rates > 0.1 * UNIT] / (2.0 * np.pi)


@pytest.mark.parametrize(("speed", "limit"), [(3.0, 2e-5), (6.0, 1e-4), (12.0, 4e-4)])
def test_frequencies_of_a_spinning_blade(speed, limit):
    # both see the stretch of the spinning blade, in different measures of strain: the difference
    # grows with the strain, that is with the square of the speed
    theirs = calculix.spun_frequencies(
        calculix.Deck(GRID, STEEL, ROOT), speed * UNIT, (0.0, 0.0, 1.0), 4
    )
    ours = frequencies(speed * UNIT)
    found = np.array([ours[np.argmin(np.abs(ours - f))] for f in theirs])
    np.testing.assert_allclose(found, theirs, rtol=limit)
    # flap is far from that at rest
    rest = 3.516 * UNIT / (2.0 * np.pi)
    assert theirs[0] > 1.3 * rest
