"""Linear elastic, isotropic material."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from jousto.base.arguments import explained
from jousto.base.errors import Problems, warn

# Pa, a thousand times diamond: stiffer ones leave no digits for the rest of a model
STIFFEST = 1e15


@explained
@dataclass(frozen=True)
class Material:
    """Linear elastic, isotropic material.

    Parameters
    ----------
    E : float
        Young's modulus in Pa.
    nu : float
        Poisson's ratio, above -1 and at most 0.5.
    rho : float
        Density in kg/m^3; zero makes a massless member.
    name : str
        Shown in messages.
    source : str
        Where the values come from; the materials of :func:`material` say it.
    alpha : float, optional
        Coefficient of thermal expansion in 1/K, for the temperature of strain gauges.

    Raises
    ------
    InputError
        If a value is not finite or outside its physical range (all of them together).

    Warns
    -----
    JoustoWarning
        If E or rho looks like another system of units (MPa, GPa, kPa, t/mm^3, g/cm^3).

    Examples
    --------
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> round(steel.G / 1e9, 2)
    80.77
    """

    E: float
    nu: float
    rho: float
    name: str = ""
    source: str = field(default="", compare=False)
    alpha: float | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        where = f"material '{self.name}'" if self.name else "material"
        problems = Problems()
        problems.positive(where, "Young's modulus E", self.E, "Pa")
        if not problems.found and self.E > STIFFEST:
            problems.add(
                where,
                f"Young's modulus E is {self.E:g} Pa, must be below {STIFFEST:g} Pa: nothing is as"
                " stiff, and too few digits are left for the rest of the model",
            )
        if not -1.0 < self.nu <= 0.5:
            problems.add(where, f"Poisson's ratio nu is {self.nu:g}, must be in (-1, 0.5]")
        if not (math.isfinite(self.rho) and self.rho >= 0.0):
            problems.add(where, f"density rho is {self.rho:g} kg/m^3, must be zero or positive")
        if self.alpha is not None and not abs(self.alpha) < 0.01:
            problems.add(
                where, f"alpha is {self.alpha:g} 1/K; was it meant in 1e-6/K? Give it as 12e-6"
            )
        problems.raise_if_any()

        # values that are legal numbers but most likely in other units
        hints = []
        if self.E < 1e9:
            unit = _likely_unit(self.E)
            hints.append(f"E = {self.E:g} Pa is softer than most plastics; was it given in {unit}?")
        elif self.E > 2e12:
            hints.append(f"E = {self.E:g} Pa is stiffer than diamond; SI needs Pa")
        if self.rho > 5e4:
            hints.append(f"rho = {self.rho:g} kg/m^3 is denser than any metal; SI needs kg/m^3")
        elif 0.0 < self.rho < 1.0:
            hints.append(f"rho = {self.rho:g} kg/m^3 is lighter than air; was it given in t/mm^3?")
        elif 0.0 < self.rho < 25.0 and self.E > 1e9:
            hints.append(
                f"rho = {self.rho:g} kg/m^3 is lighter than any foam; was it given in g/cm^3?"
            )
        for hint in hints:
            warn(where, hint)

    @property
    def G(self) -> float:
        """Shear modulus E / (2 (1 + nu)) in Pa."""
        return self.E / (2.0 * (1.0 + self.nu))


def _likely_unit(E: float) -> str:
    """Return the unit in which a modulus would be that of a metal or a hard plastic."""
    for factor, unit in ((1e6, "MPa"), (1e9, "GPa"), (1e3, "kPa")):
        if 1e9 <= E * factor <= 2e12:
            return unit
    return "MPa"
