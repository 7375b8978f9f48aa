"""ExactElement: the planar two-node Reissner beam.

E. Reissner, *ZAMP* 23 (1972) 795-804; J. C. Simo, L. Vu-Quoc, *J. Appl. Mech.* 53 (1986) 849-863;
in the form of Makinen, Marjamaki and Pajunen, equations 14 to 19: linear shape functions, one point
of integration for the elastic forces, exact integration of the mass.

The variables at the midpoint of an element are ``z = [x', y', theta, kappa]``, without their values
in the unloaded frame. With c, s the cosine and sine of theta

    eps = x' c + y' s - 1,   gam = y' c - x' s,   kap = theta'                          (17)
    d eps/dz = [c, s, gam, 0],   d gam/dz = [-s, c, -(1 + eps), 0],   d kap/dz = [0, 0, 0, 1]

and B of eq. 15 is these rows times T.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.errors import Problems
from jousto.base.object_repr import described
from jousto.planar.element import Beams, PlanarElement, PlanarLaw
from jousto.planar.section import PlanarSection

Array = NDArray[Any]


@described
class ExactLaw:
    """Strains of Reissner's beam, one point for each beam.

    Parameters
    ----------
    beams : Beams
    """

    def __init__(self, beams: Beams) -> None:
        x, y = (beams.chord / beams.length[:, None]).T
        self.start = np.stack([x, y, np.arctan2(y, x), 0.0 * x], axis=1)[:, None]
        self.stiffness = np.stack([beams.EA, beams.GA, beams.EI], axis=1)

    def strains(self, z: Array) -> tuple[Array, Array]:
        """Return eps, gam, kap, eq. 17, and their derivatives by z, eq. 15."""
        x, y, th, kap = np.moveaxis(z + self.start, -1, 0)
        c, s = np.cos(th), np.sin(th)
        stretch, gam = x * c + y * s, y * c - x * s
        rows = np.zeros((*z.shape[:2], 3, 4), dtype=z.dtype)
        rows[..., 0, 0] = rows[..., 1, 1] = c
        rows[..., 0, 1] = s
        rows[..., 1, 0] = -s
        rows[..., 0, 2] = gam
        rows[..., 1, 2] = -stretch
        rows[..., 2, 3] = 1.0
        return np.stack([stretch - 1.0, gam, kap], axis=-1), rows

    def seconds(self, z: Array) -> Array:
        """Return the second derivatives: the rows of eps and gam turn with theta."""
        rows = self.strains(z)[1]
        second = np.zeros((*rows.shape, 4), dtype=z.dtype)
        # d(eps row)/dtheta is the gam row, d(gam row)/dtheta minus the eps row
        for k, other in ((0, rows[..., 1, :3]), (1, -rows[..., 0, :3])):
            second[..., k, :3, 2] = other
            second[..., k, 2, :3] = other
        return second

    def means(self, z: Array) -> tuple[Array, Array]:
        """Return strains and resultants at the midpoint."""
        strains = self.strains(z)[0][:, 0]
        return strains, self.stiffness * strains


class ExactElement(PlanarElement):
    """Geometrically exact beam of Reissner with two nodes: stretch, shear and bending.

    ``eps = x' c + y' s - 1, gam = y' c - x' s, kap = theta'`` at the midpoint, by linear shape
    functions; consistent mass with rotary inertia. Errors are of order 2 in the length of the
    elements. Bending by end moments is exact.

    References
    ----------
    E. Reissner, *ZAMP* 23 (1972) 795-804; J. C. Simo, L. Vu-Quoc, *J. Appl. Mech.* 53 (1986)
    849-863.
    """

    word = "exact"
    shear_limit = True

    def check(self, problems: Problems, where: str, section: PlanarSection) -> None:
        """Report an infinite shear stiffness: the element would lock."""
        if not np.isfinite(section.GA):
            text = "GA is infinite, and the exact element has shear deformation; give GA in N, "
            text += "or element='ancf' or 'corotational'"
            problems.add(where, text)

    def points(self, beams: Beams) -> tuple[PlanarLaw, Array, Array]:
        """Return the law and the midpoints."""
        L = beams.length
        T = np.zeros((len(L), 1, 4, 6))
        for row, (a, b) in {0: (0, 3), 1: (1, 4), 3: (2, 5)}.items():
            T[:, 0, row, a] = -1.0 / L
            T[:, 0, row, b] = 1.0 / L
        T[:, 0, 2, [2, 5]] = 0.5
        law = ExactLaw(beams)
        return law, T, (law.stiffness * L[:, None])[:, None]

    def masses(self, beams: Beams) -> Array:
        """Return the mass matrices of eq. 19."""
        return linear_mass(beams, beams.mass)


def linear_mass(beams: Beams, mass: Array) -> Array:
    """Return the mass matrices (ne, 6, 6) of linear positions and rotations, eq. 19.

    Parameters
    ----------
    beams : Beams
    mass : (ne,) array
        Mass per length of the positions, kg/m.
    """
    M = np.zeros((len(mass), 6, 6))
    for c, value in enumerate((mass, mass, beams.rotary)):
        share = value * beams.length / 6.0
        M[:, c, c] = M[:, c + 3, c + 3] = 2.0 * share
        M[:, c, c + 3] = M[:, c + 3, c] = share
    return M
