"""Polynomials in the coordinates of a part."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.polynomial import legendre

from jousto.base.errors import Problems
from jousto.base.fields import Choice, field
from jousto.base.numbers import OptionalWhole, Whole
from jousto.reduction.shapes.functions import Columns, Family

if TYPE_CHECKING:
    from jousto.parts.part import Part

FLAT = 1e-9
"""Smallest extent of a part along an axis / its largest extent."""

MOTIONS = ("x", "y", "z", "turn x", "turn y", "turn z")


class Polynomials(Family, tag="polynomials"):
    """All polynomials in the coordinates up to an order, in every direction of motion.

    They are products of Legendre polynomials over the extent of the part, so that high orders stay
    independent in floating point. Rotations of beam nodes have polynomials up to the same order.
    Rigid motions among them are removed, since the frame describes them.

    Raises
    ------
    InputError
        If the order is below 2 or above 20, or `along` is given without `across`.

    Examples
    --------
    >>> Polynomials(5, along="x", across=2)
    Polynomials(order=5, along='x', across=2)
    """

    whole: ClassVar[bool] = True
    order: Whole = field("Highest sum of the exponents", least=2, most=20)
    along: Choice = field(
        "Axis of a slender part; the exponents of the other coordinates are limited by `across`",
        words=("all", "x", "y", "z"),
        default="all",
    )
    across: OptionalWhole = field(
        "Highest sum of the exponents across the axis; 2 allows warping and lateral contraction"
        " of sections",
        least=0,
        default=None,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report `across` without `along`, or `along` without `across`."""
        if (self.across is None) != (self.along == "all"):
            problems.add(
                where, 'along and across must both be given, as in along="x", across=2', "along"
            )

    def columns(self, part: Part) -> Columns:
        """Return the functions at the nodes of a part."""
        extent = np.ptp(part.nodes, axis=0)
        middle = 0.5 * (part.nodes.max(axis=0) + part.nodes.min(axis=0))
        axes = [a for a in range(3) if extent[a] > FLAT * extent.max()]
        s = {a: 2.0 * (part.nodes[:, a] - middle[a]) / extent[a] for a in axes}
        most = self.order if self.across is None else self.across
        d, names, found = part.dofs_per_node, [], []
        for powers in sorted(product(range(self.order + 1), repeat=len(axes)), key=sum):
            beside = sum(k for a, k in zip(axes, powers, strict=True) if "xyz"[a] != self.along)
            if sum(powers) > self.order or beside > most:
                continue
            value = np.ones(len(part.nodes))
            for a, k in zip(axes, powers, strict=True):
                value = value * legendre.Legendre.basis(k)(s[a])
            text = " ".join(f"{'xyz'[a]}^{k}" for a, k in zip(axes, powers, strict=True) if k)
            for j in range(d):
                names.append(f"{text or '1'} in {MOTIONS[j]}")
                found.append(value[:, None] * np.eye(d)[j])
        return Columns(tuple(names), np.stack(found, axis=2))
