"""Order of sites in a table: largest value first, equal ones by label."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

TIE = 1e-9
"""Largest relative difference of equal values: above the round-off of long sums."""


def ranking(
    values: ArrayLike, labels: Sequence[str] | None = None, *, then: ArrayLike | None = None
) -> NDArray[np.intp]:
    """Return the order of sites by decreasing value; equal values by label.

    Symmetric sites have equal values except for round-off, which depends on the processor. Values
    whose difference is less than `TIE` times the largest value count as equal and are sorted by
    label, with numbers in labels compared as numbers.

    Parameters
    ----------
    values : (ns,) array_like
        Values in any unit; nan comes last.
    labels : sequence of str, optional
        Labels of the sites; without labels equal sites keep the given order.
    then : (ns,) array_like, optional
        Second value, decreasing, for sites of equal values, before their labels.

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
        # infinite values are equal to themselves only
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
    """Return the first of several equal sites by label, or by index without labels."""
    return int(min(places, key=_order(labels))) if len(places) > 1 else int(places[0])


def largest(values: ArrayLike, labels: Sequence[str] | None = None) -> int:
    """Return the index of the largest value; among equal values the first, as in `ranking`.

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
    """Return the sorting key of equal sites."""
    if labels is None:
        return int
    return lambda i: (_natural(labels[i]), i)


def _natural(label: str) -> list[tuple[int, int, str]]:
    """Return a sorting key in which numbers within labels are compared as numbers."""
    pieces = re.findall(r"\d+|\D+", label)
    return [(0, int(p), "") if p.isdecimal() else (1, 0, p) for p in pieces]
