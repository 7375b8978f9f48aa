"""Craig-Bampton bases of increasing size and their errors against the full model."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.linalg

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.certificate.interface_loads import elastic_response
from jousto.certificate.interface_modes import Modes, modes_of
from jousto.certificate.part_checks import FullModel
from jousto.reduction.methods import CraigBampton
from jousto.reduction.modes import eigen
from jousto.reduction.modes.eigen import MissingModesError
from jousto.reduction.stages import Run

if TYPE_CHECKING:
    from jousto.parts.part import Part


SHARE = 0.95
"""Smallest part of a mode of the full part that the modes must contain."""

TRIED = (40, 20, 10, 5, 2, 1)
"""Numbers of fixed-interface modes tried without a frequency limit; small parts have few."""

ON_INTERFACE = 1e-7
"""Displacement / that of the free part below which a load acts on the fixed interfaces."""

MOST_DOFS = 600
"""Largest number of degrees of freedom of all interfaces for a proposal."""


@dataclass(frozen=True, eq=False)
class Family:
    """Craig-Bampton bases of 0, 1, 2 ... fixed-interface modes, subspaces of the largest one.

    z are coordinates of the mass-orthonormal motions ``[R X]``; `fixed` are the fixed-interface
    modes (columns, mass-normalised), `static` spans the remaining motions: the constraint modes.
    """

    full: FullModel
    modes: Modes
    omega2: Array
    fixed: Array
    static: Array
    frequencies: Array

    def motions(self, z: Array) -> Array:
        """Return displacements (ndof, m)."""
        assert self.full.rigid is not None
        return self.full.rigid.R @ z[:6] + self.modes.X @ z[6:]


def modes_below(full: FullModel, limit: float, run: Run) -> tuple[Array, Array]:
    """Return frequencies, up to a limit, and mass-normalised modes of the full free part."""
    assert full.rigid is not None and full.held is not None
    rigid, held = full.rigid, full.held
    elastic = replace(held, lift=lambda y: rigid.remove(held.lift(y)))
    where = f"part '{full.part.name}'"
    with run.stage("full model's modes") as tell:
        mu, X = eigen.spectrum(
            elastic,
            full.M,
            modes=None,
            frequency_limit=limit,
            where=where,
            report=lambda done: tell("full model's modes", done),
        )
    f = 1.0 / (2.0 * np.pi * np.sqrt(mu))
    # one more than requested, for comparison
    keep = max(int(np.searchsorted(f, limit, side="right")), 1)
    return f[:keep], (X / np.sqrt(mu))[:, :keep]


def family_of(full: FullModel, names: tuple[str, ...], limit: float | None, run: Run) -> Family:
    """Return the bases of interfaces, with fixed-interface modes up to a frequency limit in Hz.

    Without a limit, or without modes below it, the number of modes is limited by that of the part.

    Raises
    ------
    InputError
        If the part cannot be reduced, or its interfaces have too many degrees of freedom.
    """
    from jousto.reduction.reducer import reduce

    # trial reductions are not cached
    options: dict[str, Any] = {
        "solver": run.solver,
        "cache": False,
        "progress": run.report or False,
    }
    reduced = None
    if limit is not None:
        try:
            reduced = reduce(full.part, CraigBampton(names, frequency_limit=limit), **options)
        except MissingModesError:
            pass  # one fixed node and no mode below the limit: use the first few modes
    for modes in TRIED if limit is None else TRIED[-3:]:
        if reduced is not None:
            break
        try:
            reduced = reduce(full.part, CraigBampton(names, modes=modes), **options)
        except MissingModesError:
            if modes == TRIED[-1]:  # a small part has fewer modes
                raise
    assert reduced is not None
    modes_ = modes_of(full, reduced)
    if len(modes_.names) > MOST_DOFS:
        message = (
            f"its interfaces have {len(modes_.names)} degrees of freedom, each of which becomes a "
            f"mode: tie the nodes of each surface to one node (Interface) and repeat"
        )
        raise InputError(Problem(f"part '{full.part.name}'", message))
    assert full.rigid is not None
    omega2 = np.concatenate([np.zeros(6), (2.0 * np.pi * reduced.frequencies) ** 2])
    C = modes_.moved(np.concatenate([full.rigid.R, modes_.X], axis=1))
    size = np.maximum(np.sqrt(np.einsum("ij,ij->j", C, C)), np.finfo(float).tiny)
    Z = scipy.linalg.null_space(C / size, rcond=1e-10) / size[:, None]
    n = len(omega2)
    if not Z.shape[1]:
        return Family(full, modes_, omega2, np.zeros((n, 0)), np.eye(n), np.zeros(0))
    values, Y = scipy.linalg.eigh(Z.T @ (omega2[:, None] * Z), Z.T @ Z)
    fixed = Z @ Y
    # motions without coupling energy to the fixed-interface modes
    static = scipy.linalg.null_space((omega2[:, None] * fixed).T / values[:, None], rcond=1e-10)
    f = np.sqrt(np.maximum(values, 0.0)) / (2.0 * np.pi)
    return Family(full, modes_, omega2, fixed, static, f)


def spectrum(family: Family, k: int) -> tuple[Array, Array]:
    """Return free-free frequencies and modes (coordinates z) with k fixed-interface modes."""
    B = np.concatenate([family.static, family.fixed[:, :k]], axis=1)
    values, Y = scipy.linalg.eigh(B.T @ (family.omega2[:, None] * B), B.T @ B)
    # the six rigid motions come first
    return np.sqrt(np.maximum(values[6:], 0.0)) / (2.0 * np.pi), (B @ Y)[:, 6:]


def frequency_errors(family: Family, truth: tuple[Array, Array]) -> Array:
    """Return the largest relative error of the frequencies, for 0, 1, 2 ... fixed modes."""
    f, shapes = truth
    assert family.full.rigid is not None
    M_shapes = family.full.M @ shapes
    seen = np.concatenate([family.full.rigid.R.T @ M_shapes, family.modes.X.T @ M_shapes])
    worst = np.ones(family.fixed.shape[1] + 1)
    for k in range(len(worst)):
        found, z = spectrum(family, k)
        if not len(found):
            continue
        overlap = (z.T @ seen) ** 2
        error = np.abs(found[overlap.argmax(axis=0)] / f - 1.0)
        error[overlap.sum(axis=0) < SHARE] = 1.0
        worst[k] = min(float(error.max()), 1.0)
    return worst


def load_errors(
    family: Family, patterns: dict[str, Array]
) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return errors of displacement and stress of each load, for 0, 1, 2 ... fixed modes.

    With fixed interfaces ``u = K_II^-1 f``, and k modes contain ``sum phi_j phi_j^T f / omega_j^2``
    of it.
    """
    bends: dict[str, Array] = {}
    stresses: dict[str, Array] = {}
    if not patterns:
        return bends, stresses
    F = np.column_stack(list(patterns.values()))
    exact = held_response(family.full, family.modes, F)
    assert family.full.rigid is not None
    relieved = F - family.full.rigid.MR @ (family.full.rigid.R.T @ F)
    free = np.abs(elastic_response(family.full, relieved) * family.full.weights[:, None])
    phi = family.motions(family.fixed)
    omega2 = (2.0 * np.pi * family.frequencies) ** 2
    moves = np.arange(F.shape[0]) % family.full.dofs < 3
    for j, name in enumerate(patterns):
        u = exact[:, j]
        if np.abs(u).max() <= ON_INTERFACE * free[:, j].max():
            bends[name] = stresses[name] = np.zeros(phi.shape[1] + 1)
            continue
        share = phi * ((phi.T @ F[:, j]) / omega2)
        left = u[:, None] - np.concatenate(
            [np.zeros((len(u), 1)), np.cumsum(share, axis=1)], axis=1
        )
        size = np.abs(u[moves]).max()
        bends[name] = np.abs(left[moves]).max(axis=0) / max(size, np.finfo(float).tiny)
        stresses[name] = _stress_errors(family.full.part, u, left)
    return bends, stresses


