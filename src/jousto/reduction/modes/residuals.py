"""Residual vectors: static responses to loads minus their projection onto the modes."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problems

if TYPE_CHECKING:
    from jousto.parts.part import Part


NEW = 1e-9
"""Smallest independent part of a response, in the norm of strain energy / response."""


class Pattern:
    """Nodal loads (ndof, m) of a method, which are compared and displayed by their content.

    Parameters
    ----------
    loads : (ndof, m) array
        Read-only.
    """

    def __init__(self, loads: Array) -> None:
        self.loads = loads
        self.digest = hashlib.sha256(f"{loads.shape}".encode() + loads.tobytes()).hexdigest()[:16]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Pattern) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    def __repr__(self) -> str:
        n = self.loads.shape[1]
        return f"<{n} load{'s'[: n != 1]} {self.digest}>"


def read_residuals(where: str, given: Any, problems: Problems) -> tuple[Pattern | str, ...]:
    """Return the residuals of a method, or report what is wrong with them."""
    items = (given,) if isinstance(given, str | np.ndarray | Pattern) else given
    if not isinstance(items, list | tuple):
        problems.add(
            where,
            f"residuals is {given!r}, must be load patterns (ndof,) or names of stress sites",
            "residuals",
        )
        return ()
    found: list[Pattern | str] = []
    for item in items:
        if isinstance(item, Pattern | str):
            found.append(item)
            continue
        if not np.ndim(item):
            problems.add(
                where,
                f"residual {item!r} is neither a load pattern (ndof,) nor a stress site",
                "residual",
            )
            continue
        shape = (None,) * min(np.ndim(item), 2)
        loads = problems.array(where, "load pattern", item, shape)
        if loads is None:
            continue
        loads = np.ascontiguousarray(loads.reshape(len(loads), -1))
        empty = np.flatnonzero(~np.any(loads, axis=0))
        if len(empty):
            problems.add(where, f"load pattern {len(found) + 1} has no load in column {empty[0]}")
            continue
        loads.setflags(write=False)
        found.append(Pattern(loads))
    return tuple(found)


def residual_loads(part: Part, residuals: tuple[Pattern | str, ...]) -> Array:
    """Return the loads (ndof, m) of residuals on a part.

    The load for a stress site is the adjoint of its stress: ``s = S u`` is exact for the response u
    to every load if the basis contains the response to ``S^T``, since ``S u`` is their inner
    product in strain energy.

    Raises
    ------
    InputError
        If loads belong to another part, or the part does not have a stress site.
    """
    where, problems = f"part '{part.name}'", Problems()
    ndof = part.K.shape[0]
    columns: list[Array] = []
    sites: list[str] = []
    for item in residuals:
        if isinstance(item, str):
            sites.append(item)
        elif len(item.loads) != ndof:
            problems.add(where, f"a residual load has {len(item.loads)} rows, the part has {ndof}")
        else:
            columns.append(item.loads)
    if sites and part.stress is None:
        problems.add(
            where,
            f"residuals contain the stress site '{sites[0]}', but the part has no stress data",
            "residuals",
        )
    elif sites:
        assert part.stress is not None
        try:
            rows = part.stress.rows(sites)
            columns.append(np.asarray(rows.toarray().T, dtype=np.float64))
        except InputError as error:
            problems.found.extend(replace(p, where=where) for p in error.problems)
    problems.raise_if_any()
    return np.concatenate(columns, axis=1) if columns else np.zeros((ndof, 0))


def residual_vectors(responses: Array, loads: Array, basis: Array, K: sp.csr_array) -> Array:
    """Return the parts of static responses independent of a basis, orthonormal in strain energy.

    Parameters
    ----------
    responses : (n, m) array
        Static responses.
    loads : (n, m) array
        Loads of these responses.
    basis : (n, k) array
        Vectors of the basis, ``basis^T K basis = E``.
    K : (n, n) sparse array
        Stiffness.

    Returns
    -------
    (n, r) array
        X with ``X^T K X = E`` and ``basis^T K X = 0``, at most one column per response.
    """
    # a load on the interfaces has a response of rounding size: compare the response with the effect
    # of the load where it acts
    diagonal = K.diagonal()
    near = np.einsum("ij,i,ij->j", loads, 1.0 / np.where(diagonal > 0.0, diagonal, np.inf), loads)
    norm = np.sqrt(np.maximum(np.einsum("ij,ij->j", loads, responses), near))
    used = norm > 0.0
    rest = responses[:, used] / norm[used]
    found = np.zeros((len(responses), 0))
    K_found = found
    while rest.shape[1]:
        # twice, to remove rounding errors
        for _ in range(2):
            K_rest = np.asarray(K @ rest)
            rest = rest - basis @ (basis.T @ K_rest) - found @ (K_found.T @ rest)
        K_rest = np.asarray(K @ rest)
        size = np.sqrt(np.maximum(np.einsum("ij,ij->j", rest, K_rest), 0.0))
        k = int(np.argmax(size))
        if size[k] < NEW:
            break
        found = np.column_stack([found, rest[:, k] / size[k]])
        K_found = np.column_stack([K_found, K_rest[:, k] / size[k]])
        rest = rest[:, (size >= NEW) & (np.arange(len(size)) != k)]
    return found
