"""Derivatives of reduced parts by complex numbers, with real factorisations.

The modes X are Ritz vectors of a subspace, ``X = Y Q`` with ``Y = [R, T c]``: rigid motions R and
the basis T of the method. At the point of the derivative, Q selects columns; the derivative of Q is
that of a diagonal eigenproblem. Only the part of dT outside of the subspace is needed. It follows
for constraint modes from ``K_II dPhi = -(dK T)_I``, for vibration modes from Nelson's method (AIAA
J. 14, 1976), with all kept modes as border, so that equal frequencies among them cause no
singularity.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.complexstep import parts
from jousto.base.errors import NotAnalytic
from jousto.parts.part import Part
from jousto.reduction.methods import CraigBampton, Method, ShapeFunctions
from jousto.reduction.modes.eigen import clusters
from jousto.reduction.modes.fixed_interface_response import Inside
from jousto.reduction.modes.partition import fixed_modes
from jousto.reduction.modes.rigid import rigid_modes
from jousto.reduction.modes.ties import boundary, coordinates, interface_names
from jousto.reduction.reduced import ReducedPart
from jousto.reduction.stages import Run

SPANNED = 1e-6
"""Largest part of a mode outside of the basis / size of the mode."""


class Matrices:
    """Stiffness, mass and rigid motions of a part with their derivatives.

    Parameters
    ----------
    part : Part
        Part with complex numbers.
    """

    def __init__(self, part: Part) -> None:
        self.K, self.dK = (sp.csr_array(x) for x in parts(part.K))
        self.M, self.dM = (sp.csr_array(x) for x in parts(part.M))
        R, dR = parts(rigid_modes(part.nodes, part.dofs_per_node))
        L = np.linalg.cholesky(R.T @ (self.M @ R))
        self.R, self.dR = (scipy.linalg.solve_triangular(L, x.T, lower=True).T for x in (R, dR))


def stepped_modes(part: Part, plain: Part, kept: ReducedPart, method: Method) -> tuple[Any, Any]:
    """Return modes (ndof, n) and frequencies (n,) with their derivatives.

    Parameters
    ----------
    part, plain : Part
        The part with complex numbers, and the part with the real parts of these numbers.
    kept : ReducedPart
        The reduction of `plain`.
    method : CraigBampton or FreeFree
        Method of that reduction.

    Raises
    ------
    NotAnalytic
        If surfaces are tied, residual loads are given, or motions have no mass.
    """
    if isinstance(method, ShapeFunctions):
        raise NotAnalytic("the method is shape functions")
    if part.ties:
        raise NotAnalytic("surfaces of the part are tied to nodes")
    if method.residuals:
        raise NotAnalytic("the reduction has residual loads")
    nn = len(plain.nodes)
    blocks = [kept.modes[:nn]] if kept.rotations is None else [kept.modes[:nn], kept.rotations[:nn]]
    X = np.concatenate(blocks, axis=1).reshape(-1, kept.n)
    square = np.asarray(kept.stiffness)
    given = Matrices(part)
    if np.abs(X.T @ (given.M @ X) - np.eye(kept.n)).max() > SPANNED:
        raise NotAnalytic("some modes have no mass")
    T, dT = _basis(plain, given, method, X, square)
    # X = T c + R a; rows scaled so that rotations and translations are comparable
    both, slopes = np.concatenate([T, given.R], axis=1), np.concatenate([dT, given.dR], axis=1)
    rows = np.sqrt(np.maximum(given.K.diagonal(), 1e-12 * given.K.diagonal().max()))[:, None]
    size = np.linalg.norm(rows * both, axis=0)
    c = scipy.linalg.lstsq(rows * both / size, rows * X, cond=1e-13)[0] / size[:, None]
    if np.linalg.norm(rows * (both @ c - X)) > SPANNED * np.linalg.norm(rows * X):
        raise NotAnalytic("the modes are not those of the method's basis")
    dX = slopes @ c
    # among modes of equal frequency: the shapes that separate under the perturbation
    for one in clusters(1.0 / square):
        if one.stop - one.start > 1:
            dK, dM = _small(given, X[:, one], dX[:, one])
            turn = np.linalg.eigh(dK - square[one].mean() * dM)[1]
            X[:, one], dX[:, one] = X[:, one] @ turn, dX[:, one] @ turn
    return _ritz(given, X, dX, square)


def _small(given: Matrices, Y: Array, dY: Array) -> tuple[Array, Array]:
    """Return the derivatives of ``Y^T K Y`` and ``Y^T M Y``."""
    found = []
    for A, dA in ((given.K, given.dK), (given.M, given.dM)):
        half = Y.T @ (0.5 * (dA @ Y) + A @ dY)
        found.append(half + half.T)
    return found[0], found[1]


def _ritz(given: Matrices, X: Array, dX: Array, square: Array) -> tuple[Any, Any]:
    """Return ``Y Q`` and the frequencies, with derivatives, for ``Y = [R, X]``."""
    Y, dY = np.concatenate([given.R, X], axis=1), np.concatenate([given.dR, dX], axis=1)
    every = np.concatenate([np.zeros(6), square])
    dK, dM = _small(given, Y, dY)
    work = dK - dM * every  # column i: dK - omega_i^2 dM
    gap = every[None, :] - every[:, None]
    apart = np.abs(gap) > 1e-8 * np.maximum(every[None, :], every[:, None])
    dQ = np.where(apart, work / np.where(apart, gap, 1.0), -0.5 * dM)[:, 6:]
    slope = np.diag(work)[6:]
    frequencies = np.sqrt(square) / (2.0 * np.pi)
    return X + 1j * (dX + Y @ dQ), frequencies * (1.0 + 0.5j * slope / square)


def _basis(
    plain: Part, given: Matrices, method: Method, X: Array, square: Array
) -> tuple[Array, Array]:
    """Return a basis of the modes, and the part of its derivative outside of its span."""
    if not isinstance(method, CraigBampton):
        if method.interfaces:
            raise NotAnalytic("the reduction has attachment modes")
        whole = np.arange(len(X))
        border = np.concatenate([X, given.R], axis=1)
        return X, _nelson(given, whole, X, square, border)
    where = f"part '{plain.name}'"
    z = coordinates(plain)
    b = boundary(plain, z, interface_names(plain, method.interfaces))
    run = Run()
    inside = Inside(z, b, given.K, lambda A, *about: run.factorise(A, where, *about))
    inside.prepare()
    rows = np.asarray(z.dof[inside.rows])
    Phi, _ = inside.constraint_modes()
    C = np.zeros((len(X), len(b.held)))
    C[rows], C[z.dof[b.held], np.arange(len(b.held))] = Phi, 1.0
    found = [C]
    slopes = [_spread(rows, inside.solve(-(given.dK @ C)[rows]), C)]
    mu, N = fixed_modes(plain, given.M, inside, method, lambda stage, done: None)
    if len(mu):
        found.append(N)
        slopes.append(_nelson(given, rows, N, 1.0 / mu, N[rows]))
    if method.inertia_relief:
        load, slope = given.M @ given.R, given.dM @ given.R + given.M @ given.dR
        U = _spread(rows, inside.solve(load[rows]), load)
        found.append(U)
        slopes.append(_spread(rows, inside.solve((slope - given.dK @ U)[rows]), U))
    return np.concatenate(found, axis=1), np.concatenate(slopes, axis=1)


def _spread(rows: NDArray[Any], inside: Array, like: Array) -> Array:
    out = np.zeros(like.shape)
    out[rows] = inside
    return out


def _nelson(given: Matrices, rows: NDArray[Any], X: Array, square: Array, border: Array) -> Array:
    """Return derivatives of modes outside of the border by ``(K - w2 M) dx = -(dK - w2 dM) x``."""
    K, M = (sp.csr_array(A[rows][:, rows]) for A in (given.K, given.M))
    scale = 1.0 / np.sqrt(np.where(K.diagonal() > 0.0, K.diagonal(), 1.0))
    S = sp.diags_array(scale)
    B = scale[:, None] * (M @ border)
    B /= np.linalg.norm(B, axis=0)
    none = sp.csr_array((B.shape[1], B.shape[1]))
    dX = np.zeros(X.shape)
    for i, w2 in enumerate(square):
        A = S @ (K - w2 * M) @ S
        factor = sp.linalg.splu(sp.csc_array(sp.block_array([[A, sp.csr_array(B)], [B.T, none]])))
        load = -(given.dK @ X[:, i] - w2 * (given.dM @ X[:, i]))[rows]
        found = factor.solve(np.concatenate([scale * load, np.zeros(B.shape[1])]))
        dX[rows, i] = scale * found[: len(rows)]
    return dX
