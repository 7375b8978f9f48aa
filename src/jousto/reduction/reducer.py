"""From a finite element part to a few modes: `reduce`."""

from __future__ import annotations

import hashlib
import importlib.metadata
from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray

from jousto.errors import InputError, Problem, Problems, warn
from jousto.parts import Part
from jousto.reduction import eigen
from jousto.reduction.invariants import (
    Invariants,
    invariants_from_matrix,
    invariants_from_points,
)
from jousto.reduction.methods import CraigBampton, FreeFree, Method
from jousto.reduction.partition import (
    craig_bampton_basis,
    whole_part_basis,
)
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.rigid import (
    check_stiffness_is_free,
    length_scale,
    mass_orthonormal_rigid_modes,
)
from jousto.reduction.stiffening import stiffening as second_order_field
from jousto.reduction.stress import StressModes

Array = NDArray[np.float64]

ORTHONORMALITY = 1e-10
"""Largest deviation of the modal mass matrix from the identity."""


def reduce(part: Part, method: Method, *, stiffening: bool = False) -> ReducedPart:
    """Reduce a part to its elastic modes, orthonormal and free of rigid-body motion.

    Craig-Bampton: ``T = [E 0; Phi_C Phi_N]``, the rigid motions R are taken out of T by the
    projection ``P = E - R (R^T M R)^-1 R^T M``, and what is left is orthonormalised (Rantalainen
    2007, eqs. 3.24-3.36, where the rigid modes are found by their frequency instead).

    Parameters
    ----------
    part : Part
        The free part.
    method : CraigBampton or FreeFree
        Which modes.
    stiffening : bool
        Whether forces along the body stiffen or soften it: for blades, shafts and arms that spin
        fast, and members near buckling. Parts made of beams only. Off by default: without it the
        body is the linear one of other programs, and costs less.

    Returns
    -------
    ReducedPart
        Modes by ascending frequency, mass-normalised, with invariants and modal stress.

    Raises
    ------
    InputError
        The stiffness matrix is not free or lets the held body move, all mass lies on a line, an
        interface is unknown or does not hold the body, there are fewer modes than asked for, or
        stiffening is asked of a part that is not made of beams.
    """
    body: object = part
    if not isinstance(body, Part):
        message = f"part is {body!r}, must be a Part such as Part.beam(...)"
        raise InputError(Problem("reduce", message))
    where = f"part '{part.name}'"
    given: object = method
    if not isinstance(given, (CraigBampton, FreeFree)):
        message = f"method is {given!r}, must be CraigBampton(...) or FreeFree(...)"
        raise InputError(Problem(where, message))
    M, K = sp.csr_array(part.M), sp.csr_array(part.K)
    check_stiffness_is_free(K, part.nodes, part.dofs_per_node, where)
    rigid = mass_orthonormal_rigid_modes(M, part.nodes, part.dofs_per_node, where)
    interfaces: tuple[str, ...] = ()
    wanted: int | None
    limit: float | None
    if isinstance(method, CraigBampton):
        interfaces = method.interfaces
        basis = craig_bampton_basis(part, M, K, method)
        wanted, limit = basis.size, None
    else:
        basis = whole_part_basis(part, K)
        wanted, limit = method.modes, method.frequency_limit
    # the basis is held at six degrees of freedom; the rigid motion that adds is taken out again
    # (P^T M P = M P, so that lower needs no projection)
    elastic = replace(basis, lift=lambda y: rigid.remove(basis.lift(y)))
    mu, X = eigen.spectrum(elastic, M, modes=wanted, frequency_limit=limit, where=where)
    mu, X = eigen.canonical(mu, X, M, part.dofs_per_node, length_scale(part.nodes))
    if isinstance(method, FreeFree):
        mu, X = eigen.select(mu, X, method.modes, method.frequency_limit, "free-free", where)
    if not len(mu):
        message = (
            "the method leaves no elastic mode: ask for more modes, or use a RigidBody with the "
            "mass and inertia of the part"
        )
        raise InputError(Problem(where, message))
    X = X / np.sqrt(mu)
    _check_orthonormal(X, M, where)
    frequencies = 1.0 / (2.0 * np.pi * np.sqrt(mu))
    reduced = _assemble(part, X, frequencies, interfaces, repr(method))
    return replace(reduced, stiffening=second_order_field(part, X)) if stiffening else reduced


