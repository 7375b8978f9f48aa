"""Initial velocities: what joints and drives ask for, with the least vibration."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import warn
from jousto.base.rotations import rotation_matrix
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.model.rank.redundancy import RANK, constraint_matrix

SAME = 1e-12  # of the velocities: round-off
FITS = 1e-9  # m/s or rad/s of a mechanism of 1 m and velocities of 1: the velocities fit
MOST = 2000  # velocities and rows that are worth dense matrices


def quiet_velocities(model: Model, engine: Engine, given: Array) -> Array | None:
    """Return velocities v (nv,) that fit the joints and drives with the least elastic rates.

    Velocities that do not fit (a machine at rest whose drives move, say) are changed by dv with
    ``Cq dv = -(Cq v + C_t)``. Of all such dv those with the least ``|dp'|`` are taken, none where
    the rigid mechanism can follow, and of these the one of least kinetic energy ``dv^T M dv``. The
    nearest velocities in the mass metric alone would be those after a blow: the modes would ring
    from the start. Mechanisms of more than `MOST` velocities or rows of constraints keep the
    nearest velocities, with a warning.

    Parameters
    ----------
    model : Model
    engine : Engine
        At the closed position; its velocities are those nearest in the mass metric.
    given : (nv,) array
        Velocities asked for.

    Returns
    -------
    array or None
        None where nothing is to be gained: no elastic rates differ, or the mechanism is too large;
        and where velocities were given, which keep their momentum: what they stretch must stretch.
    """
    if np.any(given):
        return None
    modal = modal_velocities(model)
    nearest = np.array(engine.v)
    scale = max(float(np.abs(nearest).max(initial=0.0)), float(np.abs(given).max(initial=0.0)))
    changed = float(np.abs((nearest - given)[modal]).max(initial=0.0))
    if changed <= SAME * max(scale, model.size):
        return None
    if model.nv > MOST or model.nrow > MOST:
        warn(
            "start",
            f"velocities that do not fit the joints were corrected as by a blow, so that the modes"
            f" ring from time 0: {model.nv} velocities and {model.nrow} rows are more than {MOST},"
            " for which the quiet ones are sought; let drives begin at rest (SCurve), give initial"
            " velocities that fit, or start from jo.simulation.settled(model) or, where all turns"
            " about one axis, from jo.simulation.steady_rotation(model, axis, speed)",
        )
        return None
    Cq = constraint_matrix(model, engine)
    engine.v[:] = given
    asked = -np.array(engine.constraints()[1][: len(Cq)])
    engine.v[:] = nearest
    dv = least_motion(model, engine, Cq, asked)
    if dv is None:
        return None
    v = given + dv
    engine.v[:] = v
    fits = engine.residuals()[1] <= FITS * max(1.0, model.size) * max(1.0, scale)
    engine.v[:] = nearest
    return v if fits else None


def least_motion(model: Model, engine: Engine, Cq: Array, asked: Array) -> Array | None:
    """Return dv (nv,) with ``Cq dv = asked`` as nearly as possible, elastic rates the least.

    Of all such dv those with the least ``|dp'|``, and of these the one of least ``dv^T M dv``.
    Increments of the position follow likewise. None where a body has no mass.

    Parameters
    ----------
    model : Model
    engine : Engine
        At the position of Cq.
    Cq : (rows, nv) array
        For [R' (world), w_local, p'] of every body.
    asked : (rows,) array
    """
    modal = modal_velocities(model)
    try:
        L, coupling = _masses(model, engine, modal)
    except np.linalg.LinAlgError:  # a body without mass
        return None
    # rows of length 1 in the mass metric of the rigid motions, dv = L^-T x
    weighted = scipy.linalg.solve_triangular(L, Cq[:, ~modal].T, lower=True).T
    length = np.linalg.norm(weighted, axis=1)
    length = np.where(length > 0.0, length, 1.0)
    weighted, elastic, asked = (
        weighted / length[:, None],
        Cq[:, modal] / length[:, None],
        asked / length,
    )
    # what rigid motions cannot do is left to the modes
    U, s, Vt = np.linalg.svd(weighted, full_matrices=True)
    rank = int((s > RANK).sum())
    left = U[:, rank:].T
    need = left @ asked
    dp = np.zeros(int(modal.sum()))
    if np.abs(need).max(initial=0.0) > SAME * float(np.abs(asked).max(initial=0.0)):
        dp = scipy.linalg.lstsq(left @ elastic, need, cond=RANK)[0]
    # least dv^T M dv = |L^T dv + L^-1 M_rp dp|^2 + what dp decides
    shift = scipy.linalg.solve_triangular(L, coupling @ dp, lower=True)
    wanted = asked - elastic @ dp + weighted @ shift
    x = Vt[:rank].T @ ((U[:, :rank].T @ wanted) / s[:rank])
    dv = np.zeros(model.nv)
    dv[modal] = dp
    dv[~modal] = scipy.linalg.solve_triangular(L, x - shift, lower=True, trans="T")
    return dv


def modal_velocities(model: Model) -> NDArray[np.bool_]:
    """Return which velocities (nv,) are modal."""
    modal = np.zeros(model.nv, dtype=bool)
    for body in model.bodies:
        modal[body.iv + 6 : body.iv + 6 + body.n] = True
    return modal


def _masses(model: Model, engine: Engine, modal: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Return the Cholesky factor of M_rr and M_rp, velocities [R' (world) w (local)] and p'."""
    nr, place = int((~modal).sum()), np.cumsum(~modal) - 1
    column = np.cumsum(modal) - 1
    L, coupling = np.zeros((nr, nr)), np.zeros((nr, int(modal.sum())))
    for i, body in enumerate(model.bodies):
        M = np.array(engine.mass_matrix(i))
        A = rotation_matrix(engine.q[body.iq + 3 : body.iq + 7])
        M[:3] = A @ M[:3]  # R'' of the engine's matrix is resolved in the body
        M[:, :3] = M[:, :3] @ A.T
        rows = slice(place[body.iv], place[body.iv] + 6)
        L[rows, rows] = np.linalg.cholesky(M[:6, :6])
        if body.n:
            first = column[body.iv + 6]
            coupling[rows, first : first + body.n] = M[:6, 6:]
    return L, coupling
