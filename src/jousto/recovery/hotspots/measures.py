"""Ranking of values of a criterion, and convex upper bounds of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.recovery.fields.criteria import Criterion, check_criterion, evaluate, weights

Scale = Callable[[Array], Array]

EXTREMES = ("largest", "smallest", "magnitude")
RANKS: dict[str, Scale] = {
    "largest": lambda x: x,
    "smallest": lambda x: -x,
    "magnitude": np.abs,
}
SLACK = 1e-7  # relative error of the closed form of principal values, see principal_bounds


@dataclass(frozen=True, eq=False)
class Measure:
    """Ranking of a criterion, with a convex upper bound.

    The search maximises ``rank(value)`` of a criterion. The convex function F of the stress s is an
    upper bound of it, and ``|F(s) - F(s')| <= |G (s - s')|``.

    Attributes
    ----------
    extreme : str
        Extreme of the search: "largest", "smallest" or "magnitude".
    rows : (r, 6) array
        Matrix G.
    value : function of (..., 6)
        The criterion, with its sign.
    rank : function
        Ranked value, to be maximised, of a value of the criterion.
    majorant : function of (..., r)
        F as a function of ``G s``, including a rounding error of SLACK ``|G s|``.
    tight : bool
        Whether F equals the ranked criterion, so that it is a lower bound too.
    smooth : bool
        Whether the ranked criterion changes by at most ``|G (s - s')|``; False for criteria whose
        sign jumps.
    """

    extreme: str
    rows: Array
    value: Scale
    rank: Scale
    majorant: Scale
    tight: bool
    smooth: bool = True


def matrix_root(A: Array) -> Array:
    """Return G (r, 6) with ``G^T G = A`` for a positive semidefinite A, r its rank."""
    values, vectors = np.linalg.eigh(A)
    kept = values > 1e-12 * values[-1]
    return np.asarray(np.sqrt(values[kept])[:, None] * vectors[:, kept].T)


def vector_norm(g: Array) -> Array:
    """Return ``|g|`` over the last axis."""
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", g, g)))


def principal_bounds(g: Array) -> tuple[Array, Array]:
    """Return an upper bound of the largest and a lower bound of the smallest principal value.

    The tensors are ``[s11 s22 s33 sqrt2 s12 sqrt2 s23 sqrt2 s13]``. The closed form
    ``m + 2 sqrt(J2 / 3) cos(phi)`` with ``cos(3 phi) = (J3 / 2) (3 / J2)^1.5`` has an error of some
    1e-8 near equal principal values, where the slope of the arc cosine is infinite; the bounds
    include 1e-7 of the norm of the tensor for it.
    """
    a, b, c, d, e, f = np.moveaxis(g, -1, 0)
    m = (a + b + c) / 3.0
    a, b, c = a - m, b - m, c - m
    d, e, f = d * 0.5**0.5, e * 0.5**0.5, f * 0.5**0.5
    J2 = 0.5 * (a * a + b * b + c * c) + d * d + e * e + f * f
    size = np.sqrt(J2 / 3.0)
    u = np.maximum(size, 1e-300)
    a, b, c, d, e, f = a / u, b / u, c / u, d / u, e / u, f / u
    J3 = a * (b * c - e * e) - d * (d * c - e * f) + f * (d * e - b * f)
    phi = np.arccos(np.clip(0.5 * J3, -1.0, 1.0)) / 3.0
    slack = SLACK * vector_norm(g)
    high = m + 2.0 * size * np.cos(phi) + slack
    low = m + 2.0 * size * np.cos(phi + 2.0 * np.pi / 3.0) - slack
    return high, low


def measure(criterion: Criterion, extreme: str | None = None, *, strain: bool = False) -> Measure:
    """Return the measure of a criterion and an extreme.

    Parameters
    ----------
    criterion : str or Plane
        See `evaluate`.
    extreme : "largest", "smallest", "magnitude" or None
        Extreme of the search. None: the largest von Mises, shear and first principal stress, the
        smallest third principal stress, and the largest magnitude of all other criteria.
    strain : bool
        Whether components are strains, with engineering shears.

    Raises
    ------
    InputError
        For an unknown criterion or extreme.
    """
    check_criterion(criterion, strain, "hot_spots")

    def value(s: Array) -> Array:
        return evaluate(s, criterion, strain)

    usual = {"principal-3": "smallest", "principal-1": "largest"}
    positive = criterion in ("von-mises", "max-shear")
    name = criterion if isinstance(criterion, str) else "plane"
    chosen = extreme or ("largest" if positive else usual.get(name, "magnitude"))
    if chosen not in EXTREMES:
        known = ", ".join(f"'{one}'" for one in EXTREMES)
        raise InputError(Problem("hot_spots", f"extreme is {extreme!r}, must be one of {known}"))
    if positive and chosen == "smallest":
        raise InputError(
            Problem(
                "hot_spots",
                f"extreme is 'smallest', but the smallest {criterion} is zero at every unloaded "
                "site; omit extreme",
            )
        )
    rank, row = RANKS[chosen], weights(criterion, strain)
    if row is not None:
        majorant: Scale = {"largest": _first, "smallest": _minus_first}.get(chosen, _size_of_first)
        return Measure(chosen, row[None], value, rank, majorant, True)
    if criterion in ("von-mises", "signed-von-mises"):
        # the signed criterion never exceeds the unsigned one, for any extreme
        tight = positive or chosen == "magnitude"
        return Measure(chosen, mises_rows(strain), value, rank, vector_norm, tight, tight)
    if criterion == "max-shear":
        # factor 2 for strains, whose shear is the full difference of the principal values
        rows = (2.0 if strain else 1.0) * tensor_rows(strain)
        return Measure(chosen, rows, value, rank, _shear, True)
    bounds = {"largest": _high, "smallest": _low, "magnitude": _spectral}
    tight = (criterion, chosen) in (
        ("principal-1", "largest"),
        ("principal-3", "smallest"),
        ("signed-principal", "magnitude"),
    )
    smooth = criterion != "signed-principal" or chosen == "magnitude"
    return Measure(chosen, tensor_rows(strain), value, rank, bounds[chosen], tight, smooth)


def tensor_rows(strain: bool) -> Array:
    """Return G (6, 6) such that ``|G s|`` is the Frobenius norm of the tensor.

    The norm bounds the change of principal values (Weyl 1912).
    """
    shear = 0.5**0.5 if strain else 2.0**0.5
    return np.diag([1.0, 1.0, 1.0, shear, shear, shear])


def mises_rows(strain: bool) -> Array:
    """Return G (5, 6) such that ``|G s|`` is the equivalent (von Mises) stress, ``G^T G = V``.

    For strains the equivalent strain is ``sqrt(2/3 e:e)`` with the deviator e.
    """
    V = np.diag([1.5, 1.5, 1.5, 3.0, 3.0, 3.0])
    V[:3, :3] -= 0.5
    if strain:
        V = (4.0 / 9.0) * V @ np.diag([1.0, 1.0, 1.0, 0.25, 0.25, 0.25])
    return matrix_root(V)


def _first(g: Array) -> Array:
    return np.asarray(g[..., 0])


def _minus_first(g: Array) -> Array:
    return np.asarray(-g[..., 0])


def _size_of_first(g: Array) -> Array:
    return np.asarray(np.abs(g[..., 0]))


def _high(g: Array) -> Array:
    return principal_bounds(g)[0]


def _low(g: Array) -> Array:
    return -principal_bounds(g)[1]


def _spectral(g: Array) -> Array:
    high, low = principal_bounds(g)
    return np.maximum(high, -low)


def _shear(g: Array) -> Array:
    high, low = principal_bounds(g)
    return 0.5 * (high - low)