def _check_orthonormal(X: Array, M: sp.csr_array, where: str) -> None:
    error = np.abs(X.T @ (M @ X) - np.eye(X.shape[1]))
    # modes that move hardly any mass: products of large numbers that cancel
    rounding = 100.0 * np.finfo(float).eps * (np.abs(X).T @ (abs(M) @ np.abs(X)))
    if not np.all(error < ORTHONORMALITY + rounding):
        message = (
            f"the modes could not be made orthonormal (error {error.max():.1e}): the matrices are "
            "too ill-conditioned; ask for fewer modes and check units and element sizes"
        )
        raise InputError(Problem(where, message))


def from_modes(part: Part, modes: ArrayLike, frequencies: ArrayLike) -> ReducedPart:
    """See `ReducedPart.from_modes`."""
    where = f"part '{part.name}'"
    problems = Problems()
    M = sp.csr_array(part.M)
    f = problems.array(where, "frequencies", frequencies, (None,))
    n = None if f is None else len(f)
    X = problems.array(where, "modes", modes, (M.shape[0], n))
    problems.raise_if_any()
    assert X is not None and f is not None
    error = np.abs(X.T @ (M @ X) - np.eye(X.shape[1]))
    if error.max(initial=0.0) > 1e-3:
        i, j = np.unravel_index(int(error.argmax()), error.shape)
        warn(
            where,
            f"the given modes are not mass-orthonormal: mode {i}^T M mode {j} is off by "
            f"{error[i, j]:.2g} (limit 1e-3); the modal mass matrix is taken as the identity. "
            "Check units and the order of degrees of freedom",
        )
    return _assemble(part, X, f, (), "given mode shapes")


def _assemble(
    part: Part, X: Array, frequencies: Array, interfaces: tuple[str, ...], method: str
) -> ReducedPart:
    nn, n = len(part.nodes), X.shape[1]
    vectors = X.reshape(nn, part.dofs_per_node, n)
    return ReducedPart(
        name=part.name,
        nodes=part.nodes,
        elements=part.elements,
        node_sets=part.node_sets,
        modes=vectors[:, :3],
        rotations=vectors[:, 3:] if part.dofs_per_node == 6 else None,
        frequencies=frequencies,
        invariants=invariants(part, X),
        stress=_stress(part, X),
        interfaces=interfaces,
        provenance=_provenance(part, method),
    )


def invariants(part: Part, X: ArrayLike) -> Invariants:
    """Return the inertia invariants of mode shapes (ndof, n) of a part.

    Mass points are used where the part has them, else bilinear forms of its mass matrix; rigid
    masses attached to a consistent mass matrix are points again.
    """
    modes = np.asarray(X, dtype=np.float64)
    if part.mass_points is not None:
        return invariants_from_points(part.mass_points, modes)
    M = sp.csr_array(part.M)
    if part.attached is None:
        return invariants_from_matrix(M, part.nodes, part.dofs_per_node, modes)
    elements = sp.csr_array(M - part.attached.matrix())
    own = invariants_from_matrix(elements, part.nodes, part.dofs_per_node, modes)
    return own + invariants_from_points(part.attached, modes)


def _stress(part: Part, X: Array) -> StressModes | None:
    if part.stress is None:
        return None
    s = part.stress
    return StressModes(tuple(s.sites), s.positions, s.axes, s.evaluate(X), s.elasticity)


def _provenance(part: Part, method: str) -> dict[str, str]:
    versions = {}
    for package in ("jousto", "numpy", "scipy"):
        try:
            versions[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            versions[package] = "unknown"
    return {"method": method, "input": content_hash(part), **versions}


def content_hash(part: Part) -> str:
    """Return a hash of what a reduction depends on: nodes, M and K."""
    digest = hashlib.sha256()
    digest.update(f"{part.dofs_per_node}".encode())
    digest.update(np.ascontiguousarray(part.nodes, dtype="<f8").tobytes())
    for matrix in (part.M, part.K):
        csr = sp.csr_array(matrix, copy=True)
        csr.sum_duplicates()
        digest.update(np.asarray(csr.indptr, dtype="<i8").tobytes())
        digest.update(np.asarray(csr.indices, dtype="<i8").tobytes())
        digest.update(np.asarray(csr.data, dtype="<f8").tobytes())
    return "sha256:" + digest.hexdigest()
