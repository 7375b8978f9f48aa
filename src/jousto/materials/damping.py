"""Damping proportional to mass and stiffness, for exact beams in space and planar beams."""

from __future__ import annotations

from jousto.base.declare import Declared
from jousto.base.fields import field
from jousto.base.numbers import Number


class ProportionalDamping(Declared, by_value=True):
    """Proportional damping: forces ``-mass M v`` and resultants ``C (e + stiffness e')``.

    A vibration of angular frequency w has the damping ratio ``mass/(2 w) + stiffness w/2``.
    """

    mass: Number = field(
        "Coefficient of the forces ``-mass M v`` against all absolute motion, rigid motion "
        "included. M is the mass matrix of the beam: lumped, corrected or consistent",
        unit="1/s",
        least=0,
        wanted="zero or positive",
        default=0.0,
    )
    stiffness: Number = field(
        "Coefficient of the resultants ``s = C (e + stiffness e')`` against strain rates only",
        unit="s",
        least=0,
        wanted="zero or positive",
        default=0.0,
    )
