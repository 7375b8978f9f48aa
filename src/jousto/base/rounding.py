"""Common rule of rounding: values below the rounding error of their terms count as zero.

Two numbers are equal if they differ by less than `SHARE` times the larger one. A reading counts as
zero if it is below `SHARE` times the largest reading of the same group, or below `DIGITS` times the
scale of its quantity in the machine (`Scales`). The rule applies to displayed values: arrays and
files contain all digits.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.units import parse_unit

SHARE = 1e-12
"""Rounding error / largest of the numbers: some thousand roundings of double precision."""
DIGITS = 64.0 * float(np.finfo(np.float64).eps)
"""Rounding error / scale of a quantity: some roundings of sums with cancellation."""
STANDARD_GRAVITY = 9.80665  # m/s2


def difference(a: float, b: float) -> float:
    """Return a - b, or zero if the difference is within the rounding error of a and b.

    Examples
    --------
    >>> difference(1.0 + 4e-16, 1.0), difference(1.5, 1.0)
    (0.0, 0.5)
    """
    return 0.0 if abs(a - b) <= SHARE * max(abs(a), abs(b)) else a - b


def without_rounding(values: ArrayLike, floor: ArrayLike = 0.0) -> Array:
    """Return the values, with zero for rounding errors of the largest one and below the floor.

    Parameters
    ----------
    values : array
        Values of one quantity in one unit.
    floor : array or float, optional
        From `Scales.floor`.

    Examples
    --------
    >>> without_rounding([1.0, 3e-17, -0.5])
    array([ 1. ,  0. , -0.5])
    """
    x = np.array(values, dtype=np.float64)
    size = np.abs(x)
    largest = size.max(initial=0.0, where=np.isfinite(size))
    x[size <= np.maximum(SHARE * largest, floor)] = 0.0
    return x


@dataclass(frozen=True)
class Scales:
    """Scales of the quantities of a machine.

    Attributes
    ----------
    mass : float
        Mass of all bodies, kg.
    length : float
        Size of the machine, m.
    stress : float
        Stress of the material at strains of order one, Pa; 0 without elastic bodies.
    """

    mass: float
    length: float
    stress: float

    def floor(self, unit: str) -> float:
        """Return the smallest value in a unit that exceeds rounding errors, in that unit.

        A quantity of dimension kg^a m^b s^c has the scale ``mass^a length^b time^c`` with the fall
        time over the size of the machine, ``(length / g)^(1/2)``; a stress has that of the
        material. Pure numbers have no scale: 0.

        Examples
        --------
        >>> one = Scales(mass=10.0, length=1.0, stress=2e11)
        >>> f"{one.floor('m'):.1e}", f"{one.floor('Pa'):.1e}", one.floor("1")
        ('1.4e-14', '2.8e-03', 0.0)
        """
        if unit == "Pa" and self.stress > 0.0:
            return DIGITS * self.stress
        powers = dimension(unit)
        if powers is None:
            return 0.0
        time = (self.length / STANDARD_GRAVITY) ** 0.5
        of_all = zip((self.mass, self.length, time), powers, strict=True)
        return DIGITS * float(np.prod([scale**power for scale, power in of_all]))

    def array(self) -> Array:
        """Return the three numbers, as stored in results files."""
        return np.array(astuple(self))


POWERS: dict[str, tuple[float, float, float] | None] = {
    "m": (0, 1, 0),
    "m/s": (0, 1, -1),
    "m/s2": (0, 1, -2),
    "rad": None,
    "rad/s": None,
    "rad/s2": None,
    "N": (1, 1, -2),
    "N m": (1, 2, -2),
    "J": (1, 2, -2),
    "Pa": (1, -1, -2),
}
"""The `dimension` of the usual units, for which the library of units need not be loaded."""


@cache
def dimension(unit: str) -> tuple[float, float, float] | None:
    """Return the powers of kg, m and s of a unit; None for others, angles and pure numbers."""
    if unit in ("", "1"):
        return None
    return POWERS[unit] if unit in POWERS else parsed_dimension(unit)


def parsed_dimension(unit: str) -> tuple[float, float, float] | None:
    """Return the `dimension` of any unit."""
    try:
        powers = dict(parse_unit(unit).dimensionality)
    except ValueError:
        return None
    three = [float(powers.pop(key, 0.0)) for key in ("[mass]", "[length]", "[time]")]
    return None if powers else (three[0], three[1], three[2])
