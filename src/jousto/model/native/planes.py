"""Damage on planes at sites: the engine counts shear along lines and normal stresses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.mechanism.sensors.damage_rule import meter_rule
from jousto.model.native import library
from jousto.model.native.damage_meter import native_rule
from jousto.model.native.header import kinds

FINEST, COARSEST, POINTS = 1e-7, 1.0, 65_536
"""Strain range of the table of a strain-life curve, and number of points: their spacing of 2.5e-4
in logarithm leaves an error of 1e-7 of the life."""


@dataclass(frozen=True)
class StrainCurve:
    """Life as a function of shear strain, as a table.

    Parameters
    ----------
    cycles : callable
        Function from strains (n,) to lives (n,).
    modulus : float
        Shear modulus, Pa.
    slope : float
        Smallest exponent of damage over strain.
    """

    cycles: Callable[[Array], Array]
    modulus: float
    slope: float

    def table(self) -> tuple[Array, float, float]:
        """Return ln(1/N) (points,), ln of the first shear stress, and the step."""
        x = np.linspace(np.log(FINEST), np.log(COARSEST), POINTS)
        with np.errstate(divide="ignore"):
            damage = -np.log(np.asarray(self.cycles(np.exp(x)), dtype=np.float64))
        return np.maximum(damage, -700.0), float(x[0] + np.log(self.modulus)), float(x[1] - x[0])


class PlaneCounter:
    """Counter of the worst line of shear, or worst normal stress, of all planes at a site.

    Parameters
    ----------
    kind : str
        "normal", "findley" or "strain".
    k : float
        Sensitivity to the normal stress; in 1/Pa for "strain".
    rows : (m, 3, 6) array
        Rows of the normal stress and of the shear stress along two directions, per plane.
    turns : (l, 2) array
        Cosine and sine of the lines in each plane.
    curve : SN or StrainCurve
        Curve of the damage of a cycle.
    residue : str
        "half", "repeat" or "ignore".
    mean : optional
        Mean stress correction, for "normal".

    Raises
    ------
    InputError
        If curve or correction cannot be used.
    """

    def __init__(
        self,
        kind: str,
        k: float,
        rows: Array,
        turns: Array,
        curve: Any,
        *,
        residue: str,
        mean: Any = None,
    ) -> None:
        self._library, self._ffi = library.real_library(), library.ffi()
        self._rows = np.ascontiguousarray(rows, dtype=np.float64)
        self._turns = np.ascontiguousarray(turns, dtype=np.float64)
        r = self._ffi.new("jo_planes *")
        r.kind, r.residue, r.k = kinds("jo_plane_kind")[kind], kinds("jo_residue")[residue], k
        r.planes, r.turns = len(self._rows), 1 if kind == "normal" else len(self._turns)
        r.rows, r.turn = self._pointer(self._rows), self._pointer(self._turns)
        self._meter = self._ffi.new("jo_meter *")
        if isinstance(curve, StrainCurve):
            self._table, r.first, r.step = curve.table()
            r.table, r.points = self._pointer(self._table), len(self._table)
            r.p = curve.slope
        else:
            problems = Problems()
            rule = meter_rule(problems, "plane damage", curve, residue=residue, mean=mean)
            problems.raise_if_any()
            self._meter = native_rule(self._ffi, rule)
            r.p = min(rule.curve[2:4]) if mean is None else 0.0
        self._rule = r

    def worst(self, stress: Array) -> tuple[float, int]:
        """Return damage and plane of the worst line; other threads run meanwhile.

        Parameters
        ----------
        stress : (nt, 6) array
            ``[s11 s22 s33 s12 s23 s13]``, Pa, finite.
        """
        s = np.ascontiguousarray(stress, dtype=np.float64)
        lines = int(self._rule.planes * self._rule.turns)
        scratch = np.empty(6 * len(s) + 4 + lines)
        order = np.empty(lines, np.int64)
        damage, plane = self._ffi.new("double *"), self._ffi.new("long long *")
        self._library.jo_plane_damage(
            self._rule,
            self._meter,
            self._pointer(s),
            len(s),
            self._pointer(scratch),
            self._ffi.cast("long long *", order.ctypes.data),
            damage,
            plane,
        )
        return float(damage[0]), int(plane[0])

    def _pointer(self, array: Array) -> Any:
        return self._ffi.cast("double *", array.ctypes.data)
