"""Equilibria of planar frames: load steps, arc length, and natural frequencies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jousto.base.errors import InputError, Problem, Problems, SimulationError
from jousto.planar.dynamics import solve
from jousto.planar.frame import PlanarFrame
from jousto.planar.methods import Convergence
from jousto.planar.results import PlanarPath, PlanarState
from jousto.planar.system import Point, System

Array = NDArray[Any]
SHORTEST = 1e-3  # shortest load step after halving, relative to the given step


class _Equilibrium(NamedTuple):
    factor: float
    point: Point
    history: tuple[float, ...]
    solves: int = 0


def load_steps(
    frame: PlanarFrame,
    factors: Sequence[float] | NDArray[np.float64] = (1.0,),
    *,
    convergence: Convergence | None = None,
    start: PlanarState | None = None,
) -> PlanarPath:
    """Return the equilibria under loads and gravity times load factors, by Newton's method.

    Parameters
    ----------
    frame : PlanarFrame
        Frame; signals of its loads have no effect.
    factors : sequence of float
        Load factors of the equilibria; a step that fails is halved.
    convergence : Convergence, optional
        Criterion; the default is a residual of 1e-9 of the largest force.
    start : PlanarState, optional
        Starting point; the default is the unloaded frame.

    Returns
    -------
    PlanarPath

    Raises
    ------
    InputError
        If there are no factors, or the frame can move without force; with the moving unknown.
    SimulationError
        If a step does not converge; with its factor. ``arc_length`` passes limit points.
    """
    problems = Problems()
    values = problems.array("load_steps", "factors", factors, (None,))
    if values is not None and not len(values):
        problems.add("load_steps", "factors is empty; give one load factor at least, as [1.0]")
    problems.raise_if_any()
    assert values is not None
    convergence = convergence or Convergence()
    system = frame.system
    _refuse_motions(system)
    q = np.zeros(system.size) if start is None else start.q.copy()
    if start is None:
        _check_supports(system)
    found = []
    last = 0.0
    known = start is None  # whether the load factor of the start is known
    for factor in values:
        out = _reach(system, q, (last if known else float(factor), float(factor)), convergence)
        if not out.history or not _good(system, out, convergence):
            tail = ", ".join(f"{x:.2g}" for x in out.history[-3:])
            text = (
                f"load_steps: factor {factor:g} after {last:g} does not converge, nor do steps "
                f"from {out.factor:g} on (residuals ... {tail} N); use arc_length if there is a "
                "limit point"
            )
            raise SimulationError(text, time=float(factor))
        known = True
        q, last = out.point.q.copy(), float(factor)
        found.append(out)
    return _path(frame, found)


def arc_length(
    frame: PlanarFrame,
    first: float,
    *,
    until: float = 1.0,
    max_steps: int = 200,
    convergence: Convergence | None = None,
) -> PlanarPath:
    """Return a path of equilibria through limit points, by an arc-length method.

    ``|dq|^2 = s^2`` over all corrections of a step (M. A. Crisfield, *Comput. Struct.* 13 (1981)
    55-62, cylindrical), with rotations times the mean length of the elements; s is adapted to the
    number of iterations.

    Parameters
    ----------
    frame : PlanarFrame
    first : float
        Load factor of the first step, which determines its arc length.
    until : float
        Load factor at the end of the path, of the same sign as `first`.
    max_steps : int
        Maximum number of points.
    convergence : Convergence, optional
        Criterion; the default is a residual of 1e-9 of the largest force in 12 iterations.

    Raises
    ------
    InputError
        If the frame can move without force or has no load, or `first` and `until` differ in sign.
    SimulationError
        If a step does not converge at a thousandth of its length.
    """
    problems = Problems()
    wanted = "a number other than zero"
    for name, factor in (("first", first), ("until", until)):
        problems.number("arc_length", name, factor, "", wanted, lambda x: x != 0.0)
    if not problems.found and first * until < 0.0:
        text = f"first is {first:g} and leads away from until = {until:g}; give both the same sign"
        problems.add("arc_length", text)
    problems.raise_if_any()
    convergence = convergence or Convergence(max_iterations=12)
    system = frame.system
    _refuse_motions(system)
    _check_supports(system)
    free, sign = system.free, math.copysign(1.0, first)
    weight = np.array(
        [
            float(np.mean(system.length)) if name.startswith(("r of", "stretch of")) else 1.0
            for name in system.names
        ]
    )[free]
    q, factor = np.zeros(system.size), 0.0
    found = [_Equilibrium(0.0, _at(system, q, 0.0), (0.0,))]
    direction = _tangent_step(system, q, factor)
    if not np.linalg.norm(direction) > 0.0:
        raise InputError(Problem("arc_length", "no load moves the frame; give loads or gravity"))
    s = abs(first) * float(np.linalg.norm(weight * direction))
    longest, shortest = s, 1e-3 * s
    before = sign * direction
    while len(found) <= max_steps:
        slope = _tangent_step(system, q, factor)
        way = 1.0 if (weight * slope) @ (weight * before) >= 0.0 else -1.0
        step = way * s / float(np.linalg.norm(weight * slope))
        out = _corrected(system, q, factor, step, slope, weight, s, convergence)
        if out is None:
            s *= 0.5
            if s < shortest:
                text = f"arc_length: no equilibrium is found beyond factor {factor:g}"
                raise SimulationError(f"{text}; begin with a smaller first step", time=factor)
            continue
        before = (out.point.q - q)[free]
        if sign * out.factor >= sign * until:
            # last point at the load factor `until`
            last = _newton(system, out.point.q, until, convergence)
            found.append(last if _good(system, last, convergence) else out)
            break
        q, factor = out.point.q.copy(), out.factor
        found.append(out)
        s = min(longest, s * math.sqrt(4.0 / max(1, len(out.history) - 1)))
    return _path(frame, found)


def _at(system: System, q: Array, factor: float) -> Point:
    zero = np.zeros(system.size)
    return system.evaluate(q, zero, zero, system.at_factor(factor))


def _load_vector(system: System, p: Point) -> Array:
    """Return ``-dr/dfactor``: the load of factor 1 on the unsupported unknowns."""
    return np.asarray((p.slaves.B.T @ system.at_factor(1.0).force(p.slaves.u))[system.free])


def _stiffness(system: System, p: Point, factor: float) -> Array:
    K = system.stiffness(p, system.at_factor(factor))
    return np.asarray(K[np.ix_(system.free, system.free)])


def _tangent_step(system: System, q: Array, factor: float) -> Array:
    p = _at(system, q, factor)
    x = solve(_stiffness(system, p, factor), _load_vector(system, p))
    return np.zeros(len(system.free)) if x is None else x


def _newton(system: System, q0: Array, factor: float, convergence: Convergence) -> _Equilibrium:
    """Return the result of Newton's iteration at a load factor, converged or not."""
    q, history = q0.copy(), []
    p = _at(system, q, factor)
    for _ in range(convergence.max_iterations + 1):
        p = _at(system, q, factor)
        history.append(float(np.linalg.norm(p.residual[system.free])))
        out = _Equilibrium(factor, p, tuple(history), len(history) - 1)
        if not math.isfinite(history[-1]) or _good(system, out, convergence):
            return out
        dq = solve(_stiffness(system, p, factor), p.residual[system.free])
        if dq is None:
            return out
        q = q.copy()
        q[system.free] -= dq
    return _Equilibrium(factor, p, tuple(history), len(history))


