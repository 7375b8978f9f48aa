"""settle: static equilibrium of a large mechanism by sparse matrices."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl

from jousto.base.arrays import Array
from jousto.base.errors import SimulationError
from jousto.model.model import Model
from jousto.model.scales import largest_speed
from jousto.simulation.state import State
from jousto.simulation.statics.continuation import (
    PUSHED,
    SMALL,
    NoConvergenceError,
    Point,
    at_least,
    least_step,
    least_stiffness,
    most_moved_body,
    step_factor,
)
from jousto.simulation.statics.free_bodies import UNHELD
from jousto.simulation.statics.plastic_limit import name_plastic_limit
from jousto.simulation.statics.residual import TIME, Balance

TRIES = 300  # maximum number of steps
INNER = 12  # maximum number of Newton iterations of a step
CLOSE = 1e-3  # relative step size at which Newton's iteration of a step has converged
STRIDE = 0.5  # largest increment of a body in a step, rad or sizes of the mechanism
NEAR = 1e-3  # length of a step / size of the mechanism, below which Newton's method takes over
FIRST = 0.05  # length of the first step under the largest acceleration / size of the mechanism
QUICK = 4  # number of Newton iterations up to which a step counts as quick
SOFTER, SOFT, HARDER = 0.1, 0.4, 6.0  # factors on the resistance after quick, slow, failed steps


def settle(model: Model, state: State | None) -> State:
    """Return a static equilibrium near a state, for mechanisms with thousands of coordinates.

    Implicit steps of an overdamped motion, ``r(q + x) + s D x = 0`` under the constraints, reduce
    the potential energy: each step minimises the energy plus ``s x D x / 2`` (proximal point
    method, Rockafellar 1976). The resistance s is reduced while steps converge quickly. Stiff
    directions, such as the stretch of a rope, are in equilibrium after every step. D is the metric
    of `Balance.metric`, in which slender bodies have a larger rotary inertia about their axis.

    Raises
    ------
    SimulationError
        If no equilibrium is found.
    """
    flow = _Flow(Balance(model, TIME, state, where="equilibrium", frictionless=True))
    at, s = flow.start, max(flow.fall / (FIRST * model.size), flow.least)
    why: NoConvergenceError | None = None
    limit = ""
    for _ in range(TRIES):
        try:
            at, length = flow.step(at, s)
        except NoConvergenceError as error:
            why = error
            # at the first failures: later the body may have turned round
            limit = limit or name_plastic_limit(flow.balance.engine, at.q)
            s *= HARDER
            continue
        flow.balance.count_turns(at.q, at.lam, flow.time)
        s = max(s * (SOFTER if at.iterations <= QUICK else SOFT), flow.least)
        if length < NEAR:
            try:
                found = at_least(flow.balance, at, flow.time)
            except NoConvergenceError as error:
                why = error
                continue
            return flow.balance.accept(found.q, found.lam, flow.time)[0]
    raise flow.failed(at, why, limit)


class _Flow:
    """Implicit steps of the overdamped motion of a mechanism."""

    def __init__(self, balance: Balance) -> None:
        self.balance, self.time = balance, balance.value
        q, lam = balance.engine.q, balance.engine.lam
        self.start = Point(np.array(q), np.array(lam), self.time)
        at = (self.start.q, self.start.lam, self.time)
        self.metric = balance.metric(*at)
        self.least = least_stiffness(balance.matrix(*at), self.metric)
        r = balance.residual(*at)[: len(self.metric)]
        self.fall = largest_speed(balance.model, r / self.metric)  # m/s2

    def step(self, start: Point, s: float) -> tuple[Point, float]:
        """Return x and lam of one step, ``r(q + x, lam) + s D x = 0``, and the length of x.

        Raises
        ------
        NoConvergenceError
            If Newton's iteration fails, or the step is too long or raises the energy, because the
            resistance is too small.
        """
        balance, nv = self.balance, self.balance.model.nv
        q, lam, x = start.q, start.lam, np.zeros(nv)
        held = np.zeros(balance.size)
        held[:nv] = s * self.metric
        for count in range(1, INNER + 1):
            r = self._residual(q, lam)
            r[:nv] += held[:nv] * x
            A = balance.matrix(q, lam, self.time) + sp.diags(held)
            change = -spl.splu(A.tocsc()).solve(r)
            if not step_factor(balance, change) >= 1.0:
                raise NoConvergenceError(
                    "an iteration went too far", most_moved_body(balance, change)
                )
            q, lam = balance.moved(q, change), lam + change[nv:]
            x = balance.between(start.q, q)
            length = balance.length(x)
            if balance.length(change) <= max(CLOSE * length, SMALL):
                self._check(start, lam, x, alone=count == 1)
                return Point(q, lam, self.time, count), length
        raise NoConvergenceError("an iteration did not converge", most_moved_body(balance, change))

    def _check(self, start: Point, lam: Array, x: Array, *, alone: bool) -> None:
        """Raise NoConvergenceError for steps that are too long or raise the energy."""
        if not step_factor(self.balance, x / STRIDE) >= 1.0:
            raise NoConvergenceError("a step was too long", most_moved_body(self.balance, x))
        r = self._residual(start.q, lam)[: len(x)]
        if not alone and float(r @ x) > SMALL * float(np.abs(r) @ np.abs(x)):
            raise NoConvergenceError("a step raised the energy", most_moved_body(self.balance, x))

    def failed(self, at: Point, why: NoConvergenceError | None, limit: str) -> SimulationError:
        """Return the error of a search without equilibrium, which names the plastic limit."""
        balance = self.balance
        try:
            step, free = least_step(balance, at)
        except NoConvergenceError:
            step = free = np.zeros(balance.size)
        if not limit and balance.length(free) > max(PUSHED, balance.length(step)):
            body = most_moved_body(balance, free)
            text = UNHELD.format(body)
        else:
            body = why.body if why and why.body else most_moved_body(balance, step)
            remedy = limit or (
                "; start nearer to the equilibrium (state=...), or raise the loads in steps with "
                "load_path"
            )
            text = f"{why or 'it still moves'}, body '{body}' moves most{remedy}"
        return SimulationError(
            f"no static equilibrium found in {TRIES} steps: {text}", time=self.time, body=body
        )

    def _residual(self, q: Array, lam: Array) -> Array:
        try:
            r = np.asarray(self.balance.residual(q, lam, self.time))
        except SimulationError as error:
            raise NoConvergenceError(str(error), error.body) from error
        if not np.isfinite(r).all():
            raise NoConvergenceError("forces are not finite")
        return r
