"""settle: where a large mechanism rests, by sparse matrices."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl

from jousto.engine import Model
from jousto.errors import SimulationError
from jousto.simulation.balance import TIME, Balance
from jousto.simulation.continuation import NoConvergenceError, Point, at_load, bounded
from jousto.simulation.state import State

TRIES = 200
NEAR = 1e-3  # length of an increment from which Newton's method goes on alone
SOFTER, HARDER = 0.3, 4.0  # of the added stiffness, after a good and a bad increment


def settle(model: Model, state: State | None) -> State:
    """Return a static equilibrium near a state, of mechanisms with thousands of coordinates.

    Increments of ``(K + s M) x + Cq^T y = -r``, ``Cq x = -C`` lead downhill while s, an added
    stiffness in the mass metric, is large, and are Newton's as it goes to zero (pseudo-transient
    continuation, Kelley and Keyes 1998).

    Raises
    ------
    SimulationError
        If there is none.
    """
    balance = Balance(model, TIME, state, where="equilibrium")
    nv, time = model.nv, balance.value
    q, lam = np.array(balance.engine.q), np.array(balance.engine.lam)
    added, before = -1.0, np.inf
    body = ""
    for _ in range(TRIES):
        r = balance.residual(q, lam, time)
        A = balance.matrix(q, lam, time)
        M = balance.mass(q, lam, time)
        if added < 0.0:  # the first increment: a share of the size under the largest acceleration
            fall = float(np.max(np.abs(r[:nv]) / np.maximum(np.abs(M.diagonal()), 1e-300)))
            added = max(fall, 1e-300) / (0.05 * model.size)
        extra: Any = sp.block_diag([added * M, sp.csc_matrix((model.nrow, model.nrow))], "csc")
        step = -spl.splu((A + extra).tocsc()).solve(r)
        cut = bounded(balance, step)
        length = balance.length(step)
        moved = balance.moved(q, cut * step)
        try:
            after = float(np.abs(balance.residual(moved, lam + step[nv:], time)[:nv]).max())
        except SimulationError:
            after = np.inf
        moves = [float(np.linalg.norm(step[b.iv : b.iv + 6])) for b in model.bodies]
        body = model.bodies[int(np.argmax(moves))].name
        if cut < 1.0 or not after < 10.0 * before:
            added *= HARDER
            if not np.isfinite(after) or cut < 0.1:
                continue
        else:
            added *= SOFTER
        q, lam, before = moved, lam + step[nv:], max(after, 1e-300)
        if length < NEAR:
            try:
                found = at_load(balance, Point(q, lam, time), time)
            except NoConvergenceError:
                continue
            return balance.accept(found.q, found.lam, time)[0]
    raise SimulationError(
        f"no static equilibrium found in {TRIES} iterations: body '{body}' is pushed in a "
        "direction in which nothing holds it; add a joint, or take the load away that pushes it, "
        "or start nearer to the rest position",
        time=time,
        body=body,
    )