def _reach(
    system: System, q: Array, span: tuple[float, float], convergence: Convergence
) -> _Equilibrium:
    """Return the equilibrium at the end of a load step, which is halved where it fails."""
    last, factor = span
    aim, step, solves = factor, factor - last, 0
    shortest = SHORTEST * abs(step)
    while True:
        out = _newton(system, q, aim, convergence)
        solves += out.solves
        out = out._replace(solves=solves)
        if out.history and _good(system, out, convergence):
            if aim == factor:
                return out
            q, last, step = out.point.q, aim, 2.0 * step
        else:
            step *= 0.5
            if abs(step) <= shortest:
                return out
        near = abs(step) >= (1.0 - 1e-9) * abs(factor - last)
        aim = factor if near else last + step


def _good(system: System, out: _Equilibrium, convergence: Convergence) -> bool:
    size = out.history[-1]
    if not math.isfinite(size):
        return False
    if convergence.residual is not None and size > convergence.residual:
        return False
    relative = convergence.relative
    if relative is None and convergence.residual is None:
        relative = 1e-9
    if relative is None:
        return True
    scale = system.scale(out.point, system.at_factor(out.factor))
    return size <= max(relative * scale, system.rounding(out.point))


def _corrected(
    system: System,
    q0: Array,
    factor0: float,
    step: float,
    slope: Array,
    weight: Array,
    s: float,
    convergence: Convergence,
) -> _Equilibrium | None:
    """Return the equilibrium at the distance s from q0; None if the iteration fails."""
    free = system.free
    q, factor, history = q0.copy(), factor0 + step, []
    q[free] += step * slope
    for _ in range(convergence.max_iterations + 1):
        p = _at(system, q, factor)
        r = p.residual[free]
        history.append(float(np.linalg.norm(r)))
        out = _Equilibrium(factor, p, tuple(history), len(history) - 1)
        d = weight * (q - q0)[free]
        gap = float(d @ d) - s * s
        if abs(gap) <= 1e-8 * s * s and _good(system, out, convergence):
            return out
        # bordered system: equilibrium and length together, regular at limit points
        n = len(free)
        A = np.zeros((n + 1, n + 1))
        A[:n, :n] = _stiffness(system, p, factor)
        A[:n, n] = -_load_vector(system, p)
        A[n, :n] = 2.0 * weight * d
        dx = solve(A, np.append(r, gap))
        if dx is None:
            return None
        q = q.copy()
        q[free] -= dx[:n]
        factor -= float(dx[n])
    return None


