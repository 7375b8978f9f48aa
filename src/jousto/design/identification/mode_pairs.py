"""Pairing of measured modes with those of a machine, by shapes and frequencies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems

APART = 0.1
"""Weight of a difference of frequencies (of their logarithms) beside that of shapes."""


@explained
def mac(a: ArrayLike, b: ArrayLike) -> Array:
    """Return the modal assurance criterion (k, l) of real shapes (k, m) and (l, m).

    ``(a_i b_j)^2 / (a_i a_i b_j b_j)``: 1 for equal shapes of any scale, 0 for orthogonal ones
    (Allemang and Brown, Proc. 1st IMAC, 1982).

    Raises
    ------
    InputError
        If the shapes are no arrays of rows of one length.

    Examples
    --------
    >>> mac(np.array([[1.0, 2.0]]), np.array([[-2.0, -4.0], [2.0, -1.0]])).round(12)
    array([[1., 0.]])
    """
    problems = Problems()
    first = problems.array("mac", "a", a, (None, None))
    second = problems.array("mac", "b", b, (None, None))
    if first is not None and second is not None and first.shape[1] != second.shape[1]:
        message = f"a and b have rows of {first.shape[1]} and {second.shape[1]} values"
        problems.add("mac", f"{message}, must be measured at the same places")
    problems.raise_if_any()
    return _mac(np.asarray(first), np.asarray(second))


def _mac(a: Array, b: Array) -> Array:
    """Return the criterion of arrays."""
    products = (a @ b.T) ** 2
    sizes = np.outer(np.sum(a**2, axis=1), np.sum(b**2, axis=1))
    return np.asarray(np.divide(products, sizes, out=np.zeros_like(products), where=sizes > 0.0))


@dataclass(frozen=True, eq=False)
class Pairing:
    """Measured modes with those of a machine.

    Attributes
    ----------
    frequencies : (k,) array
        Frequencies of the machine's modes in the order of the measured ones, Hz.
    damping : (k,) array
        Their damping ratios; empty for undamped modes.
    measured, computed : (k, m) array
        Shapes, the measured ones with their largest value 1; empty without shapes.
    clusters : tuple of tuple of int
        Measured modes that are compared together, since their frequencies are close.
    mac : (k,) array
        Assurance criterion of each pair; within a cluster of its subspace.
    """

    frequencies: Array
    damping: Array
    measured: Array
    computed: Array
    clusters: tuple[tuple[int, ...], ...]
    mac: Array

    def shape(self, i: int) -> Array:
        """Return the part of measured shape i that the machine's modes of its cluster show (m,).

        ``Q Q' phi_m`` with an orthonormal basis Q of the cluster's shapes: for a single mode the
        shape scaled to fit best.
        """
        (own,) = (cluster for cluster in self.clusters if i in cluster)
        Q = np.linalg.qr(self.computed[list(own)].T)[0]
        return np.asarray(Q @ (Q.T @ self.measured[i]))


def pair_modes(
    f: Array,
    shapes: Array | None,
    frequencies: Array,
    computed: Array | None,
    damping: Array | None,
    close: float,
) -> Pairing:
    """Return measured modes with those of a machine: the assignment of least total difference.

    The difference of two modes is ``1 - MAC + 0.1 |ln f / f_m|``, without shapes that of the
    frequencies. Modes whose frequencies differ by less than `close` form a cluster, within which
    frequencies are paired in ascending order.

    Parameters
    ----------
    f : (k,) array
        Measured frequencies, Hz.
    shapes : (k, m) array or None
        Measured shapes.
    frequencies : (n,) array
        Frequencies of the machine, Hz.
    computed : (n, m) array or None
        Its shapes at the measured places.
    damping : (n,) array or None
        Its damping ratios.
    close : float
        Relative difference of frequencies below which modes form a cluster.

    Raises
    ------
    InputError
        If the machine has fewer modes than were measured.
    """
    from scipy.optimize import linear_sum_assignment

    if len(frequencies) < len(f):
        message = f"the machine has {len(frequencies)} modes, {len(f)} were measured"
        raise InputError(Problem("modal data", message))
    cost = APART * np.abs(np.log(frequencies[None] / f[:, None]))
    if shapes is not None and computed is not None:
        cost = cost + 1.0 - _mac(shapes, computed)
    _, places = linear_sum_assignment(cost)
    clusters = _clusters(f, close)
    for own in clusters:
        # close modes may exchange their shapes: frequencies in ascending order
        inside = np.array(own)[np.argsort(f[list(own)])]
        places[inside] = places[inside][np.argsort(frequencies[places[inside]])]
    nothing = np.zeros((len(f), 0))
    if shapes is None or computed is None:
        measured, paired, likeness = nothing, nothing, np.full(len(f), np.nan)
    else:
        measured = shapes / np.abs(shapes).max(axis=1)[:, None]
        paired = computed[places]
        likeness = np.empty(len(f))
        for own in clusters:
            Q = np.linalg.qr(paired[list(own)].T)[0]
            for i in own:
                likeness[i] = np.sum((Q.T @ measured[i]) ** 2) / np.sum(measured[i] ** 2)
    zeta = np.zeros(0) if damping is None else damping[places]
    return Pairing(frequencies[places], zeta, measured, paired, clusters, likeness)


def _clusters(f: Array, close: float) -> tuple[tuple[int, ...], ...]:
    """Return the measured modes in groups of close frequencies."""
    order = np.argsort(f)
    groups: list[list[int]] = []
    for i in order:
        if groups and f[i] <= f[groups[-1][-1]] * (1.0 + close):
            groups[-1].append(int(i))
        else:
            groups.append([int(i)])
    return tuple(tuple(group) for group in groups)
