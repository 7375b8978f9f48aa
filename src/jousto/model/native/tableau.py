"""Coefficients of an integration method, as stored in the engine."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.base.object_repr import described
from jousto.model.native.header import kinds
from jousto.model.native.library import real_library


@described
@dataclass(frozen=True, eq=False)
class Tableau:
    """A row of JO_METHODS in jousto.h.

    ``k_i = f(y + h sum_j A_ij k_j) + h J sum_j Gamma_ij k_j``, the step is ``h sum_i b_i k_i``.

    Attributes
    ----------
    order, stages : int
        Order, and number of stages; 0 stages if the family of the method has no tableau.
    A, Gamma : (s, s) arrays
        Explicit and implicit coefficients; those of an explicit method are 0.
    b : (s,) array
        Weights.
    """

    order: int
    stages: int
    A: Array
    Gamma: Array
    b: Array


@functools.cache
def tableau(method: str) -> Tableau:
    """Return the coefficients of a jo_method such as "rk4"."""
    row = real_library().jo_method_tableau(kinds("jo_method")[method])
    s = int(row.stages)
    below = np.tril_indices(s, -1)
    count = len(below[0])
    size = (1 + row.implicit) * count + s + row.implicit
    values = np.array([row.coefficient[i] for i in range(size)])
    A, Gamma = np.zeros((s, s)), np.zeros((s, s))
    if s and row.implicit:
        np.fill_diagonal(Gamma, values[0])
        Gamma[below] = values[1 + count : 1 + 2 * count]
    A[below] = values[row.implicit : row.implicit + count]
    return Tableau(int(row.order), s, A, Gamma, values[len(values) - s :])
