"""Check of the step before a run, by the modes of the bodies and of the mechanism."""

from __future__ import annotations

from dataclasses import replace
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.mechanism.beams.limits import element_matrices
from jousto.model.model import Model
from jousto.model.native.header import named
from jousto.model.native.native import IMAGINARY, Engine, displaced
from jousto.model.scales import velocity_metres
from jousto.simulation.solvers.base import Solver

Eigenvalues = NDArray[np.complex128]
DENSE = 300  # number of states up to which all eigenvalues are computed
MANY_STEPS = 1e6
DIFFERENCE = 1e-6  # relative step of the central differences


def body_eigenvalues(model: Model, body: int) -> Eigenvalues:
    """Return the eigenvalues lambda of a free body's modal motion at p = 0, 1/s.

    ``(lambda^2 M + lambda D + K) y = 0`` with the rigid coordinates eliminated. Joints can only
    lower the highest eigenvalue (Cauchy interlacing), so the estimate is safe.
    """
    b = model.bodies[body]
    if b.n == 0:
        return np.zeros(0, dtype=np.complex128)
    S, J = b.S0, b.J0
    skew = np.array([[0.0, -S[2], S[1]], [S[2], 0.0, -S[0]], [-S[1], S[0], 0.0]])
    inertia = np.array([[J[0], J[5], J[4]], [J[5], J[1], J[3]], [J[4], J[3], J[2]]])
    Mrr = np.block([[b.mass[0] * np.eye(3), -skew], [skew, inertia]])
    Mrp = np.vstack([b.I3, b.B0])
    M = np.eye(b.n) - Mrp.T @ np.linalg.lstsq(Mrr, Mrp, rcond=None)[0]
    companion = np.block(
        [
            [np.zeros((b.n, b.n)), np.eye(b.n)],
            [-np.linalg.solve(M, np.diag(b.K)), -np.linalg.solve(M, np.diag(b.D))],
        ]
    )
    return np.asarray(np.linalg.eigvals(companion), dtype=np.complex128)


def beam_eigenvalues(model: Model, i: int) -> Eigenvalues:
    """Return the eigenvalues lambda of one free beam element, 1/s.

    The masses and stiffnesses of a beam are sums over its elements, so that none of its frequencies
    is above the highest of them (Irons and Treharne 1971); bodies at the nodes only lower them.
    """
    x = named("jo_beam_data", np.asarray(model.beams[i].data, dtype=np.float64))
    K, M = element_matrices(x.length, x.C.reshape(6, 6), x.share, x.mass, x.J)
    if np.linalg.eigvalsh(M)[0] <= 0.0:
        return np.zeros(0, dtype=np.complex128)
    A, D = np.linalg.solve(M, K), x.beta * np.linalg.solve(M, K) + x.alpha * np.eye(12)
    companion = np.block([[np.zeros((12, 12)), np.eye(12)], [-A, -D]])
    return np.asarray(np.linalg.eigvals(companion), dtype=np.complex128)


def all_beam_eigenvalues(model: Model) -> list[Eigenvalues]:
    """Return the eigenvalues of every beam element, 1/s; equal elements are computed once."""
    made: dict[bytes, Eigenvalues] = {}
    found = []
    for i, beam in enumerate(model.beams):
        x = named("jo_beam_data", np.asarray(beam.data, dtype=np.float64))
        # lengths that differ by round-off only are equal
        values = np.hstack([x.length, x.C, x.beta, x.alpha, x.share, x.mass, x.J])
        key = values.astype(np.float32).tobytes()
        if key not in made:
            made[key] = beam_eigenvalues(model, i)
        found.append(made[key])
    return found


_FREE: WeakKeyDictionary[Model, list[Eigenvalues]] = WeakKeyDictionary()


def modal_bodies(model: Model) -> list[int]:
    """Return the indices of the bodies with modes."""
    return [i for i, body in enumerate(model.bodies) if body.n]


def free_eigenvalues(model: Model) -> list[Eigenvalues]:
    """Return the eigenvalues of each free body with modes and each beam element, 1/s (cached)."""
    if model not in _FREE:
        bodies = [body_eigenvalues(model, i) for i in modal_bodies(model)]
        _FREE[model] = bodies + all_beam_eigenvalues(model)
    return _FREE[model]


