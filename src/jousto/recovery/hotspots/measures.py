"""What a criterion is worth, and convex functions that are never below it."""

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
SLACK = 1e-7  # of the closed form of principal values, see principal_bounds


@dataclass(frozen=True, eq=False)
class Measure:
    """How the search ranks by a criterion.

    Every criterion is ranked by a number that is to be large, ``rank(value)``. The convex function
    F of the stress s is never below it, and ``|F(s) - F(s')| <= |G (s - s')|``.

    Attributes
    ----------
    extreme : str
        What is sought: "largest", "smallest" or "magnitude".
    rows : (r, 6) array
        G.
    value : function of (..., 6)
        The criterion, with its sign.
    rank : function
        What is to be large, of a value.
    majorant : function of (..., r)
        F as a function of ``G s``, a rounding error of SLACK ``|G s|`` included.
    tight : bool
        Whether F is the ranked criterion itself, so that it also bounds from below.
    smooth : bool
        Whether the ranked criterion, too, changes by no more than ``|G (s - s')|``: not those with
        a sign that jumps.
    """

    extreme: str
    rows: Array
    value: Scale
    rank: Scale
    majorant: Scale
    tight: bool
    smooth: bool = True


def root(A: Array) -> Array:
    """Return G (r, 6) with ``G^T G = A`` for a positive semidefinite A, r its rank."""
    values, vectors = np.linalg.eigh(A)
    kept = values > 1e-12 * values[-1]
    return np.asarray(np.sqrt(values[kept])[:, None] * vectors[:, kept].T)


def length(g: Array) -> Array:
    """Return ``|g|`` over the last axis."""
    return np.asarray(np.sqrt(np.einsum("...i,...i->...", g, g)))


def principal_bounds(g: Array) -> tuple[Array, Array]:
    """Return numbers above the largest and below the smallest principal value.

    Of tensors given as ``[s11 s22 s33 sqrt2 s12 sqrt2 s23 sqrt2 s13]``. The closed form
    ``m + 2 sqrt(J2 / 3) cos(phi)`` with ``cos(3 phi) = (J3 / 2) (3 / J2)^1.5`` errs by some
    1e-8 where two principal values are equal, since the arc cosine has no slope there; 1e-7 of the
    length of the tensor is added for it.
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
    slack = SLACK * length(g)
    high = m + 2.0 * size * np.cos(phi) + slack
    low = m + 2.0 * size * np.cos(phi + 2.0 * np.pi / 3.0) - slack
    return high, low


def measure(criterion: Criterion, extreme: str | None = None, *, strain: bool = False) -> Measure:
    """Return how to search by a criterion.

    Parameters
    ----------
    criterion : str or Plane
        See `evaluate`.
    extreme : "largest", "smallest", "magnitude" or None
        What is sought. None takes the largest von Mises, shear and first principal stress, the
        smallest third one, and the largest magnitude of all others.
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
                f"the smallest {criterion} is of no use, it is zero wherever nothing pulls; "
                "leave extreme out",
            )
        )
    rank, row = RANKS[chosen], weights(criterion, strain)
    if row is not None:
        majorant: Scale = {"largest": _first, "smallest": _minus_first}.get(chosen, _size_of_first)
        return Measure(chosen, row[None], value, rank, majorant, True)
    if criterion in ("von-mises", "signed-von-mises"):
        # the signed one is never larger than the plain one, whichever extreme is sought
        tight = positive or chosen == "magnitude"
        return Measure(chosen, mises_rows(strain), value, rank, length, tight, tight)
    if criterion == "max-shear":
        # of strains the difference of the principal values, not half of it
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
    """Return G (6, 6) with ``|G s|`` the Frobenius norm of the tensor; Weyl 1912 bounds by it."""
    shear = 0.5**0.5 if strain else 2.0**0.5
    return np.diag([1.0, 1.0, 1.0, shear, shear, shear])


def mises_rows(strain: bool) -> Array:
    """Return G (5, 6) with ``|G s|`` the equivalent (von Mises) stress, ``G^T G = V``.

    Of strains it is ``sqrt(2/3 e:e)`` of their deviator e.
    """
    V = np.diag([1.5, 1.5, 1.5, 3.0, 3.0, 3.0])
    V[:3, :3] -= 0.5
    if strain:
        V = (4.0 / 9.0) * V @ np.diag([1.0, 1.0, 1.0, 0.25, 0.25, 0.25])
    return root(V)


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
