"""Derivatives of natural frequencies and equilibria, from models with complex constants."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.complexstep import parts, plainly, real_parts
from jousto.base.errors import NotAnalytic
from jousto.model.model import Model
from jousto.model.native.native import Engine, displaced
from jousto.simulation.contacts import slides_freely
from jousto.simulation.controllers import controllers
from jousto.simulation.modes.linear import modes
from jousto.simulation.second_order import as_in, where_noticed
from jousto.simulation.state import State
from jousto.simulation.statics.equilibrium import equilibrium

SAME = 1e-6
"""Relative difference below which frequencies are equal."""
STILL = 1e-12
"""Eigenvalue over the largest one, below which a motion does not oscillate."""
RANK = 1e-10
"""Singular value over the largest one, below which a row is redundant."""


def rest(model: Model) -> State:
    """Return the static equilibrium with derivatives: ``[K, Cq^T; Cq, 0] [dq; dlam] = -[r; C]``.

    r and C are the residuals of the equations of rest and of the joints, with the complex
    constants, at the equilibrium of their real parts.
    """
    if controllers(model):
        raise NotAnalytic("the equilibrium of controllers is found by iterations")
    for force in model.forces:
        if force.law.yields and not slides_freely(force):
            name = f"{force.element} '{force.name}'"
            raise NotAnalytic(f"the rest on {name} depends on the way to it", noisy=True)
    with plainly():
        found = equilibrium(real_parts(model))
    engine = _at(model, found.q, np.zeros(model.nv), found.states)
    engine.lam[:] = found.lam
    r, c = engine.residual().imag.copy(), engine.constraints()[0].imag.copy()
    A = engine.newton_matrix(0.0, 0.0, 1.0).real
    nv = model.nv
    A[nv:, :nv] = A[:nv, nv:].T
    # least squares: no increment of motions without stiffness and of redundant rows
    step = scipy.linalg.lstsq(A, -np.concatenate([r, c]), cond=RANK)[0]
    q = displaced(model, found.q, 1j * step[:nv])
    lam: Any = found.lam + 1j * step[nv:]
    return State(q, found.v, lam, found.time, states=found.states)


def frequency(model: Model, number: int, at_rest: bool) -> float:
    """Return a natural frequency, Hz, with its derivative.

    With ``P(s) = [K - s M, Cq^T; H - s Cq, 0]``, ``s = omega^2``, H the derivative of ``Cq a`` by
    positions, and null vectors x of P and y of P^T: ``ds = y^T (dP at fixed s) x / y^T [M, 0; Cq,
    0] x``. For equal frequencies these numbers form a matrix whose eigenvalues, in ascending order,
    are the derivatives.

    Raises
    ------
    NotAnalytic
        For a motion that does not oscillate, or grows or decays.
    """
    plain = real_parts(model)
    state = rest(model) if at_rest else None
    q = np.asarray(model.q0 if state is None else state.q)
    with plainly():
        zero = np.zeros(model.nv)
        states = None if state is None else state.states
        about = State(q.real.copy(), zero, np.zeros(model.nrow), states=states)
        found = modes(plain, about)
        loaded = where_noticed(plain, about, "modes")
    model = as_in(model, loaded, about)
    if number > len(found.frequencies):
        raise NotAnalytic(f"there are only {len(found.frequencies)} modes")
    squares = -(found.eigenvalues**2)
    s = squares[number - 1]
    if abs(s) <= STILL * np.abs(squares).max() or abs(s.imag) > SAME * abs(s):
        raise NotAnalytic(f"mode {number} does not oscillate, or not steadily")
    s = s.real
    near = np.abs(squares - s) <= 2.0 * SAME * abs(s)
    place = int(near[: number - 1].sum())
    slope = _slopes(model, q, states, s, int(near.sum()))[place]
    f = float(found.frequencies[number - 1])
    made: Any = f + 1j * slope / (8.0 * np.pi**2 * f)
    return np.complex128(made)  # type: ignore[return-value]


def _slopes(
    model: Model, q: NDArray[Any], states: Array | None, s: float, count: int
) -> NDArray[np.float64]:
    """Return the derivatives (count,) of equal eigenvalues s = omega^2, ascending."""
    nv = model.nv
    engine = _at(model, q, np.zeros(nv), states)
    a = engine.accelerations()[0].copy()
    K = engine.newton_matrix(0.0, 0.0, 1.0)
    M = engine.newton_matrix(1.0, 0.0, 0.0)[:nv, :nv]
    Cq = K[:nv, nv:].T
    engine.v[:] = a
    H = engine.newton_matrix(0.0, 0.0, 1.0)[nv:, :nv]
    # scale unknowns and rows to equal size; redundant rows are left out
    scale = 1.0 / np.sqrt(np.abs(np.diag(K[:nv, :nv]).real) + abs(s) * np.diag(M).real)
    U, sizes, _ = np.linalg.svd(Cq.real * scale, full_matrices=False)
    rank = int((sizes > RANK * sizes.max(initial=0.0)).sum())
    kept = (U[:, :rank] / sizes[:rank]).T
    Cq, H = kept @ Cq * scale, kept @ H * (scale / s)
    M, K = scale[:, None] * M * scale, scale[:, None] * K[:nv, :nv] * scale
    none = np.zeros((rank, rank))
    A = np.block([[K, Cq.T], [H, none]])
    B = np.block([[M, np.zeros(Cq.T.shape)], [Cq / s, none]])
    (A0, dA), (B0, dB) = parts(A), parts(B)
    for _ in range(3):  # improves s, found with the symmetric part of K if the skew part is small
        Y, _, X = np.linalg.svd(A0 - s * B0)
        Y, X = Y[:, -count:], X[-count:].T
        weight = np.linalg.inv(Y.T @ B0 @ X)

        s += float(np.trace(weight @ (Y.T @ (A0 - s * B0) @ X))) / count
    slopes = np.linalg.eigvals(weight @ (Y.T @ (dA - s * dB) @ X))
    return np.sort(slopes.real)


def _at(model: Model, q: NDArray[Any], v: NDArray[Any], states: Array | None = None) -> Engine:
    engine = Engine(model, complex_scalars=True)
    engine.q[:], engine.v[:] = q, v
    if states is not None:  # such as which contacts are closed
        engine.states[:] = states
    return engine