def mechanism_eigenvalues(model: Model) -> Eigenvalues:
    """Return the largest eigenvalues of the linearised mechanism at its initial state, 1/s.

    The Jacobian consists of central differences of the engine's accelerations. Increments of q are
    relative to the size of the mechanism, those of v to this size per radian of the fastest body
    mode. Small mechanisms get all eigenvalues, others the four of largest magnitude (Arnoldi
    iteration). Friction is left out: stick-slip friction has no derivative at rest, and
    `friction_warning` checks the regularised law.
    """
    engine = Engine(replace(model, frictions=()))
    scale = max(np.abs(e).max(initial=0.0) for e in free_eigenvalues(model))
    nv, unit = model.nv, model.size / velocity_metres(model)

    def rate(x: Array) -> Array:
        engine.q[:] = displaced(model, model.q0, unit * x[:nv])
        engine.v[:] = model.v0 + scale * unit * x[nv:]
        a, _ = engine.accelerations()
        return np.concatenate([engine.v / unit, a / (scale * unit)])

    def product(x: Array) -> Array:
        size = DIFFERENCE / max(float(np.abs(x).max()), 1e-300)
        return (rate(size * x.ravel()) - rate(-size * x.ravel())) / (2.0 * size)

    if 2 * nv <= DENSE:
        matrix = np.stack([product(column) for column in np.eye(2 * nv)], axis=1)
        return np.asarray(np.linalg.eigvals(matrix), dtype=np.complex128)
    import scipy.sparse.linalg  # slow to import and rarely needed

    operator = scipy.sparse.linalg.LinearOperator((2 * nv, 2 * nv), matvec=product, dtype=float)
    start = np.random.default_rng(0).normal(size=2 * nv)
    values = scipy.sparse.linalg.eigs(
        operator, k=4, ncv=40, v0=start, tol=1e-3, maxiter=100, return_eigenvectors=False
    )
    return np.asarray(values, dtype=np.complex128)


def stability_warning(model: Model, solver: Solver, step: float) -> str:
    """Return a warning if the step is too large for the mechanism's modes, else None.

    If the step suits the modes of all free bodies, it is accepted. Otherwise the modes of the
    mechanism decide, since its joints lower the frequencies.
    """
    sentence = _baumgarte_warning(solver, step)
    if sentence:
        return sentence
    modal = modal_bodies(model)
    if not modal and not model.beams:
        return ""
    eigenvalues = free_eigenvalues(model)
    names = [model.bodies[i].name for i in modal] + [beam.body for beam in model.beams]
    largest = [np.abs(e[solver.unstable(step, e)]).max(initial=0.0) for e in eigenvalues]
    if not any(largest):
        return ""
    body = names[int(np.argmax(largest))]
    beam = int(np.argmax(largest)) >= len(modal)
    from scipy.sparse.linalg import ArpackNoConvergence  # slow to import and rarely needed

    try:
        joined = mechanism_eigenvalues(model)
    except ArpackNoConvergence:
        # no convergence: use the modes of the free bodies, a safe estimate
        joined = np.concatenate(eigenvalues)
    # the undamped motions of a mechanism may grow slowly on their own (an upright pendulum)
    modes = joined[np.abs(joined) * step > 1.0]
    bad = modes[solver.unstable(step, modes)]
    if not len(bad):
        return ""
    limit = largest_stable_step(modes, solver, step)
    return (
        f"the mechanism has a mode of {np.abs(bad).max() / (2 * np.pi):.4g} Hz (stiffest body "
        f"'{body}'), for which {type(solver).__name__} needs a step below {limit:.2g} s (it is "
        f"{step:.3g} s); take a smaller step, fewer {'elements' if beam else 'modes'}, or ROS2"
    )


def friction_warning(model: Model, solver: Solver, step: float) -> str:
    """Return a warning if the step is too large for regularised friction, else None.

    Near rest such friction is a damper with the rates of ``da/dv``, computed at rest in the initial
    position. If the step is too large for these rates, the joint chatters.
    """
    smooth = tuple(friction for friction in model.frictions if not friction.sticks)
    if not smooth or 2 * model.nv > DENSE:
        return ""
    rates = braking(replace(model, frictions=smooth), replace(model, frictions=()))
    limit = _longest(solver, step, rates)
    if limit == step:
        return ""
    names = ", ".join(f"'{friction.name}'" for friction in smooth)
    fastest = float(np.abs(rates).max())
    return (
        f"regularised friction {names} stops the slip at a rate of {fastest:.3g} 1/s, for which "
        f"{type(solver).__name__} needs a step below {limit:.2g} s (it is {step:.3g} s), or the "
        "joint chatters; take a smaller step, a larger velocity of the law, or law=StickSlip()"
    )


