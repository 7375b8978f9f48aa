"""AncfElement: cable element in absolute nodal coordinates, cubic positions without shear.

A. A. Shabana, *Nonlinear Dynamics* 16 (1998) 293-306; M. Berzeri, A. A. Shabana, *J. Sound Vib.*
235 (2000) 539-565 (law "BS"); J. Gerstmayr, H. Irschik, *J. Sound Vib.* 318 (2008) 461-487 (law
"GI", Reissner's strains without shear).

The axis is ``r = S e`` with cubic Hermite functions of the positions and slopes r' of both ends. At
a point of integration z = [r' - r0', r''], and with c = r' x r''

    GI: eps = |r'| - 1,            k = c / |r'|^2
    BS: eps = (r' . r' - 1) / 2,   k = c / |r'|^3

Unknowns of an end are x, y, the rotation th, and the stretch s: ``r' = (1 + s) R(th) r0'`` is a
coupling, so that supports, moments, offsets and links act as on other elements.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.fields import Choice, field
from jousto.base.object_repr import described
from jousto.planar.element import Beams, Motion, PlanarElement, PlanarLaw
from jousto.planar.elimination import PlanarCoupling
from jousto.planar.section import PlanarSection
from jousto.planar.slope_coupling import SlopeCoupling

Array = NDArray[Any]

RULES = ("lobatto 3", "lobatto 4", "lobatto 5", *(f"gauss {n}" for n in range(1, 8)))


def rule(word: str) -> tuple[Array, Array]:
    """Return points and weights of a rule ``"gauss N"`` or ``"lobatto N"`` on 0 to 1."""
    name, n = word.split()
    legendre = np.polynomial.legendre
    if name == "gauss":
        x, w = legendre.leggauss(int(n))
    else:
        # Lobatto: ends and the extremes of the Legendre polynomial P of degree n - 1
        P = legendre.Legendre.basis(int(n) - 1)
        x = np.concatenate([[-1.0], np.sort(P.deriv().roots().real), [1.0]])
        w = 2.0 / (int(n) * (int(n) - 1) * P(x) ** 2)
    return 0.5 * (x + 1.0), 0.5 * w


@described
class AncfLaw:
    """Strains eps and k of the points.

    Parameters
    ----------
    beams : Beams
    law : str
        "GI" or "BS".
    place, axial, bending : (p,) array
        Points from 0 to 1, with their weights for the axial and the bending part.
    """

    def __init__(self, beams: Beams, law: str, place: Array, axial: Array, bending: Array) -> None:
        self.start = (beams.chord / beams.length[:, None])[:, None]
        self.green, self.power = law == "BS", 3 if law == "BS" else 2
        self.place, self.axial, self.bending = place, axial, bending
        self.EA, self.EI, self.L = beams.EA, beams.EI, beams.length

    def _parts(self, z: Array) -> tuple[Array, Array, Array, Array, Array]:
        """Return r', r'', c and its derivative by r', |r'|^2 - 1."""
        d, curved = z[..., :2], z[..., 2:]
        slope = self.start + d
        grown = np.sum((2.0 * self.start + d) * d, axis=-1)
        c = slope[..., 0] * curved[..., 1] - slope[..., 1] * curved[..., 0]
        by_slope = np.stack([curved[..., 1], -curved[..., 0]], axis=-1)
        return slope, curved, c, by_slope, grown

    def strains(self, z: Array) -> tuple[Array, Array]:
        """Return eps and k (1/m) with their derivatives by z."""
        slope, _, c, by_slope, grown = self._parts(z)
        square = 1.0 + grown
        size, m = np.sqrt(square), self.power
        eps = 0.5 * grown if self.green else grown / (size + 1.0)
        k = c / size**m
        rows = np.zeros((*z.shape[:2], 2, 4), dtype=z.dtype)
        rows[..., 0, :2] = slope if self.green else slope / size[..., None]
        rows[..., 1, :2] = by_slope / (size**m)[..., None] - (m * k / square)[..., None] * slope
        rows[..., 1, 2] = -slope[..., 1] / size**m
        rows[..., 1, 3] = slope[..., 0] / size**m
        return np.stack([eps, k], axis=-1), rows

    def seconds(self, z: Array) -> Array:
        """Return the second derivatives of eps and k by z."""
        slope, _, c, by_slope, grown = self._parts(z)
        square = (1.0 + grown)[..., None, None]
        size, m = np.sqrt(square), self.power
        one = np.eye(2)
        rr = slope[..., :, None] * slope[..., None, :]
        second = np.zeros((*z.shape[:2], 2, 4, 4), dtype=z.dtype)
        second[..., 0, :2, :2] = one if self.green else (one - rr / square) / size
        # k twice by r'
        gr = by_slope[..., :, None] * slope[..., None, :]
        k = c[..., None, None] / size**m
        second[..., 1, :2, :2] = (
            -m * (gr + np.swapaxes(gr, -1, -2)) / size ** (m + 2)
            - m * k * one / square
            + m * (m + 2) * k * rr / square**2
        )
        # k by r' and r''
        turned = np.stack([-slope[..., 1], slope[..., 0]], axis=-1)
        J = np.array([[0.0, 1.0], [-1.0, 0.0]])
        mixed = J / size**m - m * slope[..., :, None] * turned[..., None, :] / size ** (m + 2)
        second[..., 1, :2, 2:] = mixed
        second[..., 1, 2:, :2] = np.swapaxes(mixed, -1, -2)
        return second

    def means(self, z: Array) -> tuple[Array, Array]:
        """Return the means over the points, and Q from the slope of M through them."""
        e = self.strains(z)[0]
        eps, kap = e[..., 0] @ self.axial, e[..., 1] @ self.bending
        # least squares: M = EI (kap + slope (s - 1/2))
        arm = self.place - 0.5
        spread = float(self.bending @ arm**2)
        slope = e[..., 1] @ (self.bending * arm) / (spread * self.L) if spread > 0.0 else 0.0 * kap
        N, Q = self.EA * eps, -self.EI * slope / (1.0 + eps)
        strains = np.stack([eps, 0.0 * eps, kap], axis=1)
        return strains, np.stack([N, Q, self.EI * kap], axis=1)


