"""simulate_planar: Newmark and generalised-alpha methods with full Newton iterations."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from jousto.base.errors import InputError, Problem, Problems, SimulationError, warn
from jousto.planar.frame import PlanarFrame
from jousto.planar.methods import Convergence, Method
from jousto.planar.results import PlanarRun, PlanarState, Records, planar_rest
from jousto.planar.system import Loads, Point, System, Tangents

Array = NDArray[Any]


# axial force relative to its stability limit, above which a failure is attributed to it
NEAR = 0.95


class Outcome(NamedTuple):
    """Result of Newton's iteration.

    Attributes
    ----------
    point : Point
        Last evaluated state.
    converged : bool
    evaluations, solves : int
        Numbers of residuals and linear systems.
    history : list of float
        Norms of the residuals.
    """

    point: Point
    converged: bool
    evaluations: int
    solves: int
    history: list[float]


class Scheme(NamedTuple):
    """Coefficients of a method: derivatives c, m of velocities and accelerations by unknowns.

    Attributes
    ----------
    h, am, af, beta, gamma : float
    c, m : float or (n,) array
    """

    h: float
    c: float | Array
    m: float | Array
    am: float
    af: float
    beta: float
    gamma: float

    def with_massless(self, system: System) -> Scheme:
        """Return the scheme in which rotations without mass have rates by BDF2.

        Newton's matrix then has their derivatives ``c = 3/(2 h)`` and ``m = 0``.
        """
        if not len(system.massless):
            return self
        c, m = np.full(system.size, self.c), np.full(system.size, self.m)
        c[system.massless], m[system.massless] = 1.5 / self.h, 0.0
        return self._replace(c=c, m=m)


def scheme(method: Method, step: float | None = None) -> Scheme:
    """Return the coefficients of a method, optionally with another step."""
    am, af, beta, gamma = method.weights
    h = method.step if step is None else step
    c, m = gamma / (beta * h), (1.0 - am) / ((1.0 - af) * beta * h * h)
    return Scheme(h, c, m, am, af, beta, gamma)


def solve(A: Array, b: Array) -> Array | None:
    """Return the solution of a dense linear system; None if it is singular."""
    _, _, x, info = lapack.dgesv(A, b, overwrite_a=1)
    return x if info == 0 and np.isfinite(x).all() else None


def newton(
    system: System,
    start: tuple[Array, Array, Array],
    loads: Loads,
    rule: Scheme,
    convergence: Convergence,
    inertia_tangents: Tangents,
) -> Outcome:
    """Return the result of Newton's iteration from the predicted state of a step."""
    q, v, a = (x.copy() for x in start)
    free = system.free
    grid = free[:, None], free
    c, m = (x[free] if isinstance(x, np.ndarray) else x for x in (rule.c, rule.m))
    history: list[float] = []
    solves = 0
    while True:
        p = system.evaluate(q, v, a, loads)
        r = p.residual[free]
        size = math.sqrt(float(r @ r))
        history.append(size)
        if not math.isfinite(size):
            return Outcome(p, False, len(history), solves, history)
        good = convergence.residual is None or size <= convergence.residual
        if good and convergence.relative is not None:
            good = size <= max(convergence.relative * system.scale(p, loads), system.rounding(p))
        if good and convergence.increment is None:
            return Outcome(p, True, len(history), solves, history)
        if solves == convergence.max_iterations:
            return Outcome(p, False, len(history), solves, history)
        J = system.tangent(p, loads, rule.c, rule.m, inertia_tangents)
        dq = solve(J[grid], r)
        solves += 1
        if dq is None:
            return Outcome(p, False, len(history), solves, history)
        q[free] -= dq
        v[free] -= c * dq
        a[free] -= m * dq
        if good and convergence.increment is not None:
            if math.sqrt(float(dq @ dq)) <= convergence.increment:
                # residual of the accepted state, for the results; not counted
                p = system.evaluate(q, v, a, loads)
                return Outcome(p, True, len(history), solves, history)


