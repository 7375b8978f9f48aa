"""Laws of contact whose force without loss is no power of the depth: cylinders, tables, robots."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, Values
from jousto.base.object_repr import described
from jousto.materials.material import Material
from jousto.mechanism.contacts.laws import IMPEDANCE, LINE, TABLE, Rebounding, modulus_of


class HertzLine(Rebounding, tag="hertz-line"):
    """Parallel cylinders as a spring: ``N = pi/4 E* L d (1 + u d' / v_in)``.

    The stiffness of a line contact by its length, whatever the radii; see `JohnsonLine` for their
    influence. The law acts at each point where two shapes touch: a cylinder that lies on a plane
    touches it at two, each with half of its length.

    Examples
    --------
    >>> HertzLine(100e9, 0.02).numbers(None)["stiffness"]
    1570796326.794...
    """

    modulus: Number = field("E* of both bodies", unit="Pa", above=0)
    length: Number = field("Length L of the line at each point", unit="m", above=0)

    @classmethod
    def between(
        cls,
        material: Material,
        other: Material | None = None,
        *,
        length: float,
        restitution: float = 0.5,
    ) -> HertzLine:
        """Return the law between two materials; `other` None: the same one."""
        return cls(modulus_of(material, other), length, restitution=restitution)

    def numbers(self, curvature: float | None) -> dict[str, float]:
        """Stiffness and damping."""
        stiffness = 0.25 * pi * self.modulus * self.length
        return self.loss | {"stiffness": stiffness, "exponent": 1.0}


class JohnsonLine(Rebounding, tag="johnson-line"):
    """Parallel cylinders: ``d = F/(pi E* L) (ln(4 pi E* L dR / F) - 1)``, N as `PowerLaw` with F.

    dR is the sum of both radii, or their difference if one cylinder is in the other: a pin in its
    hole (K. L. Johnson, Contact Mechanics, 1985, section 5.6). The equation ends at the depth 0.541
    dR; from 0.527 dR on the force continues along its tangent.
    """

    curve = LINE
    modulus: Number = field("E* of both bodies", unit="Pa", above=0)
    length: Number = field("Length L of the line at each point", unit="m", above=0)
    radii: Number = field(
        "dR: sum of both radii, or their difference for a cylinder in a hole", unit="m", above=0
    )

    @classmethod
    def between(
        cls,
        material: Material,
        other: Material | None = None,
        *,
        length: float,
        radii: float,
        restitution: float = 0.5,
    ) -> JohnsonLine:
        """Return the law between two materials; `other` None: the same one."""
        return cls(modulus_of(material, other), length, radii, restitution=restitution)

    def numbers(self, curvature: float | None) -> dict[str, float]:
        """``pi E* L``, ``4 dR`` and damping."""
        stiffness = pi * self.modulus * self.length
        more = {"stiffness": stiffness, "exponent": 1.0, "curve": float(LINE)}
        return self.loss | more | {"extent": 4.0 * self.radii}


@described
class TableLaw(Rebounding, tag="table-law"):
    """Force F by a table of depths, N as `PowerLaw` with F: ``N = F(d) (1 + u d' / v_in)``.

    Between the points F is a cubic with continuous slope that rises as they do (Fritsch and
    Carlson, SIAM Journal on Numerical Analysis 17, 1980, 238-246); beyond the last one it is
    straight. The restitution is reached whatever the table.

    Examples
    --------
    >>> law = TableLaw([0, 1e-3, 2e-3], [0, 1000, 4000], restitution=0.6)
    >>> law.rows[:, 3].round(2).tolist()  # energy, J
    [0.0, 0.38, 2.67]
    """

    curve = TABLE
    depths: Values = field("Depths, ascending from 0", unit="m", shape=(None,))
    forces: Values = field("Forces at these depths, ascending from 0", unit="N", shape=(None,))

    def consistent(self, problems: Problems, where: str) -> None:
        """Report tables that do not start at 0 or do not rise."""
        d, F = np.asarray(self.depths), np.asarray(self.forces)
        if len(d) != len(F) or len(d) < 2:
            problems.add(
                where,
                f"{len(d)} depths and {len(F)} forces; a table needs as many of both, 2 at least",
                "forces",
            )
            return
        for name, values in (("depths", d), ("forces", F)):
            if values[0] != 0.0:
                problems.add(where, f"{name} start at {values[0]:g}, must start at 0", name)
            if len(falls := np.flatnonzero(np.diff(values) <= 0.0)):
                i = int(falls[0])
                problems.add(
                    where,
                    f"{name} must rise: {values[i]:g} is followed by {values[i + 1]:g}",
                    name,
                )

    @property
    def rows(self) -> Array:
        """Depth, force, slope and energy at each point (n, 4) in SI units."""
        from scipy.interpolate import PchipInterpolator

        d, F = np.asarray(self.depths), np.asarray(self.forces)
        slope = PchipInterpolator(d, F).derivative()(d)
        slope[-1] = max(slope[-1], (F[-1] - F[-2]) / (d[-1] - d[-2]))
        h = np.diff(d)
        parts = 0.5 * h * (F[:-1] + F[1:]) + h * h * (slope[:-1] - slope[1:]) / 12.0
        return np.stack([d, F, slope, np.concatenate([[0.0], np.cumsum(parts)])], axis=1)

    def numbers(self, curvature: float | None) -> dict[str, float]:
        """Mean stiffness of the table, number of its rows, and damping."""
        stiffness = float(self.forces[-1] / self.depths[-1])
        more = {"stiffness": stiffness, "exponent": 1.0, "curve": float(TABLE)}
        return self.loss | more | {"extent": float(len(self.depths))}


class Impedance(Rebounding, tag="impedance"):
    """The soft contact of MuJoCo: ``F = K d a^2 / (1 - a)`` with its impedance a, N as `PowerLaw`.

    a rises from ``low`` at the depth 0 to ``high`` at the depth ``width``: ``a = low + (high - low)
    y(d / width)`` with ``y = x^p / m^(p-1)`` up to the middle m, then ``1 - (1-x)^p / (1-m)^(p-1)``
    (MuJoCo documentation, Solver parameters). With ``K = m / (high tc dr)^2`` bodies rest at the
    depths of MuJoCo, m being the mass in play, tc and dr ``solref``.

    Examples
    --------
    >>> law = Impedance(2770.0, 0.9, 0.95, 1e-3)
    >>> law.low, law.middle, law.power
    (0.9, 0.5, 2.0)
    """

    curve = IMPEDANCE
    stiffness: Number = field("K", unit="N/m", above=0)
    low: Number = field("Impedance a at the depth 0", unit="1", above=0, below=1)
    high: Number = field("Impedance a from the depth `width` on", unit="1", above=0, below=1)
    width: Number = field("Depth at which a is `high`", unit="m", above=0)
    middle: Number = field(
        "m, share of the width at which a bends", unit="1", above=0, below=1, default=0.5
    )
    power: Number = field("p, how sharply a bends", unit="1", least=1, default=2.0)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report an impedance that falls with the depth."""
        if self.low > self.high:
            problems.add(where, f"low {self.low:g} is above high {self.high:g}", "low")

    def numbers(self, curvature: float | None) -> dict[str, Any]:
        """Stiffness, the five numbers of the impedance, and damping."""
        impedance = (self.low, self.high, self.width, self.middle, self.power)
        more = {"stiffness": self.stiffness, "exponent": 1.0, "curve": float(IMPEDANCE)}
        return self.loss | more | {"impedance": impedance}
