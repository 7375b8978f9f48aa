"""Newton's method for a point of an equilibrium path, at a load or at an arc length."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any, TypeVar

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spl

from jousto.base.arrays import Array
from jousto.base.errors import SimulationError
from jousto.model.scales import largest_speed, velocity_metres
from jousto.simulation.modes.linear import rotations
from jousto.simulation.modes.spectrum import Spectrum, lowest_modes
from jousto.simulation.statics.residual import Balance

SMALL = 1e-10  # increment at which Newton's iteration has converged, sizes of the mechanism or rad
STALLED = 1e-6  # increment below which an iteration that no longer contracts is at round-off
NEUTRAL = 1e-13  # stiffness over metric, relative to the largest, that counts as zero
PUSHED = 1e-3  # displacement along neutral directions at that stiffness, above which a force acts
TURN = 1.0  # largest increment of a body in an iteration, rad or sizes of the mechanism


class NoConvergenceError(Exception):
    """Error raised if Newton's method does not converge; `body` has the largest increment."""

    def __init__(self, message: str, body: str = "") -> None:
        self.body = body
        super().__init__(message)


class SingularTangentError(NoConvergenceError):
    """Error raised if the tangent matrix is singular: a motion has no stiffness."""

    def __init__(self) -> None:
        super().__init__("the tangent matrix is singular")


@dataclass(frozen=True, eq=False)
class Point:
    """Point of a path: positions q, multipliers (with the azimuth torque) and the parameter."""

    q: Array
    lam: Array
    value: float
    iterations: int = 0


@dataclass(frozen=True, eq=False)
class Rates:
    """Path tangent: derivatives of all unknowns and of the parameter by the arc length."""

    step: Array
    value: float


T = TypeVar("T")


def _raise_no_convergence(solve: Callable[..., T]) -> Callable[..., T]:
    """Decorate `solve`: errors of the engine at a trial position become NoConvergenceError."""

    @wraps(solve)
    def tried(*values: Any, **options: Any) -> T:
        try:
            return solve(*values, **options)
        except SimulationError as error:
            raise NoConvergenceError(str(error), error.body) from error

    return tried


def factor(balance: Balance, point: Point) -> Any:
    """Return the sparse LU factors of the tangent matrix at a point.

    Raises
    ------
    NoConvergenceError
        If the matrix is singular.
    """
    A = balance.matrix(point.q, point.lam, point.value)
    try:
        return spl.splu(A)
    except RuntimeError as error:
        raise SingularTangentError from error


def least_step(balance: Balance, point: Point) -> tuple[Array, Array]:
    """Return Newton's step, split into parts across and along neutral directions, (size,) each.

    A neutral direction, such as the spin of a rope about its own axis, has no stiffness and no
    force. With ``P = (K + s D)^-1`` under the constraints, D the metric of `Balance.metric` and s
    at the round-off of K, the neutral part of a step x is ``s P D x``: about 0 in directions with
    stiffness, x in directions without.

    Raises
    ------
    NoConvergenceError
        If the matrix is singular because constraints contradict one another.
    """
    nv = balance.model.nv
    metric = balance.metric(point.q, point.lam, point.value)
    r = balance.residual(point.q, point.lam, point.value)
    A = balance.matrix(point.q, point.lam, point.value)
    fall = largest_speed(balance.model, r[:nv] / metric)  # m/s2
    least = max(
        least_stiffness(A, metric), NEUTRAL * fall / balance.model.size
    )  # regularisation s, 1/s2
    added = np.concatenate([least * metric, np.zeros(len(r) - nv)])
    try:
        lu = spl.splu((A + sp.diags(added)).tocsc())
    except RuntimeError as error:
        raise SingularTangentError from error
    step = whole = -lu.solve(r)
    for _ in range(3):
        step = step - lu.solve(added * step)
    return step, whole - step


def least_stiffness(A: Any, metric: Array) -> float:
    """Return the least stiffness above round-off, as diagonal over metric, 1/s2."""
    nv = len(metric)
    return max(NEUTRAL * float((abs(A[:nv, :nv].diagonal()) / metric).max()), 1e-100)