def _stress_errors(part: Part, u: Array, left: Array) -> Array:
    """Return the largest error of the von Mises stress / its largest value."""
    if part.stress is None:
        return np.zeros(left.shape[1])
    exact = np.asarray(part.stress.evaluate(u))
    peak = float(_von_mises(exact).max())
    if not peak > 0.0:
        return np.zeros(left.shape[1])
    return np.asarray(_von_mises(np.asarray(part.stress.evaluate(left))).max(axis=0) / peak)


def _von_mises(s: Array) -> Array:
    a, b, c, d, e, f = np.moveaxis(s, 1, 0)
    square = 0.5 * ((a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2) + 3.0 * (d**2 + e**2 + f**2)
    return np.asarray(np.sqrt(square))


def held_response(full: FullModel, modes: Modes, F: Array) -> Array:
    """Return displacements (ndof, m) under loads with fixed interfaces.

    ``u = S (F + L lam) + R a`` with the response S of the part fixed at six degrees of freedom, the
    interface loads L and their reactions lam: ``L^T u = 0``, ``R^T (F + L lam) = 0``.
    """
    assert full.held is not None and full.held.solve is not None and full.rigid is not None
    held, R = full.held, full.rigid.R
    L = modes.loads.toarray() / modes.weights
    both = np.concatenate([L, F], axis=1)
    assert held.solve is not None
    S = held.lift(held.solve(held.lower(both)))
    nb = L.shape[1]
    LR = L.T @ R
    A = np.block([[L.T @ S[:, :nb], LR], [LR.T, np.zeros((6, 6))]])
    b = -np.concatenate([L.T @ S[:, nb:], R.T @ F])
    scale = np.ones(len(A))
    for _ in range(4):
        scale /= np.sqrt(np.maximum(np.abs(scale[:, None] * A * scale).max(axis=1), 1e-300))
    x = scale[:, None] * np.linalg.lstsq(scale[:, None] * A * scale, scale[:, None] * b)[0]
    return np.asarray(S[:, nb:] + S[:, :nb] @ x[:nb] + R @ x[nb:])
