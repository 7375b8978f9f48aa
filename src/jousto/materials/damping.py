"""Damping proportional to mass and stiffness, of beams in space and in the plane."""

from __future__ import annotations

from jousto.base.declare import Declared
from jousto.base.fields import field
from jousto.base.numbers import Number


class ProportionalDamping(Declared, by_value=True):
    """Forces ``-mass M v`` and resultants ``C (e + stiffness e')``.

    A vibration of angular frequency w has the damping ratio ``mass/(2 w) + stiffness w/2``.
    """

    mass: Number = field(
        "Forces ``-mass M v``: resists all motion through the world, rigid motion too. M is the "
        "mass matrix of the beam, whichever it is: lumped, corrected or shared",
        unit="1/s",
        least=0,
        wanted="zero or positive",
        default=0.0,
    )
    stiffness: Number = field(
        "Resultants ``s = C (e + stiffness e')``: resists straining alone",
        unit="s",
        least=0,
        wanted="zero or positive",
        default=0.0,
    )
