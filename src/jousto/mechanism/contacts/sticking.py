"""Contacts whose points at rest are held by rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from jousto.base.errors import Problems
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.contacts.shapes import HalfSpace, Shape, Tip
from jousto.mechanism.joints.rolling import PointSlip

BRISTLE = "; leave out friction for the bristle, which sticks too"
"""What to do where rows cannot hold a contact."""


def check_sticking(
    problems: Problems,
    where: str,
    contact: Any,
    sides: tuple[Marker, Shape, Marker, Shape],
    tips: Sequence[Tip] | None,
) -> None:
    """Report contacts whose points rows cannot hold.

    Parameters
    ----------
    contact : Contact
        With `StickSlip`.
    sides : tuple
        Marker and shape that is touched, marker and shape of the tips.
    tips : sequence of Tip or None
        Tips that touch.
    """
    _, on, b, of = sides
    if not isinstance(on, HalfSpace) or tips is None or any(tip.moves for tip in tips):
        problems.add(
            where,
            "friction=StickSlip() holds points of a sphere, capsule or cuboid on a half-space, not "
            f"of a {of.tag} on a {on.tag}{BRISTLE}",
            "friction",
        )
    elif b.site is not None and any(any(tip.centre) for tip in tips):
        problems.add(
            where,
            f"friction=StickSlip() holds a sphere at a node of a flexible body, not the tips of a "
            f"{of.tag} beside it{BRISTLE}",
            "friction",
        )
    if contact.mu_kinetic == 0.0:
        problems.add(
            where, "friction is StickSlip(), but mu_kinetic is 0; give mu_kinetic", "mu_kinetic"
        )
    if contact.resolve == "impulse":
        problems.add(
            where,
            "friction=StickSlip() holds what touches for a time, and resolve is 'impulse'; give "
            "resolve='cut', or leave out friction",
            "friction",
        )


def tip_slips(name: str, a: Marker, b: Marker, tip: Tip) -> tuple[PointSlip, PointSlip]:
    """Return the coordinates of a tip along x and y of a, whose rates are its slip velocity.

    Parameters
    ----------
    name : str
        Name of the contact.
    a, b : Marker
        Marker of the half-space and marker of the tip.
    tip : Tip
        Sphere or point fixed to b.
    """
    if any(tip.centre):
        place = b.position_local + b.axes @ tip.centre
        b = replace(b, point=f"{b.point} tip", position_local=place)
    x, y = (PointSlip(a, b, tip.radius, axis, name=f"{name}.slip {axis}") for axis in ("x", "y"))
    return x, y