def _path(frame: PlanarFrame, found: list[_Equilibrium]) -> PlanarPath:
    system = frame.system
    negative = []
    for item in found:
        K = _stiffness(system, item.point, item.factor)
        negative.append(int(np.sum(np.linalg.eigvalsh(0.5 * (K + K.T)) < 0.0)))
    n = 3 * system.count
    means = np.array([system.means(item.point) for item in found])
    return PlanarPath(
        frame=frame,
        factors=np.array([item.factor for item in found]),
        q=np.array([item.point.q for item in found]),
        displacements=np.array([item.point.slaves.u[:n] for item in found]).reshape(
            len(found), -1, 3
        ),
        strains=means[:, 0],
        resultants=means[:, 1],
        negative=np.array(negative),
        residuals=tuple(item.history for item in found),
        solves=np.array([item.solves for item in found]),
    )


def _refuse_motions(system: System) -> None:
    """Raise an InputError for frames with prescribed motions, which have no load factor."""
    if system.moved:
        names = ", ".join(system.names[i] for i, _ in system.moved)
        text = f"has prescribed motions ({names}), functions of the time that statics does not have"
        raise InputError(Problem("PlanarFrame", f"{text}; use PlanarSupport, or simulate_planar"))


def _check_supports(system: System) -> None:
    """Raise an error for frames that move without force when unloaded.

    Raises
    ------
    InputError
        With the unknown that moves most.
    """
    K = _stiffness(system, _at(system, np.zeros(system.size), 0.0), 0.0)
    # scale each unknown by its own stiffness, so that units have no effect
    d = np.sqrt(np.maximum(np.abs(np.diag(K)), 1e-300))
    values, vectors = np.linalg.eigh(K / d[:, None] / d)
    loose = values < 1e-12
    if loose.any():
        k = int(np.argmax(np.abs(vectors[:, 0] / d)))
        remedy = "add PlanarSupport"
        if any(group.free_motions() for group in system.groups):
            remedy += ", or choose other points of integration of the element"
        text = (
            f"the frame can move without force in {int(loose.sum())} ways; "
            f"{system.names[system.free[k]]} moves most; {remedy}"
        )
        raise InputError(Problem("PlanarFrame", text))


def planar_frequencies(
    frame: PlanarFrame, path: PlanarPath | None = None, k: int = -1
) -> NDArray[np.float64]:
    """Return undamped natural frequencies, Hz, of the unloaded frame or about an equilibrium.

    Parameters
    ----------
    frame : PlanarFrame
    path : PlanarPath, optional
        Equilibria from `load_steps` or `arc_length`.
    k : int
        Index of the equilibrium in the path.

    Returns
    -------
    (n,) array
        Frequencies, Hz, ascending; negative for unstable modes: ``-sqrt(-K/M) / (2 pi)``.
    """
    from scipy.linalg import eigh

    system = frame.system
    q, factor = (np.zeros(system.size), 0.0) if path is None else (path.q[k], path.factors[k])
    p = _at(system, q, float(factor))
    K = _stiffness(system, p, float(factor))
    K = 0.5 * (K + K.T)
    M = (p.slaves.B.T @ system.M @ p.slaves.B)[np.ix_(system.free, system.free)]
    # rotations without mass follow the others (static condensation, exact for them)
    rest = np.isin(system.free, system.massless)
    if rest.any():
        follow = np.linalg.solve(K[np.ix_(rest, rest)], K[np.ix_(rest, ~rest)])
        K = K[np.ix_(~rest, ~rest)] - K[np.ix_(~rest, rest)] @ follow
        M = M[np.ix_(~rest, ~rest)]
    values = eigh(K, M, eigvals_only=True)
    return np.asarray(np.sign(values) * np.sqrt(np.abs(values)) / (2 * np.pi))
