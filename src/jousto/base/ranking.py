"""The order of places in a table: the largest value first, equal ones by their label."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

TIE = 1e-9
"""Values that differ by less than this share are equal: round-off of long sums stays below it."""


def ranking(
    values: ArrayLike, labels: Sequence[str] | None = None, *, then: ArrayLike | None = None
) -> NDArray[np.intp]:
    """Return the order of places by falling value; where values are equal, by label.

    Symmetric places have the same value but for round-off, which differs from processor to
    processor. Values less than `TIE` of the largest of them apart count as equal, and stand in the
    order of their labels, in which numbers count as numbers.

    Parameters
    ----------
    values : (ns,) array_like
        In any unit; what is not a number comes last.
    labels : sequence of str, optional
        Of the places; without them equal places stand in the order in which they are given.
    then : (ns,) array_like, optional
        Ranks places whose values are equal, before their labels do; also falling.

    Returns
    -------
    array (ns,)

    Examples
    --------
    >>> ranking([2.0, 3.0, 3.0 + 1e-14, 3.0], ["e1.a", "e10.a", "e9.b", "e9.a"])
    array([3, 2, 1, 0])
    """
    x = np.asarray(values, dtype=np.float64)
    x = np.where(np.isnan(x), -np.inf, x)
    second = None if then is None else np.asarray(then, dtype=np.float64)
    order = np.argsort(-x, kind="stable")
    falling = -x[order]
    ranked: list[int] = []
    first = 0
    while first < len(order):
        top = falling[first]
        # infinite values are equal to none but themselves
        most = top + TIE * abs(top) if np.isfinite(top) else top
        after = int(np.searchsorted(falling, most, side="right"))
        tied = order[first:after].tolist()
        if len(tied) > 1 and second is not None:
            names = None if labels is None else [labels[i] for i in tied]
            tied = [tied[k] for k in ranking(second[tied], names)]
        elif len(tied) > 1:
            tied.sort(key=_order(labels))
        ranked += tied
        first = after
    return np.array(ranked, dtype=np.intp)


def first(places: Sequence[int] | NDArray[np.intp], labels: Sequence[str] | None) -> int:
    """Return which of some equal places comes first: by its label, or by its index if None."""
    return int(min(places, key=_order(labels))) if len(places) > 1 else int(places[0])


def largest(values: ArrayLike, labels: Sequence[str] | None = None) -> int:
    """Return the place of the largest value; of equal ones the first as in `ranking`.

    Examples
    --------
    >>> largest([2.0, 3.0, 3.0 + 1e-14])
    1
    """
    x = np.asarray(values, dtype=np.float64)
    x = np.where(np.isnan(x), -np.inf, x)
    top = float(x.max())
    least = top - TIE * abs(top) if np.isfinite(top) else top
    return first(np.flatnonzero(x >= least), labels)


def _order(labels: Sequence[str] | None) -> Callable[[int], Any]:
    """Return the key by which equal places are sorted."""
    if labels is None:
        return int
    return lambda i: (_natural(labels[i]), i)


def _natural(label: str) -> list[tuple[int, int, str]]:
    """Return a key by which numbers within labels are compared as numbers."""
    pieces = re.findall(r"\d+|\D+", label)
    return [(0, int(p), "") if p.isdecimal() else (1, 0, p) for p in pieces]