def at_load(balance: Balance, point: Point, value: float, iterations: int = 15) -> Point:
    """Return the equilibrium at a value of the parameter, starting from a nearby point.

    Raises
    ------
    NoConvergenceError
        If Newton's iteration fails.
    """
    try:
        return _at_load(balance, point, value, iterations)
    except NoConvergenceError:
        try:
            return at_least(balance, point, value, iterations)
        except NoConvergenceError:
            pass
        raise


@_raise_no_convergence
def _at_load(balance: Balance, point: Point, value: float, iterations: int) -> Point:
    q, lam = point.q, point.lam
    before = np.inf
    for k in range(iterations):
        r = balance.residual(q, lam, value)
        step = -factor(balance, Point(q, lam, value)).solve(r)
        cut = step_factor(balance, step)
        q, lam = balance.moved(q, cut * step), lam + cut * step[balance.model.nv :]
        length = balance.length(step)
        if has_converged(length, before, cut):
            return Point(q, lam, value, k + 1)
        before = _checked(balance, step, length, before, k)
    raise _failed(balance, step, iterations)


@_raise_no_convergence
def at_least(balance: Balance, point: Point, value: float, iterations: int = 15) -> Point:
    """Return a nearby equilibrium, by Newton steps without their neutral part.

    Raises
    ------
    NoConvergenceError
        If the iteration fails, or a force acts along a neutral direction.
    """
    q, lam = point.q, point.lam
    before = np.inf
    for k in range(iterations):
        step, free = least_step(balance, Point(q, lam, value))
        cut = step_factor(balance, step)
        q, lam = balance.moved(q, cut * step), lam + cut * step[balance.model.nv :]
        length = balance.length(step)
        if has_converged(length, before, cut):
            if balance.length(free) > PUSHED:
                raise NoConvergenceError(
                    "a force acts in a direction without stiffness", most_moved_body(balance, free)
                )
            return Point(q, lam, value, k + 1)
        before = _checked(balance, step, length, before, k)
    raise _failed(balance, step, iterations)


@_raise_no_convergence
def at_arc_length(
    balance: Balance, point: Point, ahead: Rates, length: float, weight: float, iterations: int = 12
) -> Point:
    """Return the equilibrium at an arc length, ``x^T W x + (weight s)^2 = length^2``.

    Newton's method for the unknowns and the parameter together (Riks 1979; Schweizerhof and
    Wriggers 1986). x are the increments from `point`, with rotations as rotation vectors: the
    derivative of ``|theta|^2`` by body-fixed rotations is exactly ``2 theta``.

    Raises
    ------
    NoConvergenceError
        If Newton's iteration fails.
    """
    nv = balance.model.nv
    q = balance.moved(point.q, length * ahead.step)
    lam = point.lam + length * ahead.step[nv:]
    value = point.value + length * ahead.value
    before = np.inf
    for k in range(iterations):
        lu = factor(balance, Point(q, lam, value))
        free = -lu.solve(balance.residual(q, lam, value))
        pushed = -lu.solve(balance.push(q, lam, value))
        x, s = balance.between(point.q, q), value - point.value
        normal = 2.0 * balance.weights * x
        gap = float(balance.weights @ (x * x)) + (weight * s) ** 2 - length**2
        below = float(normal @ pushed[:nv]) + 2.0 * weight**2 * s
        if below == 0.0:
            raise NoConvergenceError("the path turns back on itself")
        change = -(gap + float(normal @ free[:nv])) / below
        step = free + change * pushed
        cut = step_factor(balance, step)
        q, lam = balance.moved(q, cut * step), lam + cut * step[nv:]
        value += cut * change
        moved = balance.length(step) + abs(weight * change)
        if has_converged(moved, before, cut):
            return Point(q, lam, value, k + 1)
        before = _checked(balance, step, moved, before, k)
    raise _failed(balance, step, iterations)


@_raise_no_convergence
def tangent(balance: Balance, point: Point, weight: float, last: Rates | None) -> Rates:
    """Return the unit tangent of the path in the direction of the last tangent.

    Raises
    ------
    NoConvergenceError
        If the tangent matrix is singular.
    """
    push = balance.push(point.q, point.lam, point.value)
    step = -factor(balance, point).solve(push)
    size = float(np.hypot(balance.length(step), weight))
    sign = 1.0
    if last is not None:
        nv = balance.model.nv
        onwards = float((balance.weights * last.step[:nv]) @ step[:nv]) + weight**2 * last.value
        sign = -1.0 if onwards < 0.0 else 1.0
    return Rates(sign * step / size, sign / size)


