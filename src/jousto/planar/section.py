"""PlanarSection: stiffness and mass of a beam in its plane."""

from __future__ import annotations

import math
from typing import Any

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, Positive
from jousto.materials.material import Material
from jousto.sections.section import Section

NOT_NEGATIVE = "zero or a positive number"


class PositiveOrInfinite(Positive):
    """Field of a number above zero, or infinity."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a float above zero, or report what is wrong."""
        if isinstance(value, float) and value == math.inf:
            return math.inf
        return super().check(problems, where, value)


class PlanarSection(Declared, by_value=True):
    """Stiffness and mass of a beam in its plane: ``[N, Q, M] = [EA eps, GA gam, EI kap]``.

    Raises
    ------
    InputError
        With all values that are not positive (mass and rotary: not negative).

    Examples
    --------
    >>> PlanarSection(EA=2.8e7, GA=1e7, EI=1.4e4, mass=1.2, rotary=6e-4).limit
    15555555.6
    """

    EA: Positive = field("Axial stiffness", unit="N")
    GA: PositiveOrInfinite = field(
        "Shear stiffness with its shear coefficient; infinite for no shear deformation", unit="N"
    )
    EI: Positive = field("Bending stiffness", unit="N m^2")
    mass: Number = field("Mass per length", unit="kg/m", least=0, wanted=NOT_NEGATIVE, default=0.0)
    rotary: Number = field(
        "Rotary inertia per length, rho I", unit="kg m", least=0, wanted=NOT_NEGATIVE, default=0.0
    )

    @classmethod
    def of(cls, section: Section, material: Material, *, GA: float | None = None) -> PlanarSection:
        """Return the planar section of a section in bending about its z axis.

        Parameters
        ----------
        section : Section
            `Rectangle`, `Circle` and others, with y in the plane of the frame.
        material : Material
        GA : float, optional
            Shear stiffness, N; the default is the shear area ``ky A`` times G.

        Raises
        ------
        InputError
            If the section has no shear coefficient and no GA is given.
        """
        if GA is None:
            problems = Problems()
            if section.ky is None:
                text = "has no shear coefficient ky; give PlanarSection.of(..., GA=) in N"
                problems.add(type(section).__name__, text)
            problems.raise_if_any()
            GA = (section.ky or 0.0) * section.A * material.G
        rho = material.rho
        return cls(
            EA=material.E * section.A,
            GA=GA,
            EI=material.E * section.Iz,
            mass=rho * section.A,
            rotary=rho * section.Iz,
        )

    @property
    def slender(self) -> PlanarSection:
        """The section without shear deformation and rotary inertia."""
        if math.isinf(self.GA) and not self.rotary:
            return self
        return PlanarSection(EA=self.EA, GA=math.inf, EI=self.EI, mass=self.mass)

    @property
    def limit(self) -> float:
        """Largest stable axial force, N: ``GA / (1 - GA / EA)``; infinite for GA >= EA.

        Above this limit a stretched beam reduces its energy by a rotation of its cross sections.
        This tension-shear instability is a property of the linear law, not of real materials.
        """
        return math.inf if self.GA >= self.EA else self.GA / (1.0 - self.GA / self.EA)