def start_accelerations(
    system: System, q: Array, v: Array, loads: Loads, moved: Array | None = None
) -> Array:
    """Return the accelerations (n,) by the equations of motion at the start.

    Those of `System.massless` rotations are zero.

    Parameters
    ----------
    system : System
    q, v : (n,) array
    loads : Loads
    moved : (n,) array, optional
        Accelerations of unknowns with a prescribed motion, zero for others.

    Raises
    ------
    InputError
        If an unknown has no mass.
    """
    a = np.zeros_like(q) if moved is None else moved.copy()
    p = system.evaluate(q, v, a, loads)
    free = np.setdiff1d(system.free, system.massless)
    M = (p.slaves.B.T @ system.M @ p.slaves.B)[np.ix_(free, free)]
    bare = [system.names[i] for i, mass in zip(free, np.diag(M), strict=True) if mass <= 0.0]
    if bare:
        listed = ", ".join(bare[:6]) + (", ..." if len(bare) > 6 else "")
        text = f"no mass moves with {listed}; give sections mass and rotary, or a PlanarMass"
        raise InputError(Problem("simulate_planar", text))
    a[free] = np.linalg.solve(M, -p.residual[free])
    return a


def simulate_planar(
    frame: PlanarFrame,
    t_end: float,
    method: Method,
    *,
    convergence: Convergence | None = None,
    inertia_tangents: Tangents = True,
    start: PlanarState | None = None,
    partial: bool = False,
) -> PlanarRun:
    """Return the motion of a planar frame over time.

    Parameters
    ----------
    frame : PlanarFrame
    t_end : float
        End of the run, s.
    method : PlanarNewmark or PlanarGeneralizedAlpha
        Method; its step is shortened, never lengthened, so that equal steps end at `t_end`.
    convergence : Convergence, optional
        Criterion; the default is a residual of 1e-9 of the largest force.
    inertia_tangents : bool or "symmetric"
        Whether Newton's matrix includes the velocity-dependent tangents K_acc and C_acc of eq. 13,
        or their symmetric part. They change the number of iterations, not the result.
    start : PlanarState, optional
        Initial state; the default is unloaded and at rest. ``run.state()`` continues a run.
    partial : bool
        Whether to return the results so far if a step does not converge, instead of an error.

    Returns
    -------
    PlanarRun

    Raises
    ------
    InputError
        If the frame has unknowns without mass.
    SimulationError
        If Newton's iteration does not converge; with the instant, the element concerned and the
        remedy.

    Warns
    -----
    JoustoWarning
        If an axial force exceeds the limit of tension-shear stability of the linear law.
    """
    problems = Problems()
    problems.positive("simulate_planar", "t_end", t_end, "s")
    given: object = inertia_tangents
    if not isinstance(given, bool) and given != "symmetric":
        text = f"inertia_tangents is {given!r}, must be True, False or 'symmetric'"
        problems.add("simulate_planar", text)
    problems.raise_if_any()
    convergence = convergence or Convergence()
    system, rule = frame.system, scheme(method)
    given_start = start is not None
    start = start or planar_rest(frame)
    t0, q, v = start.time, start.q.copy(), start.v.copy()
    steps = int(math.ceil((t_end - t0) / rule.h - 1e-9))
    if steps < 1:
        text = f"t_end is {t_end:g} s, must be after the start at {t0:g} s"
        raise InputError(Problem("simulate_planar", text))
    if t_end - t0 < (steps - 1e-6) * rule.h:
        rule = scheme(method, (t_end - t0) / steps)
    rule = rule.with_massless(system)
    loads = system.at_time(t0)
    moved = _start_of_motions(system, t0, q, v, given_start)
    a = start_accelerations(system, q, v, loads, moved) if start.a is None else start.a.copy()
    rest = system.massless
    s = a.copy() if start.s is None else start.s.copy()
    # rotations without mass: s has their mean rate in the last step
    s[rest] = v[rest] if start.s is None else s[rest]
    records = Records(frame, t0, rule.h, steps)
    records.add(system.evaluate(q, v, a, loads), loads, s, 0, 0)
    failure = ""
    history: list[float] = []
    for k in range(1, steps + 1):
        t = t0 + k * rule.h
        loads = system.at_time(t)
        # predictor with zero acceleration at the end
        rest_s = (rule.af * a - rule.am * s) / (1.0 - rule.am)
        mean = (0.5 - rule.beta) * s + rule.beta * rest_s
        q1 = q + rule.h * v + rule.h**2 * mean
        v1 = v + rule.h * ((1.0 - rule.gamma) * s + rule.gamma * rest_s)
        q1[records.held], v1[records.held] = q[records.held], 0.0
        a1 = np.zeros_like(a)
        q1[rest], v1[rest] = q[rest] + rule.h * s[rest], s[rest]
        for i, motion in system.moved:
            q1[i], v1[i], a1[i] = motion(t)
        out = newton(system, (q1, v1, a1), loads, rule, convergence, inertia_tangents)
        history = out.history
        if not out.converged:
            failure = _explain(frame, out, t, records, convergence)
            break
        turned = (out.point.q - q)[rest] / rule.h
        q, v = out.point.q, out.point.v
        s = ((1.0 - rule.af) * out.point.a + rule.af * a - rule.am * s) / (1.0 - rule.am)
        a = out.point.a
        s[rest] = turned
        records.add(out.point, loads, s, out.evaluations, out.solves)
    run = records.run(failure, tuple(history))
    unstable = run.unstable
    if failure and not partial:
        raise SimulationError(
            failure, time=float(run.time[-1]), body=unstable[1] if unstable else ""
        )
    if unstable:
        time, where, ratio = unstable
        warn(where, f"at t = {time:g} s {_instability(ratio)}")
    return run


