"""Checks of the inertia and damping of a body."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array, read_only, skew
from jousto.base.errors import InputError, Problem, Problems

if TYPE_CHECKING:
    from jousto.reduction.fields.invariants import Invariants
    from jousto.reduction.reduced import ReducedPart

# singularity threshold: smallest / largest eigenvalue of the rigid mass matrix
SINGULAR = 1e-14


def check_inertia(problems: Problems, where: str, inertia: ArrayLike) -> Array | None:
    """Return the inertia tensor (3, 3), kg m2, or report one that no real body can have."""
    try:
        shape = np.shape(inertia)
    except ValueError:
        shape = ()
    tensor = problems.array(where, "inertia", inertia, (3,) if shape == (3,) else (3, 3))
    if tensor is None:
        return None
    diagonal = shape == (3,)
    J = np.diag(tensor) if diagonal else tensor
    scale = max(map(abs, tensor.ravel().tolist()))
    if not diagonal and np.abs(J - J.T).max() > 1e-9 * scale:
        i, j = np.unravel_index(int(np.argmax(np.abs(J - J.T))), (3, 3))
        problems.add(
            where,
            f"inertia is not symmetric: element ({i + 1},{j + 1}) is {J[i, j]:g}, "
            f"({j + 1},{i + 1}) is {J[j, i]:g} kg m2",
            "inertia",
        )
        return None
    if diagonal:
        J1, J2, J3 = sorted(tensor.real.tolist())
    else:
        J1, J2, J3 = np.linalg.eigvalsh((J + J.T).real / 2)
    if J1 <= 1e-14 * scale:
        hint = ""
        if J2 > 0 and J1 > -1e-14 * scale:
            hint = "; all mass on one line cannot be simulated, give it a moment about that line"
        moments = f"principal moments {J1:g}, {J2:g}, {J3:g} kg m2"
        problems.add(where, f"inertia is not positive: {moments}{hint}", "inertia")
    elif J3 > (J1 + J2) * (1 + 1e-9):
        moments = f"principal moments {J1:g}, {J2:g}, {J3:g} kg m2"
        problems.add(
            where,
            f"inertia violates the triangle inequality: {moments}, the largest must not exceed "
            f"the sum of the others, {J1 + J2:g}",
            "inertia",
        )
    return read_only(J if diagonal else (J + J.T) / 2)


def damping_diagonal(
    problems: Problems, where: str, damping: Any, reduced: ReducedPart
) -> Array | None:
    """Return the diagonal (n,) of D, 1/s, or report what is wrong with the damping."""
    from jousto.reduction.damping import modal_damping

    try:
        return read_only(modal_damping(damping, reduced.frequencies))
    except InputError as error:
        problems.found.extend(p.inside(where, "damping") for p in error.problems)
        return None


def rigid_mass(invariants: Invariants, p: Array) -> Array:
    """Return the mass matrix (6, 6) of the rigid motion after the modes are eliminated.

    ``Z = M_rr - M_rp M_pp^-1 M_pr`` at the initial modal coordinates, resolved in the body
    frame, with ``M_pp = E`` (mass-normalised modes).
    """
    I = invariants
    S = I.first_moment + I.I3 @ p
    # second moment of the deformed body, int u u^T dm, and int u phi_j^T dm
    N = I.N0 + np.einsum("k,kjab->jab", p, I.E)
    cross = np.einsum("j,jab->ab", p, I.N0)
    U = I.second_moment + cross + cross.T + np.einsum("j,k,jkab->ab", p, p, I.E)
    M_wp = np.stack([N[:, 1, 2] - N[:, 2, 1], N[:, 2, 0] - N[:, 0, 2], N[:, 0, 1] - N[:, 1, 0]])
    M_rr = np.block(
        [[I.mass * np.eye(3), -skew(S)], [skew(S), np.trace(U) * np.eye(3) - U]],
    )
    M_rp = np.vstack([I.I3, M_wp])
    return np.asarray(M_rr - M_rp @ M_rp.T)


def rigid_inertia(invariants: Invariants) -> tuple[Array, Array]:
    """Return the undeformed centre of mass (3,) in m and the inertia about it (3, 3) in kg m2."""
    c = invariants.first_moment / invariants.mass
    U = invariants.second_moment - invariants.mass * np.outer(c, c)
    return c, np.trace(U) * np.eye(3) - U


def principal_inertia(invariants: Invariants) -> tuple[Array, Array]:
    """Return the principal moments of inertia (3,), ascending, kg m2, and their axes (3, 3)."""
    moments, axes = np.linalg.eigh(rigid_inertia(invariants)[1])
    return np.maximum(moments, 0.0), axes


def check_mass(name: str, invariants: Invariants, p: Array) -> None:
    """Raise an error if the mass matrix of the rigid motion is singular."""
    Z = rigid_mass(invariants, p)
    Z, mass = Z.real, invariants.mass.real
    # scale rotations by the body's size to compare them with translations
    size = np.sqrt(max(float(np.trace(Z[3:, 3:])) / 2 / mass, np.finfo(float).tiny))
    scale = np.array([1, 1, 1, 1 / size, 1 / size, 1 / size])
    values, vectors = np.linalg.eigh(Z * np.outer(scale, scale))
    if values[0] > SINGULAR * values[-1]:
        return
    axis = vectors[3:, 0] / max(float(np.linalg.norm(vectors[3:, 0])), 1e-300)
    axis = axis * np.sign(axis[np.argmax(np.abs(axis))])
    text = ", ".join(f"{x:.3g}" for x in axis + 0.0)
    raise InputError(
        Problem(
            f"body {name!r}",
            f"the mass matrix is singular: no inertia about the body axis ({text}), because all "
            "mass lies on one line; use rotary_inertia=True in the part, or point masses beside "
            "the line",
        )
    )
