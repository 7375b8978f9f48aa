"""Planar beam elements: what an element declares, and its forces, all beams of a kind at a time.

An element is a `PlanarElement`: a class with its options as fields. It gives points of integration
with four variables z each, linear in the displacements, ``z = T u``, and a `PlanarLaw`: strains
e(z) with their first and second derivatives. From these follow for all elements

    f = sum T^T (de/dz)^T D (e + beta e'),   K = df/du,   C = df/du',   V = sum e^T D e / 2

where D has the stiffness times the weight of each point, and beta is the Kelvin-Voigt damping.
Displacements of a beam are x, y and rotation of both ends, and its own ones (slopes), which are
functions of unknowns by a coupling of `jousto.planar.elimination`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.object_repr import described
from jousto.planar.elimination import PlanarCoupling
from jousto.planar.section import PlanarSection

Array = NDArray[Any]


class Beams(NamedTuple):
    """Beams of one element in arrays.

    Attributes
    ----------
    chord : (ne, 2) array
        Vector from end to end in the unloaded frame, m.
    EA, GA, EI : (ne,) array
        Stiffness, N, N and N m^2; GA is infinite for a beam without shear deformation.
    mass, rotary : (ne,) array
        Mass and rotary inertia per length, kg/m and kg m.
    """

    chord: Array
    EA: Array
    GA: Array
    EI: Array
    mass: Array
    rotary: Array

    @property
    def length(self) -> Array:
        """Lengths, (ne,), m."""
        return np.asarray(np.hypot(self.chord[:, 0], self.chord[:, 1]))

    @classmethod
    def of(cls, chord: Array, sections: list[PlanarSection]) -> Beams:
        """Return the arrays of beams with their chords and sections."""
        names = ("EA", "GA", "EI", "mass", "rotary")
        return cls(chord, *(np.array([getattr(s, name) for s in sections]) for name in names))


class PlanarLaw(Protocol):
    """Interface of the strains of an element at its points of integration.

    Arrays have the shape (ne, points, ...); m is the number of strains of a point.
    """

    def strains(self, z: Array) -> tuple[Array, Array]:
        """Return the strains (ne, p, m) and their derivatives by z (ne, p, m, 4)."""

    def seconds(self, z: Array) -> Array:
        """Return the second derivatives of the strains by z, (ne, p, m, 4, 4)."""

    def means(self, z: Array) -> tuple[Array, Array]:
        """Return mean eps, gam, kap (1/m) and N, Q (N), M (N m) of each beam, (ne, 3) each."""


class Motion(NamedTuple):
    """Places of the displacements that the own displacements of beams depend on.

    Attributes
    ----------
    ends : (ne, 6) array of int
        x, y, rotation of both ends of each beam.
    stretches : (ne, 2) array of int
        Unknown stretch of both ends of each beam; -1 without.
    size : int
        Number of displacements of ends and of stretches together.
    """

    ends: Array
    stretches: Array
    size: int


class PlanarElement(Declared, by_value=True):
    """Base of the elements of planar frames; the fields of a kind are its options."""

    word: str = ""
    """The word that stands for the element with its default options."""
    own = 0
    """Number of own displacements of a beam, besides x, y and rotation of its ends."""
    stretches = False
    """Whether the stretch of both ends is an unknown."""
    shear_limit = False
    """Whether the law has the tension-shear instability of `PlanarSection.limit`."""

    def check(self, problems: Problems, where: str, section: PlanarSection) -> None:
        """Report a section that the element cannot have."""

    def left_out(self, section: PlanarSection) -> list[str]:
        """Return what the element leaves out of a section, with the value that says so."""
        return []

    def points(self, beams: Beams) -> tuple[PlanarLaw, Array, Array]:
        """Return the law, T (ne, p, 4, 6 + own) and D (ne, p, m) of the points."""
        raise NotImplementedError

    def masses(self, beams: Beams) -> Array:
        """Return the mass matrices (ne, 6 + own, 6 + own)."""
        raise NotImplementedError

    def own_coupling(self, beams: Beams, motion: Motion) -> PlanarCoupling | None:
        """Return the own displacements (own per beam) as a function of ends and stretches."""
        return None


class GroupState(NamedTuple):
    """Strains of a group of beams at one state.

    Attributes
    ----------
    z : (ne, p, 4) array
    rate : (ne, p, 4) array or None
        Rates of z, for the damping.
    strains, resultants : (ne, p, m) array
        Strains, and D times strains with their damping part.
    rows : (ne, p, m, 4) array
        Derivatives of the strains by z.
    """

    z: Array
    rate: Array | None
    strains: Array
    resultants: Array
    rows: Array


@described
@dataclass(frozen=True, eq=False)
class ElementGroup:
    """All beams of a frame that have the same element.

    Attributes
    ----------
    element : PlanarElement
    members : (ne,) array of int
        Indices of the beams in the frame.
    dofs : (ne, k) array of int
        Indices of the displacements of each beam.
    law : PlanarLaw
    T : (ne, p, 4, k) array
        z of the points from the displacements.
    D : (ne, p, m) array
        Stiffness times weight.
    """

    element: PlanarElement
    members: Array
    dofs: Array
    law: PlanarLaw
    T: Array
    D: Array

    def state(self, u: Array, v: Array, beta: float = 0.0) -> GroupState:
        """Return strains and resultants for the displacements and velocities of the frame."""
        z = self._of(u)
        strains, rows = self.law.strains(z)
        if beta == 0.0:
            return GroupState(z, None, strains, self.D * strains, rows)
        rate = self._of(v)
        speed = np.einsum("epmj,epj->epm", rows, rate)
        return GroupState(z, rate, strains, self.D * (strains + beta * speed), rows)

    def _of(self, u: Array) -> Array:
        return np.asarray(np.einsum("epjk,ek->epj", self.T, u[self.dofs]))

    def beam_forces(self, s: GroupState) -> Array:
        """Return the internal forces of each beam on its displacements, (ne, k)."""
        w = np.einsum("epm,epmj->epj", s.resultants, s.rows)
        return np.asarray(np.einsum("epj,epjk->ek", w, self.T))

    def add_force(self, s: GroupState, F: Array) -> None:
        """Add the internal forces to F, in place."""
        np.add.at(F, self.dofs, self.beam_forces(s))

    def add_stiffness(self, s: GroupState, beta: float, K: Array) -> None:
        """Add the derivative of the internal forces by the displacements, in place."""
        second = self.law.seconds(s.z)
        rows = s.rows
        if s.rate is not None:
            # the strain rates depend on z too
            rows = rows + beta * np.einsum("epmij,epj->epmi", second, s.rate)
        H = np.einsum("epmi,epm,epmj->epij", s.rows, self.D, rows)
        H = H + np.einsum("epm,epmij->epij", s.resultants, second)
        self._add(H, K)

    def add_damping(self, s: GroupState, beta: float, C: Array) -> None:
        """Add the derivative of the internal forces by the velocities, in place."""
        self._add(beta * np.einsum("epmi,epm,epmj->epij", s.rows, self.D, s.rows), C)

    def _add(self, H: Array, K: Array) -> None:
        of_beams = (self.T.transpose(0, 1, 3, 2) @ H @ self.T).sum(axis=1)
        np.add.at(K, (self.dofs[:, :, None], self.dofs[:, None, :]), of_beams)

    def energy(self, s: GroupState) -> float:
        """Return the strain energy, J."""
        return 0.5 * float(np.sum(self.D * s.strains**2))

    def dissipation(self, s: GroupState, beta: float) -> float:
        """Return the power that the damping dissipates, W."""
        if s.rate is None:
            return 0.0
        speed = np.einsum("epmj,epj->epm", s.rows, s.rate)
        return beta * float(np.sum(self.D * speed**2))

    def free_motions(self) -> int:
        """Return the number of motions of a free beam without energy, besides rigid ones.

        The rank of the strains by the displacements, for the first beam, straight and unloaded.
        Displacements without an effect on z, such as rotations beside slopes, do not count.
        """
        none = np.zeros((len(self.T), self.T.shape[1], 4))
        rows = self.law.strains(none)[1][0] @ self.T[0]
        used = np.abs(self.T[0]).max(axis=(0, 1)) > 0.0
        rows = rows[self.D[0] > 0.0][:, used]
        # columns by their size, then rows, so that units have no effect
        rows = rows / _sizes(rows, 0)
        rows = rows / _sizes(rows, 1)
        return int(used.sum() - np.linalg.matrix_rank(rows, tol=1e-9) - 3)


def _sizes(rows: Array, axis: int) -> Array:
    """Return the norms along an axis, 1 instead of zero."""
    size = np.linalg.norm(rows, axis=axis, keepdims=True)
    return np.asarray(np.where(size > 0.0, size, 1.0))
