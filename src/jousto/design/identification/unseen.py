"""Combinations of unknowns that a measurement does not show, by names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from jousto.base.arrays import Array
from jousto.base.object_repr import described
from jousto.design.identification.unknowns import Unknown

WHOLE = 2e-2
"""Distance from a whole number within which an exponent is one."""
LARGEST = 6
"""Largest number of unknowns in one combination that is looked for."""


@described
@dataclass(frozen=True)
class Unseen:
    """One combination of unknowns that the measurement does not show.

    Attributes
    ----------
    names : tuple of str
        The unknowns.
    change : tuple of float
        Their changes of u, relative to their sizes, that change nothing.
    text : str
        The sentence.
    """

    names: tuple[str, ...]
    change: tuple[float, ...]
    text: str

    def _facts(self) -> str:
        return self.text


def find_unseen(
    J: Array, unknowns: Sequence[Unknown], u: Array
) -> tuple[tuple[Unseen, ...], Array]:
    """Return the unseen combinations, and an orthonormal basis (p, k) of them.

    A direction is unseen if a change by one size of the unknowns (a factor e) changes all values
    together by less than one deviation. The basis is brought to the combinations with the fewest
    unknowns.

    Parameters
    ----------
    J : (n, p) array
        Derivatives of the weighted residuals by ``u / size``, with those of priors.
    unknowns : sequence of Unknown
    u : (p,) array
    """
    p = J.shape[1]
    # of the triangular factor, whose size does not grow with the number of samples
    _, s, V = np.linalg.svd(np.linalg.qr(J, mode="r"), full_matrices=True)
    small = np.concatenate([s, np.zeros(p - len(s))]) < 1.0
    N = V[small].T
    sparse = _sparse(N)
    found: list[Unseen] = []
    sums: list[tuple[int, int]] = []
    for vector in sparse:
        found.append(_named(vector, unknowns, u, sums))
    return tuple(found), N


def _sparse(N: Array) -> list[Array]:
    """Return a basis of a space whose vectors have as few entries as possible."""
    p, k = N.shape
    found: list[Array] = []
    for size in range(1, min(p, LARGEST) + 1):
        for support in combinations(range(p), size):
            if len(found) == k:
                return found
            rest = [i for i in range(p) if i not in support]
            # vectors of the space that vanish outside of the support
            _, s, W = np.linalg.svd(N[rest], full_matrices=True)
            small = np.concatenate([s, np.zeros(k - len(s))]) < 1e-3
            if np.count_nonzero(small) != 1:
                continue
            vector = N @ W[small][0]
            vector[rest] = 0.0
            vector /= vector[np.argmax(np.abs(vector))]
            if np.any(np.abs(vector[list(support)]) < 1e-2):
                continue
            if np.linalg.matrix_rank(np.array([*found, vector]), tol=1e-2) > len(found):
                found.append(vector)
    for vector in N.T:
        if len(found) < k and np.linalg.matrix_rank(np.array([*found, vector]), tol=1e-2) > len(
            found
        ):
            found.append(vector / vector[np.argmax(np.abs(vector))])
    return found


def _named(
    vector: Array, unknowns: Sequence[Unknown], u: Array, sums: list[tuple[int, int]]
) -> Unseen:
    """Return a combination with its sentence; pairs of which only the sum is seen are collected."""
    places = [int(i) for i in np.flatnonzero(vector)]
    names = [unknowns[i].name for i in places]
    change = tuple(float(vector[i]) for i in places)
    text = ""
    if len(places) == 1:
        text = f"{names[0]} has no influence"
    elif len(places) == 2:
        text = _pair(vector, places, names, unknowns, u, sums)
    if not text:
        text = _scaled(vector, places, unknowns, u, sums)
    if not text:
        parts = ", ".join(f"{name} by {x:+.2g}" for name, x in zip(names, change, strict=True))
        text = f"{parts} (of their sizes) change nothing together"
    return Unseen(tuple(names), change, text)


def _pair(
    vector: Array,
    places: list[int],
    names: list[str],
    unknowns: Sequence[Unknown],
    u: Array,
    sums: list[tuple[int, int]],
) -> str:
    """Return the sentence of a pair: a sum, a difference, a product or a ratio."""
    i, j = places
    a, b = names
    theta = [vector[k] * unknowns[k].size * unknowns[k].slope(u[k]) for k in places]
    alike = unknowns[i].parameter.exponents == unknowns[j].parameter.exponents
    if alike and abs(theta[0] + theta[1]) < WHOLE * abs(theta[0]):
        sums.append((i, j))
        return f"{a} may be exchanged against {b}: only {a} + {b} is seen"
    if (
        alike
        and abs(theta[0] - theta[1]) < WHOLE * abs(theta[0])
        and not (unknowns[i].log and unknowns[j].log)
    ):
        return f"{a} and {b} may grow together: only {a} - {b} is seen"
    if unknowns[i].log and unknowns[j].log:
        if abs(vector[i] + vector[j]) < WHOLE:
            return f"{a} may grow as {b} shrinks: only {a} * {b} is seen"
        if abs(vector[i] - vector[j]) < WHOLE:
            return f"{a} and {b} may be multiplied by one number together: only {a} / {b} is seen"
    return ""


def _scaled(
    vector: Array,
    places: list[int],
    unknowns: Sequence[Unknown],
    u: Array,
    sums: list[tuple[int, int]],
) -> str:
    """Return the sentence of a product of powers that may change; empty if it is none."""
    left = dict.fromkeys(places)
    terms: list[tuple[str, float]] = []
    for i, j in sums:
        inside = [k for k in (i, j) if k in left]
        if not inside:
            continue
        theta = {k: unknowns[k].theta(u[k]) for k in (i, j)}
        change = sum(vector[k] * unknowns[k].size * unknowns[k].slope(u[k]) for k in inside)
        total = theta[i] + theta[j]
        if total == 0.0:
            return ""
        terms.append((f"{unknowns[i].name} + {unknowns[j].name}", float(change / total)))
        for k in inside:
            del left[k]
    for k in left:
        if not unknowns[k].log:
            return ""
        terms.append((unknowns[k].name, float(vector[k])))
    least = min(abs(x) for _, x in terms)
    if least == 0.0:
        return ""
    powers = [(name, x / least) for name, x in terms]
    if any(abs(x - round(x)) > WHOLE * max(abs(x), 1.0) or abs(x) > 4.5 for _, x in powers):
        return ""
    if len({round(x) for _, x in powers}) == 1:
        names = [name for name, _ in powers]
        return f"{', '.join(names[:-1])} and {names[-1]} may be multiplied by one number together"
    parts = ", ".join(f"{name} by its power {round(x):d}" for name, x in powers)
    return f"a number may multiply {parts} together"
