"""One rule for rounding: what is below the rounding of the numbers that it comes from is zero.

Two numbers agree where they differ by less than `SHARE` of the larger one. A reading is zero where
it is below `SHARE` of the largest reading beside it, or below `DIGITS` of what its quantity comes
to in the machine (`Scales`). It is a rule for what is shown: arrays and files keep all digits.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.units import parse_unit

SHARE = 1e-12
"""Of the largest of the numbers: some thousand roundings of double precision."""
DIGITS = 64.0 * float(np.finfo(np.float64).eps)
"""Of the scale of a quantity: some roundings of sums in which it cancels."""
STANDARD_GRAVITY = 9.80665  # m/s2


def difference(a: float, b: float) -> float:
    """Return a - b, zero where that is the rounding of a and b.

    Examples
    --------
    >>> difference(1.0 + 4e-16, 1.0), difference(1.5, 1.0)
    (0.0, 0.5)
    """
    return 0.0 if abs(a - b) <= SHARE * max(abs(a), abs(b)) else a - b


def without_rounding(values: ArrayLike, floor: ArrayLike = 0.0) -> Array:
    """Return the values, zero where they are the rounding of the largest or below the floor.

    Parameters
    ----------
    values : array
        Of one quantity in one unit.
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
    """What the quantities of a machine come to.

    Attributes
    ----------
    mass : float
        Of all bodies, kg.
    length : float
        Size of the machine, m.
    stress : float
        What its material bears at strains of order one, Pa; 0 where nothing is elastic.
    """

    mass: float
    length: float
    stress: float

    def floor(self, unit: str) -> float:
        """Return what readings in a unit must exceed to be more than rounding, in that unit.

        A quantity of dimension kg^a m^b s^c has the scale ``mass^a length^b time^c`` with the time
        in which a body falls the size of the machine, ``(length / g)^(1/2)``; a stress that of the
        material. Pure numbers have none, since they may be of any size: 0.

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
        """Return the three numbers, as results files keep them."""
        return np.array(astuple(self))


@cache
def dimension(unit: str) -> tuple[float, float, float] | None:
    """Return the powers of kg, m and s of a unit; None of other units and of pure numbers.

    Angles and strains have the powers 0, 0, 0.
    """
    if unit in ("", "1"):
        return None
    try:
        powers = dict(parse_unit(unit).dimensionality)
    except ValueError:
        return None
    three = [float(powers.pop(key, 0.0)) for key in ("[mass]", "[length]", "[time]")]
    return None if powers else (three[0], three[1], three[2])
