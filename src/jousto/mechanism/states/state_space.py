"""Matrices of linear systems: transfer functions in state space, systems of other libraries."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.complexstep import floats
from jousto.base.errors import InputError, Problem

Matrices = tuple[Array, Array, Array, Array]
"""A (n x n), B (n x m), C (p x n) and D (p x m) of ``x' = A x + B u``, ``y = C x + D u``."""


def of_transfer_function(numerator: Array, denominator: Array) -> Matrices:
    """Return the matrices of a transfer function in controllable form, with balanced states.

    Balancing scales the states by powers of 2 (`scipy.linalg.matrix_balance`); the output does not
    change.

    Parameters
    ----------
    numerator, denominator : ndarray
        Coefficients of falling powers of s.

    Raises
    ------
    InputError
        If the denominator is 0, or the numerator has a higher degree.
    """
    from scipy.linalg import matrix_balance

    num, den = _trimmed(numerator), _trimmed(denominator)
    where = "transfer function"
    if not len(den):
        raise InputError(Problem(where, "has a denominator of zeros"))
    if len(num) > len(den):
        raise InputError(
            Problem(
                where,
                f"has a numerator of degree {len(num) - 1} over a denominator of degree "
                f"{len(den) - 1}, which differentiates jumps; filter it: multiply the denominator "
                "by (1 + s T) with a short time T",
            )
        )
    n = len(den) - 1
    den, num = den / den[0], np.append(np.zeros(n + 1 - len(num)), num) / den[0]
    A = np.zeros((n, n), den.dtype)
    A[:1] = -den[1:]
    A[1:, :-1] += np.eye(n - 1) if n > 1 else 0.0
    B, C = np.eye(n, 1), (num[1:] - num[0] * den[1:])[None, :]
    if n > 1:
        scale = matrix_balance(np.real(A), permute=False, separate=True)[1][0]
        A, B, C = A * scale / scale[:, None], B / scale[:, None], C * scale
    return A, B, C, num[:1, None]


def _trimmed(coefficients: Array) -> Array:
    """Return coefficients without leading zeros."""
    found = np.flatnonzero(coefficients)
    return coefficients[found[0] :] if len(found) else coefficients[:0]


def matrices_of(system: Any) -> tuple[Matrices, float]:
    """Return the matrices and the sampling period of a system of another library.

    Parameters
    ----------
    system : object
        Linear system with the attributes ``A, B, C, D`` or ``num, den``, and ``dt``, such as those
        of python-control and `scipy.signal`; the period is 0 s for continuous systems.

    Raises
    ------
    InputError
        If it is none, or has more than one input or output as a transfer function.
    """
    where = f"system {type(system).__name__}"
    period = _period(where, getattr(system, "dt", None))
    if all(hasattr(system, key) for key in "ABCD"):
        A, B, C, D = (np.atleast_2d(floats(getattr(system, key))) for key in "ABCD")
        n = len(A) if A.size else 0
        return (A.reshape(n, n), B.reshape(n, D.shape[1]), C.reshape(len(D), n), D), period
    if hasattr(system, "gain") and hasattr(system, "to_tf"):  # zeros, poles and gain of scipy
        system = system.to_tf()
    if not (hasattr(system, "num") and hasattr(system, "den")):
        text = "has neither A, B, C, D nor num, den: give a linear system, or the matrices"
        raise InputError(Problem(where, text))
    num, den = (_polynomial(where, getattr(system, key)) for key in ("num", "den"))
    return of_transfer_function(num, den), period


def _polynomial(where: str, given: Any) -> Array:
    """Return the coefficients of one input and one output."""
    made = given
    while len(made) == 1 and np.ndim(made[0]):
        made = made[0]
    if any(np.ndim(one) for one in made):
        text = "has several inputs or outputs; give it in state space"
        raise InputError(Problem(where, text))
    return np.asarray(floats(made))


def _period(where: str, dt: Any) -> float:
    """Return the sampling period, s; 0 for continuous systems."""
    if dt is True:
        text = "is sampled with an unknown period; give it dt in seconds"
        raise InputError(Problem(where, text))
    return float(dt or 0.0)
