"""Factorisation of a stiffness matrix by the best installed sparse Cholesky library.

A factorisation takes most of the time of a reduction, and libraries differ by a factor of ten in
time and memory. Each library factorises a symmetric positive definite matrix scaled to unit
diagonal, and solves for blocks of right-hand sides.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, suggest
from jousto.base.object_repr import described
from jousto.reduction.sparse import backends

SMALL = 6000
"""Number of unknowns up to which SuperLU is always used: fast enough, and equal everywhere."""

LOOSE = 2e-14
"""Smallest eigenvalue of the scaled matrix; below it the body has a free motion."""

BLOCK = 16
"""Number of right-hand sides per solve, since libraries copy them."""


class Solver(Protocol):
    """Solver of ``K x = f`` for a supported body."""

    def __call__(self, f: Array, /) -> Array:
        """Return x for right-hand sides f (n,) or (n, m)."""
        ...


@described
@dataclass(frozen=True)
class SolverInfo:
    """Information about one factorisation library.

    Parameters
    ----------
    name : str
        Name for `reduce(..., solver=name)`.
    library : str
        Name of the library.
    licence : str
        Licence of the library.
    installed : bool
        Whether the library is installed.
    remark : str
        Source and use of the library.
    """

    name: str
    library: str
    licence: str
    installed: bool
    remark: str

    def _facts(self) -> str:
        return "installed" if self.installed else "not installed"


# name -> (required module, function that creates it, library, licence, remark), best first
_KNOWN: dict[str, tuple[str, Callable[..., backends.Backend], str, str, str]] = {
    "pardiso": (
        "pypardiso",
        backends.Pardiso,
        "PARDISO of Intel MKL by pypardiso",
        "proprietary, free of charge",
        "pip install pypardiso (Linux and Windows, x86-64)",
    ),
    "cholmod": (
        "sksparse",
        backends.Cholmod,
        "CHOLMOD by scikit-sparse",
        "GPL (supernodal part)",
        "conda install scikit-sparse, or built with SuiteSparse and a compiler",
    ),
    "ngsolve": (
        "ngsolve",
        backends.NGSolve,
        "sparse Cholesky of NGSolve",
        "LGPL",
        "pip install ngsolve (macOS, where pypardiso is not to be had, and elsewhere)",
    ),
    "multifrontal": (
        "scipy",
        backends.Multifrontal,
        "nested dissection by node positions, dense fronts by LAPACK",
        "that of jousto",
        "always there",
    ),
    "superlu": (
        "scipy",
        backends.SuperLU,
        "SuperLU of scipy",
        "BSD",
        "always available; for small parts",
    ),
}


def solvers() -> tuple[SolverInfo, ...]:
    """Return the known factorisation libraries, best first.

    The first installed one is used for large parts; parts of up to 6000 unknowns are always
    factorised by SuperLU, which is equally fast for them.

    Examples
    --------
    >>> solvers()[-1].name, solvers()[-1].installed
    ('superlu', True)
    """
    return tuple(
        SolverInfo(name, library, licence, _installed(module), remark)
        for name, (module, _, library, licence, remark) in _KNOWN.items()
    )


def _installed(module: str) -> bool:
    return importlib.util.find_spec(module) is not None


def choose(n: int, where: str, solver: str | None = None) -> str:
    """Return the name of the library for n unknowns: the requested one, or the best installed one.

    Raises
    ------
    InputError
        If the requested library is unknown or missing.
    """
    if solver is None and n <= SMALL:
        return "superlu"
    installed = [known.name for known in solvers() if known.installed]
    if solver is not None:
        given: object = solver
        if not isinstance(given, str) or given not in _KNOWN:
            raise InputError(Problem(where, f"no solver '{given}'{suggest(given, _KNOWN)}"))
        if solver not in installed:
            _, _, library, _, remark = _KNOWN[solver]
            message = f"solver '{solver}' ({library}) is not installed: {remark}"
            raise InputError(Problem(where, f"{message}; installed: {', '.join(installed)}"))
        return solver
    return installed[0]


class Factor:
    """Factorised stiffness matrix; a call solves for right-hand sides.

    Attributes
    ----------
    name : str
        Name of the library.
    memory : int
        Bytes of the factor; 0 if the library does not report them.
    """

    def __init__(self, name: str, backend: backends.Backend, scale: Array) -> None:
        self.name = name
        self.memory = backend.memory
        self._backend = backend
        self._scale = scale

    def __call__(self, f: Array, /) -> Array:
        """Return x for right-hand sides f (n,) or (n, m)."""
        columns = f.reshape(len(f), -1)
        # column after column, as most libraries need and return them
        out = np.empty(columns.shape, order="F")
        for k in range(0, columns.shape[1], BLOCK):
            part = slice(k, min(k + BLOCK, columns.shape[1]))
            out[:, part] = self._backend.solve(self._scale[:, None] * columns[:, part])
        out *= self._scale[:, None]
        return out.reshape(f.shape)


def factorise(
    K: sp.csc_array | sp.csr_array,
    where: str,
    dof_name: Callable[[int], str],
    points: Array | None = None,
    *,
    solver: str | None = None,
    limit: float = np.inf,
) -> Solver:
    """Factorise a sparse symmetric positive definite matrix.

    Parameters
    ----------
    K : (n, n) sparse array
        Stiffness of a held body, both triangles.
    where : str
        Name for errors.
    dof_name : callable
        Name of a degree of freedom, for errors.
    points : (n, 3) array, optional
        Position of each degree of freedom, m; without positions SuperLU is used, which orders by
        the pattern of K.
    solver : str, optional
        Library, see `solvers`; None for the best installed one.
    limit : float
        Available memory, bytes.

    Raises
    ------
    InputError
        If K is not positive definite (the message contains the free degree of freedom), or the
        library is missing.
    """
    n = K.shape[0]
    name = choose(n, where, solver)
    if name == "multifrontal" and points is None:
        name = "superlu"
    if n == 0:
        return lambda f: f
    diagonal = K.diagonal()
    if diagonal.min() <= 0.0:
        raise _not_held(where, dof_name(int(np.argmin(diagonal))))
    # unit diagonal, so that translations and rotations are comparable
    scale = 1.0 / np.sqrt(diagonal)
    scaled = _scaled(K, scale)
    make = partial(_KNOWN[name][1], points=points)
    try:
        backend = make(scaled, limit=limit)
    except backends.NotPositiveDefinite:
        raise _not_held(where, dof_name(_loosest(scaled, make))) from None
    except (MemoryError, RuntimeError, ImportError, OSError) as error:
        message = (
            f"{name} could not factorise the stiffness matrix of {n} unknowns: {error}; free "
            "memory, use a coarser mesh, or ask for another solver "
            "(jo.reduction.solvers() lists them)"
        )
        raise InputError(Problem(where, message)) from error
    if _is_loose(backend, n):
        raise _not_held(where, dof_name(_loosest(scaled, make)))
    return Factor(name, backend, scale)


def _scaled(K: sp.csc_array | sp.csr_array, scale: Array) -> sp.csr_array:
    """Return ``S K S`` for a diagonal S, sharing the pattern of K."""
    # symmetric, so columns are rows
    data = K.data * scale[K.indices]
    data *= np.repeat(scale, np.diff(K.indptr))
    scaled = sp.csr_array((data, K.indices, K.indptr), shape=K.shape)
    if not scaled.has_canonical_format:
        scaled = scaled.copy()
        scaled.sum_duplicates()
    return scaled


def _is_loose(backend: backends.Backend, n: int) -> bool:
    """Return whether the matrix is singular up to rounding.

    After two inverse iterations the Rayleigh quotient is an upper bound of the smallest eigenvalue.
    """
    x = np.random.default_rng(20070607).standard_normal((n, 1))
    for _ in range(2):
        x = backend.solve(x / np.linalg.norm(x))
        # some libraries divide by a zero pivot
        if not np.all(np.isfinite(x)):
            return True
    return bool(np.linalg.norm(x) > 1.0 / LOOSE)


def _loosest(scaled: sp.csr_array, make: Callable[..., backends.Backend]) -> int:
    # a small shift makes the matrix regular; the solution is the motion without stiffness
    n = scaled.shape[0]
    shifted = sp.csr_array(scaled + sp.diags_array(np.full(n, 1e-10)))
    try:
        motion = make(shifted).solve(np.random.default_rng(20070607).standard_normal((n, 1)))
    except backends.NotPositiveDefinite as error:
        return max(error.row, 0)
    return int(np.argmax(np.abs(motion)))


def _not_held(where: str, dof: str) -> InputError:
    return InputError(
        Problem(
            where,
            f"the stiffness matrix has a free motion although the body is fixed; {dof} moves "
            f"most: check that all elements are connected, and that every node has stiffness in "
            f"all its degrees of freedom",
        )
    )
