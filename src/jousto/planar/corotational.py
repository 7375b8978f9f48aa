"""CorotationalElement: small deformations about a chord that turns by any angle.

M. A. Crisfield, *Non-linear Finite Element Analysis of Solids and Structures*, vol. 1, Wiley 1991,
chapter 7; T. N. Le, J.-M. Battini, M. Hjiaj, *Comput. Struct.* 89 (2011) 1159-1178 for the mass.

With the chord of length l and angle psi from its unloaded direction, ``t_i = th_i - psi`` and

    eps = (l - l0)/l0,   a = t2 - t1,   b = t1 + t2
    2 V = EA l0 eps^2 + EI/l0 a^2 + 3 EI/(l0 (1 + Phi)) b^2,   Phi = 12 EI / (GA l0^2)

which is ``M1 = EI/l0 (4 t1 + 2 t2)`` for Phi = 0. The option ``arch`` adds the mean of w'^2/2 to
eps: ``(2 t1^2 - t1 t2 + 2 t2^2)/30 = a^2/24 + b^2/40``.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.fields import Choice, Flag, field
from jousto.base.object_repr import described
from jousto.planar.chord_coupling import ChordCoupling, turned
from jousto.planar.element import Beams, Motion, PlanarElement, PlanarLaw
from jousto.planar.elimination import PlanarCoupling
from jousto.planar.exact import linear_mass
from jousto.planar.section import PlanarSection

Array = NDArray[Any]


@described
class CorotationalLaw:
    """Strains eps, a, b of an element; z is the change of the chord (m) and both rotations.

    Parameters
    ----------
    beams : Beams
    shear : bool
        Whether Phi counts.
    arch : bool
        Whether eps has the shallow-arch part.
    """

    def __init__(self, beams: Beams, shear: bool, arch: bool) -> None:
        self.chord, self.l0, self.arch = beams.chord[:, None], beams.length[:, None], arch
        self.EA, self.EI, self.GA = beams.EA, beams.EI, beams.GA
        L = beams.length
        self.phi = 12.0 * beams.EI / (beams.GA * L**2) if shear else 0.0 * L
        self.shear = shear
        stiffness = (beams.EA * L, beams.EI / L, 3.0 * beams.EI / (L * (1.0 + self.phi)))
        self.D = np.stack(stiffness, axis=1)[:, None]

    def _turned(self, z: Array) -> tuple[Array, Array, Array, Array, Array]:
        """Return l - l0, l, the unit vector of the chord, t1 and t2."""
        d = z[..., :2]
        now = self.chord + d
        # l^2 - l0^2 from displacements, without the difference of large numbers
        grown = np.sum((2.0 * self.chord + d) * d, axis=-1)
        length = np.sqrt(self.l0**2 + grown)
        psi = turned(self.chord, d)
        t = z[..., 2:] - psi[..., None]
        # to the nearest turn
        t = t - 2.0 * np.pi * np.round(np.real(t) / (2.0 * np.pi))
        unit = now / length[..., None]
        return grown / (length + self.l0), length, unit, t[..., 0], t[..., 1]

    def strains(self, z: Array) -> tuple[Array, Array]:
        """Return eps, a, b and their derivatives by z."""
        stretch, length, unit, t1, t2 = self._turned(z)
        a, b = t2 - t1, t1 + t2
        rows = np.zeros((*z.shape[:2], 3, 4), dtype=z.dtype)
        rows[..., 0, :2] = unit / self.l0[..., None]
        rows[..., 1, 2:] = -1.0, 1.0
        # d psi = n . dx / l
        rows[..., 2, 0] = 2.0 * unit[..., 1] / length
        rows[..., 2, 1] = -2.0 * unit[..., 0] / length
        rows[..., 2, 2:] = 1.0
        eps = stretch / self.l0
        if self.arch:
            eps = eps + a**2 / 24.0 + b**2 / 40.0
            rows[..., 0, :] += (a / 12.0)[..., None] * rows[..., 1, :]
            rows[..., 0, :] += (b / 20.0)[..., None] * rows[..., 2, :]
        return np.stack([eps, a, b], axis=-1), rows

    def seconds(self, z: Array) -> Array:
        """Return the second derivatives of eps, a, b by z."""
        _, length, e, t1, t2 = self._turned(z)
        n = np.stack([-e[..., 1], e[..., 0]], axis=-1)
        second = np.zeros((*z.shape[:2], 3, 4, 4), dtype=z.dtype)
        nn, ne = n[..., :, None] * n[..., None, :], n[..., :, None] * e[..., None, :]
        second[..., 0, :2, :2] = nn / (length * self.l0)[..., None, None]
        both = ne + np.swapaxes(ne, -1, -2)
        second[..., 2, :2, :2] = 2.0 * both / (length**2)[..., None, None]
        if self.arch:
            rows, b = self.strains(z)[1], t1 + t2
            for k, share in ((1, 12.0), (2, 20.0)):
                r = rows[..., k, :]
                second[..., 0, :, :] += r[..., :, None] * r[..., None, :] / share
            second[..., 0, :, :] += (b / 20.0)[..., None, None] * second[..., 2, :, :]
        return second

    def means(self, z: Array) -> tuple[Array, Array]:
        """Return eps, mean curvature a/l0 and the shear strain of Q; Q = -(M1 + M2)/l."""
        e = self.strains(z)[0][:, 0]
        length = self._turned(z)[1][:, 0]
        L = self.l0[:, 0]
        # M1 + M2 is twice the derivative of the energy by b
        Q = -2.0 * self.D[:, 0, 2] * e[:, 2] / length
        gam = Q / self.GA if self.shear else 0.0 * Q
        kap = e[:, 1] / L
        strains = np.stack([e[:, 0], gam, kap], axis=1)
        return strains, np.stack([self.EA * e[:, 0], Q, self.EI * kap], axis=1)


class CorotationalElement(PlanarElement):
    """Small strains and small angles about the chord of the element, which turns by any angle.

    ``N = EA (l - l0)/l0, M1 = EI/l0 (4 t1 + 2 t2)`` with the angles ``t_i = th_i - psi`` from the
    chord to the ends. Errors are of order 2 in the length of the elements, also in bending by end
    moments: the nodes lie on a polygon.

    References
    ----------
    M. A. Crisfield, *Non-linear Finite Element Analysis of Solids and Structures*, vol. 1, Wiley
    1991, chapter 7; T. N. Le, J.-M. Battini, M. Hjiaj, *Comput. Struct.* 89 (2011) 1159-1178.
    """

    shear: Flag = field(
        "Whether the stiffness GA of the section counts, by ``Phi = 12 EI / (GA l0^2)``",
        default=True,
    )
    arch: Flag = field(
        "Whether bending stretches the axis: adds ``(2 t1^2 - t1 t2 + 2 t2^2)/30`` to the strain",
        default=False,
    )
    mass: Choice = field(
        "``'linear'``: linear positions and rotations, a constant mass matrix. ``'cubic'``: "
        "positions cubic about the turned chord; the mass matrix depends on the displacements, "
        "with its velocity terms",
        words=("linear", "cubic"),
        default="linear",
    )

    word = "corotational"

    @property
    def own(self) -> int:  # type: ignore[override]
        """Number of own displacements: two deviations from the chord with a cubic mass."""
        return 4 if self.mass == "cubic" else 0

    def left_out(self, section: PlanarSection) -> list[str]:
        """Return the shear deformation, if it does not count and is not infinite."""
        return [] if self.shear or not np.isfinite(section.GA) else ["shear (GA=math.inf)"]

    def points(self, beams: Beams) -> tuple[PlanarLaw, Array, Array]:
        """Return the law and one point for each beam."""
        T = np.zeros((len(beams.EA), 1, 4, 6 + self.own))
        for row, (a, b) in {0: (0, 3), 1: (1, 4)}.items():
            T[:, 0, row, a], T[:, 0, row, b] = -1.0, 1.0
        T[:, 0, 2, 2] = T[:, 0, 3, 5] = 1.0
        law = CorotationalLaw(beams, self.shear, self.arch)
        return law, T, law.D

    def masses(self, beams: Beams) -> Array:
        """Return the mass matrices of the ends, and of the deviations d_i = l0 t_i n."""
        if self.mass == "linear":
            return linear_mass(beams, beams.mass)
        M = np.zeros((len(beams.mass), 10, 10))
        M[:, :6, :6] = linear_mass(beams, 0.0 * beams.mass)
        # r = (1 - s) x1 + s x2 + s (1 - s)^2 d1 - s^2 (1 - s) d2
        s, w = np.polynomial.legendre.leggauss(4)
        s, w = 0.5 * (s + 1.0), 0.5 * w
        shape = np.stack([1.0 - s, s, s * (1.0 - s) ** 2, -(s**2) * (1.0 - s)])
        share = (shape * w) @ shape.T
        for c in range(2):
            at = np.array([c, c + 3, c + 6, c + 8])
            M[:, at[:, None], at] += (beams.mass * beams.length)[:, None, None] * share
        return M

    def own_coupling(self, beams: Beams, motion: Motion) -> PlanarCoupling | None:
        """Return the deviations of both ends from the chord."""
        return ChordCoupling(beams.chord, motion.ends, motion.size) if self.own else None
