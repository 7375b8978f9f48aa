"""Systems of units of other programs, which the reader converts to SI."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array, Ints
from jousto.base.errors import InputError, Problem
from jousto.base.units import LENGTHS

POUND_FORCE = 0.45359237 * 9.80665
MASSES = {"kg": 1.0, "t": 1e3, "g": 1e-3, "slug": POUND_FORCE / 0.3048, "lb": 0.45359237}
TIMES = {"s": 1.0, "ms": 1e-3}
SYSTEMS = ("SI", "mm-t-s", "mm-kg-s", "mm-kg-ms", "in-lbf-s", "ft-lbf-s")
"""Common systems of units; any length-mass-time of known units is accepted."""


@dataclass(frozen=True)
class Units:
    """A consistent system of units.

    Parameters
    ----------
    length, mass, time : float
        Units of length, mass and time in m, kg and s; the unit of force is mass length / time^2.
    unit : str
        Name of the unit of length.

    Examples
    --------
    >>> Units.read("mm-t-s").force
    1.0
    >>> f"{Units.read('in-lbf-s').mass:.3f} kg"
    '175.127 kg'
    """

    length: float
    mass: float
    time: float
    unit: str

    @classmethod
    def read(cls, text: str) -> Units:
        """Return the system of units with a name such as ``"SI"``, ``"mm-t-s"`` or ``"in-lbf-s"``.

        With ``lbf`` in the middle, pounds are forces; the unit of mass is the mass to which one
        pound-force gives an acceleration of one unit of length per s^2.

        Raises
        ------
        InputError
            If the name is unknown.
        """
        words = ("m-kg-s" if text == "SI" else str(text)).split("-")
        if len(words) == 3 and words[0] in LENGTHS and words[2] in TIMES:
            length, time = LENGTHS[words[0]], TIMES[words[2]]
            if words[1] == "lbf":
                return cls(length, POUND_FORCE * time**2 / length, time, words[0])
            if words[1] in MASSES:
                return cls(length, MASSES[words[1]], time, words[0])
        known = ", ".join(SYSTEMS)
        raise InputError(
            Problem(
                "",
                f"units is {text!r}, must be length-mass-time such as {known}",
                path=("units",),
            )
        )

    @property
    def force(self) -> float:
        """Unit of force in N."""
        return self.mass * self.length / self.time**2

    def factors(self, components: Ints) -> tuple[Array, float, float]:
        """Return s and k of the conversion to SI: ``M = m s M s``, ``K = k s K s``.

        Parameters
        ----------
        components : (ndof,) ndarray of int
            1, 2, 3 for translations, 4, 5, 6 for rotations, 0 for modal coordinates, whose values
            are not converted.

        Returns
        -------
        s : (ndof,) ndarray
        m, k : float
        """
        s = np.where((components >= 1) & (components <= 3), 1.0 / self.length, 1.0)
        return s, self.mass * self.length**2, self.force * self.length
