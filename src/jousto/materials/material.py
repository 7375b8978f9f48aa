"""Linear elastic, isotropic material."""

from __future__ import annotations

from jousto.base.declare import Declared
from jousto.base.errors import Problems, warn
from jousto.base.fields import Label, field
from jousto.base.numbers import Number, OptionalNumber, Positive


class Material(Declared, section="materials", tag="isotropic", by_value=True):
    """Linear elastic, isotropic material.

    Raises
    ------
    InputError
        With all values that are not finite or outside of their physical range.

    Warns
    -----
    JoustoWarning
        If E or rho is probably in another unit (MPa, GPa, kPa, t/mm^3, g/cm^3).

    Examples
    --------
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> round(steel.G / 1e9, 2)
    80.77
    """

    kind = "material"
    E: Positive = field("Young's modulus", unit="Pa", label="Young's modulus E")
    nu: Number = field(
        "Poisson's ratio, above -1 and at most 0.5",
        above=-1,
        most=0.5,
        label="Poisson's ratio nu",
        wanted="in (-1, 0.5]",
    )
    rho: Number = field(
        "Density; zero for a massless member",
        unit="kg/m^3",
        least=0,
        label="density rho",
        wanted="zero or positive",
    )
    name: Label = field("Name, for messages", default="")
    source: Label = field(
        "Source of the values; given for the materials of :func:`material`",
        default="",
        compare=False,
        file=False,
    )
    alpha: OptionalNumber = field(
        "Coefficient of thermal expansion, for the temperature of strain gauges",
        unit="1/K",
        default=None,
        compare=False,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report unphysical values; warn about values that are probably in another unit."""
        if self.alpha is not None and not abs(self.alpha) < 0.01:
            problems.add(
                where,
                f"alpha is {self.alpha:g} 1/K; was it meant in 1e-6/K? Give it as 12e-6",
                "alpha",
            )
        if problems.found:
            return

        # allowed values that are probably in another unit
        hints: dict[str, str] = {}
        if self.E < 1e9:
            unit = _likely_unit(self.E)
            hints["E"] = f"E = {self.E:g} Pa is softer than most plastics; was it given in {unit}?"
        elif self.E > 2e12:
            hints["E"] = f"E = {self.E:g} Pa is stiffer than diamond; SI needs Pa"
        if self.rho > 5e4:
            hints["rho"] = f"rho = {self.rho:g} kg/m^3 is denser than any metal; SI needs kg/m^3"
        elif 0.0 < self.rho < 1.0:
            hints["rho"] = f"rho = {self.rho:g} kg/m^3 is lighter than air; was it given in t/mm^3?"
        elif 0.0 < self.rho < 25.0 and self.E > 1e9:
            hints["rho"] = (
                f"rho = {self.rho:g} kg/m^3 is lighter than any foam; was it given in g/cm^3?"
            )
        for key, hint in hints.items():
            warn(where, hint, key)

    @property
    def G(self) -> float:
        """Shear modulus E / (2 (1 + nu)) in Pa."""
        return self.E / (2.0 * (1.0 + self.nu))


def _likely_unit(E: float) -> str:
    """Return the unit in which a modulus E would have the value of a metal or a hard plastic."""
    for factor, unit in ((1e6, "MPa"), (1e9, "GPa"), (1e3, "kPa")):
        if 1e9 <= E * factor <= 2e12:
            return unit
    return "MPa"