def hermite(s: Array, L: Array) -> tuple[Array, Array]:
    """Return the derivatives r' and r'' of cubic Hermite functions, (ne, p, 4) each.

    Parameters
    ----------
    s : (p,) array
        Places from 0 to 1.
    L : (ne,) array
        Lengths, m; the functions belong to r1, r1', r2, r2'.
    """
    one, x = np.ones((len(L), 1)), L[:, None]
    first = [(6 * s**2 - 6 * s) / x, one * (1 - 4 * s + 3 * s**2)]
    first += [(6 * s - 6 * s**2) / x, one * (3 * s**2 - 2 * s)]
    second = [(12 * s - 6) / x**2, (6 * s - 4) / x, (6 - 12 * s) / x**2, (6 * s - 2) / x]
    return np.stack(first, axis=-1), np.stack(second, axis=-1)


class AncfElement(PlanarElement):
    """Cable in absolute nodal coordinates: cubic positions, stretch and bending, no shear.

    The slopes r' of both ends follow their rotation, with a stretch of their own; two collinear
    beams of one section share the stretch at a node that nothing else acts on along the axis. For
    these unknowns the mass matrix depends on the displacements (`Elimination`); for r and r' it is
    constant. Errors are of order 4 in the length of the elements. The section has neither shear nor
    rotary inertia.

    References
    ----------
    A. A. Shabana, *Nonlinear Dynamics* 16 (1998) 293-306; M. Berzeri, A. A. Shabana, *J. Sound
    Vib.* 235 (2000) 539-565; J. Gerstmayr, H. Irschik, *J. Sound Vib.* 318 (2008) 461-487.
    """

    law: Choice = field(
        "``'GI'``: ``eps = |r'| - 1`` and the curvature ``th'``, as of the exact beam. ``'BS'``: "
        "``eps = (r'.r' - 1)/2`` and the geometric curvature; pure bending stretches the axis",
        words=("GI", "BS"),
        default="GI",
    )
    axial: Choice = field(
        "Points of integration of the axial part. More than 3 lock the element in coarse meshes, "
        "2 Gauss points leave a motion without energy",
        words=RULES,
        default="lobatto 3",
    )
    bending: Choice = field(
        "Points of integration of the bending part", words=RULES, default="gauss 3"
    )

    word = "ancf"
    own = 4
    stretches = True

    def left_out(self, section: PlanarSection) -> list[str]:
        """Return shear deformation and rotary inertia of the section, which have no effect."""
        found = ["shear (GA=math.inf)"] if math.isfinite(section.GA) else []
        return found + (["rotary inertia (rotary=0)"] if section.rotary > 0.0 else [])

    def points(self, beams: Beams) -> tuple[PlanarLaw, Array, Array]:
        """Return the law, and the points of both rules."""
        (xa, wa), (xb, wb) = rule(self.axial), rule(self.bending)
        place = np.concatenate([xa, xb])
        axial = np.concatenate([wa, 0.0 * wb])
        bending = np.concatenate([0.0 * wa, wb])
        L = beams.length
        first, second = hermite(place, L)
        T = np.zeros((len(L), len(place), 4, 10))
        for c in range(2):
            # x, y of the ends, and their slopes behind the six displacements of the ends
            at = [c, 6 + c, 3 + c, 8 + c]
            T[:, :, c, at] = first
            T[:, :, 2 + c, at] = second
        D = np.zeros((len(L), len(place), 2))
        D[..., 0] = (beams.EA * L)[:, None] * axial
        D[..., 1] = (beams.EI * L)[:, None] * bending
        return AncfLaw(beams, self.law, place, axial, bending), T, D

    def masses(self, beams: Beams) -> Array:
        """Return ``int m S^T S``, the mass matrices of cubic Hermite functions."""
        L = beams.length
        one = np.ones_like(L)
        shares = [
            [156 * one, 22 * L, 54 * one, -13 * L],
            [22 * L, 4 * L**2, 13 * L, -3 * L**2],
            [54 * one, 13 * L, 156 * one, -22 * L],
            [-13 * L, -3 * L**2, -22 * L, 4 * L**2],
        ]
        share = np.moveaxis(np.array(shares), -1, 0) * (beams.mass * L / 420.0)[:, None, None]
        M = np.zeros((len(L), 10, 10))
        for c in range(2):
            at = np.array([c, 6 + c, 3 + c, 8 + c])
            M[:, at[:, None], at] = share
        return M

    def own_coupling(self, beams: Beams, motion: Motion) -> PlanarCoupling | None:
        """Return the slopes of both ends."""
        start = np.repeat(beams.chord / beams.length[:, None], 2, axis=0)
        turn, stretch = motion.ends[:, [2, 5]].ravel(), motion.stretches.ravel()
        return SlopeCoupling(turn, stretch, start, motion.size)