def _start_of_motions(system: System, t0: float, q: Array, v: Array, given: bool) -> Array:
    """Set the unknowns with prescribed motions in q and v, and return their accelerations (n,).

    Raises
    ------
    InputError
        If a given start contradicts a motion.
    """
    problems = Problems()
    a = np.zeros_like(q)
    for i, motion in system.moved:
        found = motion(t0)
        apart = max(abs(q[i] - found[0]), abs(v[i] - found[1]))
        if given and not apart <= 1e-9 * (1.0 + max(map(abs, found[:2]))):
            text = f"{system.names[i]} starts at {q[i]:g} with the rate {v[i]:g}, and its motion "
            text += f"at {found[0]:g} with {found[1]:g} at t = {t0:g} s; give a start that agrees"
            problems.add("simulate_planar", text)
        q[i], v[i], a[i] = found
    problems.raise_if_any()
    return a


def _instability(ratio: float) -> str:
    return (
        f"its axial force is {ratio:.3g} times the limit GA / (1 - GA/EA), beyond which the linear "
        "law is unstable: sections rotate and the beam shears without a transverse load. No "
        "material is linear at such strains; use GA = EA, a stiffer section or less load"
    )


def _explain(
    frame: PlanarFrame, out: Outcome, t: float, records: Records, convergence: Convergence
) -> str:
    """Return the cause and the remedy of a step that did not converge, as a text."""
    tail = ", ".join(f"{x:.2g}" for x in out.history[-4:])
    text = f"step to t = {t:g} s does not converge (residuals ... {tail} N)"
    # largest ratio of the converged steps, since the ratio of a failed iteration has no meaning
    if records.largest_ratio > NEAR:
        where = frame.beam_name(records.worst_element)
        return f"{text}; {where}: {_instability(records.largest_ratio)}"
    if math.isfinite(out.history[-1]):
        force = frame.system.scale(out.point, frame.system.at_time(t))
        if out.history[-1] < 100.0 * frame.system.rounding(out.point) and force < math.inf:
            return (
                f"{text}; the residual is at the round-off of forces of {force:.2g} N; give a "
                "larger Convergence(residual=) or a relative one"
            )
    turned = np.abs(out.point.q - records.q[-1] if records.q else 0.0)
    k = int(np.argmax(turned)) if np.isfinite(turned).all() else 0
    return (
        f"{text}; {frame.system.names[k]} changes most ({turned[k]:.2g} in this step); use a "
        f"smaller step than {records.step:g} s"
    )