def spectrum(balance: Balance, point: Point, count: int, *, held: bool = False) -> Spectrum:
    """Return the modes of the tangent stiffness with omega^2 nearest to 0 at a point.

    With `held`, the stiffness of `least_stiffness` is added, so that neutral modes are stable.
    """
    nv, nrow = balance.model.nv, balance.model.nrow
    A = balance.matrix(point.q, point.lam, point.value)
    M = balance.mass(point.q, point.lam, point.value)
    C, K = A[nv : nv + nrow + balance.gauge, :nv], A[:nv, :nv]
    if held:
        metric = balance.metric(point.q, point.lam, point.value)
        K = K + sp.diags(least_stiffness(A, metric) * metric)
    return lowest_modes(K, M, C, count)


def neutral_modes(balance: Balance, point: Point, found: Spectrum) -> int:
    """Return the number of modes without stiffness, ``|x K x| <= 1000 eps |x||K||x|``."""
    nv = balance.model.nv
    K = balance.matrix(point.q, point.lam, point.value)[:nv, :nv]
    x = np.abs(found.shapes)
    size = np.einsum("ij,ij->j", x, abs(K) @ x)
    return int((np.abs(found.squares) <= 1000 * np.finfo(float).eps * size).sum())


def free_motion(balance: Balance, point: Point) -> str:
    """Return a sentence with the body that moves freely, and its motion, at a singular tangent."""
    from jousto.simulation.modes.spectrum import lowest_modes

    nv, nrow = balance.model.nv, balance.model.nrow
    A = balance.matrix(point.q, point.lam, point.value)
    M = balance.mass(point.q, point.lam, point.value)
    found = lowest_modes(A[:nv, :nv], M, A[nv : nv + nrow, :nv], 1)
    if not found.shapes.shape[1]:
        return "its joints contradict one another"
    x = np.real(found.shapes[:, 0])
    model = balance.model
    moves = np.array([np.linalg.norm(x[b.iv : b.iv + 3]) for b in model.bodies]) / model.size
    turns = np.array([np.linalg.norm(x[b.iv + 3 : b.iv + 6]) for b in model.bodies])
    k = int(np.argmax(moves + turns))
    b, R = model.bodies[k], rotations(model, point.q)[k]
    turning = turns[k] > moves[k]
    way = R @ x[b.iv + 3 : b.iv + 6] if turning else x[b.iv : b.iv + 3]
    way = way / np.linalg.norm(way) + 0.0
    way = np.where(np.abs(way) < 1e-6, 0.0, way)
    text = ", ".join(f"{c:.3g}" for c in way)
    return f"body '{b.name}' {'turns freely about' if turning else 'moves freely along'} ({text})"


def step_factor(balance: Balance, step: Array) -> float:
    """Return the factor on a step that limits rotations and translations of bodies to TURN."""
    size = balance.model.size
    most = max(
        max(
            float(np.abs(step[b.iv : b.iv + 3]).max()) / size,
            float(np.abs(step[b.iv + 3 : b.iv + 6]).max()),
        )
        for b in balance.model.bodies
    )
    return float(min(1.0, TURN / max(most, 1e-300)))


def has_converged(length: float, before: float, cut: float) -> bool:
    """Return whether Newton's iteration has converged or stalled at round-off."""
    if cut < 1.0:
        return False
    return length <= SMALL or (length <= STALLED and length > 0.3 * before)


def _checked(balance: Balance, step: Array, length: float, before: float, k: int) -> float:
    if not np.isfinite(length) or (k > 3 and length > 10.0 * before):
        raise _failed(balance, step, k + 1)
    return length


def most_moved_body(balance: Balance, step: Array) -> str:
    """Return the name of the body with the largest increment."""
    bodies = balance.model.bodies
    moves = step[: balance.model.nv] * velocity_metres(balance.model)
    size = [float(np.linalg.norm(moves[b.iv : b.iv + 6])) for b in bodies]
    return str(bodies[int(np.argmax(np.nan_to_num(size, nan=np.inf)))].name)


def _failed(balance: Balance, step: Array, iterations: int) -> NoConvergenceError:
    body = most_moved_body(balance, step)
    return NoConvergenceError(
        f"Newton's iteration did not converge in {iterations} iterations, body '{body}' moves most",
        body,
    )