def damper_warning(model: Model, solver: Solver, step: float) -> str:
    """Return a warning if the step is too large for the steepest part of a damper table.

    There the table acts as a damper whose coefficient is the slope, with the rates of ``da/dv`` at
    the initial position. If the step is too large for these rates, the velocity oscillates.
    """
    places = [i for i, force in enumerate(model.forces) if force.damper >= 0]
    if not places or 2 * model.nv > DENSE:
        return ""
    with_, without = list(model.forces), list(model.forces)
    for i in places:
        bare = replace(model.forces[i], damper=-1)
        data = bare.data.copy()
        named("jo_along_data", data).damping[...] += _steepest(model, model.forces[i].damper)
        without[i], with_[i] = bare, replace(bare, data=data)
    quiet = replace(model, forces=tuple(without), frictions=())
    rates = braking(replace(quiet, forces=tuple(with_)), quiet)
    limit = _longest(solver, step, rates)
    if limit == step:
        return ""
    names = ", ".join(f"'{model.forces[i].name}'" for i in places)
    return (
        f"damper_table of {names} brakes at a rate of up to {float(np.abs(rates).max()):.3g} 1/s "
        f"where it is steepest, for which {type(solver).__name__} needs a step below {limit:.2g} s "
        f"(it is {step:.3g} s), or the force chatters; take a smaller step, a less steep table, or "
        "Friction with law=StickSlip() where the table stands for dry friction"
    )


def _steepest(model: Model, signal: int) -> float:
    """Return the steepest negative slope of a table, N s/m or N m s."""
    table = model.signals[signal]
    if table.kind != "table":
        return 0.0
    times, values = table.data[: table.count], table.data[table.count : 2 * table.count]
    return max(0.0, -float((np.diff(values) / np.diff(times)).min(initial=0.0)))


def braking(one: Model, other: Model) -> Eigenvalues:
    """Return the eigenvalues, 1/s, of the difference of ``da/dv`` between two models at rest.

    Parameters
    ----------
    one, other : Model
        Models with the same bodies.
    """
    slopes = []
    for model in (one, other):
        engine = Engine(model, complex_scalars=True)
        columns = []
        for j in range(model.nv):
            engine.v[:] = 0.0
            engine.v[j] = 1j * IMAGINARY
            columns.append(engine.accelerations()[0].imag / IMAGINARY)
        slopes.append(np.stack(columns, axis=1))
    return np.asarray(np.linalg.eigvals(slopes[0] - slopes[1]), dtype=np.complex128)


def _longest(solver: Solver, step: float, rates: Eigenvalues) -> float:
    """Return the largest step up to `step` for which no motion with these rates grows."""
    while (solver.explicit_growth(step * rates) > 1.0 + 1e-9).any():
        step *= 0.9
    return step


def many_steps(model: Model, duration: float) -> str:
    """Return a warning if the modes force an explicit method to very many steps, else None."""
    fastest = [
        float(np.abs(body_eigenvalues(model, i)).max(initial=0.0)) for i in range(len(model.bodies))
    ]
    steps = duration * max(fastest, default=0.0) / 2.0
    if steps < MANY_STEPS:
        return ""
    body = model.bodies[int(np.argmax(fastest))].name
    return (
        f"modes of body '{body}' up to {max(fastest) / (2 * np.pi):.4g} Hz force an explicit "
        f"method to about {steps:.2g} steps; ROS2 does not mind them, or take fewer modes"
    )


def _baumgarte_warning(solver: Solver, step: float) -> str:
    """Return a warning if ``lambda^2 + 2 alpha lambda + beta^2 = 0`` is too fast for the step."""
    terms = solver.baumgarte
    if terms is None:
        return ""
    roots = np.roots([1.0, 2.0 * terms.alpha, terms.beta**2]).astype(np.complex128)
    if not (solver.explicit_growth(step * roots) > 1.0 + 1e-12).any():
        return ""
    return (
        f"{terms} is too stiff for a step of {step:.3g} s; take values of about "
        f"{0.1 / step:.3g} 1/s, or projection instead"
    )


def largest_stable_step(eigenvalues: Eigenvalues, solver: Solver, step: float) -> float:
    """Return the largest stable step not above `step`, found by bisection, s."""
    if not solver.unstable(step, eigenvalues).any():
        return step
    low, high = 0.0, step
    for _ in range(60):
        middle = 0.5 * (low + high)
        if solver.unstable(middle, eigenvalues).any():
            high = middle
        else:
            low = middle
    return low
